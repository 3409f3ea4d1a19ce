use super::{CIE_1931, Method};
use shisen_core::frame::Spectrum;
use shisen_core::spectrum::{
    Matching, SpectralSample, SpectralTable, Wavelengths, WavelengthsError,
};

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
    /// A comb of 14 wavelengths.
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

    /// Its wavelengths, if it has several.
    pub const fn wavelengths(&self) -> Option<Wavelengths> {
        match *self {
            Self::Comb(wavelengths, _)
            | Self::Reference(wavelengths)
            | Self::Images(wavelengths, _) => Some(wavelengths),
            Self::Off | Self::Single(_) => None,
        }
    }

    /// The spectrum in the tracer's terms, its table in `storage`. For pictures of single
    /// wavelengths, which are rendered one by one, that is plain RGB.
    pub fn spectrum<'s>(&self, storage: &'s mut Vec<SpectralSample>) -> Spectrum<'s> {
        let (wavelengths, each, matching) = match *self {
            Self::Off | Self::Images(..) => return Spectrum::Rgb,
            Self::Single(nm) => return Spectrum::Single(nm),
            Self::Comb(wavelengths, each) => (wavelengths, each, Matching::Wyman),
            Self::Reference(wavelengths) => (wavelengths, u8::MAX, Matching::Table(CIE_1931)),
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
