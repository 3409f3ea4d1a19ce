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

pub(super) trait Image {
    /// All its pictures, in an order that is always the same.
    fn pictures(&mut self) -> Vec<&mut Picture>;

    /// The rays, steps and seconds of each of its parts.
    fn costs(&mut self) -> Vec<(&mut Statistics, &mut f64)>;
}

/// The sum of the pictures of all wavelengths; `None` where there are no wavelengths.
pub(super) fn sum<I: Image, E>(
    images: &[(Options, Vec3)],
    mut render: impl FnMut(&Options) -> Result<I, E>,
) -> Result<Option<I>, E> {
    let share = 1.0 / images.len() as f32;
    let mut sum: Option<I> = None;
    for (options, weight) in images {
        let weight = [weight.x, weight.y, weight.z, share];
        let mut part = render(options)?;
        for picture in part.pictures() {
            for pixel in &mut picture.pixels {
                *pixel = std::array::from_fn(|channel| pixel[channel] * weight[channel]);
            }
        }
        let Some(sum) = &mut sum else {
            sum = Some(part);
            continue;
        };
        for (sum, part) in sum.pictures().into_iter().zip(part.pictures()) {
            let sums = sum.pixels.as_flattened_mut().iter_mut();
            for (sum, part) in sums.zip(part.pixels.as_flattened()) {
                *sum += part;
            }
        }
        for (sum, part) in sum.costs().into_iter().zip(part.costs()) {
            sum.0.add(part.0);
            *sum.1 += *part.1;
        }
    }
    Ok(sum)
}

impl Image for DomePicture {
    fn pictures(&mut self) -> Vec<&mut Picture> {
        vec![&mut self.picture]
    }

    fn costs(&mut self) -> Vec<(&mut Statistics, &mut f64)> {
        vec![(&mut self.statistics, &mut self.seconds)]
    }
}

impl Image for Frame {
    fn pictures(&mut self) -> Vec<&mut Picture> {
        let captured = self.capture.iter_mut().flat_map(|one| &mut one.hemispheres);
        let shown = self.pictures.iter_mut().map(|one| &mut one.picture);
        shown.chain(captured).collect()
    }

    fn costs(&mut self) -> Vec<(&mut Statistics, &mut f64)> {
        let captured = self.capture.iter_mut();
        let captured = captured.map(|one| (&mut one.statistics, &mut one.seconds));
        std::iter::once((&mut self.statistics, &mut self.seconds))
            .chain(captured)
            .collect()
    }
}
