//! `shisen-evidence bench budget`: frames at half of what they take.

use super::{list, numbers, print, text};
use crate::table::Table;
use clap::Args;
use serde_json::{Value, json};
use shisen::cli::numbers::whole;
use shisen::cli::output::failure::Failure;
use shisen::cli::play::{LiveArguments, Played, TimeArguments, paper_lod};
use shisen::cli::tracker::{Interrupt, TrackerName};
use shisen::live::quantiles::median;
use shisen::live::{Display, FrameBudget, FrameRecord, SessionSettings, SingleMachine};
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
        let tracker = arguments.live.listen(&arguments.tracker.spec)?;
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
    let report = json!({
        "scene": prepared.scene,
        "mesh": prepared.mesh,
        "tracker": arguments.tracker.to_string(),
        "size": arguments.live.room.size,
        "threads": prepared.options.threads,
        "simd": prepared.simd().name(),
        "lod": arguments.live.lod.name(),
        "free": { "frames": free, "steps": steps, "milliseconds": milliseconds },
        "runs": runs,
    });
    let [scene, tracker, lod] = ["scene", "tracker", "lod"].map(|key| text(&report, key));
    let said = format!(
        "scene {scene}, {0} × {0} pixels a wall, {1} threads, tracker {tracker}, level of detail \
         {lod}\n{free} frames without a budget: {milliseconds:.2} ms and {steps} steps at the \
         median\n{2}",
        report["size"],
        report["threads"],
        table(list(&report, "runs"))
    );
    print(arguments.json, &report, &said)
}

fn table(runs: &[Value]) -> Table<'_, Value> {
    numbers(
        Table::new(runs).text("budget", |run| text(run, "budget")),
        &[
            ("refreshes a second", "/hz", 1.0, 0),
            ("frames", "/frames", 1.0, 0),
            ("late", "/late_frames", 1.0, 0),
            ("late, %", "/late_share", 1e2, 2),
            ("over their time", "/over_time_frames", 1.0, 0),
            ("over their steps", "/over_budget_frames", 1.0, 0),
            ("unfinished", "/frames_with_unfinished_tiles", 1.0, 0),
            (
                "unfinished near the line of sight",
                "/frames_with_unfinished_fovea",
                1.0,
                0,
            ),
            ("quality lowered, %", "/lowered_share", 1e2, 2),
            ("quality changed", "/quality_changes", 1.0, 0),
            (
                "of the budget spent, at the median, %",
                "/spent_share",
                1e2,
                2,
            ),
            (
                "times the processor was taken away",
                "/involuntary_switches",
                1.0,
                0,
            ),
            (
                "processor time the hypervisor took, seconds",
                "/stolen_seconds",
                1.0,
                2,
            ),
        ],
    )
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

fn described(budget: FrameBudget, hz: u32, played: &Played) -> Value {
    let report = &played.report;
    let share = |part: u64| part as f64 / report.frames.max(1) as f64;
    json!({
        "budget": budget.to_string(),
        "hz": hz,
        "frames": report.frames,
        "late_frames": report.late_frames,
        "late_share": share(report.late_frames),
        "over_budget_frames": report.over_budget_frames,
        "over_time_frames": report.over_time_frames,
        "frames_with_unfinished_fovea": report.frames_with_unfinished_fovea,
        "frames_with_unfinished_tiles": report.frames_with_unfinished_tiles,
        "lowered_share": share(report.lowered_frames),
        "quality_changes": report.quality_changes,
        "spent_share": report.spent_share,
        "involuntary_switches": played.interference.involuntary_switches,
        "stolen_seconds": played.interference.stolen_seconds,
    })
}
