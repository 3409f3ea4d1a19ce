//! Names on the net, in a bitmap font: light with a dark outline, to be read
//! on any picture.

use crate::picture::Picture;
use crate::picture::glyph::{GLYPH, glyph};
use glam::DVec2;

/// Of a wall's shorter side, in glyph pixels: how small the letters are.
const SIDE: f64 = 240.0;
/// The largest magnification of a glyph.
const MAX_SCALE: f64 = 8.0;

const TEXT: [f32; 4] = [0.9, 0.9, 0.9, 1.0];
const OUTLINE: [f32; 4] = [0.0, 0.0, 0.0, 1.0];

/// Writes `name` into the rectangle from `low` to `high`, in pixels from the
/// upper left: into its upper left corner, or its middle where `centred`.
/// Letters that do not fit its width are left out.
pub(super) fn write(picture: &mut Picture, name: &str, low: DVec2, high: DVec2, centred: bool) {
    let size = high - low;
    let scale = (size.min_element() / SIDE).round().clamp(1.0, MAX_SCALE) as u32;
    let advance = f64::from(GLYPH * scale);
    // The outline's width, so that it stays inside too.
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

    let dots: Vec<(u32, u32)> = glyphs
        .iter()
        .zip((left..).step_by((GLYPH * scale) as usize))
        .flat_map(|(glyph, left)| {
            let set = |column: u32, row: u32| (glyph[row as usize] >> column) & 1 == 1;
            (0..GLYPH)
                .flat_map(|row| (0..GLYPH).map(move |column| (column, row)))
                .filter(move |&(column, row)| set(column, row))
                .map(move |(column, row)| (left + column * scale, top + row * scale))
                .collect::<Vec<_>>()
        })
        .collect();
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

#[cfg(test)]
mod tests {
    use super::*;

    const GREY: [f32; 4] = [0.5, 0.5, 0.5, 1.0];

    fn written(name: &str, width: u32, height: u32) -> Picture {
        let count = (width * height) as usize;
        let mut picture = Picture::from_pixels(width, height, vec![GREY; count]).unwrap();
        let high = DVec2::new(f64::from(width), f64::from(height));
        write(&mut picture, name, DVec2::ZERO, high, false);
        picture
    }

    #[test]
    fn letters_stand_upright_and_are_outlined() {
        let picture = written("L", 40, 40);
        let light = |x, y| picture.pixel(x, y) == Some(TEXT);
        // The foot of an L is at its right, and its stem above it.
        let rows: Vec<u32> = (0..40)
            .map(|y| (0..40).filter(|&x| light(x, y)).count() as u32)
            .collect();
        let top = rows.iter().position(|&count| count > 0).unwrap();
        let foot = rows.iter().rposition(|&count| count > 0).unwrap();
        assert!(rows[top] < rows[foot] && top < foot);
        for y in 0..40 {
            for x in 0..40 {
                if light(x, y) {
                    for (x, y) in [(x - 1, y), (x + 1, y), (x, y - 1), (x, y + 1)] {
                        assert_ne!(picture.pixel(x, y), Some(GREY));
                    }
                }
            }
        }
    }

    #[test]
    fn long_names_stay_inside() {
        let picture = written(&"W".repeat(1000), 50, 20);
        assert!((0..20).all(|y| picture.pixel(49, y) == Some(GREY)));
        let none = written("W", 5, 5);
        assert!(none.pixels.iter().all(|pixel| *pixel == GREY));
    }
}
