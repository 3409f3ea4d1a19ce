//! Where a shape stands in the scene.

use crate::cave::angle::sin_cos_degrees;
use crate::scene::mesh::TriangleMesh;
use glam::{DAffine3, DMat3, DVec3};

/// Where a shape stands: it is scaled, then rotated, then moved.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Placement {
    /// Where the shape's origin is, metres.
    pub position: DVec3,
    /// Yaw, pitch and roll, degrees: about +Y, then about the turned +X,
    /// then about the +Z so turned; right-handed. A positive yaw turns what
    /// points to −Z towards −X, a positive pitch raises it.
    pub rotation_degrees: [f64; 3],
    /// Along the shape's own axes, above 0.
    pub scale: DVec3,
}

impl Default for Placement {
    /// At the origin, with its own size.
    fn default() -> Self {
        Self {
            position: DVec3::ZERO,
            rotation_degrees: [0.0; 3],
            scale: DVec3::ONE,
        }
    }
}

/// The shift and scale that make a mesh 1 m wide about the origin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Normalisation {
    /// The middle of the vertices' box, in the mesh's units.
    centre: DVec3,
    /// The box's extent along X, in the mesh's units, above 0.
    x_extent: f64,
}

impl Normalisation {
    /// Changes nothing.
    pub const NONE: Self = Self {
        centre: DVec3::ZERO,
        x_extent: 1.0,
    };

    /// How many times longer a box may be along Y or Z than along X.
    const FLATTEST: f64 = 1.0e6;

    /// What normalises a mesh; `None` where its box has no vertices, or less than a
    /// millionth of its largest extent along X.
    pub fn of(mesh: &TriangleMesh) -> Option<Self> {
        let (low, high) = mesh.bounds();
        let (low, high) = (
            DVec3::from_array(low.map(f64::from)),
            DVec3::from_array(high.map(f64::from)),
        );
        let extent = high - low;
        let usable = extent.is_finite()
            && extent.x > 0.0
            && extent.x * Self::FLATTEST >= extent.max_element();
        usable.then(|| Self {
            centre: 0.5 * (low + high),
            x_extent: extent.x,
        })
    }
}

impl Placement {
    /// The map from a shape's coordinates, normalised first, to the world.
    pub fn world_from_object(&self, normalisation: &Normalisation) -> DAffine3 {
        let matrix = self.rotation() * DMat3::from_diagonal(self.scale / normalisation.x_extent);
        DAffine3 {
            matrix3: matrix,
            translation: self.position - matrix * normalisation.centre,
        }
    }

    fn rotation(&self) -> DMat3 {
        let [yaw, pitch, roll] = self.rotation_degrees.map(sin_cos_degrees);
        let about_y = DMat3::from_cols(
            DVec3::new(yaw.1, 0.0, -yaw.0),
            DVec3::Y,
            DVec3::new(yaw.0, 0.0, yaw.1),
        );
        let about_x = DMat3::from_cols(
            DVec3::X,
            DVec3::new(0.0, pitch.1, pitch.0),
            DVec3::new(0.0, -pitch.0, pitch.1),
        );
        let about_z = DMat3::from_cols(
            DVec3::new(roll.1, roll.0, 0.0),
            DVec3::new(-roll.0, roll.1, 0.0),
            DVec3::Z,
        );
        about_y * about_x * about_z
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
                rotation_degrees,
                ..Placement::default()
            };
            placement
                .world_from_object(&Normalisation::NONE)
                .transform_vector3(v)
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
        assert_near(
            placed.transform_point3(DVec3::ONE),
            DVec3::new(14.0, 23.0, 28.0),
        );
    }
}
