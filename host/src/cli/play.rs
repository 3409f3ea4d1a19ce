//! Frames that follow a tracker.

#[cfg(all(test, unix))]
mod allocations;
mod interference;

use crate::bake::{Layout, Staged};
use crate::cli::arguments::cache::CacheArguments;
use crate::cli::arguments::dispersion::{in_one_frame, range_in_one_frame};
use crate::cli::arguments::lod::LodArguments;
use crate::cli::arguments::room::RoomArguments;
use crate::cli::arguments::source::{Ready, Shown};
use crate::cli::arguments::tracing::TracingArguments;
use crate::cli::arguments::{ModelArguments, SCENES, SceneName};
use crate::cli::output::Warner;
use crate::cli::prelude::*;
use crate::cli::tracker::{Opened, TrackerName};
use crate::live::{
    self, Display, Engine, FrameBudget, LiveTracker, Look, Observe, SessionError, SessionReport,
    SessionSettings, Share, SwapError, SwapLock, Table2, with_engine,
};
use crate::render::spectrum::Dispersion;
use crate::render::{CaptureOptions, Observer, Options, frame_hash};
use crate::scene::builtin::PaperScene;
use crate::tracker::{By, Navigation, RawBytes, check_controls};
use clap::Arg;
use clap::builder::ArgPredicate;
pub use interference::Interference;
use shisen_core::Simd;
use xxhash_rust::xxh3::xxh3_64;

const UP: &str = "Direction of the top of the head, for --lod [default: as the tracker says]";

const FIXATE: &str = "Point in the room, in metres, that both eyes look at. With --lod each eye \
                      then has its own line of sight [default: one for both, as the tracker says]";

#[derive(Debug, Clone, Args)]
#[command(
    mut_arg("look", |look| look.hide(true)),
    mut_arg("up", |up| up.help(UP)),
    mut_arg("fixate", |fixate| fixate.help(FIXATE)),
    mut_arg("dispersion", in_one_frame),
    mut_arg("range", range_in_one_frame)
)]
pub struct LiveArguments {
    /// A, B, C or D of the paper, gallery, grid, prism, spheres, a model, a TOML description or a
    /// baked scene
    #[arg(long, value_name = SCENES, default_value = "A")]
    pub scene: SceneName,
    #[command(flatten)]
    model: ModelArguments,
    #[command(flatten)]
    pub room: RoomArguments,
    /// File of `shisen tracker calibrate`
    #[arg(long, value_name = "TOML")]
    calibration: Option<PathBuf>,
    #[command(flatten)]
    pub lod: LodArguments,
    #[command(flatten)]
    pub tracing: TracingArguments,
    #[command(flatten)]
    cache: CacheArguments,
    /// Layout of the tree's nodes in a scene that is not baked yet
    #[arg(long, value_enum, default_value = "fast")]
    layout: Layout,
    /// How to capture the surroundings, if at all.
    #[arg(skip)]
    capture: Option<CaptureOptions>,
    /// The projectors whose own pixels are traced.
    #[arg(skip)]
    pub direct: Vec<String>,
}

/// `--lod` for commands whose frames follow the gaze by default.
pub fn live_lod(lod: Arg) -> Arg {
    let paper =
        ["A", "B", "C", "D", "a", "b", "c", "d"].map(|name| ("scene", name.into(), "paper"));
    let others = ("scene", ArgPredicate::IsPresent, "foveated");
    lod.default_value("paper")
        .default_value_ifs(paper.into_iter().chain([others]))
        .help(
            "What follows the gaze: detail falls with the distance from the line of sight \
             [default: paper for scenes A to D, else foveated]",
        )
}

#[derive(Debug, Clone, Copy, Args)]
pub struct TimeArguments {
    /// Refreshes per second, and without --budget the time of a frame [default: the
    /// display's, or 60]
    #[arg(long, value_name = "HZ", value_parser = whole::<u64>(1..=1_000))]
    hz: Option<u64>,
    /// What a frame may take: a time such as 33ms, steps such as 2000000steps (which give the same
    /// frames for the same gazes), paper (the seconds of its Table 2), paper-scaled (the part of a
    /// full frame's time that level of detail takes in Table 2) or off [default: a refresh of
    /// --hz; without it paper-scaled for scenes A to D, and off for --view png of others]
    #[arg(long, value_name = "BUDGET")]
    budget: Option<FrameBudget>,
    /// Refreshes per second of the display, if it has one.
    #[arg(skip)]
    pub refresh: Option<u32>,
}

pub struct Prepared {
    pub arguments: LiveArguments,
    pub shown: Shown,
    baked: BakedScene,
    /// The scene where something moves.
    moving: Option<Box<crate::scene::Scene>>,
    pub cave: Cave,
    pub options: Options,
    pub hz: u32,
    pub budget: FrameBudget,
    table: Option<Table2>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Change {
    Scene(PaperScene),
    /// To the next `--lod`.
    Detail,
    /// To a capture of the surroundings, or to none.
    Capture(Option<CaptureOptions>),
}

impl LiveArguments {
    pub fn prepare(&self, time: &TimeArguments) -> Result<Prepared, Failure> {
        if self.room.look.is_some() {
            return Err(misuse!(
                "--look is for a single frame: here the viewer looks where the tracker says"
            ));
        }
        let table = match self.scene {
            SceneName::Paper(scene) => Table2::for_scene(scene),
            _ => None,
        };
        let budget = time.frame_budget(&self.scene, table)?;
        let mut cave = self.room.cave()?;
        self.room.check_eyes(&cave, self.room.head())?;
        let model = self.model.within(&cave);
        cave.trace_directly(&self.direct)?;
        let Ready {
            baked,
            shown,
            moving,
            ..
        } = (self.lod).ready(&self.scene, &model, &self.cache, self.layout, false)?;
        let (options, _) = self.tracing.options(&baked)?;
        if matches!(options.dispersion, Dispersion::Images(..)) {
            return Err(misuse!(
                "--dispersion paper renders a frame for each wavelength: take comb or split"
            ));
        }
        if self.lod.is_foveated() {
            self.tracing.foveated_samples(&options);
        }
        Ok(Prepared {
            arguments: self.clone(),
            shown,
            baked,
            moving,
            cave,
            options,
            hz: time.hz() as u32,
            budget,
            table,
        })
    }

    #[must_use]
    pub fn changed(&self, change: Change) -> Self {
        let mut changed = self.clone();
        match change {
            Change::Scene(scene) => changed.scene = SceneName::Paper(scene),
            Change::Detail => changed.lod = self.lod.next(),
            Change::Capture(capture) => changed.capture = capture,
        }
        changed
    }

    /// Opens a viewer's trackers and listens to them. Announces what happens to them.
    pub fn listen(&self, trackers: &[TrackerName], room: &Cave) -> Result<LiveTracker, Failure> {
        Ok(self.listen_raw(trackers, None, room, false)?.0)
    }

    /// Does the same with what steers; with `raw` also returns the bytes of the trackers.
    pub fn listen_raw(
        &self,
        trackers: &[TrackerName],
        navigation: Option<&Navigation>,
        room: &Cave,
        raw: bool,
    ) -> Result<(LiveTracker, Vec<RawBytes>), Failure> {
        let calibration = self.calibration.as_deref();
        let mut opened = Opened::new(trackers, calibration, self.room.head(), room, raw)?;
        if let Some(navigation) = navigation {
            let first = trackers.first().filter(|_| navigation.by == By::Tracker);
            if let Some(first) = first {
                check_controls(&first.to_string(), &first.spec)?;
            }
            opened = opened.steered_by(navigation)?;
        }
        let raw = std::mem::take(&mut opened.raw);
        Ok((opened.listen()?, raw))
    }
}

impl TimeArguments {
    pub const fn of(budget: FrameBudget) -> Self {
        Self {
            hz: None,
            budget: Some(budget),
            refresh: None,
        }
    }

    /// Returns the same without a limit, if neither a time nor a budget is given.
    #[must_use]
    pub fn or_unlimited(self) -> Self {
        let unlimited = self.hz.is_none().then_some(FrameBudget::Off);
        Self {
            budget: self.budget.or(unlimited),
            ..self
        }
    }

    fn hz(&self) -> u64 {
        let of_display = self.refresh.map(u64::from);
        self.hz.or(of_display).unwrap_or(60)
    }

    fn frame_budget(
        &self,
        scene: &SceneName,
        table: Option<Table2>,
    ) -> Result<FrameBudget, Failure> {
        match (self.budget, self.hz, table) {
            (Some(budget @ (FrameBudget::Paper | FrameBudget::PaperScaled)), _, None) => {
                Err(misuse!(
                    "--budget {budget} is for the scenes A to D of the paper's Table 2, and {scene} \
                     is none of them: give --hz or another --budget"
                ))
            }
            (Some(budget), ..) => Ok(budget),
            (None, None, Some(_)) => Ok(FrameBudget::PaperScaled),
            (None, ..) => {
                let refresh = Duration::from_secs_f64(1.0 / self.hz() as f64);
                Ok(FrameBudget::Time(refresh))
            }
        }
    }
}

impl Prepared {
    /// Returns the baked scene.
    pub fn scene_bytes(&self) -> &[u8] {
        self.baked.as_bytes()
    }

    /// Returns the hash of the baked scene.
    pub fn scene_hash(&self) -> u64 {
        xxh3_64(self.scene_bytes())
    }

    pub const fn simd(&self) -> Simd {
        self.baked.layout().simd(self.options.simd)
    }

    /// Returns the settings of a session: those of the arguments, and the rest of `of`.
    pub const fn settings(&self, of: SessionSettings) -> SessionSettings {
        SessionSettings {
            hz: self.hz,
            budget: self.budget,
            table: self.table,
            ..of
        }
    }

    /// Renders frames until the display has enough, with all machines of the lock.
    pub fn play(
        &self,
        tracker: &LiveTracker,
        settings: &SessionSettings,
        display: &mut dyn Display,
        lock: &mut dyn SwapLock,
    ) -> Result<Played, Failure> {
        let share = lock.share();
        let (report, interference) = self.engage(share, |engine, observe| {
            // Read while the engine's threads exist: the system counts by thread.
            let before = Interference::so_far();
            let report = live::run(engine, tracker, settings, observe, display, lock)?;
            Ok((report, Interference::so_far().since(&before)))
        })?;
        let last = report.last.filter(|_| share.ranks() > 1);
        let alone = last.map(|last| {
            self.engage(Share::ALL, |engine, observe| {
                let mut eyes = Vec::new();
                observe(&last.look, &mut eyes);
                engine.set_time(last.time)?;
                engine.set_place(&last.place);
                engine.render(&eyes, last.decision.quality(), None)?;
                Ok(frame_hash(engine.hashes()?))
            })
        });
        Ok(Played {
            report,
            interference,
            alone: alone.transpose()?,
        })
    }

    /// Renders this machine's share of what another machine orders.
    pub fn obey(&self, display: &mut dyn Display, lock: &mut dyn SwapLock) -> Result<(), Failure> {
        self.engage(lock.share(), |engine, observe| {
            live::follow(engine, observe, display, lock)
        })
    }

    /// Runs a part with an engine, and what puts the eyes of a look into a list.
    pub fn engage<T>(
        &self,
        share: Share,
        part: impl FnOnce(&mut dyn Engine, &mut Observe<'_>) -> Result<T, SessionError>,
    ) -> Result<T, Failure> {
        let (arguments, cave, options) = (&self.arguments, &self.cave, &self.options);
        let (room, lod) = (&arguments.room, &arguments.lod);
        let start = room.head();
        let eyes = lod.observers(room.eyes(start), room.directions(start), 0.0)?;
        let (ranks, pictures) = (share.ranks(), cave.pictured().count() * eyes.len());
        if ranks > pictures {
            return Err(Failure::from_error(SwapError(format!(
                "{ranks} processes are too many for {pictures} pictures (walls times eyes): start \
                 at most as many"
            ))));
        }
        let warner = Warner::start();
        let mut named = vec![false; cave.pictured().count()];
        let mut observe = |look: &Look, eyes: &mut Vec<Observer>| {
            let places = room.eyes(look.head);
            let (mut all, mut any) = (true, false);
            for (pictured, named) in cave.pictured().zip(&mut named) {
                let mut views = places.clone().map(|(_, place)| pictured.view_from(place));
                let Some(fault) = views.find_map(Result::err) else {
                    any = true;
                    continue;
                };
                all = false;
                if !std::mem::replace(named, true) {
                    warner.warn(format!(
                        "{fault}; its picture for that eye is dark meanwhile"
                    ));
                }
            }
            if any || eyes.is_empty() {
                // All screens are seen from the first pose.
                let places = if any { places } else { room.eyes(start) };
                let directions = (look.forward.as_dvec3(), look.up.as_dvec3());
                // A wrong line of sight leaves the eyes unchanged.
                let _ = lod.observe(places, directions, look.widen, eyes);
            }
            all
        };
        let run = |engine: &mut dyn Engine| part(engine, &mut observe);
        let how = arguments.capture;
        let staged = Staged {
            scene: self.baked.scene(),
            moving: self.moving.as_deref(),
        };
        let played = with_engine(staged, cave, &eyes, options, how, share, run)?;
        Ok(played?)
    }
}

pub struct Played {
    pub report: SessionReport,
    pub interference: Interference,
    /// Hash of the last frame as this machine renders it alone; `None` with one machine.
    pub alone: Option<u64>,
}
