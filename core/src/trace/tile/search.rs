use super::slabs::TileSlabs;
use super::walk::{TileVisitor, walk_tile};
use super::{EIGHT, PerRay, Rungs, TileHits, TileRays, of_group, of_ray};
use crate::numeric::{map3, max};
use crate::scene::Scene;
use crate::scene::format::{COUNT_SHIFT, Instance, Mesh, kind};
use crate::shape::{Ray, Shear, Slabs, Triangle};
use crate::simd::{Kernel, Lanes};
use crate::trace::hit::{Hit, MeshHit};
use crate::trace::leaves::{Leaves, MeshView};
use crate::trace::map::{map_component, map_point};
use crate::trace::stack::{TraversalStack, Work};
use crate::trace::walk::{Path, leaf_index};
use glam::Vec3;

struct TileInMesh<'r, 'a, const W: usize> {
    leaves: Leaves<'a, W>,
    rays: &'r TileRays,
    slabs: &'r TileSlabs,
    axes: [usize; 3],
    shear: [PerRay; 3],
    /// Distance at which each ray enters the instance's box.
    start: &'r PerRay,
    instance: u32,
    hits: &'r mut TileHits,
}

impl<const W: usize> TileInMesh<'_, '_, W> {
    /// Decides exactly the lanes of a group whose edge functions vanished.
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
            let Some(t) = triangle.exact_distance(&shear) else {
                continue;
            };
            let slabs = Slabs::from_parts(
                of_ray(&self.slabs.reciprocal, group, lane),
                of_ray(&self.slabs.near, group, lane),
                of_ray(&self.slabs.far, group, lane),
                self.slabs.span.negative,
            );
            if let Some(t) = triangle.clamp_to_box(t, &slabs) {
                let mut hit = hit;
                hit.on.t = max(t, self.start[group % EIGHT][lane % EIGHT]);
                self.hits.take_nearer(group, lane, hit);
            }
        }
        self.hits.update_limit(group);
    }
}

impl<const W: usize> TileVisitor for TileInMesh<'_, '_, W> {
    #[inline(always)]
    fn expect<L: Lanes<EIGHT>>(&self, l: L, child: u32) {
        if let Some(block) = self.leaves.block(leaf_index(child)) {
            l.prefetch(block);
        }
    }

    #[inline(always)]
    fn hits(&mut self) -> &mut TileHits {
        self.hits
    }

    // Longer than 80 lines: one loop, whose vectors stay in registers.
    #[inline(always)]
    fn leaf<L: Lanes<EIGHT>>(&mut self, l: L, child: u32, groups: u8, path: &mut Path<'_>) {
        let count = (child >> COUNT_SHIFT & 7) + 1;
        if !path.take(u64::from(count)) {
            return;
        }
        let leaf = leaf_index(child);
        let Some(triangles) = self.leaves.leaf(leaf) else {
            return;
        };
        let [kx, ky, kz] = self.axes;
        let zero = l.splat(0.0);
        for lane in 0..count {
            let Some(triangle) = triangles.triangle(lane) else {
                return;
            };
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
                        triangle: triangles.ids[lane as usize & (W - 1)],
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

struct TileInWorld<'r, 'a, const W: usize> {
    scene: &'r Scene<'a, W>,
    rays: &'r TileRays,
    slabs: &'r TileSlabs,
    hits: &'r mut TileHits,
}

impl<const W: usize> TileInWorld<'_, '_, W> {
    /// Returns false if the rays cannot be traced together in the mesh's frame.
    #[inline(always)]
    fn in_mesh<L: Lanes<EIGHT>>(
        &mut self,
        l: L,
        mesh: &Mesh,
        number: u32,
        instance: &Instance,
        groups: u8,
        path: &mut Path<'_>,
    ) -> bool {
        let Some(rays) = mapped(l, self.rays, groups, instance) else {
            return false;
        };
        let Some((axes, shear)) = shears(l, &rays, groups) else {
            return false;
        };
        let Some(slabs) = TileSlabs::new(l, &rays, groups, mesh.extent, &self.hits.t) else {
            return false;
        };
        let (near, far) = self.slabs.planes(instance.low, instance.high);
        let mut start = [[0.0; EIGHT]; EIGHT];
        for group in 0..EIGHT {
            if groups >> group & 1 == 0 {
                continue;
            }
            let (near, far) = self.slabs.of_group(l, group, near, far);
            let near = l.max(near, l.splat(0.0));
            // A ray that misses the box gets NaN, which fails all later comparisons: traced
            // alone it would never enter the box either.
            let enters = l.le(near, far);
            start[group] = l.store(l.select(enters, near, l.splat(f32::NAN)));
        }
        if !path.take(1) {
            return true;
        }
        let mut search = TileInMesh::<W> {
            leaves: Leaves::new(self.scene, mesh),
            rays: &rays,
            slabs: &slabs,
            axes,
            shear,
            start: &start,
            instance: number,
            hits: &mut *self.hits,
        };
        let (nodes, root) = (self.scene.nodes, mesh.root);
        walk_tile(l, nodes, root, &slabs, groups, &mut search, path);
        true
    }
}

impl<const W: usize> TileVisitor for TileInWorld<'_, '_, W> {
    /// Does nothing: instances are few and stay in the cache.
    #[inline(always)]
    fn expect<L: Lanes<EIGHT>>(&self, _: L, _: u32) {}

    #[inline(always)]
    fn hits(&mut self) -> &mut TileHits {
        self.hits
    }

    #[inline(always)]
    fn leaf<L: Lanes<EIGHT>>(&mut self, l: L, child: u32, groups: u8, path: &mut Path<'_>) {
        let number = leaf_index(child);
        let Some(instance) = self.scene.instances.get(number as usize) else {
            return;
        };
        let (least, most, own) = match &self.rays.rungs {
            Rungs::Equal(rung) => (*rung, *rung, None),
            Rungs::Own(least, most, own) => (*least, *most, Some(own)),
        };
        for rung in least..=most {
            let groups = match own {
                Some(own) if least != most => {
                    groups & TileRays::groups_with(own, |other| other == rung)
                }
                _ => groups,
            };
            if groups == 0 {
                continue;
            }
            // Rays of these groups on other rungs are excluded during the search.
            let mixed = match own {
                Some(own) => groups & TileRays::groups_with(own, |other| other != rung),
                None => 0,
            };
            let others = own.filter(|_| mixed != 0).map(|own| {
                let found = self.hits.t;
                self.hits
                    .exclude(mixed, |group, lane| own[group][lane] != rung);
                (own, found)
            });
            let mesh = self.scene.mesh_at(instance.geometry, rung);
            let together = match mesh.filter(|_| instance.kind == kind::MESH) {
                Some(mesh) => self.in_mesh(l, mesh, number, instance, groups, path),
                None => false,
            };
            if let Some((own, found)) = others {
                self.hits
                    .restore(&found, mixed, |group, lane| own[group][lane] != rung);
            }
            if !together && self.hits.deferred.push((number, groups)).is_err() {
                // The list is full: replace it by one entry for all instances.
                self.hits.deferred.clear();
                let _ = self.hits.deferred.push((ALL_INSTANCES, u8::MAX));
            }
        }
    }
}

/// Entry for all instances, in a deferred list that was too short.
pub(in crate::trace) const ALL_INSTANCES: u32 = u32::MAX;

/// Returns the rays in an instance's frame; `None` if one cannot be traced there.
#[inline(always)]
fn mapped<L: Lanes<EIGHT>>(
    l: L,
    rays: &TileRays,
    groups: u8,
    instance: &Instance,
) -> Option<TileRays> {
    let map = &instance.object_from_world;
    let mut inside = TileRays::without_directions(map_point(map, rays.origin));
    Ray::new(inside.origin, Vec3::X)?;
    let zero = l.splat(0.0);
    let magnitude = |x: L::F| l.max(x, l.sub(zero, x));
    for group in 0..EIGHT {
        if groups >> group & 1 == 0 {
            continue;
        }
        let d = map3(of_group(&rays.direction, group), |d| l.load(d));
        let d = [
            map_component(l, map, 0, d),
            map_component(l, map, 1, d),
            map_component(l, map, 2, d),
        ];
        let [x, y, z] = map3(d, magnitude);
        let largest = l.max(x, l.max(y, z));
        let usable = l.and(
            l.le(l.splat(Ray::SHORTEST_DIRECTION), largest),
            l.le(largest, l.splat(Ray::LONGEST_DIRECTION)),
        );
        if l.bits(usable) != 0xff {
            return None;
        }
        for (inside, d) in inside.direction.iter_mut().zip(d) {
            inside[group] = l.store(d);
        }
    }
    Some(inside)
}

/// Returns the axes, the main one that all rays share last, and the rays' shears; `None` without a
/// shared main axis.
#[inline(always)]
fn shears<L: Lanes<EIGHT>>(l: L, rays: &TileRays, groups: u8) -> Option<([usize; 3], [PerRay; 3])> {
    let first = rays.ray(groups.trailing_zeros() as usize, 0)?;
    let axes = Shear::new(&first).axes;
    let [kx, ky, kz] = axes;
    let zero = l.splat(0.0);
    let mut shear = [[[0.0; EIGHT]; EIGHT]; 3];
    for group in 0..EIGHT {
        if groups >> group & 1 == 0 {
            continue;
        }
        let d = map3([kx, ky, kz], |axis| {
            l.load(&rays.direction[axis % 3][group])
        });
        let [x, y, z] = map3(d, |d| l.max(d, l.sub(zero, d)));
        // Rays with two equal components are traced alone: Shear then takes the first axis.
        if l.bits(l.or(l.le(z, x), l.le(z, y))) != 0 {
            return None;
        }
        shear[0][group] = l.store(l.div(d[0], d[2]));
        shear[1][group] = l.store(l.div(d[1], d[2]));
        shear[2][group] = l.store(l.div(l.splat(1.0), d[2]));
    }
    Some((axes, shear))
}

pub(in crate::trace) struct TileSearch<'r, 'a, const W: usize> {
    pub(in crate::trace) scene: &'r Scene<'a, W>,
    pub(in crate::trace) rays: &'r TileRays,
    pub(in crate::trace) hits: &'r mut TileHits,
    pub(in crate::trace) stack: &'r mut TraversalStack,
    pub(in crate::trace) most: u64,
}

impl<const W: usize> Kernel<EIGHT> for TileSearch<'_, '_, W> {
    /// Returns `None` if the rays cannot be traced together.
    type Output = Option<Work>;

    #[inline(always)]
    fn run<L: Lanes<EIGHT>>(self, l: L) -> Option<Work> {
        let mut path = Path::new(self.stack, self.most);
        let (scene, rays) = (self.scene, self.rays);
        let slabs = TileSlabs::new(l, rays, u8::MAX, scene.extent, &self.hits.t)?;
        let mut visitor = TileInWorld::<W> {
            scene,
            rays,
            slabs: &slabs,
            hits: self.hits,
        };
        let (nodes, root, groups) = (scene.top, scene.header.root, rays.groups());
        walk_tile(l, nodes, root, &slabs, groups, &mut visitor, &mut path);
        Some(path.work())
    }
}

/// Searches one mesh, in its own frame, for all rays of a tile.
pub(in crate::trace) struct TileInMeshSearch<'r, 'a, const W: usize> {
    pub(in crate::trace) mesh: &'r MeshView<'a, W>,
    pub(in crate::trace) rays: &'r TileRays,
    pub(in crate::trace) hits: &'r mut TileHits,
    pub(in crate::trace) stack: &'r mut TraversalStack,
}

impl<const W: usize> Kernel<EIGHT> for TileInMeshSearch<'_, '_, W> {
    type Output = Option<Work>;

    #[inline(always)]
    fn run<L: Lanes<EIGHT>>(self, l: L) -> Option<Work> {
        let mut path = Path::new(self.stack, u64::MAX);
        let (axes, shear) = shears(l, self.rays, u8::MAX)?;
        let slabs = TileSlabs::new(l, self.rays, u8::MAX, self.mesh.extent, &self.hits.t)?;
        let mut search = TileInMesh::<W> {
            leaves: self.mesh.leaves,
            rays: self.rays,
            slabs: &slabs,
            axes,
            shear,
            start: &[[0.0; EIGHT]; EIGHT],
            instance: 0,
            hits: self.hits,
        };
        let MeshView { nodes, root, .. } = *self.mesh;
        walk_tile(l, nodes, root, &slabs, u8::MAX, &mut search, &mut path);
        Some(path.work())
    }
}
