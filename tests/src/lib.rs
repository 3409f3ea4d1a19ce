//! What the tests that cross crates share: commands, meshes, scenes, ray files, random numbers.

pub mod command;
#[cfg(unix)]
pub mod firmware;
pub mod limits;
pub mod meshes;
pub mod paths;
pub mod rays;
pub mod scenes;
pub mod sizes;
pub mod ways;
