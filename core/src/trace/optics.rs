//! Reflection, refraction and Fresnel's equations.

use crate::numeric::sqrt;
use glam::Vec3;

/// The direction mirrored about a unit normal.
#[inline]
pub fn reflect(direction: Vec3, normal: Vec3) -> Vec3 {
    direction - normal * (2.0 * direction.dot(normal))
}

/// Light at a smooth border between two clear media.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Refraction {
    /// The share of unpolarised light that is reflected, 0 to 1.
    pub reflectance: f32,
    /// The unit direction of the rest; `None` on total internal reflection.
    pub direction: Option<Vec3>,
}

/// Fresnel's equations and Snell's law, exact, for a unit `direction` and a
/// unit `normal` on the side it comes from; `ratio` is the index of
/// refraction on that side over the index beyond.
pub fn refract(direction: Vec3, normal: Vec3, ratio: f32) -> Refraction {
    let cos_in = crate::numeric::min(-direction.dot(normal), 1.0).max(0.0);
    // The part of the direction along the surface; its length is the sine
    // without the cancellation of 1 − cos² at normal incidence.
    let along = direction + normal * cos_in;
    let sin2_out = along.dot(along) * ratio * ratio;
    if !(sin2_out < 1.0) {
        return Refraction {
            reflectance: 1.0,
            direction: None,
        };
    }
    let cos_out = sqrt(1.0 - sin2_out);
    let s = (ratio * cos_in - cos_out) / (ratio * cos_in + cos_out);
    let p = (ratio * cos_out - cos_in) / (ratio * cos_out + cos_in);
    Refraction {
        reflectance: 0.5 * (s * s + p * p),
        direction: crate::numeric::normalize(along * ratio - normal * cos_out),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Reflectance and the sine beyond, in f64. Each from the sine and the
    /// cosine given: one from the other would magnify their f32 rounding.
    fn reference(sin_in: f64, cos_in: f64, ratio: f64) -> Option<(f64, f64)> {
        let sin_out = sin_in * ratio;
        (sin_out < 1.0).then(|| {
            let cos_out = (1.0 - sin_out * sin_out).sqrt();
            let s = (ratio * cos_in - cos_out) / (ratio * cos_in + cos_out);
            let p = (ratio * cos_out - cos_in) / (ratio * cos_out + cos_in);
            (f64::midpoint(s * s, p * p), sin_out)
        })
    }

    #[test]
    fn glass_at_normal_incidence_reflects_four_percent() {
        let found = refract(Vec3::NEG_Y, Vec3::Y, 1.0 / 1.5);
        assert!((found.reflectance - 0.04).abs() < 1e-7);
        assert_eq!(found.direction, Some(Vec3::NEG_Y));
    }

    #[test]
    fn beyond_the_critical_angle_all_light_is_reflected() {
        // sin 41.81° = 1 / 1.5.
        for (degrees, total) in [(41.7f32, false), (41.9, true), (60.0, true), (90.0, true)] {
            let (sin, cos) = degrees.to_radians().sin_cos();
            let found = refract(Vec3::new(sin, -cos, 0.0), Vec3::Y, 1.5);
            assert_eq!(found.direction.is_none(), total, "{degrees}");
            assert_eq!(found.reflectance == 1.0, total);
        }
    }

    #[test]
    fn matched_indices_let_everything_straight_through() {
        let direction = Vec3::new(0.6, -0.8, 0.0);
        let found = refract(direction, Vec3::Y, 1.0);
        assert!(found.reflectance < 1e-12);
        assert!((found.direction.unwrap() - direction).length() < 1e-6);
    }

    #[test]
    fn reflection_turns_the_normal_component_only() {
        assert_eq!(
            reflect(Vec3::new(1.0, -2.0, 3.0), Vec3::Y),
            Vec3::new(1.0, 2.0, 3.0)
        );
    }

    proptest! {
        #[test]
        fn agrees_with_f64(angle in 0f32..1.56, ratio in 0.4f32..2.5) {
            let (sin, cos) = angle.sin_cos();
            let found = refract(Vec3::new(sin, -cos, 0.0), Vec3::Y, ratio);
            let sine = f64::from(sin) * f64::from(ratio);
            // Within 1e-5 of the critical angle reflectance has no bound slope.
            prop_assume!((sine - 1.0).abs() > 1e-5);
            match (reference(f64::from(sin), f64::from(cos), f64::from(ratio)), found.direction) {
                (Some((reflectance, sin_out)), Some(direction)) => {
                    prop_assert!((f64::from(found.reflectance) - reflectance).abs() < 3e-4);
                    prop_assert!((f64::from(direction.x) - sin_out).abs() < 1e-6);
                    prop_assert!(direction.y < 0.0 && direction.z == 0.0);
                }
                (None, None) => prop_assert_eq!(found.reflectance, 1.0),
                other => prop_assert!(false, "{:?}", other),
            }
        }
    }
}
