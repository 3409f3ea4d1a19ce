//! What prediction is worth, on the mock. The table is printed by
//! `cargo test -p shisen-tracker prediction -- --nocapture`.

use crate::estimate::{EstimatorConfig, Filter, GazeEstimator, State};
use crate::mock::{Kind, Tracker, TrackerConfig, Viewer, ViewerConfig};
use crate::rotation::angle;
use crate::time::Micros;
use std::vec::Vec;

const LATENCY: Micros = Micros(20_000);

/// Errors in degrees: in fixation, pursuit, on the way of a saccade, and in
/// the first 20 ms after its landing.
type Errors = [Vec<f32>; 4];

const NAMES: [&str; 4] = ["fixation", "pursuit", "flight", "landing"];

fn errors(config: EstimatorConfig, rate: u32, seconds: u64) -> Errors {
    let mut errors = Errors::default();
    for seed in 1..=3 {
        let tracker = TrackerConfig {
            rate,
            latency: Micros(0),
            ..TrackerConfig::default()
        };
        let viewer = Viewer::new(ViewerConfig::default(), seed);
        let mut tracker = Tracker::new(tracker, viewer, seed).unwrap();
        let mut estimator = GazeEstimator::new(config).unwrap();
        let mut landed = Micros(0);
        while tracker.next_time() < Micros::from_millis(1_000 * seconds) {
            let (time, sample) = tracker.next_sample();
            estimator.push(&sample, time, &mut |_| {});
            let shown = time.after(LATENCY);
            let truth = tracker.viewer().truth(shown).unwrap();
            let estimate = estimator.estimate(shown, &mut |_| {});
            if truth.kind == Kind::Saccade {
                landed = truth.end;
            }
            if estimate.state != State::Fresh || truth.openness < 1.0 || time.0 < 1_000_000 {
                continue;
            }
            let class = match truth.kind {
                Kind::Saccade => 2,
                _ if shown.since(landed) < LATENCY => 3,
                Kind::Pursuit => 1,
                Kind::Fixation | Kind::Microsaccade => 0,
            };
            let off = angle(estimate.line_of_sight.forward(), truth.direction);
            errors[class].push(off.to_degrees());
        }
    }
    for errors in &mut errors {
        errors.sort_by(f32::total_cmp);
    }
    errors
}

fn quantile(sorted: &[f32], part: f32) -> f32 {
    sorted[(part * (sorted.len() - 1) as f32) as usize]
}

#[test]
fn prediction_pays_and_harms_nowhere() {
    if cfg!(miri) {
        return;
    }
    let filtered = EstimatorConfig::default();
    let raw = EstimatorConfig {
        filter: Filter::None,
        ..filtered
    };
    for rate in [60, 120, 500] {
        for (name, with) in [("One-Euro", filtered), ("no filter", raw)] {
            let without = EstimatorConfig {
                prediction: None,
                ..with
            };
            let without = errors(without, rate, 60);
            let with = errors(with, rate, 60);
            for (class, (with, without)) in with.iter().zip(&without).enumerate() {
                let at = |part| (quantile(without, part), quantile(with, part));
                let (median, tail) = (at(0.5), at(0.95));
                std::println!(
                    "{rate:5} Hz | {name:9} | {:8} | {:.2} -> {:.2} | {:.2} -> {:.2} | n {}",
                    NAMES[class], median.0, median.1, tail.0, tail.1, with.len()
                );
            }
        }
    }
}
