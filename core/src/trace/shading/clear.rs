//! What rays go through without being bent: holes in surfaces, and clear things between a point and
//! its lights.

use super::{RayTree, Shading, place};
use crate::numeric::{map3, max, min, sqrt};
use crate::scene::EffectSet;
use crate::scene::format::{Instance, MOST_NESTED, Material, effect, flag};
use crate::shape::Ray;
use crate::simd::{Runs, Simd};
use crate::trace::hit::Hit;
use crate::trace::ledger::Record;
use crate::trace::media::{Border, Media};
use crate::trace::optics::refract;
use crate::trace::surface::Surface;
use crate::trace::texture;
use glam::Vec3;

/// Most surfaces that a ray goes through; the next one is opaque. A ray tree sees through as many
/// veils without spending bounces.
pub(super) const MOST_LAYERS: usize = 128;

/// Least alpha of what is seen, half a step of an eight-bit texture, and least share of light that
/// casts no full shadow.
const LEAST: f32 = 0.5 / 255.0;

const CLEAR_SHADOWS: u32 = EffectSet::CLEAR_SHADOWS.bits();

impl<const W: usize, const EFFECTS: u32> Shading<'_, '_, W, EFFECTS> {
    /// Returns whether an effect is carried out that the scene asks for.
    #[inline(always)]
    pub(super) const fn is_asked(&self, effect: u32) -> bool {
        EFFECTS & effect != 0 && self.effects & self.searcher.scene.header.effects & effect != 0
    }

    /// Returns what is on both sides of the border of a clear body, for a ray that is in some;
    /// `None` without nested media.
    #[inline(always)]
    pub(super) fn border(&self, media: Media, material: &Material, leaves: bool) -> Option<Border> {
        let is_clear = material.effects & self.effects & effect::REFRACTION != 0;
        if !self.is_asked(effect::NESTED_MEDIA) || !is_clear || material.index_of_refraction == 1.0
        {
            return None;
        }
        let materials = self.searcher.scene.materials;
        // A material of the scene is one of its table.
        let from = materials.as_ptr().addr();
        let bytes = core::ptr::from_ref(material).addr().checked_sub(from)?;
        let number = bytes / size_of::<Material>();
        let body = u8::try_from(number).ok().filter(|_| number < MOST_NESTED)?;
        Some(media.border(body, leaves, materials))
    }
}

impl<'a, const W: usize, const EFFECTS: u32, R: Record> RayTree<'_, 'a, W, EFFECTS, R>
where
    Simd: Runs<W>,
{
    /// Returns what fills the way of a ray in some bodies: `own` without nested media.
    #[inline(always)]
    pub(super) fn filling(&self, media: Media, own: Option<&'a Material>) -> Option<&'a Material> {
        if !self.shading.is_asked(effect::NESTED_MEDIA) {
            return own;
        }
        let materials = self.shading.searcher.scene.materials;
        match media.top(materials) {
            Some(top) => materials.get(usize::from(top)),
            None => own,
        }
    }

    /// Returns whether what is behind a surface is seen straight through it, as far as it is not
    /// opaque.
    #[inline(always)]
    pub(super) fn is_veil(&self, material: &Material) -> bool {
        let effects = material.effects & self.shading.effects;
        Self::has(effect::ALPHA)
            && effects & effect::ALPHA != 0
            && material.index_of_refraction == 1.0
    }

    /// Returns whether light comes through shadows.
    #[inline(always)]
    pub(super) fn has_clear_shadows(&self) -> bool {
        self.shading.is_asked(CLEAR_SHADOWS)
    }

    /// Returns the opacity of a surface: of a mask 0 or 1.
    #[inline(always)]
    pub(super) fn opacity(&self, surface: &Surface<'_>) -> f32 {
        let material = surface.material;
        let effects = material.effects & self.shading.effects;
        if !Self::has(effect::ALPHA) || effects & effect::ALPHA == 0 {
            return 1.0;
        }
        let scene = &self.shading.searcher.scene;
        let number = material.alpha_texture;
        let alpha = texture::alpha::<W, EFFECTS>(scene, number, effects, &surface.coordinates);
        let alpha = material.opacity * alpha;
        if material.alpha_cutoff > 0.0 {
            return if alpha < material.alpha_cutoff {
                0.0
            } else {
                1.0
            };
        }
        alpha
    }

    /// Returns the first surface along a ray that is neither a hole nor the border of a body that
    /// another one fills, and its distance.
    #[inline(always)]
    pub(super) fn first_surface(
        &mut self,
        ray: &Ray,
        met: Option<(Surface<'a>, f32)>,
    ) -> Option<(Surface<'a>, f32)> {
        if !self.shading.is_asked(effect::ALPHA) && !self.shading.is_asked(effect::NESTED_MEDIA) {
            return met;
        }
        let (mut surface, mut t) = met?;
        for _ in 0..MOST_LAYERS {
            let leaves = ray.direction().dot(surface.geometric_normal) > 0.0;
            let border = self.shading.border(self.media, surface.material, leaves);
            // A body that another one with a higher priority fills has no border there.
            let hidden = border.filter(|border| border.before == border.beyond);
            let cause = match hidden {
                Some(border) => {
                    self.media = border.after;
                    effect::NESTED_MEDIA
                }
                None if self.opacity(&surface) <= LEAST => effect::ALPHA,
                None => break,
            };
            self.record.touch(cause);
            let scene = &self.shading.searcher.scene;
            let start = surface.start(scene, ray.direction());
            let next = Ray::new(start, ray.direction())?;
            self.workspace.statistics.refracted += 1;
            let (_, next) = self.next_along(&next, f32::INFINITY, cause)?;
            t += next.1;
            surface = next.0;
        }
        Some((surface, t))
    }

    /// Returns what a ray that is traced for an effect meets next up to a distance.
    fn next_along(
        &mut self,
        ray: &Ray,
        limit: f32,
        cause: u32,
    ) -> Option<(&'a Instance, (Surface<'a>, f32))> {
        let (searcher, rung) = (self.shading.searcher, self.shading.detail.rung);
        let (budget, workspace) = (&mut *self.budget, &mut *self.workspace);
        let before = workspace.statistics.steps;
        let hit = searcher.next_within(rung, ray, limit, budget, workspace);
        let steps = workspace.statistics.steps - before;
        self.record.ray(place(cause), steps);
        let hit: Hit = hit.filter(|_| !self.budget.is_exhausted())?;
        let instance = searcher.scene.instances.get(hit.instance as usize)?;
        Some((instance, self.meet(ray, &hit)?))
    }

    /// Returns the share of a light that gets through what is between it and a point: attenuated by
    /// transmission, Fresnel's equations and absorption, but not bent.
    #[inline(never)]
    pub(super) fn let_by(&mut self, ray: &Ray, limit: f32, mut cause: u32) -> Vec3 {
        let (mut share, mut ray, mut left) = (Vec3::ONE, *ray, limit);
        let mut media = self.media;
        for _ in 0..MOST_LAYERS {
            self.workspace.statistics.shadow += 1;
            let Some((instance, (surface, t))) = self.next_along(&ray, left, cause) else {
                return share;
            };
            // Without this effect one ray would say it.
            cause = CLEAR_SHADOWS;
            self.record.touch(cause);
            if instance.flags & (flag::OCCLUDES | flag::VEILS) != 0 {
                share *= self.clarity(&ray, &surface, t, &mut media);
            }
            if share.max_element() < LEAST {
                return Vec3::ZERO;
            }
            left -= t;
            let start = surface.start(&self.shading.searcher.scene, ray.direction());
            match Ray::new(start, ray.direction()) {
                Some(next) => ray = next,
                None => return share,
            }
        }
        Vec3::ZERO
    }

    /// Returns the share of light that comes through a surface, and through what is before it, and
    /// sets the bodies that the light is in.
    fn clarity(&self, ray: &Ray, surface: &Surface<'a>, t: f32, media: &mut Media) -> Vec3 {
        let material = surface.material;
        let effects = material.effects & self.shading.effects;
        let opacity = self.opacity(surface);
        if opacity <= LEAST {
            return Vec3::ONE;
        }
        if effects & effect::REFRACTION == 0 {
            return Vec3::ZERO;
        }
        let length = sqrt(ray.direction().dot(ray.direction()));
        let direction = ray.direction() / length;
        let cosine = direction.dot(surface.geometric_normal);
        let leaves = cosine > 0.0;
        let mut share = Vec3::ONE;
        if let Some(filling) = self.filling(*media, leaves.then_some(material))
            && filling.effects & self.shading.effects & effect::ABSORPTION != 0
        {
            let [r, g, b] = map3(filling.absorption, |a| libm::expf(-a * t * length));
            share = Vec3::new(r, g, b);
        }
        let border = self.shading.border(*media, material, leaves);
        let (thin, dense) = match border {
            Some(border) => {
                *media = border.after;
                if border.before == border.beyond {
                    return share;
                }
                let (before, beyond) = self.shading.indices(border, 0.0);
                (min(before, beyond), max(before, beyond))
            }
            None => (1.0, material.index_of_refraction),
        };
        share *= Vec3::from_array(material.transmission);
        share *= self.stain(surface, self.tint(surface, false), opacity);
        // Unbent light meets each border at the angle it has outside.
        let normal = surface.shading_normal * if leaves { -1.0 } else { 1.0 };
        share * refract(direction, normal, thin, dense).transmittance
    }
}
