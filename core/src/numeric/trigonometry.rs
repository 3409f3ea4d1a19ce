use crate::simd::Lanes;
use core::f32::consts::FRAC_2_PI;

/// The largest magnitude that [`sin_cos`] takes: more than two turns.
pub const LARGEST_ANGLE: f32 = 16.0;

/// π/2 to 2⁻⁶³ in four parts, of which multiples up to 15 of the first three are exact.
const QUARTER_TURN: [f32; 4] = [1.570_312_5, 4.837_513e-4, 7.549_533_6e-8, 2.563_344e-12];

/// Coefficients of the sine on ±π/4, from the highest; the last is taken off.
const SINE: [f32; 3] = [-1.951_529_6e-4, 8.332_161e-3, 1.666_665_5e-1];

/// Coefficients of the cosine; the second is subtracted.
const COSINE: [f32; 3] = [2.443_315_7e-5, 1.388_731_6e-3, 4.166_664_6e-2];

/// Sine and cosine of an angle in radians, up to [`LARGEST_ANGLE`] either way; NaN beyond. Error
/// of each ≤ 1.5 ulp, by the polynomials of Moshier's Cephes library.
pub fn sin_cos(angle: f32) -> (f32, f32) {
    // NaN fails the comparison too.
    if !(angle.abs() <= LARGEST_ANGLE) {
        return (f32::NAN, f32::NAN);
    }
    let quarters = (angle.abs() * FRAC_2_PI + 0.5) as u8;
    let count = f32::from(quarters);
    let [first, second, third, fourth] = QUARTER_TURN;
    let x = angle.abs() - count * first - count * second - count * third - count * fourth;
    let z = x * x;
    let sin = (SINE[0] * z + SINE[1]) * z - SINE[2];
    let sin = sin * z * x + x;
    let cos = (COSINE[0] * z - COSINE[1]) * z + COSINE[2];
    let cos = cos * z * z - 0.5 * z + 1.0;
    let (sin, cos) = match quarters % 4 {
        0 => (sin, cos),
        1 => (cos, -sin),
        2 => (-sin, -cos),
        _ => (-cos, sin),
    };
    (if angle < 0.0 { -sin } else { sin }, cos)
}

/// [`sin_cos`] in every lane, to the last bit, of angles from 0 to π.
#[inline(always)]
pub(crate) fn sines_and_cosines<const W: usize, L: Lanes<W>>(l: L, angle: L::F) -> (L::F, L::F) {
    let (zero, one, two) = (l.splat(0.0), l.splat(1.0), l.splat(2.0));
    let quarters = l.add(l.mul(angle, l.splat(FRAC_2_PI)), l.splat(0.5));
    let (second, third) = (l.le(one, quarters), l.le(two, quarters));
    let count = l.select(third, two, l.select(second, one, zero));
    let [a, b, c, d] = QUARTER_TURN;
    let x = l.sub(angle, l.mul(count, l.splat(a)));
    let x = l.sub(x, l.mul(count, l.splat(b)));
    let x = l.sub(x, l.mul(count, l.splat(c)));
    let x = l.sub(x, l.mul(count, l.splat(d)));
    let z = l.mul(x, x);
    let sin = l.add(l.mul(l.splat(SINE[0]), z), l.splat(SINE[1]));
    let sin = l.sub(l.mul(sin, z), l.splat(SINE[2]));
    let sin = l.add(l.mul(l.mul(sin, z), x), x);
    let cos = l.sub(l.mul(l.splat(COSINE[0]), z), l.splat(COSINE[1]));
    let cos = l.add(l.mul(cos, z), l.splat(COSINE[2]));
    let cos = l.sub(l.mul(l.mul(cos, z), z), l.mul(l.splat(0.5), z));
    let cos = l.add(cos, one);
    let minus = l.splat(-1.0);
    let (minus_sin, minus_cos) = (l.mul(minus, sin), l.mul(minus, cos));
    (
        l.select(third, minus_sin, l.select(second, cos, sin)),
        l.select(third, minus_cos, l.select(second, minus_sin, cos)),
    )
}
