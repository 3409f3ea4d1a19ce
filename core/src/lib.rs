//! Shisen's ray tracer core: `no_std`, no allocation, a fixed budget.
//!
//! A baked [`Scene`](scene::Scene) is checked once and used in place. A
//! [`View`](frame::View) gives the rays of a screen, a
//! [`TileJob`](frame::TileJob) renders a rectangle of it into the caller's
//! pixels. When its [`Budget`](frame::Budget) is spent, it stops between two
//! samples; the next call goes on from there.
//!
//! ```
//! use glam::Vec3;
//! use shisen_core::Simd;
//! use shisen_core::frame::{Budget, Outcome, Pixel, Renderer, Settings, Tile, TileJob, View, Workspace};
//! use shisen_core::scene::{Scene, SceneError};
//!
//! /// A picture of 32×32 pixels, a million steps at a time.
//! fn render(blob: &[u8], pixels: &mut [Pixel; 1024]) -> Result<(), SceneError> {
//!     let scene: Scene = Scene::from_bytes(blob)?;
//!     let renderer = Renderer::new(scene, Simd::detect(), Settings::default());
//!     let (right, down) = (Vec3::X / 16.0, Vec3::NEG_Y / 16.0);
//!     let first = Vec3::new(-1.0, 1.0, -1.5) + (right + down) / 2.0;
//!     let view = View::new(Vec3::ZERO, first, right, down, [32, 32]).expect("a screen");
//!     let mut job = TileJob::new(Tile { x: 0, y: 0, width: 32, height: 32 });
//!     let mut workspace = Workspace::new();
//!     loop {
//!         let mut budget = Budget::steps(1_000_000);
//!         match job.render(&renderer, &view, pixels, &mut budget, &mut workspace) {
//!             Ok(Outcome::BudgetSpent) => {} // The caller can do other work here.
//!             other => return Ok(assert_eq!(other, Ok(Outcome::Finished))),
//!         }
//!     }
//! }
//! # assert_eq!(render(b"not a scene", &mut [Pixel::default(); 1024]), Err(SceneError::NotAScene));
//! ```
//!
//! The folder `examples` has a scene written by hand, and a wall for an eye that is not
//! in front of its middle. The crate `shisen` bakes scenes and renders whole rooms; its
//! first page shows the architecture of the workspace.
//!
//! # Where things are
//!
//! Each module uses only the modules above it, and what all share: the vectors of `simd`, and
//! `compiled`, which compiles the tracer for each width of nodes:
//!
//! | Module | Contents |
//! |---|---|
//! | [`numeric`] | numbers, vectors and angles with stated error bounds |
//! | [`shape`] | rays, boxes, triangles, spheres, spheroids |
//! | [`spectrum`] | media, wavelengths, the colours that the eye sees at them |
//! | [`scene`] | a scene's bytes, checked once, and the effects that the scene needs |
//! | [`gaze`] | head, line of sight, visual field, level, detail |
//! | [`capture`] | mirrors and fisheyes: from a pixel of a dome master to its ray |
//! | [`trace`] | what a ray meets, and the light that comes back, within a budget |
//! | [`frame`] | views, tiles, their order; pictures |
//!
//! # What holds everywhere
//! - Nothing here panics, allocates, recurses, blocks or reads a clock.
//! - Results are the same bits on every target, thread and instruction set.
//! - Right-handed axes, +X right, +Y up, −Z forward; metres; linear RGB.
//! - `unsafe` stands in two modules: `simd`, and the square root of
//!   hard-float ARM in [`numeric`].
//!
//! # Features
//!
//! None is on by default.
//!
//! | Feature | What it adds |
//! |---|---|
//! | `fpv5` | a Cortex-M7's `FPv5` instructions, for `-C target-cpu=cortex-m7`: fewer instructions, the same bits |
//! | `defmt` | `defmt::Format` for errors and outcomes |
//!
//! # What it does not do
//!
//! No building of trees and no reading of files: the crate `shisen` does both. No
//! global illumination, no caustics, no media inside media, and no shadows of transparent
//! objects. AVX2 is the one instruction set with code of its own; elsewhere portable code
//! gives the same bits.

#![no_std]

pub mod capture;
mod compiled;
pub mod frame;
pub mod gaze;
#[cfg(test)]
mod hostile;
pub mod numeric;
pub mod scene;
pub mod shape;
mod simd;
pub mod spectrum;
pub mod trace;

pub use compiled::{COMPILED, Runs};
pub use simd::Simd;

/// The scene of the examples, for tests.
#[cfg(test)]
#[path = "../examples/ball/mod.rs"]
mod ball;
#[cfg(test)]
extern crate self as shisen_core;
#[cfg(test)]
extern crate std;
