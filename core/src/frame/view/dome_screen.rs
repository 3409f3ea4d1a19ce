use super::DomePose;

/// A dome's inside that a dome master is shown on: the part of a sphere within
/// half of the field of view around its zenith. The picture is equidistant as
/// seen from the sphere's centre: the distance of a pixel from the picture's is
/// the angle between zenith and its place on the dome.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DomeScreen {
    /// Where the sphere's centre is and which way the dome points.
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

    /// Farthest that an eye may be from the centre: radii. Past it a pixel's
    /// place would be a matter of rounding.
    pub const FARTHEST_EYE: f32 = 0.99;
}

#[cfg(test)]
mod tests {
    use super::super::{DomeError, DomeProjection, View};
    use super::*;
    use core::f32::consts::PI;
    use glam::{EulerRot, Mat3, Vec3};

    // Fewer under Miri, which is slow.
    const SIZE: u32 = if cfg!(miri) { 8 } else { 64 };
    const STEP: usize = if cfg!(miri) { 13 } else { 1 };

    fn screen() -> DomeScreen {
        DomeScreen {
            pose: DomePose {
                position: Vec3::new(0.5, -1.5, 2.0),
                room_from_capture: Mat3::from_euler(EulerRot::XYZ, 0.3, -1.1, 2.0),
            },
            radius: 2.5,
            field_of_view: 1.25 * PI,
        }
    }

    #[test]
    fn rays_from_the_centre_are_the_dome_masters() {
        let screen = screen();
        let centre = screen.pose.position;
        let view = View::dome_screen(screen, centre, SIZE).unwrap();
        let field_of_view = screen.field_of_view;
        let lens = DomeProjection::Equidistant { field_of_view };
        let master = View::dome(lens, screen.pose, SIZE).unwrap();
        for at in (0..SIZE * SIZE)
            .step_by(STEP)
            .map(|i| ((i % SIZE) as f32, (i / SIZE) as f32))
        {
            assert_eq!(view.ray(at.0, at.1), master.ray(at.0, at.1), "{at:?}");
        }
    }

    #[test]
    fn what_is_no_screen_and_no_eye_of_one_is_refused() {
        let screen = screen();
        let centre = screen.pose.position;
        let eye = |offset: Vec3| View::dome_screen(screen, centre + offset, SIZE);
        assert!(eye(2.47 * Vec3::X).is_ok());
        for outside in [2.48 * Vec3::X, 3.0 * Vec3::Y, Vec3::splat(f32::NAN)] {
            assert!(matches!(eye(outside), Err(DomeError::Eye { .. })));
        }
        for radius in [0.0, -2.5, 1.0e7, f32::NAN] {
            let none = View::dome_screen(DomeScreen { radius, ..screen }, centre, SIZE);
            assert!(matches!(none, Err(DomeError::ScreenRadius { .. })));
        }
    }
}
