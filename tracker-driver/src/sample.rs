//! What the decoders hand over: samples whose axes and units do not depend
//! on the device.
//!
//! A field that a device does not send is `None`. One that it sends but did
//! not measure this time (its last value held, or extrapolated) is a
//! [`Reading`] that is not tracked: valid and tracked are two flags, as in
//! `OpenXR`.

mod parts;

pub use parts::{Part, Parts};

use crate::time::{DeviceTime, Micros};
use glam::{Quat, Vec2, Vec3};

/// A value and whether the device measured it for this sample.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Reading<T> {
    /// The value; finite, and of length 1 as a direction or a rotation.
    pub value: T,
    /// False where the device held or extrapolated the value.
    pub tracked: bool,
}

impl<T> Reading<T> {
    /// Returns a value that was measured.
    pub const fn tracked(value: T) -> Self {
        Self {
            value,
            tracked: true,
        }
    }

    /// Returns a value that the device had to guess.
    pub const fn held(value: T) -> Self {
        Self {
            value,
            tracked: false,
        }
    }
}

/// Where a head is, as far as its tracker knows.
///
/// The head's axes are those of [`HeadPose`](shisen_core::gaze::HeadPose): right-handed, +X to the
/// viewer's right, +Y up, −Z forward. The tracker's frame is right-handed
/// too; what it has to do with the room is not known to a decoder and not
/// applied.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Head {
    /// Metres, in the tracker's frame.
    #[cfg_attr(feature = "defmt", defmt(Debug2Format))]
    pub position: Option<Reading<Vec3>>,
    /// Unit quaternion, `tracker_from_head`.
    #[cfg_attr(feature = "defmt", defmt(Debug2Format))]
    pub orientation: Option<Reading<Quat>>,
    /// Radians per second about the head's own axes.
    #[cfg_attr(feature = "defmt", defmt(Debug2Format))]
    pub angular_velocity: Option<Vec3>,
}

/// One eye, or both taken as one.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Eye {
    /// Where the line of sight starts: metres, in the [`GazeFrame`].
    #[cfg_attr(feature = "defmt", defmt(Debug2Format))]
    pub origin: Option<Reading<Vec3>>,
    /// Where it goes: a unit vector, in the [`GazeFrame`].
    #[cfg_attr(feature = "defmt", defmt(Debug2Format))]
    pub direction: Option<Reading<Vec3>>,
    /// The pupil's diameter.
    pub pupil: Option<Pupil>,
    /// From 0, shut, to 1, wide open.
    pub openness: Option<f32>,
}

impl Eye {
    /// Returns whether nothing is known of this eye.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }
}

/// How large a pupil is.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Pupil {
    /// Its diameter in metres.
    Diameter(f32),
    /// In the device's own units, which depend on its camera.
    Raw(f32),
}

/// The axes of an [`Eye`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum GazeFrame {
    /// The head's: the tracker is worn.
    #[default]
    Head,
    /// The tracker's own: it stands on a desk, or under a screen.
    Tracker,
}

/// A place that is looked at, on a plane that the device knows.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum GazePoint {
    /// Metres from the calibrated area's upper left corner, x to the right and y **down**.
    Plane(#[cfg_attr(feature = "defmt", defmt(Debug2Format))] Vec2),
    /// From (0, 0), the upper left corner of a picture, to (1, 1), the lower right.
    Normalized(#[cfg_attr(feature = "defmt", defmt(Debug2Format))] Vec2),
    /// The device's own units; only a calibration makes a direction of them.
    Raw(#[cfg_attr(feature = "defmt", defmt(Debug2Format))] Vec2),
}

impl GazePoint {
    /// Returns its two numbers, whatever they mean.
    pub const fn numbers(self) -> Vec2 {
        match self {
            Self::Plane(p) | Self::Normalized(p) | Self::Raw(p) => p,
        }
    }
}

/// What a tracker reported at one time.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Sample {
    /// When it was measured, by the device's clock; `None` in a protocol without times.
    pub device_time: Option<DeviceTime>,
    /// When its last byte came in, by the caller's clock.
    pub arrival: Micros,
    /// Which of the device's sensors: 0 is the first.
    pub sensor: u8,
    /// The device's own count of its reports; it wraps at the protocol's width.
    pub sequence: Option<u32>,
    /// The head, or whatever else the sensor is fixed to.
    pub head: Head,
    /// The axes of the three eyes below.
    pub gaze_frame: GazeFrame,
    /// The left eye.
    pub left: Eye,
    /// The right eye.
    pub right: Eye,
    /// Both eyes as the device combines them (the cyclopean eye).
    pub combined: Eye,
    /// What is looked at, where the device says it as a point.
    pub gaze_point: Option<Reading<GazePoint>>,
}

impl Sample {
    /// Returns a sample with its time of arrival and no other part.
    pub fn arrived(arrival: Micros) -> Self {
        Self {
            device_time: None,
            arrival,
            sensor: 0,
            sequence: None,
            head: Head::default(),
            gaze_frame: GazeFrame::default(),
            left: Eye::default(),
            right: Eye::default(),
            combined: Eye::default(),
            gaze_point: None,
        }
    }
}
