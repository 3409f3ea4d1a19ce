//! `shisen-evidence bench sweep`: whether a gaze can make level of detail dearer.

use super::frames::{FrameArguments, Frames, Look, Way};
use super::{numbers, text};
use crate::table::Table;
use clap::Args;
use glam::DVec3;
use serde_json::{Value, json};
use shisen::cave::look::ViewDirection;
use shisen::cli::numbers::whole;
use shisen::cli::output::failure::Failure;
use shisen::live::quantiles::median;
use shisen::render::Filling;
use shisen::scene::builtin::PaperScene;

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
            json!({ "ratio": ratio(gaze), "look": gaze.look.to_array() })
        };
        scenes.push(json!({
            "scene": scene.name(),
            "worst_steps": worst(|gaze| gaze.steps),
            "worst_time": worst(Gaze::time),
            "mean_steps": mean_steps,
            "mean_time": mean_time,
        }));
    }
    let look = |key: &'static str| {
        move |scene: &Value| {
            let look = scene[key]["look"].as_array().into_iter().flatten();
            let look = look.map(|x| format!("{:.2}", x.as_f64().unwrap_or(f64::NAN)));
            look.collect::<Vec<_>>().join(", ")
        }
    };
    let table = Table::new(&scenes).text("scene", |one| text(one, "scene"));
    let table = numbers(table, &[("steps at worst", "/worst_steps/ratio", 1.0, 3)])
        .text("looking along", look("worst_steps"));
    let fields = [
        ("mean", "/mean_steps", 1.0, 3),
        ("time at worst", "/worst_time/ratio", 1.0, 3),
    ];
    let table = numbers(table, &fields).text("looking along", look("worst_time"));
    let table = numbers(table, &[("mean", "/mean_time", 1.0, 3)]);
    let report = json!({ "directions": directions, "scenes": scenes });
    let compared = "level of detail against plain tracing";
    frames.print(
        report,
        &format!(", {directions} directions; {compared}\n{table:#}"),
    )
}

/// A point of a Fibonacci spiral of `count` points, evenly spread over the sphere.
fn direction(number: u32, count: u32) -> DVec3 {
    let height = 1.0 - (2.0 * f64::from(number) + 1.0) / f64::from(count);
    let turn = f64::from(number) * std::f64::consts::PI * (3.0 - 5.0f64.sqrt());
    let radius = (1.0 - height * height).sqrt();
    DVec3::new(radius * turn.cos(), height, radius * turn.sin())
}
