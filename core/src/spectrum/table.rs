use super::{Matching, Wavelengths};
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
/// A table has one or more *phases*, each of which is n wavelengths at the same offset in their
/// parts of the range. One phase alone is the fixed set: the parts' centres. Rays that take
/// phases at random, or one after another, are a comb, which shows no stripes.
///
/// In every phase the weights sum to white, exactly, whatever the order: X, Y and Z of the n
/// wavelengths are scaled to those of white, and one that none of them has they share equally. A
/// comb of 7 or more wavelengths is off by this scaling by 0.008 of white at most.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpectralTable<'a> {
    /// Phase after phase.
    samples: &'a [SpectralSample],
    wavelengths: Wavelengths,
    phases: u32,
}

/// Why a table cannot be made.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
#[allow(missing_docs, reason = "the messages say what the fields are")]
pub enum TableError {
    /// Phases that are no power of two up to [`SpectralTable::MOST_PHASES`].
    #[error(
        "{given} phases: give a power of two from 1 to {}",
        SpectralTable::MOST_PHASES
    )]
    Phases { given: u32 },
    /// Room for fewer samples than n and three more in every phase.
    #[error(
        "there is room for {given} samples: {needed} are needed, one a wavelength and phase and {} \
         more a phase",
        SpectralTable::BROAD
    )]
    Storage { given: usize, needed: usize },
}

impl<'a> SpectralTable<'a> {
    /// Phases of a comb, unless somebody asks for another number: the offsets
    /// between them are then too small to see.
    pub const COMB_PHASES: u32 = 32;

    /// Most phases.
    pub const MOST_PHASES: u32 = 256;

    /// Samples in a phase's [`broad`](Self::broad) set.
    pub const BROAD: usize = 3;

    /// Samples that most wavelengths in the phases of a comb take.
    pub const MOST_SAMPLES: usize =
        (Wavelengths::MOST as usize + Self::BROAD) * Self::COMB_PHASES as usize;

    /// Returns samples that a table takes; `usize::MAX` where a usize does not count them.
    pub const fn samples(wavelengths: Wavelengths, phases: u32) -> usize {
        (wavelengths.count() + Self::BROAD).saturating_mul(phases as usize)
    }

    /// The least sum of a colour-matching function that is scaled.
    const LEAST_SUM: f32 = 1.0e-6;

    /// Works a table out, in the caller's memory: [`samples`](Self::samples) of 16 bytes.
    ///
    /// # Errors
    /// Phases that are no power of two up to [`MOST_PHASES`](Self::MOST_PHASES), or too little
    /// memory.
    pub fn new(
        wavelengths: Wavelengths,
        phases: u32,
        matching: Matching<'_>,
        storage: &'a mut [SpectralSample],
    ) -> Result<Self, TableError> {
        if !(phases.is_power_of_two() && phases <= Self::MOST_PHASES) {
            return Err(TableError::Phases { given: phases });
        }
        let (given, needed) = (storage.len(), Self::samples(wavelengths, phases));
        let Some(samples) = storage.get_mut(..needed) else {
            return Err(TableError::Storage { given, needed });
        };
        let of_phase = wavelengths.count() + Self::BROAD;
        for (phase, samples) in samples.chunks_exact_mut(of_phase).enumerate() {
            let (samples, broad) = samples.split_at_mut(wavelengths.count());
            let offset = offset(phase as u32, phases);
            for (k, sample) in samples.iter_mut().enumerate() {
                sample.nm = wavelengths.at(k, offset);
            }
            weigh(samples, matching);
            gather(samples, broad);
        }
        Ok(Self {
            samples,
            wavelengths,
            phases,
        })
    }

    /// Returns the wavelengths, by their parts.
    pub const fn wavelengths(&self) -> Wavelengths {
        self.wavelengths
    }

    /// Returns how many phases there are: a power of two.
    pub const fn phases(&self) -> u32 {
        self.phases
    }

    /// Returns where in their parts the wavelengths of a phase are, above 0 and below
    /// 1.
    pub fn offset(&self, phase: u32) -> f32 {
        offset(phase & (self.phases - 1), self.phases)
    }

    /// Returns the n samples of a phase, modulo their number, by wavelength. Phases one after
    /// another halve the gaps between those before.
    #[inline]
    pub fn phase(&self, phase: u32) -> &'a [SpectralSample] {
        self.within(phase, 0, self.wavelengths.count())
    }

    /// Returns the [`BROAD`](Self::BROAD) samples that stand for all of a phase: what they see has
    /// the same colour where it is a parabola over 1/λ², as nearly all that a glass reflects
    /// (Cauchy's formula).
    #[inline]
    pub fn broad(&self, phase: u32) -> &'a [SpectralSample] {
        self.within(phase, self.wavelengths.count(), Self::BROAD)
    }

    #[inline]
    fn within(&self, phase: u32, first: usize, count: usize) -> &'a [SpectralSample] {
        let of_phase = self.wavelengths.count() + Self::BROAD;
        let first = (phase & (self.phases - 1)) as usize * of_phase + first;
        self.samples.get(first..first + count).unwrap_or_default()
    }

    /// Sample `k`, 0 to n − 1, of a phase; nothing, black, beyond.
    #[inline]
    pub fn sample(&self, phase: u32, k: usize) -> SpectralSample {
        self.phase(phase).get(k).copied().unwrap_or_default()
    }
}

/// Returns the centre of one of `phases` parts of 0 to 1, by van der Corput's sequence.
fn offset(phase: u32, phases: u32) -> f32 {
    let place = (u64::from(phase.reverse_bits()) * u64::from(phases)) >> 32;
    (place as f32 + 0.5) / phases as f32
}

/// Added and taken off again, this rounds weights to multiples of 2⁻²¹: exact sums.
const GRID: Vec3 = Vec3::splat(6.5);

/// Sets the weights by the wavelengths.
fn weigh(samples: &mut [SpectralSample], matching: Matching<'_>) {
    for sample in samples.iter_mut() {
        sample.weight = matching.values(sample.nm);
    }
    let sum: Vec3 = samples.iter().map(|sample| sample.weight).sum();
    let seen = sum.cmpge(Vec3::splat(SpectralTable::LEAST_SUM));
    let scale = matching.white() / Vec3::select(seen, sum, Vec3::ONE);
    let equal = matching.white() / samples.len() as f32;
    for sample in samples.iter_mut() {
        let share = Vec3::select(seen, sample.weight * scale, equal);
        sample.weight = (matching.rgb(share) + GRID) - GRID;
    }
    settle(samples);
}

/// Sets the samples that stand for all of a phase, by Lagrange's parabolas.
fn gather(samples: &[SpectralSample], broad: &mut [SpectralSample]) {
    let count = samples.len();
    if count <= SpectralTable::BROAD {
        broad.fill(SpectralSample {
            weight: Vec3::ZERO,
            ..samples.first().copied().unwrap_or_default()
        });
        for (one, sample) in broad.iter_mut().zip(samples) {
            *one = *sample;
        }
        return;
    }
    let place = |sample: &SpectralSample| 1.0e5 / (sample.nm * sample.nm);
    // About where Chebyshev's points are.
    let nodes = [count / 6, count / 2, count - 1 - count / 6];
    let nodes = nodes.map(|k| samples.get(k).copied().unwrap_or_default());
    let at = nodes.map(|node| place(&node));
    for (k, (one, node)) in broad.iter_mut().zip(nodes).enumerate() {
        let (a, b) = (at[(k + 1) % 3], at[(k + 2) % 3]);
        let height = (at[k] - a) * (at[k] - b);
        let share = |sample: &SpectralSample| {
            let x = place(sample);
            sample.weight * ((x - a) * (x - b) / height)
        };
        let weight: Vec3 = samples.iter().map(share).sum();
        *one = SpectralSample {
            nm: node.nm,
            weight: (weight + GRID) - GRID,
        };
    }
    settle(broad);
}

/// Makes weights sum to white: the largest takes what rounding took, in each channel.
fn settle(samples: &mut [SpectralSample]) {
    let sum: Vec3 = samples.iter().map(|sample| sample.weight).sum();
    let largest = samples.iter().map(|sample| sample.weight);
    let largest = largest.fold(Vec3::NEG_INFINITY, Vec3::max);
    let mut missing = Vec3::ONE - sum;
    for sample in samples.iter_mut() {
        let here = sample.weight.cmpeq(largest);
        sample.weight += Vec3::select(here, missing, Vec3::ZERO);
        missing = Vec3::select(here, Vec3::ZERO, missing);
    }
}

#[cfg(test)]
mod tests {
    use super::super::MatchingTable;
    use super::*;
    use crate::hostile::{finite, finite_or_error, with_hostile_numbers};
    use std::string::ToString;

    /// A function whose Z is 0.
    const RED: Matching<'_> = Matching::Table(MatchingTable {
        first_nm: 700.0,
        step_nm: 65.0,
        xyz: &[
            [0.011, 0.004, 0.0],
            [0.001, 0.001, 0.0],
            [0.001, 0.001, 0.0],
        ],
    });

    const MATCHINGS: [(Matching<'_>, [f32; 2]); 4] = [
        (Matching::Wyman, Wavelengths::RANGE),
        (Matching::Wyman, Wavelengths::LIMITS),
        (Matching::Endo, Wavelengths::PAPER_RANGE),
        (RED, [700.0, 830.0]),
    ];

    #[test]
    fn every_phase_sums_to_white() {
        let mut storage = std::vec![SpectralSample::default(); SpectralTable::MOST_SAMPLES];
        let white = |samples: &[SpectralSample]| {
            let weights = samples.iter().map(|sample| sample.weight);
            assert_eq!(weights.clone().sum::<Vec3>(), Vec3::ONE, "{samples:?}");
            assert_eq!(weights.rev().sum::<Vec3>(), Vec3::ONE, "{samples:?}");
        };
        for count in (1..=Wavelengths::MOST).step_by(if cfg!(miri) { 63 } else { 1 }) {
            for phases in [1, 8, if cfg!(miri) { 2 } else { 32 }] {
                for (matching, range) in MATCHINGS {
                    let wavelengths = Wavelengths::new(count, range).unwrap();
                    let table = SpectralTable::new(wavelengths, phases, matching, &mut storage);
                    let table = table.unwrap();
                    for phase in 0..phases {
                        let (all, broad) = (table.phase(phase), table.broad(phase));
                        assert_eq!((all.len(), broad.len()), (count as usize, 3));
                        white(all);
                        white(broad);
                    }
                }
            }
        }
    }

    #[test]
    fn tables_that_are_none_are_refused() {
        let mut storage = [SpectralSample::default(); 20];
        let mut new = |count, range, phases| {
            let wavelengths = Wavelengths::new(count, range).unwrap();
            SpectralTable::new(wavelengths, phases, Matching::Wyman, &mut storage)
                .map(|table| table.phases())
        };
        let range = Wavelengths::RANGE;
        assert_eq!(new(2, range, 4), Ok(4));
        for phases in [0, 3, 512, u32::MAX] {
            let error = new(1, range, phases).unwrap_err();
            assert_eq!(error, TableError::Phases { given: phases });
            assert!(error.to_string().contains("from 1 to 256"));
        }
        let error = new(18, range, 1).unwrap_err();
        let (given, needed) = (20, 21);
        assert_eq!(error, TableError::Storage { given, needed });
        assert!(error.to_string().contains("21 are needed"));
    }

    #[test]
    fn tables_of_any_numbers_are_finite() {
        with_hostile_numbers(|n| {
            let range = [n.next(400.0), n.next(700.0)];
            let offset = n.next(0.5);
            let Some(wavelengths) = finite_or_error(Wavelengths::new(5, range)) else {
                return;
            };
            finite_or_error(wavelengths.clamped_to([n.next(420.0), n.next(600.0)]));
            for nm in [0, 4, 5, usize::MAX].map(|k| wavelengths.at(k, offset)) {
                assert!((range[0]..=range[1]).contains(&nm));
            }
            let xyz = [[0.1, 0.2, 0.3], [0.4, 0.5, 0.6]].map(|xyz| n.vector(xyz).to_array());
            let own = MatchingTable {
                first_nm: n.next(400.0),
                step_nm: n.next(300.0),
                xyz: &xyz,
            };
            let mut storage = [SpectralSample::default(); 64];
            for matching in [Matching::Wyman, Matching::Endo, Matching::Table(own)] {
                let table = SpectralTable::new(wavelengths, 4, matching, &mut storage);
                if let Some(table) = finite_or_error(table) {
                    for phase in [0, 3, 4, u32::MAX] {
                        finite(&(table.offset(phase), table.phase(phase), table.broad(phase)));
                        finite(&table.sample(phase, 4));
                    }
                }
            }
        });
    }
}
