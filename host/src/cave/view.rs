//! A wall as one eye sees it: rays through its pixels, and the frustum.

use super::{Wall, WallError, is_in_a_room};
use glam::DVec3;
use shisen_core::frame::FlatScreen;

/// The rays from an eye through the pixels of a wall.
///
/// The ray through the centre of pixel (x, y) starts at `eye` and runs along
/// `first_pixel + x * column_step + y * row_step`, which ends on the wall.
/// Everything is computed in f64 and rounded once.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WallView {
    /// Metres, in the room.
    pub eye: [f32; 3],
    /// From the eye to the centre of pixel (0, 0), metres.
    pub first_pixel: [f32; 3],
    /// From a pixel to its right-hand neighbour, metres.
    pub column_step: [f32; 3],
    /// From a pixel to the one below it, metres.
    pub row_step: [f32; 3],
    /// Pixels in a row.
    pub columns: u32,
    /// Pixels in a column.
    pub rows: u32,
}

/// An off-axis viewing frustum, as `glFrustum` takes it: the near plane's
/// rectangle in the axes of the wall, from the foot of the eye's
/// perpendicular. Metres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Frustum {
    /// Left edge; to the right is positive.
    pub left: f64,
    /// Right edge.
    pub right: f64,
    /// Lower edge; upwards is positive.
    pub bottom: f64,
    /// Upper edge.
    pub top: f64,
    /// From the eye to the near plane, above 0.
    pub near: f64,
}

impl Wall {
    /// Largest cosine of the angle between the edges of a rectangle: half a
    /// millimetre on 5 m, which is as well as corners are measured.
    const LARGEST_SKEW: f64 = 1.0e-4;

    /// The wall as an eye at `eye` (metres, in the room) sees it.
    ///
    /// # Errors
    /// A wall that [`Self::validate`] rejects; an eye that is not finite or
    /// farther than [`Self::FARTHEST`] out, or not at least
    /// [`Self::CLOSEST`] before the wall's plane.
    pub fn view_from(&self, eye: DVec3) -> Result<WallView, WallError> {
        self.distance_before(eye)?;
        let [columns, rows] = self.pixels;
        let [first_pixel, column_step, row_step] = self.grid();
        Ok(WallView {
            eye: eye.as_vec3().to_array(),
            first_pixel: (first_pixel - eye).as_vec3().to_array(),
            column_step: column_step.as_vec3().to_array(),
            row_step: row_step.as_vec3().to_array(),
            columns,
            rows,
        })
    }

    /// The wall as firmware has it: for any eye, in f32.
    pub fn flat_screen(&self) -> FlatScreen {
        let [first_pixel, column_step, row_step] = self.grid().map(DVec3::as_vec3);
        FlatScreen {
            first_pixel,
            column_step,
            row_step,
            size: self.pixels,
        }
    }

    /// The centre of pixel (0, 0), and the steps to its neighbours to the right and below.
    fn grid(&self) -> [DVec3; 3] {
        let [columns, rows] = self.pixels.map(f64::from);
        let column_step = self.across() / columns;
        let row_step = -self.upward() / rows;
        let first_pixel = self.upper_left + 0.5 * (column_step + row_step);
        [first_pixel, column_step, row_step]
    }

    /// The off-axis frustum of an eye at `eye` (metres, in the room) with
    /// its near plane at `near` metres: Kooima, "Generalized Perspective
    /// Projection" (2008).
    ///
    /// # Errors
    /// As [`Self::view_from`]; besides, a wall whose edges are not at right
    /// angles, and a `near` that is not above 0 and at most
    /// [`Self::FARTHEST`].
    pub fn frustum(&self, eye: DVec3, near: f64) -> Result<Frustum, WallError> {
        let distance = self.distance_before(eye)?;
        if !(near > 0.0 && near <= Self::FARTHEST) {
            return Err(WallError::Near {
                wall: self.name.clone(),
                near,
            });
        }
        let right = self.across().normalize();
        let up = self.upward().normalize();
        let cosine = right.dot(up);
        if cosine.abs() > Self::LARGEST_SKEW {
            return Err(WallError::NotRectangular {
                wall: self.name.clone(),
                degrees: libm::acos(cosine.clamp(-1.0, 1.0)).to_degrees(),
            });
        }
        let scale = near / distance;
        Ok(Frustum {
            left: right.dot(self.lower_left - eye) * scale,
            right: right.dot(self.lower_right - eye) * scale,
            bottom: up.dot(self.lower_left - eye) * scale,
            top: up.dot(self.upper_left - eye) * scale,
            near,
        })
    }

    /// How far `eye` is before the wall's plane, metres, above
    /// [`Self::CLOSEST`].
    fn distance_before(&self, eye: DVec3) -> Result<f64, WallError> {
        self.validate()?;
        if !is_in_a_room(eye) {
            return Err(WallError::Eye {
                wall: self.name.clone(),
                eye,
            });
        }
        let normal = self.across().normalize().cross(self.upward().normalize());
        let distance = (eye - self.lower_left).dot(normal.normalize());
        if distance <= Self::CLOSEST {
            return Err(WallError::Behind {
                wall: self.name.clone(),
                eye,
                distance,
            });
        }
        Ok(distance)
    }
}
