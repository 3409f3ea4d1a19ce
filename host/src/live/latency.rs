//! The record of a frame, and the latencies of its stages, from the eye's movement to the wall.

use hdrhistogram::Histogram;
use schemars::JsonSchema;
use serde::Serialize;
use std::time::Duration;

/// The record of a frame. Times are microseconds since the tracker was opened.
#[derive(Debug, Clone, Default, Serialize, JsonSchema)]
#[expect(
    clippy::struct_excessive_bools,
    reason = "a table's columns, each by itself"
)]
pub struct FrameRecord {
    /// The frame's number, from 0.
    pub frame: u64,
    /// When it was due on the walls: at its refresh, or at the end of a longer budget.
    pub due_us: u64,
    /// The refresh at which it was due, from 1.
    pub due_refresh: u64,
    /// The refresh at which it was shown.
    pub refresh: u64,
    /// When its newest sample was measured.
    pub sample_us: Option<u64>,
    /// When that sample came.
    pub arrive_us: Option<u64>,
    /// When the gaze was taken.
    pub latch_us: u64,
    /// When the first ray started.
    pub first_ray_us: u64,
    /// When the last pixel was done.
    pub done_us: u64,
    /// When it was on the walls.
    pub present_us: u64,
    /// Whether it was shown later than due.
    pub late: bool,
    /// The room's origin in the scene, metres, and its turn about +Y, radians: where the viewer has
    /// flown.
    pub place: [f64; 4],
    /// The point between the eyes: metres, in the room.
    pub position: [f32; 3],
    /// The line of sight.
    pub forward: [f32; 3],
    /// How far the gaze could be relied on.
    pub state: &'static str,
    /// Whether it follows the newest sample: the gaze is known, and the tracker was not silent
    /// for longer than a gaze is held.
    pub follows_gaze: bool,
    /// Its budget from the gaze to the last pixel; null where the budget was no time.
    pub budget_us: Option<u64>,
    /// Whether it took longer than that.
    pub over_time: bool,
    /// Its budget in steps; null without a limit. Where the steps are an estimate of a time,
    /// the fovea may have taken more.
    pub budget_steps: Option<u64>,
    /// Steps taken.
    pub steps: u64,
    /// Steps that all of it would have taken, as far as is known.
    pub need_steps: u64,
    /// The rung of quality, from 0.
    pub rung: usize,
    /// Number of tiles that the gaze does not skip.
    pub tiles: usize,
    /// Tiles that the budget did not finish.
    pub unfinished_tiles: usize,
    /// Whether an unfinished tile is within 5° of the line of sight, or of the head's direction
    /// where the gaze is lost.
    pub unfinished_fovea: bool,
}

/// The way from one stage to another.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Leg {
    /// From the measurement to its last byte: the tracker's delay.
    SampleToArrive,
    /// From the last byte until the gaze was taken.
    ArriveToLatch,
    /// From the gaze to the first ray: planning the frame.
    LatchToFirstRay,
    /// From the first ray to the last pixel: tracing.
    FirstRayToDone,
    /// From the last pixel to the walls: waiting for the refresh, and showing.
    DoneToPresent,
    /// From the last byte to the first ray: the loop's own delay.
    ArriveToFirstRay,
    /// From the measurement to the walls.
    MotionToWall,
}

named!(Leg {
    SampleToArrive => "sample_to_arrive",
    ArriveToLatch => "arrive_to_latch",
    LatchToFirstRay => "latch_to_first_ray",
    FirstRayToDone => "first_ray_to_done",
    DoneToPresent => "done_to_present",
    ArriveToFirstRay => "arrive_to_first_ray",
    MotionToWall => "motion_to_wall",
});

impl Leg {
    /// Returns the duration in a frame; `None` without a sample that the gaze follows.
    pub fn duration(self, frame: &FrameRecord) -> Option<Duration> {
        let sample = frame.sample_us.filter(|_| frame.follows_gaze);
        let arrive = frame.arrive_us.filter(|_| frame.follows_gaze);
        let (from, to) = match self {
            Self::SampleToArrive => (sample?, arrive?),
            Self::ArriveToLatch => (arrive?, frame.latch_us),
            Self::LatchToFirstRay => (frame.latch_us, frame.first_ray_us),
            Self::FirstRayToDone => (frame.first_ray_us, frame.done_us),
            Self::DoneToPresent => (frame.done_us, frame.present_us),
            Self::ArriveToFirstRay => (arrive?, frame.first_ray_us),
            Self::MotionToWall => (sample?, frame.present_us),
        };
        Some(Duration::from_micros(to.saturating_sub(from)))
    }
}

/// The longest time of a histogram; longer ones count as this.
const LONGEST: Duration = Duration::from_mins(1);

/// The end of the first of a histogram's few classes, nanoseconds.
const FIRST_CLASS: u64 = 10_000;

/// The ratio of the ends of successive few classes.
const WIDER: f64 = 1.2;

/// Histograms of all legs, to three digits from a microsecond to a minute. They take no memory
/// while they are filled.
#[derive(Debug, Clone)]
pub struct Latencies {
    legs: Vec<Histogram<u64>>,
}

/// The summary of a histogram, milliseconds.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct Summary {
    /// The number of frames.
    pub frames: u64,
    /// The shortest.
    pub least: f64,
    /// The median.
    pub p50: f64,
    /// The 95th percentile.
    pub p95: f64,
    /// The 99th percentile.
    pub p99: f64,
    /// The longest.
    pub most: f64,
}

impl Default for Latencies {
    fn default() -> Self {
        let most = LONGEST.as_nanos() as u64;
        // Never an error: the bounds are constants.
        let one = || Histogram::new_with_bounds(1_000, most, 3).ok();
        Self {
            legs: Leg::ALL.iter().filter_map(|_| one()).collect(),
        }
    }
}

impl Latencies {
    /// Records a frame.
    pub fn record(&mut self, frame: &FrameRecord) {
        for (leg, histogram) in Leg::ALL.into_iter().zip(&mut self.legs) {
            if let Some(time) = leg.duration(frame) {
                histogram.saturating_record(time.min(LONGEST).as_nanos() as u64);
            }
        }
    }

    /// Returns the summary of a leg; `None` where no frame had it.
    pub fn summary(&self, leg: Leg) -> Option<Summary> {
        let histogram = self.leg(leg).filter(|legs| !legs.is_empty())?;
        let milliseconds = |nanoseconds: u64| nanoseconds as f64 * 1.0e-6;
        // A quantile is the end of its class, which may lie beyond the longest time.
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

    /// Returns a leg's frames in few classes, each a fifth longer than the one before: the end of
    /// each class with frames, milliseconds, and their number.
    pub fn few_classes(&self, leg: Leg) -> impl Iterator<Item = (f64, u64)> + '_ {
        let legs = self.leg(leg).into_iter();
        let classes = legs.flat_map(|legs| legs.iter_log(FIRST_CLASS, WIDER));
        let classes = classes.map(|class| {
            let end = class.value_iterated_to() as f64 * 1.0e-6;
            (end, class.count_since_last_iteration())
        });
        classes.filter(|&(_, frames)| frames > 0)
    }

    /// Returns a leg's frames in fine classes, a thousandth wide or more: the end of each class,
    /// milliseconds, and the number of its frames.
    pub fn classes(&self, leg: Leg) -> impl Iterator<Item = (f64, u64)> + '_ {
        let legs = self.leg(leg).into_iter();
        legs.flat_map(Histogram::iter_recorded).map(|class| {
            let end = class.value_iterated_to() as f64 * 1.0e-6;
            (end, class.count_at_value())
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn record(frame: u64) -> FrameRecord {
        let at = |microseconds: u64| 10_000 * frame + microseconds;
        FrameRecord {
            sample_us: Some(at(0)),
            arrive_us: Some(at(1_000)),
            latch_us: at(1_500),
            first_ray_us: at(1_600 + frame),
            done_us: at(9_000),
            present_us: at(12_000),
            follows_gaze: true,
            ..FrameRecord::default()
        }
    }

    #[test]
    fn quantiles_are_within_a_thousandth() {
        let own = |leg: Leg| leg.duration(&record(3)).unwrap();
        let sum: Duration = Leg::ALL[..5].iter().map(|&leg| own(leg)).sum();
        assert_eq!(sum, own(Leg::MotionToWall));
        let leg = Leg::ArriveToFirstRay;
        let mut latencies = Latencies::default();
        assert_eq!(latencies.summary(leg), None);
        for frame in 0..1_000 {
            latencies.record(&record(frame));
        }
        let found = latencies.summary(leg).unwrap();
        let quantiles = [found.least, found.p50, found.p95, found.p99, found.most];
        for (found, expected) in quantiles.into_iter().zip([0.6, 1.099, 1.549, 1.589, 1.599]) {
            assert!((found / expected - 1.0_f64).abs() < 1.1e-3, "{found}");
        }
        assert_eq!(found.frames, 1_000);
        // An hour counts as a minute; without a sample some legs do not count.
        latencies.record(&FrameRecord {
            present_us: 3_600_000_000,
            follows_gaze: false,
            ..record(0)
        });
        assert_eq!(latencies.summary(leg), Some(found));
        let shown = latencies.summary(Leg::DoneToPresent).unwrap();
        assert!((shown.most / 60_000.0 - 1.0).abs() < 1.1e-3, "{shown:?}");
    }
}
