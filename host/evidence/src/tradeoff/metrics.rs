//! How far a picture is from the one that it should be, and whether a viewer would see it.
//!
//! Three measures, each of what a display shows: the peak signal-to-noise ratio
//! of its 8-bit codes; FLIP (Andersson et al., 2020), 0 for equal to 1, at the
//! display's own pixels per degree, or 2, which it needs; and structural
//! similarity (Wang et al., "Image Quality Assessment: From Error Visibility to
//! Structural Similarity", 2004) of its luma, 1 for equal.
//!
//! Each is taken over all pixels, over those of each [`Ring`] round the line of
//! sight, and weighted by how much of the primary visual cortex looks at a pixel:
//! its solid angle times the square of Horton & Hoyt's magnification, 17.3 mm by
//! E + 0.75°, of its eccentricity E ("The Representation of the Visual Field in
//! Human Striate Cortex", 1991).

mod similarity;

use super::{Measure, measure};
use glam::{DVec4, Vec3};
use nv_flip::FlipImageRgb8;
use rayon::prelude::*;
use shisen::picture::{Picture, srgb_from_linear};
use shisen_core::frame::View;
use similarity::similarities;

/// The least pixels a degree of FLIP: coarser pictures are compared as if seen from farther.
/// With fewer, its filters of edges and points, Gaussians of 0.041°, are 0 beside the middle
/// pixel.
pub(super) const LEAST_PIXELS_PER_DEGREE: f32 = 2.0;

/// A part of the field of view, by degrees from the line of sight: Rayner's, "Eye
/// Movements in Reading and Information Processing", 1998.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ring {
    /// To 1°: the point that is looked at.
    Fovea,
    /// To 5°.
    Parafovea,
    /// Beyond.
    Periphery,
}

impl Ring {
    /// All of them, from the middle outwards.
    pub const ALL: [Self; 3] = [Self::Fovea, Self::Parafovea, Self::Periphery];

    /// Returns the ring at an angle from the line of sight, degrees.
    pub fn of(degrees: f32) -> Self {
        match degrees {
            ..=1.0 => Self::Fovea,
            ..=5.0 => Self::Parafovea,
            _ => Self::Periphery,
        }
    }
}

/// How a viewer sees the pixels of a view.
#[derive(Debug, Clone)]
pub struct Sight {
    rings: Vec<Ring>,
    /// In proportion to the cortex that sees the pixel; 0 where it shows nothing.
    weights: Vec<f64>,
    pixels_per_degree: f32,
}

impl Sight {
    /// `forward` is the viewer's line of sight, of any length but 0.
    pub fn new(view: &View, forward: Vec3) -> Self {
        let forward = forward.as_dvec3().normalize_or_zero();
        let towards = |x: f32, y: f32| {
            let direction = view.direction(x, y)?;
            Some(direction.as_dvec3().normalize_or_zero())
        };
        let (mut rings, mut weights) = (Vec::new(), Vec::new());
        let mut widest: f64 = 0.0;
        for y in 0..view.rows() {
            for x in 0..view.columns() {
                let (x, y) = (x as f32, y as f32);
                let edges = [(-0.5, 0.0), (0.5, 0.0), (0.0, -0.5), (0.0, 0.5)];
                let edges = edges.map(|(right, down)| towards(x + right, y + down));
                let (Some(middle), [Some(left), Some(right), Some(above), Some(below)]) =
                    (towards(x, y), edges)
                else {
                    rings.push(Ring::Periphery);
                    weights.push(0.0);
                    continue;
                };
                let across = right - left;
                widest = widest.max(across.length());
                let apart = middle.cross(forward).length();
                let degrees = libm::atan2(apart, middle.dot(forward)).to_degrees();
                let magnification = 17.3 / (degrees + 0.75);
                rings.push(Ring::of(degrees as f32));
                weights.push(across.cross(below - above).length() * magnification * magnification);
            }
        }
        Self {
            rings,
            weights,
            pixels_per_degree: (1.0 / widest.to_degrees()) as f32,
        }
    }

    /// Returns the number of pixels in a ring.
    pub fn pixels(&self, ring: Ring) -> usize {
        let seen = self.rings.iter().zip(&self.weights);
        seen.filter(|&(of, &weight)| *of == ring && weight > 0.0)
            .count()
    }

    /// Returns the least number of pixels a degree; on a wall, at the foot of the perpendicular.
    pub const fn pixels_per_degree(&self) -> f32 {
        self.pixels_per_degree
    }
}

/// The measures over some pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Quality {
    /// Decibels; `None` where nothing differs.
    pub psnr: Option<f64>,
    /// 0 to 1, less is better; where there are fewer than 2 pixels a degree, as if seen
    /// from as far as there are 2.
    pub flip: f64,
    /// −1 to 1, more is better.
    pub ssim: f64,
}

impl Quality {
    const EQUAL: Self = Self {
        psnr: None,
        flip: 0.0,
        ssim: 1.0,
    };
}

/// How far pictures are from what they should be.
#[derive(Debug, Clone, PartialEq)]
pub struct PictureDifference {
    /// All pixels alike.
    pub all: Quality,
    /// Weighted by the cortex that sees them.
    pub weighted: Quality,
    /// The quality in each [`Ring`]; `None` for a ring without pixels.
    pub rings: [Option<Quality>; 3],
    /// The sums of `weighted`, ring by ring.
    by_acuity: [Sum; 3],
}

impl PictureDifference {
    /// Compares the pictures of a frame, each with its sight: as found, and as they should be.
    /// Pictures have the pixels of their view.
    pub fn new(pictures: &[(&Sight, &Picture, &Picture)]) -> Self {
        let sums: Vec<Sums> = pictures
            .par_iter()
            .map(|&(sight, found, truth)| sums(sight, found, truth))
            .collect();
        let of_rings = |of: fn(&Sums) -> &[Sum; 3]| {
            [0, 1, 2].map(|ring| sums.iter().map(|sums| of(sums)[ring]).sum::<Sum>())
        };
        let by_acuity = of_rings(|sums| &sums.by_acuity);
        let all = sums.iter().map(|sums| sums.all).sum();
        Self {
            all: quality(all).unwrap_or(Quality::EQUAL),
            weighted: weighted(&by_acuity),
            rings: of_rings(|sums| &sums.by_pixels).map(quality),
            by_acuity,
        }
    }
}

pub(super) const MEASURES: [Measure; 15] = [
    measure("flip_weighted", "FLIP by acuity"),
    measure("flip_fovea", "FLIP to 1°"),
    measure("flip_parafovea", "FLIP to 5°"),
    measure("flip_periphery", "FLIP beyond"),
    measure("flip", "FLIP"),
    measure("psnr_weighted_db", "PSNR by acuity, dB"),
    measure("psnr_fovea_db", "PSNR to 1°, dB"),
    measure("psnr_parafovea_db", "PSNR to 5°, dB"),
    measure("psnr_periphery_db", "PSNR beyond, dB"),
    measure("psnr_db", "PSNR, dB"),
    measure("ssim_weighted", "SSIM by acuity"),
    measure("ssim_fovea", "SSIM to 1°"),
    measure("ssim_parafovea", "SSIM to 5°"),
    measure("ssim_periphery", "SSIM beyond"),
    measure("ssim", "SSIM"),
];

impl PictureDifference {
    /// Replaces the fovea and the parafovea, in the rings and in `weighted`, by those of pictures
    /// with more pixels there, for the same eyes. Weights are solid angles, so that those of fine
    /// and of coarse pixels add up.
    pub(super) fn with_middle_of(mut self, near: &Self) -> Self {
        self.rings[..2].copy_from_slice(&near.rings[..2]);
        self.by_acuity[..2].copy_from_slice(&near.by_acuity[..2]);
        self.weighted = weighted(&self.by_acuity);
        self
    }

    /// Returns the errors by [`MEASURES`].
    pub(super) fn errors(&self) -> Vec<Option<f64>> {
        let [fovea, parafovea, periphery] = self.rings;
        let parts = [
            Some(self.weighted),
            fovea,
            parafovea,
            periphery,
            Some(self.all),
        ];
        let by = |of: fn(Quality) -> Option<f64>| parts.map(|part| part.and_then(of));
        let flip = by(|one| Some(one.flip));
        let ssim = by(|one| Some(one.ssim));
        [flip, by(|one| one.psnr), ssim].concat()
    }
}

fn sums(sight: &Sight, found: &Picture, truth: &Picture) -> Sums {
    let codes = [found, truth].map(|picture| {
        let pixels = picture.pixels.iter();
        let codes = pixels.map(|&[r, g, b, _]| [r, g, b].map(srgb_from_linear));
        codes.collect::<Vec<[u8; 3]>>()
    });
    let [found_codes, true_codes] = &codes;
    let (width, height) = (truth.width, truth.height);
    // Equal pictures need no maps.
    let maps = (found_codes != true_codes).then(|| {
        let image =
            |codes: &[[u8; 3]]| FlipImageRgb8::with_data(width, height, codes.as_flattened());
        let pixels_per_degree = sight.pixels_per_degree.max(LEAST_PIXELS_PER_DEGREE);
        let flip = nv_flip::flip(image(true_codes), image(found_codes), pixels_per_degree);
        let luma = |codes: &[[u8; 3]]| codes.iter().copied().map(luma).collect::<Vec<f64>>();
        let ssim = similarities(&luma(found_codes), &luma(true_codes), width as usize);
        (flip.to_vec(), ssim)
    });
    let mut sums = Sums::default();
    for (index, (ring, &weight)) in sight.rings.iter().zip(&sight.weights).enumerate() {
        if weight == 0.0 {
            continue;
        }
        // Weight, mean square of the codes' differences, FLIP and similarity.
        let mut sum = Sum::new(1.0, 0.0, 0.0, 1.0);
        if let Some((flips, similarities)) = &maps {
            for (&a, &b) in found_codes[index].iter().zip(&true_codes[index]) {
                let off = f64::from(a) - f64::from(b);
                sum.y += off * off / 3.0;
            }
            (sum.z, sum.w) = (f64::from(flips[index]), similarities[index]);
        }
        sums.all += sum;
        sums.by_pixels[*ring as usize] += sum;
        sums.by_acuity[*ring as usize] += weight * sum;
    }
    sums
}

/// Rec. 709's luma of 8-bit codes.
fn luma([red, green, blue]: [u8; 3]) -> f64 {
    0.2126 * f64::from(red) + 0.7152 * f64::from(green) + 0.0722 * f64::from(blue)
}

/// The sums over a picture; over each ring, all pixels alike, and by the cortex that sees them.
#[derive(Default)]
struct Sums {
    all: Sum,
    by_pixels: [Sum; 3],
    by_acuity: [Sum; 3],
}

/// Sums of weights, and of squares, FLIP and similarities times the weights.
type Sum = DVec4;

fn quality(sum: Sum) -> Option<Quality> {
    let mean = sum / sum.x;
    (sum.x > 0.0).then(|| Quality {
        psnr: (mean.y > 0.0).then(|| 10.0 * libm::log10(255.0 * 255.0 / mean.y)),
        flip: mean.z,
        ssim: mean.w,
    })
}

fn weighted(by_acuity: &[Sum; 3]) -> Quality {
    quality(by_acuity.iter().sum()).unwrap_or(Quality::EQUAL)
}

#[cfg(test)]
mod tests;
