//! Pictures of a frame for people: screens in one picture, both eyes in one, the gaze's detail,
//! a window and what it says.

pub mod dashboard;
pub mod lod;
pub mod overview;
pub mod stereo;
#[cfg(all(unix, feature = "window"))]
pub mod window;
