//! `shisen bake`: scenes and meshes to the bytes that the core traces.

use crate::bake::BakedScene;
use crate::bake::simplify::PolygonLevels;
use crate::cli::arguments::levels::Level;
use crate::cli::arguments::source::{Loaded, Source, bake, is_mesh, load_mesh, scene_of_meshes};
use crate::cli::arguments::{LayoutChoice, LevelArguments, Model, SceneName};
use crate::cli::output::failure::{Failure, Fault};
use crate::cli::output::print;
use crate::files::write_atomically;
use crate::scene::Scene;
use crate::with_scene;
use clap::Args;
use serde::Serialize;
use std::fmt;
use std::path::PathBuf;
use std::time::Instant;

/// Bakes a scene for tracing
///
/// With --faces or --levels each mesh is baked at several polygon levels, of
/// which `shisen cave --lod` takes for each ray what the gaze asks for. Without
/// them all rays see every face.
///
/// With --json, one object: path, bytes, layout (fast or compact), objects,
/// triangles (each mesh once, at its finest), nodes, leaves, `stack_entries`
/// (the most that a ray can need), levels (mesh, faces and bytes of each
/// polygon level of each mesh; what the levels of a mesh share does not count),
/// `largest_deviation` (of the faces that a pixel sees from those of the paper's
/// equation 10, as a share of MAX - MIN, what pixels share in blocks included;
/// null without --faces and --levels) and seconds (reading, building and writing).
#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// A TOML scene, a built-in one such as A or prism, or mesh files, each of which becomes an
    /// object
    #[arg(required = true, value_parser = SceneName::parser())]
    input: Vec<SceneName>,
    /// Where the baked scene goes
    #[arg(short, long, visible_alias = "out", value_name = "FILE")]
    output: PathBuf,
    #[command(flatten)]
    model: Model,
    /// For whom it is laid out
    #[arg(long, value_enum, default_value = "fast")]
    layout: LayoutChoice,
    #[command(flatten)]
    levels: LevelArguments,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

/// What was baked.
#[derive(Debug, Serialize)]
struct Report {
    path: String,
    bytes: usize,
    layout: &'static str,
    objects: usize,
    triangles: usize,
    nodes: usize,
    leaves: usize,
    stack_entries: u32,
    levels: Vec<Level>,
    largest_deviation: Option<f64>,
    seconds: f64,
}

/// Runs the command.
pub(super) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let start = Instant::now();
    let scene = load(arguments)?;
    let names: Vec<String> = arguments.input.iter().map(ToString::to_string).collect();
    let layout = arguments.layout.0;
    let asked = arguments.levels.given();
    let levels = asked.map(|_| arguments.levels.polygon_levels(layout));
    let levels = levels.transpose()?;
    let baked = bake(&scene, &names.join(", "), layout, levels.as_ref())?;
    let path = &arguments.output;
    write_atomically(path, |file| file.write_all(baked.as_bytes())).map_err(Fault::write(path))?;
    let report = Report::new(arguments, &baked, levels.as_ref(), start);
    print(&report, arguments.json)
}

fn load(arguments: &Arguments) -> Result<Scene, Failure> {
    let Arguments { input, model, .. } = arguments;
    let meshes: Vec<_> = input
        .iter()
        .filter_map(|name| match name {
            SceneName::File(path) if is_mesh(path) => Some(path),
            _ => None,
        })
        .collect();
    match input.as_slice() {
        [name] if meshes.is_empty() => match Source::load(name, model)?.scene {
            Loaded::Described(scene) => Ok(scene),
            Loaded::Baked(_) => {
                let name = name.to_string();
                Err(Fault::AlreadyBaked { name }.into())
            }
        },
        all if meshes.len() == all.len() => {
            if model.mesh.is_some() || model.normals.is_some() {
                return Err(Failure::usage(
                    "--mesh and --normals are for the built-in scenes A to D, not for mesh files",
                ));
            }
            let meshes = meshes
                .into_iter()
                .map(|path| load_mesh(path))
                .collect::<Result<_, _>>()?;
            Ok(scene_of_meshes(meshes))
        }
        _ => Err(Failure::usage(
            "several inputs must all be meshes (.obj, .ply, .gltf or .glb): bake one scene at a time",
        )),
    }
}

impl Report {
    fn new(
        arguments: &Arguments,
        baked: &BakedScene,
        asked: Option<&PolygonLevels>,
        start: Instant,
    ) -> Self {
        let ((nodes, leaves, _), objects, stack_entries) = with_scene!(baked, |scene| (
            scene.sizes(),
            scene.instances().len(),
            scene.stack_entries(),
        ));
        let levels = Level::of(baked);
        let deviation = |asked: &PolygonLevels| {
            Level::by_mesh(&levels)
                .map(|levels| {
                    let faces: Vec<u32> = levels.iter().map(|level| level.faces).collect();
                    asked.largest_deviation(&faces)
                })
                .fold(0.0, f64::max)
        };
        Self {
            path: arguments.output.display().to_string(),
            bytes: baked.as_bytes().len(),
            layout: baked.layout().name(),
            objects,
            triangles: Level::finest_faces(&levels),
            nodes,
            leaves,
            stack_entries,
            largest_deviation: asked.map(deviation),
            levels,
            seconds: start.elapsed().as_secs_f64(),
        }
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            path,
            bytes,
            layout,
            objects,
            triangles,
            levels,
            largest_deviation,
            seconds,
            ..
        } = self;
        write!(
            f,
            "{path}: {objects} objects, {triangles} triangles, {bytes} bytes in the {layout} layout, \
             baked in {seconds:.2} s"
        )?;
        let Some(deviation) = largest_deviation else {
            return Ok(());
        };
        for levels in Level::by_mesh(levels) {
            write!(f, "\nmesh {}:", levels[0].mesh)?;
            for level in levels {
                write!(f, " {}", level.faces)?;
            }
            f.write_str(" faces")?;
        }
        write!(
            f,
            "\na pixel's are at most {:.1} % of their range from what its level of detail asks for",
            100.0 * deviation
        )
    }
}
