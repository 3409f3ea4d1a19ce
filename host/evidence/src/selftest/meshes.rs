//! Rays and closed meshes: no ray gets through a seam.

use super::input::{Inputs, aimed, single};
use super::triangles::LEAST;
use super::{Case, Effort, Errors, wrong};
use crate::textbook::moller_trumbore;
use glam::{DVec3, Vec3};
use shisen::bake::{Baked, lone_mesh};
use shisen::scene::Scene;
use shisen::scene::mesh::TriangleMesh;
use shisen_core::Simd;
use shisen_core::frame::{Budget, Workspace};
use shisen_core::trace::{MeshTracer, Tracer, TraversalStack};
use std::collections::{BTreeMap, HashMap};

const LOST: &str = "rays lost";
const CLOSED: &str = "from inside a closed mesh every ray meets it";

pub(super) const CASES: &[Case] = cases! {
    [LOST, CLOSED, "Möller and Trumbore's test of the two triangles at the edge"]:
    "mesh-shared-edges", 0.0, |effort| lost_at(200, effort, edges),
        "rays from inside a closed mesh at the middles of its edges";
    [LOST, CLOSED, "Möller and Trumbore's test of the triangles at the vertex"]:
    "mesh-shared-vertices", 0.0, |effort| lost_at(201, effort, vertices),
        "rays from inside a closed mesh at its vertices";
    ["rays that see the background through the seam",
     "the mesh is closed",
     "Möller and Trumbore's test of the three large triangles at the seam"]:
    "mesh-with-t-junctions", 0.0, |effort| wrong(208, effort.of(500), 100.0, t_junctions),
        "an edge with a vertex in its middle, closed by a triangle without area";
};

/// An edge or vertex of a closed mesh: where to aim, and its triangles.
struct Target {
    at: DVec3,
    triangles: Vec<[Vec3; 3]>,
}

pub(super) fn positions(mesh: &TriangleMesh, triangle: [u32; 3]) -> [Vec3; 3] {
    triangle.map(|v| Vec3::from(mesh.positions[v as usize]))
}

/// Returns the parts of a closed mesh, each by its vertices in order: `of` are those of a triangle.
fn targets(mesh: &TriangleMesh, of: fn([u32; 3]) -> Vec<Vec<u32>>) -> Vec<Target> {
    let mut parts: BTreeMap<Vec<u32>, Vec<[Vec3; 3]>> = BTreeMap::new();
    for &triangle in &mesh.triangles {
        for part in of(triangle) {
            let triangles = parts.entry(part).or_default();
            triangles.push(positions(mesh, triangle));
        }
    }
    let middle = |part: &[u32]| {
        let places = part
            .iter()
            .map(|&v| Vec3::from(mesh.positions[v as usize]).as_dvec3());
        places.sum::<DVec3>() / part.len() as f64
    };
    let targets = parts.into_iter().map(|(part, triangles)| Target {
        at: middle(&part),
        triangles,
    });
    targets.collect()
}

fn vertices(triangle: [u32; 3]) -> Vec<Vec<u32>> {
    triangle.map(|v| vec![v]).to_vec()
}

fn edges([a, b, c]: [u32; 3]) -> Vec<Vec<u32>> {
    let edges = [[a, b], [b, c], [c, a]];
    edges.map(|[p, q]| vec![p.min(q), p.max(q)]).to_vec()
}

/// Returns a turned ellipsoid of 5,120 triangles: an icosahedron, its faces cut in
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

fn lost_at(seed: u64, effort: Effort, of: fn([u32; 3]) -> Vec<Vec<u32>>) -> Option<Errors> {
    let mesh = ellipsoid();
    let targets = targets(&mesh, of);
    let baked = Baked::<8>::new(&lone_mesh(mesh)).ok()?;
    let scene = baked.scene();
    let tracer = MeshTracer::new(&scene, 0, Simd::detect())?;
    let mut stack = TraversalStack::EMPTY;
    wrong(seed, effort.of(5_000_000), 0.5, |inputs, lost| {
        let from = inputs.in_ball() * 0.3;
        let target = &targets[inputs.below(targets.len())];
        let ray = aimed(from, target.at)?;
        let hit = tracer.nearest(&ray, &mut stack).0;
        let naive = |&t: &[Vec3; 3]| moller_trumbore(t, &ray, LEAST).is_some();
        lost.wrong(
            !hit.is_some_and(|hit| hit.t.is_finite()),
            !target.triangles.iter().any(naive),
        );
        Some(())
    })
}

fn t_junctions(inputs: &mut Inputs, lost: &mut Errors) -> Option<()> {
    // On a grid, so that the vertex is on the edge exactly.
    let mut at = || (inputs.in_ball() * 64.0).round() / 8.0;
    let (a, b, c) = (at(), at(), at());
    let m = a + (b - a) * (1 + inputs.below(7)) as f64 / 8.0;
    let d = a + b - c;
    let corners = [a, b, c, d, m].map(single);
    if (b - a).cross(c - a).length() < 1.0 {
        return None;
    }
    let mesh = TriangleMesh {
        positions: corners.map(|c| c.to_array()).to_vec(),
        triangles: vec![[0, 1, 2], [0, 3, 4], [4, 3, 1], [0, 4, 1]],
        ..TriangleMesh::default()
    };
    let large = [0, 1, 2].map(|i| positions(&mesh, mesh.triangles[i]));
    let scene = Scene {
        background: shisen::scene::Background::uniform([64.0; 3]),
        ..lone_mesh(mesh)
    };
    let baked = Baked::<8>::new(&scene).ok()?;
    let tracer = Tracer::new(baked.scene(), Simd::detect(), 0);
    let mut workspace = Workspace::new();
    for _ in 0..200 {
        let target = a + (b - a) * inputs.range(0.01, 0.99);
        let from = target + (c - a).cross(b - a).normalize() * 8.0 + inputs.in_ball() * 4.0;
        let Some(ray) = aimed(from, target) else {
            continue;
        };
        let seen = tracer.radiance(&ray, &mut Budget::UNLIMITED.clone(), &mut workspace);
        let met = |&t: &[Vec3; 3]| moller_trumbore(t, &ray, LEAST).is_some();
        lost.wrong(seen.red > 32.0, !large.iter().any(met));
    }
    Some(())
}
