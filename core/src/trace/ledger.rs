//! The cost of each effect of a picture.

use crate::scene::EffectSet;
use glam::Vec3;

/// Counts of one effect.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Entry {
    /// Pixels whose ray trees had the effect.
    pub pixels: u64,
    /// Rays traced for this effect alone.
    pub rays: u64,
    /// Steps of those rays: nodes visited and primitives tested. Each ray counts
    /// once, for the effect that sent it.
    pub steps: u64,
}

/// Counts of each effect in the pixels that were rendered with this ledger.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Ledger {
    /// One entry per effect, by the number of its bit.
    entries: [Entry; EffectSet::PLACES],
    /// Bits of the effects of the pixel that is being traced.
    touched: u32,
}

impl Ledger {
    /// Returns a ledger without pixels.
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

/// Receives the effects and rays of shading.
pub(super) trait Record {
    /// Takes note that the effects with these bits are shaded.
    #[inline(always)]
    fn touch(&mut self, _effects: u32) {}

    /// Takes note of a ray traced for the effect with bit number `cause`.
    #[inline(always)]
    fn ray(&mut self, _cause: u8, _steps: u64) {}

    /// Whether it keeps the diffuse light of a primary hit apart from the texture that colours it.
    const SPLITS: bool = false;

    /// Takes note of the texture of a primary hit, whose colour its diffuse light does not have.
    #[inline(always)]
    fn coat(&mut self, _texture: u32, _place: [f32; 2]) {}

    /// Takes note of diffuse light of a primary hit.
    #[inline(always)]
    fn diffuse(&mut self, _light: Vec3) {}

    /// Takes the light of a small source, and the diffuse part of it, if something else finds out
    /// whether the source is seen; false if shading has to.
    #[inline(always)]
    fn source(&mut self, _number: u32, _light: Vec3, _diffuse: Vec3) -> bool {
        false
    }
}

/// Records nothing, and compiles to no code.
impl Record for () {}

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
