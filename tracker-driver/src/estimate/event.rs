//! Events that an estimator reports beside its estimates.

use super::config::Sensors;
use super::fallback::State;
use super::movement::Saccade;
use crate::time::Micros;

/// Something that happened to the gaze or to its data.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Event {
    /// The estimator moved to another rung of its fallback ladder.
    State {
        /// The rung until now.
        from: State,
        /// The rung from now on.
        to: State,
        /// The time of display for which it was decided.
        at: Micros,
    },
    /// The tracker lost the eyes: a blink, if it finds them soon.
    BlinkStarted {
        /// The time of the first sample without eyes.
        at: Micros,
    },
    /// The tracker found the eyes again.
    BlinkEnded {
        /// The time of the first sample with eyes.
        at: Micros,
        /// The length of the blink.
        lasted: Micros,
    },
    /// A saccade is under way.
    SaccadeStarted {
        /// When it was larger than noise.
        at: Micros,
    },
    /// A saccade is over.
    SaccadeEnded {
        /// The time of the sample that showed it.
        at: Micros,
        /// Its amplitude, duration and speed.
        saccade: Saccade,
    },
    /// A sensor that is not used sent a sample; reported once.
    OtherSensor {
        /// The sensor that is used.
        taken: u8,
        /// Whether that sensor has sent a sample so far.
        heard: bool,
        /// The sensor that is not used.
        ignored: u8,
    },
    /// The head's pose has been the same bits since the first sample: the head is
    /// on a stand, it follows a script without noise, or its tracker always sends
    /// the same. The pose is used; reported once.
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
    /// It is older than the newest sample. A sample with the newest time replaces
    /// it: records that came in one read have one time of arrival.
    NotNewer,
    /// The gaze is farther from straight ahead than eyes turn, or behind the head.
    Eccentric {
        /// Its angle from straight ahead, radians.
        angle: f32,
    },
    /// A gaze point without a screen or a calibration.
    Uncalibrated,
    /// A number is not finite, a place farther out than
    /// [`Ray::FARTHEST`](shisen_core::shape::Ray::FARTHEST), or a rotation has no
    /// length.
    NotFinite,
    /// The gaze has been the same bits for too long.
    Stuck {
        /// For how long.
        since: Micros,
    },
    /// A part of the head's pose that had changed before has been the same bits for too long.
    HeadStuck {
        /// The part.
        part: HeadPart,
        /// For how long.
        since: Micros,
    },
}

/// A part of the head's pose.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum HeadPart {
    /// Its place.
    Position,
    /// Rotation and angular velocity.
    Orientation,
}

/// The sensors that have sent samples; one of them may be chosen.
#[derive(Debug, Clone, Copy, Default)]
pub struct HeardSensors {
    taken: Option<u8>,
    other_reported: bool,
}

impl HeardSensors {
    /// Returns whether a sensor is used by the rule `sensors`. Reports the first one that is not
    /// to `sink`.
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
