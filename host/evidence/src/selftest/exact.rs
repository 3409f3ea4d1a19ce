//! A line and a spheroid in whole numbers: no rounding before the square root.

use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::{Signed, ToPrimitive};
use shisen_core::shape::Ray;

/// The meeting of a line and a spheroid about the Y axis.
pub(super) struct Meeting {
    /// 1 − |l|², l the line's closest point to the centre where the spheroid is
    /// the unit sphere: above 0 where it is met, correct to f64.
    pub(super) clearance: f64,
    /// Both distances in units of the ray's direction, the lesser first.
    pub(super) t: Option<[f64; 2]>,
    /// Length of the ray's direction in radii.
    pub(super) speed: f64,
}

impl Meeting {
    /// `equatorial` is the radius across the axis, `polar` the one along it.
    pub(super) fn new([equatorial, polar]: [f32; 2], ray: &Ray) -> Self {
        let (o, d) = (ray.origin().to_array(), ray.direction().to_array());
        // Lengths share a scale, and directions have one.
        let lengths = scale(&[o[0], o[1], o[2], equatorial, polar]);
        let steps = scale(&d);
        let [e, p] = [equatorial, polar].map(|r| square(&whole(r, lengths)));
        let weights = [&p, &e, &p];
        let o = o.map(|x| whole(x, lengths));
        let d = d.map(|x| whole(x, steps));
        // Times e²·p²: A·t² + 2·H·t + C = 0.
        let sum = |of: &dyn Fn(usize) -> BigInt| {
            of(0) * weights[0] + of(1) * weights[1] + of(2) * weights[2]
        };
        let a = sum(&|i| square(&d[i]));
        let h = sum(&|i| &o[i] * &d[i]);
        let everything = &e * &p;
        let c = sum(&|i| square(&o[i])) - &everything;
        let discriminant = square(&h) - &a * &c;
        let ratio = |n: &BigInt, d: &BigInt| BigRational::new(n.clone(), d.clone()).to_f64();
        let ratio = |n: &BigInt, d: &BigInt| ratio(n, d).unwrap_or(f64::NAN);
        // From whole steps of the direction to the ray's own.
        let unit = 2f64.powi(steps - lengths);
        let t = (!discriminant.is_negative()).then(|| {
            let middle = -ratio(&h, &a);
            let half = ratio(&discriminant, &square(&a)).sqrt();
            let far = if middle < 0.0 {
                middle - half
            } else {
                middle + half
            };
            // The lesser root by the product of both, without a difference.
            let near = if far == 0.0 { 0.0 } else { ratio(&c, &a) / far };
            let [near, far] = [near, far].map(|t| t * unit);
            [near.min(far), near.max(far)]
        });
        Self {
            clearance: ratio(&discriminant, &(&a * &everything)),
            t,
            speed: ratio(&a, &everything).sqrt() / unit,
        }
    }
}

fn square(x: &BigInt) -> BigInt {
    x * x
}

/// The power of two that makes all of these whole numbers.
fn scale(values: &[f32]) -> i32 {
    let exponents = values.iter().map(|&x| parts(x).1);
    -exponents.min().unwrap_or(0)
}

/// x·2^`scale`.
fn whole(x: f32, scale: i32) -> BigInt {
    let (significand, exponent) = parts(x);
    BigInt::from(significand) << (exponent + scale).max(0)
}

/// x as a whole number times a power of two.
fn parts(x: f32) -> (i64, i32) {
    if x == 0.0 {
        return (0, 0);
    }
    let bits = x.to_bits();
    let (exponent, fraction) = ((bits >> 23 & 0xff) as i32, i64::from(bits & 0x7f_ffff));
    let (significand, exponent) = if exponent == 0 {
        (fraction, -149)
    } else {
        (fraction | 1 << 23, exponent - 150)
    };
    let significand = if x < 0.0 { -significand } else { significand };
    (significand, exponent)
}
