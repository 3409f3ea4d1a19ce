//! Light of primary hits apart from what is found for many of them at once: the colours of
//! textures, and which lights are seen.

use super::beam::SurfaceId;
use super::budget::Budget;
use super::hit::Hit;
use super::leaves::Leaves;
use super::ledger::Record;
use super::map::{map_point, map_vector};
use super::sample::Sample;
use super::search::Searcher;
use super::shading::{NOT_DULL, PrimaryRay, light_of_facet, shade_and_record};
use super::surface;
use super::texture::{self, TEXTURES};
use super::tracer::Tracer;
use super::workspace::{Pixel, RayDetail, Workspace};
use crate::scene::EffectSet;
use crate::scene::format::{Material, NO_COLOURS, NO_MATERIAL, NO_TEXTURE, effect, flag, kind};
use crate::shape::{Ray, Spheroid};
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
    fn touch(&mut self, _: u32) {}

    #[inline(always)]
    fn ray(&mut self, _: u8, _: u64) {}

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
    fn touch(&mut self, _: u32) {}

    #[inline(always)]
    fn ray(&mut self, _: u8, _: u64) {}

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

/// A triangle in the room.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Facet<'a> {
    pub(crate) corners: [Vec3; 3],
    /// Unit length.
    pub(crate) normal: Vec3,
    pub(crate) is_flat: bool,
    pub(crate) material: &'a Material,
    /// Whether lights and ambient light alone say what it shows, apart from its texture.
    pub(crate) is_dull: bool,
    pub(crate) texture: Option<(u32, [[f32; 2]; 3])>,
}

impl<'a, const W: usize> Tracer<'a, W>
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

    /// Returns whether lights have shadows.
    pub(crate) fn casts_shadows(&self) -> bool {
        self.searcher.effects.contains(EffectSet::SHADOWS)
    }

    /// Returns where a ray meets a spheroid; `None` of other shapes, and past it.
    pub(crate) fn on_spheroid(&self, instance: u32, ray: &Ray) -> Option<f32> {
        let instance = self.searcher.scene.instances.get(instance as usize)?;
        if instance.kind != kind::SPHEROID {
            return None;
        }
        let ray = Ray::new(
            map_point(&instance.object_from_world, ray.origin()),
            map_vector(&instance.object_from_world, ray.direction()),
        )?;
        let hits = Spheroid::of_checked(instance.radii).intersect(&ray)?;
        hits.t.into_iter().find(|t| *t > 0.0)
    }

    /// Returns whether colours of a surface may change from a pixel to the next.
    pub(crate) fn is_busy(&self, id: &SurfaceId) -> bool {
        let scene = &self.searcher.scene;
        let Some(material) = self.material(id.instance, id.triangle) else {
            return false;
        };
        let effects = material.effects & self.searcher.effects.bits();
        let is_mesh = scene
            .instances
            .get(id.instance as usize)
            .is_some_and(|it| it.kind == kind::MESH);
        let changes = effect::GRATICULE | effect::VERTEX_COLOURS;
        effects & changes != 0
            || effects & TEXTURES != 0
                && (material.emission_texture != NO_TEXTURE
                    || material.metal_texture != NO_TEXTURE
                    || material.texture != NO_TEXTURE && (effects & NOT_DULL != 0 || !is_mesh))
    }

    /// Returns the material of a triangle of a mesh, or of another shape.
    pub(crate) fn material(&self, instance: u32, triangle: u32) -> Option<&'a Material> {
        let scene = &self.searcher.scene;
        let instance = scene.instances.get(instance as usize)?;
        let number = if instance.material == NO_MATERIAL {
            let mesh = scene.meshes.get(instance.geometry as usize)?;
            let record = mesh.first_triangle.checked_add(triangle)?;
            scene.triangles.get(record as usize)?.material
        } else {
            instance.material
        };
        scene.materials.get(number as usize)
    }

    /// Returns a triangle of an instance in the room.
    pub(crate) fn facet(&self, hit: &Hit) -> Option<Facet<'a>> {
        let scene = &self.searcher.scene;
        let instance = scene.instances.get(hit.instance as usize)?;
        if instance.kind != kind::MESH {
            return None;
        }
        let mesh = scene.meshes.get(instance.geometry as usize)?;
        let triangle = Leaves::new(scene, mesh)
            .leaf(hit.on.leaf)?
            .triangle(hit.on.lane)?;
        let record = mesh.first_triangle.checked_add(hit.on.triangle)?;
        let record = scene.triangles.get(record as usize)?;
        let corners = triangle
            .0
            .map(|p| map_point(&instance.world_from_object, p));
        let [a, b, c] = triangle.0;
        let normal = surface::world_normal(instance, (b - a).cross(c - a))?;
        let is_flat = instance.flags & flag::SMOOTH == 0
            || mesh.normal_count == 0
            || record.corners.iter().all(|&corner| {
                let number = mesh.first_normal.checked_add(corner);
                let own = number.and_then(|number| scene.normals.get(number as usize));
                own.and_then(|&own| surface::world_normal(instance, Vec3::from_array(own)))
                    .is_some_and(|own| own.dot(normal) > 1.0 - 1.0e-5)
            });
        let material = self.material(hit.instance, hit.on.triangle)?;
        let effects = material.effects & self.searcher.effects.bits();
        let is_coloured = effects & effect::VERTEX_COLOURS != 0 && mesh.first_colour != NO_COLOURS;
        let emits = effects & TEXTURES != 0 && material.emission_texture != NO_TEXTURE;
        let is_dull = effects & (NOT_DULL | effect::GRATICULE) == 0 && !is_coloured && !emits;
        let mut texture = None;
        let is_textured = effects & TEXTURES != 0 && mesh.coordinate_count > 0;
        if is_dull && is_textured && material.texture != NO_TEXTURE {
            let mut places = [[0.0; 2]; 3];
            for (place, weights) in
                places
                    .iter_mut()
                    .zip([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
            {
                let coordinates = surface::coordinates(scene, mesh, record, weights)?;
                *place = texture::place(scene, material.texture, &coordinates)?;
            }
            texture = Some((material.texture, places));
        }
        Some(Facet {
            corners,
            normal,
            is_flat,
            material,
            is_dull,
            texture,
        })
    }
}
