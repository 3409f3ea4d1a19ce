//! From samples to the line of sight at the time of display.
//!
//! A [`GazeEstimator`] takes samples as they come, from one device or from a
//! head tracker and an eye tracker side by side, each with its time on the
//! caller's clock (a [`ClockEstimator`](crate::clock::ClockEstimator) knows
//! it), and gives an [`Estimate`] for any time.
//!
//! - **Gaze is judged in the room**, not in the head: while the head turns,
//!   eyes that rest on something turn against it, and only their sum stands
//!   still. The head's own prediction moves the eye's place and the top of
//!   the head, not the line of sight.
//! - **Fixation** is not predicted; **pursuit** goes on at its velocity; a
//!   **saccade** goes on along the course fitted to it and lands where that
//!   ends ([`Estimate::landing`]).
//! - **Eyes that the device does not see** are a blink: by what its samples lack, and
//!   by its own word ([`GazeEstimator::on_message`]).
//! - **Stale data are not passed off as fresh**: [`Estimate::state`] says
//!   which rung of the ladder is taken, and every change is an
//!   [`Event::State`]. A gaze, or the head's position or orientation, that stops
//!   changing by a bit counts as measured when it last changed
//!   ([`EstimatorConfig::stuck_after`], [`EstimatorConfig::head_stuck_after`]),
//!   and one whose device's clock stands still ages by its time.
//!
//! [`GazePrediction`] says what prediction is worth.

mod calibration;
mod config;
mod event;
mod fallback;
mod gaze;
mod head;
mod hidden;
mod least_squares;
mod movement;
mod one_euro;
mod trend;
mod unchanged;

pub use calibration::{
    Calibration, CalibrationError, MOST_ECCENTRICITY, Model, Residual, Target, plane_of,
};
pub use config::{
    EstimatorConfig, EstimatorConfigError, Eyes, Filter, GazePrediction, RoomFromTracker, Screen,
    Sensors,
};
pub use event::{Event, HeadPart, HeardSensors, Rejection};
pub use fallback::{FallbackConfig, State};
pub use gaze::Measured;
pub use head::HeadConfig;
#[cfg(any(test, feature = "mock"))]
pub(crate) use movement::minimum_jerk;
pub use movement::{Landing, Movement, PursuitConfig, Saccade, SaccadeConfig};
pub use one_euro::OneEuroConfig;

use crate::decoder::Message;
use crate::rotation::{along, angle, rotate};
use crate::sample::{Head, Sample};
use crate::time::Micros;
use fallback::Age;
use gaze::Gaze;
use glam::Vec3;
use head::{HeadTrack, forward};
use hidden::Hidden;
use movement::{Change, EyeTrack};
use one_euro::OneEuro;
use shisen_core::gaze::{HeadPose, LineOfSight};
use shisen_core::numeric::{largest_magnitude, sin_cos};
use shisen_core::shape::Ray;
use trend::seconds;
use unchanged::{Fingerprint, Unchanged};

/// Where the viewer looks at a time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// The time that was asked for, or that of the newest data where these are newer.
    pub for_time: Micros,
    /// Where the viewer looks: the head's direction from [`State::HeadDirection`] on.
    pub line_of_sight: LineOfSight,
    /// Where the head is.
    pub head: HeadPose,
    /// How much of this can be relied on.
    pub state: State,
    /// By how much the field of full detail has to be wider, radians: 0 in
    /// [`State::Fresh`] and [`State::Hold`], π in [`State::FullQuality`].
    pub widen: f32,
    /// Whether the eyes are shut, or were when last heard of.
    pub blink: bool,
    /// What the eyes do.
    pub movement: Movement,
    /// Where a saccade under way will land.
    pub landing: Option<Landing>,
    /// When the newest gaze was measured; of one that is stuck, when it last changed.
    pub gaze_time: Option<Micros>,
    /// When the head's pose was measured, its older part; if stuck, when it last changed.
    pub head_time: Option<Micros>,
    /// How old the gaze is at [`for_time`](Self::for_time).
    pub gaze_age: Option<Micros>,
    /// How late the filter makes a steady movement, seconds; prediction makes up for it.
    pub group_delay: f32,
}

/// Eyes that are not seen.
#[derive(Debug, Clone, Copy)]
struct Lost {
    /// When they were last seen.
    seen: Micros,
    /// The first sample that says so.
    since: Micros,
    /// The newest sample that says so.
    until: Micros,
}

/// What samples and messages have said beside poses and gazes.
#[derive(Debug, Clone, Copy, Default)]
struct Heard {
    sensors: HeardSensors,
    lost: Option<Lost>,
    /// The eyes that the device reports as hidden.
    hidden: Hidden,
    /// The time of the newest sample.
    newest: Micros,
    /// What decides the gaze.
    same_gaze: Unchanged,
    /// The head's position and its orientation.
    same_head: [Unchanged; 2],
    /// Whether the unchanged head has been reported.
    still_said: bool,
}

/// Turns samples into the line of sight. One for each viewer.
///
/// It keeps the newest `HEAD` poses of the head and `EYES` gazes: enough for the spans of
/// [`HeadConfig::window`] and [`PursuitConfig::window`] at 1,000 Hz as they come, and at 500 Hz
/// with 24 and 64, in little more than half of the memory. With shorter ones spans are shorter,
/// and pursuit is not predicted with less than half of its window.
#[derive(Debug, Clone)]
pub struct GazeEstimator<const HEAD: usize = 64, const EYES: usize = 128> {
    config: EstimatorConfig,
    /// The cosine of the largest eccentricity.
    least_ahead: f32,
    heard: Heard,
    head: HeadTrack<HEAD>,
    eyes: EyeTrack<EYES>,
    filter: Option<OneEuro>,
    /// As it was before the newest direction.
    filter_before: Option<OneEuro>,
    /// The newest direction in the room, filtered.
    smooth: Vec3,
    state: State,
    /// The newest one; what is shown if ever none can be made.
    sight: LineOfSight,
}

impl GazeEstimator {
    /// Returns one that has seen nothing: [`State::FullQuality`].
    ///
    /// # Errors
    /// Values that [`EstimatorConfig::check`] refuses.
    // Inlined: builds the state in its place, without a copy on the stack.
    #[inline(always)]
    pub fn new(config: EstimatorConfig) -> Result<Self, EstimatorConfigError> {
        Self::with_histories(config)
    }
}

impl<const HEAD: usize, const EYES: usize> GazeEstimator<HEAD, EYES> {
    /// Does what [`GazeEstimator::new`] does, with histories of these lengths.
    ///
    /// # Errors
    /// Values that [`EstimatorConfig::check`] refuses.
    #[inline(always)]
    pub fn with_histories(config: EstimatorConfig) -> Result<Self, EstimatorConfigError> {
        config.check()?;
        let (_, least_ahead) = sin_cos(config.most_eccentricity);
        let resting = config.resting_head;
        let sight = sight(&resting, forward(&resting));
        Ok(Self {
            sight: sight.ok_or(EstimatorConfigError::NotFinite("the resting head"))?,
            config,
            least_ahead,
            heard: Heard::default(),
            head: HeadTrack::new(config.head, config.resting_head),
            eyes: EyeTrack::new(
                config.saccades,
                config
                    .prediction
                    .map_or_else(PursuitConfig::default, |p| p.pursuit),
            ),
            filter_before: None,
            filter: match config.filter {
                Filter::None => None,
                Filter::OneEuro(config) => Some(OneEuro::new(config)),
            },
            smooth: Vec3::NEG_Z,
            state: State::FullQuality,
        })
    }

    /// Returns what it was told.
    pub const fn config(&self) -> &EstimatorConfig {
        &self.config
    }

    /// Returns the rung taken by the newest estimate.
    pub const fn state(&self) -> State {
        self.state
    }

    /// Takes a sample that was measured at `time`.
    // Not inlined: keeps its code out of the decoders whose events it takes.
    #[inline(never)]
    pub fn push(&mut self, sample: &Sample, time: Micros, sink: &mut dyn FnMut(Event)) {
        if !self
            .heard
            .sensors
            .counts(self.config.sensors, sample.sensor, sink)
        {
            return;
        }
        if self.config.head_tracked {
            self.push_head(&sample.head, time, sink);
        }
        self.heard.newest = self.heard.newest.max(time);
        self.heard
            .hidden
            .look(sample, time, self.config.fallback.longest_blink);
        let mut reject = |reason| sink(Event::Rejected { at: time, reason });
        let head = self.head.at(time);
        match gaze::of_sample(&self.config, sample, &head, self.heard.hidden.eyes()) {
            Gaze::None => {}
            Gaze::Uncalibrated => reject(Rejection::Uncalibrated),
            Gaze::Lost => self.lose(time, sink),
            Gaze::Seen { direction, reading } => {
                // NaN fails the comparison too.
                if !(-direction.z >= self.least_ahead) {
                    let angle = angle(direction, Vec3::NEG_Z);
                    reject(Rejection::Eccentric { angle });
                } else if let Some(since) = self.gaze_stuck(reading, time) {
                    reject(Rejection::Stuck { since });
                } else {
                    let direction = rotate(head.orientation, direction);
                    self.push_gaze(direction, time, sink);
                }
            }
        }
    }

    /// Takes which eyes the device says are shut or lost. Without any that count this is a
    /// blink from the sample before on, and samples have no gaze until the device says that an
    /// eye is back, or the eye is measured [`FallbackConfig::longest_blink`] later. Other
    /// messages change nothing.
    #[inline(never)]
    pub fn on_message(&mut self, message: &Message, sink: &mut dyn FnMut(Event)) {
        let Message::Eyes(event) = message else {
            return;
        };
        self.heard.hidden.hear(event, self.heard.newest);
        if self.heard.hidden.hides(self.config.eyes) {
            self.lose(self.heard.newest, sink);
        }
    }

    fn push_head(&mut self, head: &Head, time: Micros, sink: &mut dyn FnMut(Event)) {
        let [position, orientation] = self.head_stuck(head, time, sink);
        let mut reject = |reason| sink(Event::Rejected { at: time, reason });
        let room = self.config.room_from_tracker;
        if let Some(position) = head.position.filter(|p| p.tracked && !position) {
            let place = room.place(position.value);
            if !(largest_magnitude(place) <= Ray::FARTHEST && place.is_finite()) {
                reject(Rejection::NotFinite);
            } else if !self.head.push_position(time, place) {
                reject(Rejection::NotNewer);
            }
        }
        if let Some(orientation) = head.orientation.filter(|o| o.tracked && !orientation) {
            let Some(orientation) = room.orientation(orientation.value) else {
                return reject(Rejection::NotFinite);
            };
            let turn = head.angular_velocity.filter(|turn| turn.is_finite());
            let turn = turn.map(|turn| rotate(orientation, turn));
            if !self.head.push_orientation(time, orientation, turn) {
                reject(Rejection::NotNewer);
            }
        }
    }

    /// Returns whether position and orientation are the same for too long after a change was seen.
    fn head_stuck(&mut self, head: &Head, time: Micros, sink: &mut dyn FnMut(Event)) -> [bool; 2] {
        let Some(most) = self.config.head_stuck_after else {
            return [false; 2];
        };
        let position = head.position.filter(|p| p.tracked);
        let position = position.map(|p| Fingerprint::of(&p.value.to_array()));
        let orientation = head.orientation.filter(|o| o.tracked).map(|o| {
            let turn = head.angular_velocity.map(|turn| turn.to_array());
            let turn: &[f32] = turn.as_ref().map_or(&[], |turn| turn);
            Fingerprint::of(&o.value.to_array()).and(turn)
        });
        let (mut shortest, mut changed) = (None, false);
        let mut stuck = [false; 2];
        let parts = [HeadPart::Position, HeadPart::Orientation];
        let readings = [position, orientation];
        for (((part, reading), same), stuck) in parts
            .into_iter()
            .zip(readings)
            .zip(&mut self.heard.same_head)
            .zip(&mut stuck)
        {
            let Some(reading) = reading else {
                continue;
            };
            let since = same.push(reading, time);
            shortest = Some(shortest.map_or(since, |shortest: Micros| shortest.min(since)));
            changed |= same.has_changed();
            if since > most && same.has_changed() {
                *stuck = true;
                same.set_stuck();
                let reason = Rejection::HeadStuck { part, since };
                sink(Event::Rejected { at: time, reason });
            }
        }
        let still = shortest.filter(|since| *since > most && !changed);
        if let (Some(since), false) = (still, self.heard.still_said) {
            self.heard.still_said = true;
            sink(Event::HeadStill { at: time, since });
        }
        stuck
    }

    /// For how long the gaze has been the same, if that is too long.
    fn gaze_stuck(&mut self, reading: Fingerprint, time: Micros) -> Option<Micros> {
        let most = self.config.stuck_after?;
        let since = self.heard.same_gaze.push(reading, time);
        let stuck = since > most;
        if stuck {
            self.heard.same_gaze.set_stuck();
        }
        stuck.then_some(since)
    }

    /// Returns when the gaze was measured that is shown.
    fn gaze_time(&self) -> Option<Micros> {
        let newest = self.eyes.newest().map(|(time, _)| time);
        self.heard.same_gaze.measured(newest)
    }

    /// Returns when the head's pose was measured, its older part; `None` before any.
    fn head_time(&self) -> Option<Micros> {
        let [position, orientation] = &self.heard.same_head;
        let position = position.measured(self.head.position_time());
        let orientation = orientation.measured(self.head.orientation_time());
        match (position, orientation) {
            (Some(a), Some(b)) => Some(a.min(b)),
            (a, b) => a.or(b),
        }
    }

    fn lose(&mut self, time: Micros, sink: &mut dyn FnMut(Event)) {
        let (Some((newest, _)), Some(seen)) = (self.eyes.newest(), self.gaze_time()) else {
            return;
        };
        if time < newest {
            return;
        }
        let since = self.heard.lost.map_or(time, |lost| lost.since);
        if self.heard.lost.is_none() {
            self.heard.same_gaze.interrupt();
            sink(Event::BlinkStarted { at: time });
        }
        self.heard.lost = Some(Lost {
            seen,
            since,
            until: time,
        });
    }

    fn push_gaze(&mut self, direction: Vec3, time: Micros, sink: &mut dyn FnMut(Event)) {
        let last = self.eyes.newest();
        if last.is_some_and(|(last, _)| time < last) {
            let reason = Rejection::NotNewer;
            return sink(Event::Rejected { at: time, reason });
        }
        if let Some(lost) = self.heard.lost.take() {
            let lasted = time.since(lost.since);
            sink(Event::BlinkEnded { at: time, lasted });
        }
        if last.is_some_and(|(last, _)| time == last) {
            self.filter = self.filter_before;
        } else {
            self.filter_before = self.filter;
        }
        let gap = self.eyes.before(time).map(|last| time.since(last));
        let change = self.eyes.push(time, direction);
        match change {
            Some(Change::Started) => sink(Event::SaccadeStarted { at: time }),
            Some(Change::Ended(saccade)) => sink(Event::SaccadeEnded { at: time, saccade }),
            None => {}
        }
        let Some(filter) = &mut self.filter else {
            self.smooth = direction;
            return;
        };
        let started_anew = gap.is_none_or(|gap| gap > self.config.saccades.most_gap);
        self.smooth = if self.eyes.in_saccade() {
            filter.reset();
            direction
        } else if matches!(change, Some(Change::Ended(_))) {
            filter.reset();
            filter.filter(self.eyes.mean_since_saccade().unwrap_or(direction), 0.0)
        } else {
            if started_anew {
                filter.reset();
            }
            filter.filter(direction, gap.unwrap_or_default().seconds())
        };
    }

    /// Forgets all samples, as after a change of viewers; the next estimate decides the state.
    pub fn reset(&mut self) {
        self.heard = Heard::default();
        self.head = HeadTrack::new(self.config.head, self.config.resting_head);
        self.eyes.clear();
        if let Some(filter) = &mut self.filter {
            filter.reset();
        }
    }

    /// Returns where the viewer looks at `time`, when the frame will be seen; a time before the
    /// newest data counts as theirs ([`Estimate::for_time`]).
    #[inline(never)]
    pub fn estimate(&mut self, time: Micros, sink: &mut dyn FnMut(Event)) -> Estimate {
        let (gaze_time, head_time) = (self.gaze_time(), self.head_time());
        let newest = self.eyes.newest().map(|(time, _)| time);
        let time = time.max(newest.max(self.head.newest()).unwrap_or(time));
        let fallback = self.config.fallback;
        let of = |at: Option<Micros>| at.map_or(Age::Never, |at| Age::Of(time.since(at)));
        let gaze_age = match self.config.eyes {
            Eyes::HeadOnly => Age::Unused,
            _ => of(gaze_time),
        };
        let head_age = if self.config.head_tracked {
            of(head_time)
        } else {
            Age::Unused
        };
        // The tracker has to go on saying that the eyes are shut: one that
        // fell silent says nothing.
        let blink = self.heard.lost.is_some_and(|lost| {
            time.since(lost.seen) <= fallback.longest_blink
                && time.since(lost.until) < fallback.widen_after
        });
        let (state, widen) = fallback::rung(&fallback, gaze_age, head_age, blink);
        if state != self.state {
            sink(Event::State {
                from: self.state,
                to: state,
                at: time,
            });
            self.state = state;
        }
        let head = self.head.at(time);
        let group_delay = self.filter.map_or(0.0, |filter| filter.group_delay());
        let (movement, gaze) = self.gaze_at(time, group_delay);
        let forward = if state >= State::HeadDirection {
            forward(&head)
        } else {
            gaze
        };
        if let Some(sight) = sight(&head, forward) {
            self.sight = sight;
        }
        Estimate {
            for_time: time,
            line_of_sight: self.sight,
            head,
            state,
            widen,
            blink: self.heard.lost.is_some(),
            movement: if state >= State::HeadDirection {
                Movement::Unknown
            } else {
                movement
            },
            landing: self.eyes.landing().filter(|_| state < State::HeadDirection),
            gaze_time,
            head_time,
            gaze_age: gaze_time.map(|at| time.since(at)),
            group_delay,
        }
    }

    /// Returns what the eyes do and where they look, in the room.
    fn gaze_at(&self, time: Micros, group_delay: f32) -> (Movement, Vec3) {
        let Some((newest, measured)) = self.eyes.newest() else {
            return (Movement::Unknown, Vec3::NEG_Z);
        };
        if self.eyes.in_saccade() {
            let course = self.config.prediction.and(self.eyes.flight_at(time));
            return (Movement::Saccade, course.unwrap_or(measured));
        }
        let velocity = self.eyes.followed();
        if velocity == Vec3::ZERO {
            return (Movement::Fixation, self.smooth);
        }
        let Some(prediction) = self.config.prediction else {
            return (Movement::Pursuit, self.smooth);
        };
        let ahead = seconds(newest, time) + group_delay;
        let ahead = ahead.clamp(0.0, prediction.horizon.seconds());
        (Movement::Pursuit, along(self.smooth, velocity * ahead))
    }
}

/// Returns the line of sight from a head along a direction, both in the room.
fn sight(head: &HeadPose, forward: Vec3) -> Option<LineOfSight> {
    let up = rotate(head.orientation, Vec3::Y);
    let back = rotate(head.orientation, Vec3::Z);
    // Straight up or down, the back of the head is where the top was.
    LineOfSight::new(head.position, forward, up)
        .or_else(|_| LineOfSight::new(head.position, forward, back))
        .ok()
}

#[cfg(test)]
mod tests;
