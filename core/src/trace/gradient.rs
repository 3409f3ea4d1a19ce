//! How coordinates on textures grow over a surface.

use super::clearance::Place;
use super::map::map_point;
use super::surface::{coordinates, mapped_normal};
use crate::numeric::{max, sqrt};
use crate::scene::Scene;
use core::f32::consts::FRAC_1_PI;
use glam::Vec3;

impl<'a> Place<'a> {
    /// Returns the gradients, in the room, of the first or second coordinates at a point with a unit
    /// normal: per metre. `None` of a triangle without an area.
    // Not inlined: several textures need it.
    #[inline(never)]
    pub(super) fn gradients<const W: usize>(
        &self,
        scene: &Scene<'a, W>,
        (point, normal): (Vec3, Vec3),
        is_second: bool,
    ) -> Option<[Vec3; 2]> {
        let gradients = match &self.triangle {
            Some(_) => self.over_triangle(scene, is_second)?,
            None => around(map_point(&self.instance.object_from_world, point)),
        };
        Some(gradients.map(|own| {
            let own = mapped_normal(self.instance, own);
            own - normal * own.dot(normal)
        }))
    }

    /// Returns the gradients over a triangle, in its mesh's frame.
    fn over_triangle<const W: usize>(
        &self,
        scene: &Scene<'a, W>,
        is_second: bool,
    ) -> Option<[Vec3; 2]> {
        let of = self.triangle?;
        let [a, b, c] = of.corners(scene)?.0;
        let at = |weights| {
            Some(coordinates(scene, of.mesh, of.record, weights)?[usize::from(is_second) % 2])
        };
        let first = at([1.0, 0.0, 0.0])?;
        let [along, across] = [at([0.0, 1.0, 0.0])?, at([0.0, 0.0, 1.0])?];
        let (right, up) = (b - a, c - a);
        let normal = right.cross(up);
        let square = normal.dot(normal);
        let (of_right, of_up) = (up.cross(normal) / square, normal.cross(right) / square);
        let gradient = |axis: usize| {
            of_right * (along[axis % 2] - first[axis % 2])
                + of_up * (across[axis % 2] - first[axis % 2])
        };
        (square > 0.0 && square.is_finite()).then(|| [gradient(0), gradient(1)])
    }
}

/// Returns the gradients of longitude and latitude, as shares of their ranges, at a point of a shape
/// about its own Y axis.
fn around(point: Vec3) -> [Vec3; 2] {
    let square = point.x * point.x + point.z * point.z;
    let (across, whole) = (max(sqrt(square), 1.0e-6), max(point.dot(point), 1.0e-12));
    let east = Vec3::new(point.z, 0.0, -point.x) / (across * across);
    let north = Vec3::new(
        -point.x * point.y / across,
        across,
        -point.z * point.y / across,
    ) / whole;
    [east * (0.5 * FRAC_1_PI), north * FRAC_1_PI]
}
