//! Cameras of models.

use glam::{DMat3, DQuat, DVec3};

/// A camera of a model, in the model's frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Camera {
    /// What its file calls it, or "camera" and its number, from 1.
    pub name: String,
    /// Its own name, where `name` is its node's.
    pub own_name: Option<String>,
    /// Where it is, in the model's units.
    pub position: DVec3,
    /// From its own axes to the model's: it looks along −Z, its top is towards +Y.
    pub orientation: DQuat,
}

impl Camera {
    /// Returns whether its file calls it this.
    pub fn is_called(&self, name: &str) -> bool {
        self.name == name || self.own_name.as_deref() == Some(name)
    }

    /// Returns the turn about the vertical that brings the way it looks above the front, −Z. The
    /// top of its picture decides where it looks straight up or down.
    pub fn front_from_model(&self) -> DMat3 {
        let ahead = self.orientation * DVec3::NEG_Z;
        let top = self.orientation * DVec3::Y;
        let level = |direction: DVec3| DVec3::new(direction.x, 0.0, direction.z);
        let heading = if level(ahead).length() > 1.0e-6 {
            level(ahead)
        } else {
            level(top * -ahead.y)
        };
        let heading = heading.normalize_or(DVec3::NEG_Z);
        DMat3::from_cols(heading.cross(DVec3::Y), DVec3::Y, -heading).transpose()
    }

    /// Returns the way it looks after that turn, at unit length.
    pub fn look(&self) -> DVec3 {
        self.front_from_model() * (self.orientation * DVec3::NEG_Z)
    }
}
