//! Objects as the core has them: where they stand, and a box around each.

use super::BakeError;
use crate::scene::material::Material;
use crate::scene::{Object, Scene, Shape};
use shisen_core::scene::format::{Instance, NO_MATERIAL, flag, kind};
use shisen_core::shape::Spheroid;
use zerocopy::FromZeros as _;

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
    let mut instance = Instance {
        kind,
        geometry,
        material: object.material.map_or(NO_MATERIAL, |m| m as u32),
        flags: flags(scene, object),
        radii,
        ..Instance::new_zeroed()
    };
    let slack = instance.place(&object.world_from_object, low, high);
    let slack = slack.ok_or(BakeError::Transform { object: number })?;
    Ok((instance, slack))
}

/// Returns an object's materials: its own, or those of its mesh. They exist.
pub(super) fn materials_of<'s>(scene: &'s Scene, object: &Object) -> &'s [Material] {
    let own = object
        .material
        .map(|number| std::slice::from_ref(&scene.materials[number]));
    let of_mesh = match object.shape {
        Shape::Mesh(number) => &scene.meshes[number].materials[..],
        _ => &[],
    };
    own.unwrap_or(of_mesh)
}

/// Returns how the object casts a shadow, and whether it is smooth. Its mesh and material exist.
fn flags(scene: &Scene, object: &Object) -> u32 {
    let materials = materials_of(scene, object);
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
