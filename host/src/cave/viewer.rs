//! Where the viewer's eyes are.

use glam::DVec3;
use shisen_core::gaze::HeadPose;
use std::fmt;

/// Between the pupils of an adult, metres.
pub const DEFAULT_INTERPUPILLARY_DISTANCE: f64 = 0.064;

/// Which eye a picture is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Eye {
    /// The viewer's left.
    Left,
    /// The viewer's right.
    Right,
    /// Midway between the two: for pictures that are not stereo.
    Centre,
}

named!(Eye { Left => "left", Right => "right", Centre => "centre" });

impl Eye {
    /// The two of a stereo pair, left first.
    pub const STEREO: [Self; 2] = [Self::Left, Self::Right];
}

impl fmt::Display for Eye {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// A head and the eyes in it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Viewer {
    /// Where the head is and how it is turned.
    pub pose: HeadPose,
    /// Between the pupils, metres, 0 or more.
    pub interpupillary_distance: f64,
}

impl Default for Viewer {
    /// Returns a viewer at the room's origin, looking along −Z, eyes ±32 mm from it.
    fn default() -> Self {
        Self {
            pose: HeadPose::IDENTITY,
            interpupillary_distance: DEFAULT_INTERPUPILLARY_DISTANCE,
        }
    }
}

impl Viewer {
    /// Returns where an eye is, metres, in the room. Not finite where the pose is not.
    pub fn eye(&self, which: Eye) -> DVec3 {
        let middle = self.pose.position.as_dvec3();
        let half = 0.5 * self.interpupillary_distance;
        let offset = match which {
            Eye::Left => -half,
            Eye::Right => half,
            Eye::Centre => return middle,
        };
        // An f32 quaternion is a unit one to seven digits only.
        let room_from_head = self.pose.orientation.as_dquat();
        let length = room_from_head.length();
        middle + (room_from_head / length) * DVec3::new(offset, 0.0, 0.0)
    }
}
