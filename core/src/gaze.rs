//! Where the viewer is and where the viewer looks.
//!
//! Trackers produce these types and the tracer consumes them; they are the
//! whole interface between the two.

use glam::{Quat, Vec3};

/// The pose of a viewer's head.
///
/// Right-handed axes: +X to the viewer's right, +Y up, −Z forward. The
/// identity orientation looks along −Z.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HeadPose {
    /// The midpoint between the eyes, in metres, in the room's frame.
    pub position: Vec3,
    /// Unit quaternion, `room_from_head`.
    pub orientation: Quat,
}

impl HeadPose {
    /// At the room's origin, looking along −Z.
    pub const IDENTITY: Self = Self {
        position: Vec3::ZERO,
        orientation: Quat::IDENTITY,
    };
}
