//! `shisen bake`: scenes and meshes to the bytes that the core traces.

use crate::bake::Layout;
use crate::cli::arguments::levels::Level;
use crate::cli::arguments::source::{Loaded, Shown, Source, Told, bake, is_model, load_mesh};
use crate::cli::arguments::{LevelArguments, ModelArguments, SceneName};
use crate::cli::output::progress::Ticker;
use crate::cli::prelude::*;
use crate::files::write_atomically;
use crate::scene::Scene;
use shisen_core::scene::format::LARGEST_SIDE;

/// Bakes a scene for tracing
#[derive(Debug, Clone, Args)]
pub(super) struct Arguments {
    /// A model, a TOML scene or a built-in one such as A or prism; or several models, each of which
    /// becomes an object where its file places it
    #[arg(required_unless_present = "scene", conflicts_with = "scene")]
    input: Vec<SceneName>,
    /// One input, as other commands take it
    #[arg(long, value_name = "SCENE")]
    scene: Option<SceneName>,
    /// File of the baked scene
    #[arg(short, long, visible_alias = "out", value_name = "FILE")]
    output: PathBuf,
    #[command(flatten)]
    model: ModelArguments,
    /// Layout of the tree's nodes
    #[arg(long, value_enum, default_value = "fast")]
    layout: Layout,
    #[command(flatten)]
    levels: LevelArguments,
    /// Halve textures, and the picture around the scene, until no side has more pixels than this
    #[arg(long, value_name = "PIXELS", value_parser = whole::<u32>(1..=LARGEST_SIDE))]
    textures: Option<u32>,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

/// A baked scene.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct Report {
    /// File of the baked scene.
    path: String,
    /// Size of the file.
    bytes: usize,
    /// fast or compact.
    layout: &'static str,
    /// Objects in the scene.
    objects: usize,
    /// Triangles of all meshes at their finest levels.
    triangles: usize,
    /// Nodes of all trees.
    nodes: usize,
    /// Leaves of all trees.
    leaves: usize,
    /// Most stack entries that a ray can need.
    stack_entries: u32,
    /// Polygon levels of the meshes.
    levels: Vec<Level>,
    #[serde(flatten)]
    shown: Shown,
    /// Largest difference between the faces that a pixel sees and those of the paper's equation
    /// 10, as a share of MAX - MIN; null without --faces and --levels.
    largest_deviation: Option<f64>,
    /// Time to read, build and write.
    seconds: f64,
}

/// Refuses an output that would overwrite an input.
fn check(arguments: &Arguments) -> Result<(), Failure> {
    let Ok(output) = arguments.output.canonicalize() else {
        return Ok(());
    };
    let is_output = |name: &&SceneName| match name {
        SceneName::File(path) => path.canonicalize().is_ok_and(|path| path == output),
        _ => false,
    };
    match arguments.input.iter().find(is_output) {
        None => Ok(()),
        Some(name) => Err(misuse!(
            "--output would overwrite the input {name}: give the baked scene another name, such \
             as scene.shisen"
        )),
    }
}

pub(super) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let mut arguments = arguments.clone();
    arguments.input.extend(arguments.scene.take());
    let arguments = &arguments;
    check(arguments)?;
    let start = Instant::now();
    let names: Vec<_> = arguments.input.iter().map(ToString::to_string).collect();
    let ticker = Ticker::start(format!("reading {}", names.join(", ")), false);
    let (mut scene, shown) = load(arguments)?;
    if let Some(most) = arguments.textures {
        scene.fit_textures(most);
    }
    let layout = arguments.layout;
    let asked = arguments.levels.given();
    let levels = asked.map(|_| arguments.levels.polygon_levels(layout));
    let levels = levels.transpose()?;
    let (baked, _) = bake(&scene, &shown.scene, layout, levels.as_ref(), &ticker)?;
    drop(ticker);
    let path = &arguments.output;
    write_atomically(path, |file| file.write_all(baked.as_bytes())).map_err(Fault::write(path))?;
    let ((nodes, leaves, _), objects, stack_entries) = with_scene!(baked.scene(), |scene| (
        scene.sizes(),
        scene.instances().len(),
        scene.stack_entries(),
    ));
    let of_meshes = Level::of(&baked);
    let largest_deviation = levels.map(|asked| {
        let deviations = Level::by_mesh(&of_meshes).map(|levels| {
            let faces: Vec<u32> = levels.iter().map(|level| level.faces).collect();
            asked.largest_deviation(&faces)
        });
        deviations.fold(0.0, f64::max)
    });
    let report = Report {
        path: path.display().to_string(),
        bytes: baked.as_bytes().len(),
        layout: layout.name(),
        objects,
        triangles: Level::finest_faces(&of_meshes),
        nodes,
        leaves,
        stack_entries,
        largest_deviation,
        levels: of_meshes,
        shown,
        seconds: start.elapsed().as_secs_f64(),
    };
    print(&report, arguments.json)
}

fn load(arguments: &Arguments) -> Result<(Scene, Shown), Failure> {
    let Arguments { input, model, .. } = arguments;
    let meshes = input.iter().filter_map(|name| match name {
        SceneName::File(path) if is_model(path) => Some(path),
        _ => None,
    });
    let meshes: Vec<_> = meshes.collect();
    match input.as_slice() {
        [name] => {
            let Source { scene, shown, .. } = Source::load(name, model)?;
            match scene {
                Loaded::Described(scene) => {
                    if !scene.motion.is_empty() {
                        warn(&format!(
                            "{name}: a baked scene stands still, as at 0 s: give {name} itself to \
                             `shisen run` to see it move"
                        ));
                    }
                    Ok((*scene, shown))
                }
                Loaded::Baked(_) => {
                    let message = format!("{name} is baked already");
                    Err(Fault::new(message, "give what it was baked from").into())
                }
            }
        }
        all if meshes.len() < all.len() => Err(misuse!(
            "several inputs must all be models, such as .obj and .glb files: bake one scene at a time"
        )),
        _ if model.is_given() => Err(misuse!(
            "--mesh, --normals, --scale, --camera, --exposure, --animation and --time are for one \
             scene: several models stand where their files place them"
        )),
        all => {
            let mut told = Told::default();
            let meshes = meshes.into_iter();
            let meshes = meshes.map(|path| load_mesh(path, &mut told));
            let scene = Scene::of_meshes(meshes.collect::<Result<_, _>>()?);
            let names: Vec<String> = all.iter().map(ToString::to_string).collect();
            let shown = Shown {
                scene: names.join(", "),
                mesh: None,
                exposure: Some(0.0),
                told,
            };
            Ok((scene, shown))
        }
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (path, objects, triangles) = (&self.path, self.objects, self.triangles);
        let (bytes, layout, seconds) = (self.bytes, self.layout, self.seconds);
        let objects = counted(objects as u64, "object");
        write!(
            f,
            "{path}: {}, {objects}, {}, ",
            self.shown,
            counted(triangles as u64, "triangle")
        )?;
        write!(f, "{bytes} bytes in the {layout} layout, ")?;
        write!(f, "baked in {seconds:.2} s")?;
        let Some(deviation) = self.largest_deviation else {
            return Ok(());
        };
        for levels in Level::by_mesh(&self.levels) {
            write!(f, "\nmesh {}:", levels[0].mesh)?;
            for level in levels {
                write!(f, " {}", level.faces)?;
            }
            f.write_str(" faces")?;
        }
        write!(
            f,
            "\nA pixel sees at most {:.1} % of the range of faces more or fewer than its level of \
             detail asks for.",
            100.0 * deviation
        )
    }
}
