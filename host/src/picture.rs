//! Pictures in linear light, their files (PNG, `OpenEXR`), and charts.
//!
//! ```
//! let mut picture = shisen::picture::Picture::new(2, 1)?;
//! picture.set_pixel(0, 0, [1.0, 0.5, 0.25, 1.0]);
//! assert!(picture.png_bytes().is_ok_and(|file| file.starts_with(b"\x89PNG")));
//! # Ok::<(), shisen::picture::PictureError>(())
//! ```

pub mod chart;

pub(crate) mod glyph;

use crate::files::{WriteSeek, explain, write_atomically};
use palette::color_difference::Ciede2000;
use palette::{IntoColor, Lab, LinSrgb};
use png::{BitDepth, ColorType, SrgbRenderingIntent};
use rayon::prelude::*;
use shisen_core::frame::Pixel;
use std::io::{self, Write};
use std::path::Path;
use thiserror::Error;
use xxhash_rust::xxh3::Xxh3Default;
use zerocopy::{FromBytes, IntoBytes};

/// The most pixels a picture may have: 4 GiB of them.
pub const MAX_PIXELS: u64 = 1 << 28;

/// Pictures up to this size (64 MiB) are made without checking for free memory.
const UNASKED_PIXELS: u64 = 1 << 22;

/// Free memory, if the system says: Linux promises more than it has and ends programs that use it.
fn available_bytes() -> Option<u64> {
    let text = std::fs::read_to_string("/proc/meminfo").ok()?;
    let line = text
        .lines()
        .find_map(|line| line.strip_prefix("MemAvailable:"))?;
    let kibibytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kibibytes * 1024)
}

/// Linear RGBA with premultiplied alpha, rows from the top, row by row.
#[derive(Debug, Clone, PartialEq)]
pub struct Picture {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// `width * height` pixels.
    pub pixels: Vec<[f32; 4]>,
}

/// Why a picture could not be made or written: what is wrong, where, and what to do.
#[derive(Debug, Error)]
#[error("{0}")]
pub struct PictureError(String);

impl Picture {
    /// Returns a picture of transparent black.
    ///
    /// # Errors
    /// More than [`MAX_PIXELS`] pixels, or no memory for them.
    pub fn new(width: u32, height: u32) -> Result<Self, PictureError> {
        let count = u64::from(width) * u64::from(height);
        let mut pixels = Vec::new();
        if count > MAX_PIXELS
            || (count > UNASKED_PIXELS && available_bytes().is_some_and(|free| 16 * count > free))
            || pixels.try_reserve_exact(count as usize).is_err()
        {
            return Err(PictureError(format!(
                "a picture of {width} × {height} pixels is too large: ask for fewer than \
                 {MAX_PIXELS} pixels, and for as many as fit into memory at 16 bytes each"
            )));
        }
        pixels.resize(count as usize, [0.0; 4]);
        Ok(Self {
            width,
            height,
            pixels,
        })
    }

    /// Returns a picture of linear premultiplied pixels, rows from the top.
    ///
    /// # Errors
    /// Another number of pixels than `width * height`.
    pub fn from_pixels(
        width: u32,
        height: u32,
        pixels: Vec<[f32; 4]>,
    ) -> Result<Self, PictureError> {
        let picture = Self {
            width,
            height,
            pixels,
        };
        picture.check_count()?;
        Ok(picture)
    }

    fn check_count(&self) -> Result<(), PictureError> {
        let (width, height, found) = (self.width, self.height, self.pixels.len());
        if found as u64 == u64::from(width) * u64::from(height) {
            return Ok(());
        }
        Err(PictureError(format!(
            "a picture of {width} × {height} pixels was given {found} pixels: give width × height \
             of them, row by row"
        )))
    }

    /// Returns the pixel in column `x` from the left and row `y` from the top; `None` outside.
    pub fn pixel(&self, x: u32, y: u32) -> Option<[f32; 4]> {
        self.pixels.get(self.index(x, y)?).copied()
    }

    /// Sets a pixel, if it is in the picture.
    pub fn set_pixel(&mut self, x: u32, y: u32, value: [f32; 4]) {
        let index = self.index(x, y);
        if let Some(pixel) = index.and_then(|index| self.pixels.get_mut(index)) {
            *pixel = value;
        }
    }

    /// Returns the pixels as the core reads them.
    pub fn core_pixels(&self) -> &[Pixel] {
        // Four floats of one size and alignment: nothing is left out.
        <[Pixel]>::ref_from_bytes(self.pixels.as_bytes()).unwrap_or_default()
    }

    /// Returns the pixels as the core writes them, in bands of `rows` rows.
    pub fn rows_mut(&mut self, rows: u32) -> impl Iterator<Item = &mut [Pixel]> {
        let band = self.width as usize * rows.max(1) as usize;
        let pixels = self.pixels.chunks_mut(band.max(1));
        // Four floats of one size and alignment: nothing is left out.
        pixels.filter_map(|pixels| <[Pixel]>::mut_from_bytes(pixels.as_mut_bytes()).ok())
    }

    fn index(&self, x: u32, y: u32) -> Option<usize> {
        (x < self.width && y < self.height).then(|| y as usize * self.width as usize + x as usize)
    }

    /// Interpolates bilinearly between pixel centres, which are at half-odd coordinates from the
    /// upper left corner; the edge goes on outside. Transparent black for an empty picture or
    /// a NaN.
    pub fn sample(&self, x: f64, y: f64) -> [f32; 4] {
        if self.width == 0 || self.height == 0 || x.is_nan() || y.is_nan() {
            return [0.0; 4];
        }
        let cell = |coordinate: f64, count: u32| {
            let last = count - 1;
            let centre = (coordinate - 0.5).clamp(0.0, f64::from(last));
            let low = centre as u32;
            (low, (low + 1).min(last), centre - f64::from(low))
        };
        let (left, right, along_x) = cell(x, self.width);
        let (top, bottom, along_y) = cell(y, self.height);
        let at = |x, y| self.pixel(x, y).unwrap_or_default();
        let corners = [
            (at(left, top), (1.0 - along_x) * (1.0 - along_y)),
            (at(right, top), along_x * (1.0 - along_y)),
            (at(left, bottom), (1.0 - along_x) * along_y),
            (at(right, bottom), along_x * along_y),
        ];
        std::array::from_fn(|channel| {
            corners
                .iter()
                // A neighbour without weight must not turn infinity into NaN.
                .filter(|(_, weight)| *weight != 0.0)
                .map(|(pixel, weight)| f64::from(pixel[channel]) * weight)
                .sum::<f64>() as f32
        })
    }

    /// Returns a hash of the size and of every bit of the pixels, the same on every machine.
    pub fn hash(&self) -> u64 {
        let mut hash = Xxh3Default::new();
        hash.update(&self.width.to_le_bytes());
        hash.update(&self.height.to_le_bytes());
        // Many channels at a time: each call has its price.
        let mut bytes = [[0; 4]; 1024];
        for channels in self.pixels.as_flattened().chunks(bytes.len()) {
            let bytes = &mut bytes[..channels.len()];
            for (bytes, channel) in bytes.iter_mut().zip(channels) {
                *bytes = channel.to_bits().to_le_bytes();
            }
            hash.update(bytes.as_flattened());
        }
        hash.digest()
    }

    /// Writes 8-bit opaque sRGB, the picture before black, clipped to 0 to 1. `metadata` becomes
    /// text chunks, in the order given: tEXt for ASCII values, iTXt for others. The file
    /// appears complete or not at all, over an existing file, too.
    ///
    /// # Errors
    /// A picture that is empty or has the wrong number of pixels, a metadata key or value that is
    /// not allowed, a file that cannot be written.
    pub fn write_png(&self, path: &Path, metadata: &[(&str, String)]) -> Result<(), PictureError> {
        self.write_8_bit(path, metadata, ColorType::Rgb, srgb_of_pixel)
    }

    /// Returns the file that [`write_png`](Self::write_png) writes, without metadata.
    ///
    /// # Errors
    /// A picture that is empty or has the wrong number of pixels.
    pub fn png_bytes(&self) -> io::Result<Vec<u8>> {
        let coded: Vec<[u8; 3]> = self.pixels.iter().copied().map(srgb_of_pixel).collect();
        let mut file = Vec::new();
        let (size, bytes) = ([self.width, self.height], coded.as_flattened());
        encode_png(&mut file, size, ColorType::Rgb, bytes, &[])?;
        Ok(file)
    }

    /// As [`write_png`](Self::write_png), with 8-bit alpha, by which colours are divided.
    ///
    /// # Errors
    /// As [`write_png`](Self::write_png).
    pub fn write_png_with_alpha(
        &self,
        path: &Path,
        metadata: &[(&str, String)],
    ) -> Result<(), PictureError> {
        let bytes = |pixel: [f32; 4]| {
            let [.., alpha] = pixel;
            if !(alpha > 0.0) {
                return [0; 4];
            }
            let [red, green, blue] = srgb_of_pixel(pixel.map(|channel| channel / alpha));
            [red, green, blue, (alpha * 255.0 + 0.5) as u8]
        };
        self.write_8_bit(path, metadata, ColorType::Rgba, bytes)
    }

    fn write_8_bit<const N: usize>(
        &self,
        path: &Path,
        metadata: &[(&str, String)],
        colour: ColorType,
        bytes: impl Fn([f32; 4]) -> [u8; N] + Sync,
    ) -> Result<(), PictureError> {
        self.check(path, metadata)?;
        let coded = self.pixels.par_iter().with_min_len(self.width as usize);
        let coded: Vec<[u8; N]> = coded.map(|&pixel| bytes(pixel)).collect();
        let (size, bytes) = ([self.width, self.height], coded.as_flattened());
        write_file(path, |file| encode_png(file, size, colour, bytes, metadata))
    }

    /// Writes every bit as `OpenEXR`: linear 32-bit RGBA with premultiplied alpha, ZIP-compressed.
    /// `metadata` goes into the attribute `comments`, as lines `key: value` in the order given.
    /// The file appears complete or not at all.
    ///
    /// # Errors
    /// As [`write_png`](Self::write_png).
    pub fn write_exr(&self, path: &Path, metadata: &[(&str, String)]) -> Result<(), PictureError> {
        use exr::image::write::WritableImage;
        use exr::prelude::{
            Blocks, Compression, Encoding, Image, Layer, LayerAttributes, LineOrder,
            SpecificChannels, Text, Vec2,
        };

        self.check(path, metadata)?;
        let mut attributes = LayerAttributes::default();
        if !metadata.is_empty() {
            let mut comments = String::new();
            for (key, value) in metadata {
                comments.extend([*key, ": ", value, "\n"]);
            }
            // OpenEXR's strings are bytes; UTF-8 is what its tools expect.
            attributes.comments = Some(Text::from_slice_unchecked(comments.as_bytes()));
        }
        let pixel = |at: Vec2<usize>| {
            let pixel = self.pixel(at.x() as u32, at.y() as u32);
            <(f32, f32, f32, f32)>::from(pixel.unwrap_or_default())
        };
        let encoding = Encoding {
            compression: Compression::ZIP16,
            blocks: Blocks::ScanLines,
            line_order: LineOrder::Increasing,
        };
        let size = (self.width as usize, self.height as usize);
        let layer = Layer::new(size, attributes, encoding, SpecificChannels::rgba(pixel));
        write_file(path, |file| {
            Image::from_layer(layer)
                .write()
                .to_buffered(file)
                .map_err(|error| match error {
                    exr::error::Error::Io(reason) => reason,
                    other => io::Error::other(other),
                })
        })
    }

    fn check(&self, path: &Path, metadata: &[(&str, String)]) -> Result<(), PictureError> {
        self.check_count()?;
        let error = |fault: String| Err(PictureError(format!("{}: {fault}", path.display())));
        let (width, height) = (self.width, self.height);
        if self.pixels.is_empty() {
            return error(format!(
                "a picture of {width} × {height} pixels cannot be written"
            ));
        }
        for (key, value) in metadata {
            let printable = key.bytes().all(|byte| (b' '..=b'~').contains(&byte));
            let spaced = key.trim() != *key || key.contains("  ");
            if !(1..=79).contains(&key.len()) || !printable || spaced {
                return error(format!(
                    "metadata key {key:?} cannot be written: use 1 to 79 printable ASCII \
                     characters, no space at either end and no two spaces in a row"
                ));
            }
            if value.contains('\0') {
                return error(format!(
                    "the value of metadata key {key:?} cannot be written: remove its NUL characters"
                ));
            }
        }
        Ok(())
    }
}

/// Returns the sRGB code of a linear value (IEC 61966-2-1), 0 to 255 for 0 to 1; clipped outside, 0
/// for NaN. Within 0.545 of the exact code, from a table: files are the same on every machine.
pub fn srgb_from_linear(linear: f32) -> u8 {
    fast_srgb8::f32_to_srgb8(linear)
}

pub(crate) fn srgb_of_pixel(pixel: [f32; 4]) -> [u8; 3] {
    let [red, green, blue, _] = fast_srgb8::f32x4_to_srgb8(pixel);
    [red, green, blue]
}

/// Returns the hash of a tile by its rows of pixels: of the bits of red, green, blue and alpha of
/// each, the lowest byte first.
pub fn tile_hash<'p>(rows: impl IntoIterator<Item = &'p [Pixel]>) -> u64 {
    let mut hash = Xxh3Default::new();
    for row in rows {
        if cfg!(target_endian = "little") {
            hash.update(row.as_bytes());
        } else {
            for pixel in row {
                let channels = [pixel.red, pixel.green, pixel.blue, pixel.alpha];
                hash.update(channels.map(f32::to_le_bytes).as_flattened());
            }
        }
    }
    hash.digest()
}

/// Encodes 8-bit sRGB or sRGB with alpha, row by row from the top.
pub(crate) fn encode_png(
    file: impl Write,
    [width, height]: [u32; 2],
    colour: ColorType,
    bytes: &[u8],
    metadata: &[(&str, String)],
) -> io::Result<()> {
    let mut encoder = png::Encoder::new(file, width, height);
    encoder.set_color(colour);
    encoder.set_depth(BitDepth::Eight);
    // A frame's files must not take longer than its rays: the best of five filters, chosen anew
    // for each row, saves little and takes a third longer.
    encoder.set_compression(png::Compression::Fast);
    encoder.set_filter(png::Filter::Paeth);
    encoder.set_source_srgb(SrgbRenderingIntent::RelativeColorimetric);
    let encoded = (|| {
        for (key, value) in metadata {
            let (key, value) = ((*key).to_owned(), value.clone());
            if value.is_ascii() {
                encoder.add_text_chunk(key, value)?;
            } else {
                encoder.add_itxt_chunk(key, value)?;
            }
        }
        let mut writer = encoder.write_header()?;
        writer.write_image_data(bytes)?;
        writer.finish()
    })();
    encoded.map_err(|error| match error {
        // The crate's own conversion forgets the kind.
        png::EncodingError::IoError(reason) => reason,
        other => io::Error::other(other),
    })
}

fn write_file(
    path: &Path,
    write: impl FnOnce(&mut dyn WriteSeek) -> io::Result<()>,
) -> Result<(), PictureError> {
    write_atomically(path, write).map_err(|reason| {
        let (path, (what, advice)) = (path.display(), explain(&reason));
        PictureError(format!("{path}: cannot write: {what}; {advice}"))
    })
}

/// Returns how far apart the colours of two pictures are, pixel by pixel as far as both go:
/// CIEDE2000 of the colours clipped to sRGB. A difference up to about 1 is not seen.
pub fn colour_differences(one: &Picture, other: &Picture) -> Vec<f32> {
    let pairs = one.pixels.par_iter().zip(&other.pixels);
    pairs
        .map(|(one, other)| shown(*one).difference(shown(*other)))
        .collect()
}

fn shown([red, green, blue, _]: [f32; 4]) -> Lab {
    let clip = |channel: f32| channel.clamp(0.0, 1.0);
    LinSrgb::new(clip(red), clip(green), clip(blue)).into_color()
}

#[cfg(test)]
mod tests;
