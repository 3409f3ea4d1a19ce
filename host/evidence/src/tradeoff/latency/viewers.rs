//! Simulated viewers, and how far the estimate of their gaze is off.

use super::super::{Cause, timed};
use crate::textbook::angle;
use glam::DVec3;
use shisen::live::quantiles::quantile_of;
use shisen_tracker::estimate::{EstimatorConfig, GazeEstimator, GazePrediction, State};
use shisen_tracker::mock::{Kind, Tracker, TrackerConfig, Viewer, ViewerConfig};
use shisen_tracker::time::Micros;

pub(super) const RATE: u32 = 500;

/// Samples during a frame: 62.5 frames a second.
pub(super) const FRAME: u32 = 8;

/// The least time between the latency and the age at which data are stale.
const SPARE: Micros = Micros::from_millis(30);

/// Seeds of the viewers that widenings are found by, and of those they are tried on.
const VIEWERS: [std::ops::RangeInclusive<u64>; 2] = [1..=3, 4..=5];

/// Angles from the truth, degrees.
pub(super) struct GazeError {
    /// The errors in fixation, in pursuit, during a saccade, and for the time of the latency
    /// after its landing.
    classes: [Vec<f64>; 4],
    /// The largest error of each frame while it is shown, by [`VIEWERS`].
    frames: [Vec<f64>; 2],
    seconds: f64,
}

impl GazeError {
    fn all(&self, part: f64) -> f64 {
        quantile_of(self.classes.concat(), part)
    }

    /// Returns the degrees by which a field has to be wider for a part of the frames.
    pub(super) fn widening(&self, part: f64) -> f64 {
        quantile_of(self.frames[0].clone(), part)
    }

    /// Returns the percentage of the other viewers' frames that a widening holds.
    fn held(&self, widening: f64) -> f64 {
        let held = self.frames[1].iter().filter(|&&off| off <= widening);
        100.0 * held.count() as f64 / self.frames[1].len().max(1) as f64
    }

    /// Returns the errors by [`MEASURES`](super::MEASURES), but for the last.
    pub(super) fn errors(&self) -> Vec<Option<f64>> {
        let of_class = |class: &Vec<f64>| {
            let any = !class.is_empty();
            any.then(|| quantile_of(class.clone(), 0.95))
        };
        let any = self.classes.iter().any(|class| !class.is_empty());
        let all = |part: f64| any.then(|| self.all(part));
        let mut errors = vec![all(0.95), all(0.5), all(0.99)];
        errors.extend(self.classes.iter().map(of_class));
        errors.push(Some(self.widening(0.95)));
        errors.push(Some(self.widening(0.99)));
        errors.push(Some(self.held(self.widening(0.95))));
        errors.push(Some(1e6 * self.seconds));
        errors
    }
}

struct Moment {
    truth: DVec3,
    /// The estimate of an open eye by fresh data.
    estimate: Option<DVec3>,
}

/// Returns the largest error of each frame's estimate while the frame is shown.
fn frames(moments: &[Moment]) -> Vec<f64> {
    let frames = moments.windows(FRAME as usize).step_by(FRAME as usize);
    let most = frames.filter_map(|shown| {
        let estimate = shown.first()?.estimate?;
        let off = shown.iter().map(|moment| degrees(estimate, moment.truth));
        Some(off.fold(0.0, f64::max))
    });
    most.collect()
}

fn degrees(a: DVec3, b: DVec3) -> f64 {
    angle(a, b).to_degrees()
}

/// Runs the estimator on all viewers; latency and horizon are in milliseconds, a horizon of 0
/// for no prediction.
pub(super) fn gaze(latency: u32, horizon: u32, seconds: u64) -> Result<GazeError, Cause> {
    let late = Micros::from_millis(latency.into());
    let prediction = GazePrediction {
        horizon: Micros::from_millis(horizon.into()),
        ..GazePrediction::default()
    };
    let mut config = EstimatorConfig {
        prediction: (horizon > 0).then_some(prediction),
        ..EstimatorConfig::default()
    };
    // Data that are late by design are not stale.
    let fallback = &mut config.fallback;
    for after in [&mut fallback.hold_after, &mut fallback.head_hold_after] {
        *after = late.after(SPARE).max(*after);
    }
    let mut classes: [Vec<f64>; 4] = Default::default();
    let mut all_frames: [Vec<f64>; 2] = Default::default();
    let (mut time_taken, mut samples) = (0.0, 0u32);
    for (group, seed) in (0..)
        .zip(VIEWERS)
        .flat_map(|(group, seeds)| seeds.map(move |seed| (group, seed)))
    {
        let tracker = TrackerConfig {
            rate: RATE,
            latency: Micros(0),
            ..TrackerConfig::default()
        };
        let viewer = Viewer::new(ViewerConfig::default(), seed);
        let mut tracker = Tracker::new(tracker, viewer, seed)?;
        let mut estimator = GazeEstimator::new(config)?;
        let mut landed = Micros(0);
        let mut moments = Vec::new();
        while tracker.next_time() < Micros::from_millis(1_000 * seconds) {
            let (time, sample) = tracker.next_sample();
            let shown = time.after(late);
            let (taken, estimate) = timed(|| {
                estimator.push(&sample, time, &mut |_| {});
                estimator.estimate(shown, &mut |_| {})
            });
            time_taken += taken;
            samples += 1;
            let Some(truth) = tracker.viewer().truth(shown) else {
                continue;
            };
            if truth.kind == Kind::Saccade {
                landed = truth.end;
            }
            // The first second is for the filters.
            let counts =
                estimate.state == State::Fresh && truth.openness >= 1.0 && time.0 >= 1_000_000;
            let found = estimate.line_of_sight.forward().as_dvec3();
            let direction = truth.direction.as_dvec3();
            moments.push(Moment {
                truth: direction,
                estimate: counts.then_some(found),
            });
            // The other viewers only try the widening.
            if !counts || group > 0 {
                continue;
            }
            let class = match truth.kind {
                Kind::Saccade => 2,
                _ if shown.since(landed) < late => 3,
                Kind::Pursuit => 1,
                Kind::Fixation | Kind::Microsaccade => 0,
            };
            classes[class].push(degrees(found, direction));
        }
        all_frames[group].extend(frames(&moments));
    }
    Ok(GazeError {
        classes,
        frames: all_frames,
        seconds: time_taken / f64::from(samples.max(1)),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_frame_is_off_by_the_most_while_it_is_shown() {
        let at = |degrees: f64| {
            let (sin, cos) = libm::sincos(degrees.to_radians());
            DVec3::new(sin, 0.0, -cos)
        };
        let frame = |from: f64, estimate: Option<f64>| {
            (0..FRAME).map(move |number| Moment {
                truth: at(from + 0.1 * f64::from(number)),
                estimate: estimate.filter(|_| number == 0).map(at),
            })
        };
        // The second has no estimate, the last is not whole.
        let moments: Vec<Moment> = frame(0.0, Some(0.0))
            .chain(frame(3.0, None))
            .chain(frame(5.0, Some(6.0)))
            .chain(frame(0.0, Some(0.0)).take(3))
            .collect();
        let found = frames(&moments);
        assert_eq!(found.len(), 2);
        assert!(
            (found[0] - 0.7).abs() < 1.0e-9 && (found[1] - 1.0).abs() < 1.0e-9,
            "{found:?}"
        );
    }
}
