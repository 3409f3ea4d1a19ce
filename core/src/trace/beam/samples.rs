//! Where the samples of a square are, and linear functions of their places.

use crate::numeric::max;
use crate::simd::Lanes;
use glam::Vec3;

/// Pixels a side of a square.
pub(crate) const SIDE: usize = 16;
/// Blocks of a row: each has the four samples of two pixels.
pub(crate) const ROW_BLOCKS: usize = SIDE / 2;
pub(crate) const BLOCKS: usize = SIDE * ROW_BLOCKS;

/// Where the samples of a square's blocks are.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Samples {
    /// Columns from a block's first, in even and in odd rows.
    x: [[f32; 8]; 2],
    /// Rows from a block's own.
    y: [f32; 8],
    /// Rows and columns of the square's pixels that are drawn.
    pub(super) side: u32,
    /// Least distance of a sample from its pixel's border.
    pub(super) margin: f32,
}

/// Four samples of a pixel, on a turned grid; from the pixel's middle.
const TURNED: [(f32, f32); 4] = [
    (-0.125, -0.375),
    (0.375, -0.125),
    (-0.375, 0.125),
    (0.125, 0.375),
];

impl Samples {
    /// Returns the samples of a pass, moved by (x, y).
    pub(crate) fn new((dx, dy): (f32, f32), side: u32) -> Self {
        let (mut x, mut y) = ([[0.0; 8]; 2], [0.0; 8]);
        for lane in 0..8 {
            let (u, v) = TURNED[lane % 4];
            let pixel = lane / 4;
            for (row, x) in x.iter_mut().enumerate() {
                // Mirrored in every other pixel.
                let u = if (pixel + row) % 2 == 0 { u } else { -u };
                x[lane] = pixel as f32 + 0.5 + u + dx;
            }
            y[lane] = 0.5 + v + dy;
        }
        let margin = 0.124 - max(dx.abs(), dy.abs());
        Self { x, y, side, margin }
    }

    /// Returns the place of a sample in the square's picture.
    pub(crate) fn at(&self, block: usize, lane: usize) -> (f32, f32) {
        let (row, column) = (block / ROW_BLOCKS, 2 * (block % ROW_BLOCKS));
        (
            self.x[row & 1][lane & 7] + column as f32,
            self.y[lane & 7] + row as f32,
        )
    }
}

/// A linear function of a sample's place: a · x + b · y + c.
pub(super) type Form = Vec3;

/// A form's values at the samples of a row's first block.
#[inline(always)]
pub(super) fn at_row<L: Lanes<8>>(l: L, form: Form, samples: &Samples, row: usize) -> L::F {
    let x = l.mul(l.splat(form.x), l.load(&samples.x[row & 1]));
    let y = l.mul(l.splat(form.y), l.load(&samples.y));
    l.add(l.add(x, y), l.splat(form.y * row as f32 + form.z))
}

/// Blocks of rows in which samples may lie between two places.
#[derive(Clone, Copy)]
pub(super) struct Range {
    pub(super) rows: (usize, usize),
    pub(super) blocks: (usize, usize),
}

impl Range {
    #[inline(always)]
    pub(super) fn new((left, right): (f32, f32), (top, bottom): (f32, f32), side: u32) -> Self {
        // Conversions round down, and NaN to 0.
        let last = side as usize;
        let whole = |x: f32| x as usize;
        Self {
            rows: (whole(top), whole(bottom + 1.0).min(last)),
            blocks: (
                whole(left * 0.5),
                whole(right * 0.5 + 1.0).min(last.div_ceil(2)),
            ),
        }
    }

    pub(super) const fn all(side: u32) -> Self {
        let side = side as usize;
        Self {
            rows: (0, side),
            blocks: (0, side.div_ceil(2)),
        }
    }
}
