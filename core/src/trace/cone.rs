//! The widths of rays: how large a part of what it meets a pixel sees (Akenine-Möller et al. 2019,
//! "Texture Level of Detail Strategies for Real-Time Ray Tracing").

/// Bits of an f32 below those that are kept: five of its exponent and three of its mantissa.
const BELOW: u32 = 20;

/// The kept bits of 2⁻²⁰, the least width but zero.
const LEAST: u32 = (127 - 20) << 3;

/// A width or a spread in a byte: zero, or 2⁻²⁰ to 2¹¹ in eight steps an octave.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Width(u8);

impl Width {
    /// No width.
    pub const ZERO: Self = Self(0);

    /// Returns the width next below a number, or the nearest there is; zero for what is no number.
    #[inline(always)]
    pub(crate) fn new(width: f32) -> Self {
        if width > 0.0 {
            let kept = (width.to_bits() >> BELOW).saturating_sub(LEAST);
            Self(kept.min(u8::MAX as u32) as u8)
        } else {
            Self::ZERO
        }
    }

    /// Returns the number.
    #[inline(always)]
    pub(crate) const fn get(self) -> f32 {
        if self.0 == 0 {
            return 0.0;
        }
        f32::from_bits((self.0 as u32 + LEAST) << BELOW)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_width_is_at_most_an_eighth_less_than_its_number() {
        for exponent in -19..11 {
            for share in [1.0, 1.1, 1.5, 1.99] {
                let width = share * libm::exp2f(exponent as f32);
                let kept = Width::new(width).get();
                assert!(kept <= width && kept > width * 0.875, "{width} {kept}");
                assert_eq!(Width::new(kept).get(), kept);
            }
        }
        for none in [0.0, -1.0, f32::NAN, 1.0e-9] {
            assert_eq!(Width::new(none), Width::ZERO);
        }
        assert!(Width::new(f32::INFINITY).get() > 2000.0);
    }
}
