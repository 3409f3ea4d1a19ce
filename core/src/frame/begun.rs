//! What there is of a tile's next pixel when a budget ends between two of its samples.

use super::lattice::Cell;
use crate::trace::{Balance, Budget, Pixel, Workspace};

/// How far the current block or square of a tile has got.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Begun {
    /// Finished pixels of a block, row by row.
    pub(super) pixels: u32,
    /// Samples of the pixel after them.
    pub(super) samples: u16,
    sum: Sum,
    /// Where a square goes on whose samples are apart.
    pub(super) cell: Cell,
}

impl Begun {
    pub(super) const NOTHING: Self = Self {
        pixels: 0,
        samples: 0,
        sum: Sum::NONE,
        cell: Cell::NONE,
    };

    /// Whether no sample of a block is there.
    pub(super) const fn is_nothing(&self) -> bool {
        self.pixels == 0 && self.samples == 0
    }

    /// Whether the budget ends between two samples of a pixel.
    pub(super) const fn is_interrupted(&self, budget: &Budget) -> bool {
        self.samples > 0 && budget.is_spent()
    }

    /// Adds a sample of the next pixel.
    pub(super) fn add(&mut self, seen: Pixel, workspace: &mut Workspace) {
        self.sum.add(seen, workspace);
        self.samples += 1;
    }

    /// The next pixel, which has all of its samples: they are forgotten.
    pub(super) fn take_pixel(&mut self, samples: u16) -> Pixel {
        let pixel = self.sum.mean(samples);
        self.finish(self.pixels);
        pixel
    }

    /// Ends with this many finished pixels, and no sample of another.
    pub(super) const fn finish(&mut self, pixels: u32) {
        self.keep(pixels, 0, &Sum::NONE);
    }

    /// Keeps the sum of so many samples of the pixel after `pixels` finished ones.
    pub(super) const fn keep(&mut self, pixels: u32, samples: u16, sum: &Sum) {
        self.pixels = pixels;
        self.samples = samples;
        self.sum = *sum;
    }
}

/// Samples of a pixel, in their order.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Sum {
    pixel: Pixel,
    balance: Balance,
}

impl Sum {
    /// The sum of no samples.
    pub(super) const NONE: Self = Self {
        pixel: Pixel {
            red: 0.0,
            green: 0.0,
            blue: 0.0,
            alpha: 0.0,
        },
        balance: Balance::NONE,
    };

    /// Adds a sample and the colour balance that tracing it left in the workspace.
    pub(super) fn add(&mut self, sample: Pixel, workspace: &mut Workspace) {
        self.pixel.red += sample.red;
        self.pixel.green += sample.green;
        self.pixel.blue += sample.blue;
        self.pixel.alpha += sample.alpha;
        self.balance.take(&mut workspace.balance);
    }

    pub(super) fn mean(&self, samples: u16) -> Pixel {
        let share = 1.0 / f32::from(samples);
        let made_up = self.balance.light();
        Pixel {
            red: (self.pixel.red + made_up.x) * share,
            green: (self.pixel.green + made_up.y) * share,
            blue: (self.pixel.blue + made_up.z) * share,
            alpha: self.pixel.alpha * share,
        }
    }
}
