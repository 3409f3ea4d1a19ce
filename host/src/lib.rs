//! Shisen on a desk: meshes and scenes in, CAVE walls out.

mod angle;
pub mod bake;
pub mod cave;
pub mod chart;
pub mod dashboard;
pub mod description;
pub mod dome;
pub mod effects;
#[cfg(unix)]
pub mod firmware;
pub mod gaze_reference;
mod glyph;
pub mod import;
pub mod input;
pub mod live;
pub mod lod;
pub mod look;
pub mod mesh;
pub mod net;
pub mod output;
pub mod picture;
pub mod quadruped;
pub mod quantiles;
pub mod render;
pub mod scene;
pub mod selftest;
pub mod simplify;
pub mod spectrum;
pub mod stereo;
pub mod texture;
pub mod tracker;
pub mod tradeoff;
pub mod viewer;
pub mod wall_plane;
pub mod warp;
#[cfg(all(unix, feature = "window"))]
pub mod window;
