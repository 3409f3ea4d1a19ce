//! `shisen run`: frames that follow a tracker, each in its time.

mod interference;
mod report;

use super::arguments::{Model, SceneName};
use super::failure::{Failure, Fault};
use super::lod::LodArguments;
use super::picture_files::make_writable;
use super::print;
use super::room::RoomArguments;
use super::source::Source;
use super::tracing::TracingArguments;
use super::tracker::{Happenings, Interrupt, TrackerName, warn_of_sensors, whole};
use super::warn;
use clap::{Args, ValueEnum};
use interference::Interference;
use report::{Around, Report};
use shisen::bake::{BakedScene, Layout};
use shisen::cave::{Cave, Eye};
use shisen::live::{
    Engine, FrameBudget, FrameRecord, Happening, Latch, LiveTracker, SessionReport,
    SessionSettings, Stage, Table2, with_engine,
};
use shisen::net;
use shisen::picture::Picture;
use shisen::render::{Observer, Options};
use shisen::spectrum::Dispersion;
use shisen::tracker::calibration::{Calibrated, estimation};
use shisen::tracker::{Feed, Notice};
use shisen_core::scene::Scene;
use shisen_core::{Runs, Simd};
use shisen_tracker::clock::{ClockConfig, ClockEstimator};
use shisen_tracker::decoder::Event;
use shisen_tracker::estimate::{Estimate, GazeEstimator};
use shisen_tracker::time::Micros;
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Follows a tracker frame after frame, within a budget
///
/// Each frame takes the newest gaze, is made as good as fits into its budget, and
/// is shown at a refresh of the display. What does not fit is chosen before the
/// frame begins: bounces, then faces, then the rim of the visual field. A frame
/// whose budget ends before it is finished lacks its rim, never what is looked at.
///
/// Ctrl-C ends it, with its report.
///
/// With --json, one object: scene, mesh, tracker, size, threads, simd, lod, hz,
/// budget, `budget_ms` and `budget_steps` (the last frame's allowance, null where it
/// is not by time or by steps), `plain_ms` (a frame in full, where the budget is a
/// part of that), latch, seconds, frames, `late_frames` (not there at their refresh), `over_budget_frames` (more steps than
/// allowed), `frames_with_unfinished_fovea` (a tile within 5° of the line of sight
/// not finished), `frames_with_unfinished_tiles`, `lowered_share` (of the frames,
/// those whose quality was lowered), `quality_changes`, rungs (depth, faces, field
/// and frames of each quality, the best first), `blind_frames` (the head was where
/// a screen is not seen), `median_steps`, samples, `dropped_bytes`,
/// `motion_to_wall_ms` (frames, least, p50, p95, p99, most; null without samples),
/// stages (the same of `sample_to_arrive`, `arrive_to_latch`, `latch_to_first_ray`,
/// `first_ray_to_done`, `done_to_present`, `arrive_to_first_ray` and
/// `motion_to_wall`), `involuntary_switches` (how often the system took the
/// processor away) and `stolen_seconds` (of all processors, by whatever this machine
/// runs on); null where the system does not say.
#[derive(Debug, Args)]
#[command(mut_arg("lod", |lod| lod.default_value("paper").hide_default_value(false)
    .help("What follows the gaze: detail falls with the distance from the line of sight, and \
           nothing outside the visual field is traced")))]
pub(super) struct Arguments {
    /// A, B, C or D of the paper, grid, prism, spheres, a TOML description or a baked
    /// scene
    #[arg(long, value_name = "A|B|C|D|grid|prism|spheres|FILE", default_value = "A",
          value_parser = SceneName::parser())]
    scene: SceneName,
    #[command(flatten)]
    model: Model,
    #[command(flatten)]
    room: RoomArguments,
    /// The tracker: mock, mock:seed=7&rate=200&as=fastrak, serial:PORT?protocol=NAME,
    /// hid:VENDOR:PRODUCT or replay:FILE; --head is where its origin is
    #[arg(long, value_name = "SPEC", default_value = "mock")]
    tracker: TrackerName,
    /// What `shisen tracker calibrate` wrote for it
    #[arg(long, value_name = "TOML")]
    calibration: Option<PathBuf>,
    #[command(flatten)]
    lod: LodArguments,
    #[command(flatten)]
    tracing: TracingArguments,
    /// Refreshes per second; without --budget, also what a frame may take
    #[arg(long, value_name = "HZ", allow_negative_numbers = true, value_parser = whole::<1, 1_000>)]
    hz: Option<u64>,
    /// What a frame may take: 33ms, 2000000steps (the same frames on every machine),
    /// paper (the seconds of its Table 2), paper-scaled (its time with level of detail
    /// as a part of its time without, of what that takes here) or off [default: a
    /// refresh of --hz, or else paper-scaled]
    #[arg(long, value_name = "BUDGET")]
    budget: Option<FrameBudget>,
    /// When a frame takes the gaze
    #[arg(long, value_enum, default_value = "late")]
    latch: LatchName,
    /// End after so many seconds
    #[arg(long, value_name = "S", allow_negative_numbers = true, value_parser = whole::<1, 86_400>)]
    seconds: Option<u64>,
    /// End after so many frames
    #[arg(long, value_name = "N", allow_negative_numbers = true,
          value_parser = whole::<1, { u64::MAX }>)]
    frames: Option<u64>,
    /// What becomes of the frames
    #[arg(long, value_enum, default_value = "none")]
    view: View,
    /// Folder of the pictures of --view png; made where it does not exist
    #[arg(long, value_name = "DIR", default_value = "shisen-out")]
    out: PathBuf,
    /// Write what each frame was, one JSON object a line: `due_us`, `sample_us`,
    /// `arrive_us`, `latch_us`, `first_ray_us`, `done_us`, `present_us` (since the
    /// tracker was opened), frame, late, position, forward, state, `budget_steps`,
    /// steps, `need_steps`, rung, tiles, `unfinished_tiles` and `unfinished_fovea`
    #[arg(long, value_name = "FILE")]
    record: Option<PathBuf>,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

/// `--latch`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum LatchName {
    /// As soon as the frame before is shown
    Early,
    /// As late as the last frames allow
    Late,
}

/// `--view`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum View {
    /// They are measured, and forgotten
    None,
    /// A PNG each: the walls of one eye, unfolded
    Png,
}

/// Runs the command.
pub(super) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let table = match arguments.scene {
        SceneName::Paper(scene) => Table2::of(scene),
        _ => None,
    };
    let budget = budget(arguments, table)?;
    let cave = arguments.room.cave()?;
    let pose = arguments.room.head();
    for (_, place) in arguments.room.eyes(pose) {
        cave.check_eye(place)?;
    }
    let log = arguments.record.as_deref().map(Log::create).transpose()?;
    let source = Source::load(&arguments.scene, &arguments.model)?;
    let baked = arguments.lod.baked(source.scene, &source.name)?;
    if arguments.view == View::Png {
        make_writable(&arguments.out)?;
    }
    let (options, dispersion) = arguments.tracing.options(&baked)?;
    if dispersion.is_some() && matches!(options.dispersion, Dispersion::Images(..)) {
        return Err(Failure::usage(
            "--dispersion paper renders a frame for each wavelength: take comb or split",
        ));
    }
    let interrupt = Interrupt::new();
    let tracker = listen(arguments)?;
    let hz = arguments.hz.unwrap_or(60);
    let settings = SessionSettings {
        hz: hz as u32,
        budget,
        table,
        latch: match arguments.latch {
            LatchName::Early => Latch::Early,
            LatchName::Late => Latch::Late,
        },
        frames: arguments.frames,
    };
    let mut show = Show {
        arguments,
        cave: &cave,
        interrupt: &interrupt,
        end: None,
        log,
        pictures: Vec::new(),
        shown: 0,
        interference: Interference::NONE,
        failure: None,
    };
    let report = match &baked {
        BakedScene::Fast(baked) => play(baked.scene(), &options, &tracker, &settings, &mut show),
        BakedScene::Compact(baked) => play(baked.scene(), &options, &tracker, &settings, &mut show),
    }?;
    if let Some(failure) = show.failure {
        return Err(failure);
    }
    if let Some(log) = show.log {
        log.finish()?;
    }
    let around = Around {
        scene: source.name,
        mesh: source.mesh,
        simd: match baked.layout() {
            Layout::Fast => options.simd.name(),
            // Four lanes have the portable path only.
            Layout::Compact => Simd::PORTABLE.name(),
        },
        threads: options.threads,
        dropped_bytes: tracker.counts().dropped_bytes,
        interference: show.interference,
    };
    let report = Report::new(around, arguments, &settings, &report);
    print(&report, arguments.json)
}

/// What a frame may take.
///
/// # Errors
/// Of usage: a scene that the paper has no time for.
fn budget(arguments: &Arguments, table: Option<Table2>) -> Result<FrameBudget, Failure> {
    let name = || arguments.scene.to_string();
    match (arguments.budget, arguments.hz, table) {
        (Some(budget @ (FrameBudget::Paper | FrameBudget::PaperScaled)), _, None) => {
            Err(Failure::usage(&format!(
                "--budget {budget} is for the scenes A to D of the paper's Table 2, and {} is none \
                 of them: give --hz or another --budget",
                name()
            )))
        }
        (Some(budget), ..) => Ok(budget),
        (None, Some(hz), _) => Ok(FrameBudget::Time(Duration::from_secs_f64(1.0 / hz as f64))),
        (None, None, Some(_)) => Ok(FrameBudget::PaperScaled),
        (None, None, None) => Err(Failure::usage(&format!(
            "the paper's Table 2 has no time for {}: give --hz or --budget",
            name()
        ))),
    }
}

/// Opens the tracker and listens to it.
fn listen(arguments: &Arguments) -> Result<LiveTracker, Failure> {
    let spec = &arguments.tracker.spec;
    let calibration = arguments.calibration.as_deref();
    let calibrated = calibration.map(|path| Calibrated::load(path, spec));
    let calibrated = calibrated.transpose()?;
    let feed = Feed::open(spec)?;
    let head = arguments.room.head();
    let config = estimation(spec, feed.senses(spec), head, calibrated.as_ref());
    let estimator = GazeEstimator::new(config).map_err(Failure::from_error)?;
    let clock = ClockEstimator::new(ClockConfig::default()).map_err(Failure::from_error)?;
    let mut happenings = Happenings::default();
    let tell = move |happening: Happening| {
        let said = match happening {
            Happening::Clock(event, at) => happenings.of_clock(&event, at),
            Happening::Gaze(event, at) => {
                warn_of_sensors(&event);
                happenings.of_gaze(&event, at)
            }
            Happening::Feed(Notice::Decoded(event)) => match *event {
                Event::Message(message) => happenings.of_device(&message, Micros(0)),
                _ => None,
            },
            Happening::Feed(Notice::Unplugged { path, reason }) => {
                Some(format!("{path} is gone ({reason}); waiting for it"))
            }
            Happening::Feed(Notice::Refused { reason }) => Some(format!("{reason}; trying again")),
            Happening::Feed(Notice::Trouble(failure)) => Some(failure.to_string()),
            Happening::Feed(Notice::Plugged(_) | Notice::Described(_)) => None,
        };
        if let Some(said) = said {
            warn(&said);
        }
    };
    LiveTracker::start(feed, clock, estimator, tell).map_err(Failure::from_error)
}

/// Renders until the end.
fn play<const W: usize>(
    scene: Scene<'_, W>,
    options: &Options,
    tracker: &LiveTracker,
    settings: &SessionSettings,
    show: &mut Show<'_>,
) -> Result<SessionReport, Failure>
where
    Simd: Runs<W>,
{
    let mut storage = Vec::new();
    let spectrum = options.dispersion.spectrum(&mut storage);
    let pose = show.arguments.room.head();
    let eyes = show.arguments.room.eyes(pose);
    let (forward, up) = show.arguments.room.directions(pose);
    let eyes = show.arguments.lod.observers(&eyes, (forward, up), 0.0)?;
    let cave = show.cave;
    with_engine(scene, spectrum, cave, &eyes, options, |engine| {
        show.pictures = match show.arguments.view {
            View::Png => engine.pictures().map_err(Failure::from_error)?,
            View::None => Vec::new(),
        };
        let seconds = show
            .arguments
            .seconds
            .map(|s| Micros::from_millis(1_000 * s));
        show.end = seconds.map(|seconds| tracker.now().after(seconds));
        let before = Interference::so_far();
        let report = shisen::live::run(engine, tracker, settings, show);
        show.interference = Interference::so_far().since(&before);
        report.map_err(Failure::from_error)
    })
    .map_err(Failure::from_error)?
}

/// What becomes of frames.
struct Show<'s> {
    arguments: &'s Arguments,
    cave: &'s Cave,
    interrupt: &'s Interrupt,
    /// On the tracker's clock.
    end: Option<Micros>,
    log: Option<Log>,
    /// Where a frame's pictures are kept for a file.
    pictures: Vec<Picture>,
    shown: u64,
    interference: Interference,
    failure: Option<Failure>,
}

impl Show<'_> {
    fn write(&self, eyes: &[Observer]) -> Result<(), Failure> {
        let eye = eyes.first().map_or(Eye::Centre, |one| one.eye);
        let pictures = shisen::live::eyes_of(self.cave, eyes).zip(&self.pictures);
        let seen: Vec<_> = pictures
            .filter(|((_, of), _)| *of == eye)
            .filter_map(|((screen, _), picture)| Some((self.cave.screens().nth(screen)?, picture)))
            .collect();
        let net = net::unfold(&seen).map_err(Failure::from_error)?;
        let path = self
            .arguments
            .out
            .join(format!("frame-{:06}.png", self.shown));
        net.write_png(&path, &[]).map_err(Failure::from_error)
    }
}

impl<const W: usize> Stage<W> for Show<'_>
where
    Simd: Runs<W>,
{
    fn observe(&mut self, estimate: &Estimate, eyes: &mut Vec<Observer>) -> bool {
        let places = self.arguments.room.eyes(estimate.head);
        let sight = estimate.line_of_sight;
        let (forward, up) = (sight.forward().as_dvec3(), sight.up().as_dvec3());
        let seen = places
            .iter()
            .all(|&(_, place)| self.cave.check_eye(place).is_ok());
        let lod = &self.arguments.lod;
        match lod.observers(&places, (forward, up), estimate.widen) {
            Ok(observers) if seen || eyes.is_empty() => *eyes = observers,
            _ => {}
        }
        seen
    }

    fn present(&mut self, engine: &Engine<'_, '_, W>, _: &Estimate, eyes: &[Observer]) {
        if self.arguments.view == View::Png {
            engine.copy(&mut self.pictures);
            if let Err(failure) = self.write(eyes) {
                self.failure.get_or_insert(failure);
            }
        }
        self.shown += 1;
    }

    fn after(&mut self, record: &FrameRecord) -> bool {
        if let Some(log) = &mut self.log
            && let Err(failure) = log.write(record)
        {
            self.failure.get_or_insert(failure);
        }
        let over = self.end.is_some_and(|end| record.present_us >= end.0);
        !(over || self.failure.is_some() || self.interrupt.came())
    }
}

/// The file of `--record`.
struct Log {
    path: PathBuf,
    file: BufWriter<File>,
}

impl Log {
    fn create(path: &Path) -> Result<Self, Failure> {
        let file = File::create(path).map_err(|reason| Fault::Write {
            path: path.to_owned(),
            reason,
        })?;
        Ok(Self {
            path: path.to_owned(),
            file: BufWriter::with_capacity(1 << 20, file),
        })
    }

    fn write(&mut self, record: &FrameRecord) -> Result<(), Failure> {
        let written = serde_json::to_writer(&mut self.file, record).map_err(Into::into);
        let written = written.and_then(|()| self.file.write_all(b"\n"));
        written.map_err(|reason| self.failed(reason))
    }

    fn finish(mut self) -> Result<(), Failure> {
        let flushed = self.file.flush();
        flushed.map_err(|reason| self.failed(reason))
    }

    fn failed(&self, reason: std::io::Error) -> Failure {
        Fault::Write {
            path: self.path.clone(),
            reason,
        }
        .into()
    }
}
