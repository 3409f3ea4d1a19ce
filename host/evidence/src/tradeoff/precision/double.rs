//! The core's formulas in double precision.

use crate::textbook::exact_refraction;
use glam::{DVec3, Vec3};
use shisen_core::shape::Ray;

pub(super) struct Hit {
    /// Distance in units of the ray's direction.
    pub(super) t: f64,
    pub(super) weights: [f64; 3],
}

/// As `Triangle::intersect`: the signs of the edges in the ray's sheared frame (Woop, Benthin &
/// Wald 2013) decide, and the distance is no less than that of the triangle's box.
pub(super) fn intersection(corners: [Vec3; 3], ray: &Ray, extent: f64) -> Option<Hit> {
    let (origin, d) = (ray.origin().as_dvec3(), ray.direction().as_dvec3());
    let size = d.abs();
    let [kx, ky, kz] = if size.x >= size.y && size.x >= size.z {
        [1, 2, 0]
    } else if size.y >= size.z {
        [2, 0, 1]
    } else {
        [0, 1, 2]
    };
    let shear = [d[kx] / d[kz], d[ky] / d[kz], 1.0 / d[kz]];
    let corners = corners.map(Vec3::as_dvec3);
    let from_eye = corners.map(|corner| corner - origin);
    let z = from_eye.map(|at| at[kz]);
    let [ax, bx, cx] = from_eye.map(|at| at[kx] - shear[0] * at[kz]);
    let [ay, by, cy] = from_eye.map(|at| at[ky] - shear[1] * at[kz]);
    let edges = [cx * by - cy * bx, ax * cy - ay * cx, bx * ay - by * ax];
    let [u, v, w] = edges;
    let same_side = edges.iter().all(|&e| e >= 0.0) || edges.iter().all(|&e| e <= 0.0);
    let determinant = u + v + w;
    if !same_side || determinant == 0.0 {
        return None;
    }
    let t = (u * z[0] + v * z[1] + w * z[2]) / determinant * shear[2];
    let [a, b, c] = corners;
    let (low, high) = (a.min(b).min(c), a.max(b).max(c));
    let (near, far) = interval(origin, d, (low, high), extent);
    (t >= 0.0 && far >= 0.0).then_some(Hit {
        t: t.max(near),
        weights: edges.map(|edge| edge / determinant),
    })
}

/// Returns the interval of a ray in a box, whose slabs are widened by the rounding of coordinates
/// up to `extent`.
fn interval(origin: DVec3, d: DVec3, (low, high): (DVec3, DVec3), extent: f64) -> (f64, f64) {
    let room = DVec3::splat(4.0 * f64::EPSILON * (extent + origin.abs().max_element()));
    let inverse = d.recip();
    let (first, last) = (
        (low - room - origin) * inverse,
        (high + room - origin) * inverse,
    );
    (first.min(last).max_element(), first.max(last).min_element())
}

/// As `trace::refract`: the reflected and the transmitted share and the direction; NaN for total
/// reflection.
pub(super) fn refraction(d: DVec3, normal: DVec3, m: f64, n: f64) -> (f64, f64, DVec3) {
    let cos = (-d.dot(normal)).clamp(0.0, 1.0);
    let Some((reflected, transmitted)) = exact_refraction(cos, m, n) else {
        return (f64::NAN, f64::NAN, DVec3::NAN);
    };
    let g = ((n - m) * (n + m) + m * cos * (m * cos)).sqrt();
    let along = d + normal * cos;
    let direction = (along * m - normal * g).normalize();
    (reflected, transmitted, direction)
}
