//! Directions and places as they are written on a command line.
//!
//! A direction is one of the names `front`, `floor`, `right`, `left`, `back` and `ceiling`; or
//! `YAW,PITCH` in degrees, to the right and upwards positive (`0,0` is −Z, `90,0` is +X, `0,90` is
//! +Y); or `X,Y,Z`, of any length but zero. A place is `X,Y,Z` in metres. White space around a
//! number does not count.

use crate::cave::angle::sin_cos_degrees;
use glam::{DMat3, DQuat, DVec3};
use std::str::FromStr;
use thiserror::Error;

/// Why a direction or a place could not be read, and what would be one.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("\"{given}\" {fault}")]
pub struct LookError {
    /// The text.
    pub given: String,
    fault: String,
}

impl LookError {
    fn new(given: &str, fault: impl Into<String>) -> Self {
        Self {
            given: given.to_owned(),
            fault: fault.into(),
        }
    }
}

/// A direction in the room, of unit length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ViewDirection(DVec3);

/// Right-handed orthonormal axes of a direction: `right` × `up` = −`forward`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ViewBasis {
    /// To the right, level.
    pub right: DVec3,
    /// As near to the world's up as is at right angles to `forward`.
    pub up: DVec3,
    /// The direction itself.
    pub forward: DVec3,
}

impl ViewDirection {
    /// Along −Z.
    pub const FRONT: Self = Self(DVec3::NEG_Z);

    /// Shortest level part of a direction that is not vertical: far above
    /// the rounding of a unit vector, far below any angle that is meant.
    const VERTICAL: f64 = 1.0e-9;

    /// Returns the way `direction` points; `None` where it is zero or not finite.
    pub fn new(direction: DVec3) -> Option<Self> {
        let largest = direction.abs().max_element();
        // Scaled first, so that no square overflows or vanishes.
        (direction.is_finite() && largest > 0.0).then(|| Self((direction / largest).normalize()))
    }

    /// Returns the unit vector.
    pub const fn vector(self) -> DVec3 {
        self.0
    }

    /// Returns forward and up of [`basis`](Self::basis).
    pub fn directions(self) -> (DVec3, DVec3) {
        let basis = self.basis();
        (basis.forward, basis.up)
    }

    /// Returns the turn of an upright head that faces this way, from one that faces the front.
    pub fn orientation(self) -> DQuat {
        let ViewBasis { right, up, forward } = self.basis();
        DQuat::from_mat3(&DMat3::from_cols(right, up, -forward))
    }

    /// Returns the axes of a viewer who looks this way and holds the head upright. Straight down,
    /// `up` is −Z; straight up it is +Z; `right` is +X in both.
    pub fn basis(self) -> ViewBasis {
        let forward = self.0;
        let level = DVec3::new(-forward.z, 0.0, forward.x);
        let right = if level.length() > Self::VERTICAL {
            level.normalize()
        } else {
            DVec3::X
        };
        ViewBasis {
            right,
            up: right.cross(forward),
            forward,
        }
    }
}

impl FromStr for ViewDirection {
    type Err = LookError;

    fn from_str(text: &str) -> Result<Self, LookError> {
        let named = match text.trim() {
            "front" => Some(DVec3::NEG_Z),
            "floor" => Some(DVec3::NEG_Y),
            "right" => Some(DVec3::X),
            "left" => Some(DVec3::NEG_X),
            "back" => Some(DVec3::Z),
            "ceiling" => Some(DVec3::Y),
            _ => None,
        };
        if let Some(direction) = named {
            return Ok(Self(direction));
        }
        match numbers(text).as_deref() {
            Some(&[_, pitch]) if !(-90.0..=90.0).contains(&pitch) => {
                let fault = format!("has a pitch of {pitch}°: use -90 (down) to 90 (up)");
                Err(LookError::new(text, fault))
            }
            Some(&[yaw, pitch]) => {
                let (sin_yaw, cos_yaw) = sin_cos_degrees(yaw);
                let (sin_pitch, cos_pitch) = sin_cos_degrees(pitch);
                Ok(Self(DVec3::new(
                    sin_yaw * cos_pitch,
                    sin_pitch,
                    -cos_yaw * cos_pitch,
                )))
            }
            Some(&[x, y, z]) => Self::new(DVec3::new(x, y, z)).ok_or_else(|| {
                LookError::new(text, "points nowhere: at least one of X,Y,Z is not 0")
            }),
            _ => Err(LookError::new(
                text,
                "is not a direction: use front, floor, right, left, back or ceiling, YAW,PITCH in \
                 degrees (right and up are positive), or X,Y,Z",
            )),
        }
    }
}

/// A place in the room, metres; finite.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Point(pub DVec3);

impl FromStr for Point {
    type Err = LookError;

    fn from_str(text: &str) -> Result<Self, LookError> {
        match numbers(text).as_deref() {
            Some(&[x, y, z]) => Ok(Self(DVec3::new(x, y, z))),
            _ => Err(LookError::new(
                text,
                "is not a position: use X,Y,Z in metres, such as 0,1.6,0.5",
            )),
        }
    }
}

/// Returns the finite numbers between commas; `None` if one is missing or not finite.
fn numbers(text: &str) -> Option<Vec<f64>> {
    text.split(',')
        .map(|number| number.trim().parse().ok().filter(|n: &f64| n.is_finite()))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn vector(text: &str) -> DVec3 {
        text.parse::<ViewDirection>().unwrap().vector()
    }

    #[test]
    fn names_degrees_and_vectors_mean_the_same() {
        for (name, degrees, xyz) in [
            ("front", "0,0", "0,0,-2"),
            ("right", "90,0", "0.5,0,0"),
            ("left", "-90,0", "-1e300,0,0"),
            ("back", "180,0", "0,0,1e-320"),
            ("floor", "0,-90", "0,-1,0"),
            ("ceiling", "0,90", "0,7,0"),
        ] {
            assert_eq!(vector(name), vector(degrees), "{name}");
            assert_eq!(vector(name), vector(xyz), "{name}");
        }
    }

    #[test]
    fn what_is_no_direction_or_place_says_what_was_given_and_the_grammar() {
        for text in ["", "Front", "1", "1,", "1,2,3,4", "1,x,3", "nan,0", "1 2 3"] {
            let message = text.parse::<ViewDirection>().unwrap_err().to_string();
            assert!(message.contains(&format!("\"{text}\"")), "{message}");
            assert!(message.contains("YAW,PITCH"), "{message}");
        }
        for (text, says) in [("0,90.5", "a pitch of 90.5°"), ("0,-0,0", "points nowhere")] {
            let error = text.parse::<ViewDirection>().unwrap_err();
            assert!(error.to_string().contains(says), "{error}");
        }
        let point = " 0, -1.5,2e-1".parse();
        assert_eq!(point, Ok(Point(DVec3::new(0.0, -1.5, 0.2))));
        let error = "1,2,1e999".parse::<Point>().unwrap_err().to_string();
        assert!(error.contains("is not a position: use X,Y,Z"), "{error}");
    }

    #[test]
    fn vertical_gazes_keep_right_at_x() {
        for (text, up) in [("ceiling", DVec3::Z), ("1e-12,-1,1e-12", DVec3::NEG_Z)] {
            let basis = text.parse::<ViewDirection>().unwrap().basis();
            assert_eq!(basis.right, DVec3::X, "{text}");
            assert!((basis.up - up).length() < 1e-11, "{text}");
        }
    }

    #[test]
    fn a_head_turns_with_its_look() {
        for text in ["front", "right", "back", "ceiling", "-30,40", "1,-2,3"] {
            let look = text.parse::<ViewDirection>().unwrap();
            let (head, basis) = (look.orientation(), look.basis());
            for (axis, found) in [
                (basis.right, head * DVec3::X),
                (basis.up, head * DVec3::Y),
                (basis.forward, head * DVec3::NEG_Z),
            ] {
                assert!((axis - found).length() < 1e-15, "{text}: {found}");
            }
        }
    }
}
