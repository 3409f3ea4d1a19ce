//! What shapes are drawn on: the nearest surface of each sample, or the samples in shadow.

use super::samples::BLOCKS;
use crate::simd::Lanes;
use heapless::Vec;

/// What a sample sees.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct SurfaceId {
    pub(crate) instance: u32,
    pub(crate) triangle: u32,
    pub(crate) leaf: u32,
    pub(crate) lane: u32,
}

/// The surfaces that samples have seen. A surface's number is its place in the list plus 1.
#[derive(Debug)]
pub(crate) struct Surfaces(Vec<SurfaceId, MOST_SURFACES>);

/// Room for a surface a sample of a square, and for more until those that none sees are dropped.
pub(crate) const MOST_SURFACES: usize = 1024 + 512;

impl Surfaces {
    pub(crate) const fn new() -> Self {
        Self(Vec::new())
    }

    pub(crate) fn list(&self) -> &[SurfaceId] {
        &self.0
    }

    #[inline(always)]
    pub(super) fn next(&self) -> f32 {
        (self.0.len() + 1) as f32
    }

    #[inline(always)]
    pub(super) fn push(&mut self, id: SurfaceId) {
        let _ = self.0.push(id);
    }

    /// Returns whether the next leaf may find no room.
    #[inline(always)]
    pub(super) fn is_full(&self) -> bool {
        self.0.len() + 8 > MOST_SURFACES
    }
}

/// What shapes are drawn on.
pub(crate) trait Paper {
    const IS_SHADOW: bool;

    /// Takes the samples of a block that are inside a shape; returns whether it is seen.
    fn take<L: Lanes<8>>(
        &mut self,
        l: L,
        block: usize,
        inside: L::M,
        near: L::F,
        ink: &Ink<'_>,
    ) -> bool;

    /// Drops surfaces that no sample sees.
    fn forget(&mut self, surfaces: &mut Surfaces);
}

/// What is drawn.
pub(crate) struct Ink<'i> {
    pub(super) number: f32,
    pub(super) id: &'i dyn Fn() -> SurfaceId,
    pub(super) surfaces: &'i Surfaces,
}

/// The nearest surface of each sample.
pub(crate) struct Seen {
    /// 1/t, 0 where nothing is seen, by block.
    pub(crate) near: [[f32; 8]; BLOCKS],
    /// Number of the surface, 0 for none.
    pub(crate) number: [[f32; 8]; BLOCKS],
}

impl Seen {
    pub(crate) const NOTHING: Self = Self {
        near: [[0.0; 8]; BLOCKS],
        number: [[0.0; 8]; BLOCKS],
    };
}

impl Paper for Seen {
    const IS_SHADOW: bool = false;

    #[inline(always)]
    fn take<L: Lanes<8>>(
        &mut self,
        l: L,
        block: usize,
        inside: L::M,
        near: L::F,
        ink: &Ink<'_>,
    ) -> bool {
        let block = block & (BLOCKS - 1);
        let old = l.load(&self.near[block]);
        let equal = l.bits(l.and(inside, l.eq(near, old)));
        if equal != 0 {
            self.take_one_by_one(block, l.bits(inside), &l.store(near), ink)
        } else {
            let nearer = l.and(inside, l.le(old, near));
            if l.bits(nearer) == 0 {
                return false;
            }
            self.near[block] = l.store(l.select(nearer, near, old));
            let number = l.select(nearer, l.splat(ink.number), l.load(&self.number[block]));
            self.number[block] = l.store(number);
            true
        }
    }

    fn forget(&mut self, surfaces: &mut Surfaces) {
        let mut new = [0u16; MOST_SURFACES + 1];
        for number in self.number.as_flattened() {
            new[(*number as usize).min(MOST_SURFACES)] = 1;
        }
        let mut kept = 0;
        for old in 1..=surfaces.0.len() {
            if new[old] != 0 {
                surfaces.0[kept] = surfaces.0[old - 1];
                kept += 1;
                new[old] = kept as u16;
            }
        }
        new[0] = 0;
        surfaces.0.truncate(kept);
        for number in self.number.as_flattened_mut() {
            *number = f32::from(new[(*number as usize).min(MOST_SURFACES)]);
        }
    }
}

impl Seen {
    /// Takes samples one by one: among surfaces equally near the lowest instance counts, then the
    /// lowest triangle. Triangles of one leaf come in this order.
    #[cold]
    #[inline(never)]
    fn take_one_by_one(
        &mut self,
        block: usize,
        mut inside: u32,
        near: &[f32; 8],
        ink: &Ink<'_>,
    ) -> bool {
        let mut is_seen = false;
        let own = (ink.id)();
        while inside != 0 {
            let lane = inside.trailing_zeros() as usize & 7;
            inside &= inside - 1;
            let (old, number) = (self.near[block][lane], self.number[block][lane]);
            let wins = near[lane] > old
                || near[lane] == old
                    && (number as usize)
                        .checked_sub(1)
                        .and_then(|n| ink.surfaces.0.get(n))
                        .is_some_and(|other| {
                            (own.instance, own.triangle) < (other.instance, other.triangle)
                        });
            if wins {
                self.near[block][lane] = near[lane];
                self.number[block][lane] = ink.number;
                is_seen = true;
            }
        }
        is_seen
    }
}

/// Samples that a light does not reach, a bit for each.
pub(crate) struct Shadows {
    pub(crate) dark: [u8; BLOCKS],
}

impl Paper for Shadows {
    const IS_SHADOW: bool = true;

    #[inline(always)]
    fn take<L: Lanes<8>>(
        &mut self,
        l: L,
        block: usize,
        inside: L::M,
        _: L::F,
        _: &Ink<'_>,
    ) -> bool {
        self.dark[block & (BLOCKS - 1)] |= l.bits(inside) as u8;
        false
    }

    fn forget(&mut self, _: &mut Surfaces) {}
}
