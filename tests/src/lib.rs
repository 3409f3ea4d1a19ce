//! What the tests that cross crates share: meshes, ray files, random numbers.

pub mod command;
#[cfg(unix)]
pub mod firmware;
pub mod meshes;
pub mod paths;
pub mod rays;
pub mod sizes;
pub mod ways;
