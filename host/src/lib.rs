//! Shisen on a desk: meshes and scenes in, CAVE walls out.

pub mod bake;
mod angle;
pub mod cave;
pub mod description;
pub mod look;
pub mod import;
pub mod mesh;
pub mod net;
pub mod picture;
pub mod quadruped;
pub mod scene;
pub mod viewer;
pub mod wall_plane;
