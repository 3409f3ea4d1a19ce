//! Tiles of pixels: resumable, within a budget.
//!
//! A wall, a dome or a dome master is a [`View`]; a [`TileJob`] is a rectangle
//! of it on its way to being finished. The caller owns the pixels and the [`Workspace`], deals out the
//! [`Budget`], and calls [`TileJob::render`] until it says
//! [`Outcome::Finished`]. Every pixel is a function of the scene, the view, the
//! [`Settings`] and its place in the view only: not of tiles, their order, or
//! how often rendering was interrupted.

mod block;
mod detail;
mod dome;
mod past;
mod view;

pub use crate::trace::{
    Budget, LEAST_WEIGHT, MAX_DEPTH, Pixel, RayDetail, Statistics, Tracer, Workspace,
};
use block::{BLOCK, Block, Target};
use core::fmt;
use detail::{BlockDetail, BlockLevels, PATCH, region_of};
pub use detail::{FACE_TOLERANCE, LevelOfDetail};
pub use view::{DomeError, DomePose, DomeProjection, DomeScreen, MirrorCamera, View, ViewError};

use crate::gaze::Region;
use crate::scene::Scene;
use crate::simd::{Runs, Simd};

/// Most samples of a pixel.
pub const MAX_SAMPLES: u16 = 4096;

/// How good a picture to make.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Settings {
    /// Reflections and refractions after one another, 0 to [`MAX_DEPTH`].
    pub depth: u8,
    /// Rays a pixel, 1 to [`MAX_SAMPLES`], in a fixed pattern (Hammersley's
    /// points); a single one goes through the centre.
    pub samples: u16,
    /// How primary rays go.
    pub mode: Mode,
}

impl Default for Settings {
    /// The paper's three bounces, one ray a pixel.
    fn default() -> Self {
        Self {
            depth: 3,
            samples: 1,
            mode: Mode::Tile,
        }
    }
}

/// How primary rays go through the scene. It changes the number of steps,
/// never a pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mode {
    /// One at a time: the finest budget and the least memory.
    Single,
    /// Blocks of 8×8 pixels of a view together: a node or a primitive counts
    /// one step for the whole block. Rays of dome masters start apart: rows
    /// of eight pixels, or eight samples of one, go together through a scene of
    /// few instances, as far as its meshes.
    Tile,
}

/// A rectangle of pixels of a view.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Tile {
    /// First column.
    pub x: u32,
    /// First row.
    pub y: u32,
    /// Columns, above 0.
    pub width: u32,
    /// Rows, above 0.
    pub height: u32,
}

/// Why a tile cannot be rendered.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum TileError {
    /// Not inside the view, or empty.
    Outside,
    /// Not as many pixels as the tile has.
    Pixels {
        /// How many it has.
        needed: usize,
        /// How many were given.
        given: usize,
    },
}

impl fmt::Display for TileError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Outside => f.write_str("the tile is empty or not inside the view"),
            Self::Pixels { needed, given } => {
                write!(
                    f,
                    "the tile has {needed} pixels, but there is room for {given}"
                )
            }
        }
    }
}

impl core::error::Error for TileError {}

/// How a call of [`TileJob::render`] ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outcome {
    /// All pixels are there.
    Finished,
    /// The budget ran out; call again to go on where it stopped. Pixels not
    /// reached are as they were.
    BudgetSpent,
}

/// Renders views of a scene.
#[derive(Debug, Clone, Copy)]
pub struct Renderer<'a, const W: usize = 8> {
    tracer: Tracer<'a, W>,
    settings: Settings,
    lod: Option<LevelOfDetail>,
}

impl<'a, const W: usize> Renderer<'a, W>
where
    Simd: Runs<W>,
{
    /// Settings out of range are moved to the nearest that is in it.
    pub fn new(scene: Scene<'a, W>, simd: Simd, settings: Settings) -> Self {
        let settings = Settings {
            depth: settings.depth.min(MAX_DEPTH),
            samples: settings.samples.clamp(1, MAX_SAMPLES),
            mode: settings.mode,
        };
        Self {
            tracer: Tracer::new(scene, simd, settings.depth),
            settings,
            lod: None,
        }
    }

    /// The same renderer with a detail that follows the gaze. Where a pixel is
    /// outside the visual field it shows what a ray sees that meets nothing;
    /// in the central field it is what it would be without.
    #[must_use]
    pub const fn with_level_of_detail(mut self, lod: LevelOfDetail) -> Self {
        self.lod = Some(lod);
        self
    }

    /// What traces its rays.
    pub const fn tracer(&self) -> &Tracer<'a, W> {
        &self.tracer
    }

    /// How pixel (x, y) of a view is traced; `None` where it is not, where
    /// the view has no such pixel, and where the pixel's centre is outside a
    /// dome master's rim.
    pub fn detail(&self, view: &View, x: u32, y: u32) -> Option<RayDetail> {
        if x >= view.columns() || y >= view.rows() {
            return None;
        }
        view.direction(x as f32, y as f32)?;
        let patch = self.patch_region(view, x, y);
        self.block_detail(patch, view, x, y)
            .at(x % BLOCK, y % BLOCK)
    }

    /// Where the patch of blocks of the view that pixel (x, y) is in lies in
    /// the field.
    fn patch_region(&self, view: &View, x: u32, y: u32) -> Region {
        match &self.lod {
            None => Region::Central,
            Some(lod) => region_of(lod, view, (x, y), PATCH),
        }
    }

    /// Of the pixels of the block of the view's grid that pixel (x, y) is in,
    /// by the region of its patch.
    fn block_detail(&self, patch: Region, view: &View, x: u32, y: u32) -> BlockDetail {
        let most = self.tracer.detail();
        match (&self.lod, patch) {
            (None, _) | (_, Region::Central) => BlockDetail::Equal(most),
            (_, Region::Outside) => BlockDetail::Outside,
            (Some(lod), Region::Traced(_) | Region::Mixed) => {
                let rungs = self.tracer.scene().rungs();
                BlockDetail::new(lod, self.tracer.simd(), view, (x, y), most, rungs)
            }
        }
    }

    /// Which pixels of that block are traced, by the region of its patch: a bit
    /// for each, by row, then column.
    fn block_traced(&self, patch: Region, view: &View, x: u32, y: u32) -> u64 {
        match (&self.lod, patch) {
            (None, _) | (_, Region::Central | Region::Traced(_)) => u64::MAX,
            (_, Region::Outside) => 0,
            (Some(lod), Region::Mixed) => match region_of(lod, view, (x, y), BLOCK) {
                Region::Central | Region::Traced(_) => u64::MAX,
                Region::Outside => 0,
                Region::Mixed => BlockLevels::new(lod, self.tracer.simd(), view, (x, y)).traced,
            },
        }
    }
}

/// A tile on its way to being finished.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TileJob {
    tile: Tile,
    /// Pixels finished, in the order of blocks and rows within them.
    finished: u32,
}

impl TileJob {
    /// Not begun.
    pub const fn new(tile: Tile) -> Self {
        Self { tile, finished: 0 }
    }

    /// The rectangle.
    pub const fn tile(&self) -> Tile {
        self.tile
    }

    /// Renders pixels into `pixels` (rows of the tile, from the top) until
    /// the tile is finished or the budget spent.
    ///
    /// The budget is looked at before each pixel, in tile mode before each
    /// block of 8×8 and each ray tree in it. A call does at most its budget
    /// and all samples of one pixel more; in tile mode, besides, one sample's
    /// primary rays of a block, or of a row of eight pixels of a dome master. A
    /// budget that is spent already does nothing.
    ///
    /// # Errors
    /// A tile that is not inside the view; `pixels` of another length than
    /// the tile.
    pub fn render<const W: usize>(
        &mut self,
        renderer: &Renderer<'_, W>,
        view: &View,
        pixels: &mut [Pixel],
        budget: &mut Budget,
        workspace: &mut Workspace,
    ) -> Result<Outcome, TileError>
    where
        Simd: Runs<W>,
    {
        let tile = self.tile;
        let inside = |first: u32, count: u32, all: u32| {
            count > 0 && first.checked_add(count).is_some_and(|end| end <= all)
        };
        if !inside(tile.x, tile.width, view.columns()) || !inside(tile.y, tile.height, view.rows())
        {
            return Err(TileError::Outside);
        }
        let needed = tile.width as usize * tile.height as usize;
        if pixels.len() != needed {
            return Err(TileError::Pixels {
                needed,
                given: pixels.len(),
            });
        }
        // Blocks are of the view's grid, cut off at the tile's borders.
        let mut before = 0;
        let mut patch = None;
        let mut y = tile.y;
        while y < tile.y + tile.height {
            let rows = (BLOCK - y % BLOCK).min(tile.y + tile.height - y);
            let mut x = tile.x;
            while x < tile.x + tile.width {
                let columns = (BLOCK - x % BLOCK).min(tile.x + tile.width - x);
                let area = rows * columns;
                if self.finished < before + area {
                    if budget.is_spent() {
                        return Ok(Outcome::BudgetSpent);
                    }
                    let place = (x / PATCH, y / PATCH);
                    let (_, patch) = match patch {
                        Some(known @ (at, _)) if at == place => known,
                        _ => *patch.insert((place, renderer.patch_region(view, x, y))),
                    };
                    let block = Block {
                        x,
                        y,
                        columns,
                        rows,
                        patch,
                    };
                    let first = self.finished - before;
                    let mut target = Target {
                        pixels: &mut *pixels,
                        width: tile.width as usize,
                        x: (x - tile.x) as usize,
                        y: (y - tile.y) as usize,
                    };
                    let done = block.render(renderer, view, first, budget, workspace, &mut target);
                    self.finished += done;
                    if self.finished < before + area {
                        return Ok(Outcome::BudgetSpent);
                    }
                }
                before += area;
                x += columns;
            }
            y += rows;
        }
        Ok(Outcome::Finished)
    }
}
