//! Shisen's ray tracer core: `no_std`, no allocation, a fixed budget.
#![no_std]

pub mod frame;
pub mod gaze;
pub mod numeric;
pub mod scene;
pub mod shape;
mod simd;
pub mod trace;

pub use simd::{Runs, Simd};
