//! Arithmetic that gives the same bits on every machine.
//!
//! No function here uses f64, a fused multiply-add or the platform's
//! mathematics library.

mod double_float;
pub(crate) mod scalar;
mod trigonometry;

pub(crate) use double_float::DoubleFloat;
pub(crate) use scalar::{greater, largest_number, lesser, map3, smallest_number};
pub use scalar::{max, min, sqrt};
pub(crate) use trigonometry::sines_and_cosines;
pub use trigonometry::{LARGEST_ANGLE, sin_cos};

use crate::simd::{Lanes, Portable, Simd};
use core::f32::consts::FRAC_PI_2;
use core::ops::RangeInclusive;
use glam::Vec3;

/// Half the distance from 1 to the next f32: the unit roundoff, 2⁻²⁴.
pub const UNIT_ROUNDOFF: f32 = f32::EPSILON * 0.5;

/// Returns a hash of 32 bits in which each depends on all (Wellons' lowbias32, 2018).
#[inline]
pub(crate) const fn lowbias32(word: u32) -> u32 {
    let word = (word ^ word >> 16).wrapping_mul(0x7feb_352d);
    let word = (word ^ word >> 15).wrapping_mul(0x846c_a68b);
    word ^ word >> 16
}

/// Returns the largest magnitude among three components.
#[inline(always)]
pub fn largest_magnitude(v: Vec3) -> f32 {
    max(v.x.abs(), max(v.y.abs(), v.z.abs()))
}

/// `v` scaled to unit length without overflow or underflow on the way, or
/// `None` where it is zero or not finite. Error of each component ≤ 4 ulp
/// of 1.
#[inline]
pub fn normalize(v: Vec3) -> Option<Vec3> {
    // Twice the code, on targets that favour speed over size.
    if Simd::HAS_VECTORS {
        let squared = v.dot(v);
        if SQUARES.contains(&squared) {
            return Some(v / sqrt(squared));
        }
        return normalize_rare(v);
    }
    normalize_any(v)
}

#[cold]
#[inline(never)]
fn normalize_rare(v: Vec3) -> Option<Vec3> {
    normalize_any(v)
}

/// Squared lengths that imply that the largest component is in [`SQUARABLE`].
const SQUARES: RangeInclusive<f32> = 1.0e-29..=1.0e29;

/// [`normalize`] for any length.
fn normalize_any(v: Vec3) -> Option<Vec3> {
    let largest = largest_magnitude(v);
    // NaN in any component fails one of the comparisons.
    if !(largest > 0.0 && v.is_finite()) {
        return None;
    }
    let v = if SQUARABLE.contains(&largest) {
        v
    } else {
        // Subnormal lengths have no finite reciprocal: lift them first.
        let v = if largest < 1.0e-30 { v * 1.0e30 } else { v };
        v / largest_magnitude(v)
    };
    Some(v / sqrt(v.dot(v)))
}

/// Largest components of vectors whose squares can be summed.
pub(crate) const SQUARABLE: RangeInclusive<f32> = 1.0e-15..=1.0e15;

/// `v` times a power of two, its largest component from 1 to 2; `None` for zero and infinities.
pub(crate) fn scale_to_one(v: Vec3) -> Option<Vec3> {
    let largest = largest_magnitude(v);
    // NaN in any component fails one of the comparisons.
    if !(largest > 0.0 && v.is_finite()) {
        return None;
    }
    // Into the middle of the range first, so that the factor is a normal
    // number.
    let v = if largest < 1.0 {
        v * power_of_two(64)
    } else {
        v * power_of_two(-64)
    };
    let (_, exponent) = decompose(largest_magnitude(v));
    Some(v * power_of_two(-23 - exponent))
}

/// 2^exponent for exponents from −126 to 127.
const fn power_of_two(exponent: i32) -> f32 {
    f32::from_bits(((127 + exponent) as u32) << 23)
}

/// Returns the angle from the x axis to (x, y), radians, 0 to π/2, for coordinates not below zero;
/// 0 where both are. Error ≤ 1.6e-7, by atan q = q + q³·N(q²)/D(q²) with minimax quadratics.
#[inline(always)]
pub(crate) fn arctangent<const W: usize, L: Lanes<W>>(l: L, y: L::F, x: L::F) -> L::F {
    let flat = l.le(y, x);
    let (less, more) = (l.select(flat, y, x), l.select(flat, x, y));
    // The smallest number there is instead of zero: 0/0 becomes 0, and no
    // other quotient changes.
    let q = l.div(less, l.max(more, l.splat(f32::from_bits(1))));
    let z = l.mul(q, q);
    let n = l.add(l.mul(l.splat(-0.010_320_913), z), l.splat(-0.676_680_27));
    let n = l.add(l.mul(n, z), l.splat(-1.225_031_1));
    let d = l.add(z, l.splat(4.234_543_3));
    let d = l.add(l.mul(d, z), l.splat(3.675_129_4));
    let angle = l.add(q, l.mul(l.mul(q, z), l.div(n, d)));
    l.select(flat, angle, l.sub(l.splat(FRAC_PI_2), angle))
}

/// Returns the tangent of an angle from 0 to 1.57, to six digits, by Newton's method.
pub(crate) fn tangent(angle: f32) -> f32 {
    let part = angle / FRAC_PI_2;
    let mut tangent = angle / (1.0 - part * part);
    for _ in 0..5 {
        let [reached] = arctangent(Portable, [tangent], [1.0]);
        tangent = max(tangent + (angle - reached) * (1.0 + tangent * tangent), 0.0);
    }
    tangent
}

/// Returns the solutions of a·t² + 2·h·t + c = 0 in ascending order, given `discriminant` = h² −
/// a·c in a form that does not cancel. `None` if there is no real solution or a is zero; a root
/// that is too large for f32 is infinite. Neither root subtracts nearly equal numbers.
#[inline]
pub fn quadratic_roots(a: f32, h: f32, c: f32, discriminant: f32) -> Option<(f32, f32)> {
    if !(discriminant >= 0.0) || a == 0.0 {
        return None;
    }
    let root = sqrt(discriminant);
    let q = if h > 0.0 { -h - root } else { root - h };
    if q == 0.0 {
        return Some((0.0, 0.0));
    }
    let (t0, t1) = (c / q, q / a);
    Some(if t0 < t1 { (t0, t1) } else { (t1, t0) })
}

/// a·b − c·d, of finite products, with the sign exact and the value rounded once where their f32
/// difference would vanish. By integers only, for targets that emulate f64; values that
/// underflow keep their sign as the smallest subnormal.
#[cold]
pub fn difference_of_products(a: f32, b: f32, c: f32, d: f32) -> f32 {
    let plain = a * b - c * d;
    if plain != 0.0 {
        return plain;
    }
    let (left, right) = (Product::new(a, b), Product::new(c, d));
    let (sign, magnitude, exponent) = match (left.significand, right.significand) {
        (0, 0) => return 0.0,
        (_, 0) => (left.negative, left.significand, left.exponent),
        (0, _) => (!right.negative, right.significand, right.exponent),
        _ if left.negative != right.negative => (left.negative, left.significand, left.exponent),
        _ => {
            // Significands are 46 to 48 bits long. With exponents more than
            // two apart the larger product wins whatever they are, and the
            // f32 difference would not have vanished but for underflow.
            let shift = left.exponent - right.exponent;
            if shift > 2 {
                (left.negative, left.significand, left.exponent)
            } else if shift < -2 {
                (!right.negative, right.significand, right.exponent)
            } else {
                let least = left.exponent.min(right.exponent);
                let l = left.significand << (left.exponent - least);
                let r = right.significand << (right.exponent - least);
                if l == r {
                    return 0.0;
                }
                (left.negative != (l < r), l.abs_diff(r), least)
            }
        }
    };
    let value = scale_by_power_of_two(magnitude, exponent);
    let value = max(value, f32::from_bits(1));
    if sign { -value } else { value }
}

/// A product of two f32 as ±significand·2^exponent, exact.
struct Product {
    negative: bool,
    significand: u64,
    exponent: i32,
}

impl Product {
    fn new(a: f32, b: f32) -> Self {
        let (a_significand, a_exponent) = decompose(a);
        let (b_significand, b_exponent) = decompose(b);
        Self {
            negative: a.is_sign_negative() != b.is_sign_negative(),
            significand: u64::from(a_significand) * u64::from(b_significand),
            exponent: a_exponent + b_exponent,
        }
    }
}

/// |x| as a 24-bit significand and the exponent of its last bit.
fn decompose(x: f32) -> (u32, i32) {
    let bits = x.to_bits();
    let fraction = bits & 0x007f_ffff;
    let biased = (bits >> 23 & 0xff) as i32;
    if biased != 0 {
        (fraction | 0x0080_0000, biased - 150)
    } else if fraction == 0 {
        (0, 0)
    } else {
        let lift = fraction.leading_zeros() - 8;
        (fraction << lift, -149 - lift as i32)
    }
}

/// magnitude·2^exponent, rounded; at most the largest finite f32.
fn scale_by_power_of_two(magnitude: u64, exponent: i32) -> f32 {
    let mut value = magnitude as f32;
    let mut left = exponent.clamp(-400, 400);
    // Four steps at most: each factor is in the normal range.
    while left < 0 {
        let step = left.max(-120);
        value *= power_of_two(step);
        left -= step;
    }
    while left > 0 {
        let step = left.min(120);
        value *= power_of_two(step);
        left -= step;
    }
    min(value, f32::MAX)
}

/// Returns a right-handed orthonormal basis (x, y, `z`) around the unit vector `z` (Duff et al.,
/// "Building an Orthonormal Basis, Revisited", 2017).
pub fn basis_around(z: Vec3) -> (Vec3, Vec3) {
    let sign = if z.z.is_sign_negative() { -1.0 } else { 1.0 };
    let a = -1.0 / (sign + z.z);
    let b = z.x * z.y * a;
    (
        Vec3::new(1.0 + sign * z.x * z.x * a, sign * b, -sign * z.x),
        Vec3::new(b, sign + z.y * z.y * a, -z.y),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hostile::{is_unit, with_hostile_numbers};

    /// Returns the exact sign of a·b − c·d, by f64: two 48-bit products, compared.
    fn exact_sign(a: f32, b: f32, c: f32, d: f32) -> i32 {
        let (p, q) = (a as f64 * b as f64, c as f64 * d as f64);
        p.partial_cmp(&q).map_or(0, |o| o as i32)
    }

    fn sign(x: f32) -> i32 {
        x.partial_cmp(&0.0).map_or(0, |o| o as i32)
    }

    #[test]
    fn any_numbers_give_what_is_documented() {
        with_hostile_numbers(|n| {
            let [a, b, c, d] = [1.0, -3.0, 2.0, 7.0].map(|x| n.next(x));
            assert_eq!(sqrt(a).is_finite(), (0.0..f32::INFINITY).contains(&a));
            for d in [d, b * b - a * c] {
                let roots = quadratic_roots(a, b, c, d);
                assert!(roots.is_none_or(|(first, second)| !(first > second)));
            }
            if (a * b).is_finite() && (c * d).is_finite() {
                assert_eq!(
                    sign(difference_of_products(a, b, c, d)),
                    exact_sign(a, b, c, d)
                );
            }
            let (sin, cos) = sin_cos(a);
            let known = a.abs() <= LARGEST_ANGLE;
            assert_eq!(known, sin.is_finite() && cos.is_finite());
            let v = Vec3::new(a, b, c);
            let unit = normalize(v);
            assert_eq!(unit.is_some(), v.is_finite() && v != Vec3::ZERO);
            let bits = |v: Option<Vec3>| v.map(|v| v.to_array().map(f32::to_bits));
            assert_eq!(bits(unit), bits(normalize_any(v)));
            if let Some(unit) = unit {
                is_unit(&unit);
                let (x, y) = basis_around(unit);
                assert!((x.cross(y) - unit).length() < 3e-6 && x.dot(y).abs() < 2e-6);
                assert_eq!(largest_magnitude(v), v.abs().max_element());
            }
        });
    }
}
