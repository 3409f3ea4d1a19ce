//! Where dome masters of a scene are taken, frame by frame.

use crate::scene::mesh::TriangleMesh;
use glam::{DVec3, Mat3};
use shisen_core::frame::DomePose;
use thiserror::Error;

/// Where a dome master is taken and which way round.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DomeCamera {
    /// Metres.
    pub position: DVec3,
    /// Towards the middle of the picture; any length but zero.
    pub zenith: DVec3,
    /// Towards the top of the picture, as far as that is square to the zenith; not along it.
    pub top: DVec3,
}

impl DomeCamera {
    /// Straight up at the origin, the front (−Z) at the bottom of the picture.
    pub const UPRIGHT: Self = Self {
        position: DVec3::ZERO,
        zenith: DVec3::Y,
        top: DVec3::Z,
    };

    /// Upright, then leaning forward until the front is this much nearer to the
    /// middle of the picture: radians.
    pub fn tilted(position: DVec3, angle: f64) -> Self {
        let (sin, cos) = (libm::sin(angle), libm::cos(angle));
        Self {
            position,
            zenith: DVec3::new(0.0, cos, -sin),
            top: DVec3::new(0.0, sin, cos),
        }
    }

    /// Returns whether zenith and top are directions, and not along each other.
    fn is_usable(&self) -> bool {
        let length = self.zenith.length() * self.top.length();
        let across = self.zenith.cross(self.top).length();
        self.position.is_finite() && length > 0.0 && across >= 1.0e-6 * length
    }

    /// Returns the camera in the core's terms.
    pub fn pose(&self) -> DomePose {
        let back = -self.zenith.normalize_or_zero();
        let right = self.top.cross(back).normalize_or_zero();
        let top = back.cross(right);
        DomePose {
            position: self.position.as_vec3(),
            room_from_capture: Mat3::from_cols(right.as_vec3(), top.as_vec3(), back.as_vec3()),
        }
    }
}

/// A camera at a frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CameraKey {
    /// The number of its picture, from 1.
    pub frame: u32,
    /// Where it is then.
    pub camera: DomeCamera,
}

/// A camera's way through a scene: a Catmull-Rom spline through its keys, at rest before the first
/// and after the last. Zenith and top turn in proportion to the frames between keys.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct CameraPath {
    keys: Vec<CameraKey>,
}

/// A key that makes no path with the others.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[error("the camera's {fault}")]
pub struct CameraPathError {
    /// The number of the key, from 0.
    pub key: usize,
    fault: &'static str,
    pub(super) help: &'static str,
}

impl CameraPath {
    /// Returns a path through keys; without keys there is no camera.
    ///
    /// # Errors
    /// A key beyond [`TriangleMesh::FARTHEST`] on an axis, whose zenith and top are zero or along
    /// each other, whose frame is not after that of the key before it, or whose zenith or top is
    /// opposite to that of the key before it: it could turn either way.
    pub fn new(keys: Vec<CameraKey>) -> Result<Self, CameraPathError> {
        let error = |key, fault, help| Err(CameraPathError { key, fault, help });
        for (number, key) in keys.iter().enumerate() {
            let farthest = key.camera.position.abs().max_element();
            // NaN is refused too.
            if !(key.camera.position.is_finite() && farthest <= f64::from(TriangleMesh::FARTHEST)) {
                let help = "coordinates may be up to 1e12 m; move the scene nearer to its origin";
                return error(number, "`position` is too far away", help);
            }
            if !key.camera.is_usable() {
                let help = "give directions to the middle and to the top of the picture, such as \
                            [0, 1, 0] and [0, 0, 1]";
                let fault = "`zenith` and `top` point nowhere or along each other";
                return error(number, fault, help);
            }
        }
        for (number, pair) in (1..).zip(keys.windows(2)) {
            let &[before, after] = pair else { continue };
            if after.frame <= before.frame {
                let help = "put cameras in the order of their frames, each at its own";
                let fault = "`frame` is not after that of the camera before it";
                return error(number, fault, help);
            }
            // Half a turn is the most that a straight line between directions
            // can make; at a hundred places of it, axes are never lost.
            let steps = (0..=100).map(|i| between(&before, &after, f64::from(i) / 100.0));
            if steps.into_iter().any(|camera| !camera.is_usable()) {
                let help = "add a camera between the two that says which way to turn";
                let fault = "`zenith` or `top` is against that of the camera before it";
                return error(number, fault, help);
            }
        }
        Ok(Self { keys })
    }

    /// Returns the frame of the last key; 1 without keys.
    pub fn frames(&self) -> u32 {
        self.keys.last().map_or(1, |key| key.frame)
    }

    /// Returns the camera at a frame, counted from 1; `None` without keys.
    pub fn camera(&self, frame: u32) -> Option<DomeCamera> {
        let after = self.keys.partition_point(|key| key.frame <= frame);
        let (Some(before), Some(next)) = (after.checked_sub(1), self.keys.get(after)) else {
            // Before the first or after the last.
            let held = self.keys.first().filter(|_| after == 0);
            return held.or(self.keys.last()).map(|key| key.camera);
        };
        let key = self.keys[before];
        let span = f64::from(next.frame - key.frame);
        let t = f64::from(frame - key.frame) / span;
        let mut camera = between(&key, next, t);
        // Hermite's form, with the slope at a key that of its neighbours.
        let start = self.slope(before) * span;
        let end = self.slope(after) * span;
        let (t2, t3) = (t * t, t * t * t);
        camera.position = key.camera.position * (2.0 * t3 - 3.0 * t2 + 1.0)
            + start * (t3 - 2.0 * t2 + t)
            + next.camera.position * (3.0 * t2 - 2.0 * t3)
            + end * (t3 - t2);
        Some(camera)
    }

    /// Returns metres a frame at a key.
    fn slope(&self, key: usize) -> DVec3 {
        let last = self.keys.len() - 1;
        let (before, after) = (key.saturating_sub(1), (key + 1).min(last));
        let (before, after) = (&self.keys[before], &self.keys[after]);
        let frames = f64::from(after.frame - before.frame);
        (after.camera.position - before.camera.position) / frames
    }
}

/// Zenith and top on the way from one key to another.
fn between(before: &CameraKey, after: &CameraKey, t: f64) -> DomeCamera {
    let (before, after) = (&before.camera, &after.camera);
    let mixed = |a: DVec3, b: DVec3| a.normalize_or_zero().lerp(b.normalize_or_zero(), t);
    DomeCamera {
        position: before.position.lerp(after.position, t),
        zenith: mixed(before.zenith, after.zenith),
        top: mixed(before.top, after.top),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn key(frame: u32, x: f64) -> CameraKey {
        CameraKey {
            frame,
            camera: DomeCamera {
                position: DVec3::new(x, 0.0, 0.0),
                ..DomeCamera::UPRIGHT
            },
        }
    }

    #[test]
    fn paths_go_through_their_keys_and_straight_on() {
        let path = CameraPath::new(vec![key(1, 0.0), key(11, 10.0), key(21, 20.0)]).unwrap();
        assert_eq!(path.frames(), 21);
        for frame in 1..=30 {
            let x = path.camera(frame).unwrap().position.x;
            let expected = f64::from(frame.min(21)) - 1.0;
            assert!((x - expected).abs() < 1.0e-12, "{frame}: {x}");
        }
        let late = CameraPath::new(vec![key(5, 3.0)]).unwrap();
        assert_eq!(late.camera(1), Some(key(5, 3.0).camera));
        assert_eq!(late.camera(9), Some(key(5, 3.0).camera));
        assert_eq!(CameraPath::default().camera(1), None);
    }

    #[test]
    fn keys_that_make_no_path_are_refused() {
        let [mut far, mut along, mut over] = [key(1, 0.0), key(1, 0.0), key(2, 0.0)];
        far.camera.position.x = 1.0e300;
        along.camera.top = DVec3::NEG_Y;
        over.camera.zenith = DVec3::NEG_Y;
        for (keys, at, says) in [
            (vec![key(4, 0.0), key(4, 1.0)], 1, "not after"),
            (vec![far], 0, "too far"),
            (vec![along], 0, "along each other"),
            (vec![key(1, 0.0), over], 1, "against"),
        ] {
            let error = CameraPath::new(keys).unwrap_err();
            assert!(
                error.key == at && error.to_string().contains(says),
                "{error}"
            );
        }
    }

    #[test]
    fn directions_turn_between_keys() {
        let mut keys = vec![key(1, 0.0), key(3, 0.0)];
        keys[1].camera = DomeCamera::tilted(DVec3::ZERO, std::f64::consts::FRAC_PI_2);
        let middle = CameraPath::new(keys).unwrap().camera(2).unwrap().pose();
        let expected = DomeCamera::tilted(DVec3::ZERO, std::f64::consts::FRAC_PI_4).pose();
        let axes = [middle, expected].map(|pose| pose.room_from_capture);
        assert!(axes[0].abs_diff_eq(axes[1], 1.0e-6), "{axes:?}");
    }
}
