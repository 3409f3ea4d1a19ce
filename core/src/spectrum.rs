//! Light by wavelength: media that bend each differently, and the colour that
//! a display gives it.
//!
//! Wavelengths are in nanometres, in air; coefficients of media in
//! micrometres, as catalogues have them. Colours are linear sRGB.
//!
//! A ray that takes n wavelengths adds up n colours: [`SpectralTable`] has the
//! wavelengths and what light of each counts for, worked out once, so that n
//! of them sum to the display's white. A [`Medium`] says what index of
//! refraction each of them meets. Sources:
//! - media: Sellmeier's equation with the coefficients of Malitson 1965, Ghosh
//!   1999, Schott, Peter 1923 and Daimon & Masumura 2007;
//! - colour matching: Wyman, Sloan & Shirley, "Simple Analytic Approximations
//!   to the CIE XYZ Color Matching Functions" (2013), and Endo's Gaussians,
//!   which Kishioka's paper uses.

mod matching;
mod medium;
mod named;
mod table;
mod wavelengths;

pub use matching::{Matching, MatchingTable, rgb_from_xyz, xyz_from_rgb};
pub use medium::{Medium, MediumError, line};
pub use table::{SpectralSample, SpectralTable, TableError};
pub use wavelengths::{Wavelengths, WavelengthsError};
