//! Rooms that cannot be used, and light that meets a dome.

use super::*;
use crate::files::description::tests::check_faults;
use glam::DVec2;
use shisen_core::frame::View;

fn oblique_wall() -> Wall {
    Wall::new(
        "oblique",
        DVec3::new(-1.0, -0.5, -2.0),
        DVec3::new(1.4, -0.5, -3.8),
        DVec3::new(-1.0, 1.3, -2.0),
        [31, 17],
    )
    .unwrap()
}

fn direction(view: &View, x: u32, y: u32) -> DVec3 {
    view.direction(x as f32, y as f32).unwrap().as_dvec3()
}

#[test]
fn rays_end_at_pixel_centres_on_an_oblique_wall() {
    let wall = oblique_wall();
    let eye = DVec3::new(0.3, 0.2, 0.9);
    let view = wall.view_from(eye).unwrap();
    for (x, y) in [(0, 0), (30, 0), (0, 16), (30, 16), (12, 5)] {
        let hit = eye + direction(&view, x, y);
        let expected = wall.upper_left + (f64::from(x) + 0.5) / 31.0 * wall.across()
            - (f64::from(y) + 0.5) / 17.0 * wall.upward();
        assert!((hit - expected).length() < 2e-6, "pixel {x}, {y}: {hit}");
    }
}

#[test]
fn eyes_in_or_behind_the_plane_are_named_with_the_wall() {
    let cave = Cave::built_in(BuiltInCave::ThreeWall, [2, 2]).unwrap();
    let front = &cave.walls[0];
    assert!(front.view_from(DVec3::new(0.0, 0.0, -1.499_99)).is_ok());
    for z in [-1.5, -1.499_999_5, -1.500_000_5, -2.0] {
        let error = front.view_from(DVec3::new(0.0, 0.0, z)).unwrap_err();
        assert!(error.to_string().contains("\"front\""), "{error}");
    }
    let error = front.view_from(DVec3::NAN).unwrap_err();
    assert!(error.to_string().contains("cannot be seen from"), "{error}");
}

#[test]
fn names_and_corners_that_no_file_can_have_are_rejected() {
    let good = &Cave::built_in(BuiltInCave::ThreeWall, [4; 2])
        .unwrap()
        .walls[0];
    let far = Wall {
        upper_left: DVec3::splat(1e300),
        ..good.clone()
    };
    let error = far.validate().unwrap_err().to_string();
    assert!(error.contains("upper left corner"), "{error}");
    let long = "x".repeat(101);
    for name in ["", "..", "a/b", "a\\b", "a\n", " a", "a.", "c:", "*", &long] {
        let name = name.into();
        let wall = Wall {
            name,
            ..good.clone()
        };
        let error = wall.validate().unwrap_err().to_string();
        assert!(error.starts_with("the wall name"), "{error}");
    }
}

const ROOM: &str = r#"
[[wall]]
name = "front"
lower_left = [-1, -1, -1]
lower_right = [1, -1, -1]
upper_left = [-1, 1, -1]

[[wall]]
name = "floor"
lower_left = [-1.0, -1.0, 1.0]
lower_right = [1.0, -1.0, 1.0]
upper_left = [-1.0, -1.0, -1.0]
pixels = [640, 480]

[[dome]]
name = "sky"
radius = 2.5
centre = [0, -1.0, 0.5]
tilt_degrees = 30
field_of_view_degrees = 200
size = 1640

[[dome]]
name = "small"
radius = 1
centre = [0, 0, 0]

[[cylinder]]
name = "curve"
radius = 3
centre = [0, 0, 0.25]
azimuth_degrees = [-80, 70]
height = [-1, 1.5]
pixels = [300, 80]
"#;

#[test]
fn walls_and_domes_come_from_toml() {
    let cave = Cave::from_toml(ROOM, "room.toml", [100, 50]).unwrap();
    let names: Vec<&str> = cave.screens().map(Screen::name).collect();
    assert_eq!(names, ["front", "floor", "sky", "small", "curve"]);
    let pixels = [0, 1].map(|i| cave.walls[i].pixels);
    assert_eq!(pixels, [[100, 50], [640, 480]]);
    let [sky, small] = [0, 1].map(|i| &cave.domes[i]);
    assert_eq!((sky.radius, sky.size, small.size), (2.5, 1640, 100));
    assert_eq!(sky.centre, DVec3::new(0.0, -1.0, 0.5));
    assert_eq!(small.field_of_view(), std::f64::consts::PI);
    assert_eq!(small.axes().z_axis, DVec3::NEG_Y);
}

/// As `check_faults` reads them.
const FAULTS: &str = r#"
"floor" | "Front" | two walls
[640, 480] | [640, 0] | 640 × 0
pixels | pixel | unknown key `pixel`
upper_left = [-1, 1, -1] | | upper_left | [[wall]]
[-1, 1, -1] | [-1, -1, -1] | no height
[-1, 1, -1] | [-1, nan, -1] | upper left corner
[-1, 1, -1] | [3, -1, -1] | on one line
[1, -1, -1] | [-1, -1, -1] | no width
"sky" | "FLOOR" | as another screen
"small" | "Sky" | as another screen
2.5 | 0 | radius of 0 m
2.5 | 1e7 | radius of 10000000 m
[0, -1.0, 0.5] | [0, inf, 0.5] | inf
30 | 361 | tilted by 361°
200 | 0 | field of view of 0°
200 | 360.5 | field of view of 360.5°
1640 | 0 | 0 × 0
1640 | 16385 | 16385 × 16385
radius = 1 | | radius | *
"curve" | "Sky" | as another screen
[-80, 70] | [70, -80] | from 70° to -80°
[-80, 70] | [-360, 1] | from -360° to 1°
[-1, 1.5] | [1, 1] | from 1 m to 1 m
[-1, 1.5] | [-1, nan] | NaN m
[300, 80] | [0, 80] | 0 × 80
radius = 3 | radius = 0 | radius of 0 m
"#;

#[test]
fn faults_in_toml_point_at_their_line() {
    check_faults(ROOM, FAULTS, |text| {
        Cave::from_toml(text, "room.toml", [9, 9])
    });
    let error = Cave::from_toml("", "room.toml", [9, 9]).unwrap_err();
    assert!(error.to_string().contains("no walls and no domes") && error.line().is_none());
}

#[test]
fn light_comes_through_the_opening_and_not_through_the_dome() {
    let dome = &Cave::built_in(BuiltInCave::Dome, [8; 2]).unwrap().domes[0];
    let below = DVec3::new(0.0, -3.0, 0.0);
    assert_eq!(dome.lit(below, DVec3::Y), Some(DVec2::ZERO));
    let above = DVec3::new(0.0, 3.0, 0.0);
    assert_eq!(dome.lit(above, DVec3::NEG_Y), None);
    assert!(dome.meet(above, DVec3::NEG_Y).is_some());
    // Down through the opening, past, and from a lamp on the rim.
    assert_eq!(dome.lit(DVec3::ZERO, DVec3::NEG_Y), None);
    assert_eq!(dome.lit(above, DVec3::X), None);
    let rim = DVec3::new(2.5, -1.5, 0.0);
    let across = dome.lit(rim, DVec3::new(-1.0, 1.0, 0.0).normalize());
    assert!(across.unwrap().length() < 1e-14, "{across:?}");
}

#[test]
fn rays_end_at_pixel_centres_on_a_cylinder() {
    let cave = Cave::from_toml(ROOM, "room.toml", [9, 9]).unwrap();
    let (cylinder, eye) = (&cave.cylinders[0], DVec3::new(0.4, 0.3, 1.0));
    let view = cylinder.view_from(eye).unwrap();
    for (x, y) in [(0, 0), (299, 0), (0, 79), (133, 40), (290, 71)] {
        let place = (DVec2::new(f64::from(x), f64::from(y)) + 0.5) / DVec2::new(300.0, 80.0);
        let point = cylinder.point(place);
        let apart = direction(&view, x, y).normalize() - (point - eye).normalize();
        assert!(apart.length() < 1e-6, "pixel {x}, {y}: {apart}");
        assert!(cylinder.place(point).unwrap().distance(place) < 1e-12);
        let met = cylinder.lit(eye, (point - eye).normalize()).unwrap();
        assert!(met.distance(place) < 1e-12, "pixel {x}, {y}: {met}");
    }
    // From outside and behind, and up along the axis.
    let (outside, inwards) = (DVec3::new(0.0, 0.5, -5.0), DVec3::Z);
    assert_eq!(cylinder.lit(outside, inwards), None);
    assert!(cylinder.meet(outside, inwards).is_some());
    assert_eq!(cylinder.lit(DVec3::ZERO, DVec3::Y), None);
    let error = cylinder.view_from(DVec3::new(3.2, 0.0, 0.0)).unwrap_err();
    assert!(
        error.to_string().contains("not inside cylinder \"curve\""),
        "{error}"
    );
}

#[test]
fn eyes_outside_a_dome_are_refused() {
    let cave = Cave::built_in(BuiltInCave::Dome, [8; 2]).unwrap();
    let at = |y: f64| cave.check_eye(DVec3::new(0.0, -1.5 + y, 0.0));
    assert_eq!(at(2.47), Ok(()));
    for y in [2.48, -2.6, f64::NAN, f64::INFINITY] {
        let error = at(y).unwrap_err();
        assert!(error.to_string().contains("not inside dome \"dome\""));
        let help = Diagnostic::help(&error).unwrap().to_string();
        assert!(help.contains("2.475"), "{help}");
    }
    for pixels in [0, Wall::MOST_PIXELS + 1] {
        let error = Cave::built_in(BuiltInCave::Dome, [pixels; 2]).unwrap_err();
        assert_eq!(error.key, "size");
    }
}
