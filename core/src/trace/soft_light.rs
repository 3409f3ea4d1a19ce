//! Points of a light that has a size.

use crate::numeric::{lowbias32, min, normalize, sqrt};
use crate::scene::format::{Light, light};
use core::f32::consts::FRAC_1_PI;
use glam::Vec3;

/// The first two dimensions of Sobol's sequence (1967), scrambled for each pixel by
/// exclusive-or (Kollig & Keller 2002): 2ⁿ points fill each grid of 2ⁿ cells.
#[derive(Debug, Clone, Copy)]
pub(super) struct Points {
    scramble: [u32; 2],
}

impl Points {
    /// Returns the points on a light for the pixel of this seed.
    pub(super) const fn new(seed: u32, light: u32) -> Self {
        let first = lowbias32(seed ^ light.wrapping_mul(0x9e37_79b9));
        Self {
            scramble: [first, lowbias32(first ^ 0x5bf0_3635)],
        }
    }

    /// Returns a point of a square, from −1 to 1, both excluded.
    pub(super) fn point(self, number: u32) -> [f32; 2] {
        let first = number.reverse_bits();
        let mut second = 0;
        let (mut left, mut direction) = (number, 1u32 << 31);
        // A turn a bit of the number: 32 at most.
        while left != 0 {
            if left & 1 != 0 {
                second ^= direction;
            }
            left >>= 1;
            direction ^= direction >> 1;
        }
        [
            centred(first ^ self.scramble[0]),
            centred(second ^ self.scramble[1]),
        ]
    }
}

/// 32 bits as a number from −1 to 1: the middle of one of 2²³ equal parts.
fn centred(bits: u32) -> f32 {
    const PARTS: f32 = 8_388_608.0;
    ((bits >> 9) as f32 * 2.0 + (1.0 - PARTS)) / PARTS
}

/// A rectangular light, prepared for sampling.
#[derive(Debug, Clone, Copy)]
pub(super) struct Rectangle<'a> {
    light: &'a Light,
    /// Unit normal of the side that shines; of either side if both do.
    normal: Vec3,
    /// Area divided by π: square metres.
    area: f32,
}

impl<'a> Rectangle<'a> {
    /// `None` for a rectangle without an area, which gives no light.
    pub(super) fn new(light: &'a Light) -> Option<Self> {
        let right = Vec3::from_array(light.right);
        let up = Vec3::from_array(light.up);
        let normal = normalize(right.cross(up))?;
        let cross = right.cross(up);
        Some(Self {
            light,
            normal,
            area: 4.0 * sqrt(cross.dot(cross)) * FRAC_1_PI,
        })
    }

    /// Returns the place of a point of the square from −1 to 1.
    pub(super) fn place(&self, [x, y]: [f32; 2]) -> Vec3 {
        Vec3::from_array(self.light.place)
            + Vec3::from_array(self.light.right) * x
            + Vec3::from_array(self.light.up) * y
    }

    /// Irradiance cos θ·area/(π·distance²) of radiance 1, at most the number of points.
    pub(super) fn irradiance(&self, to_light: Vec3, unit: Vec3) -> f32 {
        let cosine = -self.normal.dot(unit);
        let cosine = if self.light.kind == light::TWO_SIDED_RECTANGLE {
            cosine.abs()
        } else {
            cosine
        };
        if cosine > 0.0 {
            let all = self.light.samples as f32;
            min(cosine * self.area / to_light.dot(to_light), all)
        } else {
            0.0
        }
    }
}
