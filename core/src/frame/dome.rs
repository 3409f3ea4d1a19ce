//! A block of a dome master: rays made eight at a time and traced one by one.

use super::Renderer;
use super::block::{Block, Sum, Target, offset};
use super::view::{Dome, RayRow, View};
use crate::simd::{Runs, Simd};
use crate::trace::{Budget, Pixel, RayDetail, Workspace};

impl Block {
    /// Renders the pixels from number `first` on, in rows, and says how many
    /// it finished.
    pub(super) fn render_dome<const W: usize>(
        &self,
        renderer: &Renderer<'_, W>,
        (view, dome): (&View, &Dome),
        first: u32,
        budget: &mut Budget,
        workspace: &mut Workspace,
        target: &mut Target<'_>,
    ) -> u32
    where
        Simd: Runs<W>,
    {
        let (simd, samples) = (renderer.tracer.simd(), renderer.settings.samples);
        let mut detail = None;
        let mut made: Option<(u32, RayRow)> = None;
        for number in first..self.columns * self.rows {
            if budget.is_spent() {
                return number - first;
            }
            let (column, row) = (number % self.columns, number / self.columns);
            let mut own = || {
                let detail = detail.get_or_insert_with(|| self.detail(renderer, view));
                detail.at(column, row)
            };
            let pixel = if samples == 1 {
                let rays = match made.take() {
                    Some((of, rays)) if of == row => rays,
                    _ => self.rays_of_row(simd, dome, row),
                };
                let (_, rays) = made.insert((row, rays));
                if rays.is_empty() {
                    Pixel::default()
                } else {
                    let lane = column as usize;
                    seen(renderer, (rays, lane), own(), budget, workspace)
                }
            } else {
                let mut sum = Sum::default();
                for sample in 0..samples {
                    let lane = usize::from(sample % 8);
                    let rays = match made.take() {
                        Some((_, rays)) if lane > 0 => rays,
                        _ => self.rays_of_pixel(simd, dome, (column, row), sample, samples),
                    };
                    let (_, rays) = made.insert((row, rays));
                    if !rays.is_empty() {
                        sum.add(seen(renderer, (rays, lane), own(), budget, workspace));
                    }
                }
                sum.mean(samples)
            };
            target.write(column, row, pixel);
        }
        self.columns * self.rows - first
    }

    /// Through the centres of its pixels in a row.
    fn rays_of_row(&self, simd: Simd, dome: &Dome, row: u32) -> RayRow {
        let (mut x, mut y) = ([0.0; 8], [0.0; 8]);
        let centre = offset(0, 1);
        for (column, (x, y)) in (0..).zip(x.iter_mut().zip(&mut y)) {
            (*x, *y) = self.at(column, row, centre);
        }
        dome.row(simd, &x, &y)
    }

    /// Eight samples of a pixel, from one on.
    fn rays_of_pixel(
        &self,
        simd: Simd,
        dome: &Dome,
        (column, row): (u32, u32),
        sample: u16,
        samples: u16,
    ) -> RayRow {
        let (mut x, mut y) = ([0.0; 8], [0.0; 8]);
        for (sample, (x, y)) in (sample..samples).zip(x.iter_mut().zip(&mut y)) {
            (*x, *y) = self.at(column, row, offset(sample, samples));
        }
        dome.row(simd, &x, &y)
    }
}

/// What a ray sees: nothing outside the rim.
fn seen<const W: usize>(
    renderer: &Renderer<'_, W>,
    (rays, lane): (&RayRow, usize),
    detail: Option<RayDetail>,
    budget: &mut Budget,
    workspace: &mut Workspace,
) -> Pixel
where
    Simd: Runs<W>,
{
    let tracer = &renderer.tracer;
    match (rays.ray(lane), detail) {
        (Some(ray), Some(detail)) => tracer.radiance_with(&ray, detail, budget, workspace),
        (Some(ray), None) => tracer.missed(ray.direction()),
        (None, _) => Pixel::default(),
    }
}
