//! A wall as one eye sees it: rays through its pixels.

use super::{RoomError, Wall, is_in_a_room};
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

impl Wall {
    /// The wall as an eye at `eye` (metres, in the room) sees it.
    ///
    /// # Errors
    /// A wall that [`Self::validate`] rejects; an eye that is not finite or
    /// farther than [`Self::FARTHEST`] out, or not at least
    /// [`Self::CLOSEST`] before the wall's plane.
    pub fn view_from(&self, eye: DVec3) -> Result<WallView, RoomError> {
        self.check_eye(eye)?;
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

    /// Refuses an eye that is not [`Self::CLOSEST`] before the wall's plane.
    fn check_eye(&self, eye: DVec3) -> Result<(), RoomError> {
        self.validate()?;
        if !is_in_a_room(eye) {
            return Err(RoomError::new(
                "eye",
                format!(
                    "wall \"{}\" cannot be seen from {}, {}, {}",
                    self.name, eye.x, eye.y, eye.z
                ),
                format!(
                    "the eye's coordinates are metres from -{0} to {0}",
                    Self::FARTHEST
                ),
            ));
        }
        let normal = self.across().normalize().cross(self.upward().normalize());
        let distance = (eye - self.lower_left).dot(normal.normalize());
        if distance > Self::CLOSEST {
            return Ok(());
        }
        let place = if distance < -Self::CLOSEST {
            format!("{:.6} m behind its plane", -distance)
        } else {
            "in its plane".to_owned()
        };
        Err(RoomError::new(
            "eye",
            format!(
                "wall \"{}\" does not face the eye at {:.4}, {:.4}, {:.4}: the eye is {place}",
                self.name, eye.x, eye.y, eye.z
            ),
            "move the head before the wall; if it is there, the wall's corners are given as seen \
             from behind: exchange left and right",
        ))
    }
}
