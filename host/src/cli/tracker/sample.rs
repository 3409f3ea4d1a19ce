//! What a tracker sends, for reports.

use super::announcer::Announcer;
use super::drops::{by_reason, in_words};
use super::features::FeatureReport;
use crate::cli::prelude::*;
use crate::tracker::{Intake, TrackerEvent};
use shisen_tracker::clock::StampSource;
use shisen_tracker::decoder::{Counts, EyeEventKind, Message, Side};
use shisen_tracker::estimate::GazeEstimator;
use shisen_tracker::sample::{Eye, GazeFrame, GazePoint, Pupil, Reading, Sample};
use shisen_tracker::time::{DeviceTime, Micros};
use std::collections::{BTreeMap, VecDeque};

/// A sample, and the state of the tracker.
#[derive(Debug, Serialize, JsonSchema)]
pub(in crate::cli) struct Record {
    /// Number of the sample, from 0.
    number: u64,
    /// Time of arrival since the start, microseconds.
    arrival_us: u64,
    /// Time by the device's clock, microseconds; null if it has none.
    device_us: Option<u64>,
    /// Delay beyond the least of the last seconds, microseconds; null without a running clock.
    late_us: Option<u64>,
    /// The device's clock: runs, stands still or none.
    clock: &'static str,
    /// Number of the sensor.
    sensor: u8,
    /// Number of the sample by the device, or null.
    sequence: Option<u32>,
    /// The head, in the tracker's axes.
    head: Head,
    /// Axes of the gaze: head or tracker.
    gaze_frame: &'static str,
    /// The left eye, or null.
    left: Option<EyeReport>,
    /// The right eye, or null.
    right: Option<EyeReport>,
    /// Both eyes together, or null.
    combined: Option<EyeReport>,
    /// The point looked at, or null.
    gaze_point: Option<Point>,
    /// Where the viewer looks; null without --calibration.
    line_of_sight: Option<Sight>,
    /// Samples in the last second.
    rate_hz: f32,
    /// Samples lost, by the device's count.
    lost: u64,
    /// Unused samples that came before the device was told what to send.
    held_back: u64,
    /// Drops of bytes.
    dropped: u64,
    /// Drops of bytes by reason.
    dropped_by: BTreeMap<&'static str, u32>,
    /// Bytes dropped.
    dropped_bytes: u64,
    /// What a HID eye tracker says of itself, in the first record after it was plugged in; null
    /// otherwise.
    device: Option<FeatureReport>,
    /// What the device said since the record before, at most 64 things.
    said: Vec<DeviceMessage>,
}

/// Most things that a device says between two samples and that are kept.
const MOST_SAID: usize = 64;

const STANDS_STILL: &str = "stands still";

#[derive(Debug, Serialize, JsonSchema)]
struct Value<V> {
    /// The numbers.
    value: V,
    /// Whether the tracker sees it now; if not, the numbers are older.
    tracked: bool,
}

#[derive(Debug, Serialize, JsonSchema)]
struct Head {
    /// Position, metres, or null.
    position: Option<Value<[f32; 3]>>,
    /// Orientation x, y, z, w, or null.
    orientation: Option<Value<[f32; 4]>>,
    /// Angular velocity, radians per second, or null.
    angular_velocity: Option<[f32; 3]>,
}

#[derive(Debug, Serialize, JsonSchema)]
struct EyeReport {
    /// Position, metres, or null.
    origin: Option<Value<[f32; 3]>>,
    /// Direction of the gaze, or null.
    direction: Option<Value<[f32; 3]>>,
    /// Diameter of the pupil, metres, or null.
    pupil_m: Option<f32>,
    /// Size of the pupil in the device's own unit, or null.
    pupil_raw: Option<f32>,
    /// Opening of the lids, or null.
    openness: Option<f32>,
}

#[derive(Debug, Serialize, JsonSchema)]
struct Point {
    /// Unit: plane, normalized or raw.
    kind: &'static str,
    #[serde(flatten)]
    place: Value<[f32; 2]>,
}

#[derive(Debug, Serialize, JsonSchema)]
struct Sight {
    /// Position between the eyes in the room, metres.
    position: [f32; 3],
    /// Direction in the room.
    direction: [f32; 3],
    /// fresh, hold, widened, head direction or full quality.
    state: &'static str,
}

#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case")]
enum DeviceMessage {
    Fault {
        /// Number of the fault.
        code: u32,
        /// Meaning by the device's manual.
        meaning: &'static str,
    },
    State {
        /// Number of the state.
        code: u32,
        /// Meaning by the device's manual.
        meaning: &'static str,
    },
    Text {
        /// The text.
        text: String,
    },
    Reply {
        /// Number of the command that is answered.
        command: u32,
        /// 0 if the device agrees.
        result: u32,
        /// Meaning by the device's manual.
        meaning: &'static str,
    },
    Eyes {
        /// blink, closed, opened, lost, found, saccade or fixation.
        event: &'static str,
        /// left, right or null for both.
        eye: Option<&'static str>,
        /// Time by the device's clock, microseconds, or null.
        device_us: Option<u64>,
        /// Length of an event that is over, microseconds, or null.
        duration_us: Option<u64>,
    },
}

impl DeviceMessage {
    /// Returns what a message says; `None` for what the samples tell.
    fn of(message: &Message) -> Option<Self> {
        Some(match message {
            &Message::Fault { code, meaning } => Self::Fault { code, meaning },
            &Message::State { code, meaning } => Self::State { code, meaning },
            Message::Text(text) => Self::Text {
                text: text.as_str().into(),
            },
            Message::Reply(reply) => Self::Reply {
                command: reply.to,
                result: reply.result,
                meaning: reply.meaning,
            },
            Message::Eyes(event) => Self::Eyes {
                event: match event.kind {
                    EyeEventKind::Blink => "blink",
                    EyeEventKind::Closed => "closed",
                    EyeEventKind::Opened => "opened",
                    EyeEventKind::Lost => "lost",
                    EyeEventKind::Found => "found",
                    EyeEventKind::Saccade => "saccade",
                    EyeEventKind::Fixation => "fixation",
                    _ => return None,
                },
                eye: event.eye.map(|eye| match eye {
                    Side::Left => "left",
                    Side::Right => "right",
                }),
                device_us: event.device_time.map(|time| time.microseconds),
                duration_us: event.duration.map(|duration| duration.0),
            },
            _ => return None,
        })
    }
}

fn value<V: Into<[f32; N]>, const N: usize>(reading: Reading<V>) -> Value<[f32; N]> {
    Value {
        value: reading.value.into(),
        tracked: reading.tracked,
    }
}

fn eye(eye: &Eye) -> Option<EyeReport> {
    let (pupil_m, pupil_raw) = match eye.pupil {
        Some(Pupil::Diameter(metres)) => (Some(metres), None),
        Some(Pupil::Raw(raw)) => (None, Some(raw)),
        _ => (None, None),
    };
    (!eye.is_empty()).then(|| EyeReport {
        origin: eye.origin.map(value),
        direction: eye.direction.map(value),
        pupil_m,
        pupil_raw,
        openness: eye.openness,
    })
}

fn point(point: Reading<GazePoint>) -> Point {
    let (kind, place) = match point.value {
        GazePoint::Plane(place) => ("plane", place),
        GazePoint::Normalized(place) => ("normalized", place),
        GazePoint::Raw(place) => ("raw", place),
    };
    let place = Value {
        value: place.to_array(),
        tracked: point.tracked,
    };
    Point { kind, place }
}

/// Makes the record of each sample.
pub(super) struct Records {
    intake: Intake,
    sight: Option<GazeEstimator>,
    announcer: Announcer,
    count: u64,
    /// Samples that came before the device was set up.
    pub(super) held_back: u64,
    /// Arrivals within the last second.
    recent: VecDeque<Micros>,
    /// The device's time of the last sample.
    shown: Option<DeviceTime>,
    /// What the next record says of the device.
    pub(super) described: Option<FeatureReport>,
    said: Vec<DeviceMessage>,
}

impl Records {
    /// With an estimator, records say where the viewer looks.
    pub(super) fn new(intake: Intake, sight: Option<GazeEstimator>) -> Self {
        Self {
            intake,
            sight,
            announcer: Announcer::default(),
            count: 0,
            held_back: 0,
            recent: VecDeque::new(),
            shown: None,
            described: None,
            said: Vec::new(),
        }
    }

    /// Announces what the device said, and puts it into the next record.
    pub(super) fn hear(&mut self, message: &Message, now: Micros) {
        if let Some(sight) = &mut self.sight {
            sight.on_message(message, &mut |_| {});
        }
        self.announcer.announce(TrackerEvent::Device(*message, now));
        if self.said.len() < MOST_SAID {
            self.said.extend(DeviceMessage::of(message));
        }
    }

    /// Takes note of how far the device's clock is ahead.
    pub(super) fn hear_offset(&mut self, at: Micros, offset: i64) {
        self.intake.set_offset(at, offset);
    }

    pub(super) fn next(&mut self, sample: &Sample, counts: &Counts) -> Record {
        let arrival = sample.arrival;
        let announcer = &mut self.announcer;
        let stamp = self
            .intake
            .stamp(sample, &mut |event| announcer.announce(event));
        let moved = self.shown != sample.device_time;
        self.shown = sample.device_time;
        let frozen = self.intake.is_frozen();
        let intake = &mut self.intake;
        let line_of_sight = self.sight.as_mut().map(|sight| {
            let time = stamp.time;
            let taken = intake.take_stamped(sample, time, &mut |event| announcer.announce(event));
            if let Some((sample, time)) = taken {
                sight.push(&sample, time, &mut |event| {
                    announcer.announce(TrackerEvent::Gaze(event, arrival));
                });
            }
            let estimate = sight.estimate(arrival, &mut |_| {});
            Sight {
                position: estimate.line_of_sight.position().to_array(),
                direction: estimate.line_of_sight.forward().to_array(),
                state: estimate.state.name(),
            }
        });
        self.recent.push_back(arrival);
        let second = Micros::from_millis(1_000);
        let is_old = |&time: &Micros| arrival.since(time) > second;
        while self.recent.front().is_some_and(is_old) {
            self.recent.pop_front();
        }
        let first = self.recent.front().copied().unwrap_or(arrival);
        let spanned = arrival.since(first).seconds();
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
            late_us: (stamp.source == StampSource::Device && moved && !frozen)
                .then(|| arrival.since(stamp.time).0),
            clock: match sample.device_time {
                None => "none",
                Some(_) if frozen => STANDS_STILL,
                Some(_) => "runs",
            },
            sensor: sample.sensor,
            sequence: sample.sequence,
            head: Head {
                position: sample.head.position.map(value),
                orientation: sample.head.orientation.map(value),
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

/// Writes measured numbers, or that they are not tracked.
fn write_value<const N: usize>(
    f: &mut fmt::Formatter<'_>,
    name: &str,
    value: Option<&Value<[f32; N]>>,
    unit: &str,
) -> fmt::Result {
    let Some(Value { value, tracked }) = value else {
        return Ok(());
    };
    write!(f, "  {name}")?;
    if !tracked {
        return f.write_str(" not tracked");
    }
    for number in value {
        write!(f, " {number:.3}")?;
    }
    f.write_str(unit)
}

impl fmt::Display for DeviceMessage {
    /// Writes events of the eyes; standard error has the rest.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self::Eyes {
            event,
            eye,
            duration_us,
            ..
        } = self
        else {
            return Ok(());
        };
        f.write_str("  ")?;
        if let Some(eye) = eye {
            write!(f, "{eye} eye ")?;
        }
        f.write_str(event)?;
        match duration_us {
            Some(duration) => write!(f, " of {} ms", duration / 1_000),
            None => Ok(()),
        }
    }
}

impl fmt::Display for Record {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:10.3} s", self.arrival_us as f64 * 1.0e-6)?;
        write_value(f, "head", self.head.position.as_ref(), " m")?;
        write_value(f, "turn", self.head.orientation.as_ref(), "")?;
        for (name, eye) in [
            ("left", &self.left),
            ("right", &self.right),
            ("gaze", &self.combined),
        ] {
            let direction = eye.as_ref().and_then(|eye| eye.direction.as_ref());
            write_value(f, name, direction, "")?;
        }
        if let Some(Point { kind, place }) = &self.gaze_point {
            write_value(f, kind, Some(place), "")?;
        }
        if let Some(sight) = &self.line_of_sight {
            let ([x, y, z], state) = (sight.direction, sight.state);
            write!(f, "  looks {x:.3} {y:.3} {z:.3} ({state})")?;
        }
        let (rate, lost, dropped) = (self.rate_hz, self.lost, self.dropped);
        write!(f, "  {rate:.0} Hz  lost {lost}  ")?;
        write!(f, "dropped {dropped}{}", in_words(&self.dropped_by))?;
        match (self.late_us, self.clock) {
            (Some(late), _) => write!(f, "  late {:.1} ms", late as f64 * 1.0e-3),
            (None, STANDS_STILL) => write!(f, "  latency: the device's clock stands still"),
            (None, _) => write!(f, "  latency: the device has no clock"),
        }?;
        self.said.iter().try_for_each(|said| said.fmt(f))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tracker::Role;
    use glam::Vec3;
    use shisen_tracker::clock::ClockEstimator;
    use shisen_tracker::decoder::DropReason;

    #[test]
    fn lines_have_what_is_not_tracked_and_drops_by_reason() {
        let mut sample = Sample::arrived(Micros(1_000_000));
        sample.left.direction = Some(Reading::tracked(Vec3::NEG_Z));
        sample.right.direction = Some(Reading::held(Vec3::NEG_Z));
        sample.head.position = Some(Reading::held(Vec3::X));
        let mut counts = Counts::new();
        counts.dropped[DropReason::Truncated as usize] = 3;
        counts.dropped[DropReason::OutOfStep as usize] = 1;
        let spec = "mock".parse().unwrap();
        let intake = Intake::new(Role::All, ClockEstimator::default(), &spec, None);
        let record = Records::new(intake, None).next(&sample, &counts);
        assert_eq!((record.dropped, record.dropped_by["truncated"]), (4, 3));
        let line = record.to_string();
        let expected = "  head not tracked  left 0.000 0.000 -1.000  right not tracked  0 Hz  \
                        lost 0  dropped 4 (1 out of step, 3 truncated)  latency: the device has \
                        no clock";
        assert!(line.ends_with(expected), "{line}");
    }
}
