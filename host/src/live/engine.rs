//! A frame on all cores within a budget of steps.
//!
//! Threads and memory stay from frame to frame: while frames are rendered
//! nothing is allocated. The budget is dealt out to tiles before they are
//! rendered, from the line of sight outwards, by what each took in the frame
//! before; what tiles leave of theirs goes to those that had too little, in
//! further rounds. All of that is a function of steps alone, so a frame is the
//! same on any number of threads, whatever the clock says.

use super::quality::Quality;
use super::swap::Share;
use crate::cave::{Cave, Eye, Screen};
use crate::picture::Picture;
use crate::render::{self, Observer, Options, RenderError};
use glam::Vec3;
use shisen_core::frame::{
    Budget, Fill, Outcome, Pixel, Renderer, Spectrum, Statistics, Tile, TileJob, View, Workspace,
};
use shisen_core::scene::Scene;
use shisen_core::{Runs, Simd};
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::sync::{Barrier, Mutex, MutexGuard, PoisonError, RwLock};
use std::time::{Duration, Instant};

/// The part of a frame that is never to be missing: this close to the line of
/// sight, radians (5°).
pub const FOVEA: f32 = 0.087_266_46;

/// In how many rounds a budget is dealt out at most.
const MOST_ROUNDS: u32 = 8;

/// Steps that a tile may take above its allotment, until more has been seen: the
/// dearest block's primary rays, or a pixel's whole tree.
const LEAST_EXCESS: u64 = 2_048;

/// The same where squares of pixels share their samples: the dearest square's.
const LEAST_EXCESS_OF_SQUARES: u64 = 2 * LEAST_EXCESS;

/// Steps that a pixel is expected to take of which nothing is known.
const UNKNOWN_PIXEL: u64 = 16;

/// Renders frames of one scene for one set of screens.
pub struct Engine<'e, 's, const W: usize> {
    shared: &'e Shared<'s, W>,
    cave: &'e Cave,
    scene: Scene<'s, W>,
    options: Options,
    spectrum: Spectrum<'s>,
    workspace: Workspace,
    share: Share,
    /// The most that a call took above its allotment.
    excess: u64,
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
    /// Whether one of these is within [`FOVEA`] of a line of sight.
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

/// What all threads see.
struct Shared<'s, const W: usize> {
    epoch: Instant,
    frame: RwLock<Plan<'s, W>>,
    tiles: Vec<Mutex<LiveTile>>,
    /// The next in the order of the plan.
    next: AtomicUsize,
    /// Nanoseconds after the epoch; all ones before a frame's first ray.
    first_ray: AtomicU64,
    statistics: Mutex<Statistics>,
    begin: Barrier,
    end: Barrier,
    over: AtomicBool,
}

/// A frame.
struct Plan<'s, const W: usize> {
    parts: Vec<(View, Renderer<'s, W>)>,
    /// Indices of tiles, from the line of sight outwards.
    order: Vec<(f32, u32)>,
}

/// A tile and its pixels.
struct LiveTile {
    part: usize,
    job: TileJob,
    pixels: Vec<Pixel>,
    /// What it may take in this round.
    allotment: u64,
    /// What it took in this frame.
    spent: u64,
    /// What it is expected to take in this frame.
    expected: u64,
    /// What the last call took above its allotment.
    excess: u64,
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
///
/// # Errors
/// An eye that does not see a screen.
pub fn with_engine<'s, const W: usize, R>(
    scene: Scene<'s, W>,
    spectrum: Spectrum<'s>,
    cave: &Cave,
    eyes: &[Observer],
    options: &Options,
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
        tiles.extend(render::tiles(&view, options.tile).map(|tile| {
            let area = tile.width as usize * tile.height as usize;
            Mutex::new(LiveTile {
                part,
                job: TileJob::new(tile),
                pixels: vec![Pixel::default(); area],
                allotment: 0,
                spent: 0,
                expected: area as u64 * UNKNOWN_PIXEL,
                excess: 0,
            })
        }));
        parts.push((view, render::renderer(&scene, observer, options, spectrum)?));
    }
    let threads = options.threads.max(1);
    let shared = Shared {
        epoch: Instant::now(),
        frame: RwLock::new(Plan {
            parts,
            order: (0..tiles.len() as u32).map(|tile| (0.0, tile)).collect(),
        }),
        tiles,
        next: AtomicUsize::new(0),
        first_ray: AtomicU64::new(u64::MAX),
        statistics: Mutex::new(Statistics::default()),
        begin: Barrier::new(threads),
        end: Barrier::new(threads),
        over: AtomicBool::new(false),
    };
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
            excess: LEAST_EXCESS,
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
    /// Renders what these eyes see, at most `steps` of it.
    ///
    /// # Errors
    /// Other eyes than it was made for; an eye that does not see a screen.
    pub fn render(
        &mut self,
        eyes: &[Observer],
        quality: &Quality,
        steps: Option<u64>,
    ) -> Result<Rendered, RenderError> {
        self.plan(eyes, quality)?;
        if eyes.iter().any(|eye| eye.acuity.is_some()) {
            self.excess = self.excess.max(LEAST_EXCESS_OF_SQUARES);
        }
        self.shared.first_ray.store(u64::MAX, Ordering::SeqCst);
        let (mut rounds, mut tracing) = (0, Duration::ZERO);
        loop {
            let spent = self.spent();
            let unfinished = match steps {
                None => self.deal_everything(),
                Some(steps) => self.deal(steps.saturating_sub(spent)),
            };
            if unfinished == 0 || rounds == MOST_ROUNDS {
                break;
            }
            rounds += 1;
            let begun = Instant::now();
            self.shared.next.store(0, Ordering::SeqCst);
            self.shared.begin.wait();
            self.shared.work(&mut self.workspace);
            self.shared.end.wait();
            tracing += begun.elapsed();
            self.look_at_excess();
        }
        Ok(Rendered {
            tracing,
            ..self.finish(rounds)
        })
    }

    /// Lays out the next frame.
    fn plan(&mut self, eyes: &[Observer], quality: &Quality) -> Result<(), RenderError> {
        let Self {
            shared,
            cave,
            scene,
            options,
            spectrum,
            share,
            ..
        } = self;
        let mut options = *options;
        options.settings.depth = options.settings.depth.min(quality.depth);
        let mut plan = shared.frame.write().unwrap_or_else(PoisonError::into_inner);
        let Plan { parts, order } = &mut *plan;
        if pairs(cave, eyes, *share).count() != parts.len() {
            return Err(RenderError::Previous);
        }
        for ((screen, observer), part) in pairs(cave, eyes, *share).zip(parts.iter_mut()) {
            let renderer = render::in_full(scene, &options, *spectrum)?;
            let renderer = renderer.with_faces_of_level(quality.faces);
            let renderer = quality.lower(*observer).follow(&renderer);
            *part = (render::view(screen, observer)?, renderer);
        }
        for (cosine, tile) in order.iter_mut() {
            let mut one = lock(&shared.tiles[*tile as usize]);
            let tile = one.job.tile();
            let (view, renderer) = &parts[one.part];
            *cosine = towards(renderer, view, tile);
            one.job = TileJob::new(tile);
            one.spent = 0;
        }
        order.sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        Ok(())
    }

    /// Steps of this frame so far.
    fn spent(&self) -> u64 {
        self.shared.tiles.iter().map(|tile| lock(tile).spent).sum()
    }

    fn deal_everything(&mut self) -> usize {
        let mut unfinished = 0;
        for tile in &self.shared.tiles {
            let mut tile = lock(tile);
            tile.allotment = u64::MAX;
            unfinished += usize::from(!tile.job.is_finished());
        }
        unfinished
    }

    /// Gives unfinished tiles what they are expected to need, from the line of
    /// sight outwards, as long as there is something left. Each may take a little
    /// more than it is given, so that much is set aside for it. How many have
    /// something.
    fn deal(&mut self, mut left: u64) -> usize {
        let shared = self.shared;
        let plan = shared.frame.read().unwrap_or_else(PoisonError::into_inner);
        let mut given = 0;
        for &(_, tile) in &plan.order {
            let mut tile = lock(&shared.tiles[tile as usize]);
            tile.allotment = 0;
            if tile.job.is_finished() || left <= self.excess {
                continue;
            }
            // One that had too little shows that the frame before says little.
            if tile.spent >= tile.expected {
                tile.expected = 2 * tile.spent;
            }
            tile.allotment = (tile.expected - tile.spent).min(left - self.excess);
            left -= tile.allotment + self.excess;
            given += 1;
        }
        given
    }

    fn look_at_excess(&mut self) {
        let most = self.shared.tiles.iter().map(|tile| lock(tile).excess).max();
        // What comes next may be half as dear again.
        self.excess = self.excess.max(most.unwrap_or(0) * 3 / 2);
    }

    /// Gives up what is not finished, and says what there is.
    fn finish(&mut self, rounds: u32) -> Rendered {
        let shared = self.shared;
        let plan = shared.frame.read().unwrap_or_else(PoisonError::into_inner);
        let begun = Instant::now();
        let (mut steps, mut need, mut unfinished) = (0, 0, 0);
        let mut unfinished_fovea = false;
        for tile in &shared.tiles {
            let mut tile = lock(tile);
            let tile = &mut *tile;
            let (view, renderer) = &plan.parts[tile.part];
            steps += tile.spent;
            if tile.job.is_finished() {
                // A gaze that moves on makes it a little dearer.
                tile.expected = tile.spent + tile.spent / 4 + 64;
                need += tile.spent;
            } else {
                tile.expected = tile.expected.max(tile.spent);
                need += tile.expected;
                unfinished += 1;
                unfinished_fovea |= is_foveal(renderer, view, tile.job.tile());
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
            tiles: shared.tiles.len(),
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
            .parts
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
        tiles.clear();
        tiles.extend(plan.order.iter().map(|&(_, number)| {
            let tile = lock(&self.shared.tiles[number as usize]);
            (tile.part, tile.job.tile())
        }));
    }
}

impl<const W: usize> Shared<'_, W>
where
    Simd: Runs<W>,
{
    /// A thread's life.
    fn serve(&self) {
        let mut workspace = Workspace::new();
        loop {
            self.begin.wait();
            if self.over.load(Ordering::SeqCst) {
                return;
            }
            self.work(&mut workspace);
            let mut statistics = self
                .statistics
                .lock()
                .unwrap_or_else(PoisonError::into_inner);
            statistics.add(&workspace.statistics);
            workspace.statistics = Statistics::default();
            drop(statistics);
            self.end.wait();
        }
    }

    /// Takes tiles until there are none left.
    fn work(&self, workspace: &mut Workspace) {
        let plan = self.frame.read().unwrap_or_else(PoisonError::into_inner);
        loop {
            let number = self.next.fetch_add(1, Ordering::SeqCst);
            let Some(&(_, tile)) = plan.order.get(number) else {
                return;
            };
            if number == 0 {
                let now = self.epoch.elapsed().as_nanos() as u64;
                self.first_ray.fetch_min(now, Ordering::SeqCst);
            }
            let mut tile = lock(&self.tiles[tile as usize]);
            let tile = &mut *tile;
            tile.excess = 0;
            if tile.allotment == 0 || tile.job.is_finished() {
                continue;
            }
            let (view, renderer) = &plan.parts[tile.part];
            let mut budget = Budget::steps(tile.allotment);
            let before = workspace.statistics.steps;
            let job = &mut tile.job;
            let outcome = job.render(renderer, view, &mut tile.pixels, &mut budget, workspace);
            debug_assert!(outcome.is_ok(), "its own tile");
            let spent = workspace.statistics.steps - before;
            tile.spent += spent;
            if let Ok(Outcome::BudgetSpent) = outcome {
                tile.excess = spent.saturating_sub(tile.allotment);
            }
        }
    }
}

fn lock<T>(one: &Mutex<T>) -> MutexGuard<'_, T> {
    one.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Of the angle between the line of sight and a tile's centre.
fn towards<const W: usize>(renderer: &Renderer<'_, W>, view: &View, tile: Tile) -> f32
where
    Simd: Runs<W>,
{
    let Some(gaze) = renderer.gaze() else {
        return 1.0;
    };
    let (x, y) = (
        tile.x as f32 + 0.5 * (tile.width - 1) as f32,
        tile.y as f32 + 0.5 * (tile.height - 1) as f32,
    );
    let towards = view.direction(x, y).map(Vec3::normalize_or_zero);
    towards.map_or(-2.0, |towards| towards.dot(gaze.line_of_sight().forward()))
}

/// Whether a pixel of a tile is within [`FOVEA`] of the line of sight. Where
/// nothing follows a gaze, all are.
fn is_foveal<const W: usize>(renderer: &Renderer<'_, W>, view: &View, tile: Tile) -> bool
where
    Simd: Runs<W>,
{
    let Some(gaze) = renderer.gaze() else {
        return true;
    };
    let forward = gaze.line_of_sight().forward();
    let pixels = (0..tile.height).flat_map(|y| (0..tile.width).map(move |x| (x, y)));
    pixels.into_iter().any(|(x, y)| {
        let direction = view.direction((tile.x + x) as f32, (tile.y + y) as f32);
        direction.is_some_and(|direction| direction.angle_between(forward) <= FOVEA)
    })
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
