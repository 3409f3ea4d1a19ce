//! Why there is no dome master, or none on a dome screen.

use super::MirrorCamera;
use crate::frame::view::{DomeScreen, View};
use crate::shape::Ray;
use core::f32::consts::TAU;
use core::fmt;
use glam::{Mat3, Vec3};

/// Why there is no such dome master.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum DomeError {
    /// No pixels, or more than [`View::MOST_PIXELS`] a side.
    Size {
        /// Pixels a side.
        size: u32,
    },
    /// The viewpoint is not finite or too far out.
    Position {
        /// Where it is: metres.
        #[cfg_attr(feature = "defmt", defmt(Debug2Format))]
        position: Vec3,
    },
    /// The axes are not of unit length, right angles and right-handed, within
    /// [`DomeError::SKEW`], or not finite.
    Axes {
        /// The axes.
        #[cfg_attr(feature = "defmt", defmt(Debug2Format))]
        axes: Mat3,
    },
    /// The field of view is NaN, 0 or less, or more than 2π.
    FieldOfView {
        /// Radians.
        field_of_view: f32,
    },
    /// The mirror's size is NaN or outside [`MirrorCamera::RADII`].
    Radius {
        /// Its equatorial radius: metres.
        radius: f32,
    },
    /// The mirror's point at the position is NaN or too far off.
    Viewpoint {
        /// Equatorial radii from the mirror's centre.
        viewpoint: f32,
    },
    /// The screen's size is NaN or outside [`DomeScreen::RADII`].
    ScreenRadius {
        /// Of the screen: metres.
        radius: f32,
    },
    /// The eye is not finite, or farther from the screen's centre than
    /// [`DomeScreen::FARTHEST_EYE`].
    Eye {
        /// Where it is: metres, in the room.
        #[cfg_attr(feature = "defmt", defmt(Debug2Format))]
        eye: Vec3,
        /// From it to the screen's centre: radii.
        distance: f32,
    },
}

impl DomeError {
    /// How far axes may be from unit length and right angles: of 1.
    pub const SKEW: f32 = 1.0e-5;

    /// Coordinates of a position may be so far out: metres. What is around the
    /// mirror can still be traced.
    pub(super) const FARTHEST: f32 = 0.5 * Ray::FARTHEST;
}

impl fmt::Display for DomeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Size { size } => write!(
                f,
                "a dome master of {size} pixels a side: give 1 to {}",
                View::MOST_PIXELS
            ),
            Self::Position { position } => write!(
                f,
                "the dome master's position is {position}: give three numbers from -{0:e} to {0:e}",
                Self::FARTHEST
            ),
            Self::Axes { axes } => write!(
                f,
                "the dome master's axes are {axes}: give three right-handed axes of unit length \
                 at right angles, within {:e}",
                Self::SKEW
            ),
            Self::FieldOfView { field_of_view } => write!(
                f,
                "the field of view is {field_of_view} rad: give a number above 0, to {TAU}"
            ),
            Self::Radius { radius } => {
                let (least, most) = MirrorCamera::RADII;
                write!(
                    f,
                    "the mirror's radius is {radius} m: give a number from {least:e} to {most:e}"
                )
            }
            Self::Viewpoint { viewpoint } => write!(
                f,
                "the viewpoint is {viewpoint} radii from the mirror's centre: give a number from \
                 -{0} to {0}",
                MirrorCamera::FARTHEST_VIEWPOINT
            ),
            Self::ScreenRadius { radius } => {
                let (least, most) = DomeScreen::RADII;
                write!(
                    f,
                    "the dome screen's radius is {radius} m: give a number from {least:e} to {most:e}"
                )
            }
            Self::Eye { eye, distance } => write!(
                f,
                "the eye is at {eye}, {distance} radii from the dome screen's centre: give a place \
                 within {} radii",
                DomeScreen::FARTHEST_EYE
            ),
        }
    }
}

impl core::error::Error for DomeError {}
