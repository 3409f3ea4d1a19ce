//! How large the parts of a square's picture are, by what the eye resolves there.

use super::{Picture, SIDE};
use crate::frame::view::{Kind, View};
use crate::gaze::{Acuity, LineOfSight};
use crate::numeric::{normalize, sqrt};
use core::f32::consts::SQRT_2;

/// Most pixels of a view a side of a pixel of a square.
pub const LARGEST_UNIT: u32 = 8;

/// The eye's MAR, apart from its least, over the size of a leaf, the quarter of a unit: needed for
/// edges, which are seen far better than gratings.
const LEAF: f32 = 15.0;
/// The same over the least distance of points at which bent surfaces are lit.
const BENT: f32 = 5.5;

/// Most pixels of a square between points at which bent surfaces are lit.
const BENT_MOST: usize = 8;

/// Sizes of a square: powers of two.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::frame) struct Sizes {
    /// Pixels of the view a side of a pixel of the square.
    pub(in crate::frame) unit: u32,
    /// Pixels of the square a side.
    pub(super) side: usize,
    /// Pixels of the square between points at which planes are lit.
    pub(super) plane: usize,
    /// The same for bent surfaces, at first and at least.
    pub(super) bent: usize,
    pub(super) bent_least: usize,
}

impl Sizes {
    /// Returns the sizes of the square of `pixels`² of a view with the first pixel (x, y); `None`
    /// where its middle is outside a dome's rim.
    pub(in crate::frame) fn new(
        acuity: &Acuity,
        sight: &LineOfSight,
        view: &View,
        (x, y): (u32, u32),
        pixels: u32,
    ) -> Option<Self> {
        let half = 0.5 * pixels as f32 - 0.5;
        let (x, y) = (x as f32 + half, y as f32 + half);
        let middle = view.direction(x, y)?;
        let (right, below) = (view.direction(x + 1.0, y)?, view.direction(x, y + 1.0)?);
        let length = sqrt(middle.dot(middle));
        // The solid angle of a pixel.
        let area =
            (right - middle).cross(below - middle).dot(middle).abs() / (length * length * length);
        let pixel = sqrt(area);
        let middle = normalize(middle)?;
        let forward = sight.forward();
        let across = middle.cross(forward);
        let eccentricity = libm::atan2f(sqrt(across.dot(across)), middle.dot(forward));
        let least = acuity.least_angle(eccentricity);
        let slope = least - acuity.fovea();
        let unit = power(2.0 * SQRT_2 * slope / LEAF / pixel, LARGEST_UNIT as usize);
        let side = (pixels as usize / unit).min(SIDE);
        let of_units = pixel * unit as f32;
        let cell = power((least - 0.5 * acuity.fovea()) / of_units, side);
        Some(Self {
            unit: unit as u32,
            side,
            plane: cell.max(4).min(side),
            bent: cell.min(BENT_MOST),
            bent_least: power(slope / BENT / of_units, BENT_MOST.min(side)),
        })
    }

    /// Returns whether each pixel of the view is lit by itself.
    pub(in crate::frame) const fn is_of_pixels(&self) -> bool {
        self.unit == 1 && self.bent == 1
    }
}

/// Returns the largest power of two that is not above a size, from 1 to `most`.
fn power(size: f32, most: usize) -> usize {
    let mut power = 1;
    while power < most && (2 * power) as f32 <= size {
        power *= 2;
    }
    power
}

impl Picture {
    /// Returns the directions over a square with the first pixel (x, y), in units of some pixels;
    /// exact on flat screens, on domes between the square's corners. `None` where the view's rays
    /// have no common start, or a dome bends too much.
    pub(in crate::frame) fn new(view: &View, (x, y): (u32, u32), sizes: &Sizes) -> Option<Self> {
        let unit = sizes.unit as f32;
        let (left, top) = (x as f32 - 0.5, y as f32 - 0.5);
        let at = |x: f32, y: f32| view.direction(left + unit * x, top + unit * y);
        if let Kind::Screen(screen) = view.kind() {
            let first = screen.direction(left, top);
            let right = screen.direction(left + unit, top) - first;
            let below = screen.direction(left, top + unit) - first;
            let (eye, directions) = (screen.eye, [right, below, first]);
            return Some(Self { eye, directions });
        }
        if !view.is_from_one_point() {
            return None;
        }
        let side = sizes.side as f32;
        let [a, b, c, d] = [
            at(0.0, 0.0)?,
            at(side, 0.0)?,
            at(0.0, side)?,
            at(side, side)?,
        ];
        // Lengths that make the four corners those of a parallelogram.
        let volume = a.dot(b.cross(c));
        let (a, b, c) = (
            a * (-d.dot(b.cross(c)) / volume),
            b * (a.dot(d.cross(c)) / volume),
            c * (a.dot(b.cross(d)) / volume),
        );
        let picture = Self {
            eye: view.eye(),
            directions: [(b - a) / side, (c - a) / side, a],
        };
        let half = 0.5 * side;
        let bends = [
            (half, half),
            (half, 0.0),
            (0.0, half),
            (side, half),
            (half, side),
        ]
        .into_iter()
        .any(|(x, y)| {
            let (Some(own), Some(right)) = (
                at(x, y).and_then(normalize),
                at(x + 1.0, y).and_then(normalize),
            ) else {
                return true;
            };
            let off = normalize(picture.direction(x, y))
                .map_or(f32::INFINITY, |there| (there - own).length_squared());
            !(off <= MOST_OFF * MOST_OFF * (right - own).length_squared())
        });
        (!bends).then_some(picture)
    }
}

/// Most distance of a sample from its place on a dome, in pixels of the square.
const MOST_OFF: f32 = 0.25;
