//! Samples, for reports.

use super::features::FeatureReport;
use super::happenings::Happenings;
use super::said::Said;
use crate::cli::output::warn;
use glam::{Quat, Vec2, Vec3};
use serde::Serialize;
use shisen_tracker::clock::{ClockConfig, ClockEstimator, StampSource};
use shisen_tracker::decoder::{Counts, DropReason, Message};
use shisen_tracker::estimate::{Estimate, GazeEstimator};
use shisen_tracker::sample::{Eye, GazeFrame, GazePoint, Pupil, Reading, Sample};
use shisen_tracker::time::{DeviceTime, Micros};
use std::collections::{BTreeMap, VecDeque};
use std::fmt;

/// A sample and how things stand with it.
#[derive(Debug, Serialize)]
pub(super) struct Record {
    /// Counted from 0.
    number: u64,
    arrival_us: u64,
    device_us: Option<u64>,
    /// Later than the least delayed of the last seconds; not known of a device
    /// without a clock, nor while it stands still.
    late_us: Option<u64>,
    clock: &'static str,
    sensor: u8,
    sequence: Option<u32>,
    head: Head,
    gaze_frame: &'static str,
    left: Option<EyeReport>,
    right: Option<EyeReport>,
    combined: Option<EyeReport>,
    gaze_point: Option<Point>,
    line_of_sight: Option<Sight>,
    /// Of the last second.
    rate_hz: f32,
    lost: u64,
    /// Samples before the device was told what to send.
    held_back: u64,
    dropped: u64,
    /// How often, by why, where it is at all.
    dropped_by: BTreeMap<&'static str, u32>,
    dropped_bytes: u64,
    /// What the device says of itself, in the first record after it was plugged in.
    device: Option<FeatureReport>,
    /// What it said since the record before.
    said: Vec<Said>,
}

/// Most that is kept of what a device says between two samples.
const MOST_SAID: usize = 64;

/// What the clock of a device does, as a record says it.
const NO_CLOCK: &str = "none";
const RUNS: &str = "runs";
const STANDS_STILL: &str = "stands still";

#[derive(Debug, Serialize)]
struct Value<V> {
    value: V,
    tracked: bool,
}

#[derive(Debug, Serialize)]
struct Head {
    position: Option<Value<[f32; 3]>>,
    orientation: Option<Value<[f32; 4]>>,
    angular_velocity: Option<[f32; 3]>,
}

#[derive(Debug, Serialize)]
struct EyeReport {
    origin: Option<Value<[f32; 3]>>,
    direction: Option<Value<[f32; 3]>>,
    pupil_m: Option<f32>,
    pupil_raw: Option<f32>,
    openness: Option<f32>,
}

#[derive(Debug, Serialize)]
struct Point {
    kind: &'static str,
    value: [f32; 2],
    tracked: bool,
}

/// Where the viewer looks, in the room.
#[derive(Debug, Serialize)]
struct Sight {
    position: [f32; 3],
    direction: [f32; 3],
    state: &'static str,
}

impl Sight {
    fn of(estimate: &Estimate) -> Self {
        let sight = &estimate.line_of_sight;
        Self {
            position: sight.position().to_array(),
            direction: sight.forward().to_array(),
            state: estimate.state.name(),
        }
    }
}

fn vector(reading: Reading<Vec3>) -> Value<[f32; 3]> {
    Value {
        value: reading.value.to_array(),
        tracked: reading.tracked,
    }
}

fn turn(reading: Reading<Quat>) -> Value<[f32; 4]> {
    Value {
        value: reading.value.to_array(),
        tracked: reading.tracked,
    }
}

fn eye(eye: &Eye) -> Option<EyeReport> {
    (!eye.is_empty()).then(|| EyeReport {
        origin: eye.origin.map(vector),
        direction: eye.direction.map(vector),
        pupil_m: match eye.pupil {
            Some(Pupil::Diameter(metres)) => Some(metres),
            _ => None,
        },
        pupil_raw: match eye.pupil {
            Some(Pupil::Raw(raw)) => Some(raw),
            _ => None,
        },
        openness: eye.openness,
    })
}

fn point(point: Reading<GazePoint>) -> Point {
    let (kind, place): (_, Vec2) = match point.value {
        GazePoint::Plane(place) => ("plane", place),
        GazePoint::Normalized(place) => ("normalized", place),
        GazePoint::Raw(place) => ("raw", place),
    };
    Point {
        kind,
        value: place.to_array(),
        tracked: point.tracked,
    }
}

/// How often bytes were dropped for each reason that there was.
pub(super) fn by_reason(counts: &Counts) -> BTreeMap<&'static str, u32> {
    let all = DropReason::ALL.into_iter();
    let all = all.map(|reason| (reason.name(), counts.dropped_for(reason)));
    all.filter(|&(_, count)| count > 0).collect()
}

/// In words, such as ` (3 truncated, 1 out of step)`; nothing of none.
pub(super) struct ByReason<'a>(pub(super) &'a BTreeMap<&'static str, u32>);

impl fmt::Display for ByReason<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, (reason, count)) in self.0.iter().enumerate() {
            let before = if i == 0 { " (" } else { ", " };
            write!(f, "{before}{count} {reason}")?;
        }
        f.write_str(if self.0.is_empty() { "" } else { ")" })
    }
}

/// Counts samples, and watches their rate and their delay.
pub(super) struct Records {
    clock: Option<ClockEstimator>,
    sight: Option<GazeEstimator>,
    happenings: Happenings,
    count: u64,
    held_back: u64,
    /// Arrivals within the last second.
    recent: VecDeque<Micros>,
    /// What the device's clock showed last.
    shown: Option<DeviceTime>,
    /// Of the next record.
    described: Option<FeatureReport>,
    said: Vec<Said>,
}

impl Records {
    /// With an estimator, of where the viewer looks too.
    pub(super) fn new(sight: Option<GazeEstimator>) -> Self {
        Self {
            clock: ClockEstimator::new(ClockConfig::default()).ok(),
            sight,
            happenings: Happenings::default(),
            count: 0,
            held_back: 0,
            recent: VecDeque::new(),
            shown: None,
            described: None,
            said: Vec::new(),
        }
    }

    /// Takes note of what the device says of itself, for the next record.
    pub(super) fn describe(&mut self, features: &FeatureReport) {
        self.described = Some(features.clone());
    }

    /// Says what the device said, and minds it.
    pub(super) fn hear(&mut self, message: &Message, now: Micros) {
        if let Some(sight) = &mut self.sight {
            sight.on_message(message, &mut |_| {});
        }
        if let Some(what) = self.happenings.of_device(message, now) {
            warn(&what);
        }
        if self.said.len() < MOST_SAID {
            self.said.extend(Said::of(message));
        }
    }

    /// So many samples were not used since they came before the device was set up.
    pub(super) const fn hold_back(&mut self, samples: u64) {
        self.held_back = samples;
    }

    /// The record of the next sample.
    pub(super) fn next(&mut self, sample: &Sample, counts: &Counts) -> Record {
        let arrival = sample.arrival;
        let happenings = &mut self.happenings;
        let say = |what: Option<String>| {
            if let Some(what) = what {
                warn(&what);
            }
        };
        let stamp = self.clock.as_mut().map(|clock| {
            clock.stamp(sample, &mut |event| {
                say(happenings.of_clock(&event, arrival));
            })
        });
        let moved = self.shown != sample.device_time;
        self.shown = sample.device_time;
        let frozen = self.clock.as_ref().is_some_and(ClockEstimator::is_frozen);
        let measured = stamp.map_or(arrival, |stamp| stamp.time);
        let line_of_sight = self.sight.as_mut().map(|sight| {
            sight.push(sample, measured, &mut |event| {
                super::warn_of_sensors(&event);
                say(happenings.of_gaze(&event, arrival));
            });
            Sight::of(&sight.estimate(arrival, &mut |_| {}))
        });
        self.recent.push_back(arrival);
        let second = Micros::from_millis(1_000);
        while self
            .recent
            .front()
            .is_some_and(|&first| arrival.since(first) > second)
        {
            self.recent.pop_front();
        }
        let spanned = self
            .recent
            .front()
            .map_or(0.0, |&first| arrival.since(first).seconds());
        let rate_hz = match self.recent.len() {
            0 | 1 => 0.0,
            count => (count - 1) as f32 / spanned.max(1.0e-6),
        };
        let number = self.count;
        self.count += 1;
        Record {
            device: self.described.take(),
            said: std::mem::take(&mut self.said),
            number,
            arrival_us: arrival.0,
            device_us: sample.device_time.map(|time| time.microseconds),
            late_us: stamp
                .filter(|stamp| stamp.source == StampSource::Device && moved && !frozen)
                .map(|stamp| arrival.since(stamp.time).0),
            clock: match sample.device_time {
                None => NO_CLOCK,
                Some(_) if frozen => STANDS_STILL,
                Some(_) => RUNS,
            },
            sensor: sample.sensor,
            sequence: sample.sequence,
            head: Head {
                position: sample.head.position.map(vector),
                orientation: sample.head.orientation.map(turn),
                angular_velocity: sample.head.angular_velocity.map(|turn| turn.to_array()),
            },
            gaze_frame: match sample.gaze_frame {
                GazeFrame::Head => "head",
                GazeFrame::Tracker => "tracker",
            },
            left: eye(&sample.left),
            right: eye(&sample.right),
            combined: eye(&sample.combined),
            gaze_point: sample.gaze_point.map(point),
            line_of_sight,
            rate_hz,
            lost: counts.lost,
            held_back: self.held_back,
            dropped: counts.dropped.iter().map(|&count| u64::from(count)).sum(),
            dropped_by: by_reason(counts),
            dropped_bytes: counts.dropped_bytes,
        }
    }
}

/// Numbers that a tracker measured; that it did not, where it says so.
fn write_value(
    f: &mut fmt::Formatter<'_>,
    name: &str,
    value: Option<(&[f32], bool)>,
    unit: &str,
) -> fmt::Result {
    let Some((numbers, tracked)) = value else {
        return Ok(());
    };
    write!(f, "  {name}")?;
    if !tracked {
        return f.write_str(" not tracked");
    }
    for number in numbers {
        write!(f, " {number:.3}")?;
    }
    f.write_str(unit)
}

impl fmt::Display for Record {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:10.3} s", self.arrival_us as f64 * 1.0e-6)?;
        let turn = self.head.orientation.as_ref();
        let place = self.head.position.as_ref();
        write_value(f, "head", place.map(|v| (&v.value[..], v.tracked)), " m")?;
        write_value(f, "turn", turn.map(|v| (&v.value[..], v.tracked)), "")?;
        for (name, eye) in [
            ("left", &self.left),
            ("right", &self.right),
            ("gaze", &self.combined),
        ] {
            let direction = eye.as_ref().and_then(|eye| eye.direction.as_ref());
            write_value(f, name, direction.map(|v| (&v.value[..], v.tracked)), "")?;
        }
        let point = self.gaze_point.as_ref();
        let kind = point.map_or("", |point| point.kind);
        write_value(f, kind, point.map(|p| (&p.value[..], p.tracked)), "")?;
        if let Some(Sight {
            direction: [x, y, z],
            state,
            ..
        }) = self.line_of_sight
        {
            write!(f, "  looks {x:.3} {y:.3} {z:.3} ({state})")?;
        }
        write!(
            f,
            "  {:.0} Hz  lost {}  dropped {}{}",
            self.rate_hz,
            self.lost,
            self.dropped,
            ByReason(&self.dropped_by)
        )?;
        match (self.late_us, self.clock) {
            (Some(late), _) => write!(f, "  late {:.1} ms", late as f64 * 1.0e-3),
            (None, STANDS_STILL) => write!(f, "  late unknown: the device's clock stands still"),
            (None, _) => write!(f, "  late unknown"),
        }?;
        self.said.iter().try_for_each(|said| said.fmt(f))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample(i: u64, device: Option<u64>) -> Sample {
        let mut sample = Sample::arrived(Micros(1_000_000 + 2_000 * i));
        sample.device_time = device.map(DeviceTime::unwrapped);
        sample
    }

    #[test]
    fn a_clock_that_stands_still_makes_nothing_late() {
        let mut records = Records::new(None);
        let counts = Counts::new();
        let mut record = |i: u64, time| records.next(&sample(i, time), &counts);
        for i in 0..1_000 {
            let record = record(i, Some(2_000 * i));
            assert_eq!((record.late_us, record.clock), (Some(0), RUNS));
        }
        let stopped = Some(2_000 * 999);
        for i in 1_000..2_000 {
            assert_eq!(record(i, stopped).late_us, None, "{i}");
        }
        let last = record(2_000, stopped);
        assert_eq!(last.clock, STANDS_STILL);
        assert!(
            last.to_string()
                .ends_with("the device's clock stands still")
        );
        // A device without one.
        let without = Records::new(None).next(&sample(0, None), &counts);
        assert_eq!((without.late_us, without.clock), (None, NO_CLOCK));
        assert!(without.to_string().ends_with("late unknown"), "{without}");
    }

    #[test]
    fn what_is_not_tracked_is_no_number() {
        let mut sample = sample(0, None);
        sample.left.direction = Some(Reading::tracked(Vec3::NEG_Z));
        sample.right.direction = Some(Reading::held(Vec3::NEG_Z));
        sample.head.position = Some(Reading::held(Vec3::X));
        let said = Records::new(None).next(&sample, &Counts::new()).to_string();
        let expected = "  head not tracked  left 0.000 0.000 -1.000  right not tracked  0 Hz";
        assert!(said.contains(expected), "{said}");
    }

    #[test]
    fn drops_are_told_by_reason() {
        let mut counts = Counts::new();
        counts.dropped[DropReason::Truncated as usize] = 3;
        counts.dropped[DropReason::OutOfStep as usize] = 1;
        let record = Records::new(None).next(&sample(0, None), &counts);
        assert_eq!(record.dropped, 4);
        assert_eq!(record.dropped_by["truncated"], 3);
        assert_eq!(record.dropped_by.len(), 2);
        let said = record.to_string();
        assert!(
            said.contains("dropped 4 (1 out of step, 3 truncated)"),
            "{said}"
        );
    }
}
