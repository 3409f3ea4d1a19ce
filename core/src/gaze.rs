//! Where the viewer is and where the viewer looks, and how much detail a ray
//! deserves for it.
//!
//! Trackers produce a pose and a line of sight, and the tracer consumes them;
//! they are the whole interface between the two. A [`Gaze`] gives each
//! primary ray a level from 0 to 1, by its angle to the line of sight; the
//! ray's whole tree inherits the level, and [`Detail`] says what it buys.
//!
//! Equation numbers are those of Mochizuki & Makino, "An Efficient Ray
//! Tracing with LOD Control by Human Eyesight for Immersive Display System".

mod acuity;
mod detail;
#[cfg(test)]
pub(crate) mod hostile;
mod level;
mod line_of_sight;
mod visual_field;

pub use acuity::{Acuity, AcuityError};
pub use detail::{Detail, FaceRange, FaceRangeError};
pub(crate) use level::Region;
pub use level::{Gaze, Sight, Zone};
pub use line_of_sight::{LineOfSight, LineOfSightError};
pub use visual_field::{Boundary, VisualField, VisualFieldError, VisualFieldLimits};

use glam::{Quat, Vec3};

/// The pose of a viewer's head.
///
/// Right-handed axes: +X to the viewer's right, +Y up, −Z forward. The
/// identity orientation looks along −Z.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct HeadPose {
    /// The midpoint between the eyes, in metres, in the room's frame.
    pub position: Vec3,
    /// Unit quaternion, `room_from_head`.
    pub orientation: Quat,
}

impl HeadPose {
    /// Returns a pose at the room's origin, looking along −Z.
    pub const IDENTITY: Self = Self {
        position: Vec3::ZERO,
        orientation: Quat::IDENTITY,
    };
}
