//! Temporary.
#![no_std]
#![no_main]
use core::hint::black_box;
use core::panic::PanicInfo;
use cortex_m_rt::entry;
use glam::Vec3;
use shisen_core::frame::{Budget, FlatScreen, FrameJob, LevelOfDetail, Mode, Part, Pixel, Place, Renderer, Settings, Workspace};
use shisen_core::gaze::{Gaze, LineOfSight, VisualField};
use shisen_core::scene::Scene;
use shisen_core::Simd;
unsafe extern "C" { safe fn a_path_leads_to_a_panic() -> !; }
#[panic_handler]
fn panic(_: &PanicInfo<'_>) -> ! { loop {} }

#[cfg(feature = "everything")]
const EFFECTS: u32 = shisen_core::EffectSet::ALL.bits();
#[cfg(not(feature = "everything"))]
const EFFECTS: u32 = shisen_core::EffectSet::ALL.bits() & !shisen_core::EffectSet::DISPERSION.bits();

static mut PIXELS: [Pixel; 256] = [Pixel { red: 0.0, green: 0.0, blue: 0.0, alpha: 0.0 }; 256];
fn run(blob: &[u8], pixels: &mut [Pixel], places: &mut [Place], workspace: &mut Workspace) -> Option<()> {
    let scene: Scene<4> = Scene::from_bytes(blob).ok()?;
    let mut settings = Settings { mode: Mode::Single, ..Settings::default() };
    settings.depth = black_box(3);
    let renderer = Renderer::single::<EFFECTS>(scene, Simd::PORTABLE, settings);
    #[cfg(feature = "everything")]
    let renderer = renderer.with_spectrum(black_box(shisen_core::frame::Spectrum::Rgb)).ok()?;
    let sight = LineOfSight::new(black_box(Vec3::ZERO), black_box(Vec3::NEG_Z), black_box(Vec3::Y)).ok()?;
    let field = VisualField::PAPER.wider(black_box(0.1))?;
    let renderer = renderer.with_level_of_detail(LevelOfDetail::new(Gaze::new(sight, field)));
    let screen: FlatScreen = black_box(FlatScreen { first_pixel: Vec3::X, column_step: Vec3::X, row_step: Vec3::Y, size: [64, 64] });
    let view = screen.view_from(black_box(Vec3::ZERO)).ok()?;
    let parts = [Part { view, renderer }];
    let mut job = FrameJob::new(&parts, black_box(16), Budget::UNLIMITED, places).ok()?;
    while let Ok(p) = job.render(&parts, pixels, &mut Budget::steps(black_box(100)), workspace) { black_box(p); }
    Some(())
}

#[entry]
fn main() -> ! {
    let mut workspace = Workspace::new();
    let mut places = [Place::default(); 64];
    let mut pixels = [Pixel::default(); 256];
    let blob = unsafe { core::slice::from_raw_parts(0x6000_0000 as *const u8, 0x0020_0000) };
    black_box(run(blob, &mut pixels, &mut places, &mut workspace));
    loop { cortex_m::asm::nop(); }
}
