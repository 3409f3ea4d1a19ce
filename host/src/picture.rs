//! Pictures: what was traced, and the files it is written to.

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
