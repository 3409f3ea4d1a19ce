//! From a sample's fields to one direction in the head's axes.

use super::calibration::{Calibration, plane_of};
use super::config::{EstimatorConfig, Eyes};
use super::unchanged::Fingerprint;
use crate::rotation::{inverse, rotate};
use crate::sample::{Eye, GazeFrame, GazePoint, Sample};
use glam::{Vec2, Vec3};
use shisen_core::gaze::HeadPose;
use shisen_core::numeric::normalize;

/// What a sample says about the gaze.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Gaze {
    /// Nothing: it is not of an eye tracker.
    None,
    /// The eye tracker sees no gaze, or an eye that is shut.
    Lost,
    /// There is a gaze point and nothing to make a direction of it.
    Uncalibrated,
    /// The gaze is seen.
    Seen {
        /// A unit vector in the head's axes.
        direction: Vec3,
        /// The fingerprint of what the tracker said, before the head turns it.
        reading: Fingerprint,
    },
}

/// What an eye tracker says of the eyes, before any calibration: what a
/// [`Calibration`] is fitted to and then applied to.
///
/// A direction is the place where it meets the plane one metre ahead of the
/// head ([`plane_of`]); a gaze point is that of its direction where there is a
/// [`Screen`](super::Screen) that it lies on, and unchanged otherwise.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Measured {
    /// The left eye.
    pub left: Option<Vec2>,
    /// The right eye.
    pub right: Option<Vec2>,
    /// The combined eye, or else the gaze point.
    pub combined: Option<Vec2>,
}

impl Measured {
    /// Returns what a sample says, with the head at `head` in the room when it was measured. `None`
    /// for an eye that is shut, not tracked or not among [`EstimatorConfig::eyes`];
    /// calibrations are not applied.
    pub fn of(config: &EstimatorConfig, sample: &Sample, head: &HeadPose) -> Self {
        let blink = both_shut(config, sample, [false; 2]);
        let [left, right, combined] = eyes(config, sample).map(|(eye, _)| {
            let eye = eye.filter(|_| !blink)?;
            plane_of(direction_of(config, sample, eye, head)?)
        });
        let point = sample.gaze_point.filter(|point| point.tracked && !blink);
        let point = point.filter(|_| !matches!(config.eyes, Eyes::HeadOnly));
        let of_point = || match of_point(config, point?.value, head)? {
            Seen::Direction(direction) => plane_of(direction),
            Seen::Raw(place) => Some(place),
        };
        Self {
            left,
            right,
            combined: combined.or_else(of_point),
        }
    }
}

/// An eye's data and its calibration; no data where it is not asked for.
type Chosen<'a> = (Option<&'a Eye>, &'a Option<Calibration>);

/// Left, right and combined.
fn eyes<'a>(config: &'a EstimatorConfig, sample: &'a Sample) -> [Chosen<'a>; 3] {
    let [left, right, combined] = match config.eyes {
        Eyes::HeadOnly => [false; 3],
        Eyes::Combined => [true, true, true],
        Eyes::Left => [true, false, false],
        Eyes::Right => [false, true, false],
    };
    [
        (left.then_some(&sample.left), &config.left),
        (right.then_some(&sample.right), &config.right),
        (combined.then_some(&sample.combined), &config.combined),
    ]
}

fn shut(config: &EstimatorConfig, eye: &Eye) -> bool {
    let least = config.least_openness;
    eye.openness.is_some_and(|open| open < least)
}

fn both_shut(config: &EstimatorConfig, sample: &Sample, [left, right]: [bool; 2]) -> bool {
    let left = left || shut(config, &sample.left);
    let right = right || shut(config, &sample.right);
    left && right || shut(config, &sample.combined)
}

/// Returns the direction of an eye that is open and tracked: a unit vector in the head's axes.
fn direction_of(
    config: &EstimatorConfig,
    sample: &Sample,
    eye: &Eye,
    head: &HeadPose,
) -> Option<Vec3> {
    let reading = eye.direction.filter(|direction| direction.tracked)?;
    if shut(config, eye) {
        return None;
    }
    normalize(match sample.gaze_frame {
        GazeFrame::Head => reading.value,
        GazeFrame::Tracker => {
            let in_room = rotate(config.room_from_tracker.orientation, reading.value);
            rotate(inverse(head.orientation), in_room)
        }
    })
}

/// Returns the gaze of a sample, the head then at `head`, the left and the right eye hidden or not.
pub(super) fn of_sample(
    config: &EstimatorConfig,
    sample: &Sample,
    head: &HeadPose,
    hidden: [bool; 2],
) -> Gaze {
    if config.eyes == Eyes::HeadOnly {
        return Gaze::None;
    }
    let eyes = eyes(config, sample);
    let known = eyes
        .iter()
        .any(|(eye, _)| eye.is_some_and(|eye| !eye.is_empty()));
    if !known && sample.gaze_point.is_none() {
        return Gaze::None;
    }
    if both_shut(config, sample, hidden) {
        return Gaze::Lost;
    }
    let direction = |(eye, calibration): Chosen<'_>| {
        let direction = direction_of(config, sample, eye?, head)?;
        let reading = eye?.direction?.value;
        Some((calibrated(direction, calibration.as_ref())?, reading))
    };
    let [left, right, combined] = eyes.map(direction);
    let [left, right] =
        [(left, hidden[0]), (right, hidden[1])].map(|(seen, hidden)| seen.filter(|_| !hidden));
    let of_one =
        |(direction, reading): (Vec3, Vec3)| (direction, Fingerprint::of(&reading.to_array()));
    let of_both = || match (left, right) {
        (Some((left, a)), Some((right, b))) => {
            let reading = Fingerprint::of(&a.to_array()).and(&b.to_array());
            Some((normalize(left + right)?, reading))
        }
        (left, right) => left.or(right).map(of_one),
    };
    if let Some((direction, reading)) = combined.map(of_one).or_else(of_both) {
        return Gaze::Seen { direction, reading };
    }
    let Some(point) = sample.gaze_point.filter(|point| point.tracked) else {
        return Gaze::Lost;
    };
    let calibration = config.combined.as_ref();
    let direction = match of_point(config, point.value, head) {
        Some(Seen::Direction(direction)) => calibrated(direction, calibration),
        Some(Seen::Raw(place)) => match calibration {
            Some(calibration) => calibration.direction(place),
            None => return Gaze::Uncalibrated,
        },
        None => None,
    };
    match direction {
        Some(direction) if direction.is_finite() => Gaze::Seen {
            direction,
            reading: Fingerprint::of(&point.value.numbers().to_array()),
        },
        _ => Gaze::Lost,
    }
}

/// Returns a unit vector through its calibration.
fn calibrated(direction: Vec3, calibration: Option<&Calibration>) -> Option<Vec3> {
    match calibration.zip(plane_of(direction)) {
        Some((calibration, place)) => calibration.direction(place),
        // What is behind the head stays so, and is refused for it.
        None => Some(direction),
    }
}

/// What a gaze point says.
enum Seen {
    /// A point on a known screen: a unit vector in the head's axes.
    Direction(Vec3),
    /// In units that only a calibration knows.
    Raw(Vec2),
}

/// `None` where the head is on the screen.
fn of_point(config: &EstimatorConfig, point: GazePoint, head: &HeadPose) -> Option<Seen> {
    let (screen, metres) = match (point, config.screen) {
        (GazePoint::Plane(metres), Some(screen)) => (screen, metres),
        (GazePoint::Normalized(part), Some(screen)) => (screen, part * screen.size),
        (point, _) => return Some(Seen::Raw(point.numbers())),
    };
    let in_room = normalize(screen.place(metres) - head.position)?;
    Some(Seen::Direction(rotate(inverse(head.orientation), in_room)))
}
