use shisen_core::spectrum::{Matching, SpectralTable, Wavelengths};

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
    /// The default range: nanometres.
    pub const fn range(self) -> [f32; 2] {
        match self {
            Self::Fixed | Self::Comb | Self::Split => Wavelengths::RANGE,
            Self::Paper => Wavelengths::PAPER_RANGE,
        }
    }

    /// The default colours.
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
