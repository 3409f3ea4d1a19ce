use super::{View, ViewError};
use glam::Vec3;

/// A flat screen in its room: the places of its pixels, independent of the eye.
/// Metres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FlatScreen {
    /// The centre of pixel (0, 0).
    pub first_pixel: Vec3,
    /// From a pixel to its right-hand neighbour.
    pub column_step: Vec3,
    /// From a pixel to the one below it.
    pub row_step: Vec3,
    /// Columns and rows.
    pub size: [u32; 2],
}

impl FlatScreen {
    /// The least distance of an eye from the screen's plane, metres.
    pub const CLOSEST: f32 = 1.0e-6;

    /// Returns a screen by three of its corners, seen from its front side.
    pub fn from_corners(
        lower_left: Vec3,
        lower_right: Vec3,
        upper_left: Vec3,
        size: [u32; 2],
    ) -> Self {
        let [columns, rows] = size.map(|pixels| pixels as f32);
        let column_step = (lower_right - lower_left) / columns;
        let row_step = (lower_left - upper_left) / rows;
        Self {
            first_pixel: upper_left + 0.5 * (column_step + row_step),
            column_step,
            row_step,
            size,
        }
    }

    /// Returns the rays from an eye (metres, in the room) through its pixels, the same in a
    /// display controller as on a host.
    ///
    /// # Errors
    /// Those of [`View::new`]; an eye behind the screen or within [`Self::CLOSEST`] of its plane.
    pub fn view_from(&self, eye: Vec3) -> Result<View, ViewError> {
        let first_pixel = self.first_pixel - eye;
        // Points to the front side.
        let normal = self.row_step.cross(self.column_step).normalize_or_zero();
        if normal != Vec3::ZERO && !(-first_pixel.dot(normal) > Self::CLOSEST) {
            return Err(ViewError::Behind);
        }
        View::new(eye, first_pixel, self.column_step, self.row_step, self.size)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the front wall of a 3 m cube around the origin.
    fn front() -> FlatScreen {
        let corner = |x: f32, y: f32| 1.5 * Vec3::new(x, y, -1.0);
        let (left, right, upper) = (corner(-1.0, -1.0), corner(1.0, -1.0), corner(-1.0, 1.0));
        FlatScreen::from_corners(left, right, upper, [64, 32])
    }

    #[test]
    fn rays_go_through_the_centres_of_its_pixels() {
        let eye = Vec3::new(0.25, -0.5, 0.125);
        let view = front().view_from(eye).unwrap();
        assert_eq!((view.columns(), view.rows(), view.eye()), (64, 32, eye));
        for (x, y, place) in [
            (0.0, 0.0, [-1.5 + 1.5 / 64.0, 1.5 - 1.5 / 32.0, -1.5]),
            (63.0, 31.0, [1.5 - 1.5 / 64.0, -1.5 + 1.5 / 32.0, -1.5]),
            (-0.5, -0.5, [-1.5, 1.5, -1.5]),
        ] {
            let direction = view.direction(x, y).unwrap();
            assert_eq!(eye + direction, Vec3::from_array(place));
        }
    }

    #[test]
    fn it_is_seen_from_its_front_only() {
        let front = front();
        assert!(front.view_from(Vec3::Z * -1.4).is_ok());
        for z in [-1.5, -1.6, f32::NAN, f32::NEG_INFINITY] {
            assert_eq!(front.view_from(Vec3::Z * z), Err(ViewError::Behind), "{z}");
        }
    }
}
