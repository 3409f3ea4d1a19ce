//! Traversal finds what a look at every triangle finds, bit for bit; and the
//! triangle test takes what exact arithmetic says it must.

use crate::exact::{Verdict, verdict};
use glam::{DAffine3, DQuat, DVec3, Vec3};
use shisen::bake::{Baked, lone_mesh};
use shisen::scene::mesh::TriangleMesh;
use shisen::scene::{Object, Scene, Shape};
use shisen_core::frame::{Budget, Workspace};
use shisen_core::shape::{Ray, Triangle};
use shisen_core::trace::{Hit, MeshHit, MeshTracer, TileRays, Tracer, TraversalStack};
use shisen_core::{Runs, Simd};
use shisen_tests::meshes::{gridded_cube, icosphere};
use shisen_tests::paths::Paths;
use shisen_tests::rays::Random;
use shisen_tests::scenes::object;
use shisen_tests::sizes::cases;

/// Shapes of trouble.
#[derive(Debug, Clone, Copy)]
enum Soup {
    Ordinary,
    Needles,
    Grid,
    Duplicates,
    Flat,
    Tiny,
    Huge,
}

use Soup::{Duplicates, Flat, Grid, Huge, Needles, Ordinary, Tiny};

const SOUPS: [Soup; 7] = [Ordinary, Needles, Grid, Duplicates, Flat, Tiny, Huge];

fn point(random: &mut Random, size: f64) -> DVec3 {
    DVec3::from_array([0; 3].map(|_| random.range(-size, size)))
}

impl Soup {
    /// Returns about the largest magnitude of a coordinate.
    fn size(self) -> f64 {
        if let Huge = self { 1e9 } else { 1.0 }
    }

    fn corners(self, random: &mut Random) -> [DVec3; 3] {
        let size = self.size();
        let a = point(random, size);
        let spread = |random: &mut Random, by| a + point(random, by);
        match self {
            Needles => {
                let b = spread(random, 1.0);
                let width = 10f64.powf(random.range(-9.0, -2.0));
                [a, b, b + point(random, width)]
            }
            Tiny => {
                // Tiny and at the origin, so that f32 can hold it; or one
                // grain of f32 somewhere else.
                let by = 10f64.powf(random.range(-20.0, -5.0));
                let a = if random.bits() & 1 == 0 { a * by } else { a };
                [a, a + point(random, by), a + point(random, by)]
            }
            Flat => {
                let axis = random.below(3);
                let level = f64::from(random.below(3) as u32) - 1.0;
                [0; 3].map(|_| {
                    let mut corner = point(random, 1.0);
                    corner[axis] = level;
                    corner
                })
            }
            _ => [a, spread(random, 0.5 * size), spread(random, 0.5 * size)],
        }
    }

    fn mesh(self, random: &mut Random) -> TriangleMesh {
        if let Grid = self {
            let cells = 1 + random.below(5) as u32;
            return gridded_cube(cells);
        }
        let mut mesh = TriangleMesh::default();
        for _ in 0..=random.below(60) {
            let corners = self.corners(random).map(|c| c.as_vec3().to_array());
            let more = if let Duplicates = self {
                random.below(12)
            } else {
                0
            };
            for copy in 0..=more {
                let first = mesh.positions.len() as u32;
                mesh.positions.extend(corners);
                let mut triangle = [first, first + 1, first + 2];
                triangle.rotate_left(copy % 3);
                mesh.triangles.push(triangle);
            }
        }
        mesh
    }
}

/// Returns a ray that means to meet the mesh, one way or another.
fn ray(mesh: &TriangleMesh, size: f64, random: &mut Random) -> Option<Ray> {
    let corner = |random: &mut Random| {
        let vertex = random.below(mesh.positions.len());
        Vec3::from(mesh.positions[vertex]).as_dvec3()
    };
    let triangle = mesh.triangles[random.below(mesh.triangles.len())];
    let [a, b, c] = triangle.map(|v| Vec3::from(mesh.positions[v as usize]).as_dvec3());
    let target = match random.below(6) {
        0 => a,
        1 => 0.5 * (a + b),
        2 => a + (c - a) * random.unit(),
        3 => point(random, size),
        _ => a + (b - a) * random.unit() * 0.5 + (c - a) * random.unit() * 0.5,
    };
    let far = size * 10f64.powf(random.range(3.0, 6.0));
    let origin = match random.below(6) {
        0 => corner(random),
        // In the plane of the triangle.
        1 => a + (b - a) * random.range(-3.0, 3.0) + (c - a) * random.range(-3.0, 3.0),
        2 => target + DVec3::from(random.direction()) * far,
        3 => point(random, 0.1 * size),
        _ => point(random, 4.0 * size),
    };
    let mut direction = (target - origin).as_vec3();
    let mut origin = origin.as_vec3();
    match random.below(4) {
        // Parallel to an axis or a plane, exactly or all but.
        0 => {
            for axis in 0..3 {
                if random.bits() & 1 == 0 {
                    direction[axis] = [0.0, -0.0, 1e-45, -1e-40, 1e-30, 1e-18][random.below(6)];
                    if random.bits() & 1 == 0 {
                        origin[axis] = target[axis] as f32;
                    }
                }
            }
        }
        1 => direction *= 10f32.powf(random.range(-17.0, 15.0) as f32),
        _ => {}
    }
    Ray::new(origin, direction)
}

/// Returns the largest coordinate.
fn extent(mesh: &TriangleMesh) -> f32 {
    let (low, high) = mesh.bounds();
    let all = low.iter().chain(&high);
    all.fold(0.0, |extent, c| extent.max(c.abs()))
}

/// Returns the least (t, id) over all triangles.
fn brute_force(mesh: &TriangleMesh, ray: &Ray) -> Option<(f32, u32)> {
    let extent = extent(mesh);
    let all = (0..).zip(&mesh.triangles).filter_map(|(id, corners)| {
        let hit = triangle(mesh, *corners).intersect(ray, extent)?;
        Some((hit.t, id))
    });
    all.min_by(|a, b| a.0.partial_cmp(&b.0).expect("distances"))
}

fn triangle(mesh: &TriangleMesh, corners: [u32; 3]) -> Triangle {
    // As baked: no −0.
    Triangle(corners.map(|v| Vec3::from(mesh.positions[v as usize]) + 0.0))
}

#[test]
fn every_path_finds_the_least_distance_and_number() {
    let (mut hits, mut rays) = (0, 0);
    for case in 0..cases("meshes against brute force", 400, 3_000) {
        let seed = 0xB0_0000 + case as u64;
        let mut random = Random::new(seed);
        let soup = SOUPS[case % SOUPS.len()];
        let mesh = soup.mesh(&mut random);
        let paths = Paths::new(&lone_mesh(mesh.clone()));
        let rays_here = (0..40).filter_map(|_| ray(&mesh, soup.size(), &mut random));
        let rays_here: Vec<_> = rays_here.collect();
        let expected = rays_here.iter().map(|ray| brute_force(&mesh, ray));
        let expected: Vec<_> = expected.collect();
        for (path, mut search) in paths.in_mesh() {
            for (ray, expected) in rays_here.iter().zip(&expected) {
                let found = search(ray).map(|hit| (hit.t.to_bits(), hit.triangle));
                let expected = expected.map(|(t, id)| (t.to_bits(), id));
                assert_eq!(found, expected, "seed {seed:#x}, {soup:?}, {path}: {ray:?}");
            }
        }
        rays += rays_here.len();
        hits += expected.iter().flatten().count();
    }
    // A fuzz that mostly misses shows nothing.
    assert!(hits * 3 > rays, "{hits} of {rays}");
}

#[test]
fn triangles_are_accepted_as_exact_arithmetic_says() {
    let mut counts = [0; 3];
    for case in 0..cases("triangles against exact arithmetic", 30_000, 300_000) {
        let seed = 0xE0_0000 + case as u64;
        let mut random = Random::new(seed);
        let soup = SOUPS[case % SOUPS.len()];
        let mesh = if let Soup::Grid = soup {
            shisen_tests::meshes::gridded_cube(2)
        } else {
            let positions = soup
                .corners(&mut random)
                .map(|c| c.as_vec3().to_array())
                .to_vec();
            TriangleMesh {
                positions,
                triangles: vec![[0, 1, 2]],
                ..TriangleMesh::default()
            }
        };
        let Some(ray) = ray(&mesh, soup.size(), &mut random) else {
            continue;
        };
        let extent = extent(&mesh);
        let corners = mesh.triangles[random.below(mesh.triangles.len())];
        let triangle = triangle(&mesh, corners);
        let found = triangle.intersect(&ray, extent);
        let context = || format!("seed {seed:#x}, {soup:?}: {ray:?} {triangle:?} {found:?}");
        match verdict(&triangle, &ray) {
            Verdict::Miss => {
                counts[0] += 1;
                assert_eq!(found, None, "{}", context());
            }
            Verdict::Hit { t, error } if t < -error => {
                counts[1] += 1;
                assert_eq!(found, None, "{} behind, at {t}", context());
            }
            Verdict::Hit { t, error } if t > error => {
                counts[2] += 1;
                let hit = found.unwrap_or_else(|| panic!("{}: a hit at {t}", context()));
                let off = (f64::from(hit.t) - t).abs();
                assert!(
                    off <= error,
                    "{}: {off:e} off {t}, allowed {error:e}",
                    context()
                );
                let sum: f32 = hit.weights.iter().sum();
                assert!(hit.weights.iter().all(|&w| w >= 0.0), "{}", context());
                assert!((sum - 1.0).abs() <= 3.0 * f32::EPSILON, "{}", context());
            }
            // Too near the ray's start to say on which side.
            Verdict::Hit { .. } => {}
        }
    }
    assert!(counts.iter().all(|&count| count > 20), "{counts:?}");
}

fn placed(shape: Shape, random: &mut Random) -> Object {
    let axis = DVec3::from(random.direction());
    let rotation = DQuat::from_axis_angle(axis, random.range(0.0, 6.0));
    let scale = DVec3::from_array([0; 3].map(|_| random.range(0.2, 2.0)));
    let translation = point(random, 4.0);
    let map = DAffine3::from_scale_rotation_translation(scale, rotation, translation);
    Object {
        material: None,
        ..object(shape, 0, map)
    }
}

#[test]
fn many_instances_give_the_nearest_of_each_alone() {
    let mut found_hits = 0;
    for case in 0..cases("scenes of many instances", 12, 100) {
        let seed = 0x15_0000 + case as u64;
        let mut random = Random::new(seed);
        let mut scene = Scene {
            meshes: vec![icosphere(2), Needles.mesh(&mut random)],
            objects: Vec::new(),
            ..lone_mesh(icosphere(0))
        };
        for _ in 0..=random.below(30) {
            let shape = match random.below(4) {
                0 => Shape::Sphere { radius: 0.7 },
                1 => Shape::Spheroid {
                    equatorial_radius: random.range(0.2, 1.0) as f32,
                    polar_radius: random.range(0.2, 1.0) as f32,
                },
                2 => Shape::Mesh(0),
                _ => Shape::Mesh(1),
            };
            let object = placed(shape, &mut random);
            scene.objects.push(object);
            if random.below(4) == 0 {
                // The same place twice: the first wins.
                scene.objects.extend(scene.objects.last().cloned());
            }
        }
        let rays: Vec<Ray> = (0..60)
            .filter_map(|_| {
                let origin = point(&mut random, 12.0);
                let target = point(&mut random, 4.0);
                Ray::new(origin.as_vec3(), (target - origin).as_vec3())
            })
            .collect();
        let mut expected: Vec<Option<(f32, u32, u32)>> = vec![None; rays.len()];
        for (number, object) in (0..).zip(&scene.objects) {
            let alone = Paths::new(&Scene {
                objects: vec![object.clone()],
                ..scene.clone()
            });
            let (_, mut search) = alone.in_scene().swap_remove(0);
            for (ray, expected) in rays.iter().zip(&mut expected) {
                if let Some(hit) = search(ray) {
                    assert!(hit.on.t.is_finite(), "seed {seed:#x}: a hit at no distance");
                    if expected.is_none_or(|(t, ..)| hit.on.t < t) {
                        *expected = Some((hit.on.t, number, hit.on.triangle));
                    }
                }
            }
        }
        for (path, mut search) in Paths::new(&scene).in_scene() {
            for (ray, expected) in rays.iter().zip(&expected) {
                let found = search(ray).map(|hit| (hit.on.t, hit.instance, hit.on.triangle));
                assert_eq!(found, *expected, "seed {seed:#x}, {path}: {ray:?}");
            }
        }
        found_hits += expected.iter().flatten().count();
    }
    assert!(found_hits > 80, "{found_hits}");
}

/// 64 rays from the start of `ray` around its direction, `spread` apart at
/// its end.
fn tile_around(ray: &Ray, spread: f32, random: &mut Random) -> TileRays {
    let axis = |random: &mut Random| Vec3::from(random.direction().map(|c| c as f32)) * spread;
    let (across, down) = (axis(random), axis(random));
    TileRays::new(ray.origin(), |column, row| {
        ray.direction() + across * (column as f32 - 3.5) + down * (row as f32 - 3.5)
    })
}

fn places() -> impl Iterator<Item = (usize, usize)> {
    (0..8).flat_map(|row| (0..8).map(move |column| (column, row)))
}

fn assert_tile_is_its_rays<const W: usize>(
    scene: &Scene,
    simd: Simd,
    tiles: &[TileRays],
    context: &str,
) -> usize
where
    Simd: Runs<W>,
{
    let baked = Baked::<W>::new(scene).expect("a scene");
    let in_mesh = MeshTracer::new(&baked.scene(), 0, simd).expect("a mesh");
    let in_scene = Tracer::new(baked.scene(), simd, 0);
    let mut stack = TraversalStack::EMPTY;
    let mut workspace = Workspace::new();
    let mut budget = Budget::UNLIMITED;
    let mut hits = 0;
    for tile in tiles {
        let (mesh_hits, _) = in_mesh.nearest_of_tile(tile, &mut stack);
        let scene_hits = in_scene.nearest_of_tile(tile, &mut budget, &mut workspace);
        let rays = || places().map(|(column, row)| tile.at(column, row));
        let (mut nearest, mut any) = (Vec::new(), Vec::new());
        let steps = in_mesh.nearest_of_each(rays(), &mut stack, |hit| nearest.push(hit));
        let fewer = in_mesh.any_of_each(rays(), &mut stack, |hit| any.push(hit));
        assert!(fewer <= steps, "{context}: {fewer} of {steps} steps");
        assert!(nearest.iter().map(Option::is_some).eq(any), "{context}");
        let mut all = 0;
        for ((column, row), nearest) in places().zip(nearest) {
            let Some(ray) = tile.at(column, row) else {
                continue;
            };
            let what = format!("{context}, {simd:?} {W} wide, {column} {row}: {ray:?}");
            let together = mesh_hits.at(column, row).map(|hit| hit.on);
            let (alone, steps) = in_mesh.nearest(&ray, &mut stack);
            all += steps;
            let bits = |hit: MeshHit| (hit.t.to_bits(), hit.triangle);
            assert_eq!(together.map(bits), alone.map(bits), "{what}");
            assert_eq!(nearest.map(bits), alone.map(bits), "{what}");
            let alone = in_scene.nearest(&ray, &mut budget, &mut workspace);
            let together = scene_hits.at(column, row);
            let bits = |hit: Hit| (hit.on.t.to_bits(), hit.instance, hit.on.triangle);
            assert_eq!(together.map(bits), alone.map(bits), "{what}");
            hits += usize::from(alone.is_some());
        }
        assert_eq!(steps, all, "{context}, {simd:?} {W} wide");
    }
    hits
}

#[test]
fn tiles_and_rows_of_rays_find_what_these_find_alone() {
    let mut hits = 0;
    for case in 0..cases("scenes by tiles", 35, 350) {
        let seed = 0x71_0000 + case as u64;
        let mut random = Random::new(seed);
        let soup = SOUPS[case % SOUPS.len()];
        let mut scene = lone_mesh(soup.mesh(&mut random));
        let tiles: Vec<TileRays> = (0..6)
            .filter_map(|_| {
                let ray = ray(&scene.meshes[0], soup.size(), &mut random)?;
                let by = 10f64.powf(random.range(-6.0, -0.5)) as f32;
                let spread = by * ray.direction().abs().max_element();
                Some(tile_around(&ray, spread, &mut random))
            })
            .collect();
        for _ in 0..random.below(25) {
            let shape = match random.below(3) {
                0 => Shape::Sphere { radius: 0.7 },
                _ => Shape::Mesh(0),
            };
            let object = placed(shape, &mut random);
            scene.objects.push(object);
        }
        let context = format!("seed {seed:#x}, {soup:?}");
        for simd in [Simd::detect(), Simd::PORTABLE] {
            hits += assert_tile_is_its_rays::<8>(&scene, simd, &tiles, &context);
        }
        hits += assert_tile_is_its_rays::<4>(&scene, Simd::detect(), &tiles, &context);
    }
    assert!(hits > 500, "{hits}");
}
