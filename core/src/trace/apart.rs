//! Light of primary hits apart from what is found for many of them at once: the colours of
//! textures, and which lights are seen.

use super::budget::Budget;
use super::hit::Hit;
use super::ledger::Record;
use super::sample::Sample;
use super::search::Searcher;
use super::shading::{PrimaryRay, light_of_facet, shade_and_record};
use super::tracer::Tracer;
use super::workspace::{Pixel, RayDetail, Workspace};
use crate::scene::format::Material;
use crate::shape::Ray;
use crate::simd::{Runs, Simd};
use glam::Vec3;

/// Most lights whose shadows are drawn.
pub(crate) const MOST_LIGHTS: usize = 4;

/// The diffuse light of a hit, and the texture that colours it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Apart {
    pub(crate) diffuse: Vec3,
    pub(crate) coat: Option<(u32, [f32; 2])>,
}

/// Light of a facet, as a whole and its diffuse part, which a texture colours.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Part {
    pub(crate) whole: Vec3,
    pub(crate) diffuse: Vec3,
}

/// Light of a facet: what it has in any case, and what it has of each light if that is seen.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Open {
    pub(crate) own: Part,
    pub(crate) sources: [Part; MOST_LIGHTS],
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

impl Record for Apart {
    const SPLITS: bool = true;

    #[inline(always)]
    fn coat(&mut self, texture: u32, place: [f32; 2]) {
        self.coat = Some((texture, place));
    }

    #[inline(always)]
    fn diffuse(&mut self, light: Vec3) {
        self.diffuse += light;
    }
}

impl Record for Open {
    const SPLITS: bool = true;

    #[inline(always)]
    fn diffuse(&mut self, light: Vec3) {
        self.own.diffuse += light;
    }

    #[inline(always)]
    fn source(&mut self, number: u32, whole: Vec3, diffuse: Vec3) -> bool {
        if let Some(source) = self.sources.get_mut(number as usize) {
            *source = Part { whole, diffuse };
        }
        true
    }
}

/// Shading that keeps parts apart, compiled for a set of effects: pointers.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ShadeApart<const W: usize> {
    tree: ShadeTree<W>,
    facet: ShadeFacet<W>,
}

type ShadeTree<const W: usize> = for<'r, 's> fn(
    &'r Searcher<'s, W>,
    &'r PrimaryRay<'r>,
    &'r mut Budget,
    &'r mut Workspace,
    &'r mut Apart,
) -> Pixel;

type ShadeFacet<const W: usize> = for<'r, 's> fn(
    &'r Searcher<'s, W>,
    &'r FacetPoint<'r>,
    &'r mut Budget,
    &'r mut Workspace,
    &'r mut Open,
);

/// A point of a facet, and the direction that it is seen in.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FacetPoint<'a> {
    pub(crate) point: Vec3,
    pub(crate) normal: Vec3,
    pub(crate) material: &'a Material,
    pub(crate) direction: Vec3,
}

impl<const W: usize> ShadeApart<W>
where
    Simd: Runs<W>,
{
    pub(crate) fn for_effects<const EFFECTS: u32>() -> Self {
        Self {
            tree: |searcher, primary, budget, workspace, apart| {
                shade_and_record::<W, EFFECTS, Apart>(searcher, primary, budget, workspace, apart)
            },
            facet: |searcher, at, budget, workspace, open| {
                open.own.whole =
                    light_of_facet::<W, EFFECTS, Open>(searcher, at, budget, workspace, open);
            },
        }
    }
}

impl<const W: usize> Tracer<'_, W>
where
    Simd: Runs<W>,
{
    /// Returns the light of a hit, without the colour of the texture of a dull surface.
    pub(crate) fn light_apart(
        &self,
        shade: &ShadeApart<W>,
        (ray, hit): (&Ray, Hit),
        (detail, sample): (RayDetail, Sample),
        budget: &mut Budget,
        workspace: &mut Workspace,
    ) -> (Pixel, Apart) {
        workspace.statistics.lit += 1;
        let mut apart = Apart {
            diffuse: Vec3::ZERO,
            coat: None,
        };
        let primary = PrimaryRay {
            ray,
            hit,
            detail,
            sample,
        };
        let pixel = (shade.tree)(&self.searcher, &primary, budget, workspace, &mut apart);
        (pixel, apart)
    }

    /// Returns the light of a point of a facet.
    pub(crate) fn light_of_facet(
        &self,
        shade: &ShadeApart<W>,
        at: &FacetPoint<'_>,
        budget: &mut Budget,
        workspace: &mut Workspace,
    ) -> Open {
        workspace.statistics.lit += 1;
        let mut open = Open::default();
        (shade.facet)(&self.searcher, at, budget, workspace, &mut open);
        open
    }
}
