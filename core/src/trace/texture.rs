//! Colours over a surface: checkers and images.

use crate::numeric::{map3, max, sqrt};
use crate::scene::Scene;
use crate::scene::format::{Material, Texel, Texture, effect};
use core::f32::consts::FRAC_1_PI;
use glam::Vec3;
use libm::floorf;

pub(super) const TEXTURES: u32 = effect::CHECKER_TEXTURE | effect::IMAGE_TEXTURE;

/// Factor of a material's colours at a place on its texture, 0 to 1.
pub(super) fn colour<const W: usize, const EFFECTS: u32>(
    scene: &Scene<'_, W>,
    material: &Material,
    coordinate: [f32; 2],
) -> Vec3 {
    let Some(texture) = scene.textures.get(material.texture as usize) else {
        return Vec3::ONE;
    };
    if EFFECTS & effect::IMAGE_TEXTURE != 0 && material.effects & effect::IMAGE_TEXTURE != 0 {
        image(texture, scene.texels, coordinate)
    } else if EFFECTS & effect::CHECKER_TEXTURE != 0 {
        checker(texture, coordinate)
    } else {
        Vec3::ONE
    }
}

/// Longitude, ½ at +Z and more towards +X, and latitude, 0 at −Y: error ≤ 3·10⁻⁷.
pub(super) fn around(point: Vec3) -> [f32; 2] {
    let across = sqrt(point.x * point.x + point.z * point.z);
    [
        0.5 + libm::atan2f(point.x, point.z) * (0.5 * FRAC_1_PI),
        0.5 + libm::atan2f(point.y, across) * FRAC_1_PI,
    ]
}

/// Returns the colour of a checker; borders belong to the cell above or to the right.
fn checker(texture: &Texture, [u, v]: [f32; 2]) -> Vec3 {
    let [across, up] = texture.repeats;
    let odd = is_odd(floorf(u * across)) != is_odd(floorf(v * up));
    Vec3::from_array(texture.colours[usize::from(odd)])
}

fn is_odd(whole: f32) -> bool {
    whole - 2.0 * floorf(0.5 * whole) == 1.0
}

/// Returns the colour of an image, interpolated in linear light; it wraps around.
fn image(texture: &Texture, texels: &[Texel], [u, v]: [f32; 2]) -> Vec3 {
    let [across, up] = texture.repeats;
    let (left, right, to_right) = beside(u * across, texture.width);
    // Rows go down.
    let (upper, lower, down) = beside(-v * up, texture.height);
    let texel = |column: u32, row: u32| {
        // Loading has checked the sides: nothing wraps.
        let number = row.wrapping_mul(texture.width).wrapping_add(column);
        let number = number.wrapping_add(texture.first_texel);
        let &[r, g, b, _] = texels.get(number as usize).unwrap_or(&[0; 4]);
        Vec3::from_array(map3([r, g, b], |code| SRGB[usize::from(code)]))
    };
    let mix = |a: Vec3, b: Vec3, share: f32| a + (b - a) * share;
    mix(
        mix(texel(left, upper), texel(right, upper), to_right),
        mix(texel(left, lower), texel(right, lower), to_right),
        down,
    )
}

/// Returns the texels on both sides of a position, and its share of the way between them.
fn beside(position: f32, count: u32) -> (u32, u32, f32) {
    let last = count.saturating_sub(1);
    // 0 to 1, either included, or NaN, which becomes the first texel.
    let turn = position - floorf(position);
    let at = turn * count as f32 - 0.5;
    let floor = floorf(at);
    let first = if floor < 0.0 {
        last
    } else {
        (floor as u32).min(last)
    };
    let second = if first == last { 0 } else { first + 1 };
    (first, second, max(at - floor, 0.0))
}

/// Light of each sRGB code (IEC 61966-2-1), the nearest f32, worked out by the compiler.
static SRGB: [f32; 256] = {
    let mut table = [0.0; 256];
    let mut code = 0;
    while code < table.len() {
        table[code] = decoded(code as f64 / 255.0) as f32;
        code += 1;
    }
    table
};

/// Returns light of a code from 0 to 1; above the dark ones to the power of 2.4.
const fn decoded(code: f64) -> f64 {
    if code <= 0.040_45 {
        return code / 12.92;
    }
    let base = (code + 0.055) / 1.055;
    let square = base * base;
    // The fifth root of the square, by Newton's method from above.
    let mut root = 1.0;
    let mut turn = 0;
    while turn < 40 {
        root -= (root - square / (root * root * root * root)) / 5.0;
        turn += 1;
    }
    square * root
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::format::texture;
    use zerocopy::FromZeros as _;

    #[test]
    fn what_is_no_number_has_a_colour() {
        let checkers = Texture {
            repeats: [8.0, 4.0],
            ..Texture::new_zeroed()
        };
        let quarter = Texture {
            kind: texture::IMAGE,
            width: 2,
            height: 2,
            repeats: [1.0; 2],
            ..Texture::new_zeroed()
        };
        let texels = [[255, 0, 0, 0], [0, 255, 0, 0], [0, 0, 255, 0], [0; 4]];
        for odd in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX, 1e38] {
            for at in [[odd, 0.3], [0.3, odd], [odd, odd]] {
                assert!(checker(&checkers, at).is_finite());
                let colour = image(&quarter, &texels, at);
                assert!(colour.is_finite() && colour.min_element() >= 0.0, "{at:?}");
            }
        }
        // Too few texels are black, not read past their end.
        assert_eq!(image(&quarter, &texels[..0], [0.3; 2]), Vec3::ZERO);
    }
}
