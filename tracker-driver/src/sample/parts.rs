//! Which parts of a sample something is about.

use core::fmt;

/// A part of a sample that a device may fail to measure while it measures others.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Part {
    /// How the head is turned.
    HeadOrientation,
    /// Where the left eye's line of sight starts.
    LeftOrigin,
    /// Where the left eye looks.
    LeftDirection,
    /// The left pupil's diameter.
    LeftPupil,
    /// Where the right eye's line of sight starts.
    RightOrigin,
    /// Where the right eye looks.
    RightDirection,
    /// The right pupil's diameter.
    RightPupil,
    /// Where both eyes together look.
    CombinedDirection,
    /// The point that is looked at.
    GazePoint,
}

impl Part {
    /// All of them, in the order of their bits in [`Parts::bits`].
    pub const ALL: [Self; 9] = [
        Self::HeadOrientation,
        Self::LeftOrigin,
        Self::LeftDirection,
        Self::LeftPupil,
        Self::RightOrigin,
        Self::RightDirection,
        Self::RightPupil,
        Self::CombinedDirection,
        Self::GazePoint,
    ];

    /// In words, for a report.
    pub const fn name(self) -> &'static str {
        match self {
            Self::HeadOrientation => "the head's orientation",
            Self::LeftOrigin => "the left eye's origin",
            Self::LeftDirection => "the left eye's direction",
            Self::LeftPupil => "the left pupil",
            Self::RightOrigin => "the right eye's origin",
            Self::RightDirection => "the right eye's direction",
            Self::RightPupil => "the right pupil",
            Self::CombinedDirection => "the combined direction",
            Self::GazePoint => "the gaze point",
        }
    }
}

/// Some parts of a sample.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Parts(u16);

impl Parts {
    /// None of them.
    pub const NONE: Self = Self(0);

    /// Returns the parts of these bits: the lowest is that of the first of [`Part::ALL`]. `None` where
    /// one is no part's.
    pub const fn from_bits(bits: u16) -> Option<Self> {
        if bits >> Part::ALL.len() == 0 {
            Some(Self(bits))
        } else {
            None
        }
    }

    /// As bits, the lowest of which is that of the first of [`Part::ALL`].
    pub const fn bits(self) -> u16 {
        self.0
    }

    /// Returns these parts and one more.
    #[must_use]
    pub const fn with(self, part: Part) -> Self {
        Self(self.0 | 1 << part as u16)
    }

    /// Returns these parts without one.
    #[must_use]
    pub const fn without(self, part: Part) -> Self {
        Self(self.0 & !(1 << part as u16))
    }

    /// Returns whether a part is among them.
    pub const fn contains(self, part: Part) -> bool {
        self.0 & 1 << part as u16 != 0
    }

    /// Returns whether there is none.
    pub const fn is_empty(self) -> bool {
        self.0 == 0
    }
}

impl fmt::Display for Parts {
    /// Returns the names, between commas.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut before = "";
        for part in Part::ALL {
            if self.contains(part) {
                write!(f, "{before}{}", part.name())?;
                before = ", ";
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::format;

    #[test]
    fn each_part_has_a_bit_and_a_name() {
        let mut all = Parts::NONE;
        for (i, part) in Part::ALL.into_iter().enumerate() {
            let one = Parts::NONE.with(part);
            assert_eq!(one.bits(), 1 << i, "{part:?}");
            assert!(!all.contains(part) && one.contains(part));
            assert_eq!(format!("{one}"), part.name());
            all = all.with(part);
        }
        assert_eq!(Parts::from_bits(all.bits()), Some(all));
        assert_eq!(Parts::from_bits(all.bits() + 1), None);
        let two = Parts::NONE.with(Part::RightPupil).with(Part::LeftOrigin);
        assert_eq!(format!("{two}"), "the left eye's origin, the right pupil");
        let one = Parts::NONE.with(Part::LeftOrigin);
        assert_eq!(two.without(Part::RightPupil), one);
        assert!(Parts::NONE.is_empty() && !two.is_empty());
    }
}
