//! `shisen-evidence bench latency`: from the eye's movement to the wall.

mod files;

use super::{Surroundings, print};
use crate::table::Table;
use clap::builder::ArgPredicate;
use clap::{Arg, Args};
use schemars::JsonSchema;
use serde::Serialize;
use shisen::cli::arguments::span;
use shisen::cli::numbers::whole;
use shisen::cli::output::failure::Failure;
use shisen::cli::output::picture_files::make_writable;
use shisen::cli::play::{Interference, LiveArguments, Played, Prepared, TimeArguments, live_lod};
use shisen::cli::tracker::{Interrupt, TrackerName, protocol, require_serial};
use shisen::live::{
    Display, FrameRecord, Latch, Leg, SessionReport, SessionSettings, SingleMachine, Summary,
};
use shisen::tracker::pty::Pty;
use shisen::tracker::{MockSpec, ProtocolSpec, Spec, TrackerKind, serve, simulated};
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// How long it takes from a movement of the eye to the wall
///
/// A simulated tracker behind a pseudo-terminal is read like one behind a serial port,
/// at each rate; frames follow it as in `shisen run`, with the gaze
/// taken at once and as late as the last frames allow, in turns.
#[derive(Debug, Args)]
#[command(mut_arg("lod", live_lod), mut_arg("budget", in_half_a_refresh))]
pub(in crate::cli) struct Arguments {
    #[command(flatten)]
    live: LiveArguments,
    #[command(flatten)]
    time: TimeArguments,
    /// What the tracker speaks: a protocol as for `shisen tracker serve`
    #[arg(long = "as", value_name = "PROTOCOL", default_value = "link", value_parser = protocol)]
    protocol: ProtocolSpec,
    /// Samples per second of the tracker
    #[arg(long, value_name = "HZ,…", value_delimiter = ',', default_value = "60,250,1000",
          value_parser = whole::<u64>(60..=10_000))]
    rates: Vec<u64>,
    /// Time of each run
    #[arg(long, value_name = "S", default_value = "10",
          value_parser = span)]
    seconds: Duration,
    /// Write each frame's times, the histograms and charts to this folder; made where it
    /// does not exist
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

/// Returns the argument `--budget`. By default frames end well before their refresh on any machine,
/// which leaves time to wait for the newest sample.
fn in_half_a_refresh(budget: Arg) -> Arg {
    budget
        .default_value_if("hz", ArgPredicate::IsPresent, None::<&str>)
        .default_value("8ms")
        .hide_default_value(true)
        .help(
            "What a frame may take: 33ms, 2000000steps (for the same gazes the same frames), paper \
             (the seconds of its Table 2), paper-scaled (the part of a full frame's time that level \
             of detail takes in Table 2) or off [default: a refresh of --hz, or \
             else 8ms, half of one at 60 Hz]",
        )
}

/// How long it takes from a movement of the eye to the wall.
#[derive(Debug, Serialize, JsonSchema)]
pub(in crate::cli) struct Report {
    #[serde(flatten)]
    surroundings: Surroundings,
    /// Refreshes per second.
    hz: u32,
    /// What a frame may take.
    budget: String,
    /// What the tracker speaks.
    protocol: &'static str,
    /// Time of each run, seconds.
    seconds: f64,
    /// Runs at each rate with each latch.
    runs: Vec<Run>,
    /// What the late latch gains at each rate.
    gains: Vec<Gain>,
    /// Paths of the files of --out: frames.csv, all times of each frame; latency.csv, the
    /// histograms of all legs; latency.svg, motion to wall; legs.svg, all legs at the highest
    /// rate, taken late.
    files: Vec<String>,
}

#[derive(Debug, Serialize, JsonSchema)]
struct Gain {
    /// Samples per second of the tracker.
    tracker_hz: u64,
    /// Time from the movement to the wall by which the late latch is ahead at the median,
    /// milliseconds.
    motion_to_wall_ms: f64,
}

#[derive(Debug, Serialize, JsonSchema)]
struct Run {
    /// Samples per second of the tracker.
    tracker_hz: u64,
    /// When a frame takes the gaze: early or late.
    latch: &'static str,
    /// Number of frames.
    frames: u64,
    /// Frames that were not there at their refresh.
    late_frames: u64,
    /// Samples since the line was opened.
    samples: u64,
    /// Samples that were not used because there were too many.
    passed_over_samples: u64,
    /// Time of each stage from the sample to the wall, milliseconds; null without samples.
    stages: BTreeMap<&'static str, Option<Summary>>,
    #[serde(flatten)]
    interference: Interference,
    #[serde(skip)]
    report: SessionReport,
    #[serde(skip)]
    records: Vec<FrameRecord>,
}

/// When a frame takes the gaze, and its name in reports.
const LATCHES: [(Latch, &str); 2] = [(Latch::Early, "early"), (Latch::Late, "late")];

pub(in crate::cli) fn run(arguments: &Arguments) -> Result<(), Failure> {
    require_serial(&arguments.protocol)?;
    let prepared = arguments.live.prepare(&arguments.time)?;
    if let Some(folder) = &arguments.out {
        make_writable(folder)?;
    }
    let interrupt = Interrupt::watched();
    let mut runs = Vec::new();
    for &rate in &arguments.rates {
        if !interrupt.came() {
            runs.extend(arguments.at_rate(rate, &prepared, &interrupt)?);
        }
    }
    let gains = arguments.rates.iter().filter_map(|&rate| {
        let times = |latch: &str| {
            let mut runs = runs.iter();
            let run = runs.find(|run| run.tracker_hz == rate && run.latch == latch)?;
            run.report.latencies.summary(Leg::MotionToWall)
        };
        let ahead = times("early")?.p50 - times("late")?.p50;
        Some(Gain {
            tracker_hz: rate,
            motion_to_wall_ms: ahead,
        })
    });
    let gains: Vec<_> = gains.collect();
    let files = match &arguments.out {
        Some(folder) => files::write(folder, &runs).map_err(Failure::from_error)?,
        None => Vec::new(),
    };
    let (size, threads) = (arguments.live.room.size, prepared.options.threads);
    let (hz, budget) = (prepared.hz, prepared.budget.to_string());
    let (scene, protocol) = (&prepared.shown.scene, arguments.protocol.name());
    let mut table =
        Table::new(&runs).text("", |run| format!("{} Hz {}", run.tracker_hz, run.latch));
    for leg in Leg::ALL {
        table = table.text(leg.name().replace('_', " "), |run| {
            let found = run.report.latencies.summary(leg);
            found.map_or("-".to_owned(), |times| {
                format!("{:.2} ({:.2})", times.p50, times.p99)
            })
        });
    }
    table = table.text("late frames", |run| {
        format!("{} of {}", run.late_frames, run.frames)
    });
    let text = format!(
        "scene {scene}, {size} × {size} pixels a wall, {threads} threads, {hz} Hz, budget {budget}, \
         tracker {protocol} on a line; milliseconds at the median (and 99%)\n{table}"
    );
    let ahead = gains
        .iter()
        .map(|gain| (gain.tracker_hz, gain.motion_to_wall_ms))
        .map(|(rate, ahead)| format!("The late latch is ahead by {ahead:.2} ms at {rate} Hz."));
    let lines: Vec<String> = [text]
        .into_iter()
        .chain(ahead)
        .chain(files.clone())
        .collect();
    let report = Report {
        surroundings: Surroundings::new(&prepared),
        hz,
        budget,
        protocol,
        seconds: arguments.seconds.as_secs_f64(),
        runs,
        gains,
        files,
    };
    print(arguments.json, &report, &lines.join("\n"))
}

impl Arguments {
    /// Returns both latches at a rate of the tracker.
    fn at_rate(
        &self,
        rate: u64,
        prepared: &Prepared,
        interrupt: &Interrupt,
    ) -> Result<Vec<Run>, Failure> {
        let folder = tempfile::tempdir().map_err(Failure::from_error)?;
        let path = folder.path().join("tracker");
        let mut line = Pty::open(&path).map_err(Failure::from_error)?;
        let spec = MockSpec {
            rate: rate as u32,
            ..MockSpec::default()
        };
        let source = simulated(&spec)?;
        let over = AtomicBool::new(false);
        std::thread::scope(|scope| {
            let served = scope.spawn(|| {
                let mut goes_on = |_| !over.load(Ordering::Relaxed);
                serve::serve(&mut line, source, &self.protocol, None, &mut goes_on)
            });
            let (path, late) = (path.display(), spec.delay.0 as f64 * 1.0e-6);
            let line = format!("serial:{path}?protocol={}&delay={late}", self.protocol);
            let runs = self.runs(rate, &line, prepared, interrupt);
            over.store(true, Ordering::Relaxed);
            match served.join() {
                Ok(Err(broken)) => Err(Failure::from_error(broken)),
                Ok(Ok(())) | Err(_) => runs,
            }
        })
    }

    fn runs(
        &self,
        rate: u64,
        line: &str,
        prepared: &Prepared,
        interrupt: &Interrupt,
    ) -> Result<Vec<Run>, Failure> {
        let mut tracker = TrackerName::from(line.parse::<Spec>()?);
        if let TrackerKind::Serial(line) = &mut tracker.spec.kind {
            line.protocol = self.protocol.clone();
        }
        let tracker = self.live.listen(&[tracker], &prepared.cave)?;
        let mut runs = Vec::new();
        let most = match &self.out {
            Some(_) => (self.seconds.as_secs_f64() * f64::from(prepared.hz)) as usize + 16,
            None => 0,
        };
        for (latch, name) in LATCHES {
            let settings = prepared.settings(SessionSettings {
                latch,
                ..SessionSettings::default()
            });
            let mut clock = StopWatch {
                span: self.seconds,
                end: None,
                interrupt,
                records: Vec::with_capacity(most),
            };
            let Played {
                report,
                interference,
                ..
            } = prepared.play(&tracker, &settings, &mut clock, &mut SingleMachine)?;
            runs.push(Run {
                tracker_hz: rate,
                latch: name,
                frames: report.frames,
                late_frames: report.late_frames,
                samples: report.samples,
                passed_over_samples: report.passed_over_samples,
                stages: Leg::ALL
                    .into_iter()
                    .map(|leg| (leg.name(), report.latencies.summary(leg)))
                    .collect(),
                interference,
                report,
                records: clock.records,
            });
        }
        Ok(runs)
    }
}

/// Keeps the times of frames, and ends after a while.
struct StopWatch<'i> {
    span: Duration,
    end: Option<Instant>,
    interrupt: &'i Interrupt,
    /// Allocated for all frames beforehand.
    records: Vec<FrameRecord>,
}

impl Display for StopWatch<'_> {
    fn is_over(&mut self) -> bool {
        self.interrupt.came()
    }

    fn after(&mut self, record: &FrameRecord) -> bool {
        if self.records.len() < self.records.capacity() {
            self.records.push(record.clone());
        }
        let now = Instant::now();
        now < *self.end.get_or_insert(now + self.span) && !self.interrupt.came()
    }
}
