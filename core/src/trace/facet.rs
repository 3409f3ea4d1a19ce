//! What is asked of a surface before it is lit.

use super::apart::MOST_LIGHTS;
use super::beam::SurfaceId;
use super::clearance::{Place, TrianglePlace};
use super::leaves::Leaves;
use super::map::{map_point, map_vector};
use super::shading::NOT_DULL;
use super::surface::{self, Surface};
use super::texture::{self, TEXTURES};
use super::tracer::Tracer;
use crate::numeric::{min, normalize};
use crate::scene::EffectSet;
use crate::scene::format::{Material, NO_COLOURS, NO_MATERIAL, NO_TEXTURE, effect, flag, kind};
use crate::shape::{Ray, Spheroid};
use crate::simd::{Runs, Simd};
use glam::Vec3;

/// Cosine between a triangle's normal and those of its corners above which it is flat.
const FLAT: f32 = 1.0 - 1.0e-5;
/// The same under which the triangle meets others at an edge.
const MOST_BENT: f32 = 0.65;

/// Where the colours of a surface may change within a pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Fineness {
    Nowhere,
    /// Where the pixel sees several facets.
    BetweenFacets,
    Everywhere,
}

/// A triangle in the room.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Facet<'a> {
    pub(crate) corners: [Vec3; 3],
    /// Unit length.
    pub(crate) normal: Vec3,
    /// Normals at the corners, of any length, where the surface is shaded smoothly.
    normals: Option<[Vec3; 3]>,
    pub(crate) material: &'a Material,
    /// Whether lights and ambient light alone say what it shows, apart from its texture.
    pub(crate) is_dull: bool,
    /// Whether what it shows takes neither coordinates nor colours of its corners, apart from the
    /// texture.
    pub(crate) is_plain: bool,
    pub(crate) texture: Option<(u32, [[f32; 2]; 3])>,
    place: Place<'a>,
}

impl<'a> Facet<'a> {
    pub(crate) fn is_flat(&self) -> bool {
        self.normals.is_none_or(|normals| {
            normals
                .iter()
                .all(|&own| normalize(own).is_some_and(|own| own.dot(self.normal) > FLAT))
        })
    }

    /// Returns the surface at a point, given by the weights of the corners.
    pub(crate) fn surface(&self, [a, b, c]: [f32; 3]) -> Surface<'a> {
        let between = |[p, q, r]: [Vec3; 3]| p * a + q * b + r * c;
        let point = between(self.corners);
        let shading_normal = self
            .normals
            .and_then(|normals| normalize(between(normals)))
            .filter(|own| own.dot(self.normal) > 0.0)
            .unwrap_or(self.normal);
        let normals = (self.normal, shading_normal);
        Surface::of_facet(point, normals, self.material, self.place)
    }

    /// Returns the surface at a point of its plane.
    pub(crate) const fn at(&self, point: Vec3) -> Surface<'a> {
        let normals = (self.normal, self.normal);
        Surface::of_facet(point, normals, self.material, self.place)
    }
}

impl<'a, const W: usize> Tracer<'a, W>
where
    Simd: Runs<W>,
{
    /// Returns whether lights have shadows.
    pub(crate) fn casts_shadows(&self) -> bool {
        self.searcher.effects.contains(EffectSet::SHADOWS)
    }

    /// Returns whether light comes through shadows.
    pub(crate) fn has_clear_shadows(&self) -> bool {
        let carried_out = self
            .searcher
            .effects
            .intersection(self.searcher.scene.effects());
        carried_out.contains(EffectSet::CLEAR_SHADOWS)
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

    /// Returns where a surface's colours may change within a pixel: by lines, by textures that are
    /// not averaged, by vertex colours.
    pub(crate) fn fineness(&self, id: &SurfaceId) -> Fineness {
        let Some(material) = self.material(id) else {
            return Fineness::Nowhere;
        };
        let effects = material.effects & self.searcher.effects.bits();
        let instance = self.searcher.scene.instances.get(id.instance as usize);
        let is_mesh = instance.is_some_and(|it| it.kind == kind::MESH);
        let is_textured = effects & TEXTURES != 0
            && (material.emission_texture != NO_TEXTURE
                || material.metal_texture != NO_TEXTURE
                || effects & effect::NORMAL_MAP != 0
                || material.texture != NO_TEXTURE && (effects & NOT_DULL != 0 || !is_mesh));
        if is_textured || effects & (effect::GRATICULE | effect::ALPHA) != 0 {
            Fineness::Everywhere
        } else if effects & effect::VERTEX_COLOURS != 0 {
            Fineness::BetweenFacets
        } else {
            Fineness::Nowhere
        }
    }

    /// Returns whether colours of a surface may change from a pixel to the next.
    pub(crate) fn is_busy(&self, id: &SurfaceId) -> bool {
        let scene = &self.searcher.scene;
        let Some(material) = self.material(id) else {
            return false;
        };
        let effects = material.effects & self.searcher.effects.bits();
        // Glass and flat mirrors show other things, which may be smaller than a pixel.
        let is_flat = || self.facet(id).is_some_and(|facet| facet.is_flat());
        let is_clear = effects & effect::REFRACTION != 0;
        if is_clear || effects & effect::REFLECTION != 0 && is_flat() {
            return true;
        }
        // Shadows on planes that are not drawn may be thinner than a pixel.
        let is_drawn = scene.lights.len() <= MOST_LIGHTS && !self.has_clear_shadows();
        if !is_drawn && self.casts_shadows() && is_flat() {
            return true;
        }
        self.fineness(id) != Fineness::Nowhere
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

    /// Returns which of six ways a triangle faces in its mesh, 1 to 6; 0 for one whose normals
    /// bend gently, and for other shapes.
    pub(crate) fn facing(&self, id: &SurfaceId) -> u8 {
        let scene = &self.searcher.scene;
        let facing = || {
            let instance = scene.instances.get(id.instance as usize)?;
            if instance.kind != kind::MESH {
                return None;
            }
            let mesh = scene.meshes.get(instance.geometry as usize)?;
            let [a, b, c] = Leaves::new(scene, mesh).leaf(id.leaf)?.triangle(id.lane)?.0;
            let normal = normalize((b - a).cross(c - a))?;
            if instance.flags & flag::SMOOTH != 0 && mesh.normal_count > 0 {
                let record = mesh.first_triangle.checked_add(id.triangle)?;
                let mut least = 1.0;
                for corner in scene.triangles.get(record as usize)?.corners {
                    let number = mesh.first_normal.checked_add(corner)?;
                    let own = normalize(Vec3::from_array(*scene.normals.get(number as usize)?))?;
                    least = min(least, own.dot(normal));
                }
                if least > MOST_BENT && least < FLAT {
                    return None;
                }
            }
            let [x, y, z] = normal.abs().to_array();
            let (axis, own) = match (x >= y && x >= z, y >= z) {
                (true, _) => (0, normal.x),
                (false, true) => (1, normal.y),
                (false, false) => (2, normal.z),
            };
            Some(1 + 2 * axis + u8::from(own < 0.0))
        };
        facing().unwrap_or(0)
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
        // Normalised first, since products of tiny triangles' edges underflow.
        let own = normalize((b - a).cross(c - a))?;
        let normal = surface::world_normal(instance, own)?;
        let mut normals = None;
        if instance.flags & flag::SMOOTH != 0 && mesh.normal_count > 0 {
            let mut own = [Vec3::ZERO; 3];
            for (own, &corner) in own.iter_mut().zip(&record.corners) {
                let number = mesh.first_normal.checked_add(corner)?;
                let normal = Vec3::from_array(*scene.normals.get(number as usize)?);
                *own = surface::mapped_normal(instance, normal);
            }
            normals = Some(own);
        }
        let material = self.material(id)?;
        let effects = material.effects & self.searcher.effects.bits();
        let is_coloured = effects & effect::VERTEX_COLOURS != 0 && mesh.first_colour != NO_COLOURS;
        let emits = effects & TEXTURES != 0 && material.emission_texture != NO_TEXTURE;
        let is_dull = effects & (NOT_DULL | effect::GRATICULE) == 0 && !is_coloured && !emits;
        let mut texture = None;
        let is_textured = effects & TEXTURES != 0 && mesh.coordinate_count > 0;
        let is_plain = is_dull || effects & effect::GRATICULE == 0 && !is_coloured && !is_textured;
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
            normals,
            material,
            is_dull,
            is_plain,
            texture,
            place: Place {
                instance,
                triangle: Some(TrianglePlace {
                    mesh,
                    record,
                    leaf: id.leaf,
                    lane: id.lane,
                }),
            },
        })
    }
}
