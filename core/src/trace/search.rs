//! What rays meet in a scene.

use super::budget::Budget;
use super::dispersion::Spectrum;
use super::hit::{Any, Goal, Hit, Nearest};
use super::row::{RowHits, RowRays, RowSearch};
use super::stack::Work;
use super::tile::{ALL_INSTANCES, MOST_NODES, MayHit, TileHits, TileRays, TileSearch};
use super::workspace::{RayDetail, Workspace};
use super::world::{Search, SearchInstance};
use crate::scene::format::effect;
use crate::scene::{EffectSet, Scene};
use crate::shape::Ray;
use crate::simd::{Runs, Simd};
use glam::Vec3;

/// A scene, how it is traced, and the searches for what rays meet in it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Searcher<'a, const W: usize> {
    pub(super) scene: Scene<'a, W>,
    pub(super) simd: Simd,
    pub(super) detail: RayDetail,
    pub(super) spectrum: Spectrum<'a>,
    pub(super) effects: EffectSet,
}

impl<const W: usize> Searcher<'_, W>
where
    Simd: Runs<W>,
{
    /// Finds the nearest hit through the meshes of a rung, as far as the budget goes.
    pub(crate) fn nearest_on(
        &self,
        rung: u8,
        ray: &Ray,
        budget: &mut Budget,
        workspace: &mut Workspace,
    ) -> Option<Hit> {
        self.nearest_within(rung, ray, f32::INFINITY, budget, workspace)
    }

    /// Does what [`nearest_on`](Self::nearest_on) does, for hits up to `limit` directions from the
    /// start.
    // Not inlined: compiled once for all sets of effects.
    #[inline(never)]
    pub(super) fn next_within(
        &self,
        rung: u8,
        ray: &Ray,
        limit: f32,
        budget: &mut Budget,
        workspace: &mut Workspace,
    ) -> Option<Hit> {
        self.nearest_within(rung, ray, limit, budget, workspace)
    }

    #[inline(always)]
    fn nearest_within(
        &self,
        rung: u8,
        ray: &Ray,
        limit: f32,
        budget: &mut Budget,
        workspace: &mut Workspace,
    ) -> Option<Hit> {
        let hit = if Simd::HAS_VECTORS {
            self.search(Nearest, rung, ray, limit, budget, workspace)
        } else {
            self.search_either(false, rung, ray, limit, budget, workspace)
        };
        (hit.instance != u32::MAX).then_some(hit)
    }

    /// Finds the hit of a goal. For any hit only its existence is valid.
    #[inline(always)]
    fn search<S: Goal>(
        &self,
        goal: S,
        rung: u8,
        ray: &Ray,
        limit: f32,
        budget: &mut Budget,
        workspace: &mut Workspace,
    ) -> Hit {
        let search = Search::<W, S> {
            goal,
            scene: &self.scene,
            rung,
            limit,
            stack: &mut workspace.stack,
            most: budget.most(),
        };
        let (hit, work) = self.simd.run_along(ray, search);
        workspace.account(work, budget);
        hit
    }

    /// As `search`, with one compiled walk for both goals, for small programs.
    #[inline(never)]
    fn search_either(
        &self,
        is_any: bool,
        rung: u8,
        ray: &Ray,
        limit: f32,
        budget: &mut Budget,
        workspace: &mut Workspace,
    ) -> Hit {
        self.search(is_any, rung, ray, limit, budget, workspace)
    }

    // Not inlined: its stack frame must not be live during deeper searches.
    #[inline(never)]
    pub(super) fn may_hit(
        &self,
        origin: Vec3,
        corners: &[Vec3; 4],
        budget: &mut Budget,
        workspace: &mut Workspace,
    ) -> bool {
        let (may_hit, steps) = self.simd.run(MayHit {
            scene: &self.scene,
            origin,
            corners,
            most: budget.most().min(MOST_NODES),
        });
        workspace.account(Work { steps, deepest: 0 }, budget);
        may_hit
    }

    pub(super) fn nearest_of_tile(
        &self,
        rays: &TileRays,
        budget: &mut Budget,
        workspace: &mut Workspace,
    ) -> TileHits {
        let mut hits = TileHits::none_of(rays);
        let search = TileSearch::<W> {
            scene: &self.scene,
            rays,
            hits: &mut hits,
            stack: &mut workspace.stack,
            most: budget.most(),
        };
        let work = <Simd as Runs<8>>::run(self.simd, search);
        let all = [(ALL_INSTANCES, u8::MAX)];
        let deferred = hits.deferred.clone();
        let left = match work {
            Some(work) => {
                workspace.account(work, budget);
                deferred.as_slice()
            }
            None => all.as_slice(),
        };
        for &(instance, groups) in left {
            if budget.is_exhausted() {
                break;
            }
            for (group, lane) in (0..8).flat_map(|group| (0..8).map(move |lane| (group, lane))) {
                if groups >> group & 1 == 0 {
                    continue;
                }
                let (Some(ray), Some(rung)) = (rays.ray(group, lane), rays.rung(group, lane))
                else {
                    continue;
                };
                let hit = if instance == ALL_INSTANCES {
                    self.nearest_on(rung, &ray, budget, workspace)
                        .unwrap_or(Hit::NONE)
                } else {
                    let best = hits.get(group, lane);
                    self.nearer_in(instance, rung, &ray, best, budget, workspace)
                };
                hits.set(group, lane, hit);
            }
        }
        hits
    }

    /// Returns the nearest hit of a ray in an instance on a rung, or `best` if that is nearer.
    fn nearer_in(
        &self,
        instance: u32,
        rung: u8,
        ray: &Ray,
        best: Hit,
        budget: &mut Budget,
        workspace: &mut Workspace,
    ) -> Hit {
        let search = SearchInstance::<W> {
            scene: &self.scene,
            rung,
            instance,
            best,
            stack: &mut workspace.stack,
            most: budget.most(),
        };
        let (hit, work) = self.simd.run_along(ray, search);
        workspace.account(work, budget);
        hit
    }

    /// Returns the nearest hits of eight rays, each on its own rung; `None` if they cannot go
    /// together.
    pub(crate) fn nearest_of_row<const EFFECTS: u32>(
        &self,
        rays: &RowRays<'_>,
        rung: impl Fn(usize) -> Option<(Ray, u8)>,
        budget: &mut Budget,
        workspace: &mut Workspace,
    ) -> Option<RowHits> {
        // The tree's node and its spheroids.
        if budget.most() <= W as u64 {
            return None;
        }
        let mut found = self.search_row(rays)?;
        if EFFECTS & effect::GRATICULE != 0 && self.effects.contains(EffectSet::GRATICULE) {
            self.see_lines(rays, &mut found);
        }
        let steps = found.steps;
        workspace.account(Work { steps, deepest: 0 }, budget);
        for &(instance, entering) in &found.meshes {
            for (lane, best) in found.hits.iter_mut().enumerate() {
                if entering >> lane & 1 == 0 {
                    continue;
                }
                let Some((ray, rung)) = rung(lane) else {
                    continue;
                };
                *best = self.nearer_in(instance, rung, &ray, *best, budget, workspace);
            }
        }
        Some(found)
    }

    // Not inlined: compiled once for all sets of effects.
    #[inline(never)]
    fn search_row(&self, rays: &RowRays<'_>) -> Option<RowHits> {
        let scene = &self.scene;
        <Simd as Runs<8>>::run(self.simd, RowSearch::<W> { scene, rays })
    }

    /// Sets which rays go between the lines of a graticule.
    // Not inlined: compiled once for all sets of effects.
    #[inline(never)]
    fn see_lines(&self, rays: &RowRays<'_>, found: &mut RowHits) {
        if let Some(on_lines) = found.on_lines(&self.scene, rays) {
            found.between = <Simd as Runs<8>>::run(self.simd, on_lines);
        }
    }

    /// Returns whether anything on a rung blocks light up to `limit` directions from the start.
    pub(crate) fn is_occluded_on(
        &self,
        rung: u8,
        ray: &Ray,
        limit: f32,
        budget: &mut Budget,
        workspace: &mut Workspace,
    ) -> bool {
        let hit = if Simd::HAS_VECTORS {
            self.search(Any, rung, ray, limit, budget, workspace)
        } else {
            self.search_either(true, rung, ray, limit, budget, workspace)
        };
        workspace.statistics.shadow += 1;
        hit.instance != u32::MAX
    }
}
