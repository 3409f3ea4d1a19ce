use crate::numeric::{max, min};

/// n wavelengths: one in each of n equal parts of a range, at the same place
/// in each.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wavelengths {
    count: u8,
    range: [f32; 2],
}

/// Why wavelengths cannot be made.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
#[allow(missing_docs, reason = "the messages say what the fields are")]
pub enum WavelengthsError {
    /// The number of wavelengths is 0 or more than [`Wavelengths::MOST`].
    #[error("{given} wavelengths: give a number from 1 to {}", Wavelengths::MOST)]
    Count { given: u32 },
    /// A range that is NaN, reversed, or not within [`Wavelengths::LIMITS`].
    #[error(
        "the range of wavelengths is {} to {} nm: give two from {} to {} nm, the shorter one first",
        .range[0], .range[1], Wavelengths::LIMITS[0], Wavelengths::LIMITS[1]
    )]
    Range { range: [f32; 2] },
    /// Two ranges without a wavelength in common.
    #[error(
        "no wavelength from {} to {} nm is within {} to {} nm: give a range that is, in part at least",
        .range[0], .range[1], .within[0], .within[1]
    )]
    Apart { range: [f32; 2], within: [f32; 2] },
}

impl Wavelengths {
    /// Most of them.
    pub const MOST: u32 = 64;

    /// Least and greatest wavelength of any range: nanometres. What the
    /// standard's tables have.
    pub const LIMITS: [f32; 2] = [360.0, 830.0];

    /// The range unless somebody asks for another: nanometres.
    pub const RANGE: [f32; 2] = [400.0, 700.0];

    /// Range of Endo's colours, and so of Kishioka's paper: nanometres.
    pub const PAPER_RANGE: [f32; 2] = [380.0, 750.0];

    /// `count` wavelengths, 1 to [`MOST`](Self::MOST), of a range in
    /// nanometres within [`LIMITS`](Self::LIMITS).
    ///
    /// # Errors
    /// Any other number or range.
    pub fn new(count: u32, range: [f32; 2]) -> Result<Self, WavelengthsError> {
        if !(1..=Self::MOST).contains(&count) {
            return Err(WavelengthsError::Count { given: count });
        }
        let [least, most] = Self::LIMITS;
        // NaN fails the comparisons.
        if !(least <= range[0] && range[0] < range[1] && range[1] <= most) {
            return Err(WavelengthsError::Range { range });
        }
        let count = count as u8;
        Ok(Self { count, range })
    }

    /// As many, of the part of their range that is within another, in
    /// nanometres: a medium's.
    ///
    /// # Errors
    /// Ranges that have nothing in common.
    pub fn clamped_to(self, within: [f32; 2]) -> Result<Self, WavelengthsError> {
        let range = self.range;
        let low = max(range[0], within[0]);
        let high = min(range[1], within[1]);
        if !(low < high) {
            return Err(WavelengthsError::Apart { range, within });
        }
        let range = [low, high];
        Ok(Self { range, ..self })
    }

    /// Returns the number of wavelengths.
    pub const fn count(&self) -> usize {
        self.count as usize
    }

    /// Returns the least and the greatest there may be: nanometres.
    pub const fn range(&self) -> [f32; 2] {
        self.range
    }

    /// Returns the wavelength in part `k`, 0 to [`count`](Self::count) − 1, nanometres, at `offset`
    /// in it, 0 to 1; ½ is its centre. Others are moved into the range.
    pub fn at(&self, k: usize, offset: f32) -> f32 {
        let [low, high] = self.range;
        let part = (k as f32 + offset) / f32::from(self.count);
        // Rounding must not lead out of the range.
        max(min(low + (high - low) * part, high), low)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::string::ToString;

    #[test]
    fn clamping_keeps_the_number() {
        let paper = Wavelengths::new(14, Wavelengths::PAPER_RANGE).unwrap();
        let clamped = paper.clamped_to([390.0, 2500.0]).unwrap();
        assert_eq!((clamped.count(), clamped.range()), (14, [390.0, 750.0]));
        assert_eq!(paper.clamped_to([200.0, 2000.0]), Ok(paper));
        for within in [[750.0, 900.0], [100.0, 380.0], [f32::NAN, f32::NAN]] {
            let error = paper.clamped_to(within).unwrap_err().to_string();
            assert!(error.contains("no wavelength from 380 to 750"), "{error}");
        }
    }

    #[test]
    fn numbers_and_ranges_that_are_none_are_refused() {
        for given in [0, 65, u32::MAX] {
            let error = Wavelengths::new(given, Wavelengths::RANGE).unwrap_err();
            assert_eq!(error, WavelengthsError::Count { given });
            assert!(error.to_string().contains("from 1 to 64"));
        }
        let nan = f32::NAN;
        for range in [
            [700.0, 400.0],
            [500.0, 500.0],
            [359.0, 700.0],
            [400.0, 831.0],
            [nan, 700.0],
            [400.0, nan],
        ] {
            let error = Wavelengths::new(7, range).unwrap_err().to_string();
            assert!(error.contains("from 360 to 830 nm"), "{error}");
        }
    }
}
