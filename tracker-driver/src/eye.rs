//! Eye trackers that send a stream of bytes.
//!
//! Each has a decoder, the bytes that start and stop it where it takes any, and an `encode` that
//! writes a sample as the device would, for the mock and for tests.

pub mod adhawk;
pub mod asl;
pub mod iscan;

use crate::sample::{Pupil, Sample};
use glam::Vec2;

/// Returns the gaze point and the pupil as mere numbers, zero where there is none.
fn numbers(sample: &Sample) -> (Vec2, f32) {
    let gaze = sample.gaze_point.map(|point| point.value.numbers());
    let pupil = match sample.combined.pupil {
        Some(Pupil::Raw(pupil) | Pupil::Diameter(pupil)) => pupil,
        None => 0.0,
    };
    (gaze.unwrap_or_default(), pupil)
}
