//! What the level of detail of the gaze does to a screen: numbers and pictures.

mod outside;
mod pictures;

pub use outside::OutsideDifference;
pub use pictures::{difference, levels, polygons, sampling};

use shisen_core::frame::{LevelOfDetail, View};
use shisen_core::gaze::Detail;

/// What share of a screen's pixels is in which zone, and what they get; of a
/// dome, of those inside its rim.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Coverage {
    /// Share of pixels of level 1.
    pub central: f64,
    /// Share of pixels with a level between 0 and 1.
    pub peripheral: f64,
    /// Share of pixels that are not traced.
    pub outside: f64,
    /// Mean level of all pixels.
    pub mean_level: f64,
    /// Mean of the reflections and refractions allowed (eq. 9), all pixels.
    pub mean_bounces: f64,
}

impl Coverage {
    /// Of a view in which rays of level 1 may bounce `depth` times.
    pub fn new(view: &View, lod: &LevelOfDetail, depth: u8) -> Self {
        let mut sum = Self::default();
        let mut pixels = 0u32;
        for (x, y) in seen(view) {
            let level = level(view, lod, x, y);
            pixels += 1;
            match level {
                1.0 => sum.central += 1.0,
                0.0 => sum.outside += 1.0,
                _ => sum.peripheral += 1.0,
            }
            sum.mean_level += f64::from(level);
            let bounces = Detail::of_level(level).map_or(0, |detail| detail.bounces(depth));
            sum.mean_bounces += f64::from(bounces);
        }
        let share = 1.0 / f64::from(pixels.max(1));
        Self {
            central: sum.central * share,
            peripheral: sum.peripheral * share,
            outside: sum.outside * share,
            mean_level: sum.mean_level * share,
            mean_bounces: sum.mean_bounces * share,
        }
    }
}

/// The level of a pixel: 0 to 1.
fn level(view: &View, lod: &LevelOfDetail, x: u32, y: u32) -> f32 {
    view.direction(x as f32, y as f32)
        .and_then(|direction| lod.gaze.level(direction))
        .unwrap_or(0.0)
}

/// All pixels, in rows.
fn places(view: &View) -> impl Iterator<Item = (u32, u32)> + use<> {
    let (columns, rows) = (view.columns(), view.rows());
    (0..rows).flat_map(move |y| (0..columns).map(move |x| (x, y)))
}

/// Those that show anything: of a dome, inside its rim.
fn seen(view: &View) -> impl Iterator<Item = (u32, u32)> {
    places(view).filter(|&(x, y)| view.direction(x as f32, y as f32).is_some())
}
