//! `shisen-evidence bench motion`: how long it takes to move a scene.

use super::print;
use clap::Args;
use glam::{DAffine3, DQuat, DVec3};
use schemars::JsonSchema;
use serde::Serialize;
use shisen::bake::{Baked, Stage, StageMemory};
use shisen::cli::arguments::source::{Loaded, Source};
use shisen::cli::arguments::{ModelArguments, SceneName};
use shisen::cli::numbers::whole;
use shisen::cli::output::failure::Failure;
use shisen::files::Fault;
use shisen::live::quantiles::median;
use shisen::scene::quadruped::quadruped;
use shisen::scene::{Object, Scene, Shape};
use shisen_core::scene::Poses;
use shisen_core::scene::format::Node;
use std::time::Instant;

/// Seconds between the frames of a scene.
const STEP: f64 = 1.0 / 60.0;

/// Times how long instances and deforming meshes take to move, on one thread
///
/// Without --scene a crowd of animals moves, each by itself: 1,000 instances of one mesh. A scene
/// that moves is taken through its animation instead.
#[derive(Debug, Args)]
pub(in crate::cli) struct Arguments {
    /// A model or a scene file that moves
    #[arg(long, value_name = "FILE")]
    scene: Option<SceneName>,
    /// Instances of the crowd
    #[arg(long, value_name = "N", default_value_t = 1_000, conflicts_with = "scene",
          value_parser = whole::<u32>(1..=100_000))]
    instances: u32,
    /// Frames to time
    #[arg(long, value_name = "N", default_value_t = 120, value_parser = whole::<u32>(1..=100_000))]
    frames: u32,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

/// What the movement took.
#[derive(Debug, Serialize, JsonSchema)]
pub(in crate::cli) struct Report {
    /// What moved: crowd, or the scene's name.
    scene: String,
    /// Instances in the scene.
    instances: usize,
    /// Triangles of all meshes.
    triangles: usize,
    /// Median time of a frame's movement, milliseconds.
    milliseconds: f64,
    /// Longest one.
    longest_milliseconds: f64,
    /// Time of a bake of the scene, milliseconds.
    bake_milliseconds: f64,
    /// The median as a part of that.
    part_of_bake: f64,
}

pub(in crate::cli) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build();
    let pool = pool.map_err(Failure::from_error)?;
    let report = pool.install(|| measure(arguments))?;
    let text = format!(
        "{}: {} instances, {} triangles: {:.3} ms a frame at the median, {:.3} at most; a bake takes \
         {:.0} ms, {:.0} times as long",
        report.scene,
        report.instances,
        report.triangles,
        report.milliseconds,
        report.longest_milliseconds,
        report.bake_milliseconds,
        report.part_of_bake.recip()
    );
    print(arguments.json, &report, &text)
}

fn measure(arguments: &Arguments) -> Result<Report, Failure> {
    let source = match &arguments.scene {
        None => crowd(arguments.instances),
        Some(name) => moving(name)?,
    };
    let begun = Instant::now();
    let baked = Baked::<8>::new(&source).map_err(Failure::from_error)?;
    let bake_milliseconds = 1e3 * begun.elapsed().as_secs_f64();
    let scene = baked.scene();
    let mut times = Vec::new();
    let mut time = |work: &mut dyn FnMut() -> Result<(), Failure>| {
        let begun = Instant::now();
        work()?;
        times.push(1e3 * begun.elapsed().as_secs_f64());
        Ok::<(), Failure>(())
    };
    if arguments.scene.is_some() {
        let mut memory = StageMemory::of(&scene, &source);
        let stage = Stage::new(scene, &source, &mut memory);
        let mut stage = stage.map_err(Failure::from_error)?;
        for frame in 0..arguments.frames {
            time(&mut || {
                let moved = stage.set_time(f64::from(frame) * STEP);
                moved.map_err(Failure::from_error)
            })?;
        }
    } else {
        let mut top = vec![Node::EMPTY; scene.top_nodes()];
        let mut instances = scene.instances().to_vec();
        let poses = Poses::new(scene, &mut top, &mut instances);
        let mut poses = poses.map_err(Failure::from_error)?;
        for frame in 0..arguments.frames {
            time(&mut || {
                for number in 0..arguments.instances {
                    let place = place(number, f64::from(frame));
                    let moved = poses.set(number as usize, &place);
                    moved.map_err(Failure::from_error)?;
                }
                poses.refit();
                Ok(())
            })?;
        }
    }
    let longest_milliseconds = times.iter().copied().fold(0.0, f64::max);
    let milliseconds = median(times);
    Ok(Report {
        scene: source.name,
        instances: scene.instances().len(),
        triangles: scene.sizes().2,
        milliseconds,
        longest_milliseconds,
        bake_milliseconds,
        part_of_bake: milliseconds / bake_milliseconds,
    })
}

fn moving(name: &SceneName) -> Result<Scene, Failure> {
    let source = Source::load(name, &ModelArguments::default())?;
    match source.scene {
        Loaded::Described(scene) if !scene.motion.is_empty() => Ok(*scene),
        _ => {
            let message = format!("nothing in {name} moves");
            Err(Fault::new(message, "give a scene with animations that is not baked").into())
        }
    }
}

/// Returns animals in rows on a floor.
fn crowd(count: u32) -> Scene {
    let objects = (0..count).map(|number| Object {
        world_from_object: place(number, 0.0),
        ..Object::new(Shape::Mesh(0))
    });
    Scene {
        name: "crowd".into(),
        meshes: vec![quadruped()],
        objects: objects.collect(),
        ..Scene::default()
    }
}

/// Returns where an animal is at a frame: it turns, and walks a circle.
fn place(number: u32, frame: f64) -> DAffine3 {
    let (row, column) = (f64::from(number / 40), f64::from(number % 40));
    let angle = 0.02 * frame + 2.4 * f64::from(number);
    let circle = DVec3::new(angle.sin(), 0.0, angle.cos());
    let place = 3.0 * DVec3::new(column, 0.0, row) + 0.8 * circle;
    DAffine3::from_scale_rotation_translation(
        DVec3::splat(0.2),
        DQuat::from_rotation_y(angle),
        place,
    )
}
