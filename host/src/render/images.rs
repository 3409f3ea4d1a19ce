//! A picture of each wavelength: Kishioka's method.

use super::{DomePicture, Frame, Options};
use crate::picture::Picture;
use crate::render::spectrum::Dispersion;
use glam::Vec3;
use shisen_core::frame::Statistics;
use shisen_core::scene::{EffectSet, Scene};
use shisen_core::spectrum::{Matching, SpectralSample, SpectralTable, Wavelengths};

/// How to render each wavelength's picture, and what colour it has; `None`
/// where all wavelengths have one picture.
pub(super) fn images<const W: usize>(
    scene: &Scene<'_, W>,
    options: &Options,
) -> Option<Vec<(Options, Vec3)>> {
    let Dispersion::Images(wavelengths, matching) = options.dispersion else {
        return None;
    };
    let asked = scene.effects();
    let carried_out = options.effects.of(asked).intersection(asked);
    carried_out
        .contains(EffectSet::DISPERSION)
        .then(|| shares(wavelengths, matching, options))
}

/// Samples that cannot be shared out evenly go to the first.
fn shares(
    wavelengths: Wavelengths,
    matching: Matching<'_>,
    options: &Options,
) -> Vec<(Options, Vec3)> {
    let count = wavelengths.count();
    let mut storage = vec![SpectralSample::default(); SpectralTable::samples(wavelengths, 1)];
    let Ok(table) = SpectralTable::new(wavelengths, 1, matching, &mut storage) else {
        return Vec::new();
    };
    let samples = usize::from(options.settings.samples);
    let share = |(number, sample): (usize, &SpectralSample)| {
        let mut one = *options;
        let own = samples / count + usize::from(number < samples % count);
        one.settings.samples = own.max(1) as u16;
        one.dispersion = Dispersion::Single(sample.nm);
        (one, sample.weight)
    };
    table.phase(0).iter().enumerate().map(share).collect()
}

/// What is summed up over wavelengths.
pub(super) trait Image {
    /// Takes one wavelength's part in; `share` is that of its coverage.
    fn add(&mut self, part: Self, weight: Vec3, share: f32);

    /// Makes it the part of its wavelength.
    fn weigh(&mut self, weight: Vec3, share: f32);
}

/// The sum of the pictures of all wavelengths; `None` where there are none.
pub(super) fn sum<I: Image, E>(
    images: &[(Options, Vec3)],
    mut render: impl FnMut(&Options) -> Result<I, E>,
) -> Result<Option<I>, E> {
    let share = 1.0 / images.len() as f32;
    let mut sum: Option<I> = None;
    for (options, weight) in images {
        let mut part = render(options)?;
        if let Some(sum) = &mut sum {
            sum.add(part, *weight, share);
        } else {
            part.weigh(*weight, share);
            sum = Some(part);
        }
    }
    Ok(sum)
}

/// What a pixel of one wavelength adds.
fn part([red, green, blue, alpha]: [f32; 4], weight: Vec3, share: f32) -> [f32; 4] {
    [
        red * weight.x,
        green * weight.y,
        blue * weight.z,
        alpha * share,
    ]
}

impl Image for Picture {
    fn add(&mut self, other: Self, weight: Vec3, share: f32) {
        for (pixel, other) in self.pixels.iter_mut().zip(other.pixels) {
            for (sum, part) in pixel.iter_mut().zip(part(other, weight, share)) {
                *sum += part;
            }
        }
    }

    fn weigh(&mut self, weight: Vec3, share: f32) {
        for pixel in &mut self.pixels {
            *pixel = part(*pixel, weight, share);
        }
    }
}

impl Image for DomePicture {
    fn add(&mut self, other: Self, weight: Vec3, share: f32) {
        self.picture.add(other.picture, weight, share);
        add_cost(
            (&mut self.statistics, &mut self.seconds),
            (&other.statistics, other.seconds),
        );
    }

    fn weigh(&mut self, weight: Vec3, share: f32) {
        self.picture.weigh(weight, share);
    }
}

impl Image for Frame {
    fn add(&mut self, other: Self, weight: Vec3, share: f32) {
        for (sum, part) in self.pictures.iter_mut().zip(other.pictures) {
            sum.picture.add(part.picture, weight, share);
        }
        if let (Some(sum), Some(part)) = (&mut self.capture, other.capture) {
            for (sum, part) in sum.hemispheres.iter_mut().zip(part.hemispheres) {
                sum.add(part, weight, share);
            }
            add_cost(
                (&mut sum.statistics, &mut sum.seconds),
                (&part.statistics, part.seconds),
            );
        }
        add_cost(
            (&mut self.statistics, &mut self.seconds),
            (&other.statistics, other.seconds),
        );
    }

    fn weigh(&mut self, weight: Vec3, share: f32) {
        for one in &mut self.pictures {
            one.picture.weigh(weight, share);
        }
        for hemisphere in self.capture.iter_mut().flat_map(|one| &mut one.hemispheres) {
            hemisphere.weigh(weight, share);
        }
    }
}

fn add_cost((sum, time): (&mut Statistics, &mut f64), (part, more): (&Statistics, f64)) {
    sum.add(part);
    *time += more;
}
