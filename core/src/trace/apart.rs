//! Light of primary hits apart from what is found for many of them at once: the colours of
//! textures, and which lights are seen.

use super::budget::Budget;
use super::hit::Hit;
use super::ledger::Record;
use super::search::Searcher;
use super::shading::{Met, shade_met};
use super::surface::Surface;
use super::tracer::Tracer;
use super::workspace::{Pixel, Workspace};
use crate::numeric::normalize;
use crate::scene::format::light;
use crate::shape::Ray;
use crate::simd::{Runs, Simd};
use glam::Vec3;

/// Most lights that are kept apart: the first ones.
pub(crate) const MOST_LIGHTS: usize = 4;

/// Light as a whole, and its diffuse part, which a texture colours.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Part {
    pub(crate) whole: Vec3,
    pub(crate) diffuse: Vec3,
}

/// Light of a point: what it has in any case, and what it has of each light if nothing is between.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Open {
    pub(crate) own: Part,
    pub(crate) sources: [Part; MOST_LIGHTS],
    /// The texture of a dull surface, whose colour the diffuse light does not have, and the place
    /// on it.
    pub(crate) coat: Option<(u32, [f32; 2])>,
}

impl Part {
    #[inline(always)]
    pub(crate) fn between(&self, other: &Self, share: f32) -> Self {
        Self {
            whole: self.whole + (other.whole - self.whole) * share,
            diffuse: self.diffuse + (other.diffuse - self.diffuse) * share,
        }
    }

    #[inline(always)]
    pub(crate) fn and(&self, other: &Self) -> Self {
        Self {
            whole: self.whole + other.whole,
            diffuse: self.diffuse + other.diffuse,
        }
    }

    #[inline(always)]
    pub(crate) fn times(&self, count: f32) -> Self {
        Self {
            whole: self.whole * count,
            diffuse: self.diffuse * count,
        }
    }
}

impl Record for Open {
    const SPLITS: bool = true;

    #[inline(always)]
    fn coat(&mut self, texture: u32, place: [f32; 2]) {
        self.coat = Some((texture, place));
    }

    #[inline(always)]
    fn diffuse(&mut self, light: Vec3) {
        self.own.diffuse += light;
    }

    #[inline(always)]
    fn source(&mut self, number: u32, whole: Vec3, diffuse: Vec3) -> bool {
        let source = self.sources.get_mut(number as usize);
        source
            .map(|source| *source = Part { whole, diffuse })
            .is_some()
    }
}

/// Shading that keeps parts apart, compiled for a set of effects: pointers.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ShadeApart<const W: usize> {
    surface: FindSurface<W>,
    shade: Shade<W>,
}

type FindSurface<const W: usize> =
    for<'r, 's> fn(&'r Searcher<'s, W>, &'r Ray, &'r Hit) -> Option<Surface<'s>>;

type Shade<const W: usize> = for<'r, 's> fn(
    &'r Searcher<'s, W>,
    &'r Met<'r, 's>,
    &'r mut Budget,
    &'r mut Workspace,
    &'r mut Open,
) -> Pixel;

impl<const W: usize> ShadeApart<W>
where
    Simd: Runs<W>,
{
    pub(crate) fn for_effects<const EFFECTS: u32>() -> Self {
        Self {
            surface: |searcher, ray, hit| {
                let effects = searcher.effects.bits();
                Surface::new::<W, EFFECTS>(&searcher.scene, ray, hit, effects)
            },
            shade: |searcher, met, budget, workspace, open| {
                shade_met::<W, EFFECTS, Open>(searcher, met, budget, workspace, open)
            },
        }
    }
}

impl<'a, const W: usize> Tracer<'a, W>
where
    Simd: Runs<W>,
{
    /// Returns the surface at a hit.
    pub(crate) fn surface(
        &self,
        shade: &ShadeApart<W>,
        ray: &Ray,
        hit: &Hit,
    ) -> Option<Surface<'a>> {
        (shade.surface)(&self.searcher, ray, hit)
    }

    /// Returns the light of a surface that a primary ray meets: what it has in any case, and the
    /// same in parts.
    pub(crate) fn light_apart(
        &self,
        shade: &ShadeApart<W>,
        met: &Met<'_, 'a>,
        budget: &mut Budget,
        workspace: &mut Workspace,
    ) -> (Pixel, Open) {
        workspace.statistics.lit += 1;
        let mut open = Open::default();
        let pixel = (shade.shade)(&self.searcher, met, budget, workspace, &mut open);
        open.own.whole = Vec3::new(pixel.red, pixel.green, pixel.blue);
        (pixel, open)
    }

    /// Returns whether nothing is between a surface and one of the lights.
    pub(crate) fn is_reached(
        &self,
        met: &Met<'_, '_>,
        number: usize,
        budget: &mut Budget,
        workspace: &mut Workspace,
    ) -> bool {
        let Some(source) = self.searcher.scene.lights.get(number) else {
            return false;
        };
        if !self.casts_shadows() {
            return true;
        }
        let scene = &self.searcher.scene;
        let place = Vec3::from_array(source.place);
        let is_inside = met.ray.direction().dot(met.surface.geometric_normal) > 0.0;
        let facing = if is_inside { -1.0 } else { 1.0 };
        let ray = if source.kind == light::DIRECTIONAL {
            normalize(place).and_then(|unit| met.surface.ray_to(scene, unit, facing, None))
        } else {
            let unit = normalize(place - met.surface.point);
            unit.and_then(|unit| met.surface.ray_to(scene, unit, facing, Some(place)))
        };
        ray.is_some_and(|(ray, limit)| {
            let rung = met.detail.rung;
            !self
                .searcher
                .is_occluded_on(rung, &ray, limit, budget, workspace)
        })
    }
}
