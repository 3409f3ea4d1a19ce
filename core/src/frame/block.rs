//! A block of pixels that go through the scene together.

use super::{Renderer, View};
use crate::simd::{Runs, Simd};
use crate::trace::{Budget, Pixel, Workspace};

/// Pixels a side.
pub(super) const BLOCK: u32 = 8;

/// The part of a cell of the view's grid that a tile covers.
pub(super) struct Block {
    pub(super) x: u32,
    pub(super) y: u32,
    /// 1 to [`BLOCK`].
    pub(super) columns: u32,
    /// 1 to [`BLOCK`].
    pub(super) rows: u32,
}

impl Block {
    /// Renders the pixels from number `first` on, in rows, and says how many
    /// it finished.
    pub(super) fn render<const W: usize>(
        &self,
        renderer: &Renderer<'_, W>,
        view: &View,
        first: u32,
        budget: &mut Budget,
        workspace: &mut Workspace,
        mut write: impl FnMut(u32, u32, Pixel),
    ) -> u32
    where
        Simd: Runs<W>,
    {
        let mut done = 0;
        for number in first..self.columns * self.rows {
            if budget.is_spent() {
                return done;
            }
            let (column, row) = (number % self.columns, number / self.columns);
            let samples = renderer.settings.samples;
            let mut sum = Pixel::default();
            for sample in 0..samples {
                let (dx, dy) = offset(sample, samples);
                let x = (self.x + column) as f32 + dx;
                let y = (self.y + row) as f32 + dy;
                let pixel = view
                    .ray(x, y)
                    .map(|ray| renderer.tracer.radiance(&ray, budget, workspace))
                    .unwrap_or_default();
                sum.red += pixel.red;
                sum.green += pixel.green;
                sum.blue += pixel.blue;
                sum.alpha += pixel.alpha;
            }
            let share = 1.0 / f32::from(samples);
            write(
                column,
                row,
                Pixel {
                    red: sum.red * share,
                    green: sum.green * share,
                    blue: sum.blue * share,
                    alpha: sum.alpha * share,
                },
            );
            done += 1;
        }
        done
    }
}

/// Where in its pixel a sample lies, from the centre: Hammersley's points,
/// centred.
fn offset(sample: u16, samples: u16) -> (f32, f32) {
    let x = (f32::from(sample) + 0.5) / f32::from(samples) - 0.5;
    // The radical inverse: the bits of the number behind the binary point.
    let bits = samples.next_power_of_two().trailing_zeros();
    let reversed = u32::from(sample).reverse_bits().checked_shr(32 - bits);
    let steps = (1u32 << bits) as f32;
    let y = (reversed.unwrap_or(0) as f32 + 0.5) / steps - 0.5;
    (x, y)
}
