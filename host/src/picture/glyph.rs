//! Letters as bitmaps.

use font8x8::{
    BASIC_FONTS, BLOCK_FONTS, BOX_FONTS, GREEK_FONTS, HIRAGANA_FONTS, LATIN_FONTS, UnicodeFonts,
};

pub(crate) const GLYPH: u32 = 8;

/// Returns the dots of a line of letters: columns and rows from its upper left corner.
pub(crate) fn dots(text: &str) -> impl Iterator<Item = (u32, u32)> {
    let letters = (0..).step_by(GLYPH as usize).zip(text.chars());
    letters.flat_map(|(left, character)| {
        let rows = (0..).zip(glyph(character));
        rows.flat_map(move |(row, bits)| {
            let lit = (0..GLYPH).filter(move |column| (bits >> column) & 1 == 1);
            lit.map(move |column| (left + column, row))
        })
    })
}

/// An arrow up, which the fonts lack.
const ARROW: [u8; 8] = [0x18, 0x3C, 0x7E, 0xFF, 0x18, 0x18, 0x18, 0x18];

/// Returns the rows from the top, the leftmost column in the lowest bit; `?` for unknown letters.
fn glyph(character: char) -> [u8; 8] {
    if character == '↑' {
        return ARROW;
    }
    BASIC_FONTS
        .get(character)
        .or_else(|| LATIN_FONTS.get(character))
        .or_else(|| GREEK_FONTS.get(character))
        .or_else(|| HIRAGANA_FONTS.get(character))
        .or_else(|| BOX_FONTS.get(character))
        .or_else(|| BLOCK_FONTS.get(character))
        .or_else(|| BASIC_FONTS.get('?'))
        .unwrap_or_default()
}
