//! `shisen bench sweep`: whether a gaze can make level of detail dearer.

use super::super::failure::Failure;
use super::super::print;
use super::frames::{FrameArguments, Way, median};
use clap::Args;
use glam::DVec3;
use serde::Serialize;
use shisen::look::ViewDirection;
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
/// direction are the median of the ratios of pairs.
#[derive(Debug, Args)]
pub(in crate::cli) struct Arguments {
    #[command(flatten)]
    frames: FrameArguments,
    /// How many directions
    #[arg(long, value_name = "N", default_value_t = 200,
          value_parser = clap::value_parser!(u32).range(1..=100_000))]
    directions: u32,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

/// What was measured.
#[derive(Debug, Serialize)]
struct Report {
    threads: usize,
    size: u32,
    mesh: String,
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

impl Worst {
    const NONE: Self = Self {
        ratio: 0.0,
        look: [0.0; 3],
    };

    fn take(&mut self, ratio: f64, look: DVec3) {
        if ratio > self.ratio {
            *self = Self {
                ratio,
                look: look.to_array(),
            };
        }
    }
}

/// Runs the command.
pub(in crate::cli) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let frames = &arguments.frames;
    let (mesh, threads) = frames.title();
    let mut scenes = Vec::new();
    for scene in PaperScene::ALL {
        let of_scene = frames.frames(scene)?;
        let mut report = OfScene {
            scene: scene.name(),
            worst_steps: Worst::NONE,
            worst_time: Worst::NONE,
            mean_steps: 0.0,
            mean_time: 0.0,
        };
        let share = 1.0 / f64::from(arguments.directions);
        for number in 0..arguments.directions {
            let look = direction(number, arguments.directions);
            let up = ViewDirection::new(look).map_or(DVec3::Y, |look| look.basis().up);
            let render = |way| of_scene.render(way, look.as_vec3(), up.as_vec3());
            let mut ratios = Vec::new();
            let mut steps = 0.0;
            for _ in 0..frames.repeat {
                let (plain, plain_work) = render(Way::Plain)?;
                let (lod, lod_work) = render(Way::Lod)?;
                ratios.push(lod / plain);
                steps = lod_work.steps as f64 / plain_work.steps as f64;
            }
            let time = median(ratios);
            report.worst_steps.take(steps, look);
            report.worst_time.take(time, look);
            report.mean_steps += steps * share;
            report.mean_time += time * share;
        }
        scenes.push(report);
    }
    let report = Report {
        threads,
        size: frames.size,
        mesh,
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
        let Self {
            threads,
            size,
            mesh,
            directions,
            scenes,
        } = self;
        write!(
            f,
            "{mesh}, {size} × {size} pixels × 6, threads: {threads}, {directions} directions; \
             level of detail against plain tracing"
        )?;
        for scene in scenes {
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
