//! Whether numbers from a wire can be used.

use crate::decoder::DropReason;
use glam::{Quat, Vec3};
use shisen_core::numeric;

/// Shorter is no direction: what the device would need is not in its digits.
const SHORTEST: f32 = 1.0e-3;

/// Longer than this, squares leave the range of `f32`, and no device means
/// it.
const LONGEST: f32 = 1.0e9;

/// A finite number, no further from zero than `limit`.
pub(crate) fn within(value: f32, limit: f32) -> Result<f32, DropReason> {
    if value.abs() <= limit {
        Ok(value)
    } else {
        Err(DropReason::OutOfRange)
    }
}

/// A place, each coordinate no further from zero than `limit`.
pub(crate) fn place(value: Vec3, limit: f32) -> Result<Vec3, DropReason> {
    for part in value.to_array() {
        within(part, limit)?;
    }
    Ok(value)
}

/// A vector of any length as a unit vector.
pub(crate) fn direction(value: Vec3) -> Result<Vec3, DropReason> {
    let norm = length(&place(value, LONGEST)?.to_array());
    if norm < SHORTEST {
        return Err(DropReason::NotUnit);
    }
    Ok(value / norm)
}

/// A quaternion whose norm is 1 within `tolerance`, normalised.
pub(crate) fn rotation(value: Quat, tolerance: f32) -> Result<Quat, DropReason> {
    let parts = value.to_array();
    for part in parts {
        within(part, LONGEST)?;
    }
    let norm = length(&parts);
    if (norm - 1.0).abs() > tolerance {
        return Err(DropReason::NotUnit);
    }
    Ok(Quat::from_array(parts.map(|part| part / norm)))
}

/// The Euclidean norm.
pub(crate) fn length(parts: &[f32]) -> f32 {
    numeric::sqrt(parts.iter().map(|part| part * part).sum())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_that_cannot_be_used_are_refused() {
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1.5] {
            assert_eq!(within(bad, 1.0), Err(DropReason::OutOfRange));
            let place = place(Vec3::new(0.0, 0.0, bad), 1.0);
            assert_eq!(place, Err(DropReason::OutOfRange));
        }
        for bad in [f32::NAN, f32::INFINITY, 1.0e30] {
            let vector = Vec3::new(0.0, bad, 1.0);
            assert_eq!(direction(vector), Err(DropReason::OutOfRange));
            let quat = Quat::from_xyzw(0.0, 0.0, bad, 1.0);
            assert_eq!(rotation(quat, 0.1), Err(DropReason::OutOfRange));
        }
        assert_eq!(direction(Vec3::ZERO), Err(DropReason::NotUnit));
        let none = Quat::from_xyzw(0.0, 0.0, 0.0, 0.0);
        assert_eq!(rotation(none, 0.1), Err(DropReason::NotUnit));
    }

    #[test]
    fn the_rest_is_normalised() {
        assert_eq!(within(-1.0, 1.0), Ok(-1.0));
        let unit = direction(Vec3::new(0.0, 0.0, -0.25));
        assert_eq!(unit, Ok(Vec3::NEG_Z));
        let turn = rotation(Quat::from_xyzw(0.0, 1.05, 0.0, 0.0), 0.1);
        assert_eq!(turn, Ok(Quat::from_xyzw(0.0, 1.0, 0.0, 0.0)));
    }
}
