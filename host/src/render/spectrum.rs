//! Light by its wavelengths: media by name, ways to choose wavelengths, prisms.
//!
//! What the tracer computes with is in [`shisen_core::spectrum`].

mod cie1931;
mod dispersion;
mod method;
mod prism;

pub use cie1931::CIE_1931;
pub use dispersion::Dispersion;
pub use method::Method;
pub use prism::minimum_deviation;

use crate::files::description::suggestion;
use miette::Diagnostic;
use shisen_core::spectrum::Medium;
use thiserror::Error;

/// A name that no medium has.
#[derive(Debug, Clone, PartialEq, Eq, Error, Diagnostic)]
#[error("{0}")]
pub struct UnknownMedium(String);

/// The built-in medium of a name.
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

#[cfg(test)]
mod tests {
    use super::*;
    use shisen_core::spectrum::Matching;

    #[test]
    fn the_fit_is_as_near_to_the_table_as_its_authors_say() {
        let table = Matching::Table(CIE_1931);
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
