//! Test meshes: the real cow where `SHISEN_COW` names it, and shapes of our
//! own.

use shisen::mesh::TriangleMesh;
use std::collections::HashMap;

/// The vertices moved and scaled so that the box's centre is the origin and
/// the farthest vertex is at `radius`.
pub fn normalised(mut mesh: TriangleMesh, radius: f32) -> TriangleMesh {
    let (low, high) = mesh.bounds();
    let centre: [f32; 3] = std::array::from_fn(|a| low[a].midpoint(high[a]));
    for position in &mut mesh.positions {
        *position = std::array::from_fn(|a| position[a] - centre[a]);
    }
    let length = |p: &[f32; 3]| p.iter().map(|c| c * c).sum::<f32>().sqrt();
    let farthest = mesh.positions.iter().map(length).fold(0.0, f32::max);
    for position in &mut mesh.positions {
        *position = position.map(|c| c * (radius / farthest));
    }
    mesh
}

/// A closed sphere of 20·4^`subdivisions` triangles about the origin.
pub fn icosphere(subdivisions: u32) -> TriangleMesh {
    let g = f64::midpoint(1.0, 5f64.sqrt());
    let mut points: Vec<[f64; 3]> = [-1.0, 1.0]
        .into_iter()
        .flat_map(|a| [-g, g].map(|b| [[0.0, a, b], [a, b, 0.0], [b, 0.0, a]]))
        .flatten()
        .collect();
    let edge = |points: &[[f64; 3]], i: usize, j: usize| {
        let d: f64 = (0..3).map(|k| (points[i][k] - points[j][k]).powi(2)).sum();
        (d - 4.0).abs() < 1e-9
    };
    let mut triangles = Vec::new();
    for i in 0..12 {
        for j in i + 1..12 {
            for k in j + 1..12 {
                if edge(&points, i, j) && edge(&points, j, k) && edge(&points, i, k) {
                    let [a, b, c] = [points[i], points[j], points[k]];
                    let volume = a[0] * (b[1] * c[2] - b[2] * c[1])
                        + a[1] * (b[2] * c[0] - b[0] * c[2])
                        + a[2] * (b[0] * c[1] - b[1] * c[0]);
                    let (j, k) = if volume > 0.0 { (j, k) } else { (k, j) };
                    triangles.push([i as u32, j as u32, k as u32]);
                }
            }
        }
    }
    for _ in 0..subdivisions {
        let mut middle = HashMap::new();
        let mut split = |points: &mut Vec<[f64; 3]>, a: u32, b: u32| {
            *middle.entry((a.min(b), a.max(b))).or_insert_with(|| {
                let (p, q) = (points[a as usize], points[b as usize]);
                points.push(std::array::from_fn(|i| f64::midpoint(p[i], q[i])));
                points.len() as u32 - 1
            })
        };
        let mut finer = Vec::with_capacity(triangles.len() * 4);
        for [a, b, c] in triangles {
            let (ab, bc, ca) = (
                split(&mut points, a, b),
                split(&mut points, b, c),
                split(&mut points, c, a),
            );
            finer.extend([[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]);
        }
        triangles = finer;
    }
    let positions = points
        .into_iter()
        .map(|p| {
            let length = p.iter().map(|c| c * c).sum::<f64>().sqrt();
            p.map(|c| (c / length) as f32)
        })
        .collect();
    TriangleMesh {
        positions,
        triangles,
        ..TriangleMesh::default()
    }
}
