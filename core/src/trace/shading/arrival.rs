//! Rays that arrive at clear bodies and mirrors, and those that leave them.

use super::place;
use crate::scene::Scene;
use crate::shape::Ray;
use crate::trace::cone::Width;
use crate::trace::media::Media;
use crate::trace::optics::{Refraction, reflect};
use crate::trace::surface::Surface;
use crate::trace::workspace::Pending;
use glam::Vec3;

/// A ray's arrival at the border of a clear body, or at a mirror.
#[derive(Clone, Copy)]
pub(super) struct Arrival<'a> {
    pub(super) surface: Surface<'a>,
    /// Colour that the surface's texture and its vertices give to what it lets through.
    pub(super) stain: Vec3,
    /// Direction of the ray, unit length.
    pub(super) direction: Vec3,
    /// Shading normal on the ray's side, unit length.
    pub(super) normal: Vec3,
    pub(super) inside: bool,
    /// Weight of the ray's light in the pixel, on arrival.
    pub(super) weight: Vec3,
    pub(super) uncovered: f32,
    /// Number of bounces of its child rays.
    pub(super) bounces: u8,
    pub(super) is_tinted: bool,
    /// Width of the ray on arrival.
    pub(super) width: Width,
    /// The clear bodies that the ray is in.
    pub(super) media: Media,
}

impl<'a> Arrival<'a> {
    pub(super) fn next<const W: usize>(
        &self,
        scene: &Scene<'a, W>,
        direction: Vec3,
        (weight, uncovered): (Vec3, f32),
        (cause, media): (u32, Media),
    ) -> Option<Pending> {
        Some(Pending {
            ray: Ray::new(self.surface.start(scene, direction), direction)?,
            weight,
            uncovered,
            bounces: self.bounces,
            cause: place(cause),
            media,
            width: self.width,
            is_tinted: self.is_tinted,
        })
    }

    pub(super) fn reflected<const W: usize>(
        &self,
        scene: &Scene<'a, W>,
        share: (Vec3, f32),
        cause: u32,
    ) -> Option<Pending> {
        let facing = if self.inside { -1.0 } else { 1.0 };
        let reflected = above(
            reflect(self.direction, self.normal),
            self.surface.geometric_normal * facing,
        );
        self.next(scene, reflected, share, (cause, self.media))
    }

    /// Returns the share of light that the border lets through.
    pub(super) fn let_through(&self, refraction: &Refraction) -> Vec3 {
        let transmission = Vec3::from_array(self.surface.material.transmission) * self.stain;
        transmission * refraction.transmittance
    }

    /// Returns the refracted ray, with a share of the light; `None` on total reflection.
    pub(super) fn refracted<const W: usize>(
        &self,
        scene: &Scene<'a, W>,
        refraction: &Refraction,
        share: Vec3,
        cause: (u32, Media),
    ) -> Option<Pending> {
        let uncovered = self.uncovered * share.max_element();
        let share = (self.weight * share, uncovered);
        self.next(scene, refraction.direction?, share, cause)
    }
}

/// The shares of light that go on from the border of a clear body, if any.
pub(super) struct Sides {
    pub(super) through: Option<Vec3>,
    pub(super) back: Option<Vec3>,
}

/// Mirrors a direction that points into the surface back out of it. Continuous.
pub(super) fn above(direction: Vec3, normal: Vec3) -> Vec3 {
    let depth = direction.dot(normal);
    if depth < 0.0 {
        direction - normal * (2.0 * depth)
    } else {
        direction
    }
}
