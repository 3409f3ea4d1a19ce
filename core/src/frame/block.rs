//! A block of pixels that go through the scene together.

use super::{Mode, Renderer, View};
use crate::simd::{Runs, Simd};
use crate::trace::{Budget, Pixel, TileRays, Workspace};

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
        write: impl FnMut(u32, u32, Pixel),
    ) -> u32
    where
        Simd: Runs<W>,
    {
        // What is left of a block that was interrupted goes ray by ray.
        if renderer.settings.mode == Mode::Tile && first == 0 {
            self.render_together(renderer, view, budget, workspace, write)
        } else {
            self.render_singly(renderer, view, first, budget, workspace, write)
        }
    }

    fn render_singly<const W: usize>(
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
        for number in first..self.columns * self.rows {
            if budget.is_spent() {
                return number - first;
            }
            let (column, row) = (number % self.columns, number / self.columns);
            let pixel = self.pixel(renderer, view, (column, row), budget, workspace);
            write(column, row, pixel);
        }
        self.columns * self.rows - first
    }

    /// All samples of a pixel, one ray after the other.
    fn pixel<const W: usize>(
        &self,
        renderer: &Renderer<'_, W>,
        view: &View,
        (column, row): (u32, u32),
        budget: &mut Budget,
        workspace: &mut Workspace,
    ) -> Pixel
    where
        Simd: Runs<W>,
    {
        let samples = renderer.settings.samples;
        let mut sum = Sum::default();
        for sample in 0..samples {
            let (x, y) = self.at(column, row, offset(sample, samples));
            if let Some(ray) = view.ray(x, y) {
                sum.add(renderer.tracer.radiance(&ray, budget, workspace));
            }
        }
        sum.mean(samples)
    }

    fn render_together<const W: usize>(
        &self,
        renderer: &Renderer<'_, W>,
        view: &View,
        budget: &mut Budget,
        workspace: &mut Workspace,
        mut write: impl FnMut(u32, u32, Pixel),
    ) -> u32
    where
        Simd: Runs<W>,
    {
        let samples = renderer.settings.samples;
        let mut sums = [Sum::default(); (BLOCK * BLOCK) as usize];
        for sample in 0..samples {
            let rays = self.rays(view, offset(sample, samples));
            let hits = renderer.tracer.nearest_of_tile(&rays, budget, workspace);
            let last = sample + 1 == samples;
            for (number, sum) in (0..self.columns * self.rows).zip(&mut sums) {
                let (column, row) = (number % self.columns, number / self.columns);
                if budget.is_spent() && number > 0 && last {
                    return number;
                }
                if budget.is_spent() && !last {
                    // No pixel has all its samples yet, and none would by
                    // starting over: one is finished alone, and the block is
                    // no longer whole.
                    write(0, 0, self.pixel(renderer, view, (0, 0), budget, workspace));
                    return 1;
                }
                let at = (column as usize, row as usize);
                if let Some(ray) = rays.at(at.0, at.1) {
                    let hit = hits.at(at.0, at.1);
                    sum.add(renderer.tracer.radiance_from(&ray, hit, budget, workspace));
                }
                if last {
                    write(column, row, sum.mean(samples));
                }
            }
        }
        self.columns * self.rows
    }

    /// A point of a pixel of this block, in pixels of the view.
    fn at(&self, column: u32, row: u32, (dx, dy): (f32, f32)) -> (f32, f32) {
        ((self.x + column) as f32 + dx, (self.y + row) as f32 + dy)
    }

    /// All 64 rays; those past a cut-off block's borders repeat its last
    /// column and row.
    fn rays(&self, view: &View, offset: (f32, f32)) -> TileRays {
        TileRays::new(view.eye(), |column, row| {
            let column = (column as u32).min(self.columns - 1);
            let row = (row as u32).min(self.rows - 1);
            let (x, y) = self.at(column, row, offset);
            view.direction(x, y)
        })
    }
}

/// Samples of a pixel, in their order.
#[derive(Clone, Copy, Default)]
struct Sum(Pixel);

impl Sum {
    fn add(&mut self, pixel: Pixel) {
        self.0.red += pixel.red;
        self.0.green += pixel.green;
        self.0.blue += pixel.blue;
        self.0.alpha += pixel.alpha;
    }

    fn mean(self, samples: u16) -> Pixel {
        let share = 1.0 / f32::from(samples);
        Pixel {
            red: self.0.red * share,
            green: self.0.green * share,
            blue: self.0.blue * share,
            alpha: self.0.alpha * share,
        }
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
