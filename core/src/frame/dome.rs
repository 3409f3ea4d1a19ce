//! A block of a dome master, eight rays at a time.

use super::begun::Work;
use super::block::Rendering;
use super::past::RowPast;
use super::tile::{Tile, offset};
use super::view::{Dome, RayRow};
use crate::scene::Scene;
use crate::scene::format::{Instance, kind};
use crate::simd::{Runs, Simd};
use crate::trace::{Budget, Pixel, RayDetail, RowHits, Sample, Tracer, Workspace};
use core::num::NonZeroU32;

impl<const W: usize> Rendering<'_, '_, W>
where
    Simd: Runs<W>,
{
    /// Renders the samples that are not begun, row by row, until the budget is spent.
    pub(super) fn render_dome(&self, dome: &Dome, work: &mut Work<'_>) {
        let (block, samples) = (&self.block, self.renderer.settings.samples);
        let Tile { width, height, .. } = block.tile;
        let mut detail = None;
        let mut traced = Traced::NONE;
        let columns = NonZeroU32::new(width).unwrap_or(NonZeroU32::MIN);
        let (first, mut from) = (work.begun.pixels / columns, work.begun.pixels % columns);
        for row in first..height {
            if work.budget.is_spent() {
                return;
            }
            let mut own = |column: u32| {
                let detail = detail.get_or_insert_with(|| self.detail());
                detail.at(column, row)
            };
            if samples == 1 {
                let points = (0..8).map(|column| block.at(column, row, offset(0, 1)));
                let rays = self.rays_through(dome, points);
                let own = |lane| if lane < from { None } else { own(lane) };
                traced = self.traced(rays, own, work);
                if from == 0 && !work.budget.is_spent() && self.write_past(&traced, row, work) {
                    work.begun.pixels += width;
                    continue;
                }
            }
            for column in from..width {
                if column > from && work.budget.is_spent() {
                    return;
                }
                let first = work.begun.samples;
                while work.begun.samples < samples {
                    let sample = work.begun.samples;
                    let lane = if samples == 1 {
                        column
                    } else {
                        u32::from((sample - first) % 8)
                    };
                    if samples > 1 && lane == 0 {
                        let points = (sample..samples)
                            .map(|sample| block.at(column, row, offset(sample, samples)));
                        let rays = self.rays_through(dome, points);
                        traced = self.traced(rays, |_| own(column), work);
                    }
                    let of = block.sample((column, row), sample, samples);
                    let seen = self.seen(&traced, lane, of, work);
                    if work.budget.is_exhausted() {
                        return;
                    }
                    work.begun.add(seen, work.workspace);
                    if work.begun.samples < samples && work.budget.is_spent() {
                        return;
                    }
                }
                let pixel = work.begun.take_pixel(samples);
                work.target.write(column, row, pixel);
                work.begun.pixels += 1;
            }
            from = 0;
        }
    }

    /// Returns rays through the first eight points of the picture.
    fn rays_through(&self, dome: &Dome, points: impl Iterator<Item = (f32, f32)>) -> RayRow {
        let (mut x, mut y) = ([0.0; 8], [0.0; 8]);
        for ((x, y), point) in x.iter_mut().zip(&mut y).zip(points) {
            (*x, *y) = point;
        }
        dome.row(self.renderer.tracer.simd(), &x, &y)
    }

    /// Traces rays, each in the detail of its own.
    fn traced(
        &self,
        rays: RayRow,
        mut own: impl FnMut(u32) -> Option<RayDetail>,
        work: &mut Work<'_>,
    ) -> Traced {
        let (mut detail, mut hits) = ([None; 8], None);
        if rays.seen != 0 {
            for (lane, detail) in (0..).zip(&mut detail) {
                *detail = own(lane);
            }
            let (tracer, together) = (&self.renderer.tracer, self.renderer.together);
            let (budget, workspace) = (&mut *work.budget, &mut *work.workspace);
            hits = together
                .and_then(|together| (together.row)(tracer, &rays, &detail, budget, workspace));
        }
        Traced { rays, detail, hits }
    }

    /// Writes a row of pixels if all rays see past everything; whether they do.
    fn write_past(&self, traced: &Traced, row: u32, work: &mut Work<'_>) -> bool {
        let sees_past = match &traced.hits {
            Some(hits) => hits.are_none(),
            None => traced.detail.iter().all(Option::is_none),
        };
        if !sees_past || !traced.rays.are_all() {
            return false;
        }
        let past = RowPast {
            background: self.renderer.tracer.scene().background(),
            directions: &traced.rays.directions,
        };
        let Some(past) = <Simd as Runs<8>>::run(self.renderer.tracer.simd(), past) else {
            return false;
        };
        let pixels = work.target.row(row, self.block.tile.width);
        for ((pixel, past), detail) in pixels.iter_mut().zip(past).zip(&traced.detail) {
            *pixel = past;
            work.workspace.statistics.primary += u64::from(detail.is_some());
        }
        true
    }

    /// Returns what the ray of a place sees: nothing outside the rim.
    #[inline]
    fn seen(&self, traced: &Traced, lane: u32, sample: Sample, work: &mut Work<'_>) -> Pixel {
        let (tracer, lane) = (&self.renderer.tracer, lane as usize % 8);
        let (budget, workspace) = (&mut *work.budget, &mut *work.workspace);
        let Some(ray) = traced.rays.ray(lane) else {
            return Pixel::default();
        };
        match (traced.detail[lane], &traced.hits) {
            (None, _) => self.missed(ray.direction()),
            (Some(detail), None) => tracer.radiance_with(&ray, detail, sample, budget, workspace),
            (Some(detail), Some(hits)) => {
                hits.between_lines(lane, workspace).unwrap_or_else(|| {
                    tracer.radiance_from(&ray, hits.at(lane), detail, sample, budget, workspace)
                })
            }
        }
    }
}

/// Returns whether a dome that is seen from one point is rendered by blocks, not rows.
pub(super) fn goes_in_blocks<const W: usize>(scene: &Scene<'_, W>) -> bool {
    let is_mesh = |instance: &Instance| instance.kind == kind::MESH;
    Simd::HAS_VECTORS && scene.instances.iter().all(is_mesh)
}

/// Returns the nearest hits of the rays of eight places, where they can go together.
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
}
