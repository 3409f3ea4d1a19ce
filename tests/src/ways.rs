//! Ways to render a frame, all of which make the same.

use shisen::render::{Frame, Options};
use shisen_core::Simd;
use shisen_core::frame::{Mode, Settings, Statistics};

/// Settings for a mode and a number of samples.
pub fn settings(mode: Mode, samples: u16) -> Settings {
    Settings {
        mode,
        samples,
        ..Settings::default()
    }
}

/// Options for a number of threads and of pixels a side of tiles.
pub fn options(threads: usize, tile: u32, mode: Mode, simd: Simd) -> Options {
    Options {
        threads,
        tile,
        simd,
        settings: settings(mode, 1),
        ..Options::default()
    }
}

/// Holds a frame of a scene so many lanes `wide` against one ray by ray in tiles of
/// whole blocks: pixels and rays, and all that was counted where both went so.
pub fn assert_same(way: &str, found: &Frame, reference: &Frame, wide: usize, options: &Options) {
    let rays = |statistics: &Statistics| Statistics {
        steps: 0,
        deepest_stack: 0,
        ..*statistics
    };
    let (of, expected) = (&found.statistics, &reference.statistics);
    assert_eq!(found.hash(), reference.hash(), "{way}");
    assert_eq!(rays(of), rays(expected), "{way}");
    let by_ray = options.settings.mode == Mode::Single && options.tile.is_multiple_of(8);
    if wide == 8 && by_ray {
        assert_eq!(of, expected, "{way}");
    }
}
