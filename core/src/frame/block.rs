//! A block of pixels whose rays are traced together.

use super::begun::{Sum, Work};
use super::detail::BlockDetail;
use super::past::{CopyPast, SeePast};
use super::tile::{BLOCK, Block, Target, Tile, offset, spread};
use super::view::{Dome, Kind, OnePoint, Screen, View};
use super::{Renderer, Together};
use crate::gaze::Region;
use crate::simd::{Kernel, Lanes, Runs, Simd};
use crate::trace::{NOT_TRACED, Pixel, RayDetail, Sample, TileRays};
use core::num::NonZeroU32;
use glam::Vec3;

/// A block of a view, and the renderer for it.
pub(super) struct Rendering<'r, 'a, const W: usize> {
    pub(super) renderer: &'r Renderer<'a, W>,
    pub(super) view: &'r View,
    pub(super) block: Block,
}

impl<const W: usize> Rendering<'_, '_, W>
where
    Simd: Runs<W>,
{
    /// Renders the remaining samples, row by row, until the budget is spent.
    pub(super) fn render(&self, work: &mut Work<'_>) {
        let (block, fresh) = (&self.block, work.begun.is_nothing());
        match (self.view.kind(), self.renderer.together) {
            (Kind::Dome(dome), _) if fresh && block.is_outside(dome, &mut work.target) => {
                work.begun.pixels = block.tile.area();
            }
            // An interrupted block is finished ray by ray.
            (Kind::Screen(screen), Some(together)) if fresh => (together.block)(self, screen, work),
            // A dome seen from one point is rendered like a screen. Targets without vectors
            // have no code for this, which saves stack.
            (
                Kind::Dome(dome),
                Some(Together {
                    dome_block: Some(render),
                    ..
                }),
            ) if Simd::HAS_VECTORS && fresh && dome.sees_all_from(block.tile.x, block.tile.y) => {
                render(self, dome, work);
            }
            // Eight rays at once on targets with vectors.
            (Kind::Dome(dome), _) if Simd::HAS_VECTORS => self.render_dome(dome, work),
            _ => self.render_singly(work),
        }
    }

    // Not inlined: keeps its stack frame out of the callers'.
    #[inline(never)]
    fn render_singly(&self, work: &mut Work<'_>) {
        if let (Kind::Screen(screen), true) = (self.view.kind(), work.begun.is_nothing())
            && !self.any_sample_reaches(screen, work)
        {
            self.show_background_only(work);
            return;
        }
        let tile = self.block.tile;
        let detail = self.grid_detail();
        while work.begun.pixels < tile.area() {
            let (column, row) = self.block.place(work.begun.pixels);
            let own = detail.at(tile.x % BLOCK + column, tile.y % BLOCK + row);
            let Some(pixel) = self.pixel(own, work) else {
                return;
            };
            work.target.write(column, row, pixel);
            // Every call traces at least one sample.
            if work.budget.is_spent() {
                return;
            }
        }
    }

    /// Returns whether any sample of any pixel is traced and may hit anything: one test for all.
    fn any_sample_reaches(&self, screen: &Screen, work: &mut Work<'_>) -> bool {
        let around = spread(self.renderer.settings.samples);
        let (block, tile) = (&self.block, self.block.tile);
        let first = block.at(0, 0, (-around, -around));
        let last = block.at(tile.width - 1, tile.height - 1, (around, around));
        self.reaches(screen.eye, || screen.corners_between(first, last), work)
    }

    /// Renders all of its pixels when none sees an object.
    fn show_background_only(&self, work: &mut Work<'_>) {
        for (column, row) in self.block.places_from(0) {
            let pixel = self.pixel(None, work);
            work.target.write(column, row, pixel.unwrap_or_default());
        }
        let samples = u64::from(self.renderer.settings.samples);
        work.workspace.statistics.primary += samples * self.count_traced();
    }

    fn grid_detail(&self) -> BlockDetail {
        let Block { tile, patch } = self.block;
        self.renderer.block_detail(patch, self.view, tile.x, tile.y)
    }

    /// Returns the detail of its pixels, by its own columns and rows.
    pub(super) fn detail(&self) -> BlockDetail {
        let (tile, detail) = (self.block.tile, self.grid_detail());
        detail.part((tile.x % BLOCK, tile.y % BLOCK), (tile.width, tile.height))
    }

    fn count_traced(&self) -> u64 {
        let Block { tile, patch } = self.block;
        let traced = self.renderer.block_traced(patch, self.view, tile.x, tile.y);
        let (x, y) = (tile.x % BLOCK, tile.y % BLOCK);
        let columns = (0xff >> (BLOCK - tile.width)) << x;
        let mut count = 0;
        for row in y..y + tile.height {
            count += u64::from((traced >> (BLOCK * row) & columns).count_ones());
        }
        count
    }

    /// Renders the rest of the next pixel's samples; `None` if the budget ends before the last.
    fn pixel(&self, detail: Option<RayDetail>, work: &mut Work<'_>) -> Option<Pixel> {
        let (tracer, samples) = (&self.renderer.tracer, self.renderer.settings.samples);
        let (column, row) = self.block.place(work.begun.pixels);
        while work.begun.samples < samples {
            let sample = work.begun.samples;
            let (x, y) = self.block.at(column, row, offset(sample, samples));
            let traced = detail.and_then(|detail| Some((detail, self.view.ray(x, y)?)));
            let seen = if let Some((detail, ray)) = traced {
                // Checked here, since samples that are not traced take no steps.
                if work.begun.is_interrupted(work.budget) {
                    return None;
                }
                let own = self.block.sample((column, row), sample, samples);
                let seen = tracer.radiance_with(&ray, detail, own, work.budget, work.workspace);
                if work.budget.is_exhausted() {
                    return None;
                }
                seen
            } else {
                self.renderer.past(self.view, x, y)
            };
            work.begun.add(seen, work.workspace);
        }
        work.begun.pixels += 1;
        Some(work.begun.take_pixel(samples))
    }

    /// Renders all of its pixels with rays that are traced together.
    pub(super) fn render_together<S: OnePoint>(&self, sight: &S, work: &mut Work<'_>) {
        let (simd, samples) = (self.renderer.tracer.simd(), self.renderer.settings.samples);
        let offset = offset(0, samples);
        let corners = || self.block.corners(simd, sight, offset);
        let reaches = self.reaches(sight.eye(), corners, work);
        if samples == 1 && !reaches {
            // The mean of one sample is the sample.
            let (past, target) = (self.past(sight, offset), &mut work.target);
            let copied = <Simd as Runs<8>>::run(simd, CopyPast { past, target });
            if copied.is_some() {
                work.workspace.statistics.primary += self.count_traced();
                work.begun.pixels = self.block.tile.area();
                return;
            }
        }
        self.render_samples(sight, reaches, work);
    }

    /// Returns whether a traced sample may hit anything in directions between four corners.
    fn reaches(&self, eye: Vec3, corners: impl FnOnce() -> [Vec3; 4], work: &mut Work<'_>) -> bool {
        let tracer = &self.renderer.tracer;
        self.block.patch != Region::Outside
            && tracer.may_hit(eye, &corners(), work.budget, work.workspace)
    }

    /// Renders sample by sample; `reaches` says whether the first may hit anything.
    fn render_samples<S: OnePoint>(&self, sight: &S, mut reaches: bool, work: &mut Work<'_>) {
        let (tracer, samples) = (&self.renderer.tracer, self.renderer.settings.samples);
        let (block, tile) = (&self.block, self.block.tile);
        let mut detail = None;
        let mut sums = [[Sum::NONE; BLOCK as usize]; BLOCK as usize];
        for sample in 0..samples {
            let offset = offset(sample, samples);
            let last = sample + 1 == samples;
            if sample > 0 {
                if work.budget.is_spent() {
                    return;
                }
                let corners = || block.corners(tracer.simd(), sight, offset);
                reaches = self.reaches(sight.eye(), corners, work);
            }
            let found = reaches.then(|| {
                let detail = &*detail.get_or_insert_with(|| self.detail());
                let rays = self.rays(sight, offset, detail);
                let hits = tracer.nearest_of_tile(&rays, work.budget, work.workspace);
                (detail, rays, hits)
            });
            if work.budget.is_exhausted() {
                return;
            }
            let past = <Simd as Runs<8>>::run(tracer.simd(), self.past(sight, offset));
            for (row, sums) in (0..tile.height).zip(&mut sums) {
                for (column, sum) in (0..tile.width).zip(sums) {
                    let number = row * tile.width + column;
                    let mut traced = false;
                    let hit = found.as_ref().and_then(|(detail, rays, hits)| {
                        let own = detail.at(column, row)?;
                        traced = true;
                        let (column, row) = (column as usize, row as usize);
                        Some((own, rays.at(column, row)?, hits.at(column, row)?))
                    });
                    if let Some((own, ray, hit)) = hit {
                        let mut seen = None;
                        if number == 0 || !work.budget.is_spent() {
                            let of = block.sample((column, row), sample, samples);
                            let (budget, workspace) = (&mut *work.budget, &mut *work.workspace);
                            let hit = Some(hit);
                            let light = tracer.radiance_from(&ray, hit, own, of, budget, workspace);
                            seen = Some(light).filter(|_| !budget.is_exhausted());
                        }
                        let Some(seen) = seen else {
                            if last {
                                work.begun.keep(number, sample, sum);
                            }
                            return;
                        };
                        sum.add(seen, work.workspace);
                    } else {
                        work.workspace.statistics.primary += u64::from(traced);
                        let missed = if let Some(past) = &past {
                            past.pixel(column, row)
                        } else {
                            let (x, y) = block.at(column, row, offset);
                            self.missed(sight.towards(x, y))
                        };
                        sum.add(missed, work.workspace);
                    }
                    if last {
                        work.target.write(column, row, sum.mean(samples));
                    } else if number == 0 {
                        work.begun.keep(0, sample + 1, sum);
                    }
                }
            }
            if found.is_none() {
                work.workspace.statistics.primary += self.count_traced();
            }
        }
        work.begun.finish(tile.area());
    }

    /// Returns what is seen past all objects along a direction.
    pub(super) fn missed(&self, direction: Vec3) -> Pixel {
        self.renderer.missed(self.view, direction)
    }

    /// Returns what pixels that see past all objects show.
    pub(super) fn past<'s, S>(&'s self, sight: &'s S, offset: (f32, f32)) -> SeePast<'s, S> {
        SeePast {
            tile: self.block.tile,
            background: self.renderer.tracer.scene().background(),
            sight,
            offset,
        }
    }

    /// Returns all 64 rays; those past the borders of a cut-off block are not traced.
    fn rays<S: OnePoint>(&self, sight: &S, offset: (f32, f32), detail: &BlockDetail) -> TileRays {
        let simd = self.renderer.tracer.simd();
        let rays = <Simd as Runs<8>>::run(simd, RaysOf(self.block.tile, sight, offset));
        match detail {
            BlockDetail::Equal(detail) => rays.on_rung(detail.rung),
            BlockDetail::Own(own) => rays.on_rungs(&own.rungs),
            BlockDetail::Outside => rays.on_rungs(&[[NOT_TRACED; 8]; 8]),
        }
    }
}

impl Block {
    /// Returns whether all of its pixels lie outside a dome's rim; clears them if so.
    // Not inlined: keeps its stack frame out of the callers'.
    #[inline(never)]
    fn is_outside(&self, dome: &Dome, target: &mut Target<'_>) -> bool {
        let is_outside = dome.sees_nothing_from(self.tile.x, self.tile.y);
        if is_outside {
            for row in 0..self.tile.height {
                target.row(row, self.tile.width).fill(Pixel::default());
            }
        }
        is_outside
    }

    /// Returns the column and row of a pixel's number, row by row.
    fn place(&self, number: u32) -> (u32, u32) {
        let columns = NonZeroU32::new(self.tile.width).unwrap_or(NonZeroU32::MIN);
        (number % columns, number / columns)
    }

    /// Returns columns and rows of its pixels from number `first` on, row by row.
    pub(super) fn places_from(&self, first: u32) -> impl Iterator<Item = (u32, u32)> {
        (first..self.tile.area()).map(|number| self.place(number))
    }

    /// Returns a point of a pixel of this block, in pixels of the view.
    pub(super) fn at(&self, column: u32, row: u32, (dx, dy): (f32, f32)) -> (f32, f32) {
        let Tile { x, y, .. } = self.tile;
        ((x + column) as f32 + dx, (y + row) as f32 + dy)
    }

    #[inline(always)]
    pub(super) fn sample(&self, (column, row): (u32, u32), index: u16, count: u16) -> Sample {
        Sample::new(self.tile.x + column, self.tile.y + row, index, count)
    }

    /// Returns the directions between which its pixels lie, at an offset from their centres.
    fn corners(&self, simd: Simd, sight: &impl OnePoint, offset: (f32, f32)) -> [Vec3; 4] {
        let (first, tile) = ((self.tile.x, self.tile.y), self.tile);
        let last = (tile.x + tile.width - 1, tile.y + tile.height - 1);
        sight.corners(simd, first, last, offset)
    }
}

struct RaysOf<'r, S>(Tile, &'r S, (f32, f32));

impl<S: OnePoint> Kernel<8> for RaysOf<'_, S> {
    type Output = TileRays;

    #[inline(always)]
    fn run<L: Lanes<8>>(self, l: L) -> TileRays {
        let Self(tile, sight, (dx, dy)) = self;
        let columns = sight.columns_at(l, tile.x, dx);
        let mut rays = TileRays::without_directions(sight.eye());
        // Not a closure's body, which would leave the vectors' instruction set.
        for row in 0..8 {
            let [x, y, z] = sight.towards_row(l, &columns, tile.y + row as u32, dy);
            rays.set_row(row, &[l.store(x), l.store(y), l.store(z)]);
        }
        rays
    }
}
