//! `shisen-evidence bench sweep`: whether a gaze can make level of detail dearer.

use super::frames::{FrameArguments, Frames, Look, Way};
use crate::table::Table;
use clap::Args;
use glam::DVec3;
use schemars::JsonSchema;
use serde::Serialize;
use shisen::cave::look::ViewDirection;
use shisen::cli::numbers::whole;
use shisen::cli::output::failure::Failure;
use shisen::live::quantiles::median;
use shisen::render::Filling;
use shisen::scene::builtin::PaperScene;

/// Level of detail against plain tracing for gazes all around
///
/// For each of scenes A to D, directions spread evenly over the sphere; frames
/// with and without level of detail are rendered in turns. The greatest of hundreds of medians
/// is likely a disturbed one: the direction with the greatest ratio of times is measured again
/// with ten times as many pairs, until that direction has been.
#[derive(Debug, Args)]
pub(in crate::cli) struct Arguments {
    #[command(flatten)]
    frames: FrameArguments,
    /// How many directions
    #[arg(long, value_name = "N", default_value_t = 200,
          value_parser = whole::<u32>(1..=100_000))]
    directions: u32,
}

/// Level of detail against plain tracing for gazes all around.
#[derive(Debug, Serialize, JsonSchema)]
pub(in crate::cli) struct Report {
    /// How many directions.
    directions: u32,
    /// Scenes A to D.
    scenes: Vec<Ratios>,
}

/// Ratios of level of detail to plain tracing in a scene.
#[derive(Debug, Serialize, JsonSchema)]
struct Ratios {
    /// Scene of the paper: A, B, C or D.
    scene: &'static str,
    /// The greatest ratio of steps.
    worst_steps: Worst,
    /// The greatest ratio of times: each direction's is the median of the ratios of its pairs.
    worst_time: Worst,
    /// The mean ratio of steps.
    mean_steps: f64,
    /// The mean ratio of times.
    mean_time: f64,
}

#[derive(Debug, Serialize, JsonSchema)]
struct Worst {
    /// The ratio.
    ratio: f64,
    /// Where the viewer looks with this ratio: x, y and z.
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

/// Returns the gaze with the greatest ratio, the first of equal ones.
fn worst(gazes: &mut [Gaze], ratio: impl Fn(&Gaze) -> f64) -> &mut Gaze {
    let (mut at, mut greatest) = (0, f64::NEG_INFINITY);
    for (number, ratio) in gazes.iter().map(ratio).enumerate() {
        if ratio > greatest {
            (at, greatest) = (number, ratio);
        }
    }
    &mut gazes[at]
}

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
        scenes.push(Ratios {
            scene: scene.name(),
            worst_steps: worst(|gaze| gaze.steps),
            worst_time: worst(Gaze::time),
            mean_steps,
            mean_time,
        });
    }
    let look = |worst: &Worst| worst.look.map(|x| format!("{x:.2}")).join(", ");
    let table = Table::new(&scenes)
        .text("scene", |one| one.scene.to_owned())
        .number("steps at worst", 3, |one| one.worst_steps.ratio)
        .text("looking along", |one| look(&one.worst_steps))
        .number("mean", 3, |one| one.mean_steps)
        .number("time at worst", 3, |one| one.worst_time.ratio)
        .text("looking along", |one| look(&one.worst_time))
        .number("mean", 3, |one| one.mean_time);
    let compared = "level of detail against plain tracing";
    let text = format!(", {directions} directions; {compared}\n{table:#}");
    frames.print(Report { directions, scenes }, &text)
}

/// Returns a point of a Fibonacci spiral of `count` points, evenly spread over the sphere.
fn direction(number: u32, count: u32) -> DVec3 {
    let height = 1.0 - (2.0 * f64::from(number) + 1.0) / f64::from(count);
    let turn = f64::from(number) * std::f64::consts::PI * (3.0 - 5.0f64.sqrt());
    let radius = (1.0 - height * height).sqrt();
    DVec3::new(radius * turn.cos(), height, radius * turn.sin())
}
