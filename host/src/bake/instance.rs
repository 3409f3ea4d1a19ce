//! Objects as the core has them: where they stand, and a box around each.

use super::BakeError;
use crate::scene::material::Material;
use crate::scene::mesh::TriangleMesh;
use crate::scene::{Object, Scene, Shape};
use glam::{DAffine3, DVec3};
use shisen_core::scene::format::{Instance, NO_MATERIAL, flag, kind};
use shisen_core::shape::Spheroid;

/// Rounding of the map into the object's frame and back, in units of the largest number involved.
const MAP_SLACK: f64 = 64.0 * 5.960_464_477_539_063e-8;

/// Returns what an object becomes, and by how many metres its boxes are wider than it.
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
    let spheroid = |e: f32, p: f32| (kind::SPHEROID, 0, [e, p], ([-e, -p, -e], [e, p, e]));
    let (kind, geometry, radii, (low, high)) = match object.shape {
        Shape::Mesh(index) => {
            let mesh = scene.meshes.get(index).ok_or(missing("mesh", index))?;
            (kind::MESH, index as u32, [0.0; 2], mesh.bounds())
        }
        Shape::Sphere { radius } => spheroid(radius, radius),
        Shape::Spheroid {
            equatorial_radius: e,
            polar_radius: p,
        } => spheroid(e, p),
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
    let bad_map = BakeError::Transform { object: number };
    let map = object.world_from_object;
    let inverse = map.inverse();
    if !map.is_finite() || !inverse.is_finite() || !map.matrix3.determinant().is_normal() {
        return Err(bad_map);
    }
    let (mut least, mut most) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for corner in 0..8 {
        let pick = |axis: usize| f64::from(if corner >> axis & 1 == 0 { low } else { high }[axis]);
        let corner = map.transform_point3(DVec3::new(pick(0), pick(1), pick(2)));
        (least, most) = (least.min(corner), most.max(corner));
    }
    let farthest = least.abs().max(most.abs()).max_element();
    if !(farthest <= f64::from(TriangleMesh::FARTHEST)) {
        return Err(bad_map);
    }
    // An ill-conditioned map magnifies what rounding does in its other frame.
    let norm = |m: glam::DMat3| m.to_cols_array().iter().map(|c| c * c).sum::<f64>().sqrt();
    let condition = norm(map.matrix3) * norm(inverse.matrix3);
    let translation = map.translation.abs().max_element();
    let slack = MAP_SLACK * condition * farthest.max(translation);
    let instance = Instance {
        kind,
        geometry,
        material: object.material.map_or(NO_MATERIAL, |m| m as u32),
        flags: flags(scene, object),
        radii,
        condition: condition as f32,
        cover: 0,
        object_from_world: columns(inverse),
        world_from_object: columns(map),
        low: (least - slack).to_array().map(|c| (c as f32).next_down()),
        high: (most + slack).to_array().map(|c| (c as f32).next_up()),
        cover_nodes: 0,
        reserved: 0,
    };
    Ok((instance, slack))
}

/// Returns how the object casts a shadow, and whether it is smooth. Its mesh and material exist.
fn flags(scene: &Scene, object: &Object) -> u32 {
    let own = object
        .material
        .map(|number| std::slice::from_ref(&scene.materials[number]));
    let of_mesh = match object.shape {
        Shape::Mesh(number) => &scene.meshes[number].materials[..],
        _ => &[],
    };
    let materials = own.unwrap_or(of_mesh);
    let is_clear = |m: &Material| m.transmission != [0.0; 3];
    let occludes = materials.is_empty() || !materials.iter().all(is_clear);
    let veils = materials.iter().any(|m| is_clear(m) || m.alpha.is_some());
    let asked = [
        (object.casts_shadow && occludes, flag::OCCLUDES),
        (object.casts_shadow && veils, flag::VEILS),
        (object.smooth, flag::SMOOTH),
    ];
    let asked = asked.into_iter().filter(|(is_asked, _)| *is_asked);
    asked.fold(0, |all, (_, flag)| all | flag)
}

fn columns(map: DAffine3) -> [[f32; 3]; 4] {
    map.to_cols_array_2d()
        .map(|column| column.map(|c| c as f32))
}
