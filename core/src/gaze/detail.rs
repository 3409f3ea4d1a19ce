/// The detail of a ray tree by its level: bounces, polygons and wavelengths.
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd)]
pub struct Detail(f32);

impl Detail {
    /// Full detail: level 1.
    pub const FULL: Self = Self(1.0);

    /// No detail: level 0.
    pub const NONE: Self = Self(0.0);

    /// Returns the detail of a level from 0 to 1; `None` for other levels and NaN.
    pub fn of_level(level: f32) -> Option<Self> {
        (0.0..=1.0).contains(&level).then_some(Self(level))
    }

    /// Returns the level, 0 to 1.
    pub const fn level(self) -> f32 {
        self.0
    }

    /// Returns whether a ray is traced: the level is above 0.
    pub fn is_traced(self) -> bool {
        self.0 > 0.0
    }

    /// Returns the reflections and refractions along a path, at most `most`:
    /// equation 9, rounded down, since step 6 of the paper ends a path when their
    /// number "exceeds" it. Only level 1 has `most`.
    pub fn bounces(self, most: u8) -> u8 {
        (self.0 * f32::from(most)) as u8
    }

    /// Returns the faces of a mesh: equation 10 in steps of two faces, since a
    /// closed mesh loses two at a time. From `range`'s least to its most, which
    /// level 1 always gets.
    pub fn faces(self, range: FaceRange) -> u32 {
        // 32 fractional bits: exact down to level 2⁻⁸; below that the error is far
        // less than a face.
        let level = (self.0 * 4_294_967_296.0) as u64;
        // No overflow: the difference is below 2³².
        let removed = u64::from(range.max - range.min) * level;
        let pairs = removed.saturating_add(1 << 32) >> 33;
        // An odd number ends with a single face.
        (u64::from(range.min) + 2 * pairs).min(u64::from(range.max)) as u32
    }

    /// Returns the number of wavelengths of a pixel's samples: `most` at level 1, 1
    /// towards the field's rim, 0 where nothing is traced.
    pub fn wavelengths(self, most: u8) -> u8 {
        let more = f32::from(most.saturating_sub(1)) * self.0;
        u8::from(self.is_traced()).min(most) + more as u8
    }
}

/// The least and the most faces of a mesh: `N_min` and `N_max` of equation 10.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FaceRange {
    min: u32,
    max: u32,
}

/// Why two numbers are not a range of faces.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
#[allow(missing_docs, reason = "the messages say what the fields are")]
pub enum FaceRangeError {
    /// A least number of 0.
    #[error("a mesh cannot be shown with 0 faces: give at least 1")]
    Zero,
    /// A least number above the most.
    #[error("the least number of faces, {min}, is above the most, {max}: exchange them")]
    Reversed { min: u32, max: u32 },
}

impl FaceRange {
    /// Returns the range from `min` to `max` faces.
    ///
    /// # Errors
    /// A `min` that is 0 or above `max`.
    pub const fn new(min: u32, max: u32) -> Result<Self, FaceRangeError> {
        if min == 0 {
            Err(FaceRangeError::Zero)
        } else if min > max {
            Err(FaceRangeError::Reversed { min, max })
        } else {
            Ok(Self { min, max })
        }
    }

    /// Returns the faces at level 0.
    pub const fn min(self) -> u32 {
        self.min
    }

    /// Returns the faces at level 1.
    pub const fn max(self) -> u32 {
        self.max
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn detail(level: f32) -> Detail {
        Detail::of_level(level).unwrap()
    }

    #[test]
    fn all_bounces_and_wavelengths_only_at_level_1() {
        for bad in [f32::NAN, -1.0e-9, 1.0f32.next_up(), f32::INFINITY] {
            assert_eq!(Detail::of_level(bad), None);
        }
        let below = 1.0 - f32::EPSILON / 2.0;
        for most in [1, 3, 16, 255] {
            assert_eq!(Detail::FULL.bounces(most), most);
            assert_eq!(detail(below).bounces(most), most - 1);
            assert_eq!(Detail::FULL.wavelengths(most), most);
            let none = (detail(0.0).bounces(most), detail(0.0).wavelengths(most));
            assert_eq!(none, (0, 0));
            let faint = detail(f32::from_bits(1));
            assert_eq!((faint.bounces(most), faint.wavelengths(most)), (0, 1));
        }
        let bounces = [0.14, 0.34, 0.66, 0.67].map(|level| detail(level).bounces(3));
        assert_eq!(bounces, [0, 1, 1, 2]);
    }

    #[test]
    fn faces_go_in_pairs_from_the_least_to_the_most() {
        assert_eq!(FaceRange::new(0, 5), Err(FaceRangeError::Zero));
        let error = FaceRangeError::Reversed { min: 6, max: 5 };
        assert_eq!(FaceRange::new(6, 5), Err(error));
        let cow = FaceRange::new(500, 5804).unwrap();
        assert_eq!(detail(0.5).faces(cow), 3152);
        for (min, max) in [(1, 1), (1, 2), (4, 9), (1, u32::MAX), (u32::MAX, u32::MAX)] {
            let range = FaceRange::new(min, max).unwrap();
            assert_eq!(detail(0.0).faces(range), min);
            assert_eq!(Detail::FULL.faces(range), max);
        }
    }

    proptest! {
        #[test]
        fn faces_are_equation_10(level in 0f32..=1.0, min in 1u32..9999, more in 0u32..1_000_000) {
            let range = FaceRange::new(min, min + 2 * more).unwrap();
            let exact = f64::from(level) * f64::from(more);
            let found = f64::from(detail(level).faces(range) - min) / 2.0;
            prop_assert_eq!(found.fract(), 0.0);
            prop_assert!((found - exact).abs() <= 0.5 + 1e-3, "{} {}", found, exact);
        }
    }
}
