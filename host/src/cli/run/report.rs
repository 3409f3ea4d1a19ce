//! What `shisen run` says at its end.

use super::{Arguments, LatchName};
use crate::cli::live::Interference;
use serde::Serialize;
use shisen::live::{Allowance, Leg, Quality, SessionReport, SessionSettings, Summary};
use std::collections::BTreeMap;
use std::fmt;

/// The report.
#[derive(Debug, Serialize)]
pub(super) struct Report {
    #[serde(flatten)]
    around: Around,
    tracker: String,
    size: u32,
    lod: &'static str,
    hz: u32,
    budget: String,
    budget_ms: Option<f64>,
    budget_steps: Option<u64>,
    plain_ms: Option<f64>,
    latch: &'static str,
    seconds: f64,
    frames: u64,
    late_frames: u64,
    over_budget_frames: u64,
    frames_with_unfinished_fovea: u64,
    frames_with_unfinished_tiles: u64,
    lowered_share: f64,
    quality_changes: u64,
    rungs: Vec<Rung>,
    blind_frames: u64,
    median_steps: u64,
    samples: u64,
    motion_to_wall_ms: Option<Summary>,
    stages: BTreeMap<&'static str, Option<Summary>>,
}

/// What a session does not know of itself.
#[derive(Debug, Serialize)]
pub(super) struct Around {
    pub(super) scene: String,
    pub(super) mesh: Option<String>,
    pub(super) threads: usize,
    pub(super) simd: &'static str,
    pub(super) dropped_bytes: u64,
    #[serde(flatten)]
    pub(super) interference: Interference,
}

/// How many frames had a quality.
#[derive(Debug, Serialize)]
struct Rung {
    depth: u8,
    faces: f32,
    field: f32,
    sampling: f32,
    frames: u64,
}

impl Report {
    pub(super) fn new(
        around: Around,
        arguments: &Arguments,
        settings: &SessionSettings,
        of: &SessionReport,
    ) -> Self {
        let part = |count: u64| count as f64 / (of.frames.max(1)) as f64;
        let depth = arguments.live.tracing.depth;
        Self {
            around,
            tracker: arguments.tracker.to_string(),
            size: arguments.live.room.size,
            lod: arguments.live.lod.name(),
            hz: settings.hz,
            budget: settings.budget.to_string(),
            budget_ms: match of.allowance {
                Allowance::Time(time) => Some(1.0e3 * time.as_secs_f64()),
                Allowance::Unlimited | Allowance::Steps(_) => None,
            },
            budget_steps: match of.allowance {
                Allowance::Steps(steps) => Some(steps),
                Allowance::Unlimited | Allowance::Time(_) => None,
            },
            plain_ms: of.plain_seconds.map(|seconds| 1.0e3 * seconds),
            latch: match arguments.latch {
                LatchName::Early => "early",
                LatchName::Late => "late",
            },
            seconds: of.seconds,
            frames: of.frames,
            late_frames: of.late_frames,
            over_budget_frames: of.over_budget_frames,
            frames_with_unfinished_fovea: of.frames_with_unfinished_fovea,
            frames_with_unfinished_tiles: of.frames_with_unfinished_tiles,
            lowered_share: part(of.lowered_frames),
            quality_changes: of.quality_changes,
            rungs: Quality::LADDER
                .iter()
                .zip(of.rungs)
                .map(|(quality, frames)| Rung {
                    depth: quality.depth.min(depth),
                    faces: quality.faces,
                    field: quality.field,
                    sampling: if arguments.live.lod.is_foveated() {
                        quality.sampling
                    } else {
                        1.0
                    },
                    frames,
                })
                .collect(),
            blind_frames: of.blind_frames,
            median_steps: of.median_steps,
            samples: of.samples,
            motion_to_wall_ms: of.latencies.of(Leg::MotionToWall),
            stages: Leg::ALL
                .into_iter()
                .map(|leg| (leg.name(), of.latencies.of(leg)))
                .collect(),
        }
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "scene {}, {} × {} pixels a wall, {} threads, tracker {}, {} Hz, level of detail {}",
            self.around.scene,
            self.size,
            self.size,
            self.around.threads,
            self.tracker,
            self.hz,
            self.lod
        )?;
        write!(f, "budget {}", self.budget)?;
        if let Some(plain) = self.plain_ms {
            write!(f, " (a frame in full takes {plain:.2} ms)")?;
        }
        if let Some(time) = self.budget_ms {
            write!(f, ", at last {time:.2} ms")?;
        }
        writeln!(f, "; {} steps a frame at the median", self.median_steps)?;
        writeln!(
            f,
            "{} frames in {:.1} s: {} late, {} over their steps, {} unfinished, {} of these near \
             the line of sight",
            self.frames,
            self.seconds,
            self.late_frames,
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
        for rung in self.rungs.iter().filter(|rung| rung.frames > 0) {
            writeln!(
                f,
                "  {:6} frames: {} bounces, faces of level {}, field to {:.0}%",
                rung.frames,
                rung.depth,
                rung.faces,
                100.0 * rung.field
            )?;
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
