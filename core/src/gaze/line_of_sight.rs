use crate::numeric::{DoubleFloat, scale_to_one};
use glam::Vec3;

/// Where the viewer looks from, and the axes of equations 1 to 3: unit
/// vectors in the room, at right angles, each component within an ulp.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LineOfSight {
    position: Vec3,
    forward: Vec3,
    right: Vec3,
    up: Vec3,
}

/// Why there is no line of sight.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum LineOfSightError {
    /// A coordinate of the position is NaN or infinite.
    #[error("the viewer's position is not finite: give metres in the room")]
    Position,
    /// A component of the direction is NaN or infinite.
    #[error("the direction of sight is not finite: give three finite numbers")]
    Direction,
    /// The direction is (0, 0, 0).
    #[error(
        "the direction of sight is zero and points nowhere: give a vector of any length but zero"
    )]
    ZeroDirection,
    /// A component of up is NaN or infinite.
    #[error("up is not finite: give three finite numbers")]
    Up,
    /// Up is (0, 0, 0).
    #[error("up is zero and points nowhere: give a vector of any length but zero")]
    ZeroUp,
    /// Up along the direction or against it, within [`LineOfSight::PARALLEL`].
    #[error(
        "up is parallel to the direction of sight, so which way is right cannot be told: give the \
         way that the top of the head points"
    )]
    Parallel,
    /// Axes that are not of length 1, not at right angles or left-handed, by more than
    /// [`LineOfSight::SKEW`].
    #[error("the axes of the line of sight are not three unit vectors at right angles")]
    Axes,
}

impl LineOfSight {
    /// The sine of the angle between direction and up, 2⁻²², up to which they
    /// count as parallel: the rounding of their components can make as much.
    pub const PARALLEL: f32 = f32::EPSILON * 2.0;

    /// How far the products of axes may be from 0 or 1.
    pub const SKEW: f32 = 1.0e-5;

    /// Returns the line of sight that has these axes, bit for bit: from `position` (metres, in the
    /// room) along `forward`, with what [`right`](Self::right) and [`up`](Self::up) have returned.
    ///
    /// # Errors
    /// A position that is not finite; axes that are not unit vectors at right angles.
    pub fn from_axes(
        position: Vec3,
        forward: Vec3,
        right: Vec3,
        up: Vec3,
    ) -> Result<Self, LineOfSightError> {
        if !position.is_finite() {
            return Err(LineOfSightError::Position);
        }
        let off = [
            forward.dot(forward) - 1.0,
            right.dot(right) - 1.0,
            up.dot(up) - 1.0,
            forward.dot(right),
            right.dot(up),
            up.dot(forward),
        ];
        let is_square = off.into_iter().all(|off| off.abs() <= Self::SKEW);
        if !(is_square && right.cross(forward).dot(up) > 0.0) {
            return Err(LineOfSightError::Axes);
        }
        Ok(Self {
            position,
            forward,
            right,
            up,
        })
    }

    /// From `position` (metres, in the room) along `direction`, the head's top
    /// towards `up`: vectors of any length but zero, at any angle but
    /// parallel. Right is forward × up; up is then put at right angles.
    ///
    /// # Errors
    /// What is not finite, zero or parallel.
    pub fn new(position: Vec3, direction: Vec3, up: Vec3) -> Result<Self, LineOfSightError> {
        use LineOfSightError as Error;
        if !position.is_finite() {
            return Err(Error::Position);
        }
        if !direction.is_finite() {
            return Err(Error::Direction);
        }
        if !up.is_finite() {
            return Err(Error::Up);
        }
        let direction = scale_to_one(direction).ok_or(Error::ZeroDirection)?;
        let up = scale_to_one(up).ok_or(Error::ZeroUp)?;
        let [direction, up] = [direction, up].map(|v| v.to_array().map(DoubleFloat::from));
        // From the components as given, whose products are exact: in f32 the product would
        // cancel as the angle shrinks.
        let right = cross(direction, up);
        let squares = dot(direction, direction).rounded() * dot(up, up).rounded();
        if !(dot(right, right).rounded() > Self::PARALLEL * Self::PARALLEL * squares) {
            return Err(Error::Parallel);
        }
        let forward = normalize(direction);
        let right = normalize(right);
        let vector = |v: [DoubleFloat; 3]| Vec3::from_array(v.map(DoubleFloat::rounded));
        Ok(Self {
            position,
            forward: vector(forward),
            right: vector(right),
            up: vector(normalize(cross(right, forward))),
        })
    }

    /// Returns where the viewer is: metres, in the room.
    pub const fn position(&self) -> Vec3 {
        self.position
    }

    /// `E_f`: the way the viewer looks.
    pub const fn forward(&self) -> Vec3 {
        self.forward
    }

    /// `E_r`: to the viewer's right.
    pub const fn right(&self) -> Vec3 {
        self.right
    }

    /// `E_u`: towards the top of the viewer's head.
    pub const fn up(&self) -> Vec3 {
        self.up
    }
}

fn dot([ax, ay, az]: [DoubleFloat; 3], [bx, by, bz]: [DoubleFloat; 3]) -> DoubleFloat {
    ax.multiply(bx).add(ay.multiply(by)).add(az.multiply(bz))
}

fn cross([ax, ay, az]: [DoubleFloat; 3], [bx, by, bz]: [DoubleFloat; 3]) -> [DoubleFloat; 3] {
    let difference =
        |a: DoubleFloat, b, c: DoubleFloat, d| a.multiply(b).add(c.multiply(d).negate());
    [
        difference(ay, bz, az, by),
        difference(az, bx, ax, bz),
        difference(ax, by, ay, bx),
    ]
}

/// Returns a vector whose square is above zero, at unit length.
fn normalize(v: [DoubleFloat; 3]) -> [DoubleFloat; 3] {
    let scale = dot(v, v).reciprocal_sqrt();
    v.map(|component| component.multiply(scale))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn new(direction: Vec3, up: Vec3) -> Result<LineOfSight, LineOfSightError> {
        LineOfSight::new(Vec3::ZERO, direction, up)
    }

    #[test]
    fn axes_are_kept_bit_for_bit_or_refused() {
        let sight = new(Vec3::new(0.3, -0.2, -0.9), Vec3::Y).unwrap();
        let (forward, right, up) = (sight.forward(), sight.right(), sight.up());
        let again = LineOfSight::from_axes(Vec3::ZERO, forward, right, up);
        assert_eq!(again, Ok(sight));
        for [forward, right, up] in [
            [forward, up, right],
            [forward, right, -up],
            [forward * 1.001, right, up],
            [forward, right, Vec3::new(f32::NAN, 0.0, 0.0)],
            [Vec3::ZERO; 3],
        ] {
            let refused = LineOfSight::from_axes(Vec3::ZERO, forward, right, up);
            assert_eq!(refused, Err(LineOfSightError::Axes));
        }
    }

    #[test]
    fn what_is_no_line_of_sight_says_so() {
        use LineOfSightError as Error;
        let ahead = Vec3::NEG_Z;
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            let bad = Vec3::new(0.0, bad, 1.0);
            assert_eq!(LineOfSight::new(bad, ahead, Vec3::Y), Err(Error::Position));
            assert_eq!(new(bad, Vec3::Y), Err(Error::Direction));
            assert_eq!(new(ahead, bad), Err(Error::Up));
        }
        assert_eq!(new(-Vec3::ZERO, Vec3::Y), Err(Error::ZeroDirection));
        assert_eq!(new(ahead, Vec3::ZERO), Err(Error::ZeroUp));
        assert_eq!(new(ahead, ahead * 1e-40), Err(Error::Parallel));
        assert_eq!(new(ahead, ahead * -1e38), Err(Error::Parallel));
        // Parallel but for the rounding of the components.
        let (a, b) = (Vec3::new(0.1, 0.2, 0.3), Vec3::new(0.3, 0.6, 0.9));
        assert_eq!(new(a, b), Err(Error::Parallel));
    }
}
