//! Light by its wavelengths: media by name, and ways to choose wavelengths.
//!
//! The tracer's own types are in [`shisen_core::spectrum`].

use crate::files::description::suggestion;
use miette::Diagnostic;
use shisen_core::frame::Spectrum;
use shisen_core::spectrum::{
    Matching, MatchingTable, Medium, SpectralSample, SpectralTable, Wavelengths, WavelengthsError,
};
use std::sync::LazyLock;
use thiserror::Error;

/// The colour-matching functions of the CIE 1931 standard observer, 2°: the standard's table at
/// steps of 5 nm, 380 to 780 nm.
pub static CIE_1931: LazyLock<MatchingTable<'static>> = LazyLock::new(|| {
    let rows = include_str!("spectrum/cie1931.csv").lines().skip(1);
    let xyz: Vec<[f32; 3]> = rows
        .map(|row| {
            let mut numbers = row.split(',').skip(1).map(str::parse::<f32>);
            [(); 3].map(|()| numbers.next().expect("x, y and z").expect("a number"))
        })
        .collect();
    MatchingTable {
        first_nm: 380.0,
        step_nm: 5.0,
        xyz: xyz.leak(),
    }
});

/// A name that no medium has.
#[derive(Debug, Clone, PartialEq, Eq, Error, Diagnostic)]
#[error("{0}")]
pub struct UnknownMedium(String);

/// Returns the built-in medium of a name.
///
/// # Errors
/// An unknown name.
pub fn medium(name: &str) -> Result<Medium, UnknownMedium> {
    Medium::named(name).ok_or_else(|| {
        let help = suggestion(name, Medium::NAMED.map(|(known, _)| known)).unwrap_or_default();
        let name = name.escape_debug();
        UnknownMedium(format!("there is no medium \"{name}\": {help}"))
    })
}

/// A way to choose wavelengths.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Method {
    /// The centres of n equal parts of 400 to 700 nm, for all rays.
    Fixed,
    /// The same, shifted by an offset that changes from ray to ray.
    Comb,
    /// As a comb, each ray taking all of its wavelengths.
    Split,
    /// As in Kishioka's paper: the centres of n equal parts of 380 to 750 nm, in Endo's colours.
    Paper,
}

named!(Method { Fixed => "fixed", Comb => "comb", Split => "split", Paper => "paper" });

impl Method {
    /// Returns the default range: nanometres.
    pub const fn range(self) -> [f32; 2] {
        match self {
            Self::Fixed | Self::Comb | Self::Split => Wavelengths::RANGE,
            Self::Paper => Wavelengths::PAPER_RANGE,
        }
    }

    /// Returns the default colours.
    pub const fn matching(self) -> Matching<'static> {
        match self {
            Self::Fixed | Self::Comb | Self::Split => Matching::Wyman,
            Self::Paper => Matching::Endo,
        }
    }

    /// Phases of its table.
    pub const fn phases(self) -> u32 {
        match self {
            Self::Fixed | Self::Paper => 1,
            Self::Comb | Self::Split => SpectralTable::COMB_PHASES,
        }
    }
}

/// How pictures take wavelengths, where a scene asks for dispersion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Dispersion {
    /// None: media have the index of the d line for all colours.
    Off,
    /// [`Spectrum::Comb`], and how many each sample takes.
    Comb(Wavelengths, u8),
    /// A comb in the colours of the CIE's own table of which each sample takes
    /// all: what others are measured against.
    Reference(Wavelengths),
    /// Kishioka's: a whole picture for each wavelength, with its share of the
    /// samples, one at least; their sum in these colours.
    Images(Wavelengths, Matching<'static>),
    /// [`Spectrum::Single`]: nanometres.
    Single(f32),
}

impl Default for Dispersion {
    /// Returns a comb of 14 wavelengths.
    fn default() -> Self {
        Self::of(Method::Comb, Self::WAVELENGTHS, None).unwrap_or(Self::Off)
    }
}

impl Dispersion {
    /// The default number of wavelengths.
    pub const WAVELENGTHS: u32 = 14;

    /// Takes `count` wavelengths by a method, from a range in nanometres or the method's own. A
    /// single wavelength turns dispersion off, but for methods with a picture for each.
    ///
    /// # Errors
    /// A number or a range that cannot be.
    pub fn of(
        method: Method,
        count: u32,
        range: Option<[f32; 2]>,
    ) -> Result<Self, WavelengthsError> {
        let wavelengths = Wavelengths::new(count, range.unwrap_or(method.range()))?;
        Ok(match method {
            Method::Paper | Method::Fixed => Self::Images(wavelengths, method.matching()),
            _ if count == 1 => Self::Off,
            Method::Comb => Self::Comb(wavelengths, 1),
            Method::Split => Self::Comb(wavelengths, u8::MAX),
        })
    }

    /// Returns its wavelengths, if it has several.
    pub const fn wavelengths(&self) -> Option<Wavelengths> {
        match *self {
            Self::Comb(wavelengths, _)
            | Self::Reference(wavelengths)
            | Self::Images(wavelengths, _) => Some(wavelengths),
            Self::Off | Self::Single(_) => None,
        }
    }

    /// Returns the spectrum in the tracer's terms, its table in `storage`. For pictures of single
    /// wavelengths, which are rendered one by one, that is plain RGB.
    pub fn spectrum<'s>(&self, storage: &'s mut Vec<SpectralSample>) -> Spectrum<'s> {
        let (wavelengths, each, matching) = match *self {
            Self::Off | Self::Images(..) => return Spectrum::Rgb,
            Self::Single(nm) => return Spectrum::Single(nm),
            Self::Comb(wavelengths, each) => (wavelengths, each, Matching::Wyman),
            Self::Reference(wavelengths) => (wavelengths, u8::MAX, Matching::Table(*CIE_1931)),
        };
        let phases = SpectralTable::COMB_PHASES;
        storage.resize(
            SpectralTable::samples(wavelengths, phases),
            SpectralSample::default(),
        );
        let table = SpectralTable::new(wavelengths, phases, matching, storage);
        // The storage is large enough, and the number of phases allowed.
        table.map_or(Spectrum::Rgb, |table| Spectrum::Comb { table, each })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_fit_is_as_near_to_the_table_as_its_authors_say() {
        let table = Matching::Table(*CIE_1931);
        // At the table's own wavelengths: between them it is interpolated.
        let worst = (0..=80u16).fold([0f32; 3], |worst, i| {
            let nm = 380.0 + 5.0 * f32::from(i);
            let error = (Matching::Wyman.values(nm) - table.values(nm)).abs();
            let [x, y, z] = error.to_array();
            [worst[0].max(x), worst[1].max(y), worst[2].max(z)]
        });
        for (worst, bound) in worst.into_iter().zip([0.0140, 0.0080, 0.0222]) {
            assert!(worst <= bound && worst > 0.9 * bound, "{worst} {bound}");
        }
    }
}
