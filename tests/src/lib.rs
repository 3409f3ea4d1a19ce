//! What the tests that cross crates share: commands, meshes, scenes, ray files, random numbers.
#![expect(
    clippy::missing_panics_doc,
    reason = "what cannot be made or does not hold fails the test"
)]

pub mod command;
#[cfg(unix)]
pub mod firmware;
pub mod limits;
pub mod meshes;
pub mod paths;
pub mod png_file;
pub mod rays;
pub mod scenes;
pub mod sizes;
pub mod ways;
