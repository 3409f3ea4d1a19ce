//! The effect of the level of detail on a screen: numbers and pictures.

mod pictures;

pub use pictures::difference;
pub(crate) use pictures::{levels, polygons, units};

use crate::picture::{Picture, srgb_from_linear};
use schemars::JsonSchema;
use serde::Serialize;
use shisen_core::frame::{LevelOfDetail, View};
use shisen_core::gaze::Detail;

/// The shares of a screen's pixels by zone, and their mean detail. On a dome only pixels inside
/// the rim count.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, JsonSchema)]
pub struct Coverage {
    /// The share of pixels of level 1.
    pub central: f64,
    /// The share of pixels with a level between 0 and 1.
    pub peripheral: f64,
    /// The share of pixels that are not traced.
    pub outside: f64,
    /// The mean level of all pixels.
    pub mean_level: f64,
    /// The mean number of reflections and refractions allowed (eq. 9).
    pub mean_bounces: f64,
}

impl Coverage {
    /// Measures a view in which rays of level 1 may bounce `depth` times.
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

/// The error of pictures where the gaze skips rays, in the codes that a display shows, summed
/// over all pictures of a frame.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct OutsideDifference {
    squares: f64,
    pixels: u64,
}

impl OutsideDifference {
    /// Compares the pixels of a view outside the visual field with those of full tracing.
    pub fn add(&mut self, view: &View, lod: &LevelOfDetail, found: &Picture, full: &Picture) {
        for (x, y) in seen(view).filter(|&(x, y)| level(view, lod, x, y) == 0.0) {
            let (Some(found), Some(full)) = (found.pixel(x, y), full.pixel(x, y)) else {
                continue;
            };
            for channel in 0..3 {
                let [a, b] = [found, full].map(|p| f64::from(srgb_from_linear(p[channel])));
                self.squares += (a - b) * (a - b) / 3.0;
            }
            self.pixels += 1;
        }
    }

    /// Returns the number of pixels outside the visual field.
    pub const fn pixels(&self) -> u64 {
        self.pixels
    }

    /// Returns the root mean square error in codes, 0 to 255; `None` where no pixel is outside.
    pub fn root_mean_square(&self) -> Option<f64> {
        (self.pixels > 0).then(|| libm::sqrt(self.squares / self.pixels as f64))
    }

    /// Returns the peak signal-to-noise ratio, decibels; `None` without pixels or differences.
    pub fn psnr(&self) -> Option<f64> {
        let error = self.root_mean_square().filter(|&error| error > 0.0)?;
        Some(20.0 * libm::log10(255.0 / error))
    }
}

fn level(view: &View, lod: &LevelOfDetail, x: u32, y: u32) -> f32 {
    view.direction(x as f32, y as f32)
        .and_then(|direction| lod.gaze.level(direction))
        .unwrap_or(0.0)
}

fn places(view: &View) -> impl Iterator<Item = (u32, u32)> + use<> {
    let (columns, rows) = (view.columns(), view.rows());
    (0..rows).flat_map(move |y| (0..columns).map(move |x| (x, y)))
}

fn seen(view: &View) -> impl Iterator<Item = (u32, u32)> {
    places(view).filter(|&(x, y)| view.direction(x as f32, y as f32).is_some())
}
