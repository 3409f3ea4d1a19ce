//! `shisen-evidence bench motion`: how long it takes to move a scene.

use super::print;
use crate::walker::walker;
use clap::Args;
use glam::{DAffine3, DQuat, DVec3};
use schemars::JsonSchema;
use serde::Serialize;
use shisen::bake::{Baked, Stage, StageMemory};
use shisen::cli::arguments::source::{Loaded, Source};
use shisen::cli::arguments::{ModelArguments, SceneName};
use shisen::cli::numbers::whole;
use shisen::cli::output::counted;
use shisen::cli::output::failure::Failure;
use shisen::files::{Fault, write_atomically};
use shisen::live::quantiles::median;
use shisen::scene::quadruped::quadruped;
use shisen::scene::{Object, Scene, Shape};
use shisen_core::scene::format::Node;
use shisen_core::scene::{self as core, PoseError, Poses};
use std::fmt;
use std::path::PathBuf;
use std::time::Instant;

/// Seconds between the frames of a scene.
const STEP: f64 = 1.0 / 60.0;

/// Times how long instances and deforming meshes take to move, on one thread
///
/// 1,000 animals walk in circles, each a copy of one mesh. Then one animal of 92,864 triangles walks
/// on ten joints, or a scene of your own moves.
#[derive(Debug, Args)]
pub(in crate::cli) struct Arguments {
    /// A model or a scene file that moves, in place of the animal
    #[arg(long, value_name = "FILE")]
    scene: Option<SceneName>,
    /// Write the animal, as a binary glTF file
    #[arg(long, value_name = "FILE.glb")]
    write: Option<PathBuf>,
    /// Copies in the crowd
    #[arg(long, value_name = "N", default_value_t = 1_000, value_parser = whole::<u32>(1..=100_000))]
    crowd: u32,
    /// Frames to time
    #[arg(long, value_name = "N", default_value_t = 120, value_parser = whole::<u32>(1..=100_000))]
    frames: u32,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

/// What the movements took.
#[derive(Debug, Serialize, JsonSchema)]
pub(in crate::cli) struct Report {
    /// The crowd: poses and boxes alone.
    crowd: Movement,
    /// The animal or the scene: also keys, joints and trees.
    animation: Movement,
}

#[derive(Debug, Serialize, JsonSchema)]
struct Movement {
    /// What moved.
    scene: String,
    /// Instances in the scene.
    instances: usize,
    /// Triangles of all meshes.
    triangles: usize,
    /// Median time of a frame's movement, milliseconds.
    milliseconds: f64,
    /// The longest time.
    longest_milliseconds: f64,
    /// Time of a bake of the scene, milliseconds.
    bake_milliseconds: f64,
    /// The median as a part of that.
    part_of_bake: f64,
}

pub(in crate::cli) fn run(arguments: &Arguments) -> Result<(), Failure> {
    if let Some(path) = &arguments.write {
        let animal = walker(0);
        write_atomically(path, |file| file.write_all(&animal)).map_err(Fault::write(path))?;
    }
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build();
    let pool = pool.map_err(Failure::from_error)?;
    let report = pool.install(|| {
        Ok::<_, Failure>(Report {
            crowd: move_crowd(arguments)?,
            animation: animate(arguments)?,
        })
    })?;
    let text = format!("{}\n{}", report.crowd, report.animation);
    print(arguments.json, &report, &text)
}

/// A baked scene, and the time that its bake took.
fn bake(source: &Scene) -> Result<(Baked<8>, f64), Failure> {
    let begun = Instant::now();
    let baked = Baked::<8>::new(source).map_err(Failure::from_error)?;
    Ok((baked, 1e3 * begun.elapsed().as_secs_f64()))
}

/// Times the movement of each frame.
fn time(
    frames: u32,
    scene: &core::FastScene<'_>,
    (name, bake_milliseconds): (&str, f64),
    mut advance: impl FnMut(f64) -> Result<(), PoseError>,
) -> Result<Movement, Failure> {
    let mut times = Vec::new();
    for frame in 0..frames {
        let begun = Instant::now();
        advance(f64::from(frame)).map_err(Failure::from_error)?;
        times.push(1e3 * begun.elapsed().as_secs_f64());
    }
    let longest_milliseconds = times.iter().copied().fold(0.0, f64::max);
    let milliseconds = median(times);
    Ok(Movement {
        scene: name.to_owned(),
        instances: scene.instances().len(),
        triangles: scene.sizes().2,
        milliseconds,
        longest_milliseconds,
        bake_milliseconds,
        part_of_bake: milliseconds / bake_milliseconds,
    })
}

fn move_crowd(arguments: &Arguments) -> Result<Movement, Failure> {
    let (baked, bake_milliseconds) = bake(&crowd(arguments.crowd))?;
    let scene = baked.scene();
    let mut top = vec![Node::EMPTY; scene.top_nodes()];
    let mut instances = scene.instances().to_vec();
    let poses = Poses::new(scene, &mut top, &mut instances);
    let mut poses = poses.map_err(Failure::from_error)?;
    let bake = ("crowd", bake_milliseconds);
    time(arguments.frames, &scene, bake, |frame| {
        for number in 0..arguments.crowd {
            poses.set(number as usize, &place(number, frame))?;
        }
        poses.refit();
        Ok(())
    })
}

fn animate(arguments: &Arguments) -> Result<Movement, Failure> {
    let folder = tempfile::tempdir().map_err(Failure::from_error)?;
    let own = folder.path().join("animal.glb");
    std::fs::write(&own, walker(2)).map_err(Fault::write(&own))?;
    let scene = arguments.scene.clone();
    let source = moving(&scene.unwrap_or(SceneName::File(own)))?;
    let (baked, bake_milliseconds) = bake(&source)?;
    let scene = baked.scene();
    let mut memory = StageMemory::of(&scene, &source);
    let mut stage = Stage::new(scene, &source, &mut memory).map_err(Failure::from_error)?;
    let name = arguments.scene.as_ref().map(ToString::to_string);
    let bake = (name.as_deref().unwrap_or("animal"), bake_milliseconds);
    time(arguments.frames, &scene, bake, |frame| {
        stage.set_time(frame * STEP)
    })
}

impl fmt::Display for Movement {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{}: {} and {} move in {:.3} ms at the median, {:.3} ms at most; a bake takes {:.0} times \
             as long",
            self.scene,
            counted(self.instances as u64, "instance"),
            counted(self.triangles as u64, "triangle"),
            self.milliseconds,
            self.longest_milliseconds,
            self.part_of_bake.recip()
        )
    }
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
