//! Which samples of a square exist.

use super::{HALVINGS, STEPS};
use crate::frame::tile::Piece;

/// The places of a square's samples, and which of them exist.
pub(super) struct Grid {
    /// A bit for each sample that exists, by row, from the lowest.
    known: [u32; STEPS + 1],
    /// Samples to be traced, as bits like `known`.
    wanted: [u32; STEPS + 1],
    pub(super) piece: Piece,
    /// Pixels between the finest samples.
    pub(super) unit: u32,
}

impl Grid {
    pub(super) fn new(piece: Piece) -> Self {
        let finest = (piece.stride >> HALVINGS).max(piece.side / STEPS as u32);
        Self {
            known: [0; STEPS + 1],
            wanted: [0; STEPS + 1],
            piece,
            unit: finest.max(1),
        }
    }

    /// Requests the corners that the piece has of a block of `step` steps a side.
    pub(super) fn request(
        &mut self,
        (column, row): (usize, usize),
        step: usize,
        blocks: &mut [u16; STEPS],
    ) {
        if !self.meets((column, row), step) {
            return;
        }
        blocks[row % STEPS] |= 1 << column;
        let both = 1 << column | 1 << (column + step);
        for row in [row, row + step] {
            self.wanted[row % (STEPS + 1)] |= both;
        }
    }

    /// Returns whether the piece contains a part of a block of `step` steps a side.
    pub(super) fn meets(&self, (column, row): (usize, usize), step: usize) -> bool {
        let side = step as u32 * self.unit;
        let meets =
            |start: u32, first: u32, count: u32| start < first + count && first < start + side;
        let (x, y) = self.place(column, row);
        let tile = self.piece.tile;
        meets(x, tile.x, tile.width) && meets(y, tile.y, tile.height)
    }

    /// Returns steps along a side of the square.
    pub(super) const fn steps(&self) -> usize {
        (self.piece.side / self.unit) as usize
    }

    /// Returns steps between the samples that every square has.
    pub(super) const fn coarsest(&self) -> usize {
        (self.piece.stride / self.unit) as usize
    }

    /// Returns the pixel of a node: it may be past the view's borders.
    pub(super) fn place(&self, column: usize, row: usize) -> (u32, u32) {
        let (x, y) = self.piece.corner;
        (x + column as u32 * self.unit, y + row as u32 * self.unit)
    }

    /// Takes the next requested node from `row` on, which moves along.
    pub(super) fn next(&mut self, row: &mut usize) -> Option<(usize, usize)> {
        while let (Some(known), Some(wanted)) = (self.known.get_mut(*row), self.wanted.get(*row)) {
            let missing = wanted & !*known;
            if missing != 0 {
                let column = missing.trailing_zeros();
                *known |= 1 << column;
                return Some((column as usize, *row));
            }
            *row += 1;
        }
        None
    }
}
