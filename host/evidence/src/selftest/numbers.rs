//! The basic functions of the core.

use super::input::{Inputs, single};
use super::{Case, Errors, UNIT, largest, wrong};
use glam::{DVec3, Vec3};
use shisen_core::numeric::{
    LARGEST_ANGLE, basis_around, difference_of_products, normalize, quadratic_roots, sin_cos,
};

pub(super) const CASES: &[Case] = cases! {
    ["of the unit vector, 2⁻²⁴", "f64", "v / √(v·v)"]:
    "normalise-any-length", 4.0, |effort| largest(900, effort.of(500_000), unit_vectors),
        "vectors from 10⁻⁴⁵ to 10³⁸ long";
    ["of lengths and right angles, 2⁻²⁴", "1 and 0", "Frisvad's basis of 2012 in f32"]:
    "basis-around-any-axis", 8.0, |effort| largest(901, effort.of(500_000), bases),
        "unit vectors next to −Z, where the usual basis has its pole";
    ["2⁻²⁴", "f64", "the angle less whole turns of 2π in f32, and a library's sine of the rest"]:
    "sine-and-cosine", 2.0, |effort| largest(902, effort.of(500_000), sines),
        "angles up to the largest that is defined, and next to the zeros";
    ["of the root next to 0, relative, 2⁻²⁴", "f64", "(−h + √(h² − a·c)) / a"]:
    "quadratic-with-one-root-next-to-0", 4.0, |effort| largest(903, effort.of(500_000), roots),
        "roots 10⁷ apart";
    ["wrong signs", "f64, where products of f32 are exact", "a·b − c·d in f32"]:
    "difference-of-products", 0.0, |effort| wrong(904, effort.of(500_000), 1.0, signs),
        "a·b − c·d of products that agree in all digits of f32";
};

fn unit_vectors(inputs: &mut Inputs, worst: &mut Errors) {
    let length = inputs.magnitude(-44.0, 38.0);
    let v = single(inputs.direction() * length);
    if v == Vec3::ZERO {
        return;
    }
    let exact = v.as_dvec3().normalize();
    let error = |found: Vec3| (found.as_dvec3() - exact).length() / UNIT;
    worst.ours(error(normalize(v).unwrap_or(Vec3::NAN)));
    worst.naive(error(v / v.dot(v).sqrt()));
}

fn frisvad(n: Vec3) -> (Vec3, Vec3) {
    if n.z < -0.999_999_9 {
        return (Vec3::NEG_Y, Vec3::NEG_X);
    }
    let a = 1.0 / (1.0 + n.z);
    let b = -n.x * n.y * a;
    (
        Vec3::new(1.0 - n.x * n.x * a, b, -n.x),
        Vec3::new(b, 1.0 - n.y * n.y * a, -n.y),
    )
}

fn bases(inputs: &mut Inputs, worst: &mut Errors) {
    let away = inputs.magnitude(-8.0, 0.0);
    let z = single((DVec3::NEG_Z + inputs.direction() * away).normalize());
    let error = |(x, y): (Vec3, Vec3)| {
        let [x, y, z] = [x, y, z].map(Vec3::as_dvec3);
        let dots = [x.dot(x) - 1.0, y.dot(y) - 1.0, x.dot(y), y.dot(z), z.dot(x)];
        dots.iter().fold(0.0, |most, &d| super::worse(most, d)) / UNIT
    };
    worst.ours(error(basis_around(z)));
    worst.naive(error(frisvad(z)));
}

fn reduced(angle: f32) -> (f32, f32) {
    use std::f32::consts::TAU;
    let rest = angle - TAU * (angle / TAU).round();
    (libm::sinf(rest), libm::cosf(rest))
}

fn sines(inputs: &mut Inputs, worst: &mut Errors) {
    let most = f64::from(LARGEST_ANGLE);
    let angle = if inputs.sign() < 0.0 {
        inputs.range(-most, most)
    } else {
        let quarter = std::f64::consts::FRAC_PI_2;
        let near = (inputs.range(-most, most) / quarter).round() * quarter;
        (near + inputs.sign() * inputs.magnitude(-8.0, -1.0)).clamp(-most, most)
    };
    let angle = angle as f32;
    let (sin, cos) = f64::from(angle).sin_cos();
    let error =
        |(s, c): (f32, f32)| super::worse((f64::from(s) - sin).abs(), f64::from(c) - cos) / UNIT;
    worst.ours(error(sin_cos(angle)));
    worst.naive(error(reduced(angle)));
}

fn roots(inputs: &mut Inputs, worst: &mut Errors) {
    let h = (inputs.magnitude(0.0, 3.5) * inputs.sign()) as f32;
    let c = inputs.range(0.1, 1.0) as f32;
    let discriminant = h * h - c;
    let wide = f64::from(h) * f64::from(h) - f64::from(c);
    if wide < 0.5 {
        return;
    }
    let far = -f64::from(h) - f64::from(h).signum() * wide.sqrt();
    let exact = f64::from(c) / far;
    let error = |found: f32| (f64::from(found) / exact - 1.0) / UNIT;
    let least = |a: f32, b: f32| if a.abs() < b.abs() { a } else { b };
    let ours = quadratic_roots(1.0, h, c, discriminant);
    worst.ours(error(ours.map_or(f32::NAN, |(near, far)| least(near, far))));
    let root = discriminant.sqrt();
    worst.naive(error(least(-h - root, -h + root)));
}

fn signs(inputs: &mut Inputs, verdicts: &mut Errors) {
    let [a, b] = [0; 2].map(|_| inputs.range(1.0, 2.0) as f32);
    // c·d differs from a·b in some of the last digits.
    let c = inputs.range(1.0, 2.0) as f32;
    let d = (f64::from(a) * f64::from(b) / f64::from(c)) as f32;
    let exact = f64::from(a) * f64::from(b) - f64::from(c) * f64::from(d);
    let sign = |x: f64| (x > 0.0) as i8 - (x < 0.0) as i8;
    let wrong = |found: f32| sign(f64::from(found)) != sign(exact);
    verdicts.wrong(
        wrong(difference_of_products(a, b, c, d)),
        wrong(a * b - c * d),
    );
}
