//! A line and a spheroid in whole numbers: no rounding before the square root.

use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::{FromPrimitive, Signed, ToPrimitive};
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
        let [e, p] = [equatorial, polar].map(|r| square(&whole(r)));
        let weights = [&p, &e, &p];
        let (o, d) = (o.map(whole), d.map(whole));
        // Times e²·p²: A·t² + 2·H·t + C = 0.
        let sum = |of: &dyn Fn(usize) -> BigInt| {
            of(0) * weights[0] + of(1) * weights[1] + of(2) * weights[2]
        };
        let a = sum(&|i| square(&d[i]));
        let h = sum(&|i| &o[i] * &d[i]);
        let everything = &e * &p;
        let c = sum(&|i| square(&o[i])) - &everything;
        let discriminant = square(&h) - &a * &c;
        let ratio = |n: &BigInt, d: &BigInt| {
            let ratio = BigRational::new(n.clone(), d.clone()).to_f64();
            ratio.unwrap_or(f64::NAN)
        };
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
            [near.min(far), near.max(far)]
        });
        Self {
            clearance: ratio(&discriminant, &(&a * &everything)),
            t,
            speed: ratio(&a, &everything).sqrt(),
        }
    }
}

fn square(x: &BigInt) -> BigInt {
    x * x
}

/// x·2¹⁴⁹, of which every f32 is a whole number.
fn whole(x: f32) -> BigInt {
    BigInt::from_f64(f64::from(x) * 2f64.powi(149)).unwrap_or_default()
}
