//! Gathers samples while the viewer looks at targets.

use super::{EYES, SeenTarget, TimedTarget};
use crate::files::Fault;
use glam::{Vec2, Vec3};
use shisen_core::gaze::HeadPose;
use shisen_tracker::estimate::{EstimatorConfig, Event, HeardSensors, Measured};
use shisen_tracker::sample::Sample;
use shisen_tracker::time::Micros;

/// How long eyes take to rest on a target: a saccade starts after 200 ms, lasts 100 ms.
const SETTLE: Micros = Micros::from_millis(400);

const LEAST_SAMPLES: usize = 10;

/// Glances elsewhere deviate by this many median deviations (3.4 standard ones of noise).
const OUTLIER: f32 = 5.0;

/// A sample while a target was looked at.
#[derive(Debug, Clone, Copy)]
struct Look {
    /// The direction of the target, in the head's axes.
    direction: Vec3,
    measured: [Option<Vec2>; 3],
}

/// Collects samples while targets are looked at.
pub(crate) struct Gatherer {
    config: EstimatorConfig,
    targets: Vec<TimedTarget>,
    looks: Vec<Vec<Look>>,
    sensors: HeardSensors,
}

impl Gatherer {
    /// For targets by the samples' arrival; samples without a head have that of `config`.
    pub(crate) fn new(config: &EstimatorConfig, targets: Vec<TimedTarget>) -> Self {
        let looks = vec![Vec::new(); targets.len()];
        Self {
            config: *config,
            targets,
            looks,
            sensors: HeardSensors::default(),
        }
    }

    /// Returns the targets.
    pub(crate) fn targets(&self) -> &[TimedTarget] {
        &self.targets
    }

    /// Takes a sample while a target is looked at, of a sensor that counts by `config`.
    pub(crate) fn push(&mut self, sample: &Sample, sink: &mut dyn FnMut(Event)) {
        if !self
            .sensors
            .counts(self.config.sensors, sample.sensor, sink)
        {
            return;
        }
        let head = self.head(sample);
        let at = sample.arrival;
        let looked = |target: &TimedTarget| at >= target.start.after(SETTLE) && at < target.end;
        let Some(index) = self.targets.iter().position(looked) else {
            return;
        };
        let from_head = head.orientation.inverse() * (self.targets[index].place - head.position);
        let measured = Measured::of(&self.config, sample, &head);
        let measured = [measured.left, measured.right, measured.combined];
        if let Some(direction) = from_head.try_normalize()
            && measured.iter().any(Option::is_some)
        {
            self.looks[index].push(Look {
                direction,
                measured,
            });
        }
    }

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

    /// Returns each target with its measurements.
    pub(crate) fn finish(&self) -> Result<Vec<SeenTarget>, Fault> {
        let all = (1..).zip(self.targets.iter().zip(&self.looks));
        all.map(|(number, (target, looks))| {
            seen(target, looks).ok_or_else(|| {
                let samples = looks.len();
                Fault::new(
                    format!(
                        "{samples} samples of the eyes came while they looked at target {number}"
                    ),
                    format!(
                        "{LEAST_SAMPLES} or more are needed of each target after the first {} ms: \
                         look at each for longer, and see what comes with `shisen tracker monitor`",
                        SETTLE.0 / 1_000
                    ),
                )
            })
        })
        .collect()
    }
}

fn seen(target: &TimedTarget, looks: &[Look]) -> Option<SeenTarget> {
    let measured: [_; EYES.len()] = std::array::from_fn(|eye| {
        let measured = looks.iter().filter_map(|look| look.measured[eye]);
        mean(&measured.collect::<Vec<_>>())
    });
    measured.iter().any(Option::is_some).then_some(())?;
    let sum: Vec3 = looks.iter().map(|look| look.direction).sum();
    Some(SeenTarget {
        place: Some(target.place),
        direction: sum.try_normalize()?,
        samples: Some(looks.len() as u32),
        measured,
    })
}

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

    #[test]
    fn glances_elsewhere_do_not_count() {
        let config = EstimatorConfig {
            head_tracked: false,
            ..EstimatorConfig::default()
        };
        let (start, end) = (Micros(0), Micros(1_000_000));
        let place = Vec3::new(0.0, 1.0, -1.0);
        let mut gatherer = Gatherer::new(&config, vec![TimedTarget { start, end, place }]);
        for i in 0..100u64 {
            let tremble = if i % 2 == 0 { 1.0 } else { -1.0 };
            // On the way for 400 ms, and elsewhere for 50.
            let point = match i {
                0..40 => Vec2::ZERO,
                70..75 => Vec2::new(500.0, 0.0),
                _ => Vec2::new(100.0 + tremble, 50.0),
            };
            let mut sample = Sample::arrived(Micros(i * 10_000));
            sample.gaze_point = Some(Reading::tracked(GazePoint::Raw(point)));
            gatherer.push(&sample, &mut |event| panic!("{event:?}"));
        }
        let seen = gatherer.finish().unwrap();
        assert_eq!((seen.len(), seen[0].samples), (1, Some(60)));
        let [None, None, Some(combined)] = seen[0].measured else {
            panic!("{:?}", seen[0]);
        };
        assert!(combined.distance(Vec2::new(100.0, 50.0)) < 0.1);
        let up = Vec3::new(0.0, 1.0, -1.0).normalize();
        assert!(seen[0].direction.distance(up) < 1e-6);
    }
}
