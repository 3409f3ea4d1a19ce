use super::*;
use crate::files::description::tests::check_faults;

const PROJECTOR: &str = r#"
name = "back"
position = [0.2, -1.2, 2]
look = [0, 0.6, -1]
up = [0, 1, 0]
horizontal_degrees = 60
lens_shift = [0.1, 0.5]
resolution = [1920, 1200]
"#;

fn lens(text: &str) -> Lens {
    let projector = Projector::from_toml(text, "back.toml").unwrap();
    *projector.lens().unwrap()
}

#[test]
fn a_picture_is_as_wide_as_its_lens_throws_it_and_shifted() {
    let level = PROJECTOR
        .replace("look = [0, 0.6, -1]", "look = [0, 0, -3]")
        .replace("lens_shift = [0.1, 0.5]", "");
    let half = 30f64.to_radians().tan();
    // Square pixels.
    let tall = half * 1200.0 / 1920.0;
    let vertical = "vertical_degrees = 90\nresolution";
    let shift = "lens_shift = [0.25, 0.5]\nresolution";
    for (from, to, [x, y], expected) in [
        ("", "", [0.5, 0.5], [0.0, 0.0]),
        ("", "", [0.0, 0.5], [-half, 0.0]),
        ("", "", [0.5, 0.0], [0.0, tall]),
        (
            "horizontal_degrees = 60",
            "throw = 0.5",
            [1.0, 0.5],
            [1.0, 0.0],
        ),
        ("resolution", vertical, [0.5, 1.0], [0.0, -1.0]),
        // By half its height upwards: the lower edge is straight ahead.
        ("resolution", shift, [0.25, 1.0], [0.0, 0.0]),
        ("resolution", shift, [0.25, 0.0], [0.0, 2.0 * tall]),
    ] {
        let found = lens(&level.replacen(from, to, 1)).direction(DVec2::new(x, y));
        let expected = DVec3::new(expected[0], expected[1], -1.0).normalize();
        assert!(found.distance(expected) < 1e-14, "{to}: {found} {expected}");
    }
}

#[test]
fn angles_are_those_that_a_projector_is_turned_by() {
    for (yaw, pitch, roll) in [(-100.0, 40.0, 10.0), (170.0, -80.0, -60.0)] {
        let text = PROJECTOR
            .replace("look = [0, 0.6, -1]", &format!("yaw_degrees = {yaw:.1}"))
            .replace(
                "up = [0, 1, 0]",
                &format!("pitch_degrees = {pitch:.1}\nroll_degrees = {roll:.1}"),
            );
        let found = lens(&text).angles().map(f64::to_degrees);
        for (found, expected) in found.into_iter().zip([yaw, pitch, roll]) {
            assert!((found - expected).abs() < 1e-12, "{found} {expected}");
        }
    }
    // To the right, up, and the picture's right side down.
    let turned = |text: &str| {
        let text = PROJECTOR.replace("look = [0, 0.6, -1]", text);
        lens(&text.replace("up = [0, 1, 0]", "")).axes
    };
    assert_eq!(-turned("yaw_degrees = 90").z_axis, DVec3::X);
    assert_eq!(-turned("pitch_degrees = 90").z_axis, DVec3::Y);
    assert_eq!(turned("roll_degrees = 90").x_axis, DVec3::NEG_Y);
    let up = turned("look = [0, 5, 0]\nup = [0, 0, 1]");
    assert_eq!((-up.z_axis, up.y_axis), (DVec3::Y, DVec3::Z));
}

/// As `check_faults` reads them.
const FAULTS: &str = r#"
"back" | "a/b" | "a/b"
0.2 | nan | NaN
[0, 0.6, -1] | [0, 0, 0] | looks along 0, 0, 0
[0, 1, 0] | [0, 1.2, -2] | what is up
up = | yaw_degrees = 10 # | both of look
horizontal_degrees = 60 | horizontal_degrees = 180 | 180°
horizontal_degrees = 60 | throw = 0 | throw is 0
horizontal_degrees = 60 | | none of horizontal_degrees | -
lens_shift = [0.1, 0.5] | throw = 1.2 | both of horizontal
lens_shift = [0.1, 0.5] | vertical_degrees = 0 | vertical
[0.1, 0.5] | [0.1, 2.5] | shifted by 0.1, 2.5
[1920, 1200] | [1920, 0] | 1920 × 0
lens_shift | shift | unknown key `shift`
"#;

#[test]
fn faults_of_projectors_point_at_their_line() {
    check_faults(PROJECTOR, FAULTS, |text| {
        Projector::from_toml(text, "back.toml")
    });
    let angles = PROJECTOR.replace("look = [0, 0.6, -1]\nup = [0, 1, 0]", "yaw_degrees = 400");
    let error = Projector::from_toml(&angles, "back.toml").unwrap_err();
    assert_eq!(error.line(), Some(4), "{error}");
}
