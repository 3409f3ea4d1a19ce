use super::*;
use crate::cave::Wall;
use std::f64::consts::FRAC_PI_2;

/// Pixels along each side of a wall.
const PIXELS: u32 = 256;
/// Where the walls are painted for: off the cube's centre.
const EYE: DVec3 = DVec3::new(0.1, -0.15, 0.2);
/// The least distance from the eye to a wall of the cube from −1 to 1.
const LEAST_DISTANCE: f64 = 0.8;

fn wall(name: &str, lower_left: DVec3, lower_right: DVec3, upper_left: DVec3) -> Wall {
    Wall {
        name: name.to_owned(),
        lower_left,
        lower_right,
        upper_left,
        pixels: [PIXELS; 2],
    }
}

/// Front, right and floor of the cube from −1 to 1.
fn three_walls() -> [Wall; 3] {
    let at = DVec3::new;
    [
        wall(
            "front",
            at(-1.0, -1.0, -1.0),
            at(1.0, -1.0, -1.0),
            at(-1.0, 1.0, -1.0),
        ),
        wall(
            "right",
            at(1.0, -1.0, -1.0),
            at(1.0, -1.0, 1.0),
            at(1.0, 1.0, -1.0),
        ),
        wall(
            "floor",
            at(-1.0, -1.0, 1.0),
            at(1.0, -1.0, 1.0),
            at(-1.0, -1.0, -1.0),
        ),
    ]
}

/// A smooth colour for each direction, of slope at most 1.5 per radian.
fn colour(direction: DVec3) -> [f64; 3] {
    let axes = [
        DVec3::new(0.6, 0.8, 0.0),
        DVec3::new(0.0, 0.6, -0.8),
        DVec3::new(-0.8, 0.0, 0.6),
    ];
    axes.map(|axis| 0.5 + 0.5 * (3.0 * direction.normalize().dot(axis)).sin())
}

fn paint(wall: &Wall) -> Picture {
    let mut picture = Picture::new(PIXELS, PIXELS).unwrap();
    let count = f64::from(PIXELS);
    for y in 0..PIXELS {
        for x in 0..PIXELS {
            let along = (f64::from(x) + 0.5) / count;
            let up = 1.0 - (f64::from(y) + 0.5) / count;
            let point = wall.lower_left
                + along * (wall.lower_right - wall.lower_left)
                + up * (wall.upper_left - wall.lower_left);
            let [red, green, blue] = colour(point - EYE).map(|channel| channel as f32);
            picture.set_pixel(x, y, [red, green, blue, 1.0]);
        }
    }
    picture
}

/// Renders the three walls and compares each pixel with the function that
/// they were painted with. Returns how many pixels were interpolated, fell
/// within half a pixel of a wall's edge, and missed the walls.
fn compare(forward: DVec3, field_of_view: f64) -> [usize; 3] {
    let walls = three_walls();
    let pictures = walls.each_ref().map(paint);
    let pairs: Vec<_> = walls.iter().zip(&pictures).collect();
    let camera = ViewerCamera::new(EYE, forward, DVec3::Y, field_of_view, [301, 203]).unwrap();
    let view = render(&camera, &pairs).unwrap();

    let step = 2.0 / f64::from(PIXELS);
    // Bilinear interpolation is off by at most step² / 8 times the sum of the
    // second derivatives along the wall. Those of sin(3 d·a) / 2 are at most
    // 4.5 and 1.5 times the direction's own, 2, at distance 1.
    let bilinear = 2.0 * (4.5 + 3.0) / 8.0 * (step / LEAST_DISTANCE).powi(2) + 1e-7;
    // Beyond the outermost centres the nearest one stands for up to half a
    // pixel each way.
    let clamped = 1.5 * 0.5 * step * 2.0_f64.sqrt() / LEAST_DISTANCE + 1e-7;

    let mut counts = [0; 3];
    for y in 0..203 {
        for x in 0..301 {
            let direction = camera.ray(f64::from(x) + 0.5, f64::from(y) + 0.5);
            let pixel = view.pixel(x, y).unwrap();
            // Independently of the walls: leave the cube along the ray.
            let exits = (0..3).map(|axis| {
                let side = 1.0_f64.copysign(direction[axis]);
                ((side - EYE[axis]) / direction[axis], axis, side)
            });
            let (distance, axis, side) = exits.min_by(|a, b| a.0.total_cmp(&b.0)).unwrap();
            let is_wall = [(2, -1.0), (0, 1.0), (1, -1.0)].contains(&(axis, side));
            if !is_wall {
                assert_eq!(pixel, NO_WALL, "{x} {y}");
                counts[2] += 1;
                continue;
            }
            let point = EYE + distance * direction;
            let near_edge = (0..3)
                .filter(|&other| other != axis)
                .any(|other| point[other].abs() > 1.0 - 0.5 * step);
            let bound = if near_edge { clamped } else { bilinear };
            counts[usize::from(near_edge)] += 1;
            assert_eq!(pixel[3], 1.0);
            for (found, expected) in pixel.iter().zip(colour(direction)) {
                let error = (f64::from(*found) - expected).abs();
                assert!(error <= bound, "{x} {y}: {error} is above {bound}");
            }
        }
    }
    counts
}

#[test]
fn view_agrees_with_what_the_walls_were_painted_with() {
    let [inside, _, missed] = compare(DVec3::NEG_Z, 1.2);
    assert!(inside > 40_000);
    assert_eq!(missed, 0);
}

#[test]
fn view_has_no_seam_where_three_walls_meet() {
    let corner = DVec3::new(1.0, -1.0, -1.0) - EYE;
    let [inside, edge, missed] = compare(corner, 1.0);
    assert!(inside > 40_000 && edge > 50, "{inside} {edge}");
    assert_eq!(missed, 0);
}

#[test]
fn view_ends_where_the_walls_end() {
    let [inside, _, missed] = compare(DVec3::new(0.4, 0.5, -1.0), 2.4);
    assert!(inside > 10_000 && missed > 10_000, "{inside} {missed}");
}

#[test]
fn nearest_wall_hides_the_others() {
    let [front, ..] = three_walls();
    let mut near = front.clone();
    for corner in [
        &mut near.lower_left,
        &mut near.lower_right,
        &mut near.upper_left,
    ] {
        *corner *= 0.5;
    }
    let white = Picture::from_pixels(1, 1, vec![[1.0; 4]]).unwrap();
    let black = Picture::from_pixels(1, 1, vec![[0.0, 0.0, 0.0, 1.0]]).unwrap();
    let camera = ViewerCamera::new(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, FRAC_PI_2, [3, 3]).unwrap();
    for pairs in [
        [(&near, &white), (&front, &black)],
        [(&front, &black), (&near, &white)],
    ] {
        let view = render(&camera, &pairs).unwrap();
        assert!(view.pixels.iter().all(|pixel| *pixel == [1.0; 4]));
    }
}

/// A dome's picture of directions from its eye, off its centre, is seen from
/// that eye in those directions: to its rim, past which there is nothing.
#[test]
fn a_dome_is_seen_from_the_eye_that_it_is_painted_for() {
    let room = r#"
        [[dome]]
        name = "dome"
        radius = 2.0
        centre = [0.4, -0.3, 0.5]
        tilt_degrees = 25
    "#;
    let cave = crate::cave::Cave::from_toml(room, "", [512; 2]).unwrap();
    let dome = &cave.domes[0];
    let mut picture = Picture::new(512, 512).unwrap();
    for (x, y) in (0..512).flat_map(|y| (0..512).map(move |x| (x, y))) {
        let at = DVec2::new(f64::from(x) - 255.5, 255.5 - f64::from(y)) / 256.0;
        if at.length() <= 1.0 {
            let [red, green, blue] = colour(dome.point(at) - EYE).map(|c| c as f32);
            picture.set_pixel(x, y, [red, green, blue, 1.0]);
        }
    }
    let (mut seen, mut missed) = (0, 0);
    for look in [DVec3::NEG_Z, DVec3::Y, DVec3::new(1.0, 0.2, 0.3)] {
        let up = if look == DVec3::Y { DVec3::Z } else { DVec3::Y };
        let camera = ViewerCamera::new(EYE, look, up, FRAC_PI_2, [200, 150]).unwrap();
        let view = render(&camera, &[(dome, &picture)]).unwrap();
        for (x, y) in (0..200).flat_map(|x| (0..150).map(move |y| (x, y))) {
            let direction = camera.ray(f64::from(x) + 0.5, f64::from(y) + 0.5);
            let pixel = view.pixel(x, y).unwrap();
            if dome.meet(EYE, direction).is_none() {
                assert_eq!(pixel, NO_WALL);
                missed += 1;
                continue;
            }
            seen += 1;
            // Two pixels of the dome, from the nearest that the eye is to it.
            let slack = 2.0 * dome.width() / 512.0 / 1.2 * 1.5;
            for (found, expected) in pixel.into_iter().zip(colour(direction)) {
                let apart = (f64::from(found) - expected).abs();
                assert!(apart < slack, "{direction}: {found} {expected}");
            }
            assert_eq!(pixel[3], 1.0);
        }
    }
    assert!(seen > 60_000 && missed > 1_000, "{seen} {missed}");
}

#[test]
fn rays_span_the_field_of_view() {
    let camera = ViewerCamera::new(
        DVec3::ZERO,
        DVec3::new(0.0, 0.0, -5.0),
        // Not perpendicular: only its side of the view direction matters.
        DVec3::new(0.0, 1.0, -3.0),
        FRAC_PI_2,
        [400, 200],
    )
    .unwrap();
    let near = |ray: DVec3, expected: DVec3| {
        assert!(ray.distance(expected.normalize()) < 1e-12, "{ray}");
    };
    near(camera.ray(200.0, 100.0), DVec3::NEG_Z);
    near(camera.ray(0.0, 100.0), DVec3::new(-1.0, 0.0, -1.0));
    near(camera.ray(400.0, 100.0), DVec3::new(1.0, 0.0, -1.0));
    near(camera.ray(200.0, 0.0), DVec3::new(0.0, 0.5, -1.0));
    near(camera.ray(200.0, 200.0), DVec3::new(0.0, -0.5, -1.0));
}

#[test]
fn impossible_cameras_are_refused() {
    let camera = |forward, up, field_of_view, size| {
        ViewerCamera::new(DVec3::ZERO, forward, up, field_of_view, size).unwrap_err()
    };
    let size = [8, 8];
    for forward in [DVec3::ZERO, DVec3::NAN, DVec3::INFINITY] {
        assert!(matches!(
            camera(forward, DVec3::Y, 1.0, size),
            CameraError::Direction { .. }
        ));
    }
    for up in [DVec3::ZERO, DVec3::NAN, DVec3::Z, -3.0 * DVec3::Z] {
        assert!(matches!(
            camera(DVec3::NEG_Z, up, 1.0, size),
            CameraError::Up { .. }
        ));
    }
    for field_of_view in [0.0, -1.0, PI, f64::NAN, f64::INFINITY] {
        assert!(matches!(
            camera(DVec3::NEG_Z, DVec3::Y, field_of_view, size),
            CameraError::FieldOfView { .. }
        ));
    }
    for size in [[0, 8], [8, 0]] {
        assert!(matches!(
            camera(DVec3::NEG_Z, DVec3::Y, 1.0, size),
            CameraError::Size { .. }
        ));
    }
    let nowhere = ViewerCamera::new(DVec3::NAN, DVec3::X, DVec3::Y, 1.0, size);
    assert!(matches!(nowhere, Err(CameraError::Eye { .. })));
}

#[test]
fn walls_without_area_are_named() {
    let mut flat = three_walls()[0].clone();
    flat.upper_left = flat.lower_left;
    let picture = Picture::new(1, 1).unwrap();
    let camera = ViewerCamera::new(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, 1.0, [2, 2]).unwrap();
    let error = render(&camera, &[(&flat, &picture)]).unwrap_err();
    assert!(error.to_string().contains("\"front\""), "{error}");
}
