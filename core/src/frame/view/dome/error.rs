//! Why there is no dome master, or none on a dome screen.

use super::MirrorCamera;
use crate::frame::view::{CylinderScreen, DomeScreen, View};
use crate::shape::Ray;
use core::f32::consts::TAU;
use glam::{Mat3, Vec3};

/// Why a dome master cannot be made.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
#[allow(missing_docs, reason = "the messages say what the fields are")]
pub enum DomeError {
    /// No pixels, or more than [`View::MOST_PIXELS`] a side.
    #[error(
        "a dome master of {size} pixels a side: give 1 to {}",
        View::MOST_PIXELS
    )]
    Size { size: u32 },
    /// The viewpoint is not finite or too far out.
    #[error(
        "the dome master's position is {position}: give three numbers from -{most:e} to {most:e}",
        most = Self::FARTHEST
    )]
    Position {
        #[cfg_attr(feature = "defmt", defmt(Debug2Format))]
        position: Vec3,
    },
    /// Axes that are not right-handed units at right angles, within [`DomeError::SKEW`].
    #[error(
        "the dome master's axes are {axes}: give three right-handed axes of unit length at right \
         angles, within {:e}",
        Self::SKEW
    )]
    Axes {
        #[cfg_attr(feature = "defmt", defmt(Debug2Format))]
        axes: Mat3,
    },
    /// The field of view is NaN, 0 or less, or more than 2π.
    #[error("the field of view is {field_of_view} rad: give a number above 0, to {TAU}")]
    FieldOfView { field_of_view: f32 },
    /// The mirror's size is NaN or outside [`MirrorCamera::RADII`].
    #[error(
        "the mirror's radius is {radius} m: give a number from {:e} to {:e}",
        MirrorCamera::RADII.0, MirrorCamera::RADII.1
    )]
    Radius { radius: f32 },
    /// The mirror's point at the position is NaN or too far off.
    #[error(
        "the viewpoint is {viewpoint} radii from the mirror's centre: give a number from -{most} to \
         {most}",
        most = MirrorCamera::FARTHEST_VIEWPOINT
    )]
    Viewpoint { viewpoint: f32 },
    /// The screen's size is NaN or outside [`DomeScreen::RADII`].
    #[error(
        "the dome screen's radius is {radius} m: give a number from {:e} to {:e}",
        DomeScreen::RADII.0, DomeScreen::RADII.1
    )]
    ScreenRadius { radius: f32 },
    /// A cylinder without height, or one too far from its middle: in radii.
    #[error(
        "the cylinder starts {low} radii over its middle and is {height} high: give heights within {} \
         radii, the higher one last",
        CylinderScreen::HIGHEST
    )]
    Heights { low: f32, height: f32 },
    /// A beam whose pixels have no area or whose lens is more than [`CylinderScreen::HIGHEST`] radii
    /// away, or a screen that is no dome and no cylinder about the room's +Y.
    #[error(
        "no beam lights the screen: give steps of pixels in three directions, a lens within {} \
         radii, and a dome or an upright cylinder",
        CylinderScreen::HIGHEST
    )]
    Beam,
    /// An eye farther from the screen's centre or axis than [`DomeScreen::FARTHEST_EYE`].
    #[error(
        "the eye is at {eye}, {distance} radii from the dome screen's centre: give a place within {} \
         radii",
        DomeScreen::FARTHEST_EYE
    )]
    Eye {
        #[cfg_attr(feature = "defmt", defmt(Debug2Format))]
        eye: Vec3,
        distance: f32,
    },
}

impl DomeError {
    /// How far axes may be from unit length and right angles: of 1.
    pub const SKEW: f32 = 1.0e-5;

    /// Largest magnitude of a coordinate: metres. What is around can still be traced.
    pub(super) const FARTHEST: f32 = 0.5 * Ray::FARTHEST;
}
