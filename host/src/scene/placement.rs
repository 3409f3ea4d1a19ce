//! Where a shape stands in the scene.

use crate::cave::angle::sin_cos_degrees;
use crate::scene::mesh::TriangleMesh;
use crate::scene::motion::{Local, turn};
use glam::{DAffine3, DMat3, DVec3};

/// Where a shape stands: it is scaled, then rotated, then moved.
#[derive(Debug, Clone, Copy)]
pub(super) struct Placement {
    /// Metres.
    pub(super) position: DVec3,
    /// Yaw, pitch and roll: about +Y, then about the turned +X, then about the +Z so turned;
    /// right-handed.
    pub(super) rotation_degrees: [f64; 3],
    pub(super) scale: DVec3,
}

/// The shift and scale that make a mesh's largest side 1 m long, about the origin.
#[derive(Debug, Clone, Copy)]
pub(super) struct Normalisation {
    centre: DVec3,
    pub(super) largest_side: f64,
}

impl Normalisation {
    /// Changes nothing.
    pub(super) const NONE: Self = Self {
        centre: DVec3::ZERO,
        largest_side: 1.0,
    };

    /// `None` where the mesh has no vertices, or all in one place.
    pub(super) fn of(mesh: &TriangleMesh) -> Option<Self> {
        let (low, high) = mesh.bounds();
        let [low, high] = [low, high].map(|corner| DVec3::from(corner.map(f64::from)));
        let largest_side = (high - low).max_element();
        let usable = largest_side.is_finite() && largest_side > 0.0;
        usable.then(|| Self {
            centre: 0.5 * (low + high),
            largest_side,
        })
    }

    pub(super) fn map(&self) -> DAffine3 {
        let scale = DAffine3::from_scale(DVec3::splat(1.0 / self.largest_side));
        scale * DAffine3::from_translation(-self.centre)
    }
}

impl Placement {
    /// Returns the same as the place of a node.
    pub(super) fn local(&self) -> Local {
        Local::Free {
            position: self.position,
            rotation: turn(self.rotation_degrees),
            scale: self.scale,
        }
    }

    /// Returns the map from a shape's coordinates, normalised first, to the world.
    pub(super) fn world_from_object(&self, normalisation: &Normalisation) -> DAffine3 {
        let [(sy, cy), (sp, cp), (sr, cr)] = self.rotation_degrees.map(sin_cos_degrees);
        let yaw = DMat3::from_cols_array(&[cy, 0.0, -sy, 0.0, 1.0, 0.0, sy, 0.0, cy]);
        let pitch = DMat3::from_cols_array(&[1.0, 0.0, 0.0, 0.0, cp, sp, 0.0, -sp, cp]);
        let roll = DMat3::from_cols_array(&[cr, sr, 0.0, -sr, cr, 0.0, 0.0, 0.0, 1.0]);
        let scale = DMat3::from_diagonal(self.scale / normalisation.largest_side);
        let matrix = yaw * pitch * roll * scale;
        DAffine3 {
            matrix3: matrix,
            translation: self.position - matrix * normalisation.centre,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn assert_near(found: DVec3, expected: DVec3) {
        assert!((found - expected).length() < 1e-12, "{found}, {expected}");
    }

    #[test]
    fn yaw_pitch_and_roll_turn_the_way_they_are_documented() {
        let turned = |rotation_degrees, v| {
            let placement = Placement {
                position: DVec3::ZERO,
                rotation_degrees,
                scale: DVec3::ONE,
            };
            let placed = placement.world_from_object(&Normalisation::NONE);
            placed.transform_vector3(v)
        };
        assert_near(turned([90.0, 0.0, 0.0], DVec3::NEG_Z), DVec3::NEG_X);
        assert_near(turned([0.0, 90.0, 0.0], DVec3::NEG_Z), DVec3::Y);
        assert_near(turned([0.0, 0.0, 90.0], DVec3::X), DVec3::Y);
        // Pitch is about the axis that yaw has turned, not the world's X.
        assert_near(turned([90.0, 45.0, 0.0], DVec3::X), DVec3::NEG_Z);
        assert_near(turned([0.0, 90.0, 30.0], DVec3::NEG_Z), DVec3::Y);
        // Scaled first, moved last.
        let placement = Placement {
            position: DVec3::new(10.0, 20.0, 30.0),
            rotation_degrees: [90.0, 0.0, 0.0],
            scale: DVec3::new(2.0, 3.0, 4.0),
        };
        let placed = placement.world_from_object(&Normalisation::NONE);
        let found = placed.transform_point3(DVec3::ONE);
        assert_near(found, DVec3::new(14.0, 23.0, 28.0));
    }
}
