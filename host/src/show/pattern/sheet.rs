//! A screen's picture as a surface in the room, and signs that stand before it.

use super::ScreenView;
use crate::cave::look::ViewDirection;
use crate::cave::{DomeScreen, Eye, Screen};
use crate::picture::glyph::{GLYPH, dots};
use crate::picture::{Picture, PictureError};
use glam::{DVec2, DVec3};
use rayon::prelude::*;
use std::ops::Range;

/// Linear red, green and blue.
pub(super) type Colour = [f32; 3];

pub(super) const BLACK: Colour = [0.0; 3];
pub(super) const WHITE: Colour = [1.0; 3];

/// The height of a line of text in dots.
pub(super) const LINE: f64 = GLYPH as f64;

/// The samples of a pixel along each side, where a sign's edge crosses it.
const SAMPLES: u32 = 4;

/// A screen's picture in the room. Places in the picture are in pixels from its upper left corner.
pub(super) struct Sheet<'a> {
    screen: Screen<'a>,
    /// Columns and rows.
    pub(super) size: DVec2,
    /// The midpoint between the viewer's eyes: metres, in the room.
    pub(super) head: DVec3,
}

impl<'a> Sheet<'a> {
    pub(super) fn new(view: &ScreenView<'a>) -> Self {
        let [columns, rows] = view.screen.size().map(f64::from);
        Self {
            screen: view.screen,
            size: DVec2::new(columns, rows),
            head: view.viewer.eye(Eye::Centre),
        }
    }

    /// Returns the dome, if the screen is one.
    pub(super) const fn dome(&self) -> Option<&'a DomeScreen> {
        match self.screen {
            Screen::Dome(dome) => Some(dome),
            Screen::Wall(_) | Screen::Cylinder(_) => None,
        }
    }

    /// Returns whether the screen is a wall.
    pub(super) const fn is_flat(&self) -> bool {
        matches!(self.screen, Screen::Wall(_))
    }

    /// Returns the point of the room at a place in the picture: metres. The screen goes on outside
    /// the picture.
    pub(super) fn point(&self, at: DVec2) -> DVec3 {
        self.screen.point(at / self.size)
    }

    /// Returns the vectors along a wall's upper edge and down its left one: metres.
    fn edges(&self) -> [DVec3; 2] {
        let corner = self.screen.point(DVec2::ZERO);
        [DVec2::X, DVec2::Y].map(|end| self.screen.point(end) - corner)
    }

    /// Returns the place in the picture where a line of sight from inside meets the screen, also
    /// outside the picture; `None` where it meets nothing ahead.
    pub(super) fn meet(&self, from: DVec3, direction: DVec3) -> Option<DVec2> {
        let around = |centre: DVec3, radius: f64, axes: DVec3| {
            let (from, along) = ((from - centre) * axes, direction * axes);
            let (speed, half) = (along.length_squared(), from.dot(along));
            let square = half * half + speed * (radius * radius - from.length_squared());
            (square.max(0.0).sqrt() - half) / speed
        };
        let distance = match self.screen {
            Screen::Wall(_) => {
                let [right, down] = self.edges();
                let normal = right.cross(down);
                (self.screen.point(DVec2::ZERO) - from).dot(normal) / direction.dot(normal)
            }
            Screen::Dome(dome) => around(dome.centre, dome.radius, DVec3::ONE),
            Screen::Cylinder(one) => around(one.centre, one.radius, DVec3::new(1.0, 0.0, 1.0)),
        };
        let is_ahead = distance.is_finite() && distance > 0.0;
        let point = is_ahead.then(|| from + distance * direction)?;
        Some(self.screen.place(point)? * self.size)
    }

    /// Returns metres per column and per row; of a dome, along its meridians.
    pub(super) fn pitch(&self) -> DVec2 {
        let extent = match self.screen {
            Screen::Wall(_) => DVec2::from_array(self.edges().map(DVec3::length)),
            Screen::Dome(dome) => DVec2::splat(dome.width()),
            Screen::Cylinder(one) => DVec2::new(one.width(), one.height[1] - one.height[0]),
        };
        extent / self.size
    }

    /// Returns the width and the height of a wall or cylinder, or of the part of a dome that a viewer looks
    /// at: metres.
    pub(super) fn span(&self) -> DVec2 {
        let part = if self.dome().is_some() { 0.5 } else { 1.0 };
        part * self.pitch() * self.size
    }

    /// Returns a place in the picture: shares of a wall's or cylinder's width and height from its upper left
    /// corner. On a dome, `x` goes around it from its left (0) over its front (½) to its right
    /// (1), and `y` from the zenith down to the rim.
    pub(super) fn place(&self, x: f64, y: f64) -> DVec2 {
        if self.dome().is_none() {
            return DVec2::new(x, y) * self.size;
        }
        self.dome_place((x - 0.5) * std::f64::consts::PI, y)
    }

    /// Returns the place at an azimuth, radians to the right of a dome's front, and a share of the
    /// way from its zenith to its rim.
    pub(super) fn dome_place(&self, azimuth: f64, from_zenith: f64) -> DVec2 {
        let (sin, cos) = libm::sincos(azimuth);
        0.5 * self.size * (1.0 + from_zenith * DVec2::new(sin, cos))
    }

    /// Returns the dots of the largest text, metres, that is at most `room` wide and high; `None`
    /// if a dot would be smaller than a pixel.
    pub(super) fn fit(&self, text: &str, room: DVec2) -> Option<f64> {
        let dot = (room / extent(text)).min_element();
        let pixel = self.pitch().max_element();
        (dot >= pixel).then(|| pixel * (dot / pixel).floor())
    }

    /// Returns text on the screen, upright for the viewer, with dots of about `dot` metres. The dot
    /// `hold` of the text, from its upper left corner, is at a place in the picture. On a wall
    /// dots are whole pixels, and all of them are inside the picture.
    pub(super) fn sign(&self, text: &str, at: DVec2, hold: DVec2, dot: f64) -> Sign {
        let (corner, right, down) = match self.screen {
            Screen::Wall(_) => {
                let steps = (dot / self.pitch()).round().max(DVec2::ONE);
                let extent = steps * extent(text);
                let corner = (at - hold * steps).round().min(self.size - extent);
                let corner = self.point(corner.max(DVec2::ZERO));
                let (steps, [right, down]) = (steps / self.size, self.edges());
                (corner, steps.x * right, steps.y * down)
            }
            Screen::Dome(_) | Screen::Cylinder(_) => {
                let point = self.point(at);
                let sight = ViewDirection::new(point - self.head);
                let basis = sight.unwrap_or(ViewDirection::FRONT).basis();
                let (right, down) = (dot * basis.right, -dot * basis.up);
                (point - hold.x * right - hold.y * down, right, down)
            }
        };
        Sign::new(text, corner, right, down)
    }

    /// Returns text as [`sign`](Self::sign) does, with its middle at a place in the picture.
    pub(super) fn centred(&self, text: &str, at: DVec2, dot: f64) -> Sign {
        self.sign(text, at, 0.5 * extent(text), dot)
    }

    /// Returns a picture of the colours at places, which are pixels' centres.
    pub(super) fn paint(
        &self,
        colour: impl Fn(DVec2) -> Colour + Sync,
    ) -> Result<Picture, PictureError> {
        let mut picture = Picture::new(self.size.x as u32, self.size.y as u32)?;
        let rows = picture.pixels.par_chunks_mut((self.size.x as usize).max(1));
        rows.enumerate().for_each(|(y, row)| {
            for (x, pixel) in row.iter_mut().enumerate() {
                let at = DVec2::new(x as f64, y as f64) + 0.5;
                if self.screen.has(at / self.size) {
                    let [red, green, blue] = colour(at);
                    *pixel = [red, green, blue, 1.0];
                }
            }
        });
        Ok(picture)
    }

    /// Draws a sign into the picture as it is seen from a place in the room.
    pub(super) fn show(&self, picture: &mut Picture, sign: &Sign, from: DVec3) {
        let [columns, rows] = self.bounds(sign, from);
        let share = 1.0 / f64::from(SAMPLES * SAMPLES);
        for (x, y) in rows.flat_map(|y| columns.clone().map(move |x| (x, y))) {
            let Some(below @ [.., 1.0]) = picture.pixel(x, y) else {
                continue;
            };
            let corner = DVec2::new(f64::from(x), f64::from(y));
            // Sums of equal colours are exact in f64.
            let mut sum = [0.0; 4];
            for sample in 0..SAMPLES * SAMPLES {
                let step = DVec2::new(f64::from(sample % SAMPLES), f64::from(sample / SAMPLES));
                let at = corner + (step + 0.5) / f64::from(SAMPLES);
                let [red, green, blue] = match sign.colour(from, self.point(at) - from) {
                    Some(colour) => colour,
                    None => [below[0], below[1], below[2]],
                };
                for (sum, channel) in sum.iter_mut().zip([red, green, blue, 1.0]) {
                    *sum += share * f64::from(channel);
                }
            }
            picture.set_pixel(x, y, sum.map(|channel| channel as f32));
        }
    }

    /// Returns columns and rows of the picture that contain all of a sign.
    fn bounds(&self, sign: &Sign, from: DVec3) -> [Range<u32>; 2] {
        let steps = (0..81).map(|step| DVec2::new(f64::from(step % 9), f64::from(step / 9)) / 8.0);
        let places = steps.filter_map(|step| self.meet(from, sign.point(step) - from));
        let (low, high) = places.fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(low, high), at| {
            (low.min(at), high.max(at))
        });
        // A sign's edges are bent on a dome.
        let slack = 1.0 + 0.02 * (high - low);
        let (low, high) = ((low - slack).floor(), (high + slack).ceil().min(self.size));
        [low.x as u32..high.x as u32, low.y as u32..high.y as u32]
    }
}

/// A line of text on a board that stands in the room.
pub(super) struct Sign {
    /// The upper left corner of the text: metres, in the room.
    corner: DVec3,
    /// From a dot to its neighbour at the right.
    right: DVec3,
    /// From a dot to its neighbour below.
    down: DVec3,
    /// The rows of each column's dots that are set, the uppermost in the lowest bit.
    columns: Vec<u8>,
    /// The board around the text: dots to each side.
    pub(super) margin: DVec2,
    /// The colour of the text.
    pub(super) ink: Colour,
    /// The colour of the board; `None` where it is transparent.
    pub(super) paper: Option<Colour>,
}

/// Returns columns and rows of a line of text: dots.
fn extent(text: &str) -> DVec2 {
    LINE * DVec2::new(text.chars().count() as f64, 1.0)
}

impl Sign {
    fn new(text: &str, corner: DVec3, right: DVec3, down: DVec3) -> Self {
        let mut columns = vec![0; extent(text).x as usize];
        for (column, row) in dots(text) {
            columns[column as usize] |= 1 << row;
        }
        Self {
            corner,
            right,
            down,
            columns,
            margin: DVec2::ONE,
            ink: WHITE,
            paper: Some(BLACK),
        }
    }

    /// Returns text that stands upright across a line of sight, 1 m from the place `from`, with
    /// dots of `dot` metres. Its middle is `lines` lines below the line of sight.
    pub(super) fn across(text: &str, from: DVec3, sight: DVec3, lines: f64, dot: f64) -> Self {
        let sight = ViewDirection::new(sight).unwrap_or(ViewDirection::FRONT);
        let basis = sight.basis();
        let (right, down) = (dot * basis.right, -dot * basis.up);
        let middle = 0.5 * extent(text) - DVec2::new(0.0, lines * LINE);
        let corner = from + basis.forward - middle.x * right - middle.y * down;
        Self::new(text, corner, right, down)
    }

    /// Moves a sign along the lines of sight from a place, to `factor` of its distance, at which it
    /// appears as large as before.
    pub(super) fn at_distance(mut self, from: DVec3, factor: f64) -> Self {
        self.corner = from + factor * (self.corner - from);
        self.right *= factor;
        self.down *= factor;
        self
    }

    /// Returns the point of the room at shares of the board's width and height: metres.
    fn point(&self, share: DVec2) -> DVec3 {
        let size = DVec2::new(self.columns.len() as f64, LINE);
        let dot = share * (size + 2.0 * self.margin) - self.margin;
        self.corner + dot.x * self.right + dot.y * self.down
    }

    /// Returns the colour that a line of sight meets; `None` beside the board or where it is
    /// transparent.
    fn colour(&self, from: DVec3, direction: DVec3) -> Option<Colour> {
        let normal = self.right.cross(self.down);
        let distance = (self.corner - from).dot(normal) / direction.dot(normal);
        if !(distance > 0.0) {
            return None;
        }
        let point = from + distance * direction - self.corner;
        let area = normal.length_squared();
        let x = point.cross(self.down).dot(normal) / area;
        let y = self.right.cross(point).dot(normal) / area;
        let dot = DVec2::new(x, y);
        let end = DVec2::new(self.columns.len() as f64, LINE) + self.margin;
        if !(dot.cmpge(-self.margin).all() && dot.cmplt(end).all()) {
            return None;
        }
        let column = (x >= 0.0 && y >= 0.0).then(|| self.columns.get(x as usize));
        let is_ink = column
            .flatten()
            .is_some_and(|rows| y < LINE && (rows >> y as u32) & 1 == 1);
        if is_ink { Some(self.ink) } else { self.paper }
    }
}

/// Returns how much of a pixel a line covers, 0 to 1, whose middle is `distance` pixels away.
pub(super) fn stroke(distance: f64, width: f64) -> f32 {
    (0.5 * (width + 1.0) - distance.abs()).clamp(0.0, width.min(1.0)) as f32
}

/// Mixes two colours; `part` of the second, 0 to 1.
pub(super) fn mixed(one: Colour, other: Colour, part: f32) -> Colour {
    std::array::from_fn(|channel| one[channel] + part * (other[channel] - one[channel]))
}
