use crate::numeric::{DoubleFloat, max, sin_cos, sines_and_cosines, sqrt};
use crate::simd::{Lanes, Portable};
use core::f32::consts::TAU;
use glam::Vec3;

/// Returns the direction of a pixel by an equidistant fisheye (equation 1): the angle to −Z is half
/// the field of view (radians, above 0 to 2π) times √(u² + v²).
///
/// A unit vector within 4·10⁻⁷ in the axes of [`capture`](super). `None` outside the unit
/// disc, for another field of view and for NaN.
pub fn fisheye_equidistant(u: f32, v: f32, field_of_view: f32) -> Option<Vec3> {
    let radius = radius(u, v, field_of_view)?;
    let [[x], [y], [z]] = equidistant(Portable, [[u], [v], [radius]], field_of_view);
    Some(Vec3::new(x, y, z))
}

/// [`fisheye_equidistant`] in every lane, of (u, v) and √(u² + v²) in the disc.
#[inline(always)]
pub(crate) fn equidistant<const W: usize, L: Lanes<W>>(
    l: L,
    [u, v, radius]: [L::F; 3],
    field_of_view: f32,
) -> [L::F; 3] {
    let (sin, cos) = sines_and_cosines(l, l.mul(l.splat(0.5 * field_of_view), radius));
    let outwards = l.div(sin, radius);
    let outwards = l.select(l.le(radius, l.splat(0.0)), l.splat(0.0), outwards);
    [
        l.mul(u, outwards),
        l.mul(v, outwards),
        l.mul(l.splat(-1.0), cos),
    ]
}

/// Returns the direction of a pixel by an equisolid-angle fisheye: √(u² + v²) is in proportion to
/// the sine of half the angle to −Z. Otherwise as [`fisheye_equidistant`].
pub fn fisheye_equisolid(u: f32, v: f32, field_of_view: f32) -> Option<Vec3> {
    radius(u, v, field_of_view)?;
    let (scale, _) = sin_cos(0.25 * field_of_view);
    Some(doubled(u, v, scale))
}

/// Returns the direction of a pixel by a mirrored ball seen in parallel to its outline, all round
/// to +Z: an equisolid fisheye of 2π. A unit vector within 4·10⁻⁷ in the axes of
/// [`capture`](super); `None` outside the unit disc and for NaN.
pub fn mirror_ball(u: f32, v: f32) -> Option<Vec3> {
    radius(u, v, TAU)?;
    Some(doubled(u, v, 1.0))
}

/// √(u² + v²) where that is in the disc, of a field of view that there is.
fn radius(u: f32, v: f32, field_of_view: f32) -> Option<f32> {
    let radius = sqrt(u * u + v * v);
    (radius <= 1.0 && field_of_view > 0.0 && field_of_view <= TAU).then_some(radius)
}

/// Returns the direction at twice the angle to −Z whose sine is √(u² + v²)·`scale`.
fn doubled(u: f32, v: f32, scale: f32) -> Vec3 {
    let square = |x: f32| {
        let x = DoubleFloat::from(x).multiply(DoubleFloat::from(scale));
        x.multiply(x)
    };
    let squared = square(u).add(square(v));
    let left = DoubleFloat::from(1.0).add(squared.negate()).rounded();
    let outwards = 2.0 * scale * sqrt(max(left, 0.0));
    Vec3::new(u * outwards, v * outwards, 2.0 * squared.rounded() - 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hostile::{is_unit, with_hostile_numbers};

    #[test]
    fn any_numbers_give_unit_vectors_or_none() {
        with_hostile_numbers(|n| {
            let (u, v, angle) = (n.next(0.3), n.next(-0.4), n.next(3.0));
            let (in_disc, is_lens) = (radius(u, v, TAU), angle > 0.0 && angle <= TAU);
            for (found, is_any) in [
                (fisheye_equidistant(u, v, angle), is_lens),
                (fisheye_equisolid(u, v, angle), is_lens),
                (mirror_ball(u, v), true),
            ] {
                assert_eq!(found.is_some(), is_any && in_disc.is_some());
                found.iter().for_each(is_unit);
            }
        });
    }
}
