//! Rays and closed meshes, and meshes far away.

use super::input::{Inputs, aimed, single};
use super::triangles::{LEAST, moller_trumbore};
use super::{BROKEN, Case, Effort, Errors, UNIT, Worst};
use crate::bake::{Baked, lone_mesh};
use crate::mesh::TriangleMesh;
use crate::quadruped::quadruped;
use crate::scene::{Object, Scene};
use glam::{DAffine3, DVec3, Vec3};
use shisen_core::Simd;
use shisen_core::shape::Ray;
use shisen_core::trace::{Budget, MeshTracer, Tracer, TraversalStack, Workspace};
use std::collections::{BTreeMap, HashMap};

const LOST: &str = "rays lost";
const CLOSED: &str = "from inside a closed mesh every ray meets it";
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
        // Where the object is, a few roundings of 5 cm are this part of one of 100 km.
        bound: 5.0e-5,
        measure: far_millimetres,
    },
    Case {
        name: "mesh-a-million-metres-away",
        hard: "an animal of 2 m moved by 1,000 km, seen from 3 m",
        error: MOVED,
        reference: MOVED_REFERENCE,
        naive: MOVED_NAIVE,
        bound: 5.0e-4,
        measure: moved_mesh,
    },
];

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
    let mut of: BTreeMap<[u32; 2], Vec<[Vec3; 3]>> = BTreeMap::new();
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
    for p in &mut points {
        *p = p.normalize();
    }
    for _ in 0..4 {
        let mut middles = HashMap::new();
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
    moved(207, effort, &quadruped(), away)
}

fn far_millimetres(effort: Effort) -> Errors {
    let mut mesh = ellipsoid();
    for p in &mut mesh.positions {
        *p = p.map(|x| x * 0.02);
    }
    moved(209, effort, &mesh, DVec3::new(-1.0e5, 1.0e5, 0.5e5))
}

/// A mesh moved by whole metres.
fn moved(seed: u64, effort: Effort, mesh: &TriangleMesh, away: DVec3) -> Errors {
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
        .map(|&t| positions(mesh, t).map(|p| single(p.as_dvec3() + away)))
        .collect();
    let exact: Vec<[DVec3; 3]> = mesh
        .triangles
        .iter()
        .map(|&t| positions(mesh, t).map(|p| p.as_dvec3() + away))
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
