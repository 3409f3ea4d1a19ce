//! Simulates how a viewer's head and eyes move.

use super::noise::pink;
use super::random::{Random, hash};
use crate::estimate::minimum_jerk;
use crate::rotation::{along, angle, arc, compose, from_vector, rotate};
use crate::time::Micros;
use crate::valid;
use core::f32::consts::TAU;
use glam::{Quat, Vec3};
use shisen_core::gaze::HeadPose;
use shisen_core::numeric::{basis_around, max, min, normalize, sin_cos, sqrt};

/// Settings of a viewer's movement. Angles are radians, in the room. A number out
/// of range is moved to the nearest one in it, NaN to the least.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ViewerConfig {
    /// The head's mean pose; a pose that is invalid or beyond 10⁶ m becomes the identity.
    pub resting_head: HeadPose,
    /// Largest distance of the head from its mean place, metres; 0 to 10.
    pub head_sway: f32,
    /// Largest turn of the head; 0 to 1.
    pub head_turn: f32,
    /// Largest angle of the gaze from the resting head's direction; 0.01 to 1.5.
    pub field: f32,
    /// Median duration of fixations, seconds; 0.06 to 3.
    pub fixation: f32,
    /// Standard deviation of the duration's logarithm; 0 to 2.
    pub fixation_deviation: f32,
    /// The mean amplitude of saccades; 0.001 to 1.5.
    pub amplitude: f32,
    /// The main sequence's intercept, seconds (Carpenter 1988: 21 ms); 0.005 to 0.1.
    pub base_duration: f32,
    /// The main sequence's slope, seconds per radian (2.2 ms a degree); 0 to 1.
    pub duration_per_amplitude: f32,
    /// The standard deviation of the logarithm of a saccade's duration; 0 to 2.
    pub duration_deviation: f32,
    /// Share of fixations that a pursuit follows; 0 to 1.
    pub pursuit: f32,
    /// The fastest pursuit, radians per second; 0 to 10.
    pub pursuit_speed: f32,
    /// Microsaccades per second of fixation; 0 to 20.
    pub microsaccades: f32,
    /// Blinks per minute; 0 to 600.
    pub blinks: f32,
    /// Median duration of blinks, seconds; 0.02 to 2.
    pub blink: f32,
    /// Standard deviation of the duration's logarithm; 0 to 2.
    pub blink_deviation: f32,
    /// RMS jitter of a fixation along each of two axes; 0 to 0.1.
    pub jitter: f32,
}

impl ViewerConfig {
    fn in_range(mut self) -> Self {
        let HeadPose {
            position,
            orientation,
        } = self.resting_head;
        if valid::place(position, 1.0e6).is_err()
            || valid::rotation(orientation, valid::UNIT_TOLERANCE).is_err()
        {
            self.resting_head = HeadPose::IDENTITY;
        }
        for (number, least, most) in [
            (&mut self.head_sway, 0.0, 10.0),
            (&mut self.head_turn, 0.0, 1.0),
            (&mut self.field, 0.01, 1.5),
            (&mut self.fixation, 0.06, 3.0),
            (&mut self.fixation_deviation, 0.0, 2.0),
            (&mut self.amplitude, 0.001, 1.5),
            (&mut self.base_duration, 0.005, 0.1),
            (&mut self.duration_per_amplitude, 0.0, 1.0),
            (&mut self.duration_deviation, 0.0, 2.0),
            (&mut self.pursuit, 0.0, 1.0),
            (&mut self.pursuit_speed, 0.0, 10.0),
            (&mut self.microsaccades, 0.0, 20.0),
            (&mut self.blinks, 0.0, 600.0),
            (&mut self.blink, 0.02, 2.0),
            (&mut self.blink_deviation, 0.0, 2.0),
            (&mut self.jitter, 0.0, 0.1),
        ] {
            *number = min(max(*number, least), most);
        }
        self
    }
}

impl Default for ViewerConfig {
    /// Fixations of 250 ms, saccades of 6° on average within 25°, one in six
    /// fixations followed by pursuit at up to 25°/s, 1.5 microsaccades a
    /// second, 15 blinks a minute of 170 ms (mostly 100 to 300), jitter of 0.05°.
    fn default() -> Self {
        Self {
            resting_head: HeadPose::IDENTITY,
            head_sway: 0.02,
            head_turn: 0.1,
            field: 0.436_33,
            fixation: 0.25,
            fixation_deviation: 0.35,
            amplitude: 0.104_72,
            base_duration: 0.021,
            duration_per_amplitude: 0.126_05,
            duration_deviation: 0.06,
            pursuit: 1.0 / 6.0,
            pursuit_speed: 0.436_33,
            microsaccades: 1.5,
            blinks: 15.0,
            blink: 0.17,
            blink_deviation: 0.3,
            jitter: 0.000_872_7,
        }
    }
}

/// A direction to look in from a time on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ScriptedTarget {
    /// When the saccade to it starts; targets are in ascending order.
    pub at: Micros,
    /// Direction in the room, of any length but zero.
    pub direction: Vec3,
}

/// The true movement of the eyes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Kind {
    /// The eyes rest.
    Fixation,
    /// The eyes jump.
    Saccade,
    /// The eyes jump within a fixation.
    Microsaccade,
    /// The eyes follow something.
    Pursuit,
}

/// The viewer's true state at a time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Truth {
    /// Pose of the head in the room.
    pub head: HeadPose,
    /// Line of sight: a unit vector in the room.
    pub direction: Vec3,
    /// The eyes' movement.
    pub kind: Kind,
    /// When that movement began.
    pub start: Micros,
    /// When that movement will end.
    pub end: Micros,
    /// Angle of the whole movement, radians.
    pub amplitude: f32,
    /// Openness of the eyes, from 0, shut, to 1, open.
    pub openness: f32,
}

/// A part of the eyes' movement.
#[derive(Debug, Clone, Copy)]
struct Segment {
    kind: Kind,
    start: u64,
    end: u64,
    from: Vec3,
    /// The movement: a tangent at `from`, as long as its angle.
    way: Vec3,
}

/// Number of parts of the movement that are kept: some seconds of them.
const SEGMENTS: usize = 48;

/// Seconds that a pursuit takes to reach its speed.
const PURSUIT_START: f32 = 0.08;

impl Segment {
    fn direction(&self, time: u64) -> Vec3 {
        let duration = self.end.saturating_sub(self.start).max(1) as f32;
        let u = time.saturating_sub(self.start) as f32 / duration;
        let part = match self.kind {
            Kind::Fixation => return self.from,
            Kind::Saccade | Kind::Microsaccade => minimum_jerk(u).0,
            Kind::Pursuit => {
                // Constant acceleration, then constant speed.
                let start = (PURSUIT_START * 1.0e6 / duration).min(1.0);
                let whole = 1.0 - 0.5 * start;
                let way = if u < start {
                    0.5 * u * u / start
                } else {
                    u - 0.5 * start
                };
                way / whole
            }
        };
        along(self.from, self.way * part)
    }
}

/// Number of episodes of an [`Episodes`] that are kept; the last is the newest.
const KEPT: usize = 8;

/// Random episodes, such as blinks: the newest of them.
#[derive(Debug, Clone)]
pub(super) struct Episodes {
    random: Random,
    /// Mean time from an episode's end to the next one's start, microseconds; 0: no episodes.
    pause: f32,
    median: f32,
    deviation: f32,
    kept: [(u64, u64); KEPT],
}

impl Episodes {
    /// `rate` is per minute, `median` seconds.
    pub(super) fn new(random: Random, rate: f32, median: f32, deviation: f32) -> Self {
        Self {
            random,
            pause: if rate > 0.0 { 60.0e6 / rate } else { 0.0 },
            median,
            deviation,
            kept: [(0, 0); KEPT],
        }
    }

    /// Returns the start and end of the episode at a time, if there is one.
    pub(super) fn at(&mut self, time: u64) -> Option<(u64, u64)> {
        if self.pause <= 0.0 {
            return None;
        }
        while self.kept[KEPT - 1].1 <= time {
            let last = self.kept[KEPT - 1].1;
            let pause = (self.random.exponential() * self.pause) as u64;
            let seconds = self.random.log_normal(self.median, self.deviation);
            let lasts = (seconds.clamp(0.01, 10.0) * 1.0e6) as u64;
            let start = last.saturating_add(pause.max(10_000));
            self.kept.rotate_left(1);
            self.kept[KEPT - 1] = (start, start.saturating_add(lasts));
        }
        let mut kept = self.kept.iter().copied();
        kept.find(|&(start, end)| (start..end).contains(&time))
    }
}

/// A viewer whose movements follow from a seed and are computed as time goes on.
///
/// A call computes all movement up to its time: one call for an hour ahead takes as
/// long as many calls on the way there.
#[derive(Debug, Clone)]
pub struct Viewer<'a> {
    config: ViewerConfig,
    seed: u64,
    random: Random,
    script: &'a [ScriptedTarget],
    /// Parts of the movement in ascending order; the last one ends last.
    segments: [Segment; SEGMENTS],
    /// When the fixation under way ends.
    fixation_end: u64,
    /// Centre of the fixation, to which microsaccades lead back.
    home: Vec3,
    blinks: Episodes,
}

impl<'a> Viewer<'a> {
    /// Returns a viewer who looks around.
    pub fn new(config: ViewerConfig, seed: u64) -> Self {
        Self::with_script(config, seed, &[])
    }

    /// Returns a viewer who looks at one target after another, and around without targets.
    pub fn with_script(config: ViewerConfig, seed: u64, script: &'a [ScriptedTarget]) -> Self {
        let config = config.in_range();
        let forward = rotate(config.resting_head.orientation, Vec3::NEG_Z);
        let start = Segment {
            kind: Kind::Fixation,
            start: 0,
            end: 0,
            from: forward,
            way: Vec3::ZERO,
        };
        let mut viewer = Self {
            config,
            seed,
            random: Random::new(seed, 1),
            script,
            segments: [start; SEGMENTS],
            fixation_end: 0,
            home: forward,
            blinks: Episodes::new(
                Random::new(seed, 2),
                config.blinks,
                config.blink,
                config.blink_deviation,
            ),
        };
        viewer.fixation_end = viewer.fixation();
        viewer
    }

    /// Returns the true state at `time`; `None` if that is too long before the latest call's time.
    pub fn truth(&mut self, time: Micros) -> Option<Truth> {
        // Each part lasts 10 ms at least.
        while self.last().end <= time.0 {
            self.go_on();
        }
        let segment = *self
            .segments
            .iter()
            .find(|s| s.start <= time.0 && time.0 < s.end)?;
        let direction = segment.direction(time.0);
        let (x, y) = basis_around(direction);
        let jitter = self.config.jitter;
        let tremble =
            x * (jitter * pink(self.seed, 0, time.0)) + y * (jitter * pink(self.seed, 1, time.0));
        let way = segment.way;
        Some(Truth {
            head: self.head(time),
            direction: along(direction, tremble),
            kind: segment.kind,
            start: Micros(segment.start),
            end: Micros(segment.end),
            amplitude: sqrt(way.dot(way)),
            openness: self.openness(time),
        })
    }

    fn last(&self) -> Segment {
        self.segments[SEGMENTS - 1]
    }

    fn openness(&mut self, time: Micros) -> f32 {
        let Some((start, end)) = self.blinks.at(time.0) else {
            return 1.0;
        };
        // A third of a blink goes down, a fifth is shut, the rest goes up.
        let u = (time.0 - start) as f32 / (end - start) as f32;
        let open = if u < 0.33 {
            1.0 - minimum_jerk(u / 0.33).0
        } else {
            minimum_jerk((u - 0.53) / 0.47).0
        };
        open.clamp(0.0, 1.0)
    }

    /// Returns slow sums of sines, whose periods have no common multiple.
    fn head(&self, time: Micros) -> HeadPose {
        let wave = |lane: u32| {
            let mut sum = 0.0;
            for (i, period) in [7_300_000u64, 3_170_000, 1_410_000].into_iter().enumerate() {
                let phase = hash(self.seed, 100 + lane, i as u64) as f32 / 4_294_967_296.0;
                let part = (time.0 % period) as f32 / period as f32;
                let (sin, _) = sin_cos(TAU * (phase + part));
                sum += sin / (1 << i) as f32;
            }
            sum / 1.75
        };
        let HeadPose {
            position,
            orientation,
        } = self.config.resting_head;
        let turn = Vec3::new(0.6 * wave(0), wave(1), 0.3 * wave(2)) * self.config.head_turn;
        let sway = Vec3::new(wave(3), 0.4 * wave(4), 0.7 * wave(5)) * self.config.head_sway;
        let turned: Quat = compose(orientation, from_vector(turn));
        HeadPose {
            position: position + sway,
            orientation: turned,
        }
    }

    /// Returns when a fixation that starts now ends.
    fn fixation(&mut self) -> u64 {
        let config = self.config;
        let lasts = self
            .random
            .log_normal(config.fixation, config.fixation_deviation);
        self.last().end + (lasts.clamp(0.06, 3.0) * 1.0e6) as u64
    }

    fn push(&mut self, kind: Kind, way: Vec3, end: u64) {
        let last = self.last();
        let (start, from) = (last.end, last.direction(last.end));
        self.segments.rotate_left(1);
        self.segments[SEGMENTS - 1] = Segment {
            kind,
            start,
            end: end.max(start + 10_000),
            from,
            way,
        };
    }

    /// Returns the next part of the movement.
    fn go_on(&mut self) {
        let last = self.last();
        let now = last.end;
        if last.kind == Kind::Saccade || last.kind == Kind::Pursuit {
            self.home = last.direction(now);
            self.fixation_end = self.fixation();
        }
        if last.kind != Kind::Fixation {
            return self.rest();
        }
        let scripted = self.script.iter().rfind(|target| target.at.0 <= now);
        let current = scripted.and_then(|target| normalize(target.direction));
        if let Some(direction) = current {
            let way = arc(self.home, direction);
            if way.dot(way) > 1.0e-8 {
                return self.jump(Kind::Saccade, way);
            }
        }
        if now < self.rest_until(now) {
            // The fixation ended early for this movement.
            return self.microsaccade();
        }
        if self.random.chance(self.config.pursuit) {
            return self.pursue();
        }
        let way = self.way();
        self.jump(Kind::Saccade, way);
    }

    /// Returns when the eyes jump or pursue next, if they rest at `now`.
    fn rest_until(&self, now: u64) -> u64 {
        if self.script.is_empty() {
            return self.fixation_end;
        }
        let next = self.script.iter().find(|target| target.at.0 > now);
        next.map_or(u64::MAX, |next| next.at.0)
    }

    /// Returns a fixation until its next microsaccade or its end.
    fn rest(&mut self) {
        let now = self.last().end;
        let over = self.rest_until(now);
        let pause = self.random.exponential() / self.config.microsaccades.max(1.0e-3);
        // No microsaccade comes right after a saccade.
        let pause = now + 50_000 + (pause * 1.0e6) as u64;
        self.push(Kind::Fixation, Vec3::ZERO, over.min(pause));
    }

    fn microsaccade(&mut self) {
        let now = self.last();
        let here = now.direction(now.end);
        // Its amplitude is 0.1° to 1°, evenly distributed in the logarithm.
        let amplitude = 0.001_745 * libm::expf(core::f32::consts::LN_10 * self.random.uniform());
        let away = arc(here, self.home);
        // It leads back to the centre from farther than its amplitude, otherwise anywhere.
        let way = if sqrt(away.dot(away)) > amplitude {
            away
        } else {
            self.tangent(here) * amplitude
        };
        self.jump(Kind::Microsaccade, way);
    }

    fn tangent(&mut self, at: Vec3) -> Vec3 {
        let (sin, cos) = sin_cos(TAU * self.random.uniform());
        let (x, y) = basis_around(at);
        x * cos + y * sin
    }

    /// Returns a random direction in the field.
    fn way(&mut self) -> Vec3 {
        let last = self.last();
        let here = last.direction(last.end);
        let config = self.config;
        let centre = rotate(config.resting_head.orientation, Vec3::NEG_Z);
        let amplitude =
            (config.amplitude * (0.25 + 0.75 * self.random.exponential())).min(1.2 * config.field);
        let mut way = self.tangent(here) * amplitude;
        for _ in 0..8 {
            if angle(along(here, way), centre) <= config.field {
                return way;
            }
            way = self.tangent(here) * amplitude;
        }
        // Outside the field: towards its centre instead.
        let back = arc(here, centre);
        normalize(back).map_or(way, |back| back * amplitude)
    }

    fn jump(&mut self, kind: Kind, way: Vec3) {
        let amplitude = sqrt(way.dot(way));
        let config = self.config;
        let lasts = (config.base_duration + config.duration_per_amplitude * amplitude)
            * self.random.log_normal(1.0, config.duration_deviation);
        let end = self.last().end + (lasts * 1.0e6) as u64;
        self.push(kind, way, end);
    }

    fn pursue(&mut self) {
        let lasts = self.random.between(0.4, 1.5);
        let least = 0.2 * self.config.pursuit_speed;
        let speed = self.random.between(least, self.config.pursuit_speed);
        let length = (speed * (lasts - 0.5 * PURSUIT_START)).min(self.config.field);
        let lasts = length / speed.max(1.0e-3) + 0.5 * PURSUIT_START;
        let way = self.way();
        let way = normalize(way).unwrap_or(Vec3::X) * length;
        let end = self.last().end + (lasts * 1.0e6) as u64;
        self.push(Kind::Pursuit, way, end);
    }
}
