use crate::numeric::lowbias32;

/// The sample and pixel of a ray, which seed all random choices.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Sample {
    column: u16,
    row: u16,
    index: u16,
    count: u16,
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

    /// Its number among the pixel's, from 0.
    pub(crate) const fn index(self) -> u16 {
        self.index
    }

    /// How many the pixel has: 1 or more.
    pub(crate) const fn count(self) -> u16 {
        self.count
    }

    /// A pseudo-random number, the same for all samples of a pixel: a hash of its place.
    pub(crate) const fn seed(self) -> u32 {
        lowbias32((self.row as u32) << 16 | self.column as u32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pixels_have_seeds_of_their_own() {
        // Fewer under Miri, which is slow.
        let side = if cfg!(miri) { 3 } else { 64 };
        let mut bits = [0u32; 32];
        for row in 0..side {
            for column in 0..side {
                let seed = Sample::new(column, row, 3, 9).seed();
                assert_eq!(seed, Sample::new(column, row, 0, 1).seed());
                let right = Sample::new(column + 1, row, 0, 1).seed();
                let below = Sample::new(column, row + 1, 0, 1).seed();
                assert!(seed != right && seed != below && right != below);
                for (bit, count) in bits.iter_mut().enumerate() {
                    *count += (seed ^ right) >> bit & 1;
                }
            }
        }
        if !cfg!(miri) {
            // Each bit of neighbours differs half the time: 2048 ± 6 × 32.
            assert!(
                bits.iter().all(|count| count.abs_diff(2048) < 192),
                "{bits:?}"
            );
        }
    }

    #[test]
    fn the_last_pixel_is_not_the_first() {
        let last = Sample::new(Sample::MOST_PIXELS - 1, Sample::MOST_PIXELS - 1, 0, 1);
        assert_ne!(last, Sample::ALONE);
        assert_ne!(last.seed(), Sample::ALONE.seed());
    }
}
