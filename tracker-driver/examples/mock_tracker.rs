//! The simulated tracker: a viewer who looks around, measured with noise, sent as the
//! bytes of a protocol along a bad line, and read again.
//!
//! ```sh
//! cargo run -p shisen-tracker --features mock --example mock_tracker
//! ```
//!
//! For each frame of a display of 60 Hz it compares the line of sight, 20 ms ahead, with
//! the truth, which the mock knows. The same seeds give the same numbers everywhere.

use shisen_tracker::clock::{ClockConfig, ClockEstimator};
use shisen_tracker::decoder::{Decoder as _, Event};
use shisen_tracker::estimate::{EstimatorConfig, GazeEstimator};
use shisen_tracker::mock::{
    Faults, FaultsConfig, Source as _, Tracker, TrackerConfig, Viewer, ViewerConfig, Wire,
};
use shisen_tracker::protocol::{Protocol, Reader};
use shisen_tracker::time::Micros;
use std::error::Error;

const SEED: u64 = 7;
/// From the newest data to the display.
const AHEAD: Micros = Micros::from_millis(20);

fn main() -> Result<(), Box<dyn Error>> {
    let viewer = Viewer::new(ViewerConfig::default(), SEED);
    let mut truth = viewer.clone();
    let tracker = Tracker::new(TrackerConfig::default(), viewer, SEED)?;
    let protocol = Protocol::named("link").ok_or("no such protocol")?;
    let mut reader = Reader::new(&protocol).ok_or("no such device")?;
    let bad_line = FaultsConfig {
        drop: 0.01,
        corrupt: 0.01,
        ..FaultsConfig::default()
    };
    let mut line = Faults::new(Wire::new(tracker, protocol), bad_line, SEED)?;

    let mut clock = ClockEstimator::new(ClockConfig {
        least_delay: TrackerConfig::default().latency,
        ..ClockConfig::default()
    })?;
    let mut gaze = GazeEstimator::new(EstimatorConfig::default())?;
    let mut errors = Vec::new();
    for frame in 60..1_800 {
        let now = Micros(frame * 1_000_000 / 60);
        while let Some(chunk) = line.poll(now) {
            reader.feed(chunk.bytes(), chunk.arrival, &mut |event| match event {
                Event::Sample(sample) => {
                    let measured = clock.stamp(&sample, &mut |_| {});
                    gaze.push(&sample, measured.time, &mut |_| {});
                }
                Event::Message(message) => gaze.on_message(&message, &mut |_| {}),
                _ => {}
            });
        }
        let shown = now.after(AHEAD);
        let estimate = gaze.estimate(shown, &mut |_| {});
        let truth = truth.truth(shown).ok_or("too long ago")?;
        errors.push(
            estimate
                .line_of_sight
                .forward()
                .angle_between(truth.direction),
        );
    }

    errors.sort_by(f32::total_cmp);
    let [half, most] = [50, 95].map(|percent| errors[errors.len() * percent / 100].to_degrees());
    let counts = reader.counts();
    println!(
        "{} samples, {} damaged",
        counts.samples,
        counts.dropped.iter().sum::<u32>()
    );
    println!("off by {half:.2}° in half of the frames, {most:.2}° in one of twenty");
    assert!(half < 0.2);
    Ok(())
}
