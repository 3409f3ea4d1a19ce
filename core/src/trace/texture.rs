//! Colours over a surface: checkers and images.

use crate::numeric::{map3, max, min, sqrt};
use crate::scene::format::{Texel, Texture, effect, reading, texture as kind, wrap};
use crate::scene::{EffectSet, Scene};
use core::f32::consts::FRAC_1_PI;
use core::ops::{Add, Mul, Sub};
use glam::Vec3;
use libm::floorf;

pub(super) const TEXTURES: u32 = effect::CHECKER_TEXTURE | effect::IMAGE_TEXTURE;

/// Returns the colour of a texture, 0 to 1, at a surface's first or second coordinates; `effects`
/// are bits of the effects to consider, and `extent` returns the box that a pixel sees of the first
/// or second coordinates.
pub(super) fn colour<const W: usize, const EFFECTS: u32>(
    scene: &Scene<'_, W>,
    number: u32,
    effects: u32,
    coordinates: &[[f32; 2]; 2],
    extent: impl FnOnce(&Texture, bool) -> [f32; 2],
) -> Vec3 {
    let effects = effects & EFFECTS;
    let Some(texture) = scene.textures.get(number as usize) else {
        return Vec3::ONE;
    };
    if effects & texture.effects() & TEXTURES == 0 {
        return Vec3::ONE;
    }
    let [first, second] = *coordinates;
    let is_second = texture.reading & reading::SECOND != 0;
    let place = mapped(texture, if is_second { second } else { first });
    if EFFECTS & effects & effect::TEXTURE_LEVELS != 0 && texture.levels != 1 {
        mean_over(texture, scene.texels, place, extent(texture, is_second))
    } else if EFFECTS & effect::IMAGE_TEXTURE != 0 && texture.kind == kind::IMAGE {
        image(texture, scene.texels, place)
    } else if EFFECTS & effect::CHECKER_TEXTURE != 0 {
        checker(texture, place)
    } else {
        Vec3::ONE
    }
}

/// Returns the alpha of an image, 0 to 1, at a surface's first or second coordinates; 1 without an
/// image.
pub(super) fn alpha<const W: usize, const EFFECTS: u32>(
    scene: &Scene<'_, W>,
    number: u32,
    effects: u32,
    coordinates: &[[f32; 2]; 2],
) -> f32 {
    let is_there = EFFECTS & effects & effect::IMAGE_TEXTURE != 0;
    let texture = scene.textures.get(number as usize);
    let Some(texture) = texture.filter(|one| is_there && one.kind == kind::IMAGE) else {
        return 1.0;
    };
    let [first, second] = *coordinates;
    let is_second = texture.reading & reading::SECOND != 0;
    let place = mapped(texture, if is_second { second } else { first });
    interpolated(texture, scene.texels, place, |[.., alpha]| {
        f32::from(alpha) / 255.0
    })
}

/// Returns the place on a texture of a surface's first or second coordinates.
pub(super) fn place<const W: usize>(
    scene: &Scene<'_, W>,
    number: u32,
    coordinates: &[[f32; 2]; 2],
) -> Option<[f32; 2]> {
    let texture = scene.textures.get(number as usize)?;
    let [first, second] = *coordinates;
    let is_second = texture.reading & reading::SECOND != 0;
    Some(mapped(texture, if is_second { second } else { first }))
}

/// Most texels along each side of the box that a mean is taken of.
const MOST_OF_MEAN: u32 = 8;

/// Returns the mean colour of a texture over a box around a place: exact of a checker, of an image
/// by its levels where `effects` has them, else of up to [`MOST_OF_MEAN`]² points.
pub(crate) fn mean<const W: usize>(
    scene: &Scene<'_, W>,
    effects: EffectSet,
    number: u32,
    [u, v]: [f32; 2],
    [du, dv]: [f32; 2],
) -> Vec3 {
    let Some(texture) = scene.textures.get(number as usize) else {
        return Vec3::ONE;
    };
    if texture.levels != 1 && effects.contains(EffectSet::TEXTURE_LEVELS) {
        return mean_over(texture, scene.texels, [u, v], [du, dv]);
    }
    if texture.kind == kind::IMAGE {
        let count =
            |extent: f32, side: u32| (min(extent * side as f32, 64.0) as u32 + 1).min(MOST_OF_MEAN);
        let (columns, rows) = (count(du, texture.width), count(dv, texture.height));
        let mut sum = Vec3::ZERO;
        for row in 0..rows {
            for column in 0..columns {
                let at = |middle: f32, extent: f32, n: u32, of: u32| {
                    middle + extent * ((n as f32 + 0.5) / of as f32 - 0.5)
                };
                let place = [at(u, du, column, columns), at(v, dv, row, rows)];
                sum += image(texture, scene.texels, place);
            }
        }
        return sum / (columns * rows) as f32;
    }
    checker_over(texture, [u, v], [du, dv])
}

/// Returns the mean colour over about the area of a box: exact of a checker, and of an image between
/// the two levels whose texels are next smaller and larger.
fn mean_over(texture: &Texture, texels: &[Texel], place: [f32; 2], [du, dv]: [f32; 2]) -> Vec3 {
    if texture.kind != kind::IMAGE {
        return checker_over(texture, place, [du, dv]);
    }
    let area = du * texture.width as f32 * (dv * texture.height as f32);
    let level = min(
        0.5 * libm::log2f(max(area, 1.0)),
        texture.levels.saturating_sub(1) as f32,
    );
    at_level(texture, level, |level| image(level, texels, place))
}

/// Returns what is read between the two levels of an image that are next to a level.
#[inline(always)]
pub(super) fn at_level(texture: &Texture, level: f32, read: impl Fn(&Texture) -> Vec3) -> Vec3 {
    let (first, share) = (level as u32, level - floorf(level));
    let colour = |level: u32| {
        let ([width, height], first) = texture.level(level);
        let level = Texture {
            width,
            height,
            first_texel: texture.first_texel.wrapping_add(first),
            ..*texture
        };
        read(&level)
    };
    let fine = colour(first);
    if share > 0.0 {
        fine + (colour(first + 1) - fine) * share
    } else {
        fine
    }
}

/// Returns the mean colour of a checker over a box.
fn checker_over(texture: &Texture, [u, v]: [f32; 2], [du, dv]: [f32; 2]) -> Vec3 {
    let even = 0.5 + 0.5 * mean_wave(u, du) * mean_wave(v, dv);
    let [first, second] = texture.colours.map(Vec3::from_array);
    second + (first - second) * even
}

/// Returns the mean over an interval of a wave that is 1 in even cells and −1 in odd ones.
fn mean_wave(middle: f32, extent: f32) -> f32 {
    if !(extent > 1.0e-5) {
        return if is_odd(floorf(middle)) { -1.0 } else { 1.0 };
    }
    let integral = |x: f32| {
        let turn = x - 2.0 * floorf(0.5 * x);
        min(turn, 2.0 - turn)
    };
    let half = 0.5 * extent;
    (integral(middle + half) - integral(middle - half)) / extent
}

/// Returns the box that a pixel of a width, in metres, sees of a texture, by the gradients of a
/// surface's coordinates: per metre.
pub(super) fn extent(texture: &Texture, [u, v]: [Vec3; 2], width: f32) -> [f32; 2] {
    let [[au, bu], [av, bv], _] = texture.map;
    [u * au + v * av, u * bu + v * bv].map(|along| sqrt(along.dot(along)) * width)
}

/// Returns a surface's coordinates as a texture has them.
fn mapped(texture: &Texture, [u, v]: [f32; 2]) -> [f32; 2] {
    let [[au, bu], [av, bv], [a, b]] = texture.map;
    [au * u + av * v + a, bu * u + bv * v + b]
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
    let odd = is_odd(floorf(u)) != is_odd(floorf(v));
    Vec3::from_array(texture.colours[usize::from(odd)])
}

fn is_odd(whole: f32) -> bool {
    whole - 2.0 * floorf(0.5 * whole) == 1.0
}

/// Returns the colour of an image: interpolated in linear light, or of the nearest texel.
fn image(texture: &Texture, texels: &[Texel], place: [f32; 2]) -> Vec3 {
    let is_linear = texture.reading & reading::LINEAR != 0;
    interpolated(texture, texels, place, |[r, g, b, _]| {
        Vec3::from_array(map3([r, g, b], |code| {
            if is_linear {
                f32::from(code) / 255.0
            } else {
                SRGB[usize::from(code)]
            }
        }))
    })
}

/// Returns what `read` makes of an image's texels: interpolated, or of the nearest texel.
#[inline(always)]
pub(super) fn interpolated<T>(
    texture: &Texture,
    texels: &[Texel],
    [u, v]: [f32; 2],
    read: impl Fn(Texel) -> T,
) -> T
where
    T: Copy + Add<Output = T> + Sub<Output = T> + Mul<f32, Output = T>,
{
    let is_nearest = texture.reading & reading::NEAREST != 0;
    let [across, up] = texture.wrap;
    // Rows go down.
    let from_top = if up == wrap::REPEAT { -v } else { 1.0 - v };
    let (left, right, to_right) = beside(u, texture.width, across, is_nearest);
    let (upper, lower, down) = beside(from_top, texture.height, up, is_nearest);
    let texel = |column: u32, row: u32| {
        // Loading has checked the sides: nothing wraps.
        let number = row.wrapping_mul(texture.width).wrapping_add(column);
        let number = number.wrapping_add(texture.first_texel);
        read(*texels.get(number as usize).unwrap_or(&[0; 4]))
    };
    if is_nearest {
        return texel(left, upper);
    }
    let mix = |a: T, b: T, share: f32| a + (b - a) * share;
    mix(
        mix(texel(left, upper), texel(right, upper), to_right),
        mix(texel(left, lower), texel(right, lower), to_right),
        down,
    )
}

/// Returns the texels on both sides of a position, and its share of the way between them; for the
/// nearest, that texel first.
fn beside(position: f32, count: u32, way: u32, is_nearest: bool) -> (u32, u32, f32) {
    let last = count.saturating_sub(1);
    // 0 to 1, either included, or NaN, which becomes the first texel.
    let turn = match way {
        wrap::REPEAT => position - floorf(position),
        wrap::MIRROR => {
            let turn = position - 2.0 * floorf(0.5 * position);
            min(turn, 2.0 - turn)
        }
        _ => min(max(position, 0.0), 1.0),
    };
    let at = turn * count as f32;
    if is_nearest {
        let nearest = (at as u32).min(last);
        return (nearest, nearest, 0.0);
    }
    let at = at - 0.5;
    let floor = floorf(at);
    let (before, after) = if way == wrap::REPEAT {
        (last, 0)
    } else {
        (0, last)
    };
    let (first, second) = if floor < 0.0 {
        (before, 0)
    } else {
        let first = (floor as u32).min(last);
        (first, if first == last { after } else { first + 1 })
    };
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
    use zerocopy::FromZeros as _;

    #[test]
    fn what_is_no_number_has_a_colour() {
        let checkers = Texture::new_zeroed();
        let quarter = Texture {
            kind: kind::IMAGE,
            width: 2,
            height: 2,
            ..checkers
        };
        let texels = [[255, 0, 0, 0], [0, 255, 0, 0], [0, 0, 255, 0], [0; 4]];
        for odd in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX, 1e38] {
            for at in [[odd, 0.3], [0.3, odd], [odd, odd]] {
                assert!(checker(&checkers, at).is_finite());
                for (way, reading) in [(0, 0), (1, 0), (2, 0), (0, 1), (1, 1), (2, 1)] {
                    let image_of = Texture {
                        wrap: [way; 2],
                        reading,
                        ..quarter
                    };
                    let colour = image(&image_of, &texels, at);
                    assert!(colour.is_finite() && colour.min_element() >= 0.0, "{at:?}");
                }
            }
        }
        // Too few texels are black, not read past their end.
        assert_eq!(image(&quarter, &texels[..0], [0.3; 2]), Vec3::ZERO);
    }

    #[test]
    fn an_image_goes_on_as_it_says() {
        let row = Texture {
            kind: kind::IMAGE,
            width: 4,
            height: 1,
            reading: reading::NEAREST | reading::LINEAR,
            ..Texture::new_zeroed()
        };
        let texels = [[0; 4], [51, 0, 0, 0], [102, 0, 0, 0], [255, 0, 0, 0]];
        for (way, expected) in [
            (wrap::REPEAT, [0.4, 1.0, 0.0, 0.4]),
            (wrap::MIRROR, [0.2, 0.0, 1.0, 0.2]),
            (wrap::CLAMP, [0.0, 0.0, 1.0, 1.0]),
        ] {
            let texture = Texture {
                wrap: [way; 2],
                ..row
            };
            let found = [-0.4, -0.1, 1.1, 1.6].map(|u| image(&texture, &texels, [u, 0.5]).x);
            assert_eq!(found, expected, "{way}");
            let smooth = Texture {
                reading: reading::LINEAR,
                ..texture
            };
            // Half-way between texels, and at both ends.
            let [inside, start, end] = [0.5, 0.0, 1.0].map(|u| image(&smooth, &texels, [u, 0.5]).x);
            let wrapped = if way == wrap::REPEAT {
                [0.5; 2]
            } else {
                [0.0, 1.0]
            };
            assert!(
                (inside - 0.3).abs() < 1e-6 && [start, end] == wrapped,
                "{way}"
            );
        }
    }
}
