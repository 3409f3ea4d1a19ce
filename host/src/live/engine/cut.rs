//! What a frame's budget cut off, and the hashes of its tiles: what a record keeps.

use super::TileEngine;
use super::deal::LiveTile;
use crate::live::lock;
use crate::picture::tile_hash;
use rayon::prelude::*;
use shisen_core::frame::TileJob;
use shisen_core::{Runs, Simd};
use std::sync::Mutex;

/// A tile that a frame's budget cut off.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Cut {
    /// The tile's number, by picture, row and column.
    pub tile: u32,
    /// Its pixels that were done, in the order in which they are rendered.
    pub kept: u32,
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

    /// Cuts off tiles of a frame that is whole.
    pub(super) fn cut_off(&self, cuts: &[Cut]) {
        let plan = self.shared.read();
        for cut in cuts {
            let tile = self.shared.tiles.get(cut.tile as usize);
            let Some(mut tile) = tile.map(lock) else {
                continue;
            };
            let tile = &mut *tile;
            let (view, renderer) = &plan.parts[tile.part];
            let mut job = TileJob::cut(tile.job.tile(), cut.kept);
            let given_up = job.give_up(renderer, view, &mut tile.pixels);
            debug_assert!(given_up.is_ok(), "its own pixels");
        }
    }

    pub(super) fn newest_hashes(&self, hashes: &mut Vec<u64>) {
        let capture = &self.shared.read().capture;
        // Those of a capture come last.
        let count = capture.as_ref().map(|capture| capture.tile);
        let tiles = &self.shared.tiles;
        let tiles = tiles.get(..count.unwrap_or(tiles.len())).unwrap_or(tiles);
        let hash = |tile: &Mutex<LiveTile>| tile_hash([lock(tile).pixels.as_slice()]);
        tiles.par_iter().map(hash).collect_into_vec(hashes);
    }
}
