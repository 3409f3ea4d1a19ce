//! Names on the net in a bitmap font, light with a dark outline.

use crate::picture::Picture;
use crate::picture::glyph::{GLYPH, glyph};
use glam::DVec2;

/// A wall's shorter side in pixels of a glyph.
const SIDE: f64 = 240.0;
/// The largest magnification of a glyph.
const MAX_SCALE: f64 = 8.0;

const TEXT: [f32; 4] = [0.9, 0.9, 0.9, 1.0];
const OUTLINE: [f32; 4] = [0.0, 0.0, 0.0, 1.0];

/// Writes a name into the upper left corner of a rectangle, or its middle, as far as it fits.
pub(super) fn write(picture: &mut Picture, name: &str, low: DVec2, high: DVec2, centred: bool) {
    let size = high - low;
    let scale = (size.min_element() / SIDE).round().clamp(1.0, MAX_SCALE) as u32;
    let advance = f64::from(GLYPH * scale);
    // The outline stays inside, too.
    let margin = f64::from(scale);
    let fitting = ((size.x - 2.0 * margin) / advance).max(0.0) as usize;
    let glyphs: Vec<[u8; 8]> = name.chars().take(fitting).map(glyph).collect();
    let text = DVec2::new(advance * glyphs.len() as f64, advance);
    let start = if centred {
        0.5 * (low + high - text)
    } else {
        low + 3.0 * margin
    };
    let start = start.min(high - text - margin).max(low);
    let (left, top) = (start.x.round() as u32, start.y.round() as u32);

    let mut dots = Vec::new();
    for (glyph, left) in glyphs
        .iter()
        .zip((left..).step_by((GLYPH * scale) as usize))
    {
        for (row, bits) in (0..).zip(glyph) {
            let columns = (0..GLYPH).filter(|column| (bits >> column) & 1 == 1);
            dots.extend(columns.map(|column| (left + column * scale, top + row * scale)));
        }
    }
    let reach = scale.div_ceil(2);
    for &(x, y) in &dots {
        square(
            picture,
            x.saturating_sub(reach),
            y.saturating_sub(reach),
            scale + 2 * reach,
            OUTLINE,
        );
    }
    for &(x, y) in &dots {
        square(picture, x, y, scale, TEXT);
    }
}

fn square(picture: &mut Picture, left: u32, top: u32, side: u32, colour: [f32; 4]) {
    for y in top..top.saturating_add(side) {
        for x in left..left.saturating_add(side) {
            picture.set_pixel(x, y, colour);
        }
    }
}
