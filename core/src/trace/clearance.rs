//! Where rays start that leave a surface, so that rounding does not let them meet it again.

use super::leaves::Leaves;
use super::map::map_vector;
use crate::numeric::{UNIT_ROUNDOFF, largest_magnitude, max, min};
use crate::scene::Scene;
use crate::scene::format::{self, Instance, Mesh, flag};
use crate::shape::Triangle;
use glam::Vec3;

/// Error bound in unit roundoffs of a triangle's points and of its test; of the maps; and of a
/// spheroid with both.
const OF_TRIANGLE: f32 = 6.0;
const OF_MAPS: f32 = 8.0;
const OF_SPHEROID: f32 = 32.0;

/// Least distance: metres. A ray that starts on a triangle meets it, however exact its numbers are.
const LEAST: f32 = 1.0e-20;

/// A part of a shape that rays leave.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place<'a> {
    pub(super) instance: &'a Instance,
    pub(super) triangle: Option<TrianglePlace<'a>>,
}

/// A triangle of a mesh.
#[derive(Clone, Copy, Debug)]
pub(super) struct TrianglePlace<'a> {
    pub(super) mesh: &'a Mesh,
    pub(super) record: &'a format::Triangle,
    pub(super) leaf: u32,
    pub(super) lane: u32,
}

impl<'a> Place<'a> {
    /// Returns how far from a point of the surface, in the room, where it has a unit normal, rays
    /// start that go towards a direction: metres. It grows with a triangle's coordinates along its
    /// normal, not with those along the triangle.
    // Not inlined: several kinds of rays need it.
    #[inline(never)]
    pub(super) fn clearance<const W: usize>(
        &self,
        scene: &Scene<'a, W>,
        (point, normal): (Vec3, Vec3),
        direction: Vec3,
    ) -> f32 {
        let instance = self.instance;
        let Some(triangle) = self.triangle.and_then(|of| of.corners(scene)) else {
            let translation = Vec3::from_array(instance.world_from_object[3]);
            let size = largest_magnitude(point) + largest_magnitude(translation);
            return OF_SPHEROID * UNIT_ROUNDOFF * instance.condition * size;
        };
        // What a step along each of the mesh's axes is along the normal: metres.
        let [x, y, z, _] = instance.world_from_object.map(Vec3::from_array);
        let along = Vec3::new(x.dot(normal), y.dot(normal), z.dot(normal)).abs();
        let corners = triangle.0.iter().fold(Vec3::ZERO, |sum, c| sum + c.abs());
        let there = sizes(&instance.world_from_object, corners);
        let back = sizes(&instance.object_from_world, point.abs());
        let of_maps = normal.abs().dot(there) + along.dot(back);
        // The test shears the triangle along the direction's main axis: its error there counts as
        // far as the direction leans the triangle.
        let d = map_vector(&instance.object_from_world, direction).abs();
        let (main, own, corner) = if d.x >= d.y && d.x >= d.z {
            (d.x, along.x, corners.x)
        } else if d.y >= d.z {
            (d.y, along.y, corners.y)
        } else {
            (d.z, along.z, corners.z)
        };
        let leaning = if main > 0.0 {
            max(along.dot(d) / main - own, 0.0)
        } else {
            0.0
        };
        let of_triangle = along.dot(corners) + leaning * corner;
        (OF_MAPS * of_maps + OF_TRIANGLE * of_triangle) * UNIT_ROUNDOFF + LEAST
    }

    /// Returns the vector from a point of a triangle, in the room, to the bent surface that the
    /// normals of its corners describe (Hanika 2021, "Hacking the Shadow Terminator"); zero where
    /// that is behind the triangle, seen from outside or from inside.
    // Not inlined: rarely needed.
    #[inline(never)]
    pub(super) fn bulge<const W: usize>(
        &self,
        scene: &Scene<'a, W>,
        point: Vec3,
        is_inside: bool,
    ) -> Vec3 {
        if self.instance.flags & flag::SMOOTH == 0 {
            return Vec3::ZERO;
        }
        let found = || {
            let of = self.triangle?;
            let corners = of.corners(scene)?.0;
            let point = super::map::map_point(&self.instance.object_from_world, point);
            let weights = weights(&corners, point)?;
            let mut bulge = Vec3::ZERO;
            for ((&corner, weight), number) in corners.iter().zip(weights).zip(of.record.corners) {
                let number = of.mesh.first_normal.checked_add(number)?;
                let normal = Vec3::from_array(*scene.normals.get(number as usize)?);
                // The point's height over the plane that touches the surface at the corner.
                let height = (point - corner).dot(normal);
                let below = if is_inside {
                    max(height, 0.0)
                } else {
                    min(height, 0.0)
                };
                bulge -= normal * (weight * below);
            }
            Some(map_vector(&self.instance.world_from_object, bulge))
        };
        found().unwrap_or(Vec3::ZERO)
    }
}

impl<'a> TrianglePlace<'a> {
    pub(super) fn corners<const W: usize>(&self, scene: &Scene<'a, W>) -> Option<Triangle> {
        Leaves::new(scene, self.mesh)
            .leaf(self.leaf)?
            .triangle(self.lane)
    }
}

/// Returns the weights of a triangle's corners at a point of it; `None` without an area.
pub(super) fn weights([a, b, c]: &[Vec3; 3], point: Vec3) -> Option<[f32; 3]> {
    let normal = (*b - *a).cross(*c - *a);
    let square = normal.dot(normal);
    let share = |from: Vec3, to: Vec3| (to - from).cross(point - from).dot(normal) / square;
    let (u, v) = (share(*b, *c), share(*c, *a));
    (square > 0.0).then_some([u, v, 1.0 - u - v])
}

/// Returns the sizes of the terms whose sum is a point's place along each axis of a map.
#[inline(always)]
fn sizes(map: &[[f32; 3]; 4], point: Vec3) -> Vec3 {
    let [x, y, z, origin] = map.map(|column| Vec3::from_array(column).abs());
    x * point.x + y * point.y + z * point.z + origin
}
