//! What the level of detail leaves of each pixel's rays.

use super::View;
use super::block::BLOCK;
use crate::gaze::{Detail, Gaze};
use crate::numeric::{max, min};
use crate::simd::{Kernel, Lanes, Runs, Simd};
use crate::trace::{NOT_TRACED, RayDetail};

/// Pixels of a block.
const PIXELS: usize = (BLOCK * BLOCK) as usize;

/// The level of detail of Mochizuki & Makino (2012), section 3.3: rays
/// outside the visual field are not traced, and others the less the farther
/// they are from the line of sight.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LevelOfDetail {
    /// Whose levels (eqs. 1–8).
    pub gaze: Gaze,
    /// Whether the level limits reflections and refractions (eq. 9).
    pub bounces: bool,
    /// Whether it chooses the polygon counts of meshes (eq. 10), as far as the
    /// scene was baked with them.
    pub faces: bool,
}

impl LevelOfDetail {
    /// The paper's method whole.
    pub const fn new(gaze: Gaze) -> Self {
        Self {
            gaze,
            bounces: true,
            faces: true,
        }
    }
}

/// How far the faces that a pixel sees may be from eq. 10 for the sake of its
/// block, as a share of its range of faces. A thousandth less than a twentieth:
/// rungs are a pair of faces off at most where a ladder asks for odd numbers.
pub const FACE_TOLERANCE: f32 = 0.049;

/// The detail of each pixel of a block of the view's own grid. It depends on
/// the view and the gaze only: not on tiles, nor on how rays go.
pub(super) enum BlockDetail {
    /// The same for all pixels.
    Equal(RayDetail),
    /// No pixel is traced.
    Outside,
    /// By row, then column; the rung is [`NOT_TRACED`] outside the field.
    Own([RayDetail; PIXELS]),
}

impl BlockDetail {
    /// Of the block that has pixel (x, y) in it. `most` is what a ray of level
    /// 1 may do, `rungs` how many the scene's ladders have.
    pub(super) fn new(
        lod: &LevelOfDetail,
        simd: Simd,
        view: &View,
        (x, y): (u32, u32),
        most: RayDetail,
        rungs: u8,
    ) -> Self {
        let levels = levels_of_block(lod, simd, view, (x, y));
        let levels = levels.as_flattened();
        let least = levels.iter().copied().fold(1.0, min);
        if least == 1.0 {
            return Self::Equal(most);
        }
        if levels.iter().copied().fold(0.0, max) == 0.0 {
            return Self::Outside;
        }
        let ladder = Ladder::new(if lod.faces { rungs } else { 1 }, levels);
        let mut own = [most; PIXELS];
        let mut equal = least > 0.0;
        for (detail, &level) in own.iter_mut().zip(levels) {
            if level > 0.0 {
                detail.rung = ladder.rung(level);
                if lod.bounces {
                    detail.depth = Detail::of_level(level).map_or(0, |own| own.bounces(most.depth));
                }
            } else {
                detail.rung = NOT_TRACED;
            }
        }
        for detail in &own {
            equal &= *detail == own[0];
        }
        if equal {
            Self::Equal(own[0])
        } else {
            Self::Own(own)
        }
    }

    /// Of the pixel of the view's grid block at this column and row; `None`
    /// where it is not traced.
    pub(super) fn at(&self, column: u32, row: u32) -> Option<RayDetail> {
        match self {
            Self::Equal(detail) => Some(*detail),
            Self::Outside => None,
            Self::Own(own) => own
                .get((row * BLOCK + column) as usize)
                .copied()
                .filter(|detail| detail.rung != NOT_TRACED),
        }
    }

    /// Whether any pixel is traced.
    pub(super) const fn is_traced(&self) -> bool {
        !matches!(self, Self::Outside)
    }
}

/// The levels of a block of the view's grid, by row, then column. Those past
/// the view's borders repeat its last column and row.
pub(super) fn levels_of_block(
    lod: &LevelOfDetail,
    simd: Simd,
    view: &View,
    (x, y): (u32, u32),
) -> [[f32; BLOCK as usize]; BLOCK as usize] {
    <Simd as Runs<8>>::run(
        simd,
        Levels {
            lod,
            view,
            x: x / BLOCK * BLOCK,
            y: y / BLOCK * BLOCK,
        },
    )
}

struct Levels<'r> {
    lod: &'r LevelOfDetail,
    view: &'r View,
    x: u32,
    y: u32,
}

impl Kernel<8> for Levels<'_> {
    type Output = [[f32; 8]; 8];

    #[inline(always)]
    fn run<L: Lanes<8>>(self, l: L) -> [[f32; 8]; 8] {
        let mut levels = [[0.0; 8]; 8];
        for (row, levels) in levels.iter_mut().enumerate() {
            let directions = self
                .view
                .directions(l, (self.x, self.y + row as u32), (0.0, 0.0));
            *levels = l.store(self.lod.gaze.levels(l, directions));
        }
        levels
    }
}

/// Which rung of a ladder of polygon levels each level of a block sees.
///
/// Rays of a block that see the same mesh go through it together. So all of
/// them see the rung of the middle level, where that is within
/// [`FACE_TOLERANCE`] of what eq. 10 asks for; where levels differ more, and
/// for pixels of level 1, each has its own.
struct Ladder {
    steps: f32,
    shared: Option<u8>,
}

impl Ladder {
    fn new(rungs: u8, levels: &[f32]) -> Self {
        let mut ladder = Self {
            steps: f32::from(rungs.max(1) - 1),
            shared: None,
        };
        let traced = || levels.iter().copied().filter(|&level| level > 0.0);
        let least = traced().fold(1.0, min);
        let most = traced().fold(0.0, max);
        // Whoever looks straight at it sees the mesh itself.
        let shared = if most == 1.0 {
            0
        } else {
            ladder.nearest((least + most) * 0.5)
        };
        let level = 1.0 - f32::from(shared) / max(ladder.steps, 1.0);
        if most - level <= FACE_TOLERANCE && level - least <= FACE_TOLERANCE {
            ladder.shared = Some(shared);
        }
        ladder
    }

    fn rung(&self, level: f32) -> u8 {
        self.shared.unwrap_or_else(|| self.nearest(level))
    }

    /// The rung whose faces are closest to eq. 10.
    fn nearest(&self, level: f32) -> u8 {
        ((1.0 - level) * self.steps + 0.5) as u8
    }
}
