//! A canvas: pixels of eight bits a channel, as a window takes them.

use crate::files::write_atomically;
use crate::picture::encode_png;
use crate::picture::glyph::{GLYPH, dots};
use std::io;
use std::path::Path;

/// A colour: 0xRRGGBB, sRGB.
pub(crate) type Colour = u32;

/// A canvas, its rows from the top.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Canvas {
    width: u32,
    height: u32,
    pixels: Vec<Colour>,
}

/// A part of a canvas, in pixels from its upper left corner.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Rect {
    pub(crate) x: u32,
    pub(crate) y: u32,
    pub(crate) width: u32,
    pub(crate) height: u32,
}

impl Rect {
    /// Returns a rectangle with its upper left corner at (`x`, `y`).
    pub(crate) const fn new(x: u32, y: u32, width: u32, height: u32) -> Self {
        Self {
            x,
            y,
            width,
            height,
        }
    }
}

impl Canvas {
    /// The most columns and rows of a window in the X protocol.
    pub(crate) const MOST: u32 = 16_384;

    /// Returns a black canvas, at most [`MOST`](Self::MOST) on each side.
    pub(crate) fn new(width: u32, height: u32) -> Self {
        let (width, height) = (width.min(Self::MOST), height.min(Self::MOST));
        Self {
            width,
            height,
            pixels: vec![0; width as usize * height as usize],
        }
    }

    /// Returns columns and rows.
    pub(crate) const fn size(&self) -> [u32; 2] {
        [self.width, self.height]
    }

    /// Returns the pixels row by row.
    pub(crate) fn pixels(&self) -> &[Colour] {
        &self.pixels
    }

    /// Returns the pixel in column `x` and row `y`; `None` outside.
    pub(crate) fn pixel(&self, x: u32, y: u32) -> Option<Colour> {
        self.pixels.get(self.index(x, y)?).copied()
    }

    /// Sets a pixel, if it is inside.
    pub(crate) fn set(&mut self, x: u32, y: u32, colour: Colour) {
        let index = self.index(x, y);
        if let Some(pixel) = index.and_then(|index| self.pixels.get_mut(index)) {
            *pixel = colour;
        }
    }

    /// Fills the part of a rectangle that is inside.
    pub(crate) fn fill(&mut self, rect: Rect, colour: Colour) {
        let end = rect.x.saturating_add(rect.width).min(self.width);
        let start = rect.x.min(end);
        let bottom = rect.y.saturating_add(rect.height).min(self.height);
        for y in rect.y..bottom {
            let row = y as usize * self.width as usize;
            let row = row + start as usize..row + end as usize;
            self.pixels.get_mut(row).unwrap_or_default().fill(colour);
        }
    }

    /// Fills the whole canvas.
    pub(crate) fn clear(&mut self, colour: Colour) {
        self.pixels.fill(colour);
    }

    /// Writes letters from (`x`, `y`) on, as far as they fit; returns the column where they end.
    pub(crate) fn write(&mut self, x: u32, y: u32, text: &str, colour: Colour) -> u32 {
        for (column, row) in dots(text) {
            self.set(x.saturating_add(column), y.saturating_add(row), colour);
        }
        x.saturating_add(GLYPH * text.chars().count() as u32)
    }

    fn index(&self, x: u32, y: u32) -> Option<usize> {
        (x < self.width && y < self.height).then(|| y as usize * self.width as usize + x as usize)
    }

    /// Writes a PNG, whole or not at all.
    pub(crate) fn write_png(&self, path: &Path, metadata: &[(&str, String)]) -> io::Result<()> {
        let pixels = self.pixels.iter();
        let bytes = pixels.flat_map(|pixel| pixel.to_be_bytes().into_iter().skip(1));
        let bytes: Vec<u8> = bytes.collect();
        let (size, colour) = ([self.width, self.height], png::ColorType::Rgb);
        write_atomically(path, |file| {
            encode_png(file, size, colour, &bytes, metadata)
        })
    }
}

/// Mixes two colours; `part` of the second, 0 to 1.
pub(super) fn mixed(one: Colour, other: Colour, part: f32) -> Colour {
    let channel = |shift: u32| {
        let [one, other] = [one, other].map(|colour| ((colour >> shift) & 0xFF) as f32);
        let mixed = one + (other - one) * part;
        ((mixed + 0.5) as u32).min(0xFF) << shift
    };
    channel(0) | channel(8) | channel(16)
}
