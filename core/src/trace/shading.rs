//! Whitted's ray tree (1980), on an explicit stack.
//!
//! Compiled for a set of effects; effects outside the set have no code.

mod arrival;
mod clear;
mod fan;
mod light;
mod microfacet;

use super::background;
use super::budget::Budget;
use super::cone::Width;
use super::dispersion::Balance;
use super::environment;
use super::hit::Hit;
use super::ledger::Record;
use super::media::{Border, Media};
use super::optics::{Refraction, reflect, refract};
use super::sample::Sample;
use super::search::Searcher;
use super::surface::Surface;
use super::texture::TEXTURES;
use super::workspace::{Pending, Pixel, RayDetail, Workspace};
use crate::numeric::{map3, max, sqrt};
use crate::scene::EffectSet;
use crate::scene::format::{Material, effect};
use crate::shape::Ray;
use crate::simd::{Runs, Simd};
use arrival::{Arrival, Sides, above};
use clear::MOST_LAYERS;
use fan::Fan;
use glam::Vec3;
use light::Incidence;
pub(super) use light::NOT_DULL;

/// Least weight of a ray in some channel of a pixel: a quarter of a step of an eight-bit picture.
/// Lighter rays are not traced; at a clear body's border the other ray gets their share.
pub const LEAST_WEIGHT: f32 = 1.0 / 1024.0;

/// Least cosine at which what a pixel sees of a surface still grows.
const LEAST_COSINE: f32 = 0.05;

/// A primary ray that hits something.
pub(super) struct PrimaryRay<'r> {
    pub(super) ray: &'r Ray,
    pub(super) hit: Hit,
    pub(super) detail: RayDetail,
    pub(super) sample: Sample,
}

/// Traces the ray tree that starts at a primary ray's hit.
pub(super) type Shade<const W: usize> = for<'r, 's> fn(
    &'r Searcher<'s, W>,
    &'r PrimaryRay<'r>,
    &'r mut Budget,
    &'r mut Workspace,
) -> Pixel;

/// Does what [`Tracer::radiance_from`](super::Tracer::radiance_from) does; compiled for `EFFECTS`.
pub(super) fn shade_tree<const W: usize, const EFFECTS: u32>(
    searcher: &Searcher<'_, W>,
    primary: &PrimaryRay<'_>,
    budget: &mut Budget,
    workspace: &mut Workspace,
) -> Pixel
where
    Simd: Runs<W>,
{
    shade_and_record::<W, EFFECTS, ()>(searcher, primary, budget, workspace, &mut ())
}

/// Does what [`shade_tree`] does, and records what each effect does.
#[inline(always)]
pub(super) fn shade_and_record<const W: usize, const EFFECTS: u32, R: Record>(
    searcher: &Searcher<'_, W>,
    primary: &PrimaryRay<'_>,
    budget: &mut Budget,
    workspace: &mut Workspace,
    record: &mut R,
) -> Pixel
where
    Simd: Runs<W>,
{
    let (detail, sample) = (primary.detail, primary.sample);
    let mut tree =
        RayTree::<W, EFFECTS, R>::new(searcher, (detail, sample), budget, workspace, record);
    let first = Pending::primary(primary.ray);
    let met = tree.meet(primary.ray, &primary.hit);
    tree.trace(first, met)
}

/// A surface where a primary ray meets it.
pub(crate) struct Met<'r, 'a> {
    pub(crate) ray: &'r Ray,
    pub(crate) surface: Surface<'a>,
    /// Distance in units of the ray's direction.
    pub(crate) t: f32,
    pub(crate) detail: RayDetail,
    pub(crate) sample: Sample,
}

/// Traces the ray tree that starts where a primary ray meets a surface.
#[inline(always)]
pub(super) fn shade_met<const W: usize, const EFFECTS: u32, R: Record>(
    searcher: &Searcher<'_, W>,
    met: &Met<'_, '_>,
    budget: &mut Budget,
    workspace: &mut Workspace,
    record: &mut R,
) -> Pixel
where
    Simd: Runs<W>,
{
    let by = (met.detail, met.sample);
    let mut tree = RayTree::<W, EFFECTS, R>::new(searcher, by, budget, workspace, record);
    tree.trace(Pending::primary(met.ray), Some((met.surface, met.t)))
}

/// Effects that are recorded whenever a ray meets a surface that has them.
const OF_SURFACES: u32 = effect::GRATICULE
    | effect::EMISSION
    | effect::MICROFACETS
    | effect::VERTEX_COLOURS
    | effect::TEXTURE_LEVELS
    | effect::NORMAL_MAP
    | TEXTURES;

const ENVIRONMENT: u32 = EffectSet::ENVIRONMENT.bits();

/// Returns the number of an effect's bit.
const fn place(bit: u32) -> u8 {
    bit.trailing_zeros() as u8
}

/// What a ray tree is shaded with; compiled for the effects in `EFFECTS`.
#[derive(Clone, Copy)]
struct Shading<'t, 'a, const W: usize, const EFFECTS: u32> {
    searcher: &'t Searcher<'a, W>,
    detail: RayDetail,
    sample: Sample,
    /// Those of the tracer's effects that this code is compiled for.
    effects: u32,
}

impl<const W: usize, const EFFECTS: u32> Shading<'_, '_, W, EFFECTS> {
    /// Chooses the rays that leave a border; a ray too light to trace gives its share to the other.
    fn sides(&self, at: &Arrival<'_>, through: Vec3, back: Vec3) -> Sides {
        let counts = |share: Vec3| (at.weight * share).max_element() >= LEAST_WEIGHT;
        // A ray reflected into the body at the last bounce would end inside it.
        let ends_inside = at.inside && at.bounces >= self.detail.depth && through != Vec3::ZERO;
        let all = Some(through + back).filter(|all| counts(*all));
        let (all_through, all_back) = ((all, None), (None, all));
        let (through, back) = match (counts(through), counts(back)) {
            _ if ends_inside => all_through,
            (true, true) => (Some(through), Some(back)),
            (false, true) => all_back,
            (false, false) if through.max_element() < back.max_element() => all_back,
            (_, false) => all_through,
        };
        Sides { through, back }
    }

    /// Returns the refraction from or to air at one wavelength, `nm`, or at all (0).
    fn refraction(&self, at: &Arrival<'_>, nm: f32) -> Refraction {
        let (before, beyond) = if EFFECTS & effect::NESTED_MEDIA != 0
            && let Some(border) = self.border(at.media, at.surface.material, at.inside)
        {
            self.indices(border, nm)
        } else {
            let own = self.index(at.surface.material, nm);
            if at.inside { (own, 1.0) } else { (1.0, own) }
        };
        refract(at.direction, at.normal, before, beyond)
    }

    /// Returns the indices of refraction on both sides of a border at one wavelength, `nm`, or at
    /// all (0).
    #[inline(always)]
    fn indices(&self, border: Border, nm: f32) -> (f32, f32) {
        let index = |number: Option<u8>| {
            let materials = self.searcher.scene.materials;
            let material = number.and_then(|number| materials.get(usize::from(number)));
            material.map_or(1.0, |material| self.index(material, nm))
        };
        (index(border.before), index(border.beyond))
    }

    /// Returns the clear bodies that a ray is in beyond a border.
    #[inline(always)]
    fn beyond(&self, at: &Arrival<'_>) -> Media {
        if EFFECTS & effect::NESTED_MEDIA == 0 {
            return at.media;
        }
        let border = self.border(at.media, at.surface.material, at.inside);
        border.map_or(at.media, |border| border.after)
    }

    /// Returns a material's index of refraction at one wavelength, `nm`, or at all (0).
    #[inline(always)]
    fn index(&self, material: &Material, nm: f32) -> f32 {
        if EFFECTS & effect::DISPERSION != 0
            && material.effects & self.effects & effect::DISPERSION != 0
            && nm > 0.0
            && let Some(medium) = self.searcher.scene.media.get(material.medium as usize)
        {
            medium.index(nm)
        } else {
            material.index_of_refraction
        }
    }
}

/// A ray tree under way: what it is traced with, and the light that its rays have gathered.
struct RayTree<'t, 'a, const W: usize, const EFFECTS: u32, R> {
    shading: Shading<'t, 'a, W, EFFECTS>,
    budget: &'t mut Budget,
    workspace: &'t mut Workspace,
    record: &'t mut R,
    light: Vec3,
    alpha: f32,
    /// Wavelength of the current rays: nanometres; 0 for all wavelengths.
    nm: f32,
    tint: Vec3,
    fan: Option<Fan<'a>>,
    /// Share of the sample's wavelengths that is being traced; 0 outside fans.
    share: f32,
    /// Whether this is the fan's first wavelength, whose rays exist without dispersion too.
    is_first: bool,
    /// Colour of the light that fans reflect: the sum over the sample's wavelengths.
    reflected: Vec3,
    /// Mean light over the sample's wavelengths, each counted without its colour.
    through: Vec3,
    /// White less the sum of the sample's wavelengths; `None` without a fan.
    missing: Option<Vec3>,
    /// Angle by which the tree's rays widen: radians.
    spread: Width,
    /// Width of what the ray that is being shaded sees of its surface: metres.
    footprint: f32,
    /// The clear bodies that the ray is in that is being shaded.
    media: Media,
    /// Number of veils that were seen through.
    veils: usize,
}

impl<'t, 'a, const W: usize, const EFFECTS: u32, R: Record> RayTree<'t, 'a, W, EFFECTS, R>
where
    Simd: Runs<W>,
{
    #[inline(always)]
    fn new(
        searcher: &'t Searcher<'a, W>,
        (detail, sample): (RayDetail, Sample),
        budget: &'t mut Budget,
        workspace: &'t mut Workspace,
        record: &'t mut R,
    ) -> Self {
        Self {
            shading: Shading {
                searcher,
                detail,
                sample,
                effects: searcher.effects.bits() & EFFECTS,
            },
            budget,
            workspace,
            record,
            light: Vec3::ZERO,
            alpha: 1.0,
            nm: searcher.spectrum.single(),
            tint: Vec3::ONE,
            fan: None,
            share: 0.0,
            is_first: false,
            reflected: Vec3::ONE,
            through: Vec3::ZERO,
            missing: None,
            spread: Width::ZERO,
            footprint: 0.0,
            media: Media::NONE,
            veils: 0,
        }
    }

    /// Returns whether this is compiled for an effect.
    const fn has(bits: u32) -> bool {
        EFFECTS & bits != 0
    }

    /// Returns the surface at a hit, and its distance.
    #[inline(always)]
    fn meet(&self, ray: &Ray, hit: &Hit) -> Option<(Surface<'a>, f32)> {
        let (scene, effects) = (&self.shading.searcher.scene, self.shading.effects);
        let surface = Surface::new::<W, EFFECTS>(scene, ray, hit, effects)?;
        Some((surface, hit.on.t))
    }

    /// Traces a primary ray, which meets a surface, and all its descendants.
    #[inline(always)]
    fn trace(&mut self, mut next: Pending, mut met: Option<(Surface<'a>, f32)>) -> Pixel {
        let (searcher, rung) = (self.shading.searcher, self.shading.detail.rung);
        self.workspace.pending.clear();
        if Self::has(effect::TEXTURE_LEVELS | ENVIRONMENT) {
            let direction = next.ray.direction();
            let length = sqrt(direction.dot(direction));
            self.spread = Width::new(self.shading.detail.spread.get() / length);
        }
        // The loop ends: every ray but those through a fixed number of veils has more bounces than
        // its parent, and a fan has a fixed number of wavelengths.
        loop {
            self.shade(&next, met);
            if Self::has(effect::DISPERSION) {
                self.advance_fan();
            }
            let pending = self.workspace.pending.pop();
            let Some(pending) = pending.filter(|_| !self.budget.is_exhausted()) else {
                break;
            };
            next = pending;
            if Self::has(effect::DISPERSION) && self.fan.is_none() {
                self.look_through(next.is_tinted);
            }
            let before = self.workspace.statistics.steps;
            let hit = searcher.nearest_on(rung, &next.ray, self.budget, self.workspace);
            let steps = self.workspace.statistics.steps - before;
            self.record.ray(next.cause, steps);
            met = hit.and_then(|hit| self.meet(&next.ray, &hit));
        }
        if Self::has(effect::DISPERSION)
            && let Some(missing) = self.missing.filter(|_| !self.budget.is_exhausted())
        {
            self.workspace.balance = Balance::one(missing, self.through);
        }
        Pixel::new(self.light, self.alpha)
    }

    /// Adds what a ray sees to the pixel and pushes its child rays.
    fn shade(&mut self, from: &Pending, met: Option<(Surface<'a>, f32)>) {
        let direction = from.ray.direction();
        if Self::has(effect::NESTED_MEDIA) {
            self.media = from.media;
        }
        let Some((surface, t)) = self.first_surface(&from.ray, met) else {
            self.see_background(direction, from.weight, from.uncovered);
            return;
        };
        let material = surface.material;
        let effects = material.effects & self.shading.effects;
        self.record.touch(effects & OF_SURFACES);
        let length = sqrt(direction.dot(direction));
        let direction = direction / length;
        let width = if Self::has(effect::TEXTURE_LEVELS) {
            from.width.get() + self.spread.get() * (t * length)
        } else {
            0.0
        };
        let cosine = direction.dot(surface.geometric_normal);
        let inside = cosine > 0.0;
        if Self::has(effect::TEXTURE_LEVELS) {
            // As large as the ellipse that is seen aslant.
            self.footprint = width / sqrt(max(cosine.abs(), LEAST_COSINE));
        }
        let filling = self.filling(self.media, inside.then_some(material));
        let weight = if Self::has(effect::ABSORPTION)
            && let Some(filling) = filling
            && filling.effects & self.shading.effects & effect::ABSORPTION != 0
        {
            self.record.touch(effect::ABSORPTION);
            let distance = t * length;
            let [r, g, b] = map3(filling.absorption, |a| libm::expf(-a * distance));
            from.weight * Vec3::new(r, g, b)
        } else {
            from.weight
        };
        let facing = if inside { -1.0 } else { 1.0 };
        let normal = self.normal(&surface) * facing;
        let incidence = Incidence {
            direction,
            normal,
            facing,
        };
        let look = self.look(&surface, incidence, from.bounces == 0);
        let own = self.own_light(&surface, &look, incidence);
        self.add(weight * own);
        let is_clear = Self::has(effect::REFRACTION) && effects & effect::REFRACTION != 0;
        let is_mirror = Self::has(effect::REFLECTION) && effects & effect::REFLECTION != 0;
        let is_veil = is_clear && self.is_veil(material);
        // What is seen straight through a veil is no bounce further.
        let goes_on = is_veil && self.veils < MOST_LAYERS;
        self.veils += usize::from(goes_on);
        let is_last = from.bounces >= self.shading.detail.depth;
        if is_last {
            if Self::has(effect::MICROFACETS) && is_mirror && effects & effect::MICROFACETS != 0 {
                // At the last bounce the background stands for what microfacets mirror.
                let reflected = above(
                    reflect(direction, normal),
                    surface.geometric_normal * facing,
                );
                self.see_background(reflected, weight * look.mirror, 0.0);
            }
            if is_clear && !goes_on {
                // At the last bounce the background stands for what is behind the glass.
                let let_through = Vec3::from_array(material.transmission) * look.stain;
                let share = if inside { Vec3::ONE } else { let_through };
                let uncovered = from.uncovered * share.max_element();
                self.see_background(direction, weight * share, uncovered);
            }
            if !goes_on {
                return;
            }
        }
        if self.shading.border(self.media, material, inside).is_some() {
            self.record.touch(effect::NESTED_MEDIA);
        }
        let at = Arrival {
            surface,
            stain: look.stain,
            direction,
            normal,
            inside,
            weight,
            uncovered: from.uncovered,
            bounces: from.bounces + u8::from(!goes_on),
            is_tinted: from.is_tinted,
            width: Width::new(width),
            media: self.media,
        };
        if is_clear {
            self.enter(&at);
        }
        if is_mirror && !is_last && (is_veil || !is_clear) {
            let at = Arrival {
                bounces: from.bounces + 1,
                ..at
            };
            self.mirror(&at, look.mirror);
        }
    }

    /// Pushes the ray that a mirror reflects, with a share of the light.
    #[inline(always)]
    fn mirror(&mut self, at: &Arrival<'a>, share: Vec3) {
        let weight = at.weight * share;
        if weight.max_element() < LEAST_WEIGHT {
            return;
        }
        let cause = self.cause(effect::REFLECTION);
        let scene = &self.shading.searcher.scene;
        if self
            .workspace
            .push(at.reflected(scene, (weight, 0.0), cause))
        {
            self.record.touch(effect::REFLECTION);
            self.workspace.statistics.reflected += 1;
        }
    }

    /// Adds the background, with a weight and the uncovered share of the pixel.
    #[inline(always)]
    fn see_background(&mut self, direction: Vec3, weight: Vec3, uncovered: f32) {
        let background = self.shading.searcher.scene.background();
        let alpha = background.alpha;
        // Seen directly or through glass it counts as far as it covers; seen in a
        // mirror it is part of the mirror.
        let share = if uncovered > 0.0 { alpha } else { 1.0 };
        let colour = if self.shading.is_asked(ENVIRONMENT) {
            self.record.touch(ENVIRONMENT);
            environment::colour(&self.shading.searcher.scene, direction, self.spread.get())
        } else {
            background::colour(background, direction)
        };
        self.add(weight * colour * share);
        self.alpha -= uncovered * (1.0 - alpha);
    }

    /// Pushes the reflected and the refracted ray at the border of a clear body.
    fn enter(&mut self, at: &Arrival<'a>) {
        let shading = self.shading;
        if Self::has(effect::DISPERSION)
            && at.surface.material.effects & shading.effects & effect::DISPERSION != 0
            && self.nm == 0.0
            && let spectrum = shading.searcher.spectrum
            && let Some(part) = spectrum.part(shading.sample, shading.detail.wavelengths)
        {
            self.begin_fan(*at, part);
            return;
        }
        let scene = &shading.searcher.scene;
        let refraction = shading.refraction(at, self.nm);
        let reflectance = Vec3::splat(refraction.reflectance);
        let sides = shading.sides(at, at.let_through(&refraction), reflectance);
        if let Some(share) = sides.through {
            let cause = self.cause(effect::REFRACTION);
            if self.workspace.push(at.refracted(
                scene,
                &refraction,
                share,
                (cause, shading.beyond(at)),
            )) {
                self.record.touch(effect::REFRACTION);
                self.workspace.statistics.refracted += 1;
            }
        }
        if let Some(share) = sides.back {
            self.reflect_in_part(at, share);
        }
    }

    /// Pushes the ray that the border of a clear body reflects.
    fn reflect_in_part(&mut self, at: &Arrival<'a>, share: Vec3) {
        // A ray reflected inside the body may still leave it on the far side.
        let uncovered = if at.inside {
            at.uncovered * share.max_element()
        } else {
            0.0
        };
        let cause = self.cause(effect::REFRACTION);
        let scene = &self.shading.searcher.scene;
        let reflected = at.reflected(scene, (at.weight * share, uncovered), cause);
        if self.workspace.push(reflected) {
            self.record.touch(effect::REFRACTION);
            self.workspace.statistics.reflected += 1;
        }
    }

    /// Returns the effect that a ray is recorded for: `own`, or dispersion from a fan's second
    /// wavelength on.
    #[inline(always)]
    fn cause(&self, own: u32) -> u32 {
        if Self::has(effect::DISPERSION) && self.share > 0.0 && !self.is_first {
            effect::DISPERSION
        } else {
            own
        }
    }

    /// Sets the colour of the next ray, outside fans.
    #[inline(always)]
    fn look_through(&mut self, is_tinted: bool) {
        self.is_first = true;
        (self.tint, self.share) = if is_tinted {
            (self.reflected, 1.0)
        } else {
            (Vec3::ONE, 0.0)
        };
    }

    #[inline(always)]
    fn add(&mut self, light: Vec3) {
        if Self::has(effect::DISPERSION) {
            self.light += light * self.tint;
            self.through += light * self.share;
        } else {
            self.light += light;
        }
    }
}
