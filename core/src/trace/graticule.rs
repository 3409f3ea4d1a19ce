//! Meridians and parallels on a surface, as lines of one width.

use crate::numeric::{arctangent, sin_cos, sines_and_cosines};
use crate::scene::format::{Material, NO_MEDIUM, NO_TEXTURE, effect};
use crate::simd::{Lanes, Portable};
use core::f32::consts::{FRAC_2_PI, FRAC_PI_2};
use glam::Vec3;

/// The surface between the lines: opaque and black.
pub(crate) static BETWEEN: Material = Material {
    diffuse: [0.0; 3],
    shininess: 1.0,
    specular: [0.0; 3],
    index_of_refraction: 1.0,
    mirror: [0.0; 3],
    effects: effect::GRATICULE,
    transmission: [0.0; 3],
    texture: NO_TEXTURE,
    absorption: [0.0; 3],
    graticule_divisions: 0,
    graticule_width: 0.0,
    emission: [0.0; 3],
    medium: NO_MEDIUM,
    reserved2: [0; 7],
};

/// Whether a point in a shape's own frame is between a material's lines, by `effects`.
#[inline]
pub(super) fn is_between<const EFFECTS: u32>(
    effects: u32,
    material: &Material,
    point: Vec3,
) -> bool {
    EFFECTS & effect::GRATICULE != 0
        && material.effects & effects & effect::GRATICULE != 0
        && are_on_lines(Portable, point.to_array().map(|c| [c]), material) == 0
}

/// Whether the directions of points are at most half a line's width off a meridian or a
/// parallel about Y. Error ≤ 4·10⁻⁷ rad.
#[inline(always)]
pub(super) fn are_on_lines<const W: usize, L: Lanes<W>>(
    l: L,
    [x, y, z]: [L::F; 3],
    material: &Material,
) -> L::M {
    let half_width = 0.5 * material.graticule_width;
    let half = l.splat(half_width);
    let divisions = material.graticule_divisions as f32;
    let (x, y, z) = (l.abs(x), l.abs(y), l.abs(z));
    let squared = l.add(l.mul(x, x), l.mul(z, z));
    let across = l.sqrt(squared);
    let latitude = off_nearest(l, arctangent(l, y, across), divisions);
    let parallel = l.le(latitude, half);
    // The distance of a meridian is an angle of a great circle.
    let off = off_nearest(l, arctangent(l, x, z), divisions);
    let length = l.sqrt(l.add(squared, l.mul(y, y)));
    // The sine of up to half a quarter turn is not below 0.9 of the angle.
    let least = l.mul(across, l.mul(l.splat(0.9), off));
    if l.bits(l.le(least, l.mul(half, length))) == 0 {
        return parallel;
    }
    let (sin, _) = sines_and_cosines(l, off);
    let (widest, _) = sin_cos(half_width);
    let meridian = l.le(l.mul(across, sin), l.mul(l.splat(widest), length));
    l.or(parallel, meridian)
}

/// Distances of angles from 0 to π/2 from their nearest lines: radians.
#[inline(always)]
fn off_nearest<const W: usize, L: Lanes<W>>(l: L, angle: L::F, divisions: f32) -> L::F {
    /// Above this number f32 has no fractions.
    const WHOLE: f32 = 8_388_608.0;
    let lines = l.mul(angle, l.splat(FRAC_2_PI * divisions));
    let nearest = l.sub(l.add(lines, l.splat(WHOLE)), l.splat(WHOLE));
    let nearest = l.mul(nearest, l.splat(FRAC_PI_2 / divisions));
    l.abs(l.sub(angle, nearest))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// At a latitude and a longitude from +Z: degrees.
    fn is_line(latitude: f64, longitude: f64) -> bool {
        let (latitude, longitude) = (latitude.to_radians(), longitude.to_radians());
        let (x, z) = (libm::sin(longitude), libm::cos(longitude));
        let across = libm::cos(latitude);
        let point = Vec3::new(
            (x * across) as f32,
            libm::sin(latitude) as f32,
            (z * across) as f32,
        );
        let lines = Material {
            effects: effect::GRATICULE,
            graticule_divisions: 9,
            graticule_width: 0.3f32.to_radians(),
            ..BETWEEN
        };
        !is_between::<{ effect::GRATICULE }>(effect::GRATICULE, &lines, point * 7.0)
    }

    #[test]
    fn lines_are_every_ten_degrees_all_round() {
        // Fewer under Miri, which is slow.
        let step = if cfg!(miri) { 9 } else { 1 };
        for line in (-9..=9i32).step_by(step) {
            let latitude = 10.0 * f64::from(line);
            for longitude in [0.3, 44.9, 95.0, 183.0, -77.0] {
                for off in [-0.149, 0.0, 0.149] {
                    assert!(is_line(latitude + off, longitude));
                }
                if line.abs() < 8 {
                    let far = longitude + if longitude == 0.3 { 3.0 } else { 0.0 };
                    assert!(!is_line(latitude + 0.151, far), "{latitude} {far}");
                    assert!(!is_line(latitude - 0.151, far), "{latitude} {far}");
                }
            }
        }
        for line in (0..36).step_by(step) {
            let longitude = 10.0 * f64::from(line);
            for latitude in [-75.0, -33.0, 5.0, 64.0f64] {
                let width = 1.0 / latitude.to_radians().cos();
                for (off, expected) in [(0.0, true), (0.149, true), (0.151, false)] {
                    assert_eq!(is_line(latitude, longitude + off * width), expected);
                    assert_eq!(is_line(latitude, longitude - off * width), expected);
                }
            }
        }
    }
}
