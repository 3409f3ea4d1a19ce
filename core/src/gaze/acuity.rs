use crate::numeric::{max, min};
use core::f32::consts::PI;

/// How small a thing a viewer can make out: the minimum angle of resolution MAR(e) = m·e + w₀ at an
/// eccentricity e (Guenter, Finch, Drucker, Tan & Snyder, "Foveated 3D Graphics", 2012, equation 1;
/// Weymouth, "Visual Sensory Units and the Minimal Angle of Resolution", 1958).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Acuity {
    slope: f32,
    fovea: f32,
    /// How far from what is taken for it the line of sight may be: radians.
    off: f32,
    /// Radians more a radian than `slope`, beyond `inner`.
    extra: f32,
    /// An eccentricity, radians.
    inner: f32,
}

/// Why two numbers make no acuity.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
#[allow(missing_docs, reason = "the messages say what the fields are")]
pub enum AcuityError {
    /// A slope that is not from 0 to [`Acuity::STEEPEST`].
    #[error(
        "acuity cannot fall by {slope} radians a radian: give 0 to {}",
        Acuity::STEEPEST
    )]
    Slope { slope: f32 },
    /// A least angle that is not from [`Acuity::FINEST`] to [`Acuity::COARSEST`].
    #[error(
        "the least angle that is seen cannot be {fovea} rad: give {} to {} rad",
        Acuity::FINEST,
        Acuity::COARSEST
    )]
    Fovea { fovea: f32 },
}

impl Acuity {
    /// Largest slope: radians a radian.
    pub const STEEPEST: f32 = 1.0;

    /// Least of the least angles: radians.
    pub const FINEST: f32 = 1.0e-6;

    /// Largest of the least angles: radians.
    pub const COARSEST: f32 = 1.0;

    /// Guenter et al.'s: 1.65 arc minutes a degree, the larger of their slopes (1.32 is the
    /// smaller), and 1/48° in the fovea.
    pub const GUENTER: Self = Self {
        slope: 0.0275,
        fovea: 3.636_102_6e-4,
        off: 0.0,
        extra: 0.0,
        inner: 0.0,
    };

    /// Returns the acuity by which detail of a quality is chosen, 1 (coarse) to 5 (fine); 3 is
    /// [`GUENTER`](Self::GUENTER). `None` for others.
    pub fn of_quality(quality: u8) -> Option<Self> {
        let factor = match quality {
            1 => 2.5,
            2 => 1.6,
            3 => 1.0,
            4 => 0.7,
            5 => 0.45,
            _ => return None,
        };
        let slope = Self::GUENTER.slope * factor;
        Some(Self {
            slope,
            ..Self::GUENTER
        })
    }

    /// Returns an acuity of slope m (radians a radian, 0 to [`Self::STEEPEST`]) and an angle w₀ on
    /// the line of sight (radians, [`Self::FINEST`] to [`Self::COARSEST`]).
    ///
    /// # Errors
    /// Numbers that are out of these ranges, or none.
    pub fn new(slope: f32, fovea: f32) -> Result<Self, AcuityError> {
        if !(0.0..=Self::STEEPEST).contains(&slope) {
            return Err(AcuityError::Slope { slope });
        }
        if !(Self::FINEST..=Self::COARSEST).contains(&fovea) {
            return Err(AcuityError::Fovea { fovea });
        }
        Ok(Self {
            slope,
            fovea,
            off: 0.0,
            extra: 0.0,
            inner: 0.0,
        })
    }

    /// Returns the same acuity with a slope `factor` times as steep, at most the steepest: a
    /// coarser periphery. Factors below 1, and NaN, leave it unchanged.
    #[must_use]
    pub fn steeper(self, factor: f32) -> Self {
        // 0 · ∞ would be no number.
        let factor = min(max(factor, 1.0), f32::MAX);
        Self {
            slope: min(self.slope * factor, Self::STEEPEST),
            ..self
        }
    }

    /// Returns the same acuity with a slope `factor` times as steep, at most the steepest, from an
    /// eccentricity on (radians, 0 to π): as fine as before up to there. Factors below
    /// 1, and NaN, leave it unchanged; other eccentricities are moved to the nearest.
    #[must_use]
    pub fn steeper_beyond(self, factor: f32, eccentricity: f32) -> Self {
        let extra = self.steeper(factor).slope - self.slope;
        if extra == 0.0 {
            return self;
        }
        Self {
            extra,
            inner: min(max(eccentricity, 0.0), PI),
            ..self
        }
    }

    /// Returns the same for a line of sight that is known to within some radians: as fine
    /// so much farther out. Numbers below 0, and NaN, leave it unchanged.
    #[must_use]
    pub const fn around(self, off: f32) -> Self {
        Self {
            off: min(max(off, 0.0), PI),
            ..self
        }
    }

    /// m: radians a radian, next to the line of sight.
    pub const fn slope(self) -> f32 {
        self.slope
    }

    /// w₀: radians.
    pub const fn fovea(self) -> f32 {
        self.fovea
    }

    /// How far the line of sight may be from what is taken for it: radians.
    pub const fn off(self) -> f32 {
        self.off
    }

    /// MAR(e), radians, of an eccentricity in radians, 0 to π; below 0 and for NaN
    /// as for 0, above π as for π.
    pub fn least_angle(self, eccentricity: f32) -> f32 {
        let eccentricity = min(max(eccentricity - self.off, 0.0), PI);
        let beyond = max(eccentricity - self.inner, 0.0);
        self.slope * eccentricity + self.fovea + self.extra * beyond
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hostile::{finite, finite_or_error, with_hostile_numbers};

    #[test]
    fn what_is_no_acuity_is_refused() {
        for slope in [-0.1, 1.1, f32::NAN, f32::INFINITY] {
            let error = Acuity::new(slope, 0.001).unwrap_err();
            assert!(matches!(error, AcuityError::Slope { .. }));
        }
        for fovea in [0.0, -1.0, 2.0, f32::NAN, f32::INFINITY] {
            let error = Acuity::new(0.02, fovea).unwrap_err();
            assert!(matches!(error, AcuityError::Fovea { .. }));
        }
        let guenter = Acuity::GUENTER;
        assert_eq!(Acuity::new(guenter.slope(), guenter.fovea()), Ok(guenter));
        assert_eq!(guenter.slope(), 1.65 / 60.0);
        assert_eq!(guenter.fovea(), (1.0f64 / 48.0).to_radians() as f32);
    }

    #[test]
    fn acuities_of_any_numbers_grow_outwards() {
        with_hostile_numbers(|n| {
            let factor = n.next(2.0);
            let steeper = Acuity::GUENTER.steeper(factor);
            assert!((Acuity::GUENTER.slope()..=Acuity::STEEPEST).contains(&steeper.slope()));
            let beyond = Acuity::GUENTER.steeper_beyond(factor, n.next(0.1));
            assert_eq!(beyond.least_angle(0.0), Acuity::GUENTER.fovea());
            assert!(beyond.least_angle(3.0) >= Acuity::GUENTER.least_angle(3.0));
            finite(&(steeper, beyond, beyond.least_angle(3.0)));
            let acuity = finite_or_error(Acuity::new(n.next(0.02), n.next(0.001)));
            if let Some(acuity) = acuity {
                let least = acuity.around(n.next(0.1)).least_angle(n.next(0.5));
                assert!(least >= acuity.fovea() && least <= acuity.least_angle(4.0));
            }
        });
    }
}
