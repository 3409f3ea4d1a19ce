//! What the decoders hand over: samples whose axes and units do not depend
//! on the device.

use glam::{Quat, Vec3};
use shisen_core::gaze::HeadPose;

/// One sample of a head tracker.
///
/// The head's axes are those of [`HeadPose`]: right-handed, +X to the
/// viewer's right, +Y up, −Z forward. The tracker's reference frame is also
/// right-handed with +Y up where the device knows where up is; which way its
/// −Z points is the device's choice. Where the reference frame stands in the
/// room is not known to a decoder and not applied.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HeadSample {
    /// Unit quaternion, `reference_from_head`.
    pub orientation: Quat,
    /// Radians per second about the head's own axes; `None` where the device
    /// does not measure it.
    pub angular_velocity: Option<Vec3>,
    /// The device's own count of its reports; it wraps at the width that the
    /// protocol gives it.
    pub sequence: u32,
    /// Whether the head-mounted display receives a picture; `None` where the
    /// device does not say.
    pub video_detected: Option<bool>,
    /// Whether that picture is taller than wide; `None` where the device does
    /// not say.
    pub portrait: Option<bool>,
}

impl HeadSample {
    /// The head's pose for a device that measures no position: `position` is
    /// the midpoint between the eyes, in metres, in the tracker's reference
    /// frame.
    ///
    /// Where that frame is not the room's, turn the result by
    /// `room_from_reference` before tracing from it.
    pub fn pose_at(&self, position: Vec3) -> HeadPose {
        HeadPose {
            position,
            orientation: self.orientation,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pose_takes_the_position_given_and_the_orientation_measured() {
        let sample = HeadSample {
            orientation: Quat::from_xyzw(0.0, 1.0, 0.0, 0.0),
            angular_velocity: None,
            sequence: 0,
            video_detected: None,
            portrait: None,
        };
        let pose = sample.pose_at(Vec3::new(0.5, 1.7, -0.25));
        assert_eq!(pose.position, Vec3::new(0.5, 1.7, -0.25));
        // Half a turn about Y: the viewer looks along +Z.
        assert_eq!(pose.orientation * Vec3::NEG_Z, Vec3::Z);
    }
}
