//! From a device's axes to those of [`Head`](crate::sample::Head), and the
//! forms in which devices write a rotation down.

pub use crate::valid::{FARTHEST_POSITION, NORM_TOLERANCE};

use crate::decoder::DropReason;
use crate::rotation::{compose, inverse};
use crate::valid;
use glam::{Mat3, Quat, Vec3};
use shisen_core::numeric::{sin_cos, sqrt};

/// A device's axes beside those of [`Head`](crate::sample::Head).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Axes {
    tracker_from_device: Quat,
    head_from_sensor: Quat,
}

/// A quaternion that is no rotation.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[error(
    "a quaternion of norm {norm} for a tracker's axes: give a rotation, whose norm is 1 ± \
     {NORM_TOLERANCE}"
)]
pub struct AxesError {
    /// Its norm; NaN where a part is NaN.
    pub norm: f32,
}

impl Axes {
    /// The device's axes are ours.
    pub const SAME: Self = Self {
        tracker_from_device: Quat::IDENTITY,
        head_from_sensor: Quat::IDENTITY,
    };

    /// The device's +X points forward, +Y to the right and +Z down: Polhemus' and Ascension's
    /// transmitters, and receivers with their cable to the rear. [`Axes::new`] is for others.
    pub const FORWARD_RIGHT_DOWN: Self = Self {
        tracker_from_device: FROM_FORWARD_RIGHT_DOWN,
        head_from_sensor: FROM_FORWARD_RIGHT_DOWN,
    };

    /// Returns the rotation from the device's frame to one with +Y up, and from the sensor's axes
    /// to those of the head that wears it; both are normalised.
    ///
    /// # Errors
    /// Where either is no rotation.
    pub fn new(tracker_from_device: Quat, head_from_sensor: Quat) -> Result<Self, AxesError> {
        let unit = |q| valid::unit(q, NORM_TOLERANCE).map_err(|norm| AxesError { norm });
        Ok(Self {
            tracker_from_device: unit(tracker_from_device)?,
            head_from_sensor: unit(head_from_sensor)?,
        })
    }

    /// Returns a place, from the device's frame to the tracker's.
    pub fn position(&self, device: Vec3) -> Vec3 {
        Mat3::from_quat(self.tracker_from_device) * device
    }

    /// `tracker_from_head` of `device_from_sensor`.
    pub fn orientation(&self, device: Quat) -> Quat {
        let tracker_from_sensor = compose(self.tracker_from_device, device);
        compose(tracker_from_sensor, inverse(self.head_from_sensor))
    }

    /// Returns the reverse of [`Axes::position`].
    pub fn device_position(&self, tracker: Vec3) -> Vec3 {
        Mat3::from_quat(inverse(self.tracker_from_device)) * tracker
    }

    /// Returns the reverse of [`Axes::orientation`].
    pub fn device_orientation(&self, tracker: Quat) -> Quat {
        let device_from_head = compose(inverse(self.tracker_from_device), tracker);
        compose(device_from_head, self.head_from_sensor)
    }
}

/// Forward (+X) becomes −Z, right (+Y) +X and down (+Z) −Y.
const FROM_FORWARD_RIGHT_DOWN: Quat = Quat::from_xyzw(0.5, 0.5, -0.5, 0.5);

/// Returns the rotation whose columns are the sensor's axes.
pub(crate) fn from_columns([x, y, z]: [Vec3; 3]) -> Result<Quat, DropReason> {
    if !(x.is_finite() && y.is_finite() && z.is_finite()) {
        return Err(DropReason::OutOfRange);
    }
    let unit = |v: Vec3| (v.dot(v) - 1.0).abs() <= 2.0 * NORM_TOLERANCE;
    let square = |a: Vec3, b: Vec3| a.dot(b).abs() <= NORM_TOLERANCE;
    let right_handed = x.cross(y).dot(z) > 0.0;
    let is_rotation = unit(x)
        && unit(y)
        && unit(z)
        && square(x, y)
        && square(y, z)
        && square(z, x)
        && right_handed;
    if !is_rotation {
        return Err(DropReason::NotUnit);
    }
    // Shepperd's method: divide by the largest of the four parts.
    let trace = x.x + y.y + z.z;
    let parts = if trace > 0.0 {
        let s = 2.0 * sqrt(trace + 1.0);
        [(y.z - z.y) / s, (z.x - x.z) / s, (x.y - y.x) / s, 0.25 * s]
    } else if x.x >= y.y && x.x >= z.z {
        let s = 2.0 * sqrt(1.0 + x.x - y.y - z.z);
        [0.25 * s, (y.x + x.y) / s, (z.x + x.z) / s, (y.z - z.y) / s]
    } else if y.y >= z.z {
        let s = 2.0 * sqrt(1.0 + y.y - x.x - z.z);
        [(y.x + x.y) / s, 0.25 * s, (z.y + y.z) / s, (z.x - x.z) / s]
    } else {
        let s = 2.0 * sqrt(1.0 + z.z - x.x - y.y);
        [(z.x + x.z) / s, (z.y + y.z) / s, 0.25 * s, (x.y - y.x) / s]
    };
    let norm = valid::length(&parts);
    Ok(Quat::from_array(parts.map(|part| part / norm)))
}

/// Returns the sensor's axes: the columns of the rotation's matrix.
pub(crate) fn columns(q: Quat) -> [Vec3; 3] {
    let m = Mat3::from_quat(q);
    [m.x_axis, m.y_axis, m.z_axis]
}

/// Returns the rotation of azimuth about Z, elevation about the new Y, roll about the new X:
/// degrees.
pub(crate) fn from_euler_degrees(
    azimuth: f32,
    elevation: f32,
    roll: f32,
) -> Result<Quat, DropReason> {
    // Devices stay within a turn; `sin_cos` takes more than two.
    if ![azimuth, elevation, roll].iter().all(|a| a.abs() <= 360.0) {
        return Err(DropReason::OutOfRange);
    }
    let half = |degrees: f32| sin_cos(0.5 * degrees.to_radians());
    let ((sa, ca), (se, ce), (sr, cr)) = (half(azimuth), half(elevation), half(roll));
    let about_z = Quat::from_xyzw(0.0, 0.0, sa, ca);
    let about_y = Quat::from_xyzw(0.0, se, 0.0, ce);
    let about_x = Quat::from_xyzw(sr, 0.0, 0.0, cr);
    valid::sent_rotation(compose(compose(about_z, about_y), about_x))
}

/// Returns the reverse of [`from_euler_degrees`]; elevation within ±90.
pub(crate) fn euler_degrees(q: Quat) -> [f32; 3] {
    let [x, y, z] = columns(q);
    let azimuth = libm::atan2f(x.y, x.x);
    // The others of what is left once that is turned back: straight up,
    // where the azimuth can be anything, they agree with it.
    let (sin, cos) = sin_cos(azimuth);
    let elevation = libm::atan2f(-x.z, cos * x.x + sin * x.y);
    let roll = libm::atan2f(sin * z.x - cos * z.y, cos * y.y - sin * y.x);
    [azimuth, elevation, roll].map(f32::to_degrees)
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f32::consts::FRAC_1_SQRT_2;
    use proptest::prelude::*;

    #[test]
    fn forward_right_and_down_are_where_ours_are() {
        let axes = Axes::FORWARD_RIGHT_DOWN;
        assert_eq!(axes.position(Vec3::X), Vec3::NEG_Z);
        assert_eq!(axes.position(Vec3::Y), Vec3::X);
        assert_eq!(axes.position(Vec3::Z), Vec3::NEG_Y);
        assert_eq!(axes.orientation(Quat::IDENTITY), Quat::IDENTITY);
        let near = |a: Vec3, b: Vec3| assert!(a.distance(b) < 1e-6, "{a} is not {b}");
        // Azimuth grows clockwise from above: to the right.
        let right = axes.orientation(from_euler_degrees(90.0, 0.0, 0.0).unwrap());
        near(right * Vec3::NEG_Z, Vec3::X);
        near(right * Vec3::Y, Vec3::Y);
        // Elevation grows upwards, roll clockwise as the wearer sees it.
        let up = axes.orientation(from_euler_degrees(0.0, 90.0, 0.0).unwrap());
        near(up * Vec3::NEG_Z, Vec3::Y);
        near(up * Vec3::X, Vec3::X);
        let rolled = axes.orientation(from_euler_degrees(0.0, 0.0, 90.0).unwrap());
        near(rolled * Vec3::Y, Vec3::X);
        near(rolled * Vec3::NEG_Z, Vec3::NEG_Z);
    }

    #[test]
    fn a_sensor_may_sit_askew() {
        let quarter = Quat::from_xyzw(0.0, FRAC_1_SQRT_2, 0.0, FRAC_1_SQRT_2);
        let axes = Axes::new(Quat::IDENTITY, quarter).unwrap();
        let straight = axes.orientation(quarter);
        assert!((straight * Vec3::NEG_Z).distance(Vec3::NEG_Z) < 1e-6);
        for bad in [[0.0; 4], [f32::NAN, 0.0, 0.0, 1.0], [0.0, 0.0, 0.0, 1.02]] {
            let error = Axes::new(Quat::from_array(bad), quarter).unwrap_err();
            assert!(!(error.norm == 1.0), "{error}");
        }
    }

    #[test]
    fn what_is_no_rotation_is_refused() {
        use DropReason::{NotUnit, OutOfRange};
        assert_eq!(from_columns([Vec3::X, Vec3::Y, Vec3::NEG_Z]), Err(NotUnit));
        assert_eq!(from_columns([Vec3::X, Vec3::X, Vec3::Z]), Err(NotUnit));
        assert_eq!(from_columns([Vec3::NAN, Vec3::Y, Vec3::Z]), Err(OutOfRange));
        assert_eq!(from_euler_degrees(f32::NAN, 0.0, 0.0), Err(OutOfRange));
        assert_eq!(from_euler_degrees(0.0, 361.0, 0.0), Err(OutOfRange));
    }

    fn rotation() -> impl Strategy<Value = Quat> {
        prop::array::uniform4(-1.0_f32..1.0)
            .prop_map(Quat::from_array)
            .prop_filter("a length", |q| q.length() > 0.1)
            .prop_map(Quat::normalize)
    }

    fn same(a: Quat, b: Quat) -> bool {
        (a - b).length().min((a + b).length()) < 2e-6
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(if cfg!(miri) { 4 } else { 4096 }))]
        #[test]
        fn rotations_survive_their_forms(q in rotation(), t in rotation(), h in rotation()) {
            prop_assert!(same(from_columns(columns(q)).unwrap(), q));
            let [a, e, r] = euler_degrees(q);
            prop_assert!(same(from_euler_degrees(a, e, r).unwrap(), q), "{a} {e} {r}");
            let up = from_euler_degrees(a, 90.0, r).unwrap();
            let [a, e, r] = euler_degrees(up);
            prop_assert!(same(from_euler_degrees(a, e, r).unwrap(), up), "{a} {e} {r}");
            let axes = Axes::new(t, h).unwrap();
            prop_assert!(same(axes.device_orientation(axes.orientation(q)), q));
            let v = Vec3::new(q.x, q.y, q.z);
            prop_assert!(axes.device_position(axes.position(v)).distance(v) < 2e-6);
            // Where the head's front is in the tracker's frame, by glam.
            let expected = t * (q * (h.conjugate() * Vec3::NEG_Z));
            prop_assert!((axes.orientation(q) * Vec3::NEG_Z).distance(expected) < 4e-6);
        }
    }
}
