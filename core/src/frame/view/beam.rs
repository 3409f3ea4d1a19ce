use glam::Vec3;

/// A projector's light: lines from a lens through the pixels of its picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Beam {
    /// The lens, from the dome's centre or the cylinder's point, along the room's axes: radii.
    pub lens: Vec3,
    /// Along the room's axes, from the lens towards what pixel (0, 0) lights, to its neighbour to the
    /// right, and to that below: all by one unit, such that the longest is about 1.
    pub first_pixel: Vec3,
    /// See [`first_pixel`](Self::first_pixel).
    pub column_step: Vec3,
    /// See [`first_pixel`](Self::first_pixel).
    pub row_step: Vec3,
    /// Columns and rows.
    pub size: [u32; 2],
}

#[cfg(test)]
mod tests {
    use super::super::{CylinderScreen, DomeError, DomePose, DomeScreen, View};
    use super::*;
    use core::f32::consts::PI;
    use glam::{Mat3, Vec2};

    /// 40 × 30 pixels, 1 wide and 0.75 high at distance 1, along −Z from a lens.
    fn beam(lens: Vec3) -> Beam {
        Beam {
            lens,
            first_pixel: Vec3::new(-0.4875, 0.3625, -1.0),
            column_step: 0.025 * Vec3::X,
            row_step: -0.025 * Vec3::Y,
            size: [40, 30],
        }
    }

    fn views(eye: Vec3) -> [View; 2] {
        let pose = DomePose {
            position: Vec3::new(1.0, 0.5, -2.0),
            room_from_capture: Mat3::IDENTITY,
        };
        let (radius, position) = (3.0, pose.position);
        let dome = DomeScreen {
            pose,
            radius,
            field_of_view: PI,
        };
        let cylinder = CylinderScreen {
            pose,
            radius,
            angle: PI,
            heights: [-2.0, 2.0],
        };
        [
            View::dome_screen(dome, position + eye, 64).unwrap(),
            View::cylinder_screen(cylinder, position + eye, [64, 32]).unwrap(),
        ]
    }

    #[test]
    fn rays_go_to_what_pixels_light() {
        let eye = Vec3::new(0.4, 0.3, 0.9);
        // A lens inside and one outside, whose light comes through the opening.
        for lens in [Vec3::new(0.2, -0.1, 0.5), Vec3::new(0.1, 0.05, 1.4)] {
            for (view, is_cylinder) in views(eye).into_iter().zip([false, true]) {
                let view = view.lit_by(beam(lens)).unwrap();
                assert_eq!((view.columns(), view.rows()), (40, 30));
                for (x, y) in [(0.0, 0.0), (39.0, 29.0), (17.0, 21.0), (20.5, 3.25)] {
                    // A place on the ray at which the light from the lens arrives.
                    let towards = view.direction(x, y).unwrap().normalize();
                    let lit = beam(lens);
                    let line = lit.first_pixel + x * lit.column_step + y * lit.row_step;
                    let from_eye = 3.0 * (lens + -eye / 3.0);
                    let normal = line.cross(from_eye).cross(line);
                    let distance = from_eye.dot(normal) / towards.dot(normal);
                    let place = (eye + distance * towards) / 3.0;
                    let miss = (place - lens).cross(line.normalize()).length();
                    let radius = if is_cylinder {
                        Vec2::new(place.x, place.z).length()
                    } else {
                        place.length()
                    };
                    assert!(miss < 1.0e-5, "{lens} {x} {y}: {miss}");
                    assert!((radius - 1.0).abs() < 1.0e-5, "{lens} {x} {y}: {radius}");
                    assert!((place - lens).dot(line) > 0.0);
                }
            }
        }
    }

    #[test]
    fn a_view_that_is_moved_has_its_rays_moved() {
        let eye = Vec3::new(0.4, 0.3, 0.9);
        let flat = View::new(eye, Vec3::NEG_Z, 0.1 * Vec3::X, -0.1 * Vec3::Y, [40, 30]);
        let [dome, cylinder] = views(eye);
        let lit = [dome, cylinder].map(|view| view.lit_by(beam(0.5 * Vec3::Z)).unwrap());
        let (angle, by) = (2.5_f32, Vec3::new(7.0, -2.0, 30.0));
        let turn = Mat3::from_rotation_y(angle);
        for view in [flat.unwrap(), dome, cylinder, lit[0], lit[1]] {
            let moved = view.moved([angle.sin(), angle.cos()], by);
            assert!((moved.eye() - (turn * view.eye() + by)).length() < 1.0e-5);
            for (x, y) in [(31.0, 14.0), (12.0, 21.0), (20.5, 3.25)] {
                let [before, after] = [view, moved].map(|view| view.direction(x, y));
                let miss = (turn * before.unwrap()).angle_between(after.unwrap());
                assert!(miss < 1.0e-3, "{view:?} {x} {y}: {miss}");
            }
        }
    }

    #[test]
    fn beams_that_light_nothing_are_refused() {
        let [dome, _] = views(Vec3::ZERO);
        let lens = Vec3::new(0.0, 0.0, 0.5);
        let with = |change: fn(&mut Beam)| {
            let mut beam = beam(lens);
            change(&mut beam);
            dome.lit_by(beam)
        };
        for refused in [
            with(|beam| beam.row_step = beam.column_step),
            with(|beam| beam.first_pixel.x = f32::NAN),
            with(|beam| beam.lens.z = 101.0),
            with(|beam| beam.lens.z = f32::NAN),
            View::new(lens, Vec3::NEG_Z, Vec3::X, Vec3::Y, [2; 2])
                .unwrap()
                .lit_by(beam(lens)),
        ] {
            assert_eq!(refused, Err(DomeError::Beam));
        }
        let size = with(|beam| beam.size = [40, 0]);
        assert_eq!(size, Err(DomeError::Size { size: 0 }));
    }
}
