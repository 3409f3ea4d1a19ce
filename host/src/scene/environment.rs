//! A picture of all that is far away, from `OpenEXR` and Radiance files.

use crate::files::{Fault, UNREAD, read_within};
use exr::math::Vec2;
use exr::prelude::{ReadChannels as _, ReadLayers as _};
use shisen_core::scene::format::LARGEST_SIDE;
use std::f64::consts::PI;
use std::io::{Cursor, ErrorKind};
use std::path::Path;
use std::sync::Arc;

/// A picture around a scene, instead of its background's gradient: from left to right a turn about
/// +Y, and from +Y at the top to −Y.
#[derive(Debug, Clone, PartialEq)]
pub struct Environment {
    /// The picture.
    pub image: Arc<Radiance>,
    /// The turn of its middle from −Z towards −X: radians, up to a turn.
    pub yaw: f32,
    /// Factor for its light, 0 or more.
    pub strength: f32,
}

impl Environment {
    /// Returns the mean light between two heights of directions, from −1 to 1.
    pub(super) fn mean(&self, heights: [f64; 2]) -> [f32; 3] {
        let mean = self.image.mean(heights);
        mean.map(|channel| (channel * self.strength).min(1.0e12))
    }
}

/// Linear red, green and blue of a picture.
#[derive(Debug, Clone, PartialEq)]
pub struct Radiance {
    sides: [usize; 2],
    pixels: Vec<[f32; 3]>,
    replaced: u64,
}

impl Radiance {
    /// Largest file: MiB.
    const MOST_MIB: u64 = 100;
    /// Most pixels: 8192 × 4096.
    const MOST_PIXELS: usize = 1 << 25;
    /// The brightest light, as that of other lights.
    const BRIGHTEST: f32 = 1.0e12;

    /// Returns a picture of pixels, row by row from the top; `None` if a side is not 1 to
    /// [`LARGEST_SIDE`], or their number above 2²⁵ or not width × height. A channel that
    /// is negative or no number becomes 0, and one that is infinite or above 10¹² the highest of the
    /// others.
    pub fn new(sides: [usize; 2], mut pixels: Vec<[f32; 3]>) -> Option<Self> {
        if !Self::fits(sides) || pixels.len() != sides[0] * sides[1] {
            return None;
        }
        let is_light = |channel: &f32| (0.0..=Self::BRIGHTEST).contains(channel);
        let known = pixels.as_flattened().iter().copied().filter(is_light);
        let most = known.fold(0.0, f32::max);
        let mut replaced = 0;
        for pixel in pixels
            .iter_mut()
            .filter(|pixel| !pixel.iter().all(is_light))
        {
            replaced += 1;
            *pixel = pixel.map(|channel| match channel {
                channel if is_light(&channel) => channel,
                channel if channel > 0.0 => most,
                _ => 0.0,
            });
        }
        Some(Self {
            sides,
            pixels,
            replaced,
        })
    }

    fn fits(sides: [usize; 2]) -> bool {
        let fits = |side: &usize| (1..=LARGEST_SIDE as usize).contains(side);
        sides.iter().all(fits) && sides[0] * sides[1] <= Self::MOST_PIXELS
    }

    /// Reads an `OpenEXR` or Radiance file.
    ///
    /// # Errors
    /// What is wrong, where, and what to do.
    pub(crate) fn load(path: &Path) -> Result<Self, Fault> {
        let told = |fault: &str, help: &str| {
            Fault::new(format!("{}: {fault}", path.display()), help.to_owned())
        };
        let help = "save it again as .exr or .hdr, smaller if it is too large";
        let bytes = read_within(path, Self::MOST_MIB).map_err(|fault| match fault.kind() {
            ErrorKind::FileTooLarge => told(&fault.to_string(), help),
            _ => told(&fault.to_string(), UNREAD),
        })?;
        let (decoded, help) = if bytes.starts_with(&[0x76, 0x2f, 0x31, 0x01]) {
            let help =
                "save it again with the channels R, G and B; if it may be cut off, copy it anew";
            (open_exr(&bytes), help)
        } else if bytes.starts_with(b"#?") {
            let help = "save it as .exr, or as .hdr with FORMAT=32-bit_rle_rgbe, rows of -Y N +X N \
                        and runs in the new form";
            (radiance(&bytes), help)
        } else {
            let fault = "neither an OpenEXR nor a Radiance file".to_owned();
            (Err(fault), help)
        };
        let (sides, pixels) = decoded.map_err(|fault| told(&fault, help))?;
        let [width, height] = sides;
        Self::new(sides, pixels).ok_or_else(|| {
            let fault = format!(
                "it has {width} × {height} pixels, but either side may have 1 to {LARGEST_SIDE}, \
                 and the picture {}",
                Self::MOST_PIXELS
            );
            told(&fault, "save it again with 8192 × 4096 pixels or fewer")
        })
    }

    /// Returns pixels from left to right, and from top to bottom.
    pub const fn sides(&self) -> [usize; 2] {
        self.sides
    }

    /// Returns its pixels, row by row from the top.
    pub fn pixels(&self) -> &[[f32; 3]] {
        &self.pixels
    }

    /// Returns the number of pixels whose light was none that can be.
    pub const fn replaced(&self) -> u64 {
        self.replaced
    }

    /// Returns the mean light from the directions between two heights, −1 to 1; from those around the
    /// height in the middle where there are none.
    pub fn mean(&self, [low, high]: [f64; 2]) -> [f32; 3] {
        let [width, height] = self.sides;
        let edge = |row: usize| (PI * row as f64 / height as f64).cos();
        let (mut sum, mut all) = ([0.0; 3], 0.0);
        for (row, pixels) in self.pixels.chunks(width).enumerate() {
            let (top, bottom) = (edge(row).min(high), edge(row + 1).max(low));
            let share = (top - bottom).max(0.0);
            for pixel in pixels {
                for (sum, channel) in sum.iter_mut().zip(pixel) {
                    *sum += share * f64::from(*channel);
                }
            }
            all += share * width as f64;
        }
        sum.map(|channel| (channel / all) as f32)
    }
}

type Pixels = ([usize; 2], Vec<[f32; 3]>);

fn open_exr(bytes: &[u8]) -> Result<Pixels, String> {
    let fault = |fault: exr::error::Error| {
        format!("no picture of the channels R, G and B can be read from it ({fault})")
    };
    let read = exr::meta::MetaData::read_from_buffered(Cursor::new(bytes), false);
    for header in &read.map_err(fault)?.headers {
        // Before anything is allocated for it.
        let Vec2(width, height) = header.layer_size;
        if !Radiance::fits([width, height]) {
            return Ok(([width, height], Vec::new()));
        }
    }
    let reader = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level();
    let image = reader
        .rgb_channels(
            |Vec2(width, height), _| ([width, height], vec![[0.0; 3]; width * height]),
            |(sides, pixels): &mut Pixels, Vec2(x, y), (r, g, b): (f32, f32, f32)| {
                pixels[y * sides[0] + x] = [r, g, b];
            },
        )
        .first_valid_layer()
        .all_attributes()
        .non_parallel()
        .from_buffered(Cursor::new(bytes));
    Ok(image.map_err(fault)?.layer_data.channel_data.pixels)
}

/// Reads a Radiance file, whose rows go down and to the right: with runs, or without.
fn radiance(bytes: &[u8]) -> Result<Pixels, String> {
    let cut_off = || "the Radiance file is cut off or damaged".to_owned();
    let mut rest = bytes;
    let mut line = || {
        let end = rest.iter().position(|&byte| byte == b'\n');
        let (line, after) = rest.split_at(end.ok_or_else(cut_off)?);
        rest = &after[1..];
        // Errors quote lines.
        Ok::<_, String>(String::from_utf8_lossy(&line[..line.len().min(100)]))
    };
    let mut exposure = 1.0;
    loop {
        let line = line()?;
        match line.split_once('=') {
            _ if line.is_empty() => break,
            _ if line.ends_with('\r') => {
                return Err("the lines of its header end with CR and LF, not LF alone".to_owned());
            }
            Some(("FORMAT", format)) if format.trim() != "32-bit_rle_rgbe" => {
                return Err(format!(
                    "its pixels are {}, which is not read",
                    format.trim()
                ));
            }
            Some(("EXPOSURE", factor)) => match factor.trim().parse::<f64>() {
                Ok(factor) if factor > 0.0 && factor.is_finite() => exposure *= factor,
                _ => return Err(format!("its EXPOSURE={factor} is no number above 0")),
            },
            _ => {}
        }
    }
    let line = line()?;
    let words: Vec<&str> = line.split_whitespace().collect();
    let sides = match words[..] {
        ["-Y", height, "+X", width] => width.parse().ok().zip(height.parse().ok()),
        _ => None,
    };
    let sides = sides.ok_or_else(|| format!("its rows are {line:?}, not -Y N +X N"))?;
    let (width, height): (usize, usize) = sides;
    if !Radiance::fits([width, height]) {
        return Ok(([width, height], Vec::new()));
    }
    let mut rest = rest.iter().copied();
    let mut byte = || rest.next().ok_or_else(cut_off);
    let mut pixels = Vec::with_capacity(width * height);
    for _ in 0..height {
        let head: [u8; 4] = [byte()?, byte()?, byte()?, byte()?];
        let mut row = vec![[0; 4]; width];
        if head[..2] == [2, 2] && usize::from(head[2]) << 8 | usize::from(head[3]) == width {
            for channel in 0..4 {
                let mut column = 0;
                while column < width {
                    let count = byte()?;
                    let run = (count > 128).then(&mut byte).transpose()?;
                    for _ in 0..if count > 128 { count - 128 } else { count } {
                        let value = run.map_or_else(&mut byte, Ok)?;
                        row.get_mut(column).ok_or_else(cut_off)?[channel] = value;
                        column += 1;
                    }
                    if count == 0 {
                        return Err(cut_off());
                    }
                }
            }
        } else {
            row[0] = head;
            for pixel in &mut row[1..] {
                *pixel = [byte()?, byte()?, byte()?, byte()?];
                if pixel[..3] == [1; 3] {
                    return Err("its rows have runs in the old form".to_owned());
                }
            }
        }
        pixels.extend(row.into_iter().map(|[r, g, b, exponent]| {
            let unit = libm::exp2(f64::from(exponent) - 136.0);
            let unit = if exponent == 0 { 0.0 } else { unit / exposure };
            [r, g, b].map(|channel| (f64::from(channel) * unit) as f32)
        }));
    }
    Ok(([width, height], pixels))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn light_that_cannot_be_is_replaced_and_counted() {
        let odd = [f32::NAN, -1.0, 0.5];
        let pixels = vec![odd, [f32::INFINITY, 2.0, 3.0], [1.0; 3]];
        let image = Radiance::new([3, 1], pixels).unwrap();
        assert_eq!(image.pixels(), [[0.0, 0.0, 0.5], [3.0, 2.0, 3.0], [1.0; 3]]);
        assert_eq!(image.replaced(), 2);
        assert_eq!(Radiance::new([8193, 1], vec![[0.0; 3]; 8193]), None);
    }

    #[test]
    fn radiance_files_are_read_with_runs_and_without_and_cut_off_ones_refused() {
        let head = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\nEXPOSURE=.5\nEXPOSURE= 4\n\n-Y 1 +X 8\n";
        let flat = [&head[..], &[128, 64, 0, 130].repeat(8)].concat();
        let runs = [
            2, 2, 0, 8, 136, 128, 136, 64, 4, 0, 0, 0, 0, 132, 0, 136, 130,
        ];
        let coded = [&head[..], &runs].concat();
        let expected = ([8, 1], vec![[1.0, 0.5, 0.0]; 8]);
        for bytes in [flat, coded] {
            assert_eq!(radiance(&bytes), Ok(expected.clone()));
            for length in 0..bytes.len() {
                assert!(radiance(&bytes[..length]).is_err(), "{length}");
            }
        }
    }
}
