//! What pixels of a block show that see past everything.

use super::tile::{BLOCK, Target, Tile};
use super::view::OnePoint;
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

/// What eight pixels past everything show; `None` where they cannot be computed together.
pub(super) struct RowPast<'r> {
    pub(super) background: &'r Background,
    /// Directions, by component.
    pub(super) directions: &'r [[f32; BLOCK as usize]; 3],
}

impl Kernel<8> for RowPast<'_> {
    type Output = Option<[Pixel; BLOCK as usize]>;

    #[inline(always)]
    fn run<L: Lanes<8>>(self, l: L) -> Option<[Pixel; BLOCK as usize]> {
        let [x, y, z] = self.directions;
        let directions = [l.load(x), l.load(y), l.load(z)];
        let [red, green, blue] = Colours::new(l, self.background).along(l, directions)?;
        Some(pixels(l, self.background, [red, green, blue]))
    }
}

#[inline(always)]
fn pixels<L: Lanes<8>>(
    l: L,
    background: &Background,
    [red, green, blue]: [L::F; 3],
) -> [Pixel; BLOCK as usize] {
    // Same rounding as the alpha of a traced ray.
    let alpha = l.splat(1.0 - (1.0 - background.alpha));
    transmute!(l.interleave([red, green, blue, alpha]))
}

/// What pixels of a block show that see past all objects.
pub(super) struct SeePast<'r, S> {
    pub(super) tile: Tile,
    pub(super) background: &'r Background,
    pub(super) sight: &'r S,
    pub(super) offset: (f32, f32),
}

impl<S: OnePoint> SeePast<'_, S> {
    /// Calls `take` with each row of pixels; false where one cannot be computed together.
    #[inline(always)]
    fn each_row<L: Lanes<8>>(
        &self,
        l: L,
        mut take: impl FnMut(u32, [Pixel; BLOCK as usize]),
    ) -> bool {
        let (dx, dy) = self.offset;
        let columns = self.sight.columns_at(l, self.tile.x, dx);
        let colours = Colours::new(l, self.background);
        for row in 0..self.tile.height {
            let y = self.tile.y + row;
            let directions = self.sight.towards_row(l, &columns, y, dy);
            let Some(colours) = colours.along(l, directions) else {
                return false;
            };
            take(row, pixels(l, self.background, colours));
        }
        true
    }
}

impl<S: OnePoint> Kernel<8> for SeePast<'_, S> {
    type Output = Option<Past>;

    #[inline(always)]
    fn run<L: Lanes<8>>(self, l: L) -> Option<Past> {
        let mut past = Past(Default::default());
        self.each_row(l, |row, pixels| past.0[(row % BLOCK) as usize] = pixels)
            .then_some(past)
    }
}

/// Writes [`SeePast`]'s pixels straight to the target; `None` if a row cannot be computed.
pub(super) struct CopyPast<'r, 't, 'p, S> {
    pub(super) past: SeePast<'r, S>,
    pub(super) target: &'t mut Target<'p>,
}

impl<S: OnePoint> Kernel<8> for CopyPast<'_, '_, '_, S> {
    type Output = Option<()>;

    #[inline(always)]
    fn run<L: Lanes<8>>(self, l: L) -> Option<()> {
        let Self { past, target } = self;
        let columns = past.tile.width;
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
