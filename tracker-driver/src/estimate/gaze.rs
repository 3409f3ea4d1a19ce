//! From a sample's fields to one direction in the head's axes.

use super::calibration::{Calibration, plane_of};
use super::config::{EstimatorConfig, Eyes};
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
    /// A unit vector in the head's axes.
    Direction(Vec3),
}

/// The gaze of a sample, with the head at `head` when it was measured.
pub(super) fn of_sample(config: &EstimatorConfig, sample: &Sample, head: &HeadPose) -> Gaze {
    let [left, right, combined] = match config.eyes {
        Eyes::HeadOnly => return Gaze::None,
        Eyes::Combined => [true, true, true],
        Eyes::Left => [true, false, false],
        Eyes::Right => [false, true, false],
    };
    let eyes = [
        (&sample.left, &config.left, left),
        (&sample.right, &config.right, right),
        (&sample.combined, &config.combined, combined),
    ];
    let known = eyes
        .iter()
        .any(|(eye, _, chosen)| *chosen && !eye.is_empty());
    if !known && sample.gaze_point.is_none() {
        return Gaze::None;
    }
    let shut = |eye: &Eye| {
        eye.openness
            .is_some_and(|open| open < config.least_openness)
    };
    let both_shut = shut(&sample.left) && shut(&sample.right);
    if both_shut || shut(&sample.combined) {
        return Gaze::Lost;
    }
    let [left, right, combined] = eyes.map(|(eye, calibration, chosen)| {
        let reading = eye.direction.filter(|d| d.tracked && chosen)?;
        if shut(eye) {
            return None;
        }
        let direction = match sample.gaze_frame {
            GazeFrame::Head => reading.value,
            GazeFrame::Tracker => {
                let in_room = rotate(config.room_from_tracker.orientation, reading.value);
                rotate(inverse(head.orientation), in_room)
            }
        };
        calibrated(direction, calibration.as_ref())
    });
    let direction = combined.or_else(|| match (left, right) {
        (Some(left), Some(right)) => normalize(left + right),
        (left, right) => left.or(right),
    });
    if let Some(direction) = direction {
        return Gaze::Direction(direction);
    }
    let Some(point) = sample.gaze_point.filter(|point| point.tracked) else {
        return Gaze::Lost;
    };
    of_point(config, point.value, head)
}

fn calibrated(direction: Vec3, calibration: Option<&Calibration>) -> Option<Vec3> {
    let direction = normalize(direction)?;
    match calibration {
        // What is behind the head stays so, and is refused for it.
        Some(calibration) => match plane_of(direction) {
            Some(place) => calibration.direction(place),
            None => Some(direction),
        },
        None => Some(direction),
    }
}

fn of_point(config: &EstimatorConfig, point: GazePoint, head: &HeadPose) -> Gaze {
    let seen = |place: Vec3| {
        let in_room = normalize(place - head.position)?;
        Some(rotate(inverse(head.orientation), in_room))
    };
    let by_calibration = |measured: Vec2| {
        let calibration = config.combined.as_ref();
        calibration.map(|calibration| calibration.direction(measured))
    };
    let direction = match (point, config.screen) {
        (GazePoint::Plane(metres), Some(screen)) => Some(seen(screen.place(metres))),
        (GazePoint::Normalized(part), Some(screen)) => Some(seen(screen.place(part * screen.size))),
        (GazePoint::Plane(p) | GazePoint::Normalized(p) | GazePoint::Raw(p), _) => {
            by_calibration(p)
        }
    };
    match direction {
        Some(Some(direction)) if direction.is_finite() => Gaze::Direction(direction),
        Some(_) => Gaze::Lost,
        None => Gaze::Uncalibrated,
    }
}
