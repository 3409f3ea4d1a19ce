//! The surface at a hit: exact point, normals, material.

use super::clearance::{Place, TrianglePlace};
use super::graticule;
use super::hit::{Hit, MeshHit};
use super::leaves::Leaves;
use super::map::{map_point, map_vector};
use super::texture::{self, TEXTURES};
use crate::numeric::{map3, min, normalize};
use crate::scene::Scene;
use crate::scene::format::{
    Instance, Material, Mesh, NO_COLOURS, NO_MATERIAL, Triangle, effect, flag, kind,
};
use crate::shape::{Ray, Spheroid};
use glam::Vec3;

#[derive(Clone, Copy)]
pub(crate) struct Surface<'a> {
    /// On the surface to rounding: computed from the corners' weights, not from the ray.
    pub(super) point: Vec3,
    /// Outward normal of the true shape, unit length.
    pub(super) geometric_normal: Vec3,
    /// Outward normal, interpolated where the instance asks for it, unit length.
    pub(super) shading_normal: Vec3,
    pub(super) material: &'a Material,
    /// First and second coordinates on textures; 0 without a texture or its effect.
    pub(super) coordinates: [[f32; 2]; 2],
    /// Colour of the vertices; white without.
    pub(super) colour: Vec3,
    /// `None` of what no ray leaves.
    place: Option<Place<'a>>,
}

/// Cosine between a triangle's normal and a light under which its shadow rays start on the bent
/// surface that the mesh stands for: gradually, so that shadows have no border there.
const GRAZING: f32 = 0.1;

impl<'a> Surface<'a> {
    /// Returns the normal and a point of the plane that touches the true shape.
    pub(crate) const fn tangent(&self) -> (Vec3, Vec3) {
        (self.geometric_normal, self.point)
    }

    /// Returns the surface at a hit; `effects` are bits of the effects to consider. `None` only if
    /// the scene's bytes are inconsistent.
    pub(super) fn new<const W: usize, const EFFECTS: u32>(
        scene: &Scene<'a, W>,
        ray: &Ray,
        hit: &Hit,
        effects: u32,
    ) -> Option<Self> {
        let effects = effects & EFFECTS;
        let instance = scene.instances.get(hit.instance as usize)?;
        let object_ray = Ray::new(
            map_point(&instance.object_from_world, ray.origin()),
            map_vector(&instance.object_from_world, ray.direction()),
        )?;
        let local = if instance.kind == kind::MESH {
            Local::of_mesh::<W, EFFECTS>(scene, instance, &object_ray, &hit.on, effects)?
        } else {
            Local::of_spheroid::<W, EFFECTS>(scene, instance, &object_ray, &hit.on, effects)?
        };
        let point = map_point(&instance.world_from_object, local.point);
        if graticule::is_between::<EFFECTS>(effects, local.material, local.point) {
            return Some(Self::between_lines(point));
        }
        // A triangle without area is hit only where it closes a seam of its mesh: whichever way
        // it faces, it shows light and not the background.
        let geometric_normal =
            world_normal(instance, local.normal).or_else(|| normalize(-ray.direction()))?;
        let shading_normal = local
            .smooth
            .and_then(|smooth| world_normal(instance, smooth))
            .filter(|n| n.dot(geometric_normal) > 0.0)
            .unwrap_or(geometric_normal);
        Some(Self {
            point,
            geometric_normal,
            shading_normal,
            material: local.material,
            coordinates: local.coordinates,
            colour: local.colour,
            place: Some(Place {
                instance,
                triangle: local.triangle,
            }),
        })
    }

    /// Returns the surface at a point of a facet, without coordinates.
    pub(super) const fn of_facet(
        point: Vec3,
        (geometric_normal, shading_normal): (Vec3, Vec3),
        material: &'a Material,
        place: Place<'a>,
    ) -> Self {
        Self {
            point,
            geometric_normal,
            shading_normal,
            material,
            coordinates: [[0.0; 2]; 2],
            colour: Vec3::ONE,
            place: Some(place),
        }
    }

    /// Returns a black, opaque surface, which no ray leaves.
    fn between_lines(point: Vec3) -> Self {
        Self {
            point,
            geometric_normal: Vec3::Y,
            shading_normal: Vec3::Y,
            material: &graticule::BETWEEN,
            coordinates: [[0.0; 2]; 2],
            colour: Vec3::ONE,
            place: None,
        }
    }

    /// Returns where a ray towards `direction` starts, clear of this surface.
    #[inline]
    pub(super) fn start<const W: usize>(&self, scene: &Scene<'a, W>, direction: Vec3) -> Vec3 {
        let distance = self.clearance(scene, direction);
        let side = if direction.dot(self.geometric_normal) >= 0.0 {
            distance
        } else {
            -distance
        };
        self.point + self.geometric_normal * side
    }

    /// Returns a ray to a light in a direction or at a place, and the light's distance along it;
    /// `facing` is −1 where the surface is seen from inside, else 1.
    ///
    /// Where a light grazes the triangles of a smooth mesh the ray starts on the bent surface that
    /// they stand for (Hanika 2021, "Hacking the Shadow Terminator"): triangles that face away from
    /// the light do not shade what the normals of their corners say is lit.
    #[inline(always)]
    pub(super) fn ray_to<const W: usize>(
        &self,
        scene: &Scene<'a, W>,
        unit: Vec3,
        facing: f32,
        place: Option<Vec3>,
    ) -> Option<(Ray, f32)> {
        let outside = self.geometric_normal * facing;
        let mut start = self.point + outside * self.clearance(scene, unit);
        let grazing = 1.0 - outside.dot(unit) / GRAZING;
        if grazing > 0.0
            && let Some(place) = &self.place
        {
            start += place.bulge(scene, self.point, facing < 0.0) * min(grazing, 1.0);
        }
        let (along, limit) = place.map_or((unit, f32::INFINITY), |place| (place - start, 1.0));
        Some((Ray::new(start, along)?, limit))
    }

    /// Returns how the first or second coordinates on textures grow over the surface: their
    /// gradients, per metre. Zero of a triangle without an area.
    pub(super) fn gradients<const W: usize>(
        &self,
        scene: &Scene<'a, W>,
        is_second: bool,
    ) -> [Vec3; 2] {
        let place = self.place.as_ref();
        let at = (self.point, self.geometric_normal);
        let found = place.and_then(|place| place.gradients(scene, at, is_second));
        found.unwrap_or_default()
    }

    /// Returns the outward normal that a normal map bends: see [`Place::bent`].
    pub(super) fn bent<const W: usize>(&self, scene: &Scene<'a, W>, parts: Vec3) -> Option<Vec3> {
        let at = (self.point, self.geometric_normal);
        self.place.as_ref()?.bent(scene, at, parts)
    }

    #[inline(always)]
    fn clearance<const W: usize>(&self, scene: &Scene<'a, W>, direction: Vec3) -> f32 {
        let place = self.place.as_ref();
        let at = (self.point, self.geometric_normal);
        place.map_or(0.0, |place| place.clearance(scene, at, direction))
    }
}

/// A surface at a hit, in the frame of its shape.
struct Local<'a> {
    point: Vec3,
    /// Unit length, or zero for a triangle without area.
    normal: Vec3,
    /// Interpolated, where the instance asks for it.
    smooth: Option<Vec3>,
    material: &'a Material,
    coordinates: [[f32; 2]; 2],
    colour: Vec3,
    triangle: Option<TrianglePlace<'a>>,
}

impl<'a> Local<'a> {
    #[inline(always)]
    fn of_mesh<const W: usize, const EFFECTS: u32>(
        scene: &Scene<'a, W>,
        instance: &Instance,
        ray: &Ray,
        on: &MeshHit,
        effects: u32,
    ) -> Option<Self> {
        let mesh = scene.meshes.get(instance.geometry as usize)?;
        let triangle = Leaves::new(scene, mesh).leaf(on.leaf)?.triangle(on.lane)?;
        let weights = triangle.weights(ray);
        let [a, b, c] = triangle.0;
        let record = mesh.first_triangle.checked_add(on.triangle)?;
        let record = scene.triangles.get(record as usize)?;
        // Normalised first, since products of tiny triangles' edges underflow.
        let normal = normalize((b - a).cross(c - a)).unwrap_or(Vec3::ZERO);
        let point = a * weights[0] + b * weights[1] + c * weights[2];
        let smooth = if instance.flags & flag::SMOOTH != 0 && mesh.normal_count > 0 {
            let corner = |i: usize| {
                let number = mesh.first_normal.checked_add(record.corners[i])?;
                let normal = scene.normals.get(number as usize);
                normal.map(|&n| Vec3::from_array(n))
            };
            Some(corner(0)? * weights[0] + corner(1)? * weights[1] + corner(2)? * weights[2])
        } else {
            None
        };
        let material = material_of(scene, instance, record.material)?;
        let coordinates = if is_textured::<EFFECTS>(material, effects) && mesh.coordinate_count > 0
        {
            coordinates(scene, mesh, record, weights)?
        } else {
            [[0.0; 2]; 2]
        };
        let is_coloured = EFFECTS & effect::VERTEX_COLOURS != 0
            && material.effects & effects & effect::VERTEX_COLOURS != 0
            && mesh.first_colour != NO_COLOURS;
        let colour = if is_coloured {
            vertex_colour(scene, mesh, record, weights)?
        } else {
            Vec3::ONE
        };
        Some(Self {
            point,
            normal,
            smooth,
            material,
            coordinates,
            colour,
            triangle: Some(TrianglePlace {
                mesh,
                record,
                leaf: on.leaf,
                lane: on.lane,
            }),
        })
    }

    #[inline(always)]
    fn of_spheroid<const W: usize, const EFFECTS: u32>(
        scene: &Scene<'a, W>,
        instance: &Instance,
        ray: &Ray,
        on: &MeshHit,
        effects: u32,
    ) -> Option<Self> {
        let spheroid = Spheroid::of_checked(instance.radii);
        let point = spheroid.project(ray.at(on.t));
        let material = material_of(scene, instance, NO_MATERIAL)?;
        let coordinates = if is_textured::<EFFECTS>(material, effects) {
            [texture::around(point); 2]
        } else {
            [[0.0; 2]; 2]
        };
        Some(Self {
            point,
            normal: spheroid.normal(point),
            smooth: None,
            material,
            coordinates,
            colour: Vec3::ONE,
            triangle: None,
        })
    }
}

/// Returns the material of an instance, or `own` where it has none.
#[inline(always)]
fn material_of<'a, const W: usize>(
    scene: &Scene<'a, W>,
    instance: &Instance,
    own: u32,
) -> Option<&'a Material> {
    let number = if instance.material == NO_MATERIAL {
        own
    } else {
        instance.material
    };
    scene.materials.get(number as usize)
}

#[inline(always)]
const fn is_textured<const EFFECTS: u32>(material: &Material, effects: u32) -> bool {
    EFFECTS & TEXTURES != 0 && material.effects & effects & TEXTURES != 0
}

/// Returns the first and second texture coordinates of a point of a triangle, from the corners'
/// weights; a mesh with one set has it twice.
#[inline(always)]
pub(super) fn coordinates<const W: usize>(
    scene: &Scene<'_, W>,
    mesh: &Mesh,
    triangle: &Triangle,
    weights: [f32; 3],
) -> Option<[[f32; 2]; 2]> {
    let first = coordinate(scene, mesh.first_coordinate, triangle, weights)?;
    let second = if mesh.coordinate_count > mesh.normal_count {
        let start = mesh.first_coordinate.checked_add(mesh.normal_count)?;
        coordinate(scene, start, triangle, weights)?
    } else {
        first
    };
    Some([first, second])
}

fn coordinate<const W: usize>(
    scene: &Scene<'_, W>,
    first: u32,
    triangle: &Triangle,
    weights: [f32; 3],
) -> Option<[f32; 2]> {
    let corner = |corner: u32| {
        let number = first.checked_add(corner)?;
        scene.coordinates.get(number as usize)
    };
    let [a, b, c] = triangle.corners;
    let [a, b, c] = [corner(a)?, corner(b)?, corner(c)?];
    Some([
        a[0] * weights[0] + b[0] * weights[1] + c[0] * weights[2],
        a[1] * weights[0] + b[1] * weights[1] + c[1] * weights[2],
    ])
}

/// Returns the colour of a point of a triangle, from the corners' weights.
#[inline(always)]
fn vertex_colour<const W: usize>(
    scene: &Scene<'_, W>,
    mesh: &Mesh,
    triangle: &Triangle,
    weights: [f32; 3],
) -> Option<Vec3> {
    let corner = |corner: u32, weight: f32| {
        let number = mesh.first_colour.checked_add(corner)?;
        let colour = scene.colours.get(number as usize);
        colour.map(|&colour| Vec3::from_array(colour) * weight)
    };
    let ([a, b, c], [u, v, w]) = (triangle.corners, weights);
    Some(corner(a, u)? + corner(b, v)? + corner(c, w)?)
}

/// Returns the unit normal in the room of a normal of about unit length in a shape's frame: by the
/// inverse transpose; both maps are stored.
pub(super) fn world_normal(instance: &Instance, normal: Vec3) -> Option<Vec3> {
    normalize(mapped_normal(instance, normal))
}

/// Does what [`world_normal`] does, up to the normal's length.
pub(super) fn mapped_normal(instance: &Instance, normal: Vec3) -> Vec3 {
    let [x, y, z, _] = instance.object_from_world;
    let [x, y, z] = map3([x, y, z], Vec3::from_array);
    Vec3::new(x.dot(normal), y.dot(normal), z.dot(normal))
}
