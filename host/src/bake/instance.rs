//! Objects as the core has them: where they stand, and a box around each.

use super::BakeError;
use crate::scene::material::Material;
use crate::scene::mesh::TriangleMesh;
use crate::scene::{Object, Scene, Shape};
use glam::{DAffine3, DVec3};
use shisen_core::scene::format::{Instance, NO_MATERIAL, flag, kind};
use shisen_core::shape::Spheroid;

/// Rounding of the map into the object's frame and back, in units of the
/// largest number involved: a box widened by this holds what the mapped ray
/// can hit.
const MAP_SLACK: f64 = 64.0 * 5.960_464_477_539_063e-8;

/// What an object becomes, and by how many metres its boxes are wider than it.
pub(super) fn instance(
    scene: &Scene,
    number: usize,
    object: &Object,
) -> Result<(Instance, f64), BakeError> {
    let missing = |what, index| BakeError::Missing {
        object: number,
        what,
        index,
    };
    let (kind, geometry, radii, (low, high)) = match object.shape {
        Shape::Mesh(index) => {
            let mesh = scene.meshes.get(index).ok_or(missing("mesh", index))?;
            (kind::MESH, index as u32, [0.0; 2], mesh.bounds())
        }
        Shape::Sphere { radius } => (kind::SPHEROID, 0, [radius; 2], cube(radius, radius)),
        Shape::Spheroid {
            equatorial_radius: e,
            polar_radius: p,
        } => (kind::SPHEROID, 0, [e, p], cube(e, p)),
    };
    if kind == kind::SPHEROID && Spheroid::new(radii[0], radii[1]).is_none() {
        return Err(BakeError::Radius { object: number });
    }
    if let Some(index) = object.material.filter(|&m| m >= scene.materials.len()) {
        return Err(missing("material", index));
    }
    if let Shape::Mesh(index) = object.shape
        && !scene.meshes[index].has_coordinates_for(object.material.map(|m| &scene.materials[m]))
    {
        return Err(BakeError::NoCoordinates { object: number });
    }
    let bad_map = BakeError::Transform {
        object: number,
        limit: TriangleMesh::FARTHEST,
    };
    let world_from_object = object.world_from_object;
    let object_from_world = world_from_object.inverse();
    let determinant = world_from_object.matrix3.determinant();
    if !world_from_object.is_finite() || !object_from_world.is_finite() || !determinant.is_normal()
    {
        return Err(bad_map);
    }
    let corners: Vec<DVec3> = (0..8)
        .map(|i| {
            let pick = |axis: usize| f64::from(if i >> axis & 1 == 0 { low } else { high }[axis]);
            world_from_object.transform_point3(DVec3::new(pick(0), pick(1), pick(2)))
        })
        .collect();
    let least = corners.iter().copied().fold(DVec3::INFINITY, DVec3::min);
    let most = corners
        .iter()
        .copied()
        .fold(DVec3::NEG_INFINITY, DVec3::max);
    let farthest = least.abs().max(most.abs()).max_element();
    if !(farthest <= f64::from(TriangleMesh::FARTHEST)) {
        return Err(bad_map);
    }
    // An ill-conditioned map magnifies what rounding does in its other frame.
    let norm = |m: glam::DMat3| m.to_cols_array().iter().map(|c| c * c).sum::<f64>().sqrt();
    let condition = norm(world_from_object.matrix3) * norm(object_from_world.matrix3);
    let translation = world_from_object.translation.abs().max_element();
    let slack = MAP_SLACK * condition * farthest.max(translation);
    let opaque = |m: &Material| m.transmission == [0.0; 3];
    let lets_light_through = match (object.material, object.shape) {
        (Some(index), _) => !opaque(&scene.materials[index]),
        (None, Shape::Mesh(index)) => {
            let materials = &scene.meshes[index].materials;
            !materials.is_empty() && !materials.iter().any(opaque)
        }
        (None, _) => false,
    };
    let mut flags = 0;
    if object.casts_shadow && !lets_light_through {
        flags |= flag::OCCLUDES;
    }
    if object.smooth {
        flags |= flag::SMOOTH;
    }
    let instance = Instance {
        kind,
        geometry,
        material: object.material.map_or(NO_MATERIAL, |m| m as u32),
        flags,
        radii,
        condition: condition as f32,
        cover: 0,
        object_from_world: columns(object_from_world),
        world_from_object: columns(world_from_object),
        low: (least - slack).to_array().map(|c| (c as f32).next_down()),
        high: (most + slack).to_array().map(|c| (c as f32).next_up()),
        cover_nodes: 0,
        reserved: 0,
    };
    Ok((instance, slack))
}

fn cube(equatorial: f32, polar: f32) -> ([f32; 3], [f32; 3]) {
    (
        [-equatorial, -polar, -equatorial],
        [equatorial, polar, equatorial],
    )
}

fn columns(map: DAffine3) -> [[f32; 3]; 4] {
    map.to_cols_array_2d()
        .map(|column| column.map(|c| c as f32))
}
