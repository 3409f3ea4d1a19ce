//! Rays through a scene: what they meet and what comes back along them.

use super::background;
use super::budget::{Budget, Statistics};
use super::dispersion::{Balance, Spectrum, SpectrumError};
use super::hit::{Any, AsTold, Hit, Nearest, Sought};
use super::ledger::Ledger;
use super::row::{Between, RowHits, RowRays, RowSearch};
use super::sample::Sample;
use super::shading::{Pending, Shade, shade_and_record, shade_tree};
use super::stack::{TraversalStack, Work};
use super::tile::{ALL_INSTANCES, MOST_NODES, MayHit, TileHits, TileRays, TileSearch};
use super::world::{Search, SearchInstance};
use crate::scene::format::effect;
use crate::scene::{EffectSet, Scene};
use crate::shape::Ray;
use crate::simd::{Runs, Simd};
use glam::Vec3;
use heapless::Vec;
use zerocopy::{FromBytes, Immutable, IntoBytes, KnownLayout};

/// Most bounces of a ray tree.
pub const MAX_DEPTH: u8 = 16;

/// Rays that add less than this to every channel of a pixel are not traced: a
/// quarter of a step of an eight-bit picture. At the border of a clear body the
/// other ray has their share.
pub const LEAST_WEIGHT: f32 = 1.0 / 1024.0;

/// Each ray leaves at most two behind and is itself done by then.
const MOST_PENDING: usize = MAX_DEPTH as usize + 2;

/// Linear light and coverage, premultiplied.
#[derive(Debug, Clone, Copy, PartialEq, Default, FromBytes, IntoBytes, Immutable, KnownLayout)]
#[repr(C)]
pub struct Pixel {
    /// Red.
    pub red: f32,
    /// Green.
    pub green: f32,
    /// Blue.
    pub blue: f32,
    /// 0 where only a transparent background is seen, 1 where it is not.
    pub alpha: f32,
}

/// The memory that tracing needs: the caller's, 2 KiB, used for one ray
/// after another.
#[derive(Debug, Clone, Default)]
pub struct Workspace {
    pub(crate) stack: TraversalStack,
    pub(super) pending: Vec<Pending, MOST_PENDING>,
    /// Of the last sample, until its pixel takes it.
    pub(crate) balance: Balance,
    /// What has been done with this workspace; the caller's to clear.
    pub statistics: Statistics,
}

impl Workspace {
    /// With nothing done yet.
    pub const fn new() -> Self {
        Self {
            stack: TraversalStack::EMPTY,
            pending: Vec::new(),
            balance: Balance::NONE,
            statistics: Statistics {
                primary: 0,
                reflected: 0,
                refracted: 0,
                shadow: 0,
                steps: 0,
                deepest_stack: 0,
            },
        }
    }

    pub(crate) fn account(&mut self, work: Work, budget: &mut Budget) {
        self.statistics.steps += work.steps;
        self.statistics.deepest_stack = self.statistics.deepest_stack.max(work.deepest);
        budget.spend(work.steps);
    }
}

/// How much is spent on a primary ray and on all that it leaves behind.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RayDetail {
    /// Most reflections and refractions after one another.
    pub depth: u8,
    /// The rung of each mesh's ladder of polygon levels, the finest being 0.
    /// A mesh that has no such rung is seen as it is.
    pub rung: u8,
    /// How many wavelengths dispersive media tell apart; 1 for none.
    pub wavelengths: u8,
}

/// Traces the rays of a scene.
///
/// Shading is compiled for a set of effects, and a tracer holds a pointer to
/// the shading that it uses: a program that makes tracers with
/// [`for_effects`](Self::for_effects) only has no code of other effects. Where
/// rays go through the scene is the same code for all sets.
#[derive(Debug, Clone, Copy)]
pub struct Tracer<'a, const W: usize = 8> {
    scene: Scene<'a, W>,
    simd: Simd,
    detail: RayDetail,
    spectrum: Spectrum<'a>,
    effects: EffectSet,
    shade: Shade<W>,
}

impl<'a, const W: usize> Tracer<'a, W>
where
    Simd: Runs<W>,
{
    /// Follows at most `depth` reflections and refractions after one another,
    /// never more than [`MAX_DEPTH`], through the finest meshes, with every
    /// effect there is.
    pub fn new(scene: Scene<'a, W>, simd: Simd, depth: u8) -> Self {
        Self::for_effects::<{ EffectSet::ALL.bits() }>(scene, simd, depth)
    }

    /// As [`new`](Self::new), with the shading compiled for the effects of some
    /// [bits](EffectSet::bits). Where the scene asks for no others the picture
    /// is the same, bit for bit; an effect of the scene's that is not among
    /// them is left out as its constant in [`EffectSet`] says.
    pub fn for_effects<const EFFECTS: u32>(scene: Scene<'a, W>, simd: Simd, depth: u8) -> Self {
        Self {
            scene,
            simd,
            detail: RayDetail {
                depth: depth.min(MAX_DEPTH),
                rung: 0,
                wavelengths: 1,
            },
            spectrum: Spectrum::Rgb,
            effects: EffectSet::from_bits(EFFECTS),
            shade: shade_tree::<W, EFFECTS>,
        }
    }

    /// The same tracer without some effects.
    #[must_use]
    pub const fn without(mut self, effects: EffectSet) -> Self {
        self.effects = self.effects.without(effects);
        self
    }

    /// The same tracer with wavelengths, where the scene asks for dispersion and
    /// the tracer carries it out. Without, all rays are [`Spectrum::Rgb`].
    ///
    /// # Errors
    /// A wavelength outside the range of a medium of the scene.
    pub fn with_spectrum(mut self, spectrum: Spectrum<'a>) -> Result<Self, SpectrumError> {
        let carried_out = self.effects.intersection(self.scene.effects());
        if carried_out.contains(EffectSet::DISPERSION) {
            spectrum.check(self.scene.media())?;
            self.detail.wavelengths = spectrum.count();
            self.spectrum = spectrum;
        }
        Ok(self)
    }

    /// The wavelengths of its rays.
    pub(super) const fn spectrum(&self) -> &Spectrum<'a> {
        &self.spectrum
    }

    /// The effects that it carries out where the scene asks for them.
    pub const fn effects(&self) -> EffectSet {
        self.effects
    }

    /// The same tracer for rays through the meshes of a rung.
    #[must_use]
    pub const fn at_rung(mut self, rung: u8) -> Self {
        self.detail.rung = rung;
        self
    }

    /// The instruction set it uses.
    pub const fn simd(&self) -> Simd {
        self.simd
    }

    /// What its own rays are traced with.
    pub const fn detail(&self) -> RayDetail {
        self.detail
    }

    /// The scene traced.
    pub const fn scene(&self) -> &Scene<'a, W> {
        &self.scene
    }

    /// The nearest hit; of those that it came to, where it
    /// [exhausts](Budget::is_exhausted) the budget.
    pub fn nearest(
        &self,
        ray: &Ray,
        budget: &mut Budget,
        workspace: &mut Workspace,
    ) -> Option<Hit> {
        self.nearest_on(self.detail.rung, ray, budget, workspace)
    }

    /// As [`nearest`](Self::nearest), through the meshes of a rung.
    pub(crate) fn nearest_on(
        &self,
        rung: u8,
        ray: &Ray,
        budget: &mut Budget,
        workspace: &mut Workspace,
    ) -> Option<Hit> {
        let limit = f32::INFINITY;
        let hit = if Simd::HAS_VECTORS {
            self.search(Nearest, rung, (ray, limit), budget, workspace)
        } else {
            self.search_as_told(false, rung, (ray, limit), budget, workspace)
        };
        (hit.instance != u32::MAX).then_some(hit)
    }

    /// The hit that is sought; of any, only whether there is one.
    #[inline(always)]
    fn search<S: Sought>(
        &self,
        sought: S,
        rung: u8,
        within: (&Ray, f32),
        budget: &mut Budget,
        workspace: &mut Workspace,
    ) -> Hit {
        if may_count(budget) {
            self.search_to::<false, S>(sought, rung, within, budget, workspace)
        } else {
            self.search_to::<true, S>(sought, rung, within, budget, workspace)
        }
    }

    #[inline(always)]
    fn search_to<const ENDS: bool, S: Sought>(
        &self,
        sought: S,
        rung: u8,
        (ray, limit): (&Ray, f32),
        budget: &mut Budget,
        workspace: &mut Workspace,
    ) -> Hit {
        let search = Search::<W, ENDS, S> {
            sought,
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

    /// One walk for nearest and for any hits, where a program's size counts for
    /// more than the test of which it is.
    #[inline(never)]
    fn search_as_told(
        &self,
        is_any: bool,
        rung: u8,
        within: (&Ray, f32),
        budget: &mut Budget,
        workspace: &mut Workspace,
    ) -> Hit {
        self.search(AsTold { is_any }, rung, within, budget, workspace)
    }

    /// Whether any ray may meet anything that starts at `origin` and whose
    /// direction lies between four `corners`, component by component: the rays
    /// of a part of a flat screen, between those of its corners. False only where
    /// none does, whatever their rungs; true, too, where the corners' components
    /// differ in sign, are no numbers, or a budget is exhausted. At most 16 steps.
    // Nor a part of its caller: what it needs is not in the way of those that go deeper.
    #[inline(never)]
    pub fn may_hit(
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

    /// The nearest hits of the rays of a tile, through the meshes of their own
    /// rungs: those that [`nearest`](Self::nearest) finds, and faster.
    pub fn nearest_of_tile(
        &self,
        rays: &TileRays,
        budget: &mut Budget,
        workspace: &mut Workspace,
    ) -> TileHits {
        let mut hits = TileHits::none_of(rays);
        let work = if may_count(budget) {
            self.tile_to::<false>(rays, &mut hits, budget, workspace)
        } else {
            self.tile_to::<true>(rays, &mut hits, budget, workspace)
        };
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
                    self.nearer_in((instance, rung), &ray, best, budget, workspace)
                };
                hits.set(group, lane, hit);
            }
        }
        hits
    }

    fn tile_to<const ENDS: bool>(
        &self,
        rays: &TileRays,
        hits: &mut TileHits,
        budget: &Budget,
        workspace: &mut Workspace,
    ) -> Option<Work> {
        let search = TileSearch::<W, ENDS> {
            scene: &self.scene,
            rays,
            hits,
            stack: &mut workspace.stack,
            most: budget.most(),
        };
        <Simd as Runs<8>>::run(self.simd, search)
    }

    /// The nearest hit of a ray in an instance, through the meshes of a rung, or `best`
    /// where that is nearer.
    fn nearer_in(
        &self,
        of: (u32, u8),
        ray: &Ray,
        best: Hit,
        budget: &mut Budget,
        workspace: &mut Workspace,
    ) -> Hit {
        if may_count(budget) {
            self.nearer_to::<false>(of, ray, best, budget, workspace)
        } else {
            self.nearer_to::<true>(of, ray, best, budget, workspace)
        }
    }

    #[inline(always)]
    fn nearer_to<const ENDS: bool>(
        &self,
        (instance, rung): (u32, u8),
        ray: &Ray,
        best: Hit,
        budget: &mut Budget,
        workspace: &mut Workspace,
    ) -> Hit {
        let search = SearchInstance::<W, ENDS> {
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

    /// The nearest hits of eight rays that start apart, each on its own rung:
    /// those that [`nearest`](Self::nearest) finds. `None`, at no price, where
    /// they cannot go together. Its code has that of some effects.
    pub(crate) fn nearest_of_row<const EFFECTS: u32>(
        &self,
        rays: &RowRays<'_>,
        rung: impl Fn(usize) -> Option<(Ray, u8)>,
        budget: &mut Budget,
        workspace: &mut Workspace,
    ) -> Option<RowHits> {
        // The tree's node, and spheroids in it.
        if budget.most() <= W as u64 {
            return None;
        }
        let scene = &self.scene;
        let mut found = <Simd as Runs<8>>::run(self.simd, RowSearch::<W> { scene, rays })?;
        if EFFECTS & effect::GRATICULE != 0
            && self.effects.contains(EffectSet::GRATICULE)
            && let Some(on) = found.on_lines(scene)
        {
            let between = Between { rays, on: &on };
            found.between = <Simd as Runs<8>>::run(self.simd, between);
        }
        let work = Work {
            steps: found.steps,
            deepest: 0,
        };
        workspace.account(work, budget);
        for &(instance, entering) in &found.meshes {
            for (lane, best) in found.hits.iter_mut().enumerate() {
                if entering >> lane & 1 == 0 {
                    continue;
                }
                let Some((ray, rung)) = rung(lane) else {
                    continue;
                };
                *best = self.nearer_in((instance, rung), &ray, *best, budget, workspace);
            }
        }
        Some(found)
    }

    /// Whether anything blocks light between the ray's start and `limit`, in
    /// units of its direction.
    pub fn is_occluded(
        &self,
        ray: &Ray,
        limit: f32,
        budget: &mut Budget,
        workspace: &mut Workspace,
    ) -> bool {
        self.is_occluded_on(self.detail.rung, ray, limit, budget, workspace)
    }

    pub(super) fn is_occluded_on(
        &self,
        rung: u8,
        ray: &Ray,
        limit: f32,
        budget: &mut Budget,
        workspace: &mut Workspace,
    ) -> bool {
        let hit = if Simd::HAS_VECTORS {
            self.search(Any, rung, (ray, limit), budget, workspace)
        } else {
            self.search_as_told(true, rung, (ray, limit), budget, workspace)
        };
        workspace.statistics.shadow += 1;
        hit.instance != u32::MAX
    }

    /// The light that comes back along a ray from the eye.
    pub fn radiance(&self, ray: &Ray, budget: &mut Budget, workspace: &mut Workspace) -> Pixel {
        let hit = self.nearest(ray, budget, workspace);
        let pixel = self.radiance_from(ray, hit, self.detail, Sample::ALONE, budget, workspace);
        // It is white alone: no pixel takes this.
        workspace.balance = Balance::NONE;
        pixel
    }

    /// As [`radiance`](Self::radiance), with a detail of its own, as a sample of
    /// a pixel.
    pub(crate) fn radiance_with(
        &self,
        ray: &Ray,
        detail: RayDetail,
        sample: Sample,
        budget: &mut Budget,
        workspace: &mut Workspace,
    ) -> Pixel {
        let hit = self.nearest_on(detail.rung, ray, budget, workspace);
        self.radiance_from(ray, hit, detail, sample, budget, workspace)
    }

    /// As [`radiance_with`](Self::radiance_with), the primary ray's hit being
    /// known.
    pub(crate) fn radiance_from(
        &self,
        ray: &Ray,
        hit: Option<Hit>,
        detail: RayDetail,
        sample: Sample,
        budget: &mut Budget,
        workspace: &mut Workspace,
    ) -> Pixel {
        workspace.statistics.primary += 1;
        match hit {
            Some(hit) => (self.shade)(self, ray, hit, (detail, sample), budget, workspace),
            None => self.missed(ray.direction()),
        }
    }

    /// As [`radiance_with`](Self::radiance_with), entering into a ledger what
    /// each effect does. Slower.
    pub(crate) fn radiance_and_record(
        &self,
        ray: &Ray,
        detail: RayDetail,
        sample: Sample,
        workspace: &mut Workspace,
        ledger: &mut Ledger,
    ) -> Pixel {
        let budget = &mut { Budget::UNLIMITED };
        let hit = self.nearest_on(detail.rung, ray, budget, workspace);
        workspace.statistics.primary += 1;
        let of = (detail, sample);
        match hit {
            Some(hit) => shade_and_record(self, (ray, hit), of, workspace, ledger),
            None => self.missed(ray.direction()),
        }
    }

    /// What is seen along a direction from the eye past all objects.
    pub(crate) fn missed(&self, direction: Vec3) -> Pixel {
        let background = self.scene.background();
        let light = background::colour(background, direction) * background.alpha;
        Pixel {
            red: light.x,
            green: light.y,
            blue: light.z,
            // As it is taken off a tree's.
            alpha: 1.0 - (1.0 - background.alpha),
        }
    }
}

/// Whether a search's steps are just counted: where they have no end and a program's speed
/// counts for more than its size.
const fn may_count(budget: &Budget) -> bool {
    Simd::HAS_VECTORS && budget.is_endless()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_workspace_is_as_small_as_documented() {
        let size = size_of::<Workspace>();
        assert!(size <= 2 * 1024 + 64, "{size} bytes");
    }
}
