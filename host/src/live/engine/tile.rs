//! The tiles that stay from frame to frame.

use shisen_core::frame::{Pixel, Tile, TileJob};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Expected steps of a pixel of which nothing is known.
const UNKNOWN_PIXEL: u64 = 16;

pub(super) struct LiveTile {
    pub(super) part: usize,
    pub(super) job: TileJob,
    pub(super) pixels: Vec<Pixel>,
    pub(super) spent: u64,
    pub(super) expected: u64,
}

impl LiveTile {
    pub(super) fn new(part: usize, tile: Tile) -> Self {
        let area = tile.width as usize * tile.height as usize;
        Self {
            part,
            job: TileJob::new(tile),
            pixels: vec![Pixel::default(); area],
            spent: 0,
            expected: area as u64 * UNKNOWN_PIXEL,
        }
    }

    /// Steps still expected; as many as were taken where that was more than expected.
    pub(super) const fn expected_rest(&self) -> u64 {
        if self.spent < self.expected {
            self.expected - self.spent
        } else {
            self.spent
        }
    }
}

pub(super) fn lock<T>(one: &Mutex<T>) -> MutexGuard<'_, T> {
    one.lock().unwrap_or_else(PoisonError::into_inner)
}
