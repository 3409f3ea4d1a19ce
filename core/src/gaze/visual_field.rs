use crate::numeric::{max, min};
use core::f32::consts::{FRAC_PI_2, FRAC_PI_3, FRAC_PI_6, PI};

/// Radians.
const LEAST_CENTRAL: f32 = 1.0e-6;

/// Radians; below the least of the limits' own most, π/2.
const MOST_WIDENED_CENTRAL: f32 = 1.5;

/// How far the visual field reaches from the line of sight, radians.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VisualFieldLimits {
    /// Radius of the central field, 1e-6 or more: the angle that levels are
    /// exact to.
    pub central: f32,
    /// Upwards, above `central`, at most π/2.
    pub up: f32,
    /// Downwards, above `central`, at most π/2.
    pub down: f32,
    /// To the left, above `central`, at most π.
    pub left: f32,
    /// To the right, above `central`, at most π.
    pub right: f32,
}

/// Which curve joins the limits.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Boundary {
    /// Equation 7 as printed: an ellipse's pedal curve (a hippopede), outside the ellipse between
    /// the axes by up to 9.9° in the paper's upper half and 5.3° in the lower.
    #[default]
    Printed,
    /// The ellipse through the limits, which equation 7 seems to mean.
    Ellipse,
}

/// Where the viewer sees how well: equations 7 and 8.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VisualField {
    limits: VisualFieldLimits,
    boundary: Boundary,
}

/// Why limits make no visual field. Angles are radians.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
#[allow(missing_docs, reason = "the messages say what the fields are")]
pub enum VisualFieldError {
    /// A limit is NaN or infinite.
    #[error("a limit of the visual field is not finite")]
    NotFinite,
    /// The central field is smaller than levels are exact.
    #[error("the central field has a radius of {central} rad: give 1e-6 or more")]
    Central { central: f32 },
    /// A limit within the central field.
    #[error(
        "the visual field ends {limit} rad {side}, within the central field of {central} rad: give a \
         larger limit or a smaller central field"
    )]
    BelowCentral {
        side: &'static str,
        limit: f32,
        central: f32,
    },
    /// A limit farther than a direction can be.
    #[error("the visual field ends {limit} rad {side}: give at most {most} rad")]
    TooFar {
        side: &'static str,
        limit: f32,
        most: f32,
    },
}

impl VisualField {
    /// The paper's: central to 30°, 60° up, 70° down, 100° to each side, joined
    /// as printed. (The limit of 60° towards the nose is not used: equation 4
    /// has no sign.)
    pub const PAPER: Self = Self {
        limits: VisualFieldLimits {
            central: FRAC_PI_6,
            up: FRAC_PI_3,
            down: 1.221_730_5,
            left: 1.745_329_3,
            right: 1.745_329_3,
        },
        boundary: Boundary::Printed,
    };

    /// Returns a field of its own limits.
    ///
    /// # Errors
    /// Limits that are not finite or outside the ranges at
    /// [`VisualFieldLimits`].
    pub fn new(limits: VisualFieldLimits, boundary: Boundary) -> Result<Self, VisualFieldError> {
        let central = limits.central;
        let sides = [
            ("up", limits.up, FRAC_PI_2),
            ("down", limits.down, FRAC_PI_2),
            ("left", limits.left, PI),
            ("right", limits.right, PI),
        ];
        if !central.is_finite() || sides.iter().any(|(_, limit, _)| !limit.is_finite()) {
            return Err(VisualFieldError::NotFinite);
        }
        if central < LEAST_CENTRAL {
            return Err(VisualFieldError::Central { central });
        }
        for (side, limit, most) in sides {
            if limit <= central {
                return Err(VisualFieldError::BelowCentral {
                    side,
                    limit,
                    central,
                });
            }
            if limit > most {
                return Err(VisualFieldError::TooFar { side, limit, most });
            }
        }
        Ok(Self { limits, boundary })
    }

    /// Returns the same field, wider all round by some radians, for a gaze that is known to within
    /// so much. `None` where that is everything, from π on, and where it is NaN.
    pub fn wider(self, by: f32) -> Option<Self> {
        if !(by < PI) {
            return None;
        }
        let by = max(by, 0.0);
        let own = self.limits;
        let limits = VisualFieldLimits {
            // Levels fall from here to the limits, which have to be farther.
            central: min(own.central + by, max(own.central, MOST_WIDENED_CENTRAL)),
            up: min(own.up + by, FRAC_PI_2),
            down: min(own.down + by, FRAC_PI_2),
            left: min(own.left + by, PI),
            right: min(own.right + by, PI),
        };
        // Limits that rounding makes equal are left as they were.
        Some(Self::new(limits, self.boundary).unwrap_or(self))
    }

    /// Returns the same limits joined by another curve.
    #[must_use]
    pub const fn with_boundary(self, boundary: Boundary) -> Self {
        Self { boundary, ..self }
    }

    /// Returns how far it reaches.
    pub const fn limits(&self) -> VisualFieldLimits {
        self.limits
    }

    /// Returns which curve joins the limits.
    pub const fn boundary(&self) -> Boundary {
        self.boundary
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::string::ToString;

    #[test]
    fn the_papers_limits_are_its_degrees_and_allowed() {
        let limits = VisualField::PAPER.limits();
        for (limit, degrees) in [
            (limits.central, 30f64),
            (limits.up, 60.0),
            (limits.down, 70.0),
            (limits.left, 100.0),
            (limits.right, 100.0),
        ] {
            assert_eq!(limit, degrees.to_radians() as f32);
        }
        let new = |boundary| VisualField::new(limits, boundary);
        assert_eq!(new(Boundary::Printed), Ok(VisualField::PAPER));
        let ellipse = VisualField::PAPER.with_boundary(Boundary::Ellipse);
        assert_eq!(new(Boundary::Ellipse), Ok(ellipse));
    }

    #[test]
    fn a_wider_field_ends_where_directions_do() {
        let paper = VisualField::PAPER;
        assert_eq!(paper.wider(0.0), Some(paper));
        assert_eq!(paper.wider(-1.0), Some(paper));
        for none in [PI, f32::INFINITY, f32::NAN] {
            assert_eq!(paper.wider(none), None);
        }
        let limits = paper.wider(0.25).unwrap().limits();
        assert_eq!(limits.central, FRAC_PI_6 + 0.25);
        assert_eq!(limits.left, paper.limits().left + 0.25);
        let limits = paper.wider(3.0).unwrap().limits();
        assert_eq!((limits.central, limits.up), (1.5, FRAC_PI_2));
        assert_eq!((limits.left, limits.right), (PI, PI));
    }

    #[test]
    fn limits_out_of_range_are_refused() {
        let new = |[central, up, down, left, right]: [f32; 5]| {
            let limits = VisualFieldLimits {
                central,
                up,
                down,
                left,
                right,
            };
            VisualField::new(limits, Boundary::Printed).map(drop)
        };
        for (limits, words) in [
            ([9.9e-7, 1.0, 1.0, 1.0, 1.0], "give 1e-6 or more"),
            ([f32::INFINITY, 1.0, 1.0, 1.0, 1.0], "not finite"),
            ([0.5, 1.0, 1.0, f32::NAN, 1.0], "not finite"),
            ([0.5, 1.0, 0.5, 1.0, 1.0], "ends 0.5 rad down, within"),
            (
                [0.5, 1.0, 1.0, 1.0, 3.15],
                "3.15 rad right: give at most 3.14",
            ),
        ] {
            let error = new(limits).unwrap_err().to_string();
            assert!(error.contains(words), "{error}");
        }
        assert_eq!(new([LEAST_CENTRAL, FRAC_PI_2, FRAC_PI_2, PI, PI]), Ok(()));
    }
}
