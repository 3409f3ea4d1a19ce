//! Codes and light: gammas, curves, and tables of codes.

use std::f64;

/// A channel's light for its codes, both 0 to 1.
#[derive(Debug, Clone, PartialEq)]
pub enum Transfer {
    /// IEC 61966-2-1.
    Srgb,
    /// The code to the power of this gamma.
    Gamma(f64),
    /// The light at codes of equal steps from 0 to 1, rising from 0 to 1.
    Curve(Vec<f64>),
}

impl Transfer {
    /// Least and greatest gamma.
    pub const GAMMAS: [f64; 2] = [1.0, 4.0];

    /// Returns a code's light.
    pub fn light(&self, code: f64) -> f64 {
        let code = code.clamp(0.0, 1.0);
        match self {
            Self::Srgb if code <= 0.040_45 => code / 12.92,
            Self::Srgb => libm::pow((code + 0.055) / 1.055, 2.4),
            Self::Gamma(gamma) => libm::pow(code, *gamma),
            Self::Curve(lights) => {
                let at = code * (lights.len() - 1) as f64;
                let below = (at as usize).min(lights.len() - 2);
                let [low, high] = [lights[below], lights[below + 1]];
                low + (at - below as f64) * (high - low)
            }
        }
    }

    /// Returns the code for a light.
    pub fn code(&self, light: f64) -> f64 {
        let light = light.clamp(0.0, 1.0);
        match self {
            Self::Srgb if light <= 0.003_130_8 => 12.92 * light,
            Self::Srgb => 1.055 * libm::pow(light, 1.0 / 2.4) - 0.055,
            Self::Gamma(gamma) => libm::pow(light, 1.0 / gamma),
            Self::Curve(lights) => {
                let above = lights.partition_point(|one| *one < light);
                let above = above.clamp(1, lights.len() - 1);
                let [low, high] = [lights[above - 1], lights[above]];
                let share = (light - low) / (high - low);
                ((above - 1) as f64 + share) / (lights.len() - 1) as f64
            }
        }
    }
}

/// The 8-bit codes of lights, by their floating-point bits: within 0.57 of the exact code for
/// gammas.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Codes(Box<[u8; 1 << 16]>);

impl Codes {
    /// Bits of a light that do not count: 11 of the fraction do.
    const DROPPED: u32 = 12;
    /// The least light that is told from none.
    pub(super) const LEAST: f32 = f32::from_bits(Self::FIRST);
    const FIRST: u32 = (127 - 31) << 23;

    #[allow(clippy::large_stack_arrays, reason = "boxed at once")]
    pub(super) fn new(transfer: &Transfer) -> Self {
        let code = |index: u32| {
            let middle = Self::FIRST + (index << Self::DROPPED) + (1 << (Self::DROPPED - 1));
            let light = if index == 0 {
                0.0
            } else {
                f64::from(f32::from_bits(middle))
            };
            (255.0 * transfer.code(light)).round_ties_even() as u8
        };
        // Past 1 all lights are white.
        let last = (f32::to_bits(1.0) - Self::FIRST) >> Self::DROPPED;
        let mut codes = Box::new([u8::MAX; 1 << 16]);
        for (index, place) in (0..=last).zip(codes.iter_mut()) {
            *place = code(index);
        }
        Self(codes)
    }

    /// Returns the code of a light from [`Self::LEAST`] to 1.
    #[inline]
    pub(super) fn of(&self, light: f32) -> u8 {
        let index = light.to_bits().wrapping_sub(Self::FIRST) >> Self::DROPPED;
        self.0[usize::from(index as u16)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_and_lights_invert_each_other_and_tables_are_near() {
        let curve = Transfer::Curve(vec![0.0, 0.02, 0.3, 1.0]);
        for transfer in [Transfer::Srgb, Transfer::Gamma(2.2), curve] {
            let codes = Codes::new(&transfer);
            for code in 0..=255u8 {
                let exact = f64::from(code) / 255.0;
                let light = transfer.light(exact);
                assert!(
                    (transfer.code(light) - exact).abs() < 1e-12,
                    "{transfer:?} {code}"
                );
                assert_eq!(
                    codes.of((light as f32).max(Codes::LEAST)),
                    code,
                    "{transfer:?}"
                );
                // Halfway to the next, either will do.
                let between = transfer.light((f64::from(code) + 0.5) / 255.0) as f32;
                let apart = f64::from(codes.of(between)) - f64::from(code) - 0.5;
                assert!(code == 255 || apart.abs() < 0.57, "{transfer:?} {code}");
            }
        }
    }
}
