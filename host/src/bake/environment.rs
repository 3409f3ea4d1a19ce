//! A picture around a scene as the core has it.

use super::blob::Tables;
use crate::scene::environment::Environment;
use rayon::prelude::*;
use shisen_core::scene::format::{self, Texel, reading, texture, wrap};
use std::f64::consts::PI;
use zerocopy::FromZeros as _;

type Pixel = [f32; 3];

impl<const W: usize> Tables<W> {
    /// Adds a picture; returns the number of its texture.
    pub(super) fn add_environment(&mut self, environment: &Environment) -> u32 {
        let (texels, levels) = texels(environment);
        let [width, height] = environment.image.sides().map(|side| side as u32);
        self.textures.push(format::Texture {
            kind: texture::IMAGE,
            width,
            height,
            first_texel: self.texels,
            map: [[1.0, 0.0], [0.0, 1.0], [0.0; 2]],
            wrap: [wrap::REPEAT, wrap::CLAMP],
            reading: reading::SHARED_EXPONENT,
            levels,
            ..format::Texture::new_zeroed()
        });
        self.texels += texels.len() as u32;
        self.images.push((None, texels));
        self.textures.len() as u32 - 1
    }
}

/// Returns the texels of a picture and of its coarser levels, one after another, and the number of
/// levels.
pub(super) fn texels(environment: &Environment) -> (Vec<Texel>, u32) {
    let mut sides = environment.image.sides();
    let strength = environment.strength;
    let pixels = environment.image.pixels().iter();
    let bright = |channel: f32| (channel * strength).min(1.0e12);
    let mut level: Vec<Pixel> = pixels.map(|pixel| pixel.map(bright)).collect();
    let (mut all, mut count) = (Vec::new(), 0);
    loop {
        all.extend(evened(&level, sides).into_iter().map(texel));
        count += 1;
        if sides == [1, 1] {
            return (all, count);
        }
        (level, sides) = halved(&level, sides);
    }
}

/// Returns a level whose texels are the means over as wide an angle as they are high: a row at a pole
/// is of one colour.
fn evened(pixels: &[Pixel], [width, height]: [usize; 2]) -> Vec<Pixel> {
    let rows = pixels.par_chunks(width).enumerate();
    let rows = rows.flat_map_iter(|(row, pixels)| {
        let sine = (PI * (row as f64 + 0.5) / height as f64).sin();
        let wide = width as f64 / (2.0 * height as f64 * sine);
        let is_pole = row == 0 || row + 1 == height;
        let wide = if is_pole {
            width as f64
        } else {
            wide.min(width as f64)
        };
        // Sums of three turns, of which the middle one is meant.
        let mut sums = vec![[0.0; 3]];
        for pixel in pixels.iter().cycle().take(3 * width) {
            let last = sums[sums.len() - 1];
            sums.push([0, 1, 2].map(|channel| last[channel] + f64::from(pixel[channel])));
        }
        let sum = move |to: f64| {
            let (first, share) = (to as usize, to.fract());
            let after = sums[(first + 1).min(3 * width)];
            let before = sums[first];
            [0, 1, 2].map(|channel| before[channel] + share * (after[channel] - before[channel]))
        };
        (0..width).map(move |column| {
            if wide <= 1.0 {
                return pixels[column];
            }
            let middle = (width + column) as f64 + 0.5;
            let (from, to) = (sum(middle - 0.5 * wide), sum(middle + 0.5 * wide));
            [0, 1, 2].map(|channel| ((to[channel] - from[channel]) / wide) as f32)
        })
    });
    rows.collect()
}

/// Returns the next coarser level: means of light over solid angles.
pub(super) fn halved(pixels: &[Pixel], [width, height]: [usize; 2]) -> (Vec<Pixel>, [usize; 2]) {
    let sides = [width, height].map(|side| (side / 2).max(1));
    let [columns, rows] = [super::levels::parts(width), super::levels::parts(height)];
    let coarser = rows.par_iter().flat_map_iter(|row| {
        columns.iter().map(move |column| {
            let (mut sum, mut all) = ([0.0; 3], 0.0);
            for &(y, of_row) in row {
                let sine = (PI * (y as f64 + 0.5) / height as f64).sin();
                for &(x, of_column) in column {
                    let share = sine * f64::from(of_row) * f64::from(of_column);
                    for (sum, channel) in sum.iter_mut().zip(pixels[y * width + x]) {
                        *sum += share * f64::from(channel);
                    }
                    all += share;
                }
            }
            sum.map(|channel: f64| (channel / all) as f32)
        })
    });
    (coarser.collect(), sides)
}

/// Returns red, green and blue with the exponent that they share.
fn texel(pixel: Pixel) -> Texel {
    let most = pixel.into_iter().fold(0.0, f32::max);
    // The power of two at or below; a mantissa that would round up to 256 takes the next.
    let (_, power) = libm::frexpf(most * (1.0 + 1.0 / 512.0));
    let exponent = (power + 128).clamp(0, i32::from(reading::MOST_EXPONENT));
    if exponent <= 9 || most == 0.0 {
        return [0; 4];
    }
    let unit = libm::exp2f((exponent - 136) as f32);
    let [r, g, b] = pixel.map(|channel| (channel / unit).round().min(255.0) as u8);
    [r, g, b, exponent as u8]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_texel_is_its_light_within_a_256th_of_its_brightest_channel() {
        for most in [1.0e-30, 1.0e-3, 0.999, 1.0, 1.5, 255.9, 1.0e12_f32] {
            let pixel = [most, 0.3 * most, 0.0];
            let [r, g, b, exponent] = texel(pixel);
            let unit = libm::exp2f(f32::from(exponent) - 136.0);
            for (code, channel) in [r, g, b].into_iter().zip(pixel) {
                let found = f32::from(code) * unit;
                assert!((found - channel).abs() <= most / 255.0, "{found} {channel}");
            }
        }
        assert_eq!(texel([0.0; 3]), [0; 4]);
    }
}
