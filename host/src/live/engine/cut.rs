//! What a frame's budget cut off, and the hashes of its tiles: what a record keeps.

use super::TileEngine;
use super::deal::LiveTile;
use super::threads::Plan;
use crate::bake::Stage;
use crate::live::lock;
use crate::picture::tile_hash;
use rayon::prelude::*;
use shisen_core::frame::TileJob;
use shisen_core::{Runs, Simd};
use std::sync::atomic::Ordering;
use std::sync::{Mutex, MutexGuard};

/// A tile that a frame's budget cut off.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Cut {
    /// The tile's number, by picture, row and column.
    pub tile: u32,
    /// Its pixels that were done, in the order in which they are rendered.
    pub kept: u32,
}

impl<const W: usize> Plan<'_, W>
where
    Simd: Runs<W>,
{
    /// Gives up what a tile's job has not finished.
    pub(super) fn give_up(&self, tile: &mut LiveTile) {
        let (view, renderer) = &self.parts[tile.part];
        let now = self.stage.as_ref().map(Stage::scene);
        let posed = now.map(|now| renderer.posed(now));
        let renderer = posed.as_ref().unwrap_or(renderer);
        tile.hash = None;
        let given_up = tile.job.give_up(renderer, view, &mut tile.pixels);
        debug_assert!(given_up.is_ok(), "its own pixels");
    }
}

impl<const W: usize> TileEngine<'_, '_, W>
where
    Simd: Runs<W>,
{
    pub(super) fn newest_cuts(&self, cuts: &mut Vec<Cut>) {
        let tiles = (0..).zip(&self.shared.tiles);
        cuts.clear();
        cuts.extend(tiles.filter_map(|(number, tile)| {
            let kept = lock(tile).kept?;
            Some(Cut { tile: number, kept })
        }));
    }

    /// Has tiles end where they were cut off.
    pub(super) fn end_at_cuts(&self) {
        for (cut, mut tile) in self.tiles_cut() {
            tile.job = TileJob::cut(tile.job.tile(), cut.kept);
        }
    }

    /// Gives up what is cut off.
    pub(super) fn cut_off(&self) {
        let plan = self.shared.read();
        for (_, mut tile) in self.tiles_cut() {
            plan.give_up(&mut tile);
        }
    }

    fn tiles_cut(&self) -> impl Iterator<Item = (&Cut, MutexGuard<'_, LiveTile>)> {
        self.cuts.iter().filter_map(|cut| {
            let tile = self.shared.tiles.get(cut.tile as usize)?;
            Some((cut, lock(tile)))
        })
    }

    pub(super) fn newest_hashes(&self, hashes: &mut Vec<u64>) {
        let capture = &self.shared.read().capture;
        // Those of a capture come last.
        let count = capture.as_ref().map(|capture| capture.tile);
        let tiles = &self.shared.tiles;
        let tiles = tiles.get(..count.unwrap_or(tiles.len())).unwrap_or(tiles);
        self.shared.hashes.store(true, Ordering::Relaxed);
        let hash = |tile: &Mutex<LiveTile>| {
            let tile = lock(tile);
            let of_pixels = || tile_hash([tile.pixels.as_slice()]);
            tile.hash.unwrap_or_else(of_pixels)
        };
        tiles.par_iter().map(hash).collect_into_vec(hashes);
    }
}
