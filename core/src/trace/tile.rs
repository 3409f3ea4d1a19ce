//! Blocks of 64 rays from one eye, through the scene together.
//!
//! One interval test a node discards the children that no ray of the block can
//! enter; those left are tested by eight rays at a time. Every ray's own test
//! is the one that it would take alone, so its hit is the same, bit for bit;
//! only culling is coarser, and conservatively so.
//!
//! Rays go together only where their directions have the same signs and, in
//! the frame of a mesh, the same main axis. Instances in whose frame they do
//! not, and shapes that are not meshes, are put on a list and traced ray by
//! ray afterwards, which changes nothing: the nearest hit does not depend on
//! the order of visit.

use super::hit::{Hit, MeshHit};
use super::stack::{TraversalStack, Work};
use super::walk::leaf_index;
use super::world::map_point;
use crate::numeric::{UNIT_ROUNDOFF, largest_magnitude, map3, max, min};
use crate::scene::Scene;
use crate::scene::format::{COUNT_SHIFT, Instance, LEAF, LeafBlock, Node, kind};
use crate::shape::{Ray, Shear, Slabs, Triangle};
use crate::simd::{Kernel, Lanes};
use glam::Vec3;
use heapless::Vec;

/// Groups of a tile, and rays of a group.
const EIGHT: usize = 8;

/// One number for each ray: by group, then lane.
type PerRay = [[f32; EIGHT]; EIGHT];

/// 8×8 rays from one point, by column and row.
#[derive(Debug, Clone)]
pub struct TileRays {
    origin: Vec3,
    direction: [PerRay; 3],
}

/// Group and lane of a place in the tile: a group is four columns wide and
/// two rows high, so that its rays are close together.
#[inline(always)]
const fn place(column: usize, row: usize) -> (usize, usize) {
    ((row & 6) | (column >> 2 & 1), (row & 1) << 2 | (column & 3))
}

impl TileRays {
    /// Rays from `origin` along `direction(column, row)`, each from 0 to 7.
    #[inline(always)]
    pub fn new(origin: Vec3, mut direction: impl FnMut(usize, usize) -> Vec3) -> Self {
        let mut rays = Self {
            origin,
            direction: [[[0.0; EIGHT]; EIGHT]; 3],
        };
        for row in 0..EIGHT {
            for column in 0..EIGHT {
                let (group, lane) = place(column, row);
                let components = direction(column, row).to_array();
                for (rows, component) in rays.direction.iter_mut().zip(components) {
                    rows[group][lane] = component;
                }
            }
        }
        rays
    }

    /// The ray at a place, or `None` where it cannot be traced.
    #[inline(always)]
    pub fn at(&self, column: usize, row: usize) -> Option<Ray> {
        let (group, lane) = place(column, row);
        self.ray(group, lane)
    }

    #[inline(always)]
    pub(super) fn ray(&self, group: usize, lane: usize) -> Option<Ray> {
        let [x, y, z] = &self.direction;
        let (g, l) = (group % EIGHT, lane % EIGHT);
        Ray::new(self.origin, Vec3::new(x[g][l], y[g][l], z[g][l]))
    }
}

/// Instances to be traced ray by ray: number and the groups that reach it.
pub(super) type Deferred = Vec<(u32, u8), 16>;

/// What the rays of a tile have found.
#[derive(Debug, Clone)]
pub struct TileHits {
    t: PerRay,
    triangle: [[u32; EIGHT]; EIGHT],
    leaf: [[u32; EIGHT]; EIGHT],
    lane: [[u8; EIGHT]; EIGHT],
    instance: [[u32; EIGHT]; EIGHT],
    /// The farthest hit of each group.
    limit: [f32; EIGHT],
    pub(super) deferred: Deferred,
}

impl TileHits {
    pub(super) const NONE: Self = Self {
        t: [[f32::INFINITY; EIGHT]; EIGHT],
        triangle: [[u32::MAX; EIGHT]; EIGHT],
        leaf: [[u32::MAX; EIGHT]; EIGHT],
        lane: [[0; EIGHT]; EIGHT],
        instance: [[u32::MAX; EIGHT]; EIGHT],
        limit: [f32::INFINITY; EIGHT],
        deferred: Vec::new(),
    };

    /// The nearest hit of the ray at a place, columns and rows from 0 to 7.
    #[inline(always)]
    pub fn at(&self, column: usize, row: usize) -> Option<Hit> {
        let (group, lane) = place(column, row);
        let hit = self.get(group, lane);
        (hit.instance != u32::MAX).then_some(hit)
    }

    #[inline(always)]
    pub(super) fn get(&self, group: usize, lane: usize) -> Hit {
        let (g, l) = (group % EIGHT, lane % EIGHT);
        Hit {
            instance: self.instance[g][l],
            on: MeshHit {
                t: self.t[g][l],
                triangle: self.triangle[g][l],
                leaf: self.leaf[g][l],
                lane: u32::from(self.lane[g][l]),
            },
        }
    }

    /// Takes a hit where it is nearer by (t, instance, triangle).
    #[inline(always)]
    fn take_nearer(&mut self, group: usize, lane: usize, hit: Hit) {
        let (g, l) = (group % EIGHT, lane % EIGHT);
        let t = self.t[g][l];
        if hit.on.t < t
            || (hit.on.t == t
                && (hit.instance, hit.on.triangle) < (self.instance[g][l], self.triangle[g][l]))
        {
            self.t[g][l] = hit.on.t;
            self.triangle[g][l] = hit.on.triangle;
            self.leaf[g][l] = hit.on.leaf;
            self.lane[g][l] = hit.on.lane as u8;
            self.instance[g][l] = hit.instance;
        }
    }

    pub(super) fn set(&mut self, group: usize, lane: usize, hit: Hit) {
        self.t[group % EIGHT][lane % EIGHT] = f32::INFINITY;
        self.instance[group % EIGHT][lane % EIGHT] = u32::MAX;
        self.triangle[group % EIGHT][lane % EIGHT] = u32::MAX;
        self.take_nearer(group, lane, hit);
    }

    #[inline(always)]
    fn update_limit(&mut self, group: usize) {
        let g = group % EIGHT;
        self.limit[g] = self.t[g].into_iter().fold(0.0, max);
    }
}

/// [`Slabs`] of all rays of a tile, and the interval that they span.
struct TileSlabs {
    origin: [f32; 3],
    reciprocal: [PerRay; 3],
    near: [PerRay; 3],
    far: [PerRay; 3],
    negative: [usize; 3],
    /// Per axis the least and the greatest reciprocal, and what the interval
    /// test widens boxes by.
    interval: [(f32, f32, f32); 3],
}

impl TileSlabs {
    /// `None` where the signs of the directions differ, or one is zero.
    #[inline(always)]
    fn new<L: Lanes<EIGHT>>(l: L, rays: &TileRays, extent: f32) -> Option<Self> {
        let o = rays.origin;
        let delta = Slabs::SLACK * UNIT_ROUNDOFF * max(extent, largest_magnitude(o));
        let zero = l.splat(0.0);
        let mut slabs = Self {
            origin: o.to_array(),
            reciprocal: [[[0.0; EIGHT]; EIGHT]; 3],
            near: [[[0.0; EIGHT]; EIGHT]; 3],
            far: [[[0.0; EIGHT]; EIGHT]; 3],
            negative: [0; 3],
            interval: [(0.0, 0.0, 0.0); 3],
        };
        for axis in 0..3 {
            let mut positive = 0xff;
            let mut negative = 0xff;
            for direction in &rays.direction[axis] {
                let direction = l.load(direction);
                positive &= !l.bits(l.le(direction, zero));
                negative &= !l.bits(l.le(zero, direction));
            }
            // Not a comparison of signs: zeros of either sign fail both.
            slabs.negative[axis] = match (positive & 0xff, negative & 0xff) {
                (0xff, _) => 0,
                (_, 0xff) => 1,
                _ => return None,
            };
        }
        let magnitude = |axis: usize, x: L::F| {
            if slabs.negative[axis] == 0 {
                x
            } else {
                l.sub(zero, x)
            }
        };
        let mut extremes = [(l.splat(f32::INFINITY), l.splat(f32::NEG_INFINITY)); 3];
        for group in 0..EIGHT {
            let d = map3([0, 1, 2], |axis: usize| {
                l.load(&rays.direction[axis][group])
            });
            let m = map3([0, 1, 2], |axis: usize| magnitude(axis, d[axis]));
            let largest = l.max(m[0], l.max(m[1], m[2]));
            let least = l.max(
                l.mul(largest, l.splat(1.0e-18)),
                l.splat(Slabs::LEAST_COMPONENT),
            );
            for axis in 0..3 {
                let clamped = magnitude(axis, l.max(m[axis], least));
                let reciprocal = l.div(l.splat(1.0), clamped);
                let centre = l.mul(l.splat(slabs.origin[axis]), reciprocal);
                let slack = l.mul(magnitude(axis, reciprocal), l.splat(delta));
                slabs.reciprocal[axis][group] = l.store(reciprocal);
                slabs.near[axis][group] = l.store(l.add(centre, slack));
                slabs.far[axis][group] = l.store(l.sub(centre, slack));
                let (low, high) = extremes[axis];
                extremes[axis] = (l.min(low, reciprocal), l.max(high, reciprocal));
            }
        }
        for axis in 0..3 {
            let (low, high) = extremes[axis];
            let low = l.store(low).into_iter().fold(f32::INFINITY, min);
            let high = l.store(high).into_iter().fold(f32::NEG_INFINITY, max);
            // Twice a ray's own slack: here the origin is subtracted first,
            // whose rounding a ray's own test does not have.
            let slack = 2.0 * delta * max(high, -low);
            slabs.interval[axis] = (low, high, slack);
        }
        Some(slabs)
    }

    #[inline(always)]
    fn octant(&self) -> usize {
        self.negative[0] | self.negative[1] << 1 | self.negative[2] << 2
    }

    /// Near and far distance of a box for the rays of a group, not clipped.
    #[inline(always)]
    fn of_group<L: Lanes<EIGHT>>(
        &self,
        l: L,
        group: usize,
        near: [f32; 3],
        far: [f32; 3],
    ) -> (L::F, L::F) {
        let g = group % EIGHT;
        let at = |plane: f32, axis: usize, offset: &[PerRay; 3]| {
            let reciprocal = l.load(&self.reciprocal[axis][g]);
            l.sub(l.mul(l.splat(plane), reciprocal), l.load(&offset[axis][g]))
        };
        let near = |axis: usize| at(near[axis], axis, &self.near);
        let far = |axis: usize| at(far[axis], axis, &self.far);
        (
            l.max(l.max(near(0), near(1)), near(2)),
            l.min(l.min(far(0), far(1)), far(2)),
        )
    }

    /// Least and greatest corner as nearer and farther planes.
    #[inline(always)]
    fn planes(&self, low: [f32; 3], high: [f32; 3]) -> ([f32; 3], [f32; 3]) {
        let pick = |axis: usize, far: usize| {
            if self.negative[axis] == far {
                low[axis]
            } else {
                high[axis]
            }
        };
        (
            map3([0, 1, 2], |a| pick(a, 0)),
            map3([0, 1, 2], |a| pick(a, 1)),
        )
    }
}

/// What to do at the leaves of a tree that some groups of a tile enter.
trait TileVisitor {
    /// The farthest hit of each group.
    fn hits(&mut self) -> &mut TileHits;
    /// Looks into a leaf.
    fn leaf<L: Lanes<EIGHT>>(
        &mut self,
        l: L,
        child: u32,
        groups: u8,
        stack: &mut TraversalStack,
        top: usize,
        work: &mut Work,
    );
}

/// A node's planes as eight lanes, those past its width empty.
#[inline(always)]
fn widened<const W: usize>(planes: &[[f32; W]; 6], plane: usize) -> [f32; EIGHT] {
    let empty = if plane & 1 == 0 {
        f32::INFINITY
    } else {
        f32::NEG_INFINITY
    };
    let mut lanes = [empty; EIGHT];
    for (lane, &value) in lanes.iter_mut().zip(&planes[plane % 6]) {
        *lane = value;
    }
    lanes
}

#[inline(always)]
#[allow(clippy::too_many_arguments)]
fn walk_tile<const W: usize, L: Lanes<EIGHT>, V: TileVisitor>(
    l: L,
    nodes: &[Node<W>],
    root: u32,
    slabs: &TileSlabs,
    groups: u8,
    visitor: &mut V,
    stack: &mut TraversalStack,
    base: usize,
    work: &mut Work,
) {
    let octant = slabs.octant();
    let zero = l.splat(0.0);
    let interval = map3(slabs.interval, |(low, high, slack)| {
        (l.splat(low), l.splat(high), l.splat(slack))
    });
    let origin = map3(slabs.origin, |o| l.splat(o));
    let mut top = base;
    let mut current = root;
    let mut active = groups;
    loop {
        work.steps += 1;
        let Some(node) = nodes.get(current as usize) else {
            return;
        };
        let hits = visitor.hits();
        let mut limit = 0.0;
        for group in 0..EIGHT {
            if active >> group & 1 != 0 {
                limit = max(limit, hits.limit[group]);
            }
        }
        let (mut near, mut far) = (zero, l.splat(limit));
        for axis in 0..3 {
            let (low, high, slack) = interval[axis];
            let negative = slabs.negative[axis];
            let n = l.sub(
                l.load(&widened(&node.planes, 2 * axis + negative)),
                origin[axis],
            );
            let f = l.sub(
                l.load(&widened(&node.planes, 2 * axis + 1 - negative)),
                origin[axis],
            );
            let n = l.min(l.mul(n, low), l.mul(n, high));
            let f = l.max(l.mul(f, low), l.mul(f, high));
            near = l.max(near, l.sub(n, slack));
            far = l.min(far, l.add(f, slack));
        }
        let candidates = l.bits(l.le(near, far));
        if candidates != 0 {
            let near_by_lane = l.store(near);
            let order = node.order(octant);
            let bits = W.trailing_zeros();
            for place in 0..W as u32 {
                let lane = (order >> (place * bits)) as usize & (W - 1);
                if candidates >> lane & 1 == 0 {
                    continue;
                }
                let plane = |p: usize| node.planes[p % 6][lane];
                let planes = |far: usize| {
                    map3([0, 1, 2], |axis: usize| {
                        plane(2 * axis + (slabs.negative[axis] ^ far))
                    })
                };
                let (n, f) = (planes(0), planes(1));
                let mut entered = 0u8;
                for group in 0..EIGHT {
                    if active >> group & 1 == 0 {
                        continue;
                    }
                    let (near, far) = slabs.of_group(l, group, n, f);
                    let near = l.max(near, zero);
                    let far = l.min(far, l.load(&hits.t[group]));
                    entered |= u8::from(l.bits(l.le(near, far)) != 0) << group;
                }
                if entered != 0 {
                    let (Some(distance), Some(child), Some(groups)) = (
                        stack.distances.get_mut(top),
                        stack.children.get_mut(top),
                        stack.groups.get_mut(top),
                    ) else {
                        return;
                    };
                    *distance = near_by_lane[lane];
                    *child = node.child[lane];
                    *groups = entered;
                    top += 1;
                }
            }
            work.deepest = work.deepest.max(top as u32);
        }
        current = loop {
            if top == base {
                return;
            }
            top -= 1;
            let (Some(&near), Some(&child), Some(&entered)) = (
                stack.distances.get(top),
                stack.children.get(top),
                stack.groups.get(top),
            ) else {
                return;
            };
            // Hits found since may have overtaken it.
            let hits = visitor.hits();
            active = 0;
            for group in 0..EIGHT {
                let reaches = entered >> group & 1 != 0 && near <= hits.limit[group];
                active |= u8::from(reaches) << group;
            }
            if active == 0 {
                continue;
            }
            if child & LEAF == 0 {
                break child;
            }
            visitor.leaf(l, child, active, stack, top, work);
        };
    }
}

/// Against the triangles of one instance.
struct TileInMesh<'r, 'a, const W: usize> {
    leaves: &'a [LeafBlock<W>],
    rays: &'r TileRays,
    slabs: &'r TileSlabs,
    axes: [usize; 3],
    shear: [PerRay; 3],
    /// Where each ray enters the instance's box.
    start: &'r PerRay,
    instance: u32,
    hits: &'r mut TileHits,
}

impl<const W: usize> TileInMesh<'_, '_, W> {
    /// Lanes of a group whose edge functions vanished, decided exactly.
    #[cold]
    #[inline(never)]
    fn accept_exactly(&mut self, triangle: &Triangle, hit: Hit, group: usize, mut lanes: u32) {
        while lanes != 0 {
            let lane = lanes.trailing_zeros() as usize;
            lanes &= lanes - 1;
            let Some(ray) = self.rays.ray(group, lane) else {
                continue;
            };
            let shear = Shear::new(&ray);
            let Some(t) = triangle.exact_distance(&ray, &shear) else {
                continue;
            };
            let at =
                |rows: &[PerRay; 3]| map3([0, 1, 2], |axis: usize| rows[axis][group % EIGHT][lane]);
            let slabs = Slabs::from_parts(
                at(&self.slabs.reciprocal),
                at(&self.slabs.near),
                at(&self.slabs.far),
                self.slabs.negative,
            );
            if let Some(t) = triangle.clamp_to_box(t, &slabs) {
                let mut hit = hit;
                hit.on.t = max(t, self.start[group % EIGHT][lane]);
                self.hits.take_nearer(group, lane, hit);
            }
        }
        self.hits.update_limit(group);
    }
}

impl<const W: usize> TileVisitor for TileInMesh<'_, '_, W> {
    #[inline(always)]
    fn hits(&mut self) -> &mut TileHits {
        self.hits
    }

    #[inline(always)]
    fn leaf<L: Lanes<EIGHT>>(
        &mut self,
        l: L,
        child: u32,
        groups: u8,
        _stack: &mut TraversalStack,
        _top: usize,
        work: &mut Work,
    ) {
        let count = (child >> COUNT_SHIFT & 7) + 1;
        work.steps += count;
        let leaf = leaf_index(child);
        let Some(block) = self.leaves.get(leaf as usize) else {
            return;
        };
        let [kx, ky, kz] = self.axes;
        let zero = l.splat(0.0);
        for lane in 0..count {
            let triangle = block.triangle(lane);
            let corners = map3(triangle.0, |c| (c - self.rays.origin).to_array());
            let component = |corner: usize, axis: usize| l.splat(corners[corner][axis % 3]);
            let (akx, aky, az) = (component(0, kx), component(0, ky), component(0, kz));
            let (bkx, bky, bz) = (component(1, kx), component(1, ky), component(1, kz));
            let (ckx, cky, cz) = (component(2, kx), component(2, ky), component(2, kz));
            for group in 0..EIGHT {
                if groups >> group & 1 == 0 {
                    continue;
                }
                let sx = l.load(&self.shear[0][group]);
                let sy = l.load(&self.shear[1][group]);
                let ax = l.sub(akx, l.mul(sx, az));
                let ay = l.sub(aky, l.mul(sy, az));
                let bx = l.sub(bkx, l.mul(sx, bz));
                let by = l.sub(bky, l.mul(sy, bz));
                let cx = l.sub(ckx, l.mul(sx, cz));
                let cy = l.sub(cky, l.mul(sy, cz));
                let u = l.sub(l.mul(cx, by), l.mul(cy, bx));
                let v = l.sub(l.mul(ax, cy), l.mul(ay, cx));
                let w = l.sub(l.mul(bx, ay), l.mul(by, ax));
                let least = l.min(u, l.min(v, w));
                let most = l.max(u, l.max(v, w));
                let inside = l.or(l.le(zero, least), l.le(most, zero));
                let inside_bits = l.bits(inside);
                if inside_bits == 0 {
                    continue;
                }
                let hit = Hit {
                    instance: self.instance,
                    on: MeshHit {
                        t: 0.0,
                        triangle: block.ids[lane as usize & (W - 1)],
                        leaf,
                        lane,
                    },
                };
                let vanished = l.or(l.eq(least, zero), l.eq(most, zero));
                let exactly = l.bits(l.and(inside, vanished));
                let determinant = l.add(l.add(u, v), w);
                let weighted = l.add(l.add(l.mul(u, az), l.mul(v, bz)), l.mul(w, cz));
                let sz = l.load(&self.shear[2][group]);
                let t = l.mul(l.div(weighted, determinant), sz);
                let best = l.load(&self.hits.t[group]);
                let in_range = l.and(l.le(zero, t), l.le(t, best));
                let mut lanes = l.bits(l.and(inside, in_range)) & !exactly;
                if lanes != 0 {
                    // Triangle::clamp_to_box, and the instance's own box.
                    let (low, high) = triangle.bounds();
                    let (near, far) = self.slabs.planes(low.to_array(), high.to_array());
                    let (near, far) = self.slabs.of_group(l, group, near, far);
                    let clamped = l.add(l.max(near, t), zero);
                    let clamped = l.max(clamped, l.load(&self.start[group]));
                    lanes &= l.bits(l.and(l.le(zero, far), l.le(clamped, best)));
                    let clamped = l.store(clamped);
                    while lanes != 0 {
                        let ray = lanes.trailing_zeros() as usize % EIGHT;
                        lanes &= lanes - 1;
                        let mut hit = hit;
                        hit.on.t = clamped[ray];
                        self.hits.take_nearer(group, ray, hit);
                    }
                    self.hits.update_limit(group);
                }
                if exactly != 0 {
                    self.accept_exactly(&triangle, hit, group, exactly);
                }
            }
        }
    }
}

/// Against the instances of a scene.
struct TileInWorld<'r, 'a, const W: usize> {
    scene: &'r Scene<'a, W>,
    rays: &'r TileRays,
    slabs: &'r TileSlabs,
    hits: &'r mut TileHits,
}

impl<const W: usize> TileVisitor for TileInWorld<'_, '_, W> {
    #[inline(always)]
    fn hits(&mut self) -> &mut TileHits {
        self.hits
    }

    #[inline(always)]
    fn leaf<L: Lanes<EIGHT>>(
        &mut self,
        l: L,
        child: u32,
        groups: u8,
        stack: &mut TraversalStack,
        top: usize,
        work: &mut Work,
    ) {
        let number = leaf_index(child);
        let Some(instance) = self.scene.instances.get(number as usize) else {
            return;
        };
        let mesh = match instance.kind {
            kind::MESH => self.scene.meshes.get(instance.geometry as usize),
            _ => None,
        };
        let together = mesh.is_some_and(|mesh| {
            let Some(rays) = mapped(l, self.rays, instance) else {
                return false;
            };
            let Some((axes, shear)) = shears(l, &rays) else {
                return false;
            };
            let Some(slabs) = TileSlabs::new(l, &rays, mesh.extent) else {
                return false;
            };
            let (near, far) = self.slabs.planes(instance.low, instance.high);
            let mut start = [[0.0; EIGHT]; EIGHT];
            for (group, start) in start.iter_mut().enumerate() {
                let (near, far) = self.slabs.of_group(l, group, near, far);
                let (near, far) = (l.store(l.max(near, l.splat(0.0))), l.store(far));
                for (start, (near, far)) in start.iter_mut().zip(near.into_iter().zip(far)) {
                    // Alone, a ray that misses the box never looks inside:
                    // NaN fails every comparison to come.
                    *start = if near <= far { near } else { f32::NAN };
                }
            }
            work.steps += 1;
            let mut search = TileInMesh::<W> {
                leaves: self.scene.leaves,
                rays: &rays,
                slabs: &slabs,
                axes,
                shear,
                start: &start,
                instance: number,
                hits: &mut *self.hits,
            };
            walk_tile(
                l,
                self.scene.nodes,
                mesh.root,
                &slabs,
                groups,
                &mut search,
                stack,
                top,
                work,
            );
            true
        });
        if !together && self.hits.deferred.push((number, groups)).is_err() {
            // More than the list holds: merge into an entry for everything.
            self.hits.deferred.clear();
            let _ = self.hits.deferred.push((ALL_INSTANCES, u8::MAX));
        }
    }
}

/// Stands for all instances in a [`Deferred`] list that was too short.
pub(super) const ALL_INSTANCES: u32 = u32::MAX;

/// The rays in an instance's frame; `None` where one cannot be traced there.
#[inline(always)]
fn mapped<L: Lanes<EIGHT>>(l: L, rays: &TileRays, instance: &Instance) -> Option<TileRays> {
    let map = &instance.object_from_world;
    let mut inside = TileRays {
        origin: map_point(map, rays.origin),
        direction: [[[0.0; EIGHT]; EIGHT]; 3],
    };
    Ray::new(inside.origin, Vec3::X)?;
    let zero = l.splat(0.0);
    let magnitude = |x: L::F| l.max(x, l.sub(zero, x));
    for group in 0..EIGHT {
        let d = map3([0, 1, 2], |axis: usize| {
            l.load(&rays.direction[axis][group])
        });
        let d = map3([0, 1, 2], |axis: usize| {
            // The order of map_vector's sums.
            let x = l.mul(l.splat(map[0][axis]), d[0]);
            let y = l.mul(l.splat(map[1][axis]), d[1]);
            let z = l.mul(l.splat(map[2][axis]), d[2]);
            l.add(l.add(x, y), z)
        });
        let [x, y, z] = map3(d, magnitude);
        let largest = l.max(x, l.max(y, z));
        let usable = l.and(
            l.le(l.splat(Ray::SHORTEST_DIRECTION), largest),
            l.le(largest, l.splat(Ray::LONGEST_DIRECTION)),
        );
        if l.bits(usable) != 0xff {
            return None;
        }
        for axis in 0..3 {
            inside.direction[axis][group] = l.store(d[axis]);
        }
    }
    Some(inside)
}

/// The main axis that all rays share, last, and their shears; `None` where
/// they do not.
#[inline(always)]
fn shears<L: Lanes<EIGHT>>(l: L, rays: &TileRays) -> Option<([usize; 3], [PerRay; 3])> {
    let first = rays.ray(0, 0)?;
    let axes = Shear::new(&first).axes;
    let [kx, ky, kz] = axes;
    let zero = l.splat(0.0);
    let mut shear = [[[0.0; EIGHT]; EIGHT]; 3];
    for group in 0..EIGHT {
        let d = map3([kx, ky, kz], |axis| {
            l.load(&rays.direction[axis % 3][group])
        });
        let [x, y, z] = map3(d, |d| l.max(d, l.sub(zero, d)));
        // Where two are equal the first axis rules: leave those to Shear.
        if l.bits(l.or(l.le(z, x), l.le(z, y))) != 0 {
            return None;
        }
        shear[0][group] = l.store(l.div(d[0], d[2]));
        shear[1][group] = l.store(l.div(d[1], d[2]));
        shear[2][group] = l.store(l.div(l.splat(1.0), d[2]));
    }
    Some((axes, shear))
}

/// All rays of a tile through a scene.
pub(super) struct TileSearch<'r, 'a, const W: usize> {
    pub(super) scene: &'r Scene<'a, W>,
    pub(super) rays: &'r TileRays,
    pub(super) hits: &'r mut TileHits,
    pub(super) stack: &'r mut TraversalStack,
}

impl<const W: usize> Kernel<EIGHT> for TileSearch<'_, '_, W> {
    /// `None` where the rays cannot go together.
    type Output = Option<Work>;

    #[inline(always)]
    fn run<L: Lanes<EIGHT>>(self, l: L) -> Option<Work> {
        let mut work = Work::default();
        let slabs = TileSlabs::new(l, self.rays, self.scene.header.extent)?;
        let mut visitor = TileInWorld::<W> {
            scene: self.scene,
            rays: self.rays,
            slabs: &slabs,
            hits: self.hits,
        };
        walk_tile(
            l,
            self.scene.nodes,
            self.scene.header.root,
            &slabs,
            u8::MAX,
            &mut visitor,
            self.stack,
            0,
            &mut work,
        );
        Some(work)
    }
}

/// All rays of a tile against one mesh in its own frame.
pub(super) struct TileInMeshSearch<'r, 'a, const W: usize> {
    pub(super) nodes: &'a [Node<W>],
    pub(super) leaves: &'a [LeafBlock<W>],
    pub(super) root: u32,
    pub(super) extent: f32,
    pub(super) rays: &'r TileRays,
    pub(super) hits: &'r mut TileHits,
    pub(super) stack: &'r mut TraversalStack,
}

impl<const W: usize> Kernel<EIGHT> for TileInMeshSearch<'_, '_, W> {
    type Output = Option<Work>;

    #[inline(always)]
    fn run<L: Lanes<EIGHT>>(self, l: L) -> Option<Work> {
        let mut work = Work::default();
        let (axes, shear) = shears(l, self.rays)?;
        let slabs = TileSlabs::new(l, self.rays, self.extent)?;
        let mut search = TileInMesh::<W> {
            leaves: self.leaves,
            rays: self.rays,
            slabs: &slabs,
            axes,
            shear,
            start: &[[0.0; EIGHT]; EIGHT],
            instance: 0,
            hits: self.hits,
        };
        walk_tile(
            l,
            self.nodes,
            self.root,
            &slabs,
            u8::MAX,
            &mut search,
            self.stack,
            0,
            &mut work,
        );
        Some(work)
    }
}
