use super::super::walls::{cube, painted};
use super::*;
use crate::cave::{BuiltInCave, Cave};
use std::f64::consts::FRAC_PI_2;

/// Pixels along each side of a wall.
const PIXELS: u32 = 256;
/// The eye that the walls are painted for: off the cube's centre.
const EYE: DVec3 = DVec3::new(0.1, -0.15, 0.2);
/// The least distance from the eye to a wall of the cube from −1 to 1.
const LEAST_DISTANCE: f64 = 0.8;

/// A smooth colour for each direction, of slope at most 1.5 per radian.
fn colour(direction: DVec3) -> [f64; 3] {
    let axes = [
        DVec3::new(0.6, 0.8, 0.0),
        DVec3::new(0.0, 0.6, -0.8),
        DVec3::new(-0.8, 0.0, 0.6),
    ];
    axes.map(|axis| 0.5 + 0.5 * (3.0 * direction.normalize().dot(axis)).sin())
}

/// Renders the three walls and compares each pixel with the function that they were painted
/// with. Returns how many pixels were interpolated, fell within half a pixel of a wall's
/// edge, and missed the walls.
fn compare(forward: DVec3, field_of_view: f64) -> [usize; 3] {
    let walls = cube(["front", "right", "floor"]);
    let paint = |point: DVec3| {
        let [red, green, blue] = colour(point - EYE).map(|channel| channel as f32);
        [red, green, blue, 1.0]
    };
    let pictures = walls
        .each_ref()
        .map(|wall| painted(wall, [PIXELS; 2], paint));
    let pairs: Vec<_> = walls.iter().zip(&pictures).collect();
    let camera = ViewerCamera::new(EYE, forward, DVec3::Y, field_of_view, [301, 203]).unwrap();
    let view = render(&camera, &pairs).unwrap();

    let step = 2.0 / f64::from(PIXELS);
    // Bilinear interpolation is off by at most step² / 8 times the sum of the second
    // derivatives along the wall. Those of sin(3 d·a) / 2 are at most 4.5 and 1.5 times the
    // direction's own, 2, at distance 1.
    let bilinear = 2.0 * (4.5 + 3.0) / 8.0 * (step / LEAST_DISTANCE).powi(2) + 1e-7;
    // Beyond the outermost centres the nearest one stands for up to half a pixel each way.
    let clamped = 1.5 * 0.5 * step * 2.0_f64.sqrt() / LEAST_DISTANCE + 1e-7;

    let mut counts = [0; 3];
    for (x, y) in (0..203).flat_map(|y| (0..301).map(move |x| (x, y))) {
        let direction = camera.ray(f64::from(x) + 0.5, f64::from(y) + 0.5);
        let pixel = view.pixel(x, y).unwrap();
        // Independently of the walls: leave the cube along the ray.
        let exits = (0..3).map(|axis| {
            let side = 1.0_f64.copysign(direction[axis]);
            ((side - EYE[axis]) / direction[axis], axis, side)
        });
        let (distance, axis, side) = exits.min_by(|a, b| a.0.total_cmp(&b.0)).unwrap();
        if ![(2, -1.0), (0, 1.0), (1, -1.0)].contains(&(axis, side)) {
            assert_eq!(pixel, NO_WALL, "{x} {y}");
            counts[2] += 1;
            continue;
        }
        let point = EYE + distance * direction;
        let mut others = (0..3).filter(|&other| other != axis);
        let near_edge = others.any(|other| point[other].abs() > 1.0 - 0.5 * step);
        let bound = if near_edge { clamped } else { bilinear };
        counts[usize::from(near_edge)] += 1;
        assert_eq!(pixel[3], 1.0);
        for (found, expected) in pixel.iter().zip(colour(direction)) {
            let error = (f64::from(*found) - expected).abs();
            assert!(error <= bound, "{x} {y}: {error} is above {bound}");
        }
    }
    counts
}

#[test]
fn the_view_is_what_the_walls_were_painted_with() {
    let [inside, _, missed] = compare(DVec3::NEG_Z, 1.2);
    assert!(inside > 40_000 && missed == 0, "{inside} {missed}");
    // Where three walls meet, and where they end.
    let [inside, edge, missed] = compare(DVec3::new(1.0, -1.0, -1.0) - EYE, 1.0);
    assert!(
        inside > 40_000 && edge > 50 && missed == 0,
        "{inside} {edge}"
    );
    let [inside, _, missed] = compare(DVec3::new(0.4, 0.5, -1.0), 2.4);
    assert!(inside > 10_000 && missed > 10_000, "{inside} {missed}");
}

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
