//! `shisen run`: frames that follow a tracker, each within a budget.

pub(super) mod files;
mod frames;
mod recorder;
pub(super) mod report;
mod shortfall;
mod together;
#[cfg_attr(
    not(all(unix, feature = "window")),
    allow(dead_code, reason = "without a window there are no keys")
)]
mod watch;

use crate::cave::{Eye, Pictured, Screen};
use crate::cli::arguments::filling::{CaptureDetail, Fill};
use crate::cli::arguments::outputs::{OutputsArguments, ProjectArguments};
use crate::cli::arguments::{SceneName, choices, span};
use crate::cli::play::{Change, LiveArguments, TimeArguments, live_lod};
use crate::cli::prelude::*;
use crate::cli::tracker::{Interrupt, TrackerName};
use crate::files::with_help;
use crate::live::{Latch, SessionSettings, Share, SwapLock, eyes_of};
use crate::outputs::Outputs;
use crate::projection::Projection;
use crate::record::Setup;
use crate::render::{CaptureOptions, Observer};
use crate::show::stereo::Stereo;
use crate::tracker::{By, Navigation};
use files::Log;
use frames::Frames;
use recorder::Recorder;
use report::{Report, SourceReport, Surroundings, Together};

/// Follows a tracker frame after frame, within a budget
#[derive(Debug, Args)]
#[command(
    mut_arg("lod", |lod| live_lod(lod).default_value("foveated")),
    mut_arg("scene", |scene| scene.default_value("gallery"))
)]
pub(super) struct Arguments {
    #[command(flatten)]
    live: LiveArguments,
    #[command(flatten)]
    time: TimeArguments,
    /// The tracker, whose origin is at --head: mock, mock:seed=7&rate=200&as=fastrak,
    /// serial:PORT?protocol=NAME, hid:VENDOR:PRODUCT, replay:FILE or one on the network (see
    /// `shisen tracker --help`), or head=SPEC and, in a --tracker of its own, gaze=SPEC
    #[arg(long, value_name = "SPEC", default_value = "mock")]
    tracker: Vec<TrackerName>,
    /// What flies the viewer through the scene: keyboard (the arrows, Page Up, Page Down and Home of
    /// the window), tracker (the buttons and axes of the --tracker) or the SPEC of another device,
    /// with speed=2 (m/s), turn=60 (degrees a second), dead=0.1, and the axes x=0, y=1 (x=-0 is the
    /// reverse) [default: keyboard]
    #[arg(long, value_name = "SPEC", value_parser = navigation)]
    navigate: Option<Navigation>,
    /// When a frame takes the gaze
    #[arg(long, value_enum, default_value = "late")]
    latch: Latch,
    /// End after S seconds
    #[arg(long, value_name = "S", value_parser = span)]
    seconds: Option<Duration>,
    /// End after N frames
    #[arg(long, value_name = "N", value_parser = whole::<u64>(1..))]
    frames: Option<u64>,
    /// Where frames are shown [default: window for the gallery and the scene of a file, where there
    /// is a display; else none]
    #[arg(long, value_enum)]
    view: Option<View>,
    /// How --view shows two eyes: mono (the left one alone), sequential (left, then right),
    /// side-by-side, top-bottom or anaglyph (for red-cyan glasses)
    #[arg(long, value_name = "FORMAT", default_value_t = Stereo::Mono)]
    stereo: Stereo,
    #[command(flatten)]
    outputs: OutputsArguments,
    #[command(flatten)]
    project: ProjectArguments,
    /// What shows where the gaze skips rays
    #[arg(long, value_enum, default_value = "background")]
    fill: Fill,
    #[command(flatten)]
    capture: CaptureDetail,
    /// Folder of the pictures of --view png and of the window; made if it does not exist
    #[arg(long, value_name = "DIR", default_value = "shisen-out")]
    out: PathBuf,
    /// File for what decides each frame and hashes of what it was: `shisen replay` shows and checks
    /// it
    #[arg(long, value_name = "FILE")]
    record: Option<PathBuf>,
    /// Keep the trackers' bytes in the record, too
    #[arg(long, requires = "record")]
    raw: bool,
    /// File for the times and figures of each frame, one JSON object a line
    #[arg(long, value_name = "FILE")]
    report: Option<PathBuf>,
    /// Share walls and eyes among the processes that mpirun started. All need the same arguments
    /// and the scene's files on their machine; the first reads the tracker
    #[arg(long)]
    cluster: bool,
    /// Longest wait for a frame of another process, with --cluster
    #[arg(long, value_name = "S", default_value_t = 5, requires = "cluster",
          value_parser = whole::<u64>(1..=3_600))]
    swap_timeout: u64,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

fn navigation(text: &str) -> Result<Navigation, String> {
    text.parse::<Navigation>()
        .map_err(|error| with_help(&error))
}

choices!(Latch {
    Early => "As soon as the frame before is shown",
    Late => "With the last sample that comes in time, as late as the last frames allow",
});

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum View {
    /// Nowhere: frames are only measured
    None,
    /// In a PNG of the unfolded walls each, or with --stereo sequential in two
    Png,
    /// In a window, with keys to look around
    Window,
}

impl Arguments {
    /// Checks that arguments go together.
    fn check(&self) -> Result<(), Failure> {
        let stereo = self.stereo;
        self.fill.check(&self.live.lod, self.capture.given())?;
        let is_shown = self.view() != View::None || self.outputs.is_given();
        if self.fill == Fill::Previous && !is_shown {
            return Err(misuse!(
                "--fill previous is for --view png or window and --outputs: nothing is shown"
            ));
        }
        let by_keys = self
            .navigate
            .as_ref()
            .is_some_and(|by| by.by == By::Keyboard);
        if by_keys && self.view() != View::Window {
            return Err(misuse!(
                "--navigate keyboard is for the keys of --view window: give the SPEC of a wand"
            ));
        }
        if self.cluster && self.view() == View::Window {
            return Err(misuse!(
                "--cluster is for --view none or png: a window would show a part of the walls"
            ));
        }
        if self.record.is_some() && self.cluster {
            return Err(misuse!(
                "--record keeps what one machine renders: leave --cluster out"
            ));
        }
        if self.record.is_some() && self.fill == Fill::Capture {
            return Err(misuse!(
                "--record cannot keep --fill capture, which builds on parts of many frames: take \
                 --fill previous or background"
            ));
        }
        if stereo == Stereo::Mono {
            return Ok(());
        }
        if self.cluster {
            return Err(misuse!(
                "--stereo {stereo} puts two eyes into one picture, and --cluster shares them \
                 out: leave one of them out",
            ));
        }
        if !is_shown {
            return Err(misuse!(
                "--stereo {stereo} is for --view png or window and --outputs: nothing is shown"
            ));
        }
        self.live.room.check_stereo(stereo)
    }

    /// Returns whether its scene is there to be looked at, rather than measured.
    const fn is_to_be_seen(&self) -> bool {
        matches!(self.live.scene, SceneName::File(_) | SceneName::Gallery)
    }

    fn view(&self) -> View {
        let shows = !self.cluster && self.is_to_be_seen();
        match self.view {
            Some(view) => view,
            None if shows && watch::is_possible() => View::Window,
            None => View::None,
        }
    }

    /// Returns `--hz` and `--budget`, with the refresh of the display that shows the frames; files
    /// of a file's scene have whole pictures unless told otherwise.
    fn time(&self, outputs: Option<&Outputs>) -> TimeArguments {
        let shown = (self.view() == View::Window).then(watch::refresh);
        let mut time = self.time;
        let hz = outputs.map(|outputs| outputs.hz().round() as u32);
        time.refresh = hz.or(shown.flatten());
        if self.is_to_be_seen() && self.view() == View::Png {
            time.or_unlimited()
        } else {
            time
        }
    }

    /// Opens the windows of this machine's share of the pictures.
    fn open_outputs(&self, share: Share) -> Result<Option<Outputs>, Failure> {
        if !self.outputs.is_given() {
            return Ok(None);
        }
        let room = &self.live.room;
        let mut cave = room.cave()?;
        cave.trace_directly(&self.direct(&cave)?)?;
        let eyes: Vec<_> = room
            .eyes(room.head())
            .map(|(eye, place)| Observer::new(eye, place))
            .collect();
        let names: Vec<&str> = cave.screens().map(Screen::name).collect();
        let sources: Vec<&str> = cave.pictured().map(Pictured::name).collect();
        let pictures = eyes_of(&cave, &eyes, share).map(|(number, eye)| (sources[number], eye));
        let pictures: Vec<(&str, Eye)> = pictures.collect();
        let projections = Projection::all(&cave)?;
        (self.outputs).open(&names, &pictures, &projections, self.stereo)
    }

    fn direct(&self, cave: &Cave) -> Result<Vec<String>, Failure> {
        let needs_screens = self.view() != View::None;
        self.project.direct(&self.outputs, cave, needs_screens)
    }

    fn live(&self) -> Result<LiveArguments, Failure> {
        let capture = Change::Capture(self.capture_for(self.fill));
        let mut live = self.live.changed(capture);
        live.direct = self.direct(&live.room.cave()?)?;
        Ok(live)
    }

    /// Returns how the frames of a session were rendered: in its walls, with the projectors whose own
    /// pixels it has.
    pub(super) fn of_session(&self, setup: &Setup) -> Result<LiveArguments, Failure> {
        let mut live = self.live.clone();
        if let Some(walls) = &setup.walls {
            live.room.set_walls(walls.clone());
        }
        let cave = live.room.cave()?;
        let names = setup.pictures.iter().map(|picture| &picture.name);
        let of_projector = |name: &&String| cave.screens().all(|screen| screen.name() != **name);
        live.direct = names.filter(of_projector).cloned().collect();
        live.direct.dedup();
        Ok(live)
    }

    fn capture_for(&self, fill: Fill) -> Option<CaptureOptions> {
        (fill == Fill::Capture).then(|| self.capture.options())
    }
}

pub(super) fn run(arguments: &Arguments) -> Result<(), Failure> {
    arguments.check()?;
    let mut lock = together::lock(arguments)?;
    if lock.share().rank() == 0 {
        lead(arguments, &mut *lock)
    } else {
        obey(arguments, &mut *lock)
    }
}

/// Renders this machine's share of what the first machine orders.
fn obey(arguments: &Arguments, lock: &mut dyn SwapLock) -> Result<(), Failure> {
    let outputs = arguments.open_outputs(lock.share())?;
    let prepared = arguments
        .live()?
        .prepare(&arguments.time(outputs.as_ref()))?;
    let interrupt = Interrupt::watched();
    let mut frames = Frames::open(
        arguments,
        &interrupt,
        (None, None),
        &prepared,
        lock.share(),
        outputs,
    )?;
    frames.begin(&prepared);
    prepared.obey(&mut frames, lock)?;
    frames.finish().1
}

/// Follows the tracker, and tells other machines what to render.
fn lead(arguments: &Arguments, lock: &mut dyn SwapLock) -> Result<(), Failure> {
    let outputs = arguments.open_outputs(lock.share())?;
    let time = arguments.time(outputs.as_ref());
    let mut prepared = arguments.live()?.prepare(&time)?;
    let interrupt = Interrupt::watched();
    let navigate = arguments.navigate.as_ref();
    let flight = navigate.map(|navigation| navigation.flight);
    let (tracker, raw) =
        arguments
            .live
            .listen_raw(&arguments.tracker, navigate, &prepared.cave, arguments.raw)?;
    // Files that are there are not written over before all else is known to be right.
    let log = arguments.report.as_deref().map(Log::create).transpose()?;
    let kept = (log, Recorder::create(arguments, raw)?);
    let mut frames = Frames::open(
        arguments,
        &interrupt,
        kept,
        &prepared,
        lock.share(),
        outputs,
    )?;
    let mut earlier = 0;
    // Once for each scene and level of detail that is asked for.
    loop {
        let settings = prepared.settings(SessionSettings {
            latch: arguments.latch,
            flight: flight.unwrap_or_default(),
            frames: arguments.frames.map(|frames| frames - earlier),
            ..SessionSettings::default()
        });
        frames.begin(&prepared);
        let played = prepared.play(&tracker, &settings, &mut frames, lock)?;
        if let Some(change) = frames.change.take() {
            earlier += played.report.frames;
            match prepared.arguments.changed(change).prepare(&time) {
                Ok(next) => {
                    prepared = next;
                    frames.note(change);
                }
                // The scene before stays.
                Err(failure) => {
                    let _ = failure.print();
                }
            }
            continue;
        }
        let fill = frames.fill;
        let shown = frames.shown_of_field();
        let outputs = frames.outputs.as_ref().map(Outputs::report);
        let (window, files) = frames.finish();
        let surroundings = Surroundings {
            fill,
            threads: prepared.options.threads,
            simd: prepared.simd().name(),
            shown_share: shown.0,
            advice: shown.1,
            lost_samples: tracker.counts().lost,
            dropped_bytes: tracker.counts().dropped_bytes,
            sources: SourceReport::all(&tracker),
            earlier_frames: earlier,
            window,
            outputs,
            cluster: Together::new(lock.share(), &played),
            interference: played.interference,
        };
        // The report comes even if a file failed.
        let report = Report::new(surroundings, arguments, &prepared, played.report);
        print(&report, arguments.json)?;
        if arguments.view() == View::Png && files.is_ok() {
            say(&format!("the pictures are in {}", arguments.out.display()));
        }
        if let (Some(record), Ok(())) = (&arguments.record, &files) {
            say(&format!("the record is {}", record.display()));
        }
        return files;
    }
}
