//! Meridians and parallels on a surface, as lines of one width.

use crate::numeric::{arctangent, sin_cos, sqrt};
use crate::scene::format::{Material, effect};
use crate::simd::Portable;
use core::f32::consts::FRAC_PI_2;
use glam::Vec3;

/// What a surface is between the lines: opaque and black.
pub(super) static BETWEEN: Material = Material {
    diffuse: [0.0; 3],
    shininess: 1.0,
    specular: [0.0; 3],
    index_of_refraction: 1.0,
    mirror: [0.0; 3],
    effects: 0,
    transmission: [0.0; 3],
    reserved: 0,
    absorption: [0.0; 3],
    graticule_divisions: 0,
    graticule_width: 0.0,
    reserved2: [0; 11],
};

/// Whether a point of a shape's own frame is between the lines of a material
/// that has lines. Not from the ray, whose angle to the surface does not
/// matter: lines have the same width everywhere, seen from the origin.
#[inline]
pub(super) fn is_between(material: &Material, point: Vec3) -> bool {
    material.effects & effect::GRATICULE != 0
        && !is_on_line(
            point,
            material.graticule_divisions,
            0.5 * material.graticule_width,
        )
}

/// Whether the direction of a point, of any length but zero, is at most
/// `half_width` (radians) off a meridian or a parallel about Y, of which a
/// quarter turn has `divisions`. Error ≤ 4·10⁻⁷ rad.
///
/// The octants are each other's mirrors, and lines lie between them.
fn is_on_line(point: Vec3, divisions: u32, half_width: f32) -> bool {
    let (x, y, z) = (point.x.abs(), point.y.abs(), point.z.abs());
    let across = sqrt(x * x + z * z);
    let [latitude] = arctangent(Portable, [y], [across]);
    if off_nearest(latitude, divisions) <= half_width {
        return true;
    }
    let [longitude] = arctangent(Portable, [x], [z]);
    // The distance of a meridian is an angle of a great circle.
    let (sin, _) = sin_cos(off_nearest(longitude, divisions));
    let (widest, _) = sin_cos(half_width);
    across * sin <= widest * sqrt(across * across + y * y)
}

/// How far an angle from 0 to π/2 is from the nearest line: radians.
fn off_nearest(angle: f32, divisions: u32) -> f32 {
    let spacing = FRAC_PI_2 / divisions as f32;
    let nearest = (angle / spacing + 0.5) as u32;
    (angle - nearest as f32 * spacing).abs()
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
        is_on_line(point * 7.0, 9, 0.15f32.to_radians())
    }

    #[test]
    fn lines_are_every_ten_degrees_all_round() {
        for line in -9..=9 {
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
        for line in 0..36 {
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

    #[test]
    fn poles_are_lines_and_so_is_nothing_between_others() {
        assert!(is_line(90.0, 0.0) && is_line(-90.0, 123.0));
        assert!(!is_line(45.0, 45.0) && !is_line(-5.0, -5.0));
    }
}
