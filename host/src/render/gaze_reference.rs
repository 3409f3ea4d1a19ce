//! The gaze's levels in f64: what the core's f32 is measured against.
//!
//! Equation numbers are those of Mochizuki & Makino, as in [`shisen_core::gaze`], and so is what
//! happens where an equation has no value. Written for exactness, not for speed, and apart from the
//! core: arc tangents are `libm`'s, and nothing is shared but the names of cases.

use glam::DVec3;
use shisen_core::gaze::{Boundary, LineOfSightError, Zone};

/// How far the visual field reaches from the line of sight, radians, with the
/// ranges of [`shisen_core::gaze::VisualFieldLimits`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// Radius of the central field.
    pub central: f64,
    /// Upwards.
    pub up: f64,
    /// Downwards.
    pub down: f64,
    /// To the left.
    pub left: f64,
    /// To the right.
    pub right: f64,
}

impl Limits {
    /// The paper's: 30°; 60° up, 70° down, 100° to each side.
    pub const PAPER: Self = Self {
        central: std::f64::consts::FRAC_PI_6,
        up: std::f64::consts::FRAC_PI_3,
        down: 7.0 * std::f64::consts::PI / 18.0,
        left: 5.0 * std::f64::consts::PI / 9.0,
        right: 5.0 * std::f64::consts::PI / 9.0,
    };
}

/// A line of sight and a visual field.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gaze {
    forward: DVec3,
    right: DVec3,
    up: DVec3,
    limits: Limits,
    boundary: Boundary,
}

/// How a ray stands to the line of sight; angles are radians, with the ranges
/// of [`shisen_core::gaze::Sight`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sight {
    /// Equation 4.
    pub m_alpha: f64,
    /// Equation 5.
    pub m_beta: f64,
    /// Equation 6.
    pub l: f64,
    /// Equation 7.
    pub big_l: f64,
    /// Equation 8.
    pub level: f64,
    /// Which case of equation 8 it is.
    pub zone: Zone,
}

impl Gaze {
    /// Along `direction`, the head's top towards `up`, of any length.
    ///
    /// # Errors
    /// What is not finite, zero or exactly parallel.
    pub fn new(
        direction: DVec3,
        up: DVec3,
        limits: Limits,
        boundary: Boundary,
    ) -> Result<Self, LineOfSightError> {
        use LineOfSightError as Error;
        if !direction.is_finite() {
            return Err(Error::Direction);
        }
        if !up.is_finite() {
            return Err(Error::Up);
        }
        let forward = unit(direction).ok_or(Error::ZeroDirection)?;
        let up = unit(up).ok_or(Error::ZeroUp)?;
        let right = unit(forward.cross(up)).ok_or(Error::Parallel)?;
        Ok(Self {
            forward,
            right,
            up: right.cross(forward),
            limits,
            boundary,
        })
    }

    /// Returns all that leads to the level of a ray, by its direction, of any length;
    /// `None` where that is zero or not finite.
    pub fn sight(&self, direction: DVec3) -> Option<Sight> {
        let direction = unit(direction)?;
        let f = self.forward.dot(direction);
        let r = self.right.dot(direction);
        let u = self.up.dot(direction);
        let m_alpha = angle(r.abs(), f);
        let m_beta = angle(u.abs(), f.abs()).copysign(if u < 0.0 { -1.0 } else { 1.0 });
        let Limits {
            central,
            up,
            down,
            left,
            right,
        } = self.limits;
        let l = libm::hypot(m_alpha, m_beta);
        let across = if r < 0.0 { left } else { right };
        let along = if u < 0.0 { down } else { up };
        let big_l = if l == 0.0 {
            right
        } else {
            let (x, y) = (m_alpha / l, m_beta / l);
            match self.boundary {
                Boundary::Printed => libm::hypot(across * x, along * y),
                Boundary::Ellipse => 1.0 / libm::hypot(x / across, y / along),
            }
        };
        let (level, zone) = if l <= central {
            (1.0, Zone::Central)
        } else if l < big_l {
            ((big_l - l) / (big_l - central), Zone::Peripheral)
        } else {
            (0.0, Zone::Outside)
        };
        Some(Sight {
            m_alpha,
            m_beta,
            l,
            big_l,
            level,
            zone,
        })
    }
}

/// Equation 9, rounded down.
pub fn bounces(level: f64, most: u8) -> u8 {
    (level * f64::from(most)) as u8
}

/// Equation 10 in steps of two faces, from `min` to at most `max`.
pub fn faces(level: f64, min: u32, max: u32) -> u32 {
    let pairs = (level * f64::from(max - min) / 2.0).round();
    (f64::from(min) + 2.0 * pairs).min(f64::from(max)) as u32
}

/// From the x axis to (x, y), `y` not below zero: 0 to π, and 0 at the origin,
/// whatever the sign of its zeros.
fn angle(y: f64, x: f64) -> f64 {
    if x == 0.0 && y == 0.0 {
        0.0
    } else {
        libm::atan2(y, x)
    }
}

/// `v` at unit length; `None` where it is zero or not finite.
fn unit(v: DVec3) -> Option<DVec3> {
    let largest = v.abs().max_element();
    // Scaled first, so that no square overflows or vanishes.
    (v.is_finite() && largest > 0.0).then(|| {
        let v = v / largest;
        v / v.length()
    })
}
