//! Pixels as they are hashed and shown.

use shisen_core::frame::Pixel;
use std::sync::LazyLock;
use xxhash_rust::xxh3::xxh3_64;
use zerocopy::IntoBytes as _;

/// Returns the hash of a tile as a record has it. The processor's numbers have the lowest byte first.
pub(crate) fn hash(pixels: &[Pixel]) -> u64 {
    xxh3_64(pixels.as_bytes())
}

/// Steps of the table of codes.
const STEPS: usize = 4_096;

/// The 8-bit code of linear light from 0 to 1.
static CODES: LazyLock<[u8; STEPS + 1]> = LazyLock::new(|| {
    let mut codes = [0; STEPS + 1];
    for (step, code) in codes.iter_mut().enumerate() {
        let linear = step as f32 / STEPS as f32;
        let coded = if linear <= 0.003_130_8 {
            12.92 * linear
        } else {
            1.055 * libm::powf(linear, 1.0 / 2.4) - 0.055
        };
        *code = (coded * 255.0 + 0.5) as u8;
    }
    codes
});

/// Puts the pixels before black, as a canvas has them, into `shown`.
pub(crate) fn show(pixels: &[Pixel], shown: &mut Vec<u8>) {
    let codes = &*CODES;
    let code = |linear: f32| codes[((linear * STEPS as f32) as usize).min(STEPS)];
    shown.resize(4 * pixels.len(), 255);
    for (pixel, [red, green, blue, _]) in pixels.iter().zip(shown.as_chunks_mut().0) {
        [*red, *green, *blue] = [pixel.red, pixel.green, pixel.blue].map(code);
    }
}
