//! Numbers, shapes, refraction and capture: pure functions, and what each says
//! of numbers that it is not made for.

use super::numbers::{Case, Numbers, finite, finite_or_error};
use glam::Vec3;
use shisen_core::capture::{
    Mapping, SpheroidMirror, fisheye_equidistant, fisheye_equisolid, mirror_ball,
};
use shisen_core::numeric::{
    LARGEST_ANGLE, basis_around, difference_of_products, largest_magnitude, max, min, normalize,
    quadratic_roots, sin_cos, sqrt,
};
use shisen_core::shape::{Ray, Slabs, Spheroid, Triangle};
use shisen_core::trace::{reflect, refract};

pub(super) const CASES: &[(&str, Case)] = &[
    ("core numeric::sqrt", |n| {
        let x = n.next(2.0);
        let root = sqrt(x);
        // NaN below zero; of infinity, infinity.
        assert_eq!(
            root.is_finite(),
            (0.0..f32::INFINITY).contains(&x),
            "{root}"
        );
    }),
    ("core numeric::max", |n| {
        let (a, b) = (n.next(1.0), n.next(2.0));
        let expected = if a > b { a } else { b };
        assert_eq!(max(a, b).to_bits(), expected.to_bits());
    }),
    ("core numeric::min", |n| {
        let (a, b) = (n.next(1.0), n.next(2.0));
        let expected = if a < b { a } else { b };
        assert_eq!(min(a, b).to_bits(), expected.to_bits());
    }),
    ("core numeric::largest_magnitude", |n| {
        let v = n.vec3([1.0, -3.0, 2.0]);
        let largest = largest_magnitude(v);
        if v.is_finite() {
            assert_eq!(largest, v.abs().max_element());
        }
    }),
    ("core numeric::normalize", |n| {
        let v = n.vec3([1.0, -3.0, 2.0]);
        let unit = normalize(v);
        assert_eq!(unit.is_some(), v.is_finite() && v != Vec3::ZERO);
        unit.inspect(is_unit);
    }),
    ("core numeric::quadratic_roots", |n| {
        let [a, h, c, d] = [1.0, -3.0, 2.0, 7.0].map(|x| n.next(x));
        for d in [d, h * h - a * c] {
            if let Some((first, second)) = quadratic_roots(a, h, c, d) {
                assert!(!(first > second), "{first} {second}");
            }
        }
        // With the equation's own discriminant, roots are quotients of numbers
        // of these magnitudes.
        if [a, h, c]
            .iter()
            .all(|x| *x == 0.0 || (1.0e-9..1.0e9).contains(&x.abs()))
        {
            finite(&quadratic_roots(a, h, c, h * h - a * c));
        }
    }),
    ("core numeric::difference_of_products", |n| {
        let [a, b, c, d] = [1.0, -3.0, 2.0, 7.0].map(|x| n.next(x));
        let difference = difference_of_products(a, b, c, d);
        if (a * b).is_finite() && (c * d).is_finite() {
            assert!(!difference.is_nan());
            let exact = f64::from(a) * f64::from(b) - f64::from(c) * f64::from(d);
            assert_eq!(exact > 0.0, difference > 0.0, "{difference}");
            assert_eq!(exact < 0.0, difference < 0.0, "{difference}");
        }
    }),
    ("core numeric::basis_around", |n| {
        // Of unit vectors; of others, whatever has their direction no more.
        let z = n.vec3([0.0, 0.6, -0.8]);
        let basis = basis_around(z);
        if let Some(unit) = normalize(z) {
            finite(&basis_around(unit));
        }
        let near_unit = (z.length() - 1.0).abs() < 1.0e-6;
        assert!(!near_unit || basis.0.is_finite() && basis.1.is_finite());
    }),
    ("core numeric::trigonometry::sin_cos", |n| {
        let angle = n.next(0.7);
        let (sin, cos) = sin_cos(angle);
        let known = angle.abs() <= LARGEST_ANGLE;
        assert_eq!(known, sin.is_finite() && cos.is_finite());
        assert_eq!(known, !sin.is_nan() && !cos.is_nan());
    }),
    ("core shape::ray::Ray::new", |n| {
        let ray = a_ray(n);
        finite(&ray);
    }),
    ("core shape::ray::Ray::at", |n| {
        let ray = a_ray(n);
        let t = n.next(2.0);
        if let Some(point) = ray.map(|ray| ray.at(t))
            && t.abs() <= 1.0e18
        {
            finite(&point);
        }
    }),
    ("core shape::bounds::Slabs::new", |n| {
        let ray = a_ray(n);
        let extent = n.next(10.0);
        if let Some(ray) = ray {
            // NaN is no extent: the ray's own start counts.
            let slabs = Slabs::new(&ray, extent);
            if !(extent.abs() > Slabs::LARGEST_EXTENT) {
                finite(&slabs);
            }
        }
    }),
    ("core shape::bounds::Slabs::interval", |n| {
        let ray = a_ray(n);
        let extent = n.next(10.0).abs().min(Slabs::LARGEST_EXTENT);
        let low = n.vec3([-1.0; 3]);
        let high = n.vec3([1.0; 3]);
        let Some(slabs) = ray.map(|ray| Slabs::new(&ray, extent)) else {
            return;
        };
        // A box from +∞ to −∞ is never entered, one that is all of space is
        // left nowhere; its planes may be infinite, and so the interval.
        let (near, far) = slabs.interval(Vec3::INFINITY, Vec3::NEG_INFINITY);
        assert!(near > far, "{near} {far}");
        let (near, far) = slabs.interval(Vec3::NEG_INFINITY, Vec3::INFINITY);
        assert!(near <= far, "{near} {far}");
        let interval = slabs.interval(low, high);
        if low.abs().max_element() <= extent && high.abs().max_element() <= extent {
            assert!(!interval.0.is_nan() && !interval.1.is_nan());
        }
    }),
    ("core shape::spheroid::Spheroid::new", |n| {
        finite(&Spheroid::new(n.next(0.5), n.next(2.0)));
    }),
    ("core shape::spheroid::Spheroid::intersect", |n| {
        let ray = a_ray(n);
        if let Some((spheroid, ray)) = a_spheroid(n).zip(ray) {
            let hits = spheroid.intersect(&ray);
            finite(&hits);
            if let Some(hits) = hits {
                assert!(hits.t[0] <= hits.t[1], "{hits:?}");
            }
        }
    }),
    ("core shape::spheroid::Spheroid::normal", |n| {
        let point = n.vec3([0.3, 0.1, -0.2]);
        if let Some(spheroid) = a_spheroid(n) {
            is_unit(&spheroid.normal(point));
        }
    }),
    ("core shape::spheroid::Spheroid::project", |n| {
        let point = n.vec3([0.3, 0.1, -0.2]);
        if let Some(spheroid) = a_spheroid(n) {
            let moved = spheroid.project(point);
            assert!(moved.is_finite() || !point.is_finite(), "{moved}");
        }
    }),
    ("core shape::triangle::Triangle::intersect", |n| {
        let ray = a_ray(n);
        let triangle = Triangle([
            n.vec3([-1.0, -1.0, -3.0]),
            n.vec3([1.0, -1.0, -3.0]),
            n.vec3([0.0, 1.0, -3.0]),
        ]);
        let extent = n.next(3.0);
        let corners = triangle.0.iter();
        let usable = corners
            .map(|&c| largest_magnitude(c))
            .all(|c| c <= Ray::FARTHEST);
        if let Some(hit) = ray.and_then(|ray| triangle.intersect(&ray, extent))
            && usable
        {
            finite(&hit);
            assert!(
                hit.t >= 0.0 && hit.weights.iter().all(|w| (0.0..=1.0).contains(w)),
                "{hit:?}"
            );
        }
    }),
    ("core trace::optics::reflect", |n| {
        let direction = n.vec3([0.6, -0.8, 0.0]);
        let normal = n.vec3([0.0, 1.0, 0.0]);
        let reflected = reflect(direction, normal);
        if let Some(unit) = normalize(normal)
            && direction.is_finite()
            && direction.abs().max_element() <= 1.0e18
        {
            finite(&reflect(direction, unit));
        }
        assert!(!n.are_sane() || reflected.is_finite());
    }),
    ("core trace::optics::refract", |n| {
        let direction = n.vec3([0.6, -0.8, 0.0]);
        let normal = n.vec3([0.0, 1.0, 0.0]);
        let indices = [n.next(1.0), n.next(1.5)];
        // Of unit vectors, and the indices of materials.
        let units = normalize(direction).zip(normalize(normal));
        let Some((direction, normal)) = units else {
            return;
        };
        if !indices.iter().all(|index| (0.01..=100.0).contains(index)) {
            return;
        }
        let all = refract(direction, normal, indices[0], indices[1]);
        finite(&all);
        for share in [all.reflectance, all.transmittance] {
            assert!((0.0..=1.0).contains(&share), "{all:?}");
        }
        if let Some(unit) = all.direction {
            is_unit(&unit);
        }
    }),
    ("core capture::fisheye::fisheye_equidistant", |n| {
        let found = fisheye_equidistant(n.next(0.3), n.next(-0.4), n.next(3.0));
        found.inspect(is_unit);
    }),
    ("core capture::fisheye::fisheye_equisolid", |n| {
        let found = fisheye_equisolid(n.next(0.3), n.next(-0.4), n.next(3.0));
        found.inspect(is_unit);
    }),
    ("core capture::fisheye::mirror_ball", |n| {
        mirror_ball(n.next(0.3), n.next(-0.4)).inspect(is_unit);
    }),
    ("core capture::mirror::SpheroidMirror::parallel", |n| {
        finite_or_error(SpheroidMirror::parallel(n.next(0.7))).inspect(known);
    }),
    ("core capture::mirror::SpheroidMirror::perspective", |n| {
        let made = SpheroidMirror::perspective(n.next(0.7), n.next(5.0));
        finite_or_error(made).inspect(known);
    }),
    ("core capture::mirror::SpheroidMirror::from_edge", |n| {
        let made = SpheroidMirror::from_edge(n.next(0.7), n.next(0.5));
        finite_or_error(made).inspect(known);
    }),
    ("core capture::mapping::SpheroidMirror::point", |n| {
        let beta = n.next(0.3);
        of_mirrors(n, |mirror| finite(&mirror.point(beta)));
    }),
    ("core capture::mapping::SpheroidMirror::theta", |n| {
        let r_d = n.next(0.3);
        of_mirrors(n, |mirror| finite(&mirror.theta(r_d)));
    }),
    ("core capture::mapping::SpheroidMirror::r_d", |n| {
        let theta = n.next(0.3);
        of_mirrors(n, |mirror| finite(&mirror.r_d(theta)));
    }),
    ("core capture::reflection::SpheroidMirror::pixel", |n| {
        let (u, v) = (n.next(0.3), n.next(-0.4));
        of_mirrors(n, |mirror| {
            for mapping in [Mapping::Screen, Mapping::Exact] {
                let seen = mirror.pixel(u, v, mapping);
                finite(&seen);
                seen.inspect(|seen| is_unit(&seen.direction));
            }
        });
    }),
    (
        "core capture::reflection::SpheroidMirror::screen_point",
        |n| {
            let (x, y) = (n.next(0.3), n.next(-0.4));
            of_mirrors(n, |mirror| {
                let seen = mirror.screen_point(x, y);
                finite(&seen);
                seen.inspect(|seen| is_unit(&seen.direction));
            });
        },
    ),
];

/// A ray that can be traced, if the numbers make one.
pub(super) fn a_ray(n: &mut Numbers) -> Option<Ray> {
    let origin = n.vec3([0.1, 0.2, 0.3]);
    let direction = n.vec3([0.05, -0.02, -1.0]);
    Ray::new(origin, direction)
}

fn a_spheroid(n: &mut Numbers) -> Option<Spheroid> {
    Spheroid::new(n.next(0.5), n.next(2.0))
}

#[track_caller]
fn is_unit(v: &Vec3) {
    assert!(
        (v.length() - 1.0).abs() <= 2.0e-6,
        "{v} is of another length"
    );
}

/// The paper's and the best, and one of these numbers.
fn of_mirrors(n: &mut Numbers, check: impl Fn(&SpheroidMirror)) {
    let own = [
        SpheroidMirror::perspective(n.next(0.7), n.next(5.0)),
        SpheroidMirror::from_edge(n.next(0.7), n.next(0.5)),
    ];
    for mirror in own.iter().flatten() {
        check(mirror);
    }
    check(&SpheroidMirror::PAPER_SPHERE);
    check(&SpheroidMirror::BEST);
}

fn known(mirror: &SpheroidMirror) {
    finite(&(mirror.edge(), mirror.field_of_view()));
    finite(&(mirror.screen_distance(), mirror.screen_radius()));
    finite(&mirror.viewpoint_to_screen());
}
