//! Colours over a surface: checkers and images.

use crate::numeric::{max, sqrt};
use crate::scene::Scene;
use crate::scene::format::{Material, Texel, Texture, effect};
use core::f32::consts::FRAC_1_PI;
use glam::Vec3;
use libm::floorf;

/// Bits of the effects that are textures.
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

/// Texture coordinates of a point in a spheroid's own frame: longitude, ½ at +Z and more
/// towards +X, and latitude, 0 at −Y and 1 at +Y. Error ≤ 3·10⁻⁷.
pub(super) fn around(point: Vec3) -> [f32; 2] {
    let across = sqrt(point.x * point.x + point.z * point.z);
    [
        0.5 + libm::atan2f(point.x, point.z) * (0.5 * FRAC_1_PI),
        0.5 + libm::atan2f(point.y, across) * FRAC_1_PI,
    ]
}

/// The colour of a checker; borders belong to the cell above or to the right.
fn checker(texture: &Texture, [u, v]: [f32; 2]) -> Vec3 {
    let [across, up] = texture.repeats;
    let odd = is_odd(floorf(u * across)) != is_odd(floorf(v * up));
    Vec3::from_array(texture.colours[usize::from(odd)])
}

/// Whether a whole number is odd.
fn is_odd(whole: f32) -> bool {
    whole - 2.0 * floorf(0.5 * whole) == 1.0
}

/// The colour of an image, interpolated in linear light; it wraps around.
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
        Vec3::new(linear(r), linear(g), linear(b))
    };
    let mix = |a: Vec3, b: Vec3, share: f32| a + (b - a) * share;
    mix(
        mix(texel(left, upper), texel(right, upper), to_right),
        mix(texel(left, lower), texel(right, lower), to_right),
        down,
    )
}

/// The texels on both sides of a position, and its share of the way between them.
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

/// Light of an sRGB code (IEC 61966-2-1).
fn linear(code: u8) -> f32 {
    SRGB[usize::from(code)]
}

/// Light of each code, the nearest f32.
static SRGB: [f32; 256] = [
    0.0,
    0.000_303_527,
    0.000_607_054,
    0.000_910_581,
    0.001_214_108,
    0.001_517_635,
    0.001_821_162,
    0.002_124_688_8,
    0.002_428_216,
    0.002_731_742_8,
    0.003_035_27,
    0.003_346_535_8,
    0.003_676_507_4,
    0.004_024_717,
    0.004_391_442,
    0.004_776_953_3,
    0.005_181_516_5,
    0.005_605_391_7,
    0.006_048_833,
    0.006_512_090_6,
    0.006_995_41,
    0.007_499_032,
    0.008_023_193,
    0.008_568_126,
    0.009_134_059,
    0.009_721_218,
    0.010_329_823,
    0.010_960_094,
    0.011_612_245,
    0.012_286_488,
    0.012_983_032_5,
    0.013_702_083,
    0.014_443_844,
    0.015_208_514,
    0.015_996_294,
    0.016_807_375,
    0.017_641_954,
    0.018_500_22,
    0.019_382_361,
    0.020_288_562,
    0.021_219_01,
    0.022_173_885,
    0.023_153_367,
    0.024_157_632,
    0.025_186_86,
    0.026_241_222,
    0.027_320_892,
    0.028_426_04,
    0.029_556_835,
    0.030_713_445,
    0.031_896_032,
    0.033_104_766,
    0.034_339_808,
    0.035_601_314,
    0.036_889_45,
    0.038_204_372,
    0.039_546_236,
    0.040_915_2,
    0.042_311_41,
    0.043_735_03,
    0.045_186_203,
    0.046_665_087,
    0.048_171_826,
    0.049_706_567,
    0.051_269_457,
    0.052_860_647,
    0.054_480_277,
    0.056_128_49,
    0.057_805_43,
    0.059_511_237,
    0.061_246_052,
    0.063_010_015,
    0.064_803_265,
    0.066_625_94,
    0.068_478_17,
    0.070_360_094,
    0.072_271_85,
    0.074_213_57,
    0.076_185_38,
    0.078_187_42,
    0.080_219_82,
    0.082_282_71,
    0.084_376_21,
    0.086_500_46,
    0.088_655_58,
    0.090_841_71,
    0.093_058_966,
    0.095_307_47,
    0.097_587_35,
    0.099_898_726,
    0.102_241_73,
    0.104_616_486,
    0.107_023_105,
    0.109_461_71,
    0.111_932_43,
    0.114_435_375,
    0.116_970_666,
    0.119_538_43,
    0.122_138_776,
    0.124_771_82,
    0.127_437_68,
    0.130_136_47,
    0.132_868_32,
    0.135_633_33,
    0.138_431_61,
    0.141_263_29,
    0.144_128_47,
    0.147_027_27,
    0.149_959_79,
    0.152_926_15,
    0.155_926_47,
    0.158_960_83,
    0.162_029_37,
    0.165_132_2,
    0.168_269_4,
    0.171_441_11,
    0.174_647_4,
    0.177_888_42,
    0.181_164_25,
    0.184_474_99,
    0.187_820_78,
    0.191_201_69,
    0.194_617_84,
    0.198_069_32,
    0.201_556_25,
    0.205_078_74,
    0.208_636_87,
    0.212_230_76,
    0.215_860_5,
    0.219_526_2,
    0.223_227_96,
    0.226_965_87,
    0.230_740_06,
    0.234_550_58,
    0.238_397_57,
    0.242_281_12,
    0.246_201_32,
    0.250_158_28,
    0.254_152_1,
    0.258_182_85,
    0.262_250_66,
    0.266_355_6,
    0.270_497_8,
    0.274_677_3,
    0.278_894_28,
    0.283_148_74,
    0.287_440_84,
    0.291_770_64,
    0.296_138_26,
    0.300_543_79,
    0.304_987_3,
    0.309_468_92,
    0.313_988_72,
    0.318_546_77,
    0.323_143_2,
    0.327_778_1,
    0.332_451_52,
    0.337_163_63,
    0.341_914_42,
    0.346_704_07,
    0.351_532_6,
    0.356_400_13,
    0.361_306_8,
    0.366_252_6,
    0.371_237_7,
    0.376_262_13,
    0.381_326_02,
    0.386_429_43,
    0.391_572_48,
    0.396_755_22,
    0.401_977_78,
    0.407_240_2,
    0.412_542_6,
    0.417_885_07,
    0.423_267_66,
    0.428_690_5,
    0.434_153_65,
    0.439_657_18,
    0.445_201_2,
    0.450_785_8,
    0.456_411_03,
    0.462_077,
    0.467_783_8,
    0.473_531_48,
    0.479_320_17,
    0.485_149_95,
    0.491_020_86,
    0.496_932_98,
    0.502_886_5,
    0.508_881_33,
    0.514_917_7,
    0.520_995_56,
    0.527_115_1,
    0.533_276_4,
    0.539_479_5,
    0.545_724_45,
    0.552_011_43,
    0.558_340_4,
    0.564_711_5,
    0.571_124_85,
    0.577_580_45,
    0.584_078_43,
    0.590_618_85,
    0.597_201_76,
    0.603_827_36,
    0.610_495_57,
    0.617_206_6,
    0.623_960_4,
    0.630_757_15,
    0.637_596_85,
    0.644_479_7,
    0.651_405_63,
    0.658_374_85,
    0.665_387_3,
    0.672_443_15,
    0.679_542_5,
    0.686_685_3,
    0.693_871_74,
    0.701_101_9,
    0.708_375_75,
    0.715_693_5,
    0.723_055_1,
    0.730_460_76,
    0.737_910_4,
    0.745_404_2,
    0.752_942_2,
    0.760_524_5,
    0.768_151_16,
    0.775_822_2,
    0.783_537_8,
    0.791_297_9,
    0.799_102_7,
    0.806_952_24,
    0.814_846_6,
    0.822_785_74,
    0.830_769_9,
    0.838_799,
    0.846_873_2,
    0.854_992_6,
    0.863_157_2,
    0.871_367_1,
    0.879_622_4,
    0.887_923_1,
    0.896_269_4,
    0.904_661_2,
    0.913_098_63,
    0.921_581_86,
    0.930_110_9,
    0.938_685_7,
    0.947_306_5,
    0.955_973_3,
    0.964_686_3,
    0.973_445_3,
    0.982_250_6,
    0.991_102_1,
    1.0,
];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::format::texture;
    use zerocopy::FromZeros as _;

    const BLACK_AND_WHITE: Texture = Texture {
        kind: texture::CHECKER,
        width: 0,
        height: 0,
        first_texel: 0,
        repeats: [8.0, 4.0],
        colours: [[0.0; 3], [1.0; 3]],
        reserved: [0; 4],
    };

    /// A picture after two other texels.
    fn picture(width: u32, height: u32) -> Texture {
        Texture {
            kind: texture::IMAGE,
            width,
            height,
            first_texel: 2,
            repeats: [1.0; 2],
            ..Texture::new_zeroed()
        }
    }

    fn is_white(u: f32, v: f32) -> bool {
        let colour = checker(&BLACK_AND_WHITE, [u, v]);
        assert!(colour == Vec3::ZERO || colour == Vec3::ONE);
        colour == Vec3::ONE
    }

    #[test]
    fn codes_are_decoded_as_the_standard_says() {
        for (code, &found) in SRGB.iter().enumerate() {
            let c = code as f64 / 255.0;
            let expected = if c <= 0.04045 {
                c / 12.92
            } else {
                libm::pow((c + 0.055) / 1.055, 2.4)
            };
            let error = (f64::from(found) - expected).abs();
            assert!(error <= expected * 6.0e-8, "{code}: {found}, {expected}");
        }
        assert_eq!((SRGB[0], SRGB[255]), (0.0, 1.0));
    }

    #[test]
    fn a_border_belongs_to_the_cell_after_it() {
        for border in -8..8i32 {
            let u = border as f32 / 8.0;
            let odd = border.rem_euclid(2) == 1;
            assert_eq!(is_white(u, 0.1), odd, "{u}");
            assert_eq!(is_white(u.next_down(), 0.1), !odd, "{u}");
            assert_eq!(is_white(u.next_up(), 0.1), odd, "{u}");
        }
        assert!(!is_white(0.0, 0.0) && !is_white(-0.0, -0.0));
        // The product with the repeats rounds to 0 from below, and stays there.
        assert!(is_white(-f32::from_bits(1), 0.1));
    }

    #[test]
    fn what_is_no_number_has_a_colour() {
        let quarter = Texture {
            first_texel: 0,
            ..picture(2, 2)
        };
        let texels = [[255, 0, 0, 0], [0, 255, 0, 0], [0, 0, 255, 0], [0; 4]];
        for odd in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX, 1e38] {
            for at in [[odd, 0.3], [0.3, odd], [odd, odd]] {
                assert!(checker(&BLACK_AND_WHITE, at).is_finite());
                let colour = image(&quarter, &texels, at);
                assert!(colour.is_finite() && colour.min_element() >= 0.0, "{at:?}");
            }
        }
        // Too few texels are black, not read past their end.
        assert_eq!(image(&quarter, &texels[..0], [0.3; 2]), Vec3::ZERO);
    }

    #[test]
    fn texels_are_exact_in_their_middles_and_mixed_between() {
        let (width, height) = (5, 3);
        let picture = picture(width, height);
        let texels: [Texel; 17] =
            core::array::from_fn(|i| [i as u8 * 15, 255 - i as u8 * 7, i as u8, 0]);
        let of = |column: u32, row: u32| {
            let [r, g, b, _] = texels[(2 + (row % height) * width + column % width) as usize];
            Vec3::new(linear(r), linear(g), linear(b))
        };
        let near = |at: [f32; 2], expected: Vec3| {
            let found = image(&picture, &texels, at);
            let error = (found - expected).abs().max_element();
            assert!(error < 2.0e-6, "{at:?}: {found}, {expected}");
        };
        for column in 0..width {
            for row in 0..height {
                let u = (column as f32 + 0.5) / width as f32;
                let v = 1.0 - (row as f32 + 0.5) / height as f32;
                near([u, v], of(column, row));
                near([u + 3.0, v - 2.0], of(column, row));
                // Half-way to the right and down, at the edges to the other side.
                let [half_u, half_v] = [0.5 / width as f32, 0.5 / height as f32];
                let to_right = (of(column, row) + of(column + 1, row)) * 0.5;
                near([u + half_u, v], to_right);
                let down = (of(column, row) + of(column, row + 1)) * 0.5;
                near([u, v - half_v], down);
            }
        }
    }

    #[test]
    fn longitude_grows_to_the_right_as_seen_from_outside() {
        let near = |point: Vec3, expected: [f32; 2]| {
            let found = around(point);
            let error = (0..2).map(|i| (found[i] - expected[i]).abs());
            assert!(error.fold(0.0, f32::max) < 3e-7, "{point}: {found:?}");
        };
        near(Vec3::Z, [0.5, 0.5]);
        near(Vec3::X * 3.0, [0.75, 0.5]);
        near(Vec3::NEG_X, [0.25, 0.5]);
        near(Vec3::new(1e-9, 0.0, -1.0), [1.0, 0.5]);
        near(Vec3::new(-1e-9, 0.0, -1.0), [0.0, 0.5]);
        near(Vec3::Y * 2.0, [0.5, 1.0]);
        near(Vec3::NEG_Y, [0.5, 0.0]);
        near(Vec3::new(0.0, 1.0, 1.0), [0.5, 0.75]);
        assert_eq!(around(Vec3::ZERO), [0.5; 2]);
    }
}
