//! Random inputs of hard cases, the same on every machine.

use glam::{DVec3, Vec3};
use shisen_core::shape::Ray;
use shisen_tracker::mock::Random;

pub(crate) struct Inputs(Random);

impl Inputs {
    pub(crate) fn new(seed: u64) -> Self {
        Self(Random::new(seed, 8))
    }

    /// Returns a number from 0 up to, but not including, 1.
    pub(crate) fn unit(&mut self) -> f64 {
        let high = u64::from(self.0.bits()) << 32 | u64::from(self.0.bits());
        (high >> 11) as f64 / (1u64 << 53) as f64
    }

    pub(crate) fn range(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// Returns a number between two powers of ten, evenly over the exponents.
    pub(crate) fn magnitude(&mut self, low: f64, high: f64) -> f64 {
        libm::exp10(self.range(low, high))
    }

    pub(crate) fn sign(&mut self) -> f64 {
        if self.unit() < 0.5 { -1.0 } else { 1.0 }
    }

    /// 0 to `count` − 1.
    pub(crate) fn below(&mut self, count: usize) -> usize {
        (self.unit() * count as f64) as usize
    }

    /// Returns a direction, evenly over the unit sphere.
    pub(crate) fn direction(&mut self) -> DVec3 {
        let z = self.range(-1.0, 1.0);
        let (sin, cos) = libm::sincos(self.range(0.0, std::f64::consts::TAU));
        let r = (1.0 - z * z).sqrt();
        DVec3::new(r * cos, r * sin, z)
    }

    /// Returns a point, evenly in the unit ball.
    pub(crate) fn in_ball(&mut self) -> DVec3 {
        self.direction() * libm::cbrt(self.unit())
    }

    /// Returns a unit vector perpendicular to another.
    pub(crate) fn across(&mut self, direction: DVec3) -> DVec3 {
        let (x, y) = direction.any_orthonormal_pair();
        let (sin, cos) = libm::sincos(self.range(0.0, std::f64::consts::TAU));
        x * cos + y * sin
    }
}

/// Returns a ray from `origin` towards `target`, rounded to f32 for the tracer and the reference
/// alike.
pub(super) fn aimed(origin: DVec3, target: DVec3) -> Option<Ray> {
    Ray::new(origin.as_vec3(), (target - origin).as_vec3())
}

pub(super) fn single(v: DVec3) -> Vec3 {
    v.as_vec3()
}
