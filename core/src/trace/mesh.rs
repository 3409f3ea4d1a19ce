//! Rays against the triangles of one mesh.

use super::hit::{Any, Goal, Hit, MeshHit, Nearest};
use super::leaves::{Leaves, MeshView};
use super::stack::{TraversalStack, Work};
use super::tile::{TileHits, TileInMeshSearch, TileRays};
use super::walk::{Path, Visitor, leaf_index, walk};
use crate::numeric::{map3, max, min};
use crate::scene::Scene;
use crate::scene::format::{COUNT_SHIFT, LeafBlock};
use crate::shape::{Ray, Shear, Slabs, Triangle};
use crate::simd::{Kernel, Lanes, RayKernel, Runs, Simd};

/// Visits the triangles of a mesh for the nearest hit, or for any.
pub(super) struct InMesh<'r, 'a, const W: usize, S> {
    goal: S,
    leaves: Leaves<'a, W>,
    ray: &'r Ray,
    slabs: &'r Slabs,
    /// The ray's shear, computed at the first leaf: most rays meet none.
    shear: Option<Shear>,
    /// Least distance of a hit: where the ray enters the instance's box.
    start: f32,
    limit: f32,
    pub(super) best: MeshHit,
}

impl<'r, 'a, const W: usize, S: Goal> InMesh<'r, 'a, W, S> {
    #[inline(always)]
    pub(super) fn new(
        goal: S,
        mesh: &MeshView<'a, W>,
        ray: &'r Ray,
        slabs: &'r Slabs,
        (start, limit): (f32, f32),
    ) -> Self {
        Self {
            goal,
            leaves: mesh.leaves,
            ray,
            slabs,
            shear: None,
            start,
            limit,
            best: MeshHit::NONE,
        }
    }

    /// Keeps a hit within the limit. True ends the search.
    #[inline(always)]
    fn accept(&mut self, hit: MeshHit) -> bool {
        self.best.take_nearer(hit);
        self.limit = min(self.limit, self.best.t);
        self.goal.is_any()
    }

    #[inline(always)]
    fn shear(&mut self) -> Shear {
        match self.shear {
            Some(shear) => shear,
            None => *self.shear.insert(Shear::new(self.ray)),
        }
    }

    /// Returns a leaf of numbers, a triangle at a time, which is faster than gathering lanes.
    #[inline(always)]
    fn one_by_one(&mut self, leaf: u32) -> bool {
        let Some(triangles) = self.leaves.leaf(leaf) else {
            return false;
        };
        let shear = self.shear();
        for (lane, &triangle) in (0..).zip(triangles.ids) {
            // Empty lanes come last.
            let Some(corners) = self.leaves.corners(triangle) else {
                break;
            };
            let t = Triangle::distance(corners, &shear, self.slabs, self.limit);
            let Some(t) = t.map(|t| max(t, self.start)).filter(|&t| t <= self.limit) else {
                continue;
            };
            let hit = MeshHit {
                t,
                triangle,
                leaf,
                lane,
            };
            if self.accept(hit) {
                return true;
            }
        }
        false
    }
}

/// Returns the nearest of the lanes whose edge functions vanished, decided exactly. Takes values: a
/// reference to the search would keep it in memory.
#[cold]
#[inline(never)]
fn nearest_exactly<const W: usize>(
    block: &LeafBlock<W>,
    mut lanes: u32,
    leaf: u32,
    shear: Shear,
    slabs: Slabs,
    start: f32,
) -> MeshHit {
    let mut best = MeshHit::NONE;
    while lanes != 0 {
        let lane = lanes.trailing_zeros();
        lanes &= lanes - 1;
        let triangle = block.triangle(lane);
        let t = triangle.exact_distance(&shear);
        if let Some(t) = t.and_then(|t| triangle.clamp_to_box(t, &slabs)) {
            best.take_nearer(MeshHit {
                t: max(t, start),
                triangle: block.ids[lane as usize & (W - 1)],
                leaf,
                lane,
            });
        }
    }
    best
}

/// [`Slabs::interval`] of the box of each of a block's triangles.
#[inline(always)]
fn box_interval<const W: usize, L: Lanes<W>>(
    l: L,
    block: &LeafBlock<W>,
    slabs: &Slabs,
) -> (L::F, L::F) {
    let (near_x, far_x) = axis_interval(l, block, slabs, 0);
    let (near_y, far_y) = axis_interval(l, block, slabs, 1);
    let (near_z, far_z) = axis_interval(l, block, slabs, 2);
    (
        l.greater(l.greater(near_x, near_y), near_z),
        l.lesser(l.lesser(far_x, far_y), far_z),
    )
}

#[inline(always)]
fn axis_interval<const W: usize, L: Lanes<W>>(
    l: L,
    block: &LeafBlock<W>,
    slabs: &Slabs,
    axis: usize,
) -> (L::F, L::F) {
    let a = l.load(&block.corners[0][axis]);
    let b = l.load(&block.corners[1][axis]);
    let c = l.load(&block.corners[2][axis]);
    let low = l.lesser(l.lesser(a, b), c);
    let high = l.greater(l.greater(a, b), c);
    let (reciprocal, near, far) = slabs.coefficients(axis);
    let (first, last) = if slabs.is_negative(axis) {
        (high, low)
    } else {
        (low, high)
    };
    let reciprocal = l.splat(reciprocal);
    (
        l.sub(l.mul(first, reciprocal), l.splat(near)),
        l.sub(l.mul(last, reciprocal), l.splat(far)),
    )
}

impl<const W: usize, S: Goal> Visitor<W> for InMesh<'_, '_, W, S> {
    #[inline(always)]
    fn limit(&self) -> f32 {
        self.limit
    }

    /// [`Triangle::intersect`] on all lanes of a block, or one by one without blocks.
    #[inline(always)]
    fn leaf<L: Lanes<W>>(&mut self, l: L, child: u32, _near: f32, path: &mut Path<'_>) -> bool {
        if !path.take(u64::from((child >> COUNT_SHIFT & 7) + 1)) {
            return false;
        }
        let leaf = leaf_index(child);
        if W == 4 {
            return self.one_by_one(leaf);
        }
        let Some(block) = self.leaves.block(leaf) else {
            return false;
        };
        let shear = self.shear();
        // 0 to 2; the remainder tells the compiler without a branch.
        let [kx, ky, kz] = map3(shear.axes, |axis| axis.min(2));
        let [sx, sy, sz] = map3(shear.factors, |s| l.splat(s));
        let [ox, oy, oz] = map3(shear.origin, |o| l.splat(o));
        let component =
            |corner: usize, axis: usize, o: L::F| l.sub(l.load(&block.corners[corner][axis]), o);
        let az = component(0, kz, oz);
        let bz = component(1, kz, oz);
        let cz = component(2, kz, oz);
        let ax = l.sub(component(0, kx, ox), l.mul(sx, az));
        let ay = l.sub(component(0, ky, oy), l.mul(sy, az));
        let bx = l.sub(component(1, kx, ox), l.mul(sx, bz));
        let by = l.sub(component(1, ky, oy), l.mul(sy, bz));
        let cx = l.sub(component(2, kx, ox), l.mul(sx, cz));
        let cy = l.sub(component(2, ky, oy), l.mul(sy, cz));
        let u = l.sub(l.mul(cx, by), l.mul(cy, bx));
        let v = l.sub(l.mul(ax, cy), l.mul(ay, cx));
        let w = l.sub(l.mul(bx, ay), l.mul(by, ax));
        let zero = l.splat(0.0);
        let least = l.min(u, l.min(v, w));
        let most = l.max(u, l.max(v, w));
        let inside = l.or(l.le(zero, least), l.le(most, zero));
        let inside_bits = l.bits(inside);
        if inside_bits == 0 {
            return false;
        }
        let vanished = l.or(l.eq(least, zero), l.eq(most, zero));
        let exactly = l.bits(l.and(inside, vanished));
        let determinant = l.add(l.add(u, v), w);
        let weighted = l.add(l.add(l.mul(u, az), l.mul(v, bz)), l.mul(w, cz));
        let t = l.mul(l.div(weighted, determinant), sz);
        let limit = l.splat(self.limit);
        let in_range = l.and(l.le(zero, t), l.le(t, limit));
        let hits = l.and(inside, in_range);
        if l.bits(hits) & !exactly != 0 {
            // Triangle::clamp_to_box, and the instance's own box.
            let (near, far) = box_interval(l, block, self.slabs);
            let t = l.max(l.add(l.max(near, t), zero), l.splat(self.start));
            let hits = l.and(hits, l.and(l.le(zero, far), l.le(t, limit)));
            let mut lanes = l.bits(hits) & !exactly;
            let t = l.store(t);
            while lanes != 0 {
                let lane = lanes.trailing_zeros();
                lanes &= lanes - 1;
                let hit = MeshHit {
                    t: t[lane as usize & (W - 1)],
                    triangle: block.ids[lane as usize & (W - 1)],
                    leaf,
                    lane,
                };
                if self.accept(hit) {
                    return true;
                }
            }
        }
        if exactly != 0 {
            let hit = nearest_exactly(block, exactly, leaf, shear, *self.slabs, self.start);
            return hit.t <= self.limit && hit.triangle != u32::MAX && self.accept(hit);
        }
        false
    }
}

/// Traces rays against one mesh in its own frame: for benchmarks and tests
/// of intersection, and for tools that have no scene around their mesh.
#[derive(Debug, Clone, Copy)]
pub struct MeshTracer<'a, const W: usize = 8> {
    mesh: MeshView<'a, W>,
    simd: Simd,
}

struct SearchMesh<'r, 'a, const W: usize, S> {
    goal: S,
    mesh: &'r MeshView<'a, W>,
    stack: &'r mut TraversalStack,
}

impl<const W: usize, S: Goal> RayKernel<W> for SearchMesh<'_, '_, W, S> {
    type Output = (MeshHit, Work);
    #[inline(always)]
    fn run<L: Lanes<W>>(self, lanes: L, ray: &Ray) -> (MeshHit, Work) {
        let slabs = Slabs::new(ray, self.mesh.extent);
        let mut search = InMesh::new(self.goal, self.mesh, ray, &slabs, (0.0, f32::INFINITY));
        let mut path = Path::new(self.stack, u64::MAX);
        let (nodes, root) = (self.mesh.nodes, self.mesh.root);
        walk(lanes, nodes, root, &slabs, &mut search, &mut path);
        (search.best, path.work())
    }
}

/// Rays one after the other, by code of one instruction set from the first to the last.
struct SearchEach<'r, 'a, const W: usize, S, R, T> {
    goal: S,
    mesh: &'r MeshView<'a, W>,
    rays: R,
    stack: &'r mut TraversalStack,
    take: T,
}

impl<const W: usize, S, R, T> Kernel<W> for SearchEach<'_, '_, W, S, R, T>
where
    S: Goal,
    R: Iterator<Item = Option<Ray>>,
    T: FnMut(Option<MeshHit>),
{
    type Output = u64;

    #[inline(always)]
    fn run<L: Lanes<W>>(mut self, lanes: L) -> u64 {
        let mut steps: u64 = 0;
        for ray in self.rays {
            // Not a closure: one that is not inlined is compiled without the kernel's
            // instruction set.
            let hit = match ray {
                Some(ray) => {
                    let search = SearchMesh {
                        goal: self.goal,
                        mesh: self.mesh,
                        stack: &mut *self.stack,
                    };
                    let (hit, work) = search.run(lanes, &ray);
                    steps = steps.wrapping_add(work.steps);
                    hit
                }
                None => MeshHit::NONE,
            };
            (self.take)((hit.triangle != u32::MAX).then_some(hit));
        }
        steps
    }
}

impl<'a, const W: usize> MeshTracer<'a, W>
where
    Simd: Runs<W>,
{
    /// Returns a tracer for mesh number `mesh` of the scene; `None` if the scene has no such mesh.
    pub fn new(scene: &Scene<'a, W>, mesh: usize, simd: Simd) -> Option<Self> {
        let mesh = MeshView::new(scene, scene.meshes.get(mesh)?);
        Some(Self { mesh, simd })
    }

    /// Returns the nearest triangle and the number of steps it took to find it: one
    /// a node visited, one a triangle tested.
    #[inline]
    pub fn nearest(&self, ray: &Ray, stack: &mut TraversalStack) -> (Option<MeshHit>, u64) {
        let (hit, work) = self.search(Nearest, ray, stack);
        ((hit.triangle != u32::MAX).then_some(hit), work.steps)
    }

    /// Returns whether there is any triangle along the ray, and the number of steps: at most those
    /// of [`nearest`](Self::nearest), because the first hit ends the search.
    #[inline]
    pub fn any(&self, ray: &Ray, stack: &mut TraversalStack) -> (bool, u64) {
        let (hit, work) = self.search(Any, ray, stack);
        (hit.triangle != u32::MAX, work.steps)
    }

    #[inline(always)]
    fn search<S: Goal>(&self, goal: S, ray: &Ray, stack: &mut TraversalStack) -> (MeshHit, Work) {
        let mesh = &self.mesh;
        let search = SearchMesh { goal, mesh, stack };
        self.simd.run_along(ray, search)
    }

    /// Calls `take` for each ray, in order, with its nearest triangle, and returns the number of
    /// steps of all; faster than a call of [`nearest`](Self::nearest) for each.
    #[inline]
    pub fn nearest_of_each(
        &self,
        rays: impl Iterator<Item = Option<Ray>>,
        stack: &mut TraversalStack,
        take: impl FnMut(Option<MeshHit>),
    ) -> u64 {
        self.each(Nearest, rays, stack, take)
    }

    /// Calls `take` for each ray, in order, with whether it meets any triangle, and returns the
    /// number of steps of all: see [`any`](Self::any).
    #[inline]
    pub fn any_of_each(
        &self,
        rays: impl Iterator<Item = Option<Ray>>,
        stack: &mut TraversalStack,
        mut take: impl FnMut(bool),
    ) -> u64 {
        self.each(Any, rays, stack, |hit| take(hit.is_some()))
    }

    #[inline(always)]
    fn each<S: Goal>(
        &self,
        goal: S,
        rays: impl Iterator<Item = Option<Ray>>,
        stack: &mut TraversalStack,
        take: impl FnMut(Option<MeshHit>),
    ) -> u64 {
        let mesh = &self.mesh;
        let search = SearchEach {
            goal,
            mesh,
            rays,
            stack,
            take,
        };
        self.simd.run(search)
    }

    /// Returns the nearest triangles for the rays of a tile, as [`nearest`](Self::nearest) finds
    /// them, and the number of steps: one for all rays that go together.
    #[inline]
    pub fn nearest_of_tile(&self, rays: &TileRays, stack: &mut TraversalStack) -> (TileHits, u64) {
        let mut hits = TileHits::NONE;
        let work = <Simd as Runs<8>>::run(
            self.simd,
            TileInMeshSearch::<W> {
                mesh: &self.mesh,
                rays,
                hits: &mut hits,
                stack: &mut *stack,
            },
        );
        if let Some(work) = work {
            return (hits, work.steps);
        }
        let mut steps = 0;
        for (group, lane) in (0..8).flat_map(|group| (0..8).map(move |lane| (group, lane))) {
            let Some(ray) = rays.ray(group, lane) else {
                continue;
            };
            let (hit, work) = self.nearest(&ray, stack);
            steps += work;
            if let Some(on) = hit {
                hits.set(group, lane, Hit { instance: 0, on });
            }
        }
        (hits, steps)
    }
}
