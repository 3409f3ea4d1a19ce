//! What the eye does, from where it has looked: fixation, pursuit or saccade,
//! and where it will look a little later.
//!
//! A saccade is recognised by its speed (I-VT, Salvucci and Goldberg 2000), the
//! slope over a window, since the difference of two samples is mostly noise
//! at high rates. From its first samples on, a minimum-jerk course is fitted
//! to it whose duration belongs to its amplitude by the main sequence; the
//! amplitude has a prior, that of natural saccades, so that a few samples
//! make no wild guess. The course says where the eye will be, and where it
//! will land.

use super::trend::{History, seconds, slope, steady_velocity};
use crate::rotation::{across, along, angle, arc};
use crate::time::Micros;
use glam::Vec3;
use shisen_core::numeric::{normalize, sqrt};

/// How saccades are recognised. Speeds are radians per second.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SaccadeConfig {
    /// Least speed at which a saccade starts; 0.05 to 20.
    pub start_speed: f32,
    /// Speed at which a saccade ends; at most `start_speed`.
    pub end_speed: f32,
    /// Window of the speed estimate: 1 to 100 ms. If it has fewer than two
    /// samples, the newest two are used.
    pub window: Micros,
    /// Least duration of a saccade, up to 100 ms: a shorter movement is noise.
    pub least_duration: Micros,
    /// Most duration of a saccade: 20 to 500 ms.
    pub most_duration: Micros,
    /// Least amplitude that is predicted and reported, radians; 0 to 0.2.
    pub least_amplitude: f32,
    /// Longest gap between samples over which a speed is measured: 5 to 500 ms.
    pub most_gap: Micros,
    /// Duration of the smallest saccade, seconds; 0.005 to 0.1.
    pub base_duration: f32,
    /// Duration that each radian of amplitude adds, seconds per radian; 0 to 1.
    pub duration_per_amplitude: f32,
}

impl Default for SaccadeConfig {
    /// 30°/s (20°/s at the end), a window of 20 ms, least amplitude 0.5°, and
    /// Carpenter's main sequence, 21 ms + 2.2 ms per degree.
    fn default() -> Self {
        Self {
            start_speed: core::f32::consts::FRAC_PI_6,
            end_speed: 0.349_1,
            window: Micros(20_000),
            least_duration: Micros(12_000),
            most_duration: Micros(200_000),
            least_amplitude: 0.008_727,
            most_gap: Micros(75_000),
            base_duration: 0.021,
            duration_per_amplitude: 0.126_05,
        }
    }
}

/// The movement of an eye.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Movement {
    /// Too few samples to tell.
    #[default]
    Unknown,
    /// The eye rests.
    Fixation,
    /// The eye follows something.
    Pursuit,
    /// The eye jumps.
    Saccade,
}

/// Where and when a saccade will end, or has ended.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Landing {
    /// Line of sight at the end: a unit vector.
    pub direction: Vec3,
    /// Time of the end, by the caller's clock.
    pub time: Micros,
    /// Angle from the start of the saccade to its end, radians.
    pub amplitude: f32,
}

/// A change of the eye's movement that a new sample shows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Change {
    Started,
    Ended(Saccade),
}

/// A saccade that is over.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Saccade {
    /// Amplitude, radians.
    pub amplitude: f32,
    /// Duration, seconds.
    pub duration: f32,
    /// Peak speed of the fitted course, radians per second.
    pub peak_speed: f32,
}

/// A saccade that is under way.
#[derive(Debug, Clone, Copy)]
struct Flight {
    /// When a sample first had its speed.
    detected: Micros,
    /// Line of sight at its start.
    base: Vec3,
    /// Direction of the movement: a unit tangent at `base`.
    axis: Vec3,
    course: Course,
    /// Velocity of the pursuit before it, which is no part of the saccade: radians per second, in
    /// the room.
    followed: Vec3,
    /// Whether it is larger than noise and was reported.
    told: bool,
}

/// The newest samples of an eye and the movement that they show.
#[derive(Debug, Clone)]
pub(super) struct EyeTrack<const N: usize> {
    config: SaccadeConfig,
    pursuit: PursuitConfig,
    samples: History<Vec3, N>,
    flight: Option<Flight>,
    /// When the eye began to rest or to follow; older samples belong to a saccade.
    steady_since: Micros,
    /// Velocity of pursuit at the last sample, radians per second.
    followed: Vec3,
}

/// Fewest samples that tell a velocity from noise.
const LEAST_FOLLOWED: usize = 5;

/// Share of a velocity that is ignored for each second between samples: the farther apart they
/// are, the later the end of a pursuit shows.
const DOUBT: f32 = 30.0;
/// Least share of a velocity that is used.
const LEAST_RELIANCE: f32 = 0.5;

/// How pursuit is recognised.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PursuitConfig {
    /// Window of the velocity estimate: 20 to 500 ms. A longer one is steadier
    /// and notices later that the target has turned.
    pub window: Micros,
    /// Least speed of a pursuit, radians per second; 0.001 to 1. Slower is fixation.
    pub least_speed: f32,
}

impl Default for PursuitConfig {
    /// Returns a window of 100 ms, and a least speed of 2°/s.
    fn default() -> Self {
        Self {
            window: Micros(100_000),
            least_speed: 0.034_91,
        }
    }
}

impl<const N: usize> EyeTrack<N> {
    // Inlined: builds the state in its place, without a copy on the stack.
    #[inline(always)]
    pub(super) fn new(config: SaccadeConfig, pursuit: PursuitConfig) -> Self {
        Self {
            config,
            pursuit,
            samples: History::new(),
            flight: None,
            steady_since: Micros(0),
            followed: Vec3::ZERO,
        }
    }

    /// Returns the newest sample.
    pub(super) fn newest(&self) -> Option<(Micros, Vec3)> {
        self.samples.newest()
    }

    /// Returns the time of the newest sample before `time`.
    pub(super) fn before(&self, time: Micros) -> Option<Micros> {
        let mut samples = self.samples.newest_first();
        samples.find_map(|(at, _)| (at < time).then_some(at))
    }

    pub(super) fn in_saccade(&self) -> bool {
        self.flight.is_some_and(|flight| flight.told)
    }

    /// Takes the line of sight, a unit vector, at `time`, which is not before the last sample's. A
    /// sample of the same time replaces the last one.
    pub(super) fn push(&mut self, time: Micros, direction: Vec3) -> Option<Change> {
        if let Some((last, _)) = self.samples.newest()
            && time.since(last) > self.config.most_gap
        {
            self.clear();
            self.steady_since = time;
        }
        self.samples.push(time, direction);
        let followed = self.flight.map_or(self.followed, |flight| flight.followed);
        let speed = self.speed(time, direction, followed);
        match self.flight {
            None => {
                if speed >= self.config.start_speed {
                    self.start(time);
                    return self.advance(time, direction);
                }
                self.followed = self.steady();
                None
            }
            Some(flight) => {
                let lasted = time.since(flight.detected);
                let landed = self.landing_of(&flight).map(|landing| landing.time);
                let overdue = landed.is_some_and(|landed| time.since(landed) > self.config.window);
                if (speed < self.config.end_speed || overdue)
                    && lasted >= self.config.least_duration
                    || lasted > self.config.most_duration
                {
                    return self.end(time, flight);
                }
                self.advance(time, direction)
            }
        }
    }

    /// Returns the speed of the newest samples, less the pursuit's velocity `followed`.
    fn speed(&self, time: Micros, direction: Vec3, followed: Vec3) -> f32 {
        let window = self.config.window;
        let newest_first = self.samples.newest_first().enumerate();
        let counted = newest_first.take_while(|(i, (t, _))| *i < 2 || time.since(*t) <= window);
        let places = self.samples.places(counted.count(), Vec3::ZERO);
        let velocity = across(slope(&places).unwrap_or_default() - followed, direction);
        sqrt(velocity.dot(velocity))
    }

    fn start(&mut self, time: Micros) {
        // Samples before the window are from before the saccade.
        let before = |t: Micros, least: u64, most: u64| {
            let age = time.since(t).0;
            t >= self.steady_since && age >= least && age <= most
        };
        let window = self.config.window.0;
        let mean = |least, most| {
            let places = self.samples.newest_first();
            let sum = places
                .filter(|(t, _)| before(*t, least, most))
                .fold(Vec3::ZERO, |sum, (_, d)| sum + d);
            normalize(sum)
        };
        let oldest = self
            .samples
            .newest_first()
            .take_while(|(t, _)| time.since(*t).0 <= window)
            .last();
        let earlier = self
            .samples
            .newest_first()
            .find(|(t, _)| time.since(*t).0 > window);
        let base = mean(window, window + 30_000)
            .or(earlier.map(|(_, d)| d))
            .or(oldest.map(|(_, d)| d));
        if let Some(base) = base {
            self.flight = Some(Flight {
                detected: time,
                base,
                axis: Vec3::ZERO,
                course: Course::new(self.interval()),
                followed: self.followed,
                told: false,
            });
        }
    }

    /// Fits the course again with the newest sample.
    fn advance(&mut self, time: Micros, direction: Vec3) -> Option<Change> {
        let config = self.config;
        let flight = self.flight.as_mut()?;
        let detected = flight.detected;
        let from = Micros(detected.0.saturating_sub(config.window.0));
        let (base, places) = (flight.base, self.samples.newest_first());
        let places = places
            .take_while(move |(t, _)| *t >= from)
            .map(move |(t, d)| (seconds(detected, t), arc(base, d)));
        // A sample farther from the start says more about the direction.
        let way = places
            .clone()
            .fold(Vec3::ZERO, |sum, (_, p)| sum + p * sqrt(p.dot(p)));
        flight.axis = normalize(way)?;
        let axis = flight.axis;
        let progress = places.map(move |(t, p)| (t, p.dot(axis)));
        flight.course = flight.course.fit(&config, &progress);
        let elapsed = seconds(detected, time) + config.window.seconds() + 0.015;
        if !flight.told
            && angle(base, direction) >= config.least_amplitude.max(config.start_speed * elapsed)
        {
            flight.told = true;
            return Some(Change::Started);
        }
        None
    }

    fn end(&mut self, time: Micros, flight: Flight) -> Option<Change> {
        let landed = self.landing_of(&flight).map_or(time, |l| l.time);
        self.flight = None;
        let told = flight.told;
        if told {
            self.steady_since = landed.min(time);
        }
        told.then(|| {
            let (amplitude, duration) = flight.course.amplitude_and_duration(&self.config);
            Change::Ended(Saccade {
                amplitude,
                duration,
                peak_speed: 1.875 * amplitude / duration,
            })
        })
    }

    fn landing_of(&self, flight: &Flight) -> Option<Landing> {
        let (amplitude, duration) = flight.course.amplitude_and_duration(&self.config);
        let after = flight.course.onset + duration;
        let micros = (after.abs() * 1.0e6) as u64;
        let time = if after >= 0.0 {
            flight.detected.after(Micros(micros))
        } else {
            Micros(flight.detected.0.saturating_sub(micros))
        };
        let direction = along(flight.base, flight.axis * amplitude);
        direction.is_finite().then_some(Landing {
            direction,
            time,
            amplitude,
        })
    }

    /// Returns where the saccade under way will end.
    pub(super) fn landing(&self) -> Option<Landing> {
        self.flight
            .filter(|flight| flight.told)
            .and_then(|flight| self.landing_of(&flight))
    }

    /// Returns where the saccade under way is at a time.
    pub(super) fn flight_at(&self, time: Micros) -> Option<Vec3> {
        let flight = self.flight.filter(|flight| flight.told)?;
        let progress = flight
            .course
            .progress(&self.config, seconds(flight.detected, time));
        Some(along(flight.base, flight.axis * progress))
    }

    /// Returns the velocity of pursuit: a tangent, radians per second; zero without a pursuit.
    pub(super) fn followed(&self) -> Vec3 {
        self.followed
    }

    fn steady(&self) -> Vec3 {
        let Some((newest, direction)) = self.samples.newest() else {
            return Vec3::ZERO;
        };
        let (since, window) = (self.steady_since, self.pursuit.window);
        let newest_first = self.samples.newest_first().enumerate();
        let counted = newest_first.take_while(|(i, (t, _))| {
            *t >= since && (*i < LEAST_FOLLOWED || newest.since(*t) <= window)
        });
        let (mut count, mut oldest) = (0, newest);
        for (i, (t, _)) in counted {
            (count, oldest) = (i + 1, t);
        }
        // Less than half of a window is too short to tell a pursuit.
        if 2.0 * newest.since(oldest).seconds() < window.seconds() || count < LEAST_FOLLOWED {
            return Vec3::ZERO;
        }
        let places = self.samples.places(count, Vec3::ZERO);
        let velocity = across(
            steady_velocity(&places, self.pursuit.least_speed),
            direction,
        );
        velocity * (1.0 - DOUBT * self.interval()).max(LEAST_RELIANCE)
    }

    /// Returns the mean interval of the newest five samples, seconds.
    fn interval(&self) -> f32 {
        let mut newest = self.samples.newest_first().take(5);
        let first = newest.next().map(|(t, _)| t);
        let last = newest.enumerate().last();
        first.zip(last).map_or(0.0, |(first, (count, (last, _)))| {
            first.since(last).seconds() / (count + 1) as f32
        })
    }

    /// Returns the mean of the samples since the last saccade.
    pub(super) fn mean_since_saccade(&self) -> Option<Vec3> {
        let since = self.steady_since;
        let steady = self.samples.newest_first().take_while(|(t, _)| *t >= since);
        normalize(steady.fold(Vec3::ZERO, |sum, (_, d)| sum + d))
    }

    /// Forgets all samples and the movement that they show.
    pub(super) fn clear(&mut self) {
        self.samples.clear();
        self.flight = None;
        self.followed = Vec3::ZERO;
    }
}

/// A minimum-jerk course: its duration follows from its amplitude by the main sequence, times a
/// fitted stretch.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Course {
    /// The logarithm of the amplitude in radians.
    log_amplitude: f32,
    /// Start of the movement, seconds after the detection.
    onset: f32,
    /// Logarithm of the duration's ratio to the main sequence's.
    stretch: f32,
    /// Seconds between samples.
    interval: f32,
    fitted: bool,
}

/// Mean and standard deviation of a course's parameters before any sample is
/// fitted: the amplitude's logarithm (4°, two thirds of them between 1.6°
/// and 10°), the onset, and the duration's logarithm.
type Prior = [(f32, f32); 3];

/// Standard deviation of a sample from the course: 0.15°, in radians.
const COURSE_ERROR: f32 = 0.0026;

impl Course {
    /// Returns the expected course of a saccade just found in samples at an `interval`.
    fn new(interval: f32) -> Self {
        let [amplitude, onset, stretch] = Self::prior(interval);
        Self {
            log_amplitude: amplitude.0,
            onset: onset.0,
            stretch: stretch.0,
            interval,
            fitted: false,
        }
    }

    /// Returns the prior: a saccade is found some 8 ms and half an interval after its onset.
    fn prior(interval: f32) -> Prior {
        let spread = sqrt(3.6e-5 + interval * interval / 12.0);
        let onset = -0.008 - 0.5 * interval;
        [(-2.66, 0.9), (onset, spread), (0.0, 0.1)]
    }

    fn amplitude_and_duration(&self, config: &SaccadeConfig) -> (f32, f32) {
        let amplitude = libm::expf(self.log_amplitude);
        let plain = config.base_duration + config.duration_per_amplitude * amplitude;
        (amplitude, plain * libm::expf(self.stretch))
    }

    /// Returns the angle covered at a time after the detection, radians.
    fn progress(&self, config: &SaccadeConfig, time: f32) -> f32 {
        let (amplitude, duration) = self.amplitude_and_duration(config);
        let (part, _) = minimum_jerk((time - self.onset) / duration);
        amplitude * part
    }

    /// Returns the most probable course, by the Gauss-Newton method from this one.
    fn fit(
        self,
        config: &SaccadeConfig,
        progress: &(impl Iterator<Item = (f32, f32)> + Clone),
    ) -> Self {
        let mut course = self;
        for _ in 0..if self.fitted { 3 } else { 8 } {
            let parameters = [course.log_amplitude, course.onset, course.stretch];
            let mut normal = [[0.0f32; 3]; 3];
            let mut right = [0.0f32; 3];
            for (i, (mean, deviation)) in Self::prior(self.interval).into_iter().enumerate() {
                let weight = 1.0 / (deviation * deviation);
                normal[i][i] = weight;
                right[i] = weight * (mean - parameters[i]);
            }
            let (amplitude, duration) = course.amplitude_and_duration(config);
            let lengthens =
                config.duration_per_amplitude * amplitude * libm::expf(course.stretch) / duration;
            let weight = 1.0 / (COURSE_ERROR * COURSE_ERROR);
            for (time, measured) in progress.clone() {
                let u = (time - course.onset) / duration;
                let (part, speed) = minimum_jerk(u);
                let slope = [
                    amplitude * (part - speed * u * lengthens),
                    -amplitude * speed / duration,
                    -amplitude * speed * u,
                ];
                let off = measured - amplitude * part;
                for i in 0..3 {
                    right[i] += weight * slope[i] * off;
                    for j in 0..3 {
                        normal[i][j] += weight * slope[i] * slope[j];
                    }
                }
            }
            let Some([a, o, s]) = solve(normal, right) else {
                return self;
            };
            // Steps that the linear picture still holds for.
            course.log_amplitude = (course.log_amplitude + a.clamp(-0.5, 0.5)).clamp(-6.0, 0.0);
            course.onset = (course.onset + o.clamp(-0.006, 0.006)).clamp(-0.2, 0.1);
            course.stretch = (course.stretch + s.clamp(-0.1, 0.1)).clamp(-0.5, 0.5);
        }
        course.fitted = true;
        course
    }
}

/// Returns the part of a minimum-jerk movement that is done at a part u of its time,
/// and its derivative (Flash and Hogan, "The coordination of arm movements",
/// 1985).
pub(crate) fn minimum_jerk(u: f32) -> (f32, f32) {
    let u = u.clamp(0.0, 1.0);
    let rest = u * (1.0 - u);
    (
        u * u * u * (10.0 - 15.0 * u + 6.0 * u * u),
        30.0 * rest * rest,
    )
}

/// Solves a symmetric positive definite system by Cholesky's method.
fn solve(normal: [[f32; 3]; 3], right: [f32; 3]) -> Option<[f32; 3]> {
    let mut l = [[0.0f32; 3]; 3];
    for i in 0..3 {
        for j in 0..=i {
            let mut sum = normal[i][j];
            for k in 0..j {
                sum -= l[i][k] * l[j][k];
            }
            if i == j {
                if !(sum > 0.0) {
                    return None;
                }
                l[i][i] = sqrt(sum);
            } else {
                l[i][j] = sum / l[j][j];
            }
        }
    }
    let mut x = right;
    for i in 0..3 {
        for k in 0..i {
            x[i] -= l[i][k] * x[k];
        }
        x[i] /= l[i][i];
    }
    for i in (0..3).rev() {
        for k in i + 1..3 {
            x[i] -= l[k][i] * x[k];
        }
        x[i] /= l[i][i];
    }
    x.iter().all(|x| x.is_finite()).then_some(x)
}
