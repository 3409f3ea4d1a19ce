//! `shisen-evidence bench foveated`: what it saves to sample the periphery coarsely.

use super::cells::{Rows, Title};
use super::frames::{FrameArguments, Frames, Look, Way};
use super::table2::STATES;
use crate::tradeoff::{PictureDifference, Sight};
use clap::Args;
use serde::Serialize;
use shisen::cli::output::failure::Failure;
use shisen::cli::output::print;
use shisen::cli::output::ray_counts::RayCounts;
use shisen::live::quantiles::{median, median_ratio};
use shisen::live::{Engine, Quality, Share, with_engine};
use shisen::picture::Picture;
use shisen::render::{self, Observer};
use shisen::scene::builtin::PaperScene;
use shisen::with_scene;
use shisen_core::frame::{Budget, Outcome, Pixel, Spectrum, Tile, TileJob, Workspace};
use shisen_core::scene::Scene;
use shisen_core::{Runs, Simd};
use std::fmt;

/// Frames with fewer rays in the periphery beside the paper's and full tracing
///
/// Scenes A to D, the viewer looking at the front wall (state 1) and at the floor
/// (state 2), three walls for two eyes. Frames are rendered in turns, by what
/// `shisen run` renders them with; times are medians, of tracing, and their ratios medians
/// of those of frames of the same turn. Errors are FLIP
/// against full tracing, from 0 (equal) to 1, weighted by the part of the visual
/// cortex that sees a pixel, as in `shisen-evidence tradeoff`.
///
/// What such sampling saves at most is what it would with samples nowhere nearer to each
/// other than acuity asks for: the steps of full tracing, those of each square by the
/// pixels that a sample stands for.
///
/// With --json, one object: threads, size, mesh and cells: for each scene and state
/// plain, paper and foveated, each with seconds, steps, rays (primary, reflected,
/// refracted, shadow), `flip_weighted` and flip (of all pixels alike);
/// `primary_ratio`, `steps_ratio` and `time_ratio`, plain by foveated; and
/// `least_steps`, those that acuity asks for.
#[derive(Debug, Args)]
pub(in crate::cli) struct Arguments {
    #[command(flatten)]
    frames: FrameArguments,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

/// The ways of a frame, in the order of their turns.
const WAYS: [Way; 3] = [Way::Plain, Way::Lod, Way::Foveated];

/// What was measured.
#[derive(Debug, Serialize)]
struct Report {
    #[serde(flatten)]
    title: Title,
    cells: Vec<Cell>,
}

/// One scene, looked at one way.
#[derive(Debug, Serialize)]
struct Cell {
    scene: &'static str,
    state: usize,
    plain: Measured,
    paper: Measured,
    foveated: Measured,
    least_steps: u64,
    primary_ratio: f64,
    steps_ratio: f64,
    time_ratio: f64,
}

/// A way of a frame.
#[derive(Debug, Clone, Copy, Serialize)]
struct Measured {
    seconds: f64,
    steps: u64,
    rays: RayCounts,
    flip_weighted: f64,
    flip: f64,
}

/// All ways of one frame.
struct Compared {
    ways: [Measured; WAYS.len()],
    /// Plain by foveated.
    time_ratio: f64,
}

/// Runs the command.
pub(in crate::cli) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let frames = &arguments.frames;
    let mut cells = Vec::new();
    for scene in PaperScene::ALL {
        let of_scene = frames.frames(scene)?;
        for (state, (forward, up)) in (1..).zip(STATES) {
            let look = Look { forward, up };
            let (ways, least_steps) = with_scene!(&of_scene.scene, |scene| cell(
                scene,
                &of_scene,
                look,
                frames.repeat
            ))?;
            let Compared {
                ways: [plain, paper, foveated],
                time_ratio,
            } = ways;
            cells.push(Cell {
                scene: scene.name(),
                state,
                plain,
                paper,
                foveated,
                least_steps,
                primary_ratio: plain.rays.primary as f64 / foveated.rays.primary as f64,
                steps_ratio: plain.steps as f64 / foveated.steps as f64,
                time_ratio,
            });
        }
    }
    let report = Report {
        title: frames.title(),
        cells,
    };
    print(&report, arguments.json)
}

/// All ways of one frame, and the steps that acuity asks for.
fn cell<const W: usize>(
    scene: Scene<'_, W>,
    frames: &Frames,
    look: Look,
    repeat: u32,
) -> Result<(Compared, u64), Failure>
where
    Simd: Runs<W>,
{
    let bound = least_steps(&scene, frames, look)?;
    Ok((ways(scene, frames, look, repeat)?, bound))
}

/// Pixels a side of the smallest squares that choose how far apart their samples are.
const SQUARE: u32 = 16;

fn least_steps<const W: usize>(
    scene: &Scene<'_, W>,
    frames: &Frames,
    look: Look,
) -> Result<u64, Failure>
where
    Simd: Runs<W>,
{
    let of = |observer: &Observer| {
        render::renderer(scene, observer, &frames.options, Spectrum::default())
            .map_err(Failure::from_error)
    };
    let (mut workspace, mut least) = (Workspace::new(), 0.0);
    let mut pixels = [Pixel::default(); (SQUARE * SQUARE) as usize];
    let plain = Frames::observers(Way::Plain, look)?;
    let foveated = Frames::observers(Way::Foveated, look)?;
    for screen in frames.cave.screens() {
        for (eye, foveated) in plain.iter().zip(&foveated) {
            let view = render::view(screen, eye)?;
            let (renderer, chooses) = (of(eye)?, of(foveated)?);
            for y in (0..view.rows()).step_by(SQUARE as usize) {
                for x in (0..view.columns()).step_by(SQUARE as usize) {
                    let tile = Tile {
                        x,
                        y,
                        width: SQUARE.min(view.columns() - x),
                        height: SQUARE.min(view.rows() - y),
                    };
                    let pixels = &mut pixels[..(tile.width * tile.height) as usize];
                    let (before, mut budget) = (workspace.statistics.steps, Budget::UNLIMITED);
                    let outcome = TileJob::new(tile)
                        .render(&renderer, &view, pixels, &mut budget, &mut workspace)
                        .map_err(Failure::from_error)?;
                    assert_eq!(outcome, Outcome::Finished, "nothing ends it before");
                    let stride = f64::from(chooses.stride(&view, x, y));
                    least += (workspace.statistics.steps - before) as f64 / (stride * stride);
                }
            }
        }
    }
    Ok(least as u64)
}

/// All ways of one frame.
fn ways<const W: usize>(
    scene: Scene<'_, W>,
    frames: &Frames,
    look: Look,
    repeat: u32,
) -> Result<Compared, Failure>
where
    Simd: Runs<W>,
{
    let (cave, options) = (&frames.cave, &frames.options);
    let eyes = Frames::observers(Way::Plain, look)?;
    let mut sights = Vec::new();
    for screen in cave.screens() {
        for eye in &eyes {
            let view = render::view(screen, eye)?;
            sights.push(Sight::new(&view, look.forward));
        }
    }
    let spectrum = Spectrum::default();
    with_engine(
        (scene, spectrum),
        cave,
        &eyes,
        options,
        None,
        Share::ALL,
        |engine| measure(engine, &sights, look, repeat),
    )?
}

fn measure<const W: usize>(
    engine: &mut Engine<'_, '_, W>,
    sights: &[Sight],
    look: Look,
    repeat: u32,
) -> Result<Compared, Failure>
where
    Simd: Runs<W>,
{
    let mut seconds = [const { Vec::new() }; WAYS.len()];
    let mut work = [None; WAYS.len()];
    let mut pictures: [Vec<Picture>; WAYS.len()] = Default::default();
    // The first round is for what is only done once.
    for round in 0..=repeat {
        for (number, way) in WAYS.into_iter().enumerate() {
            let eyes: [Observer; 2] = Frames::observers(way, look)?;
            let frame = engine.render(&eyes, &Quality::FULL, None)?;
            if round == 0 {
                pictures[number] = engine.pictures()?;
                engine.copy(&mut pictures[number]);
                work[number] = Some(frame.statistics);
            } else {
                seconds[number].push(frame.tracing.as_secs_f64());
            }
        }
    }
    let [plain, _, foveated] = &seconds;
    let time_ratio = median_ratio(plain, foveated);
    let [truth, ..] = &pictures;
    let mut measured = Vec::new();
    for ((found, seconds), work) in pictures.iter().zip(seconds).zip(work) {
        let pairs = sights.iter().zip(found.iter().zip(truth));
        let pairs: Vec<_> = pairs.map(|(sight, (a, b))| (sight, a, b)).collect();
        let error = PictureDifference::new(&pairs);
        let work = work.unwrap_or_default();
        measured.push(Measured {
            seconds: median(seconds),
            steps: work.steps,
            rays: work.into(),
            flip_weighted: error.weighted.flip,
            flip: error.all.flip,
        });
    }
    let Ok(ways) = measured.try_into() else {
        unreachable!("as many as there are ways")
    };
    Ok(Compared { ways, time_ratio })
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}; milliseconds a frame", self.title)?;
        let mut table = Rows::new(f, &self.cells, 26, |c| (c.scene, c.state))?;
        table.numbers("plain", 1, |c| Some(1e3 * c.plain.seconds))?;
        table.numbers("paper", 1, |c| Some(1e3 * c.paper.seconds))?;
        table.numbers("foveated", 1, |c| Some(1e3 * c.foveated.seconds))?;
        table.numbers("plain by foveated", 2, |c| Some(c.time_ratio))?;
        table.row("primary rays, plain", |c| c.plain.rays.primary.to_string())?;
        table.row("primary rays, paper", |c| c.paper.rays.primary.to_string())?;
        table.row("primary rays, foveated", |c| {
            c.foveated.rays.primary.to_string()
        })?;
        table.numbers("plain by foveated", 2, |c| Some(c.primary_ratio))?;
        table.numbers("steps, plain by foveated", 2, |c| Some(c.steps_ratio))?;
        table.numbers("the same, at most", 2, |c| {
            (c.least_steps > 0).then(|| c.plain.steps as f64 / c.least_steps as f64)
        })?;
        table.numbers("FLIP by acuity, paper", 5, |c| Some(c.paper.flip_weighted))?;
        table.numbers("FLIP by acuity, foveated", 5, |c| {
            Some(c.foveated.flip_weighted)
        })?;
        table.numbers("FLIP, paper", 5, |c| Some(c.paper.flip))?;
        table.numbers("FLIP, foveated", 5, |c| Some(c.foveated.flip))
    }
}
