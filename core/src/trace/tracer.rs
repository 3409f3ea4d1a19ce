//! Whitted's ray tree (1980), on an explicit stack.

use super::background;
use super::budget::{Budget, Statistics};
use super::hit::Hit;
use super::optics::{reflect, refract};
use super::row::{RowHits, RowRays, RowSearch};
use super::stack::{TraversalStack, Work};
use super::surface::Surface;
use super::tile::{ALL_INSTANCES, MayHit, TileHits, TileRays, TileSearch};
use super::world::{Search, SearchInstance};
use crate::numeric::{map3, normalize, sqrt};
use crate::scene::Scene;
use crate::scene::format::{effect, light};
use crate::shape::Ray;
use crate::simd::{Runs, Simd};
use glam::Vec3;
use heapless::Vec;
use zerocopy::{FromBytes, Immutable, IntoBytes, KnownLayout};

/// Most bounces of a ray tree.
pub const MAX_DEPTH: u8 = 16;

/// Rays that add less than this to every channel of a pixel are not traced:
/// a quarter of a step of an eight-bit picture.
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
    pending: Vec<Pending, MOST_PENDING>,
    /// What has been done with this workspace; the caller's to clear.
    pub statistics: Statistics,
}

impl Workspace {
    /// With nothing done yet.
    pub const fn new() -> Self {
        Self {
            stack: TraversalStack::EMPTY,
            pending: Vec::new(),
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
}

/// A ray of the tree that is still to be traced.
#[derive(Debug, Clone, Copy)]
struct Pending {
    ray: Ray,
    /// What its light counts for in the pixel.
    weight: Vec3,
    /// What the background behind it takes from the pixel's coverage.
    uncovered: f32,
    bounces: u8,
}

/// Traces the rays of a scene.
#[derive(Debug, Clone, Copy)]
pub struct Tracer<'a, const W: usize = 8> {
    scene: Scene<'a, W>,
    simd: Simd,
    detail: RayDetail,
}

impl<'a, const W: usize> Tracer<'a, W>
where
    Simd: Runs<W>,
{
    /// Follows at most `depth` reflections and refractions after one another,
    /// never more than [`MAX_DEPTH`], through the finest meshes.
    pub fn new(scene: Scene<'a, W>, simd: Simd, depth: u8) -> Self {
        Self {
            scene,
            simd,
            detail: RayDetail {
                depth: depth.min(MAX_DEPTH),
                rung: 0,
            },
        }
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

    /// The nearest hit.
    pub fn nearest(
        &self,
        ray: &Ray,
        budget: &mut Budget,
        workspace: &mut Workspace,
    ) -> Option<Hit> {
        self.nearest_on(self.detail.rung, ray, budget, workspace)
    }

    fn nearest_on(
        &self,
        rung: u8,
        ray: &Ray,
        budget: &mut Budget,
        workspace: &mut Workspace,
    ) -> Option<Hit> {
        let (hit, work) = self.simd.run(Search::<W, false> {
            scene: &self.scene,
            rung,
            ray,
            limit: f32::INFINITY,
            stack: &mut workspace.stack,
        });
        workspace.account(work, budget);
        (hit.instance != u32::MAX).then_some(hit)
    }

    /// Whether any ray may meet anything that starts at `origin` and whose
    /// direction lies between four `corners`, component by component. False
    /// only where none does.
    pub(crate) fn may_hit(
        &self,
        origin: Vec3,
        corners: &[Vec3; 4],
        budget: &mut Budget,
        workspace: &mut Workspace,
    ) -> bool {
        let (may_hit, steps) = <Simd as Runs<8>>::run(
            self.simd,
            MayHit::<W> {
                scene: &self.scene,
                origin,
                corners,
            },
        );
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
        let work = <Simd as Runs<8>>::run(
            self.simd,
            TileSearch::<W> {
                scene: &self.scene,
                rays,
                hits: &mut hits,
                stack: &mut workspace.stack,
            },
        );
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
                    let (hit, work) = self.simd.run(SearchInstance::<W> {
                        scene: &self.scene,
                        rung,
                        ray: &ray,
                        instance,
                        best: hits.get(group, lane),
                        stack: &mut workspace.stack,
                    });
                    workspace.account(work, budget);
                    hit
                };
                hits.set(group, lane, hit);
            }
        }
        hits
    }

    /// The nearest hits of eight rays that start apart, each on its own rung:
    /// those that [`nearest`](Self::nearest) finds. `None`, at no price, where
    /// they cannot go together.
    pub(crate) fn nearest_of_row(
        &self,
        rays: &RowRays<'_>,
        rung: impl Fn(usize) -> Option<(Ray, u8)>,
        budget: &mut Budget,
        workspace: &mut Workspace,
    ) -> Option<RowHits> {
        let scene = &self.scene;
        let mut found = <Simd as Runs<8>>::run(self.simd, RowSearch::<W> { scene, rays })?;
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
                let (hit, work) = self.simd.run(SearchInstance::<W> {
                    scene,
                    rung,
                    ray: &ray,
                    instance,
                    best: *best,
                    stack: &mut workspace.stack,
                });
                workspace.account(work, budget);
                *best = hit;
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

    fn is_occluded_on(
        &self,
        rung: u8,
        ray: &Ray,
        limit: f32,
        budget: &mut Budget,
        workspace: &mut Workspace,
    ) -> bool {
        let (hit, work) = self.simd.run(Search::<W, true> {
            scene: &self.scene,
            rung,
            ray,
            limit,
            stack: &mut workspace.stack,
        });
        workspace.account(work, budget);
        workspace.statistics.shadow += 1;
        hit.instance != u32::MAX
    }

    /// The light that comes back along a ray from the eye.
    pub fn radiance(&self, ray: &Ray, budget: &mut Budget, workspace: &mut Workspace) -> Pixel {
        let hit = self.nearest(ray, budget, workspace);
        self.radiance_from(ray, hit, self.detail, budget, workspace)
    }

    /// As [`radiance`](Self::radiance), with a detail of its own.
    pub(crate) fn radiance_with(
        &self,
        ray: &Ray,
        detail: RayDetail,
        budget: &mut Budget,
        workspace: &mut Workspace,
    ) -> Pixel {
        let hit = self.nearest_on(detail.rung, ray, budget, workspace);
        self.radiance_from(ray, hit, detail, budget, workspace)
    }

    /// As [`radiance`](Self::radiance), the primary ray's hit being known.
    pub(crate) fn radiance_from(
        &self,
        ray: &Ray,
        hit: Option<Hit>,
        detail: RayDetail,
        budget: &mut Budget,
        workspace: &mut Workspace,
    ) -> Pixel {
        workspace.statistics.primary += 1;
        if hit.is_none() {
            return self.missed(ray.direction());
        }
        let mut gathered = Gathered {
            light: Vec3::ZERO,
            alpha: 1.0,
        };
        let primary = Pending {
            ray: *ray,
            weight: Vec3::ONE,
            uncovered: 1.0,
            bounces: 0,
        };
        workspace.pending.clear();
        self.shade(&primary, hit, detail, &mut gathered, budget, workspace);
        // Every ray has more bounces than its parent: the loop ends.
        while let Some(next) = workspace.pending.pop() {
            let hit = self.nearest_on(detail.rung, &next.ray, budget, workspace);
            self.shade(&next, hit, detail, &mut gathered, budget, workspace);
        }
        Pixel {
            red: gathered.light.x,
            green: gathered.light.y,
            blue: gathered.light.z,
            alpha: gathered.alpha,
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
            // As it is taken off below.
            alpha: 1.0 - (1.0 - background.alpha),
        }
    }

    fn shade(
        &self,
        from: &Pending,
        hit: Option<Hit>,
        detail: RayDetail,
        gathered: &mut Gathered,
        budget: &mut Budget,
        workspace: &mut Workspace,
    ) {
        let direction = from.ray.direction();
        let surface = hit.and_then(|hit| Surface::new(&self.scene, &from.ray, &hit));
        let (Some(hit), Some(surface)) = (hit, surface) else {
            let background = self.scene.background();
            let alpha = background.alpha;
            // Seen directly or through glass it counts as far as it covers;
            // seen in a mirror it is part of the mirror.
            let share = if from.uncovered > 0.0 { alpha } else { 1.0 };
            gathered.light += from.weight * background::colour(background, direction) * share;
            gathered.alpha -= from.uncovered * (1.0 - alpha);
            return;
        };
        let material = surface.material;
        let length = sqrt(direction.dot(direction));
        let direction = direction / length;
        let inside = direction.dot(surface.geometric_normal) > 0.0;
        let weight = if inside && material.effects & effect::ABSORPTION != 0 {
            let distance = hit.on.t * length;
            let [r, g, b] = map3(material.absorption, |a| libm::expf(-a * distance));
            from.weight * Vec3::new(r, g, b)
        } else {
            from.weight
        };
        let facing = if inside { -1.0 } else { 1.0 };
        let normal = surface.shading_normal * facing;
        if material.effects & effect::LIT != 0 {
            gathered.light += weight
                * self.lit(
                    &surface,
                    direction,
                    (normal, facing),
                    detail.rung,
                    budget,
                    workspace,
                );
        }
        if from.bounces >= detail.depth {
            return;
        }
        let bounces = from.bounces + 1;
        if material.effects & effect::REFRACTION != 0 {
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
                };
                if next.push(workspace) {
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
            };
            if next.push(workspace) {
                workspace.statistics.reflected += 1;
            }
        } else if material.effects & effect::REFLECTION != 0 {
            let reflected = above(
                reflect(direction, normal),
                surface.geometric_normal * facing,
            );
            let next = Next {
                ray: Ray::new(surface.start(reflected), reflected),
                weight: weight * Vec3::from_array(material.mirror),
                uncovered: 0.0,
                bounces,
            };
            if next.push(workspace) {
                workspace.statistics.reflected += 1;
            }
        }
    }

    /// Light from lights: ambient, Lambert, and Blinn-Phong (Blinn 1977).
    fn lit(
        &self,
        surface: &Surface<'_>,
        direction: Vec3,
        (normal, facing): (Vec3, f32),
        rung: u8,
        budget: &mut Budget,
        workspace: &mut Workspace,
    ) -> Vec3 {
        let material = surface.material;
        let diffuse = Vec3::from_array(material.diffuse);
        let specular = Vec3::from_array(material.specular);
        let mut sum = Vec3::from_array(self.scene.header.ambient) * diffuse;
        for source in self.scene.lights {
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
            if self.is_occluded_on(rung, &ray, limit, budget, workspace) {
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

struct Gathered {
    light: Vec3,
    alpha: f32,
}

/// A ray about to be added to the tree.
struct Next {
    ray: Option<Ray>,
    weight: Vec3,
    uncovered: f32,
    bounces: u8,
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
    fn a_workspace_is_as_small_as_documented() {
        let size = size_of::<Workspace>();
        assert!(size <= 2 * 1024 + 64, "{size} bytes");
    }

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
