//! Whether an estimator's configuration can work.

use super::{EstimatorConfig, Filter, Screen};
use crate::time::Micros;
use crate::valid::UNIT_TOLERANCE;

/// A configuration that cannot work.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum EstimatorConfigError {
    /// A number outside its range, or NaN.
    #[error("{field} is {found}: give {least} to {most}")]
    OutOfRange {
        /// Which, and its unit.
        field: &'static str,
        /// The number.
        found: f32,
        /// The least it can be.
        least: f32,
        /// The most it can be.
        most: f32,
    },
    /// A time outside its range.
    #[error("{field} is {} µs: give {} to {} µs", .found.0, .least.0, .most.0)]
    Time {
        /// Which.
        field: &'static str,
        /// The time.
        found: Micros,
        /// The least it can be.
        least: Micros,
        /// The most it can be.
        most: Micros,
    },
    /// Two values that ascend, of which the second is below the first.
    #[error("{first} is above {second}: exchange them or change one")]
    Order {
        /// The one that is to be lower.
        first: &'static str,
        /// The one that is to be higher.
        second: &'static str,
    },
    /// A place is NaN or infinite.
    #[error("{field} is not finite: give three finite numbers")]
    NotFinite {
        /// Which.
        field: &'static str,
    },
    /// A direction or a rotation does not have length 1.
    #[error("{field} has length {length}: give one of length 1")]
    NotUnit {
        /// Which.
        field: &'static str,
        /// Its length.
        length: f32,
    },
    /// The screen's edges are not at right angles.
    #[error(
        "the screen's edges are not at right angles (the cosine is {cosine}): measure its corners \
         again"
    )]
    Skewed {
        /// The cosine of their angle.
        cosine: f32,
    },
}

impl EstimatorConfig {
    /// Checks all values.
    ///
    /// # Errors
    /// The first that is out of its range.
    pub fn check(&self) -> Result<(), EstimatorConfigError> {
        let (tracker, resting) = (&self.room_from_tracker, &self.resting_head);
        for (field, place) in [
            ("the tracker's position", tracker.position),
            ("the resting head's position", resting.position),
        ] {
            if !place.is_finite() {
                return Err(EstimatorConfigError::NotFinite { field });
            }
        }
        let turn = tracker.orientation.length();
        unit("the tracker's orientation", turn)?;
        unit(
            "the resting head's orientation",
            resting.orientation.length(),
        )?;
        if let Some(screen) = self.screen {
            screen.check()?;
        }
        self.check_numbers()?;
        self.check_times()
    }

    fn check_numbers(&self) -> Result<(), EstimatorConfigError> {
        use core::f32::consts::{FRAC_PI_2, PI};
        let saccades = &self.saccades;
        let numbers = [
            (
                "the largest eccentricity (rad)",
                self.most_eccentricity,
                1.0e-3,
                FRAC_PI_2,
            ),
            ("the least openness", self.least_openness, 0.0, 1.0),
            ("the widening (rad)", self.fallback.widen_by, 0.0, PI),
            (
                "a saccade's start speed (rad/s)",
                saccades.start_speed,
                0.05,
                20.0,
            ),
            (
                "a saccade's end speed (rad/s)",
                saccades.end_speed,
                0.01,
                20.0,
            ),
            (
                "a saccade's least amplitude (rad)",
                saccades.least_amplitude,
                0.0,
                0.2,
            ),
            (
                "a saccade's base duration (s)",
                saccades.base_duration,
                0.005,
                0.1,
            ),
            (
                "a saccade's duration per amplitude (s/rad)",
                saccades.duration_per_amplitude,
                0.0,
                1.0,
            ),
            (
                "the head's least turn (rad/s)",
                self.head.least_turn,
                0.001,
                1.0,
            ),
            (
                "the head's least speed (m/s)",
                self.head.least_speed,
                0.001,
                1.0,
            ),
        ];
        for (field, found, least, most) in numbers {
            number(field, found, least, most)?;
        }
        if let Filter::OneEuro(filter) = self.filter {
            let (cutoff, speed_cutoff) = (filter.least_cutoff, filter.speed_cutoff);
            number("the filter's least cutoff (Hz)", cutoff, 0.01, 1e3)?;
            number("the filter's beta (Hz s/rad)", filter.beta, 0.0, 1e4)?;
            number("the filter's speed cutoff (Hz)", speed_cutoff, 0.01, 1e3)?;
        }
        if let Some(prediction) = self.prediction {
            let least_speed = prediction.pursuit.least_speed;
            number("pursuit's least speed (rad/s)", least_speed, 0.001, 1.0)?;
        }
        ascend(
            "a saccade's end speed",
            saccades.end_speed,
            "its start speed",
            saccades.start_speed,
        )
    }

    fn check_times(&self) -> Result<(), EstimatorConfigError> {
        let (saccades, fallback) = (&self.saccades, &self.fallback);
        for (field, found, least, most) in [
            ("a saccade's window", saccades.window, 1, 100),
            (
                "a saccade's least duration",
                saccades.least_duration,
                0,
                100,
            ),
            (
                "a saccade's longest duration",
                saccades.most_duration,
                20,
                500,
            ),
            ("the largest gap between samples", saccades.most_gap, 5, 500),
            ("the head's window", self.head.window, 10, 500),
            ("the head's horizon", self.head.horizon, 0, 200),
            ("the longest blink", fallback.longest_blink, 0, 5_000),
            ("the time to hold", fallback.hold_after, 1, 60_000),
            ("the time to full quality", fallback.full_after, 1, 60_000),
            (
                "the head's time to hold",
                fallback.head_hold_after,
                1,
                60_000,
            ),
            (
                "the head's time to full quality",
                fallback.head_full_after,
                1,
                60_000,
            ),
        ] {
            time(field, found, least, most)?;
        }
        for (field, stuck_after) in [
            ("the time until the gaze is stuck", self.stuck_after),
            ("the time until the head is stuck", self.head_stuck_after),
        ] {
            if let Some(stuck_after) = stuck_after {
                time(field, stuck_after, 50, 60_000)?;
            }
        }
        if let Some(prediction) = self.prediction {
            time("the gaze's horizon", prediction.horizon, 0, 200)?;
            time("pursuit's window", prediction.pursuit.window, 20, 500)?;
        }
        for chain in [
            &[
                ("a saccade's least duration", saccades.least_duration),
                ("its longest", saccades.most_duration),
            ][..],
            &[
                ("the time to hold", fallback.hold_after),
                ("the time to widen", fallback.widen_after),
                ("the time to the head's direction", fallback.head_after),
                ("the time to full quality", fallback.full_after),
            ],
            &[
                ("the head's time to hold", fallback.head_hold_after),
                ("the head's time to widen", fallback.head_widen_after),
                ("its time to full quality", fallback.head_full_after),
            ],
        ] {
            for pair in chain.windows(2) {
                let [(first, lower), (second, higher)] = *pair else {
                    continue;
                };
                ascend(first, lower, second, higher)?;
            }
        }
        Ok(())
    }
}

impl Screen {
    fn check(&self) -> Result<(), EstimatorConfigError> {
        if !self.corner.is_finite() {
            let field = "the screen's corner";
            return Err(EstimatorConfigError::NotFinite { field });
        }
        unit("the screen's right", self.right.length())?;
        unit("the screen's down", self.down.length())?;
        number("the screen's width (m)", self.size.x, 1.0e-3, 1.0e3)?;
        number("the screen's height (m)", self.size.y, 1.0e-3, 1.0e3)?;
        let cosine = self.right.dot(self.down);
        if !(cosine.abs() <= 0.01) {
            return Err(EstimatorConfigError::Skewed { cosine });
        }
        Ok(())
    }
}

fn number(
    field: &'static str,
    found: f32,
    least: f32,
    most: f32,
) -> Result<(), EstimatorConfigError> {
    if (least..=most).contains(&found) {
        return Ok(());
    }
    Err(EstimatorConfigError::OutOfRange {
        field,
        found,
        least,
        most,
    })
}

/// The limits are milliseconds.
fn time(
    field: &'static str,
    found: Micros,
    least: u64,
    most: u64,
) -> Result<(), EstimatorConfigError> {
    let (least, most) = (Micros::from_millis(least), Micros::from_millis(most));
    if (least..=most).contains(&found) {
        return Ok(());
    }
    Err(EstimatorConfigError::Time {
        field,
        found,
        least,
        most,
    })
}

fn ascend<T: PartialOrd + Copy>(
    first: &'static str,
    lower: T,
    second: &'static str,
    higher: T,
) -> Result<(), EstimatorConfigError> {
    if lower <= higher {
        Ok(())
    } else {
        Err(EstimatorConfigError::Order { first, second })
    }
}

fn unit(field: &'static str, length: f32) -> Result<(), EstimatorConfigError> {
    if (length - 1.0).abs() <= UNIT_TOLERANCE {
        Ok(())
    } else {
        Err(EstimatorConfigError::NotUnit { field, length })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::OneEuroConfig;
    use glam::{Quat, Vec2, Vec3};
    use std::format;

    fn checked(change: impl FnOnce(&mut EstimatorConfig)) -> Result<(), EstimatorConfigError> {
        let mut config = EstimatorConfig::default();
        change(&mut config);
        config.check()
    }

    #[test]
    fn the_default_is_allowed_and_slips_are_told() {
        assert_eq!(checked(|_| {}), Ok(()));
        let error = checked(|c| c.most_eccentricity = 2.0).unwrap_err();
        assert_eq!(
            format!("{error}"),
            "the largest eccentricity (rad) is 2: give 0.001 to 1.5707964"
        );
        let error = checked(|c| c.fallback.widen_after = Micros(1)).unwrap_err();
        assert_eq!(
            format!("{error}"),
            "the time to hold is above the time to widen: exchange them or change one"
        );
        let error = checked(|c| c.head.horizon = Micros(300_000)).unwrap_err();
        assert_eq!(
            format!("{error}"),
            "the head's horizon is 300000 µs: give 0 to 200000 µs"
        );
        let error = checked(|c| c.resting_head.orientation = Quat::from_xyzw(0.0, 0.0, 0.0, 2.0));
        assert!(
            matches!(error, Err(EstimatorConfigError::NotUnit { length, .. }) if length == 2.0)
        );
        let error = checked(|c| c.room_from_tracker.position.x = f32::NAN);
        assert!(matches!(error, Err(EstimatorConfigError::NotFinite { .. })));
        let error = checked(|c| {
            c.filter = Filter::OneEuro(OneEuroConfig {
                beta: f32::NAN,
                ..OneEuroConfig::default()
            });
        });
        assert!(matches!(
            error,
            Err(EstimatorConfigError::OutOfRange { .. })
        ));
        let skewed = Screen {
            corner: Vec3::ZERO,
            right: Vec3::X,
            down: Vec3::X,
            size: Vec2::ONE,
        };
        let error = checked(|c| c.screen = Some(skewed));
        assert_eq!(error, Err(EstimatorConfigError::Skewed { cosine: 1.0 }));
    }
}
