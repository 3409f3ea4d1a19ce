//! `shisen-evidence bench table2`: the paper's measurement, here and now.

use super::frames::{FrameArguments, Frames, Look, Title, Way};
use crate::measure::in_turns;
use crate::table::Table;
use clap::{Arg, Args};
use serde::Serialize;
use shisen::cli::output::failure::Failure;
use shisen::cli::output::print;
use shisen::cli::output::ray_counts::RayCounts;
use shisen::live::Table2;
use shisen::render::Filling;
use shisen::scene::builtin::PaperScene;
use std::fmt;

/// The paper's Table 2: frames with and without level of detail
///
/// Scenes A to D, the viewer looking at the front wall (state 1) and at the
/// floor (state 2), three walls for two eyes. Frames with and without level of
/// detail are rendered in turns; times are medians, and ratios of times medians of the
/// ratios of frames of the same turn.
///
/// With --json, one object: threads, size, mesh, repeat (frames that a median is of) and cells: for each scene and
/// state `lod_seconds`, `plain_seconds`, `paper_lod_seconds`, `paper_plain_seconds`, ratio,
/// `paper_ratio`, `bound_ratio` (what it would be for the paper's cow if
/// rays that meet nothing cost almost nothing and detail had no cost of its own), `lod_rays` and
/// `plain_rays` (primary, reflected, refracted, shadow), `lod_steps`,
/// `plain_steps`, `steps_ratio`, `cut_seconds` (the rays of the frame with level of
/// detail, each with all faces and bounces), and bookkeeping: where
/// the rays of the field take nearly all steps of the plain frame, the share of
/// time that asking for their levels adds to it (else null).
#[derive(Debug, Args)]
#[command(mut_arg("repeat", often))]
pub(in crate::cli) struct Arguments {
    #[command(flatten)]
    frames: FrameArguments,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

/// The argument `--repeat`: ratios of a few frames differ by hundredths from run to run.
fn often(repeat: Arg) -> Arg {
    repeat.default_value("25")
}

/// The ratios of scenes A to D in states 1 and 2 that follow from the paper's counts of rays
/// (primary, hits and bounces of its cow), if misses and detail itself cost nothing.
const BOUND: [[f64; 2]; 4] = [[0.50, 0.37], [0.53, 0.39], [0.98, 0.06], [0.96, 0.08]];

/// The least share of the plain frame's steps at which times of frames are compared.
const SAME_WORK: f64 = 0.98;

/// The ways to render a frame, in the order of their turns.
const WAYS: [Way; 4] = [Way::Plain, Way::Lod, Way::Cut, Way::Levels];

#[derive(Debug, Serialize)]
struct Report {
    #[serde(flatten)]
    title: Title,
    repeat: u32,
    cells: Vec<Cell>,
}

/// A scene and a state.
#[derive(Debug, Serialize)]
struct Cell {
    scene: &'static str,
    state: usize,
    lod_seconds: f64,
    plain_seconds: f64,
    paper_lod_seconds: f64,
    paper_plain_seconds: f64,
    ratio: f64,
    paper_ratio: f64,
    bound_ratio: f64,
    lod_rays: RayCounts,
    plain_rays: RayCounts,
    lod_steps: u64,
    plain_steps: u64,
    steps_ratio: f64,
    cut_seconds: f64,
    bookkeeping: Option<f64>,
}

/// Runs the command.
pub(in crate::cli) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let frames = &arguments.frames;
    let rounds = frames.repeat as usize;
    let report = Report {
        title: frames.title(),
        repeat: frames.repeat,
        cells: frames
            .cells(|frames, scene, state, look| cell(frames, scene, (state, look), rounds))?,
    };
    print(&report, arguments.json)
}

fn cell(
    frames: &Frames,
    scene: PaperScene,
    (state, look): (usize, Look),
    rounds: usize,
) -> Result<Cell, Failure> {
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
    let mut rows = rows.filter(|(row, _)| row.scene == scene);
    let Some((paper, bound)) = rows.next() else {
        unreachable!("the paper's table has all scenes")
    };
    let paper_lod = paper.lod[state - 1];
    Ok(Cell {
        scene: scene.name(),
        state,
        lod_seconds: lod.median(),
        plain_seconds: plain.median(),
        paper_lod_seconds: paper_lod,
        paper_plain_seconds: paper.plain,
        ratio: lod.ratio_to(plain),
        paper_ratio: paper_lod / paper.plain,
        bound_ratio: bound[state - 1],
        lod_rays: lod.first.into(),
        plain_rays: plain.first.into(),
        lod_steps: lod.first.steps,
        plain_steps: plain.first.steps,
        steps_ratio: steps_ratio(lod.first.steps),
        cut_seconds: cut.median(),
        bookkeeping: (same > SAME_WORK).then(|| levels.ratio_to(plain) / same - 1.0),
    })
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let table = Table::new(&self.cells)
            .text("", |c| format!("{}{}", c.scene, c.state))
            .number("level of detail", 2, |c| Some(1e3 * c.lod_seconds))
            .number("its rays in full", 2, |c| Some(1e3 * c.cut_seconds))
            .number("plain", 2, |c| Some(1e3 * c.plain_seconds))
            .number("paper, detail", 0, |c| Some(1e3 * c.paper_lod_seconds))
            .number("paper, plain", 0, |c| Some(1e3 * c.paper_plain_seconds))
            .number("ratio", 3, |c| Some(c.ratio))
            .number("ratio in the paper", 3, |c| Some(c.paper_ratio))
            .number("bound, misses free", 2, |c| Some(c.bound_ratio))
            .number("ratio of steps", 3, |c| Some(c.steps_ratio))
            .number("bookkeeping, %", 1, |c| Some(1e2 * c.bookkeeping?))
            .count("primary rays", |c| c.lod_rays.primary)
            .count("secondary rays", |c| c.lod_rays.secondary())
            .count("shadow rays", |c| c.lod_rays.shadow)
            .count("primary, plain", |c| c.plain_rays.primary)
            .count("secondary, plain", |c| c.plain_rays.secondary())
            .count("shadow, plain", |c| c.plain_rays.shadow);
        write!(f, "{}; milliseconds a frame\n{table}", self.title)
    }
}
