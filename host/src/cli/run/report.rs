//! What `shisen run` says at its end.

use super::watched::Watched;
use super::{Arguments, FillName, LatchName};
use crate::cli::output::counted;
use crate::cli::play::{Interference, Played, Prepared};
use crate::live::{
    Allowance, FrameBudget, Leg, Quality, SessionReport, SessionSettings, Share, Summary,
};
use crate::render::frame_hash;
use hdrhistogram::Histogram;
use serde::Serialize;
use std::collections::BTreeMap;
use std::fmt;

/// The report.
#[derive(Debug, Serialize)]
pub(super) struct Report {
    #[serde(flatten)]
    around: Around,
    scene: String,
    mesh: Option<String>,
    tracker: String,
    size: u32,
    lod: &'static str,
    hz: u32,
    budget: String,
    budget_ms: Option<f64>,
    budget_steps: Option<u64>,
    plain_ms: Option<f64>,
    plain_parts: Option<[f64; 2]>,
    latch: &'static str,
    stereo: Eyes,
    seconds: f64,
    frames: u64,
    refreshes: u64,
    repeated_refreshes: u64,
    late_frames: u64,
    over_budget_frames: u64,
    over_time_frames: u64,
    frames_with_unfinished_fovea: u64,
    frames_with_unfinished_tiles: u64,
    lowered_share: f64,
    spent_share: Option<f64>,
    needed_share: Option<f64>,
    quality_changes: u64,
    rungs: Vec<Rung>,
    blind_frames: u64,
    frames_without_gaze: u64,
    median_steps: u64,
    samples: u64,
    passed_over_samples: u64,
    motion_to_wall_ms: Option<Summary>,
    stages: BTreeMap<&'static str, Option<Summary>>,
    histograms: BTreeMap<&'static str, Vec<(f64, u64)>>,
}

/// What a session does not know of itself.
#[derive(Debug, Serialize)]
pub(super) struct Around {
    /// The last that a key asked for, if any did.
    pub(super) fill: FillName,
    pub(super) threads: usize,
    pub(super) simd: &'static str,
    pub(super) lost_samples: u64,
    pub(super) dropped_bytes: u64,
    pub(super) earlier_frames: u64,
    pub(super) window: Option<Watched>,
    pub(super) cluster: Option<Together>,
    #[serde(flatten)]
    pub(super) interference: Interference,
}

/// What came of several machines.
#[derive(Debug, Serialize)]
pub(super) struct Together {
    ranks: usize,
    frame_hash: String,
    frame_hash_alone: Option<String>,
    waited_us: Option<Spans>,
    spread_us: Option<Spans>,
}

/// How long something took in each frame: microseconds.
#[derive(Debug, Serialize)]
struct Spans {
    p50: u64,
    p95: u64,
    p99: u64,
    most: u64,
}

impl Spans {
    fn of(times: &Histogram<u64>) -> Self {
        Self {
            p50: times.value_at_quantile(0.5),
            p95: times.value_at_quantile(0.95),
            p99: times.value_at_quantile(0.99),
            most: times.max(),
        }
    }
}

impl Together {
    /// `None` of one machine.
    pub(super) fn of(share: Share, played: &Played) -> Option<Self> {
        if share.ranks() == 1 {
            return None;
        }
        let of = |hash: u64| format!("{hash:016x}");
        Some(Self {
            ranks: share.ranks(),
            frame_hash: of(frame_hash(played.report.hashes.iter().copied())),
            frame_hash_alone: played.alone.map(of),
            waited_us: played.report.waited.as_ref().map(Spans::of),
            spread_us: played.report.spread.as_ref().map(Spans::of),
        })
    }
}

impl fmt::Display for Together {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{} processes; the last frame of all of them is {}",
            self.ranks, self.frame_hash
        )?;
        match &self.frame_hash_alone {
            Some(alone) if *alone == self.frame_hash => f.write_str(", as it is of one alone")?,
            Some(alone) => write!(f, ", and of one alone {alone}")?,
            None => {}
        }
        for (text, spans) in [
            ("the first waited for the others for", &self.waited_us),
            (
                "the last was ready later than the first by",
                &self.spread_us,
            ),
        ] {
            if let Some(Spans { p50, p95, .. }) = spans {
                write!(f, "; {text} {p50} µs (median), {p95} µs (95%)")?;
            }
        }
        Ok(())
    }
}

/// How two eyes were shown.
#[derive(Debug, Serialize)]
struct Eyes {
    format: &'static str,
    eye_order: Vec<&'static str>,
}

/// How many frames had a quality.
#[derive(Debug, Serialize)]
struct Rung {
    depth: u8,
    faces: f32,
    field: f32,
    centre: f32,
    sampling: f32,
    capture: f32,
    frames: u64,
}

impl Report {
    pub(super) fn new(
        around: Around,
        arguments: &Arguments,
        prepared: &Prepared,
        settings: &SessionSettings,
        of: &SessionReport,
    ) -> Self {
        let part = |count: u64| count as f64 / (of.frames.max(1)) as f64;
        let depth = arguments.live.tracing.depth;
        let fill = around.fill;
        Self {
            around,
            scene: prepared.scene.clone(),
            mesh: prepared.mesh.clone(),
            tracker: arguments.tracker.to_string(),
            size: arguments.live.room.size,
            lod: prepared.arguments.lod.name(),
            hz: settings.hz,
            budget: settings.budget.to_string(),
            budget_ms: match of.allowance {
                Allowance::Time(time) => Some(1.0e3 * time.as_secs_f64()),
                Allowance::Unlimited | Allowance::Steps(_) => None,
            },
            // Of all machines.
            budget_steps: match settings.budget {
                FrameBudget::Steps(steps) => Some(steps),
                _ => None,
            },
            plain_ms: of.plain_seconds.map(|seconds| 1.0e3 * seconds),
            plain_parts: of.plain_parts,
            latch: match arguments.latch {
                LatchName::Early => "early",
                LatchName::Late => "late",
            },
            stereo: Eyes {
                format: arguments.stereo.name(),
                eye_order: arguments
                    .stereo
                    .eye_order()
                    .iter()
                    .map(|eye| eye.name())
                    .collect(),
            },
            seconds: of.seconds,
            frames: of.frames,
            refreshes: of.refreshes,
            repeated_refreshes: of.refreshes - of.frames,
            late_frames: of.late_frames,
            over_budget_frames: of.over_budget_frames,
            over_time_frames: of.over_time_frames,
            frames_with_unfinished_fovea: of.frames_with_unfinished_fovea,
            frames_with_unfinished_tiles: of.frames_with_unfinished_tiles,
            lowered_share: part(of.lowered_frames),
            spent_share: of.spent_share,
            needed_share: of.needed_share,
            quality_changes: of.quality_changes,
            rungs: Quality::LADDER
                .iter()
                .zip(of.rungs)
                .map(|(quality, frames)| Rung {
                    depth: quality.depth.min(depth),
                    faces: quality.faces,
                    field: quality.field,
                    centre: quality.centre,
                    sampling: if arguments.live.lod.is_foveated() {
                        quality.sampling
                    } else {
                        1.0
                    },
                    capture: if fill == FillName::Capture {
                        quality.capture
                    } else {
                        1.0
                    },
                    frames,
                })
                .collect(),
            blind_frames: of.blind_frames,
            frames_without_gaze: of.frames_without_gaze,
            median_steps: of.median_steps,
            samples: of.samples,
            passed_over_samples: of.passed_over,
            motion_to_wall_ms: of.latencies.summary(Leg::MotionToWall),
            stages: Leg::ALL
                .into_iter()
                .map(|leg| (leg.name(), of.latencies.summary(leg)))
                .collect(),
            histograms: Leg::ALL
                .into_iter()
                .map(|leg| (leg.name(), of.latencies.few_classes(leg).collect()))
                .collect(),
        }
    }
}

impl Report {
    fn fmt_budget(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "budget {}", self.budget)?;
        if let Some(plain) = self.plain_ms {
            write!(f, " (a frame in full takes {plain:.2} ms")?;
            if let Some([least, most]) = self.plain_parts {
                write!(f, ", a budget is {least:.2} to {most:.2} of that")?;
            }
            f.write_str(")")?;
        }
        if let Some(time) = self.budget_ms {
            write!(f, ", at last {time:.2} ms")?;
        }
        writeln!(f, "; {} steps a frame at the median", self.median_steps)
    }

    /// What frames of each rung were like.
    fn fmt_rungs(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for rung in self.rungs.iter().filter(|rung| rung.frames > 0) {
            write!(
                f,
                "  {:6} frames: {} bounces, faces of level {}, field to {:.0}%, its centre to \
                 {:.0}%",
                rung.frames,
                rung.depth,
                rung.faces,
                100.0 * rung.field,
                100.0 * rung.centre
            )?;
            if rung.sampling > 1.0 {
                write!(f, ", {} times as coarse", rung.sampling)?;
            }
            if rung.capture < 1.0 {
                write!(f, ", {:.0}% of the capture anew", 100.0 * rung.capture)?;
            }
            writeln!(f)?;
        }
        Ok(())
    }

    /// What became of the tracker's samples.
    fn fmt_samples(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} samples of the tracker", self.samples)?;
        for (count, what) in [
            (self.passed_over_samples, "passed over: too many"),
            (self.around.lost_samples, "lost before they came"),
        ] {
            if count > 0 {
                write!(f, ", {count} {what}")?;
            }
        }
        if self.frames_without_gaze > 0 {
            write!(
                f,
                "; {} frames followed none, and are in no time from a sample on",
                self.frames_without_gaze
            )?;
        }
        writeln!(f)
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "scene {}, {} × {} pixels a wall, {}, tracker {}, {} Hz, level of detail {}",
            self.scene,
            self.size,
            self.size,
            counted(self.around.threads as u64, "thread"),
            self.tracker,
            self.hz,
            self.lod
        )?;
        self.fmt_budget(f)?;
        writeln!(
            f,
            "{} in {:.1} s at {} refreshes: {} late, {} over their time, {} over their \
             steps, {} unfinished, {} of these near the line of sight",
            counted(self.frames, "frame"),
            self.seconds,
            self.refreshes,
            self.late_frames,
            self.over_time_frames,
            self.over_budget_frames,
            self.frames_with_unfinished_tiles,
            self.frames_with_unfinished_fovea
        )?;
        writeln!(
            f,
            "quality lowered in {:.1}% of them, changed {} times",
            100.0 * self.lowered_share,
            self.quality_changes
        )?;
        if let Some(share) = self.spent_share {
            writeln!(
                f,
                "{:.0}% of the budget spent, at the median",
                100.0 * share
            )?;
        }
        if let Some(share) = self.needed_share {
            writeln!(
                f,
                "of full quality frames take about {:.0}% of its steps, at the median",
                100.0 * share
            )?;
            if share <= 1.0 && self.lowered_share == 0.0 {
                writeln!(
                    f,
                    "this budget is more than a frame of full quality needs: it lowered nothing"
                )?;
            }
        }
        self.fmt_samples(f)?;
        self.fmt_rungs(f)?;
        if let Some(together) = &self.around.cluster {
            writeln!(f, "{together}")?;
        }
        write!(
            f,
            "{:20} {:>9} {:>9} {:>9} {:>9}",
            "milliseconds", "median", "95%", "99%", "most"
        )?;
        for leg in Leg::ALL {
            if let Some(Some(of)) = self.stages.get(leg.name()) {
                let name = leg.name().replace('_', " ");
                write!(
                    f,
                    "\n{name:20} {:9.3} {:9.3} {:9.3} {:9.3}",
                    of.p50, of.p95, of.p99, of.most
                )?;
            }
        }
        let Interference {
            involuntary_switches,
            stolen_seconds,
        } = self.around.interference;
        if let Some(switches) = involuntary_switches {
            write!(f, "\nthe system took the processor away {switches} times")?;
        }
        if let Some(stolen) = stolen_seconds {
            write!(
                f,
                "\nwhat this machine runs on took {stolen:.2} s of all processors"
            )?;
        }
        Ok(())
    }
}
