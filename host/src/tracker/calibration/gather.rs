//! What a tracker says while targets are looked at.

use super::{EYES, SeenTarget, TimedTarget, measured};
use glam::{Vec2, Vec3};
use miette::Diagnostic;
use shisen_core::gaze::HeadPose;
use shisen_tracker::estimate::{EstimatorConfig, Event, Sensors};
use shisen_tracker::sample::Sample;
use shisen_tracker::time::Micros;
use thiserror::Error;

/// How long eyes take to come to a target, and to rest there: a saccade begins
/// 200 ms after what brings it about and lasts up to 100.
pub const SETTLE: Micros = Micros::from_millis(400);

/// Fewer samples make no mean.
const LEAST_SAMPLES: usize = 10;

/// Deviations from the median beyond this many times their median are glances
/// elsewhere; of normal noise it is 3.4 standard deviations.
const OUTLIER: f32 = 5.0;

/// A target that was not seen.
#[derive(Debug, Clone, Copy, PartialEq, Error, Diagnostic)]
#[error("{samples} samples of the eyes came while they looked at target {target}")]
#[diagnostic(help(
    "{LEAST_SAMPLES} or more are needed of each target after the first {} ms: look at each for longer, and see what comes with `shisen tracker monitor`",
    SETTLE.0 / 1_000
))]
pub struct GatherError {
    /// Which, from 1.
    pub target: usize,
    /// How many there were.
    pub samples: usize,
}

/// A sample of a target.
#[derive(Debug, Clone, Copy)]
struct Look {
    /// Of the target, in the head's axes.
    direction: Vec3,
    measured: [Option<Vec2>; 3],
}

/// Takes samples while targets are looked at.
#[derive(Debug, Clone)]
pub struct Gatherer {
    config: EstimatorConfig,
    targets: Vec<TimedTarget>,
    looks: Vec<Vec<Look>>,
    /// The sensor that counts, once one is seen.
    sensor: Option<u8>,
    /// Of another one it was said that it does not count.
    other_said: bool,
}

impl Gatherer {
    /// For targets at times on the clock of the samples' arrival. Where the
    /// head is, `config` says as far as samples do not.
    pub fn new(config: EstimatorConfig, targets: Vec<TimedTarget>) -> Self {
        let looks = vec![Vec::new(); targets.len()];
        Self {
            config,
            targets,
            looks,
            sensor: None,
            other_said: false,
        }
    }

    /// The targets.
    pub fn targets(&self) -> &[TimedTarget] {
        &self.targets
    }

    /// Takes a sample, if a target is looked at and the sensor is the one that
    /// `config` takes for the viewer's head. Of the first that is not,
    /// [`Event::OtherSensor`] is handed to `sink`.
    pub fn push(&mut self, sample: &Sample, sink: &mut dyn FnMut(Event)) {
        if !self.counts(sample.sensor, sink) {
            return;
        }
        let head = self.head(sample);
        let at = sample.arrival;
        let looked = |target: &TimedTarget| at >= target.start.after(SETTLE) && at < target.end;
        let Some(index) = self.targets.iter().position(looked) else {
            return;
        };
        let from_head = head.orientation.inverse() * (self.targets[index].place - head.position);
        let measured = measured(&self.config, sample, &head);
        if let Some(direction) = from_head.try_normalize()
            && measured.iter().any(Option::is_some)
        {
            self.looks[index].push(Look {
                direction,
                measured,
            });
        }
    }

    /// Whether a sensor is the viewer's, by the estimator's rule.
    fn counts(&mut self, sensor: u8, sink: &mut dyn FnMut(Event)) -> bool {
        let taken = match self.config.sensors {
            Sensors::All => return true,
            Sensors::First => *self.sensor.get_or_insert(sensor),
            Sensors::Only(taken) => taken,
        };
        if taken == sensor {
            self.sensor = Some(sensor);
        } else if !std::mem::replace(&mut self.other_said, true) {
            sink(Event::OtherSensor {
                taken,
                heard: self.sensor.is_some(),
                ignored: sensor,
            });
        }
        taken == sensor
    }

    /// Where the head is, in the room.
    fn head(&self, sample: &Sample) -> HeadPose {
        let room = &self.config.room_from_tracker;
        let mut head = self.config.resting_head;
        if !self.config.head_tracked {
            return head;
        }
        if let Some(position) = sample.head.position.filter(|p| p.tracked) {
            head.position = room.place(position.value);
        }
        let turn = sample.head.orientation.filter(|turn| turn.tracked);
        if let Some(turn) = turn.and_then(|turn| room.orientation(turn.value)) {
            head.orientation = turn;
        }
        head
    }

    /// The targets and what was said of each.
    ///
    /// # Errors
    /// The first target that was not seen.
    pub fn finish(&self) -> Result<Vec<SeenTarget>, GatherError> {
        let all = self.targets.iter().zip(&self.looks).enumerate();
        all.map(|(index, (target, looks))| {
            let seen = seen(target, looks);
            seen.ok_or(GatherError {
                target: index + 1,
                samples: looks.len(),
            })
        })
        .collect()
    }
}

fn seen(target: &TimedTarget, looks: &[Look]) -> Option<SeenTarget> {
    let of_eye = |eye: usize| {
        let of_eye = looks.iter().filter_map(|look| look.measured[eye]);
        mean(&of_eye.collect::<Vec<_>>())
    };
    let measured: [_; EYES.len()] = std::array::from_fn(of_eye);
    measured.iter().any(Option::is_some).then_some(())?;
    let sum: Vec3 = looks.iter().map(|look| look.direction).sum();
    Some(SeenTarget {
        place: Some(target.place),
        direction: sum.try_normalize()?,
        samples: Some(looks.len() as u32),
        measured,
    })
}

/// The mean without outliers.
fn mean(places: &[Vec2]) -> Option<Vec2> {
    if places.len() < LEAST_SAMPLES {
        return None;
    }
    let centre = Vec2::new(
        median(places.iter().map(|p| p.x)),
        median(places.iter().map(|p| p.y)),
    );
    let limit = OUTLIER * median(places.iter().map(|p| p.distance(centre)));
    let near = places.iter().filter(|p| p.distance(centre) <= limit);
    let (sum, count) = near.fold((Vec2::ZERO, 0.0), |(sum, count), place| {
        (sum + (place - centre), count + 1.0)
    });
    Some(centre + sum / count)
}

fn median(numbers: impl Iterator<Item = f32>) -> f32 {
    let mut numbers: Vec<f32> = numbers.collect();
    let middle = numbers.len() / 2;
    *numbers.select_nth_unstable_by(middle, f32::total_cmp).1
}

#[cfg(test)]
mod tests {
    use super::*;
    use shisen_tracker::sample::{GazePoint, Reading};

    fn target(place: Vec3) -> TimedTarget {
        TimedTarget {
            start: Micros(0),
            end: Micros(1_000_000),
            place,
        }
    }

    fn sample(arrival: u64, point: Vec2) -> Sample {
        let mut sample = Sample::arrived(Micros(arrival));
        sample.gaze_point = Some(Reading::tracked(GazePoint::Raw(point)));
        sample
    }

    #[test]
    fn what_settles_counts_and_glances_do_not() {
        let config = EstimatorConfig {
            head_tracked: false,
            ..EstimatorConfig::default()
        };
        let targets = vec![target(Vec3::new(0.0, 1.0, -1.0))];
        let mut gatherer = Gatherer::new(config, targets);
        for i in 0..100u64 {
            let tremble = if i % 2 == 0 { 1.0 } else { -1.0 };
            // On the way for 400 ms, and elsewhere for 50.
            let point = match i {
                0..40 => Vec2::ZERO,
                70..75 => Vec2::new(500.0, 0.0),
                _ => Vec2::new(100.0 + tremble, 50.0),
            };
            gatherer.push(&sample(i * 10_000, point), &mut |event| panic!("{event:?}"));
        }
        let seen = gatherer.finish().unwrap();
        assert_eq!(seen.len(), 1);
        assert_eq!(seen[0].samples, Some(60));
        let [left, right, combined] = seen[0].measured;
        assert_eq!((left, right), (None, None));
        let off = combined.unwrap() - Vec2::new(100.0, 50.0);
        assert!(off.length() < 0.1, "{off}");
        let up = Vec3::new(0.0, 1.0, -1.0).normalize();
        assert!(seen[0].direction.distance(up) < 1e-6);
    }

    /// Two heads in turn, the second of which looks elsewhere.
    #[test]
    fn one_sensor_counts() {
        for (sensors, expected) in [
            (Sensors::First, Vec2::new(100.0, 50.0)),
            (Sensors::Only(3), Vec2::new(-700.0, 0.0)),
        ] {
            let config = EstimatorConfig {
                head_tracked: false,
                sensors,
                ..EstimatorConfig::default()
            };
            let mut gatherer = Gatherer::new(config, vec![target(Vec3::NEG_Z)]);
            let mut said = Vec::new();
            for i in 0..200_u64 {
                let mut one = sample(i * 5_000, Vec2::new(100.0, 50.0));
                one.sensor = 1;
                if i % 2 == 1 {
                    one = sample(i * 5_000, Vec2::new(-700.0, 0.0));
                    one.sensor = 3;
                }
                gatherer.push(&one, &mut |event| said.push(event));
            }
            let seen = gatherer.finish().unwrap();
            assert_eq!(seen[0].samples, Some(60));
            assert_eq!(seen[0].measured[2], Some(expected));
            let (taken, heard, ignored) = if sensors == Sensors::First {
                (1, true, 3)
            } else {
                (3, false, 1)
            };
            let other = Event::OtherSensor {
                taken,
                heard,
                ignored,
            };
            assert_eq!(said, [other]);
        }
    }

    #[test]
    fn a_target_that_was_not_seen_is_told() {
        let targets = vec![target(Vec3::NEG_Z)];
        let mut gatherer = Gatherer::new(EstimatorConfig::default(), targets);
        for i in 0..9 {
            gatherer.push(&sample(500_000 + i, Vec2::ONE), &mut |_| {});
        }
        let error = gatherer.finish().unwrap_err();
        assert_eq!((error.target, error.samples), (1, 9));
    }
}
