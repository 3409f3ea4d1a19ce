//! Eight rays, each with its own start, through a scene together.
//!
//! A scene whose instances are all children of one node is tested once for eight neighbouring
//! rays, spheroids by eight rays at a time, and meshes ray by ray. Every ray's own test is the
//! one that it would take alone, so its hit is the same, bit for bit.

use super::graticule;
use super::hit::{Hit, MeshHit};
use super::map::map_component;
use super::walk::leaf_index;
use super::workspace::{Pixel, Workspace};
use crate::numeric::{SQUARABLE, UNIT_ROUNDOFF, map3};
use crate::scene::Scene;
use crate::scene::format::{Instance, LEAF, Material, NO_MATERIAL, Node, effect, kind};
use crate::shape::{Ray, Slabs, Spheroid};
use crate::simd::{Kernel, Lanes};
use glam::Vec3;

/// Rays of a row.
const EIGHT: usize = 8;

/// Eight rays, by the components of their starts and directions.
pub(crate) struct RowRays<'r> {
    pub(crate) origins: &'r [[f32; EIGHT]; 3],
    pub(crate) directions: &'r [[f32; EIGHT]; 3],
    /// A bit for each that is to be traced: a ray that can be.
    pub(crate) active: u32,
}

/// What eight rays have met.
pub(crate) struct RowHits {
    pub(super) hits: [Hit; EIGHT],
    /// Meshes that rays may meet, and a bit for each ray.
    pub(super) meshes: heapless::Vec<(u32, u32), EIGHT>,
    /// A bit for each ray that has met a surface between its lines.
    pub(super) between: u32,
    /// Nodes and spheroids.
    pub(super) steps: u64,
}

impl RowHits {
    /// Returns what a ray sees that has met a surface between its lines.
    #[inline]
    pub(crate) fn between_lines(&self, lane: usize, workspace: &mut Workspace) -> Option<Pixel> {
        (self.between >> (lane % EIGHT) & 1 != 0).then(|| {
            workspace.statistics.primary += 1;
            Pixel::new(Vec3::ZERO, 1.0)
        })
    }

    pub(crate) fn are_none(&self) -> bool {
        self.hits.iter().all(|hit| hit.instance == u32::MAX)
    }

    #[inline]
    pub(crate) fn at(&self, lane: usize) -> Option<Hit> {
        let hit = self.hits[lane % EIGHT];
        (hit.instance != u32::MAX).then_some(hit)
    }

    /// Keeps the nearer hits, by the rules of a single ray.
    #[inline(always)]
    fn take_nearer(&mut self, instance: u32, t: &[f32; EIGHT], first: u32, hit: u32) {
        for (lane, best) in self.hits.iter_mut().enumerate() {
            let t = t[lane % EIGHT];
            let nearer = t < best.on.t || (t == best.on.t && instance < best.instance);
            if hit >> lane & 1 != 0 && nearer {
                *best = Hit {
                    instance,
                    on: MeshHit {
                        t,
                        triangle: 1 - (first >> lane & 1),
                        leaf: 0,
                        lane: 0,
                    },
                };
            }
        }
    }
}

/// Searches the instances of a scene; `None` unless they are all children of one node and no
/// ray is square to an axis.
pub(super) struct RowSearch<'r, 'a, const W: usize> {
    pub(super) scene: &'r Scene<'a, W>,
    pub(super) rays: &'r RowRays<'r>,
}

impl<const W: usize> Kernel<EIGHT> for RowSearch<'_, '_, W> {
    type Output = Option<RowHits>;

    #[inline(always)]
    fn run<L: Lanes<EIGHT>>(self, l: L) -> Option<RowHits> {
        let node = self.scene.top.get(self.scene.header.root as usize)?;
        let used = |lane: usize| !node.is_empty_lane(lane);
        if (0..W).any(|lane| used(lane) && node.child[lane % W] & LEAF == 0) {
            return None;
        }
        let [ox, oy, oz] = self.rays.origins;
        let [dx, dy, dz] = self.rays.directions;
        let origin = [l.load(ox), l.load(oy), l.load(oz)];
        let direction = [l.load(dx), l.load(dy), l.load(dz)];
        let slabs = RowSlabs::new(l, origin, direction, self.scene.extent)?;
        let mut found = RowHits {
            hits: [Hit::NONE; EIGHT],
            meshes: heapless::Vec::new(),
            between: 0,
            steps: 1,
        };
        let mut best = l.splat(f32::INFINITY);
        for lane in (0..W).filter(|&lane| used(lane)) {
            let (near, far) = slabs.interval(l, node, lane);
            let far = l.min(far, best);
            let entering = l.bits(l.le(near, far)) & self.rays.active;
            let number = leaf_index(node.child[lane % W]);
            let Some(instance) = self.scene.instances.get(number as usize) else {
                continue;
            };
            if entering == 0 {
                continue;
            }
            if instance.kind == kind::MESH {
                // As many as there are children.
                let _ = found.meshes.push((number, entering));
                continue;
            }
            found.steps += 1;
            let (t, first, hit) = on_spheroid(l, instance, origin, direction, near);
            let hit = l.bits(l.and(hit, l.le(t, best))) & entering;
            if hit == 0 {
                continue;
            }
            found.take_nearer(number, &l.store(t), l.bits(first), hit);
            best = l.load(&distances(&found.hits));
        }
        Some(found)
    }
}

/// Rays that all meet one spheroid with lines, and nothing else: a bit for each between lines.
pub(super) struct OnLines<'f> {
    rays: &'f RowRays<'f>,
    instance: &'f Instance,
    material: &'f Material,
    hits: &'f [Hit; EIGHT],
    /// A bit for each ray that meets it.
    met: u32,
}

impl RowHits {
    /// Returns where all rays that hit anything meet one spheroid with lines.
    #[inline]
    pub(super) fn on_lines<'f, const W: usize>(
        &'f self,
        scene: &Scene<'f, W>,
        rays: &'f RowRays<'f>,
    ) -> Option<OnLines<'f>> {
        if !self.meshes.is_empty() {
            return None;
        }
        let mut number = u32::MAX;
        let mut met = 0;
        for (lane, hit) in self.hits.iter().enumerate() {
            if hit.instance != u32::MAX {
                if number != u32::MAX && number != hit.instance {
                    return None;
                }
                number = hit.instance;
                met |= 1 << lane;
            }
        }
        let instance = scene.instances.get(number as usize)?;
        let material = scene.materials.get(instance.material as usize)?;
        let lines = material.effects & effect::GRATICULE != 0;
        (lines && instance.material != NO_MATERIAL).then_some(OnLines {
            rays,
            instance,
            material,
            hits: &self.hits,
            met,
        })
    }
}

impl Kernel<EIGHT> for OnLines<'_> {
    type Output = u32;

    #[inline(always)]
    fn run<L: Lanes<EIGHT>>(self, l: L) -> u32 {
        let instance = self.instance;
        let load = |[x, y, z]: &[[f32; EIGHT]; 3]| [l.load(x), l.load(y), l.load(z)];
        let map = &instance.object_from_world;
        let o = point(l, map, load(self.rays.origins));
        let d = vector(l, map, load(self.rays.directions));
        let t = l.load(&distances(self.hits));
        let at = [
            l.add(o[0], l.mul(d[0], t)),
            l.add(o[1], l.mul(d[1], t)),
            l.add(o[2], l.mul(d[2], t)),
        ];
        // Spheroid::project.
        let scale = radii(l, instance);
        let scaled = quotient(l, at, scale);
        let largest = largest(l, scaled);
        let usable = l.and(
            l.le(l.splat(*SQUARABLE.start()), largest),
            l.le(largest, l.splat(*SQUARABLE.end())),
        );
        let length = l.sqrt(dot(l, scaled, scaled));
        let unit = quotient(l, scaled, [length; 3]);
        let point = product(l, unit, scale);
        let lines = graticule::are_on_lines(l, point, self.material);
        self.met & l.bits(usable) & !l.bits(lines)
    }
}

/// Returns hit distances; infinity for a miss.
#[inline(always)]
fn distances(hits: &[Hit; EIGHT]) -> [f32; EIGHT] {
    let mut distances = [0.0; EIGHT];
    for (distance, hit) in distances.iter_mut().zip(hits) {
        *distance = hit.on.t;
    }
    distances
}

/// [`Slabs`] for eight rays.
struct RowSlabs<F, M> {
    reciprocal: [F; 3],
    near: [F; 3],
    far: [F; 3],
    negative: [M; 3],
}

impl<F: Copy, M: Copy> RowSlabs<F, M> {
    #[inline(always)]
    fn new<L: Lanes<EIGHT, F = F, M = M>>(l: L, o: [F; 3], d: [F; 3], extent: f32) -> Option<Self> {
        let zero = l.splat(0.0);
        let square = l.or(l.eq(d[0], zero), l.or(l.eq(d[1], zero), l.eq(d[2], zero)));
        if l.bits(square) != 0 {
            return None;
        }
        let least = l.max(
            l.mul(largest(l, d), l.splat(Slabs::LEAST_SHARE)),
            l.splat(Slabs::LEAST_COMPONENT),
        );
        let slack = l.splat(Slabs::SLACK * UNIT_ROUNDOFF);
        let delta = l.mul(slack, l.max(l.splat(extent), largest(l, o)));
        let x = axis(l, o[0], d[0], least, delta);
        let y = axis(l, o[1], d[1], least, delta);
        let z = axis(l, o[2], d[2], least, delta);
        Some(Self {
            reciprocal: [x.0, y.0, z.0],
            near: [x.1, y.1, z.1],
            far: [x.2, y.2, z.2],
            negative: [l.le(d[0], zero), l.le(d[1], zero), l.le(d[2], zero)],
        })
    }

    /// Returns where rays enter a child, not before their starts, and where they leave it.
    #[inline(always)]
    fn interval<const W: usize, L: Lanes<EIGHT, F = F, M = M>>(
        &self,
        l: L,
        node: &Node<W>,
        lane: usize,
    ) -> (F, F) {
        let x = self.within_planes(l, node, lane, 0);
        let y = self.within_planes(l, node, lane, 1);
        let z = self.within_planes(l, node, lane, 2);
        (
            l.max(l.max(x.0, y.0), l.max(z.0, l.splat(0.0))),
            l.min(l.min(x.1, y.1), z.1),
        )
    }

    /// Returns where rays are within the planes of one axis.
    // A closure would be compiled without the vectors' instruction set.
    #[inline(always)]
    fn within_planes<const W: usize, L: Lanes<EIGHT, F = F, M = M>>(
        &self,
        l: L,
        node: &Node<W>,
        lane: usize,
        axis: usize,
    ) -> (F, F) {
        let low = l.splat(node.planes[2 * (axis % 3)][lane % W]);
        let high = l.splat(node.planes[2 * (axis % 3) + 1][lane % W]);
        let near = l.select(self.negative[axis], high, low);
        let far = l.select(self.negative[axis], low, high);
        (
            l.sub(l.mul(near, self.reciprocal[axis]), self.near[axis]),
            l.sub(l.mul(far, self.reciprocal[axis]), self.far[axis]),
        )
    }
}

/// Reciprocal, and what to subtract for near and far planes, as [`Slabs::new`].
#[inline(always)]
fn axis<L: Lanes<EIGHT>>(l: L, o: L::F, d: L::F, least: L::F, delta: L::F) -> (L::F, L::F, L::F) {
    let clamped = l.max(l.abs(d), least);
    let minus = l.mul(l.splat(-1.0), clamped);
    let clamped = l.select(l.le(d, l.splat(0.0)), minus, clamped);
    let reciprocal = l.div(l.splat(1.0), clamped);
    let centre = l.mul(o, reciprocal);
    let slack = l.mul(l.abs(reciprocal), delta);
    (reciprocal, l.add(centre, slack), l.sub(centre, slack))
}

/// Maps directions, as `map_vector` does for one.
#[inline(always)]
fn vector<L: Lanes<EIGHT>>(l: L, map: &[[f32; 3]; 4], v: [L::F; 3]) -> [L::F; 3] {
    [
        map_component(l, map, 0, v),
        map_component(l, map, 1, v),
        map_component(l, map, 2, v),
    ]
}

#[inline(always)]
fn point<L: Lanes<EIGHT>>(l: L, map: &[[f32; 3]; 4], p: [L::F; 3]) -> [L::F; 3] {
    let [x, y, z] = vector(l, map, p);
    [
        l.add(x, l.splat(map[3][0])),
        l.add(y, l.splat(map[3][1])),
        l.add(z, l.splat(map[3][2])),
    ]
}

#[inline(always)]
fn dot<L: Lanes<EIGHT>>(l: L, a: [L::F; 3], b: [L::F; 3]) -> L::F {
    let xy = l.add(l.mul(a[0], b[0]), l.mul(a[1], b[1]));
    l.add(xy, l.mul(a[2], b[2]))
}

#[inline(always)]
fn quotient<L: Lanes<EIGHT>>(l: L, a: [L::F; 3], b: [L::F; 3]) -> [L::F; 3] {
    [l.div(a[0], b[0]), l.div(a[1], b[1]), l.div(a[2], b[2])]
}

#[inline(always)]
fn product<L: Lanes<EIGHT>>(l: L, a: [L::F; 3], b: [L::F; 3]) -> [L::F; 3] {
    [l.mul(a[0], b[0]), l.mul(a[1], b[1]), l.mul(a[2], b[2])]
}

#[inline(always)]
fn largest<L: Lanes<EIGHT>>(l: L, v: [L::F; 3]) -> L::F {
    l.max(l.abs(v[0]), l.max(l.abs(v[1]), l.abs(v[2])))
}

#[inline(always)]
fn radii<L: Lanes<EIGHT>>(l: L, instance: &Instance) -> [L::F; 3] {
    let [equatorial, polar] = instance.radii;
    [l.splat(equatorial), l.splat(polar), l.splat(equatorial)]
}

/// [`Spheroid::clearance_from_far`] in the lanes of `unsure`, else `all`.
#[inline(always)]
fn from_far<L: Lanes<EIGHT>>(
    l: L,
    spheroid: &Spheroid,
    (origin, direction): ([L::F; 3], [L::F; 3]),
    unsure: u32,
    mut all: [f32; EIGHT],
) -> [f32; EIGHT] {
    let [o, d] = [
        map3(origin, |part| l.store(part)),
        map3(direction, |part| l.store(part)),
    ];
    for (lane, clearance) in all.iter_mut().enumerate() {
        if unsure >> lane & 1 != 0 {
            let lane = lane % EIGHT;
            let of = |[x, y, z]: &[[f32; EIGHT]; 3]| Vec3::new(x[lane], y[lane], z[lane]);
            *clearance = spheroid.clearance_from_far(of(&o), of(&d));
        }
    }
    all
}

/// [`Spheroid::intersect`] of eight rays: the first distance after `start`, whether on the
/// way in, and whether it is a hit.
#[inline(always)]
fn on_spheroid<L: Lanes<EIGHT>>(
    l: L,
    instance: &Instance,
    origin: [L::F; 3],
    direction: [L::F; 3],
    start: L::F,
) -> (L::F, L::M, L::M) {
    let spheroid = Spheroid::of_checked(instance.radii);
    let (zero, one) = (l.splat(0.0), l.splat(1.0));
    let map = &instance.object_from_world;
    let (o, d) = (point(l, map, origin), vector(l, map, direction));
    // Ray::new.
    let (far, long) = (largest(l, o), largest(l, d));
    let usable = l.and(
        l.le(far, l.splat(Ray::FARTHEST)),
        l.and(
            l.le(l.splat(Ray::SHORTEST_DIRECTION), long),
            l.le(long, l.splat(Ray::LONGEST_DIRECTION)),
        ),
    );
    let scale = radii(l, instance);
    let in_metres = (o, d);
    let (o, d) = (quotient(l, o, scale), quotient(l, d, scale));
    let length = l.sqrt(dot(l, d, d));
    let unit = quotient(l, d, [length; 3]);
    // What is not a number is no solution below.
    let half = dot(l, o, unit);
    let closest = [
        l.sub(o[0], l.mul(unit[0], half)),
        l.sub(o[1], l.mul(unit[1], half)),
        l.sub(o[2], l.mul(unit[2], half)),
    ];
    let squared = dot(l, closest, closest);
    let distance = l.sqrt(dot(l, o, o));
    let is_far = l.bits(l.le(l.splat(Spheroid::FAR), distance));
    let (clear, clear_until) = Spheroid::CLEAR;
    let is_clear = l.bits(l.and(
        l.le(l.splat(clear), squared),
        l.le(distance, l.splat(clear_until)),
    ));
    let mut discriminant = l.sub(one, squared);
    let unsure = is_far & !is_clear;
    if unsure != 0 {
        let all = l.store(discriminant);
        discriminant = l.load(&from_far(l, &spheroid, in_metres, unsure, all));
    }
    let c = l.mul(l.sub(distance, one), l.add(distance, one));
    // quadratic_roots.
    let root = l.sqrt(discriminant);
    let behind = l.le(half, zero);
    let minus = l.mul(l.splat(-1.0), half);
    let q = l.select(behind, l.sub(root, half), l.sub(minus, root));
    let t0 = l.select(l.eq(q, zero), zero, l.div(c, q));
    let t1 = l.select(l.eq(q, zero), zero, q);
    let (near, far) = (l.min(t0, t1), l.max(t1, t0));
    let (near, far) = (l.div(near, length), l.div(far, length));
    let first = l.le(zero, near);
    let t = l.select(first, near, far);
    let hit = l.and(l.le(zero, discriminant), l.le(zero, t));
    let t = l.add(l.max(t, start), zero);
    (t, first, l.and(hit, usable))
}
