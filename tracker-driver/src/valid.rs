//! Whether numbers from a wire can be used.

use crate::decoder::DropReason;
use glam::{Quat, Vec3};
use shisen_core::numeric;

/// How far the norm of a quaternion that a device sends, or of a row of a matrix, may be
/// from 1, and the dot product of two rows from 0.
///
/// The coarsest format, 14 bits, accounts for 0.0003, and a device's own fixed-point
/// arithmetic for some more; what is further off is no rotation but damaged or misread
/// bytes.
pub const NORM_TOLERANCE: f32 = 0.01;

/// How far from 1 the norm may be of what somebody has normalised in `f32`.
pub(crate) const UNIT_TOLERANCE: f32 = 1.0e-3;

/// The farthest position of a head that is believed, in metres along each axis: more
/// than any of the trackers reaches, less than most misread bytes say.
pub const FARTHEST_POSITION: f32 = 100.0;

/// Shorter is no direction: what the device would need is not in its digits.
const SHORTEST: f32 = 1.0e-3;

/// Longer than this, squares leave the range of `f32`, and no device means it.
const LONGEST: f32 = 1.0e9;

/// Returns a finite number, no further from zero than `limit`.
pub(crate) fn within(value: f32, limit: f32) -> Result<f32, DropReason> {
    if value.abs() <= limit {
        Ok(value)
    } else {
        Err(DropReason::OutOfRange)
    }
}

/// Returns a place, each coordinate no further from zero than `limit`.
pub(crate) fn place(value: Vec3, limit: f32) -> Result<Vec3, DropReason> {
    for part in value.to_array() {
        within(part, limit)?;
    }
    Ok(value)
}

/// Returns where a head tracker says that a head is, in metres.
pub(crate) fn position(metres: Vec3) -> Result<Vec3, DropReason> {
    place(metres, FARTHEST_POSITION)
}

/// Returns a vector of any length as a unit vector.
pub(crate) fn direction(value: Vec3) -> Result<Vec3, DropReason> {
    let norm = length(&place(value, LONGEST)?.to_array());
    if norm < SHORTEST {
        return Err(DropReason::NotUnit);
    }
    Ok(value / norm)
}

/// Returns a normalised quaternion whose norm was 1 within `tolerance` and squares are finite.
pub(crate) fn rotation(value: Quat, tolerance: f32) -> Result<Quat, DropReason> {
    for part in value.to_array() {
        within(part, LONGEST)?;
    }
    unit(value, tolerance).map_err(|_| DropReason::NotUnit)
}

/// Returns the quaternion that a head tracker sends, normalised.
pub(crate) fn sent_rotation(value: Quat) -> Result<Quat, DropReason> {
    if !value.is_finite() {
        return Err(DropReason::OutOfRange);
    }
    unit(value, NORM_TOLERANCE).map_err(|_| DropReason::NotUnit)
}

/// Returns a quaternion whose norm is 1 within `tolerance`, normalised.
///
/// # Errors
/// The norm that it has; NaN where a part is NaN.
pub(crate) fn unit(value: Quat, tolerance: f32) -> Result<Quat, f32> {
    let parts = value.to_array();
    let norm = length(&parts);
    // NaN, and what is too long for squares, fail the comparison.
    if !((norm - 1.0).abs() <= tolerance) {
        return Err(norm);
    }
    Ok(Quat::from_array(parts.map(|part| part / norm)))
}

/// Returns the Euclidean norm.
pub(crate) fn length(parts: &[f32]) -> f32 {
    numeric::sqrt(parts.iter().map(|part| part * part).sum())
}
