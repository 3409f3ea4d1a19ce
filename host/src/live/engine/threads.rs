//! The plan of a frame, and threads that stay, which work on it.

use super::capture::LiveCapture;
use super::deal::{Group, LiveTile};
use crate::bake::Stage;
use crate::cave::{Cave, Pictured};
use crate::live::lock;
use crate::live::swap::Share;
use crate::render::Observer;
use glam::Vec3;
use shisen_core::frame::{Budget, Fill, Renderer, Statistics, View, Workspace};
use shisen_core::{Runs, Simd};
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::sync::{Barrier, Mutex, PoisonError, RwLock, RwLockReadGuard, RwLockWriteGuard};
use std::time::Instant;

pub(super) struct Plan<'s, const W: usize> {
    /// The scene where something moves; the renderers have it as it was baked.
    pub(super) stage: Option<Stage<'s, W>>,
    /// Pictures by screen, then eye; then the hemispheres of a capture.
    pub(super) parts: Vec<(View, Renderer<'s, W>)>,
    /// The line of sight of each picture's eye; `None` where it is not known.
    pub(super) sights: Vec<Option<Vec3>>,
    /// The pictures of screens that their eye does not see: they are dark.
    pub(super) dark: Vec<bool>,
    /// Tiles and the cosines of their angles to the line of sight, outwards; then a capture's.
    pub(super) order: Vec<(f32, u32)>,
    /// Number of tiles, first in the order, that the [`FOVEA`](crate::live::FOVEA) reaches.
    pub(super) first: usize,
    /// Whether quality and line of sight are the same as in the frame before.
    pub(super) settled: bool,
    /// The work of a round; each thread takes the next group.
    pub(super) groups: Vec<Group>,
    pub(super) capture: Option<LiveCapture>,
    /// Whether the round fills tiles rather than tracing them.
    pub(super) fills: bool,
}

impl<'s, const W: usize> Plan<'s, W> {
    pub(super) fn screens(&self) -> &[(View, Renderer<'s, W>)] {
        let count = self.capture.as_ref().map(|capture| capture.part);
        let screens = self.parts.get(..count.unwrap_or(usize::MAX));
        screens.unwrap_or(&self.parts)
    }
}

/// Returns what a share's pictures are of, and the eyes, with the number of the first.
pub(super) fn pairs<'c>(
    cave: &'c Cave,
    eyes: &'c [Observer],
    share: Share,
) -> impl Iterator<Item = (usize, Pictured<'c>, &'c Observer)> {
    let count = cave.pictured().count() * eyes.len();
    let all = cave.pictured().enumerate();
    let pairs = all.flat_map(move |(n, of)| eyes.iter().map(move |eye| (n, of, eye)));
    let own = pairs.enumerate();
    own.filter(move |(pair, _)| share.has(*pair, count))
        .map(|(_, pair)| pair)
}

pub(super) struct Shared<'s, const W: usize> {
    pub(super) epoch: Instant,
    plan: RwLock<Plan<'s, W>>,
    pub(super) tiles: Vec<Mutex<LiveTile>>,
    /// The next of the plan's groups, or of the tiles to be filled.
    pub(super) next: AtomicUsize,
    /// Nanoseconds after the epoch; `u64::MAX` before a frame's first ray.
    pub(super) first_ray: AtomicU64,
    pub(super) spent: AtomicU64,
    pub(super) excess: AtomicU64,
    pub(super) statistics: Mutex<Statistics>,
    pub(super) begin: Barrier,
    pub(super) end: Barrier,
    pub(super) over: AtomicBool,
    /// Whether tiles are hashed when they are finished: from the first time that hashes are asked for.
    pub(super) hashes: AtomicBool,
}

impl<'s, const W: usize> Shared<'s, W>
where
    Simd: Runs<W>,
{
    pub(super) fn new(plan: Plan<'s, W>, tiles: Vec<Mutex<LiveTile>>, threads: usize) -> Self {
        Self {
            epoch: Instant::now(),
            plan: RwLock::new(plan),
            tiles,
            next: AtomicUsize::new(0),
            first_ray: AtomicU64::new(u64::MAX),
            spent: AtomicU64::new(0),
            excess: AtomicU64::new(0),
            statistics: Mutex::new(Statistics::default()),
            begin: Barrier::new(threads),
            end: Barrier::new(threads),
            over: AtomicBool::new(false),
            hashes: AtomicBool::new(false),
        }
    }

    pub(super) fn read(&self) -> RwLockReadGuard<'_, Plan<'s, W>> {
        self.plan.read().unwrap_or_else(PoisonError::into_inner)
    }

    pub(super) fn write(&self) -> RwLockWriteGuard<'_, Plan<'s, W>> {
        self.plan.write().unwrap_or_else(PoisonError::into_inner)
    }

    pub(super) fn serve(&self) {
        let mut workspace = Workspace::new();
        loop {
            self.begin.wait();
            if self.over.load(Ordering::SeqCst) {
                return;
            }
            self.work(&mut workspace);
            lock(&self.statistics).add(&workspace.statistics);
            workspace.statistics = Statistics::default();
            self.end.wait();
        }
    }

    pub(super) fn work(&self, workspace: &mut Workspace) {
        let plan = self.read();
        if plan.fills {
            self.fill(&plan);
        } else {
            self.trace(&plan, workspace);
        }
    }

    fn trace(&self, plan: &Plan<'_, W>, workspace: &mut Workspace) {
        let now = plan.stage.as_ref().map(Stage::scene);
        loop {
            let number = self.next.fetch_add(1, Ordering::SeqCst);
            let Some(group) = plan.groups.get(number) else {
                return;
            };
            if number == 0 {
                let now = self.epoch.elapsed().as_nanos() as u64;
                self.first_ray.fetch_min(now, Ordering::SeqCst);
            }
            let mut budget = Budget::steps(group.allotment).with_overrun(group.overrun);
            let begun = workspace.statistics.steps;
            let tiles = plan.order.get(group.tiles.clone()).unwrap_or_default();
            for &(_, tile) in tiles {
                if budget.is_spent() {
                    break;
                }
                let mut tile = lock(&self.tiles[tile as usize]);
                let tile = &mut *tile;
                if tile.job.is_finished() {
                    continue;
                }
                let (view, renderer) = &plan.parts[tile.part];
                let posed = now.map(|now| renderer.posed(now));
                let renderer = posed.as_ref().unwrap_or(renderer);
                let before = workspace.statistics.steps;
                let (job, pixels) = (&mut tile.job, &mut tile.pixels);
                let outcome = job.render(renderer, view, pixels, &mut budget, workspace);
                debug_assert!(outcome.is_ok(), "its own tile");
                tile.spent += workspace.statistics.steps - before;
                if self.hashes.load(Ordering::Relaxed) && tile.job.is_finished() {
                    // Its pixels are still in the cache.
                    tile.keep_hash();
                }
            }
            let spent = workspace.statistics.steps - begun;
            self.spent.fetch_add(spent, Ordering::SeqCst);
            let excess = spent.saturating_sub(group.allotment);
            self.excess.fetch_max(excess, Ordering::SeqCst);
        }
    }

    fn fill(&self, plan: &Plan<'_, W>) {
        let surroundings = plan.capture.as_ref().and_then(LiveCapture::surroundings);
        let Some(surroundings) = surroundings else {
            return;
        };
        let screens = plan.screens();
        while let Some(tile) = self.tiles.get(self.next.fetch_add(1, Ordering::SeqCst)) {
            let mut tile = lock(tile);
            let tile = &mut *tile;
            let Some((view, renderer)) = screens.get(tile.part) else {
                return;
            };
            let fill = Fill::Surroundings(surroundings);
            let filled = renderer.fill(view, tile.job.tile(), &fill, &mut tile.pixels);
            debug_assert!(filled.is_ok(), "its own pixels");
            tile.hash = None;
        }
    }
}
