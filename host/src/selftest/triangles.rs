//! Rays and triangles, alone and in closed meshes.

use super::input::{Inputs, aimed, single};
use super::{BROKEN, Case, Effort, Errors, UNIT, Worst};
use crate::bake::{Baked, lone_mesh};
use crate::mesh::TriangleMesh;
use crate::quadruped::quadruped;
use crate::scene::{Object, Scene};
use glam::{DAffine3, DVec3, Vec3};
use shisen_core::Simd;
use shisen_core::numeric::largest_magnitude;
use shisen_core::shape::{Ray, Triangle};
use shisen_core::trace::{Budget, MeshTracer, Tracer, TraversalStack, Workspace};

const LOST: &str = "rays lost";
const CLOSED: &str = "from inside a closed mesh every ray meets it";
const MOLLER: &str = "Möller and Trumbore's test in f32";
const LINES: &str = "distances of the ray's line to the edges in f64";
const WRONG: &str = "how far from the edge a wrong verdict was, 2⁻²⁴ of the farthest coordinate";

const MOVED: &str = "of the distance, 2⁻²⁴ of how far the object is away; a wrong verdict is \
                     infinite where the ray is clear of every edge";
const MOVED_REFERENCE: &str = "every triangle in f64, where the object is in f64";
const MOVED_NAIVE: &str = "vertices moved in f32, Möller and Trumbore's test of each";

pub(super) const CASES: &[Case] = &[
    Case {
        name: "mesh-shared-edges",
        hard: "5 million rays from inside a closed mesh at the middles of its edges",
        error: LOST,
        reference: CLOSED,
        naive: "Möller and Trumbore's test of the two triangles at the edge",
        bound: 0.0,
        measure: shared_edges,
    },
    Case {
        name: "mesh-shared-vertices",
        hard: "5 million rays from inside a closed mesh at its vertices",
        error: LOST,
        reference: CLOSED,
        naive: "Möller and Trumbore's test of the triangles at the vertex",
        bound: 0.0,
        measure: shared_vertices,
    },
    Case {
        name: "triangle-slivers",
        hard: "triangles a million times as long as wide, rays next to their long sides",
        error: WRONG,
        reference: LINES,
        naive: MOLLER,
        bound: 4.0,
        measure: slivers,
    },
    Case {
        name: "triangle-slivers-distance",
        hard: "the distance of triangles 10 to 10⁵ times as long as wide, seen at 0.3 rad or more",
        error: "of the hit point from the plane, 2⁻²⁴ of the farthest coordinate, over how many times \
                it is as long as wide",
        reference: "the plane in f64",
        naive: MOLLER,
        bound: 2.0,
        measure: slivers_distance,
    },
    Case {
        name: "triangle-distance",
        hard: "the distance where a triangle is seen at 10⁻⁵ to 1 rad to its plane",
        error: "of the hit point from the plane, 2⁻²⁴ of the farthest coordinate",
        reference: "the plane in f64",
        naive: MOLLER,
        bound: 8.0,
        measure: distance,
    },
    Case {
        name: "triangle-in-the-rays-plane",
        hard: "rays exactly in a triangle's plane, towards it",
        error: "hits, and distances that are no numbers",
        reference: "an edge-on triangle has no area to hit",
        naive: "Möller and Trumbore's test in f32, without a least determinant",
        bound: 0.0,
        measure: coplanar,
    },
    Case {
        name: "triangle-without-area",
        hard: "triangles that are a point or a line, rays through them",
        error: "how far beside it was hit, 2⁻²⁴ of the farthest coordinate; a distance that is no \
                number is infinite",
        reference: "the line in f64",
        naive: "Möller and Trumbore's test in f32, without a least determinant",
        bound: 1.0,
        measure: without_area,
    },
    Case {
        name: "mesh-with-t-junctions",
        hard: "an edge with a vertex in its middle, closed by a triangle without area",
        error: "rays that see the background through the seam",
        reference: "the mesh is closed",
        naive: "Möller and Trumbore's test of the three large triangles at the seam",
        bound: 0.0,
        measure: t_junctions,
    },
    Case {
        name: "mesh-of-millimetres-far-away",
        hard: "a mesh of triangles of a millimetre, 100 km away from the origin, seen from 5 cm",
        error: MOVED,
        reference: MOVED_REFERENCE,
        naive: MOVED_NAIVE,
        bound: 0.01,
        measure: far_millimetres,
    },
    Case {
        name: "mesh-a-million-metres-away",
        hard: "an animal of 2 m moved by 1,000 km, seen from 3 m",
        error: MOVED,
        reference: MOVED_REFERENCE,
        naive: MOVED_NAIVE,
        bound: 0.01,
        measure: moved_mesh,
    },
];

/// Möller and Trumbore's test of 1997, in f32; with `least`, as published, a
/// determinant below which a triangle is taken for edge-on.
fn moller_trumbore(corners: [Vec3; 3], ray: &Ray, least: Option<f32>) -> Option<f32> {
    let [a, b, c] = corners;
    let (d, e1, e2) = (ray.direction(), b - a, c - a);
    let p = d.cross(e2);
    let determinant = e1.dot(p);
    if least.is_some_and(|least| determinant.abs() < least) {
        return None;
    }
    let inverse = 1.0 / determinant;
    let s = ray.origin() - a;
    let u = s.dot(p) * inverse;
    if u < 0.0 || u > 1.0 {
        return None;
    }
    let q = s.cross(e1);
    let v = d.dot(q) * inverse;
    if v < 0.0 || u + v > 1.0 {
        return None;
    }
    let t = e2.dot(q) * inverse;
    // A NaN is let pass, as it is where the comparison reads so.
    if t < 0.0 { None } else { Some(t) }
}

/// As published.
const LEAST: Option<f32> = Some(1.0e-6);

fn ours(corners: [Vec3; 3], ray: &Ray) -> Option<f32> {
    let extent = corners
        .iter()
        .fold(0f32, |most, &c| most.max(largest_magnitude(c)));
    Triangle(corners).intersect(ray, extent).map(|hit| hit.t)
}

/// The farthest coordinate, metres.
fn extent(corners: [Vec3; 3], ray: &Ray) -> f64 {
    let all = [corners[0], corners[1], corners[2], ray.origin()];
    all.into_iter()
        .map(|v| f64::from(largest_magnitude(v)))
        .fold(0.0, f64::max)
}

/// How far inside the triangle the ray's line passes, metres; below 0
/// outside, by the distance to the line of the edge that it is farthest out of.
/// All inputs are f32; in f64 it is off by 10⁻¹⁵ of their size.
fn margin(corners: [Vec3; 3], ray: &Ray) -> f64 {
    let corners = corners.map(|c| c.as_dvec3());
    let (o, d) = (ray.origin().as_dvec3(), ray.direction().as_dvec3());
    let side = (corners[1] - corners[0])
        .cross(corners[2] - corners[0])
        .dot(d)
        .signum();
    let margin = |i: usize| {
        let (a, b) = (corners[i], corners[(i + 1) % 3]);
        let across = (b - a).cross(d);
        (o - a).dot(across) / across.length() * -side
    };
    (0..3).map(margin).fold(
        f64::INFINITY,
        |least, m| if m.is_nan() { m } else { least.min(m) },
    )
}

/// Both verdicts; a wrong one is as bad as the ray is clear of the edge.
fn check_verdict(worst: &mut Worst, corners: [Vec3; 3], ray: &Ray) {
    let margin = margin(corners, ray);
    let unit = UNIT * extent(corners, ray);
    let error = |hit: Option<f32>| match hit {
        Some(t) if !t.is_finite() => f64::INFINITY,
        hit if hit.is_some() == (margin >= 0.0) => 0.0,
        _ => margin.abs() / unit,
    };
    worst.ours(error(ours(corners, ray)));
    worst.naive(error(moller_trumbore(corners, ray, LEAST)));
}

/// The triangles at each edge or vertex of a closed mesh, and where to aim.
struct Target {
    at: DVec3,
    triangles: Vec<[Vec3; 3]>,
}

fn positions(mesh: &TriangleMesh, triangle: [u32; 3]) -> [Vec3; 3] {
    triangle.map(|v| Vec3::from(mesh.positions[v as usize]))
}

fn vertices(mesh: &TriangleMesh) -> Vec<Target> {
    let mut targets: Vec<Target> = mesh
        .positions
        .iter()
        .map(|&p| Target {
            at: Vec3::from(p).as_dvec3(),
            triangles: Vec::new(),
        })
        .collect();
    for &triangle in &mesh.triangles {
        for v in triangle {
            targets[v as usize]
                .triangles
                .push(positions(mesh, triangle));
        }
    }
    targets
}

fn edges(mesh: &TriangleMesh) -> Vec<Target> {
    let mut of: std::collections::BTreeMap<[u32; 2], Vec<[Vec3; 3]>> = Default::default();
    for &triangle in &mesh.triangles {
        let [a, b, c] = triangle;
        for [p, q] in [[a, b], [b, c], [c, a]] {
            let edge = [p.min(q), p.max(q)];
            of.entry(edge).or_default().push(positions(mesh, triangle));
        }
    }
    let middle = |edge: [u32; 2]| {
        let [p, q] = edge.map(|v| Vec3::from(mesh.positions[v as usize]).as_dvec3());
        0.5 * (p + q)
    };
    of.into_iter()
        .map(|(edge, triangles)| Target {
            at: middle(edge),
            triangles,
        })
        .collect()
}

/// A turned ellipsoid of 5,120 triangles: an icosahedron, its faces cut in
/// four four times. Convex, so that from inside every target is in sight.
pub(super) fn ellipsoid() -> TriangleMesh {
    let golden = f64::midpoint(1.0, 5f64.sqrt());
    let mut points: Vec<DVec3> = Vec::new();
    for (s, t) in [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)] {
        let [a, b] = [s, t * golden];
        points.extend([
            DVec3::new(0.0, a, b),
            DVec3::new(a, b, 0.0),
            DVec3::new(b, 0.0, a),
        ]);
    }
    // Faces are the triples of points 2 apart, wound outwards.
    let near = |i: usize, j: usize| (points[i].distance(points[j]) - 2.0).abs() < 1.0e-9;
    let mut triangles = Vec::new();
    for i in 0..12 {
        for j in i + 1..12 {
            for k in j + 1..12 {
                if near(i, j) && near(j, k) && near(i, k) {
                    let out = (points[j] - points[i]).cross(points[k] - points[i]);
                    let flip = out.dot(points[i]) < 0.0;
                    triangles.push(if flip { [i, k, j] } else { [i, j, k] });
                }
            }
        }
    }
    points.iter_mut().for_each(|p| *p = p.normalize());
    for _ in 0..4 {
        let mut middles = std::collections::HashMap::new();
        let mut middle = |i: usize, j: usize, points: &mut Vec<DVec3>| {
            *middles.entry([i.min(j), i.max(j)]).or_insert_with(|| {
                points.push((points[i] + points[j]).normalize());
                points.len() - 1
            })
        };
        let mut finer = Vec::with_capacity(4 * triangles.len());
        for [i, j, k] in triangles {
            let [a, b, c] = [[i, j], [j, k], [k, i]].map(|[p, q]| middle(p, q, &mut points));
            finer.extend([[i, a, c], [a, j, b], [c, b, k], [a, b, c]]);
        }
        triangles = finer;
    }
    let turn = glam::DQuat::from_euler(glam::EulerRot::YXZ, 0.7, 1.1, 0.2);
    let place = |p: DVec3| single(turn * (p * DVec3::new(1.0, 2.3, 0.37))).to_array();
    TriangleMesh {
        positions: points.into_iter().map(place).collect(),
        triangles: triangles.iter().map(|t| t.map(|v| v as u32)).collect(),
        ..TriangleMesh::default()
    }
}

fn lost_at(seed: u64, effort: Effort, targets: impl Fn(&TriangleMesh) -> Vec<Target>) -> Errors {
    let mesh = ellipsoid();
    let targets = targets(&mesh);
    let Ok(baked) = Baked::<8>::new(&lone_mesh(mesh)) else {
        return BROKEN;
    };
    let scene = baked.scene();
    let Some(tracer) = MeshTracer::new(&scene, 0, Simd::detect()) else {
        return BROKEN;
    };
    let mut stack = TraversalStack::EMPTY;
    let mut inputs = Inputs::new(seed);
    let mut lost = Errors {
        ours: 0.0,
        naive: 0.0,
    };
    for _ in 0..effort.of(5_000_000) {
        let from = inputs.in_ball() * 0.3;
        let target = &targets[inputs.below(targets.len())];
        let Some(ray) = aimed(from, target.at) else {
            continue;
        };
        let hit = tracer.nearest(&ray, &mut stack).0;
        lost.ours += f64::from(u8::from(!hit.is_some_and(|hit| hit.t.is_finite())));
        let naive = |&t: &[Vec3; 3]| moller_trumbore(t, &ray, LEAST).is_some();
        lost.naive += f64::from(u8::from(!target.triangles.iter().any(naive)));
    }
    lost
}

fn shared_edges(effort: Effort) -> Errors {
    lost_at(200, effort, edges)
}

fn shared_vertices(effort: Effort) -> Errors {
    lost_at(201, effort, vertices)
}

/// A triangle from three points, in any order.
fn shuffled(inputs: &mut Inputs, corners: [DVec3; 3]) -> [Vec3; 3] {
    let first = inputs.below(3);
    [0, 1, 2].map(|i| single(corners[(first + i) % 3]))
}

fn slivers(effort: Effort) -> Errors {
    let mut inputs = Inputs::new(202);
    let mut worst = Worst::NONE;
    for _ in 0..effort.of(500_000) {
        let along = inputs.direction();
        let across = inputs.across(along);
        let length = inputs.magnitude(0.0, 3.0);
        let at = inputs.in_ball() * length;
        let width = length * 1.0e-6;
        let tip = at + along * inputs.range(0.2, 0.8) * length + across * width;
        let corners = shuffled(&mut inputs, [at, at + along * length, tip]);
        // Next to the long side, on either side of it, by up to three widths.
        let beside = across * width * inputs.range(-3.0, 3.0);
        let target = at + along * inputs.range(0.0, 1.0) * length + beside;
        let normal = along.cross(across);
        let from = target + (normal + 0.5 * inputs.direction()) * length * inputs.range(0.5, 3.0);
        if let Some(ray) = aimed(from, target) {
            check_verdict(&mut worst, corners, &ray);
        }
    }
    worst.0
}

fn slivers_distance(effort: Effort) -> Errors {
    let mut inputs = Inputs::new(203);
    let mut worst = Worst::NONE;
    for _ in 0..effort.of(500_000) {
        let along = inputs.direction();
        let across = inputs.across(along);
        let slimness = inputs.magnitude(1.0, 5.0);
        let at = inputs.in_ball();
        let tip = at + along * inputs.range(0.2, 0.8) + across / slimness;
        let corners = shuffled(&mut inputs, [at, at + along, tip]);
        let [a, b, c] = corners.map(|c| c.as_dvec3());
        let normal = (b - a).cross(c - a).normalize();
        let (u, v) = (inputs.unit(), inputs.unit());
        let target = a + (b - a) * u * (1.0 - v) + (c - a) * u * v;
        let from = target + (normal + inputs.in_ball() * 0.7).normalize() * 3.0;
        let Some(ray) = aimed(from, target) else {
            continue;
        };
        let unit = UNIT * extent(corners, &ray) * slimness;
        let off = |t: f32| {
            let point = ray.origin().as_dvec3() + ray.direction().as_dvec3() * f64::from(t);
            (point - a).dot(normal) / unit
        };
        if let Some(t) = ours(corners, &ray) {
            worst.ours(off(t));
        }
        if let Some(t) = moller_trumbore(corners, &ray, None) {
            worst.naive(off(t));
        }
    }
    worst.0
}

fn distance(effort: Effort) -> Errors {
    let mut inputs = Inputs::new(204);
    let mut worst = Worst::NONE;
    for _ in 0..effort.of(500_000) {
        let corners = [0; 3].map(|_| single(inputs.in_ball()));
        let [a, b, c] = corners.map(|c| c.as_dvec3());
        let normal = (b - a).cross(c - a);
        // Triangles of a decent shape: the ray is what is hard here.
        if normal.length() < 0.1 {
            continue;
        }
        let normal = normal.normalize();
        let (u, v) = (inputs.unit(), inputs.unit());
        let target = a + (b - a) * u * (1.0 - v) + (c - a) * u * v;
        let slope = inputs.magnitude(-5.0, 0.0);
        let from = target + inputs.across(normal) * 3.0 + normal * 3.0 * slope;
        let Some(ray) = aimed(from, target) else {
            continue;
        };
        let unit = UNIT * extent(corners, &ray);
        let off = |t: f32| {
            let point = ray.origin().as_dvec3() + ray.direction().as_dvec3() * f64::from(t);
            (point - a).dot(normal) / unit
        };
        if let Some(t) = ours(corners, &ray) {
            worst.ours(off(t));
        }
        if let Some(t) = moller_trumbore(corners, &ray, None) {
            worst.naive(off(t));
        }
    }
    worst.0
}

/// Counts hits where there must be none.
fn none_expected(errors: &mut Errors, corners: [Vec3; 3], ray: &Ray) {
    errors.ours += f64::from(u8::from(ours(corners, ray).is_some()));
    errors.naive += f64::from(u8::from(moller_trumbore(corners, ray, None).is_some()));
}

fn coplanar(effort: Effort) -> Errors {
    let mut inputs = Inputs::new(205);
    let mut errors = Errors {
        ours: 0.0,
        naive: 0.0,
    };
    for _ in 0..effort.of(200_000) {
        // On a grid of powers of two everything is exact, and so is the plane.
        let mut at = || (inputs.range(-64.0, 64.0).round() / 8.0) as f32;
        let flat: [[f32; 2]; 5] = [0; 5].map(|_| [at(), at()]);
        let height = at();
        let axis = inputs.below(3);
        let slope = (inputs.below(5) as f32 - 2.0) * 0.5;
        let place = |[x, y]: [f32; 2]| {
            let mut v = [x, y, height + slope * x];
            v.rotate_right(axis);
            Vec3::from_array(v)
        };
        let corners = [place(flat[0]), place(flat[1]), place(flat[2])];
        let from = place(flat[3]);
        // At a corner, at the middle or anywhere else in the plane.
        let target = match inputs.below(3) {
            0 => corners[inputs.below(3)],
            1 => (corners[0] + corners[1]) * 0.5,
            _ => place(flat[4]),
        };
        if let Some(ray) = Ray::new(from, target - from) {
            none_expected(&mut errors, corners, &ray);
        }
    }
    errors
}

fn without_area(effort: Effort) -> Errors {
    let mut inputs = Inputs::new(206);
    let mut worst = Worst::NONE;
    for _ in 0..effort.of(200_000) {
        let mut at = || (inputs.in_ball() * 64.0).round() / 8.0;
        let (a, along) = (at(), at());
        let from = at();
        let places = match inputs.below(3) {
            0 => [0.0; 3],
            1 => [0.0, 1.0, 1.0],
            _ => [0.0, inputs.below(16) as f64 / 8.0, 1.0],
        };
        let first = inputs.below(3);
        let corners = [0, 1, 2].map(|i| single(a + along * places[(first + i) % 3]));
        let target = a + along * inputs.below(9) as f64 / 8.0;
        let Some(ray) = aimed(from, target) else {
            continue;
        };
        let unit = UNIT * extent(corners, &ray);
        // From the ray's line to what there is of the triangle.
        let beside = between_lines(&ray, corners);
        let error = |t: f32| {
            if t.is_finite() {
                beside / unit
            } else {
                f64::INFINITY
            }
        };
        if let Some(t) = ours(corners, &ray) {
            worst.ours(error(t));
        }
        if let Some(t) = moller_trumbore(corners, &ray, None) {
            worst.naive(error(t));
        }
    }
    worst.0
}

/// The least distance of the ray's line from the sides of a triangle.
fn between_lines(ray: &Ray, corners: [Vec3; 3]) -> f64 {
    let (o, d) = (
        ray.origin().as_dvec3(),
        ray.direction().as_dvec3().normalize(),
    );
    // Seen along the ray, where its line is the origin.
    let flat = corners.map(|c| {
        let from = c.as_dvec3() - o;
        from - d * from.dot(d)
    });
    let to_side = |i: usize| {
        let (a, side) = (flat[i], flat[(i + 1) % 3] - flat[i]);
        let length = side.length_squared();
        let part = if length > 0.0 {
            (-a.dot(side) / length).clamp(0.0, 1.0)
        } else {
            0.0
        };
        (a + side * part).length()
    };
    (0..3).map(to_side).fold(f64::INFINITY, f64::min)
}

fn t_junctions(effort: Effort) -> Errors {
    let mut inputs = Inputs::new(208);
    let mut lost = Errors {
        ours: 0.0,
        naive: 0.0,
    };
    for _ in 0..effort.of(500) {
        // Sixteenths, so that the middle is on the edge exactly.
        let mut at = || (inputs.in_ball() * 64.0).round() / 8.0;
        let (a, b, c) = (at(), at(), at());
        let m = a + (b - a) * (1 + inputs.below(7)) as f64 / 8.0;
        let d = a + b - c;
        let corners = [a, b, c, d, m].map(single);
        if (b - a).cross(c - a).length() < 1.0 {
            continue;
        }
        let triangles = vec![[0, 1, 2], [0, 3, 4], [4, 3, 1], [0, 4, 1]];
        let large = [0, 1, 2].map(|i| {
            let [p, q, r]: [u32; 3] = triangles[i];
            [p, q, r].map(|v| corners[v as usize])
        });
        let mesh = TriangleMesh {
            positions: corners.map(|c| c.to_array()).to_vec(),
            triangles,
            ..TriangleMesh::default()
        };
        let scene = Scene {
            background: crate::scene::Background::uniform([64.0; 3]),
            ..lone_mesh(mesh)
        };
        let Ok(baked) = Baked::<8>::new(&scene) else {
            return BROKEN;
        };
        let tracer = Tracer::new(baked.scene(), Simd::detect(), 0);
        let mut workspace = Workspace::new();
        for _ in 0..200 {
            let target = a + (b - a) * inputs.range(0.01, 0.99);
            let from = target + (c - a).cross(b - a).normalize() * 8.0 + inputs.in_ball() * 4.0;
            let Some(ray) = aimed(from, target) else {
                continue;
            };
            let seen = tracer.radiance(&ray, &mut Budget::UNLIMITED.clone(), &mut workspace);
            lost.ours += f64::from(u8::from(seen.red > 32.0));
            let met = |&t: &[Vec3; 3]| moller_trumbore(t, &ray, LEAST).is_some();
            lost.naive += f64::from(u8::from(!large.iter().any(met)));
        }
    }
    lost
}

fn moved_mesh(effort: Effort) -> Errors {
    let away = DVec3::new(1.0e6, -0.5e6, 0.75e6);
    moved(207, effort, quadruped(), away)
}

fn far_millimetres(effort: Effort) -> Errors {
    let mut mesh = ellipsoid();
    for p in &mut mesh.positions {
        *p = p.map(|x| x * 0.02);
    }
    moved(209, effort, mesh, DVec3::new(-1.0e5, 1.0e5, 0.5e5))
}

/// A mesh moved by whole metres.
fn moved(seed: u64, effort: Effort, mesh: TriangleMesh, away: DVec3) -> Errors {
    let moved = Scene {
        objects: vec![Object {
            world_from_object: DAffine3::from_translation(away),
            ..lone_mesh(mesh.clone()).objects[0].clone()
        }],
        ..lone_mesh(mesh.clone())
    };
    let Ok(baked) = Baked::<8>::new(&moved) else {
        return BROKEN;
    };
    let tracer = Tracer::new(baked.scene(), Simd::detect(), 0);
    let mut workspace = Workspace::new();
    let in_world: Vec<[Vec3; 3]> = mesh
        .triangles
        .iter()
        .map(|&t| positions(&mesh, t).map(|p| single(p.as_dvec3() + away)))
        .collect();
    let exact: Vec<[DVec3; 3]> = mesh
        .triangles
        .iter()
        .map(|&t| positions(&mesh, t).map(|p| p.as_dvec3() + away))
        .collect();
    let (low, high) = mesh.bounds();
    let middle = (Vec3::from(low) + Vec3::from(high)).as_dvec3() / 2.0 + away;
    let size = (Vec3::from(high) - Vec3::from(low)).as_dvec3().length();
    let unit = UNIT * away.abs().max_element();
    let mut inputs = Inputs::new(seed);
    let mut worst = Worst::NONE;
    for _ in 0..effort.of(5_000) {
        let from = middle + inputs.direction() * 1.5 * size;
        // The origin as f32 has it: both sides are given the same.
        let from = single(from);
        let target = middle + inputs.in_ball() * 0.5 * size;
        let Some(ray) = Ray::new(from, single((target - from.as_dvec3()).normalize())) else {
            continue;
        };
        let (truth, clear) = nearest(&exact, &ray, 1.0e-4 * size);
        let error = |found: Option<f32>| match (found, truth) {
            (None, None) => 0.0,
            (Some(found), Some(t)) => {
                if clear {
                    (f64::from(found) - t).abs() / unit
                } else {
                    0.0
                }
            }
            _ => {
                if clear {
                    f64::INFINITY
                } else {
                    0.0
                }
            }
        };
        let hit = tracer.nearest(&ray, &mut Budget::UNLIMITED.clone(), &mut workspace);
        worst.ours(error(hit.map(|hit| hit.on.t)));
        let naive = in_world
            .iter()
            .filter_map(|&t| moller_trumbore(t, &ray, LEAST));
        worst.naive(error(naive.min_by(f32::total_cmp)));
    }
    worst.0
}

/// The nearest distance in f64, and whether it is clear which triangle that
/// is: the ray passes by all edges before it by `doubt` or more, metres.
fn nearest(triangles: &[[DVec3; 3]], ray: &Ray, doubt: f64) -> (Option<f64>, bool) {
    let (o, d) = (ray.origin().as_dvec3(), ray.direction().as_dvec3());
    let mut best: Option<f64> = None;
    let mut doubtful = f64::INFINITY;
    for &[a, b, c] in triangles {
        let normal = (b - a).cross(c - a);
        let slope = normal.dot(d);
        if slope == 0.0 {
            continue;
        }
        let t = normal.dot(a - o) / slope;
        let point = o + d * t;
        let inside = [[a, b], [b, c], [c, a]].map(|[p, q]| {
            let across = (q - p).cross(normal);
            -(point - p).dot(across) / across.length()
        });
        let inside = inside.into_iter().fold(f64::INFINITY, f64::min);
        if t < 0.0 || inside < -doubt {
            continue;
        }
        // Seen along its plane it is doubtful as a whole.
        if inside < doubt || slope.abs() < 0.05 * normal.length() {
            doubtful = doubtful.min(t);
        }
        if inside >= 0.0 && best.is_none_or(|best| t < best) {
            best = Some(t);
        }
    }
    let clear = best.map_or(doubtful == f64::INFINITY, |best| doubtful > best);
    (best, clear)
}
