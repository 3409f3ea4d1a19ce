//! Shisen's ray tracer core: `no_std`, no allocation, a fixed budget.
#![no_std]

pub mod gaze;
