//! Pictures of a frame for people: all screens in one picture, both eyes in one, the level of
//! detail, and a window with a dashboard. Test pictures for setting up a room.

#[cfg_attr(
    not(all(unix, feature = "window")),
    allow(dead_code, reason = "only a window shows it")
)]
pub(crate) mod dashboard;
pub mod lod;
pub mod overview;
pub(crate) mod pattern;
pub mod stereo;
#[cfg(all(unix, feature = "window"))]
pub(crate) mod window;

use crate::cave::RoomError;
use crate::picture::PictureError;
use thiserror::Error;

/// Why a picture of screens or of both eyes cannot be made.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ShowError {
    /// No walls.
    #[error("there are no walls to unfold: give at least one")]
    NoWalls,
    /// A wall without area.
    #[error(transparent)]
    Wall(#[from] RoomError),
    /// The picture of a named wall without pixels.
    #[error("the picture of wall {0:?} has no pixels: render it before unfolding")]
    EmptyPicture(String),
    /// Pictures of the two eyes, of these columns and rows.
    #[error(
        "the left eye's picture is {} × {} pixels and the right eye's {} × {}: render both in one \
         size",
        .0[0], .0[1], .1[0], .1[1]
    )]
    Sizes([u32; 2], [u32; 2]),
    /// A picture that is too large.
    #[error(transparent)]
    Picture(#[from] PictureError),
}
