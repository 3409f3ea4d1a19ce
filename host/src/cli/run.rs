//! `shisen run`: frames that follow a tracker, each in its time.

mod files;
mod frames;
mod log;
mod report;
mod shortfall;
mod together;
#[cfg_attr(not(all(unix, feature = "window")), path = "run/no_watch.rs")]
mod watch;
mod watched;

use crate::cli::arguments::filling::{CaptureDetail, refuse_detail};
use crate::cli::arguments::{span, whole};
use crate::cli::output::failure::Failure;
use crate::cli::output::print;
use crate::cli::play::{Change, LiveArguments, TimeArguments, paper_lod};
use crate::cli::tracker::{Interrupt, TrackerName};
use crate::live::{Latch, SessionSettings, SwapLock};
use crate::render::CaptureOptions;
use crate::show::stereo::Stereo;
use clap::{Args, ValueEnum};
use frames::{Frames, Output};
use log::Log;
use report::{Around, Report, Together};
use serde::Serialize;
use std::path::PathBuf;
use std::time::Duration;

/// Follows a tracker frame after frame, within a budget
///
/// Each frame takes the newest gaze, is made as good as fits into its budget, and
/// is shown at a refresh of the display. What does not fit is chosen before the
/// frame begins: bounces, then faces, then the rim of the visual field. A frame
/// whose budget ends before it is finished lacks its rim: what is looked at comes first,
/// and of a budget of time it is finished whatever it takes.
///
/// Ctrl-C ends it, with its report.
///
/// With --json, one object: scene, mesh, tracker, size, threads, simd, lod, hz, budget,
/// `budget_ms` and `budget_steps` (the last frame's allowance, null where it is not by
/// time or by steps), `plain_ms` (a frame in full, where the budget is a part of that)
/// and `plain_parts` (the least and the most that it was), latch, seconds, frames,
/// refreshes (until the last frame), `repeated_refreshes` (those without a new frame:
/// with frames they make up refreshes), `late_frames` (not there at their refresh, or at
/// the one that ends their budget, where that is longer), `over_budget_frames` (more
/// steps than a budget of steps allows), `over_time_frames` (from taking the gaze to the
/// last pixel longer than the budget, where that is a time), `frames_with_unfinished_fovea` (a tile within
/// 5° of the line of sight not finished; where the gaze is lost, of the head's direction),
/// `frames_with_unfinished_tiles`, `lowered_share` (of the frames, those whose quality
/// was lowered), `spent_share` (of the budget, what frames took: the median; null without
/// one), `needed_share` (of its steps, what frames of full quality would have taken, as
/// far as is known: the median), `quality_changes`, rungs (depth, faces, field, centre,
/// sampling, capture and frames of each quality, the best first), `blind_frames` (the
/// head was where a screen is not seen), `frames_without_gaze` (before the first sample,
/// after a tracker was silent for longer than a gaze is held, `widen_after` of SPEC, or
/// with eyes that are not seen: in no time from a sample on), `median_steps`, samples,
/// `passed_over_samples` (of these, not used, as a sensor sent 2,000 a second or more),
/// `lost_samples` (by the device's count), `dropped_bytes`, `motion_to_wall_ms` (frames,
/// least, p50, p95, p99, most; null without samples), stages (the same of
/// `sample_to_arrive`, `arrive_to_latch`, `latch_to_first_ray`, `first_ray_to_done`,
/// `done_to_present`, `arrive_to_first_ray` and `motion_to_wall`), histograms (of each of
/// these stages the classes that have frames: where a class ends, in milliseconds, and how
/// many frames; each is a fifth longer than the one before), `involuntary_switches`
/// (how often the system took the processor away) and `stolen_seconds` (of all
/// processors, by whatever this machine runs on); null where the system does not say;
/// stereo (format and `eye_order`, the first eye first), fill (by now, where keys changed
/// it), window (null without one: shown and dropped (frames), and `is_open`, whether it
/// was at the end), cluster (null without --cluster or with one process: ranks,
/// `frame_hash` of the last frame's pictures as all processes render it without an end of
/// steps, `frame_hash_alone` as the first does by itself, `waited_us`, how long that
/// waited for the others of each frame: p50, p95, p99, most, and `spread_us`, by how much
/// longer the last took to be ready than the first, likewise) and `earlier_frames` (before
/// a key in the window asked for another scene or level of detail; all else is of the
/// frames since).
///
/// The window is on the X server that DISPLAY names. It shows what it has the time
/// for and holds no frame up; where it is closed, frames go on to the end of --frames
/// or --seconds, and without these end. Where the X server goes away, they go on.
#[derive(Debug, Args)]
#[command(mut_arg("lod", paper_lod))]
pub(super) struct Arguments {
    #[command(flatten)]
    live: LiveArguments,
    #[command(flatten)]
    time: TimeArguments,
    /// The tracker: mock, mock:seed=7&rate=200&as=fastrak, serial:PORT?protocol=NAME,
    /// hid:VENDOR:PRODUCT or replay:FILE; --head is where its origin is
    #[arg(long, value_name = "SPEC", default_value = "mock")]
    tracker: TrackerName,
    /// When a frame takes the gaze
    #[arg(long, value_enum, default_value = "late")]
    latch: LatchName,
    /// End after so many seconds
    #[arg(long, value_name = "S", value_parser = span)]
    seconds: Option<Duration>,
    /// End after so many frames
    #[arg(long, value_name = "N",
          value_parser = whole::<u64>(1..))]
    frames: Option<u64>,
    /// What becomes of the frames
    #[arg(long, value_enum, default_value = "none")]
    view: View,
    /// How --view shows two eyes: mono (the left one alone), sequential (left, then
    /// right), side-by-side, top-bottom or anaglyph (for red-cyan glasses)
    #[arg(long, value_name = "FORMAT", default_value_t = Stereo::Mono)]
    stereo: Stereo,
    /// What shows where the gaze skips rays
    #[arg(long, value_enum, default_value = "background")]
    fill: FillName,
    #[command(flatten)]
    capture: CaptureDetail,
    /// Folder of the pictures of --view png, and of the window's; made where it does
    /// not exist
    #[arg(long, value_name = "DIR", default_value = "shisen-out")]
    out: PathBuf,
    /// Write what each frame was, one JSON object a line: `due_us`, `due_refresh` and
    /// refresh (numbers of the refreshes at which it was to be shown, and was),
    /// `sample_us`, `arrive_us`, `latch_us`, `first_ray_us`, `done_us`, `present_us`
    /// (since the tracker was opened), frame, late, position, forward, state,
    /// `follows_gaze`, `budget_us` and `over_time` (whether it took longer, from
    /// `latch_us` to `done_us`), `budget_steps`, steps, `need_steps`, rung, tiles,
    /// `unfinished_tiles` and `unfinished_fovea`
    #[arg(long, value_name = "FILE")]
    record: Option<PathBuf>,
    /// Share the walls and eyes out among the processes that mpirun started: all with
    /// the same arguments, and the scene's files on each machine. The first reads the
    /// tracker
    #[arg(long)]
    cluster: bool,
    /// How long a frame of another process is waited for, with --cluster
    #[arg(long, value_name = "S", default_value_t = 5,
          value_parser = whole::<u64>(1..=3_600), requires = "cluster")]
    swap_timeout: u64,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

/// `--latch`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum LatchName {
    /// As soon as the frame before is shown
    Early,
    /// With the last sample that comes in time, as late as the last frames allow
    Late,
}

/// `--view`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum View {
    /// They are measured, and forgotten
    None,
    /// A PNG each, or for --stereo sequential two: the walls unfolded
    Png,
    /// A window, with keys to look around
    Window,
}

/// `--fill`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum, Serialize)]
#[serde(rename_all = "kebab-case")]
enum FillName {
    /// What a ray sees that meets nothing
    Background,
    /// With --view, what the frame before shows there
    Previous,
    /// The surroundings, captured through mirrored spheroids at the head within the
    /// budget: anew in each frame, or, where quality is lowered, a part of them
    Capture,
}

impl FillName {
    /// As it is written on a command line.
    const fn name(self) -> &'static str {
        match self {
            Self::Background => "background",
            Self::Previous => "previous",
            Self::Capture => "capture",
        }
    }

    /// The next in their list.
    const fn next(self) -> Self {
        match self {
            Self::Background => Self::Previous,
            Self::Previous => Self::Capture,
            Self::Capture => Self::Background,
        }
    }
}

impl Arguments {
    /// What is asked for together can be had together.
    fn check(&self) -> Result<(), Failure> {
        let stereo = self.stereo;
        if self.fill != FillName::Background && !self.live.lod.is_on() {
            return Err(Failure::usage(
                "--fill is for --lod paper, paper-ellipse or foveated: with --lod off no ray is \
                 skipped",
            ));
        }
        if self.fill == FillName::Previous && self.view == View::None {
            return Err(Failure::usage(
                "--fill previous is for --view png or window: with --view none nothing is shown",
            ));
        }
        if self.fill != FillName::Capture {
            refuse_detail(self.capture.given())?;
        }
        if self.cluster && self.view == View::Window {
            return Err(Failure::usage(
                "--cluster is for --view none or png: a window would show a part of the walls",
            ));
        }
        if stereo == Stereo::Mono {
            return Ok(());
        }
        if self.cluster {
            return Err(Failure::usage(&format!(
                "--stereo {stereo} puts two eyes into one picture, and --cluster shares them \
                 out: leave one of them out",
            )));
        }
        if self.view == View::None {
            return Err(Failure::usage(&format!(
                "--stereo {stereo} is for --view png or window: with --view none nothing is shown"
            )));
        }
        self.live.room.check_stereo(stereo)
    }

    /// What is shown at first.
    fn live(&self) -> LiveArguments {
        self.live.changed(Change::Capture(self.fills(self.fill)))
    }

    /// How to capture the surroundings for a fill.
    fn fills(&self, fill: FillName) -> Option<CaptureOptions> {
        (fill == FillName::Capture).then(|| self.capture.options())
    }

    fn latch(&self) -> Latch {
        match self.latch {
            LatchName::Early => Latch::Early,
            LatchName::Late => Latch::Late,
        }
    }
}

/// Runs the command.
pub(super) fn run(arguments: &Arguments) -> Result<(), Failure> {
    arguments.check()?;
    let mut lock = together::lock(arguments)?;
    if lock.share().rank() == 0 {
        lead(arguments, &mut *lock)
    } else {
        obey(arguments, &mut *lock)
    }
}

/// Follows the machine that leads.
fn obey(arguments: &Arguments, lock: &mut dyn SwapLock) -> Result<(), Failure> {
    let prepared = arguments.live().prepare(&arguments.time)?;
    let output = Output::open(arguments, &prepared, lock.share())?;
    let interrupt = Interrupt::watched();
    let mut frames = Frames::new(arguments, &interrupt, None, output);
    frames.begin(&prepared);
    prepared.obey(&mut frames, lock)?;
    frames.finish().1
}

/// Follows the tracker.
fn lead(arguments: &Arguments, lock: &mut dyn SwapLock) -> Result<(), Failure> {
    let log = arguments.record.as_deref().map(Log::create).transpose()?;
    let mut prepared = arguments.live().prepare(&arguments.time)?;
    let output = Output::open(arguments, &prepared, lock.share())?;
    let interrupt = Interrupt::watched();
    let tracker = arguments.live.listen(&arguments.tracker.spec)?;
    let mut frames = Frames::new(arguments, &interrupt, log, output);
    let mut earlier = 0;
    // Once for each scene and level of detail that somebody wants to see.
    loop {
        let settings = prepared.settings(SessionSettings {
            latch: arguments.latch(),
            frames: arguments.frames.map(|frames| frames - earlier),
            ..SessionSettings::default()
        });
        frames.begin(&prepared);
        let played = prepared.play(&tracker, &settings, &mut frames, lock)?;
        let report = &played.report;
        if let Some(change) = frames.change() {
            earlier += report.frames;
            match prepared.arguments.changed(change).prepare(&arguments.time) {
                Ok(next) => prepared = next,
                // What was shown before goes on.
                Err(failure) => {
                    let _ = failure.print();
                }
            }
            continue;
        }
        let fill = frames.fill();
        let (window, files) = frames.finish();
        let around = Around {
            fill,
            threads: prepared.options.threads,
            simd: prepared.simd().name(),
            lost_samples: tracker.counts().lost,
            dropped_bytes: tracker.counts().dropped_bytes,
            earlier_frames: earlier,
            window,
            cluster: Together::of(lock.share(), &played),
            interference: played.interference,
        };
        // Of the frames that there were, whatever became of the files.
        print(
            &Report::new(around, arguments, &prepared, &settings, report),
            arguments.json,
        )?;
        return files;
    }
}
