use super::super::walls::cube;
use super::*;
use crate::cave::{BuiltInCave, Cave};
use std::f64::consts::FRAC_PI_2;
#[test]
fn the_nearest_wall_hides_the_others() {
    let [front] = cube(["front"]);
    let mut near = front.clone();
    near.lower_left *= 0.5;
    near.lower_right *= 0.5;
    near.upper_left *= 0.5;
    let white = Picture::from_pixels(1, 1, vec![[1.0; 4]]).unwrap();
    let black = Picture::from_pixels(1, 1, vec![[0.0, 0.0, 0.0, 1.0]]).unwrap();
    let camera = ViewerCamera::new(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, FRAC_PI_2, [3, 3]).unwrap();
    let mut pairs = [(&near, &white), (&front, &black)];
    for _ in 0..2 {
        let view = render(&camera, &pairs).unwrap();
        assert!(view.pixels.iter().all(|pixel| *pixel == [1.0; 4]));
        pairs.reverse();
    }
}

#[test]
fn impossible_cameras_and_walls_are_refused() {
    let (zero, size) = (DVec3::ZERO, [8, 8]);
    let ahead = DVec3::NEG_Z;
    for (eye, forward, up, field_of_view, size, message) in [
        (zero, zero, DVec3::Y, 1.0, size, "view direction"),
        (zero, DVec3::NAN, DVec3::Y, 1.0, size, "view direction"),
        (zero, DVec3::INFINITY, DVec3::Y, 1.0, size, "view direction"),
        (zero, ahead, zero, 1.0, size, "up direction"),
        (zero, ahead, DVec3::NAN, 1.0, size, "up direction"),
        (zero, ahead, -3.0 * DVec3::Z, 1.0, size, "up direction"),
        (zero, ahead, DVec3::Y, 0.0, size, "field of view"),
        (zero, ahead, DVec3::Y, PI, size, "field of view"),
        (zero, ahead, DVec3::Y, f64::NAN, size, "field of view"),
        (zero, ahead, DVec3::Y, 1.0, [0, 8], "0 × 8 pixels"),
        (zero, ahead, DVec3::Y, 1.0, [8, 0], "8 × 0 pixels"),
        (DVec3::NAN, ahead, DVec3::Y, 1.0, size, "the viewer's eye"),
    ] {
        let camera = ViewerCamera::new(eye, forward, up, field_of_view, size);
        let error = camera.unwrap_err().to_string();
        assert!(error.contains(message), "{error}");
    }
    let cave = Cave::built_in(BuiltInCave::Cube, [1; 2]).unwrap();
    let mut flat = cave.walls[0].clone();
    flat.upper_left = flat.lower_left;
    let picture = Picture::new(1, 1).unwrap();
    let camera = ViewerCamera::new(zero, ahead, DVec3::Y, 1.0, [2, 2]).unwrap();
    let error = render(&camera, &[(&flat, &picture)]).unwrap_err();
    assert!(
        error.to_string().contains(&format!("{:?}", flat.name)),
        "{error}"
    );
}
