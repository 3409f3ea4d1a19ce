use super::{Matching, Wavelengths};
use core::fmt;
use glam::Vec3;

/// A wavelength and its part in a colour.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SpectralSample {
    /// Nanometres.
    pub nm: f32,
    /// What light of this wavelength counts for: linear sRGB, negative where
    /// the display cannot show it.
    pub weight: Vec3,
}

/// The wavelengths that rays take, and the colours that they add up to.
///
/// A table has one or more *phases*, each of which is n wavelengths at the same
/// offset in their parts of the range. One phase alone is the fixed set: the
/// parts' centres. Rays that take phases at random, or one after another,
/// are a comb, which sees no stripes where n is too small.
///
/// In every phase the weights sum to white, exactly but for 3.6e-7: XYZ of the
/// n wavelengths under a spectrum of equal energy are scaled, each of the three
/// by itself, to those of white.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpectralTable<'a> {
    /// Phase after phase.
    samples: &'a [SpectralSample],
    wavelengths: Wavelengths,
    phases: u32,
}

/// Why there is no such table.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum TableError {
    /// Phases that are no power of two, or more than
    /// [`SpectralTable::MOST_PHASES`].
    Phases {
        /// How many.
        given: u32,
    },
    /// Room for fewer samples than n in every phase.
    Storage {
        /// What there is.
        given: usize,
        /// What it takes.
        needed: usize,
    },
    /// Wavelengths that leave one of the display's colours out.
    NoWhite {
        /// Their range: nanometres.
        range: [f32; 2],
    },
}

impl fmt::Display for TableError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Phases { given } => write!(
                f,
                "{given} phases: give a power of two from 1 to {}",
                SpectralTable::MOST_PHASES
            ),
            Self::Storage { given, needed } => write!(
                f,
                "there is room for {given} samples: {needed} are needed, one a wavelength and \
                 phase"
            ),
            Self::NoWhite { range: [low, high] } => {
                let [least, most] = Wavelengths::RANGE;
                write!(
                    f,
                    "the wavelengths from {low} to {high} nm give no white: give a range with \
                     more of {least} to {most} nm"
                )
            }
        }
    }
}

impl core::error::Error for TableError {}

impl<'a> SpectralTable<'a> {
    /// Phases of a comb, unless somebody asks for another number: the offsets
    /// between them are then too small to see.
    pub const COMB_PHASES: u32 = 32;

    /// Most phases.
    pub const MOST_PHASES: u32 = 256;

    /// Samples that most wavelengths in the phases of a comb take.
    pub const MOST_SAMPLES: usize = (Wavelengths::MOST * Self::COMB_PHASES) as usize;

    /// Below this sum of a colour-matching function there is no light to scale.
    const LEAST_SUM: f32 = 1.0e-6;

    /// Works a table out, in the caller's memory: `wavelengths` times `phases`
    /// samples, 16 bytes each.
    ///
    /// # Errors
    /// A number of phases that is no power of two up to
    /// [`MOST_PHASES`](Self::MOST_PHASES), too little memory, or wavelengths
    /// that cannot sum to white.
    pub fn new(
        wavelengths: Wavelengths,
        phases: u32,
        matching: Matching<'_>,
        storage: &'a mut [SpectralSample],
    ) -> Result<Self, TableError> {
        if !(phases.is_power_of_two() && phases <= Self::MOST_PHASES) {
            return Err(TableError::Phases { given: phases });
        }
        let (given, needed) = (storage.len(), wavelengths.count() * phases as usize);
        let Some(samples) = storage.get_mut(..needed) else {
            return Err(TableError::Storage { given, needed });
        };
        for (phase, samples) in samples.chunks_exact_mut(wavelengths.count()).enumerate() {
            let offset = offset(phase as u32, phases);
            for (k, sample) in samples.iter_mut().enumerate() {
                sample.nm = wavelengths.at(k, offset);
            }
            if !weigh(samples, matching) {
                let range = wavelengths.range();
                return Err(TableError::NoWhite { range });
            }
        }
        Ok(Self {
            samples,
            wavelengths,
            phases,
        })
    }

    /// The wavelengths, by their parts.
    pub const fn wavelengths(&self) -> Wavelengths {
        self.wavelengths
    }

    /// How many phases there are: a power of two.
    pub const fn phases(&self) -> u32 {
        self.phases
    }

    /// Where in their parts the wavelengths of a phase are, above 0 and below
    /// 1.
    pub fn offset(&self, phase: u32) -> f32 {
        offset(phase & (self.phases - 1), self.phases)
    }

    /// The n samples of a phase, by wavelength. Phases beyond the last begin
    /// again with the first, so a hash will do. Phases one after another
    /// halve the gaps between those before.
    #[inline]
    pub fn phase(&self, phase: u32) -> &'a [SpectralSample] {
        let count = self.wavelengths.count();
        let first = (phase & (self.phases - 1)) as usize * count;
        self.samples.get(first..first + count).unwrap_or_default()
    }

    /// Sample `k`, 0 to n − 1, of a phase; nothing, black, beyond.
    #[inline]
    pub fn sample(&self, phase: u32, k: usize) -> SpectralSample {
        self.phase(phase).get(k).copied().unwrap_or_default()
    }
}

/// The centre of one of `phases` equal parts of 0 to 1, by van der Corput's
/// sequence: bits in reverse.
fn offset(phase: u32, phases: u32) -> f32 {
    let place = (u64::from(phase.reverse_bits()) * u64::from(phases)) >> 32;
    (place as f32 + 0.5) / phases as f32
}

/// Sets the weights by the wavelengths; false where they cannot sum to white.
fn weigh(samples: &mut [SpectralSample], matching: Matching<'_>) -> bool {
    for sample in samples.iter_mut() {
        sample.weight = matching.values(sample.nm);
    }
    let sum: Vec3 = samples.iter().map(|sample| sample.weight).sum();
    if !(sum.min_element() >= SpectralTable::LEAST_SUM) {
        return false;
    }
    let scale = matching.white() / sum;
    for sample in samples.iter_mut() {
        sample.weight = matching.rgb(sample.weight * scale);
    }
    // What rounding took goes to the weight that it changes least, of each
    // channel one.
    let sum: Vec3 = samples.iter().map(|sample| sample.weight).sum();
    let largest = samples.iter().map(|sample| sample.weight);
    let largest = largest.fold(Vec3::NEG_INFINITY, Vec3::max);
    let mut missing = Vec3::ONE - sum;
    for sample in samples.iter_mut() {
        let here = sample.weight.cmpeq(largest);
        sample.weight += Vec3::select(here, missing, Vec3::ZERO);
        missing = Vec3::select(here, Vec3::ZERO, missing);
    }
    true
}
