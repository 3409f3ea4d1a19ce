//! Shisen on a desk: meshes and scenes in, CAVE walls out.

pub mod cave;
pub mod import;
pub mod mesh;
pub mod picture;
pub mod quadruped;
pub mod scene;
