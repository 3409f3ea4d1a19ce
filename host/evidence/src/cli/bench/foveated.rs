//! `shisen-evidence bench foveated`: what detail as large as the eye sees saves.

use super::frames::{Cell, FrameArguments, Frames, Look, Way};
use crate::measure::in_turns;
use crate::table::Table;
use crate::tradeoff::{PictureDifference, Sight};
use clap::Args;
use schemars::JsonSchema;
use serde::Serialize;
use shisen::cli::output::failure::Failure;
use shisen::cli::output::ray_counts::RayCounts;
use shisen::live::{Engine, Quality, Share, with_engine};
use shisen::render;

/// Frames with detail as large as the eye sees beside the paper's and full tracing
///
/// Scenes A to D, the viewer looking at the front wall (state 1) and at the floor
/// (state 2), three walls for two eyes. Frames are rendered in turns, by the engine of
/// `shisen run`; times are medians, of tracing, and their ratios medians
/// of those of frames of the same turn. Errors are FLIP
/// against full tracing, from 0 (equal) to 1, weighted by the part of the visual
/// cortex that sees a pixel, as in `shisen-evidence tradeoff`.
#[derive(Debug, Args)]
pub(in crate::cli) struct Arguments {
    #[command(flatten)]
    frames: FrameArguments,
}

/// The ways to render a frame, in the order of their turns.
const WAYS: [Way; 3] = [Way::Plain, Way::Lod, Way::Foveated];

/// Frames with detail as large as the eye sees beside others.
#[derive(Debug, Serialize, JsonSchema)]
pub(in crate::cli) struct Report {
    /// Scenes and states.
    cells: Vec<MeasuredCell>,
}

/// Frames of a scene in a state.
#[derive(Debug, Serialize, JsonSchema)]
struct MeasuredCell {
    #[serde(flatten)]
    cell: Cell,
    /// Frames in full.
    plain: Measured,
    /// Frames by the paper's method.
    paper: Measured,
    /// Frames with detail as large as the eye sees.
    foveated: Measured,
    /// Primary rays, plain by foveated.
    primary_ratio: f64,
    /// Steps, plain by foveated.
    steps_ratio: f64,
    /// Time, plain by foveated.
    time_ratio: f64,
}

#[derive(Debug, Clone, Copy, Serialize, JsonSchema)]
struct Measured {
    /// Time of tracing, seconds.
    seconds: f64,
    /// Steps of a frame.
    steps: u64,
    /// Rays of a frame.
    rays: RayCounts,
    /// FLIP against full tracing, weighted by the part of the visual cortex that sees a pixel.
    flip_weighted: f64,
    /// FLIP against full tracing, of all pixels alike.
    flip: f64,
}

pub(in crate::cli) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let frames = &arguments.frames;
    let rounds = frames.repeat as usize;
    let cells = frames.cells(|frames, cell, look| {
        let ([plain, paper, foveated], time_ratio) = measure(frames, look, rounds)?;
        Ok(MeasuredCell {
            cell,
            plain,
            paper,
            foveated,
            primary_ratio: plain.rays.primary as f64 / foveated.rays.primary as f64,
            steps_ratio: plain.steps as f64 / foveated.steps as f64,
            time_ratio,
        })
    })?;
    let table = Table::new(&cells)
        .text("", |one| one.cell.to_string())
        .number("plain", 1, |one| 1e3 * one.plain.seconds)
        .number("paper", 1, |one| 1e3 * one.paper.seconds)
        .number("foveated", 1, |one| 1e3 * one.foveated.seconds)
        .number("plain by foveated", 2, |one| one.time_ratio)
        .count("primary rays, plain", |one| one.plain.rays.primary)
        .count("primary rays, paper", |one| one.paper.rays.primary)
        .count("primary rays, foveated", |one| one.foveated.rays.primary)
        .number("plain by foveated", 2, |one| one.primary_ratio)
        .number("steps, plain by foveated", 2, |one| one.steps_ratio)
        .count("shadow rays, plain", |one| one.plain.rays.shadow)
        .count("shadow rays, foveated", |one| one.foveated.rays.shadow)
        .count("points lit, plain", |one| one.plain.rays.lit)
        .count("points lit, foveated", |one| one.foveated.rays.lit)
        .count("leaves, foveated", |one| one.foveated.rays.leaves)
        .number("FLIP by acuity, paper", 5, |one| one.paper.flip_weighted)
        .number("FLIP by acuity, foveated", 5, |one| {
            one.foveated.flip_weighted
        })
        .number("FLIP, paper", 5, |one| one.paper.flip)
        .number("FLIP, foveated", 5, |one| one.foveated.flip);
    let text = format!("; milliseconds a frame\n{table}");
    frames.print(Report { cells }, &text)
}

/// Returns the frames of all ways, and the ratio of the times of the plain one and the foveated one.
fn measure(
    frames: &Frames,
    look: Look,
    rounds: usize,
) -> Result<([Measured; WAYS.len()], f64), Failure> {
    let scene = frames.scene.scene();
    let (cave, options) = (&frames.cave, &frames.options);
    let eyes = Frames::observers(Way::Plain, look)?;
    let mut sights = Vec::new();
    for screen in cave.screens() {
        for eye in &eyes {
            sights.push(Sight::new(&render::view(screen, eye)?, look.forward));
        }
    }
    let measure = |engine: &mut dyn Engine| {
        // A round of its own for pictures, and for work that is only done once.
        let first = in_turns(&WAYS, 1, |&way| {
            let frame = engine.render(&Frames::observers(way, look)?, &Quality::FULL, None)?;
            let mut pictures = Vec::new();
            engine.pictures(&mut pictures, false)?;
            Ok::<_, Failure>((0.0, (frame.statistics, pictures)))
        })?;
        let timed = in_turns(&WAYS, rounds, |&way| {
            let frame = engine.render(&Frames::observers(way, look)?, &Quality::FULL, None)?;
            Ok::<_, Failure>((frame.tracing.as_secs_f64(), ()))
        })?;
        let (_, truth) = &first[0].first;
        let measured = [0, 1, 2].map(|way| {
            let (work, found) = &first[way].first;
            let pairs = sights.iter().zip(found.iter().zip(truth));
            let pairs: Vec<_> = pairs.map(|(sight, (a, b))| (sight, a, b)).collect();
            let error = PictureDifference::new(&pairs);
            Measured {
                seconds: timed[way].median(),
                steps: work.steps,
                rays: (*work).into(),
                flip_weighted: error.weighted.flip,
                flip: error.all.flip,
            }
        });
        Ok((measured, timed[0].ratio_to(&timed[2])))
    };
    with_engine(scene, cave, &eyes, options, None, Share::ALL, measure)?
}
