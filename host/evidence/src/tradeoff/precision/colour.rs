//! A spectrum as a colour: XYZ by the standard's table, and what a display has of it.

use super::{Stage, compare, ways};
use crate::selftest::Inputs;
use crate::tradeoff::{Bench, Cause, Comparison, limit};
use glam::{DMat3, DVec3, Vec3};
use shisen::render::spectrum::CIE_1931;
use shisen_core::spectrum::{Matching, rgb_from_xyz};

pub(super) const WAVELENGTHS: usize = 40;

/// The distance of neighbouring wavelengths, nanometres.
const STEP: f32 = 10.0;

struct Light {
    first: f32,
    power: [f32; WAVELENGTHS],
}

impl Light {
    /// Draws a white spectrum with up to three bumps or dents, as of filters and lamps.
    fn draw(draw: &mut Inputs) -> Self {
        let first = 380.0 + draw.range(0.0, STEP.into()) as f32;
        let level = draw.unit();
        let bumps: Vec<[f64; 3]> = (0..=draw.below(3))
            .map(|_| {
                let height = draw.range(-level, 1.0);
                [height, draw.range(400.0, 700.0), draw.range(10.0, 80.0)]
            })
            .collect();
        let power = std::array::from_fn(|number| {
            let nm = f64::from(first) + f64::from(STEP) * number as f64;
            let bump = |&[height, middle, width]: &[f64; 3]| {
                let off = (nm - middle) / width;
                height * libm::exp(-0.5 * off * off)
            };
            (level + bumps.iter().map(bump).sum::<f64>()).max(0.0) as f32
        });
        Self { first, power }
    }

    fn nm(&self, number: usize) -> f32 {
        self.first + STEP * number as f32
    }
}

/// XYZ of a spectrum by an observer's values; equal energy of 1 has Y = 1.
fn xyz(light: &Light, values: impl Fn(f32) -> Vec3) -> Vec3 {
    let (mut sum, mut white) = (Vec3::ZERO, 0.0);
    for (number, &power) in light.power.iter().enumerate() {
        let values = values(light.nm(number));
        sum += values * power;
        white += values.y;
    }
    sum / white
}

/// Returns the table at a wavelength, by the core's polynomial.
fn table(nm: f64) -> DVec3 {
    let steps = (nm - f64::from(CIE_1931.first_nm)) / f64::from(CIE_1931.step_nm);
    let before = libm::floor(steps);
    let t = steps - before;
    let at = |offset: isize| {
        let index = usize::try_from(before as isize + offset).ok();
        let found = index.and_then(|index| CIE_1931.xyz.get(index));
        found.map_or(DVec3::ZERO, |xyz| DVec3::from_array(xyz.map(f64::from)))
    };
    let (a, b, c) = (t + 1.0, t - 1.0, t - 2.0);
    let sum = at(-1) * (-t * b * c / 6.0)
        + at(0) * (0.5 * a * b * c)
        + at(1) * (-0.5 * a * t * c)
        + at(2) * (a * t * b / 6.0);
    sum.max(DVec3::ZERO)
}

/// The rows of linear sRGB of XYZ, as most pages print them.
const PRINTED: [Vec3; 3] = [
    Vec3::new(3.2406, -1.5372, -0.4986),
    Vec3::new(-0.9689, 1.8758, 0.0415),
    Vec3::new(0.0557, -0.2040, 1.0570),
];

pub(super) fn colour(
    bench: &Bench<'_>,
    count: usize,
    share: (f64, f64),
) -> Result<Comparison, Cause> {
    let matrix = linear_srgb();
    let mut draw = Inputs::new(54);
    let inputs: Vec<Light> = (0..count).map(|_| Light::draw(&mut draw)).collect();
    let observer = Matching::Table(*CIE_1931);
    let ways = ways(
        &inputs,
        |light| rgb_from_xyz(xyz(light, |nm| observer.values(nm))),
        |light| {
            let xyz = xyz(light, |nm| Matching::Wyman.values(nm));
            Vec3::from_array(PRINTED.map(|row| row.dot(xyz)))
        },
        move |light| {
            let (mut sum, mut white) = (DVec3::ZERO, 0.0);
            for (number, &power) in light.power.iter().enumerate() {
                let values = table(light.nm(number).into());
                sum += values * f64::from(power);
                white += values.y;
            }
            matrix * (sum / white)
        },
        |found, exact| [(found.as_dvec3() - exact).abs().max_element()],
    );
    let stage = Stage {
        id: "colour",
        title: "Colour of a spectrum",
        about: "Spectra with bumps and dents, 40 wavelengths each, from power to XYZ by the CIE's \
                table of 1931 and on to linear sRGB, where equal energy has Y = 1. Double \
                precision takes the same table and the matrix of the primaries and the white; the \
                textbook's way is Wyman's fit of the table and the matrix of four digits that \
                most pages print.",
        largest: "largest error of a channel",
        parts: &[],
        limit: limit(1.0e-5, "a thirtieth of the least step of 8 bits near black"),
        steps: None,
    };
    compare(bench, stage, ways, share)
}

/// The white point D65 of ASTM E308.
const WHITE: DVec3 = DVec3::new(0.950_47, 1.0, 1.088_83);

/// Returns linear sRGB of XYZ, from the primaries of IEC 61966-2-1 and the white.
fn linear_srgb() -> DMat3 {
    let xyz = |x: f64, y: f64| DVec3::new(x / y, 1.0, (1.0 - x - y) / y);
    let primaries = DMat3::from_cols(xyz(0.64, 0.33), xyz(0.30, 0.60), xyz(0.15, 0.06));
    let shares = primaries.inverse() * WHITE;
    (primaries * DMat3::from_diagonal(shares)).inverse()
}
