//! The default model: a cow, generated rather than shipped.
//!
//! A smooth union of tapered capsules and ellipsoids, polygonised by naive surface nets and
//! simplified by quadric edge collapse. It stands in for the well-known `cow.obj`: same axes,
//! nearly the same box, the same number of triangles.

use fast_surface_nets::ndshape::{RuntimeShape, Shape};
use fast_surface_nets::{SurfaceNetsBuffer, surface_nets};
use glam::Vec3;
use meshopt::SimplifyOptions;

use crate::scene::mesh::TriangleMesh;

const TRIANGLES: usize = 5_804;
/// Edge of a grid cell. The thinnest tip has to span three, or the surface net pinches.
const CELL: f32 = 0.07;
/// Samples along each edge of a block that is filled at once where it lies far from the surface.
const BLOCK: u32 = 4;
/// Lowest corner of the sampled box. The box is symmetric in z.
const LOW: Vec3 = Vec3::new(-4.9, -3.85, -1.96);
/// Samples along each axis; the highest corner is (6.3, 3.08, 1.96).
const SAMPLES: [u32; 3] = [161, 100, 57];
const GROUND: f32 = -3.64;

/// One part of the animal, by the width of its seam to the rest.
#[derive(Clone, Copy)]
enum Part {
    /// One end and its radius, the other end and its radius.
    Limb(f32, [f32; 3], f32, [f32; 3], f32),
    /// Centre and radii.
    Ellipsoid(f32, [f32; 3], [f32; 3]),
}

use Part::{Ellipsoid, Limb};

/// The left half and the middle, +X ahead and +Y up; the right half mirrors the left one.
const PARTS: &[Part] = &[
    // Trunk: barrel, hips, shoulders, brisket and the line of the back.
    Ellipsoid(0.0, [-0.7, -0.15, 0.0], [3.0, 1.6, 1.62]),
    Ellipsoid(0.6, [-2.75, 0.5, 0.0], [1.15, 1.2, 1.2]),
    Ellipsoid(0.6, [1.75, 0.2, 0.0], [1.35, 1.55, 1.2]),
    Ellipsoid(0.5, [2.75, -0.45, 0.0], [0.75, 0.95, 0.62]),
    Limb(0.5, [-3.4, 1.3, 0.0], 0.4, [1.9, 1.35, 0.0], 0.45),
    Limb(0.3, [-3.0, 1.2, 0.35], 0.3, [-2.6, 1.15, 0.95], 0.2),
    // Neck, dewlap and head.
    Limb(0.6, [2.2, 0.7, 0.0], 1.1, [4.05, 1.7, 0.0], 0.66),
    Limb(0.4, [3.0, -0.2, 0.0], 0.4, [4.2, 1.1, 0.0], 0.3),
    Limb(0.3, [4.3, 1.9, 0.0], 0.62, [5.4, 1.12, 0.0], 0.4),
    Limb(0.2, [4.45, 1.45, 0.0], 0.45, [5.3, 0.9, 0.0], 0.28),
    Ellipsoid(0.2, [5.53, 0.98, 0.0], [0.44, 0.38, 0.46]),
    Ellipsoid(0.1, [5.83, 1.1, 0.22], [0.14, 0.16, 0.15]),
    Ellipsoid(0.1, [4.72, 1.88, 0.5], [0.17, 0.15, 0.13]),
    Limb(0.15, [4.5, 2.1, 0.42], 0.15, [4.85, 1.98, 0.42], 0.13),
    // Ear and horn.
    Limb(0.15, [4.0, 2.05, 0.5], 0.15, [3.95, 2.0, 0.85], 0.16),
    Ellipsoid(0.12, [3.92, 1.95, 1.05], [0.26, 0.15, 0.46]),
    Limb(0.1, [4.2, 2.25, 0.3], 0.2, [4.15, 2.42, 0.72], 0.16),
    Limb(0.06, [4.15, 2.42, 0.72], 0.16, [4.3, 2.68, 0.93], 0.1),
    // Foreleg.
    Limb(0.4, [1.95, -0.5, 0.72], 0.62, [2.05, -1.95, 0.72], 0.34),
    Limb(0.15, [2.05, -1.95, 0.72], 0.33, [2.0, -3.05, 0.72], 0.22),
    Limb(0.1, [2.0, -3.1, 0.72], 0.25, [2.05, -3.2, 0.72], 0.25),
    Limb(0.06, [2.06, -3.38, 0.72], 0.27, [2.2, -3.62, 0.72], 0.33),
    // Hind leg.
    Ellipsoid(0.5, [-2.75, -0.3, 0.72], [1.0, 1.35, 0.62]),
    Limb(0.4, [-2.5, -0.9, 0.82], 0.6, [-3.2, -2.0, 0.8], 0.32),
    Limb(0.15, [-3.2, -2.0, 0.8], 0.32, [-2.95, -3.05, 0.8], 0.22),
    Limb(0.1, [-2.95, -3.1, 0.8], 0.25, [-2.9, -3.2, 0.8], 0.25),
    Limb(0.06, [-2.9, -3.38, 0.8], 0.27, [-2.76, -3.62, 0.8], 0.33),
    // Udder.
    Ellipsoid(0.3, [-1.75, -1.6, 0.0], [0.7, 0.5, 0.55]),
    Limb(0.1, [-1.5, -2.0, 0.25], 0.12, [-1.48, -2.2, 0.27], 0.1),
    Limb(0.1, [-1.95, -2.0, 0.25], 0.12, [-1.97, -2.2, 0.27], 0.1),
    // Tail and its tuft.
    Limb(0.25, [-3.5, 1.35, 0.0], 0.25, [-4.1, 1.2, 0.0], 0.16),
    Limb(0.1, [-4.1, 1.2, 0.0], 0.16, [-4.4, 0.3, 0.0], 0.12),
    Limb(0.06, [-4.4, 0.3, 0.0], 0.12, [-4.45, -0.9, 0.0], 0.11),
    Limb(0.12, [-4.45, -1.0, 0.0], 0.13, [-4.4, -1.45, 0.0], 0.2),
    Limb(0.1, [-4.4, -1.45, 0.0], 0.2, [-4.3, -1.95, 0.0], 0.07),
];

impl Part {
    const fn blend(self) -> f32 {
        match self {
            Limb(blend, ..) | Ellipsoid(blend, ..) => blend,
        }
    }

    /// About the distance from `p` to the surface, negative inside.
    fn distance(self, p: Vec3) -> f32 {
        match self {
            Limb(_, a, r0, b, r1) => {
                let (a, b) = (Vec3::from(a), Vec3::from(b));
                let axis = b - a;
                let t = ((p - a).dot(axis) / axis.length_squared()).clamp(0.0, 1.0);
                (p - (a + axis * t)).length() - (r0 + (r1 - r0) * t)
            }
            // Quilez' bound: first order exact at the surface.
            Ellipsoid(_, centre, radii) => {
                let radii = Vec3::from(radii);
                let q = (p - Vec3::from(centre)) / radii;
                let slope = (q / radii).length();
                let k = q.length();
                if slope > 0.0 {
                    k * (k - 1.0) / slope
                } else {
                    -radii.min_element()
                }
            }
        }
    }
}

/// Quilez' polynomial smooth minimum.
fn smooth_min(a: f32, b: f32, blend: f32) -> f32 {
    if blend <= 0.0 {
        return a.min(b);
    }
    let h = (blend - (a - b).abs()).max(0.0) / blend;
    a.min(b) - h * h * blend * 0.25
}

/// About the signed distance to the animal's surface, negative inside.
fn field(p: Vec3) -> f32 {
    let left = Vec3::new(p.x, p.y, p.z.abs());
    let union = PARTS.iter().fold(f32::MAX, |distance, part| {
        smooth_min(distance, part.distance(left), part.blend())
    });
    union.max(GROUND - p.y)
}

/// Returns the field at every grid point; far from the surface, only its sign and that it is far
/// are right.
fn sample(shape: &RuntimeShape<u32, 3>) -> Vec<f32> {
    let mut samples = vec![0.0; shape.usize()];
    let [nx, ny, nz] = SAMPLES;
    let point = |x: u32, y: u32, z: u32| LOW + CELL * Vec3::new(x as f32, y as f32, z as f32);
    let half = Vec3::splat(0.5 * CELL * (BLOCK - 1) as f32);
    // Twice the distance to a block's corner: the field is steeper than a
    // true distance in places, but never twice as steep.
    let far = 2.0 * half.length();
    let starts = |n: u32| (0..n).step_by(BLOCK as usize);
    // The right half, z below 0, mirrors the left one.
    let middle = nz / 2;
    for z0 in starts(middle + 1) {
        for y0 in starts(ny) {
            for x0 in starts(nx) {
                let centre = field(point(x0, y0, z0) + half);
                for z in z0..(z0 + BLOCK).min(middle + 1) {
                    for y in y0..(y0 + BLOCK).min(ny) {
                        for x in x0..(x0 + BLOCK).min(nx) {
                            let value = if centre.abs() > far {
                                centre
                            } else {
                                field(point(x, y, z))
                            };
                            samples[shape.linearize([x, y, z]) as usize] = value;
                            samples[shape.linearize([x, y, nz - 1 - z]) as usize] = value;
                        }
                    }
                }
            }
        }
    }
    samples
}

fn onto_surface(p: Vec3) -> Vec3 {
    let step = 0.25 * CELL;
    let slope = |axis: Vec3| (field(p + step * axis) - field(p - step * axis)) / (2.0 * step);
    let gradient = Vec3::new(slope(Vec3::X), slope(Vec3::Y), slope(Vec3::Z));
    let steepness = gradient.length_squared();
    if steepness < 0.01 {
        return p;
    }
    let move_by = gradient * (-field(p) / steepness);
    let length = move_by.length();
    let most = 0.5 * CELL;
    if length > most {
        p + move_by * (most / length)
    } else {
        p + move_by
    }
}

/// Generates the default model: a standing cow, 5,804 triangles, closed and
/// in one piece, seen counter-clockwise from outside.
///
/// +X points ahead, +Y up; the box is about (-4.6, -3.6, -1.6) to
/// (6.0, 2.8, 1.6). It has neither normals nor materials. Every call gives
/// the same mesh, bit for bit; it takes about 100 ms when optimised.
pub fn quadruped() -> TriangleMesh {
    let shape = RuntimeShape::<u32, 3>::new(SAMPLES);
    let samples = sample(&shape);
    let mut net = SurfaceNetsBuffer::default();
    surface_nets(&samples, &shape, [0; 3], SAMPLES.map(|n| n - 1), &mut net);
    let indices = meshopt::simplify_decoder(
        &net.indices,
        &net.positions,
        3 * TRIANGLES,
        // No limit: the number of triangles alone ends the collapse.
        f32::MAX,
        SimplifyOptions::RegularizeLight,
        None,
    );
    compact(&indices, &net.positions)
}

/// Keeps the grid positions that the triangles use, in the order of their
/// first use, and brings them onto the surface.
fn compact(indices: &[u32], grid: &[[f32; 3]]) -> TriangleMesh {
    let mut mesh = TriangleMesh::default();
    let mut renamed = vec![u32::MAX; grid.len()];
    for corners in indices.as_chunks::<3>().0 {
        mesh.triangles.push(corners.map(|old| {
            let new = &mut renamed[old as usize];
            if *new == u32::MAX {
                *new = mesh.positions.len() as u32;
                let p = LOW + CELL * Vec3::from_array(grid[old as usize]);
                mesh.positions.push(onto_surface(p).to_array());
            }
            *new
        }));
    }
    mesh
}
