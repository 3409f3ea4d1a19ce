//! Formulas as textbooks and papers print them, and references in double precision.

use glam::{DVec3, Vec3};
use shisen_core::capture::SpheroidMirror;
use shisen_core::shape::Ray;

/// Returns the angle between two directions of any length, radians.
pub(crate) fn angle(a: DVec3, b: DVec3) -> f64 {
    a.cross(b).length().atan2(a.dot(b))
}

/// Möller and Trumbore's test of 1997, in f32; with `least`, as published, a
/// determinant below which a triangle is taken for edge-on.
pub(crate) fn moller_trumbore(corners: [Vec3; 3], ray: &Ray, least: Option<f32>) -> Option<f32> {
    let [a, b, c] = corners;
    let (d, e1, e2) = (ray.direction(), b - a, c - a);
    let p = d.cross(e2);
    let determinant = e1.dot(p);
    if least.is_some_and(|least| determinant.abs() < least) {
        return None;
    }
    let inverse = 1.0 / determinant;
    let s = ray.origin() - a;
    let u = s.dot(p) * inverse;
    // NaN passes, as in the published test.
    let beyond = u > 1.0;
    if u < 0.0 || beyond {
        return None;
    }
    let q = s.cross(e1);
    let v = d.dot(q) * inverse;
    if v < 0.0 || u + v > 1.0 {
        return None;
    }
    let t = e2.dot(q) * inverse;
    if t < 0.0 { None } else { Some(t) }
}

pub(crate) fn printed(v: Vec3) -> (f32, f32) {
    use std::f32::consts::{FRAC_PI_3, FRAC_PI_6, PI};
    let (f, r, u) = (-v.z, v.x, v.y);
    let alpha = (f / (f * f + r * r).sqrt()).acos();
    let beta = (f / (f * f + u * u).sqrt()).abs().acos();
    let l = (alpha * alpha + beta * beta).sqrt();
    let (across, along) = if u < 0.0 {
        (5.0 * PI / 9.0, 7.0 * PI / 18.0)
    } else {
        (5.0 * PI / 9.0, FRAC_PI_3)
    };
    let (x, y) = (across * alpha / l, along * beta / l);
    let big_l = (x * x + y * y).sqrt();
    let level = if l <= FRAC_PI_6 {
        1.0
    } else if l < big_l {
        (big_l - l) / (big_l - FRAC_PI_6)
    } else if l >= big_l {
        0.0
    } else {
        f32::NAN
    };
    (l, level)
}

/// Returns the level as printed, of a viewer who looks along −Z.
pub(crate) fn printed_level(v: Vec3) -> f32 {
    printed(v).1
}

/// The reflected and the transmitted share; `None` where all is reflected.
pub(crate) type Shares = Option<(f64, f64)>;

/// Returns the shares of light of this cosine of incidence, from index m into n, by forms of
/// Fresnel's equations that do not cancel.
pub(crate) fn exact_refraction(cos: f64, m: f64, n: f64) -> Shares {
    let difference = (n - m) * (n + m);
    let g2 = difference + (m * cos) * (m * cos);
    if g2 <= 0.0 {
        return None;
    }
    let g = g2.sqrt();
    let (s, p) = (m * cos + g, n * n * cos + m * g);
    let rs = difference / (s * s);
    let rp = difference * ((n * n + m * m) * cos * cos - m * m) / (p * p);
    let through = 2.0 * m * cos * g * (1.0 / (s * s) + n * n / (p * p));
    Some((f64::midpoint(rs * rs, rp * rp), through))
}

/// Returns the reflected and the transmitted share and the direction, as textbooks have them.
pub(crate) fn textbook_refraction(
    d: Vec3,
    normal: Vec3,
    m: f32,
    n: f32,
) -> Option<(f32, f32, Vec3)> {
    let eta = m / n;
    let cos_in = -d.dot(normal);
    let sin2 = eta * eta * (1.0 - cos_in * cos_in);
    if sin2 > 1.0 {
        return None;
    }
    let cos_out = (1.0 - sin2).sqrt();
    let s = (m * cos_in - n * cos_out) / (m * cos_in + n * cos_out);
    let p = (n * cos_in - m * cos_out) / (n * cos_in + m * cos_out);
    let reflected = f32::midpoint(s * s, p * p);
    let direction = d * eta + normal * (eta * cos_in - cos_out);
    Some((reflected, 1.0 - reflected, direction))
}

/// Returns where a line meets the ellipsoid of x²·w₁ + y²·w₂ + z²·w₃ = 1, by the quadratic formula.
pub(crate) fn quadratic(o: Vec3, d: Vec3, weights: Vec3) -> Option<[f32; 2]> {
    let a = (d * d).dot(weights);
    let b = 2.0 * (o * d).dot(weights);
    let c = (o * o).dot(weights) - 1.0;
    let discriminant = b * b - 4.0 * a * c;
    let root = discriminant.sqrt();
    // NaN passes, as in the usual test.
    let misses = discriminant < 0.0;
    (!misses).then(|| [(-b - root) / (2.0 * a), (-b + root) / (2.0 * a)])
}

/// Returns a camera's ray at a mirror, as one would write it down: the mirror stands
/// at `at`, its viewpoint is `p` above, its screen `c1` above.
pub(crate) fn traced(a: f32, p: Option<f32>, c1: f32, screen: [f32; 2], at: Vec3) -> Vec3 {
    let [x, y] = screen;
    let (origin, direction) = match p {
        Some(p) => (at + Vec3::new(0.0, 0.0, -p), Vec3::new(x, y, p - c1)),
        None => (at + Vec3::new(x, y, -10.0 * a), Vec3::Z),
    };
    let direction = direction.normalize();
    let weights = Vec3::new(1.0, 1.0, 1.0 / (a * a));
    let t = quadratic(origin - at, direction, weights).map_or(f32::NAN, |t| t[0]);
    let point = origin + direction * t - at;
    let normal = (point * weights).normalize();
    direction - normal * (2.0 * direction.dot(normal))
}

/// [`traced`] at a place of the disc of a mirror about the origin.
pub(crate) fn traced_mirror(mirror: &SpheroidMirror, place: [f32; 2]) -> Vec3 {
    let screen = place.map(|x| x * mirror.screen_radius());
    let (a, p) = (mirror.axis_ratio(), mirror.viewpoint());
    traced(a, p, mirror.screen_distance(), screen, Vec3::ZERO)
}
