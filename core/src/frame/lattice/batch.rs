//! Samples that are traced together.

use super::SquareRenderer;
use crate::frame::begun::{MISSED, Node, Sum, Work};
use crate::frame::tile::{BLOCK, offset};
use crate::frame::view::{Kind, Screen};
use crate::simd::{Runs, Simd};
use crate::trace::{Hit, NOT_TRACED, RayDetail, Sample, TileRays};

/// Most samples of a batch.
pub(super) const TOGETHER: usize = 64;

pub(super) struct Batch {
    pub(super) count: usize,
    /// Column and row among a square's finest.
    pub(super) nodes: [(u8, u8); TOGETHER],
    /// Column and row of the pixel in the view.
    places: [(u32, u32); TOGETHER],
    details: [RayDetail; TOGETHER],
    pub(super) seen: [Node; TOGETHER],
}

impl Batch {
    pub(super) const NONE: Self = Self {
        count: 0,
        nodes: [(0, 0); TOGETHER],
        places: [(0, 0); TOGETHER],
        details: [RayDetail {
            depth: 0,
            rung: 0,
            wavelengths: 0,
        }; TOGETHER],
        seen: [Node::SKIPPED; TOGETHER],
    };

    pub(super) fn push(&mut self, node: (u8, u8), place: (u32, u32), detail: RayDetail) {
        let at = self.count % TOGETHER;
        self.nodes[at] = node;
        self.places[at] = place;
        self.details[at] = detail;
        self.seen[at] = Node::SKIPPED;
        self.count = at + 1;
    }
}

impl<const W: usize> SquareRenderer<'_, '_, W>
where
    Simd: Runs<W>,
{
    /// Traces all samples. False where the budget ends before.
    pub(super) fn trace(&self, batch: &mut Batch, work: &mut Work<'_>) -> bool {
        match (self.view.kind(), self.renderer.together) {
            _ if batch.count == 0 => true,
            _ if self.ends(work) => false,
            (Kind::Screen(screen), Some(_)) => self.trace_together(batch, screen, work),
            _ => self.trace_singly(batch, work),
        }
    }

    fn trace_singly(&self, batch: &mut Batch, work: &mut Work<'_>) -> bool {
        let samples = self.renderer.settings.samples;
        for at in 0..batch.count.min(TOGETHER) {
            let mut sum = Sum::NONE;
            for sample in 0..samples {
                if self.ends(work) {
                    return false;
                }
                let Some(seen) = self.see(batch.places[at], batch.details[at], sample, work) else {
                    continue;
                };
                if sample == 0 {
                    batch.seen[at].class = seen.class;
                }
                sum.add(seen.pixel, work.workspace);
            }
            batch.seen[at].pixel = sum.mean(samples);
        }
        !work.budget.is_exhausted()
    }

    /// Traces its rays together.
    // Not inlined: keeps its stack frame out of the callers'.
    #[inline(never)]
    fn trace_together(&self, batch: &mut Batch, screen: &Screen, work: &mut Work<'_>) -> bool {
        let tracer = &self.renderer.tracer;
        let samples = self.renderer.settings.samples;
        let count = batch.count.min(TOGETHER);
        let mut rungs = [[NOT_TRACED; BLOCK as usize]; BLOCK as usize];
        let details = batch.details.iter().take(count);
        for (rung, detail) in rungs.as_flattened_mut().iter_mut().zip(details) {
            *rung = detail.rung;
        }
        let mut sums = [Sum::NONE; TOGETHER];
        for sample in 0..samples {
            if self.ends(work) {
                return false;
            }
            let (dx, dy) = offset(sample, samples);
            let rays = TileRays::new(screen.eye, |column, row| {
                // Unused places repeat the first ray.
                let at = BLOCK as usize * row + column;
                let (x, y) = batch.places[if at < count { at } else { 0 }];
                screen.direction(x as f32 + dx, y as f32 + dy)
            });
            let rays = rays.on_rungs(&rungs);
            let hits = tracer.nearest_of_tile(&rays, work.budget, work.workspace);
            if work.budget.is_exhausted() {
                return false;
            }
            for (at, sum) in sums.iter_mut().enumerate().take(count) {
                if at > 0 && self.ends(work) {
                    return false;
                }
                let (column, row) = (at % BLOCK as usize, at / BLOCK as usize);
                let hit = hits.at(column, row);
                let Some(ray) = rays.at(column, row) else {
                    continue;
                };
                if sample == 0 {
                    batch.seen[at].class = class_of(hit.as_ref());
                }
                let ((x, y), detail) = (batch.places[at], batch.details[at]);
                let of = Sample::new(x, y, sample, samples);
                let (budget, workspace) = (&mut *work.budget, &mut *work.workspace);
                let seen = tracer.radiance_from(&ray, hit, detail, of, budget, workspace);
                sum.add(seen, workspace);
            }
        }
        for (seen, sum) in batch.seen.iter_mut().zip(sums).take(count) {
            seen.pixel = sum.mean(samples);
        }
        !work.budget.is_exhausted()
    }

    /// Returns what one sample of a pixel sees; `None` outside a dome master's rim.
    pub(super) fn see(
        &self,
        (x, y): (u32, u32),
        detail: RayDetail,
        sample: u16,
        work: &mut Work<'_>,
    ) -> Option<Node> {
        let (budget, workspace) = (&mut *work.budget, &mut *work.workspace);
        let tracer = &self.renderer.tracer;
        let samples = self.renderer.settings.samples;
        let (dx, dy) = offset(sample, samples);
        let ray = self.view.ray(x as f32 + dx, y as f32 + dy)?;
        let searcher = &tracer.searcher;
        let hit = searcher.nearest_on(detail.rung, &ray, budget, workspace);
        let of = Sample::new(x, y, sample, samples);
        Some(Node {
            class: class_of(hit.as_ref()),
            pixel: tracer.radiance_from(&ray, hit, detail, of, budget, workspace),
        })
    }
}

fn class_of(hit: Option<&Hit>) -> u32 {
    hit.map_or(MISSED, |hit| hit.instance)
}
