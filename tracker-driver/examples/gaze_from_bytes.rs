//! A tracker from bytes: what came in on a serial line becomes a line of sight.
//!
//! ```sh
//! cargo run -p shisen-tracker --example gaze_from_bytes
//! ```
//!
//! A head turns 30° to the right in 30 frames of the Hatire protocol, of which one
//! lost a byte and one has noise before it. What was dropped is said, and where the
//! viewer looks 20 ms after the last frame is compared with where the head was turned.

use shisen_tracker::clock::{ClockConfig, ClockEstimator};
use shisen_tracker::decoder::{Decoder as _, Event};
use shisen_tracker::estimate::{EstimatorConfig, Eyes, GazeEstimator};
use shisen_tracker::head::hatire::{Config, Hatire};
use shisen_tracker::time::Micros;
use std::error::Error;

/// Returns a frame: its count, and the yaw in degrees, to the right.
fn frame(count: u16, yaw: f32) -> Vec<u8> {
    let mut frame = vec![0; 30];
    frame[..2].copy_from_slice(&[0xAA, 0xAA]);
    frame[2..4].copy_from_slice(&count.to_le_bytes());
    frame[4..8].copy_from_slice(&yaw.to_le_bytes());
    frame[28..].copy_from_slice(&[0x55, 0x55]);
    frame
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut decoder = Hatire::new(Config::default());
    let mut clock = ClockEstimator::new(ClockConfig::default())?;
    // There is no eye tracker: the viewer looks where the head points.
    let mut gaze = GazeEstimator::new(EstimatorConfig {
        eyes: Eyes::HeadOnly,
        ..EstimatorConfig::default()
    })?;

    let (mut samples, mut lost) = (0, 0);
    let mut arrival = Micros(0);
    for count in 0..60 {
        let mut bytes = frame(count, f32::from(count.min(30)));
        match count {
            5 => _ = bytes.remove(17),
            12 => bytes.splice(..0, *b"noise").for_each(drop),
            _ => {}
        }
        arrival = Micros::from_millis(10 * u64::from(count));
        decoder.feed(&bytes, arrival, &mut |event| match event {
            Event::Sample(sample) => {
                samples += 1;
                let measured = clock.stamp(&sample, &mut |_| {});
                gaze.push(&sample, measured.time, &mut |_| {});
            }
            // Eyes that the device has lost, or that are shut.
            Event::Message(message) => gaze.on_message(&message, &mut |_| {}),
            Event::Dropped(dropped) => {
                lost += dropped.bytes;
                println!("{} bytes dropped: {}", dropped.bytes, dropped.reason.name());
            }
            _ => {}
        });
    }

    let shown = arrival.after(Micros::from_millis(20));
    let estimate = gaze.estimate(shown, &mut |_| {});
    let forward = estimate.line_of_sight.forward();
    let right = forward.x.atan2(-forward.z).to_degrees();
    println!("{samples} samples, {lost} bytes lost; looking {right:.2}° to the right");
    assert_eq!((samples, lost), (59, 29 + 5));
    assert!((right - 30.0).abs() < 0.01);
    Ok(())
}
