//! A scene as bytes, by hand: a ball under a lamp. `shisen bake` makes the same of
//! scene files, with trees over the triangles of meshes.

use core::mem::offset_of;
use shisen_core::scene::format::{
    Background, Header, Instance, LEAF, Light, MAGIC, Material, NO_MEDIUM, NO_TEXTURE, Table,
    VERSION, effect, flag, kind, light, seal,
};
use shisen_core::scene::{EffectSet, Records};
use zerocopy::{FromBytes, FromZeros as _, Immutable, IntoBytes};

/// Metres.
pub(crate) const RADIUS: f32 = 0.5;
/// Metres, straight ahead of the origin.
pub(crate) const DISTANCE: f32 = 3.0;

/// The header, then tables of one record each. 32 is the format's alignment.
#[derive(FromBytes, IntoBytes, Immutable)]
#[repr(C, align(32))]
pub(crate) struct Scene {
    header: Header,
    /// The tree over all objects is a `Node<4>`: the boxes of up to four children,
    planes: [[f32; 4]; 6],
    /// what these are,
    children: [u32; 4],
    /// and in which order to look at them.
    order: [u32; 4],
    instance: Instance,
    material: Material,
    light: Light,
}

/// Returns the ball, of a diffuse white, and a lamp to the upper left of the viewer.
pub(crate) fn scene() -> Scene {
    let instance = Instance {
        kind: kind::SPHEROID,
        radii: [RADIUS; 2],
        flags: flag::OCCLUDES,
        condition: 3.0,
        object_from_world: moved(DISTANCE),
        world_from_object: moved(-DISTANCE),
        low: [-RADIUS, -RADIUS, -RADIUS - DISTANCE],
        high: [RADIUS, RADIUS, RADIUS - DISTANCE],
        ..Instance::new_zeroed()
    };
    let material = Material {
        diffuse: [0.9; 3],
        shininess: 1.0,
        index_of_refraction: 1.0,
        effects: effect::LIT,
        texture: NO_TEXTURE,
        emission_texture: NO_TEXTURE,
        metal_texture: NO_TEXTURE,
        alpha_texture: NO_TEXTURE,
        normal_texture: NO_TEXTURE,
        medium: NO_MEDIUM,
        ..Material::new_zeroed()
    };
    let light = Light {
        place: [-2.0, 2.0, 0.0],
        kind: light::POINT,
        colour: [1.0; 3],
        ..Light::new_zeroed()
    };
    let background = Background {
        alpha: 1.0,
        image: NO_TEXTURE,
        ..Background::new_zeroed()
    };
    let asked = EffectSet::of_records(&Records {
        instances: &[instance],
        meshes: &[],
        triangles: &[],
        materials: &[material],
        lights: &[light],
        background: &background,
    });
    let header = Header {
        magic: MAGIC,
        version: VERSION,
        width: 4,
        byte_len: size_of::<Scene>() as u32,
        extent: RADIUS + DISTANCE,
        stack_entries: 4,
        top_nodes: 1,
        rungs: 1,
        effects: asked.bits(),
        nodes: one_at(offset_of!(Scene, planes)),
        instances: one_at(offset_of!(Scene, instance)),
        materials: one_at(offset_of!(Scene, material)),
        lights: one_at(offset_of!(Scene, light)),
        background,
        ambient: [0.05; 3],
        ..Header::new_zeroed()
    };
    let mut scene = Scene {
        header,
        // The child spans low to high, unused lanes ∞ to −∞.
        planes: std::array::from_fn(|plane| {
            let (side, none) = match plane % 2 {
                0 => (instance.low, f32::INFINITY),
                _ => (instance.high, f32::NEG_INFINITY),
            };
            [side[plane / 2], none, none, none]
        }),
        children: [LEAF, 0, 0, 0],
        // 0, 1, 2, 3, two bits each from the lowest, for rays of each of the eight octants.
        order: [0b1110_0100 << 16 | 0b1110_0100; 4],
        instance,
        material,
        light,
    };
    assert!(seal(scene.as_mut_bytes()));
    scene
}

fn moved(z: f32) -> [[f32; 3]; 4] {
    [
        [1.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [0.0, 0.0, 1.0],
        [0.0, 0.0, z],
    ]
}

fn one_at(offset: usize) -> Table {
    Table {
        offset: offset as u32,
        count: 1,
    }
}
