//! `shisen-evidence bench table2`: the paper's measurement, here and now.

use super::frames::{FrameArguments, Frames, Look, Way, name};
use super::numbers;
use crate::measure::in_turns;
use crate::table::Table;
use clap::{Arg, Args};
use serde_json::{Value, json};
use shisen::cli::output::failure::Failure;
use shisen::cli::output::ray_counts::RayCounts;
use shisen::live::Table2;
use shisen::render::Filling;
use shisen::scene::builtin::PaperScene;

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

pub(in crate::cli) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let frames = &arguments.frames;
    let rounds = frames.repeat as usize;
    let cells =
        frames.cells(|frames, scene, state, look| cell(frames, scene, (state, look), rounds))?;
    let table = numbers(
        Table::new(&cells).text("", name),
        &[
            ("level of detail", "/lod_seconds", 1e3, 2),
            ("its rays in full", "/cut_seconds", 1e3, 2),
            ("plain", "/plain_seconds", 1e3, 2),
            ("paper, detail", "/paper_lod_seconds", 1e3, 0),
            ("paper, plain", "/paper_plain_seconds", 1e3, 0),
            ("ratio", "/ratio", 1.0, 3),
            ("ratio in the paper", "/paper_ratio", 1.0, 3),
            ("bound, misses free", "/bound_ratio", 1.0, 2),
            ("ratio of steps", "/steps_ratio", 1.0, 3),
            ("bookkeeping, %", "/bookkeeping", 1e2, 1),
            ("primary rays", "/lod_rays/primary", 1.0, 0),
        ],
    )
    .count("secondary rays", |cell| secondary(&cell["lod_rays"]));
    let fields = [
        ("shadow rays", "/lod_rays/shadow", 1.0, 0),
        ("primary, plain", "/plain_rays/primary", 1.0, 0),
    ];
    let table =
        numbers(table, &fields).count("secondary, plain", |cell| secondary(&cell["plain_rays"]));
    let table = numbers(table, &[("shadow, plain", "/plain_rays/shadow", 1.0, 0)]);
    let report = json!({ "repeat": frames.repeat, "cells": cells });
    frames.print(report, &format!("; milliseconds a frame\n{table}"))
}

fn secondary(rays: &Value) -> u64 {
    let kinds = ["reflected", "refracted"].into_iter();
    kinds.filter_map(|kind| rays[kind].as_u64()).sum()
}

fn cell(
    frames: &Frames,
    scene: PaperScene,
    (state, look): (usize, Look),
    rounds: usize,
) -> Result<Value, Failure> {
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
    Ok(json!({
        "scene": scene.name(),
        "state": state,
        "lod_seconds": lod.median(),
        "plain_seconds": plain.median(),
        "paper_lod_seconds": paper_lod,
        "paper_plain_seconds": paper.plain,
        "ratio": lod.ratio_to(plain),
        "paper_ratio": paper_lod / paper.plain,
        "bound_ratio": bound[state - 1],
        "lod_rays": RayCounts::from(lod.first),
        "plain_rays": RayCounts::from(plain.first),
        "lod_steps": lod.first.steps,
        "plain_steps": plain.first.steps,
        "steps_ratio": steps_ratio(lod.first.steps),
        "cut_seconds": cut.median(),
        "bookkeeping": (same > SAME_WORK).then(|| levels.ratio_to(plain) / same - 1.0),
    }))
}
