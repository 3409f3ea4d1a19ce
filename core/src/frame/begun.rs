//! The state of a tile's unfinished pixel, kept from one slice to the next.

use super::tile::Target;
use crate::trace::{Balance, Budget, Pixel, Workspace};

/// The state that rendering a block or a square changes.
pub(super) struct Work<'w> {
    pub(super) begun: &'w mut Begun,
    pub(super) budget: &'w mut Budget,
    pub(super) workspace: &'w mut Workspace,
    pub(super) target: Target<'w>,
}

/// The progress within the current block of a tile.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Begun {
    /// Finished pixels of a block, row by row.
    pub(super) pixels: u32,
    /// Rendered samples of the unfinished pixel after them.
    pub(super) samples: u16,
    sum: Sum,
}

impl Begun {
    pub(super) const NOTHING: Self = Self {
        pixels: 0,
        samples: 0,
        sum: Sum::NONE,
    };

    /// Returns whether no sample of the block has been rendered.
    pub(super) const fn is_nothing(&self) -> bool {
        self.pixels == 0 && self.samples == 0
    }

    /// Returns whether the budget ends between two samples of a pixel.
    pub(super) const fn is_interrupted(&self, budget: &Budget) -> bool {
        self.samples > 0 && budget.is_spent()
    }

    pub(super) fn add(&mut self, seen: Pixel, workspace: &mut Workspace) {
        self.sum.add(seen, workspace);
        self.samples += 1;
    }

    /// Returns the unfinished pixel once it has all its samples, and clears them.
    pub(super) fn take_pixel(&mut self, samples: u16) -> Pixel {
        let pixel = self.sum.mean(samples);
        self.finish(self.pixels);
        pixel
    }

    /// Stores the number of finished pixels, with no samples of the next.
    pub(super) const fn finish(&mut self, pixels: u32) {
        self.keep(pixels, 0, &Sum::NONE);
    }

    /// Stores the sum of the first `samples` of the pixel after `pixels` finished ones.
    pub(super) const fn keep(&mut self, pixels: u32, samples: u16, sum: &Sum) {
        self.pixels = pixels;
        self.samples = samples;
        self.sum = *sum;
    }
}

/// The sum of a pixel's samples, added in their order.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Sum {
    pixel: Pixel,
    balance: Balance,
}

impl Sum {
    pub(super) const NONE: Self = Self {
        pixel: Pixel::NONE,
        balance: Balance::NONE,
    };

    /// Adds a sample and the colour balance that tracing it left in the workspace.
    pub(super) fn add(&mut self, sample: Pixel, workspace: &mut Workspace) {
        self.pixel = self.pixel.zip(sample, |sum, own| sum + own);
        self.balance.take(&mut workspace.balance);
    }

    pub(super) fn mean(&self, samples: u16) -> Pixel {
        let share = 1.0 / f32::from(samples);
        let made_up = Pixel::new(self.balance.light(), 0.0);
        self.pixel
            .zip(made_up, |sum, made_up| (sum + made_up) * share)
    }
}
