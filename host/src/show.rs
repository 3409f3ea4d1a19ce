//! Pictures of a frame for people: all screens in one picture, both eyes in one, the level of
//! detail, and a window with a dashboard.

pub mod dashboard;
pub mod lod;
pub mod overview;
pub mod stereo;
#[cfg(all(unix, feature = "window"))]
pub mod window;
