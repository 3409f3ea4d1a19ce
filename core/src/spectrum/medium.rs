use crate::numeric::{max, min, sqrt};
use zerocopy::{FromBytes, Immutable, IntoBytes, KnownLayout};

/// Fraunhofer's lines that glass is described by: nanometres.
pub mod line {
    /// Hydrogen, blue.
    pub const F: f32 = 486.132_7;
    /// Helium, yellow.
    pub const D: f32 = 587.561_8;
    /// Hydrogen, red.
    pub const C: f32 = 656.272_5;
}

/// A clear medium, by Sellmeier's equation: n² = 1 + A + Σ Bᵢ·λ²/(λ² − Cᵢ), λ in micrometres, over
/// a range of wavelengths, with an index from 1 to [`MOST_INDEX`](Self::MOST_INDEX), if it was made
/// here or [checked](Self::check). As bytes it is eleven little-endian f32, part of a baked scene.
#[derive(Debug, Clone, Copy, PartialEq, FromBytes, IntoBytes, Immutable, KnownLayout)]
#[repr(C)]
pub struct Medium {
    /// Least and greatest wavelength: nanometres.
    range: [f32; 2],
    a: f32,
    /// 0 of terms that there are not.
    b: [f32; Medium::MOST_TERMS],
    /// Square micrometres.
    c: [f32; Medium::MOST_TERMS],
}

/// Why a medium cannot be made, or has no index.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
#[allow(missing_docs, reason = "the messages say what the fields are")]
pub enum MediumError {
    /// A range that is NaN, reversed, or not within [`Medium::WAVELENGTHS`].
    #[error(
        "the medium's range is {} to {} nm: give two wavelengths from {} to {} nm, the shorter one \
         first",
        .range[0], .range[1], Medium::WAVELENGTHS[0], Medium::WAVELENGTHS[1]
    )]
    Range { range: [f32; 2] },
    /// More terms than [`Medium::MOST_TERMS`].
    #[error(
        "the medium has {given} terms: give up to {} pairs of B and C",
        Medium::MOST_TERMS
    )]
    Terms { given: usize },
    /// A coefficient that is NaN or larger than [`Medium::MOST_COEFFICIENT`].
    #[error("a coefficient is {value}: give a number from -{most} to {most}", most = Medium::MOST_COEFFICIENT)]
    Coefficient { value: f32 },
    /// A term without limit inside the range.
    #[error(
        "the formula has a pole at {nm} nm, inside the medium's range of {} to {} nm: give a range on \
         one side of it",
        .range[0], .range[1]
    )]
    Pole { nm: f32, range: [f32; 2] },
    /// An index below 1 or above [`Medium::MOST_INDEX`], or next to either, in the range.
    #[error(
        "the square of the medium's index of refraction is {squared} at {nm} nm: give a range in \
         which the index is from 1 to {}",
        Medium::MOST_INDEX
    )]
    Index { nm: f32, squared: f32 },
    /// A wavelength that is NaN or outside the medium's range.
    #[error("a wavelength of {nm} nm is outside the medium's range, {} to {} nm", .range[0], .range[1])]
    OutOfRange { nm: f32, range: [f32; 2] },
}

impl Medium {
    /// Most pairs of B and C.
    pub const MOST_TERMS: usize = 4;

    /// Least and greatest wavelength of any range: nanometres.
    pub const WAVELENGTHS: [f32; 2] = [10.0, 1.0e6];

    /// Largest magnitude of A, of a B and of a C in square micrometres.
    pub const MOST_COEFFICIENT: f32 = 1.0e9;

    /// Greatest index of refraction, as of other materials.
    pub const MOST_INDEX: f32 = 100.0;

    /// Most steps of [`check`](Self::check) along the range.
    const MOST_STEPS: u32 = 1 << 14;

    /// Returns a medium by catalogues' form 1, n² = 1 + A + Σ Bᵢ·λ²/(λ² − Cᵢ²): `terms` are
    /// pairs of B and C, C in micrometres, `range` is in nanometres.
    ///
    /// # Errors
    /// All but [`MediumError::OutOfRange`].
    pub fn form1(range: [f32; 2], a: f32, terms: &[[f32; 2]]) -> Result<Self, MediumError> {
        Self::new(range, a, terms, |c| c * c)
    }

    /// Returns a medium by catalogues' form 2, n² = 1 + A + Σ Bᵢ·λ²/(λ² − Cᵢ): `terms` are
    /// pairs of B and C, C in square micrometres, `range` is in nanometres.
    ///
    /// # Errors
    /// All but [`MediumError::OutOfRange`].
    pub fn form2(range: [f32; 2], a: f32, terms: &[[f32; 2]]) -> Result<Self, MediumError> {
        Self::new(range, a, terms, |c| c)
    }

    fn new(
        range: [f32; 2],
        a: f32,
        terms: &[[f32; 2]],
        squared: fn(f32) -> f32,
    ) -> Result<Self, MediumError> {
        if terms.len() > Self::MOST_TERMS {
            let given = terms.len();
            return Err(MediumError::Terms { given });
        }
        let mut medium = Self {
            range,
            a,
            b: [0.0; Self::MOST_TERMS],
            c: [0.0; Self::MOST_TERMS],
        };
        let slots = medium.b.iter_mut().zip(&mut medium.c);
        for ((b, c), &[of_b, of_c]) in slots.zip(terms) {
            (*b, *c) = (of_b, squared(of_c));
        }
        medium.check()?;
        Ok(medium)
    }

    /// Returns one whose values a test has checked: form 2, or form 1 with C squared.
    pub(super) const fn known(
        range: [f32; 2],
        a: f32,
        b: [f32; Self::MOST_TERMS],
        c: [f32; Self::MOST_TERMS],
    ) -> Self {
        Self { range, a, b, c }
    }

    /// Returns whether the index is from 1 to [`MOST_INDEX`](Self::MOST_INDEX) in all of the range:
    /// for media that come as bytes. Proved by bounds over steps, since terms are monotone between
    /// poles, not sampled.
    ///
    /// # Errors
    /// All but [`MediumError::Terms`] and [`MediumError::OutOfRange`].
    pub fn check(&self) -> Result<(), MediumError> {
        let range = self.range;
        let [least, most] = Self::WAVELENGTHS;
        // NaN fails the comparisons.
        if !(least <= range[0] && range[0] < range[1] && range[1] <= most) {
            return Err(MediumError::Range { range });
        }
        let coefficients = [self.a].into_iter().chain(self.b).chain(self.c);
        for value in coefficients {
            if !(value.abs() <= Self::MOST_COEFFICIENT) {
                return Err(MediumError::Coefficient { value });
            }
        }
        let [start, end] = range.map(square_micrometres);
        for (b, c) in self.terms() {
            if b != 0.0 && start <= c && c <= end {
                let nm = 1.0e3 * sqrt(c);
                return Err(MediumError::Pole { nm, range });
            }
        }
        self.check_index(start, end)
    }

    /// Checks the index between square wavelengths without a pole between them.
    fn check_index(&self, start: f32, end: f32) -> Result<(), MediumError> {
        let allowed = 1.0 - Self::SLACK..=Self::MOST_INDEX * Self::MOST_INDEX;
        let mut at = start;
        let mut step = end - start;
        for _ in 0..Self::MOST_STEPS {
            let squared = self.squared_index(at);
            if !allowed.contains(&squared) {
                return Err(index_error(at, squared));
            }
            if at >= end {
                return Ok(());
            }
            let next = min(at + step, end);
            // The step no longer moves: the border is right here.
            if next <= at {
                return Err(index_error(at, squared));
            }
            let [low, high] = self.bounds(at, next);
            if allowed.contains(&low) && allowed.contains(&high) {
                at = next;
                step *= 2.0;
            } else {
                step *= 0.5;
            }
        }
        Err(index_error(at, self.squared_index(at)))
    }

    /// What rounding may take from n² = 1.
    const SLACK: f32 = 1.0e-6;

    /// Bounds of n² over square wavelengths between two that no pole divides.
    fn bounds(&self, from: f32, to: f32) -> [f32; 2] {
        let base = 1.0 + self.a;
        self.terms().fold([base; 2], |[low, high], term| {
            let (a, b) = (contribution(term, from), contribution(term, to));
            [low + min(a, b), high + max(a, b)]
        })
    }

    /// Pairs of B and C.
    fn terms(&self) -> impl Iterator<Item = (f32, f32)> {
        self.b.into_iter().zip(self.c)
    }

    /// n², of the square of a wavelength in micrometres.
    #[inline]
    fn squared_index(&self, square: f32) -> f32 {
        // The largest last: it decides the rounding.
        let sum = self
            .terms()
            .fold(self.a, |sum, term| sum + contribution(term, square));
        1.0 + sum
    }

    /// Returns the least and the greatest wavelength that the coefficients are good
    /// for: nanometres.
    pub const fn range(&self) -> [f32; 2] {
        self.range
    }

    /// Returns whether the index depends on the wavelength.
    pub fn is_dispersive(&self) -> bool {
        let mut terms = self.b.iter().zip(&self.c);
        terms.any(|(&b, &c)| b != 0.0 && c != 0.0)
    }

    /// Index of refraction at a wavelength in nanometres in the [`range`](Self::range); at least 1
    /// elsewhere, and never NaN. Relative error ≤ 2.8e-7 of the named media.
    #[inline]
    pub fn index(&self, nm: f32) -> f32 {
        max(sqrt(self.squared_index(square_micrometres(nm))), 1.0)
    }

    /// [`index`](Self::index) where the medium is known.
    ///
    /// # Errors
    /// A wavelength outside the [`range`](Self::range).
    pub fn index_in(&self, nm: f32) -> Result<f32, MediumError> {
        let range = self.range;
        if range[0] <= nm && nm <= range[1] {
            Ok(self.index(nm))
        } else {
            Err(MediumError::OutOfRange { nm, range })
        }
    }

    /// [`index`](Self::index) at the wavelength of the [`range`](Self::range)
    /// that is nearest: for callers that asked for this.
    pub fn index_clamped(&self, nm: f32) -> f32 {
        let [least, most] = self.range;
        self.index(max(least, min(nm, most)))
    }

    /// Abbe's number `(n_d − 1)/(n_F − n_C)`; `None` where one of the [lines](mod@line) is out of
    /// range or the medium has no dispersion, or less than the quotient can tell.
    pub fn abbe(&self) -> Option<f32> {
        let n_f = self.index_in(line::F).ok()?;
        let n_d = self.index_in(line::D).ok()?;
        let n_c = self.index_in(line::C).ok()?;
        let [f, d, c] = [line::F, line::D, line::C].map(square_micrometres);
        let apart = 1.0e-6 * (line::C - line::F) * (line::C + line::F);
        // n_F² − n_C²: each term's is B·C·(c − f)/((f − C)·(c − C)).
        let between = self.terms().fold(0.0, |sum, (b, pole)| {
            sum + b * pole * apart / ((f - pole) * (c - pole))
        });
        let above_one = (self.squared_index(d) - 1.0) / (n_d + 1.0);
        Some(above_one * (n_f + n_c) / between).filter(|abbe| abbe.is_finite())
    }
}

fn index_error(square: f32, squared: f32) -> MediumError {
    let nm = 1.0e3 * sqrt(square);
    MediumError::Index { nm, squared }
}

/// Returns λ² in square micrometres, from λ in nanometres.
#[inline]
fn square_micrometres(nm: f32) -> f32 {
    let micrometres = nm / 1.0e3;
    micrometres * micrometres
}

/// Returns a term of the sum, B·λ²/(λ² − C); 0 for an unused term, whose B is 0.
#[inline]
fn contribution((b, c): (f32, f32), square: f32) -> f32 {
    if b == 0.0 {
        0.0
    } else {
        b * square / (square - c)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hostile::{finite, finite_or_error, with_hostile_numbers};
    use std::string::ToString;

    #[test]
    fn a_dip_between_samples_is_found() {
        // n² − 1 = A + B·x/(x − C) − D·x/(x − E) has a minimum inside: lift it
        // until it is just above 0.
        let range = [400.0, 700.0];
        let terms = [[0.4, 0.1], [-1.69, 0.04]];
        let squared = |a: f64, x: f64| 1.0 + a + 0.4 * x / (x - 0.1) - 1.69 * x / (x - 0.04);
        let places = (0..=300_000).map(|i| 0.16 + 0.33 * f64::from(i) / 300_000.0);
        // Fewer under Miri, which is slow.
        let places = places.step_by(if cfg!(miri) { 300 } else { 1 });
        let least = places.fold(f64::MAX, |least, x| least.min(squared(0.0, x)));
        assert!(least < squared(0.0, 0.16) - 0.01 && least < squared(0.0, 0.49) - 0.01);
        let lifted = |above: f64| Medium::form2(range, (1.0 - least + above) as f32, &terms);
        assert!(lifted(1.0e-4).is_ok());
        for below in [-1.0e-5, -1.0e-4, -1.0e-3, -0.1] {
            assert!(matches!(lifted(below), Err(MediumError::Index { .. })));
        }
    }

    #[test]
    fn built_in_media_and_flat_ones_are_accepted() {
        for (name, medium) in Medium::NAMED {
            assert_eq!(medium.check(), Ok(()), "{name}");
        }
        // No dispersion, nothing at all, the densest there may be, and a pole that no term has.
        let flat = |a| Medium::form2([400.0, 700.0], a, &[]);
        assert_eq!(flat(0.0).unwrap().index(500.0), 1.0);
        assert_eq!(flat(0.0).unwrap().abbe(), None);
        assert_eq!(flat(9999.0).unwrap().index(500.0), 100.0);
        let none = Medium::form1([400.0, 700.0], 1.25, &[[0.0, 0.5]]).unwrap();
        assert_eq!(none.index(500.0), 1.5);
    }

    #[test]
    fn media_that_are_none_are_refused_by_name() {
        let says = |range, a, terms: &[[f32; 2]], words: &str| {
            let error = Medium::form2(range, a, terms).unwrap_err().to_string();
            assert!(error.contains(words), "{error}");
        };
        let range = [400.0, 700.0];
        let nan = f32::NAN;
        says([700.0, 400.0], 0.0, &[], "range is 700 to 400 nm");
        says([400.0, 400.0], 0.0, &[], "10 to 1000000 nm");
        says([-1.0, 400.0], 0.0, &[], "-1 to 400");
        says([nan, 400.0], 0.0, &[], "NaN to 400");
        says([400.0, f32::INFINITY], 0.0, &[], "400 to inf");
        says(range, nan, &[], "coefficient is NaN");
        says(range, 0.0, &[[2.0e9, 0.01]], "from -1000000000 to");
        says(range, 0.0, &[[1.0, f32::INFINITY]], "is inf");
        says(range, 0.0, &[[1.0, 0.01]; 5], "5 terms: give up to 4");
        says(range, 0.0, &[[1.0, 0.25]], "pole at 500 nm");
        says(range, 0.0, &[[1.0, 0.4 * 0.4]], "pole at 400 nm");
        says(range, 0.0, &[[1.0, 0.7 * 0.7]], "pole at 700 nm");
        says(range, -0.5, &[], "0.5 at 400 nm");
        says(range, 10_000.0, &[], "10001 at 400 nm");
        // Beside a pole the index has no limit, before one it is below 1.
        for beside in [0.399_999f32, 0.700_001] {
            says(range, 0.0, &[[1.0, beside * beside]], "the square of");
        }
        // A root too large for its square.
        assert!(Medium::form1(range, 0.0, &[[1.0, 1.0e30]]).is_err());
    }

    #[test]
    fn media_of_any_numbers_have_an_index_all_over_their_range() {
        with_hostile_numbers(|n| {
            let nm = n.next(550.0);
            for (_, medium) in Medium::NAMED {
                assert!(medium.index(nm) >= 1.0);
                assert!((1.0..=Medium::MOST_INDEX).contains(&medium.index_clamped(nm)));
                finite_or_error(medium.index_in(nm));
            }
            let (range, a) = ([n.next(400.0), n.next(700.0)], n.next(0.1));
            let terms = [[n.next(1.1), n.next(0.01)], [n.next(0.2), n.next(0.02)]];
            let media = [Medium::form1, Medium::form2].map(|form| form(range, a, &terms));
            for medium in media.into_iter().filter_map(finite_or_error) {
                for step in 0..=16 {
                    let part = step as f32 / 16.0;
                    let nm = (range[0] + (range[1] - range[0]) * part).min(range[1]);
                    let index = medium.index_in(nm).unwrap();
                    assert!((1.0..=Medium::MOST_INDEX).contains(&index), "{index}");
                }
                finite(&medium.abbe());
            }
        });
    }
}
