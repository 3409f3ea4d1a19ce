//! Renders a frame on all cores within a budget of steps, without allocating.
//!
//! Before tiles are rendered, each gets an allotment of the budget, from the line of sight
//! outwards, by the steps that it took in the frame before. Further rounds allot what is left over
//! to unfinished tiles. Allotments depend on steps alone: a frame is the same on any number of
//! threads.

mod capture;
mod cut;
mod deal;
mod describe;
mod fovea;
mod threads;

use super::flight::RoomPlace;
use super::lock;
use super::quality::Quality;
use super::swap::Share;
use crate::bake::{Stage, StageMemory, Staged};
use crate::cave::{Cave, Eye};
use crate::picture::Picture;
use crate::render::{self, CaptureOptions, Observer, Options, RenderError};
use crate::scene;
use crate::with_scene;
use capture::LiveCapture;
pub use cut::Cut;
use deal::{Dealer, Group, LiveTile};
pub use describe::Undescribed;
use fovea::{SAME_PLACE, is_foveal, reaching_fovea, towards};
use rayon::prelude::*;
use shisen_core::frame::{Fill, Pixel, Spectrum, Statistics, Tile, TileJob, Workspace};
use shisen_core::scene::Scene;
use shisen_core::{Runs, Simd};
use std::sync::Mutex;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};
use threads::{Plan, Shared, pairs};

/// Most rounds in which a frame's budget is allotted to its tiles.
const MOST_ROUNDS: u32 = 8;

/// Sort key of a dome master's tiles: below any cosine, so that they come after the screens' tiles.
const LAST_IN_ORDER: f32 = -3.0;

/// Steps that a finished tile is expected to take in the next frame beyond those of this one.
const LEAST_EXPECTED: u64 = 8;

/// One part in this many of the fovea's expected steps is reserved for it.
const RESERVE: u64 = 4;

/// The tiles that a round allots steps to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Allotment {
    /// The fovea's unfinished tiles.
    Fovea,
    /// All unfinished tiles.
    All,
    /// All unfinished tiles, less a reserve for the fovea.
    AllButReserve,
}

/// Renders frames of one scene for one set of screens.
pub trait Engine {
    /// Renders what these eyes see in at most `steps` steps. With `whole_fovea` it always finishes
    /// the [`FOVEA`](super::FOVEA) of eyes whose line of sight is known, and may take more.
    ///
    /// Pictures of screens that their eye does not see are dark.
    ///
    /// # Errors
    /// Other eyes than the engine was made for.
    fn render_frame(
        &mut self,
        eyes: &[Observer],
        quality: &Quality,
        steps: Option<u64>,
        whole_fovea: bool,
    ) -> Result<Rendered, RenderError>;

    /// Returns whether anything in the scene moves.
    fn moves(&self) -> bool {
        false
    }

    /// Moves the scene to where it is at a time in seconds.
    ///
    /// # Errors
    /// A pose that the core refuses.
    fn set_time(&mut self, _: f64) -> Result<(), RenderError> {
        Ok(())
    }

    /// Moves the room to another place of the scene.
    fn set_place(&mut self, _: &RoomPlace) {}

    /// Does what [`render_frame`](Self::render_frame) does without `whole_fovea`.
    ///
    /// # Errors
    /// Those of [`render_frame`](Self::render_frame).
    fn render(
        &mut self,
        eyes: &[Observer],
        quality: &Quality,
        steps: Option<u64>,
    ) -> Result<Rendered, RenderError> {
        self.render_frame(eyes, quality, steps, false)
    }

    /// Copies the newest frame's pictures, by screen, then eye, over those of an older
    /// frame or into an empty list. If `filled`, pixels that the gaze skips keep the older colour,
    /// and both are blended at the border of the field.
    ///
    /// # Errors
    /// Not enough memory.
    fn pictures(&self, over: &mut Vec<Picture>, filled: bool) -> Result<(), RenderError>;

    /// Returns the [hashes](Picture::hash) of the newest frame's pictures.
    ///
    /// # Errors
    /// Not enough memory.
    fn hashes(&self) -> Result<Vec<u64>, RenderError> {
        let mut pictures = Vec::new();
        self.pictures(&mut pictures, false)?;
        Ok(pictures.iter().map(Picture::hash).collect())
    }

    /// Puts the newest frame's tiles into `tiles`, each with the number of its picture, in the
    /// order in which they got their allotments.
    fn tiles(&self, tiles: &mut Vec<(usize, Tile)>);

    /// Puts the newest frame's tiles that its budget cut off into `cuts`.
    fn cuts(&self, cuts: &mut Vec<Cut>);

    /// Renders a frame without a budget, and cuts tiles off as another one's budget did.
    ///
    /// # Errors
    /// Those of [`render_frame`](Self::render_frame).
    fn render_cut(
        &mut self,
        eyes: &[Observer],
        quality: &Quality,
        cuts: &[Cut],
    ) -> Result<Rendered, RenderError>;

    /// Puts a hash of each of the newest frame's tiles into `hashes`, by picture, row and column.
    fn tile_hashes(&self, hashes: &mut Vec<u64>);

    /// Returns the description of the newest frame, which these eyes see with these cuts, for
    /// programs that have the core alone: `host/web/src/frame.rs` has the format.
    ///
    /// # Errors
    /// What descriptions do not have.
    fn describe(&self, eyes: &[Observer], cuts: &[Cut]) -> Result<Vec<u8>, Undescribed>;
}

/// An engine for one width of nodes.
struct TileEngine<'e, 's, const W: usize> {
    shared: &'e Shared<'s, W>,
    cave: &'e Cave,
    scene: Scene<'s, W>,
    options: Options,
    spectrum: Spectrum<'s>,
    workspace: Workspace,
    share: Share,
    dealer: Dealer,
    quality: Quality,
    place: RoomPlace,
    /// Where the frame is cut off.
    cuts: Vec<Cut>,
}

/// The result of a frame.
#[derive(Debug, Clone, Copy)]
pub struct Rendered {
    /// Steps taken.
    pub steps: u64,
    /// Estimate of the steps that all tiles need.
    pub need: u64,
    /// Number of tiles.
    pub tiles: usize,
    /// Tiles that the budget did not finish.
    pub unfinished: usize,
    /// Whether an unfinished tile is within [`FOVEA`](super::FOVEA) of a line of sight.
    pub unfinished_fovea: bool,
    /// Rounds in which the budget was dealt.
    pub rounds: u32,
    /// Rays and steps.
    pub statistics: Statistics,
    /// Time of tracing.
    pub tracing: Duration,
    /// Time to replace unfinished pixels.
    pub giving_up: Duration,
    /// When the first ray started.
    pub first_ray: Instant,
    /// When the last pixel was done.
    pub done: Instant,
}

/// Calls `run` with an engine that renders a share of what `eyes` see. A capture shows where
/// their gaze skips rays, as in [`Filling::Capture`](crate::render::Filling::Capture), but its
/// steps are part of the frame's and its axes are the room's, so that older parts of it stay
/// in place.
///
/// # Errors
/// An eye that does not see a screen; an impossible size of a capture.
pub fn with_engine<'s, R>(
    scene: impl Into<Staged<'s>>,
    cave: &Cave,
    eyes: &[Observer],
    options: &Options,
    capture: Option<CaptureOptions>,
    share: Share,
    run: impl FnOnce(&mut dyn Engine) -> R,
) -> Result<R, RenderError> {
    let Staged { scene, moving } = scene.into();
    with_scene!(scene, |scene| engine(
        &scene, moving, cave, eyes, options, capture, share, run
    ))
}

#[expect(clippy::too_many_arguments, reason = "those of `with_engine`")]
fn engine<const W: usize, R>(
    scene: &Scene<'_, W>,
    moving: Option<&scene::Scene>,
    cave: &Cave,
    eyes: &[Observer],
    options: &Options,
    capture: Option<CaptureOptions>,
    share: Share,
    run: impl FnOnce(&mut dyn Engine) -> R,
) -> Result<R, RenderError>
where
    Simd: Runs<W>,
{
    let mut memory = moving.map(|moving| StageMemory::of(scene, moving));
    let stage = moving.zip(memory.as_mut());
    let stage = stage.map(|(moving, memory)| Stage::new(*scene, moving, memory));
    let stage = stage.transpose()?;
    let mut storage = Vec::new();
    let spectrum = options.dispersion.spectrum(&mut storage);
    let mut tiles = Vec::new();
    let mut parts = Vec::new();
    for (_, screen, observer) in pairs(cave, eyes, share) {
        let view = render::view(screen, observer)?;
        let part = parts.len();
        let places = render::tiles(&view, options.tile);
        tiles.extend(places.map(|tile| Mutex::new(LiveTile::new(part, tile))));
        parts.push((view, render::renderer(scene, observer, options, spectrum)?));
    }
    let follows = eyes.iter().any(|eye| eye.lod.is_some());
    let capture = match capture.filter(|_| follows && !parts.is_empty()) {
        Some(how) => {
            let capture = LiveCapture::new(how, parts.len(), tiles.len());
            let place = &RoomPlace::START;
            parts.extend(capture.views(eyes, place, scene, options, spectrum)?);
            tiles.extend(capture.tiles().map(Mutex::new));
            Some(capture)
        }
        None => None,
    };
    let threads = options.threads.max(1);
    let plan = Plan {
        stage,
        sights: vec![None; parts.len()],
        dark: vec![false; parts.len()],
        parts,
        order: Vec::with_capacity(tiles.len()),
        first: 0,
        settled: false,
        groups: Vec::with_capacity(tiles.len()),
        capture,
        fills: false,
    };
    let shared = Shared::new(plan, tiles, threads);
    std::thread::scope(|scope| {
        for _ in 1..threads {
            scope.spawn(|| shared.serve());
        }
        // Ends the threads even if `run` panics.
        let _dismissal = Dismissal(&shared);
        Ok(run(&mut TileEngine {
            shared: &shared,
            cave,
            scene: *scene,
            options: *options,
            spectrum,
            workspace: Workspace::new(),
            share,
            dealer: Dealer::new(options.settings.samples),
            quality: Quality::FULL,
            place: RoomPlace::START,
            cuts: Vec::new(),
        }))
    })
}

struct Dismissal<'e, 's, const W: usize>(&'e Shared<'s, W>);

impl<const W: usize> Drop for Dismissal<'_, '_, W> {
    fn drop(&mut self) {
        self.0.over.store(true, Ordering::SeqCst);
        self.0.begin.wait();
    }
}

impl<const W: usize> Engine for TileEngine<'_, '_, W>
where
    Simd: Runs<W>,
{
    fn render_frame(
        &mut self,
        eyes: &[Observer],
        quality: &Quality,
        steps: Option<u64>,
        whole_fovea: bool,
    ) -> Result<Rendered, RenderError> {
        self.plan(eyes, quality, steps)?;
        if eyes.iter().any(|eye| eye.foveation.is_some()) {
            self.dealer.expect_squares();
        }
        self.dealer.hard_limit = steps.filter(|_| !whole_fovea);
        self.shared.first_ray.store(u64::MAX, Ordering::SeqCst);
        let (mut rounds, mut tracing) = (0, Duration::ZERO);
        let mut round = |engine: &mut Self| {
            rounds += 1;
            let begun = Instant::now();
            engine.run_round();
            tracing += begun.elapsed();
        };
        for &(allotment, most) in self.turns(steps) {
            for _ in 0..most {
                let spent = self.shared.spent.load(Ordering::SeqCst);
                let left = steps.map(|steps| steps.saturating_sub(spent));
                if !self.deal(left, allotment) {
                    break;
                }
                round(self);
                self.dealer.note_excess(&self.shared.excess);
            }
        }
        if whole_fovea && self.deal_fovea() {
            round(self);
        }
        let rendered = self.finish(rounds);
        self.cut_off();
        self.fill();
        Ok(Rendered {
            tracing,
            done: Instant::now(),
            ..rendered
        })
    }

    fn moves(&self) -> bool {
        self.shared.read().stage.is_some()
    }

    fn set_time(&mut self, time: f64) -> Result<(), RenderError> {
        let stage = &mut self.shared.write().stage;
        stage
            .as_mut()
            .map_or(Ok(()), |stage| stage.set_time(time))?;
        Ok(())
    }

    fn set_place(&mut self, place: &RoomPlace) {
        self.place = *place;
    }

    fn pictures(&self, over: &mut Vec<Picture>, filled: bool) -> Result<(), RenderError> {
        let plan = self.shared.read();
        let filled = filled && !over.is_empty();
        if over.is_empty() {
            for (view, _) in plan.screens() {
                over.push(Picture::new(view.columns(), view.rows())?);
            }
        }
        over.par_iter_mut().enumerate().for_each(|(part, picture)| {
            let (mut pixels, mut before) = (Vec::new(), Vec::new());
            let tiles = self.shared.tiles.iter().map(lock);
            for tile in tiles.filter(|tile| tile.part == part) {
                let place = tile.job.tile();
                if !filled || plan.dark[part] {
                    render::put(picture, place, &tile.pixels);
                    continue;
                }
                pixels.clone_from(&tile.pixels);
                render::pixels_of(picture, place, &mut before);
                let (view, renderer) = &plan.parts[part];
                let filled = renderer.fill(view, place, &Fill::Pixels(&before), &mut pixels);
                debug_assert!(filled.is_ok(), "its own pixels");
                render::put(picture, place, &pixels);
            }
        });
        Ok(())
    }

    fn tiles(&self, tiles: &mut Vec<(usize, Tile)>) {
        let plan = self.shared.read();
        let screens = plan.screens().len();
        tiles.clear();
        tiles.extend(plan.order.iter().filter_map(|&(_, number)| {
            let tile = lock(&self.shared.tiles[number as usize]);
            (tile.part < screens).then(|| (tile.part, tile.job.tile()))
        }));
    }

    fn cuts(&self, cuts: &mut Vec<Cut>) {
        self.newest_cuts(cuts);
    }

    fn render_cut(
        &mut self,
        eyes: &[Observer],
        quality: &Quality,
        cuts: &[Cut],
    ) -> Result<Rendered, RenderError> {
        self.cuts = cuts.to_vec();
        let rendered = self.render_frame(eyes, quality, None, false);
        self.cuts.clear();
        rendered
    }

    fn tile_hashes(&self, hashes: &mut Vec<u64>) {
        self.newest_hashes(hashes);
    }

    fn describe(&self, eyes: &[Observer], cuts: &[Cut]) -> Result<Vec<u8>, Undescribed> {
        self.description(eyes, cuts)
    }
}

impl<const W: usize> TileEngine<'_, '_, W>
where
    Simd: Runs<W>,
{
    fn plan(
        &mut self,
        eyes: &[Observer],
        quality: &Quality,
        steps: Option<u64>,
    ) -> Result<(), RenderError> {
        let (shared, scene, spectrum) = (self.shared, &self.scene, self.spectrum);
        let mut options = self.options;
        options.settings.depth = options.settings.depth.min(quality.depth);
        let plan = &mut *shared.write();
        let (parts, sights, order) = (&mut plan.parts, &mut plan.sights, &mut plan.order);
        let (capture, settled) = (&mut plan.capture, &mut plan.settled);
        let screens = capture.as_ref().map(|capture| capture.part);
        let screens = screens.unwrap_or(parts.len());
        if pairs(self.cave, eyes, self.share).count() != screens {
            return Err(RenderError::Previous);
        }
        *settled = *quality == self.quality;
        self.quality = *quality;
        let own = parts.iter_mut().zip(sights.iter_mut().zip(&mut plan.dark));
        for ((_, screen, observer), (part, (sight, dark))) in
            pairs(self.cave, eyes, self.share).zip(own)
        {
            let view = render::view(screen, observer).map(|view| self.place.view(&view));
            let observer = self.place.observer(observer);
            let was = std::mem::replace(sight, observer.forward());
            *settled &= match (was, *sight) {
                (Some(was), Some(sight)) => was.angle_between(sight) <= SAME_PLACE,
                (was, sight) => was == sight,
            };
            let renderer = render::in_full(scene, &options, spectrum)?;
            let renderer = renderer.with_faces_of_level(quality.faces);
            let renderer = quality.lower(observer).follow(&renderer);
            *settled &= *dark == view.is_err();
            *dark = view.is_err();
            *part = (view.unwrap_or(part.0), renderer);
        }
        order.clear();
        shared.spent.store(0, Ordering::SeqCst);
        let own = capture.as_ref().map(|capture| capture.tile);
        for (number, tile) in shared.tiles.iter().enumerate() {
            let mut tile = lock(tile);
            tile.job = TileJob::new(tile.job.tile());
            tile.hash = None;
            (tile.spent, tile.kept) = (0, None);
            if plan.dark.get(tile.part) == Some(&true) {
                tile.pixels.fill(Pixel::default());
            } else if own.is_none_or(|own| number < own) {
                let view = &parts[tile.part].0;
                let cosine = towards(sights[tile.part], view, tile.job.tile());
                order.push((cosine, number as u32));
            }
        }
        self.end_at_cuts();
        if let Some(capture) = capture {
            let views = capture.views(eyes, &self.place, scene, &options, spectrum)?;
            parts.truncate(screens);
            parts.extend(views);
            let part = steps.map_or(1.0, |_| quality.capture);
            order.extend(capture.due(part).map(|tile| (LAST_IN_ORDER, tile as u32)));
        }
        order.sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        plan.first = reaching_fovea(order.iter().map_while(|&(cosine, number)| {
            let tile = lock(&shared.tiles[number as usize]);
            let sight = sights.get(tile.part).copied().flatten();
            let sight = sight.filter(|_| cosine > LAST_IN_ORDER)?;
            Some((sight, &parts[tile.part].0, tile.job.tile()))
        }));
        Ok(())
    }

    /// Returns the order in which steps are dealt, with the most rounds of each.
    fn turns(&self, steps: Option<u64>) -> &'static [(Allotment, u32)] {
        use Allotment::{All, AllButReserve, Fovea};
        // Within a budget the fovea is finished first. While the viewer looks at the same
        // place that needs no round of its own.
        if steps.is_none() {
            &[(All, MOST_ROUNDS)]
        } else if self.shared.read().settled {
            &[(AllButReserve, 1), (Fovea, MOST_ROUNDS), (All, MOST_ROUNDS)]
        } else {
            &[(Fovea, MOST_ROUNDS), (All, MOST_ROUNDS)]
        }
    }

    fn run_round(&mut self) {
        self.shared.next.store(0, Ordering::SeqCst);
        self.shared.begin.wait();
        self.shared.work(&mut self.workspace);
        self.shared.end.wait();
    }

    /// Fills the pixels that the gaze skipped from the capture, once that is complete.
    fn fill(&mut self) {
        let mut plan = self.shared.write();
        plan.fills = plan.capture.as_ref().is_some_and(LiveCapture::is_whole);
        let fills = plan.fills;
        drop(plan);
        if fills {
            self.run_round();
            self.shared.write().fills = false;
        }
    }

    /// Deals the rest of the budget; returns whether any tile got steps.
    fn deal(&mut self, left: Option<u64>, allotment: Allotment) -> bool {
        let shared = self.shared;
        let plan = &mut *shared.write();
        let (order, groups, dealer) = (&plan.order, &mut plan.groups, &self.dealer);
        let tile = |&(_, tile): &(f32, u32)| &shared.tiles[tile as usize];
        let foveal = order.get(..plan.first).unwrap_or(order);
        match (left, allotment) {
            (None, _) => deal::unlimited(order.iter().map(tile), groups),
            (Some(left), Allotment::Fovea) => {
                dealer.deal_finely(left, foveal.iter().map(tile), groups);
            }
            (Some(left), Allotment::All) => dealer.deal(left, order.iter().map(tile), groups),
            (Some(left), Allotment::AllButReserve) => {
                let reserve = deal::expected(foveal.iter().map(tile)) / RESERVE;
                let reserve = reserve.min(left / RESERVE);
                dealer.deal(left - reserve, order.iter().map(tile), groups);
            }
        }
        !groups.is_empty()
    }

    /// Deals unlimited steps to unfinished tiles of the fovea; returns whether there are any.
    fn deal_fovea(&mut self) -> bool {
        let shared = self.shared;
        let plan = &mut *shared.write();
        plan.groups.clear();
        for (at, &(cosine, number)) in plan.order.iter().enumerate() {
            let tile = lock(&shared.tiles[number as usize]);
            let sight = plan.sights.get(tile.part).copied().flatten();
            if cosine > LAST_IN_ORDER
                && !tile.job.is_finished()
                && sight.is_some()
                && is_foveal(sight, &plan.parts[tile.part].0, tile.job.tile())
            {
                plan.groups.push(Group::unlimited(at));
            }
        }
        !plan.groups.is_empty()
    }

    fn finish(&mut self, rounds: u32) -> Rendered {
        let shared = self.shared;
        let plan = &mut *shared.write();
        let begun = Instant::now();
        let (mut steps, mut need, mut unfinished, mut tiles) = (0, 0, 0, 0);
        let mut unfinished_fovea = false;
        for &(_, number) in &plan.order {
            let mut tile = lock(&shared.tiles[number as usize]);
            let tile = &mut *tile;
            let capture = plan.capture.as_mut();
            let capture = capture.filter(|one| number as usize >= one.tile);
            let is_captured = capture.is_some();
            if let Some(capture) = capture {
                capture.take(number as usize, tile);
            } else if tile.spent > 0 || !tile.job.is_finished() {
                tiles += 1;
            }
            steps += tile.spent;
            if tile.job.is_finished() {
                tile.expected = tile.spent + LEAST_EXPECTED;
                need += tile.spent;
                continue;
            }
            tile.expected = tile.spent + tile.expected_rest();
            need += tile.expected;
            // A capture keeps the older pixels.
            if !is_captured {
                let view = &plan.parts[tile.part].0;
                unfinished += 1;
                unfinished_fovea |= is_foveal(plan.sights[tile.part], view, tile.job.tile());
                tile.kept = Some(tile.job.kept());
                plan.give_up(tile);
            }
        }
        let mut statistics = lock(&shared.statistics);
        statistics.add(&self.workspace.statistics);
        self.workspace.statistics = Statistics::default();
        let done = Instant::now();
        let first_ray = match shared.first_ray.load(Ordering::SeqCst) {
            u64::MAX => done,
            nanoseconds => shared.epoch + Duration::from_nanos(nanoseconds),
        };
        Rendered {
            steps,
            need,
            tiles,
            unfinished,
            unfinished_fovea,
            rounds,
            statistics: std::mem::take(&mut statistics),
            tracing: Duration::ZERO,
            giving_up: (done - begun) * u32::from(unfinished > 0),
            first_ray,
            done,
        }
    }
}

/// Returns the numbers among [`Cave::pictured`] and the eyes of a share's pictures.
pub fn eyes_of<'e>(
    cave: &'e Cave,
    eyes: &'e [Observer],
    share: Share,
) -> impl Iterator<Item = (usize, Eye)> + 'e {
    pairs(cave, eyes, share).map(|(screen, _, eye)| (screen, eye.eye))
}
