use super::{level, seen};
use crate::picture::{Picture, srgb_from_linear};
use shisen_core::frame::{LevelOfDetail, View};

/// How far pictures are from what they should be where the gaze skips rays, as
/// a display shows them: sums over all pictures of a frame.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct OutsideDifference {
    squares: f64,
    pixels: u64,
}

impl OutsideDifference {
    /// Counts the pixels of a view that are outside the visual field: those
    /// found, and those that full tracing finds.
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

    /// How many pixels there are outside.
    pub const fn pixels(&self) -> u64 {
        self.pixels
    }

    /// The square root of the mean square: codes, 0 to 255; `None` where no
    /// pixel is outside.
    pub fn root_mean_square(&self) -> Option<f64> {
        (self.pixels > 0).then(|| libm::sqrt(self.squares / self.pixels as f64))
    }

    /// The peak signal-to-noise ratio: decibels; `None` where no pixel is
    /// outside, or none differs.
    pub fn psnr(&self) -> Option<f64> {
        let error = self.root_mean_square().filter(|&error| error > 0.0)?;
        Some(20.0 * libm::log10(255.0 / error))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;
    use shisen_core::gaze::{Gaze, LineOfSight, VisualField};

    #[test]
    fn only_pixels_outside_the_field_count() {
        // A floor far below, half of it behind the viewer.
        let first = Vec3::new(-7.5, -2.0, -7.5);
        let view = View::new(Vec3::ZERO, first, Vec3::X, Vec3::Z, [16, 16]).unwrap();
        let sight = LineOfSight::new(Vec3::ZERO, Vec3::NEG_Z, Vec3::Y).unwrap();
        let lod = LevelOfDetail::new(Gaze::new(sight, VisualField::PAPER));
        let picture = |value: f32| {
            let pixels = vec![[value, value, value, 1.0]; 256];
            Picture::from_pixels(16, 16, pixels).unwrap()
        };
        let (black, white) = (picture(0.0), picture(1.0));
        let mut error = OutsideDifference::default();
        assert_eq!((error.psnr(), error.root_mean_square()), (None, None));
        error.add(&view, &lod, &white, &white);
        let outside = error.pixels();
        assert!((64..160).contains(&outside), "{outside}");
        assert_eq!((error.psnr(), error.root_mean_square()), (None, Some(0.0)));
        error.add(&view, &lod, &black, &white);
        assert_eq!(error.pixels(), 2 * outside);
        // Half of all pixels are as far off as can be.
        let right = 255.0 * 0.5f64.sqrt();
        assert!((error.root_mean_square().unwrap() - right).abs() < 1e-9);
        assert!((error.psnr().unwrap() - 3.010_3).abs() < 1e-4);
    }
}
