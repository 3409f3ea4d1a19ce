//! Pixels of bent surfaces that are not of one light: there each sample is lit by itself.

use super::{GroupNumber, MOST_GROUPS, SIDE, Square, hit_of, index};
use crate::frame::begun::Work;
use crate::numeric::sqrt;
use crate::simd::{Runs, Simd};
use crate::trace::apart::MOST_LIGHTS;
use crate::trace::beam::{BLOCKS, ROW_BLOCKS};
use glam::Vec3;

/// Least samples of a group for which borders of shadows are found.
const LEAST: u16 = 128;

/// Least height of what a surface casts shadows with on itself, over the square's width there:
/// more than what it bends.
const OWN_HEIGHT: f32 = 0.5;

/// An instance, and the least height of what it casts shadows with: metres.
pub(super) type Own = (u32, f32);

/// Pixels of a square, a bit for each, by row.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pixels([u16; SIDE]);

impl Pixels {
    pub(super) const NONE: Self = Self([0; SIDE]);

    pub(super) const fn has(&self, x: usize, y: usize) -> bool {
        self.0[y % SIDE] >> (x % SIDE) & 1 != 0
    }

    /// Returns whether any pixel of a cell is one of them.
    pub(super) fn cross(&self, (x, y): (usize, usize), step: usize) -> bool {
        let columns = (((1u32 << step) - 1) << x) as u16;
        let rows = self.0.iter().skip(y).take(step);
        rows.fold(0, |all, row| all | row) & columns != 0
    }

    /// Returns these pixels and those beside them.
    fn around(&self) -> Self {
        let across = self.0.map(|row| row | row << 1 | row >> 1);
        let mut around = across;
        for (row, of) in around.iter_mut().enumerate() {
            let above = row.checked_sub(1).map_or(0, |row| across[row]);
            *of |= above | across.get(row + 1).copied().unwrap_or(0);
        }
        Self(around)
    }
}

impl<const W: usize> Square<'_, '_, W>
where
    Simd: Runs<W>,
{
    /// Finds pixels with something in them that is smaller than a pixel: lines, textures that are
    /// not averaged, and borders of shadows on bent surfaces, by drawing these on a plane that touches
    /// the surface.
    #[inline(never)]
    pub(super) fn find_fine(&mut self, work: &mut Work<'_>) {
        // Samples of each group, and a sample of the surface that most of them see.
        let mut seen = [(0u16, 0u16, 0u16); MOST_GROUPS];
        for used in &self.uses {
            if let Some((all, most, sample)) = seen.get_mut(usize::from(used.group)) {
                *all += used.count;
                if used.count > *most {
                    (*most, *sample) = (used.count, used.sample);
                }
            }
        }
        let tracer = &self.renderer.tracer;
        let lights = tracer.scene().lights();
        for (number, (count, _, sample)) in (0..).zip(seen) {
            let group = self.groups.get(usize::from(number));
            let Some(group) = group.filter(|group| group.plane.is_none()) else {
                continue;
            };
            if group.is_busy {
                // Colours of corners are the same all over a facet's plane, but not over others.
                let (is_fine, seen) = (group.is_fine, self.seen.number);
                let is_mixed = |x, y| {
                    let block: &[f32; 8] = &seen[(ROW_BLOCKS * y + x / 2) % BLOCKS];
                    let own = &block[4 * (x & 1)..][..4];
                    own.iter().any(|number| *number != own[0])
                };
                self.keep_fine(number, |x, y| is_fine || is_mixed(x, y));
                continue;
            }
            if count < LEAST || !self.renderer.tracer.casts_shadows() {
                continue;
            }
            let (block, lane) = (usize::from(sample / 8) % BLOCKS, usize::from(sample % 8));
            let Some((own, tangent)) = self.tangent(block, lane) else {
                continue;
            };
            for light in lights.iter().take(MOST_LIGHTS).filter(|it| !it.is_large()) {
                if let Some(dark) = self.shadows(light, tangent, Some(own), work)
                    && dark.iter().any(|dark| *dark != 0)
                {
                    let (some, lit) = self.some_and_lit(&dark);
                    self.keep_fine(number, |x, y| some.has(x, y) && lit.has(x, y));
                }
            }
        }
    }

    /// Returns the instance that a sample sees, and the height over the plane that touches it from
    /// which on it casts shadows on itself, and that plane's normal and a point of it.
    fn tangent(&self, block: usize, lane: usize) -> Option<(Own, (Vec3, Vec3))> {
        let (x, y) = self.samples.at(block, lane);
        let id = *self
            .surfaces
            .list()
            .get(index(self.seen.number[block][lane])?)?;
        let hit = hit_of(&id, self.seen.near[block][lane]);
        let tracer = &self.renderer.tracer;
        let surface = tracer.surface(self.shade, &self.picture.ray(x, y)?, &hit)?;
        let right = self.picture.directions[0];
        let width = self.sizes.side as f32 * sqrt(right.dot(right)) * hit.on.t;
        Some(((id.instance, OWN_HEIGHT * width), surface.tangent()))
    }

    /// Returns the pixels at and beside which samples are dark, and those at which they are lit.
    fn some_and_lit(&self, dark: &[u8; BLOCKS]) -> (Pixels, Pixels) {
        let (mut some, mut lit) = (Pixels::NONE, Pixels::NONE);
        let side = self.sizes.side;
        for (y, x) in (0..side).flat_map(|y| (0..side).map(move |x| (y, x))) {
            let dark = dark[(ROW_BLOCKS * y + x / 2) % BLOCKS] >> (4 * (x & 1)) & 0xf;
            some.0[y] |= u16::from(dark != 0) << x;
            lit.0[y] |= u16::from(dark != 0xf) << x;
        }
        (some.around(), lit.around())
    }

    /// Keeps those pixels that see one group alone.
    fn keep_fine(&mut self, group: GroupNumber, is_fine: impl Fn(usize, usize) -> bool) {
        for (place, pure) in self.pure.iter().enumerate() {
            let (x, y) = (place % SIDE, place / SIDE);
            if *pure == group && is_fine(x, y) {
                self.fine.0[y] |= 1 << x;
            }
        }
    }
}
