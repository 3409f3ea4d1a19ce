//! How far above a surface rays start, so that rounding does not let them meet it again.

use super::map::map_vector;
use super::surface::mapped_normal;
use crate::numeric::{UNIT_ROUNDOFF, largest_magnitude, max, min, sqrt};
use crate::scene::format::Instance;
use crate::shape::Triangle;
use glam::Vec3;

/// Error bound in unit roundoffs of a triangle's points and of its test; of the maps; and of a
/// spheroid with both.
const OF_TRIANGLE: f32 = 16.0;
const OF_MAPS: f32 = 8.0;
const OF_SPHEROID: f32 = 32.0;

/// Least distance: metres. A ray that starts on a triangle meets it, however exact its numbers are.
const LEAST: f32 = 1.0e-20;

/// The distance from a surface beyond which rounding moves nothing across it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Clearance<'a> {
    /// Error of the point across the surface: metres.
    least: f32,
    triangle: Option<Leaning<'a>>,
}

/// What the error of the test of a triangle depends on beside the ray's direction.
#[derive(Clone, Copy, Debug)]
struct Leaning<'a> {
    instance: &'a Instance,
    /// Magnitudes of the normal's components in the mesh's frame.
    normal: Vec3,
    /// Error along each axis of the mesh, as a distance across the triangle: metres.
    error: Vec3,
}

impl<'a> Clearance<'a> {
    pub(super) const NONE: Self = Self {
        least: 0.0,
        triangle: None,
    };

    /// Returns that of a triangle with a unit `normal` in its mesh's frame (or zero), at a point of
    /// the room. It grows with the coordinates along the normal, not with those along the triangle.
    #[inline(always)]
    pub(super) fn of_triangle(
        instance: &'a Instance,
        triangle: &Triangle,
        normal: Vec3,
        point: Vec3,
    ) -> Self {
        let (low, high) = triangle.bounds();
        let (low, high) = (low.abs(), high.abs());
        let most = Vec3::new(max(low.x, high.x), max(low.y, high.y), max(low.z, high.z));
        let in_room = mapped_normal(instance, normal);
        // A metre across the triangle, in the mesh's units.
        let scale = sqrt(in_room.dot(in_room));
        let (normal, in_room) = if scale > 0.0 {
            (normal.abs(), in_room.abs() / scale)
        } else {
            (Vec3::ONE, Vec3::ONE)
        };
        let units = UNIT_ROUNDOFF / max(scale, 1.0e-30);
        let there = sizes(&instance.world_from_object, most);
        let back = sizes(&instance.object_from_world, point.abs());
        let of_maps = in_room.dot(there) * UNIT_ROUNDOFF + normal.dot(back) * units;
        let error = most * (OF_TRIANGLE * units);
        Self {
            least: OF_MAPS * of_maps + normal.dot(error) + LEAST,
            triangle: Some(Leaning {
                instance,
                normal,
                error,
            }),
        }
    }

    /// Returns that of a spheroid at a point of the room.
    pub(super) fn of_spheroid(instance: &Instance, point: Vec3) -> Self {
        let translation = Vec3::from_array(instance.world_from_object[3]);
        let size = largest_magnitude(point) + largest_magnitude(translation);
        Self {
            least: OF_SPHEROID * UNIT_ROUNDOFF * instance.condition * size,
            triangle: None,
        }
    }

    /// Returns the distance for a ray towards a direction: metres.
    #[inline(always)]
    pub(super) fn towards(&self, direction: Vec3) -> f32 {
        let Some(triangle) = &self.triangle else {
            return self.least;
        };
        // The test shears the triangle along the direction's main axis: its error there counts as
        // far as the direction leans the triangle.
        let d = map_vector(&triangle.instance.object_from_world, direction).abs();
        let (n, error) = (triangle.normal, triangle.error);
        let all = n.dot(d);
        let (main, own, error) = if d.x >= d.y && d.x >= d.z {
            (d.x, n.x, error.x)
        } else if d.y >= d.z {
            (d.y, n.y, error.y)
        } else {
            (d.z, n.z, error.z)
        };
        let leaning = if main > 0.0 { all / main - own } else { 0.0 };
        self.least + max(leaning, 0.0) * min(error, f32::MAX)
    }
}

/// Returns the sizes of the terms whose sum is a point's place along each axis of a map.
#[inline(always)]
fn sizes(map: &[[f32; 3]; 4], point: Vec3) -> Vec3 {
    let [x, y, z, origin] = map.map(|column| Vec3::from_array(column).abs());
    x * point.x + y * point.y + z * point.z + origin
}
