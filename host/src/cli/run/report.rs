//! The report of `shisen run`.

use super::Arguments;
use super::watch::Watched;
use crate::cave::Pictured;
use crate::cli::arguments::filling::Fill;
use crate::cli::arguments::lod::Choice;
use crate::cli::arguments::source::Shown;
use crate::cli::play::{Interference, Played, Prepared};
use crate::cli::prelude::*;
use crate::cli::tracker::names;
use crate::live::{
    Allowance, FrameBudget, Leg, LiveTracker, Quality, SessionReport, Share, SourceState, Summary,
};
use crate::outputs::OutputsReport;
use crate::render::frame_hash;
use hdrhistogram::Histogram;
use std::collections::BTreeMap;

/// The session. Where a key changed the scene or the level of detail, the frames since then.
#[derive(Debug, Serialize, JsonSchema)]
pub(in crate::cli) struct Report {
    #[serde(flatten)]
    surroundings: Surroundings,
    #[serde(flatten)]
    shown: Shown,
    /// SPEC of the tracker.
    tracker: String,
    /// Pixels along each side of a wall whose file does not say.
    size: u32,
    /// Pixels of all screens, for one eye.
    #[serde(skip)]
    pixels: u64,
    /// What follows the gaze: off, paper, paper-ellipse or foveated.
    lod: &'static str,
    /// Refreshes per second.
    hz: u32,
    /// What a frame may take.
    budget: String,
    /// Time that the last frame might take, milliseconds; null without a budget of time.
    budget_ms: Option<f64>,
    /// Steps that a frame may take; null without a budget of steps.
    budget_steps: Option<u64>,
    /// Time of a frame in full, milliseconds; null unless the budget is a part of it.
    plain_ms: Option<f64>,
    /// When a frame takes the gaze.
    latch: &'static str,
    /// How two eyes are shown.
    stereo: Eyes,
    #[serde(flatten)]
    session: SessionReport,
    /// Refreshes without a new frame.
    repeated_refreshes: u64,
    /// Share of frames of lowered quality.
    lowered_share: f64,
    /// Qualities, the best first.
    rungs: Vec<Rung>,
    /// Time from the sample to the wall, milliseconds; null without samples.
    motion_to_wall_ms: Option<Summary>,
    /// Time of each stage from the sample to the wall, milliseconds.
    stages: BTreeMap<&'static str, Option<Summary>>,
    /// Frames by their time in each stage: the end of each class in milliseconds, and its frames.
    /// A class is a fifth longer than the one before; empty ones are left out.
    histograms: BTreeMap<&'static str, Vec<(f64, u64)>>,
}

/// What is known outside the session.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct Surroundings {
    /// What shows where the gaze skips rays, after the last key.
    pub(super) fill: Fill,
    /// Threads that traced.
    pub(super) threads: usize,
    /// The code path taken: avx2 or portable.
    pub(super) simd: &'static str,
    /// Mean part of the visual field that frames show; null without frames.
    pub(super) shown_share: Option<f64>,
    /// What would help, where that is less than a tenth; null elsewhere.
    pub(super) advice: Option<String>,
    /// Samples lost, by the device's count.
    pub(super) lost_samples: u64,
    /// Bytes of the device that belong to no record.
    pub(super) dropped_bytes: u64,
    /// The trackers.
    pub(super) sources: Vec<SourceReport>,
    /// Frames before a key asked for another scene or level of detail.
    pub(super) earlier_frames: u64,
    /// The window, or null.
    pub(super) window: Option<Watched>,
    /// The monitors of --outputs, or null.
    pub(super) outputs: Option<OutputsReport>,
    /// Several machines; null without --cluster or with one process.
    pub(super) cluster: Option<Together>,
    #[serde(flatten)]
    pub(super) interference: Interference,
}

/// One of the trackers.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct SourceReport {
    /// What it is read for: head, gaze, or null for all.
    role: Option<&'static str>,
    /// Samples.
    samples: u64,
    /// Samples lost, by the device's count.
    lost_samples: u64,
    /// Bytes that belong to no record.
    dropped_bytes: u64,
    /// Time from the measurement to the arrival, as far as it is known, milliseconds: median and
    /// 95 %; null without samples.
    delay_ms: Option<[f64; 2]>,
    /// Time since the newest sample at the end, seconds; null without samples.
    silent_s: Option<f64>,
}

impl SourceReport {
    pub(super) fn all(tracker: &LiveTracker) -> Vec<Self> {
        let now = tracker.now();
        let of = |source: SourceState| Self {
            role: source.role.name(),
            samples: source.samples,
            lost_samples: source.counts.lost,
            dropped_bytes: source.counts.dropped_bytes,
            delay_ms: (!source.delay.is_empty()).then(|| {
                [0.5, 0.95].map(|part| source.delay.value_at_quantile(part) as f64 / 1_000.0)
            }),
            silent_s: source.newest.map(|at| f64::from(now.since(at).seconds())),
        };
        tracker.sources().into_iter().map(of).collect()
    }
}

#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct Together {
    /// Number of processes.
    ranks: usize,
    /// Hash of the last frame as all processes render it, without an end of steps.
    frame_hash: String,
    /// Hash of the same frame as the first process renders it alone, or null.
    frame_hash_alone: Option<String>,
    /// Wait of the first process for the others in each frame, microseconds, or null.
    waited_us: Option<Spans>,
    /// Time from the first process that was ready to the last, microseconds, or null.
    spread_us: Option<Spans>,
    /// Time from the first process whose monitors showed a frame to the last, microseconds; null
    /// without --outputs.
    shown_spread_us: Option<Spans>,
}

#[derive(Debug, Serialize, JsonSchema)]
struct Spans {
    /// Median.
    p50: u64,
    /// 95 % took no longer.
    p95: u64,
    /// 99 % took no longer.
    p99: u64,
    /// The longest.
    most: u64,
}

#[derive(Debug, Serialize, JsonSchema)]
struct Eyes {
    /// mono, sequential, side-by-side, top-bottom or anaglyph.
    format: &'static str,
    /// The eyes, the first one first.
    eye_order: Vec<&'static str>,
}

#[derive(Debug, Serialize, JsonSchema)]
struct Rung {
    #[serde(flatten)]
    quality: Quality,
    /// Frames of this quality.
    frames: u64,
}

impl Spans {
    fn new(times: &Histogram<u64>) -> Self {
        Self {
            p50: times.value_at_quantile(0.5),
            p95: times.value_at_quantile(0.95),
            p99: times.value_at_quantile(0.99),
            most: times.max(),
        }
    }
}

impl Together {
    /// `None` with one machine.
    pub(super) fn new(share: Share, played: &Played) -> Option<Self> {
        let report = &played.report;
        (share.ranks() > 1).then(|| Self {
            ranks: share.ranks(),
            frame_hash: hexadecimal(frame_hash(report.hashes.iter().copied())),
            frame_hash_alone: played.alone.map(hexadecimal),
            waited_us: report.waits.as_ref().map(|waits| Spans::new(&waits.waited)),
            spread_us: report.waits.as_ref().map(|waits| Spans::new(&waits.spread)),
            shown_spread_us: (report.waits.as_ref())
                .filter(|waits| !waits.shown.is_empty())
                .map(|waits| Spans::new(&waits.shown)),
        })
    }
}

impl fmt::Display for Together {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (ranks, hash) = (self.ranks, &self.frame_hash);
        write!(f, "{ranks} processes; the last frame ")?;
        write!(f, "of all of them is {hash}")?;
        match &self.frame_hash_alone {
            Some(alone) if alone == hash => f.write_str(", the same as one alone")?,
            Some(alone) => write!(f, ", and that of one alone is {alone}")?,
            None => {}
        }
        for (text, spans) in [
            ("the first waited for the others", &self.waited_us),
            ("the last was ready after the first by", &self.spread_us),
            (
                "the last showed it after the first by",
                &self.shown_spread_us,
            ),
        ] {
            if let Some(Spans { p50, p95, .. }) = spans {
                write!(f, "; {text} {p50} µs (median), {p95} µs (95%)")?;
            }
        }
        Ok(())
    }
}

impl Report {
    pub(super) fn new(
        surroundings: Surroundings,
        arguments: &Arguments,
        prepared: &Prepared,
        session: SessionReport,
    ) -> Self {
        let part = |count: u64| count as f64 / (session.frames.max(1)) as f64;
        let depth = arguments.live.tracing.depth;
        let eyes = arguments.stereo.eye_order().iter();
        let legs = || Leg::ALL.into_iter().map(|leg| (leg.name(), leg));
        let latencies = &session.latencies;
        let classes = |leg| latencies.few_classes(leg).collect();
        let foveated = arguments.live.lod.is_foveated();
        let captures = surroundings.fill == Fill::Capture;
        Self {
            surroundings,
            shown: prepared.shown.clone(),
            tracker: names(&arguments.tracker),
            size: arguments.live.room.size,
            pixels: prepared.cave.pictured().map(Pictured::pixels).sum(),
            lod: prepared.arguments.lod.name(),
            hz: prepared.hz,
            budget: prepared.budget.to_string(),
            budget_ms: match session.allowance {
                Allowance::Time(time) => Some(1.0e3 * time.as_secs_f64()),
                Allowance::Unlimited | Allowance::Steps(_) => None,
            },
            // The allowance is this machine's; the budget is that of all machines.
            budget_steps: match prepared.budget {
                FrameBudget::Steps(steps) => Some(steps),
                _ => None,
            },
            plain_ms: session.plain_seconds.map(|seconds| 1.0e3 * seconds),
            latch: arguments.latch.name(),
            stereo: Eyes {
                format: arguments.stereo.name(),
                eye_order: eyes.map(|eye| eye.name()).collect(),
            },
            repeated_refreshes: session.refreshes - session.frames,
            lowered_share: part(session.lowered_frames),
            rungs: Quality::LADDER
                .iter()
                .zip(session.rungs)
                .map(|(quality, frames)| {
                    let depth = quality.depth.min(depth);
                    let quality = if foveated {
                        // All faces and the whole field, in larger detail.
                        Quality {
                            depth,
                            sampling: quality.sampling,
                            ..Quality::FULL
                        }
                    } else {
                        Quality {
                            depth,
                            sampling: 1.0,
                            capture: if captures { quality.capture } else { 1.0 },
                            ..*quality
                        }
                    };
                    Rung { quality, frames }
                })
                .collect(),
            motion_to_wall_ms: latencies.summary(Leg::MotionToWall),
            stages: legs()
                .map(|(name, leg)| (name, latencies.summary(leg)))
                .collect(),
            histograms: legs().map(|(name, leg)| (name, classes(leg))).collect(),
            session,
        }
    }

    fn fmt_budget(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "budget {}", self.budget)?;
        if let Some(plain) = self.plain_ms {
            write!(f, " (a frame in full takes {plain:.2} ms")?;
            if let Some([least, most]) = self.session.plain_parts {
                write!(f, ", a budget {least:.2} to {most:.2} times that")?;
            }
            f.write_str(")")?;
        }
        if let Some(time) = self.budget_ms {
            write!(f, ", {time:.2} ms in the last frame")?;
        }
        let steps = self.session.median_steps;
        writeln!(f, "; the median frame took {steps} steps")
    }

    fn fmt_rungs(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for rung in self.rungs.iter().filter(|rung| rung.frames > 0) {
            let Rung { frames, quality } = rung;
            let (depth, faces) = (quality.depth, quality.faces);
            let (field, centre) = (100.0 * quality.field, 100.0 * quality.centre);
            write!(f, "  {frames:6} frames: {depth} bounces")?;
            if self.lod == Choice::Foveated.name() {
                if quality.sampling > 1.0 {
                    write!(f, ", {} times as coarse as the eye sees", quality.sampling)?;
                } else {
                    f.write_str(", as fine as the eye sees")?;
                }
            } else {
                let faces = 100.0 * faces;
                write!(
                    f,
                    ", {faces:.0}% of the meshes' detail, {field:.0}% of the field, "
                )?;
                write!(f, "{centre:.0}% of its centre")?;
            }
            if quality.capture < 1.0 {
                write!(f, ", {:.0}% of the capture anew", 100.0 * quality.capture)?;
            }
            writeln!(f)?;
        }
        Ok(())
    }

    fn fmt_samples(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let session = &self.session;
        write!(f, "the tracker sent {} samples", session.samples)?;
        for (count, what) in [
            (session.passed_over_samples, "were not used: too many came"),
            (self.surroundings.lost_samples, "were lost before they came"),
        ] {
            if count > 0 {
                write!(f, ", {count} {what}")?;
            }
        }
        let sources = &self.surroundings.sources;
        for source in sources.iter().filter(|_| sources.len() > 1) {
            let (role, samples) = (source.role.unwrap_or("tracker"), source.samples);
            write!(f, ", {samples} of the {role}")?;
            if let Some(silent) = source.silent_s.filter(|silent| *silent > 1.0) {
                write!(f, " (the last {silent:.1} s before the end)")?;
            }
        }
        let frames = session.frames_without_gaze;
        if frames > 0 {
            write!(f, "; {} followed none of them: ", counted(frames, "frame"))?;
            f.write_str("none was recent enough for the time at which the frame was shown. ")?;
            f.write_str(
                "Such frames have no latency; with --hz or --budget frames take less time",
            )?;
        }
        writeln!(f)
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let threads = counted(self.surroundings.threads as u64, "thread");
        let (shown, pixels, tracker) = (&self.shown, self.pixels, &self.tracker);
        write!(f, "{shown}, {pixels} pixels for each eye, ")?;
        let (hz, lod) = (self.hz, self.lod);
        write!(f, "{threads}, tracker {tracker}, {hz} Hz, ")?;
        writeln!(f, "level of detail {lod}")?;
        self.fmt_budget(f)?;
        let one = &self.session;
        let frames = counted(one.frames, "frame");
        let (seconds, refreshes, late) = (one.seconds, one.refreshes, one.late_frames);
        let (time, steps) = (one.over_time_frames, one.over_budget_frames);
        write!(
            f,
            "{frames} in {seconds:.1} s at {refreshes} refreshes: {late} late, "
        )?;
        writeln!(f, "{time} over their time, {steps} over their steps")?;
        let unfinished = one.frames_with_unfinished_tiles;
        if unfinished > 0 {
            let near = one.frames_with_unfinished_fovea;
            let unfinished = counted(unfinished, "frame");
            write!(f, "part of the picture is missing in {unfinished}, ")?;
            writeln!(f, "in {near} of them where the viewer looks")?;
        }
        let (lowered, changes) = (100.0 * self.lowered_share, one.quality_changes);
        write!(f, "quality lowered in {lowered:.1}% of the frames, ")?;
        writeln!(f, "changed {}", counted(changes, "time"))?;
        if let Some(spent) = one.spent_share.map(|share| 100.0 * share) {
            writeln!(f, "the median frame spent {spent:.0}% of its budget")?;
        }
        if let Some(share) = one.needed_share {
            let needed = match share {
                ..0.01 => "less than 1% of".to_owned(),
                ..2.0 => format!("about {:.0}% of", 100.0 * share),
                ..9.95 => format!("about {share:.1} times"),
                _ => format!("about {share:.0} times"),
            };
            writeln!(f, "a frame of full quality needs {needed} this budget")?;
            if share <= 1.0 && self.lowered_share == 0.0 {
                writeln!(f, "the budget lowered nothing")?;
            }
        }
        self.fmt_samples(f)?;
        self.fmt_rungs(f)?;
        if let Some(together) = &self.surroundings.cluster {
            writeln!(f, "{together}")?;
        }
        if let Some(outputs) = &self.surroundings.outputs {
            writeln!(f, "{outputs}")?;
        }
        write!(
            f,
            "{:20} {:>9} {:>9} {:>9} {:>9}",
            "milliseconds", "median", "95%", "99%", "longest"
        )?;
        for leg in Leg::ALL {
            if let Some(Some(time)) = self.stages.get(leg.name()) {
                let name = leg.name().replace('_', " ");
                let Summary {
                    p50,
                    p95,
                    p99,
                    most,
                    ..
                } = time;
                write!(f, "\n{name:20} {p50:9.3} {p95:9.3} {p99:9.3} {most:9.3}")?;
            }
        }
        let Interference {
            involuntary_switches,
            stolen_seconds,
        } = self.surroundings.interference;
        if let Some(switches) = involuntary_switches {
            write!(f, "\nthe system took the processor away {switches} times")?;
        }
        if let Some(stolen) = stolen_seconds {
            write!(f, "\nthe hypervisor took {stolen:.2} s of processor time")?;
        }
        Ok(())
    }
}
