//! Scenes, used where they are.

use crate::memory::{needed, room, shared, slice, write};
use crate::status::{Status, of_scene, settled};
use core::ffi::{c_char, c_void};
use core::ptr::null;
use shisen_core::scene::EffectSet;

/// Bytes of memory for a scene's handle.
#[cfg(target_pointer_width = "32")]
pub const SHISEN_SCENE_SIZE: usize = 144;
/// Bytes of memory for a scene's handle.
#[cfg(target_pointer_width = "64")]
pub const SHISEN_SCENE_SIZE: usize = 288;
/// Alignment of a baked scene, bytes.
pub const SHISEN_BLOB_ALIGNMENT: usize = 32;

/// Children of a node in the compact layout.
pub(crate) const WIDTH: usize = 4;

/// Effects that the library was built for.
pub(crate) const EFFECTS: u32 = {
    let all = if cfg!(feature = "all-effects") {
        EffectSet::ALL
    } else {
        EffectSet::WHITTED
    };
    if cfg!(feature = "dispersion") {
        all.bits()
    } else {
        all.difference(EffectSet::DISPERSION).bits()
    }
};

/// A scene that has been checked. It refers to the baked scene's bytes, which
/// stay the caller's: they must neither change nor move as long as the scene or
/// a frame of it is in use. It never changes, so that any number of frames and
/// threads can use it at once.
#[derive(Clone, Copy)]
pub struct Scene {
    pub(crate) scene: shisen_core::scene::Scene<'static, WIDTH>,
}

const _: () = assert!(needed::<Scene>() <= SHISEN_SCENE_SIZE);
const _: () = assert!(shisen_core::scene::format::ALIGNMENT == SHISEN_BLOB_ALIGNMENT);

/// Why a scene was refused.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct SceneFault {
    /// The shisen_status of the refusal.
    pub status: u32,
    /// A byte, a record or a size, by the status's description.
    pub number: u64,
    /// The table or value at fault, in English: `what_length` bytes without a
    /// zero at their end. NULL if the status says all. The library owns the
    /// text, which stays valid.
    pub what: *const c_char,
    /// Number of bytes of `what`.
    pub what_length: usize,
}

/// Facts about a scene.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct SceneFacts {
    /// The effects that it asks for: SHISEN_EFFECT_... bits. Effects outside
    /// shisen_effects() are not rendered.
    pub effects: u32,
    /// Its length in bytes, which may be less than the length given.
    pub byte_length: u32,
    /// Number of polygon levels of its meshes; 1 if it was baked without levels.
    pub polygon_levels: u32,
    /// Number of placed shapes.
    pub objects: u32,
    /// Number of lights.
    pub lights: u32,
}

/// Effect: objects cast shadows.
pub const SHISEN_EFFECT_SHADOWS: u32 = 0x10000;
/// Effect: mirrors.
pub const SHISEN_EFFECT_REFLECTION: u32 = 0x2;
/// Effect: clear bodies.
pub const SHISEN_EFFECT_REFRACTION: u32 = 0x4;
/// Effect: clear bodies refract each wavelength differently.
pub const SHISEN_EFFECT_DISPERSION: u32 = 0x100;
/// Effect: clear bodies absorb light.
pub const SHISEN_EFFECT_ABSORPTION: u32 = 0x8;
/// Effect: clear bodies within one another.
pub const SHISEN_EFFECT_NESTED_MEDIA: u32 = 0x2000;
/// Effect: lights with a size.
pub const SHISEN_EFFECT_SOFT_LIGHT: u32 = 0x20000;
/// Effect: lights that shine into cones.
pub const SHISEN_EFFECT_SPOT_LIGHT: u32 = 0x40000;
/// Effect: shadows that light comes through.
pub const SHISEN_EFFECT_CLEAR_SHADOWS: u32 = 0x80000;
/// Effect: an image as the background.
pub const SHISEN_EFFECT_ENVIRONMENT: u32 = 0x0010_0000;
/// Effect: images on surfaces.
pub const SHISEN_EFFECT_IMAGE_TEXTURE: u32 = 0x40;
/// Effect: checkers on surfaces.
pub const SHISEN_EFFECT_CHECKER_TEXTURE: u32 = 0x20;
/// Effect: normals that images bend.
pub const SHISEN_EFFECT_NORMAL_MAP: u32 = 0x4000;
/// Effect: textures as coarse as what a pixel sees of them.
pub const SHISEN_EFFECT_TEXTURE_LEVELS: u32 = 0x1000;
/// Effect: surfaces that shine.
pub const SHISEN_EFFECT_EMISSION: u32 = 0x80;
/// Effect: meridians and parallels on a surface.
pub const SHISEN_EFFECT_GRATICULE: u32 = 0x10;
/// Effect: microfacets, of metal and of what is more or less rough.
pub const SHISEN_EFFECT_MICROFACETS: u32 = 0x200;
/// Effect: surfaces with holes, or more or less opaque from place to place.
pub const SHISEN_EFFECT_ALPHA: u32 = 0x800;
/// Effect: colours of vertices.
pub const SHISEN_EFFECT_VERTEX_COLOURS: u32 = 0x400;

const _: () = assert!(
    EffectSet::SHADOWS.bits() == SHISEN_EFFECT_SHADOWS
        && EffectSet::REFLECTION.bits() == SHISEN_EFFECT_REFLECTION
        && EffectSet::REFRACTION.bits() == SHISEN_EFFECT_REFRACTION
        && EffectSet::DISPERSION.bits() == SHISEN_EFFECT_DISPERSION
        && EffectSet::ABSORPTION.bits() == SHISEN_EFFECT_ABSORPTION
        && EffectSet::SOFT_LIGHT.bits() == SHISEN_EFFECT_SOFT_LIGHT
        && EffectSet::SPOT_LIGHT.bits() == SHISEN_EFFECT_SPOT_LIGHT
        && EffectSet::IMAGE_TEXTURE.bits() == SHISEN_EFFECT_IMAGE_TEXTURE
        && EffectSet::CHECKER_TEXTURE.bits() == SHISEN_EFFECT_CHECKER_TEXTURE
        && EffectSet::EMISSION.bits() == SHISEN_EFFECT_EMISSION
        && EffectSet::GRATICULE.bits() == SHISEN_EFFECT_GRATICULE
        && EffectSet::MICROFACETS.bits() == SHISEN_EFFECT_MICROFACETS
        && EffectSet::CLEAR_SHADOWS.bits() == SHISEN_EFFECT_CLEAR_SHADOWS
        && EffectSet::ALPHA.bits() == SHISEN_EFFECT_ALPHA
        && EffectSet::TEXTURE_LEVELS.bits() == SHISEN_EFFECT_TEXTURE_LEVELS
        && EffectSet::ENVIRONMENT.bits() == SHISEN_EFFECT_ENVIRONMENT
        && EffectSet::NORMAL_MAP.bits() == SHISEN_EFFECT_NORMAL_MAP
        && EffectSet::NESTED_MEDIA.bits() == SHISEN_EFFECT_NESTED_MEDIA
        && EffectSet::VERTEX_COLOURS.bits() == SHISEN_EFFECT_VERTEX_COLOURS
);

/// Returns SHISEN_SCENE_SIZE, the bytes of memory for a scene's handle.
#[unsafe(no_mangle)]
pub extern "C" fn shisen_scene_size() -> usize {
    SHISEN_SCENE_SIZE
}

/// Returns the effects that this library renders: SHISEN_EFFECT_... bits.
#[unsafe(no_mangle)]
pub extern "C" fn shisen_effects() -> u32 {
    EFFECTS
}

/// Checks a scene that was baked in the compact layout (`shisen bake --layout
/// compact`) and makes a handle for it. This reads all its bytes, once.
///
/// `memory`, `memory_size`: for the handle, which needs SHISEN_SCENE_SIZE bytes
/// at a multiple of SHISEN_ALIGNMENT.
/// `blob`, `blob_length`: the scene, at a multiple of SHISEN_BLOB_ALIGNMENT. Bytes
/// after the scene's own length are ignored, so that a whole region of flash can
/// be given.
/// `scene`: receives the handle; NULL after a failure.
/// `fault`: receives the reason if the scene is refused; may be NULL.
///
/// # Safety
/// Each pointer is NULL, misaligned, or valid: `memory` for `memory_size` bytes,
/// `blob` for `blob_length`, the others for one value. Nobody else changes that
/// memory during the call. The blob stays unchanged for as long as the scene or a
/// frame of it is in use.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn shisen_scene_open(
    memory: *mut c_void,
    memory_size: usize,
    blob: *const u8,
    blob_length: usize,
    scene: *mut *mut Scene,
    fault: *mut SceneFault,
) -> Status {
    settled(|| {
        // SAFETY: as promised above.
        unsafe { write(scene, core::ptr::null_mut()) }?;
        let handle = room::<Scene>(memory, memory_size, 0)?;
        let blob_given = !blob.is_null();
        // SAFETY: as promised above; without bytes the pointer is not read.
        let bytes = unsafe { slice::<u8>(blob, blob_length) }?;
        if !blob_given {
            return Err(Status::NullPointer);
        }
        match shisen_core::scene::Scene::from_bytes(bytes) {
            Ok(checked) => {
                // SAFETY: there is room.
                unsafe { handle.write(Scene { scene: checked }) };
                // SAFETY: as promised above.
                unsafe { write(scene, handle) }
            }
            Err(error) => {
                let (status, number, what) = of_scene(error);
                if !fault.is_null() {
                    let found = SceneFault {
                        status: status as u32,
                        number,
                        what: if what.is_empty() {
                            null()
                        } else {
                            what.as_ptr().cast()
                        },
                        what_length: what.len(),
                    };
                    // SAFETY: as promised above.
                    unsafe { write(fault, found) }?;
                }
                Err(status)
            }
        }
    })
}

/// Says what a scene is like.
///
/// # Safety
/// `scene` is NULL or a scene that was opened; `facts` is NULL, misaligned, or
/// points to memory for one.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn shisen_scene_describe(
    scene: *const Scene,
    facts: *mut SceneFacts,
) -> Status {
    settled(|| {
        // SAFETY: as promised above.
        let Scene { scene } = unsafe { shared(scene) }?;
        let found = SceneFacts {
            effects: scene.effects().bits(),
            byte_length: scene.byte_len(),
            polygon_levels: scene.rungs().into(),
            objects: scene.instances().len() as u32,
            lights: scene.lights().len() as u32,
        };
        // SAFETY: as promised above.
        unsafe { write(facts, found) }
    })
}
