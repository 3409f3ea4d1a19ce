//! Whitted's ray tree (1980), on an explicit stack.
//!
//! Compiled for a set of effects: what is not in it has no code here.

use super::background;
use super::budget::Budget;
use super::hit::Hit;
use super::ledger::{Ledger, Record};
use super::optics::{reflect, refract};
use super::sample::Sample;
use super::surface::Surface;
use super::tracer::{LEAST_WEIGHT, Pixel, RayDetail, Tracer, Workspace};
use crate::numeric::{map3, normalize, sqrt};
use crate::scene::EffectSet;
use crate::scene::format::{effect, light};
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
    (detail, _sample): (RayDetail, Sample),
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
const OF_SURFACES: u32 = effect::GRATICULE;

/// The number of an effect's bit.
const fn place(bit: u32) -> u8 {
    bit.trailing_zeros() as u8
}

/// The shading of one ray tree, for the effects of some bits.
struct Shading<'t, 'a, const W: usize, const EFFECTS: u32> {
    tracer: &'t Tracer<'a, W>,
    detail: RayDetail,
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
        if material.effects & effect::LIT != 0 {
            let towards = (direction, normal, facing);
            let record = &mut *gathered.record;
            let lit = self.lit(&surface, towards, budget, workspace, record);
            gathered.light += weight * lit;
        }
        if from.bounces >= self.detail.depth {
            return;
        }
        let bounces = from.bounces + 1;
        if Self::has(effect::REFRACTION) && effects & effect::REFRACTION != 0 {
            let index = material.index_of_refraction;
            let ratio = if inside { index } else { 1.0 / index };
            let refraction = refract(direction, normal, ratio);
            let let_through = Vec3::from_array(material.transmission);
            if let Some(refracted) = refraction.direction {
                let share = let_through * (1.0 - refraction.reflectance);
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

    /// Light from lights: ambient, Lambert, and Blinn-Phong (Blinn 1977).
    fn lit<R: Record>(
        &self,
        surface: &Surface<'_>,
        (direction, normal, facing): (Vec3, Vec3, f32),
        budget: &mut Budget,
        workspace: &mut Workspace,
        record: &mut R,
    ) -> Vec3 {
        let scene = self.tracer.scene();
        let material = surface.material;
        let diffuse = Vec3::from_array(material.diffuse);
        let specular = Vec3::from_array(material.specular);
        let mut sum = Vec3::from_array(scene.header.ambient) * diffuse;
        for source in scene.lights {
            let place = Vec3::from_array(source.place);
            let (to_light, limit) = if source.kind == light::DIRECTIONAL {
                (place, f32::INFINITY)
            } else {
                (place - surface.point, 1.0)
            };
            let Some(unit) = normalize(to_light) else {
                continue;
            };
            let cosine = normal.dot(unit);
            if cosine <= 0.0 || surface.geometric_normal.dot(unit) * facing <= 0.0 {
                continue;
            }
            let start = surface.start(unit);
            // To the light's own place from where the ray starts.
            let along = if source.kind == light::DIRECTIONAL {
                unit
            } else {
                place - start
            };
            let Some(ray) = Ray::new(start, along) else {
                continue;
            };
            if self.is_shadowed(&ray, limit, budget, workspace, record) {
                continue;
            }
            let mut colour = Vec3::from_array(source.colour);
            if source.kind == light::POINT_INVERSE_SQUARE {
                colour /= to_light.dot(to_light);
            }
            let mut answer = diffuse * cosine;
            if specular != Vec3::ZERO
                && let Some(half) = normalize(unit - direction)
            {
                answer += specular * highlight(normal.dot(half), material.shininess);
            }
            sum += colour * answer;
        }
        sum
    }

    /// Whether something keeps light from a place.
    #[inline]
    fn is_shadowed<R: Record>(
        &self,
        ray: &Ray,
        limit: f32,
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
        record.ray(place(SHADOWS), workspace.statistics.steps - before);
        is_shadowed
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
