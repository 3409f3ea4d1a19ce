//! Test meshes: the real cow where `SHISEN_COW` names it, and shapes of our
//! own.

use glam::{DMat3, DQuat, DVec3, Vec3};
use shisen::scene::mesh::TriangleMesh;
use std::collections::HashMap;
use std::fmt::Write as _;
use std::path::Path;
use std::sync::Once;

/// Returns the generated quadruped, and the cow where `SHISEN_COW` names its file.
pub fn meshes() -> Vec<(&'static str, TriangleMesh)> {
    let mut meshes = vec![("quadruped", shisen::scene::quadruped::quadruped())];
    meshes.extend(cow().map(|cow| ("cow", cow)));
    meshes
}

/// Returns the cow, where `SHISEN_COW` names its file; else says once that it is missing.
pub fn cow() -> Option<TriangleMesh> {
    static TOLD: Once = Once::new();
    let Some(file) = std::env::var_os("SHISEN_COW") else {
        TOLD.call_once(|| println!("cow: not given; SHISEN_COW=FILE adds it"));
        return None;
    };
    Some(
        shisen::scene::import::load(Path::new(&file))
            .expect("SHISEN_COW names a mesh")
            .mesh,
    )
}

/// Writes `ball.obj`: a mesh of few faces, which is quickly read and baked.
pub fn write_ball(folder: &Path) {
    let mesh = icosphere(2);
    let mut text = String::new();
    for [x, y, z] in &mesh.positions {
        writeln!(text, "v {x} {y} {z}").expect("text");
    }
    for [a, b, c] in mesh.triangles.iter().map(|t| t.map(|i| i + 1)) {
        writeln!(text, "f {a} {b} {c}").expect("text");
    }
    std::fs::write(folder.join("ball.obj"), text).expect("a file");
}

/// Returns a cube from −1 to 1, its faces cut into `cells`² squares of two triangles.
pub fn gridded_cube(cells: u32) -> TriangleMesh {
    let mut numbers = HashMap::new();
    let mut mesh = TriangleMesh::default();
    let at = |i: u32| (2.0 * f64::from(i) / f64::from(cells) - 1.0) as f32;
    for (axis, side) in (0..3).flat_map(|axis| [(axis, 0), (axis, cells)]) {
        let mut vertex = |i: u32, j: u32| {
            let mut place = [0; 3];
            place[axis] = side;
            place[(axis + 1) % 3] = i;
            place[(axis + 2) % 3] = j;
            *numbers.entry(place).or_insert_with(|| {
                mesh.positions.push(place.map(at));
                mesh.positions.len() as u32 - 1
            })
        };
        for (i, j) in (0..cells).flat_map(|i| (0..cells).map(move |j| (i, j))) {
            let corners = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)];
            let [a, b, c, d] = corners.map(|(i, j)| vertex(i, j));
            mesh.triangles.extend(if side == 0 {
                [[a, c, b], [a, d, c]]
            } else {
                [[a, b, c], [a, c, d]]
            });
        }
    }
    mesh
}

/// Returns the vertices moved and scaled so that the box's centre is the origin and
/// the farthest vertex is at `radius`.
pub fn normalised(mut mesh: TriangleMesh, radius: f32) -> TriangleMesh {
    let (low, high) = mesh.bounds();
    let centre = Vec3::from(low).midpoint(high.into());
    let off = |p: &[f32; 3]| Vec3::from(*p) - centre;
    let farthest = mesh.positions.iter().map(|p| off(p).length());
    let scale = radius / farthest.fold(0.0, f32::max);
    for position in &mut mesh.positions {
        *position = (off(position) * scale).to_array();
    }
    mesh
}

/// Returns a closed sphere of 20·4^`subdivisions` triangles about the origin.
pub fn icosphere(subdivisions: u32) -> TriangleMesh {
    let g = f64::midpoint(1.0, 5f64.sqrt());
    let mut points: Vec<DVec3> = [-1.0, 1.0]
        .into_iter()
        .flat_map(|a| [-g, g].map(|b| [[0.0, a, b], [a, b, 0.0], [b, 0.0, a]]))
        .flatten()
        .map(DVec3::from)
        .collect();
    let mut triangles = Vec::new();
    for (i, j, k) in
        (0..12).flat_map(|i| (i..12).flat_map(move |j| (j..12).map(move |k| (i, j, k))))
    {
        let [a, b, c] = [i, j, k].map(|corner| points[corner as usize]);
        let sides = [a - b, b - c, c - a].map(DVec3::length_squared);
        if sides.iter().all(|side| (side - 4.0).abs() < 1e-9) {
            let outwards = a.dot(b.cross(c)) > 0.0;
            triangles.push(if outwards { [i, j, k] } else { [i, k, j] });
        }
    }
    for _ in 0..subdivisions {
        let mut middle = HashMap::new();
        let mut split = |a: u32, b: u32| {
            *middle.entry((a.min(b), a.max(b))).or_insert_with(|| {
                points.push(points[a as usize].midpoint(points[b as usize]));
                points.len() as u32 - 1
            })
        };
        let finer = triangles.into_iter().flat_map(|[a, b, c]| {
            let (ab, bc, ca) = (split(a, b), split(b, c), split(c, a));
            [[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]
        });
        triangles = finer.collect();
    }
    let positions = points
        .iter()
        .map(|&p| (p / p.length()).as_vec3().to_array());
    TriangleMesh {
        positions: positions.collect(),
        triangles,
        ..TriangleMesh::default()
    }
}

/// Returns a turned ellipsoid with no symmetry to help, around the origin.
pub fn ellipsoid() -> TriangleMesh {
    let map = DMat3::from_quat(DQuat::from_rotation_y(0.7) * DQuat::from_rotation_x(1.1))
        * DMat3::from_diagonal(DVec3::new(1.0, 2.3, 0.37));
    let mut mesh = icosphere(5);
    for position in &mut mesh.positions {
        *position = (map * Vec3::from(*position).as_dvec3())
            .as_vec3()
            .to_array();
    }
    mesh
}

/// Returns where a vertex is.
pub fn position(mesh: &TriangleMesh, vertex: u32) -> DVec3 {
    Vec3::from(mesh.positions[vertex as usize]).as_dvec3()
}

/// Returns each edge, once.
pub fn edges(mesh: &TriangleMesh) -> Vec<[u32; 2]> {
    let mut sides = HashMap::new();
    for &[a, b, c] in &mesh.triangles {
        for [p, q] in [[a, b], [b, c], [c, a]] {
            *sides.entry([p.min(q), p.max(q)]).or_insert(0) += if p < q { 1 } else { -1 };
        }
    }
    assert!(
        sides.values().all(|&sum| sum == 0),
        "a mesh that is not closed"
    );
    let mut edges: Vec<_> = sides.into_keys().collect();
    edges.sort_unstable();
    edges
}

/// Returns a closed torus about the Y axis of 2·`around`·`across` triangles, wobbling
/// so that it is nowhere the same.
pub fn torus(around: u32, across: u32) -> TriangleMesh {
    let mut mesh = TriangleMesh::default();
    for (i, j) in (0..around).flat_map(|i| (0..across).map(move |j| (i, j))) {
        let turn = |k, n| f64::from(k) / f64::from(n) * std::f64::consts::TAU;
        let (u, v) = (turn(i, around), turn(j, across));
        let r = 3.0 + (1.0 + 0.2 * (3.0 * u).sin()) * v.cos();
        let place = [r * u.cos(), (1.0 + 0.1 * u.cos()) * v.sin(), -r * u.sin()];
        mesh.positions.push(place.map(|c| c as f32));
        let vertex = |i: u32, j: u32| i % around * across + j % across;
        let [a, b] = [vertex(i, j), vertex(i + 1, j)];
        let [c, d] = [vertex(i + 1, j + 1), vertex(i, j + 1)];
        mesh.triangles.extend([[a, b, c], [a, c, d]]);
    }
    mesh
}

/// Returns the same surface with three vertices and normals of its own for every
/// triangle.
pub fn faceted(mesh: &TriangleMesh) -> TriangleMesh {
    let mut facets = TriangleMesh::default();
    for triangle in &mesh.triangles {
        let corners = triangle.map(|corner| mesh.positions[corner as usize]);
        let [a, b, c] = corners.map(Vec3::from);
        let normal = (b - a).cross(c - a).try_normalize().expect("an area");
        let first = facets.positions.len() as u32;
        facets.triangles.push([first, first + 1, first + 2]);
        facets.positions.extend(corners);
        facets.normals.extend([normal.to_array(); 3]);
    }
    facets
}
