//! The configuration of a [`GazeEstimator`](super::GazeEstimator).

mod check;

pub use check::EstimatorConfigError;

use super::calibration::Calibration;
use super::fallback::FallbackConfig;
use super::head::HeadConfig;
use super::movement::{PursuitConfig, SaccadeConfig};
use super::one_euro::OneEuroConfig;
use crate::rotation;
use crate::time::Micros;
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

/// The eye whose line of sight is used.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Eyes {
    /// The device's combined eye; without one, the mean of both, or the one that is seen.
    #[default]
    Combined,
    /// The left one alone.
    Left,
    /// The right one alone.
    Right,
    /// No eye: there is no eye tracker, and the head's direction is used.
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

/// The filter of the eyes' directions.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Filter {
    /// Nothing.
    None,
    /// The One-Euro filter; saccades go past it.
    OneEuro(OneEuroConfig),
}

/// How the gaze is continued to the time of display.
///
/// On the mock's default viewer, 20 ms after the sample, the error of the line of sight is
/// nowhere larger than without it, in median and 95th percentile, from 60 to 1,000 Hz. In pursuit
/// the median is at most 0.9 of that without at 60 Hz, two thirds at 120 Hz and half from 250 Hz
/// on; in the first 20 ms after a landing at most 0.7.
/// `cargo test -p shisen-tracker prediction -- --nocapture` prints all errors and asserts this.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GazePrediction {
    /// By how much at most, for pursuit: up to 200 ms.
    pub horizon: Micros,
    /// How pursuit is recognised.
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

/// The sensors that are the viewer's, by [`Sample::sensor`](crate::sample::Sample::sensor).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Sensors {
    /// Every sensor.
    #[default]
    All,
    /// The sensor of the first sample.
    First,
    /// This one.
    Only(u8),
}

/// The configuration of a gaze estimator; [`EstimatorConfig::check`] checks the ranges.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EstimatorConfig {
    /// Where the tracker is.
    pub room_from_tracker: RoomFromTracker,
    /// Where the head is as far as no tracker says.
    pub resting_head: HeadPose,
    /// Whether there is a head tracker. Without one the head rests and is never stale.
    pub head_tracked: bool,
    /// The sensors that are used, for a tracker with several.
    pub sensors: Sensors,
    /// The eyes that are used.
    pub eyes: Eyes,
    /// The calibration of the left eye's directions.
    pub left: Option<Calibration>,
    /// The calibration of the right eye's directions.
    pub right: Option<Calibration>,
    /// The calibration of the combined eye's directions and of gaze points: those on the
    /// `screen` go in as the directions that they are, others as they are
    /// (points on a plane as metres).
    pub combined: Option<Calibration>,
    /// Where gaze points lie that are not raw.
    pub screen: Option<Screen>,
    /// The farthest that eyes turn from straight ahead, radians: above 0, up to 90°.
    pub most_eccentricity: f32,
    /// An eye that is less open counts as shut; 0 to 1.
    pub least_openness: f32,
    /// A gaze that the tracker says to the same bits for longer is stuck, and as old as its
    /// last change: from 50 ms on. `None` believes it, for a tracker so coarse that a fixation
    /// shows no noise.
    pub stuck_after: Option<Micros>,
    /// A position, or an orientation with its turn, that has changed before and is the same to
    /// the last bit for longer is stuck, and as old as its last change: from 50 ms on. What never
    /// changed is believed, since a stand has no noise; if neither did,
    /// [`Event::HeadStill`](super::Event::HeadStill) says so. `None` believes everything, for a
    /// script that moves the head, and then not, without noise.
    pub head_stuck_after: Option<Micros>,
    /// The filter that smooths the directions.
    pub filter: Filter,
    /// How saccades are recognised.
    pub saccades: SaccadeConfig,
    /// How the gaze is continued; `None` shows it where it was.
    pub prediction: Option<GazePrediction>,
    /// How the head is continued.
    pub head: HeadConfig,
    /// The fallback when data are stale.
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

impl Screen {
    /// Returns a point's place in the room, given in metres from the corner.
    pub fn place(&self, point: Vec2) -> Vec3 {
        self.corner + self.right * point.x + self.down * point.y
    }
}

impl RoomFromTracker {
    /// Returns a place in the room, of what the tracker gives.
    pub fn place(&self, position: Vec3) -> Vec3 {
        self.position + rotation::rotate(self.orientation, position)
    }

    /// `room_from_head` of the tracker's `tracker_from_head`; `None` where it is no rotation.
    pub fn orientation(&self, tracker_from_head: Quat) -> Option<Quat> {
        rotation::unit(rotation::compose(self.orientation, tracker_from_head))
    }
}
