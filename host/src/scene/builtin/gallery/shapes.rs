//! Shapes of simple furniture.

use crate::scene::mesh::TriangleMesh;
use glam::{DQuat, DVec3};
use std::f64::consts::TAU;

fn add(mesh: &mut TriangleMesh, position: DVec3, normal: DVec3, coordinates: [f64; 2]) -> u32 {
    mesh.positions.push(position.as_vec3().to_array());
    mesh.normals
        .push(normal.normalize_or(DVec3::Y).as_vec3().to_array());
    mesh.coordinates.push(coordinates.map(|c| c as f32));
    mesh.positions.len() as u32 - 1
}

/// Adds a parallelogram that is seen from where `right` × `up` points.
pub(super) fn add_plate(mesh: &mut TriangleMesh, corner: DVec3, right: DVec3, up: DVec3) {
    let normal = right.cross(up);
    let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let [a, b, c, d] = corners.map(|[u, v]| add(mesh, corner + u * right + v * up, normal, [u, v]));
    mesh.triangles.extend([[a, b, c], [a, c, d]]);
}

/// Returns a parallelogram that is seen from where `right` × `up` points.
pub(super) fn plate(corner: DVec3, right: DVec3, up: DVec3) -> TriangleMesh {
    let mut mesh = TriangleMesh::default();
    add_plate(&mut mesh, corner, right, up);
    mesh
}

/// Adds a box about a point.
pub(super) fn add_block(mesh: &mut TriangleMesh, middle: DVec3, size: DVec3) {
    for (normal, right) in [
        (DVec3::X, DVec3::NEG_Z),
        (DVec3::NEG_X, DVec3::Z),
        (DVec3::Y, DVec3::X),
        (DVec3::NEG_Y, DVec3::X),
        (DVec3::Z, DVec3::X),
        (DVec3::NEG_Z, DVec3::NEG_X),
    ] {
        let up = normal.cross(right);
        let corner = middle + 0.5 * (normal - right - up) * size;
        add_plate(mesh, corner, right * size, up * size);
    }
}

/// Returns what a line of radii and heights sweeps about the Y axis, seen from the left of the line:
/// closed where both ends are on the axis. If `round`, edges across are smooth; edges along the line
/// are sharp.
pub(super) fn lathe(line: &[[f64; 2]], sides: u32, round: bool) -> TriangleMesh {
    let mut mesh = TriangleMesh::default();
    let at = |[radius, height]: [f64; 2], side: u32| {
        let angle = TAU * f64::from(side) / f64::from(sides);
        DVec3::new(radius * angle.cos(), height, -radius * angle.sin())
    };
    let length = (line.len() - 1) as f64;
    for (number, ends) in line.windows(2).enumerate() {
        let [from, to] = [ends[0], ends[1]];
        let [rise, out] = [to[1] - from[1], to[0] - from[0]];
        for side in 0..sides {
            let normal = |side: f64| {
                let angle = TAU * side / f64::from(sides);
                DVec3::new(rise * angle.cos(), -out, -rise * angle.sin())
            };
            let [first, second] = [f64::from(side), f64::from(side + 1)];
            let flat = normal(0.5 * (first + second));
            let [first_normal, second_normal] =
                [first, second].map(|side| if round { normal(side) } else { flat });
            let [u, next_u] = [first, second].map(|side| side / f64::from(sides));
            let [v, next_v] = [number, number + 1].map(|point| point as f64 / length);
            let corners = [
                (at(from, side), first_normal, [u, v]),
                (at(from, (side + 1) % sides), second_normal, [next_u, v]),
                (at(to, (side + 1) % sides), second_normal, [next_u, next_v]),
                (at(to, side), first_normal, [u, next_v]),
            ];
            let [a, b, c, d] = corners.map(|(place, normal, uv)| add(&mut mesh, place, normal, uv));
            if from[0] > 0.0 {
                mesh.triangles.push([a, b, c]);
            }
            if to[0] > 0.0 {
                mesh.triangles.push([a, c, d]);
            }
        }
    }
    mesh
}

/// Adds a thin bar of six sides.
fn add_bar(mesh: &mut TriangleMesh, from: DVec3, along: DVec3, radius: f64) {
    let (x, y) = along.normalize().any_orthonormal_pair();
    let corner = |side: u32| {
        let angle = TAU * f64::from(side) / 6.0;
        radius * (angle.cos() * x + angle.sin() * y)
    };
    for side in 0..6 {
        let (first, second) = (corner(side), corner((side + 1) % 6));
        add_plate(mesh, from + first, second - first, along);
    }
}

/// Returns a railing along a line, with upright bars and a hand rail.
pub(super) fn rail(from: DVec3, along: DVec3, height: f64, bars: u32) -> TriangleMesh {
    let mut mesh = TriangleMesh::default();
    let up = height * DVec3::Y;
    for bar in 0..=bars {
        let foot = from + along * (f64::from(bar) / f64::from(bars));
        add_bar(&mut mesh, foot, up, 0.009);
    }
    add_bar(&mut mesh, from + up, along, 0.025);
    mesh
}

/// Returns leaves on arched stalks from the origin: each a strip of squares that bends outwards.
pub(super) fn branches(count: u32) -> TriangleMesh {
    const PIECES: u32 = 5;
    let mut mesh = TriangleMesh::default();
    for leaf in 0..count {
        let share = f64::from(leaf) / f64::from(count);
        // The golden angle spreads them.
        let turn = DQuat::from_rotation_y(2.399_963 * f64::from(leaf));
        let (length, lean) = (0.95 + 0.5 * share, 1.25 - 0.95 * share);
        let spine = |piece: u32| {
            let s = f64::from(piece) / f64::from(PIECES);
            let angle = lean * (0.35 + 0.85 * s);
            DVec3::new(
                length * s * angle.sin(),
                0.36 + length * s * angle.cos(),
                0.0,
            )
        };
        let half = DVec3::new(0.0, 0.0, 0.13);
        let mut rows = Vec::new();
        for piece in 0..=PIECES {
            let v = f64::from(piece) / f64::from(PIECES);
            let along = spine(piece + 1) - spine(piece);
            let normal = turn * DVec3::new(-along.y, along.x, 0.0);
            let place = |side: f64| turn * (spine(piece) + side * half);
            rows.push([
                add(&mut mesh, place(1.0), normal, [0.0, v]),
                add(&mut mesh, place(-1.0), normal, [1.0, v]),
            ]);
        }
        for pair in rows.windows(2) {
            let ([a, b], [d, c]) = (pair[0], pair[1]);
            mesh.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    mesh
}
