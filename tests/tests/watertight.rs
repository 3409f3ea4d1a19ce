//! From inside a closed mesh every ray hits something: aimed at edges, at
//! vertices, along grid lines, through instances, on every path.

use crate::lod::cracks::{points_inside, triangles};
use glam::{DAffine3, DQuat, DVec3};
use shisen::bake::lone_mesh;
use shisen::scene::mesh::TriangleMesh;
use shisen_core::shape::Ray;
use shisen_tests::meshes::{edges, ellipsoid, gridded_cube, meshes, normalised, position};
use shisen_tests::paths::Paths;
use shisen_tests::rays::Random;
use shisen_tests::sizes::cases;

/// Returns what rays are aimed at: middles of edges, and vertices.
pub(crate) fn targets(mesh: &TriangleMesh) -> [Vec<DVec3>; 2] {
    let place = |vertex| position(mesh, vertex);
    let middles = edges(mesh)
        .into_iter()
        .map(|[a, b]| 0.5 * (place(a) + place(b)));
    let vertices = (0..mesh.positions.len() as u32).map(place);
    [middles.collect(), vertices.collect()]
}

/// Aimed in f64, rounded to f32.
pub(crate) fn aimed(origin: DVec3, target: DVec3) -> Option<Ray> {
    Ray::new(origin.as_vec3(), (target - origin).as_vec3())
}

/// Returns a point inside the turned ellipsoid: well inside its inscribed ball.
fn near_centre(random: &mut Random) -> DVec3 {
    DVec3::from(random.direction()) * random.range(0.0, 0.3)
}

/// Counts the rays that each path loses and asserts that it is none.
pub(crate) fn assert_none_lost<T>(
    what: &str,
    searches: Vec<shisen_tests::paths::Search<'_, T>>,
    distance: impl Fn(&T) -> f32,
    count: usize,
    mut next: impl FnMut(&mut Random) -> Ray,
) {
    for (path, mut search) in searches {
        // The same rays on every path.
        let mut random = Random::new(0x5EED);
        let mut lost = Vec::new();
        for number in 0..count {
            let ray = next(&mut random);
            if !search(&ray).is_some_and(|hit| distance(&hit).is_finite()) {
                lost.push((number, ray));
            }
        }
        assert!(
            lost.is_empty(),
            "{what}, {path}: {} of {count} rays lost; the first is number {:?}",
            lost.len(),
            lost.first()
        );
    }
}

#[test]
fn edges_and_vertices_through_instances() {
    let mesh = ellipsoid();
    let targets = targets(&mesh);
    let mut scene = lone_mesh(mesh);
    let rotation = DQuat::from_euler(glam::EulerRot::YXZ, 0.4, -1.2, 2.5);
    for (scale, moved) in [
        (DVec3::splat(1.0), DVec3::ZERO),
        (DVec3::new(0.2, 3.0, 1.7), DVec3::new(3.0, -2.0, 0.5)),
        (
            DVec3::new(40.0, 55.0, 30.0),
            DVec3::new(-500.0, 800.0, 300.0),
        ),
        (DVec3::new(1e-3, 2e-3, 1e-3), DVec3::new(0.1, 0.0, -0.2)),
    ] {
        let map = DAffine3::from_scale_rotation_translation(scale, rotation, moved);
        scene.objects[0].world_from_object = map;
        let paths = Paths::new(&scene);
        let count = cases(
            "rays at edges, and at vertices, of an instance",
            2_000,
            10_000,
        );
        for targets in &targets {
            assert_none_lost(
                &format!("{map}"),
                paths.in_scene(),
                |hit| hit.on.t,
                count,
                |random| {
                    let target = map.transform_point3(targets[random.below(targets.len())]);
                    let origin = map.transform_point3(near_centre(random));
                    aimed(origin, target).expect("a finite direction")
                },
            );
        }
    }
}

#[test]
fn grid_lines_of_a_cube() {
    // Powers of two put the grid lines on exact numbers, 40 does not.
    for cells in [16, 40] {
        let paths = Paths::new(&lone_mesh(gridded_cube(cells)));
        let count = cases("rays along the grid lines of a cube", 1_000, 10_000);
        let line = |random: &mut Random| {
            let i = 1 + random.below(cells as usize - 1);
            (2.0 * i as f64 / f64::from(cells) - 1.0) as f32
        };
        assert_none_lost(
            &format!("{cells} cells"),
            paths.in_mesh(),
            |hit| hit.t,
            count,
            |random| {
                let axis = random.below(3);
                let mut origin = [0.0; 3];
                let mut direction = [0.0f32; 3];
                for component in &mut direction {
                    *component = if random.bits() & 1 == 0 { 0.0 } else { -0.0 };
                }
                direction[axis] = if random.bits() & 1 == 0 { 1.0 } else { -1.0 };
                direction[axis] *= random.range(0.3, 3.0) as f32;
                origin[axis] = random.range(-0.99, 0.99) as f32;
                let [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
                origin[u] = line(random);
                origin[v] = match random.below(4) {
                    // On a line only, and on diagonals.
                    0 => random.range(-0.99, 0.99) as f32,
                    1 => origin[u],
                    _ => line(random),
                };
                if random.bits() & 1 == 0 {
                    origin.swap(u, v);
                }
                Ray::new(origin.into(), direction.into()).expect("a finite ray")
            },
        );
    }
}

#[test]
fn no_ray_escapes_from_an_animal() {
    for (name, mesh) in meshes() {
        let mesh = normalised(mesh, 10.0);
        let targets = targets(&mesh);
        let all: Vec<u32> = (0..mesh.triangles.len() as u32).collect();
        let origins = points_inside(&triangles(&mesh, &all), 100, &mut Random::new(7));
        let paths = Paths::new(&lone_mesh(mesh));
        let count = cases("rays at edges, and at vertices, from inside", 5_000, 50_000);
        for (what, targets) in ["middles of edges", "vertices"].iter().zip(&targets) {
            assert_none_lost(
                &format!("{name}, {what}"),
                paths.in_mesh(),
                |hit| hit.t,
                count,
                |random| {
                    let origin = origins[random.below(origins.len())];
                    let target = targets[random.below(targets.len())];
                    aimed(origin, target).expect("a finite direction")
                },
            );
        }
    }
}
