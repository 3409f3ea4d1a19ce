use super::DomePose;

/// A cylinder screen: the inside of a part of a cylinder. The picture's columns are at equal angles
/// about its axis, its rows at equal heights.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CylinderScreen {
    /// A point of the axis and the cylinder's axes: to the right of the picture's middle, along the
    /// axis to the picture's top, and from the middle towards the axis.
    pub pose: DomePose,
    /// Radius: metres, within [`DomeScreen::RADII`](super::DomeScreen::RADII).
    pub radius: f32,
    /// Angle across the picture: radians, above 0 to 2π.
    pub angle: f32,
    /// The lower and the upper edge's height over the pose's point: metres, within
    /// [`CylinderScreen::HIGHEST`].
    pub heights: [f32; 2],
}

impl CylinderScreen {
    /// Greatest distance of an edge or an eye from the pose's point: radii.
    pub const HIGHEST: f32 = 100.0;
}

#[cfg(test)]
mod tests {
    use super::super::{DomeError, View};
    use super::*;
    use core::f32::consts::{FRAC_PI_2, PI};
    use glam::{Mat3, Vec3};

    fn screen() -> CylinderScreen {
        CylinderScreen {
            pose: DomePose {
                position: Vec3::new(0.5, 0.0, -1.0),
                room_from_capture: Mat3::IDENTITY,
            },
            radius: 3.0,
            angle: PI,
            heights: [0.5, 2.5],
        }
    }

    #[test]
    fn pixels_lie_at_equal_angles_and_heights() {
        let eye = Vec3::new(0.7, 1.5, 0.0);
        let view = View::cylinder_screen(screen(), eye, [90, 40]).unwrap();
        assert_eq!((view.columns(), view.rows(), view.eye()), (90, 40, eye));
        for (x, y) in [(0, 0), (89, 0), (44, 20), (13, 39), (70, 7)] {
            let (column, row) = (x as f32, y as f32);
            let angle = (column + 0.5) / 90.0 * PI - FRAC_PI_2;
            let around = Vec3::new(libm::sinf(angle), 0.0, -libm::cosf(angle));
            let height = 2.5 - (row + 0.5) / 40.0 * 2.0;
            let point = Vec3::new(0.5, height, -1.0) + 3.0 * around;
            let direction = view.direction(column, row).unwrap();
            let apart = (direction.normalize() - (point - eye).normalize()).length();
            assert!(apart < 1.0e-6, "{x} {y}: {apart}");
        }
    }

    #[test]
    fn what_is_no_screen_and_no_eye_of_one_is_refused() {
        let centre = screen().pose.position;
        let eye = |offset: Vec3| View::cylinder_screen(screen(), centre + offset, [8, 4]);
        assert!(eye(Vec3::new(2.96, 7.0, 0.0)).is_ok());
        for outside in [2.98 * Vec3::X, 3.0 * Vec3::Z, 301.0 * Vec3::Y, Vec3::NAN] {
            assert!(matches!(eye(outside), Err(DomeError::Eye { .. })));
        }
        let with = |change: fn(&mut CylinderScreen)| {
            let mut screen = screen();
            change(&mut screen);
            View::cylinder_screen(screen, centre, [8, 4])
        };
        let radius = with(|screen| screen.radius = 0.0);
        assert!(matches!(radius, Err(DomeError::ScreenRadius { .. })));
        let angle = with(|screen| screen.angle = 6.3);
        assert!(matches!(angle, Err(DomeError::FieldOfView { .. })));
        for heights in [
            with(|s| s.heights = [1.0, 1.0]),
            with(|s| s.heights[0] = -400.0),
        ] {
            assert!(matches!(heights, Err(DomeError::Heights { .. })));
        }
        let rows = View::cylinder_screen(screen(), centre, [8, 0]);
        assert!(matches!(rows, Err(DomeError::Size { size: 0 })));
    }
}
