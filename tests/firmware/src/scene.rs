//! The scene, and the renderer that this firmware links.

use crate::say;
use shisen_core::Simd;
use shisen_core::frame::{CompactRenderer, Pixel, Renderer, Settings};
use shisen_core::scene::EffectSet;
use shisen_core::scene::{CompactScene, SceneError};

/// The effects that are linked.
pub const EFFECTS: u32 = if cfg!(feature = "dispersion") {
    EffectSet::WHITTED.bits()
} else {
    EffectSet::WHITTED.bits() & !EffectSet::DISPERSION.bits()
};

/// Colour of all pixels without a scene.
pub const NO_SCENE: Pixel = Pixel {
    red: 1.0,
    green: 0.0,
    blue: 1.0,
    alpha: 1.0,
};

/// Returns the scene in `bytes`, or the number of its error.
pub fn open(bytes: &'static [u8]) -> Result<CompactScene<'static>, u32> {
    CompactScene::from_bytes(bytes).map_err(|error| {
        say!(error, "no scene: {}", error);
        fault(&error)
    })
}

/// Returns an error's number for a report, from 1 on.
const fn fault(error: &SceneError) -> u32 {
    match error {
        SceneError::Truncated { .. } => 1,
        SceneError::Misaligned { .. } => 2,
        SceneError::NotAScene => 3,
        SceneError::Version { .. } => 4,
        SceneError::Width { .. } => 5,
        SceneError::Checksum { .. } => 6,
        _ => 7,
    }
}

/// Returns a renderer with at most `depth` bounces, which traces one ray at a time.
pub fn renderer<'a>(scene: CompactScene<'a>, depth: u8) -> CompactRenderer<'a> {
    let settings = Settings {
        depth,
        ..Settings::default()
    };
    Renderer::single::<EFFECTS>(scene, Simd::PORTABLE, settings)
}
