//! Clear bodies that may lie within one another.

use super::instance::materials_of;
use super::simplify::Topology;
use super::tree::Bounds;
use crate::scene::material::Material;
use crate::scene::{Object, Scene, Shape};

/// Returns whether clear bodies may lie within one another or overlap: two are there, with closed
/// surfaces, whose boxes meet, or one mesh has several. What is open has no inside.
pub(super) fn may_nest(scene: &Scene, boxes: &[Bounds]) -> bool {
    let clear = scene.objects.iter().zip(boxes).filter_map(|(object, own)| {
        let bodies = materials_of(scene, object).iter().filter(|m| is_body(m));
        let count = bodies.count();
        (count > 0).then_some((object, own, count))
    });
    let mut clear: Vec<(&Object, &Bounds, usize)> = clear.collect();
    clear.sort_by(|(_, a, _), (_, b, _)| a.low[0].total_cmp(&b.low[0]));
    let mut closed = vec![None; scene.meshes.len()];
    let mut is_closed = |object: &Object| match object.shape {
        Shape::Mesh(number) => {
            *closed[number].get_or_insert_with(|| Topology::of(&scene.meshes[number]).is_closed())
        }
        _ => true,
    };
    for (number, &(object, own, count)) in clear.iter().enumerate() {
        let beside = clear[number + 1..].iter();
        let near = beside.take_while(|(_, other, _)| other.low[0] <= own.high[0]);
        let mut met = near.filter(|(_, other, _)| own.meets(other));
        if (count > 1 || met.clone().next().is_some())
            && is_closed(object)
            && (count > 1 || met.any(|(other, ..)| is_closed(other)))
        {
            return true;
        }
    }
    false
}

fn is_body(material: &Material) -> bool {
    material.transmission != [0.0; 3] && material.index_of_refraction != 1.0
}
