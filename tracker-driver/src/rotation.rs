//! Rotations and arcs in plain scalar arithmetic: the same bits on every
//! machine, where glam's quaternions use whatever vector unit there is.

use glam::{Quat, Vec3};
use shisen_core::numeric::{normalize, sin_cos, sqrt};

/// `a_from_b · b_from_c`.
pub(crate) fn compose(a: Quat, b: Quat) -> Quat {
    Quat::from_xyzw(
        a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y,
        a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x,
        a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w,
        a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z,
    )
}

/// Returns the inverse of a unit quaternion.
pub(crate) fn inverse(q: Quat) -> Quat {
    Quat::from_xyzw(-q.x, -q.y, -q.z, q.w)
}

/// Returns a vector turned by a unit quaternion.
pub(crate) fn rotate(q: Quat, v: Vec3) -> Vec3 {
    let axis = Vec3::new(q.x, q.y, q.z);
    let twice = axis.cross(v) * 2.0;
    v + twice * q.w + axis.cross(twice)
}

/// Returns the quaternion at unit length; `None` for one of no length or of far too much.
pub(crate) fn unit(q: Quat) -> Option<Quat> {
    let norm = sqrt(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w);
    // NaN fails the comparison too.
    (norm > 1.0e-6 && norm < 1.0e6)
        .then(|| Quat::from_xyzw(q.x / norm, q.y / norm, q.z / norm, q.w / norm))
}

/// By a rotation vector: its length is the angle, radians, at most 2π.
pub(crate) fn from_vector(vector: Vec3) -> Quat {
    let angle = sqrt(vector.dot(vector));
    if !(angle > 1.0e-12) {
        return Quat::IDENTITY;
    }
    let (sin, cos) = sin_cos(angle.min(core::f32::consts::TAU) * 0.5);
    let axis = vector * (sin / angle);
    Quat::from_xyzw(axis.x, axis.y, axis.z, cos)
}

/// Returns the rotation vector of a unit quaternion, of at most half a turn.
pub(crate) fn to_vector(q: Quat) -> Vec3 {
    let (axis, w) = (Vec3::new(q.x, q.y, q.z), q.w);
    let sin = sqrt(axis.dot(axis));
    if !(sin > 1.0e-12) {
        return axis * 2.0;
    }
    let sign = if w < 0.0 { -1.0 } else { 1.0 };
    axis * (2.0 * sign * libm::atan2f(sin, w.abs()) / sin)
}

/// Returns the angle between two unit vectors, radians.
pub(crate) fn angle(a: Vec3, b: Vec3) -> f32 {
    let cross = a.cross(b);
    libm::atan2f(sqrt(cross.dot(cross)), a.dot(b))
}

/// Returns the way along the great circle: a tangent at `from` whose length is the angle.
pub(crate) fn arc(from: Vec3, to: Vec3) -> Vec3 {
    let aside = to - from * from.dot(to);
    let sin = sqrt(aside.dot(aside));
    if !(sin > 1.0e-12) {
        return Vec3::ZERO;
    }
    aside * (libm::atan2f(sin, from.dot(to)) / sin)
}

/// From a unit vector along a tangent at it: the inverse of [`arc`].
pub(crate) fn along(from: Vec3, tangent: Vec3) -> Vec3 {
    let angle = sqrt(tangent.dot(tangent));
    if !(angle > 1.0e-12) {
        return from;
    }
    let (sin, cos) = sin_cos(angle.min(core::f32::consts::PI));
    normalize(from * cos + tangent * (sin / angle)).unwrap_or(from)
}

/// Returns the component of `v` at right angles to the unit vector `axis`.
pub(crate) fn across(v: Vec3, axis: Vec3) -> Vec3 {
    v - axis * v.dot(axis)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn rotations_are_glams(
            x in -1f32..1.0, y in -1f32..1.0, z in -1f32..1.0,
            a in -1f32..1.0, b in -1f32..1.0, c in -1f32..1.0,
        ) {
            let (p, q) = (Vec3::new(x, y, z), Vec3::new(a, b, c));
            let (turn, other) = (from_vector(p), from_vector(q));
            let glams = Quat::from_scaled_axis(p);
            prop_assert!((rotate(turn, q) - glams * q).length() < 1e-6);
            let composed = rotate(compose(turn, other), Vec3::X);
            prop_assert!((composed - rotate(turn, rotate(other, Vec3::X))).length() < 1e-6);
            prop_assert!((rotate(inverse(turn), rotate(turn, q)) - q).length() < 1e-6);
            prop_assert!((to_vector(turn) - p).length() < 2e-6);
        }
    }
}
