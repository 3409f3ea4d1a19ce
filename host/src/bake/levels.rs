//! The coarser levels of images.

use crate::picture::srgb_from_linear;
use crate::scene::texture::Image;
use fast_srgb8::srgb8_to_f32;
use shisen_core::scene::format::Texel;

/// What the texels of an image's coarser levels are means of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Levels {
    /// There are none: the nearest texel is taken alone.
    None,
    /// Light.
    OfColours,
    /// Codes.
    OfData,
}

impl Levels {
    /// Returns the number of an image's levels, itself included.
    pub(super) const fn count(self, image: &Image) -> u32 {
        let (width, height) = (image.width(), image.height());
        let larger = if width > height { width } else { height };
        match self {
            Self::None => 1,
            Self::OfColours | Self::OfData => larger.ilog2() + 1,
        }
    }

    /// Returns the texels of an image's coarser levels, one after another.
    pub(super) fn of(self, image: &Image) -> Vec<Texel> {
        let (mut all, mut sides) = (
            Vec::new(),
            [image.width() as usize, image.height() as usize],
        );
        let mut from = 0;
        for level in 1..self.count(image) {
            let finer = if level == 1 {
                image.texels()
            } else {
                &all[from..]
            };
            let coarser = self.halved(finer, sides);
            from = all.len();
            sides = sides.map(|side| (side / 2).max(1));
            all.extend(coarser);
        }
        all
    }

    /// Returns the means of a level's texels over those of the next.
    pub(super) fn halved(self, texels: &[Texel], [width, height]: [usize; 2]) -> Vec<Texel> {
        let [columns, rows] = [parts(width), parts(height)];
        let mut coarser = Vec::with_capacity(columns.len() * rows.len());
        for row in &rows {
            for column in &columns {
                let mut sum = [0.0; 4];
                for &(y, of_row) in row {
                    for &(x, of_column) in column {
                        let texel = self.light(texels[y * width + x]);
                        for (sum, channel) in sum.iter_mut().zip(texel) {
                            *sum += of_row * of_column * channel;
                        }
                    }
                }
                coarser.push(self.code(sum));
            }
        }
        coarser
    }

    fn light(self, [r, g, b, alpha]: Texel) -> [f32; 4] {
        let [r, g, b] = [r, g, b].map(|code| match self {
            Self::OfData => f32::from(code) / 255.0,
            Self::OfColours | Self::None => srgb8_to_f32(code),
        });
        [r, g, b, f32::from(alpha) / 255.0]
    }

    fn code(self, [r, g, b, alpha]: [f32; 4]) -> Texel {
        let share = |share: f32| (share * 255.0).round() as u8;
        let [r, g, b] = [r, g, b].map(|light| match self {
            Self::OfData => share(light),
            Self::OfColours | Self::None => srgb_from_linear(light),
        });
        [r, g, b, share(alpha)]
    }
}

/// Returns for each texel along a side of the next level the texels that it is the mean of, and
/// their shares.
pub(super) fn parts(side: usize) -> Vec<Vec<(usize, f32)>> {
    let count = (side / 2).max(1);
    let part = |number: usize| {
        // In units of 1 / count of a texel.
        let (from, to) = (number * side, (number + 1) * side);
        let texels = from / count..to.div_ceil(count);
        let share = |texel: usize| {
            let overlap = to.min((texel + 1) * count) - from.max(texel * count);
            (texel, overlap as f32 / side as f32)
        };
        texels.map(share).collect()
    };
    (0..count).map(part).collect()
}
