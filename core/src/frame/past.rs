//! What pixels of a block show that see past everything.

use super::block::{BLOCK, Block, Target};
use super::view::Screen;
use crate::scene::format::Background;
use crate::simd::{Kernel, Lanes};
use crate::trace::{self, Pixel};

/// What is seen past all objects, by row, then column.
pub(super) struct Past([[Pixel; BLOCK as usize]; BLOCK as usize]);

impl Past {
    #[inline(always)]
    fn row(&self, row: u32) -> &[Pixel; BLOCK as usize] {
        &self.0[(row % BLOCK) as usize]
    }

    #[inline(always)]
    pub(super) fn pixel(&self, column: u32, row: u32) -> Pixel {
        self.row(row)[(column % BLOCK) as usize]
    }
}

/// What pixels of a block show that see past everything.
pub(super) struct SeePast<'r> {
    pub(super) block: &'r Block,
    pub(super) background: &'r Background,
    pub(super) screen: &'r Screen,
    pub(super) offset: (f32, f32),
}

impl SeePast<'_> {
    /// Of a row; `None` where that cannot be computed for all together.
    #[inline(always)]
    fn row<L: Lanes<8>>(&self, l: L, row: u32) -> Option<[Pixel; BLOCK as usize]> {
        let place = (self.block.x, self.block.y + row);
        let directions = self.screen.directions_at(l, place, self.offset);
        let [red, green, blue] = trace::colours(l, self.background, directions)?;
        let (red, green, blue) = (l.store(red), l.store(green), l.store(blue));
        let alpha = 1.0 - (1.0 - self.background.alpha);
        let mut pixels = [Pixel::default(); BLOCK as usize];
        for (column, pixel) in pixels.iter_mut().enumerate() {
            *pixel = Pixel {
                red: red[column],
                green: green[column],
                blue: blue[column],
                alpha,
            };
        }
        Some(pixels)
    }
}

impl Kernel<8> for SeePast<'_> {
    type Output = Option<Past>;

    #[inline(always)]
    fn run<L: Lanes<8>>(self, l: L) -> Option<Past> {
        let mut past = Past(Default::default());
        for row in 0..self.block.rows {
            past.0[(row % BLOCK) as usize] = self.row(l, row)?;
        }
        Some(past)
    }
}

/// The same, straight to where the pixels go: `None` where some are not there.
pub(super) struct CopyPast<'r, 't, 'p> {
    pub(super) past: SeePast<'r>,
    pub(super) target: &'t mut Target<'p>,
}

impl Kernel<8> for CopyPast<'_, '_, '_> {
    type Output = Option<()>;

    #[inline(always)]
    fn run<L: Lanes<8>>(self, l: L) -> Option<()> {
        let block = self.past.block;
        for row in 0..block.rows {
            let pixels = self.past.row(l, row)?;
            let places = self.target.row(row, block.columns);
            for (place, pixel) in places.iter_mut().zip(&pixels) {
                *place = *pixel;
            }
        }
        Some(())
    }
}
