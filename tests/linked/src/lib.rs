//! One call of the core, as a firmware makes it.
#![no_std]

use core::slice;
use shisen_core::Simd;
use shisen_core::frame::{Budget, Pixel, Renderer, Settings, Tile, TileJob, View, Workspace};
#[cfg(not(feature = "all-effects"))]
use shisen_core::scene::EffectSet;
use shisen_core::scene::Scene;

#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    loop {}
}

/// Renders 8 × 8 pixels.
///
/// # Safety
/// `scene` points to `length` bytes and `pixels` to 64 pixels.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn render(
    scene: *const u8,
    length: usize,
    view: &View,
    pixels: *mut Pixel,
    workspace: &mut Workspace,
) -> u32 {
    // SAFETY: the caller's.
    let (scene, pixels) = unsafe {
        (
            slice::from_raw_parts(scene, length),
            slice::from_raw_parts_mut(pixels, 64),
        )
    };
    let Ok(scene) = Scene::<4>::from_bytes(scene) else {
        return 1;
    };
    let settings = Settings::default();
    #[cfg(feature = "all-effects")]
    let renderer = Renderer::new(scene, Simd::PORTABLE, settings);
    #[cfg(not(feature = "all-effects"))]
    let renderer =
        Renderer::for_effects::<{ EffectSet::SHADOWS.bits() }>(scene, Simd::PORTABLE, settings);
    let tile = Tile {
        x: 0,
        y: 0,
        width: 8,
        height: 8,
    };
    let job =
        TileJob::new(tile).render(&renderer, view, pixels, &mut Budget::steps(1000), workspace);
    if job.is_ok() { 0 } else { 2 }
}
