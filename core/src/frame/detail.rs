//! The detail of each pixel's rays.

use super::tile::BLOCK;
use super::view::{Directions, Kind, View};
use crate::gaze::{Detail, Gaze, Region};
use crate::numeric::{max, min};
use crate::simd::{Kernel, Lanes, Runs, Simd};
use crate::trace::{NOT_TRACED, RayDetail, TileRays, Width};

const SIDE: usize = BLOCK as usize;

/// The level of detail of Mochizuki & Makino (2012), section 3.3: rays
/// outside the visual field are not traced, and others the less the farther
/// they are from the line of sight.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LevelOfDetail {
    /// The gaze that gives the levels (eqs. 1–8).
    pub gaze: Gaze,
    /// Whether the level limits reflections and refractions (eq. 9).
    pub bounces: bool,
    /// Whether it chooses the polygon counts of meshes (eq. 10), as far as the
    /// scene was baked with them.
    pub faces: bool,
}

impl LevelOfDetail {
    /// Returns the whole method of the paper.
    pub const fn new(gaze: Gaze) -> Self {
        Self {
            gaze,
            bounces: true,
            faces: true,
        }
    }
}

/// How far the faces that a pixel sees may be from eq. 10 for the sake of its block, as a share of
/// its range of faces: a thousandth, for odd numbers of faces, less than a twentieth.
pub const FACE_TOLERANCE: f32 = 0.049;

/// The level from which on a traced pixel is only itself; below, towards the
/// border of the visual field, it goes over into what fills the rest.
pub const BLEND: f32 = 0.1;

/// The detail of each pixel of a block of the view's own grid.
pub(super) enum BlockDetail {
    /// The same for all pixels.
    Equal(RayDetail),
    Outside,
    /// Each pixel's own.
    Own(OwnDetail),
}

/// The detail of each pixel of a block, by row, then column.
pub(super) struct OwnDetail {
    depths: [[u8; SIDE]; SIDE],
    /// Rungs; [`NOT_TRACED`] for pixels that are not traced.
    pub(super) rungs: [[u8; SIDE]; SIDE],
    wavelengths: [[u8; SIDE]; SIDE],
    /// The spread of all pixels' rays.
    spread: Width,
}

impl BlockDetail {
    /// Returns the detail of the block around a pixel: `most` at level 1, on ladders of `rungs`
    /// rungs.
    pub(super) fn new(
        lod: &LevelOfDetail,
        simd: Simd,
        view: &View,
        place: (u32, u32),
        most: RayDetail,
        rungs: u8,
    ) -> Self {
        let ladder = Ladder::new(if lod.faces { rungs } else { 1 });
        // More level never means fewer bounces: where the least and the most
        // are the same, all are.
        let detail = |rung: u8, level: f32| {
            let rung = rung.max(most.rung);
            match Detail::of_level(level) {
                Some(detail) if lod.bounces => RayDetail {
                    depth: detail.bounces(most.depth),
                    rung,
                    wavelengths: detail.wavelengths(most.wavelengths),
                    ..most
                },
                _ => RayDetail { rung, ..most },
            }
        };
        let equal = |least: f32, most: f32| {
            let rung = ladder.shared(least, most)?;
            let detail = (detail(rung, least), detail(rung, most));
            (detail.0 == detail.1).then_some(detail.0)
        };
        match region_of(lod, view, place, BLOCK) {
            Region::Central => return Self::Equal(most),
            Region::Outside => return Self::Outside,
            // Where the bounds give the same detail, the levels are not needed.
            Region::Traced(part) => {
                let (least, most) = lod.gaze.levels_within(&part);
                if let Some(equal) = equal(least, most).filter(|_| most < 1.0) {
                    return Self::Equal(equal);
                }
            }
            Region::Mixed => {}
        }
        let levels = BlockLevels::new(lod, simd, view, place);
        if levels.traced == 0 {
            return Self::Outside;
        }
        if levels.traced == u64::MAX
            && let Some(equal) = equal(levels.least, levels.most)
        {
            return Self::Equal(equal);
        }
        let shared = ladder.shared(levels.least, levels.most);
        let mut own = OwnDetail::NONE;
        for group in 0..TileRays::GROUPS {
            let (least, most, traced) = levels.group_levels(group);
            let shared = shared.or_else(|| ladder.shared(least, most));
            let equal = shared.map(|rung| detail(rung, least));
            let equal = equal.filter(|own| traced && *own == detail(own.rung, most));
            for (column, row) in TileRays::places_of_group(group) {
                let level = levels.levels[row % SIDE][column % SIDE];
                let detail = match (equal, level > 0.0) {
                    (Some(equal), _) => equal,
                    (None, true) => detail(shared.unwrap_or_else(|| ladder.nearest(level)), level),
                    (None, false) => detail(NOT_TRACED, 0.0),
                };
                own.set(column, row, detail);
            }
        }
        Self::Own(own)
    }

    /// Detail of the pixel at this column and row; `None` where it is not traced.
    pub(super) fn at(&self, column: u32, row: u32) -> Option<RayDetail> {
        match self {
            Self::Equal(detail) => Some(*detail),
            Self::Outside => None,
            Self::Own(own) => own.at(column as usize, row as usize),
        }
    }

    /// Returns which pixels are traced: a bit for each, by row, then column.
    pub(super) fn traced(&self) -> u64 {
        let mut traced = 0;
        for number in 0..BLOCK * BLOCK {
            let pixel = self.at(number % BLOCK, number / BLOCK);
            traced |= u64::from(pixel.is_some()) << number;
        }
        traced
    }

    /// Returns the detail of a part of the block; pixels past the part are not traced.
    pub(super) fn part(self, (left, top): (u32, u32), (columns, rows): (u32, u32)) -> Self {
        if (left, top, columns, rows) == (0, 0, BLOCK, BLOCK) {
            return self;
        }
        let mut part = OwnDetail::NONE;
        for row in 0..rows {
            for column in 0..columns {
                if let Some(detail) = self.at(left + column, top + row) {
                    part.set(column as usize, row as usize, detail);
                }
            }
        }
        Self::Own(part)
    }
}

impl OwnDetail {
    const NONE: Self = Self {
        depths: [[0; SIDE]; SIDE],
        rungs: [[NOT_TRACED; SIDE]; SIDE],
        wavelengths: [[0; SIDE]; SIDE],
        spread: Width::ZERO,
    };

    #[inline(always)]
    fn at(&self, column: usize, row: usize) -> Option<RayDetail> {
        let (column, row) = (column % SIDE, row % SIDE);
        let (depth, rung) = (self.depths[row][column], self.rungs[row][column]);
        (rung != NOT_TRACED).then_some(RayDetail {
            depth,
            rung,
            wavelengths: self.wavelengths[row][column],
            spread: self.spread,
        })
    }

    #[inline(always)]
    fn set(&mut self, column: usize, row: usize, detail: RayDetail) {
        let (column, row) = (column % SIDE, row % SIDE);
        self.depths[row][column] = detail.depth;
        self.rungs[row][column] = detail.rung;
        self.wavelengths[row][column] = detail.wavelengths;
        self.spread = detail.spread;
    }
}

/// Pixels a side of a patch, which is tested before its blocks.
pub(super) const PATCH: u32 = 4 * BLOCK;

/// Returns where the square of `side` pixels that contains (x, y) lies in the visual field.
pub(super) fn region_of(lod: &LevelOfDetail, view: &View, (x, y): (u32, u32), side: u32) -> Region {
    let Kind::Screen(screen) = view.kind() else {
        return Region::Mixed;
    };
    let last = |first: u32, count: u32| (first + (side - 1)).min(count - 1);
    let (left, top) = (x / side * side, y / side * side);
    let (right, bottom) = (last(left, view.columns()), last(top, view.rows()));
    let corner = |x: u32, y: u32| screen.direction(x as f32, y as f32);
    lod.gaze.region_between(&[
        corner(left, top),
        corner(right, top),
        corner(left, bottom),
        corner(right, bottom),
    ])
}

/// The levels of a block of the view's grid; its borders repeat.
pub(super) struct BlockLevels {
    /// Levels by row, then column.
    levels: [[f32; SIDE]; SIDE],
    /// A bit for each level above 0, in the same order from the lowest.
    pub(super) traced: u64,
    /// The least level above 0; 1 where there is none.
    least: f32,
    most: f32,
}

impl BlockLevels {
    pub(super) const OUTSIDE: Self = Self {
        levels: [[0.0; SIDE]; SIDE],
        traced: 0,
        least: 1.0,
        most: 0.0,
    };

    pub(super) fn at(&self, column: u32, row: u32) -> f32 {
        self.levels[row as usize % SIDE][column as usize % SIDE]
    }

    /// Returns the detail `most` for pixels below a level; others are not traced.
    pub(super) fn below(&self, level: f32, most: RayDetail) -> BlockDetail {
        let mut own = OwnDetail::NONE;
        let (mut any, mut all) = (false, true);
        for (row, levels) in self.levels.iter().enumerate() {
            for (column, &pixel_level) in levels.iter().enumerate() {
                let is_below = pixel_level < level;
                if is_below {
                    own.set(column, row, most);
                }
                (any, all) = (any || is_below, all && is_below);
            }
        }
        match (any, all) {
            (false, _) => BlockDetail::Outside,
            (true, true) => BlockDetail::Equal(most),
            (true, false) => BlockDetail::Own(own),
        }
    }

    /// Returns whether a pixel is outside the field, or within [`BLEND`] of it.
    pub(super) fn reaches_the_border(&self) -> bool {
        self.traced != u64::MAX || self.least < BLEND
    }

    /// Returns the levels of the block that contains pixel (x, y).
    pub(super) fn new(lod: &LevelOfDetail, simd: Simd, view: &View, (x, y): (u32, u32)) -> Self {
        let (x, y) = (x / BLOCK * BLOCK, y / BLOCK * BLOCK);
        if !Simd::HAS_VECTORS {
            return Self::one_by_one(lod, view, (x, y));
        }
        match view.kind() {
            Kind::Screen(view) => <Simd as Runs<8>>::run(simd, Levels { lod, view, x, y }),
            Kind::Dome(view) => <Simd as Runs<8>>::run(simd, Levels { lod, view, x, y }),
        }
    }

    fn one_by_one(lod: &LevelOfDetail, view: &View, (x, y): (u32, u32)) -> Self {
        let mut block = Self::OUTSIDE;
        for (number, level) in block.levels.as_flattened_mut().iter_mut().enumerate() {
            let (column, row) = (number as u32 % BLOCK, number as u32 / BLOCK);
            let place = (x + column, y + row);
            let direction = match view.kind() {
                Kind::Screen(screen) => Directions::direction(screen, place),
                Kind::Dome(dome) => Directions::direction(dome, place),
            };
            *level = lod.gaze.level(direction).unwrap_or(0.0);
            if *level > 0.0 {
                block.traced |= 1 << number;
                (block.least, block.most) = (min(*level, block.least), max(*level, block.most));
            }
        }
        block
    }

    /// Returns the least and the most of a group's levels above 0, and whether all are.
    fn group_levels(&self, group: usize) -> (f32, f32, bool) {
        let (mut least, mut most, mut traced) = (1.0, 0.0, true);
        for (column, row) in TileRays::places_of_group(group) {
            let level = self.levels[row % SIDE][column % SIDE];
            if level > 0.0 {
                (least, most) = (min(least, level), max(most, level));
            } else {
                traced = false;
            }
        }
        (least, most, traced)
    }
}

struct Levels<'r, V> {
    lod: &'r LevelOfDetail,
    view: &'r V,
    x: u32,
    y: u32,
}

impl<V: Directions> Kernel<8> for Levels<'_, V> {
    type Output = BlockLevels;

    #[inline(always)]
    fn run<L: Lanes<8>>(self, l: L) -> BlockLevels {
        let mut levels = [[0.0; 8]; 8];
        let (mut least, mut most) = (l.splat(1.0), l.splat(0.0));
        let mut traced = 0;
        for row in 0..8 {
            let directions = self.view.directions(l, (self.x, self.y + row as u32));
            let level = self.lod.gaze.levels(l, directions);
            let outside = l.le(level, l.splat(0.0));
            least = l.min(l.select(outside, l.splat(1.0), level), least);
            most = l.max(level, most);
            traced |= u64::from(!l.bits(outside) & 0xff) << (8 * row);
            levels[row] = l.store(level);
        }
        BlockLevels {
            levels,
            traced,
            least: l.store(least).into_iter().fold(1.0, min),
            most: l.store(most).into_iter().fold(0.0, max),
        }
    }
}

/// The rung for each level: a block shares one within [`FACE_TOLERANCE`] of eq. 10, else a group of
/// [`TileRays`] does, else each ray has its own. Level 1 sees the mesh itself.
pub(super) struct Ladder {
    /// Number of steps from the first rung to the last.
    steps: f32,
}

impl Ladder {
    pub(super) fn new(rungs: u8) -> Self {
        Self {
            steps: f32::from(rungs.max(1) - 1),
        }
    }

    /// Returns the rung shared by all levels from `least` to `most`, if there is one.
    fn shared(&self, least: f32, most: f32) -> Option<u8> {
        if self.steps == 0.0 {
            return Some(0);
        }
        let rung = if most == 1.0 {
            0
        } else {
            self.nearest((least + most) * 0.5)
        };
        let level = 1.0 - f32::from(rung) / self.steps;
        (most - level <= FACE_TOLERANCE && level - least <= FACE_TOLERANCE).then_some(rung)
    }

    /// Returns the rung whose faces are closest to eq. 10.
    pub(super) fn nearest(&self, level: f32) -> u8 {
        ((1.0 - level) * self.steps + 0.5) as u8
    }
}

/// Returns the detail of the valid level nearest to `level`.
pub(super) fn nearest_detail(level: f32) -> Detail {
    let nearest = if level > 1.0 {
        Detail::FULL
    } else {
        Detail::NONE
    };
    Detail::of_level(level).unwrap_or(nearest)
}
