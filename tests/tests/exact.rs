//! The triangle test again, with exact signs and f64 distances: written
//! apart from the core, over the sheared f32 vertices that its documentation
//! defines.

use shisen_core::shape::{Ray, Slabs, Triangle};
use std::cmp::Ordering;

/// What a ray does at a triangle.
pub(crate) enum Verdict {
    /// Passes it, or sees it edge-on.
    Miss,
    /// Meets its plane inside it, maybe behind the ray's start.
    Hit {
        /// Distance.
        t: f64,
        /// By how much f32 may be off.
        error: f64,
    },
}

/// ±significand·2^exponent with the significand's top bit set; exact.
struct Product {
    negative: bool,
    significand: u64,
    exponent: i32,
}

impl Product {
    fn new(a: f32, b: f32) -> Option<Self> {
        let (a_negative, a_significand, a_exponent) = parts(a);
        let (b_negative, b_significand, b_exponent) = parts(b);
        let product = a_significand * b_significand;
        if product == 0 {
            return None;
        }
        let lift = product.leading_zeros();
        Some(Self {
            negative: a_negative != b_negative,
            significand: product << lift,
            exponent: a_exponent + b_exponent - lift as i32,
        })
    }

    fn sign(&self) -> Ordering {
        if self.negative {
            Ordering::Less
        } else {
            Ordering::Greater
        }
    }
}

fn parts(x: f32) -> (bool, u64, i32) {
    let bits = x.to_bits();
    let (exponent, fraction) = (bits >> 23 & 0xff, u64::from(bits & 0x7f_ffff));
    assert!(exponent != 0xff, "not finite: {x}");
    if exponent == 0 {
        (x < 0.0, fraction, -149)
    } else {
        (x < 0.0, fraction | 1 << 23, exponent as i32 - 150)
    }
}

/// The sign of a·b − c·d.
fn sign_of_difference(a: f32, b: f32, c: f32, d: f32) -> Ordering {
    match (Product::new(a, b), Product::new(c, d)) {
        (None, None) => Ordering::Equal,
        (Some(left), None) => left.sign(),
        (None, Some(right)) => right.sign().reverse(),
        (Some(left), Some(right)) if left.negative != right.negative => left.sign(),
        (Some(left), Some(right)) => {
            let larger =
                (left.exponent, left.significand).cmp(&(right.exponent, right.significand));
            if left.negative {
                larger.reverse()
            } else {
                larger
            }
        }
    }
}

const ROUNDOFF: f64 = 1.0 / (1u64 << 24) as f64;

/// Decides exactly, and measures in f64.
pub(crate) fn verdict(triangle: &Triangle, ray: &Ray) -> Verdict {
    let d = ray.direction().to_array();
    let o = ray.origin().to_array();
    let longest = (0..3).fold(0, |best, axis| {
        if d[axis].abs() > d[best].abs() {
            axis
        } else {
            best
        }
    });
    let (kx, ky, kz) = ((longest + 1) % 3, (longest + 2) % 3, longest);
    let (sx, sy, sz) = (d[kx] / d[kz], d[ky] / d[kz], 1.0 / d[kz]);
    let sheared = triangle.0.map(|corner| {
        let corner = corner.to_array();
        let [x, y, z] = [kx, ky, kz].map(|axis| corner[axis] - o[axis]);
        [x - sx * z, y - sy * z, z]
    });
    // Twice the area that the edge opposite each corner spans.
    let opposite = [1, 2, 0].map(|i| (sheared[(i + 1) % 3], sheared[i]));
    let signs = opposite.map(|(c, b)| sign_of_difference(c[0], b[1], c[1], b[0]));
    let none = |sign| signs.iter().all(|&s| s != sign);
    if signs == [Ordering::Equal; 3] || !(none(Ordering::Less) || none(Ordering::Greater)) {
        return Verdict::Miss;
    }
    let wide = |x: f32| f64::from(x);
    let areas = opposite.map(|(c, b)| wide(c[0]) * wide(b[1]) - wide(c[1]) * wide(b[0]));
    // Each product and the difference are rounded once, or underflow.
    let smallest = f64::from(f32::from_bits(1));
    let roundings = opposite.map(|(c, b)| {
        2.0 * ROUNDOFF * ((wide(c[0]) * wide(b[1])).abs() + (wide(c[1]) * wide(b[0])).abs())
            + 2.0 * smallest
    });
    let sum: f64 = areas.iter().sum();
    let depths = sheared.map(|[_, _, z]| wide(z));
    let t = areas
        .iter()
        .zip(depths)
        .map(|(area, z)| area * z)
        .sum::<f64>()
        / sum
        * wide(sz);
    let least = depths.iter().copied().fold(f64::INFINITY, f64::min);
    let most = depths.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let farthest = most.abs().max(least.abs());
    // Weights move by their areas' rounding, never out of the triangle.
    let moved = (4.0 * roundings.iter().sum::<f64>() / sum.abs()).min(1.0) * (most - least);
    // Three products of an area and a depth, and their sums, underflow.
    let rounded = 16.0 * ROUNDOFF * farthest + 3.0 * smallest / sum.abs();
    // The distance may be moved on to the triangle's box, widened.
    let extent = triangle
        .0
        .iter()
        .chain([&ray.origin()])
        .fold(0.0f32, |m, c| m.max(c.abs().max_element()));
    let slack = f64::from(Slabs::SLACK) * ROUNDOFF * wide(extent);
    Verdict::Hit {
        t,
        error: (moved + rounded + slack) * wide(sz).abs() + smallest,
    }
}
