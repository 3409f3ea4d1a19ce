//! Wavelengths: chosen when a ray first enters a dispersive medium.

use super::sample::Sample;
use crate::spectrum::{Medium, SpectralSample, SpectralTable};
use core::num::NonZeroU32;
use glam::Vec3;

/// The wavelengths of rays: a ray carries all colours until it first enters a medium whose index
/// depends on the wavelength; from there one ray follows for each wavelength of the sample. In
/// pixels of less detail, neighbouring wavelengths share a ray.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Spectrum<'a> {
    /// No dispersion: media have the index of the d line, 587.5618 nm, for all colours.
    #[default]
    Rgb,
    /// The samples of a pixel take wavelengths in turn, so that together they have each equally
    /// often; the first wavelength and the phase differ from pixel to pixel.
    Comb {
        /// The wavelengths.
        table: SpectralTable<'a>,
        /// Wavelengths for each sample, evenly spread; more if a pixel has too few samples. With
        /// all wavelengths (255 always suffices) every sample is white.
        each: u8,
    },
    /// All rays have this wavelength, nanometres, from the eye on: one picture of Kishioka's
    /// method.
    Single(f32),
}

/// Why a scene cannot be traced with a spectrum.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[error(
    "the wavelengths are {} to {} nm, but medium {medium} of the scene is known from {} to {} nm: \
     give a range within",
    .wavelengths[0], .wavelengths[1], .known[0], .known[1]
)]
pub struct SpectrumError {
    /// Number of the medium whose index is not known at some wavelength of the spectrum.
    pub medium: usize,
    /// Range in which the medium's index is known: nanometres.
    pub known: [f32; 2],
    /// Range of the spectrum: nanometres.
    pub wavelengths: [f32; 2],
}

impl<'a> Spectrum<'a> {
    /// Returns the number of wavelengths that a dispersive medium may distinguish.
    pub(crate) fn count(&self) -> u8 {
        match self {
            Self::Rgb | Self::Single(_) => 1,
            // At most 64.
            Self::Comb { table, .. } => table.wavelengths().count() as u8,
        }
    }

    /// Checks that media are known at all its wavelengths; the error names the first that is not.
    pub(super) fn check(&self, media: &[Medium]) -> Result<(), SpectrumError> {
        let wavelengths = match *self {
            Self::Rgb => return Ok(()),
            Self::Comb { table, .. } => table.wavelengths().range(),
            Self::Single(nm) => [nm, nm],
        };
        for (medium, known) in media.iter().map(Medium::range).enumerate() {
            // NaN fails the comparisons.
            if !(known[0] <= wavelengths[0] && wavelengths[1] <= known[1]) {
                return Err(SpectrumError {
                    medium,
                    known,
                    wavelengths,
                });
            }
        }
        Ok(())
    }

    /// Returns the wavelength of all rays; 0 if rays carry all colours.
    pub(super) const fn single(&self) -> f32 {
        match self {
            Self::Single(nm) => *nm,
            _ => 0.0,
        }
    }

    /// Returns a sample's part of `groups` groups of wavelengths; `None` for one group.
    pub(super) fn part(&self, sample: Sample, groups: u8) -> Option<Part<'a>> {
        let groups = u32::from(groups).min(u32::from(self.count()));
        let groups = NonZeroU32::new(groups).filter(|groups| groups.get() > 1)?;
        let seed = sample.seed();
        let (index, count) = (u32::from(sample.index), u32::from(sample.count));
        match self {
            Self::Rgb | Self::Single(_) => None,
            Self::Comb { table, each } => {
                // Each whole round has a phase of its own; the samples left over share
                // the last round's.
                let round_length = groups.get().div_ceil(u32::from(*each).max(1)).min(count);
                // Never 0: `max` shows it to the compiler.
                let round_length = round_length.max(1);
                let rounds = count / round_length;
                let round = (index / round_length).min(rounds - 1);
                let position = index % round_length;
                let is_shared = round + 1 == rounds && position < count % round_length;
                let sharing = if is_shared { 2.0 } else { 1.0 };
                let turn = ((seed >> 16) + rotation(round, round_length)) % round_length;
                let phase = seed.wrapping_add(round);
                Some(Part {
                    samples: table.phase(phase),
                    broad: table.broad(phase),
                    groups,
                    next: (position * STRIDE + turn) % round_length,
                    step: round_length,
                    factor: count as f32 / (rounds as f32 * sharing),
                })
            }
        }
    }
}

/// Step from one turn to the next: a prime above every round's length.
const STRIDE: u32 = 67;

/// Returns the turns by which a round is shifted, so that a wavelength visits the whole pixel.
const fn rotation(round: u32, round_length: u32) -> u32 {
    if round_length.is_multiple_of(2) && round_length > 0 {
        round + round / round_length
    } else {
        0
    }
}

/// The wavelengths of one sample of a pixel.
#[derive(Debug, Clone, Copy)]
pub(super) struct Part<'a> {
    /// Spectral samples of the phase, by wavelength.
    samples: &'a [SpectralSample],
    /// Spectral samples that stand for the whole phase.
    pub(super) broad: &'a [SpectralSample],
    /// Number of groups in the phase.
    groups: NonZeroU32,
    /// The next group to take.
    next: u32,
    /// Step to the group after it.
    step: u32,
    /// Weight of each, so that the mean of the pixel's samples is white.
    factor: f32,
}

impl Part<'_> {
    /// Returns the number of wavelengths left.
    pub(super) fn count(&self) -> u32 {
        self.groups
            .get()
            .saturating_sub(self.next)
            .div_ceil(self.step.max(1))
    }

    /// Returns the next wavelength and its colour.
    pub(super) fn next(&mut self) -> Option<SpectralSample> {
        if self.next >= self.groups.get() {
            return None;
        }
        let SpectralSample { nm, weight } = self.group(self.next);
        self.next += self.step;
        Some(SpectralSample {
            nm,
            weight: weight * self.factor,
        })
    }

    /// Returns all wavelengths left.
    pub(super) fn rest(mut self) -> impl Iterator<Item = SpectralSample> {
        core::iter::from_fn(move || self.next())
    }

    /// Returns whether it takes all groups.
    pub(super) const fn is_whole(&self) -> bool {
        self.step == 1
    }

    /// Returns a group's middle wavelength with the sum of its colours.
    fn group(&self, group: u32) -> SpectralSample {
        let count = self.samples.len() as u32;
        let first = (group * count / self.groups) as usize;
        let end = ((group + 1) * count / self.groups) as usize;
        let own = self.samples.get(first..end).unwrap_or_default();
        let middle = own.get(own.len() / 2).copied().unwrap_or_default();
        if own.len() == 1 {
            return middle;
        }
        SpectralSample {
            nm: middle.nm,
            weight: own.iter().map(|sample| sample.weight).sum(),
        }
    }
}

/// White less the colours of a pixel's samples, and the light that fills this difference.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct Balance {
    /// Sum over samples of white less their wavelengths' colours.
    missing: Vec3,
    /// Sum over samples of the mean light of their wavelengths.
    light: Vec3,
    /// Number of samples with wavelengths.
    samples: u16,
}

impl Balance {
    pub(crate) const NONE: Self = Self {
        missing: Vec3::ZERO,
        light: Vec3::ZERO,
        samples: 0,
    };

    pub(super) const fn one(missing: Vec3, light: Vec3) -> Self {
        Self {
            missing,
            light,
            samples: 1,
        }
    }

    /// Adds a sample's balance and resets it.
    #[inline(always)]
    pub(crate) fn take(&mut self, from: &mut Self) {
        if from.samples != 0 {
            self.missing += from.missing;
            self.light += from.light;
            self.samples += from.samples;
            *from = Self::NONE;
        }
    }

    /// Returns the light that the sum of the pixel's samples lacks.
    pub(crate) fn light(&self) -> Vec3 {
        if self.samples == 0 {
            return Vec3::ZERO;
        }
        self.missing * self.light / f32::from(self.samples)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn media_that_are_not_known_are_named() {
        let media = [Medium::N_BK7, Medium::SF11];
        let error = Spectrum::Single(380.0).check(&media).unwrap_err();
        assert_eq!((error.medium, error.known), (1, [390.0, 2500.0]));
        assert_eq!(error.wavelengths, [380.0; 2]);
        assert!(Spectrum::Single(f32::NAN).check(&media).is_err());
        assert_eq!(Spectrum::Single(400.0).check(&media), Ok(()));
        assert_eq!(Spectrum::Rgb.check(&media), Ok(()));
    }
}
