//! Calls of the core in each mode, as a firmware makes them.
#![no_std]

use core::slice;
use shisen_core::Simd;
use shisen_core::frame::{
    Budget, CompactRenderer, Pixel, Renderer, Settings, Tile, TileJob, View, Workspace,
};
use shisen_core::scene::{CompactScene, EffectSet};

const EFFECTS: u32 = if cfg!(feature = "all-effects") {
    EffectSet::ALL.bits()
} else {
    EffectSet::SHADOWS.bits()
};

#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    loop {}
}

/// 8 × 8 pixels of a view.
#[repr(C)]
pub struct Order<'a> {
    scene: *const u8,
    length: usize,
    view: &'a View,
    pixels: *mut Pixel,
    workspace: &'a mut Workspace,
}

/// Renders rays in blocks, `Mode::Tile`.
///
/// # Safety
/// `scene` points to `length` bytes and `pixels` to 64 pixels.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn render_together(order: &mut Order<'_>) -> u32 {
    // SAFETY: the caller promises it.
    unsafe { render(order, Renderer::for_effects::<EFFECTS>) }
}

/// Renders ray by ray, `Mode::Single`.
///
/// # Safety
/// The same as for [`render_together`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn render_singly(order: &mut Order<'_>) -> u32 {
    // SAFETY: the caller promises it.
    unsafe { render(order, Renderer::single::<EFFECTS>) }
}

/// # Safety
/// The same as for [`render_together`].
unsafe fn render<'a>(
    order: &mut Order<'a>,
    renderer: fn(CompactScene<'a>, Simd, Settings) -> CompactRenderer<'a>,
) -> u32 {
    // SAFETY: the caller promises it.
    let (scene, pixels) = unsafe {
        (
            slice::from_raw_parts(order.scene, order.length),
            slice::from_raw_parts_mut(order.pixels, 64),
        )
    };
    let Ok(scene) = CompactScene::from_bytes(scene) else {
        return 1;
    };
    let renderer = renderer(scene, Simd::PORTABLE, Settings::default());
    let tile = Tile {
        x: 0,
        y: 0,
        width: 8,
        height: 8,
    };
    let (budget, workspace) = (&mut Budget::steps(1000), &mut *order.workspace);
    let job = TileJob::new(tile).render(&renderer, order.view, pixels, budget, workspace);
    if job.is_ok() { 0 } else { 2 }
}
