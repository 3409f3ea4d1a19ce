//! A tracker that measures a [`Viewer`].

use super::faults::Source;
use super::movement::{Episodes, Truth, Viewer};
use super::random::Random;
use crate::rotation::{along, compose, from_vector, inverse, rotate, unit};
use crate::sample::{Eye, Head, Pupil, Reading, Sample};
use crate::time::{DeviceTime, Micros};
use glam::Vec3;
use shisen_core::numeric::{basis_around, normalize};

/// The properties of a simulated tracker. Angles are radians.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrackerConfig {
    /// Samples per second: 60 to 10,000. Real trackers send 1,000 at most; more tests a flood.
    pub rate: u32,
    /// RMS white noise of the eyes' direction along each of two axes; 0 to 0.2.
    pub eye_noise: f32,
    /// RMS noise of the head's rotation about each axis; 0 to 0.2.
    pub turn_noise: f32,
    /// RMS noise of the head's position along each axis, metres; 0 to 0.1.
    pub place_noise: f32,
    /// Losses of the eyes per minute, blinks not counted; 0 to 600.
    pub losses: f32,
    /// Whether it measures the head.
    pub head: bool,
    /// Whether it measures the eyes.
    pub eyes: bool,
    /// Time from the measurement to the arrival; up to 1 s.
    pub latency: Micros,
    /// What the device's clock shows at time 0.
    pub clock_start: u64,
    /// Clock error of the device, parts per million; ±10,000.
    pub clock_drift: i32,
    /// Period after which the device's clock wraps, microseconds; 0: never.
    pub clock_wraps_at: u64,
}

impl Default for TrackerConfig {
    /// Head and eyes at 500 Hz; noise of 0.1° (eyes), 0.02° and 0.1 mm (head); six losses a
    /// minute; a latency of 8 ms.
    fn default() -> Self {
        Self {
            rate: 500,
            eye_noise: 0.001_745,
            turn_noise: 0.000_349,
            place_noise: 0.000_1,
            losses: 6.0,
            head: true,
            eyes: true,
            latency: Micros(8_000),
            clock_start: 0,
            clock_drift: 0,
            clock_wraps_at: 0,
        }
    }
}

/// A value of a [`TrackerConfig`] that is out of range.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[error("the mock's {field} is {found}: give {least} to {most}")]
pub struct TrackerConfigError {
    /// The value's name, and its unit where it has one.
    pub field: &'static str,
    /// The value; it may be NaN.
    pub found: f32,
    /// The least it can be.
    pub least: f32,
    /// The most it can be.
    pub most: f32,
}

/// Half of the distance between the eyes, metres.
const HALF_DISTANCE: f32 = 0.032;
/// How far open an eye has to be for the tracker to see its pupil.
pub(super) const LEAST_OPENNESS: f32 = 0.3;

/// A tracker that measures a viewer, sample after sample.
#[derive(Debug, Clone)]
pub struct Tracker<'a> {
    config: TrackerConfig,
    viewer: Viewer<'a>,
    noise: Random,
    losses: Episodes,
    count: u64,
}

impl<'a> Tracker<'a> {
    /// Returns a tracker in front of a viewer. `seed` is the noise's own.
    ///
    /// # Errors
    /// Values outside the ranges at [`TrackerConfig`].
    pub fn new(
        config: TrackerConfig,
        viewer: Viewer<'a>,
        seed: u64,
    ) -> Result<Self, TrackerConfigError> {
        for (field, found, least, most) in [
            ("rate (Hz)", config.rate as f32, 60.0, 10_000.0),
            ("eye noise (rad)", config.eye_noise, 0.0, 0.2),
            ("turn noise (rad)", config.turn_noise, 0.0, 0.2),
            ("place noise (m)", config.place_noise, 0.0, 0.1),
            ("losses per minute", config.losses, 0.0, 600.0),
            ("latency (s)", config.latency.seconds(), 0.0, 1.0),
            (
                "clock drift (ppm)",
                config.clock_drift as f32,
                -10_000.0,
                10_000.0,
            ),
        ] {
            if !(least..=most).contains(&found) {
                return Err(TrackerConfigError {
                    field,
                    found,
                    least,
                    most,
                });
            }
        }
        Ok(Self {
            config,
            viewer,
            noise: Random::new(seed, 11),
            losses: Episodes::new(Random::new(seed, 12), config.losses, 0.06, 0.6),
            count: 0,
        })
    }

    /// Returns the viewer, whose true gaze can be asked for.
    pub fn viewer(&mut self) -> &mut Viewer<'a> {
        &mut self.viewer
    }

    /// Returns when the next sample is measured.
    pub fn next_time(&self) -> Micros {
        Micros(self.count.saturating_mul(1_000_000) / u64::from(self.config.rate.max(1)))
    }

    /// Returns the next sample and the time at which it was measured.
    pub fn next_sample(&mut self) -> (Micros, Sample) {
        let time = self.next_time();
        let sequence = self.count as u32;
        self.count = self.count.saturating_add(1);
        let mut sample = Sample::arrived(time.after(self.config.latency));
        sample.sequence = Some(sequence);
        sample.device_time = Some(self.device_time(time));
        if let Some(truth) = self.viewer.truth(time) {
            self.measure(time, &truth, &mut sample);
        }
        (time, sample)
    }

    fn device_time(&self, time: Micros) -> DeviceTime {
        let drift = i128::from(time.0) * i128::from(self.config.clock_drift) / 1_000_000;
        let shown = i128::from(self.config.clock_start) + i128::from(time.0) + drift;
        let shown = shown.max(0) as u64;
        let wraps_at = self.config.clock_wraps_at;
        DeviceTime {
            microseconds: shown.checked_rem(wraps_at).unwrap_or(shown),
            wraps_at,
        }
    }

    fn measure(&mut self, time: Micros, truth: &Truth, sample: &mut Sample) {
        // All noise is drawn always, so that one setting does not change the
        // noise of another.
        let mut draw = |size: f32| {
            let noise = &mut self.noise;
            Vec3::new(noise.normal(), noise.normal(), noise.normal()) * size
        };
        let (turn, place) = (draw(self.config.turn_noise), draw(self.config.place_noise));
        let (left, right) = (draw(self.config.eye_noise), draw(self.config.eye_noise));
        if self.config.head {
            let orientation = compose(truth.head.orientation, from_vector(turn));
            sample.head = Head {
                position: Some(Reading::tracked(truth.head.position + place)),
                orientation: unit(orientation).map(Reading::tracked),
                angular_velocity: None,
            };
        }
        if !self.config.eyes {
            return;
        }
        let lost = self.losses.at(time.0).is_some() || truth.openness < LEAST_OPENNESS;
        let ahead = rotate(inverse(truth.head.orientation), truth.direction);
        let (x, y) = basis_around(normalize(ahead).unwrap_or(Vec3::NEG_Z));
        // Each eye gets √2 times the noise, so that their mean has `eye_noise`.
        let both = core::f32::consts::SQRT_2;
        let eye = |side: f32, noise: Vec3| {
            let seen = along(ahead, (x * noise.x + y * noise.y) * both);
            Eye {
                origin: Some(Reading::tracked(Vec3::X * (side * HALF_DISTANCE))),
                direction: (!lost).then(|| Reading::tracked(seen)),
                pupil: (!lost).then_some(Pupil::Diameter(0.004)),
                openness: Some(truth.openness),
            }
        };
        sample.left = eye(-1.0, left);
        sample.right = eye(1.0, right);
    }
}

impl Source for Tracker<'_> {
    type Item = Sample;

    fn poll(&mut self, until: Micros) -> Option<Sample> {
        let due = self.next_time().after(self.config.latency) <= until;
        due.then(|| self.next_sample().1)
    }
}
