//! Rays against all instances of a scene.

use super::hit::{Goal, Hit, MeshHit, Nearest};
use super::leaves::MeshView;
use super::map::{map_point, map_vector};
use super::mesh::InMesh;
use super::stack::{TraversalStack, Work};
use super::walk::{Path, Visitor, leaf_index, walk};
use crate::numeric::{max, min};
use crate::scene::Scene;
use crate::scene::format::{Instance, flag, kind};
use crate::shape::{Ray, Slabs, Spheroid};
use crate::simd::{Lanes, RayKernel, Simd};

/// Visits the instances of a scene for the nearest hit, or for any that blocks light.
struct InWorld<'r, 'a, const W: usize, S> {
    goal: S,
    scene: &'r Scene<'a, W>,
    rung: u8,
    ray: &'r Ray,
    limit: f32,
    best: Hit,
}

impl<const W: usize, S> InWorld<'_, '_, W, S> {
    #[inline(always)]
    fn take_nearer(&mut self, instance: u32, on: MeshHit) {
        let best = &self.best;
        if on.t < best.on.t || (on.t == best.on.t && instance < best.instance) {
            self.best = Hit { instance, on };
            self.limit = min(self.limit, on.t);
        }
    }
}

/// Returns the hits of a ray on a spheroid, first and second, that lie after `start`.
#[inline(always)]
fn on_spheroid(instance: &Instance, ray: &Ray, start: f32) -> Option<MeshHit> {
    let hits = Spheroid::of_checked(instance.radii).intersect(ray)?;
    let [first, second] = hits.t;
    let (t, side) = if first >= 0.0 {
        (first, 0)
    } else {
        (second, 1)
    };
    (t >= 0.0).then_some(MeshHit {
        t: max(t, start) + 0.0,
        triangle: side,
        leaf: 0,
        lane: 0,
    })
}

impl<const W: usize, S: Goal> Visitor<W> for InWorld<'_, '_, W, S> {
    #[inline(always)]
    fn limit(&self) -> f32 {
        self.limit
    }

    #[inline(always)]
    fn leaf<L: Lanes<W>>(&mut self, l: L, child: u32, near: f32, path: &mut Path<'_>) -> bool {
        let number = leaf_index(child);
        if Simd::HAS_VECTORS {
            self.instance(l, number, near, path)
        } else {
            self.instance_apart(l, number, near, path)
        }
    }
}

impl<const W: usize, S: Goal> InWorld<'_, '_, W, S> {
    /// As `instance`. Most rays meet no instance, and inlined code would keep their registers
    /// in memory.
    #[inline(never)]
    fn instance_apart<L: Lanes<W>>(
        &mut self,
        lanes: L,
        number: u32,
        near: f32,
        path: &mut Path<'_>,
    ) -> bool {
        self.instance(lanes, number, near, path)
    }

    /// Looks into an instance that the ray enters at `near`. True ends the search.
    #[inline(always)]
    fn instance<L: Lanes<W>>(
        &mut self,
        lanes: L,
        number: u32,
        near: f32,
        path: &mut Path<'_>,
    ) -> bool {
        let Some(instance) = self.scene.instances.get(number as usize) else {
            return false;
        };
        if self.goal.is_any() && instance.flags & flag::OCCLUDES == 0 {
            return false;
        }
        if !path.take(1) {
            return false;
        }
        // The direction keeps its mapped length, so that distances agree.
        let ray = Ray::new(
            map_point(&instance.object_from_world, self.ray.origin()),
            map_vector(&instance.object_from_world, self.ray.direction()),
        );
        let Some(ray) = ray else {
            return false;
        };
        let on = if instance.kind == kind::MESH {
            let Some(mesh) = self.scene.mesh_at(instance.geometry, self.rung) else {
                return false;
            };
            let mesh = MeshView::new(self.scene, mesh);
            let slabs = Slabs::new(&ray, mesh.extent);
            let within = (near, self.limit);
            let mut search = InMesh::new(self.goal, &mesh, &ray, &slabs, within);
            let found = walk(lanes, mesh.nodes, mesh.root, &slabs, &mut search, path);
            // No hit is at infinity, where a limit can be too.
            if !found && search.best == MeshHit::NONE {
                return false;
            }
            search.best
        } else {
            match on_spheroid(instance, &ray, near) {
                Some(on) if on.t <= self.limit => on,
                _ => return false,
            }
        };
        if self.goal.is_any() {
            return true;
        }
        self.take_nearer(number, on);
        false
    }
}

pub(super) struct Search<'r, 'a, const W: usize, S> {
    pub(super) goal: S,
    pub(super) scene: &'r Scene<'a, W>,
    pub(super) rung: u8,
    /// Farthest distance of a hit.
    pub(super) limit: f32,
    pub(super) stack: &'r mut TraversalStack,
    pub(super) most: u64,
}

impl<const W: usize, S: Goal> RayKernel<W> for Search<'_, '_, W, S> {
    type Output = (Hit, Work);

    #[inline(always)]
    fn run<L: Lanes<W>>(self, lanes: L, ray: &Ray) -> (Hit, Work) {
        let slabs = Slabs::new(ray, self.scene.extent);
        let mut visitor = InWorld {
            goal: self.goal,
            scene: self.scene,
            rung: self.rung,
            ray,
            limit: self.limit,
            best: Hit::NONE,
        };
        let mut path = Path::new(self.stack, self.most);
        let (nodes, root) = (self.scene.top, self.scene.header.root);
        let found = walk(lanes, nodes, root, &slabs, &mut visitor, &mut path);
        if self.goal.is_any() && found {
            visitor.best.instance = 0;
        }
        (visitor.best, path.work())
    }
}

/// A search for the nearest hit of one ray in one instance.
pub(super) struct SearchInstance<'r, 'a, const W: usize> {
    pub(super) scene: &'r Scene<'a, W>,
    pub(super) rung: u8,
    pub(super) instance: u32,
    pub(super) best: Hit,
    pub(super) stack: &'r mut TraversalStack,
    pub(super) most: u64,
}

impl<const W: usize> RayKernel<W> for SearchInstance<'_, '_, W> {
    type Output = (Hit, Work);

    #[inline(always)]
    fn run<L: Lanes<W>>(self, lanes: L, ray: &Ray) -> (Hit, Work) {
        let mut path = Path::new(self.stack, self.most);
        let mut visitor = InWorld {
            goal: Nearest,
            scene: self.scene,
            rung: self.rung,
            ray,
            limit: self.best.on.t,
            best: self.best,
        };
        if let Some(instance) = self.scene.instances.get(self.instance as usize) {
            let slabs = Slabs::new(ray, self.scene.extent);
            let (near, far) = slabs.interval(instance.low.into(), instance.high.into());
            let near = max(near, 0.0);
            if near <= min(far, visitor.limit) {
                visitor.instance(lanes, self.instance, near, &mut path);
            }
        }
        (visitor.best, path.work())
    }
}
