//! Whether an estimator's configuration can work.

use super::{EstimatorConfig, Filter, GazePrediction, Screen};
use crate::time::Micros;
use crate::valid::UNIT_TOLERANCE;
use glam::Vec3;

/// A configuration that cannot work.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum EstimatorConfigError {
    /// A number outside its range, or NaN.
    #[error("{field} is {found}: give {least} to {most}")]
    OutOfRange {
        /// The name of the value, with its unit.
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
        /// The name of the value.
        field: &'static str,
        /// The time.
        found: Micros,
        /// The least it can be.
        least: Micros,
        /// The most it can be.
        most: Micros,
    },
    /// Two values that ascend, of which the second is below the first.
    #[error("{0} is above {1}: exchange them or change one")]
    Order(&'static str, &'static str),
    /// A place is NaN or infinite.
    #[error("{0} is not finite: give three finite numbers")]
    NotFinite(&'static str),
    /// A direction or a rotation, and its length, which is not 1.
    #[error("{0} has length {1}: give one of length 1")]
    NotUnit(&'static str, f32),
    /// The screen's edges are not at right angles; the cosine of their angle.
    #[error(
        "the screen's edges are not at right angles (the cosine is {0}): measure its corners again"
    )]
    Skewed(f32),
}

/// Checks a table of values, each by its name and its range.
macro_rules! within {
    ($check:ident: $($field:literal: $found:expr, $least:literal to $most:expr;)*) => {
        $($check($field, $found, $least, $most)?;)*
    };
}

impl EstimatorConfig {
    /// Checks all values.
    ///
    /// # Errors
    /// The first that is out of its range.
    pub fn check(&self) -> Result<(), EstimatorConfigError> {
        let (tracker, resting) = (&self.room_from_tracker, &self.resting_head);
        finite("the tracker's position", tracker.position)?;
        finite("the resting head's position", resting.position)?;
        let (turn, resting_turn) = (tracker.orientation.length(), resting.orientation.length());
        unit("the tracker's orientation", turn)?;
        unit("the resting head's orientation", resting_turn)?;
        if let Some(screen) = self.screen {
            screen.check()?;
        }
        self.check_numbers()?;
        self.check_times()
    }

    fn check_numbers(&self) -> Result<(), EstimatorConfigError> {
        use core::f32::consts::{FRAC_PI_2, PI};
        let (saccades, fallback, head) = (&self.saccades, &self.fallback, &self.head);
        within! { number:
            "the largest eccentricity (rad)": self.most_eccentricity, 1.0e-3 to FRAC_PI_2;
            "the least openness": self.least_openness, 0.0 to 1.0;
            "the widening (rad)": fallback.widen_by, 0.0 to PI;
            "a saccade's start speed (rad/s)": saccades.start_speed, 0.05 to 20.0;
            "a saccade's end speed (rad/s)": saccades.end_speed, 0.01 to 20.0;
            "a saccade's least amplitude (rad)": saccades.least_amplitude, 0.0 to 0.2;
            "a saccade's base duration (s)": saccades.base_duration, 0.005 to 0.1;
            "a saccade's duration per amplitude (s/rad)":
                saccades.duration_per_amplitude, 0.0 to 1.0;
            "the head's least turn (rad/s)": head.least_turn, 0.001 to 1.0;
            "the head's least speed (m/s)": head.least_speed, 0.001 to 1.0;
        }
        if let Filter::OneEuro(filter) = self.filter {
            within! { number:
                "the filter's least cutoff (Hz)": filter.least_cutoff, 0.01 to 1e3;
                "the filter's beta (Hz s/rad)": filter.beta, 0.0 to 1e4;
                "the filter's speed cutoff (Hz)": filter.speed_cutoff, 0.01 to 1e3;
            }
        }
        if let Some(GazePrediction { pursuit, .. }) = self.prediction {
            within! { number: "pursuit's least speed (rad/s)": pursuit.least_speed, 0.001 to 1.0; }
        }
        let ends = [
            ("a saccade's end speed", saccades.end_speed),
            ("its start speed", saccades.start_speed),
        ];
        ascend(&ends)
    }

    fn check_times(&self) -> Result<(), EstimatorConfigError> {
        let (saccades, fallback) = (&self.saccades, &self.fallback);
        within! { time:
            "a saccade's window": saccades.window, 1 to 100;
            "a saccade's least duration": saccades.least_duration, 0 to 100;
            "a saccade's longest duration": saccades.most_duration, 20 to 500;
            "the largest gap between samples": saccades.most_gap, 5 to 500;
            "the head's window": self.head.window, 10 to 500;
            "the head's horizon": self.head.horizon, 0 to 200;
            "the longest blink": fallback.longest_blink, 0 to 5_000;
            "the time to hold": fallback.hold_after, 1 to 60_000;
            "the time to full quality": fallback.full_after, 1 to 60_000;
            "the head's time to hold": fallback.head_hold_after, 1 to 60_000;
            "the head's time to full quality": fallback.head_full_after, 1 to 60_000;
        }
        if let Some(stuck_after) = self.stuck_after {
            within! { time: "the time until the gaze is stuck": stuck_after, 50 to 60_000; }
        }
        if let Some(stuck_after) = self.head_stuck_after {
            within! { time: "the time until the head is stuck": stuck_after, 50 to 60_000; }
        }
        if let Some(prediction) = self.prediction {
            within! { time:
                "the gaze's horizon": prediction.horizon, 0 to 200;
                "pursuit's window": prediction.pursuit.window, 20 to 500;
            }
        }
        ascend(&[
            ("a saccade's least duration", saccades.least_duration),
            ("its longest", saccades.most_duration),
        ])?;
        ascend(&[
            ("the time to hold", fallback.hold_after),
            ("the time to widen", fallback.widen_after),
            ("the time to the head's direction", fallback.head_after),
            ("the time to full quality", fallback.full_after),
        ])?;
        ascend(&[
            ("the head's time to hold", fallback.head_hold_after),
            ("the head's time to widen", fallback.head_widen_after),
            ("its time to full quality", fallback.head_full_after),
        ])
    }
}

impl Screen {
    fn check(&self) -> Result<(), EstimatorConfigError> {
        finite("the screen's corner", self.corner)?;
        unit("the screen's right", self.right.length())?;
        unit("the screen's down", self.down.length())?;
        within! { number:
            "the screen's width (m)": self.size.x, 1.0e-3 to 1.0e3;
            "the screen's height (m)": self.size.y, 1.0e-3 to 1.0e3;
        }
        let cosine = self.right.dot(self.down);
        if !(cosine.abs() <= 0.01) {
            return Err(EstimatorConfigError::Skewed(cosine));
        }
        Ok(())
    }
}

fn finite(field: &'static str, place: Vec3) -> Result<(), EstimatorConfigError> {
    if place.is_finite() {
        Ok(())
    } else {
        Err(EstimatorConfigError::NotFinite(field))
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

/// Checks a time against limits in milliseconds.
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

/// Refuses values that do not ascend.
fn ascend<T: PartialOrd + Copy>(values: &[(&'static str, T)]) -> Result<(), EstimatorConfigError> {
    for pair in values.windows(2) {
        if let [(first, lower), (second, higher)] = *pair
            && !(lower <= higher)
        {
            return Err(EstimatorConfigError::Order(first, second));
        }
    }
    Ok(())
}

fn unit(field: &'static str, length: f32) -> Result<(), EstimatorConfigError> {
    if (length - 1.0).abs() <= UNIT_TOLERANCE {
        Ok(())
    } else {
        Err(EstimatorConfigError::NotUnit(field, length))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::OneEuroConfig;
    use glam::{Quat, Vec2};
    use std::format;

    type Change = fn(&mut EstimatorConfig);

    fn checked(change: impl FnOnce(&mut EstimatorConfig)) -> Result<(), EstimatorConfigError> {
        let mut config = EstimatorConfig::default();
        change(&mut config);
        config.check()
    }

    #[test]
    fn the_default_is_allowed_and_slips_are_told() {
        assert_eq!(checked(|_| {}), Ok(()));
        let cases: [(Change, &str); 7] = [
            (
                |c| c.most_eccentricity = 2.0,
                "the largest eccentricity (rad) is 2: give 0.001 to 1.5707964",
            ),
            (
                |c| c.fallback.widen_after = Micros(1),
                "the time to hold is above the time to widen: exchange them or change one",
            ),
            (
                |c| c.head.horizon = Micros(300_000),
                "the head's horizon is 300000 µs: give 0 to 200000 µs",
            ),
            (
                |c| c.resting_head.orientation = Quat::from_xyzw(0.0, 0.0, 0.0, 2.0),
                "the resting head's orientation has length 2: give one of length 1",
            ),
            (
                |c| c.room_from_tracker.position.x = f32::NAN,
                "the tracker's position is not finite: give three finite numbers",
            ),
            (
                |c| {
                    c.filter = Filter::OneEuro(OneEuroConfig {
                        beta: f32::NAN,
                        ..OneEuroConfig::default()
                    });
                },
                "the filter's beta (Hz s/rad) is NaN: give 0 to 10000",
            ),
            (
                |c| {
                    c.screen = Some(Screen {
                        corner: Vec3::ZERO,
                        right: Vec3::X,
                        down: Vec3::X,
                        size: Vec2::ONE,
                    });
                },
                "the screen's edges are not at right angles (the cosine is 1): measure its \
                 corners again",
            ),
        ];
        for (change, text) in cases {
            assert_eq!(format!("{}", checked(change).unwrap_err()), text);
        }
    }
}
