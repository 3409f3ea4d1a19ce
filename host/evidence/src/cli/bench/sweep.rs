//! `shisen-evidence bench sweep`: whether a gaze can make level of detail dearer.

use super::frames::{FrameArguments, Frames, Look, Title, Way};
use crate::table::Table;
use clap::Args;
use glam::DVec3;
use serde::Serialize;
use shisen::cave::look::ViewDirection;
use shisen::cli::arguments::whole;
use shisen::cli::output::failure::Failure;
use shisen::cli::output::print;
use shisen::live::quantiles::median;
use shisen::render::Filling;
use shisen::scene::builtin::PaperScene;
use std::fmt;

/// Level of detail against plain tracing for gazes all around
///
/// For each of scenes A to D, directions spread evenly over the sphere; frames
/// with and without level of detail are rendered in turns.
///
/// With --json, one object: threads, size, mesh, directions and scenes: for each
/// `worst_steps` and `worst_time` (ratio to plain tracing, and the look with that ratio),
/// `mean_steps` and `mean_time`. The time of a direction is the median of the ratios of pairs.
/// The greatest of hundreds of medians is likely a disturbed one: the worst direction is
/// measured again with ten times as many pairs, until the worst one has been.
#[derive(Debug, Args)]
pub(in crate::cli) struct Arguments {
    #[command(flatten)]
    frames: FrameArguments,
    /// How many directions
    #[arg(long, value_name = "N", default_value_t = 200,
          value_parser = whole::<u32>(1..=100_000))]
    directions: u32,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Serialize)]
struct Report {
    #[serde(flatten)]
    title: Title,
    directions: u32,
    scenes: Vec<SceneRatios>,
}

#[derive(Debug, Serialize)]
struct SceneRatios {
    scene: &'static str,
    worst_steps: Worst,
    worst_time: Worst,
    mean_steps: f64,
    mean_time: f64,
}

/// The greatest ratio, and its line of sight.
#[derive(Debug, Clone, Copy, Serialize)]
struct Worst {
    ratio: f64,
    look: [f64; 3],
}

/// How many times as many pairs the worst gaze is measured with.
const AGAIN: u32 = 10;

/// Ratios of level of detail to plain tracing, along one line of sight.
#[derive(Debug, Clone)]
struct Gaze {
    look: DVec3,
    /// The ratio of times of each pair of frames.
    ratios: Vec<f64>,
    steps: f64,
}

impl Gaze {
    /// Adds pairs of frames; each way comes first in every other pair.
    fn measure(&mut self, frames: &Frames, pairs: u32) -> Result<(), Failure> {
        let up = ViewDirection::new(self.look).map_or(DVec3::Y, |look| look.basis().up);
        let look = Look {
            forward: self.look.as_vec3(),
            up: up.as_vec3(),
        };
        let render = |way| frames.frame(way, look, Filling::Background);
        for pair in 0..pairs {
            let (plain, lod) = if pair % 2 == 0 {
                (render(Way::Plain)?, render(Way::Lod)?)
            } else {
                let lod = render(Way::Lod)?;
                (render(Way::Plain)?, lod)
            };
            self.ratios.push(lod.seconds / plain.seconds);
            self.steps = lod.statistics.steps as f64 / plain.statistics.steps as f64;
        }
        Ok(())
    }

    fn time(&self) -> f64 {
        median(self.ratios.clone())
    }
}

/// The gaze with the greatest ratio, the first of equal ones.
fn worst(gazes: &mut [Gaze], ratio: impl Fn(&Gaze) -> f64) -> &mut Gaze {
    let (mut at, mut greatest) = (0, f64::NEG_INFINITY);
    for (number, ratio) in gazes.iter().map(ratio).enumerate() {
        if ratio > greatest {
            (at, greatest) = (number, ratio);
        }
    }
    &mut gazes[at]
}

/// Runs the command.
pub(in crate::cli) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let (frames, directions) = (&arguments.frames, arguments.directions);
    let mut scenes = Vec::new();
    for scene in PaperScene::ALL {
        let rendered = frames.frames(scene)?;
        let mut gazes = Vec::new();
        for number in 0..directions {
            let mut gaze = Gaze {
                look: direction(number, directions),
                ratios: Vec::new(),
                steps: 0.0,
            };
            gaze.measure(&rendered, frames.repeat)?;
            gazes.push(gaze);
        }
        loop {
            let worst = worst(&mut gazes, Gaze::time);
            if worst.ratios.len() > frames.repeat as usize {
                break;
            }
            worst.measure(&rendered, (AGAIN - 1) * frames.repeat)?;
        }
        let mean =
            |ratio: fn(&Gaze) -> f64| gazes.iter().map(ratio).sum::<f64>() / f64::from(directions);
        let (mean_steps, mean_time) = (mean(|gaze| gaze.steps), mean(Gaze::time));
        let mut worst = |ratio: fn(&Gaze) -> f64| {
            let gaze = worst(&mut gazes, ratio);
            Worst {
                ratio: ratio(gaze),
                look: gaze.look.to_array(),
            }
        };
        scenes.push(SceneRatios {
            scene: scene.name(),
            worst_steps: worst(|gaze| gaze.steps),
            worst_time: worst(Gaze::time),
            mean_steps,
            mean_time,
        });
    }
    let report = Report {
        title: frames.title(),
        directions,
        scenes,
    };
    print(&report, arguments.json)
}

/// A point of a Fibonacci spiral of `count` points, evenly spread over the sphere.
fn direction(number: u32, count: u32) -> DVec3 {
    let height = 1.0 - (2.0 * f64::from(number) + 1.0) / f64::from(count);
    let turn = f64::from(number) * std::f64::consts::PI * (3.0 - 5.0f64.sqrt());
    let radius = (1.0 - height * height).sqrt();
    DVec3::new(radius * turn.cos(), height, radius * turn.sin())
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let look = |worst: &Worst| {
            let [x, y, z] = worst.look;
            format!("{x:.2}, {y:.2}, {z:.2}")
        };
        let table = Table::new(&self.scenes)
            .text("scene", |one| one.scene.to_owned())
            .number("steps at worst", 3, |one| Some(one.worst_steps.ratio))
            .text("looking along", |one| look(&one.worst_steps))
            .number("mean", 3, |one| Some(one.mean_steps))
            .number("time at worst", 3, |one| Some(one.worst_time.ratio))
            .text("looking along", |one| look(&one.worst_time))
            .number("mean", 3, |one| Some(one.mean_time));
        write!(
            f,
            "{}, {} directions; level of detail against plain tracing\n{table:#}",
            self.title, self.directions
        )
    }
}
