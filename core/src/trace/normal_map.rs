//! Normals that maps bend.

use super::clearance::{Place, weights};
use super::map::map_point;
use super::surface::world_normal;
use crate::numeric::normalize;
use crate::scene::Scene;
use crate::scene::format::{NO_TANGENTS, flag};
use crate::shape::Spheroid;
use glam::Vec3;

/// Normal, tangent and bitangent of a shape in its own frame, as they are interpolated: of about unit
/// length.
struct Frame {
    normal: Vec3,
    tangent: Vec3,
    bitangent: Vec3,
}

impl<'a> Place<'a> {
    /// Returns the outward unit normal, in the room, whose parts along the tangent, the bitangent and
    /// the normal at a point are given, as `MikkTSpace` has them: vectors are interpolated, combined,
    /// and only then normalised. `None` without tangents, or where it points into the surface.
    // Not inlined: rarely needed.
    #[inline(never)]
    pub(super) fn bent<const W: usize>(
        &self,
        scene: &Scene<'a, W>,
        (point, geometric_normal): (Vec3, Vec3),
        parts: Vec3,
    ) -> Option<Vec3> {
        let point = map_point(&self.instance.object_from_world, point);
        let frame = match self.triangle {
            Some(_) => self.over_corners(scene, point)?,
            None => self.around(point),
        };
        let bent = frame.tangent * parts.x + frame.bitangent * parts.y + frame.normal * parts.z;
        world_normal(self.instance, bent).filter(|bent| bent.dot(geometric_normal) > 0.0)
    }

    fn over_corners<const W: usize>(&self, scene: &Scene<'a, W>, point: Vec3) -> Option<Frame> {
        let of = self.triangle?;
        let first = of.mesh.first_tangent;
        if first == NO_TANGENTS {
            return None;
        }
        let corners = of.corners(scene)?.0;
        let weights = weights(&corners, point)?;
        let (mut tangent, mut side, mut smooth) = (Vec3::ZERO, 0.0, Vec3::ZERO);
        for (corner, weight) in of.record.corners.into_iter().zip(weights) {
            let at = |first: u32| Some(first.checked_add(corner)? as usize);
            let [x, y, z, own] = *scene.tangents.get(at(first)?)?;
            tangent += Vec3::new(x, y, z) * weight;
            side += own * weight;
            smooth += Vec3::from_array(*scene.normals.get(at(of.mesh.first_normal)?)?) * weight;
        }
        let normal = if self.instance.flags & flag::SMOOTH != 0 {
            smooth
        } else {
            let [a, b, c] = corners;
            normalize((b - a).cross(c - a))?
        };
        Some(Frame {
            normal,
            tangent,
            bitangent: normal.cross(tangent) * side,
        })
    }

    /// Returns the frame of a shape about its own Y axis, east and north.
    fn around(&self, point: Vec3) -> Frame {
        let normal = Spheroid::of_checked(self.instance.radii).normal(point);
        let east = normalize(Vec3::new(point.z, 0.0, -point.x)).unwrap_or(Vec3::X);
        Frame {
            normal,
            tangent: east,
            bitangent: normal.cross(east),
        }
    }
}
