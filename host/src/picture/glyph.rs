//! Letters as bitmaps.

use font8x8::{
    BASIC_FONTS, BLOCK_FONTS, BOX_FONTS, GREEK_FONTS, HIRAGANA_FONTS, LATIN_FONTS, UnicodeFonts,
};

/// Columns and rows of a letter.
pub(crate) const GLYPH: u32 = 8;

/// The rows from the top, the leftmost column in the lowest bit; of letters that there
/// are not, those of a question mark.
pub(crate) fn glyph(character: char) -> [u8; 8] {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unknown_characters_become_question_marks() {
        assert_eq!(glyph('床'), glyph('?'));
        assert!(
            ['é', 'λ', 'ゆ']
                .iter()
                .all(|&known| glyph(known) != glyph('?'))
        );
    }
}
