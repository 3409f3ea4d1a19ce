//! `shisen-evidence bench budget`: frames at half of what they take.

use super::{Surroundings, print};
use crate::table::Table;
use clap::Args;
use schemars::JsonSchema;
use serde::Serialize;
use shisen::cli::numbers::whole;
use shisen::cli::output::failure::Failure;
use shisen::cli::play::{Interference, LiveArguments, Played, TimeArguments, live_lod};
use shisen::cli::tracker::{Interrupt, TrackerName};
use shisen::live::quantiles::median;
use shisen::live::{Display, FrameBudget, FrameRecord, SessionSettings, SingleMachine};
use std::time::Duration;

/// Frames with half of the budget they need: are they in time, and complete where the viewer looks?
///
/// Frames follow a tracker as with `shisen run`: first a tenth of them without a budget, for
/// the medians; then all with half of the median steps, and all with half of the median time,
/// a frame for each refresh of a display that is as fast as that. Each run begins with the
/// tracker's first sample.
#[derive(Debug, Args)]
#[command(mut_arg("lod", live_lod))]
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

/// Frames at half of what they take.
#[derive(Debug, Serialize, JsonSchema)]
pub(in crate::cli) struct Report {
    #[serde(flatten)]
    surroundings: Surroundings,
    /// SPEC of the tracker.
    tracker: String,
    /// Frames without a budget.
    free: Free,
    /// Runs with a budget of steps and with one of time.
    runs: Vec<Run>,
}

#[derive(Debug, Serialize, JsonSchema)]
struct Free {
    /// Number of frames.
    frames: u64,
    /// Steps of a frame, the median.
    steps: u64,
    /// Time from taking the gaze to the last pixel, milliseconds, the median.
    milliseconds: f64,
}

#[derive(Debug, Serialize, JsonSchema)]
struct Run {
    /// What a frame may take.
    budget: String,
    /// Refreshes per second. A budget of time is one refresh, at most half of the median time.
    hz: u32,
    /// Number of frames.
    frames: u64,
    /// Frames that were not there at their refresh.
    late_frames: u64,
    /// Share of late frames.
    late_share: f64,
    /// Frames with more steps than a budget of steps allows.
    over_budget_frames: u64,
    /// Frames that took longer than a budget of time.
    over_time_frames: u64,
    /// Frames with an unfinished tile within 5° of the line of sight.
    frames_with_unfinished_fovea: u64,
    /// Frames with an unfinished tile.
    frames_with_unfinished_tiles: u64,
    /// Share of frames of lowered quality.
    lowered_share: f64,
    /// How often the quality changed.
    quality_changes: u64,
    /// Share of the budget that a frame spent, the median; null without a budget.
    spent_share: Option<f64>,
    #[serde(flatten)]
    interference: Interference,
}

/// Refreshes a second of the frames without a budget.
const HZ: u32 = 60;

/// Refreshes a second of the fastest display.
const MOST_HZ: f64 = 1_000.0;

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
        let tracker = arguments
            .live
            .listen(std::slice::from_ref(&arguments.tracker), &prepared.cave)?;
        let played = prepared.play(&tracker, &settings, &mut counts, &mut SingleMachine)?;
        Ok::<_, Failure>((played, counts.seconds))
    };
    let (played, seconds) = play(FrameBudget::Off, HZ, arguments.frames.div_ceil(10))?;
    let steps = played.report.median_steps;
    let milliseconds = 1.0e3 * median(seconds);
    let free = played.report.frames;
    // A whole number of refreshes a second, so that a frame's time is one of them.
    let hz = (2.0e3 / milliseconds).ceil().clamp(1.0, MOST_HZ);
    let refresh = Duration::from_secs_f64(1.0 / hz);
    let mut runs = Vec::new();
    for budget in [
        FrameBudget::Steps((steps / 2).max(1)),
        FrameBudget::Time(refresh),
    ] {
        if !interrupt.came() {
            let (played, _) = play(budget, hz as u32, arguments.frames)?;
            runs.push(described(budget, hz as u32, &played));
        }
    }
    let report = Report {
        surroundings: Surroundings::new(&prepared),
        tracker: arguments.tracker.to_string(),
        free: Free {
            frames: free,
            steps,
            milliseconds,
        },
        runs,
    };
    let Surroundings {
        scene,
        size,
        threads,
        lod,
        ..
    } = &report.surroundings;
    let said = format!(
        "scene {scene}, {size} × {size} pixels a wall, {threads} threads, tracker {}, level of \
         detail {lod}\n{free} frames without a budget: {milliseconds:.2} ms and {steps} steps at \
         the median\n{}",
        report.tracker,
        table(&report.runs)
    );
    print(arguments.json, &report, &said)
}

fn table(runs: &[Run]) -> Table<'_, Run> {
    Table::new(runs)
        .text("budget", |one| one.budget.clone())
        .count("refreshes a second", |one| one.hz.into())
        .count("frames", |one| one.frames)
        .count("late", |one| one.late_frames)
        .number("late, %", 2, |one| 1e2 * one.late_share)
        .count("over their time", |one| one.over_time_frames)
        .count("over their steps", |one| one.over_budget_frames)
        .count("unfinished", |one| one.frames_with_unfinished_tiles)
        .count("unfinished near the line of sight", |one| {
            one.frames_with_unfinished_fovea
        })
        .number("quality lowered, %", 2, |one| 1e2 * one.lowered_share)
        .count("quality changed", |one| one.quality_changes)
        .number("of the budget spent, at the median, %", 2, |one| {
            one.spent_share.map(|share| 1e2 * share)
        })
        .number("times the processor was taken away", 0, |one| {
            let switches = one.interference.involuntary_switches;
            switches.map(|count| count as f64)
        })
        .number("processor time the hypervisor took, seconds", 2, |one| {
            one.interference.stolen_seconds
        })
}

struct Counts<'i> {
    seconds: Vec<f64>,
    interrupt: &'i Interrupt,
}

impl Display for Counts<'_> {
    fn is_over(&mut self) -> bool {
        self.interrupt.came()
    }

    fn after(&mut self, record: &FrameRecord) -> bool {
        let microseconds = record.done_us.saturating_sub(record.latch_us);
        self.seconds.push(1.0e-6 * microseconds as f64);
        !self.interrupt.came()
    }
}

fn described(budget: FrameBudget, hz: u32, played: &Played) -> Run {
    let report = &played.report;
    let share = |part: u64| part as f64 / report.frames.max(1) as f64;
    Run {
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
