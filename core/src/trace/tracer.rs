//! Rays through a scene: their nearest hits, and the light that comes back along them.

use super::background;
use super::budget::Budget;
use super::cone::Width;
use super::dispersion::{Balance, Spectrum, SpectrumError};
use super::environment;
use super::hit::Hit;
use super::ledger::{Ledger, Record as _};
use super::sample::Sample;
use super::search::Searcher;
use super::shading::{PrimaryRay, Shade, shade_and_record, shade_tree};
use super::tile::{TileHits, TileRays};
use super::workspace::{MAX_DEPTH, Pixel, RayDetail, Workspace};
use crate::numeric::sqrt;
use crate::scene::{EffectSet, Scene};
use crate::shape::Ray;
use crate::simd::{Runs, Simd};
use glam::Vec3;

const ENVIRONMENT: u32 = EffectSet::ENVIRONMENT.bits();

/// Traces the rays of a scene. It holds a pointer to shading that is compiled for a set of
/// effects: a program that makes tracers with [`for_effects`](Self::for_effects) only has no
/// code of other effects.
#[derive(Debug, Clone, Copy)]
pub struct Tracer<'a, const W: usize = 8> {
    pub(crate) searcher: Searcher<'a, W>,
    shade: Shade<W>,
    /// Returns what a ray of a width, in radians, sees of an image as the background.
    environment: Option<SeeEnvironment<W>>,
}

type SeeEnvironment<const W: usize> = fn(&Scene<'_, W>, Vec3, f32) -> Vec3;

impl<'a, const W: usize> Tracer<'a, W>
where
    Simd: Runs<W>,
{
    /// Returns a tracer that follows at most `depth` reflections and refractions in a row,
    /// never more than [`MAX_DEPTH`], through the finest meshes, with every effect.
    pub fn new(scene: Scene<'a, W>, simd: Simd, depth: u8) -> Self
    where
        Simd: crate::Runs<W>,
    {
        <Simd as crate::Runs<W>>::tracer(scene, simd, depth)
    }

    /// Returns the same tracer for the same scene at other [poses](crate::scene::Poses).
    #[must_use]
    pub const fn posed<'b>(self, scene: Scene<'b, W>) -> Tracer<'b, W>
    where
        'a: 'b,
    {
        let mut posed: Tracer<'b, W> = self;
        posed.searcher.scene = scene;
        posed
    }

    /// Returns a tracer like [`new`](Self::new)'s, with the shading compiled for the effects in
    /// [bits](EffectSet::bits): the same picture, bit for bit, if the scene asks for no others. For
    /// a scene without an effect, see the effect's constant in [`EffectSet`].
    pub fn for_effects<const EFFECTS: u32>(scene: Scene<'a, W>, simd: Simd, depth: u8) -> Self {
        Self {
            searcher: Searcher {
                scene,
                simd,
                detail: RayDetail {
                    depth: depth.min(MAX_DEPTH),
                    rung: 0,
                    wavelengths: 1,
                    spread: Width::ZERO,
                },
                spectrum: Spectrum::Rgb,
                effects: EffectSet::from_bits_truncate(EFFECTS),
            },
            shade: shade_tree::<W, EFFECTS>,
            // A pointer: sets of effects without it do not link the function.
            environment: if EFFECTS & ENVIRONMENT == 0 {
                None
            } else {
                Some(environment::colour)
            },
        }
    }

    /// Returns the same tracer without some effects.
    #[must_use]
    pub const fn without(mut self, effects: EffectSet) -> Self {
        self.searcher.effects = self.searcher.effects.difference(effects);
        self
    }

    /// Returns the same tracer with a spectrum, if the scene asks for dispersion and
    /// the tracer has code for it; otherwise all rays are [`Spectrum::Rgb`].
    ///
    /// # Errors
    /// A wavelength outside the range of a medium of the scene.
    pub fn with_spectrum(mut self, spectrum: Spectrum<'a>) -> Result<Self, SpectrumError> {
        let searcher = &mut self.searcher;
        let carried_out = searcher.effects.intersection(searcher.scene.effects());
        if carried_out.contains(EffectSet::DISPERSION) {
            spectrum.check(searcher.scene.media())?;
            searcher.detail.wavelengths = spectrum.count();
            searcher.spectrum = spectrum;
        }
        Ok(self)
    }

    /// Returns the effects that it carries out if the scene asks for them.
    pub const fn effects(&self) -> EffectSet {
        self.searcher.effects
    }

    /// Returns the same tracer for rays through the meshes of a rung.
    #[must_use]
    pub const fn at_rung(mut self, rung: u8) -> Self {
        self.searcher.detail.rung = rung;
        self
    }

    /// Returns the instruction set it uses.
    pub const fn simd(&self) -> Simd {
        self.searcher.simd
    }

    /// Returns the detail of its own rays.
    pub const fn detail(&self) -> RayDetail {
        self.searcher.detail
    }

    /// Returns the scene.
    pub const fn scene(&self) -> &Scene<'a, W> {
        &self.searcher.scene
    }

    /// Finds the nearest hit. A search that [exhausts](Budget::is_exhausted) the budget
    /// returns the nearest of the hits found so far.
    pub fn nearest(&self, ray: &Ray, budget: &mut Budget, workspace: &mut Workspace) -> Option<Hit>
    where
        Simd: crate::Runs<W>,
    {
        <Simd as crate::Runs<W>>::nearest(self, ray, budget, workspace)
    }

    /// Returns whether a ray from `origin` may meet anything, if its direction is, component by
    /// component, between four `corners`. False only if none does on any rung; true, too, if
    /// corners differ in sign or are NaN, or the budget ends. Takes at most 16 steps.
    #[inline(always)]
    pub fn may_hit(
        &self,
        origin: Vec3,
        corners: &[Vec3; 4],
        budget: &mut Budget,
        workspace: &mut Workspace,
    ) -> bool {
        self.searcher.may_hit(origin, corners, budget, workspace)
    }

    /// Finds the nearest hits of the rays of a tile, through the meshes of their own
    /// rungs: the same as by [`nearest`](Self::nearest), but faster.
    #[inline(always)]
    pub fn nearest_of_tile(
        &self,
        rays: &TileRays,
        budget: &mut Budget,
        workspace: &mut Workspace,
    ) -> TileHits {
        self.searcher.nearest_of_tile(rays, budget, workspace)
    }

    /// Returns whether anything blocks light between the ray's start and `limit`, in
    /// units of its direction.
    pub fn is_occluded(
        &self,
        ray: &Ray,
        limit: f32,
        budget: &mut Budget,
        workspace: &mut Workspace,
    ) -> bool
    where
        Simd: crate::Runs<W>,
    {
        <Simd as crate::Runs<W>>::is_occluded(self, ray, limit, budget, workspace)
    }

    /// Returns the light that comes back along a ray from the eye.
    pub fn radiance(&self, ray: &Ray, budget: &mut Budget, workspace: &mut Workspace) -> Pixel {
        let detail = self.searcher.detail;
        let pixel = self.radiance_with(ray, detail, Sample::ALONE, budget, workspace);
        // A single ray has all wavelengths: its balance goes to no pixel.
        workspace.balance = Balance::NONE;
        pixel
    }

    /// Returns the light along a ray that is a pixel's `sample`, with a detail of its own.
    pub(crate) fn radiance_with(
        &self,
        ray: &Ray,
        detail: RayDetail,
        sample: Sample,
        budget: &mut Budget,
        workspace: &mut Workspace,
    ) -> Pixel {
        let searcher = &self.searcher;
        let hit = searcher.nearest_on(detail.rung, ray, budget, workspace);
        self.radiance_from(ray, hit, detail, sample, budget, workspace)
    }

    /// Does what [`radiance_with`](Self::radiance_with) does, for a primary ray whose hit is known.
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
            Some(hit) => {
                workspace.statistics.lit += 1;
                let primary = PrimaryRay {
                    ray,
                    hit,
                    detail,
                    sample,
                };
                (self.shade)(&self.searcher, &primary, budget, workspace)
            }
            None => self.missed(ray.direction(), || detail.spread),
        }
    }

    /// Does what [`radiance_with`](Self::radiance_with) does, and records each effect. Slower.
    pub(crate) fn radiance_and_record(
        &self,
        ray: &Ray,
        detail: RayDetail,
        sample: Sample,
        workspace: &mut Workspace,
        ledger: &mut Ledger,
    ) -> Pixel {
        const ALL: u32 = EffectSet::ALL.bits();
        let (searcher, budget) = (&self.searcher, &mut { Budget::UNLIMITED });
        let hit = searcher.nearest_on(detail.rung, ray, budget, workspace);
        workspace.statistics.primary += 1;
        let Some(hit) = hit else {
            ledger
                .touch(self.searcher.effects.bits() & ENVIRONMENT & searcher.scene.header.effects);
            return self.missed(ray.direction(), || detail.spread);
        };
        let primary = PrimaryRay {
            ray,
            hit,
            detail,
            sample,
        };
        shade_and_record::<W, ALL, Ledger>(searcher, &primary, budget, workspace, ledger)
    }

    /// Returns the background along a direction from the eye; `spread` is that of the ray.
    pub(crate) fn missed(&self, direction: Vec3, spread: impl FnOnce() -> Width) -> Pixel {
        let scene = &self.searcher.scene;
        let background = scene.background();
        let asked = self.searcher.effects.bits() & scene.header.effects;
        let light = match self.environment {
            Some(colour) if asked & ENVIRONMENT != 0 => self.in_image(colour, direction, spread),
            _ => background::colour(background, direction),
        };
        let light = light * background.alpha;
        // Rounds alpha as a ray tree does.
        Pixel::new(light, 1.0 - (1.0 - background.alpha))
    }

    // Not inlined: keeps its registers out of scenes whose background is no image.
    #[inline(never)]
    fn in_image(
        &self,
        colour: SeeEnvironment<W>,
        direction: Vec3,
        spread: impl FnOnce() -> Width,
    ) -> Vec3 {
        let length = sqrt(direction.dot(direction));
        colour(&self.searcher.scene, direction, spread().get() / length)
    }
}
