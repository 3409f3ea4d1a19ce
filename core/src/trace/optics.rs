//! Reflection, refraction and Fresnel's equations.

use crate::numeric::{DoubleFloat, max, min, normalize, sqrt};
use glam::Vec3;

/// Returns the direction mirrored about a unit normal; its components at most 10¹⁸.
#[inline]
pub fn reflect(direction: Vec3, normal: Vec3) -> Vec3 {
    direction - normal * (2.0 * direction.dot(normal))
}

/// Light at a smooth border between two clear media.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Refraction {
    /// The share of unpolarised light that is reflected, 0 to 1.
    pub reflectance: f32,
    /// The share that is transmitted, 0 to 1. Where it is small it is not computed as a
    /// difference from 1, which has no digits left at grazing incidence.
    pub transmittance: f32,
    /// The unit direction of the transmitted light; `None` on total internal reflection.
    pub direction: Option<Vec3>,
}

/// Fresnel's equations and Snell's law for a unit `direction` and a unit `normal` on the side it
/// comes from; `from` is the index of refraction on that side, `to` the one beyond, both from
/// 0.01 to 100. A normal that faces away counts as at right angles: all is reflected.
///
/// Against exact arithmetic on the same cosine of incidence, relative errors are at most 2e-6 of
/// the reflectance and the transmittance, and 3e-7 of the direction.
pub fn refract(direction: Vec3, normal: Vec3, from: f32, to: f32) -> Refraction {
    let cos_in = max(min(-direction.dot(normal), 1.0), 0.0);
    // With m and n the two indices and g = n·cos θₜ: g² = n² − m² + m²·cos² θᵢ.
    let (m, n) = (from, to);
    let difference = (n - m) * (n + m);
    let a = m * cos_in;
    let mut g2 = difference + a * a;
    // Near the critical angle the difference of the two terms is mostly rounding.
    if g2.abs() < a * a * NEARLY_CRITICAL {
        g2 = nearly_critical(m, n, cos_in);
        if g2.abs() < a * a * CRITICAL {
            g2 = critical(m, n, cos_in);
        }
    }
    if !(g2 > 0.0) {
        return Refraction {
            reflectance: 1.0,
            transmittance: 0.0,
            direction: None,
        };
    }
    let g = sqrt(g2);
    // The usual quotients, widened by their denominators: every difference
    // that vanishes between equal media is in the one factor n² − m².
    let s = 1.0 / (a + g);
    let p = 1.0 / (n * n * cos_in + m * g);
    let (m2, n2) = (m * m, n * n);
    let reflected_s = difference * s * s;
    let reflected_p = difference * ((n2 + m2) * cos_in * cos_in - m2) * p * p;
    let reflected = 0.5 * (reflected_s * reflected_s + reflected_p * reflected_p);
    // The lesser share by its own formula, the greater as the rest.
    let (reflectance, transmittance) = if reflected < 0.5 {
        (reflected, 1.0 - reflected)
    } else {
        let transmitted = 2.0 * ((a * s) * (g * s) + (n * a * p) * (n * g * p));
        (1.0 - transmitted, transmitted)
    };
    // The part of the direction along the surface, whose length is the sine:
    // a sine from the cosine has no digits left at normal incidence.
    let along = direction + normal * cos_in;
    Refraction {
        reflectance,
        transmittance,
        direction: normalize(along * m - normal * g),
    }
}

/// Below this share of m²·cos² θᵢ, g² is computed with twice as many digits.
const NEARLY_CRITICAL: f32 = 0.125;

/// Below this share g² is computed exactly: of 45 bits 25 are left here.
const CRITICAL: f32 = 1.0 / 1_048_576.0;

/// n² − m² + m²·cos², good to some 45 bits of its terms.
fn nearly_critical(m: f32, n: f32, cos: f32) -> f32 {
    let difference = DoubleFloat::sum(n, -m).multiply(DoubleFloat::sum(n, m));
    let a = DoubleFloat::product(m, cos);
    difference.add(a.multiply(a)).rounded()
}

/// n² − m² + m²·cos² as if computed exactly.
#[cold]
fn critical(m: f32, n: f32, cos: f32) -> f32 {
    let a = DoubleFloat::product(m, cos);
    let squares = [
        DoubleFloat::product(n, n),
        DoubleFloat::product(m, m).negate(),
        DoubleFloat::product(a.high, a.high),
        DoubleFloat::product(2.0 * a.high, a.low),
        DoubleFloat::product(a.low, a.low),
    ];
    DoubleFloat::exact_sum(squares)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hostile::{finite, is_unit, with_hostile_numbers};
    use crate::numeric::normalize;
    use proptest::prelude::*;

    /// Returns light that comes down on a level border, at an angle of this cosine.
    fn falling(cos: f32) -> Vec3 {
        Vec3::new(sqrt((1.0 - cos) * (1.0 + cos)), -cos, 0.0)
    }

    proptest! {
        #[test]
        fn refracted_light_obeys_snell(cos in 1e-3f32..=1.0, m in 1f32..2.5, n in 1f32..2.5) {
            let direction = falling(cos);
            if let Some(refracted) = refract(direction, Vec3::Y, m, n).direction {
                prop_assert!((refracted.length() - 1.0).abs() < 3.0e-7);
                prop_assert!((refracted.x * n - direction.x * m).abs() < 2.0e-6);
                prop_assert!(refracted.y <= 0.0 && refracted.z == 0.0);
            }
        }
    }

    #[test]
    fn directions_of_any_unit_vectors_and_indices_are_unit_vectors() {
        with_hostile_numbers(|n| {
            let (direction, normal) = (n.vector([0.6, -0.8, 0.0]), n.vector([0.0, 1.0, 0.0]));
            let units = normalize(direction).zip(normalize(normal));
            let (from, to) = (n.next(1.0), n.next(1.5));
            let known = [from, to]
                .iter()
                .all(|index| (0.01..=100.0).contains(index));
            if let Some((direction, normal)) = units.filter(|_| known) {
                finite(&reflect(direction, normal));
                let all = refract(direction, normal, from, to);
                finite(&all);
                for share in [all.reflectance, all.transmittance] {
                    assert!((0.0..=1.0).contains(&share), "{all:?}");
                }
                all.direction.iter().for_each(is_unit);
            }
        });
    }
}
