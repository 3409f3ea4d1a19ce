//! Maps between planes: of a projector's picture onto a flat screen's.

use super::projector::Lens;
use crate::cave::{RoomError, WallPlane};
use glam::{DMat3, DVec2, DVec3};

/// A map of a projector's picture to its screen's, both in 0 to 1 from the upper left corner, to the
/// right and downwards. The third coordinate is positive where light goes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Homography {
    to_screen: DMat3,
    to_picture: DMat3,
}

/// A point of the projector's picture and where it lies in the screen's.
pub(super) type Pin = [DVec2; 2];

impl Homography {
    /// Greatest distance of a pin from where all the others have it: of the screen's picture.
    const MOST_OFF: f64 = 0.02;

    fn new(to_screen: DMat3) -> Option<Self> {
        let to_picture = to_screen.inverse();
        to_picture.is_finite().then_some(Self {
            to_screen,
            to_picture,
        })
    }

    /// Returns the map of a projector's light onto a wall, from its front or its back; `None` for a
    /// projector in the wall's plane.
    pub(super) fn of_lens(lens: &Lens, wall: &WallPlane) -> Option<Self> {
        let screen = DMat3::from_cols(wall.right, wall.down, wall.upper_left - lens.position);
        let scale = wall.right.length() * wall.down.length();
        let distance = (screen.determinant() / scale).abs();
        (distance > 1.0e-9).then(|| Self::new(screen.inverse() * lens.frame()))?
    }

    pub(super) const fn to_screen(self) -> DMat3 {
        self.to_screen
    }

    /// Returns the map onto a part of the screen's picture: its left, upper, right and lower edges.
    pub(super) fn of_part([left, top, right, bottom]: [f64; 4]) -> Option<Self> {
        let columns = DVec3::new(right - left, 0.0, 0.0);
        let rows = DVec3::new(0.0, bottom - top, 0.0);
        Self::new(DMat3::from_cols(columns, rows, DVec3::new(left, top, 1.0)))
    }

    /// Returns the map by least squares (Hartley and Zisserman's normalised direct linear
    /// transformation) of four or more pins.
    pub(super) fn of_pins(pins: &[Pin]) -> Result<Self, RoomError> {
        let fault = |message: String, help: &str| RoomError::new("corner_pins", message, help);
        let order = "list each pin as [[x, y], [s, t]]: the same corner in the projector's picture \
                     and on the screen, no three on one line";
        let found = (|| {
            let [from, to] = [0, 1].map(|side| normalisation(pins, side));
            let (from, to) = (from?, to?);
            let to_screen = to.inverse() * solved(pins, from, to)? * from;
            // The third coordinate is positive in the pins' middle.
            let middle = pins.iter().map(|[at, _]| *at).sum::<DVec2>() / pins.len() as f64;
            let sign = (to_screen * middle.extend(1.0)).z.signum();
            let size = to_screen.to_cols_array().into_iter().map(f64::abs);
            Self::new(to_screen * (sign / size.fold(0.0, f64::max)))
        })();
        let Some(map) = found else {
            let message = if turns_both_ways(pins) {
                "the corner pins cross, or are not convex"
            } else {
                "the corner pins lie on one line, or two are the same"
            };
            return Err(fault(message.to_owned(), order));
        };
        for (number, [at, place]) in pins.iter().enumerate() {
            let number = number + 1;
            let Some(found) = map.place(*at) else {
                let message = format!(
                    "the corner pins cross, or are not convex: pin {number} is on the other side"
                );
                return Err(fault(message, order));
            };
            let off = found.distance(*place);
            if !(off <= Self::MOST_OFF) {
                let message = format!(
                    "corner pin {number} is {:.1} % of the screen's picture away from where the \
                     others have it",
                    100.0 * off
                );
                return Err(fault(message, "measure this pin again, or leave it out"));
            }
        }
        Ok(map)
    }

    /// Returns where a point of the projector's picture is in the screen's, also outside 0 to 1;
    /// `None` where its light does not meet the plane.
    pub(super) fn place(&self, at: DVec2) -> Option<DVec2> {
        projected(&self.to_screen, at)
    }

    /// Returns the point of the projector's picture that lights a place in the screen's, also
    /// outside 0 to 1; `None` for places behind the lens.
    pub(super) fn at(&self, place: DVec2) -> Option<DVec2> {
        projected(&self.to_picture, place)
    }
}

fn projected(map: &DMat3, point: DVec2) -> Option<DVec2> {
    let DVec3 { x, y, z } = *map * point.extend(1.0);
    let point = DVec2::new(x / z, y / z);
    (z > 0.0 && point.is_finite()).then_some(point)
}

/// Returns whether some triangles of pins are turned over on the screen, and others are not.
fn turns_both_ways(pins: &[Pin]) -> bool {
    let of = |[a, b, c]: [&Pin; 3]| {
        let turn = |side: usize| (b[side] - a[side]).perp_dot(c[side] - a[side]);
        turn(0) * turn(1)
    };
    let triangles = (2..pins.len()).map(|last| of([&pins[0], &pins[last - 1], &pins[last]]));
    let signs: Vec<f64> = triangles.filter(|turn| *turn != 0.0).collect();
    signs.iter().any(|one| *one > 0.0) && signs.iter().any(|one| *one < 0.0)
}

/// Returns the map of one side's points to a mean of 0 and a mean distance of √2.
fn normalisation(pins: &[Pin], side: usize) -> Option<DMat3> {
    let points = || pins.iter().map(|pin| pin[side]);
    let count = pins.len() as f64;
    let middle = points().sum::<DVec2>() / count;
    let distance = points().map(|point| point.distance(middle)).sum::<f64>() / count;
    let scale = std::f64::consts::SQRT_2 / distance;
    let map = DMat3::from_scale(DVec2::splat(scale)) * DMat3::from_translation(-middle);
    map.is_finite().then_some(map)
}

/// Returns the homography of normalised points whose last element is 1, by the normal equations.
fn solved(pins: &[Pin], from: DMat3, to: DMat3) -> Option<DMat3> {
    // Eight unknowns, and the right side.
    let mut equations = [[0.0; 9]; 8];
    for [at, place] in pins {
        let DVec2 { x, y } = from.transform_point2(*at);
        let DVec2 { x: s, y: t } = to.transform_point2(*place);
        for row in [
            [x, y, 1.0, 0.0, 0.0, 0.0, -s * x, -s * y, s],
            [0.0, 0.0, 0.0, x, y, 1.0, -t * x, -t * y, t],
        ] {
            for (sums, factor) in equations.iter_mut().zip(row) {
                for (sum, value) in sums.iter_mut().zip(row) {
                    *sum += factor * value;
                }
            }
        }
    }
    // Gauss and Jordan, with the largest pivots.
    for column in 0..8 {
        let size = |row: &usize| equations[*row][column].abs();
        let pivot = (column..8).max_by(|a, b| size(a).total_cmp(&size(b)))?;
        if !(size(&pivot) > 1.0e-9) {
            return None;
        }
        equations.swap(column, pivot);
        let pivot = equations[column].map(|value| value / equations[column][column]);
        for row in &mut equations {
            let factor = row[column];
            for (value, pivot) in row.iter_mut().zip(pivot) {
                *value -= factor * pivot;
            }
        }
        equations[column] = pivot;
    }
    let [a, b, c, d, e, f, g, h] = equations.map(|row| row[8]);
    Some(DMat3::from_cols_array(&[a, d, g, b, e, h, c, f, 1.0]))
}
