//! Reflection, refraction and Fresnel's equations.

use crate::numeric::{DoubleFloat, max, min, normalize, sqrt};
use glam::Vec3;

/// The direction mirrored about a unit normal; its components at most 10¹⁸.
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
    use crate::hostile::{finite, is_unit, torment};
    use crate::numeric::normalize;
    use proptest::prelude::*;

    /// Reflectance and transmittance in f64; `None` beyond the critical angle.
    fn reference(cos: f64, m: f64, n: f64) -> Option<(f64, f64)> {
        let g2 = (n - m) * (n + m) + (m * cos) * (m * cos);
        if g2 < 0.0 {
            return None;
        }
        let (g, difference) = (libm::sqrt(g2), (n - m) * (n + m));
        let (s, p) = (m * cos + g, n * n * cos + m * g);
        let reflected_s = difference / (s * s);
        let reflected_p = difference * ((n * n + m * m) * cos * cos - m * m) / (p * p);
        Some((
            f64::midpoint(reflected_s * reflected_s, reflected_p * reflected_p),
            2.0 * m * cos * g * (1.0 / (s * s) + n * n / (p * p)),
        ))
    }

    /// Light that comes down on a level border, at an angle of this cosine.
    fn falling(cos: f32) -> Vec3 {
        Vec3::new(sqrt((1.0 - cos) * (1.0 + cos)), -cos, 0.0)
    }

    /// Relative errors of reflectance and transmittance.
    fn errors(cos: f32, m: f32, n: f32) -> Option<(f64, f64)> {
        let found = refract(falling(cos), Vec3::Y, m, n);
        let expected = reference(f64::from(cos), f64::from(m), f64::from(n));
        assert_eq!(
            found.direction.is_some(),
            expected.is_some(),
            "{cos} {m} {n}"
        );
        let Some((r, t)) = expected else {
            assert_eq!((found.reflectance, found.transmittance), (1.0, 0.0));
            return None;
        };
        let sum = f64::from(found.reflectance) + f64::from(found.transmittance);
        assert!((sum - 1.0).abs() < 1.0e-7, "{cos} {m} {n}: {found:?}");
        let error = |found: f32, exact: f64| (f64::from(found) / exact - 1.0).abs();
        Some((error(found.reflectance, r), error(found.transmittance, t)))
    }

    /// Glass, water, diamond, air, and what is nearly nothing.
    const INDICES: [f32; 8] = [
        1.333_403, 1.458_464, 1.5168, 1.78472, 2.417_486, 1.0003, 1.000_01, 100.0,
    ];

    #[test]
    fn shares_are_fresnels_at_every_angle_and_next_to_the_critical_one() {
        // Fewer under Miri, which is slow.
        let steps = if cfg!(miri) { 5 } else { 4000 };
        for index in INDICES {
            for (m, n) in [(1.0, index), (index, 1.0)] {
                let grazing = [1.0e-4, 1.0e-6, 1.0e-9, 1.0e-15];
                for cos in grazing
                    .into_iter()
                    .chain((1..=steps).map(|i| i as f32 / steps as f32))
                {
                    if let Some((r, t)) = errors(cos, m, n) {
                        assert!(r <= 2.0e-6 && t <= 2.0e-6, "{cos} {m} {n}: {r} {t}");
                    }
                }
            }
            let n = f64::from(index);
            let critical = libm::sqrt((n - 1.0) * (n + 1.0)) / n;
            for delta in [1.0e-3, 1.0e-5, 2.0e-7, -2.0e-7, -1.0e-5] {
                let cos = (critical + delta) as f32;
                if let Some((r, _)) = errors(cos.clamp(0.0, 1.0), index, 1.0) {
                    assert!(r <= 2.0e-6, "{delta} {index}: {r}");
                }
            }
        }
    }

    #[test]
    fn light_near_the_normal_keeps_its_direction() {
        for angle in [1.0e-2f32, 1.0e-3, 1.0e-4, 1.0e-6, 1.0e-12] {
            for (m, n) in [(1.0, 1.5), (1.5, 1.0)] {
                // The cosine rounds to 1; the sine is in the vector.
                let direction = Vec3::new(angle, -sqrt(1.0 - angle * angle), 0.0);
                let found = refract(direction, Vec3::Y, m, n).direction.unwrap();
                let expected = f64::from(angle) * f64::from(m) / f64::from(n);
                let error = f64::from(found.x) / expected - 1.0;
                assert!(error.abs() < 3.0e-7, "{angle} {m} {n}: {error}");
            }
        }
    }

    #[test]
    fn matched_indices_let_everything_straight_through() {
        for index in [1.0, 0.01, 1.7, 100.0] {
            for cos in [1.0, 0.8, 1.0e-3, 1.0e-8] {
                let direction = falling(cos);
                let found = refract(direction, Vec3::Y, index, index);
                assert_eq!(found.reflectance, 0.0, "{index} {cos}");
                assert!((found.transmittance - 1.0).abs() < 3.0e-7);
                assert!((found.direction.unwrap() - direction).length() < 1e-6);
            }
            // Along the border itself there is no other side.
            for cos in [0.0, 1.0e-30] {
                let found = refract(falling(cos), Vec3::Y, index, index);
                assert!(found.reflectance + found.transmittance == 1.0, "{found:?}");
            }
        }
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
        torment(|n| {
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
