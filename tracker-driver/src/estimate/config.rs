//! What a [`GazeEstimator`](super::GazeEstimator) is told beforehand.

use super::calibration::Calibration;
use super::fallback::FallbackConfig;
use super::head::HeadConfig;
use super::movement::{PursuitConfig, SaccadeConfig};
use super::one_euro::OneEuroConfig;
use crate::rotation;
use crate::time::Micros;
use core::fmt;
use glam::{Quat, Vec2, Vec3};
use shisen_core::gaze::HeadPose;

/// Where the tracker's axes are in the room: `room_from_tracker`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RoomFromTracker {
    /// The tracker's origin: metres, in the room.
    pub position: Vec3,
    /// Unit quaternion.
    pub orientation: Quat,
}

impl RoomFromTracker {
    /// The tracker's axes are the room's.
    pub const IDENTITY: Self = Self {
        position: Vec3::ZERO,
        orientation: Quat::IDENTITY,
    };
}

/// Which eye's line of sight is taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Eyes {
    /// The device's combined eye; where there is none, the mean of both
    /// directions, or the one eye that is seen.
    #[default]
    Combined,
    /// The left one alone.
    Left,
    /// The right one alone.
    Right,
    /// None: there is no eye tracker, and the head's direction counts.
    HeadOnly,
}

/// The plane on which a tracker's gaze points lie, in the room.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Screen {
    /// The upper left corner of the calibrated area: metres.
    pub corner: Vec3,
    /// Unit vector along its upper edge.
    pub right: Vec3,
    /// Unit vector along its left edge.
    pub down: Vec3,
    /// Width and height, metres; above 0.
    pub size: Vec2,
}

/// What the eyes' directions pass through.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Filter {
    /// Nothing.
    None,
    /// The One-Euro filter; saccades go past it.
    OneEuro(OneEuroConfig),
}

/// How the gaze is continued to the time of display.
///
/// What it is worth: the angle between the estimate and the truth, degrees,
/// median / 95th percentile, on the feature `mock`'s default viewer (seeds
/// of 60 s, ten at 60 Hz, five at 120 and three above, 0.1° of noise), 20 ms after the sample. Landing is the first
/// 20 ms after a saccade. Without a filter and prediction; with the default
/// filter alone; with both:
///
/// | Rate | Eyes in | Neither | Filter | Both |
/// |---|---|---|---|---|
/// | 60 Hz | fixation | 0.14 / 0.30 | 0.10 / 0.23 | 0.10 / 0.23 |
/// | | pursuit | 0.31 / 0.57 | 0.36 / 0.64 | 0.26 / 0.56 |
/// | | saccade | 2.22 / 8.24 | 2.23 / 8.27 | 2.06 / 7.10 |
/// | | landing | 0.80 / 3.39 | 0.82 / 3.43 | 0.53 / 2.32 |
/// | 120 Hz | fixation | 0.14 / 0.30 | 0.09 / 0.21 | 0.09 / 0.21 |
/// | | pursuit | 0.30 / 0.57 | 0.35 / 0.62 | 0.18 / 0.44 |
/// | | saccade | 2.23 / 8.29 | 2.22 / 8.44 | 1.90 / 6.67 |
/// | | landing | 0.84 / 3.47 | 0.85 / 3.52 | 0.28 / 2.33 |
/// | 250 Hz | fixation | 0.14 / 0.30 | 0.08 / 0.19 | 0.08 / 0.19 |
/// | | pursuit | 0.29 / 0.57 | 0.32 / 0.60 | 0.13 / 0.36 |
/// | | saccade | 2.19 / 8.07 | 2.20 / 8.21 | 1.80 / 6.53 |
/// | | landing | 0.80 / 3.44 | 0.82 / 3.48 | 0.26 / 2.39 |
/// | 500 Hz | fixation | 0.14 / 0.30 | 0.07 / 0.18 | 0.07 / 0.17 |
/// | | pursuit | 0.29 / 0.57 | 0.32 / 0.58 | 0.10 / 0.34 |
/// | | saccade | 2.19 / 8.03 | 2.20 / 8.15 | 1.78 / 6.44 |
/// | | landing | 0.80 / 3.42 | 0.82 / 3.46 | 0.24 / 2.40 |
/// | 1000 Hz | fixation | 0.14 / 0.30 | 0.06 / 0.17 | 0.06 / 0.16 |
/// | | pursuit | 0.29 / 0.57 | 0.32 / 0.58 | 0.09 / 0.33 |
/// | | saccade | 2.18 / 8.06 | 2.18 / 8.18 | 1.75 / 6.44 |
/// | | landing | 0.80 / 3.39 | 0.82 / 3.45 | 0.21 / 2.46 |
///
/// So it is nowhere worse than neither, nor than the filter alone; on seeds that its
/// constants were not chosen on, neither. At low rates that takes some of its
/// worth in pursuit: what starts and what stops is noticed later, and less of the
/// velocity is relied on. At 60 Hz, against neither, the median gains a sixth, and the
/// 95th percentile, which is that of eyes that have just begun to follow, 3 %; against
/// the filter alone a quarter and an eighth. The table
/// is printed and held, and what is gained asserted, by
/// `cargo test -p shisen-tracker prediction -- --nocapture`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GazePrediction {
    /// By how much at most, for pursuit: up to 200 ms.
    pub horizon: Micros,
    /// What pursuit is.
    pub pursuit: PursuitConfig,
}

impl Default for GazePrediction {
    /// 60 ms.
    fn default() -> Self {
        Self {
            horizon: Micros(60_000),
            pursuit: PursuitConfig::default(),
        }
    }
}

/// Which of a tracker's sensors are the viewer's, by
/// [`Sample::sensor`](crate::sample::Sample::sensor).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Sensors {
    /// All of them.
    #[default]
    All,
    /// The one of the first sample.
    First,
    /// This one.
    Only(u8),
}

/// What a gaze estimator is told beforehand. The ranges stand at the fields
/// and at their types; [`EstimatorConfig::check`] checks them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EstimatorConfig {
    /// Where the tracker is.
    pub room_from_tracker: RoomFromTracker,
    /// Where the head is as far as no tracker says.
    pub resting_head: HeadPose,
    /// Whether there is a head tracker. Without one the head is always at
    /// rest, and never stale.
    pub head_tracked: bool,
    /// Which of the tracker's sensors count: what a tracker with several
    /// stations says of the others is no word of the viewer.
    pub sensors: Sensors,
    /// Which eyes count.
    pub eyes: Eyes,
    /// Of the left eye's directions.
    pub left: Option<Calibration>,
    /// Of the right eye's directions.
    pub right: Option<Calibration>,
    /// Of the combined eye's directions, and of gaze points: those on the
    /// `screen` go in as the directions that they are, others as they are
    /// (points on a plane as metres).
    pub combined: Option<Calibration>,
    /// Where gaze points lie that are not raw.
    pub screen: Option<Screen>,
    /// Eyes turn no farther from straight ahead: above 0, up to 90°; radians.
    /// What is beyond is refused.
    pub most_eccentricity: f32,
    /// An eye that is less open counts as shut; 0 to 1.
    pub least_openness: f32,
    /// A gaze that is the same to the last bit for longer is stuck, and then as
    /// old as its last change: from 50 ms on. What the tracker said is compared,
    /// not what the head's turn makes of it; of two eyes, both. `None` believes
    /// it: for a tracker so coarse that a fixation shows no noise.
    pub stuck_after: Option<Micros>,
    /// A position, or an orientation with its turn, that is the same to the last
    /// bit for longer, though it has changed before, is stuck, and then as old as
    /// its last change: from 50 ms on. What never changed is believed, since a
    /// stand or a script has no noise, and some trackers turn but do not move; if
    /// neither did, an [`Event::HeadStill`](super::Event::HeadStill) says so. A
    /// head that somebody wears never rests so well; a script that moves it, and
    /// then not, and adds no noise wants `None`, which believes everything.
    pub head_stuck_after: Option<Micros>,
    /// What smooths the directions.
    pub filter: Filter,
    /// How saccades are told.
    pub saccades: SaccadeConfig,
    /// How the gaze is continued; `None` shows it where it was.
    pub prediction: Option<GazePrediction>,
    /// How the head is continued.
    pub head: HeadConfig,
    /// What to do when data are stale.
    pub fallback: FallbackConfig,
}

impl Default for EstimatorConfig {
    fn default() -> Self {
        Self {
            room_from_tracker: RoomFromTracker::IDENTITY,
            resting_head: HeadPose::IDENTITY,
            head_tracked: true,
            sensors: Sensors::All,
            eyes: Eyes::Combined,
            left: None,
            right: None,
            combined: None,
            screen: None,
            most_eccentricity: 1.308_997,
            least_openness: 0.2,
            stuck_after: Some(Micros(250_000)),
            head_stuck_after: Some(Micros(500_000)),
            filter: Filter::OneEuro(OneEuroConfig::default()),
            saccades: SaccadeConfig::default(),
            prediction: Some(GazePrediction::default()),
            head: HeadConfig::default(),
            fallback: FallbackConfig::default(),
        }
    }
}

/// A configuration that cannot work.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum ConfigError {
    /// A number outside its range, or NaN.
    OutOfRange {
        /// Which, and its unit.
        field: &'static str,
        /// The number.
        found: f32,
        /// The least it can be.
        least: f32,
        /// The most it can be.
        most: f32,
    },
    /// A time outside its range.
    Time {
        /// Which.
        field: &'static str,
        /// The time.
        found: Micros,
        /// The least it can be.
        least: Micros,
        /// The most it can be.
        most: Micros,
    },
    /// Of two values that ascend, the second is below the first.
    Order {
        /// The one that is to be lower.
        first: &'static str,
        /// The one that is to be higher.
        second: &'static str,
    },
    /// A place is NaN or infinite.
    NotFinite {
        /// Which.
        field: &'static str,
    },
    /// A direction or a rotation does not have length 1.
    NotUnit {
        /// Which.
        field: &'static str,
        /// Its length.
        length: f32,
    },
    /// The screen's edges are not at right angles.
    Skewed {
        /// The cosine of their angle.
        cosine: f32,
    },
}

impl fmt::Display for ConfigError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::OutOfRange {
                field,
                found,
                least,
                most,
            } => write!(f, "{field} is {found}: give {least} to {most}"),
            Self::Time {
                field,
                found,
                least,
                most,
            } => write!(
                f,
                "{field} is {} µs: give {} to {} µs",
                found.0, least.0, most.0
            ),
            Self::Order { first, second } => {
                write!(f, "{first} is above {second}: exchange them or change one")
            }
            Self::NotFinite { field } => {
                write!(f, "{field} is not finite: give three finite numbers")
            }
            Self::NotUnit { field, length } => {
                write!(f, "{field} has length {length}: give one of length 1")
            }
            Self::Skewed { cosine } => write!(
                f,
                "the screen's edges are not at right angles (the cosine is {cosine}): measure \
                 its corners again"
            ),
        }
    }
}

impl core::error::Error for ConfigError {}

impl EstimatorConfig {
    /// Checks all values.
    ///
    /// # Errors
    /// The first that is out of its range.
    pub fn check(&self) -> Result<(), ConfigError> {
        for (field, place) in [
            ("the tracker's position", self.room_from_tracker.position),
            ("the resting head's position", self.resting_head.position),
        ] {
            if !place.is_finite() {
                return Err(ConfigError::NotFinite { field });
            }
        }
        let orientations = [
            (
                "the tracker's orientation",
                self.room_from_tracker.orientation,
            ),
            (
                "the resting head's orientation",
                self.resting_head.orientation,
            ),
        ];
        for (field, orientation) in orientations {
            unit(field, orientation.length())?;
        }
        if let Some(screen) = self.screen {
            screen.check()?;
        }
        self.check_numbers()?;
        self.check_times()
    }

    fn check_numbers(&self) -> Result<(), ConfigError> {
        use core::f32::consts::{FRAC_PI_2, PI};
        let saccades = &self.saccades;
        let numbers = [
            (
                "the largest eccentricity (rad)",
                self.most_eccentricity,
                1.0e-3,
                FRAC_PI_2,
            ),
            ("the least openness", self.least_openness, 0.0, 1.0),
            ("the widening (rad)", self.fallback.widen_by, 0.0, PI),
            (
                "a saccade's start speed (rad/s)",
                saccades.start_speed,
                0.05,
                20.0,
            ),
            (
                "a saccade's end speed (rad/s)",
                saccades.end_speed,
                0.01,
                20.0,
            ),
            (
                "a saccade's least amplitude (rad)",
                saccades.least_amplitude,
                0.0,
                0.2,
            ),
            (
                "a saccade's base duration (s)",
                saccades.base_duration,
                0.005,
                0.1,
            ),
            (
                "a saccade's duration per amplitude (s/rad)",
                saccades.duration_per_amplitude,
                0.0,
                1.0,
            ),
            (
                "the head's least turn (rad/s)",
                self.head.least_turn,
                0.001,
                1.0,
            ),
            (
                "the head's least speed (m/s)",
                self.head.least_speed,
                0.001,
                1.0,
            ),
        ];
        for (field, found, least, most) in numbers {
            number(field, found, least, most)?;
        }
        if let Filter::OneEuro(filter) = self.filter {
            number(
                "the filter's least cutoff (Hz)",
                filter.least_cutoff,
                0.01,
                1_000.0,
            )?;
            number("the filter's beta (Hz s/rad)", filter.beta, 0.0, 10_000.0)?;
            number(
                "the filter's speed cutoff (Hz)",
                filter.speed_cutoff,
                0.01,
                1_000.0,
            )?;
        }
        if let Some(prediction) = self.prediction {
            let least_speed = prediction.pursuit.least_speed;
            number("pursuit's least speed (rad/s)", least_speed, 0.001, 1.0)?;
        }
        ascend(
            "a saccade's end speed",
            saccades.end_speed,
            "its start speed",
            saccades.start_speed,
        )
    }

    fn check_times(&self) -> Result<(), ConfigError> {
        let (saccades, fallback) = (&self.saccades, &self.fallback);
        for (field, found, least, most) in [
            ("a saccade's window", saccades.window, 1, 100),
            (
                "a saccade's least duration",
                saccades.least_duration,
                0,
                100,
            ),
            (
                "a saccade's longest duration",
                saccades.most_duration,
                20,
                500,
            ),
            ("the largest gap between samples", saccades.most_gap, 5, 500),
            ("the head's window", self.head.window, 10, 500),
            ("the head's horizon", self.head.horizon, 0, 200),
            ("the longest blink", fallback.longest_blink, 0, 5_000),
            ("the time to hold", fallback.hold_after, 1, 60_000),
            ("the time to full quality", fallback.full_after, 1, 60_000),
            (
                "the head's time to hold",
                fallback.head_hold_after,
                1,
                60_000,
            ),
            (
                "the head's time to full quality",
                fallback.head_full_after,
                1,
                60_000,
            ),
        ] {
            time(field, found, least, most)?;
        }
        for (field, stuck_after) in [
            ("the time until the gaze is stuck", self.stuck_after),
            ("the time until the head is stuck", self.head_stuck_after),
        ] {
            if let Some(stuck_after) = stuck_after {
                time(field, stuck_after, 50, 60_000)?;
            }
        }
        if let Some(prediction) = self.prediction {
            time("the gaze's horizon", prediction.horizon, 0, 200)?;
            time("pursuit's window", prediction.pursuit.window, 20, 500)?;
        }
        for (first, lower, second, higher) in [
            (
                "a saccade's least duration",
                saccades.least_duration,
                "its longest",
                saccades.most_duration,
            ),
            (
                "the time to hold",
                fallback.hold_after,
                "the time to widen",
                fallback.widen_after,
            ),
            (
                "the time to widen",
                fallback.widen_after,
                "the time to the head's direction",
                fallback.head_after,
            ),
            (
                "the time to the head's direction",
                fallback.head_after,
                "the time to full quality",
                fallback.full_after,
            ),
            (
                "the head's time to hold",
                fallback.head_hold_after,
                "its time to widen",
                fallback.head_widen_after,
            ),
            (
                "the head's time to widen",
                fallback.head_widen_after,
                "its time to full quality",
                fallback.head_full_after,
            ),
        ] {
            ascend(first, lower, second, higher)?;
        }
        Ok(())
    }
}

impl Screen {
    fn check(&self) -> Result<(), ConfigError> {
        if !self.corner.is_finite() {
            let field = "the screen's corner";
            return Err(ConfigError::NotFinite { field });
        }
        unit("the screen's right", self.right.length())?;
        unit("the screen's down", self.down.length())?;
        number("the screen's width (m)", self.size.x, 1.0e-3, 1.0e3)?;
        number("the screen's height (m)", self.size.y, 1.0e-3, 1.0e3)?;
        let cosine = self.right.dot(self.down);
        if !(cosine.abs() <= 0.01) {
            return Err(ConfigError::Skewed { cosine });
        }
        Ok(())
    }

    /// A point's place in the room, given in metres from the corner.
    pub fn place(&self, point: Vec2) -> Vec3 {
        self.corner + self.right * point.x + self.down * point.y
    }
}

fn number(field: &'static str, found: f32, least: f32, most: f32) -> Result<(), ConfigError> {
    if (least..=most).contains(&found) {
        return Ok(());
    }
    Err(ConfigError::OutOfRange {
        field,
        found,
        least,
        most,
    })
}

/// The limits are milliseconds.
fn time(field: &'static str, found: Micros, least: u64, most: u64) -> Result<(), ConfigError> {
    let (least, most) = (Micros::from_millis(least), Micros::from_millis(most));
    if (least..=most).contains(&found) {
        return Ok(());
    }
    Err(ConfigError::Time {
        field,
        found,
        least,
        most,
    })
}

fn ascend<T: PartialOrd + Copy>(
    first: &'static str,
    lower: T,
    second: &'static str,
    higher: T,
) -> Result<(), ConfigError> {
    if lower <= higher {
        Ok(())
    } else {
        Err(ConfigError::Order { first, second })
    }
}

fn unit(field: &'static str, length: f32) -> Result<(), ConfigError> {
    if (length - 1.0).abs() <= 1.0e-3 {
        Ok(())
    } else {
        Err(ConfigError::NotUnit { field, length })
    }
}

impl RoomFromTracker {
    /// A place in the room, of what the tracker gives.
    pub fn place(&self, position: Vec3) -> Vec3 {
        self.position + rotation::rotate(self.orientation, position)
    }

    /// `room_from_head` of the tracker's `tracker_from_head`; `None` where it
    /// is no rotation.
    pub fn orientation(&self, tracker_from_head: Quat) -> Option<Quat> {
        rotation::unit(rotation::compose(self.orientation, tracker_from_head))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::format;

    fn checked(change: impl FnOnce(&mut EstimatorConfig)) -> Result<(), ConfigError> {
        let mut config = EstimatorConfig::default();
        change(&mut config);
        config.check()
    }

    #[test]
    fn the_default_is_allowed_and_slips_are_told() {
        assert_eq!(checked(|_| {}), Ok(()));
        let error = checked(|c| c.most_eccentricity = 2.0).unwrap_err();
        assert_eq!(
            format!("{error}"),
            "the largest eccentricity (rad) is 2: give 0.001 to 1.5707964"
        );
        let error = checked(|c| c.fallback.widen_after = Micros(1)).unwrap_err();
        assert_eq!(
            format!("{error}"),
            "the time to hold is above the time to widen: exchange them or change one"
        );
        let error = checked(|c| c.head.horizon = Micros(300_000)).unwrap_err();
        assert_eq!(
            format!("{error}"),
            "the head's horizon is 300000 µs: give 0 to 200000 µs"
        );
        let error = checked(|c| c.resting_head.orientation = Quat::from_xyzw(0.0, 0.0, 0.0, 2.0));
        assert!(matches!(error, Err(ConfigError::NotUnit { length, .. }) if length == 2.0));
        let error = checked(|c| c.room_from_tracker.position.x = f32::NAN);
        assert!(matches!(error, Err(ConfigError::NotFinite { .. })));
        let error = checked(|c| {
            c.filter = Filter::OneEuro(OneEuroConfig {
                beta: f32::NAN,
                ..OneEuroConfig::default()
            });
        });
        assert!(matches!(error, Err(ConfigError::OutOfRange { .. })));
        let skewed = Screen {
            corner: Vec3::ZERO,
            right: Vec3::X,
            down: Vec3::X,
            size: Vec2::ONE,
        };
        let error = checked(|c| c.screen = Some(skewed));
        assert_eq!(error, Err(ConfigError::Skewed { cosine: 1.0 }));
    }
}
