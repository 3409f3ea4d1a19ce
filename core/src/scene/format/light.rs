//! Lights, and the values of [`Light::kind`].

use crate::numeric::{max, min};
use glam::Vec3;
use zerocopy::{FromBytes, Immutable, IntoBytes, KnownLayout};

/// A point light, as bright at any distance.
pub const POINT: u32 = 0;
/// A point light that falls off by the inverse square of the distance.
pub const POINT_INVERSE_SQUARE: u32 = 1;
/// A light infinitely far away.
pub const DIRECTIONAL: u32 = 2;
/// A parallelogram that shines to the side of
/// [`right`](Light::right) × [`up`](Light::up). It is itself
/// invisible.
pub const RECTANGLE: u32 = 3;
/// A parallelogram that shines to both sides.
pub const TWO_SIDED_RECTANGLE: u32 = 4;

/// Most points of a light that each point of a surface samples.
pub const MOST_SAMPLES: u32 = 64;

/// A light.
#[derive(Debug, Clone, Copy, PartialEq, FromBytes, IntoBytes, Immutable, KnownLayout)]
#[repr(C, align(32))]
pub struct Light {
    /// Position, for a rectangle that of its middle; for a directional light the unit
    /// vector towards it.
    pub place: [f32; 3],
    /// One of [this module](self)'s kinds.
    pub kind: u32,
    /// Linear RGB irradiance, at 1 m if it falls off; for rectangles the radiance.
    /// Light of radiance 1 from all around a surface, or of irradiance 1 head-on,
    /// gives it the colour of its reflectance.
    pub colour: [f32; 3],
    /// Points of it that each point of a surface samples: 1 to
    /// [`MOST_SAMPLES`] for rectangles, 0 for other kinds.
    pub samples: u32,
    /// Vector from a rectangle's middle to that of its right side: metres. For a spot, which is a
    /// point light with a cone, the unit vector along its axis. Zero for other lights.
    pub right: [f32; 3],
    /// Zero.
    pub reserved: u32,
    /// Vector from a rectangle's middle to that of its upper side: metres. For a spot a factor, a
    /// summand, and zero: see [`Light::share`]. Zero for other lights.
    pub up: [f32; 3],
    /// Zero.
    pub reserved2: u32,
}

impl Light {
    /// Returns whether it has a size.
    pub const fn is_large(&self) -> bool {
        matches!(self.kind, RECTANGLE | TWO_SIDED_RECTANGLE)
    }

    /// Returns whether it shines into a cone.
    pub const fn is_spot(&self) -> bool {
        let [x, y, z] = self.right;
        !self.is_large() && (x != 0.0 || y != 0.0 || z != 0.0)
    }

    /// Returns the share of a spot's light, 0 to 1, that goes away from a unit vector to it: the
    /// square of a linear function of the cosine to its axis (`KHR_lights_punctual`).
    pub fn share(&self, to_light: Vec3) -> f32 {
        let [factor, summand, _] = self.up;
        let cosine = -to_light.dot(Vec3::from_array(self.right));
        let share = max(min(factor * cosine + summand, 1.0), 0.0);
        share * share
    }
}
