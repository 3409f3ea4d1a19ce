//! Scenes with hostile numbers in their bytes.

use super::super::numbers::Numbers;
use super::BAKED;
use shisen::bake::Baked;
use shisen_core::scene::Scene;
use shisen_core::scene::format::{Header, Instance, Light, Material, seal};
use std::mem::offset_of;
use zerocopy::FromBytes as _;

/// Where numbers go into a scene, and the numbers.
pub(super) fn numbers_of_a_scene(n: &mut Numbers) -> Vec<(usize, f32)> {
    let bytes = BAKED.as_bytes();
    let (header, _) = Header::read_from_prefix(bytes).expect("a header");
    let material =
        |i: usize, field| header.materials.offset as usize + i * size_of::<Material>() + field;
    let light = |i: usize, field| header.lights.offset as usize + i * size_of::<Light>() + field;
    let instance =
        |i: usize, field| header.instances.offset as usize + i * size_of::<Instance>() + field;
    let places = [
        material(0, offset_of!(Material, diffuse)),
        material(0, offset_of!(Material, shininess)),
        material(0, offset_of!(Material, transmission) + 4),
        material(0, offset_of!(Material, absorption) + 8),
        material(0, offset_of!(Material, index_of_refraction)),
        material(1, offset_of!(Material, specular)),
        material(1, offset_of!(Material, shininess)),
        material(1, offset_of!(Material, mirror) + 4),
        material(1, offset_of!(Material, graticule_width)),
        material(2, offset_of!(Material, emission)),
        light(0, offset_of!(Light, place)),
        light(0, offset_of!(Light, colour)),
        light(1, offset_of!(Light, place) + 4),
        light(1, offset_of!(Light, colour) + 8),
        light(2, offset_of!(Light, right)),
        light(2, offset_of!(Light, up) + 8),
        instance(3, offset_of!(Instance, radii)),
        instance(3, offset_of!(Instance, radii) + 4),
        instance(3, offset_of!(Instance, condition)),
        instance(3, offset_of!(Instance, object_from_world)),
        instance(3, offset_of!(Instance, object_from_world) + 36),
        instance(3, offset_of!(Instance, world_from_object) + 16),
        instance(3, offset_of!(Instance, low)),
        instance(3, offset_of!(Instance, high) + 4),
        offset_of!(Header, extent),
        offset_of!(Header, ambient),
        offset_of!(Header, background),
        offset_of!(Header, background) + 12,
        header.normals.offset as usize,
        header.textures.offset as usize + 16,
        header.coordinates.offset as usize,
        header.media.offset as usize + 8,
    ];
    places
        .into_iter()
        .map(|place| {
            let sane = f32::from_le_bytes([0, 1, 2, 3].map(|i| bytes[place + i]));
            (place, n.next(sane))
        })
        .collect()
}

pub(super) fn write(bytes: &mut [u8], numbers: &[(usize, f32)]) {
    for &(place, number) in numbers {
        bytes[place..place + 4].copy_from_slice(&number.to_le_bytes());
    }
    seal(bytes);
}

/// A scene with these numbers in it, unless it is refused.
pub(super) fn of_a_scene(n: &mut Numbers, check: impl Fn(Scene<'_>)) {
    let mut bytes = BAKED.as_bytes().to_vec();
    write(&mut bytes, &numbers_of_a_scene(n));
    match Baked::<8>::from_bytes(&bytes) {
        Ok(baked) => check(baked.scene()),
        Err(error) => assert!(!error.to_string().is_empty()),
    }
}
