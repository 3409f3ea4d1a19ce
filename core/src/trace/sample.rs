use crate::numeric::lowbias32;

/// The sample and pixel of a ray, which seed all random choices.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Sample {
    column: u16,
    row: u16,
    /// Its number among the pixel's, from 0.
    pub(super) index: u16,
    /// How many the pixel has: 1 or more.
    pub(super) count: u16,
}

impl Sample {
    /// Pixels a side of the largest view: their numbers have 16 bits.
    pub(crate) const MOST_PIXELS: u32 = 1 << 16;

    /// Most samples of a pixel.
    pub(crate) const MOST: u16 = 4096;

    /// The sample of a ray that belongs to no picture.
    pub(crate) const ALONE: Self = Self::new(0, 0, 0, 1);

    /// Number `index` of the `count` of a pixel of a view.
    pub(crate) const fn new(column: u32, row: u32, index: u16, count: u16) -> Self {
        Self {
            column: column as u16,
            row: row as u16,
            index,
            count,
        }
    }

    /// Returns a pseudo-random number, the same for all samples of a pixel: a hash of its place.
    pub(crate) const fn seed(self) -> u32 {
        lowbias32((self.row as u32) << 16 | self.column as u32)
    }
}
