//! Rays and triangles, each alone.

use super::input::{Inputs, aimed, single};
use super::{Case, Errors, UNIT, largest, wrong};
use crate::textbook::moller_trumbore;
use glam::{DVec3, Vec3};
use shisen_core::numeric::largest_magnitude;
use shisen_core::shape::{Ray, Triangle};

const MOLLER: &str = "Möller and Trumbore's test in f32, as published";
const LINES: &str = "distances of the ray's line to the edges in f64";
const WRONG: &str = "how far from the edge a wrong verdict was, 2⁻²⁴ of the farthest coordinate";

pub(super) const CASES: &[Case] = cases! {
    [WRONG, LINES, MOLLER]:
    "triangle-slivers", 4.0, |effort| largest(202, effort.of(500_000), slivers),
        "triangles a million times as long as wide, rays next to their long sides";
    ["of the hit point from the plane, 2⁻²⁴ of the farthest coordinate, over how many times it is \
      as long as wide; a miss inside is infinite",
     "the plane in f64",
     MOLLER]:
    "triangle-slivers-distance", 2.0, |effort| largest(203, effort.of(500_000), slivers_distance),
        "the distance of triangles 10 to 10⁵ times as long as wide, seen at 0.3 rad or more";
    ["of the hit point from the plane, 2⁻²⁴ of the farthest coordinate; a miss inside is infinite",
     "the plane in f64",
     MOLLER]:
    "triangle-distance", 8.0, |effort| largest(204, effort.of(500_000), distance),
        "the distance where a triangle is seen at 10⁻⁵ to 1 rad to its plane";
    ["hits, and distances that are no numbers",
     "an edge-on triangle has no area to hit",
     "Möller and Trumbore's test in f32, without a least determinant"]:
    "triangle-in-the-rays-plane", 0.0, |effort| wrong(205, effort.of(200_000), 0.5, coplanar),
        "rays exactly in a triangle's plane, towards it";
    ["how far beside it was hit, 2⁻²⁴ of the farthest coordinate; a distance that is no number is \
      infinite",
     "the line in f64",
     MOLLER]:
    // The rounding of the reference itself.
    "triangle-without-area", 1.0e-7, |effort| largest(206, effort.of(200_000), without_area),
        "triangles that are a point or a line, rays through them";
};

/// The least determinant as published.
pub(super) const LEAST: Option<f32> = Some(1.0e-6);

fn ours(corners: [Vec3; 3], ray: &Ray) -> Option<f32> {
    let extent = corners
        .iter()
        .fold(0f32, |most, &c| most.max(largest_magnitude(c)));
    Triangle(corners).intersect(ray, extent).map(|hit| hit.t)
}

/// Returns the farthest coordinate, metres.
fn extent(corners: [Vec3; 3], ray: &Ray) -> f64 {
    let all = [corners[0], corners[1], corners[2], ray.origin()];
    all.into_iter()
        .map(|v| f64::from(largest_magnitude(v)))
        .fold(0.0, f64::max)
}

/// Returns the distance from the ray's line to the nearest edge, metres; below 0 for a line
/// outside, and then the distance to the farthest crossed edge. Off by 10⁻¹⁵ of the size of the
/// inputs.
fn margin(corners: [Vec3; 3], ray: &Ray) -> f64 {
    let corners = corners.map(Vec3::as_dvec3);
    let (o, d) = (ray.origin().as_dvec3(), ray.direction().as_dvec3());
    let side = (corners[1] - corners[0])
        .cross(corners[2] - corners[0])
        .dot(d)
        .signum();
    let margin = |i: usize| {
        let (a, b) = (corners[i], corners[(i + 1) % 3]);
        let across = (b - a).cross(d);
        (o - a).dot(across) / across.length() * -side
    };
    (0..3).map(margin).fold(
        f64::INFINITY,
        |least, m| if m.is_nan() { m } else { least.min(m) },
    )
}

/// Checks both verdicts; the error of a wrong one is the distance of the ray from the edge.
fn check_verdict(worst: &mut Errors, corners: [Vec3; 3], ray: &Ray) {
    let margin = margin(corners, ray);
    let unit = UNIT * extent(corners, ray);
    let error = |hit: Option<f32>| match hit {
        Some(t) if !t.is_finite() => f64::INFINITY,
        hit if hit.is_some() == (margin >= 0.0) => 0.0,
        _ => margin.abs() / unit,
    };
    worst.ours(error(ours(corners, ray)));
    worst.naive(error(moller_trumbore(corners, ray, LEAST)));
}

fn shuffled(inputs: &mut Inputs, corners: [DVec3; 3]) -> [Vec3; 3] {
    let first = inputs.below(3);
    [0, 1, 2].map(|i| single(corners[(first + i) % 3]))
}

fn slivers(inputs: &mut Inputs, worst: &mut Errors) {
    let along = inputs.direction();
    let across = inputs.across(along);
    let length = inputs.magnitude(0.0, 3.0);
    let at = inputs.in_ball() * length;
    let width = length * 1.0e-6;
    let tip = at + along * inputs.range(0.2, 0.8) * length + across * width;
    let corners = shuffled(inputs, [at, at + along * length, tip]);
    // Next to the long side, on either side of it, by up to three widths.
    let beside = across * width * inputs.range(-3.0, 3.0);
    let target = at + along * inputs.range(0.0, 1.0) * length + beside;
    let normal = along.cross(across);
    let from = target + (normal + 0.5 * inputs.direction()) * length * inputs.range(0.5, 3.0);
    if let Some(ray) = aimed(from, target) {
        check_verdict(worst, corners, &ray);
    }
}

fn slivers_distance(inputs: &mut Inputs, worst: &mut Errors) -> Option<()> {
    let along = inputs.direction();
    let across = inputs.across(along);
    let slimness = inputs.magnitude(1.0, 5.0);
    let at = inputs.in_ball();
    let tip = at + along * inputs.range(0.2, 0.8) + across / slimness;
    let corners = shuffled(inputs, [at, at + along, tip]);
    let [a, b, c] = corners.map(Vec3::as_dvec3);
    let normal = (b - a).cross(c - a).normalize();
    let (u, v) = (inputs.unit(), inputs.unit());
    let target = a + (b - a) * u * (1.0 - v) + (c - a) * u * v;
    let from = target + (normal + inputs.in_ball() * 0.7).normalize() * 3.0;
    let ray = aimed(from, target)?;
    let unit = UNIT * extent(corners, &ray) * slimness;
    off_the_plane(worst, corners, normal, (&ray, unit));
    Some(())
}

/// Measures the distances of hits from a triangle's plane, in units; `normal` has length 1.
fn off_the_plane(worst: &mut Errors, corners: [Vec3; 3], normal: DVec3, (ray, unit): (&Ray, f64)) {
    let off = |t: f32| {
        let point = ray.origin().as_dvec3() + ray.direction().as_dvec3() * f64::from(t);
        (point - corners[0].as_dvec3()).dot(normal) / unit
    };
    match ours(corners, ray) {
        Some(t) => worst.ours(off(t)),
        // No ray this far inside may miss.
        None if margin(corners, ray) > 8.0 * UNIT * extent(corners, ray) => {
            worst.ours(f64::INFINITY);
        }
        None => {}
    }
    if let Some(t) = moller_trumbore(corners, ray, LEAST) {
        worst.naive(off(t));
    }
}

fn distance(inputs: &mut Inputs, worst: &mut Errors) -> Option<()> {
    let corners = [0; 3].map(|_| single(inputs.in_ball()));
    let [a, b, c] = corners.map(Vec3::as_dvec3);
    let normal = (b - a).cross(c - a);
    // Triangles of a decent shape: the ray is what is hard here.
    if normal.length() < 0.1 {
        return None;
    }
    let normal = normal.normalize();
    let (u, v) = (inputs.unit(), inputs.unit());
    let target = a + (b - a) * u * (1.0 - v) + (c - a) * u * v;
    let slope = inputs.magnitude(-5.0, 0.0);
    let from = target + inputs.across(normal) * 3.0 + normal * 3.0 * slope;
    let ray = aimed(from, target)?;
    let unit = UNIT * extent(corners, &ray);
    off_the_plane(worst, corners, normal, (&ray, unit));
    Some(())
}

fn coplanar(inputs: &mut Inputs, verdicts: &mut Errors) {
    // On a grid of powers of two everything is exact, and so is the plane.
    let mut at = || (inputs.range(-64.0, 64.0).round() / 8.0) as f32;
    let flat: [[f32; 2]; 5] = [0; 5].map(|_| [at(), at()]);
    let height = at();
    let axis = inputs.below(3);
    let slope = (inputs.below(5) as f32 - 2.0) * 0.5;
    let place = |[x, y]: [f32; 2]| {
        let mut v = [x, y, height + slope * x];
        v.rotate_right(axis);
        Vec3::from_array(v)
    };
    let corners = [place(flat[0]), place(flat[1]), place(flat[2])];
    let from = place(flat[3]);
    // At a corner, at the middle or anywhere else in the plane.
    let target = match inputs.below(3) {
        0 => corners[inputs.below(3)],
        1 => (corners[0] + corners[1]) * 0.5,
        _ => place(flat[4]),
    };
    if let Some(ray) = Ray::new(from, target - from) {
        let naive = moller_trumbore(corners, &ray, None);
        verdicts.wrong(ours(corners, &ray).is_some(), naive.is_some());
    }
}

fn without_area(inputs: &mut Inputs, worst: &mut Errors) -> Option<()> {
    let mut at = || (inputs.in_ball() * 64.0).round() / 8.0;
    let (a, along) = (at(), at());
    let from = at();
    let places = match inputs.below(3) {
        0 => [0.0; 3],
        1 => [0.0, 1.0, 1.0],
        _ => [0.0, inputs.below(16) as f64 / 8.0, 1.0],
    };
    let first = inputs.below(3);
    let corners = [0, 1, 2].map(|i| single(a + along * places[(first + i) % 3]));
    let target = a + along * inputs.below(9) as f64 / 8.0;
    let ray = aimed(from, target)?;
    let unit = UNIT * extent(corners, &ray);
    // From the ray's line to what there is of the triangle.
    let beside = between_lines(&ray, corners);
    let error = |t: f32| {
        if t.is_finite() {
            beside / unit
        } else {
            f64::INFINITY
        }
    };
    if let Some(t) = ours(corners, &ray) {
        worst.ours(error(t));
    }
    if let Some(t) = moller_trumbore(corners, &ray, LEAST) {
        worst.naive(error(t));
    }
    Some(())
}

/// Returns the least distance of the ray's line from the sides of a triangle.
fn between_lines(ray: &Ray, corners: [Vec3; 3]) -> f64 {
    let (o, d) = (
        ray.origin().as_dvec3(),
        ray.direction().as_dvec3().normalize(),
    );
    // Seen along the ray, where its line is the origin.
    let flat = corners.map(|c| {
        let from = c.as_dvec3() - o;
        from - d * from.dot(d)
    });
    let to_side = |i: usize| {
        let (a, side) = (flat[i], flat[(i + 1) % 3] - flat[i]);
        let length = side.length_squared();
        let part = if length > 0.0 {
            (-a.dot(side) / length).clamp(0.0, 1.0)
        } else {
            0.0
        };
        (a + side * part).length()
    };
    (0..3).map(to_side).fold(f64::INFINITY, f64::min)
}
