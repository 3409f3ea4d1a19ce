//! Light at the border of clear bodies.

use super::input::Inputs;
use super::{Case, Effort, Errors, UNIT, largest};
use crate::textbook::{Shares, exact_refraction, textbook_refraction};
use glam::{DVec2, Vec3};
use shisen_core::trace::{Refraction, refract};

const F64: &str = "Fresnel's equations in f64, by forms that do not cancel";
const TEXTBOOK: &str = "η·d + (η·cos θᵢ − cos θₜ)·n and 1 − R in f32";
const OF_LIGHT: &str = "of the reflected and the transmitted share, relative; a wrong verdict \
                        on total reflection is infinite";

const SNELL: &str = "Snell's law in f64";
const OF_DIRECTION: &str =
    "of the refracted ray, 2⁻²⁴ rad; a wrong verdict on total reflection is infinite";

/// The bound that the documentation of `refract` states.
const BOUND: f64 = 2.0e-6;
const DIRECTION_BOUND: f64 = 3.0e-7 / UNIT;

pub(super) const CASES: &[Case] = cases! {
    [OF_LIGHT, F64, TEXTBOOK]:
    "refraction-at-the-critical-angle", BOUND, |effort| drawn(700, effort, at_critical, shares),
        "cosines that are the critical one or up to three f32 beside it";
    "refraction-just-under-the-critical-angle", BOUND,
        |effort| drawn(701, effort, under_critical, shares),
        "10⁻⁷ to 10⁻² under it: little gets through, nearly level";
    "refraction-just-over-the-critical-angle", BOUND,
        |effort| drawn(702, effort, over_critical, nothing_through),
        "10⁻⁷ to 10⁻² over it: nothing gets through";
    "refraction-grazing", BOUND, |effort| drawn(703, effort, grazing, shares),
        "cosines of incidence from 10⁻⁷ to 10⁻²: 1 − R has no digits left";
    "refraction-of-matched-media", BOUND, |effort| drawn(704, effort, matched, shares),
        "indices that differ by 10⁻⁷ to 10⁻³: R is the square of next to nothing";
    [OF_DIRECTION, SNELL, TEXTBOOK]:
    "refracted-ray-at-the-critical-angle", DIRECTION_BOUND,
        |effort| drawn(707, effort, next_to_critical, directions),
        "cosines that are the critical one to a hundredth over it: the ray leaves nearly level";
    "refracted-ray-grazing", DIRECTION_BOUND, |effort| drawn(708, effort, grazing, directions),
        "cosines of incidence from 10⁻⁷ to 10⁻², into denser media";
    "refracted-ray-of-matched-media", DIRECTION_BOUND,
        |effort| drawn(709, effort, matched_at_any_angle, directions),
        "indices that differ by 10⁻⁷ to 10⁻³, from the normal to a cosine of 10⁻³";
    ["of the refracted ray's slope, relative, 2⁻²⁴",
     SNELL,
     "angles: sin⁻¹(η·sin(cos⁻¹(−d·n))) in f32"]:
    "refraction-next-to-the-normal", 8.0, |effort| largest(705, effort.of(200_000), next_to_normal),
        "rays within 10⁻⁷ to 10⁻² of the normal: the sine from a cosine of 1";
    ["of R from 1 and of T from 0, and of the direction's length from 1",
     "a normal that is taken for one at right angles to the ray: all is reflected",
     TEXTBOOK]:
    "refraction-with-inside-out-normals", 4.0 * UNIT, |effort| largest(706, effort.of(200_000), inside_out),
        "a normal that faces away from the ray, as an interpolated one may";
};

/// Returns a direction down to a level border at an angle of this cosine.
fn falling(cos: f32) -> Vec3 {
    let sin = (1.0 - f64::from(cos) * f64::from(cos)).max(0.0).sqrt();
    Vec3::new(sin as f32, -cos, 0.0)
}

fn shares(worst: &mut Errors, cos: f32, m: f32, n: f32) {
    let expected = exact_refraction(cos.into(), m.into(), n.into());
    let error = |found: Shares| match (found, expected) {
        (None, None) => 0.0,
        (Some(found), Some(expected)) => {
            let relative = |found: f64, exact: f64| {
                if exact == 0.0 {
                    found.abs()
                } else {
                    (found / exact - 1.0).abs()
                }
            };
            super::worse(relative(found.0, expected.0), relative(found.1, expected.1))
        }
        _ => f64::INFINITY,
    };
    let d = falling(cos);
    let Refraction {
        reflectance,
        transmittance,
        direction,
    } = refract(d, Vec3::Y, m, n);
    let found = direction.map(|_| (f64::from(reflectance), f64::from(transmittance)));
    worst.ours(error(found));
    // Total reflection keeps all light.
    if direction.is_none() {
        worst.ours(f64::from(reflectance) - 1.0);
        worst.ours(transmittance.into());
    }
    let naive = textbook_refraction(d, Vec3::Y, m, n);
    worst.naive(error(naive.map(|(r, t, _)| (f64::from(r), f64::from(t)))));
}

/// Checks [`shares`] of total reflection; the case is broken where light gets through.
fn nothing_through(worst: &mut Errors, cos: f32, m: f32, n: f32) {
    if exact_refraction(cos.into(), m.into(), n.into()).is_some() {
        worst.ours(f64::NAN);
        worst.naive(f64::NAN);
    }
    shares(worst, cos, m, n);
}

fn directions(worst: &mut Errors, cos: f32, m: f32, n: f32) {
    let d = falling(cos);
    let (cos, from, to) = (f64::from(cos), f64::from(m), f64::from(n));
    let g2 = (to - from) * (to + from) + (from * cos) * (from * cos);
    // Both components times the index beyond: m·sin θᵢ = n·sin θₜ and n·cos θₜ.
    let exact = (g2 > 0.0).then(|| DVec2::new(from * f64::from(d.x), -g2.sqrt()));
    let error = |found: Option<Vec3>| match (found.map(Vec3::as_dvec3), exact) {
        (None, None) => 0.0,
        (Some(found), Some(exact)) => found.truncate().angle_to(exact) / UNIT + found.z.abs(),
        _ => f64::INFINITY,
    };
    worst.ours(error(refract(d, Vec3::Y, m, n).direction));
    worst.naive(error(
        textbook_refraction(d, Vec3::Y, m, n).map(|found| found.2),
    ));
}

/// A cosine of incidence and the indices before and beyond the border.
type Drawn = (f32, f32, f32);

fn drawn(
    seed: u64,
    effort: Effort,
    draw: fn(&mut Inputs) -> Drawn,
    check: fn(&mut Errors, f32, f32, f32),
) -> Option<Errors> {
    largest(seed, effort.of(200_000), |inputs, worst| {
        let (cos, m, n) = draw(inputs);
        check(worst, cos, m, n);
    })
}

/// Water, glasses and diamond in air.
fn index(inputs: &mut Inputs) -> f32 {
    [1.333_403, 1.458_464, 1.5168, 1.784_72, 2.417_486][inputs.below(5)]
}

/// Returns the cosine at which light of an index stays inside.
fn critical(index: f32) -> f64 {
    let sine = 1.0 / f64::from(index);
    (1.0 - sine * sine).sqrt()
}

fn at_critical(inputs: &mut Inputs) -> Drawn {
    let index = inputs.range(1.0003, 3.0) as f32;
    let mut cos = critical(index) as f32;
    for _ in 0..inputs.below(4) {
        cos = cos.next_down();
    }
    for _ in 0..inputs.below(7) {
        cos = cos.next_up();
    }
    (cos, index, 1.0)
}

fn under_critical(inputs: &mut Inputs) -> Drawn {
    beside_critical(inputs, 1.0)
}

fn over_critical(inputs: &mut Inputs) -> Drawn {
    beside_critical(inputs, -1.0)
}

/// `side` is 1 for steeper rays, of which some light gets through, and −1 for flatter ones.
fn beside_critical(inputs: &mut Inputs, side: f64) -> Drawn {
    let index = index(inputs);
    let off = side * inputs.magnitude(-7.0, -2.0);
    ((critical(index) * (1.0 + off)) as f32, index, 1.0)
}

fn next_to_critical(inputs: &mut Inputs) -> Drawn {
    match inputs.below(2) {
        0 => at_critical(inputs),
        _ => under_critical(inputs),
    }
}

fn grazing(inputs: &mut Inputs) -> Drawn {
    (inputs.magnitude(-7.0, -2.0) as f32, 1.0, index(inputs))
}

/// Far from Brewster's angle, where one of two squares is 0.
fn matched(inputs: &mut Inputs) -> Drawn {
    let (m, n) = nearly_same(inputs);
    (inputs.range(0.8, 1.0) as f32, m, n)
}

fn matched_at_any_angle(inputs: &mut Inputs) -> Drawn {
    let (m, n) = nearly_same(inputs);
    (inputs.magnitude(-3.0, 0.0) as f32, m, n)
}

fn nearly_same(inputs: &mut Inputs) -> (f32, f32) {
    let m = index(inputs);
    let n = m * (1.0 + inputs.magnitude(-7.0, -3.0) as f32);
    if inputs.sign() < 0.0 { (m, n) } else { (n, m) }
}

fn next_to_normal(inputs: &mut Inputs, worst: &mut Errors) {
    let slope = inputs.magnitude(-7.0, -2.0) as f32;
    let d = Vec3::new(slope, -1.0, 0.0).normalize();
    let (m, n) = (1.0, index(inputs));
    let sine = f64::from(d.x) / f64::from(d.x).hypot(f64::from(d.y)) / f64::from(n);
    let expected = sine / (1.0 - sine * sine).sqrt();
    let relative = |found: f64| (found / expected - 1.0) / UNIT;
    let ours = refract(d, Vec3::Y, m, n).direction.unwrap_or(Vec3::NAN);
    worst.ours(relative(-f64::from(ours.x) / f64::from(ours.y)));
    let angle = (m / n * (-d.dot(Vec3::Y)).acos().sin()).asin();
    worst.naive(relative(f64::from(angle.tan())));
}

fn inside_out(inputs: &mut Inputs, worst: &mut Errors) {
    let cos = -inputs.magnitude(-7.0, 0.0) as f32;
    let (m, n) = if inputs.sign() < 0.0 {
        (1.0, index(inputs))
    } else {
        (index(inputs), 1.0)
    };
    let d = falling(cos);
    let found = refract(d, Vec3::Y, m, n);
    worst.ours(f64::from(found.reflectance) - 1.0);
    worst.ours(found.transmittance.into());
    if let Some(direction) = found.direction {
        worst.ours(direction.as_dvec3().length() - 1.0);
    }
    if let Some((r, t, direction)) = textbook_refraction(d, Vec3::Y, m, n) {
        worst.naive(f64::from(r) - 1.0);
        worst.naive(t.into());
        worst.naive(direction.as_dvec3().length() - 1.0);
    }
}
