//! `shisen-evidence bench table2`: the paper's measurement, here and now.

use super::cells::{Rows, Title};
use super::frames::{FrameArguments, Way};
use clap::{Arg, Args};
use glam::Vec3;
use serde::Serialize;
use shisen::cli::output::failure::Failure;
use shisen::cli::output::print;
use shisen::cli::output::ray_counts::RayCounts;
use shisen::live::Table2;
use shisen::live::quantiles::{median, median_ratio};
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

/// Where the viewer looks in states 1 and 2, and what is up then.
pub(super) const STATES: [(Vec3, Vec3); 2] = [(Vec3::NEG_Z, Vec3::Y), (Vec3::NEG_Y, Vec3::NEG_Z)];

/// The ratios of scenes A to D in states 1 and 2 by the paper's counts of rays (primary, hits
/// and bounces of its cow) where those that meet nothing cost next to nothing, and detail
/// costs nothing itself.
const BOUND: [[f64; 2]; 4] = [[0.50, 0.37], [0.53, 0.39], [0.98, 0.06], [0.96, 0.08]];

/// Share of the plain frame's steps above which times of frames can be compared.
const SAME_WORK: f64 = 0.98;

/// The ways of a frame, in the order of their turns.
const WAYS: [Way; 4] = [Way::Plain, Way::Lod, Way::Cut, Way::Levels];

/// What was measured.
#[derive(Debug, Serialize)]
struct Report {
    #[serde(flatten)]
    title: Title,
    repeat: u32,
    cells: Vec<Cell>,
}

/// One scene, looked at one way.
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
    let mut cells = Vec::new();
    for (Table2 { scene, lod, plain }, bound) in Table2::ROWS.into_iter().zip(BOUND) {
        let of_scene = frames.frames(scene)?;
        for (number, (forward, up)) in STATES.into_iter().enumerate() {
            let mut seconds = [const { Vec::new() }; WAYS.len()];
            let mut statistics = [None; WAYS.len()];
            for _ in 0..frames.repeat {
                for (turn, way) in WAYS.into_iter().enumerate() {
                    let (time, work) = of_scene.render(way, forward, up)?;
                    seconds[turn].push(time);
                    statistics[turn] = Some(work);
                }
            }
            let [as_plain, with_lod, _, with_levels] = &seconds;
            let ratio = median_ratio(with_lod, as_plain);
            let levels_ratio = median_ratio(with_levels, as_plain);
            let [plain_seconds, lod_seconds, cut_seconds, _] = seconds.map(median);
            let [Some(plain_work), Some(lod_work), _, Some(levels_work)] = statistics else {
                continue;
            };
            let same = levels_work.steps as f64 / plain_work.steps as f64;
            cells.push(Cell {
                scene: scene.name(),
                state: number + 1,
                lod_seconds,
                plain_seconds,
                paper_lod_seconds: lod[number],
                paper_plain_seconds: plain,
                ratio,
                paper_ratio: lod[number] / plain,
                bound_ratio: bound[number],
                lod_rays: lod_work.into(),
                plain_rays: plain_work.into(),
                lod_steps: lod_work.steps,
                plain_steps: plain_work.steps,
                steps_ratio: lod_work.steps as f64 / plain_work.steps as f64,
                cut_seconds,
                bookkeeping: (same > SAME_WORK).then_some(levels_ratio / same - 1.0),
            });
        }
    }
    let report = Report {
        title: frames.title(),
        repeat: frames.repeat,
        cells,
    };
    print(&report, arguments.json)
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}; milliseconds a frame", self.title)?;
        let mut table = Rows::new(f, &self.cells, 22, |c| (c.scene, c.state))?;
        table.numbers("level of detail", 2, |c| Some(1e3 * c.lod_seconds))?;
        table.numbers("its rays in full", 2, |c| Some(1e3 * c.cut_seconds))?;
        table.numbers("plain", 2, |c| Some(1e3 * c.plain_seconds))?;
        table.numbers("paper, detail", 0, |c| Some(1e3 * c.paper_lod_seconds))?;
        table.numbers("paper, plain", 0, |c| Some(1e3 * c.paper_plain_seconds))?;
        table.numbers("ratio", 3, |c| Some(c.ratio))?;
        table.numbers("ratio in the paper", 3, |c| Some(c.paper_ratio))?;
        table.numbers("bound, misses free", 2, |c| Some(c.bound_ratio))?;
        table.numbers("ratio of steps", 3, |c| Some(c.steps_ratio))?;
        table.row("bookkeeping", |c| match c.bookkeeping {
            Some(share) => format!("{:.1}%", 1e2 * share),
            None => "-".to_owned(),
        })?;
        table.row("primary rays", |c| c.lod_rays.primary.to_string())?;
        table.row("secondary rays", |c| c.lod_rays.secondary().to_string())?;
        table.row("shadow rays", |c| c.lod_rays.shadow.to_string())?;
        table.row("primary, plain", |c| c.plain_rays.primary.to_string())?;
        table.row("secondary, plain", |c| c.plain_rays.secondary().to_string())?;
        table.row("shadow, plain", |c| c.plain_rays.shadow.to_string())
    }
}
