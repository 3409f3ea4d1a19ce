//! Colours over a surface, as described or read from PNG and JPEG files.

use crate::files::{Fault, UNREAD, read_within};
use miette::Diagnostic;
use png::{BitDepth, ColorType, DecodingError, Limits, Transformations};
use shisen_core::scene::format::LARGEST_SIDE;
use std::fmt;
use std::io::Cursor;
use std::path::Path;
use std::sync::Arc;
use thiserror::Error;
use zune_jpeg::JpegDecoder;
use zune_jpeg::errors::DecodeErrors;
use zune_jpeg::zune_core::bytestream::ZCursor;
use zune_jpeg::zune_core::colorspace::ColorSpace;
use zune_jpeg::zune_core::options::DecoderOptions;

/// A pattern over a surface.
#[derive(Debug, Clone, PartialEq)]
pub struct Texture {
    /// The pattern.
    pub pattern: Pattern,
    /// From the surface's coordinates to the pattern's own, of which 1 is a cell of a checker or an
    /// image: where u goes, where v goes, and where the origin is. Up to 1,000,000.
    pub map: [[f32; 2]; 3],
    /// How an image goes on beyond 0 to 1, across and up.
    pub wrap: [Wrap; 2],
    /// Whether an image's nearest texel is taken alone, rather than the four around.
    pub nearest: bool,
    /// Whether the mesh's second coordinates are meant, where it has them.
    pub second_coordinates: bool,
}

impl Texture {
    /// Returns a pattern that repeats this often from 0 to 1 along u and v.
    pub const fn new(pattern: Pattern, repeats: [f32; 2]) -> Self {
        Self {
            pattern,
            map: [[repeats[0], 0.0], [0.0, repeats[1]], [0.0; 2]],
            wrap: [Wrap::Repeat; 2],
            nearest: false,
            second_coordinates: false,
        }
    }
}

impl Texture {
    /// Returns the texture whose alpha is this one's brightness, unless it has an alpha.
    pub(in crate::scene) fn into_opacity(mut self) -> Self {
        if let Pattern::Image(image) = &mut self.pattern
            && image.is_opaque()
        {
            let image = Arc::make_mut(image);
            image.opaque = false;
            for texel in &mut image.texels {
                texel[3] = texel[0].max(texel[1]).max(texel[2]);
            }
        }
        self
    }
}

/// How an image goes on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Wrap {
    /// The same again.
    Repeat,
    /// Every second time turned over.
    Mirror,
    /// As at its border.
    Clamp,
}

/// The pattern of a texture.
#[derive(Debug, Clone, PartialEq)]
pub enum Pattern {
    /// Cells of two colours in turn, linear RGB, 0 to 1. The first has its
    /// lower left corner where the coordinates are 0.
    Checker([[f32; 3]; 2]),
    /// An image, its lower left corner where the coordinates are 0.
    Image(Arc<Image>),
}

/// A picture in memory.
#[derive(Debug, Clone, PartialEq)]
pub struct Image {
    width: u32,
    height: u32,
    texels: Vec<[u8; 4]>,
    /// Whether its file lets nothing through.
    opaque: bool,
}

/// Why an image cannot be loaded: what is wrong, where, and what to do.
#[derive(Debug, Error, Diagnostic)]
#[error(transparent)]
#[diagnostic(transparent)]
pub struct ImageError(pub(super) Fault);

impl Image {
    /// Bytes that the images of a scene may take together: an eighth of what a baked scene may.
    pub const MOST_BYTES: u64 = 1 << 29;

    /// Returns an image of texels coded as sRGB, row by row from the top; `None` if a side is not 1
    /// to [`LARGEST_SIDE`] or their number is not width × height.
    pub fn new(width: u32, height: u32, texels: &[[u8; 3]]) -> Option<Self> {
        let texels: Vec<[u8; 4]> = texels.iter().map(|&[r, g, b]| [r, g, b, u8::MAX]).collect();
        Self::with_alpha(width, height, &texels)
    }

    /// Does what [`new`](Self::new) does, of texels with an alpha, 0 to 255.
    pub fn with_alpha(width: u32, height: u32, texels: &[[u8; 4]]) -> Option<Self> {
        let sides = [width, height];
        let fits = sides.iter().all(|side| (1..=LARGEST_SIDE).contains(side))
            && texels.len() == width as usize * height as usize;
        fits.then(|| Self {
            width,
            height,
            texels: texels.to_vec(),
            opaque: texels.iter().all(|&[.., alpha]| alpha == u8::MAX),
        })
    }

    /// Reads a PNG or JPEG file, within the bytes that a scene's images have left. See
    /// [`decode`](Self::decode).
    pub(crate) fn load(path: &Path, left: &mut u64) -> Result<Self, ImageError> {
        let told = |fault: &dyn fmt::Display, help: &str| {
            ImageError(Fault::new(format!("{}: {fault}", path.display()), help))
        };
        let help = "save it again as PNG or JPEG, smaller if it is too large";
        let bytes = read_within(path, Self::MOST_BYTES >> 20);
        let bytes = bytes.map_err(|fault| match fault.kind() {
            std::io::ErrorKind::FileTooLarge => told(&fault, help),
            _ => told(&fault, UNREAD),
        })?;
        Self::decode(&bytes, left).map_err(|fault| told(&fault, help))
    }

    /// Decodes a PNG or JPEG file of any kind; what is too large is not decoded. Its colours are
    /// taken to be sRGB; of 16 bits a channel the upper 8 count.
    ///
    /// # Errors
    /// What is wrong, in words.
    pub(crate) fn decode(bytes: &[u8], left: &mut u64) -> Result<Self, String> {
        if bytes.starts_with(b"\x89PNG\r\n\x1a\n") {
            decode_png(bytes, left)
        } else if bytes.starts_with(b"\xff\xd8\xff") {
            decode_jpeg(bytes, left)
        } else {
            Err("neither a PNG nor a JPEG file".to_owned())
        }
    }

    /// Returns texels from left to right.
    pub const fn width(&self) -> u32 {
        self.width
    }

    /// Returns texels from top to bottom.
    pub const fn height(&self) -> u32 {
        self.height
    }

    /// Returns whether its file lets nothing through: it has no alpha below 1.
    pub(crate) const fn is_opaque(&self) -> bool {
        self.opaque
    }

    /// Red, green and blue as sRGB codes them, and a zero: row by row from the top.
    pub fn texels(&self) -> &[[u8; 4]] {
        &self.texels
    }
}

/// Takes what an image needs from the bytes that are left.
fn reserve([width, height]: [u32; 2], left: &mut u64) -> Result<(), String> {
    if width.max(height) > LARGEST_SIDE {
        return Err(format!(
            "it has {width} × {height} texels, but either side may have {LARGEST_SIDE}"
        ));
    }
    let taken = u64::from(width) * u64::from(height) * 4;
    *left = left.checked_sub(taken).ok_or_else(|| {
        let (bytes, limit) = (Image::MOST_BYTES - *left + taken, Image::MOST_BYTES);
        format!(
            "with its {width} × {height} texels the images would take {bytes} bytes, but they may \
             take {limit}"
        )
    })?;
    Ok(())
}

fn decode_png(bytes: &[u8], left: &mut u64) -> Result<Image, String> {
    let malformed = |fault: DecodingError| format!("not a whole PNG file: {fault}");
    // Sixteen bits a channel, and a line before it.
    let limits = Limits {
        bytes: 3 * Image::MOST_BYTES as usize,
    };
    let mut decoder = png::Decoder::new_with_limits(Cursor::new(bytes), limits);
    decoder.set_transformations(Transformations::EXPAND | Transformations::STRIP_16);
    if let Some(sides) = sides(bytes) {
        reserve(sides, &mut left.clone())?;
    }
    let mut reader = decoder.read_info().map_err(malformed)?;
    let (width, height) = reader.info().size();
    reserve([width, height], left)?;
    let size = reader.output_buffer_size();
    let size = size.ok_or_else(|| malformed(DecodingError::LimitsExceeded))?;
    let mut decoded = vec![0; size];
    let frame = reader.next_frame(&mut decoded).map_err(malformed)?;
    // Past the last row there is at least the mark of the end.
    reader.finish().map_err(malformed)?;
    debug_assert_eq!(frame.bit_depth, BitDepth::Eight, "expanded or stripped");
    let samples = &decoded[..frame.buffer_size()];
    let texels = match frame.color_type {
        ColorType::Grayscale | ColorType::Indexed => {
            samples.iter().map(|&g| [g, g, g, u8::MAX]).collect()
        }
        ColorType::GrayscaleAlpha => chunks(samples, |&[g, alpha]| [g, g, g, alpha]),
        ColorType::Rgb => chunks(samples, |&[r, g, b]| [r, g, b, u8::MAX]),
        ColorType::Rgba => chunks(samples, |&rgba| rgba),
    };
    let channels = frame.color_type.samples();
    let has_alpha = matches!(
        frame.color_type,
        ColorType::GrayscaleAlpha | ColorType::Rgba
    );
    let mut alphas = samples.iter().skip(channels - 1).step_by(channels);
    Ok(Image {
        width,
        height,
        texels,
        opaque: !has_alpha || alphas.all(|&alpha| alpha == u8::MAX),
    })
}

fn decode_jpeg(bytes: &[u8], left: &mut u64) -> Result<Image, String> {
    let malformed = |fault: DecodeErrors| {
        let fault = fault.to_string();
        format!("not a whole JPEG file: {}", fault.trim_end())
    };
    let options = DecoderOptions::default()
        .set_strict_mode(true)
        .set_max_width(usize::from(u16::MAX))
        .set_max_height(usize::from(u16::MAX))
        .jpeg_set_out_colorspace(ColorSpace::RGB);
    let mut decoder = JpegDecoder::new_with_options(ZCursor::new(bytes), options);
    decoder.decode_headers().map_err(malformed)?;
    let (width, height) = decoder.dimensions().unwrap_or_default();
    let [width, height] = [width, height].map(|side| side as u32);
    reserve([width, height], left)?;
    let samples = decoder.decode().map_err(malformed)?;
    Ok(Image {
        width,
        height,
        texels: chunks(&samples, |&[r, g, b]| [r, g, b, u8::MAX]),
        opaque: true,
    })
}

fn chunks<const N: usize>(samples: &[u8], texel: impl Fn(&[u8; N]) -> [u8; 4]) -> Vec<[u8; 4]> {
    samples.as_chunks().0.iter().map(texel).collect()
}

/// Returns width and height as the header of a PNG file claims them.
fn sides(png: &[u8]) -> Option<[u32; 2]> {
    let side = |from: usize| {
        let bytes = png.get(from..from + 4)?;
        Some(u32::from_be_bytes(bytes.try_into().ok()?))
    };
    Some([side(16)?, side(20)?])
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::scene::material::Material;

    fn png(size: [u32; 2], colour: ColorType, depth: BitDepth, data: &[u8]) -> Vec<u8> {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, size[0], size[1]);
        encoder.set_color(colour);
        encoder.set_depth(depth);
        if colour == ColorType::Indexed {
            encoder.set_palette(vec![1, 2, 3, 250, 251, 252]);
        }
        let mut writer = encoder.write_header().unwrap();
        writer.write_image_data(data).unwrap();
        writer.finish().unwrap();
        bytes
    }

    pub(in crate::scene) fn grey_png(texels: &[u8]) -> Vec<u8> {
        let size = [texels.len() as u32, 1];
        png(size, ColorType::Grayscale, BitDepth::Eight, texels)
    }

    /// Returns a row of texels, two bytes each.
    pub(in crate::scene) fn grey_and_alpha_png(texels: &[u8]) -> Vec<u8> {
        let size = [texels.len() as u32 / 2, 1];
        png(size, ColorType::GrayscaleAlpha, BitDepth::Eight, texels)
    }

    /// Returns the texels of a material's image.
    pub(in crate::scene) fn texels(material: &Material) -> &[[u8; 4]] {
        match material.texture.as_ref().map(|texture| &texture.pattern) {
            Some(Pattern::Image(image)) => image.texels(),
            other => panic!("{other:?}"),
        }
    }

    fn read(bytes: &[u8]) -> Result<Image, String> {
        Image::decode(bytes, &mut { Image::MOST_BYTES })
    }

    #[test]
    fn every_kind_of_png_becomes_eight_bits_a_channel() {
        use BitDepth::{Eight, One, Sixteen};
        use ColorType::{Grayscale, GrayscaleAlpha, Indexed, Rgb, Rgba};
        let deep: &[u8] = &[7, 200, 1, 1, 9, 0, 2, 2];
        let rgb: &[u8] = &[1, 2, 3, 4, 5, 6];
        let rgba: &[u8] = &[1, 2, 3, 9, 4, 5, 6, 0];
        for (colour, depth, data, expected) in [
            (Rgb, Eight, rgb, [[1, 2, 3, 255], [4, 5, 6, 255]]),
            (Rgba, Eight, rgba, [[1, 2, 3, 9], [4, 5, 6, 0]]),
            (Grayscale, One, &[0b0100_0000], [[0, 0, 0, 255], [255; 4]]),
            (GrayscaleAlpha, Sixteen, deep, [[7, 7, 7, 1], [9, 9, 9, 2]]),
            (
                Indexed,
                Eight,
                &[1, 0],
                [[250, 251, 252, 255], [1, 2, 3, 255]],
            ),
        ] {
            let image = read(&png([2, 1], colour, depth, data)).unwrap();
            assert_eq!((image.width(), image.height()), (2, 1));
            assert_eq!(image.texels(), expected, "{colour:?}");
        }
    }

    #[test]
    fn what_is_too_large_is_refused_before_it_is_decoded() {
        let wide = png([8193, 1], ColorType::Grayscale, BitDepth::One, &[0; 1025]);
        let error = read(&wide).unwrap_err();
        assert!(error.contains("8193 × 1 texels, but"), "{error}");
        // A header alone that claims much, with the sums that it needs.
        let mut header = png([1, 1], ColorType::Rgba, BitDepth::Eight, &[0; 4]);
        header[16..24].copy_from_slice(&[0x7f, 0xff, 0xff, 0xff, 0x7f, 0xff, 0xff, 0xff]);
        assert!(read(&header).is_err());
        // 60000 × 60000 texels of three channels.
        let jpeg = b"\xff\xd8\xff\xc0\0\x11\x08\xea\x60\xea\x60\x03\x01\x11\0\x02\x11\0\x03\x11\0\
                     \xff\xda\0\x0c\x03\x01\0\x02\0\x03\0\0\x3f\0";
        let error = read(jpeg).unwrap_err();
        assert!(error.contains("60000 × 60000 texels, but"), "{error}");
        let fits = png([8192, 1], ColorType::Grayscale, BitDepth::One, &[0; 1024]);
        assert_eq!(read(&fits).unwrap().width(), 8192);
        let mut left = 4 * 8192;
        Image::decode(&fits, &mut left).unwrap();
        assert_eq!(left, 0);
        let error = Image::decode(&fits, &mut left).unwrap_err();
        assert!(error.contains("would take"), "{error}");
    }

    #[test]
    fn damaged_files_are_refused() {
        let whole = png([3, 2], ColorType::Rgb, BitDepth::Eight, &[77; 18]);
        for length in 0..whole.len() - 12 {
            let error = read(&whole[..length]).unwrap_err();
            assert!(error.contains("PNG"), "{error}");
        }
        let mut damaged = whole;
        damaged[20] ^= 1;
        assert!(read(&damaged).is_err() && read(b"GIF89a").is_err());
    }
}
