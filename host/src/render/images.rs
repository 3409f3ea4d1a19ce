//! A picture of each wavelength: Kishioka's method.

use super::{DomePicture, Frame, Options};
use crate::picture::Picture;
use crate::render::spectrum::Dispersion;
use glam::Vec3;
use shisen_core::frame::Statistics;
use shisen_core::scene::{EffectSet, Scene};
use shisen_core::spectrum::{SpectralSample, SpectralTable};

/// Returns how to render each wavelength's picture, and what colour it has; `None`
/// where all wavelengths have one picture.
pub(super) fn images<const W: usize>(
    scene: &Scene<'_, W>,
    options: &Options,
) -> Option<Vec<(Options, Vec3)>> {
    let Dispersion::Images(wavelengths, matching) = options.dispersion else {
        return None;
    };
    let asked = scene.effects();
    if !asked.contains(EffectSet::DISPERSION)
        || !options.effects.of(asked).contains(EffectSet::DISPERSION)
    {
        return None;
    }
    let count = wavelengths.count();
    let mut storage = vec![SpectralSample::default(); SpectralTable::samples(wavelengths, 1)];
    let table = SpectralTable::new(wavelengths, 1, matching, &mut storage).ok()?;
    let share = |(samples, sample): (u16, &SpectralSample)| {
        let mut one = *options;
        one.settings.samples = samples;
        one.dispersion = Dispersion::Single(sample.nm);
        (one, sample.weight)
    };
    let shared = shares(options.settings.samples, count);
    Some(shared.zip(table.phase(0)).map(share).collect())
}

/// Returns the samples of each of `count` pictures. Samples that cannot be shared out evenly go to
/// the first.
pub(super) fn shares(samples: u16, count: usize) -> impl Iterator<Item = u16> {
    let samples = usize::from(samples);
    let share = move |number| samples / count + usize::from(number < samples % count);
    (0..count).map(move |number| share(number).max(1) as u16)
}

/// All pictures, counts of rays and steps, and seconds of an image, in an order that is always the
/// same.
type Parts<'i> = (
    Vec<&'i mut Picture>,
    Vec<&'i mut Statistics>,
    Vec<&'i mut f64>,
);

/// Returns the sum of the pictures of all wavelengths; `None` where there are no wavelengths.
pub(super) fn sum<I, E>(
    images: &[(Options, Vec3)],
    mut render: impl FnMut(&Options) -> Result<I, E>,
    parts: impl Fn(&mut I) -> Parts<'_>,
) -> Result<Option<I>, E> {
    let share = 1.0 / images.len() as f32;
    let mut sum: Option<I> = None;
    for (options, weight) in images {
        let weight = [weight.x, weight.y, weight.z, share];
        let mut part = render(options)?;
        for picture in parts(&mut part).0 {
            for pixel in &mut picture.pixels {
                *pixel = std::array::from_fn(|channel| pixel[channel] * weight[channel]);
            }
        }
        let Some(sum) = &mut sum else {
            sum = Some(part);
            continue;
        };
        let ((sums, counts, seconds), (pictures, more, time)) = (parts(sum), parts(&mut part));
        for (sum, part) in sums.into_iter().zip(pictures) {
            let sums = sum.pixels.as_flattened_mut().iter_mut();
            for (sum, part) in sums.zip(part.pixels.as_flattened()) {
                *sum += part;
            }
        }
        for (sum, part) in counts.into_iter().zip(more) {
            sum.add(part);
        }
        for (sum, part) in seconds.into_iter().zip(time) {
            *sum += *part;
        }
    }
    Ok(sum)
}

impl DomePicture {
    pub(super) fn parts(&mut self) -> Parts<'_> {
        (
            vec![&mut self.picture],
            vec![&mut self.statistics],
            vec![&mut self.seconds],
        )
    }
}

impl Frame {
    pub(super) fn parts(&mut self) -> Parts<'_> {
        let shown = self.pictures.iter_mut();
        let (mut pictures, mut counts): (Vec<_>, Vec<_>) = shown
            .map(|one| (&mut one.picture, &mut one.statistics))
            .unzip();
        counts.push(&mut self.statistics);
        let mut seconds = vec![&mut self.seconds];
        if let Some(capture) = &mut self.capture {
            pictures.extend(&mut capture.hemispheres);
            counts.push(&mut capture.statistics);
            seconds.push(&mut capture.seconds);
        }
        (pictures, counts, seconds)
    }
}
