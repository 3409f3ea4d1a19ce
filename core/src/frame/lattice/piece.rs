//! The part of a square whose samples are apart.

/// The part in a tile of a square of the view's grid whose samples are equally far apart.
#[derive(Debug, Clone, Copy)]
pub(in crate::frame) struct Piece {
    /// First column.
    pub(in crate::frame) x: u32,
    /// First row.
    pub(in crate::frame) y: u32,
    pub(in crate::frame) columns: u32,
    pub(in crate::frame) rows: u32,
    /// Column and row of the square's first pixel.
    pub(in crate::frame) corner: (u32, u32),
    /// Pixels a side of the square.
    pub(in crate::frame) side: u32,
    /// Pixels between samples, a power of two.
    pub(in crate::frame) stride: u32,
}

impl Piece {
    /// Its number of pixels.
    pub(in crate::frame) const fn area(&self) -> u32 {
        self.columns * self.rows
    }
}
