//! What is asked of a surface before it is lit.

use super::beam::SurfaceId;
use super::leaves::Leaves;
use super::map::{map_point, map_vector};
use super::shading::NOT_DULL;
use super::surface;
use super::texture::{self, TEXTURES};
use super::tracer::Tracer;
use crate::scene::EffectSet;
use crate::scene::format::{Material, NO_COLOURS, NO_MATERIAL, NO_TEXTURE, effect, flag, kind};
use crate::shape::{Ray, Spheroid};
use crate::simd::{Runs, Simd};
use glam::Vec3;

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
        let Some(material) = self.material(id) else {
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
    pub(crate) fn material(&self, id: &SurfaceId) -> Option<&'a Material> {
        let scene = &self.searcher.scene;
        let instance = scene.instances.get(id.instance as usize)?;
        let number = if instance.material == NO_MATERIAL {
            let mesh = scene.meshes.get(instance.geometry as usize)?;
            let record = mesh.first_triangle.checked_add(id.triangle)?;
            scene.triangles.get(record as usize)?.material
        } else {
            instance.material
        };
        scene.materials.get(number as usize)
    }

    /// Returns a triangle of an instance in the room.
    pub(crate) fn facet(&self, id: &SurfaceId) -> Option<Facet<'a>> {
        let scene = &self.searcher.scene;
        let instance = scene.instances.get(id.instance as usize)?;
        if instance.kind != kind::MESH {
            return None;
        }
        let mesh = scene.meshes.get(instance.geometry as usize)?;
        let triangle = Leaves::new(scene, mesh).leaf(id.leaf)?.triangle(id.lane)?;
        let record = mesh.first_triangle.checked_add(id.triangle)?;
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
        let material = self.material(id)?;
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
