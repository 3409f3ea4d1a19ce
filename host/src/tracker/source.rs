//! A viewer's trackers: one that measures the head and the eyes, or one for each, side by side.

use super::calibration::Calibrated;
use super::feed::{Feed, FeedClock};
use super::notice::{Notice, Trouble};
use super::spec::Spec;
use glam::{Quat, Vec3};
use shisen_core::gaze::HeadPose;
use shisen_tracker::clock::{self, ClockEstimator, Stamp};
use shisen_tracker::decoder::{Counts, Message};
use shisen_tracker::estimate::{self, GazeEstimator, HeardSensors, Sensors};
use shisen_tracker::sample::{Eye, GazeFrame, Head, Reading, Sample};
use shisen_tracker::time::Micros;
use std::collections::VecDeque;
use std::fmt;

/// What a tracker is read for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// All that it measures.
    All,
    /// The head alone: `head=SPEC`.
    Head,
    /// The eyes alone: `gaze=SPEC`.
    Gaze,
    /// What steers alone: `--navigate SPEC`.
    Wand,
}

impl Role {
    /// Returns its word in a command line; `None` for all.
    pub const fn name(self) -> Option<&'static str> {
        match self {
            Self::All => None,
            Self::Head => Some("head"),
            Self::Gaze => Some("gaze"),
            Self::Wand => Some("wand"),
        }
    }
}

/// An event of a tracker that is reported to people.
#[derive(Debug, Clone, PartialEq)]
#[allow(clippy::large_enum_variant, reason = "events must not allocate")]
pub enum TrackerEvent {
    /// A notice of the feed: a device that comes and goes.
    Feed(Notice),
    /// A message of the device, and when it came.
    Device(Message, Micros),
    /// What is wrong, and the counts until then.
    Trouble(Trouble, Counts),
    /// An event of the device's clock, and the arrival of its sample.
    Clock(clock::ClockEvent, Micros),
    /// An event of the gaze, and the arrival of its sample.
    Gaze(estimate::Event, Micros),
    /// Too many samples: from this time on one in this many is used.
    Flood(u64, Micros),
}

/// One of a viewer's trackers.
#[derive(Debug)]
pub struct Source {
    /// Its events.
    pub feed: Feed,
    /// What becomes of its samples.
    pub intake: Intake,
}

/// What becomes of a tracker's samples before they are the viewer's.
pub struct Intake {
    role: Role,
    clock: ClockEstimator,
    sensors: Sensors,
    heard: HeardSensors,
    /// Microseconds from the feed's clock to the viewer's.
    shift: i64,
    /// The axes between the eyes in those of the sensor; `None`: they are the same.
    sensor_from_eyes: Option<HeadPose>,
    /// From the gaze's tracker's axes to those of the head's; `None`: it is the same tracker.
    turn: Option<Quat>,
}

impl fmt::Debug for Intake {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Intake")
            .field("role", &self.role)
            .finish_non_exhaustive()
    }
}

impl Intake {
    /// Returns the intake of a tracker by its specification and calibration.
    pub(crate) fn new(
        role: Role,
        clock: ClockEstimator,
        spec: &Spec,
        calibrated: Option<&Calibrated>,
    ) -> Self {
        Self {
            role,
            clock,
            sensors: spec.head.map_or(Sensors::First, Sensors::Only),
            heard: HeardSensors::default(),
            shift: 0,
            sensor_from_eyes: calibrated.and_then(Calibrated::sensor_from_eyes),
            turn: None,
        }
    }

    /// Returns what the tracker is read for.
    pub const fn role(&self) -> Role {
        self.role
    }

    /// Takes the times of another tracker's clock, and its directions by the axes of that one.
    pub(crate) fn follow(&mut self, own: &FeedClock, others: &FeedClock, turn: Quat) {
        self.shift = others.begin().0 as i64 - own.begin().0 as i64;
        self.turn = Some(turn);
    }

    /// Takes note that at a time the device's clock showed so many microseconds more.
    pub fn set_offset(&mut self, at: Micros, offset: i64) {
        self.clock.set_offset(at, offset);
    }

    /// Returns how much faster the feed's clock runs than the device's, parts per billion; `None` in
    /// the first seconds.
    pub fn rate(&self) -> Option<i64> {
        self.clock.rate()
    }

    /// Returns whether the device's clock stands still.
    pub fn is_frozen(&self) -> bool {
        self.clock.is_frozen()
    }

    /// Returns when a sample was measured, by the feed's clock.
    pub fn stamp(&mut self, sample: &Sample, sink: &mut dyn FnMut(TrackerEvent)) -> Stamp {
        let arrival = sample.arrival;
        self.clock.stamp(sample, &mut |event| {
            sink(TrackerEvent::Clock(event, arrival));
        })
    }

    /// Returns a sample as the viewer's, and when it was measured by the viewer's clock; `None` for
    /// one of another sensor.
    pub fn take(
        &mut self,
        sample: &Sample,
        sink: &mut dyn FnMut(TrackerEvent),
    ) -> Option<(Sample, Micros)> {
        let time = self.stamp(sample, sink).time;
        self.take_stamped(sample, time, sink)
    }

    /// Does the same with a sample that was measured at `time` by the feed's clock.
    pub(crate) fn take_stamped(
        &mut self,
        sample: &Sample,
        time: Micros,
        sink: &mut dyn FnMut(TrackerEvent),
    ) -> Option<(Sample, Micros)> {
        let arrival = sample.arrival;
        let is_own = self
            .heard
            .counts(self.sensors, sample.sensor, &mut |event| {
                sink(TrackerEvent::Gaze(event, arrival));
            });
        is_own.then(|| (self.of_viewer(sample), self.at(time)))
    }

    /// Returns a time of the feed's clock by the viewer's.
    pub const fn at(&self, time: Micros) -> Micros {
        Micros(time.0.saturating_add_signed(self.shift))
    }

    fn of_viewer(&self, sample: &Sample) -> Sample {
        let mut own = *sample;
        own.sensor = 0;
        own.arrival = self.at(sample.arrival);
        if self.role == Role::Head {
            [own.left, own.right, own.combined] = [Eye::default(); 3];
            own.gaze_point = None;
        }
        if self.role == Role::Gaze {
            own.head = Head::default();
        }
        let eyes = |sample: &mut Sample, change: &dyn Fn(&mut Eye)| {
            for eye in [&mut sample.left, &mut sample.right, &mut sample.combined] {
                change(eye);
            }
        };
        if let (Some(turn), GazeFrame::Tracker) = (self.turn, own.gaze_frame) {
            eyes(&mut own, &|eye| turn_back(&mut eye.direction, turn));
        }
        if let Some(HeadPose {
            position,
            orientation,
        }) = self.sensor_from_eyes
        {
            if let (Some(place), Some(turn)) = (&mut own.head.position, own.head.orientation) {
                place.value += turn.value * position;
            }
            if let Some(turn) = &mut own.head.orientation {
                turn.value = (turn.value * orientation).normalize();
            }
            // About the head's own axes.
            let back = orientation.conjugate();
            own.head.angular_velocity = own.head.angular_velocity.map(|about| back * about);
            if own.gaze_frame == GazeFrame::Head {
                eyes(&mut own, &|eye| {
                    turn_back(&mut eye.direction, back);
                    if let Some(origin) = &mut eye.origin {
                        origin.value -= position;
                    }
                    turn_back(&mut eye.origin, back);
                });
            }
        }
        own
    }
}

/// A viewer's gaze, of one tracker or of two.
///
/// A gaze in the head is one in the room by the head's pose at that time. Where the head's samples
/// come later and the head turns, the gaze waits for them.
#[derive(Debug)]
pub struct ComposedGaze {
    /// What makes a line of sight of samples.
    pub estimator: GazeEstimator,
    /// Gazes that wait, in the order of their times.
    waiting: VecDeque<(Sample, Micros)>,
    /// The head's newest orientations, the newest last.
    heads: VecDeque<(Micros, Quat)>,
}

/// Orientations from the first to the last of which the head's turn is taken.
const HEADS: usize = 8;

/// The longest wait for the head, and the turn until then for which a gaze does not wait, radians.
const LONGEST_WAIT: Micros = Micros::from_millis(50);
const NO_TURN: f32 = 0.005;

/// Most gazes that wait: as many as 1,000 a second send meanwhile.
const MOST_WAITING: usize = 64;

impl ComposedGaze {
    /// Returns the viewer of an estimator that has seen nothing.
    pub fn new(estimator: GazeEstimator) -> Self {
        Self {
            estimator,
            waiting: VecDeque::with_capacity(MOST_WAITING),
            heads: VecDeque::with_capacity(HEADS),
        }
    }

    /// Takes a sample that was measured at `time`, of a tracker that is read for `role`.
    pub fn push(
        &mut self,
        role: Role,
        sample: &Sample,
        time: Micros,
        sink: &mut dyn FnMut(estimate::Event),
    ) {
        if role == Role::Gaze && self.waits(time) {
            self.waiting.push_back((*sample, time));
            return;
        }
        let head = sample
            .head
            .orientation
            .filter(|one| one.tracked && role == Role::Head);
        if let Some(head) = head {
            if self.heads.len() == HEADS {
                self.heads.pop_front();
            }
            self.heads.push_back((time, head.value));
            self.estimator.push(sample, time, sink);
        }
        // Those that the head's newest sample reaches, or all where they wait no longer.
        while let Some((gaze, at)) = self.waiting.pop_front_if(|(_, at)| *at <= time) {
            self.estimator.push(&gaze, at, sink);
        }
        if head.is_none() {
            self.estimator.push(sample, time, sink);
        }
    }

    /// Returns whether a gaze of this time waits for the head's pose then.
    fn waits(&self, time: Micros) -> bool {
        let (Some((first, before)), Some((newest, head))) = (self.heads.front(), self.heads.back())
        else {
            return false;
        };
        let (gap, span) = (time.since(*newest), newest.since(*first).seconds());
        let turn = before.angle_between(*head) / span.max(1.0e-3) * gap.seconds();
        let is_turning = turn > NO_TURN || !self.waiting.is_empty();
        gap.0 > 0 && gap <= LONGEST_WAIT && is_turning && self.waiting.len() < MOST_WAITING
    }
}

fn turn_back(reading: &mut Option<Reading<Vec3>>, turn: Quat) {
    if let Some(reading) = reading {
        reading.value = turn * reading.value;
    }
}

#[cfg(test)]
mod tests;
