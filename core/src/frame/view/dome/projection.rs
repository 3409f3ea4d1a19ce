//! Where a dome master is taken, and which direction each of its pixels is.

use crate::capture::{Mapping, SpheroidMirror};
use glam::{Mat3, Vec3};

/// Where a dome master is taken and which way round.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DomePose {
    /// Position of the viewpoint: metres, in the room.
    pub position: Vec3,
    /// The axes of [`capture`](crate::capture) in the room, each a column of
    /// unit length: the picture's right, its top, and what is behind it. The
    /// zenith is against the last.
    pub room_from_capture: Mat3,
}

impl DomePose {
    /// A dome over a room (+Y up, −Z forward) with the front at the bottom of
    /// the picture: a quarter turn about +X.
    pub const fn over_room(position: Vec3) -> Self {
        Self {
            position,
            room_from_capture: Mat3::from_cols(Vec3::X, Vec3::Z, Vec3::NEG_Y),
        }
    }
}

/// The direction that a dome master's pixel shows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum DomeProjection {
    /// What a camera sees in a mirrored spheroid.
    Mirror(MirrorCamera),
    /// [`fisheye_equidistant`](crate::capture::fisheye_equidistant); of π a true dome master.
    Equidistant {
        /// Across the picture: radians, above 0 to 2π.
        field_of_view: f32,
    },
    /// [`fisheye_equisolid`](crate::capture::fisheye_equisolid).
    Equisolid {
        /// Across the picture: radians, above 0 to 2π.
        field_of_view: f32,
    },
    /// [`mirror_ball`](crate::capture::mirror_ball).
    MirrorBall,
}

/// A mirror and the camera that looks at it. It is optics, not an object: it
/// casts no shadow and is in no reflection.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MirrorCamera {
    /// The mirror's shape, and what looks at it.
    pub mirror: SpheroidMirror,
    /// Which of its points a pixel sees.
    pub mapping: Mapping,
    /// Its equatorial radius: metres, within [`MirrorCamera::RADII`].
    pub radius: f32,
    /// Which point of its axis is at the pose's position: equatorial radii from
    /// its centre towards the camera, −1000 to 1000. The screen's centre, the
    /// paper's, is at [`SpheroidMirror::screen_distance`].
    pub viewpoint: f32,
    /// Whether the picture is left as mirrors give it, left and right
    /// exchanged.
    pub mirrored: bool,
}

impl MirrorCamera {
    /// Least and greatest equatorial radius: metres.
    pub const RADII: (f32, f32) = (1.0e-9, 1.0e6);

    /// Farthest viewpoint: equatorial radii.
    pub(super) const FARTHEST_VIEWPOINT: f32 = 1000.0;

    /// The best mirror, of an equatorial radius in metres, within [`RADII`](Self::RADII), in its
    /// exact mapping, left and right as a viewer under the dome sees it, the screen's centre at the
    /// pose's position.
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
