//! `shisen-evidence bench budget`: frames at half of what they take.

use crate::table::Table;
use clap::Args;
use serde::Serialize;
use shisen::cli::arguments::whole;
use shisen::cli::output::failure::Failure;
use shisen::cli::output::print;
use shisen::cli::play::{Audience, Interference, LiveArguments, Played, TimeArguments, paper_lod};
use shisen::cli::tracker::{Interrupt, TrackerName};
use shisen::live::quantiles::median;
use shisen::live::{Alone, FrameBudget, FrameRecord, SessionSettings};
use std::fmt;
use std::time::Duration;

/// Frames at half of what they take without a budget: in time, and whole where one looks
///
/// Frames follow a tracker as with `shisen run`: first a tenth of them without a budget, for
/// the medians; then all with half of the median steps, and all with half of the median time,
/// a frame for each refresh of a display that is as fast as that. Each run begins with the
/// tracker's first sample.
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
/// `stolen_seconds` (processor time that the hypervisor took; both null where the system
/// does not say).
#[derive(Debug, Args)]
#[command(mut_arg("lod", paper_lod))]
pub(in crate::cli) struct Arguments {
    #[command(flatten)]
    live: LiveArguments,
    /// The tracker, as for `shisen run`
    #[arg(long, value_name = "SPEC", default_value = "mock")]
    tracker: TrackerName,
    /// Frames with each budget
    #[arg(long, value_name = "N", default_value = "10000",
          value_parser = whole::<u64>(10..=1_000_000))]
    frames: u64,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

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

/// Frames with a budget.
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

/// Refreshes a second of the frames without a budget.
const HZ: u32 = 60;

/// Refreshes a second of the fastest display.
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
    let report = Report {
        tracker: arguments.tracker.to_string(),
        size: arguments.live.room.size,
        threads: prepared.options.threads,
        simd: prepared.simd().name(),
        lod: arguments.live.lod.name(),
        scene: prepared.scene,
        mesh: prepared.mesh,
        free,
        runs,
    };
    print(&report, arguments.json)
}

/// Keeps the seconds of frames.
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
        let report = &played.report;
        let share = |part: u64| part as f64 / report.frames.max(1) as f64;
        Self {
            budget: budget.to_string(),
            hz,
            frames: report.frames,
            late_frames: report.late_frames,
            late_share: share(report.late_frames),
            over_budget_frames: report.over_budget_frames,
            over_time_frames: report.over_time_frames,
            frames_with_unfinished_fovea: report.frames_with_unfinished_fovea,
            frames_with_unfinished_tiles: report.frames_with_unfinished_tiles,
            lowered_share: share(report.lowered_frames),
            quality_changes: report.quality_changes,
            spent_share: report.spent_share,
            interference: played.interference,
        }
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (scene, size, threads) = (&self.scene, self.size, self.threads);
        write!(
            f,
            "scene {scene}, {size} × {size} pixels a wall, {threads} threads, "
        )?;
        let (tracker, lod, free) = (&self.tracker, self.lod, &self.free);
        writeln!(f, "tracker {tracker}, level of detail {lod}")?;
        writeln!(
            f,
            "{} frames without a budget: {:.2} ms and {} steps at the median",
            free.frames, free.milliseconds, free.steps
        )?;
        let table = Table::new(&self.runs)
            .text("budget", |run| run.budget.clone())
            .count("refreshes a second", |run| run.hz.into())
            .count("frames", |run| run.frames)
            .count("late", |run| run.late_frames)
            .number("late, %", 2, |run| Some(1e2 * run.late_share))
            .count("over their time", |run| run.over_time_frames)
            .count("over their steps", |run| run.over_budget_frames)
            .count("unfinished", |run| run.frames_with_unfinished_tiles)
            .count("unfinished near the line of sight", |run| {
                run.frames_with_unfinished_fovea
            })
            .number("quality lowered, %", 2, |run| Some(1e2 * run.lowered_share))
            .count("quality changed", |run| run.quality_changes)
            .number("of the budget spent, at the median, %", 2, |run| {
                Some(1e2 * run.spent_share?)
            })
            .number("times the processor was taken away", 0, |run| {
                Some(run.interference.involuntary_switches? as f64)
            })
            .number("processor time the hypervisor took, seconds", 2, |run| {
                run.interference.stolen_seconds
            });
        write!(f, "{table}")
    }
}
