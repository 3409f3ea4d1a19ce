//! The surface at a hit: exact point, normals, material.

use super::graticule;
use super::hit::Hit;
use super::leaves::Leaves;
use super::map::{map_point, map_vector};
use super::texture::{self, TEXTURES};
use crate::numeric::{UNIT_ROUNDOFF, largest_magnitude, map3, max, normalize};
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
    /// Error bound of `point`, its distance from the surface after the instance's maps: metres.
    error: f32,
}

impl<'a> Surface<'a> {
    /// Returns the normal and a point of the plane that touches the true shape.
    pub(crate) const fn tangent(&self) -> (Vec3, Vec3) {
        (self.geometric_normal, self.point)
    }

    /// Returns the surface at a hit; `effects` are bits of the effects to consider. `None` only if
    /// the scene's bytes are inconsistent.
    // Longer than 80 lines: each step needs what those before it found.
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
        let to_world = |p| map_point(&instance.world_from_object, p);
        let material_of = |own| {
            let number = if instance.material == NO_MATERIAL {
                own
            } else {
                instance.material
            };
            scene.materials.get(number as usize)
        };
        let is_textured = |material: &Material| {
            EFFECTS & TEXTURES != 0 && material.effects & effects & TEXTURES != 0
        };
        let mut colour = Vec3::ONE;
        let (point, normal, smooth, material, coordinates, reach) = if instance.kind == kind::MESH {
            let mesh = scene.meshes.get(instance.geometry as usize)?;
            let triangle = Leaves::new(scene, mesh)
                .leaf(hit.on.leaf)?
                .triangle(hit.on.lane)?;
            let weights = triangle.weights(&object_ray);
            let [a, b, c] = triangle.0;
            let record = mesh.first_triangle.checked_add(hit.on.triangle)?;
            let record = scene.triangles.get(record as usize)?;
            let normal = (b - a).cross(c - a);
            let smooth = if instance.flags & flag::SMOOTH != 0 && mesh.normal_count > 0 {
                let corner = |i: usize| {
                    let number = mesh.first_normal.checked_add(record.corners[i])?;
                    scene
                        .normals
                        .get(number as usize)
                        .map(|&n| Vec3::from_array(n))
                };
                Some(corner(0)? * weights[0] + corner(1)? * weights[1] + corner(2)? * weights[2])
            } else {
                None
            };
            let point = a * weights[0] + b * weights[1] + c * weights[2];
            let material = material_of(record.material)?;
            if graticule::is_between::<EFFECTS>(effects, material, point) {
                return Some(Self::between_lines(to_world(point)));
            }
            // A point near the origin has the same absolute error as others.
            let reach = map3([a, b, c], |corner| largest_magnitude(to_world(corner)));
            let reach = max(reach[0], max(reach[1], reach[2]));
            let coordinates = if is_textured(material) && mesh.coordinate_count > 0 {
                coordinates(scene, mesh, record, weights)?
            } else {
                [[0.0; 2]; 2]
            };
            if EFFECTS & effect::VERTEX_COLOURS != 0
                && material.effects & effects & effect::VERTEX_COLOURS != 0
                && mesh.first_colour != NO_COLOURS
            {
                colour = vertex_colour(scene, mesh, record, weights)?;
            }
            (point, normal, smooth, material, coordinates, reach)
        } else {
            let spheroid = Spheroid::of_checked(instance.radii);
            let point = spheroid.project(object_ray.at(hit.on.t));
            let material = material_of(NO_MATERIAL)?;
            if graticule::is_between::<EFFECTS>(effects, material, point) {
                return Some(Self::between_lines(to_world(point)));
            }
            let normal = spheroid.normal(point);
            let coordinates = if is_textured(material) {
                [texture::around(point); 2]
            } else {
                [[0.0; 2]; 2]
            };
            (
                point,
                normal,
                None,
                material,
                coordinates,
                largest_magnitude(to_world(point)),
            )
        };
        // A triangle without area is hit only where it closes a seam of its mesh: whichever way
        // it faces, it shows light and not the background.
        let geometric_normal =
            world_normal(instance, normal).or_else(|| normalize(-ray.direction()))?;
        let point = to_world(point);
        let shading_normal = smooth
            .and_then(|smooth| world_normal(instance, smooth))
            .filter(|n| n.dot(geometric_normal) > 0.0)
            .unwrap_or(geometric_normal);
        Some(Self {
            point,
            geometric_normal,
            shading_normal,
            material,
            coordinates,
            colour,
            error: Self::error(instance, reach),
        })
    }

    /// Returns the surface at a point of a facet, without coordinates.
    pub(super) const fn of_facet(
        point: Vec3,
        (geometric_normal, shading_normal): (Vec3, Vec3),
        material: &'a Material,
        error: f32,
    ) -> Self {
        Self {
            point,
            geometric_normal,
            shading_normal,
            material,
            coordinates: [[0.0; 2]; 2],
            colour: Vec3::ONE,
            error,
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
            error: 0.0,
        }
    }

    /// Returns the error bound of points of an instance, or of its part that is within `reach` of
    /// the origin along each axis.
    pub(super) fn error(instance: &Instance, reach: f32) -> f32 {
        let translation = Vec3::from_array(instance.world_from_object[3]);
        let size = reach + largest_magnitude(translation);
        Self::SLACK * UNIT_ROUNDOFF * instance.condition * size
    }

    /// Error bound in unit roundoffs, for the weighted corners, both maps and the triangle test.
    const SLACK: f32 = 32.0;

    /// Returns where a ray towards `direction` starts, clear of this surface.
    #[inline]
    pub(super) fn start(&self, direction: Vec3) -> Vec3 {
        let side = if direction.dot(self.geometric_normal) >= 0.0 {
            self.error
        } else {
            -self.error
        };
        self.point + self.geometric_normal * side
    }

    /// Returns a ray to a light in a direction or at a place, and the light's distance along it.
    #[inline(always)]
    pub(super) fn ray_to(&self, unit: Vec3, place: Option<Vec3>) -> Option<(Ray, f32)> {
        let start = self.start(unit);
        let (along, limit) = place.map_or((unit, f32::INFINITY), |place| (place - start, 1.0));
        Some((Ray::new(start, along)?, limit))
    }
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

/// Maps a normal by the inverse transpose; both maps are stored.
pub(super) fn world_normal(instance: &Instance, normal: Vec3) -> Option<Vec3> {
    // Normalised first, since products of tiny triangles' edges underflow.
    normalize(mapped_normal(instance, normalize(normal)?))
}

/// Does what [`world_normal`] does, up to the normal's length.
pub(super) fn mapped_normal(instance: &Instance, normal: Vec3) -> Vec3 {
    let [x, y, z, _] = instance.object_from_world;
    let [x, y, z] = map3([x, y, z], Vec3::from_array);
    Vec3::new(x.dot(normal), y.dot(normal), z.dot(normal))
}
