//! Rectangles of pixels: tiles, and the blocks of the view's grid that they are made of.

use crate::gaze::Region;
use crate::trace::Pixel;

/// A rectangle of pixels of a view.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Tile {
    /// First column.
    pub x: u32,
    /// First row.
    pub y: u32,
    /// Columns, above 0.
    pub width: u32,
    /// Rows, above 0.
    pub height: u32,
}

impl Tile {
    /// Returns its parts of the blocks of the view's grid, row by row.
    pub(super) fn blocks(self) -> impl Iterator<Item = Self> {
        self.squares(BLOCK)
    }

    /// Returns its parts of the squares of the view's grid, row by row.
    pub(super) fn squares(self, side: u32) -> impl Iterator<Item = Self> {
        let cut = move |first: u32, end: u32| {
            let starts = (first / side..end.div_ceil(side)).map(move |square| square * side);
            starts.map(move |start| (start.max(first), (start + side).min(end)))
        };
        cut(self.y, self.y + self.height).flat_map(move |(y, below)| {
            cut(self.x, self.x + self.width).map(move |(x, right)| Self {
                x,
                y,
                width: right - x,
                height: below - y,
            })
        })
    }

    /// Returns the number of pixels of a block or square.
    pub(super) const fn area(self) -> u32 {
        self.width * self.height
    }

    /// Index among the tile's pixels of a pixel of the view.
    pub(super) fn index(self, x: u32, y: u32) -> usize {
        (y - self.y) as usize * self.width as usize + (x - self.x) as usize
    }

    /// Checks that it lies inside a view of this size and has `given` pixels.
    pub(super) fn check(self, [columns, rows]: [u32; 2], given: usize) -> Result<(), TileError> {
        let inside = |first: u32, count: u32, all: u32| {
            count > 0 && first.checked_add(count).is_some_and(|end| end <= all)
        };
        if !inside(self.x, self.width, columns) || !inside(self.y, self.height, rows) {
            return Err(TileError::Outside);
        }
        let needed = self.width as usize * self.height as usize;
        if given == needed {
            Ok(())
        } else {
            Err(TileError::Pixels { needed, given })
        }
    }
}

/// Why a tile cannot be rendered.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
#[allow(missing_docs, reason = "the messages say what the fields are")]
pub enum TileError {
    /// The tile is empty or not inside the view.
    #[error("the tile is empty or not inside the view")]
    Outside,
    /// The number of pixels given is not the tile's.
    #[error("the tile has {needed} pixels, but there is room for {given}")]
    Pixels { needed: usize, given: usize },
}

/// Pixels a side.
pub(super) const BLOCK: u32 = 8;

/// The part of a cell of the view's grid that a tile covers: 1 to [`BLOCK`] pixels a side.
pub(super) struct Block {
    pub(super) tile: Tile,
    /// Where the patch that it belongs to lies in the visual field.
    pub(super) patch: Region,
}

/// The part in a tile of a square of the view's grid.
#[derive(Debug, Clone, Copy)]
pub(super) struct Piece {
    pub(super) tile: Tile,
    /// Column and row of the square's first pixel.
    pub(super) corner: (u32, u32),
}

/// Returns how far samples may be from their pixel's centre; a single one is there.
pub(super) fn spread(samples: u16) -> f32 {
    if samples == 1 { 0.0 } else { 0.5 }
}

/// Returns where in its pixel a sample lies, from the centre: Hammersley's points.
pub(super) fn offset(sample: u16, samples: u16) -> (f32, f32) {
    let x = (f32::from(sample) + 0.5) / f32::from(samples) - 0.5;
    // The radical inverse: the bits of the number behind the binary point.
    let bits = samples.next_power_of_two().trailing_zeros();
    let reversed = u32::from(sample).reverse_bits().checked_shr(32 - bits);
    let steps = (1u32 << bits) as f32;
    let y = (reversed.unwrap_or(0) as f32 + 0.5) / steps - 0.5;
    (x, y)
}

/// Where the pixels of a block go.
pub(super) struct Target<'p> {
    /// The tile's pixels, in rows.
    pub(super) pixels: &'p mut [Pixel],
    /// Pixels of a row.
    pub(super) width: usize,
    /// Column of the block's first pixel.
    pub(super) x: usize,
    /// Row of the block's first pixel.
    pub(super) y: usize,
}

impl<'p> Target<'p> {
    /// Returns the place of a part of a tile among the tile's pixels.
    pub(super) const fn new(pixels: &'p mut [Pixel], tile: Tile, part: Tile) -> Self {
        Self {
            pixels,
            width: tile.width as usize,
            x: (part.x - tile.x) as usize,
            y: (part.y - tile.y) as usize,
        }
    }

    /// Returns the first `columns` pixels of a row of the block.
    #[inline(always)]
    pub(super) fn row(&mut self, row: u32, columns: u32) -> &mut [Pixel] {
        let start = (self.y + row as usize) * self.width + self.x;
        let pixels = self.pixels.get_mut(start..start + columns as usize);
        pixels.unwrap_or_default()
    }

    pub(super) fn write(&mut self, column: u32, row: u32, pixel: Pixel) {
        if let Some(place) = self.row(row, column + 1).last_mut() {
            *place = pixel;
        }
    }
}
