//! `shisen-evidence bench table2`: the paper's measurement, here and now.

use super::frames::{Cell, FrameArguments, Frames, Look, Way};
use crate::measure::in_turns;
use crate::table::Table;
use clap::{Arg, Args};
use schemars::JsonSchema;
use serde::Serialize;
use shisen::cli::output::failure::Failure;
use shisen::cli::output::ray_counts::RayCounts;
use shisen::live::Table2;
use shisen::render::Filling;

/// The paper's Table 2: frames with and without level of detail
///
/// Scenes A to D, the viewer looking at the front wall (state 1) and at the
/// floor (state 2), three walls for two eyes. Frames with and without level of
/// detail are rendered in turns; times are medians, and ratios of times medians of the
/// ratios of frames of the same turn.
#[derive(Debug, Args)]
#[command(mut_arg("repeat", often))]
pub(in crate::cli) struct Arguments {
    #[command(flatten)]
    frames: FrameArguments,
}

/// Returns the argument `--repeat`: ratios of a few frames differ by hundredths from run to run.
fn often(repeat: Arg) -> Arg {
    repeat.default_value("25")
}

/// The paper's Table 2.
#[derive(Debug, Serialize, JsonSchema)]
pub(in crate::cli) struct Report {
    /// Number of frames of each median.
    repeat: u32,
    /// Scenes and states.
    cells: Vec<Measured>,
}

/// Frames of a scene in a state.
#[derive(Debug, Serialize, JsonSchema)]
struct Measured {
    #[serde(flatten)]
    cell: Cell,
    /// Time of a frame with level of detail, seconds.
    lod_seconds: f64,
    /// Time of a frame without, seconds.
    plain_seconds: f64,
    /// Time with level of detail in the paper, seconds.
    paper_lod_seconds: f64,
    /// Time without in the paper, seconds.
    paper_plain_seconds: f64,
    /// Time with level of detail by time without.
    ratio: f64,
    /// The same in the paper.
    paper_ratio: f64,
    /// The same for the paper's cow if rays that meet nothing cost almost nothing and detail had
    /// no cost of its own.
    bound_ratio: f64,
    /// Rays with level of detail.
    lod_rays: RayCounts,
    /// Rays without.
    plain_rays: RayCounts,
    /// Steps with level of detail.
    lod_steps: u64,
    /// Steps without.
    plain_steps: u64,
    /// Steps with level of detail by steps without.
    steps_ratio: f64,
    /// Time of the rays of the frame with level of detail, each with all faces and bounces,
    /// seconds.
    cut_seconds: f64,
    /// Share of time that asking for levels adds; null unless the rays of the visual field take
    /// nearly all steps of the frame without level of detail.
    bookkeeping: Option<f64>,
}

/// The ratios of scenes A to D in states 1 and 2 that follow from the paper's counts of rays
/// (primary, hits and bounces of its cow), if misses and detail itself cost nothing.
const BOUND: [[f64; 2]; 4] = [[0.50, 0.37], [0.53, 0.39], [0.98, 0.06], [0.96, 0.08]];

/// The least share of the plain frame's steps at which times of frames are compared.
const SAME_WORK: f64 = 0.98;

/// The ways to render a frame, in the order of their turns.
const WAYS: [Way; 4] = [Way::Plain, Way::Lod, Way::Cut, Way::Levels];

pub(in crate::cli) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let frames = &arguments.frames;
    let rounds = frames.repeat as usize;
    let cells = frames.cells(|frames, cell, look| measured(frames, cell, look, rounds))?;
    let table = Table::new(&cells)
        .text("", |one| one.cell.to_string())
        .number("level of detail", 2, |one| 1e3 * one.lod_seconds)
        .number("its rays in full", 2, |one| 1e3 * one.cut_seconds)
        .number("plain", 2, |one| 1e3 * one.plain_seconds)
        .number("paper, detail", 0, |one| 1e3 * one.paper_lod_seconds)
        .number("paper, plain", 0, |one| 1e3 * one.paper_plain_seconds)
        .number("ratio", 3, |one| one.ratio)
        .number("ratio in the paper", 3, |one| one.paper_ratio)
        .number("bound, misses free", 2, |one| one.bound_ratio)
        .number("ratio of steps", 3, |one| one.steps_ratio)
        .number("bookkeeping, %", 1, |one| {
            one.bookkeeping.map(|share| 1e2 * share)
        })
        .count("primary rays", |one| one.lod_rays.primary)
        .count("secondary rays", |one| secondary(&one.lod_rays))
        .count("shadow rays", |one| one.lod_rays.shadow)
        .count("primary, plain", |one| one.plain_rays.primary)
        .count("secondary, plain", |one| secondary(&one.plain_rays))
        .count("shadow, plain", |one| one.plain_rays.shadow);
    let text = format!("; milliseconds a frame\n{table}");
    let report = Report {
        repeat: frames.repeat,
        cells,
    };
    frames.print(report, &text)
}

const fn secondary(rays: &RayCounts) -> u64 {
    rays.reflected + rays.refracted
}

fn measured(frames: &Frames, cell: Cell, look: Look, rounds: usize) -> Result<Measured, Failure> {
    let timed = in_turns(&WAYS, rounds, |&way| {
        let frame = frames.frame(way, look, Filling::Background)?;
        Ok::<_, Failure>((frame.seconds, frame.statistics))
    })?;
    let [plain, lod, cut, levels] = &timed[..] else {
        unreachable!("a time of each way")
    };
    let steps_ratio = |of: u64| of as f64 / plain.first.steps as f64;
    let same = steps_ratio(levels.first.steps);
    let rows = Table2::ROWS.iter().zip(BOUND);
    let mut rows = rows.filter(|(row, _)| row.scene.name() == cell.scene);
    let Some((paper, bound)) = rows.next() else {
        unreachable!("the paper's table has all scenes")
    };
    let paper_lod = paper.lod[cell.state - 1];
    Ok(Measured {
        cell,
        lod_seconds: lod.median(),
        plain_seconds: plain.median(),
        paper_lod_seconds: paper_lod,
        paper_plain_seconds: paper.plain,
        ratio: lod.ratio_to(plain),
        paper_ratio: paper_lod / paper.plain,
        bound_ratio: bound[cell.state - 1],
        lod_rays: RayCounts::from(lod.first),
        plain_rays: RayCounts::from(plain.first),
        lod_steps: lod.first.steps,
        plain_steps: plain.first.steps,
        steps_ratio: steps_ratio(lod.first.steps),
        cut_seconds: cut.median(),
        bookkeeping: (same > SAME_WORK).then(|| levels.ratio_to(plain) / same - 1.0),
    })
}
