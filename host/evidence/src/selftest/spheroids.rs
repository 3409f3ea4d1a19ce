//! Lines and spheroids.

use super::exact::Meeting;
use super::input::{Inputs, aimed, single};
use super::{Case, Effort, Errors, UNIT, largest, wrong};
use glam::{DVec3, Vec3};
use shisen_core::shape::{Ray, Spheroid};
use std::f64::consts::TAU;

const EXACT: &str = "the quadratic in whole numbers, square root in f64";
const DISTANCE: &str = "of the distance, parts of (1 + distance)·2⁻²⁴ radii";
const TEXTBOOK: &str = "(−b ± √(b² − 4·a·c)) / 2·a in f32";

pub(super) const CASES: &[Case] = cases! {
    [DISTANCE, EXACT, TEXTBOOK]:
    "sphere-from-1-radius", 8.0, |effort| from_far(0, effort),
        "origin a radius away";
    "sphere-from-1e1-radii", 8.0, |effort| from_far(1, effort),
        "origin 10 radii away";
    "sphere-from-1e2-radii", 8.0, |effort| from_far(2, effort),
        "origin 100 radii away";
    "sphere-from-1e3-radii", 8.0, |effort| from_far(3, effort),
        "origin 1,000 radii away: 1 in 10⁶ is left of b² − 4·a·c";
    "sphere-from-1e4-radii", 8.0, |effort| from_far(4, effort),
        "origin 10,000 radii away: nothing is left of b² − 4·a·c";
    "sphere-from-1e5-radii", 8.0, |effort| from_far(5, effort),
        "origin 100,000 radii away";
    "sphere-from-1e6-radii", 8.0, |effort| from_far(6, effort),
        "origin a million radii away";
    "sphere-from-1e7-radii", 8.0, |effort| from_far(7, effort),
        "origin ten million radii away: neighbouring f32 are a radius apart";
    ["how far past or inside the surface a wrong verdict was, parts of (1 + distance)·2⁻²⁴ radii",
     EXACT,
     TEXTBOOK]:
    "sphere-tangent", 2.0, |effort| touching(110, effort, tangent),
        "lines within a millionth of a radius of touching balls, coins and needles of a millimetre \
         to a kilometre, from 1 to 10 radii away";
    ["how far past or inside the surface a wrong verdict was, 2⁻²⁴ radii", EXACT, TEXTBOOK]:
    "sphere-tangent-from-far", 4.0, |effort| touching(111, effort, tangent_from_far),
        "the same from 10 to 10⁷ radii away, along their axes: others f32 does not have";
    ["of both distances, 2⁻²⁴ radii over the cosine of incidence", EXACT, TEXTBOOK]:
    "sphere-from-its-surface", 8.0, |effort| largest(112, effort.of(20_000), from_surface),
        "origin on the surface of balls, coins and needles of a millimetre to a kilometre: one \
         distance is 0, or next to it";
    ["of both distances, 2⁻²⁴ radii over the chord's half", EXACT, TEXTBOOK]:
    "sphere-from-inside", 8.0, |effort| largest(113, effort.of(20_000), from_inside),
        "origin inside such bodies, next to the surface or at the centre";
    ["of the distance, parts of (1 + distance)·2⁻²⁴ radii",
     EXACT,
     "the quadratic of x²/e² + y²/p² + z²/e² = 1 in f32"]:
    "spheroid-as-a-coin", 8.0, |effort| of_ratio(114, 0.01, effort),
        "a = 0.01, from up to 1,000 radii away";
    "spheroid-as-a-needle", 8.0, |effort| of_ratio(115, 100.0, effort),
        "a = 100, from up to 1,000 radii away";
    "spheroid-of-any-size", 8.0, |effort| largest(116, effort.of(20_000), any_size),
        "radii from a micrometre to a thousand kilometres";
    "spheroid-by-any-direction", 8.0, |effort| largest(117, effort.of(20_000), any_direction),
        "directions 10⁻¹⁸ to 10¹⁸ long";
};

fn textbook(radii: [f32; 2], ray: &Ray) -> Option<[f32; 2]> {
    let [e, p] = radii;
    let weights = Vec3::new(1.0 / (e * e), 1.0 / (p * p), 1.0 / (e * e));
    crate::textbook::quadratic(ray.origin(), ray.direction(), weights)
}

/// The clearance beyond which no rounding excuses a wrong verdict.
const BEYOND_DOUBT: f64 = 0.1;

/// Compares both ways with the truth, in `unit`s of radii: the distances of right verdicts, and
/// of wrong ones how far the line is on the other side, or NaN beyond doubt.
fn check(worst: &mut Errors, radii: [f32; 2], ray: &Ray, unit: f64) {
    let exact = Meeting::new(radii, ray);
    let error = |found: Option<[f32; 2]>| match (found, exact.t) {
        (None, None) => 0.0,
        (Some(found), Some(exact_t)) => {
            let error = |i: usize| (f64::from(found[i]) - exact_t[i]).abs();
            // A NaN is not lost on the way.
            (error(0) + error(1)) * exact.speed / 2.0 / unit
        }
        _ if exact.clearance.abs() >= BEYOND_DOUBT => f64::NAN,
        _ => exact.clearance.abs() / 2.0 / unit,
    };
    let spheroid = Spheroid::new(radii[0], radii[1]);
    let ours = spheroid.and_then(|spheroid| spheroid.intersect(ray));
    worst.ours(error(ours.map(|hits| hits.t)));
    worst.naive(error(textbook(radii, ray)));
}

/// Checks a ray from `distance` radii at the middle nine tenths of a spheroid.
fn at_middle(worst: &mut Errors, inputs: &mut Inputs, radii: [f32; 2], distance: f64, length: f64) {
    let [e, p] = radii.map(f64::from);
    let scale = DVec3::new(e, p, e);
    let from = inputs.direction() * distance;
    let target = inputs.in_ball() * 0.9;
    let direction = (target - from).normalize() * length;
    let Some(ray) = Ray::new(single(from * scale), single(direction * scale)) else {
        return;
    };
    // Rounded, the line may have gone elsewhere.
    if Meeting::new(radii, &ray).clearance >= 0.19 {
        let unit = UNIT * (1.0 + distance);
        check(worst, radii, &ray, unit);
    }
}

fn from_far(exponent: u8, effort: Effort) -> Option<Errors> {
    largest(
        100 + u64::from(exponent),
        effort.of(20_000),
        |inputs, worst| {
            let distance = 1.0 + 10f64.powi(exponent.into());
            at_middle(worst, inputs, [1.0, 1.0], distance, distance);
        },
    )
}

/// Radii of balls, coins and needles, and the scale of the unit sphere to them.
fn body(inputs: &mut Inputs) -> ([f32; 2], DVec3) {
    let size = inputs.magnitude(-3.0, 3.0) as f32;
    let ratio = inputs.magnitude(-1.0, 1.0) as f32;
    let radii = match inputs.below(3) {
        0 => [size; 2],
        _ => [size, size * ratio],
    };
    let [e, p] = radii.map(f64::from);
    (radii, DVec3::new(e, p, e))
}

/// Returns the distance of a touching line from the surface, radii: on either side, 10⁻⁹ to 10⁻⁶.
fn beside(inputs: &mut Inputs) -> f64 {
    inputs.sign() * inputs.magnitude(-9.0, -6.0)
}

fn tangent(inputs: &mut Inputs) -> Option<Touching> {
    let distance = inputs.magnitude(0.0, 1.0);
    let (radii, scale) = body(inputs);
    let side = inputs.direction();
    let along = inputs.across(side);
    let foot = side * (1.0 + beside(inputs));
    let ray = aimed((foot - along * distance) * scale, foot * scale)?;
    Some((radii, ray, UNIT * (1.0 + distance)))
}

/// Along an axis a line keeps its distance from the centre, however far it begins.
fn tangent_from_far(inputs: &mut Inputs) -> Option<Touching> {
    let distance = inputs.magnitude(1.0, 7.0);
    let (radii, scale) = body(inputs);
    let (y, x) = libm::sincos(TAU * inputs.unit());
    let (side, way) = (1.0 + beside(inputs), inputs.sign());
    let turn = |v: [f64; 3], by: usize| {
        let mut v = v;
        v.rotate_right(by);
        DVec3::from_array(v)
    };
    let axis = inputs.below(3);
    let from = turn([x * side, y * side, -way * distance], axis) * scale;
    let ray = Ray::new(single(from), single(turn([0.0, 0.0, way], axis)))?;
    Some((radii, ray, UNIT))
}

/// A body's radii, a line that touches it, and the unit of a wrong verdict.
type Touching = ([f32; 2], Ray, f64);

fn touching(
    seed: u64,
    effort: Effort,
    draw: fn(&mut Inputs) -> Option<Touching>,
) -> Option<Errors> {
    wrong(seed, effort.of(20_000), 0.9, |inputs, worst| {
        let (radii, ray, unit) = draw(inputs)?;
        let exact = Meeting::new(radii, &ray);
        // Rounded, the line may have gone elsewhere.
        worst.verdicts += usize::from(exact.clearance.abs() / 2.0 < 2.0e-6);
        verdict(worst, radii, &ray, (&exact, unit));
        Some(())
    })
}

/// Checks the verdict alone: next to a tangent the distance has half the digits.
fn verdict(worst: &mut Errors, radii: [f32; 2], ray: &Ray, (exact, unit): (&Meeting, f64)) {
    let error = |hit: bool| {
        if hit == exact.t.is_some() {
            0.0
        } else {
            exact.clearance.abs() / 2.0 / unit
        }
    };
    let ours = Spheroid::new(radii[0], radii[1]).and_then(|body| body.intersect(ray));
    worst.ours(error(ours.is_some()));
    worst.naive(error(textbook(radii, ray).is_some()));
}

fn from_surface(inputs: &mut Inputs, worst: &mut Errors) {
    let (radii, scale) = body(inputs);
    let (from, direction) = (inputs.direction(), inputs.direction());
    let cosine = from.dot(direction).abs();
    let ray = Ray::new(single(from * scale), single(direction * scale));
    if let Some(ray) = ray.filter(|_| cosine > 1.0e-3) {
        check(worst, radii, &ray, UNIT / cosine);
    }
}

fn from_inside(inputs: &mut Inputs, worst: &mut Errors) -> Option<()> {
    let (radii, scale) = body(inputs);
    let depth = inputs.magnitude(-7.0, 0.0);
    let from = inputs.direction() * (1.0 - depth) * scale;
    let ray = Ray::new(single(from), single(inputs.direction() * scale))?;
    let half = Meeting::new(radii, &ray).clearance.sqrt();
    check(worst, radii, &ray, UNIT / half);
    Some(())
}

fn of_ratio(seed: u64, a: f32, effort: Effort) -> Option<Errors> {
    largest(seed, effort.of(20_000), |inputs, worst| {
        let distance = inputs.magnitude(0.1, 3.0);
        at_middle(worst, inputs, [1.0, a], distance, distance);
    })
}

fn any_size(inputs: &mut Inputs, worst: &mut Errors) {
    let size = inputs.magnitude(-5.9, 5.9);
    let ratio = inputs.magnitude(-0.1, 0.1);
    let radii = [size as f32, (size * ratio) as f32];
    let distance = inputs.magnitude(0.1, 3.0);
    at_middle(worst, inputs, radii, distance, distance);
}

fn any_direction(inputs: &mut Inputs, worst: &mut Errors) {
    let length = inputs.magnitude(-17.9, 17.9);
    let distance = inputs.magnitude(0.1, 3.0);
    at_middle(worst, inputs, [1.0, 1.5], distance, length);
}
