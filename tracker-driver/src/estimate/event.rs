//! What an estimator has to say beside its estimates.

use super::config::Sensors;
use super::fallback::State;
use super::movement::Saccade;
use crate::time::Micros;

/// Something that happened to the gaze or to its data.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Event {
    /// Another rung of the ladder is taken.
    State {
        /// The rung until now.
        from: State,
        /// The rung from now on.
        to: State,
        /// The time of display for which it was decided.
        at: Micros,
    },
    /// The eyes were lost: a blink, if they are back soon.
    BlinkStarted {
        /// The time of the first sample that says so.
        at: Micros,
    },
    /// The eyes are back.
    BlinkEnded {
        /// When they were seen again.
        at: Micros,
        /// Since it started.
        lasted: Micros,
    },
    /// A saccade is under way.
    SaccadeStarted {
        /// When it was told from noise.
        at: Micros,
    },
    /// A saccade is over.
    SaccadeEnded {
        /// When that was known.
        at: Micros,
        /// What it was like.
        saccade: Saccade,
    },
    /// A sensor that does not count says something; reported once.
    OtherSensor {
        /// The sensor that counts.
        taken: u8,
        /// Whether that has said anything so far.
        heard: bool,
        /// The one that does not.
        ignored: u8,
    },
    /// The head has not changed by a bit since it was first seen: it is on a
    /// stand, it follows a script without noise, or its tracker always says the
    /// same. It is believed; this is said once.
    HeadStill {
        /// The sample's time.
        at: Micros,
        /// For how long.
        since: Micros,
    },
    /// A part of a sample was not used.
    Rejected {
        /// The sample's time.
        at: Micros,
        /// Why.
        reason: Rejection,
    },
}

/// Why a part of a sample was not used.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Rejection {
    /// It is older than what is known. What has the time of the newest takes
    /// its place: records that came in one read have one time of arrival.
    NotNewer,
    /// The gaze is farther from straight ahead than eyes turn, or behind the head.
    Eccentric {
        /// How far, radians.
        angle: f32,
    },
    /// A gaze point without a screen or a calibration.
    Uncalibrated,
    /// A number is not finite, a place farther out than
    /// [`Ray::FARTHEST`](shisen_core::shape::Ray::FARTHEST), or a rotation has no
    /// length.
    NotFinite,
    /// The gaze has not changed by a bit for too long.
    Stuck {
        /// For how long.
        since: Micros,
    },
    /// A part of the head's pose that had changed before has not by a bit for too long.
    HeadStuck {
        /// Which.
        part: HeadPart,
        /// For how long.
        since: Micros,
    },
}

/// A part of the head's pose.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum HeadPart {
    /// Where it is.
    Position,
    /// How it is turned, and how fast.
    Orientation,
}

/// The sensors that have said something, of which one may count.
#[derive(Debug, Clone, Copy, Default)]
pub struct HeardSensors {
    taken: Option<u8>,
    other_reported: bool,
}

impl HeardSensors {
    /// Whether a sensor counts by `sensors`; the first that does not is reported to `sink`.
    pub fn counts(&mut self, sensors: Sensors, heard: u8, sink: &mut dyn FnMut(Event)) -> bool {
        let taken = match sensors {
            Sensors::All => return true,
            Sensors::First => *self.taken.get_or_insert(heard),
            Sensors::Only(taken) => taken,
        };
        if taken == heard {
            self.taken = Some(heard);
        } else if !core::mem::replace(&mut self.other_reported, true) {
            sink(Event::OtherSensor {
                taken,
                heard: self.taken.is_some(),
                ignored: heard,
            });
        }
        taken == heard
    }
}
