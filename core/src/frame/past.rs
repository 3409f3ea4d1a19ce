//! What pixels of a block show that see past everything.

use super::block::{BLOCK, Block, Target};
use super::view::Screen;
use crate::scene::format::Background;
use crate::simd::{Kernel, Lanes};
use crate::trace::{Colours, Pixel};
use zerocopy::transmute;

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
    /// Of its rows from the first on; false where some cannot be computed for all
    /// pixels together.
    #[inline(always)]
    fn each_row<L: Lanes<8>>(
        &self,
        l: L,
        mut take: impl FnMut(u32, [Pixel; BLOCK as usize]),
    ) -> bool {
        let (dx, dy) = self.offset;
        let columns = self.screen.columns_at(l, self.block.x, dx);
        let colours = Colours::new(l, self.background);
        let alpha = l.splat(1.0 - (1.0 - self.background.alpha));
        for row in 0..self.block.rows {
            let directions = columns.directions(l, self.block.y + row, dy);
            let Some([red, green, blue]) = colours.along(l, directions) else {
                return false;
            };
            take(row, transmute!(l.interleave([red, green, blue, alpha])));
        }
        true
    }
}

impl Kernel<8> for SeePast<'_> {
    type Output = Option<Past>;

    #[inline(always)]
    fn run<L: Lanes<8>>(self, l: L) -> Option<Past> {
        let mut past = Past(Default::default());
        self.each_row(l, |row, pixels| past.0[(row % BLOCK) as usize] = pixels)
            .then_some(past)
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
        let Self { past, target } = self;
        let columns = past.block.columns;
        past.each_row(l, |row, pixels| {
            let places = target.row(row, columns);
            match places.first_chunk_mut() {
                Some(all) => *all = pixels,
                None => {
                    for (place, pixel) in places.iter_mut().zip(pixels) {
                        *place = pixel;
                    }
                }
            }
        })
        .then_some(())
    }
}
