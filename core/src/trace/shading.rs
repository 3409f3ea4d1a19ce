//! Whitted's ray tree (1980), on an explicit stack.
//!
//! Compiled for a set of effects: what is not in it has no code here.

use super::background;
use super::budget::Budget;
use super::hit::Hit;
use super::ledger::{Ledger, Record};
use super::optics::{reflect, refract};
use super::sample::Sample;
use super::soft_light::{Points, Rectangle};
use super::surface::Surface;
use super::texture::{self, TEXTURES};
use super::tracer::{LEAST_WEIGHT, Pixel, RayDetail, Tracer, Workspace};
use crate::numeric::{map3, normalize, sqrt};
use crate::scene::EffectSet;
use crate::scene::format::{Light, effect, light};
use crate::shape::Ray;
use crate::simd::{Runs, Simd};
use glam::Vec3;

/// Traces what a primary ray leaves behind where it hits.
pub(super) type Shade<const W: usize> = for<'r, 's> fn(
    &'r Tracer<'s, W>,
    &'r Ray,
    Hit,
    (RayDetail, Sample),
    &'r mut Budget,
    &'r mut Workspace,
) -> Pixel;

/// A ray of the tree that is still to be traced.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pending {
    ray: Ray,
    /// What its light counts for in the pixel.
    weight: Vec3,
    /// What the background behind it takes from the pixel's coverage.
    uncovered: f32,
    bounces: u8,
    /// The effect that sent it, by its bit's number.
    cause: u8,
}

/// As [`Tracer::radiance_from`], which it is chosen by: what is compiled for the
/// effects of some bits.
pub(super) fn shade_tree<const W: usize, const EFFECTS: u32>(
    tracer: &Tracer<'_, W>,
    ray: &Ray,
    hit: Hit,
    of: (RayDetail, Sample),
    budget: &mut Budget,
    workspace: &mut Workspace,
) -> Pixel
where
    Simd: Runs<W>,
{
    tree::<W, EFFECTS, ()>(tracer, (ray, hit), of, budget, workspace, &mut ())
}

/// The same with all effects, and what each does.
pub(super) fn shade_and_record<const W: usize>(
    tracer: &Tracer<'_, W>,
    (ray, hit): (&Ray, Hit),
    of: (RayDetail, Sample),
    workspace: &mut Workspace,
    ledger: &mut Ledger,
) -> Pixel
where
    Simd: Runs<W>,
{
    const ALL: u32 = EffectSet::ALL.bits();
    let budget = &mut { Budget::UNLIMITED };
    tree::<W, ALL, Ledger>(tracer, (ray, hit), of, budget, workspace, ledger)
}

#[inline(always)]
fn tree<const W: usize, const EFFECTS: u32, R: Record>(
    tracer: &Tracer<'_, W>,
    (ray, hit): (&Ray, Hit),
    (detail, sample): (RayDetail, Sample),
    budget: &mut Budget,
    workspace: &mut Workspace,
    record: &mut R,
) -> Pixel
where
    Simd: Runs<W>,
{
    let shading = Shading::<W, EFFECTS> {
        tracer,
        detail,
        sample,
        effects: tracer.effects().bits() & EFFECTS,
    };
    let mut gathered = Gathered {
        light: Vec3::ZERO,
        alpha: 1.0,
        record,
    };
    let primary = Pending {
        ray: *ray,
        weight: Vec3::ONE,
        uncovered: 1.0,
        bounces: 0,
        cause: 0,
    };
    workspace.pending.clear();
    shading.shade(&primary, Some(hit), &mut gathered, budget, workspace);
    // Every ray has more bounces than its parent: the loop ends.
    while let Some(next) = workspace.pending.pop() {
        let before = workspace.statistics.steps;
        let hit = tracer.nearest_on(detail.rung, &next.ray, budget, workspace);
        let steps = workspace.statistics.steps - before;
        gathered.record.ray(next.cause, steps);
        shading.shade(&next, hit, &mut gathered, budget, workspace);
    }
    Pixel {
        red: gathered.light.x,
        green: gathered.light.y,
        blue: gathered.light.z,
        alpha: gathered.alpha,
    }
}

/// Effects that are carried out wherever a surface that has them is met.
const OF_SURFACES: u32 = effect::GRATICULE | effect::EMISSION | TEXTURES;

/// The number of an effect's bit.
const fn place(bit: u32) -> u8 {
    bit.trailing_zeros() as u8
}

/// The shading of one ray tree, for the effects of some bits.
struct Shading<'t, 'a, const W: usize, const EFFECTS: u32> {
    tracer: &'t Tracer<'a, W>,
    detail: RayDetail,
    sample: Sample,
    /// The tracer's, of those that this is compiled for.
    effects: u32,
}

impl<const W: usize, const EFFECTS: u32> Shading<'_, '_, W, EFFECTS>
where
    Simd: Runs<W>,
{
    /// Whether this is compiled for an effect.
    const fn has(bits: u32) -> bool {
        EFFECTS & bits != 0
    }

    /// Adds what a ray sees to the pixel, and the rays that it leaves behind to
    /// those that are still to be traced.
    fn shade<R: Record>(
        &self,
        from: &Pending,
        hit: Option<Hit>,
        gathered: &mut Gathered<'_, R>,
        budget: &mut Budget,
        workspace: &mut Workspace,
    ) {
        let direction = from.ray.direction();
        let scene = self.tracer.scene();
        let surface =
            hit.and_then(|hit| Surface::new::<W, EFFECTS>(scene, &from.ray, &hit, self.effects));
        let (Some(hit), Some(surface)) = (hit, surface) else {
            let background = scene.background();
            let alpha = background.alpha;
            // Seen directly or through glass it counts as far as it covers;
            // seen in a mirror it is part of the mirror.
            let share = if from.uncovered > 0.0 { alpha } else { 1.0 };
            gathered.light += from.weight * background::colour(background, direction) * share;
            gathered.alpha -= from.uncovered * (1.0 - alpha);
            return;
        };
        let material = surface.material;
        let effects = material.effects & self.effects;
        gathered.record.touch(effects & OF_SURFACES);
        let length = sqrt(direction.dot(direction));
        let direction = direction / length;
        let inside = direction.dot(surface.geometric_normal) > 0.0;
        let weight = if inside && Self::has(effect::ABSORPTION) && effects & effect::ABSORPTION != 0
        {
            gathered.record.touch(effect::ABSORPTION);
            let distance = hit.on.t * length;
            let [r, g, b] = map3(material.absorption, |a| libm::expf(-a * distance));
            from.weight * Vec3::new(r, g, b)
        } else {
            from.weight
        };
        let facing = if inside { -1.0 } else { 1.0 };
        let normal = surface.shading_normal * facing;
        let towards = (direction, normal, facing);
        let record = &mut *gathered.record;
        gathered.light += weight * self.own_light(&surface, towards, budget, workspace, record);
        if from.bounces >= self.detail.depth {
            return;
        }
        let bounces = from.bounces + 1;
        if Self::has(effect::REFRACTION) && effects & effect::REFRACTION != 0 {
            let index = material.index_of_refraction;
            let (before, beyond) = if inside { (index, 1.0) } else { (1.0, index) };
            let refraction = refract(direction, normal, before, beyond);
            let let_through = Vec3::from_array(material.transmission);
            if let Some(refracted) = refraction.direction {
                let share = let_through * refraction.transmittance;
                let ray = Ray::new(surface.start(refracted), refracted);
                let next = Next {
                    ray,
                    weight: weight * share,
                    uncovered: from.uncovered * share.max_element(),
                    bounces,
                    cause: effect::REFRACTION,
                };
                if next.push(workspace) {
                    gathered.record.touch(effect::REFRACTION);
                    workspace.statistics.refracted += 1;
                }
            }
            let reflected = above(
                reflect(direction, normal),
                surface.geometric_normal * facing,
            );
            let next = Next {
                ray: Ray::new(surface.start(reflected), reflected),
                weight: weight * refraction.reflectance,
                // Inside, what is reflected is still on its way through.
                uncovered: if inside {
                    from.uncovered * refraction.reflectance
                } else {
                    0.0
                },
                bounces,
                cause: effect::REFRACTION,
            };
            if next.push(workspace) {
                gathered.record.touch(effect::REFRACTION);
                workspace.statistics.reflected += 1;
            }
        } else if Self::has(effect::REFLECTION) && effects & effect::REFLECTION != 0 {
            let reflected = above(
                reflect(direction, normal),
                surface.geometric_normal * facing,
            );
            let next = Next {
                ray: Ray::new(surface.start(reflected), reflected),
                weight: weight * Vec3::from_array(material.mirror),
                uncovered: 0.0,
                bounces,
                cause: effect::REFLECTION,
            };
            if next.push(workspace) {
                gathered.record.touch(effect::REFLECTION);
                workspace.statistics.reflected += 1;
            }
        }
    }

    /// What a surface sends back along a ray without any further ones of the
    /// tree: its own light and that of lights, in the colours of its texture.
    #[inline(always)]
    fn own_light<R: Record>(
        &self,
        surface: &Surface<'_>,
        (direction, normal, facing): (Vec3, Vec3, f32),
        budget: &mut Budget,
        workspace: &mut Workspace,
        record: &mut R,
    ) -> Vec3 {
        let material = surface.material;
        let effects = material.effects & self.effects;
        let texture = if Self::has(TEXTURES) && effects & TEXTURES != 0 {
            let (scene, at) = (self.tracer.scene(), surface.coordinate);
            Some(texture::colour::<W, EFFECTS>(scene, material, at))
        } else {
            None
        };
        let textured = |colour: [f32; 3]| {
            let colour = Vec3::from_array(colour);
            texture.map_or(colour, |texture| colour * texture)
        };
        let mut light = Vec3::ZERO;
        if material.effects & effect::LIT != 0 {
            let at = Lighting {
                surface,
                diffuse: textured(material.diffuse),
                direction,
                normal,
                facing,
            };
            light = self.lit(&at, budget, workspace, record);
        }
        let outside = facing > 0.0;
        if Self::has(effect::EMISSION) && effects & effect::EMISSION != 0 && outside {
            light += textured(material.emission);
        }
        light
    }

    /// Light from lights: ambient, Lambert, and Blinn-Phong (Blinn 1977).
    fn lit<R: Record>(
        &self,
        at: &Lighting<'_, '_>,
        budget: &mut Budget,
        workspace: &mut Workspace,
        record: &mut R,
    ) -> Vec3 {
        let scene = self.tracer.scene();
        let mut sum = Vec3::from_array(scene.header.ambient) * at.diffuse;
        for (number, source) in (0..).zip(scene.lights) {
            if source.is_large() {
                sum += self.lit_by_rectangle(at, number, source, budget, workspace, record);
                continue;
            }
            let place = Vec3::from_array(source.place);
            let (to_light, from) = if source.kind == light::DIRECTIONAL {
                (place, None)
            } else {
                (place - at.surface.point, Some(place))
            };
            let Some((unit, cosine)) = at.sees(to_light) else {
                continue;
            };
            let Some((ray, limit)) = at.ray_to(unit, from) else {
                continue;
            };
            if self.is_shadowed(&ray, limit, EffectSet::SHADOWS, budget, workspace, record) {
                continue;
            }
            let mut colour = Vec3::from_array(source.colour);
            if source.kind == light::POINT_INVERSE_SQUARE {
                colour /= to_light.dot(to_light);
            }
            sum += colour * at.answer(unit, cosine);
        }
        sum
    }

    /// The mean over points of a rectangle, further ones for each sample of a
    /// pixel; of its middle alone where soft light is left out.
    fn lit_by_rectangle<R: Record>(
        &self,
        at: &Lighting<'_, '_>,
        number: u32,
        source: &Light,
        budget: &mut Budget,
        workspace: &mut Workspace,
        record: &mut R,
    ) -> Vec3 {
        const SOFT_LIGHT: u32 = EffectSet::SOFT_LIGHT.bits();
        let Some(rectangle) = Rectangle::new(source) else {
            return Vec3::ZERO;
        };
        let points = (Self::has(SOFT_LIGHT) && self.effects & SOFT_LIGHT != 0)
            .then(|| Points::new(self.sample.seed(), number));
        let (count, cause) = match points {
            Some(_) => (source.samples, EffectSet::SOFT_LIGHT),
            None => (1, EffectSet::SHADOWS),
        };
        record.touch(cause.bits() & SOFT_LIGHT);
        let first = u32::from(self.sample.index()) * count;
        let mut sum = Vec3::ZERO;
        for point in first..first + count {
            let on_square = points.map_or([0.0; 2], |points| points.point(point));
            let place = rectangle.place(on_square);
            let to_light = place - at.surface.point;
            let Some((unit, cosine)) = at.sees(to_light) else {
                continue;
            };
            let irradiance = rectangle.irradiance(to_light, unit);
            if irradiance <= 0.0 {
                continue;
            }
            let Some((ray, limit)) = at.ray_to(unit, Some(place)) else {
                continue;
            };
            if !self.is_shadowed(&ray, limit, cause, budget, workspace, record) {
                sum += at.answer(unit, cosine) * irradiance;
            }
        }
        Vec3::from_array(source.colour) * (sum / count as f32)
    }

    /// Whether something keeps light from a place: a ray for `cause`.
    #[inline]
    fn is_shadowed<R: Record>(
        &self,
        ray: &Ray,
        limit: f32,
        cause: EffectSet,
        budget: &mut Budget,
        workspace: &mut Workspace,
        record: &mut R,
    ) -> bool {
        const SHADOWS: u32 = EffectSet::SHADOWS.bits();
        if !Self::has(SHADOWS) || self.effects & SHADOWS == 0 {
            return false;
        }
        let before = workspace.statistics.steps;
        let (tracer, rung) = (self.tracer, self.detail.rung);
        let is_shadowed = tracer.is_occluded_on(rung, ray, limit, budget, workspace);
        record.touch(SHADOWS);
        record.ray(place(cause.bits()), workspace.statistics.steps - before);
        is_shadowed
    }
}

/// A surface as light from lights finds it.
struct Lighting<'s, 'a> {
    surface: &'s Surface<'a>,
    /// Reflectance, with the texture.
    diffuse: Vec3,
    /// The ray's: unit.
    direction: Vec3,
    /// Unit, on the ray's side.
    normal: Vec3,
    /// −1 where that is inside, else 1.
    facing: f32,
}

impl Lighting<'_, '_> {
    /// The unit vector to a light and its cosine, where it is on the ray's side.
    #[inline(always)]
    fn sees(&self, to_light: Vec3) -> Option<(Vec3, f32)> {
        let unit = normalize(to_light)?;
        let cosine = self.normal.dot(unit);
        let outside = self.surface.geometric_normal.dot(unit) * self.facing > 0.0;
        (cosine > 0.0 && outside).then_some((unit, cosine))
    }

    /// A ray to a light and where that is along it. To the light's own place
    /// from where the ray starts.
    #[inline(always)]
    fn ray_to(&self, unit: Vec3, place: Option<Vec3>) -> Option<(Ray, f32)> {
        let start = self.surface.start(unit);
        let (along, limit) = place.map_or((unit, f32::INFINITY), |place| (place - start, 1.0));
        Some((Ray::new(start, along)?, limit))
    }

    /// What it sends back along the ray of irradiance 1 from a direction.
    #[inline(always)]
    fn answer(&self, unit: Vec3, cosine: f32) -> Vec3 {
        let material = self.surface.material;
        let specular = Vec3::from_array(material.specular);
        let mut answer = self.diffuse * cosine;
        if specular != Vec3::ZERO
            && let Some(half) = normalize(unit - self.direction)
        {
            answer += specular * highlight(self.normal.dot(half), material.shininess);
        }
        answer
    }
}

/// Blinn-Phong's cosⁿ, or 0 where it is under e⁻¹⁶, a ten-millionth: there
/// by ln x ≤ x − 1, without the price of a power.
fn highlight(cosine: f32, shininess: f32) -> f32 {
    if cosine <= 0.0 || shininess * (1.0 - cosine) > 16.0 {
        0.0
    } else {
        libm::powf(cosine, shininess)
    }
}

struct Gathered<'r, R> {
    light: Vec3,
    alpha: f32,
    record: &'r mut R,
}

/// A ray about to be added to the tree.
struct Next {
    ray: Option<Ray>,
    weight: Vec3,
    uncovered: f32,
    bounces: u8,
    /// The effect's bit.
    cause: u32,
}

impl Next {
    /// Whether it is worth tracing, and was put down for it.
    fn push(self, workspace: &mut Workspace) -> bool {
        let Some(ray) = self.ray else {
            return false;
        };
        if self.weight.max_element() < LEAST_WEIGHT {
            return false;
        }
        workspace
            .pending
            .push(Pending {
                ray,
                weight: self.weight,
                uncovered: self.uncovered,
                bounces: self.bounces,
                cause: place(self.cause),
            })
            .is_ok()
    }
}

/// A reflection off an interpolated normal can point into the surface; it is
/// turned back out, continuously.
fn above(direction: Vec3, normal: Vec3) -> Vec3 {
    let depth = direction.dot(normal);
    if depth < 0.0 {
        direction - normal * (2.0 * depth)
    } else {
        direction
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn highlights_are_a_power_down_to_a_ten_millionth() {
        assert_eq!(highlight(1.0, 50.0), 1.0);
        assert!((highlight(0.9, 20.0) - 0.9f32.powi(20)).abs() < 1e-6);
        assert_eq!(highlight(-0.5, 2.0), 0.0);
        for shininess in [1.0, 30.0, 1.0e4] {
            let cut = 1.0 - 16.0 / shininess;
            assert!(cut <= 0.0 || libm::powf(cut, shininess) < 1.2e-7);
        }
    }

    #[test]
    fn reflections_into_the_surface_come_back_out() {
        let bent = above(Vec3::new(0.8, -0.6, 0.0), Vec3::Y);
        assert_eq!(bent, Vec3::new(0.8, 0.6, 0.0));
        assert_eq!(above(bent, Vec3::Y), bent);
    }
}
