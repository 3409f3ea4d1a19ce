//! `shisen-evidence bench budget`: frames at half of what they take.

use clap::Args;
use serde::Serialize;
use shisen::cli::arguments::whole;
use shisen::cli::output::failure::Failure;
use shisen::cli::output::print;
use shisen::cli::play::{
    Audience, Interference, LiveArguments, Played, Prepared, TimeArguments, paper_lod,
};
use shisen::cli::tracker::{Interrupt, TrackerName};
use shisen::live::quantiles::median;
use shisen::live::{Alone, FrameBudget, FrameRecord, SessionReport, SessionSettings};
use std::fmt;
use std::time::Duration;

/// Frames at half of what they take without a budget: in time, and whole where one looks
///
/// Frames follow a tracker as with `shisen run`: first a tenth of them without a budget,
/// of which the medians are taken; then all at half of the median steps, and all at half
/// of the median time, a frame for each refresh of a display that is as fast as that.
/// Each begins with the tracker's first sample.
///
/// With --json, one object: scene, mesh, tracker, size, threads, simd, lod, free (frames,
/// and medians: steps and milliseconds, from taking the gaze to the last pixel) and runs:
/// for steps and for time budget, hz (a whole number: the time is a refresh of it, and
/// at most half of the median), frames, `late_frames` (not there at their refresh),
/// `late_share`, `over_budget_frames` (more steps than a budget of them allows),
/// `over_time_frames` (longer than the budget, where that is a time),
/// `frames_with_unfinished_fovea` (a tile within 5° of the line of sight not finished),
/// `frames_with_unfinished_tiles`, `lowered_share` (of the frames, those whose quality was
/// lowered), `quality_changes`, `spent_share` (of the budget, the median),
/// `involuntary_switches` (how often the system took the processor away) and
/// `stolen_seconds` (of all processors, by whatever this machine runs on; both null where
/// the system does not say).
#[derive(Debug, Args)]
#[command(mut_arg("lod", paper_lod))]
pub(in crate::cli) struct Arguments {
    #[command(flatten)]
    live: LiveArguments,
    /// The tracker, as for `shisen run`
    #[arg(long, value_name = "SPEC", default_value = "mock")]
    tracker: TrackerName,
    /// Of each budget
    #[arg(long, value_name = "N", default_value = "10000",
          value_parser = whole::<u64>(10..=1_000_000))]
    frames: u64,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

/// What was measured.
#[derive(Debug, Serialize)]
struct Report {
    scene: String,
    mesh: Option<String>,
    tracker: String,
    size: u32,
    threads: usize,
    simd: &'static str,
    lod: &'static str,
    free: Free,
    runs: Vec<Run>,
}

/// Frames without a budget.
#[derive(Debug, Serialize)]
struct Free {
    frames: u64,
    steps: u64,
    milliseconds: f64,
}

/// Frames with one.
#[derive(Debug, Serialize)]
struct Run {
    budget: String,
    hz: u32,
    frames: u64,
    late_frames: u64,
    late_share: f64,
    over_budget_frames: u64,
    over_time_frames: u64,
    frames_with_unfinished_fovea: u64,
    frames_with_unfinished_tiles: u64,
    lowered_share: f64,
    quality_changes: u64,
    spent_share: Option<f64>,
    #[serde(flatten)]
    interference: Interference,
}

/// Refreshes a second where nothing has been measured yet.
const HZ: u32 = 60;

/// The fastest display.
const MOST_HZ: f64 = 1_000.0;

/// Runs the command.
pub(in crate::cli) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let unlimited = TimeArguments::of(FrameBudget::Off);
    let prepared = arguments.live.prepare(&unlimited)?;
    let interrupt = Interrupt::watched();
    let play = |budget: FrameBudget, hz: u32, frames: u64| {
        let mut counts = Counts {
            seconds: Vec::with_capacity(frames as usize),
            interrupt: &interrupt,
        };
        let settings = SessionSettings {
            budget,
            hz,
            ..prepared.settings(SessionSettings {
                frames: Some(frames),
                ..SessionSettings::default()
            })
        };
        let tracker = arguments.live.listen(&arguments.tracker.spec)?;
        let played = prepared.play(&tracker, &settings, &mut counts, &mut Alone)?;
        Ok::<_, Failure>((played, counts.seconds))
    };
    let (played, seconds) = play(FrameBudget::Off, HZ, arguments.frames.div_ceil(10))?;
    let free = Free {
        frames: played.report.frames,
        steps: played.report.median_steps,
        milliseconds: 1.0e3 * median(seconds),
    };
    // A whole number of refreshes a second, so that a frame's time is one of them.
    let hz = (2.0e3 / free.milliseconds).ceil().clamp(1.0, MOST_HZ);
    let refresh = Duration::from_secs_f64(1.0 / hz);
    let mut runs = Vec::new();
    for budget in [
        FrameBudget::Steps((free.steps / 2).max(1)),
        FrameBudget::Time(refresh),
    ] {
        if !interrupt.came() {
            let (played, _) = play(budget, hz as u32, arguments.frames)?;
            runs.push(Run::new(budget, hz as u32, &played));
        }
    }
    let report = Report::new(arguments, prepared, free, runs);
    print(&report, arguments.json)
}

/// Keeps what frames took, and looks at nothing.
struct Counts<'i> {
    seconds: Vec<f64>,
    interrupt: &'i Interrupt,
}

impl Audience for Counts<'_> {
    fn is_over(&mut self) -> bool {
        self.interrupt.came()
    }

    fn hear(&mut self, record: &FrameRecord) -> bool {
        let microseconds = record.done_us.saturating_sub(record.latch_us);
        self.seconds.push(1.0e-6 * microseconds as f64);
        !self.interrupt.came()
    }
}

impl Run {
    fn new(budget: FrameBudget, hz: u32, played: &Played) -> Self {
        let SessionReport {
            frames,
            late_frames,
            over_budget_frames,
            over_time_frames,
            frames_with_unfinished_fovea,
            frames_with_unfinished_tiles,
            lowered_frames,
            quality_changes,
            spent_share,
            ..
        } = played.report;
        let share = |of: u64| of as f64 / frames.max(1) as f64;
        Self {
            budget: budget.to_string(),
            hz,
            frames,
            late_frames,
            late_share: share(late_frames),
            over_budget_frames,
            over_time_frames,
            frames_with_unfinished_fovea,
            frames_with_unfinished_tiles,
            lowered_share: share(lowered_frames),
            quality_changes,
            spent_share,
            interference: played.interference,
        }
    }
}

impl Report {
    fn new(arguments: &Arguments, prepared: Prepared, free: Free, runs: Vec<Run>) -> Self {
        Self {
            tracker: arguments.tracker.to_string(),
            size: arguments.live.room.size,
            threads: prepared.options.threads,
            simd: prepared.simd().name(),
            lod: arguments.live.lod.name(),
            scene: prepared.scene,
            mesh: prepared.mesh,
            free,
            runs,
        }
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            scene,
            size,
            threads,
            tracker,
            lod,
            free,
            runs,
            ..
        } = self;
        writeln!(
            f,
            "scene {scene}, {size} × {size} pixels a wall, {threads} threads, tracker {tracker}, \
             level of detail {lod}"
        )?;
        write!(
            f,
            "{} frames without a budget: {:.2} ms and {} steps at the median",
            free.frames, free.milliseconds, free.steps
        )?;
        let mut row = |name: &str, value: &dyn Fn(&Run) -> String| {
            write!(f, "\n{name:36}")?;
            runs.iter()
                .try_for_each(|run| write!(f, " {:>16}", value(run)))
        };
        let percent = |share: f64| format!("{:.2}%", 100.0 * share);
        let told = |what: Option<String>| what.unwrap_or_else(|| "-".to_owned());
        row("budget", &|run| run.budget.clone())?;
        row("refreshes a second", &|run| run.hz.to_string())?;
        row("frames", &|run| run.frames.to_string())?;
        row("late", &|run| run.late_frames.to_string())?;
        row("of all", &|run| percent(run.late_share))?;
        row("over their time", &|run| run.over_time_frames.to_string())?;
        row("over their steps", &|run| {
            run.over_budget_frames.to_string()
        })?;
        row("unfinished", &|run| {
            run.frames_with_unfinished_tiles.to_string()
        })?;
        row("unfinished near the line of sight", &|run| {
            run.frames_with_unfinished_fovea.to_string()
        })?;
        row("quality lowered", &|run| percent(run.lowered_share))?;
        row("quality changed", &|run| run.quality_changes.to_string())?;
        row("of the budget spent, at the median", &|run| {
            told(run.spent_share.map(percent))
        })?;
        row("times the processor was taken away", &|run| {
            let switches = run.interference.involuntary_switches;
            told(switches.map(|switches| switches.to_string()))
        })?;
        row("stolen from all processors, seconds", &|run| {
            let stolen = run.interference.stolen_seconds;
            told(stolen.map(|stolen| format!("{stolen:.2}")))
        })
    }
}
