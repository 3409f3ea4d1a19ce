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
    emission_texture: NO_TEXTURE,
    metal_texture: NO_TEXTURE,
    metalness: 0.0,
    roughness: 0.0,
    alpha_texture: NO_TEXTURE,
    alpha_cutoff: 0.0,
    opacity: 0.0,
    priority: 0,
    normal_texture: NO_TEXTURE,
    normal_scale: 0.0,
    reserved2: [0; 5],
};

/// Returns whether a point in a shape's own frame is between a material's lines, by `effects`.
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

/// Returns whether the directions of points are at most half a line's width off a meridian or a
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
