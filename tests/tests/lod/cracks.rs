//! No rung of a closed mesh lets a ray through.

use super::{GAZES, eyes, frame, level, levels, lod, places, samples, views};
use glam::{DAffine3, DQuat, DVec3, Vec3};
use shisen::bake::simplify::Ladder;
use shisen::bake::{Baked, Layout, lone_mesh};
use shisen::scene::mesh::TriangleMesh;
use shisen_core::frame::{Budget, Workspace};
use shisen_core::shape::Ray;
use shisen_core::trace::Tracer;
use shisen_core::{Runs, Simd};
use shisen_tests::meshes::{icosphere, meshes, normalised};
use shisen_tests::rays::Random;
use shisen_tests::sizes::cases;

fn closed_meshes() -> Vec<(&'static str, TriangleMesh)> {
    let mut all = meshes();
    all.push(("icosphere", icosphere(4)));
    all
}

/// The triangles of a rung, corner by corner.
pub(crate) type Triangles = Vec<[DVec3; 3]>;

pub(crate) fn triangles(all: &TriangleMesh, rung: &[u32]) -> Triangles {
    let corner = |c: u32| Vec3::from(all.positions[c as usize]).as_dvec3();
    rung.iter()
        .map(|&t| all.triangles[t as usize].map(corner))
        .collect()
}

/// Returns how often the surface winds around a point: the sum of the solid angles
/// (Van Oosterom & Strackee 1983).
fn winding(triangles: &Triangles, point: DVec3) -> f64 {
    let half_angle = |corners: &[DVec3; 3]| {
        let [a, b, c] = corners.map(|corner| corner - point);
        let [i, j, k] = [a, b, c].map(DVec3::length);
        let under = i * j * k + a.dot(b) * k + b.dot(c) * i + c.dot(a) * j;
        a.dot(b.cross(c)).atan2(under)
    };
    triangles.iter().map(half_angle).sum::<f64>() / std::f64::consts::TAU
}

/// Returns points a little below the surface that it winds around once or more; the farthest vertex
/// is 10 from the middle.
pub(crate) fn points_inside(
    triangles: &Triangles,
    count: usize,
    random: &mut Random,
) -> Vec<DVec3> {
    let mut points = Vec::new();
    while points.len() < count {
        let [a, b, c] = triangles[random.below(triangles.len())];
        let Some(normal) = (b - a).cross(c - a).try_normalize() else {
            continue;
        };
        // Where a leg is one part in a thousand of the animal.
        let depth = 10f64.powf(random.range(-3.0, -1.0));
        let point = (a + b + c) / 3.0 - normal * depth;
        if winding(triangles, point) > 0.9 {
            points.push(point);
        }
    }
    points
}

/// Vertices, and middles of edges, both where rays are lost first.
fn target(triangles: &Triangles, random: &mut Random) -> DVec3 {
    let [a, b, _] = triangles[random.below(triangles.len())];
    if random.bits() & 1 == 0 {
        a
    } else {
        0.5 * (a + b)
    }
}

/// Aims rays through vertices and edges, from points inside and towards
/// points inside; returns how many.
fn assert_rung_is_closed<const W: usize>(
    what: &str,
    tracer: &Tracer<'_, W>,
    world_from_mesh: DAffine3,
    triangles: &Triangles,
    inside: &[DVec3],
    count: usize,
) where
    Simd: Runs<W>,
{
    let mut random = Random::new(0xC1_05ED);
    let mut workspace = Workspace::new();
    let mut lost = Vec::new();
    for number in 0..count {
        let within = inside[random.below(inside.len())];
        let target = target(triangles, &mut random);
        // From inside something is hit, and on the way through a point inside
        // too: before or behind it.
        let (from, to) = if number % 2 == 0 {
            (within, target)
        } else {
            let before = (target - within) * random.range(0.01, 3.0);
            (target + before, within)
        };
        let [from, to] = [from, to].map(|p| world_from_mesh.transform_point3(p));
        let Some(ray) = Ray::new(from.as_vec3(), (to - from).as_vec3()) else {
            continue;
        };
        let hit = tracer.nearest(&ray, &mut Budget::UNLIMITED.clone(), &mut workspace);
        if !hit.is_some_and(|hit| hit.on.t.is_finite()) {
            lost.push((number, ray));
        }
    }
    assert!(
        lost.is_empty(),
        "{what}: {} of {count} rays lost, the first {:?}",
        lost.len(),
        lost[0]
    );
}

#[test]
fn every_rung_is_watertight() {
    let count = cases("rays at the edges and vertices of a rung", 300, 5_000);
    for (name, mesh) in closed_meshes() {
        let mesh = normalised(mesh, 10.0);
        let ladder = Ladder::new(&mesh, &levels());
        let rotation = DQuat::from_euler(glam::EulerRot::YXZ, 0.4, -1.2, 2.5);
        let scale = DVec3::new(0.2, 0.3, 0.17);
        let map = DAffine3::from_scale_rotation_translation(scale, rotation, DVec3::NEG_Z);
        let mut scene = lone_mesh(mesh.clone());
        scene.objects[0].world_from_object = map;
        let fast = Baked::<8>::with_levels(&scene, &levels()).expect("a scene");
        let compact = Baked::<4>::with_levels(&scene, &levels()).expect("a scene");
        assert_eq!(ladder.rungs().len(), Layout::Fast.polygon_levels() as usize);
        for (number, rung) in (0..).zip(ladder.rungs()) {
            let what = format!("{name}, rung {number}, {} faces", rung.len());
            let triangles = triangles(ladder.versions(), rung);
            let inside = points_inside(&triangles, 60, &mut Random::new(7));
            for simd in [Simd::detect(), Simd::PORTABLE] {
                let tracer = Tracer::new(fast.scene(), simd, 0).at_rung(number);
                assert_rung_is_closed(&what, &tracer, map, &triangles, &inside, count);
                let tracer = Tracer::new(compact.scene(), simd, 0).at_rung(number);
                assert_rung_is_closed(&what, &tracer, map, &triangles, &inside, count);
            }
        }
    }
}

#[test]
fn no_gap_opens_where_rungs_meet() {
    // From inside a mesh nothing but the mesh is to be seen, whatever mesh a
    // pixel sees and whatever its neighbour does.
    for (name, mesh) in closed_meshes() {
        let triangles = triangles(&mesh, &(0..mesh.triangles.len() as u32).collect::<Vec<_>>());
        let ladder = Ladder::new(&mesh, &levels());
        let coarsest = self::triangles(ladder.versions(), ladder.rungs().last().expect("a rung"));
        // Deep inside all rungs.
        let (low, high) = mesh.bounds();
        let size = (Vec3::from(high) - Vec3::from(low)).as_dvec3().length();
        let inside = points_inside(&triangles, 300, &mut Random::new(3));
        let centre = inside.into_iter().find(|&point| {
            let around = [DVec3::ZERO, DVec3::X, -DVec3::X, DVec3::Y, -DVec3::Y];
            around.into_iter().all(|step| {
                let point = point + step * (0.01 * size);
                winding(&triangles, point) > 0.9 && winding(&coarsest, point) > 0.9
            })
        });
        let centre = centre.expect("a point inside");
        let mut scene = lone_mesh(mesh);
        scene.background.alpha = 0.0;
        scene.objects[0].world_from_object =
            DAffine3::from_scale(DVec3::splat(100.0 / size)) * DAffine3::from_translation(-centre);
        let baked = Baked::<8>::with_levels(&scene, &levels()).expect("a scene");
        for gaze in GAZES {
            let lod = lod(gaze);
            let (size, eyes) = ([64, 63], eyes(Some(lod)));
            let found = frame(baked.scene(), size, &eyes, &samples(1));
            let mut traced = 0;
            for (number, (view, _)) in views(size, &eyes).iter().enumerate() {
                for at in places(view) {
                    let picture = &found.pictures[number].picture;
                    let alpha = picture.pixel(at.0, at.1).expect("a pixel")[3];
                    let inside = level(&lod, view, at) > 0.0;
                    traced += u32::from(inside);
                    let expected = f32::from(u8::from(inside));
                    assert_eq!(alpha, expected, "{name}, {gaze:?}, {number}, {at:?}");
                }
            }
            assert!(traced > 1000);
        }
    }
}
