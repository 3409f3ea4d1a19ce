//! Pixels with detail smaller than a pixel: each of their samples is lit by itself.

use super::{GroupNumber, MOST_GROUPS, SIDE, Square, hit_of, index};
use crate::frame::begun::Work;
use crate::numeric::sqrt;
use crate::simd::{Runs, Simd};
use crate::trace::apart::MOST_LIGHTS;
use crate::trace::beam::{BLOCKS, ROW_BLOCKS, SelfShadow};
use crate::trace::facet::Fineness;
use core::array::from_fn;
use glam::Vec3;

/// Least number of a group's samples for which borders of shadows are looked for.
const LEAST: u16 = 128;

/// Least height of a shape over its own tangent plane from which it shades itself, as a share of the
/// square's width there: more than a surface bends within a square.
const OWN_HEIGHT: f32 = 0.5;

/// Pixels of a square, a bit for each, by row.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pixels([u16; SIDE]);

impl Pixels {
    pub(super) const NONE: Self = Self([0; SIDE]);
    const ALL: Self = Self([u16::MAX; SIDE]);

    /// Returns the pixels of the first `side` rows and columns for which `is` holds.
    fn of(side: usize, is: impl Fn(usize, usize) -> bool) -> Self {
        let (side, mut pixels) = (side.min(SIDE), Self::NONE);
        for (y, row) in pixels.0.iter_mut().enumerate().take(side) {
            *row = (0..side).fold(0, |row, x| row | u16::from(is(x, y)) << x);
        }
        pixels
    }

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
    /// Finds pixels with lines, with textures that are not averaged, with vertex colours of several
    /// facets, and with borders of shadows on bent surfaces. The shadows are drawn on a plane that
    /// touches the surface.
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
            let Some(&group) = group.filter(|group| group.plane.is_none()) else {
                continue;
            };
            match group.fineness {
                Fineness::Everywhere => self.keep_fine(number, &Pixels::ALL),
                Fineness::BetweenFacets => self.keep_fine(number, &self.several()),
                Fineness::Nowhere => {}
            }
            if group.is_busy {
                continue;
            }
            if count < LEAST || !self.renderer.tracer.casts_shadows() {
                continue;
            }
            let (block, lane) = (usize::from(sample / 8) % BLOCKS, usize::from(sample % 8));
            let Some((tangent, own)) = self.tangent(block, lane) else {
                continue;
            };
            for light in lights.iter().take(MOST_LIGHTS).filter(|it| !it.is_large()) {
                if let Some(dark) = self.shadows(light, tangent, Some(own), work)
                    && dark.iter().any(|dark| *dark != 0)
                {
                    self.keep_fine(number, &self.borders(&dark));
                }
            }
        }
    }

    /// Returns the normal and a point of the plane that touches the surface which a sample sees,
    /// and how that surface shades itself.
    fn tangent(&self, block: usize, lane: usize) -> Option<((Vec3, Vec3), SelfShadow)> {
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
        let own = SelfShadow {
            instance: id.instance,
            least: OWN_HEIGHT * width,
        };
        Some((surface.tangent(), own))
    }

    /// Returns the pixels whose samples see several facets.
    fn several(&self) -> Pixels {
        Pixels::of(self.sizes.side, |x, y| {
            let block = &self.seen.number[(ROW_BLOCKS * y + x / 2) % BLOCKS];
            let own = &block[4 * (x & 1)..][..4];
            own.iter().any(|number| *number != own[0])
        })
    }

    /// Returns the pixels at or beside the borders of what is dark, a bit for each sample.
    fn borders(&self, dark: &[u8; BLOCKS]) -> Pixels {
        let of =
            |x: usize, y: usize| dark[(ROW_BLOCKS * y + x / 2) % BLOCKS] >> (4 * (x & 1)) & 0xf;
        let some = Pixels::of(self.sizes.side, |x, y| of(x, y) != 0).around();
        let lit = Pixels::of(self.sizes.side, |x, y| of(x, y) != 0xf).around();
        Pixels(from_fn(|row| some.0[row] & lit.0[row]))
    }

    /// Keeps those pixels that see one group alone.
    fn keep_fine(&mut self, group: GroupNumber, pixels: &Pixels) {
        let own = Pixels::of(self.sizes.side, |x, y| self.pure[SIDE * y + x] == group);
        for (row, fine) in self.fine.0.iter_mut().enumerate() {
            *fine |= own.0[row] & pixels.0[row];
        }
    }
}
