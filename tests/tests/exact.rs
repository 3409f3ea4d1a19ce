//! The triangle test again, with exact signs and distances in f64, apart from the core's code.

use glam::DVec2;
use shisen_core::shape::{Ray, Slabs, Triangle};

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

const ROUNDOFF: f64 = 1.0 / (1u64 << 24) as f64;

/// Decides exactly, and measures in f64, what a ray does at the triangle that its shear makes of
/// one in f32.
pub(crate) fn verdict(triangle: &Triangle, ray: &Ray) -> Verdict {
    let d = ray.direction();
    let longest = (1..3).fold(0, |b, a| if d[a].abs() > d[b].abs() { a } else { b });
    let [kx, ky, kz] = [1, 2, 0].map(|further| (longest + further) % 3);
    let (sx, sy, sz) = (d[kx] / d[kz], d[ky] / d[kz], 1.0 / d[kz]);
    let corners = triangle.0.map(|corner| corner - ray.origin());
    let depths = corners.map(|corner| f64::from(corner[kz]));
    let sheared = corners.map(|c| glam::Vec2::new(c[kx] - sx * c[kz], c[ky] - sy * c[kz]));
    // Both products of an edge function, whose value is twice the area that the edge opposite
    // each corner spans. They are exact in f64, and so is the sign of their difference.
    let products = [1, 2, 0].map(|i| {
        let (c, b) = (sheared[(i + 1) % 3].as_dvec2(), sheared[i].as_dvec2());
        DVec2::new(c.x * b.y, c.y * b.x)
    });
    let areas = products.map(|product| product.x - product.y);
    if areas.iter().any(|&area| area < 0.0) == areas.iter().any(|&area| area > 0.0) {
        return Verdict::Miss;
    }
    // Each product and the difference are rounded once, or underflow.
    let smallest = f64::from(f32::from_bits(1));
    let roundings = products.map(|p| 2.0 * (ROUNDOFF * p.abs().element_sum() + smallest));
    let sum: f64 = areas.iter().sum();
    let moment: f64 = areas.iter().zip(depths).map(|(area, z)| area * z).sum();
    let least = depths.iter().copied().fold(f64::INFINITY, f64::min);
    let most = depths.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let farthest = most.abs().max(least.abs());
    // Weights move by their areas' rounding, never out of the triangle.
    let moved = (4.0 * roundings.iter().sum::<f64>() / sum.abs()).min(1.0) * (most - least);
    // Three products of an area and a depth, and their sums, underflow.
    let rounded = 16.0 * ROUNDOFF * farthest + 3.0 * smallest / sum.abs();
    // The distance may be moved on to the triangle's box, widened.
    let [a, b, c] = triangle.0;
    let extent = [a, b, c, ray.origin()].map(|place| place.abs().max_element());
    let extent = extent.into_iter().fold(0.0, f32::max);
    let slack = f64::from(Slabs::SLACK) * ROUNDOFF * f64::from(extent);
    Verdict::Hit {
        t: moment / sum * f64::from(sz),
        error: (moved + rounded + slack) * f64::from(sz).abs() + smallest,
    }
}
