//! The host's formulas of records that their constructors have checked: finite on
//! the domain that their documentation names, and never a panic beyond it.

use super::host::{dome, mirror, wall};
use super::numbers::{Case, Numbers, finite, finite_or_error};
use glam::{DVec2, DVec3};
use shisen::cave::Cave;
use shisen::dome::{Design, Mapping, Mirror, NearField, px_4096};
use shisen::gaze_reference::{Gaze, Limits};
use shisen::overview::viewer::ViewerCamera;
use shisen::spectrum::{Dispersion, Method};
use shisen::warp::{Aim, Lens, Projector, Throw};
use shisen_core::gaze::Boundary;
use shisen_core::spectrum::SpectralSample;
use std::f64::consts::FRAC_PI_2;

const MAPPINGS: [Mapping; 3] = [Mapping::Mirror, Mapping::Exact, Mapping::True];

/// Beyond this a square overflows.
const FAR: f64 = 1.0e150;

fn is_angle(angle: f64) -> bool {
    (0.0..=FRAC_PI_2).contains(&angle)
}

/// A ray: where it starts, and its unit direction where that has one.
fn ray(n: &mut Numbers) -> (DVec3, Option<DVec3>) {
    let (origin, direction) = (n.dvec3([0.1, 1.0, 0.2]), n.dvec3([0.3, -0.2, -1.0]));
    (origin, direction.try_normalize())
}

fn is_near(place: DVec3) -> bool {
    place.is_finite() && place.abs().max_element() < FAR
}

fn single(mirror: &Mirror) -> Option<shisen_core::capture::SpheroidMirror> {
    finite_or_error(mirror.single())
}

pub(super) const CASES: &[(&str, Case)] = &[
    ("host cave::Cave::new", |n| {
        if let Some(wall) = wall(n) {
            let cave = finite_or_error(Cave::new(vec![wall.clone()]));
            assert!(cave.is_some());
            // Two of one name.
            assert!(finite_or_error(Cave::new(vec![wall.clone(), wall])).is_none());
        }
    }),
    ("host cave::Cave::with_dome", |n| {
        if let (Some(wall), Some(dome)) = (wall(n), dome(n)) {
            let cave = Cave::new(vec![wall]).expect("a wall");
            let cave = finite_or_error(cave.with_dome(dome.clone())).expect("another name");
            assert!(finite_or_error(cave.with_dome(dome)).is_none());
        }
    }),
    ("host cave::dome::DomeScreen::point", |n| {
        let at = DVec2::new(n.wide(0.3), n.wide(-0.4));
        if let Some(dome) = dome(n) {
            let point = dome.point(at);
            // In the unit disc it lies on the dome.
            if at.length() <= 1.0 {
                finite(&point);
                let radius = (point - dome.centre()).length();
                let scale = dome.radius() + dome.centre().abs().max_element();
                assert!((radius - dome.radius()).abs() <= 1e-9 * scale, "{radius}");
            }
        }
    }),
    ("host cave::dome::DomeScreen::place", |n| {
        let point = n.dvec3([0.5, 2.0, -1.0]);
        if let (Some(dome), true) = (dome(n), is_near(point)) {
            finite(&dome.place(point));
        }
    }),
    ("host cave::dome::DomeScreen::meet", |n| {
        let (origin, direction) = ray(n);
        if let (Some(dome), Some(direction)) = (dome(n), direction) {
            let met = dome.meet(origin, direction);
            if is_near(origin) {
                finite(&met);
            }
        }
    }),
    ("host cave::dome::DomeScreen::lit", |n| {
        let (origin, direction) = ray(n);
        if let (Some(dome), Some(direction)) = (dome(n), direction) {
            let lit = dome.lit(origin, direction);
            if is_near(origin) {
                finite(&lit);
            }
        }
    }),
    ("host dome::design::Design::of", |n| {
        if let Some(mirror) = mirror(n) {
            finite(&Design::of(mirror));
        }
    }),
    ("host dome::mapping::Mapping::theta", |n| {
        let r_d = n.wide(0.4);
        for_mappings(n, |mapping, mirror| {
            let theta = mapping.theta(mirror, r_d);
            assert!(!is_angle(r_d) || is_near_angle(theta), "{r_d} {theta}");
        });
    }),
    ("host dome::mapping::Mapping::r_d", |n| {
        let theta = n.wide(0.4);
        for_mappings(n, |mapping, mirror| {
            let r_d = mapping.r_d(mirror, theta);
            assert!(!is_angle(theta) || is_near_angle(r_d), "{theta} {r_d}");
        });
    }),
    ("host dome::mapping::Mapping::single_theta", |n| {
        let r_d = n.next(0.4);
        for_mappings(n, |mapping, mirror| {
            let theta = single(mirror).map(|mirror| mapping.single_theta(&mirror, r_d));
            finite(&theta);
        });
    }),
    ("host dome::mapping::Mapping::single_r_d", |n| {
        let theta = n.next(0.4);
        for_mappings(n, |mapping, mirror| {
            let r_d = single(mirror).map(|mirror| mapping.single_r_d(&mirror, theta));
            finite(&r_d);
        });
    }),
    ("host dome::mirror::Mirror::at", |n| {
        let beta = n.wide(0.3);
        if let Some(mirror) = mirror(n) {
            let (theta, r_d) = mirror.at(beta);
            if (0.0..=mirror.parameters().beta1).contains(&beta) {
                assert!(is_near_angle(theta) && is_near_angle(r_d), "{theta} {r_d}");
            }
        }
    }),
    ("host dome::mirror::Mirror::theta", |n| {
        let r_d = n.wide(0.4);
        if let Some(mirror) = mirror(n) {
            let theta = mirror.theta(r_d);
            assert!(!is_angle(r_d) || is_near_angle(theta), "{theta}");
        }
    }),
    ("host dome::mirror::Mirror::r_d", |n| {
        let theta = n.wide(0.4);
        if let Some(mirror) = mirror(n) {
            let r_d = mirror.r_d(theta);
            assert!(!is_angle(theta) || is_near_angle(r_d), "{r_d}");
        }
    }),
    ("host dome::mirror::Mirror::reflect", |n| {
        let screen = DVec2::new(n.wide(0.1), n.wide(0.2));
        if let Some(mirror) = mirror(n) {
            let (point, direction) = mirror.reflect(screen);
            if screen.length() <= mirror.parameters().b1 {
                finite(&point);
                assert!((direction.length() - 1.0).abs() < 1e-9, "{direction}");
            }
        }
    }),
    ("host dome::mirror::Mirror::near_theta", |n| {
        let (r_d, radius) = (n.wide(0.4), n.wide(10.0));
        if let Some(mirror) = mirror(n) {
            let theta = mirror.near_theta(r_d, radius);
            // The mirror is in the sphere.
            let reach = 4.0 * (1.0 + 1.0 / mirror.axis_ratio() + mirror.axis_ratio());
            if is_angle(r_d) && (reach..FAR).contains(&radius) {
                finite(&theta);
            }
        }
    }),
    ("host dome::near_field::px_4096", |n| {
        let angle = n.wide(0.01);
        assert_eq!(px_4096(angle).is_nan(), angle.is_nan());
        if angle.abs() < FAR {
            finite(&px_4096(angle));
        }
    }),
    ("host dome::near_field::NearField::new", |n| {
        for_mappings(n, |mapping, mirror| {
            finite(&NearField::new(*mirror, mapping).reach());
        });
    }),
    ("host dome::near_field::NearField::seen_from", |n| {
        let offset = n.wide(0.2);
        for_near_fields(n, |near| {
            let seen = near.seen_from(offset);
            if offset.abs() < FAR {
                finite(&seen.reach());
            }
        });
    }),
    ("host dome::near_field::NearField::angle", |n| {
        let (r_d, distance) = (n.wide(0.4), n.wide(10.0));
        for_near_fields(n, |near| {
            let angle = near.angle(r_d, distance);
            if is_angle(r_d) && near.check(distance).is_ok() {
                finite(&angle);
            }
        });
    }),
    ("host dome::near_field::NearField::ring", |n| {
        let (ring, distance) = (n.wide(0.4), n.wide(10.0));
        for_near_fields(n, |near| {
            let seen = near.ring(ring, distance);
            if near.check(distance).is_ok() {
                finite(&seen);
            }
        });
    }),
    ("host dome::near_field::NearField::largest", |n| {
        let distance = n.wide(10.0);
        for_near_fields(n, |near| {
            let largest = near.largest(distance);
            if near.check(distance).is_ok() {
                finite(&largest);
            }
        });
    }),
    ("host dome::near_field::NearField::largest_beyond", |n| {
        let nearest = n.wide(10.0);
        for_near_fields(n, |near| {
            let largest = near.largest_beyond(nearest);
            if near.check(nearest).is_ok() {
                finite(&largest);
            }
        });
    }),
    ("host gaze_reference::Gaze::sight", |n| {
        let gaze = Gaze::new(DVec3::NEG_Z, DVec3::Y, Limits::PAPER, Boundary::Printed);
        let direction = n.dvec3([0.1, 0.2, -1.0]);
        let sight = gaze.expect("a gaze").sight(direction);
        finite(&sight);
        let is_direction = direction.is_finite() && direction != DVec3::ZERO;
        assert_eq!(sight.is_some(), is_direction, "{direction}");
    }),
    ("host overview::viewer::ViewerCamera::ray", |n| {
        let ahead = (DVec3::ZERO, DVec3::NEG_Z, DVec3::Y);
        let camera = ViewerCamera::new(ahead.0, ahead.1, ahead.2, 1.0, [64, 48]);
        let (x, y) = (n.wide(10.0), n.wide(20.0));
        let direction = camera.expect("a camera").ray(x, y);
        if x.abs() < FAR && y.abs() < FAR {
            assert!((direction.length() - 1.0).abs() < 1e-12, "{direction}");
        }
    }),
    ("host warp::projector::Projector::direction", |n| {
        let lens = Lens {
            throw: Throw::Degrees(40.0),
            vertical_degrees: Some(30.0),
            shift: DVec2::ZERO,
        };
        let (look, up) = (DVec3::NEG_Z, DVec3::Y);
        let aim = Aim::Look { look, up };
        let projector = Projector::new("one", DVec3::ZERO, aim, lens, [64, 48]);
        let at = DVec2::new(n.wide(0.4), n.wide(0.6));
        let direction = projector.expect("a projector").direction(at);
        if at.is_finite() && at.abs().max_element() < FAR {
            assert!((direction.length() - 1.0).abs() < 1e-12, "{direction}");
        }
    }),
    ("host spectrum::dispersion::Dispersion::spectrum", |n| {
        let range = [400.0, 700.0].map(|nm| n.next(nm));
        if let Some(dispersion) = finite_or_error(Dispersion::of(Method::Comb, 7, Some(range))) {
            let mut storage: Vec<SpectralSample> = Vec::new();
            finite(&dispersion.spectrum(&mut storage));
        }
    }),
];

/// An angle of a picture, 0 to π/2 but for its rounding.
fn is_near_angle(angle: f64) -> bool {
    (-1.0e-9..=FRAC_PI_2 + 1.0e-9).contains(&angle)
}

fn for_mappings(n: &mut Numbers, check: impl Fn(Mapping, &Mirror)) {
    if let Some(mirror) = mirror(n) {
        for mapping in MAPPINGS {
            check(mapping, &mirror);
        }
    }
}

fn for_near_fields(n: &mut Numbers, check: impl Fn(NearField)) {
    for_mappings(n, |mapping, mirror| check(NearField::new(*mirror, mapping)));
}
