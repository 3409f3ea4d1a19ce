//! A picture of all that is far away, as the background.

use super::texture::{around, at_level, interpolated};
use crate::numeric::{max, min, normalize};
use crate::scene::Scene;
use crate::scene::format::{Background, Texel};
use core::f32::consts::FRAC_1_PI;
use glam::Vec3;

/// Returns the light from a direction: the mean over about a width, in radians.
// Not inlined: several kinds of rays need it.
#[inline(never)]
pub(super) fn colour<const W: usize>(scene: &Scene<'_, W>, direction: Vec3, width: f32) -> Vec3 {
    let Background { image, turn, .. } = *scene.background();
    let Some(picture) = scene.textures.get(image as usize) else {
        return Vec3::ZERO;
    };
    let unit = normalize(direction).unwrap_or(Vec3::NEG_Z);
    let [u, v] = around(Vec3::new(unit.x, unit.y, -unit.z));
    // Each texel of a level is the mean over as wide an angle as it is high.
    let texels = width * (FRAC_1_PI * picture.height as f32);
    let last = picture.levels.saturating_sub(1) as f32;
    let level = min(libm::log2f(max(texels, 1.0)), last);
    at_level(picture, level, |level| {
        interpolated(level, scene.texels, [u + turn, v], light)
    })
}

/// Returns red, green and blue of a texel whose alpha is an exponent that they share: times
/// 2^(alpha − 136), and nothing up to an alpha of 9.
fn light([r, g, b, exponent]: Texel) -> Vec3 {
    let unit = f32::from_bits(u32::from(exponent.saturating_sub(9)) << 23);
    Vec3::new(f32::from(r), f32::from(g), f32::from(b)) * unit
}

/// Halves of the microfacets' slopes over their α, of which an eighth of a lobe each is around:
/// from the middle outwards, a golden angle apart.
const SLOPES: [[f32; 2]; 8] = [
    [0.2582, 0.0000],
    [-0.3542, 0.3245],
    [0.0589, -0.6716],
    [0.5366, 0.6999],
    [-1.1166, -0.1975],
    [1.2515, -0.7961],
    [-0.5404, 2.0103],
    [-1.7851, -3.4371],
];

/// Returns the mean over the lobe that a surface of a roughness, above 0, mirrors around a direction,
/// as if that were seen head-on (Křivánek & Colbert 2008, "Real-time shading with filtered importance
/// sampling").
#[inline(never)]
pub(super) fn blurred<const W: usize>(
    scene: &Scene<'_, W>,
    direction: Vec3,
    roughness: f32,
) -> Vec3 {
    let middle = normalize(direction).unwrap_or(Vec3::NEG_Z);
    let east = normalize(Vec3::Y.cross(middle)).unwrap_or(Vec3::X);
    let north = middle.cross(east);
    let alpha = roughness * roughness;
    let (mut sum, mut all) = (Vec3::ZERO, 0.0);
    for [x, y] in SLOPES {
        let square = x * x + y * y;
        let steepness = 1.0 / (1.0 + alpha * alpha * square);
        // The cosine to the middle, and to the surface.
        let cosine = 2.0 * steepness - 1.0;
        if cosine > 0.0 {
            let aside = (east * x + north * y) * (2.0 * alpha * steepness);
            // The side of a little less than its eighth, since interpolation widens it.
            let width = alpha * steepness * (1.0 + square);
            sum += colour(scene, middle * cosine + aside, width) * cosine;
            all += cosine;
        }
    }
    sum / all
}
