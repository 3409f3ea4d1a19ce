use crate::numeric::scalar::largest_number;
use glam::Vec3;

/// A half-line from a finite origin along a finite direction of any length but zero.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ray {
    origin: Vec3,
    direction: Vec3,
}

impl Ray {
    /// Coordinates of origins and vertices up to this magnitude, in metres,
    /// keep every product that intersection forms finite.
    pub const FARTHEST: f32 = 1.0e12;
    /// Directions whose largest component is shorter than this have no
    /// usable reciprocals: see [`Slabs`](super::Slabs).
    pub const SHORTEST_DIRECTION: f32 = 1.0e-18;
    /// Directions whose largest component is longer than this overflow.
    pub const LONGEST_DIRECTION: f32 = 1.0e18;

    /// Returns a ray, or `None` where a component is NaN or infinite, the origin is farther out
    /// than [`FARTHEST`](Self::FARTHEST) or the direction's largest component is outside
    /// [`SHORTEST_DIRECTION`](Self::SHORTEST_DIRECTION) to
    /// [`LONGEST_DIRECTION`](Self::LONGEST_DIRECTION).
    #[inline]
    pub fn new(origin: Vec3, direction: Vec3) -> Option<Self> {
        // NaN can hide from these, but not from the sum.
        let far = largest_number(origin);
        let long = largest_number(direction);
        let sum = origin.element_sum() + direction.element_sum();
        let usable = far <= Self::FARTHEST
            && (Self::SHORTEST_DIRECTION..=Self::LONGEST_DIRECTION).contains(&long)
            && !sum.is_nan();
        usable.then_some(Self { origin, direction })
    }

    /// Returns a ray from parts that [`new`](Self::new) has checked.
    #[cfg(target_arch = "x86_64")]
    #[inline(always)]
    pub(crate) const fn of_usable(origin: Vec3, direction: Vec3) -> Self {
        Self { origin, direction }
    }

    /// Returns where it starts: metres.
    #[inline(always)]
    pub const fn origin(&self) -> Vec3 {
        self.origin
    }

    /// Returns where it goes; any length but zero.
    #[inline(always)]
    pub const fn direction(&self) -> Vec3 {
        self.direction
    }

    /// Returns the point at `t`: finite for distances up to 10¹⁸ either way.
    #[inline(always)]
    pub fn at(&self, t: f32) -> Vec3 {
        self.origin + self.direction * t
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_cannot_be_traced_is_no_ray() {
        let (o, d) = (Vec3::ZERO, Vec3::NEG_Z);
        assert!(Ray::new(o, d).is_some());
        for axis in [Vec3::X, Vec3::Y, Vec3::Z] {
            for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1.0e19] {
                let with_bad = |v| Vec3::select(axis.cmpgt(o), Vec3::splat(bad), v);
                assert_eq!(Ray::new(with_bad(o), d), None);
                assert_eq!(Ray::new(o, with_bad(d)), None);
            }
            assert_eq!(Ray::new(axis * 1.0e13, d), None);
        }
        assert_eq!(Ray::new(o, Vec3::ZERO), None);
        assert_eq!(Ray::new(o, Vec3::splat(9.0e-19)), None);
        assert!(Ray::new(o, Vec3::new(1.0e-18, 0.0, -0.0)).is_some());
    }
}
