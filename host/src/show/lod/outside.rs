use super::{level, seen};
use crate::picture::{Picture, srgb_from_linear};
use shisen_core::frame::{LevelOfDetail, View};

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

    /// The number of pixels outside the visual field.
    pub const fn pixels(&self) -> u64 {
        self.pixels
    }

    /// The root mean square error in codes, 0 to 255; `None` where no pixel is outside.
    pub fn root_mean_square(&self) -> Option<f64> {
        (self.pixels > 0).then(|| libm::sqrt(self.squares / self.pixels as f64))
    }

    /// The peak signal-to-noise ratio, decibels; `None` where no pixel is outside or none
    /// differs.
    pub fn psnr(&self) -> Option<f64> {
        let error = self.root_mean_square().filter(|&error| error > 0.0)?;
        Some(20.0 * libm::log10(255.0 / error))
    }
}
