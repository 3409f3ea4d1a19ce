use crate::numeric::{map3, max, min};
use glam::Vec3;
use libm::expf;

/// Linear sRGB of XYZ with the white D65, rows.
const RGB_FROM_XYZ: [[f32; 3]; 3] = [
    [3.240_454_2, -1.537_138_5, -0.498_531_4],
    [-0.969_266, 1.876_010_9, 0.041_556_02],
    [0.055_643_43, -0.204_025_9, 1.057_225_2],
];

/// Its inverse, rows.
const XYZ_FROM_RGB: [[f32; 3]; 3] = [
    [0.412_456_44, 0.357_576_08, 0.180_437_48],
    [0.212_672_85, 0.715_152_14, 0.072_174_99],
    [0.019_333_896, 0.119_192_03, 0.950_304_1],
];

fn times(rows: [[f32; 3]; 3], v: Vec3) -> Vec3 {
    Vec3::from_array(map3(rows, |row| Vec3::from_array(row).dot(v)))
}

/// Returns linear sRGB of XYZ, up to 10³⁰; negative where the display cannot show it.
pub fn rgb_from_xyz(xyz: Vec3) -> Vec3 {
    times(RGB_FROM_XYZ, xyz)
}

/// XYZ of linear sRGB, up to 10³⁰: white has Y = 1.
pub fn xyz_from_rgb(rgb: Vec3) -> Vec3 {
    times(XYZ_FROM_RGB, rgb)
}

/// What colour light of one wavelength has.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Matching<'a> {
    /// CIE 1931 by the multi-lobe fit of Wyman, Sloan & Shirley (2013). Error
    /// ≤ 0.0140, 0.0080 and 0.0222 of x, y and z.
    #[default]
    Wyman,
    /// Colour-matching functions by a table.
    Table(MatchingTable<'a>),
    /// Endo's seven Gaussians, RGB at once, as in Kishioka's paper: far from CIE 1931.
    Endo,
}

impl Matching<'_> {
    /// Returns the three values at a wavelength in nanometres: XYZ, or Endo's RGB; 0
    /// for NaN.
    pub fn values(&self, nm: f32) -> Vec3 {
        match self {
            Self::Wyman => wyman(nm),
            Self::Table(table) => table.xyz(nm),
            Self::Endo => endo(nm),
        }
    }

    /// White in these values.
    pub(super) fn white(&self) -> Vec3 {
        match self {
            Self::Wyman | Self::Table(_) => xyz_from_rgb(Vec3::ONE),
            Self::Endo => Vec3::ONE,
        }
    }

    /// Returns linear sRGB of these values.
    pub(super) fn rgb(&self, values: Vec3) -> Vec3 {
        match self {
            Self::Wyman | Self::Table(_) => rgb_from_xyz(values),
            Self::Endo => values,
        }
    }
}

/// Colour-matching functions at equal steps: 0 outside, cubic in between.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MatchingTable<'a> {
    /// The first wavelength: nanometres.
    pub first_nm: f32,
    /// From one to the next: nanometres, above 0.
    pub step_nm: f32,
    /// XYZ of each; what is larger than 10⁶, or NaN, counts as 0.
    pub xyz: &'a [[f32; 3]],
}

impl MatchingTable<'_> {
    fn xyz(&self, nm: f32) -> Vec3 {
        let steps = (nm - self.first_nm) / self.step_nm;
        // Two before the first there is nothing left to interpolate; NaN fails
        // the comparison.
        if !(steps > -2.0 && steps < self.xyz.len() as f32 + 1.0) {
            return Vec3::ZERO;
        }
        let before = libm::floorf(steps);
        let t = steps - before;
        let at = |offset: isize| {
            let index = usize::try_from(before as isize + offset).ok();
            let found = index.and_then(|index| self.xyz.get(index));
            found.map_or(Vec3::ZERO, |&xyz| Vec3::from_array(map3(xyz, usable)))
        };
        // Lagrange's polynomials of the places −1, 0, 1 and 2.
        let (a, b, c) = (t + 1.0, t - 1.0, t - 2.0);
        let sum = at(-1) * (-t * b * c / 6.0)
            + at(0) * (0.5 * a * b * c)
            + at(1) * (-0.5 * a * t * c)
            + at(2) * (a * t * b / 6.0);
        sum.max(Vec3::ZERO)
    }
}

/// Peak, centre, and the reciprocals of both standard deviations of Gaussians.
const WYMAN: [&[[f32; 4]]; 3] = [
    &[
        [0.362, 442.0, 0.0624, 0.0374],
        [1.056, 599.8, 0.0264, 0.0323],
        [-0.065, 501.1, 0.0490, 0.0382],
    ],
    &[
        [0.821, 568.8, 0.0213, 0.0247],
        [0.286, 530.9, 0.0613, 0.0322],
    ],
    &[
        [1.217, 437.0, 0.0845, 0.0278],
        [0.681, 459.0, 0.0385, 0.0725],
    ],
];

fn usable(value: f32) -> f32 {
    if value.abs() <= 1.0e6 { value } else { 0.0 }
}

fn wyman(nm: f32) -> Vec3 {
    if nm.is_nan() {
        return Vec3::ZERO;
    }
    let sum = map3(WYMAN, |lobes| {
        let lobes = lobes.iter().map(|&[peak, centre, rise, fall]| {
            let t = (nm - centre) * if nm < centre { rise } else { fall };
            peak * expf(-0.5 * t * t)
        });
        lobes.sum()
    });
    Vec3::from_array(sum)
}

/// Centre, Δ (√2 standard deviations), intensity; shares of red, green and blue.
const ENDO: [([f32; 3], [f32; 3]); 7] = [
    ([700.0, 90.0, 0.95], [1.0, 0.0, 0.0]),
    ([605.0, 60.0, 0.40], [1.0, 0.715, 0.23]),
    ([580.0, 50.0, 0.10], [0.0, 0.83, 0.0]),
    ([546.1, 80.0, 0.74], [0.0, 1.0, 0.0]),
    ([490.0, 50.0, 0.30], [0.0, 1.0, 1.0]),
    ([435.8, 80.0, 0.75], [0.0, 0.0, 1.0]),
    ([400.0, 40.0, 0.30], [1.0, 0.5, 1.0]),
];

fn endo(nm: f32) -> Vec3 {
    let [least, most] = super::Wavelengths::PAPER_RANGE;
    if !(min(nm, most) == nm && max(nm, least) == nm) {
        return Vec3::ZERO;
    }
    let lobes = ENDO.iter().map(|&([centre, delta, intensity], share)| {
        let t = (nm - centre) / delta;
        Vec3::from_array(share) * (intensity * expf(-t * t))
    });
    lobes.sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_fit_is_that_of_double_precision() {
        let exact = |nm: f64| {
            WYMAN.map(|lobes| {
                let lobes = lobes.iter().map(|lobe| {
                    let [peak, centre, rise, fall] = lobe.map(f64::from);
                    let t = (nm - centre) * if nm < centre { rise } else { fall };
                    peak * libm::exp(-0.5 * t * t)
                });
                lobes.sum::<f64>()
            })
        };
        let steps = if cfg!(miri) { 40 } else { 20_000 };
        for i in 0..=steps {
            let nm = 360.0 + 470.0 * i as f32 / steps as f32;
            let found = Matching::Wyman.values(nm).to_array();
            for (found, exact) in found.into_iter().zip(exact(f64::from(nm))) {
                let error = (f64::from(found) - exact).abs();
                assert!(error < 3.1e-7, "{nm}: {error}");
            }
        }
    }

    #[test]
    fn endos_colours_are_those_of_the_paper() {
        // Worked out apart from this code, in f64: Δ is not σ.
        for (nm, expected) in [
            (700.0, [0.982_606_8, 0.041_855_9, 0.007_513_3]),
            (546.1, [0.203_624, 0.986_710_8, 0.232_358_6]),
            (400.0, [0.300_017_6, 0.188_101_6, 0.925_640_7]),
        ] {
            let error = (endo(nm) - Vec3::from(expected)).length();
            assert!(error < 1.0e-6, "{nm} {error}");
        }
        for nm in [379.9, 750.1, f32::NAN] {
            assert_eq!(endo(nm), Vec3::ZERO);
        }
    }

    #[test]
    fn tables_are_exact_at_their_steps_and_cubic_between() {
        // Values that a cubic goes through.
        let cubic = |x: f32| 10.0 + x * (1.0 + x * (0.5 - 0.125 * x));
        let values: [[f32; 3]; 6] =
            core::array::from_fn(|i| [1.0, 2.0, 1.0].map(|scale| scale * cubic(i as f32)));
        let table = MatchingTable {
            first_nm: 400.0,
            step_nm: 5.0,
            xyz: &values,
        };
        for i in 10..=40u8 {
            let steps = f32::from(i) / 10.0;
            let found = Matching::Table(table).values(400.0 + 5.0 * steps);
            let expected = cubic(steps);
            assert!(
                (found.x - expected).abs() < 1.0e-4 * expected,
                "{steps} {found}"
            );
            assert!((found.y - 2.0 * found.x).abs() < 1.0e-5 * found.y);
        }
        assert_eq!(table.xyz(400.0), Vec3::from(values[0]));
        assert_eq!(table.xyz(425.0), Vec3::from(values[5]));
        for nm in [0.0, 389.0, 436.0, f32::NAN, f32::INFINITY] {
            assert_eq!(table.xyz(nm), Vec3::ZERO);
        }
        let empty = MatchingTable { xyz: &[], ..table };
        assert_eq!(empty.xyz(401.0), Vec3::ZERO);
    }
}
