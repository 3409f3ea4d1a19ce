//! Shisen on a desk: meshes and scenes in, CAVE walls out.

mod angle;
pub mod cave;
pub mod description;
pub mod look;
pub mod mesh;
pub mod picture;
pub mod scene;
