//! A block of pixels that go through the scene together.

use super::begun::{Begun, Sum};
use super::detail::BlockDetail;
use super::past::{CopyPast, SeePast};
use super::tile::{BLOCK, Block, Target};
use super::view::{Dome, Kind, OnePoint, Screen, View};
use super::{Renderer, Together};
use crate::gaze::Region;
use crate::simd::{Kernel, Lanes, Runs, Simd};
use crate::trace::{Budget, NOT_TRACED, Pixel, RayDetail, Sample, TileRays, Workspace};
use core::num::NonZeroU32;
use glam::Vec3;

/// What the pixels of a block are rendered with.
pub(super) struct Rendering<'r, 'a, const W: usize, S> {
    pub(super) renderer: &'r Renderer<'a, W>,
    pub(super) view: &'r View,
    /// The view's screen or dome.
    pub(super) sight: &'r S,
}

impl<'r, 'a, const W: usize, S> Rendering<'r, 'a, W, S> {
    pub(super) const fn parts(&self) -> (&'r Renderer<'a, W>, &'r View, &'r S) {
        (self.renderer, self.view, self.sight)
    }
}

impl Block {
    /// Renders the samples that are not begun, row by row, until the budget is spent.
    pub(super) fn render<const W: usize>(
        &self,
        renderer: &Renderer<'_, W>,
        view: &View,
        begun: &mut Begun,
        budget: &mut Budget,
        workspace: &mut Workspace,
        target: &mut Target<'_>,
    ) where
        Simd: Runs<W>,
    {
        let fresh = begun.is_nothing();
        match (view.kind(), renderer.together) {
            (Kind::Dome(dome), _) if fresh && self.is_outside(dome, target) => {
                begun.pixels = self.area();
            }
            // An interrupted block is finished ray by ray.
            (Kind::Screen(screen), Some(together)) if fresh => {
                let rendering = Rendering {
                    renderer,
                    view,
                    sight: screen,
                };
                (together.block)(self, &rendering, begun, budget, workspace, target);
            }
            // A dome seen from one point goes as a screen does. Targets without vectors have
            // no code for it, which saves stack.
            (
                Kind::Dome(dome),
                Some(Together {
                    dome_block: Some(render),
                    ..
                }),
            ) if Simd::HAS_VECTORS && fresh && dome.sees_all_from(self.x, self.y) => {
                let rendering = Rendering {
                    renderer,
                    view,
                    sight: dome,
                };
                render(self, &rendering, begun, budget, workspace, target);
            }
            // Eight rays at once on targets with vectors.
            (Kind::Dome(dome), _) if Simd::HAS_VECTORS => {
                let rendering = Rendering {
                    renderer,
                    view,
                    sight: dome,
                };
                self.render_dome(&rendering, begun, budget, workspace, target);
            }
            _ => self.render_singly(renderer, view, begun, budget, workspace, target),
        }
    }

    /// Whether all of its pixels lie outside a dome's rim; clears them if so.
    // Not inlined: keeps its stack frame out of the callers'.
    #[inline(never)]
    fn is_outside(&self, dome: &Dome, target: &mut Target<'_>) -> bool {
        let is_outside = dome.sees_nothing_from(self.x, self.y);
        if is_outside {
            for row in 0..self.rows {
                target.row(row, self.columns).fill(Pixel::default());
            }
        }
        is_outside
    }

    // Not inlined: keeps its stack frame out of the callers'.
    #[inline(never)]
    fn render_singly<const W: usize>(
        &self,
        renderer: &Renderer<'_, W>,
        view: &View,
        begun: &mut Begun,
        budget: &mut Budget,
        workspace: &mut Workspace,
        target: &mut Target<'_>,
    ) where
        Simd: Runs<W>,
    {
        if let (Kind::Screen(screen), true) = (view.kind(), begun.is_nothing())
            && !self.any_sample_reaches(renderer, screen, budget, workspace)
        {
            self.show_background_only(renderer, view, begun, budget, workspace, target);
            return;
        }
        let detail = renderer.block_detail(self.patch, view, self.x, self.y);
        while begun.pixels < self.area() {
            let (column, row) = self.place(begun.pixels);
            let own = detail.at(self.x % BLOCK + column, self.y % BLOCK + row);
            let Some(pixel) = self.pixel(renderer, view.kind(), own, begun, budget, workspace)
            else {
                return;
            };
            target.write(column, row, pixel);
            // Every call traces at least one sample.
            if budget.is_spent() {
                return;
            }
        }
    }

    /// Whether any sample of any pixel is traced and may hit anything: one test for all.
    fn any_sample_reaches<const W: usize>(
        &self,
        renderer: &Renderer<'_, W>,
        screen: &Screen,
        budget: &mut Budget,
        workspace: &mut Workspace,
    ) -> bool
    where
        Simd: Runs<W>,
    {
        let around = spread(renderer.settings.samples);
        let first = self.at(0, 0, (-around, -around));
        let last = self.at(self.columns - 1, self.rows - 1, (around, around));
        let corners = || screen.corners_between(first, last);
        self.reaches(renderer, screen.eye, corners, budget, workspace)
    }

    /// Renders all of its pixels, given that none sees an object.
    fn show_background_only<const W: usize>(
        &self,
        renderer: &Renderer<'_, W>,
        view: &View,
        begun: &mut Begun,
        budget: &mut Budget,
        workspace: &mut Workspace,
        target: &mut Target<'_>,
    ) where
        Simd: Runs<W>,
    {
        for (column, row) in self.places_from(0) {
            let pixel = self.pixel(renderer, view.kind(), None, begun, budget, workspace);
            target.write(column, row, pixel.unwrap_or_default());
        }
        let traced = renderer.block_traced(self.patch, view, self.x, self.y);
        let samples = u64::from(renderer.settings.samples);
        workspace.statistics.primary += samples * self.count(traced);
    }

    /// Its number of pixels.
    const fn area(&self) -> u32 {
        self.columns * self.rows
    }

    /// Column and row of a pixel's number, row by row.
    fn place(&self, number: u32) -> (u32, u32) {
        let columns = NonZeroU32::new(self.columns).unwrap_or(NonZeroU32::MIN);
        (number % columns, number / columns)
    }

    /// Columns and rows of its pixels from number `first` on, row by row.
    pub(super) fn places_from(&self, first: u32) -> impl Iterator<Item = (u32, u32)> {
        (first..self.area()).map(|number| self.place(number))
    }

    /// Detail of its pixels, by its own columns and rows.
    pub(super) fn detail<const W: usize>(
        &self,
        renderer: &Renderer<'_, W>,
        view: &View,
    ) -> BlockDetail
    where
        Simd: Runs<W>,
    {
        renderer
            .block_detail(self.patch, view, self.x, self.y)
            .part((self.x % BLOCK, self.y % BLOCK), (self.columns, self.rows))
    }

    /// Renders the rest of the next pixel's samples; `None` where the budget ends before the last.
    fn pixel<const W: usize>(
        &self,
        renderer: &Renderer<'_, W>,
        kind: &Kind,
        detail: Option<RayDetail>,
        begun: &mut Begun,
        budget: &mut Budget,
        workspace: &mut Workspace,
    ) -> Option<Pixel>
    where
        Simd: Runs<W>,
    {
        let samples = renderer.settings.samples;
        let tracer = &renderer.tracer;
        let (column, row) = self.place(begun.pixels);
        while begun.samples < samples {
            let (x, y) = self.at(column, row, offset(begun.samples, samples));
            let ray = match kind {
                Kind::Screen(screen) => screen.ray(x, y),
                Kind::Dome(dome) => dome.ray(x, y),
            };
            let seen = match (detail, ray, kind) {
                (Some(detail), Some(ray), _) => {
                    // Here, as samples that are not traced take no steps.
                    if begun.is_interrupted(budget) {
                        return None;
                    }
                    let own = self.sample((column, row), begun.samples, samples);
                    let seen = tracer.radiance_with(&ray, detail, own, budget, workspace);
                    if budget.is_exhausted() {
                        return None;
                    }
                    seen
                }
                (_, _, Kind::Screen(screen)) => tracer.missed(screen.direction(x, y)),
                (None, Some(ray), Kind::Dome(_)) => tracer.missed(ray.direction()),
                // Outside the rim.
                (_, None, Kind::Dome(_)) => Pixel::default(),
            };
            begun.add(seen, workspace);
        }
        begun.pixels += 1;
        Some(begun.take_pixel(samples))
    }

    /// Renders all of its pixels with rays that go through the scene together.
    pub(super) fn render_together<const W: usize, S: OnePoint>(
        &self,
        rendering: &Rendering<'_, '_, W, S>,
        begun: &mut Begun,
        budget: &mut Budget,
        workspace: &mut Workspace,
        target: &mut Target<'_>,
    ) where
        Simd: Runs<W>,
    {
        let (renderer, view, sight) = rendering.parts();
        let samples = renderer.settings.samples;
        let offset = offset(0, samples);
        let corners = || self.corners(renderer.tracer.simd(), sight, offset);
        let reaches = self.reaches(renderer, sight.eye(), corners, budget, workspace);
        if samples == 1 && !reaches {
            // The mean of one sample is the sample.
            let past = self.past(renderer, sight, offset);
            let copied = <Simd as Runs<8>>::run(renderer.tracer.simd(), CopyPast { past, target });
            if copied.is_some() {
                let traced = renderer.block_traced(self.patch, view, self.x, self.y);
                workspace.statistics.primary += self.count(traced);
                begun.pixels = self.area();
                return;
            }
        }
        self.render_samples(rendering, reaches, begun, budget, workspace, target);
    }

    /// Whether a traced sample may hit anything in directions between four corners.
    fn reaches<const W: usize>(
        &self,
        renderer: &Renderer<'_, W>,
        eye: Vec3,
        corners: impl FnOnce() -> [Vec3; 4],
        budget: &mut Budget,
        workspace: &mut Workspace,
    ) -> bool
    where
        Simd: Runs<W>,
    {
        self.patch != Region::Outside && {
            let tracer = &renderer.tracer;
            tracer.may_hit(eye, &corners(), budget, workspace)
        }
    }

    /// Renders sample by sample; `reaches` says whether the first may hit anything.
    fn render_samples<const W: usize, S: OnePoint>(
        &self,
        rendering: &Rendering<'_, '_, W, S>,
        mut reaches: bool,
        begun: &mut Begun,
        budget: &mut Budget,
        workspace: &mut Workspace,
        target: &mut Target<'_>,
    ) where
        Simd: Runs<W>,
    {
        let (renderer, view, sight) = rendering.parts();
        let (tracer, samples) = (&renderer.tracer, renderer.settings.samples);
        let mut detail = None;
        let mut sums = [[Sum::NONE; BLOCK as usize]; BLOCK as usize];
        for sample in 0..samples {
            let offset = offset(sample, samples);
            let last = sample + 1 == samples;
            if sample > 0 {
                if budget.is_spent() {
                    return;
                }
                let corners = || self.corners(tracer.simd(), sight, offset);
                reaches = self.reaches(renderer, sight.eye(), corners, budget, workspace);
            }
            let found = reaches.then(|| {
                let detail = &*detail.get_or_insert_with(|| self.detail(renderer, view));
                let rays = self.rays(renderer, sight, offset, detail);
                let hits = tracer.nearest_of_tile(&rays, budget, workspace);
                (detail, rays, hits)
            });
            if budget.is_exhausted() {
                return;
            }
            let past = self.past(renderer, sight, offset);
            let past = <Simd as Runs<8>>::run(tracer.simd(), past);
            for (row, sums) in (0..self.rows).zip(&mut sums) {
                for (column, sum) in (0..self.columns).zip(sums) {
                    let number = row * self.columns + column;
                    let mut traced = false;
                    let hit = found.as_ref().and_then(|(detail, rays, hits)| {
                        let own = detail.at(column, row)?;
                        traced = true;
                        let (column, row) = (column as usize, row as usize);
                        Some((own, rays.at(column, row)?, hits.at(column, row)?))
                    });
                    if let Some((own, ray, hit)) = hit {
                        let mut seen = None;
                        if number == 0 || !budget.is_spent() {
                            let of = self.sample((column, row), sample, samples);
                            let hit = Some(hit);
                            let light = tracer.radiance_from(&ray, hit, own, of, budget, workspace);
                            seen = Some(light).filter(|_| !budget.is_exhausted());
                        }
                        let Some(seen) = seen else {
                            if last {
                                begun.keep(number, sample, sum);
                            }
                            return;
                        };
                        sum.add(seen, workspace);
                    } else {
                        workspace.statistics.primary += u64::from(traced);
                        let missed = if let Some(past) = &past {
                            past.pixel(column, row)
                        } else {
                            let (x, y) = self.at(column, row, offset);
                            tracer.missed(sight.towards(x, y))
                        };
                        sum.add(missed, workspace);
                    }
                    if last {
                        target.write(column, row, sum.mean(samples));
                    } else if number == 0 {
                        begun.keep(0, sample + 1, sum);
                    }
                }
            }
            if found.is_none() {
                let traced = renderer.block_traced(self.patch, view, self.x, self.y);
                workspace.statistics.primary += self.count(traced);
            }
        }
        begun.finish(self.area());
    }

    /// Counts its pixels in a set of the grid block's, a bit each.
    fn count(&self, set: u64) -> u64 {
        let (x, y) = (self.x % BLOCK, self.y % BLOCK);
        let columns = (0xff >> (BLOCK - self.columns)) << x;
        let mut count = 0;
        for row in y..y + self.rows {
            count += u64::from((set >> (BLOCK * row) & columns).count_ones());
        }
        count
    }

    /// What its pixels show that see past all objects.
    fn past<'r, const W: usize, S: OnePoint>(
        &'r self,
        renderer: &'r Renderer<'_, W>,
        sight: &'r S,
        offset: (f32, f32),
    ) -> SeePast<'r, S>
    where
        Simd: Runs<W>,
    {
        SeePast {
            block: self,
            background: renderer.tracer.scene().background(),
            sight,
            offset,
        }
    }

    /// A point of a pixel of this block, in pixels of the view.
    pub(super) fn at(&self, column: u32, row: u32, (dx, dy): (f32, f32)) -> (f32, f32) {
        ((self.x + column) as f32 + dx, (self.y + row) as f32 + dy)
    }

    /// The sampling pattern of one pixel.
    #[inline(always)]
    pub(super) fn sample(&self, (column, row): (u32, u32), index: u16, count: u16) -> Sample {
        Sample::new(self.x + column, self.y + row, index, count)
    }

    /// Directions between which its pixels lie, at an offset from their centres.
    fn corners(&self, simd: Simd, sight: &impl OnePoint, offset: (f32, f32)) -> [Vec3; 4] {
        let last = (self.x + self.columns - 1, self.y + self.rows - 1);
        sight.corners(simd, (self.x, self.y), last, offset)
    }

    /// All 64 rays; those past a cut-off block's borders are not traced.
    fn rays<const W: usize, S: OnePoint>(
        &self,
        renderer: &Renderer<'_, W>,
        sight: &S,
        offset: (f32, f32),
        detail: &BlockDetail,
    ) -> TileRays
    where
        Simd: Runs<W>,
    {
        let rays = RaysOf {
            block: self,
            sight,
            offset,
        };
        let rays = <Simd as Runs<8>>::run(renderer.tracer.simd(), rays);
        match detail {
            BlockDetail::Equal(detail) => rays.on_rung(detail.rung),
            BlockDetail::Own(own) => rays.on_rungs(&own.rungs),
            BlockDetail::Outside => rays.on_rungs(&[[NOT_TRACED; 8]; 8]),
        }
    }
}

/// The rays of a block.
struct RaysOf<'r, S> {
    block: &'r Block,
    sight: &'r S,
    offset: (f32, f32),
}

impl<S: OnePoint> Kernel<8> for RaysOf<'_, S> {
    type Output = TileRays;

    #[inline(always)]
    fn run<L: Lanes<8>>(self, l: L) -> TileRays {
        let (dx, dy) = self.offset;
        let columns = self.sight.columns_at(l, self.block.x, dx);
        let mut rays = TileRays::without_directions(self.sight.eye());
        // Not a closure's body, which would leave the vectors' instruction set.
        for row in 0..8 {
            let y = self.block.y + row as u32;
            let [x, y, z] = self.sight.towards_row(l, &columns, y, dy);
            rays.set_row(row, &[l.store(x), l.store(y), l.store(z)]);
        }
        rays
    }
}

/// How far samples may be from their pixel's centre; a single one is there.
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
