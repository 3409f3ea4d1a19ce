//! The mirror's dome master against double precision.

use glam::{DVec2, DVec3, Vec3};
use shisen::dome::Mirror;
use shisen_core::capture::{self, Mapping, SpheroidMirror};
use shisen_tests::rays::Random;
use shisen_tests::sizes::cases;
use std::f32::consts::TAU;
use std::f64::consts::{FRAC_PI_2, PI};

const NAMED: [SpheroidMirror; 5] = [
    SpheroidMirror::PAPER_PARALLEL,
    SpheroidMirror::PAPER_SPHERE,
    SpheroidMirror::PAPER_SPHEROID,
    SpheroidMirror::BEST_PARALLEL,
    SpheroidMirror::BEST,
];

/// Returns the named mirrors, viewpoints from next to the pole to next to infinity, and flat and
/// long mirrors; each in both precisions.
fn mirrors() -> impl Iterator<Item = (SpheroidMirror, Mirror)> {
    let others = [0.5f32, 0.8, 1.0, 1.288, 2.35, 4.5, 10.0, 100.0]
        .into_iter()
        .flat_map(|a| {
            let above = [
                1.0e-6, 1.0e-3, 0.1, 0.5, 1.0, 3.0, 1.0e2, 1.0e4, 1.0e6, 1.0e7, 1.0e30,
            ];
            let seen = above.map(|above| SpheroidMirror::perspective(a, a * (1.0 + above)));
            seen.into_iter().chain([SpheroidMirror::parallel(a)])
        });
    let all = NAMED.into_iter().map(Ok).chain(others);
    all.map(|single| {
        let single = single.unwrap();
        let a = f64::from(single.axis_ratio());
        let double = match single.viewpoint() {
            None => Mirror::parallel(a),
            Some(p) => Mirror::perspective(a, f64::from(p)),
        };
        (single, double.unwrap())
    })
}

/// |found − exact| in units of the last place of f32 at the exact value.
fn ulps(found: f32, exact: f64) -> f64 {
    let nearest = (exact as f32).abs();
    let ulp = f64::from(nearest.next_up()) - f64::from(nearest);
    (f64::from(found) - exact).abs() / ulp
}

/// Returns places from 0 to 1: evenly, towards 0 by magnitudes and both ends.
fn places(count: usize, random: &mut Random) -> Vec<f32> {
    let mut places = vec![0.0, 1.0e-20, 1.0e-12, 1.0f32.next_down(), 1.0];
    for i in 0..count {
        places.push(i as f32 / count as f32);
        places.push(10f64.powf(random.range(-8.0, 0.0)) as f32);
        places.push(1.0 - 10f64.powf(random.range(-7.0, 0.0)) as f32);
    }
    places
}

#[test]
fn the_mapping_is_within_its_bound_both_ways() {
    let count = cases("places on each mirror", 300, 2_000);
    let mut random = Random::new(61);
    let mut worst = [[0f64; 4]; 2];
    for (single, double) in mirrors() {
        let worst = &mut worst[usize::from(!NAMED.contains(&single))];
        for place in places(count, &mut random) {
            let angle = place * (FRAC_PI_2 as f32);
            let wide = f64::from(angle).min(FRAC_PI_2);
            let beta = place * single.edge();
            let point = single.point(beta).unwrap();
            let (theta, r_d) = double.at(f64::from(beta));
            let found = [
                ulps(point.theta, theta),
                ulps(point.r_d, r_d),
                ulps(single.theta(angle).unwrap(), double.theta(wide)),
                ulps(single.r_d(angle).unwrap(), double.r_d(wide)),
            ];
            for (worst, found) in worst.iter_mut().zip(found) {
                *worst = worst.max(found);
            }
        }
    }
    for (worst, bound) in worst.into_iter().zip([8.0, 10.0]) {
        assert!(worst.iter().all(|&w| w <= bound), "{worst:?}");
    }
}

/// Returns the pixels' part of an angle, at 4096.
fn pixels(angle: f64) -> f64 {
    angle / FRAC_PI_2 * 2048.0
}

fn angle_between(a: DVec3, b: DVec3) -> f64 {
    a.cross(b).length().atan2(a.dot(b))
}

/// Returns a pixel of the disc.
fn pixel(place: f32, random: &mut Random) -> (f32, f32) {
    let (sin, cos) = random.range(0.0, 2.0 * PI).sin_cos();
    let (u, v) = (place * cos as f32, place * sin as f32);
    if u * u + v * v <= 1.0 {
        (u, v)
    } else {
        (place, 0.0)
    }
}

#[test]
fn rays_are_reflected_as_in_f64() {
    let count = cases("rays at each mirror", 300, 2_000);
    let mut random = Random::new(62);
    for (single, double) in mirrors() {
        let b1 = double.parameters().b1;
        let bound = if NAMED.contains(&single) {
            6.0e-4
        } else {
            1.0e-3
        };
        for place in places(count, &mut random) {
            let (u, v) = pixel(place, &mut random);
            let at = DVec2::new(f64::from(u), f64::from(v));
            let theta = at.length().min(1.0) * FRAC_PI_2;
            let way = at.normalize_or_zero();
            let exact = way * (double.r_d(theta) / FRAC_PI_2 * b1);
            for (mapping, screen, bound) in [
                (Mapping::Screen, at * b1, bound),
                (Mapping::Exact, exact, 1.0e-3),
            ] {
                let found = single.pixel(u, v, mapping).unwrap();
                let (point, direction) = double.reflect(screen);
                let off = (found.point.as_dvec3() - point).length() / point.length();
                assert!(off <= 3.0e-7, "{single:?} {u} {v}: {off}");
                let apart = pixels(angle_between(found.direction.as_dvec3(), direction));
                assert!(
                    apart <= bound,
                    "{single:?} {mapping:?} {u} {v}: {apart} pixels"
                );
                assert!((found.direction.as_dvec3().length() - 1.0).abs() <= 4.0e-7);
            }
            // Where it is said to be, it is reflected so.
            let direction = (way * theta.sin()).extend(-theta.cos());
            let reflected = double.reflect(exact).1;
            assert!(pixels(angle_between(reflected, direction)) < 1.0e-6);
        }
    }
}

#[test]
fn lenses_have_the_angles_of_their_definitions() {
    /// A lens's direction of a pixel, and the angle of its distance from the middle in f64.
    type Lens = (fn(f32, f32) -> Option<Vec3>, fn(f64) -> f64);
    let count = cases("pixels of each lens", 3000, 30_000);
    let mut random = Random::new(64);
    let lenses: [Lens; 4] = [
        (
            |u, v| capture::fisheye_equidistant(u, v, TAU),
            |rho| rho * PI,
        ),
        (
            |u, v| capture::fisheye_equidistant(u, v, 0.5),
            |rho| rho * 0.25,
        ),
        (
            |u, v| capture::fisheye_equisolid(u, v, 0.5),
            |rho| 2.0 * (rho * 0.125f64.sin()).asin(),
        ),
        (capture::mirror_ball, |rho| 2.0 * rho.min(1.0).asin()),
    ];
    let mut worst = 0f64;
    for (direction, angle) in lenses {
        for place in places(count, &mut random) {
            let (u, v) = pixel(place, &mut random);
            let (x, y) = (f64::from(u), f64::from(v));
            let theta = angle(x.hypot(y));
            let outwards = DVec2::new(x, y).normalize_or_zero() * theta.sin();
            let exact = outwards.extend(-theta.cos());
            let found = direction(u, v).unwrap().as_dvec3();
            let error = (found - exact).length();
            assert!((found.length() - 1.0).abs() <= 4.0e-7);
            worst = worst.max(error);
        }
    }
    assert!(worst <= 1.0e-6, "{worst}");
}
