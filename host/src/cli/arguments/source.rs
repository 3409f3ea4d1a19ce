//! Loads the scene that an argument names.

use crate::bake::simplify::PolygonLevels;
use crate::bake::{BakeError, Layout};
use crate::cave::look::ViewDirection;
use crate::cli::arguments::levels::Level;
use crate::cli::arguments::{Exposure, ModelArguments, Normals, SceneName};
use crate::cli::output::progress::Ticker;
use crate::cli::prelude::*;
use crate::files::{MOST, MOST_OF_TEXT, begins_with, read_within};
use crate::scene::Scene;
use crate::scene::builtin::{gallery, grid, paper_scene, prism, spheres};
use crate::scene::file::{BuiltInMesh, MeshSource};
use crate::scene::import::{self, Camera, EXPORT, ImportError, Model};
use crate::scene::mesh::TriangleMesh;
use crate::scene::motion::Playing;
use crate::scene::quadruped::quadruped;
use glam::DVec3;
use serde::Deserialize;
use shisen_core::scene::SceneError;
use shisen_core::scene::format::MAGIC;

pub const BUILT_IN_MESH: &str = "quadruped";

/// Metres.
const GRID_RADIUS: f32 = 100.0;

pub struct Source {
    pub scene: Loaded,
    pub shown: Shown,
    /// Where the viewer looks, if `--camera` says so.
    pub look: Option<DVec3>,
}

/// A scene that is ready to be traced.
pub struct Ready {
    pub baked: BakedScene,
    /// The scene that was baked, where something in it moves.
    pub moving: Option<Box<Scene>>,
    pub shown: Shown,
    /// As in [`Source`].
    pub look: Option<DVec3>,
    /// What was warned of while it was baked.
    pub warnings: Vec<String>,
    /// Whether it was baked just now.
    pub is_new: bool,
}

/// What is shown, and what of its files is not.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct Shown {
    /// The scene's letter or name, or the path as given.
    pub scene: String,
    /// The mesh of a built-in scene, or null.
    pub mesh: Option<String>,
    /// Stops by which all light is brighter than described; null for a baked scene.
    pub exposure: Option<f64>,
    #[serde(flatten)]
    pub told: Told,
}

/// What is told of the files of meshes.
#[derive(Debug, Clone, Default, Serialize, Deserialize, JsonSchema)]
pub struct Told {
    /// What meshes' files have that is not shown.
    pub not_used: Vec<NotUsed>,
    /// Files whose colours show a quantity, with its name and range.
    pub scalars: Vec<String>,
}

/// What a file has that is not shown.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct NotUsed {
    /// The file.
    pub file: String,
    /// Kinds of things with their number.
    pub what: Vec<String>,
}

impl Told {
    /// Says it again.
    pub fn repeat(&self) {
        for scalar in &self.scalars {
            say(scalar);
        }
        for file in &self.not_used {
            file.tell();
        }
    }
}

impl NotUsed {
    fn tell(&self) {
        warn(&format!(
            "{}: not used: {}",
            self.file,
            self.what.join(", ")
        ));
    }
}

impl fmt::Display for Shown {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "scene {}", self.scene)?;
        if let Some(mesh) = &self.mesh {
            write!(f, " of {mesh}")?;
        }
        match self.exposure {
            None | Some(0.0) => Ok(()),
            Some(stops) => write!(f, " (exposure {stops:+} stops)"),
        }
    }
}

#[allow(clippy::large_enum_variant, reason = "there is one of it")]
pub enum Loaded {
    Described(Box<Scene>),
    Baked(BakedScene),
}

impl Source {
    pub fn load(name: &SceneName, arguments: &ModelArguments) -> Result<Self, Failure> {
        let without_model = |why: &str| match (&arguments.mesh, arguments.normals) {
            (None, None) => Ok(()),
            _ => Err(misuse!(
                "--mesh and --normals are for the built-in scenes A to D: {why}"
            )),
        };
        let is_a_model = matches!(name, SceneName::File(path) if is_model(path));
        if arguments.scale.is_some() && !is_a_model {
            return Err(misuse!(
                "--scale is for a model that is the scene, such as --scene model.glb; other scenes \
                 say how large they are"
            ));
        }
        if arguments.camera.is_some() && !is_a_model {
            return Err(misuse!(
                "--camera is for a model that is the scene, such as --scene model.glb"
            ));
        }
        let playing = arguments.animation.clone().unwrap_or_default();
        let mut look = None;
        let built_in = |why, scene| {
            without_model(why)?;
            Ok::<_, Failure>((Loaded::Described(Box::new(scene)), None))
        };
        let mut told = Told::default();
        let mut is_under_our_sky = false;
        let (scene, mesh) = match name {
            SceneName::Paper(which) => {
                let (mesh, mesh_name) = match &arguments.mesh {
                    Some(path) => {
                        let mut model = import::load(path)?;
                        let own = model.mesh.materials.len() as u64;
                        let kind = "material{s} of its own (--scene FILE shows it in them)";
                        model.unused.add(kind, own);
                        leave_still(&mut model);
                        tell(path, &model, &mut told);
                        (model.mesh, path.display().to_string())
                    }
                    None => (quadruped(), BUILT_IN_MESH.to_owned()),
                };
                let mut scene = paper_scene(*which, mesh).map_err(|point| {
                    Fault::new(format!("{mesh_name}: {point}"), "export the mesh again")
                })?;
                for object in &mut scene.objects {
                    object.smooth = arguments.normals != Some(Normals::Flat);
                }
                (Loaded::Described(Box::new(scene)), Some(mesh_name))
            }
            SceneName::Gallery => built_in("the gallery has its own", gallery())?,
            SceneName::Grid => built_in("the grid has no mesh", grid(GRID_RADIUS))?,
            SceneName::Prism => built_in("the prism has its own", prism())?,
            SceneName::Spheres => built_in("the spheres have no mesh", spheres())?,
            SceneName::File(path) if is_model(path) => {
                without_model("--scene shows a model by itself")?;
                let mut model = load_model(path, &mut told)?;
                model.rig.play(&playing);
                is_under_our_sky = model.lights.is_empty();
                let camera = arguments.camera.as_deref();
                let camera = camera.map(|name| camera_of(&model, name)).transpose()?;
                look = camera.as_ref().map(Camera::look);
                let (metres, floor) = (arguments.scale, arguments.floor);
                let scene = Scene::of_model(model, metres, floor, camera.as_ref());
                (Loaded::Described(Box::new(scene)), None)
            }
            SceneName::File(path) => {
                without_model("a scene file names its own meshes")?;
                (load_scene(path, &playing, &mut told)?, None)
            }
        };
        let (scene, exposure) = match scene {
            Loaded::Described(mut scene) => {
                let stops = match arguments.exposure {
                    Some(Exposure::Stops(stops)) => stops,
                    None if !is_a_model => 0.0,
                    // A dark model in daylight is dark: brighter light would bleach the sky.
                    None | Some(Exposure::Auto) if is_under_our_sky => {
                        scene.suitable_exposure().min(0.0)
                    }
                    None | Some(Exposure::Auto) => scene.suitable_exposure(),
                };
                if stops != 0.0 {
                    scene.expose(stops);
                }
                animate(&mut scene, &playing, arguments.time)?;
                (Loaded::Described(scene), Some(stops))
            }
            Loaded::Baked(_) if arguments.is_given() => {
                return Err(misuse!(
                    "--exposure, --animation and --time are for scenes that are not baked yet: give \
                     them to `shisen bake`"
                ));
            }
            baked @ Loaded::Baked(_) => (baked, None),
        };
        let shown = Shown {
            scene: name.to_string(),
            mesh,
            exposure,
            told,
        };
        Ok(Self { scene, shown, look })
    }

    /// Bakes it, unless it is baked.
    pub fn baked(
        self,
        layout: Layout,
        levels: Option<&PolygonLevels>,
        ticker: &Ticker,
    ) -> Result<Ready, Failure> {
        let Self { scene, shown, look } = self;
        let (baked, moving, warnings, is_new) = match scene {
            Loaded::Baked(baked) => (baked, None, Vec::new(), false),
            Loaded::Described(scene) => {
                let (baked, warnings) = bake(&scene, &shown.scene, layout, levels, ticker)?;
                let moving = (!scene.motion.is_empty()).then_some(scene);
                (baked, moving, warnings, true)
            }
        };
        Ok(Ready {
            baked,
            moving,
            shown,
            look,
            warnings,
            is_new,
        })
    }
}

impl Ready {
    /// Returns where the viewer looks, if `--camera` says so.
    pub fn look(&self) -> Option<ViewDirection> {
        self.look.and_then(ViewDirection::new)
    }
}

#[derive(Debug, Error, Diagnostic)]
enum Unusable {
    #[error("{} cannot be used", path.display())]
    #[diagnostic(help("bake the scene, or bake it again, with `shisen bake`"))]
    Blob { path: PathBuf, source: SceneError },
    #[error("{name} cannot be baked")]
    #[diagnostic(help("change the part of the scene or mesh that is named above"))]
    Scene { name: String, source: BakeError },
}

/// Bakes a scene that reports call `name`. Warns of meshes whose polygon levels are not as asked or
/// may show gaps.
pub fn bake(
    scene: &Scene,
    name: &str,
    layout: Layout,
    levels: Option<&PolygonLevels>,
    ticker: &Ticker,
) -> Result<(BakedScene, Vec<String>), Failure> {
    ticker.set(format!("baking {name}"));
    let progress = |done, total| {
        ticker.set(format!("baking {name}: {done} of {total} levels and trees"));
    };
    let baked = BakedScene::with_progress(scene, levels, layout, &progress);
    let baked = baked.map_err(|source| {
        let name = name.to_owned();
        Unusable::Scene { name, source }
    })?;
    let mut warnings = levels.map_or(Vec::new(), |asked| Level::warnings(scene, asked, &baked));
    if levels.is_some() && scene.motion.deforming().next().is_some() {
        warnings.push(format!(
            "{name}: meshes that deform have all their faces at every level of detail: give \
             --animation none to simplify them"
        ));
    }
    for warning in &warnings {
        warn(warning);
    }
    Ok((baked, warnings))
}

/// Reads a model, and tells what its colours show and what of its file is not shown.
pub fn load_model(path: &Path, told: &mut Told) -> Result<Model, ImportError> {
    let model = import::load(path)?;
    tell(path, &model, told);
    Ok(model)
}

/// Most names that an error lists.
const MOST_NAMES: usize = 20;

fn camera_of(model: &Model, name: &str) -> Result<Camera, Failure> {
    let all = &model.cameras;
    let found = all.iter().find(|camera| camera.is_called(name));
    let names = all.iter().map(|camera| camera.name.as_str());
    found
        .cloned()
        .ok_or_else(|| unknown("model", "camera", name, names.collect()))
}

/// Returns the error of a name for `--camera` or `--animation` that its owner does not have.
fn unknown(owner: &str, what: &str, name: &str, mut names: Vec<&str>) -> Failure {
    let further = names.len().saturating_sub(MOST_NAMES);
    names.truncate(MOST_NAMES);
    let names: Vec<String> = names.iter().map(|name| format!("\"{name}\"")).collect();
    match (names.join(", "), further) {
        (names, _) if names.is_empty() => {
            misuse!("the {owner} has no {what}s: leave --{what} \"{name}\" out")
        }
        (names, 0) => misuse!("the {owner} has no {what} \"{name}\": give one of {names}"),
        (names, _) => misuse!(
            "the {owner} has no {what} \"{name}\": give one of {names} or of its {further} others"
        ),
    }
}

/// Lets a scene, whose models know what plays, move or stand as arguments say.
fn animate(scene: &mut Scene, playing: &Playing, time: Option<f64>) -> Result<(), Failure> {
    let clips = scene.motion.clips();
    match playing {
        Playing::Named(name) if clips.iter().all(|clip| clip.name != *name) => {
            let names = clips.iter().map(|clip| clip.name.as_str()).collect();
            return Err(unknown("scene", "animation", name, names));
        }
        Playing::None => scene.stop(),
        _ => {}
    }
    if let Some(time) = time {
        *scene = scene.at(time);
    }
    Ok(())
}

fn tell(path: &Path, model: &Model, told: &mut Told) {
    let file = path.display().to_string();
    if let Some(scalar) = &model.scalar {
        let scalar = format!("{file}: colours show {scalar}");
        say(&scalar);
        told.scalars.push(scalar);
    }
    if !model.unused.is_empty() {
        let what = model.unused.names();
        let new = NotUsed { file, what };
        new.tell();
        told.not_used.push(new);
    }
}

/// Reads the mesh of a model, which stands still.
pub fn load_mesh(path: &Path, told: &mut Told) -> Result<TriangleMesh, ImportError> {
    Ok(load_part(path, told, leave_still)?.mesh)
}

/// Counts animations among what is not used.
fn leave_still(model: &mut Model) {
    let count = model.rig.clips.len() as u64;
    model.unused.add("animation{s}", count);
}

/// Reads a model of whose lights and cameras nothing is used; `change` it before that is told.
fn load_part(
    path: &Path,
    told: &mut Told,
    change: impl FnOnce(&mut Model),
) -> Result<Model, ImportError> {
    let mut model = import::load(path)?;
    change(&mut model);
    let (lights, cameras) = (model.lights.len(), model.cameras.len());
    model.unused.add("light{s}", lights as u64);
    model.unused.add("camera{s}", cameras as u64);
    tell(path, &model, told);
    Ok(model)
}

pub fn load_baked(path: &Path) -> Result<BakedScene, Failure> {
    let bytes = crate::files::read(path).map_err(|reason| {
        let path = path.display();
        let message = format!("cannot read the baked scene in {path}: {reason}");
        Fault::new(message, "give the path of a scene that `shisen bake` wrote")
    })?;
    baked(path, &bytes)
}

/// Returns whether a file has the extension of a model.
pub fn is_model(path: &Path) -> bool {
    let mut known = import::EXTENSIONS.into_iter();
    let extension = path.extension();
    extension.is_some_and(|extension| known.any(|one| extension.eq_ignore_ascii_case(one)))
}

fn baked(path: &Path, bytes: &[u8]) -> Result<BakedScene, Failure> {
    BakedScene::from_bytes(bytes).map_err(|source| {
        let path = path.to_owned();
        Unusable::Blob { path, source }.into()
    })
}

/// Extensions of common files of models that are not read.
const NOT_READ: [&str; 16] = [
    "fbx", "dae", "blend", "usd", "usda", "usdc", "usdz", "3ds", "vtu", "vtk", "abc", "step",
    "stp", "iges", "x3d", "ifc",
];

fn load_scene(path: &Path, playing: &Playing, told: &mut Told) -> Result<Loaded, Failure> {
    let shown = path.display();
    let extension = path.extension().map(std::ffi::OsStr::to_ascii_lowercase);
    if let Some(name) = NOT_READ
        .iter()
        .find(|name| extension.as_deref() == Some(name.as_ref()))
    {
        let message = format!("{shown}: files of the format .{name} are not read");
        return Err(Fault::new(message, EXPORT).into());
    }
    let most = if begins_with(path, &MAGIC) {
        MOST
    } else {
        MOST_OF_TEXT
    };
    let bytes = read_within(path, most).map_err(|reason| {
        let message = format!("cannot read the scene in {shown}: {reason}");
        let help = "give A, B, C, D, gallery, grid, prism or spheres, the path of a model or of a TOML \
                    description, or of a scene that `shisen bake` wrote";
        Fault::new(message, help)
    })?;
    if bytes.starts_with(&MAGIC) {
        return baked(path, &bytes).map(Loaded::Baked);
    }
    let named_as_baked = path
        .extension()
        .is_some_and(|extension| extension == "shisen");
    let text = String::from_utf8(bytes).ok().filter(|_| !named_as_baked);
    let text = text.ok_or_else(|| {
        let message = format!("{shown} is neither a TOML description nor a baked scene");
        let help = "if `shisen bake` wrote it, it has been damaged since: bake it again";
        Fault::new(message, help)
    })?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let load = |source: &MeshSource| -> Result<Model, ImportError> {
        match source {
            MeshSource::File(path) => load_part(path, told, |model| model.rig.play(playing)),
            MeshSource::BuiltIn(BuiltInMesh::Quadruped) => Ok(quadruped().into()),
            MeshSource::BuiltIn(BuiltInMesh::Square) => Ok(TriangleMesh::square().into()),
        }
    };
    let name = path.to_string_lossy();
    let scene = Scene::from_toml(&text, &name, folder, load)?;
    let replaced = scene
        .environment
        .as_ref()
        .map_or(0, |of| of.image.replaced());
    if replaced > 0 {
        let what = "light of the background's image that is negative, too bright or no number";
        let what = format!("{what}, in {}", counted(replaced, "pixel"));
        let new = NotUsed {
            file: shown.to_string(),
            what: vec![what],
        };
        new.tell();
        told.not_used.push(new);
    }
    if scene.is_dark() {
        warn(&format!(
            "{shown}: nothing lights the scene: add a [[light]], or give ambient or a material's \
             emission"
        ));
    }
    Ok(Loaded::Described(Box::new(scene)))
}
