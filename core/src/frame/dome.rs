//! A block of a dome master, eight rays at a time.

use super::Renderer;
use super::begun::Begun;
use super::block::{Rendering, offset};
use super::past::RowPast;
use super::tile::{Block, Target};
use super::view::{Dome, RayRow};
use crate::scene::Scene;
use crate::scene::format::{Instance, kind};
use crate::simd::{Runs, Simd};
use crate::trace::{Budget, Pixel, RayDetail, RowHits, Sample, Tracer, Workspace};
use core::num::NonZeroU32;

impl Block {
    /// Renders the samples that are not begun, row by row, until the budget is spent.
    pub(super) fn render_dome<const W: usize>(
        &self,
        rendering: &Rendering<'_, '_, W, Dome>,
        begun: &mut Begun,
        budget: &mut Budget,
        workspace: &mut Workspace,
        target: &mut Target<'_>,
    ) where
        Simd: Runs<W>,
    {
        let (renderer, view, dome) = rendering.parts();
        let (simd, samples) = (renderer.tracer.simd(), renderer.settings.samples);
        let mut detail = None;
        let mut traced = Traced::NONE;
        let columns = NonZeroU32::new(self.columns).unwrap_or(NonZeroU32::MIN);
        let (first, mut from) = (begun.pixels / columns, begun.pixels % columns);
        for row in first..self.rows {
            if budget.is_spent() {
                return;
            }
            let mut own = |column: u32| {
                let detail = detail.get_or_insert_with(|| self.detail(renderer, view));
                detail.at(column, row)
            };
            if samples == 1 {
                let rays = self.rays_of_row(simd, dome, row);
                traced = Traced::new(
                    renderer,
                    rays,
                    |lane| if lane < from { None } else { own(lane) },
                    budget,
                    workspace,
                );
                if from == 0 && !budget.is_spent() {
                    let pixels = target.row(row, self.columns);
                    if traced.write_past(renderer, workspace, pixels) {
                        begun.pixels += self.columns;
                        continue;
                    }
                }
            }
            for column in from..self.columns {
                if column > from && budget.is_spent() {
                    return;
                }
                let first = begun.samples;
                while begun.samples < samples {
                    let sample = begun.samples;
                    let lane = if samples == 1 {
                        column
                    } else {
                        u32::from((sample - first) % 8)
                    };
                    if samples > 1 && lane == 0 {
                        let rays = self.rays_of_pixel(simd, dome, (column, row), sample, samples);
                        traced = Traced::new(renderer, rays, |_| own(column), budget, workspace);
                    }
                    let of = self.sample((column, row), sample, samples);
                    let seen = traced.pixel(renderer, lane, of, budget, workspace);
                    if budget.is_exhausted() {
                        return;
                    }
                    begun.add(seen, workspace);
                    if begun.samples < samples && budget.is_spent() {
                        return;
                    }
                }
                target.write(column, row, begun.take_pixel(samples));
                begun.pixels += 1;
            }
            from = 0;
        }
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

/// Whether a dome that is seen from one point is rendered by blocks, not rows.
pub(super) fn goes_in_blocks<const W: usize>(scene: &Scene<'_, W>) -> bool {
    let is_mesh = |instance: &Instance| instance.kind == kind::MESH;
    Simd::HAS_VECTORS && scene.instances.iter().all(is_mesh)
}

/// The nearest hits of the rays of eight places, where they can go together.
pub(super) fn hits_together<const W: usize, const EFFECTS: u32>(
    tracer: &Tracer<'_, W>,
    rays: &RayRow,
    detail: &[Option<RayDetail>; 8],
    budget: &mut Budget,
    workspace: &mut Workspace,
) -> Option<RowHits>
where
    Simd: Runs<W>,
{
    let one = |lane: usize| Some((rays.ray(lane)?, detail[lane % 8]?.rung));
    let rays = rays.together(detail);
    tracer
        .searcher
        .nearest_of_row::<EFFECTS>(&rays, one, budget, workspace)
}

/// Rays of eight places and, where they went together, what they met.
struct Traced {
    rays: RayRow,
    /// `None` for those that are not traced.
    detail: [Option<RayDetail>; 8],
    hits: Option<RowHits>,
}

impl Traced {
    const NONE: Self = Self {
        rays: RayRow::EMPTY,
        detail: [None; 8],
        hits: None,
    };

    fn new<const W: usize>(
        renderer: &Renderer<'_, W>,
        rays: RayRow,
        mut own: impl FnMut(u32) -> Option<RayDetail>,
        budget: &mut Budget,
        workspace: &mut Workspace,
    ) -> Self
    where
        Simd: Runs<W>,
    {
        let mut detail = [None; 8];
        if rays.seen == 0 {
            return Self {
                rays,
                detail,
                hits: None,
            };
        }
        for (lane, detail) in (0..).zip(&mut detail) {
            *detail = own(lane);
        }
        let hits = renderer.together.and_then(|together| {
            (together.row)(&renderer.tracer, &rays, &detail, budget, workspace)
        });
        Self { rays, detail, hits }
    }

    /// Writes the first pixels of a row if all rays see past everything; whether they do.
    fn write_past<const W: usize>(
        &self,
        renderer: &Renderer<'_, W>,
        workspace: &mut Workspace,
        pixels: &mut [Pixel],
    ) -> bool
    where
        Simd: Runs<W>,
    {
        let sees_past = match &self.hits {
            Some(hits) => hits.are_none(),
            None => self.detail.iter().all(Option::is_none),
        };
        if !sees_past || !self.rays.are_all() {
            return false;
        }
        let past = RowPast {
            background: renderer.tracer.scene().background(),
            directions: &self.rays.directions,
        };
        let Some(past) = <Simd as Runs<8>>::run(renderer.tracer.simd(), past) else {
            return false;
        };
        for ((pixel, past), detail) in pixels.iter_mut().zip(past).zip(&self.detail) {
            *pixel = past;
            workspace.statistics.primary += u64::from(detail.is_some());
        }
        true
    }

    /// What the ray of a place sees: nothing outside the rim.
    #[inline]
    fn pixel<const W: usize>(
        &self,
        renderer: &Renderer<'_, W>,
        lane: u32,
        sample: Sample,
        budget: &mut Budget,
        workspace: &mut Workspace,
    ) -> Pixel
    where
        Simd: Runs<W>,
    {
        let tracer = &renderer.tracer;
        let lane = lane as usize % 8;
        let Some(ray) = self.rays.ray(lane) else {
            return Pixel::default();
        };
        match (self.detail[lane], &self.hits) {
            (None, _) => tracer.missed(ray.direction()),
            (Some(detail), None) => tracer.radiance_with(&ray, detail, sample, budget, workspace),
            (Some(detail), Some(hits)) => {
                hits.between_lines(lane, workspace).unwrap_or_else(|| {
                    tracer.radiance_from(&ray, hits.at(lane), detail, sample, budget, workspace)
                })
            }
        }
    }
}
