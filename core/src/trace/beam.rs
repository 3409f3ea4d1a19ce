//! The rays of a square of a picture, from one point, tested against shapes all together.
//!
//! A projective map takes the room to the picture's columns and rows. There each shape is the set
//! of places where linear functions of column and row, or sums of their squares, are not negative:
//! a triangle by its edges (Olano & Greer, "Triangle Scan Conversion using 2D Homogeneous
//! Coordinates", 1997), a spheroid by the lines that meet it. Shadows on a plane take another map.

mod paper;
mod samples;
mod spheroid;
mod triangles;
mod walk;

pub(crate) use paper::{MOST_SURFACES, Seen, Shadows, SurfaceId, Surfaces};
pub(crate) use samples::{BLOCKS, ROW_BLOCKS, SIDE, Samples};
pub(crate) use walk::{Drawing, SelfShadow};

use crate::numeric::{map3, max, sqrt};
use glam::Vec3;

/// What lies between the borders of a square, and where it is in the square's picture.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Beam {
    /// The map, to columns, rows and depth: of a place less the origin, and the origin's.
    rows: [Vec3; 3],
    origin: Vec3,
    offset: Vec3,
    /// Sides of what it sees, pointing inwards, and their distances from the room's origin.
    sides: [(Vec3, f32); 4],
    /// The directions to the picture's first place, to its right and below.
    columns: [Vec3; 3],
    eye: Vec3,
    plane: Option<Plane>,
}

/// Least height over a plane of what casts a shadow on it, over the plane's distance from the eye.
pub(crate) const LEAST_HEIGHT: f32 = 1.0e-4;

/// A plane that shadows fall on.
#[derive(Debug, Clone, Copy)]
struct Plane {
    /// Unit length, on the eye's side.
    normal: Vec3,
    /// Distance from the room's origin.
    distance: f32,
    /// Least height of what casts a shadow: metres.
    least: f32,
    light: Vec3,
    is_directional: bool,
}

/// A shape's frame in the picture's: columns and translation, and the heights over the plane.
#[derive(Debug, Clone, Copy)]
struct Placed {
    axes: [Vec3; 3],
    origin: Vec3,
    heights: [f32; 3],
    height: f32,
}

impl Beam {
    /// Returns the rays from an eye with the directions `first` + x · `right` + y · `below`, x and
    /// y from 0 to `side`; `None` if they are parallel.
    pub(crate) fn new(eye: Vec3, [right, below, first]: [Vec3; 3], side: f32) -> Option<Self> {
        let (x, y, z) = (below.cross(first), first.cross(right), right.cross(below));
        let determinant = right.dot(x);
        if !(determinant.abs() > 0.0) {
            return None;
        }
        let rows = [x, y, z].map(|row| row / determinant);
        let corner = |x: f32, y: f32| first + right * x + below * y;
        let [a, b, c, d] = [
            corner(0.0, 0.0),
            corner(side, 0.0),
            corner(side, side),
            corner(0.0, side),
        ];
        let middle = a + b + c + d;
        let wall = |p: Vec3, q: Vec3| inwards(p.cross(q), middle, eye);
        Some(Self {
            rows,
            origin: eye,
            offset: Vec3::ZERO,
            sides: [wall(a, b), wall(b, c), wall(c, d), wall(d, a)],
            columns: [right, below, first],
            eye,
            plane: None,
        })
    }

    /// Returns shadows of a light in the same picture, on the plane through a point; `None` where
    /// the plane is not in front of all of the square, or the light is not above it.
    pub(crate) fn shadows(
        &self,
        (normal, point): (Vec3, Vec3),
        (light, is_directional): (Vec3, bool),
        side: f32,
    ) -> Option<Self> {
        let normal = if normal.dot(self.eye - point) < 0.0 {
            -normal
        } else {
            normal
        };
        let distance = normal.dot(point);
        let height = distance - normal.dot(self.eye);
        let [right, below, first] = self.columns;
        let mut on = [Vec3::ZERO; 4];
        let mut farthest = 0.0;
        for (on, (x, y)) in on
            .iter_mut()
            .zip([(0.0, 0.0), (side, 0.0), (side, side), (0.0, side)])
        {
            let direction = first + right * x + below * y;
            let t = height / normal.dot(direction);
            if !(t > 0.0 && t < 1.0e6) {
                return None;
            }
            *on = self.eye + direction * t;
            farthest = max(farthest, t * sqrt(direction.dot(direction)));
        }
        let middle = (on[0] + on[1] + on[2] + on[3]) * 0.25;
        let least = LEAST_HEIGHT * farthest;
        let map = |v: Vec3| Vec3::from_array(map3(self.rows, |row: Vec3| row.dot(v)));
        let (origin, offset, scale, towards) = if is_directional {
            let along = normal.dot(light);
            if !(along > 1.0e-3) {
                return None;
            }
            let turned = map(light) / along;
            (self.eye, turned * height, (1.0, turned), [light; 4])
        } else {
            let up = normal.dot(light) - distance;
            if !(up > least) {
                return None;
            }
            (
                light,
                Vec3::ZERO,
                (up, map(light - self.eye)),
                on.map(|p| light - p),
            )
        };
        let (by, turned) = scale;
        let rows = [
            self.rows[0] * by - normal * turned.x,
            self.rows[1] * by - normal * turned.y,
            self.rows[2] * by - normal * turned.z,
        ];
        let wall =
            |i: usize, j: usize| inwards(towards[i].cross(on[j] - on[i]), middle - on[i], on[i]);
        Some(Self {
            rows,
            origin,
            offset,
            sides: [wall(0, 1), wall(1, 2), wall(2, 3), wall(3, 0)],
            plane: Some(Plane {
                normal,
                distance,
                least,
                light,
                is_directional,
            }),
            ..*self
        })
    }

    /// Returns the place in the picture of a point of the room, times its depth, and the depth.
    #[inline(always)]
    pub(crate) fn place(&self, point: Vec3) -> Vec3 {
        self.turned(point - self.origin) + self.offset
    }

    #[inline(always)]
    fn turned(&self, v: Vec3) -> Vec3 {
        let [x, y, z] = self.rows;
        Vec3::new(x.dot(v), y.dot(v), z.dot(v))
    }

    /// Returns a frame (columns and translation, to metres) in the picture's.
    #[inline(always)]
    fn placed(&self, axes: [Vec3; 3], translation: Vec3) -> Placed {
        let (normal, height) = match &self.plane {
            Some(plane) => (plane.normal, plane.normal.dot(translation) - plane.distance),
            None => (Vec3::ZERO, 0.0),
        };
        Placed {
            axes: axes.map(|axis| self.turned(axis)),
            origin: self.place(translation),
            heights: axes.map(|axis| normal.dot(axis)),
            height,
        }
    }
}

/// Returns a side with its normal turned towards a point (less the side's own), and its distance.
fn inwards(normal: Vec3, middle: Vec3, at: Vec3) -> (Vec3, f32) {
    let normal = if normal.dot(middle) < 0.0 {
        -normal
    } else {
        normal
    };
    (normal, -normal.dot(at))
}
