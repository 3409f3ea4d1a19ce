//! What each effect of a picture cost.

use crate::scene::EffectSet;

/// What one effect did.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Entry {
    /// Pixels in whose ray trees it was carried out.
    pub pixels: u64,
    /// Rays that were traced for it and nothing else.
    pub rays: u64,
    /// What those took: nodes visited and primitives tested. Each ray counts
    /// once, for the effect that sent it.
    pub steps: u64,
}

/// What each effect did in the pixels that were rendered with this ledger.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Ledger {
    /// One entry per effect, by the number of its bit.
    entries: [Entry; EffectSet::PLACES],
    /// Bits of the effects of the pixel that is being traced.
    touched: u32,
}

impl Ledger {
    /// A ledger without pixels.
    pub const EMPTY: Self = Self {
        entries: [Entry {
            pixels: 0,
            rays: 0,
            steps: 0,
        }; EffectSet::PLACES],
        touched: 0,
    };

    /// Returns the sum of the entries of some effects. A pixel counts once for each effect.
    pub fn entry(&self, effects: EffectSet) -> Entry {
        let mut sum = Entry::default();
        for (place, entry) in self.entries.iter().enumerate() {
            if effects.bits() >> place & 1 != 0 {
                sum.add(entry);
            }
        }
        sum
    }

    /// Adds the entries of another part of the same picture.
    pub fn add(&mut self, other: &Self) {
        for (entry, other) in self.entries.iter_mut().zip(&other.entries) {
            entry.add(other);
        }
    }

    /// Ends a pixel: counts it for each effect that touched it.
    pub(crate) fn end_pixel(&mut self) {
        for (place, entry) in self.entries.iter_mut().enumerate() {
            entry.pixels += u64::from(self.touched >> place & 1);
        }
        self.touched = 0;
    }
}

impl Entry {
    const fn add(&mut self, other: &Self) {
        self.pixels += other.pixels;
        self.rays += other.rays;
        self.steps += other.steps;
    }
}

/// Receives what shading does.
pub(super) trait Record {
    /// Effects of some bits are carried out.
    fn touch(&mut self, effects: u32);

    /// A ray was traced for the effect of a bit's number.
    fn ray(&mut self, cause: u8, steps: u64);
}

/// Records nothing, and compiles to no code.
impl Record for () {
    #[inline(always)]
    fn touch(&mut self, _: u32) {}

    #[inline(always)]
    fn ray(&mut self, _: u8, _: u64) {}
}

impl Record for Ledger {
    fn touch(&mut self, effects: u32) {
        self.touched |= effects;
    }

    fn ray(&mut self, cause: u8, steps: u64) {
        if let Some(entry) = self.entries.get_mut(usize::from(cause)) {
            entry.rays += 1;
            entry.steps += steps;
        }
    }
}
