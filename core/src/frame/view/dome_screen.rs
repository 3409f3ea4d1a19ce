use super::DomePose;

/// A dome screen: the inside of a sphere, up to half the field of view from its zenith. The picture is
/// equidistant as seen from the sphere's centre: the distance of a pixel from the picture's is the
/// angle from the zenith.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DomeScreen {
    /// The sphere's centre and the dome's axes.
    pub pose: DomePose,
    /// Radius of the sphere: metres, within [`DomeScreen::RADII`].
    pub radius: f32,
    /// Angle of the screen from the centre, across the picture: radians, above 0 to
    /// 2π; π is a hemisphere.
    pub field_of_view: f32,
}

impl DomeScreen {
    /// Least and greatest radius: metres.
    pub const RADII: (f32, f32) = (1.0e-3, 1.0e6);

    /// Greatest distance of an eye from the centre: radii. Farther out, rounding
    /// would decide where a pixel is.
    pub const FARTHEST_EYE: f32 = 0.99;
}

#[cfg(test)]
mod tests {
    use super::super::{DomeError, View};
    use super::*;
    use core::f32::consts::PI;
    use glam::Vec3;

    #[test]
    fn what_is_no_screen_and_no_eye_of_one_is_refused() {
        let centre = Vec3::new(0.5, -1.5, 2.0);
        let screen = DomeScreen {
            pose: DomePose::over_room(centre),
            radius: 2.5,
            field_of_view: 1.25 * PI,
        };
        let eye = |offset: Vec3| View::dome_screen(screen, centre + offset, 64);
        assert!(eye(2.47 * Vec3::X).is_ok());
        for outside in [2.48 * Vec3::X, 3.0 * Vec3::Y, Vec3::splat(f32::NAN)] {
            assert!(matches!(eye(outside), Err(DomeError::Eye { .. })));
        }
        for radius in [0.0, -2.5, 1.0e7, f32::NAN] {
            let none = View::dome_screen(DomeScreen { radius, ..screen }, centre, 64);
            assert!(matches!(none, Err(DomeError::ScreenRadius { .. })));
        }
    }
}
