//! Names on the net in a bitmap font, light with a dark outline.

use crate::picture::Picture;
use crate::picture::glyph::{GLYPH, dots};
use glam::DVec2;

/// A wall's shorter side in pixels of a glyph.
const SIDE: f64 = 240.0;
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
    let name: String = name.chars().take(fitting).collect();
    let text = DVec2::new(advance * name.chars().count() as f64, advance);
    let start = if centred {
        0.5 * (low + high - text)
    } else {
        low + 3.0 * margin
    };
    let start = start.min(high - text - margin).max(low);
    let (left, top) = (start.x.round() as u32, start.y.round() as u32);

    // The outlines first: letters are not to cover each other.
    let reach = scale.div_ceil(2);
    for (grow, colour) in [(reach, OUTLINE), (0, TEXT)] {
        for (column, row) in dots(&name) {
            let place = [left + column * scale, top + row * scale];
            let [x, y] = place.map(|start| start.saturating_sub(grow));
            square(picture, x, y, scale + 2 * grow, colour);
        }
    }
}

fn square(picture: &mut Picture, left: u32, top: u32, side: u32, colour: [f32; 4]) {
    for y in top..top.saturating_add(side) {
        for x in left..left.saturating_add(side) {
            picture.set_pixel(x, y, colour);
        }
    }
}
