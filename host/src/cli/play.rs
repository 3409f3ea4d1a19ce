//! Frames played after a tracker to an audience: what commands that do so have in common.

#[cfg(all(test, unix))]
mod allocations;
mod interference;

use crate::bake::BakedScene;
use crate::cave::Cave;
use crate::cli::arguments::dispersion::{in_one_frame, range_in_one_frame};
use crate::cli::arguments::lod::LodArguments;
use crate::cli::arguments::room::RoomArguments;
use crate::cli::arguments::source::Source;
use crate::cli::arguments::tracing::TracingArguments;
use crate::cli::arguments::{Model, SceneName, whole};
use crate::cli::output::failure::Failure;
use crate::cli::tracker::Happenings;
use crate::live::{
    Display, Engine, FrameBudget, FrameRecord, LiveTracker, Look, Order, Quality, SessionError,
    SessionReport, SessionSettings, Share, SwapError, SwapLock, Table2, with_engine,
};
use crate::picture::Picture;
use crate::render::spectrum::Dispersion;
use crate::render::{CaptureOptions, Observer, Options, frame_hash};
use crate::scene::builtin::PaperScene;
use crate::tracker::calibration::{Calibrated, estimation};
use crate::tracker::{Feed, Spec};
use crate::with_scene;
use clap::{Arg, Args};
use glam::Vec3;
pub use interference::Interference;
use shisen_core::frame::Tile;
use shisen_core::gaze::HeadPose;
use shisen_core::scene::Scene;
use shisen_core::{Runs, Simd};
use shisen_tracker::clock::ClockEstimator;
use shisen_tracker::estimate::GazeEstimator;
use std::path::PathBuf;
use std::time::Duration;

/// The argument `--look`: a tracker says where the viewer looks.
fn hidden(look: Arg) -> Arg {
    look.hide(true)
}

/// What is shown to whom, and how well.
#[derive(Debug, Clone, Args)]
#[command(
    mut_arg("look", hidden),
    mut_arg("dispersion", in_one_frame),
    mut_arg("range", range_in_one_frame)
)]
pub struct LiveArguments {
    /// A, B, C or D of the paper, grid, prism, spheres, a TOML description or a baked
    /// scene
    #[arg(long, value_name = "A|B|C|D|grid|prism|spheres|FILE", default_value = "A",
          value_parser = SceneName::parser())]
    scene: SceneName,
    #[command(flatten)]
    model: Model,
    #[command(flatten)]
    pub room: RoomArguments,
    /// What `shisen tracker calibrate` wrote for the tracker
    #[arg(long, value_name = "TOML")]
    calibration: Option<PathBuf>,
    #[command(flatten)]
    pub lod: LodArguments,
    #[command(flatten)]
    pub tracing: TracingArguments,
    /// What shows where the gaze skips rays, if something was captured for that.
    #[arg(skip)]
    capture: Option<CaptureOptions>,
}

/// The argument `--lod` of commands whose frames follow the gaze where nobody says
/// otherwise.
pub fn paper_lod(lod: Arg) -> Arg {
    lod.default_value("paper").hide_default_value(false).help(
        "What follows the gaze: detail falls with the distance from the line of sight, and \
         nothing outside the visual field is traced",
    )
}

/// In what time.
#[derive(Debug, Clone, Copy, Args)]
pub struct TimeArguments {
    /// Refreshes per second; without --budget, also what a frame may take [default:
    /// 60]
    #[arg(long, value_name = "HZ", value_parser = whole::<u64>(1..=1_000))]
    hz: Option<u64>,
    /// What a frame may take: 33ms, 2000000steps (for the same gazes the same frames),
    /// paper (the seconds of its Table 2), paper-scaled (its time with level of detail
    /// as a part of its time without, of what that takes here) or off [default: a
    /// refresh of --hz, or else paper-scaled]
    #[arg(long, value_name = "BUDGET")]
    budget: Option<FrameBudget>,
}

/// A scene and a room, ready.
pub struct Prepared {
    pub arguments: LiveArguments,
    pub scene: String,
    pub mesh: Option<String>,
    baked: BakedScene,
    pub cave: Cave,
    pub options: Options,
    pub hz: u32,
    pub budget: FrameBudget,
    table: Option<Table2>,
}

/// Something else to be shown.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(
    not(all(unix, feature = "window")),
    allow(dead_code, reason = "keys of a window ask for it")
)]
pub enum Change {
    /// One of the paper's scenes.
    Scene(PaperScene),
    /// The next in the list of what may follow the gaze.
    Detail,
    /// Whether the surroundings are captured, and how.
    Capture(Option<CaptureOptions>),
}

/// The newest frame.
pub trait Newest {
    /// Its pictures by screen, then eye, over those of a frame before, or over none.
    /// Where it is `filled`, what the gaze skips stays what it is there.
    ///
    /// # Errors
    /// Memory that there is not.
    fn pictures(&self, over: &mut Vec<Picture>, filled: bool) -> Result<(), Failure>;

    /// Its tiles by the number of their picture, in the order in which they were dealt
    /// steps.
    fn tiles(&self, tiles: &mut Vec<(usize, Tile)>);
}

impl<const W: usize> Newest for Engine<'_, '_, W>
where
    Simd: Runs<W>,
{
    fn pictures(&self, over: &mut Vec<Picture>, filled: bool) -> Result<(), Failure> {
        if over.is_empty() {
            *over = self.pictures()?;
            self.copy(over);
        } else if filled {
            self.copy_over(over);
        } else {
            self.copy(over);
        }
        Ok(())
    }

    fn tiles(&self, tiles: &mut Vec<(usize, Tile)>) {
        self.tiles(tiles);
    }
}

/// Whoever sees frames.
pub trait Audience {
    /// Where the viewer looks, if it knows better than the tracker: in the room.
    fn gaze(&mut self) -> Option<Vec3> {
        None
    }

    /// Whether it wants no frame at all.
    fn is_over(&mut self) -> bool {
        false
    }

    /// Sees a frame.
    fn see(&mut self, newest: &dyn Newest, head: HeadPose, eyes: &[Observer]) {
        let _ = (newest, head, eyes);
    }

    /// Hears of it afterwards; whether it wants more.
    fn hear(&mut self, record: &FrameRecord) -> bool;
}

impl LiveArguments {
    /// Loads everything.
    ///
    /// # Errors
    /// Of usage: a budget that there is not for the scene, wavelengths that take
    /// several frames; a scene or a room that cannot be used.
    pub fn prepare(&self, time: &TimeArguments) -> Result<Prepared, Failure> {
        if self.room.says_where_to_look() {
            return Err(Failure::usage(
                "--look is for a single frame: here the viewer looks where the tracker says",
            ));
        }
        let table = match self.scene {
            SceneName::Paper(scene) => Table2::for_scene(scene),
            _ => None,
        };
        let budget = time.frame_budget(&self.scene, table)?;
        let cave = self.room.cave()?;
        for (_, place) in self.room.eyes(self.room.head()) {
            cave.check_eye(place)?;
        }
        let source = Source::load(&self.scene, &self.model)?;
        let baked = self.lod.baked(source.scene, &source.name)?;
        let (options, _) = self.tracing.options(&baked)?;
        if matches!(options.dispersion, Dispersion::Images(..)) {
            return Err(Failure::usage(
                "--dispersion paper renders a frame for each wavelength: take comb or split",
            ));
        }
        Ok(Prepared {
            arguments: self.clone(),
            scene: source.name,
            mesh: source.mesh,
            baked,
            cave,
            options,
            hz: time.hz.unwrap_or(60) as u32,
            budget,
            table,
        })
    }

    /// The same with something else to be shown.
    #[must_use]
    pub fn changed(&self, change: Change) -> Self {
        match change {
            Change::Scene(scene) => Self {
                scene: SceneName::Paper(scene),
                ..self.clone()
            },
            Change::Detail => Self {
                lod: self.lod.next(),
                ..self.clone()
            },
            Change::Capture(capture) => Self {
                capture,
                ..self.clone()
            },
        }
    }

    /// Opens a tracker and listens to it. What happens to it goes to standard error.
    ///
    /// # Errors
    /// A tracker that cannot be opened.
    pub fn listen(&self, spec: &Spec) -> Result<LiveTracker, Failure> {
        let calibration = self.calibration.as_deref();
        let calibrated = calibration.map(|path| Calibrated::load(path, spec));
        let calibrated = calibrated.transpose()?;
        let feed = Feed::open(spec)?;
        let head = self.room.head();
        let config = estimation(spec, feed.senses(spec), head, calibrated.as_ref());
        let estimator = GazeEstimator::new(config).map_err(Failure::from_error)?;
        let clock = ClockEstimator::new(spec.clock()).map_err(Failure::from_error)?;
        let mut happenings = Happenings::default();
        let tell = move |happening| happenings.tell(happening);
        LiveTracker::start(feed, clock, estimator, tell).map_err(Failure::from_error)
    }
}

impl TimeArguments {
    /// So much, whatever the scene.
    pub const fn of(budget: FrameBudget) -> Self {
        Self {
            hz: None,
            budget: Some(budget),
        }
    }

    /// What a frame may take.
    fn frame_budget(
        &self,
        scene: &SceneName,
        table: Option<Table2>,
    ) -> Result<FrameBudget, Failure> {
        match (self.budget, self.hz, table) {
            (Some(budget @ (FrameBudget::Paper | FrameBudget::PaperScaled)), _, None) => {
                Err(Failure::usage(&format!(
                    "--budget {budget} is for the scenes A to D of the paper's Table 2, and {scene} \
                     is none of them: give --hz or another --budget"
                )))
            }
            (Some(budget), ..) => Ok(budget),
            (None, Some(hz), _) => {
                let refresh = Duration::from_secs_f64(1.0 / hz as f64);
                Ok(FrameBudget::Time(refresh))
            }
            (None, None, Some(_)) => Ok(FrameBudget::PaperScaled),
            (None, None, None) => Err(Failure::usage(&format!(
                "the paper's Table 2 has no time for {scene}: give --hz or --budget"
            ))),
        }
    }
}

impl Prepared {
    /// What traces.
    pub const fn simd(&self) -> Simd {
        self.baked.layout().simd(self.options.simd)
    }

    /// What a session has of these; the rest is its own.
    pub const fn settings(&self, of: SessionSettings) -> SessionSettings {
        SessionSettings {
            hz: self.hz,
            budget: self.budget,
            table: self.table,
            ..of
        }
    }

    /// Renders frames until the audience has enough, with whatever machines there are
    /// besides.
    ///
    /// # Errors
    /// A frame that cannot be rendered; machines that do not keep up.
    pub fn play(
        &self,
        tracker: &LiveTracker,
        settings: &SessionSettings,
        audience: &mut dyn Audience,
        lock: &mut dyn SwapLock,
    ) -> Result<Played, Failure> {
        let share = lock.share();
        let leads = Leads {
            tracker,
            settings,
            lock,
        };
        let (report, interference) = self.engage(share, audience, leads)?;
        let repeats = report.last.filter(|_| share.ranks() > 1).map(Repeats);
        let alone = repeats.map(|repeats| self.engage(Share::ALL, audience, repeats));
        Ok(Played {
            report,
            interference,
            alone: alone.transpose()?,
        })
    }

    /// Renders a share of what another machine orders.
    ///
    /// # Errors
    /// A frame that cannot be rendered; a machine that orders nothing.
    pub fn obey(
        &self,
        audience: &mut dyn Audience,
        lock: &mut dyn SwapLock,
    ) -> Result<(), Failure> {
        self.engage(lock.share(), audience, Obeys { lock })
    }

    fn engage<P: Part>(
        &self,
        share: Share,
        audience: &mut dyn Audience,
        part: P,
    ) -> Result<P::Output, Failure> {
        with_scene!(&self.baked, |scene| self
            .trace(scene, share, audience, part))
    }

    fn trace<P: Part, const W: usize>(
        &self,
        scene: Scene<'_, W>,
        share: Share,
        audience: &mut dyn Audience,
        part: P,
    ) -> Result<P::Output, Failure>
    where
        Simd: Runs<W>,
    {
        let Self {
            arguments,
            cave,
            options,
            ..
        } = self;
        let mut storage = Vec::new();
        let spectrum = options.dispersion.spectrum(&mut storage);
        let pose = arguments.room.head();
        let places = arguments.room.eyes(pose);
        let directions = arguments.room.directions(pose);
        let eyes = arguments.lod.observers(places, directions, 0.0)?;
        let (ranks, pictures) = (share.ranks(), cave.screens().count() * eyes.len());
        if ranks > pictures {
            return Err(Failure::from_error(SwapError::TooMany { ranks, pictures }));
        }
        let mut display = Show {
            arguments,
            cave,
            start: pose,
            audience,
        };
        let (scene, capture) = ((scene, spectrum), arguments.capture);
        let played = with_engine(scene, cave, &eyes, options, capture, share, |engine| {
            part.play(engine, &mut display)
        })?;
        Ok(played?)
    }
}

/// What is done with an engine.
trait Part {
    /// What comes of it.
    type Output;

    fn play<const W: usize>(
        self,
        engine: &mut Engine<'_, '_, W>,
        display: &mut dyn Display<W>,
    ) -> Result<Self::Output, SessionError>
    where
        Simd: Runs<W>;
}

/// Follows a tracker, and says what is rendered.
struct Leads<'s> {
    tracker: &'s LiveTracker,
    settings: &'s SessionSettings,
    lock: &'s mut dyn SwapLock,
}

impl Part for Leads<'_> {
    type Output = (SessionReport, Interference);

    fn play<const W: usize>(
        self,
        engine: &mut Engine<'_, '_, W>,
        display: &mut dyn Display<W>,
    ) -> Result<Self::Output, SessionError>
    where
        Simd: Runs<W>,
    {
        // While the engine's threads are there: what they were kept from goes with them.
        let before = Interference::so_far();
        let report = crate::live::run(engine, self.tracker, self.settings, display, self.lock)?;
        Ok((report, Interference::so_far().since(&before)))
    }
}

/// Does what another machine says.
struct Obeys<'s> {
    lock: &'s mut dyn SwapLock,
}

impl Part for Obeys<'_> {
    type Output = ();

    fn play<const W: usize>(
        self,
        engine: &mut Engine<'_, '_, W>,
        display: &mut dyn Display<W>,
    ) -> Result<(), SessionError>
    where
        Simd: Runs<W>,
    {
        crate::live::follow(engine, display, self.lock)
    }
}

/// Renders alone what all machines rendered, whole: what it hashes to.
struct Repeats(Order);

impl Part for Repeats {
    type Output = u64;

    fn play<const W: usize>(
        self,
        engine: &mut Engine<'_, '_, W>,
        display: &mut dyn Display<W>,
    ) -> Result<u64, SessionError>
    where
        Simd: Runs<W>,
    {
        let mut eyes = Vec::new();
        display.observe(&self.0.look, &mut eyes);
        let quality = Quality::LADDER.get(self.0.rung).unwrap_or(&Quality::FULL);
        engine.render(&eyes, quality, None)?;
        Ok(frame_hash(engine.hashes()?))
    }
}

/// What became of a session.
pub struct Played {
    pub report: SessionReport,
    /// What the system did meanwhile.
    pub interference: Interference,
    /// What the last frame hashes to where this machine renders all of it; `None` where
    /// it is alone.
    pub alone: Option<u64>,
}

/// Between a session and its audience.
struct Show<'s> {
    arguments: &'s LiveArguments,
    cave: &'s Cave,
    /// A head that sees all screens.
    start: HeadPose,
    audience: &'s mut dyn Audience,
}

impl<const W: usize> Display<W> for Show<'_>
where
    Simd: Runs<W>,
{
    fn gaze(&mut self) -> Option<Vec3> {
        self.audience.gaze()
    }

    fn observe(&mut self, look: &Look, eyes: &mut Vec<Observer>) -> bool {
        let mut places = self.arguments.room.eyes(look.head);
        let directions = (look.forward.as_dvec3(), look.up.as_dvec3());
        let seen = places
            .clone()
            .all(|(_, place)| self.cave.check_eye(place).is_ok());
        if seen || eyes.is_empty() {
            if !seen {
                places = self.arguments.room.eyes(self.start);
            }
            let lod = &self.arguments.lod;
            // A line of sight that is none leaves the eyes as they were.
            let _ = lod.observe(places, directions, look.widen, eyes);
        }
        seen
    }

    fn present(&mut self, engine: &Engine<'_, '_, W>, look: &Look, eyes: &[Observer]) {
        self.audience.see(engine, look.head, eyes);
    }

    fn is_over(&mut self) -> bool {
        self.audience.is_over()
    }

    fn after(&mut self, record: &FrameRecord) -> bool {
        self.audience.hear(record)
    }
}
