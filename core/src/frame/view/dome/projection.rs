//! The viewpoint of a dome master, and the direction that each pixel shows.

use crate::capture::{Mapping, SpheroidMirror};
use glam::{Mat3, Vec3};

/// Position and axes of a dome master.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DomePose {
    /// Position of the viewpoint: metres, in the room.
    pub position: Vec3,
    /// The axes of [`capture`](crate::capture) in the room, each a column of
    /// unit length: the picture's right, its top, and its back. The zenith is
    /// opposite to the last.
    pub room_from_capture: Mat3,
}

impl DomePose {
    /// Returns the pose of a dome over a room (+Y up, −Z forward) with the front at
    /// the bottom of the picture: a quarter turn about +X.
    pub const fn over_room(position: Vec3) -> Self {
        Self {
            position,
            room_from_capture: Mat3::from_cols(Vec3::X, Vec3::Z, Vec3::NEG_Y),
        }
    }
}

/// The mapping from a dome master's pixels to directions.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum DomeProjection {
    /// A camera that looks at a mirrored spheroid.
    Mirror(MirrorCamera),
    /// [`fisheye_equidistant`](crate::capture::fisheye_equidistant); with a field of π a true dome master.
    Equidistant {
        /// Field of view across the picture: radians, above 0 to 2π.
        field_of_view: f32,
    },
    /// [`fisheye_equisolid`](crate::capture::fisheye_equisolid).
    Equisolid {
        /// Field of view across the picture: radians, above 0 to 2π.
        field_of_view: f32,
    },
    /// [`mirror_ball`](crate::capture::mirror_ball).
    MirrorBall,
}

/// A mirror and the camera that looks at it. The mirror is not an object of the
/// scene: it casts no shadow and appears in no reflection.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MirrorCamera {
    /// The mirror's shape and the camera's projection.
    pub mirror: SpheroidMirror,
    /// The mapping from pixels to points of the mirror.
    pub mapping: Mapping,
    /// The mirror's equatorial radius: metres, within [`MirrorCamera::RADII`].
    pub radius: f32,
    /// The point of the mirror's axis that is at the pose's position: equatorial
    /// radii from its centre towards the camera, −1000 to 1000. The screen's centre,
    /// the paper's choice, is at [`SpheroidMirror::screen_distance`].
    pub viewpoint: f32,
    /// Whether left and right are exchanged, as in a photograph of a mirror.
    pub mirrored: bool,
}

impl MirrorCamera {
    /// Least and greatest equatorial radius: metres.
    pub const RADII: (f32, f32) = (1.0e-9, 1.0e6);

    /// Farthest viewpoint from the mirror: equatorial radii.
    pub(super) const FARTHEST_VIEWPOINT: f32 = 1000.0;

    /// Returns the best mirror with an equatorial radius in metres, within [`RADII`](Self::RADII):
    /// exact mapping, left and right as a viewer under the dome sees them, the screen's centre at
    /// the pose's position.
    pub const fn best(radius: f32) -> Self {
        let mirror = SpheroidMirror::BEST;
        Self {
            mirror,
            mapping: Mapping::Exact,
            radius,
            viewpoint: mirror.screen_distance(),
            mirrored: false,
        }
    }
}
