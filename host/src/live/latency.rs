//! What each stage of a frame takes, from the eye's movement to the wall.

use hdrhistogram::Histogram;
use serde::Serialize;
use std::time::Duration;

/// When the stages of a frame were, on one clock.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Stamps {
    /// The newest sample in the frame's gaze was measured; `None` before the first.
    pub sample: Option<Duration>,
    /// Its last byte was here.
    pub arrive: Option<Duration>,
    /// The gaze was taken for the frame.
    pub latch: Duration,
    /// The first ray started.
    pub first_ray: Duration,
    /// The last pixel was there.
    pub done: Duration,
    /// The frame was on the walls.
    pub present: Duration,
}

/// A way from one stage to another.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Leg {
    /// From the measurement to its last byte.
    SampleToArrive,
    /// From there until the gaze was taken: how long samples lie around.
    ArriveToLatch,
    /// From there to the first ray: what laying out a frame takes.
    LatchToFirstRay,
    /// Tracing.
    FirstRayToDone,
    /// Waiting for the refresh, and showing.
    DoneToPresent,
    /// From the last byte to the first ray: what the loop adds to a tracker's delay.
    ArriveToFirstRay,
    /// From the measurement to the walls.
    MotionToWall,
}

impl Leg {
    /// All, in the order of a frame.
    pub const ALL: [Self; 7] = [
        Self::SampleToArrive,
        Self::ArriveToLatch,
        Self::LatchToFirstRay,
        Self::FirstRayToDone,
        Self::DoneToPresent,
        Self::ArriveToFirstRay,
        Self::MotionToWall,
    ];

    /// As reports name it.
    pub const fn name(self) -> &'static str {
        match self {
            Self::SampleToArrive => "sample_to_arrive",
            Self::ArriveToLatch => "arrive_to_latch",
            Self::LatchToFirstRay => "latch_to_first_ray",
            Self::FirstRayToDone => "first_ray_to_done",
            Self::DoneToPresent => "done_to_present",
            Self::ArriveToFirstRay => "arrive_to_first_ray",
            Self::MotionToWall => "motion_to_wall",
        }
    }

    /// How long it took in a frame; `None` where the gaze was of no sample.
    pub fn of(self, stamps: &Stamps) -> Option<Duration> {
        let Stamps {
            sample,
            arrive,
            latch,
            first_ray,
            done,
            present,
        } = *stamps;
        let (from, to) = match self {
            Self::SampleToArrive => (sample?, arrive?),
            Self::ArriveToLatch => (arrive?, latch),
            Self::LatchToFirstRay => (latch, first_ray),
            Self::FirstRayToDone => (first_ray, done),
            Self::DoneToPresent => (done, present),
            Self::ArriveToFirstRay => (arrive?, first_ray),
            Self::MotionToWall => (sample?, present),
        };
        Some(to.saturating_sub(from))
    }
}

/// Longest time that is kept as it is: longer ones count as this.
const LONGEST: Duration = Duration::from_mins(1);

/// Where the first of a histogram's few classes ends: nanoseconds.
const FIRST_CLASS: u64 = 10_000;

/// How many times as far the next class reaches.
const WIDER: f64 = 1.2;

/// Histograms of all legs, to three digits from a microsecond to a minute. They
/// take no memory while they are filled.
#[derive(Debug, Clone)]
pub struct Latencies {
    /// In nanoseconds, by [`Leg::ALL`].
    legs: Vec<Histogram<u64>>,
}

/// What a histogram comes to, milliseconds.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Summary {
    /// How many frames.
    pub frames: u64,
    /// The least.
    pub least: f64,
    /// Half of the frames took no longer.
    pub p50: f64,
    /// 95 of 100.
    pub p95: f64,
    /// 99 of 100.
    pub p99: f64,
    /// The most.
    pub most: f64,
}

impl Latencies {
    /// Of no frame yet.
    pub fn new() -> Self {
        let most = LONGEST.as_nanos() as u64;
        // Bounds and digits that it takes: they are constants.
        let one = || Histogram::new_with_bounds(1_000, most, 3).ok();
        Self {
            legs: Leg::ALL.iter().filter_map(|_| one()).collect(),
        }
    }

    /// Takes a frame.
    pub fn record(&mut self, stamps: &Stamps) {
        for (leg, histogram) in Leg::ALL.into_iter().zip(&mut self.legs) {
            if let Some(time) = leg.of(stamps) {
                histogram.saturating_record(time.min(LONGEST).as_nanos() as u64);
            }
        }
    }

    /// What a leg comes to; `None` where no frame had one.
    pub fn of(&self, leg: Leg) -> Option<Summary> {
        let histogram = self.leg(leg).filter(|legs| !legs.is_empty())?;
        let milliseconds = |nanoseconds: u64| nanoseconds as f64 * 1.0e-6;
        // A quantile is the end of its class, which may lie past all that is in it.
        let at = |quantile: f64| {
            let value = histogram.value_at_quantile(quantile);
            milliseconds(value.min(histogram.max()))
        };
        Some(Summary {
            frames: histogram.len(),
            least: milliseconds(histogram.min()),
            p50: at(0.5),
            p95: at(0.95),
            p99: at(0.99),
            most: milliseconds(histogram.max()),
        })
    }

    fn leg(&self, leg: Leg) -> Option<&Histogram<u64>> {
        let number = Leg::ALL.iter().position(|one| *one == leg);
        number.and_then(|number| self.legs.get(number))
    }

    /// A leg's frames in few classes, each a fifth longer than the one before: the end of
    /// each that has any in milliseconds, and how many.
    pub fn few_classes(&self, leg: Leg) -> impl Iterator<Item = (f64, u64)> + '_ {
        let classes = self.leg(leg).into_iter();
        let classes = classes.flat_map(|legs| legs.iter_log(FIRST_CLASS, WIDER));
        let classes = classes.map(|class| {
            (
                class.value_iterated_to() as f64 * 1.0e-6,
                class.count_since_last_iteration(),
            )
        });
        classes.filter(|&(_, frames)| frames > 0)
    }

    /// A leg's frames by how long they took: the end of each class in milliseconds,
    /// and how many are in it. Classes are a thousandth wide or more.
    pub fn classes(&self, leg: Leg) -> impl Iterator<Item = (f64, u64)> + '_ {
        let classes = self.leg(leg).into_iter();
        let classes = classes.flat_map(Histogram::iter_recorded);
        classes.map(|class| {
            (
                class.value_iterated_to() as f64 * 1.0e-6,
                class.count_at_value(),
            )
        })
    }
}

impl Default for Latencies {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn stamps(frame: u64) -> Stamps {
        let at = |microseconds: u64| Duration::from_micros(10_000 * frame + microseconds);
        Stamps {
            sample: Some(at(0)),
            arrive: Some(at(1_000)),
            latch: at(1_500),
            first_ray: at(1_600 + frame),
            done: at(9_000),
            present: at(12_000),
        }
    }

    #[test]
    fn legs_add_up_to_motion_to_wall() {
        let stamps = stamps(3);
        let of = |leg: Leg| leg.of(&stamps).unwrap();
        let parts = &Leg::ALL[..5];
        let sum: Duration = parts.iter().map(|&leg| of(leg)).sum();
        assert_eq!(sum, of(Leg::MotionToWall));
        assert_eq!(of(Leg::MotionToWall), Duration::from_millis(12));
        assert_eq!(of(Leg::ArriveToFirstRay), Duration::from_micros(603));
    }

    #[test]
    fn quantiles_are_within_a_thousandth() {
        let mut latencies = Latencies::new();
        assert_eq!(latencies.of(Leg::MotionToWall), None);
        for frame in 0..1_000 {
            latencies.record(&stamps(frame));
        }
        let near =
            |found: f64, wanted: f64| assert!((found / wanted - 1.0).abs() < 1.1e-3, "{found}");
        let first_ray = latencies.of(Leg::ArriveToFirstRay).unwrap();
        assert_eq!(first_ray.frames, 1_000);
        near(first_ray.least, 0.6);
        near(first_ray.p50, 1.099);
        near(first_ray.p95, 1.549);
        near(first_ray.p99, 1.589);
        near(first_ray.most, 1.599);
        let counted: u64 = latencies
            .classes(Leg::ArriveToFirstRay)
            .map(|(_, count)| count)
            .sum();
        assert_eq!(counted, 1_000);
        // From 0.6 to 1.6 ms, each a fifth longer than the one before.
        let few: Vec<_> = latencies.few_classes(Leg::ArriveToFirstRay).collect();
        assert!((5..=7).contains(&few.len()), "{few:?}");
        assert_eq!(few.iter().map(|&(_, count)| count).sum::<u64>(), 1_000);
        for pair in few.windows(2) {
            assert!((pair[1].0 / pair[0].0 - 1.2).abs() < 2.0e-3, "{few:?}");
        }
        let (first, last) = (few[0].0, few[few.len() - 1].0);
        assert!(
            (0.6..0.72).contains(&first) && (1.598..1.92).contains(&last),
            "{few:?}"
        );
        let of_none = Latencies::new();
        assert_eq!(of_none.few_classes(Leg::MotionToWall).count(), 0);
    }

    #[test]
    fn frames_of_no_sample_count_where_they_can() {
        let mut latencies = Latencies::new();
        latencies.record(&Stamps {
            sample: None,
            arrive: None,
            // An hour: kept as a minute.
            done: Duration::from_hours(1),
            ..stamps(0)
        });
        assert_eq!(latencies.of(Leg::MotionToWall), None);
        let most = latencies.of(Leg::FirstRayToDone).unwrap().most;
        assert!((most / 60_000.0 - 1.0).abs() < 1e-3, "{most}");
    }
}
