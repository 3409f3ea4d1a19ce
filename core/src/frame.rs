//! Tiles of pixels: resumable, within a budget.
//!
//! A wall, a dome or a dome master is a [`View`]; a [`TileJob`] is a rectangle
//! of it on its way to being finished. The caller owns the pixels and the
//! [`Workspace`], deals out the [`Budget`], and calls [`TileJob::render`] until
//! it says [`Outcome::Finished`]. Every pixel is a function of the scene, the view, the
//! [`Settings`] and its place in the view only: not of tiles, their order, or
//! how often rendering was interrupted.

mod begun;
mod block;
mod detail;
mod dome;
mod fill;
mod foveation;
#[cfg(test)]
mod hostile;
mod job;
mod ledger;
mod past;
#[cfg(test)]
mod slices;
mod square;
mod tile;
mod view;

pub use crate::trace::Width;
pub use crate::trace::budget::{Budget, Statistics};
pub use crate::trace::dispersion::{Spectrum, SpectrumError};
pub use crate::trace::ledger::{Entry, Ledger};
pub use crate::trace::shading::LEAST_WEIGHT;
pub use crate::trace::workspace::{MAX_DEPTH, Pixel, RayDetail, Workspace};
use begun::{Begun, Work};
use block::Rendering;
pub use detail::{BLEND, FACE_TOLERANCE, LevelOfDetail};
use detail::{BlockDetail, BlockLevels, Ladder, PATCH, nearest_detail, region_of};
use dome::{goes_in_blocks, hits_together};
pub use fill::{Fill, Surroundings, SurroundingsError};
use foveation::Foveation;
pub use job::{FrameError, FrameJob, Part, Pictures, Place, Progress, Tiles};
pub use square::{LARGEST_UNIT, foveated_samples};
use tile::{BLOCK, Block, Target};
pub use tile::{Tile, TileError};
#[cfg(feature = "projectors")]
pub use view::Beam;
pub use view::{
    CylinderScreen, DomeError, DomePose, DomeProjection, DomeScreen, FlatScreen, MirrorCamera,
    View, ViewError,
};

use crate::gaze::{Gaze, LineOfSight, Region};
use crate::scene::{EffectSet, Scene};
use crate::simd::{Runs, Simd};
use crate::trace::{RowHits, Sample, Tracer};
use glam::Vec3;
use view::{Dome, RayRow, Screen};

/// Most samples of a pixel.
pub const MAX_SAMPLES: u16 = Sample::MOST;

/// The quality of a picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Settings {
    /// Reflections and refractions after one another, 0 to [`MAX_DEPTH`].
    pub depth: u8,
    /// Rays a pixel, 1 to [`MAX_SAMPLES`], in a fixed pattern (Hammersley's
    /// points); a single one goes through the centre.
    pub samples: u16,
    /// How primary rays go through the scene.
    pub mode: Mode,
}

impl Default for Settings {
    /// Returns the paper's three bounces, one ray a pixel.
    fn default() -> Self {
        Self {
            depth: 3,
            samples: 1,
            mode: Mode::Tile,
        }
    }
}

/// How primary rays go through the scene: it changes steps, never a pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Mode {
    /// One at a time: the finest budget, the least memory. One test spares a block of a screen
    /// whose rays see past everything.
    Single,
    /// Blocks of 8×8 pixels together: a node or a primitive counts one step for the block. Rays of
    /// dome masters go in rows of eight pixels, or eight samples of one, as far as the meshes.
    Tile,
}

/// How a call of [`TileJob::render`] ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[must_use]
pub enum Outcome {
    /// All pixels are finished.
    Finished,
    /// The budget ran out; call again to go on. Pixels not reached are as they were.
    BudgetSpent,
}

/// Renders views of a scene in the fast layout.
pub type FastRenderer<'a> = Renderer<'a, 8>;

/// Renders views of a scene in the compact layout.
pub type CompactRenderer<'a> = Renderer<'a, 4>;

/// Renders views of a scene.
#[derive(Debug, Clone, Copy)]
pub struct Renderer<'a, const W: usize = 8> {
    tracer: Tracer<'a, W>,
    settings: Settings,
    /// How rays go together in [`Mode::Tile`].
    together: Option<Together<W>>,
    /// The detail of rays that no gaze reduces.
    most: RayDetail,
    /// Returns the width of a view's rays with a number of samples a pixel.
    pixel_width: Option<fn(&View, u16) -> Width>,
    lod: Option<LevelOfDetail>,
    pixels: Pixels<W>,
}

/// Effects that ask how wide a pixel's rays are.
const WITH_WIDTHS: EffectSet = EffectSet::TEXTURE_LEVELS.union(EffectSet::ENVIRONMENT);

/// Which pixels have rays.
#[derive(Debug, Clone, Copy)]
enum Pixels<const W: usize> {
    /// Every pixel.
    All,
    /// The pixels that this gaze gives less than this level.
    Below(LevelOfDetail, f32),
    /// Squares of pixels, with the detail that an eye sees.
    Foveated(Foveation<W>),
}

/// How rays go together: pointers, so that other programs have no code for it.
#[derive(Debug, Clone, Copy)]
struct Together<const W: usize> {
    block: RenderBlock<W, Screen>,
    /// Renders a block of a dome seen from one point; `None` where rows are faster.
    dome_block: Option<RenderBlock<W, Dome>>,
    row: FindRow<W>,
}

type RenderBlock<const W: usize, S> = fn(&Rendering<'_, '_, W>, &S, &mut Work<'_>);

type FindRow<const W: usize> = fn(
    &Tracer<'_, W>,
    &RayRow,
    &[Option<RayDetail>; 8],
    &mut Budget,
    &mut Workspace,
) -> Option<RowHits>;

impl<'a, const W: usize> Renderer<'a, W>
where
    Simd: Runs<W>,
{
    /// Returns a renderer with every effect. Settings out of range are moved to the nearest
    /// valid value.
    pub fn new(scene: Scene<'a, W>, simd: Simd, settings: Settings) -> Self
    where
        Simd: crate::Runs<W>,
    {
        <Simd as crate::Runs<W>>::renderer(scene, simd, settings)
    }

    /// Returns a renderer like [`new`](Self::new)'s, with the smallest shading in
    /// [`COMPILED`](crate::COMPILED) that has the effects wanted, or with every effect.
    pub fn smallest(scene: Scene<'a, W>, simd: Simd, settings: Settings, wanted: EffectSet) -> Self
    where
        Simd: crate::Runs<W>,
    {
        <Simd as crate::Runs<W>>::smallest(scene, simd, settings, wanted)
    }

    /// Returns a renderer like [`new`](Self::new)'s, with the shading compiled for the effects in
    /// [bits](EffectSet::bits): see [`Tracer::for_effects`].
    pub fn for_effects<const EFFECTS: u32>(
        scene: Scene<'a, W>,
        simd: Simd,
        settings: Settings,
    ) -> Self {
        let dome_block: RenderBlock<W, Dome> =
            |rendering, dome, work| rendering.render_together(dome, work);
        let together = match settings.mode {
            Mode::Single => None,
            Mode::Tile => Some(Together {
                block: |rendering, screen, work| rendering.render_together(screen, work),
                dome_block: goes_in_blocks(&scene).then_some(dome_block),
                row: hits_together::<W, EFFECTS>,
            }),
        };
        Self {
            together,
            ..Self::single::<EFFECTS>(scene, simd, settings)
        }
    }

    /// Returns a renderer like [`for_effects`](Self::for_effects)'s, always in [`Mode::Single`]. A
    /// program that makes all its renderers with this function has no code for the other mode,
    /// which is more than half of the tracer.
    pub fn single<const EFFECTS: u32>(scene: Scene<'a, W>, simd: Simd, settings: Settings) -> Self {
        let settings = Settings {
            depth: settings.depth.min(MAX_DEPTH),
            samples: settings.samples.clamp(1, MAX_SAMPLES),
            ..settings
        };
        let tracer = Tracer::for_effects::<EFFECTS>(scene, simd, settings.depth);
        Self {
            tracer,
            settings,
            together: None,
            most: tracer.detail(),
            // A pointer: other sets of effects do not link the function.
            pixel_width: if EFFECTS & WITH_WIDTHS.bits() == 0 {
                None
            } else {
                Some(View::pixel_width)
            },
            lod: None,
            pixels: Pixels::All,
        }
    }

    /// Returns the same renderer for the same scene at other [poses](crate::scene::Poses).
    #[must_use]
    pub const fn posed<'b>(self, scene: Scene<'b, W>) -> Renderer<'b, W>
    where
        'a: 'b,
    {
        let mut posed: Renderer<'b, W> = self;
        posed.tracer = self.tracer.posed(scene);
        posed
    }

    /// Returns the same renderer without some effects.
    #[must_use]
    pub const fn without(mut self, effects: EffectSet) -> Self {
        self.tracer = self.tracer.without(effects);
        self
    }

    /// Returns the same renderer with wavelengths: see [`Tracer::with_spectrum`]. Before
    /// any level of detail.
    ///
    /// # Errors
    /// A wavelength outside the range of a medium of the scene.
    pub fn with_spectrum(mut self, spectrum: Spectrum<'a>) -> Result<Self, SpectrumError> {
        self.tracer = self.tracer.with_spectrum(spectrum)?;
        self.most = self.tracer.detail();
        Ok(self)
    }

    /// Returns the same renderer with all rays at a level, moved to the nearest from 0 to 1:
    /// bounces by equation 9, the rung of meshes closest to equation 10.
    #[must_use]
    pub fn at_level(mut self, level: f32) -> Self {
        let full = self.tracer.detail();
        let level = nearest_detail(level);
        self.most = RayDetail {
            depth: level.bounces(full.depth),
            rung: Ladder::new(self.tracer.scene().rungs()).nearest(level.level()),
            wavelengths: level.wavelengths(full.wavelengths),
            ..full
        };
        self
    }

    /// Returns the same renderer with no more faces of a mesh than equation 10 gives a level, moved
    /// to the nearest from 0 to 1. Before any level of detail.
    #[must_use]
    pub fn with_faces_of_level(mut self, level: f32) -> Self {
        let level = nearest_detail(level);
        self.most.rung = Ladder::new(self.tracer.scene().rungs()).nearest(level.level());
        self
    }

    /// Returns the same renderer with a detail that follows the gaze: as it is without in the
    /// central field; outside the visual field pixels show what a ray sees that meets nothing.
    #[must_use]
    pub const fn with_level_of_detail(mut self, lod: LevelOfDetail) -> Self {
        self.lod = Some(lod);
        self
    }

    /// Returns the same renderer with only the rays that a gaze gives less than a
    /// level, each in full: for what is to fill the rest of a frame that follows
    /// that gaze. Other pixels show what a ray sees that meets nothing.
    #[must_use]
    pub const fn below_level(mut self, gaze: Gaze, level: f32) -> Self {
        self.pixels = Pixels::Below(LevelOfDetail::new(gaze), level);
        self
    }

    /// Returns the line of sight that its detail follows, if it follows one.
    pub const fn line_of_sight(&self) -> Option<LineOfSight> {
        match (&self.lod, &self.pixels) {
            (Some(lod), _) => Some(lod.gaze.line_of_sight()),
            (None, Pixels::Foveated(foveation)) => Some(foveation.sight),
            (None, _) => None,
        }
    }

    /// Returns the tracer of its rays.
    pub const fn tracer(&self) -> &Tracer<'a, W> {
        &self.tracer
    }

    /// Returns how pixel (x, y) of a view is traced; `None` where it is not, the view has no such
    /// pixel, or its centre is outside a dome master's rim.
    pub fn detail(&self, view: &View, x: u32, y: u32) -> Option<RayDetail> {
        if x >= view.columns() || y >= view.rows() {
            return None;
        }
        view.direction(x as f32, y as f32)?;
        let patch = self.patch_region(view, x, y);
        self.block_detail(patch, view, x, y)
            .at(x % BLOCK, y % BLOCK)
    }

    const fn rendering<'r>(
        &'r self,
        view: &'r View,
        tile: Tile,
        patch: Region,
    ) -> Rendering<'r, 'a, W> {
        let block = Block { tile, patch };
        Rendering {
            renderer: self,
            view,
            block,
        }
    }

    /// Returns what is seen of a view past all objects along a direction.
    #[inline]
    fn missed(&self, view: &View, direction: Vec3) -> Pixel {
        self.tracer.missed(direction, || self.most_of(view).spread)
    }

    /// Returns what is seen past all objects at a point of a view; nothing outside a dome master's
    /// rim.
    fn past(&self, view: &View, x: f32, y: f32) -> Pixel {
        match view.direction(x, y) {
            Some(direction) => self.missed(view, direction),
            None => Pixel::default(),
        }
    }

    /// Returns the most detail of the rays of a view.
    fn most_of(&self, view: &View) -> RayDetail {
        let width_of = self.pixel_width.filter(|_| self.reads_levels());
        let width_of = width_of.map(|width_of| width_of(view, self.settings.samples));
        RayDetail {
            spread: width_of.unwrap_or(Width::ZERO),
            ..self.most
        }
    }

    /// Returns whether textures or the background are as coarse as what a pixel sees of them.
    fn reads_levels(&self) -> bool {
        let carried_out = self
            .tracer
            .effects()
            .intersection(self.tracer.scene().effects());
        carried_out.intersects(WITH_WIDTHS)
    }

    /// Returns where the patch that contains pixel (x, y) lies in the visual field.
    fn patch_region(&self, view: &View, x: u32, y: u32) -> Region {
        match &self.lod {
            None => Region::Central,
            Some(lod) => region_of(lod, view, (x, y), PATCH),
        }
    }

    /// Returns the detail of the pixels of the block that contains (x, y), given its patch's
    /// region.
    #[inline]
    fn block_detail(&self, patch: Region, view: &View, x: u32, y: u32) -> BlockDetail {
        self.detail_up_to(self.most_of(view), patch, view, (x, y))
    }

    // Not inlined: keeps its stack frame out of the callers'.
    #[inline(never)]
    fn detail_up_to(
        &self,
        most: RayDetail,
        patch: Region,
        view: &View,
        (x, y): (u32, u32),
    ) -> BlockDetail {
        if let Pixels::Below(gaze, level) = &self.pixels {
            let levels = BlockLevels::new(gaze, self.tracer.simd(), view, (x, y));
            return levels.below(*level, most);
        }
        match (&self.lod, patch) {
            (None, _) | (_, Region::Central) => BlockDetail::Equal(most),
            (_, Region::Outside) => BlockDetail::Outside,
            (Some(lod), Region::Traced(_) | Region::Mixed) => {
                let rungs = self.tracer.scene().rungs();
                BlockDetail::new(lod, self.tracer.simd(), view, (x, y), most, rungs)
            }
        }
    }

    /// Returns the traced pixels of that block: a bit for each, by row, then column.
    fn block_traced(&self, patch: Region, view: &View, x: u32, y: u32) -> u64 {
        if let Pixels::Below(..) = self.pixels {
            return self.block_detail(patch, view, x, y).traced();
        }
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
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TileJob {
    tile: Tile,
    /// Pixels of finished blocks and squares, in their order.
    finished: u32,
    /// Pixels after which it ends.
    end: u32,
    /// State of the next, unfinished block or square.
    begun: Begun,
}

impl TileJob {
    /// Returns a job that has not begun.
    pub const fn new(tile: Tile) -> Self {
        Self::cut(tile, u32::MAX)
    }

    /// Returns a job that ends where another one of the same frame was [given up](Self::give_up),
    /// after its [`kept`](Self::kept) pixels: rendered without that one's budget and given up then,
    /// it has the same pixels.
    pub const fn cut(tile: Tile, kept: u32) -> Self {
        let area = tile.width as u64 * tile.height as u64;
        Self {
            tile,
            finished: 0,
            end: if area < kept as u64 {
                area as u32
            } else {
                kept
            },
            begun: Begun::NOTHING,
        }
    }

    /// Returns the rectangle.
    pub const fn tile(&self) -> Tile {
        self.tile
    }

    /// Returns how many of its pixels are finished, in rows from the top left.
    pub const fn finished(&self) -> u32 {
        self.finished
    }

    /// Returns how many of its pixels, in the order in which they are rendered, keep their colour if
    /// it is [given up](Self::give_up) now.
    pub const fn kept(&self) -> u32 {
        self.finished.saturating_add(self.begun.pixels)
    }

    /// Returns whether all its pixels are finished, or those before its [cut](Self::cut).
    pub const fn is_finished(&self) -> bool {
        self.finished >= self.end
    }

    /// Renders pixels into `pixels` (rows of the tile, from the top) until the tile is finished or
    /// the budget spent.
    ///
    /// With S the budget's steps and P the most that a sample takes, a call takes at most
    /// S + P − 1, whatever [`Settings::samples`] is: the next call goes on with the next sample. P
    /// is one ray tree and at most 16 steps of a test for its block; in tile mode, besides, one
    /// sample's primary rays of the block, or eight of a dome master. With
    /// [foveation](Renderer::with_foveation) P is what a square takes, up to 1024 ray trees. A budget
    /// [that has an overrun](Budget::with_overrun) bounds this too: a sample that is broken off is
    /// begun anew by the next call.
    ///
    /// # Errors
    /// A tile that is not inside the view; `pixels` of another length than the tile.
    pub fn render<const W: usize>(
        &mut self,
        renderer: &Renderer<'_, W>,
        view: &View,
        pixels: &mut [Pixel],
        budget: &mut Budget,
        workspace: &mut Workspace,
    ) -> Result<Outcome, TileError>
    where
        Simd: crate::Runs<W>,
    {
        <Simd as crate::Runs<W>>::render(self, renderer, view, pixels, budget, workspace)
    }

    // Not inlined: keeps its stack frame out of the callers'.
    #[inline(never)]
    pub(crate) fn render_by<const W: usize>(
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
        tile.check(view.size(), pixels.len())?;
        if let Pixels::Foveated(foveation) = &renderer.pixels {
            let render = foveation.render;
            return Ok(render(renderer, self, view, pixels, budget, workspace));
        }
        let mut before = 0;
        let mut patch = None;
        for part in tile.blocks() {
            before += part.area();
            if self.finished >= before {
                continue;
            }
            if self.is_finished() {
                break;
            }
            if budget.is_spent() {
                return Ok(Outcome::BudgetSpent);
            }
            let place = (part.x / PATCH, part.y / PATCH);
            let (_, patch) = match patch {
                Some(known @ (at, _)) if at == place => known,
                _ => *patch.insert((place, renderer.patch_region(view, part.x, part.y))),
            };
            let mut work = Work {
                begun: &mut self.begun,
                budget,
                workspace,
                target: Target::new(pixels, tile, part),
            };
            renderer.rendering(view, part, patch).render(&mut work);
            if self.begun.pixels < part.area() {
                return Ok(Outcome::BudgetSpent);
            }
            self.end_part(before);
        }
        Ok(Outcome::Finished)
    }

    /// Ends a block or square, with `finished` pixels of the tile done.
    const fn end_part(&mut self, finished: u32) {
        self.finished = finished;
        self.begun = Begun::NOTHING;
    }

    /// Gives unfinished pixels the background, and so finishes the tile. With
    /// [foveation](Renderer::with_foveation) each unfinished square gets the colour of its middle, by
    /// one ray.
    ///
    /// # Errors
    /// Those of [`render`](Self::render).
    pub fn give_up<const W: usize>(
        &mut self,
        renderer: &Renderer<'_, W>,
        view: &View,
        pixels: &mut [Pixel],
    ) -> Result<(), TileError>
    where
        Simd: crate::Runs<W>,
    {
        <Simd as crate::Runs<W>>::give_up(self, renderer, view, pixels)
    }

    #[inline(never)]
    pub(crate) fn give_up_by<const W: usize>(
        &mut self,
        renderer: &Renderer<'_, W>,
        view: &View,
        pixels: &mut [Pixel],
    ) -> Result<(), TileError>
    where
        Simd: Runs<W>,
    {
        let tile = self.tile;
        tile.check(view.size(), pixels.len())?;
        if let Pixels::Foveated(foveation) = &renderer.pixels {
            (foveation.give_up)(renderer, self, view, pixels);
            return Ok(());
        }
        let (mut number, finished) = (0, self.kept().min(self.end));
        for part in tile.blocks() {
            for y in part.y..part.y + part.height {
                for x in part.x..part.x + part.width {
                    let index = tile.index(x, y);
                    if let (true, Some(pixel)) = (number >= finished, pixels.get_mut(index)) {
                        *pixel = renderer.past(view, x as f32, y as f32);
                    }
                    number += 1;
                }
            }
        }
        self.end_part(number);
        Ok(())
    }
}
