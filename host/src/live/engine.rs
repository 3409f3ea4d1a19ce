//! A frame on all cores within a budget of steps.
//!
//! Threads and memory stay from frame to frame: while frames are rendered
//! nothing is allocated. The budget is dealt out to tiles before they are
//! rendered, from the line of sight outwards, by what each took in the frame
//! before; what tiles leave of theirs goes to those that had too little, in
//! further rounds. All of that is a function of steps alone, so a frame is the
//! same on any number of threads, whatever the clock says.

mod capture;
mod deal;
mod fovea;
mod threads;

use super::quality::Quality;
use super::swap::Share;
use crate::cave::{Cave, Eye, Screen};
use crate::picture::Picture;
use crate::render::{self, CaptureOptions, Observer, Options, RenderError};
use capture::LiveCapture;
use deal::{Dealer, Group};
use fovea::{SETTLED, is_foveal, reaching_fovea, towards};
use glam::Vec3;
use shisen_core::frame::{
    Fill, Pixel, Renderer, Spectrum, Statistics, Tile, TileJob, View, Workspace,
};
use shisen_core::scene::Scene;
use shisen_core::{Runs, Simd};
use std::fmt;
use std::sync::atomic::Ordering;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};
use threads::{Shared, lock};

/// In how many rounds a budget is dealt out at most.
const MOST_ROUNDS: u32 = 8;

/// Below all angles' cosines: what comes after all tiles of screens.
const AT_LAST: f32 = -3.0;

/// Steps that a pixel is expected to take of which nothing is known.
const UNKNOWN_PIXEL: u64 = 16;

/// Steps that a tile is expected to take which took none.
const LEAST_EXPECTED: u64 = 8;

/// Of what what is looked at is expected to take, the part that is kept back for it.
const RESERVE: u64 = 4;

/// Whom steps are dealt out to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Whom {
    /// What is looked at.
    Fovea,
    /// All that is not finished.
    All,
    /// All that is not finished, but for what is looked at something more is kept back.
    AllButReserve,
}

/// Where a frame ends that has not enough steps.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Until {
    /// With its steps.
    Steps,
    /// When the [`FOVEA`](super::FOVEA) is whole.
    WholeFovea,
}

/// Renders frames of one scene for one set of screens.
pub struct Engine<'e, 's, const W: usize> {
    shared: &'e Shared<'s, W>,
    cave: &'e Cave,
    scene: Scene<'s, W>,
    options: Options,
    spectrum: Spectrum<'s>,
    workspace: Workspace,
    share: Share,
    dealer: Dealer,
    /// Of the newest frame.
    quality: Quality,
}

impl<const W: usize> fmt::Debug for Engine<'_, '_, W> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Engine")
            .field("options", &self.options)
            .field("share", &self.share)
            .field("quality", &self.quality)
            .finish_non_exhaustive()
    }
}

/// What a frame came to.
#[derive(Debug, Clone, Copy)]
pub struct Rendered {
    /// Steps that it took.
    pub steps: u64,
    /// Steps that all of its tiles would have taken, as far as is known.
    pub need: u64,
    /// Its tiles.
    pub tiles: usize,
    /// Those that the budget did not finish.
    pub unfinished: usize,
    /// Whether one of these is within [`FOVEA`](super::FOVEA) of a line of sight.
    pub unfinished_fovea: bool,
    /// Rounds in which the budget was dealt out.
    pub rounds: u32,
    /// Rays and steps.
    pub statistics: Statistics,
    /// What tracing took.
    pub tracing: Duration,
    /// What it took to give up what was not finished.
    pub giving_up: Duration,
    /// When the first ray started.
    pub first_ray: Instant,
    /// When the last pixel was there.
    pub done: Instant,
}

/// A frame.
struct Plan<'s, const W: usize> {
    /// By screen, then eye; then the hemispheres of a capture.
    parts: Vec<(View, Renderer<'s, W>)>,
    /// Where the eye looks that a screen's part is for, if anybody knows.
    sights: Vec<Option<Vec3>>,
    /// Indices of tiles, from the line of sight outwards; at last those of a capture
    /// that are taken anew.
    order: Vec<(f32, u32)>,
    /// How many of these come before all others: they reach as far as the [`FOVEA`](super::FOVEA).
    first: usize,
    /// Whether the frame before looked at the same with the same quality, so that it says
    /// what these take.
    settled: bool,
    /// What threads take, of the order.
    groups: Vec<Group>,
    capture: Option<LiveCapture>,
    /// Tiles are filled, not traced.
    fills: bool,
}

/// A tile and its pixels.
struct LiveTile {
    part: usize,
    job: TileJob,
    pixels: Vec<Pixel>,
    /// What it took in this frame.
    spent: u64,
    /// What it is expected to take in this frame.
    expected: u64,
}

impl LiveTile {
    fn new(part: usize, tile: Tile) -> Self {
        let area = tile.width as usize * tile.height as usize;
        Self {
            part,
            job: TileJob::new(tile),
            pixels: vec![Pixel::default(); area],
            spent: 0,
            expected: area as u64 * UNKNOWN_PIXEL,
        }
    }

    /// What it is expected to take still. One that had too little shows that the frame
    /// before says little.
    const fn still(&self) -> u64 {
        if self.spent < self.expected {
            self.expected - self.spent
        } else {
            self.spent
        }
    }
}

/// The pairs of a screen and an eye that a share has.
fn pairs<'c>(
    cave: &'c Cave,
    eyes: &'c [Observer],
    share: Share,
) -> impl Iterator<Item = (Screen<'c>, &'c Observer)> {
    let all = cave.screens().count() * eyes.len();
    let pairs = cave
        .screens()
        .flat_map(move |screen| eyes.iter().map(move |eye| (screen, eye)));
    let own = pairs
        .enumerate()
        .filter(move |(pair, _)| share.has(*pair, all));
    own.map(|(_, pair)| pair)
}

/// Has an engine for as long as `run` takes, which renders a share of what `eyes` see.
/// With a capture, that shows where their gaze skips rays, as in
/// [`Filling::Capture`](crate::render::Filling::Capture), but for its steps, which are
/// the frame's, and its axes, which are the room's: what it has from older frames stays
/// where it is.
///
/// # Errors
/// An eye that does not see a screen; a capture of a size that there is not.
pub fn with_engine<'s, const W: usize, R>(
    (scene, spectrum): (Scene<'s, W>, Spectrum<'s>),
    cave: &Cave,
    eyes: &[Observer],
    options: &Options,
    capture: Option<CaptureOptions>,
    share: Share,
    run: impl FnOnce(&mut Engine<'_, 's, W>) -> R,
) -> Result<R, RenderError>
where
    Simd: Runs<W>,
{
    let mut tiles = Vec::new();
    let mut parts = Vec::new();
    for (screen, observer) in pairs(cave, eyes, share) {
        let view = render::view(screen, observer)?;
        let part = parts.len();
        let places = render::tiles(&view, options.tile);
        tiles.extend(places.map(|tile| Mutex::new(LiveTile::new(part, tile))));
        parts.push((view, render::renderer(&scene, observer, options, spectrum)?));
    }
    let follows = eyes.iter().any(|eye| eye.lod.is_some());
    let capture = match capture.filter(|_| follows && !parts.is_empty()) {
        Some(how) => {
            let capture = LiveCapture::new(how, parts.len(), tiles.len());
            parts.extend(capture.views(eyes, &scene, options, spectrum)?);
            tiles.extend(capture.tiles().map(Mutex::new));
            Some(capture)
        }
        None => None,
    };
    let threads = options.threads.max(1);
    let plan = Plan {
        sights: vec![None; parts.len()],
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
        // Whatever becomes of `run`, the threads end.
        let _dismissal = Dismissal(&shared);
        Ok(run(&mut Engine {
            shared: &shared,
            cave,
            scene,
            options: *options,
            spectrum,
            workspace: Workspace::new(),
            share,
            dealer: Dealer::new(options.settings.samples),
            quality: Quality::FULL,
        }))
    })
}

/// Ends the threads.
struct Dismissal<'e, 's, const W: usize>(&'e Shared<'s, W>);

impl<const W: usize> Drop for Dismissal<'_, '_, W> {
    fn drop(&mut self) {
        self.0.over.store(true, Ordering::SeqCst);
        self.0.begin.wait();
    }
}

impl<const W: usize> Engine<'_, '_, W>
where
    Simd: Runs<W>,
{
    /// Renders what these eyes see, in at most `steps`, never one more.
    ///
    /// # Errors
    /// Other eyes than it was made for; an eye that does not see a screen.
    pub fn render(
        &mut self,
        eyes: &[Observer],
        quality: &Quality,
        steps: Option<u64>,
    ) -> Result<Rendered, RenderError> {
        self.render_until(eyes, quality, steps, Until::Steps)
    }

    /// Renders what these eyes see: at most `steps` of it, or as many more as the
    /// [`FOVEA`](super::FOVEA) takes at this quality, of eyes of which anybody knows where they look.
    ///
    /// # Errors
    /// As [`render`](Self::render).
    pub fn render_whole_fovea(
        &mut self,
        eyes: &[Observer],
        quality: &Quality,
        steps: Option<u64>,
    ) -> Result<Rendered, RenderError> {
        self.render_until(eyes, quality, steps, Until::WholeFovea)
    }

    fn render_until(
        &mut self,
        eyes: &[Observer],
        quality: &Quality,
        steps: Option<u64>,
        until: Until,
    ) -> Result<Rendered, RenderError> {
        self.plan(eyes, quality, steps)?;
        if eyes.iter().any(|eye| eye.acuity.is_some()) {
            self.dealer.expect_squares();
        }
        self.dealer.begin(steps.filter(|_| until == Until::Steps));
        self.shared.first_ray.store(u64::MAX, Ordering::SeqCst);
        let (mut rounds, mut tracing) = (0, Duration::ZERO);
        let mut round = |engine: &mut Self| {
            rounds += 1;
            let begun = Instant::now();
            engine.have_done();
            tracing += begun.elapsed();
        };
        for &(whom, most) in self.turns(steps) {
            for _ in 0..most {
                let spent = self.shared.spent.load(Ordering::SeqCst);
                let left = steps.map(|steps| steps.saturating_sub(spent));
                if !self.deal(left, whom) {
                    break;
                }
                round(self);
                self.dealer.look_at(&self.shared.excess);
            }
        }
        if until == Until::WholeFovea && self.deal_fovea() {
            round(self);
        }
        let rendered = self.finish(rounds);
        self.fill();
        Ok(Rendered {
            tracing,
            done: Instant::now(),
            ..rendered
        })
    }

    /// Whose turn it is to be dealt steps, one after another, and how many rounds each has
    /// at most.
    fn turns(&self, steps: Option<u64>) -> &'static [(Whom, u32)] {
        if steps.is_none() {
            return &[(Whom::All, MOST_ROUNDS)];
        }
        let plan = self.shared.frame.read();
        // Where there is an end, nothing is left to others before what is looked at is
        // finished. As long as a viewer looks at the same that does not need a round of
        // its own.
        if plan.unwrap_or_else(PoisonError::into_inner).settled {
            &[
                (Whom::AllButReserve, 1),
                (Whom::Fovea, MOST_ROUNDS),
                (Whom::All, MOST_ROUNDS),
            ]
        } else {
            &[(Whom::Fovea, MOST_ROUNDS), (Whom::All, MOST_ROUNDS)]
        }
    }

    /// Has all threads do what is planned.
    fn have_done(&mut self) {
        self.shared.next.store(0, Ordering::SeqCst);
        self.shared.begin.wait();
        self.shared.work(&mut self.workspace);
        self.shared.end.wait();
    }

    /// Fills what the gaze skipped, where there is a capture.
    fn fill(&mut self) {
        let shared = self.shared;
        let set = |fills: bool| {
            let mut plan = shared.frame.write().unwrap_or_else(PoisonError::into_inner);
            let whole = plan.capture.as_ref().is_some_and(LiveCapture::is_whole);
            plan.fills = fills && whole;
            plan.fills
        };
        if set(true) {
            self.have_done();
            set(false);
        }
    }

    /// Lays out the next frame.
    fn plan(
        &mut self,
        eyes: &[Observer],
        quality: &Quality,
        steps: Option<u64>,
    ) -> Result<(), RenderError> {
        let Self {
            shared,
            cave,
            scene,
            options,
            spectrum,
            share,
            quality: before,
            ..
        } = self;
        let mut options = *options;
        options.settings.depth = options.settings.depth.min(quality.depth);
        let mut plan = shared.frame.write().unwrap_or_else(PoisonError::into_inner);
        let Plan {
            parts,
            sights,
            order,
            capture,
            first,
            settled,
            ..
        } = &mut *plan;
        let screens = capture
            .as_ref()
            .map_or(parts.len(), LiveCapture::first_part);
        if pairs(cave, eyes, *share).count() != screens {
            return Err(RenderError::Previous);
        }
        *settled = quality == before;
        *before = *quality;
        let own = parts.iter_mut().zip(sights.iter_mut());
        for ((screen, observer), (part, sight)) in pairs(cave, eyes, *share).zip(own) {
            let was = std::mem::replace(sight, observer.forward());
            *settled &= match (was, *sight) {
                (Some(was), Some(sight)) => was.angle_between(sight) <= SETTLED,
                (was, sight) => was == sight,
            };
            let renderer = render::in_full(scene, &options, *spectrum)?;
            let renderer = renderer.with_faces_of_level(quality.faces);
            let renderer = quality.lower(*observer).follow(&renderer);
            *part = (render::view(screen, observer)?, renderer);
        }
        order.clear();
        shared.spent.store(0, Ordering::SeqCst);
        let own = capture.as_ref().map(LiveCapture::first_tile);
        for (number, tile) in shared.tiles.iter().enumerate() {
            let mut one = lock(tile);
            one.job = TileJob::new(one.job.tile());
            one.spent = 0;
            if own.is_none_or(|own| number < own) {
                let sight = sights[one.part];
                let towards = towards(sight, &parts[one.part].0, one.job.tile());
                order.push((towards, number as u32));
            }
        }
        if let Some(capture) = capture {
            let views = capture.views(eyes, scene, &options, *spectrum)?;
            parts.truncate(screens);
            parts.extend(views);
            let part = if steps.is_none() {
                1.0
            } else {
                quality.capture
            };
            order.extend(capture.due(part).map(|tile| (AT_LAST, tile as u32)));
        }
        order.sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        *first = reaching_fovea(order.iter().map_while(|&(towards, number)| {
            let tile = lock(&shared.tiles[number as usize]);
            let sight = sights.get(tile.part).copied().flatten();
            let sight = sight.filter(|_| towards > AT_LAST)?;
            Some((sight, &parts[tile.part].0, tile.job.tile()))
        }));
        Ok(())
    }

    /// Deals out what is left, if there is an end of it; whether anybody has anything.
    fn deal(&mut self, left: Option<u64>, whom: Whom) -> bool {
        let shared = self.shared;
        let mut plan = shared.frame.write().unwrap_or_else(PoisonError::into_inner);
        let Plan {
            order,
            groups,
            first,
            ..
        } = &mut *plan;
        let tile = |&(_, tile): &(f32, u32)| &shared.tiles[tile as usize];
        let foveal = order.get(..*first).unwrap_or(order);
        let dealer = &self.dealer;
        match (left, whom) {
            (None, _) => deal::everything(order.iter().map(tile), groups),
            (Some(left), Whom::Fovea) => dealer.deal_finely(left, foveal.iter().map(tile), groups),
            (Some(left), Whom::All) => dealer.deal(left, order.iter().map(tile), groups),
            (Some(left), Whom::AllButReserve) => {
                let reserve = deal::expected(foveal.iter().map(tile)) / RESERVE;
                let reserve = reserve.min(left / RESERVE);
                dealer.deal(left - reserve, order.iter().map(tile), groups);
            }
        }
        !groups.is_empty()
    }

    /// Deals out to what of the [`FOVEA`](super::FOVEA) is not finished all that it may need; whether
    /// there is any.
    fn deal_fovea(&mut self) -> bool {
        let shared = self.shared;
        let mut plan = shared.frame.write().unwrap_or_else(PoisonError::into_inner);
        let Plan {
            order,
            groups,
            sights,
            parts,
            ..
        } = &mut *plan;
        groups.clear();
        for (at, &(towards, number)) in order.iter().enumerate() {
            let tile = lock(&shared.tiles[number as usize]);
            let view = &parts[tile.part].0;
            let sight = sights.get(tile.part).copied().flatten();
            if towards > AT_LAST
                && !tile.job.is_finished()
                && sight.is_some()
                && is_foveal(sight, view, tile.job.tile())
            {
                groups.push(Group {
                    tiles: at..at + 1,
                    allotment: u64::MAX,
                    overrun: u64::MAX,
                });
            }
        }
        !groups.is_empty()
    }

    /// Gives up what is not finished, and says what there is.
    fn finish(&mut self, rounds: u32) -> Rendered {
        let shared = self.shared;
        let mut plan = shared.frame.write().unwrap_or_else(PoisonError::into_inner);
        let Plan {
            parts,
            sights,
            order,
            capture,
            ..
        } = &mut *plan;
        let begun = Instant::now();
        let (mut steps, mut need, mut unfinished, mut tiles) = (0, 0, 0, 0);
        let mut unfinished_fovea = false;
        for &(_, number) in order.iter() {
            let mut tile = lock(&shared.tiles[number as usize]);
            let tile = &mut *tile;
            if let Some(capture) = capture.as_mut().filter(|one| one.has(number as usize)) {
                capture.take(number as usize, tile);
            } else {
                tiles += 1;
            }
            let (view, renderer) = &parts[tile.part];
            steps += tile.spent;
            if tile.job.is_finished() {
                tile.expected = tile.spent + LEAST_EXPECTED;
                need += tile.spent;
            } else {
                tile.expected = tile.spent + tile.still();
                need += tile.expected;
                // What a capture has of it is older, and stays.
                if capture.as_ref().is_some_and(|one| one.has(number as usize)) {
                    continue;
                }
                unfinished += 1;
                unfinished_fovea |= is_foveal(sights[tile.part], view, tile.job.tile());
                let given_up = tile.job.give_up(renderer, view, &mut tile.pixels);
                debug_assert!(given_up.is_ok(), "its own pixels");
            }
        }
        let mut statistics = shared
            .statistics
            .lock()
            .unwrap_or_else(PoisonError::into_inner);
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
            giving_up: if unfinished > 0 {
                done - begun
            } else {
                Duration::ZERO
            },
            first_ray,
            done,
        }
    }

    /// Which pictures it renders.
    pub const fn share(&self) -> Share {
        self.share
    }

    /// What the newest frame's pictures hash to: [`Picture::hash`].
    ///
    /// # Errors
    /// Memory that there is not.
    pub fn hashes(&self) -> Result<Vec<u64>, RenderError> {
        let mut pictures = self.pictures()?;
        self.copy(&mut pictures);
        Ok(pictures.iter().map(Picture::hash).collect())
    }

    /// Pictures for [`copy`](Self::copy), by screen, then eye.
    ///
    /// # Errors
    /// One that cannot be kept in memory.
    pub fn pictures(&self) -> Result<Vec<Picture>, RenderError> {
        let plan = self
            .shared
            .frame
            .read()
            .unwrap_or_else(PoisonError::into_inner);
        let sizes = plan
            .screens()
            .iter()
            .map(|(view, _)| (view.columns(), view.rows()));
        sizes
            .map(|(columns, rows)| Ok(Picture::new(columns, rows)?))
            .collect()
    }

    /// The newest frame.
    pub fn copy(&self, pictures: &mut [Picture]) {
        for tile in &self.shared.tiles {
            let tile = lock(tile);
            if let Some(picture) = pictures.get_mut(tile.part) {
                render::put(picture, tile.job.tile(), &tile.pixels);
            }
        }
    }

    /// The newest frame over the one that these pictures show: what the gaze skips
    /// stays what it is there, and at the border of the field both are blended.
    pub fn copy_over(&self, pictures: &mut [Picture]) {
        let plan = self
            .shared
            .frame
            .read()
            .unwrap_or_else(PoisonError::into_inner);
        let (mut pixels, mut before) = (Vec::new(), Vec::new());
        for tile in &self.shared.tiles {
            let tile = lock(tile);
            let Some(picture) = pictures.get_mut(tile.part) else {
                continue;
            };
            let place = tile.job.tile();
            pixels.clone_from(&tile.pixels);
            render::pixels_of(picture, place, &mut before);
            let (view, renderer) = &plan.parts[tile.part];
            let filled = renderer.fill(view, place, &Fill::Pixels(&before), &mut pixels);
            debug_assert!(filled.is_ok(), "its own pixels");
            render::put(picture, place, &pixels);
        }
    }

    /// The tiles of the newest frame in the order in which they were dealt steps, each
    /// by the number of its picture, into `tiles`.
    pub fn tiles(&self, tiles: &mut Vec<(usize, Tile)>) {
        let plan = self
            .shared
            .frame
            .read()
            .unwrap_or_else(PoisonError::into_inner);
        let screens = plan.screens().len();
        tiles.clear();
        tiles.extend(plan.order.iter().filter_map(|&(_, number)| {
            let tile = lock(&self.shared.tiles[number as usize]);
            (tile.part < screens).then(|| (tile.part, tile.job.tile()))
        }));
    }
}

impl<'s, const W: usize> Plan<'s, W> {
    /// Of the parts, those of screens.
    fn screens(&self) -> &[(View, Renderer<'s, W>)] {
        let count = self.capture.as_ref().map(LiveCapture::first_part);
        self.parts
            .get(..count.unwrap_or(usize::MAX))
            .unwrap_or(&self.parts)
    }
}

/// The screens and eyes that pictures of a share are for, by screen, then eye.
pub fn eyes_of<'e>(
    cave: &Cave,
    eyes: &'e [Observer],
    share: Share,
) -> impl Iterator<Item = (usize, Eye)> + 'e {
    let screens = cave.screens().count();
    let all = screens * eyes.len();
    let pairs = (0..screens).flat_map(move |screen| eyes.iter().map(move |eye| (screen, eye.eye)));
    let own = pairs
        .enumerate()
        .filter(move |(pair, _)| share.has(*pair, all));
    own.map(|(_, pair)| pair)
}
