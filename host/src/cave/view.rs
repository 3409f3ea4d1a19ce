//! A wall as one eye sees it: rays through its pixels.

use super::{RoomError, Wall, is_in_a_room};
use glam::DVec3;
use shisen_core::frame::{FlatScreen, View};

impl Wall {
    /// Returns the rays from an eye at `eye` (metres, in the room) through the wall's pixels:
    /// computed in f64 and rounded once.
    ///
    /// # Errors
    /// A wall that [`Self::validate`] rejects; an eye that is not finite or
    /// farther than [`Self::FARTHEST`] out, not at least [`Self::CLOSEST`]
    /// before the wall's plane, or whose rays f32 cannot hold.
    pub fn view_from(&self, eye: DVec3) -> Result<View, RoomError> {
        self.check_eye(eye)?;
        let [first_pixel, column_step, row_step] = self.grid();
        let steps = [first_pixel - eye, column_step, row_step].map(DVec3::as_vec3);
        let [first_pixel, column_step, row_step] = steps;
        let view = View::new(
            eye.as_vec3(),
            first_pixel,
            column_step,
            row_step,
            self.pixels,
        );
        view.map_err(|fault| {
            RoomError::new(
                "eye",
                format!("wall \"{}\" cannot be traced: {fault}", self.name),
                "move the head away from the wall's plane, to the side that it is seen from",
            )
        })
    }

    /// Returns the wall as firmware has it: for any eye, in f32.
    pub fn flat_screen(&self) -> FlatScreen {
        let [first_pixel, column_step, row_step] = self.grid().map(DVec3::as_vec3);
        FlatScreen {
            first_pixel,
            column_step,
            row_step,
            size: self.pixels,
        }
    }

    /// Returns the centre of pixel (0, 0), and the steps to its neighbours to the right and below.
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
            "move the head in front of the wall; if it already is, the corners were given as seen \
             from behind: exchange left and right",
        ))
    }
}
