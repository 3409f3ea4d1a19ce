use super::{Directions, OnePoint, View};
use crate::numeric::map3;
use crate::shape::Ray;
use crate::simd::{Lanes, Simd};
use glam::Vec3;

/// A map from pixels to directions: the rays of an off-axis frustum (Kooima 2008).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Screen {
    pub(crate) eye: Vec3,
    first_pixel: Vec3,
    column_step: Vec3,
    row_step: Vec3,
    pub(super) columns: u32,
    pub(super) rows: u32,
}

/// Why a flat screen has no view.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum ViewError {
    /// No columns or no rows, or more than [`View::MOST_PIXELS`] of either.
    #[error("a view has 1 to {} pixels a side", View::MOST_PIXELS)]
    Size,
    /// The eye is not finite or too far out.
    #[error("the eye's position is not finite or too far out")]
    Eye,
    /// A corner that cannot be traced, an eye in the plane, or parallel steps.
    #[error("the eye is in the screen's plane, or the screen has no area")]
    Screen,
    /// The eye is behind a [`FlatScreen`](super::FlatScreen) or in its plane.
    #[error("the eye is not in front of the screen")]
    Behind,
}

pub(crate) struct ScreenColumns<F> {
    /// Directions of the columns' pixels in the first row.
    tops: [F; 3],
    row_step: [F; 3],
    last_row: u32,
}

impl<F: Copy> ScreenColumns<F> {
    /// Returns [`Screen::direction`] for a row's pixels; pixels past the borders repeat the last.
    #[inline(always)]
    pub(crate) fn directions<L: Lanes<8, F = F>>(&self, l: L, y: u32, dy: f32) -> [F; 3] {
        let row = l.splat(y.min(self.last_row) as f32 + dy);
        map3([0, 1, 2], |axis: usize| {
            l.add(self.tops[axis], l.mul(self.row_step[axis], row))
        })
    }
}

impl Screen {
    pub(super) fn new(
        eye: Vec3,
        first_pixel: Vec3,
        column_step: Vec3,
        row_step: Vec3,
        size: [u32; 2],
    ) -> Result<Self, ViewError> {
        let [columns, rows] = size;
        let fits = |pixels: u32| (1..=View::MOST_PIXELS).contains(&pixels);
        if !fits(columns) || !fits(rows) {
            return Err(ViewError::Size);
        }
        if Ray::new(eye, Vec3::X).is_none() {
            return Err(ViewError::Eye);
        }
        let screen = Self {
            eye,
            first_pixel,
            column_step,
            row_step,
            columns,
            rows,
        };
        // A direction is no longer than the longest of the corners', and no shorter
        // than the distance of the plane.
        let corners = [(0, 0), (columns, 0), (0, rows), (columns, rows)];
        let normal = column_step.cross(row_step);
        let distance = first_pixel.dot(normal).abs();
        let traceable = corners
            .iter()
            .all(|&(x, y)| screen.direction(x as f32, y as f32).is_finite());
        if !traceable || !(distance > 0.0) || screen.ray(0.0, 0.0).is_none() {
            return Err(ViewError::Screen);
        }
        Ok(screen)
    }

    /// Returns the eye, the first pixel, and the steps of a column and of a row.
    pub(super) const fn vectors(&self) -> [Vec3; 4] {
        [self.eye, self.first_pixel, self.column_step, self.row_step]
    }

    /// Returns the screen with its eye after a turn and a move.
    pub(super) fn moved(&self, turned: impl Fn(Vec3) -> Vec3, by: Vec3) -> Self {
        Self {
            eye: turned(self.eye) + by,
            first_pixel: turned(self.first_pixel),
            column_step: turned(self.column_step),
            row_step: turned(self.row_step),
            ..*self
        }
    }

    /// Returns the direction of a point of the screen, in pixels from the centre of the first.
    #[inline(always)]
    pub(crate) fn direction(&self, x: f32, y: f32) -> Vec3 {
        (self.first_pixel + self.column_step * x) + self.row_step * y
    }

    /// Returns the directions of the corners of a part of the screen, from its first point to its
    /// last.
    pub(crate) fn corners_between(
        &self,
        (left, above): (f32, f32),
        (right, below): (f32, f32),
    ) -> [Vec3; 4] {
        [
            self.direction(left, above),
            self.direction(right, above),
            self.direction(left, below),
            self.direction(right, below),
        ]
    }

    /// Returns the ray through a point, in pixels from the first's centre, if it can be traced.
    #[inline(always)]
    pub(crate) fn ray(&self, x: f32, y: f32) -> Option<Ray> {
        Ray::new(self.eye, self.direction(x, y))
    }
}

impl OnePoint for Screen {
    type Columns<F: Copy> = ScreenColumns<F>;

    fn eye(&self) -> Vec3 {
        self.eye
    }

    #[inline(always)]
    fn towards(&self, x: f32, y: f32) -> Vec3 {
        self.direction(x, y)
    }

    /// Returns the positions of a row's columns from `x` on; the last one is repeated.
    #[inline(always)]
    fn columns_at<L: Lanes<8>>(&self, l: L, x: u32, dx: f32) -> ScreenColumns<L::F> {
        let mut columns = [0.0; 8];
        for (column, place) in (x..).zip(&mut columns) {
            *place = column.min(self.columns - 1) as f32 + dx;
        }
        let columns = l.load(&columns);
        let (first, step) = (self.first_pixel.to_array(), self.column_step.to_array());
        ScreenColumns {
            tops: map3([0, 1, 2], |axis: usize| {
                l.add(l.splat(first[axis]), l.mul(l.splat(step[axis]), columns))
            }),
            row_step: map3(self.row_step.to_array(), |step| l.splat(step)),
            last_row: self.rows - 1,
        }
    }

    #[inline(always)]
    fn towards_row<L: Lanes<8>>(
        &self,
        l: L,
        columns: &ScreenColumns<L::F>,
        y: u32,
        dy: f32,
    ) -> [L::F; 3] {
        columns.directions(l, y, dy)
    }

    fn corners(
        &self,
        _: Simd,
        first: (u32, u32),
        last: (u32, u32),
        (dx, dy): (f32, f32),
    ) -> [Vec3; 4] {
        let at = |(x, y): (u32, u32)| (x as f32 + dx, y as f32 + dy);
        self.corners_between(at(first), at(last))
    }
}

impl Directions for Screen {
    #[inline(always)]
    fn directions<L: Lanes<8>>(&self, l: L, place: (u32, u32)) -> [L::F; 3] {
        let (x, y) = place;
        self.columns_at(l, x, 0.0).directions(l, y, 0.0)
    }

    #[inline]
    fn direction(&self, (x, y): (u32, u32)) -> Vec3 {
        let (x, y) = (x.min(self.columns - 1), y.min(self.rows - 1));
        self.direction(x as f32, y as f32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_screen_is_refused() {
        let (eye, first, down) = (Vec3::ZERO, Vec3::new(-0.5, 0.5, -1.0), Vec3::NEG_Y);
        let in_plane = Vec3::new(-0.5, 0.5, 0.0);
        for (eye, first, down, size, expected) in [
            (eye, first, down, [2, 2], Ok(())),
            (eye, first, down, [0, 2], Err(ViewError::Size)),
            (eye, first, down, [2, 65_537], Err(ViewError::Size)),
            (Vec3::NAN, first, down, [2, 2], Err(ViewError::Eye)),
            (eye, in_plane, down, [2, 2], Err(ViewError::Screen)),
            (eye, Vec3::INFINITY, down, [2, 2], Err(ViewError::Screen)),
            (eye, first, Vec3::X, [2, 2], Err(ViewError::Screen)),
        ] {
            let made = View::new(eye, first, Vec3::X, down, size);
            assert_eq!(made.map(drop), expected);
        }
    }
}
