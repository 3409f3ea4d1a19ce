//! What a surface sends back of light from lights, and its own.

use super::microfacet::Lobe;
use super::{ENVIRONMENT, RayTree, above, place};
use crate::numeric::normalize;
use crate::scene::EffectSet;
use crate::scene::format::{Light, NO_TEXTURE, Texture, effect, light};
use crate::shape::Ray;
use crate::simd::{Runs, Simd};
use crate::trace::background;
use crate::trace::environment;
use crate::trace::ledger::Record;
use crate::trace::optics::reflect;
use crate::trace::soft_light::{Points, Rectangle};
use crate::trace::surface::Surface;
use crate::trace::texture::{self, TEXTURES};
use glam::Vec3;

const SPOT_LIGHT: u32 = EffectSet::SPOT_LIGHT.bits();

/// Effects of surfaces whose light is not their texture's colour times what falls on them.
pub(in crate::trace) const NOT_DULL: u32 = effect::REFLECTION
    | effect::REFRACTION
    | effect::MICROFACETS
    | effect::ALPHA
    | effect::NORMAL_MAP;

impl<const W: usize, const EFFECTS: u32, R: Record> RayTree<'_, '_, W, EFFECTS, R>
where
    Simd: Runs<W>,
{
    /// Returns a surface's own light and that of lights.
    #[inline(always)]
    pub(super) fn own_light(
        &mut self,
        surface: &Surface<'_>,
        look: &Look,
        incidence: Incidence,
    ) -> Vec3 {
        let material = surface.material;
        let effects = material.effects & self.shading.effects;
        let mut light = Vec3::ZERO;
        if material.effects & effect::LIT != 0 {
            light = self.lit(&Lighting {
                surface,
                look,
                incidence,
            });
        }
        if Self::has(effect::MICROFACETS)
            && (effects & effect::REFRACTION == 0 || self.is_veil(material))
            && let Some(lobe) = &look.lobe
        {
            light += self.surroundings(surface, lobe, incidence);
        }
        let outside = incidence.facing > 0.0;
        if Self::has(effect::EMISSION) && effects & effect::EMISSION != 0 && outside {
            light += self.emission(surface) * self.opacity(surface);
        }
        light
    }

    /// Returns what a rough surface mirrors: the background, blurred to the lobe, or ambient light
    /// where that is brighter.
    fn surroundings(&mut self, surface: &Surface<'_>, lobe: &Lobe, incidence: Incidence) -> Vec3 {
        let share = 1.0 - lobe.sharpness();
        if share <= 0.0 {
            return Vec3::ZERO;
        }
        let outside = surface.geometric_normal * incidence.facing;
        let mirrored = above(reflect(incidence.direction, incidence.normal), outside);
        let scene = &self.shading.searcher.scene;
        let blurred = if self.shading.is_asked(ENVIRONMENT) {
            self.record.touch(ENVIRONMENT);
            environment::blurred(scene, mirrored, lobe.roughness)
        } else {
            background::blurred(scene.background(), mirrored, lobe.roughness)
        };
        let ambient = Vec3::from_array(scene.header.ambient);
        lobe.albedo * blurred.max(ambient) * share
    }

    /// Returns a surface's own light, in the colours of its texture, and of its vertices where it
    /// has nothing else to colour.
    #[inline(always)]
    fn emission(&self, surface: &Surface<'_>) -> Vec3 {
        let emission = Vec3::from_array(surface.material.emission);
        let emission = self.textured(emission, surface, surface.material.emission_texture);
        if Self::has(effect::VERTEX_COLOURS) && surface.material.diffuse == [0.0; 3] {
            emission * surface.colour
        } else {
            emission
        }
    }

    /// Returns a colour times that of a texture.
    #[inline(always)]
    fn textured(&self, colour: Vec3, surface: &Surface<'_>, texture: u32) -> Vec3 {
        let effects = surface.material.effects & self.shading.effects;
        if Self::has(TEXTURES) && effects & TEXTURES != 0 && texture != NO_TEXTURE {
            let (scene, at) = (&self.shading.searcher.scene, &surface.coordinates);
            let extent = |texture: &Texture, is_second| {
                let gradients = surface.gradients(scene, is_second);
                texture::extent(texture, gradients, self.footprint)
            };
            colour * texture::colour::<W, EFFECTS>(scene, texture, effects, at, extent)
        } else {
            colour
        }
    }

    /// Returns the outward normal that a surface is lit by: bent where it has a normal map.
    #[inline(always)]
    pub(super) fn normal(&self, surface: &Surface<'_>) -> Vec3 {
        const MAPPED: u32 = effect::NORMAL_MAP | effect::IMAGE_TEXTURE;
        let material = surface.material;
        let effects = material.effects & self.shading.effects;
        if EFFECTS & MAPPED != MAPPED || effects & MAPPED != MAPPED {
            return surface.shading_normal;
        }
        let texel = self.textured(Vec3::splat(2.0), surface, material.normal_texture) - Vec3::ONE;
        let texel = texel * Vec3::new(material.normal_scale, material.normal_scale, 1.0);
        let bent = surface.bent(&self.shading.searcher.scene, texel);
        bent.unwrap_or(surface.shading_normal)
    }

    /// Returns the colours of a surface at a point, with its textures.
    #[inline(always)]
    pub(super) fn look(
        &mut self,
        surface: &Surface<'_>,
        incidence: Incidence,
        is_primary: bool,
    ) -> Look {
        let material = surface.material;
        let effects = material.effects & self.shading.effects;
        let is_apart = R::SPLITS && is_primary && self.coat(surface);
        let tint = self.tint(surface, is_apart);
        let diffuse = Vec3::from_array(material.diffuse) * tint;
        let opacity = self.opacity(surface);
        let (diffuse, stain) = (diffuse * opacity, self.stain(surface, tint, opacity));
        let specular = Vec3::from_array(material.specular) * opacity;
        let mirror = Vec3::from_array(material.mirror);
        let plain = Look {
            diffuse,
            specular,
            shininess: material.shininess,
            lobe: None,
            mirror,
            stain,
            is_primary,
        };
        if !Self::has(effect::MICROFACETS) || effects & effect::MICROFACETS == 0 {
            return plain;
        }
        let factors = Vec3::new(0.0, material.roughness, material.metalness);
        let factors = self.textured(factors, surface, material.metal_texture);
        let (metal, roughness) = (factors.z, factors.y);
        let tint = diffuse * metal;
        let cosine = -incidence.normal.dot(incidence.direction);
        let lobe = Lobe::new(specular * (1.0 - metal) + tint, roughness, cosine);
        Look {
            // What is reflected does not get to what scatters.
            diffuse: (diffuse - tint) * (Vec3::ONE - lobe.albedo),
            mirror: lobe.albedo * lobe.sharpness(),
            lobe: Some(lobe),
            ..plain
        }
    }

    /// Returns the colour that a surface gives to what it lets through, by its own tint and opacity.
    #[inline(always)]
    pub(super) fn stain(&self, surface: &Surface<'_>, tint: Vec3, opacity: f32) -> Vec3 {
        let effects = surface.material.effects & self.shading.effects;
        if Self::has(effect::ALPHA) && effects & effect::ALPHA != 0 {
            Vec3::splat(1.0 - opacity)
        } else if surface.material.index_of_refraction == 1.0 {
            // A veil.
            Vec3::ONE
        } else {
            tint
        }
    }

    /// Hands the texture of a dull surface over; false if it has none.
    #[inline(always)]
    fn coat(&mut self, surface: &Surface<'_>) -> bool {
        let material = surface.material;
        let effects = material.effects & self.shading.effects;
        let is_dull = effects & NOT_DULL == 0;
        if !is_dull || effects & TEXTURES == 0 || material.texture == NO_TEXTURE {
            return false;
        }
        let scene = &self.shading.searcher.scene;
        let place = texture::place(scene, material.texture, &surface.coordinates);
        if let Some(place) = place {
            self.record.coat(material.texture, place);
        }
        place.is_some()
    }

    /// Returns the colour that a surface has from its texture, unless that is kept apart, and its
    /// vertices.
    #[inline(always)]
    pub(super) fn tint(&self, surface: &Surface<'_>, is_apart: bool) -> Vec3 {
        let tint = if R::SPLITS && is_apart {
            Vec3::ONE
        } else {
            self.textured(Vec3::ONE, surface, surface.material.texture)
        };
        if Self::has(effect::VERTEX_COLOURS) {
            tint * surface.colour
        } else {
            tint
        }
    }

    /// Returns light from lights: ambient, Lambert, and Blinn-Phong (Blinn 1977) or microfacets.
    fn lit(&mut self, at: &Lighting<'_, '_>) -> Vec3 {
        let scene = &self.shading.searcher.scene;
        let mut sum = Vec3::from_array(scene.header.ambient) * at.look.diffuse;
        if R::SPLITS && at.look.is_primary {
            self.record.diffuse(sum);
        }
        for (number, source) in (0..).zip(scene.lights) {
            if source.is_large() {
                sum += self.lit_by_rectangle(at, number, source);
                continue;
            }
            let place = Vec3::from_array(source.place);
            let (to_light, from) = if source.kind == light::DIRECTIONAL {
                (place, None)
            } else {
                (place - at.surface.point, Some(place))
            };
            let Some((unit, cosine)) = at.sees(to_light) else {
                continue;
            };
            let mut colour = Vec3::from_array(source.colour);
            if source.kind == light::POINT_INVERSE_SQUARE {
                colour /= to_light.dot(to_light);
            }
            if Self::has(SPOT_LIGHT) && self.shading.effects & SPOT_LIGHT != 0 && source.is_spot() {
                self.record.touch(SPOT_LIGHT);
                let share = source.share(unit);
                if share == 0.0 {
                    continue;
                }
                colour *= share;
            }
            if R::SPLITS && at.look.is_primary && !self.has_clear_shadows() {
                let diffuse = colour * (at.look.diffuse * cosine);
                if self
                    .record
                    .source(number, colour * at.answer::<EFFECTS>(unit, cosine), diffuse)
                {
                    continue;
                }
            }
            let Some((ray, limit)) = at.surface.ray_to(scene, unit, at.incidence.facing, from)
            else {
                continue;
            };
            let Some(share) = self.light_along(&ray, limit, EffectSet::SHADOWS) else {
                continue;
            };
            colour *= share;
            sum += colour * at.answer::<EFFECTS>(unit, cosine);
            if R::SPLITS && at.look.is_primary {
                self.record.diffuse(colour * (at.look.diffuse * cosine));
            }
        }
        sum
    }

    /// Returns the mean over points of a rectangle; its middle alone without soft light.
    fn lit_by_rectangle(&mut self, at: &Lighting<'_, '_>, number: u32, source: &Light) -> Vec3 {
        const SOFT_LIGHT: u32 = EffectSet::SOFT_LIGHT.bits();
        let Some(rectangle) = Rectangle::new(source) else {
            return Vec3::ZERO;
        };
        let (sample, effects) = (self.shading.sample, self.shading.effects);
        let scene = &self.shading.searcher.scene;
        let points = (Self::has(SOFT_LIGHT) && effects & SOFT_LIGHT != 0)
            .then(|| Points::new(sample.seed(), number));
        let count = match points {
            Some(_) => {
                self.record.touch(SOFT_LIGHT);
                source.samples
            }
            None => 1,
        };
        let first = u32::from(sample.index) * count;
        let mut sum = Vec3::ZERO;
        for point in first..first + count {
            let on_square = points.map_or([0.0; 2], |points| points.point(point));
            let place = rectangle.place(on_square);
            let to_light = place - at.surface.point;
            let Some((unit, cosine)) = at.sees(to_light) else {
                continue;
            };
            let irradiance = rectangle.irradiance(to_light, unit);
            if irradiance <= 0.0 {
                continue;
            }
            let Some((ray, limit)) =
                at.surface
                    .ray_to(scene, unit, at.incidence.facing, Some(place))
            else {
                continue;
            };
            // One ray would be there without.
            let cause = if point == first {
                EffectSet::SHADOWS
            } else {
                EffectSet::SOFT_LIGHT
            };
            if let Some(share) = self.light_along(&ray, limit, cause) {
                sum += at.answer::<EFFECTS>(unit, cosine) * irradiance * share;
                if R::SPLITS && at.look.is_primary {
                    let share = share * (irradiance / count as f32);
                    let diffuse = at.look.diffuse * cosine * share;
                    self.record
                        .diffuse(Vec3::from_array(source.colour) * diffuse);
                }
            }
        }
        Vec3::from_array(source.colour) * (sum / count as f32)
    }

    /// Returns the share of light that gets to a place, `None` in full shadow: by a ray for `cause`.
    #[inline]
    fn light_along(&mut self, ray: &Ray, limit: f32, cause: EffectSet) -> Option<Vec3> {
        const SHADOWS: u32 = EffectSet::SHADOWS.bits();
        if !Self::has(SHADOWS) || self.shading.effects & SHADOWS == 0 {
            return Some(Vec3::ONE);
        }
        if self.has_clear_shadows() {
            self.record.touch(SHADOWS);
            let share = self.let_by(ray, limit, cause.bits());
            return (share != Vec3::ZERO).then_some(share);
        }
        let (searcher, rung) = (self.shading.searcher, self.shading.detail.rung);
        let (budget, workspace) = (&mut *self.budget, &mut *self.workspace);
        let before = workspace.statistics.steps;
        let is_shadowed = searcher.is_occluded_on(rung, ray, limit, budget, workspace);
        self.record.touch(SHADOWS);
        let steps = workspace.statistics.steps - before;
        self.record.ray(place(cause.bits()), steps);
        (!is_shadowed).then_some(Vec3::ONE)
    }
}

/// A surface as light from lights finds it.
struct Lighting<'s, 'a> {
    surface: &'s Surface<'a>,
    look: &'s Look,
    incidence: Incidence,
}

/// The colours of a surface at a point.
pub(super) struct Look {
    diffuse: Vec3,
    specular: Vec3,
    shininess: f32,
    /// Instead of `specular` and `shininess`.
    lobe: Option<Lobe>,
    pub(super) mirror: Vec3,
    /// Colour that its texture and its vertices give to what it lets through.
    pub(super) stain: Vec3,
    is_primary: bool,
}

/// How a ray meets a surface.
#[derive(Clone, Copy)]
pub(super) struct Incidence {
    /// Direction of the ray, unit length.
    pub(super) direction: Vec3,
    /// Shading normal on the ray's side, unit length.
    pub(super) normal: Vec3,
    /// −1 if the ray arrives from inside, else 1.
    pub(super) facing: f32,
}

impl Lighting<'_, '_> {
    /// Returns the unit vector to a light and its cosine, where it is on the ray's side.
    #[inline(always)]
    fn sees(&self, to_light: Vec3) -> Option<(Vec3, f32)> {
        let unit = normalize(to_light)?;
        let cosine = self.incidence.normal.dot(unit);
        (cosine > 0.0).then_some((unit, cosine))
    }

    /// Returns what it sends back along the ray of irradiance 1 from a direction.
    #[inline(always)]
    fn answer<const EFFECTS: u32>(&self, unit: Vec3, cosine: f32) -> Vec3 {
        if EFFECTS & effect::MICROFACETS != 0
            && let Some(lobe) = &self.look.lobe
        {
            let Incidence {
                normal, direction, ..
            } = self.incidence;
            let reflected = lobe.answer(normal, direction, (unit, cosine));
            return self.look.diffuse * cosine + reflected;
        }
        let specular = self.look.specular;
        let mut answer = self.look.diffuse * cosine;
        if specular != Vec3::ZERO
            && let Some(half) = normalize(unit - self.incidence.direction)
        {
            answer += specular * highlight(self.incidence.normal.dot(half), self.look.shininess);
        }
        answer
    }
}

/// Blinn-Phong's cosⁿ, or 0 under e⁻¹⁶.
fn highlight(cosine: f32, shininess: f32) -> f32 {
    if cosine <= 0.0 || shininess * (1.0 - cosine) > 16.0 {
        0.0
    } else {
        libm::powf(cosine, shininess)
    }
}
