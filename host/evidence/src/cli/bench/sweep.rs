//! `shisen-evidence bench sweep`: whether a gaze can make level of detail dearer.

use super::cells::Title;
use super::frames::{FrameArguments, Frames, Way};
use clap::Args;
use glam::DVec3;
use serde::Serialize;
use shisen::cave::look::ViewDirection;
use shisen::cli::arguments::whole;
use shisen::cli::output::failure::Failure;
use shisen::cli::output::print;
use shisen::live::quantiles::median;
use shisen::scene::builtin::PaperScene;
use std::fmt;

/// Level of detail against plain tracing for gazes all around
///
/// For each of scenes A to D, directions spread evenly over the sphere; frames
/// with and without level of detail are rendered in turns.
///
/// With --json, one object: threads, size, mesh, directions and scenes: for
/// each `worst_steps` and `worst_time` (ratio to plain tracing, and the look
/// that it was found at), and `mean_steps` and `mean_time`. Times of one
/// direction are the median of the ratios of pairs. Of hundreds of medians of a
/// few the greatest is that of the most disturbed: the direction that is worst
/// is measured again with ten times as many pairs, until the worst is one that
/// was.
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

/// What was measured.
#[derive(Debug, Serialize)]
struct Report {
    #[serde(flatten)]
    title: Title,
    directions: u32,
    scenes: Vec<OfScene>,
}

#[derive(Debug, Serialize)]
struct OfScene {
    scene: &'static str,
    worst_steps: Worst,
    worst_time: Worst,
    mean_steps: f64,
    mean_time: f64,
}

/// The greatest ratio, and where.
#[derive(Debug, Clone, Copy, Serialize)]
struct Worst {
    ratio: f64,
    look: [f64; 3],
}

/// How many times as many pairs the worst gaze is measured with.
const AGAIN: u32 = 10;

/// Level of detail to plain tracing, along one line of sight.
#[derive(Debug, Clone)]
struct Measured {
    look: DVec3,
    /// Of the time of each pair of frames.
    ratios: Vec<f64>,
    steps: f64,
}

impl Measured {
    const fn new(look: DVec3) -> Self {
        Self {
            look,
            ratios: Vec::new(),
            steps: 0.0,
        }
    }

    /// So many pairs of frames more, each frame first in every other one.
    fn measure(&mut self, frames: &Frames, pairs: u32) -> Result<(), Failure> {
        let up = ViewDirection::new(self.look).map_or(DVec3::Y, |look| look.basis().up);
        let render = |way| frames.render(way, self.look.as_vec3(), up.as_vec3());
        for pair in 0..pairs {
            let ((plain, plain_work), (lod, lod_work)) = if pair % 2 == 0 {
                let plain = render(Way::Plain)?;
                (plain, render(Way::Lod)?)
            } else {
                let lod = render(Way::Lod)?;
                (render(Way::Plain)?, lod)
            };
            self.ratios.push(lod / plain);
            self.steps = lod_work.steps as f64 / plain_work.steps as f64;
        }
        Ok(())
    }

    fn time(&self) -> f64 {
        median(self.ratios.clone())
    }
}

/// Where a ratio is greatest, among one gaze or more.
fn worst(gazes: &mut [Measured], of: impl Fn(&Measured) -> f64) -> &mut Measured {
    let (mut at, mut greatest) = (0, f64::NEG_INFINITY);
    for (number, ratio) in gazes.iter().map(of).enumerate() {
        if ratio > greatest {
            (at, greatest) = (number, ratio);
        }
    }
    &mut gazes[at]
}

/// Runs the command.
pub(in crate::cli) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let frames = &arguments.frames;
    let mut scenes = Vec::new();
    for scene in PaperScene::ALL {
        let of_scene = frames.frames(scene)?;
        let mut gazes = Vec::new();
        for number in 0..arguments.directions {
            let mut gaze = Measured::new(direction(number, arguments.directions));
            gaze.measure(&of_scene, frames.repeat)?;
            gazes.push(gaze);
        }
        loop {
            let worst = worst(&mut gazes, Measured::time);
            if worst.ratios.len() > frames.repeat as usize {
                break;
            }
            worst.measure(&of_scene, (AGAIN - 1) * frames.repeat)?;
        }
        let mean = |of: &dyn Fn(&Measured) -> f64| {
            gazes.iter().map(of).sum::<f64>() / f64::from(arguments.directions)
        };
        let (mean_steps, mean_time) = (mean(&|gaze| gaze.steps), mean(&Measured::time));
        let mut worst = |of: fn(&Measured) -> f64| {
            let gaze = worst(&mut gazes, of);
            Worst {
                ratio: of(gaze),
                look: gaze.look.to_array(),
            }
        };
        let report = OfScene {
            scene: scene.name(),
            worst_steps: worst(|gaze| gaze.steps),
            worst_time: worst(Measured::time),
            mean_steps,
            mean_time,
        };
        scenes.push(report);
    }
    let report = Report {
        title: frames.title(),
        directions: arguments.directions,
        scenes,
    };
    print(&report, arguments.json)
}

/// Points of a Fibonacci spiral: evenly spread over the sphere.
fn direction(number: u32, of: u32) -> DVec3 {
    let height = 1.0 - (2.0 * f64::from(number) + 1.0) / f64::from(of);
    let turn = f64::from(number) * std::f64::consts::PI * (3.0 - 5.0f64.sqrt());
    let radius = (1.0 - height * height).sqrt();
    DVec3::new(radius * turn.cos(), height, radius * turn.sin())
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{}, {} directions; level of detail against plain tracing",
            self.title, self.directions
        )?;
        for scene in &self.scenes {
            let at = |worst: &Worst| {
                let [x, y, z] = worst.look;
                format!("{:.3} (looking along {x:.2}, {y:.2}, {z:.2})", worst.ratio)
            };
            write!(
                f,
                "\n{}: steps at worst {}, mean {:.3}; time at worst {}, mean {:.3}",
                scene.scene,
                at(&scene.worst_steps),
                scene.mean_steps,
                at(&scene.worst_time),
                scene.mean_time
            )?;
        }
        Ok(())
    }
}
