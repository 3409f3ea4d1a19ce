//! Values of arguments, and the arguments that commands share.

pub mod cache;
pub mod dispersion;
pub mod filling;
pub mod levels;
pub mod lod;
pub mod outputs;
pub mod room;
pub mod source;
pub mod tracing;

use crate::bake::Layout;
use crate::bake::simplify::PolygonLevels;
use crate::cave::{BuiltInCave, Cave, Wall};
use crate::cli::prelude::*;
use crate::render::effects::Effects;
use crate::scene::builtin::PaperScene;
use crate::scene::motion::Playing;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use glam::Quat;
use shisen_core::Simd;
use shisen_core::gaze::FaceRange;
use shisen_tracker::head::osvr_hdk;
use std::ffi::OsString;
use std::num::NonZeroUsize;
use std::str::FromStr;

const MOST_THREADS: NonZeroUsize = NonZeroUsize::new(1024).unwrap();

/// Returns the parser of an argument of which a command refuses some values. The help does not list
/// these; they are read all the same, so that the command can say why it refuses them.
pub fn without<T: ValueEnum + Clone + Send + Sync + 'static>(
    refused: &[&str],
) -> impl TypedValueParser<Value = T> {
    let values = T::value_variants().iter();
    let values = values
        .filter_map(ValueEnum::to_possible_value)
        .map(|value| {
            let hidden = refused.contains(&value.get_name());
            value.hide(hidden)
        });
    PossibleValuesParser::new(values).try_map(|name| T::from_str(&name, false))
}

/// What `--scene` takes, for help.
pub const SCENES: &str = "A|B|C|D|gallery|grid|prism|spheres|FILE";

/// `--scene`: a letter, a name or a file.
#[derive(Debug, Clone)]
pub enum SceneName {
    Paper(PaperScene),
    Gallery,
    Grid,
    Prism,
    Spheres,
    /// A model, a description or a baked scene.
    File(PathBuf),
}

impl From<OsString> for SceneName {
    fn from(name: OsString) -> Self {
        match name.to_str().map(PaperScene::from_str) {
            Some(Ok(scene)) => Self::Paper(scene),
            _ if name.eq_ignore_ascii_case("gallery") => Self::Gallery,
            _ if name.eq_ignore_ascii_case("grid") => Self::Grid,
            _ if name.eq_ignore_ascii_case("prism") => Self::Prism,
            _ if name.eq_ignore_ascii_case("spheres") => Self::Spheres,
            _ => Self::File(name.into()),
        }
    }
}

impl fmt::Display for SceneName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Paper(which) => f.write_str(which.name()),
            Self::Gallery => f.write_str("gallery"),
            Self::Grid => f.write_str("grid"),
            Self::Prism => f.write_str("prism"),
            Self::Spheres => f.write_str("spheres"),
            Self::File(path) => path.display().fmt(f),
        }
    }
}

/// `--walls`: a name or a file.
#[derive(Debug, Clone)]
pub enum WallsName {
    BuiltIn(BuiltInCave),
    /// A TOML file of walls and domes.
    File(PathBuf),
    /// What such a file held when it was recorded.
    Text(PathBuf, String),
}

impl From<OsString> for WallsName {
    fn from(name: OsString) -> Self {
        match name.to_str().map(BuiltInCave::from_str) {
            Some(Ok(cave)) => Self::BuiltIn(cave),
            _ => Self::File(name.into()),
        }
    }
}

impl WallsName {
    /// Loads the room, and warns of skewed walls. Screens that do not say their size have `size`,
    /// columns and rows.
    pub fn cave(&self, size: [u32; 2]) -> Result<Cave, Failure> {
        let cave = self.cave_without_remarks(size)?;
        if let Some(remark) = cave.skewed() {
            warn(&remark);
        }
        cave.uneven_meshes()?.iter().for_each(|remark| warn(remark));
        Ok(cave)
    }

    /// As [`Self::cave`], without a warning.
    pub fn cave_without_remarks(&self, size: [u32; 2]) -> Result<Cave, Failure> {
        Ok(match self {
            Self::BuiltIn(which) => Cave::built_in(*which, size)?,
            Self::File(path) => Cave::load(path, size)?,
            Self::Text(path, text) => Cave::from_toml(text, &path.to_string_lossy(), size)?,
        })
    }
}

#[derive(Debug, Clone, Default, Args)]
pub struct ModelArguments {
    /// Mesh of scenes A to D, in their material: an OBJ, PLY, STL, VTP or glTF file
    /// [default: a built-in quadruped]
    #[arg(long, value_name = "FILE")]
    pub mesh: Option<PathBuf>,
    /// Metres to a unit of a model that is the scene: 1, or 0.001 for millimetres [default: its
    /// largest side becomes 2 m]
    #[arg(long, value_name = "METRES",
          value_parser = within(1.0e-6..=1.0e6, "metres from 0.000001 to 1,000,000"))]
    pub scale: Option<f64>,
    /// Camera of a model that is the scene: the model stands upright so that it is at the room's
    /// origin and heads to the front, a unit 1 m or --scale. A viewer without a tracker looks as
    /// far up or down as it does; the walls stay as they are
    #[arg(long, value_name = "NAME")]
    pub camera: Option<String>,
    /// Doublings of all light; auto makes bright surfaces nearly white, shadows aside, but light
    /// without a model's own never brighter
    /// [default: auto for a model that is the scene, else 0]
    #[arg(long, value_name = "auto|STOPS", allow_hyphen_values = true)]
    pub exposure: Option<Exposure>,
    /// Animations of glTF files that play: those of this name, all of them at once, or none. With
    /// none the objects of a scene file stand still, too. Models without the name stand still
    /// [default: the first of each model]
    #[arg(long, value_name = "NAME|all|none")]
    pub animation: Option<Playing>,
    /// Seconds from the start at which the scene stands still [default: commands that play a scene
    /// move it, and others show it as at 0 s]
    #[arg(long, value_name = "SECONDS",
          value_parser = within(0.0..=1.0e6, "seconds from 0 to 1,000,000"))]
    pub time: Option<f64>,
    /// Normals of the built-in scenes' mesh [default: smooth]
    #[arg(long, value_enum)]
    pub normals: Option<Normals>,
    /// Height of the floor that a model stands on: metres, in the room.
    #[arg(skip)]
    pub floor: Option<f64>,
}

impl ModelArguments {
    /// Returns the same for models that stand in a room.
    #[must_use]
    pub fn within(&self, room: &Cave) -> Self {
        Self {
            floor: Some(room.floor()),
            ..self.clone()
        }
    }

    pub const fn is_given(&self) -> bool {
        let size = self.scale.is_some() || self.exposure.is_some();
        let motion = self.animation.is_some() || self.time.is_some();
        motion || size || self.camera.is_some() || self.mesh.is_some() || self.normals.is_some()
    }
}

/// `--exposure`.
#[derive(Debug, Clone, Copy)]
pub enum Exposure {
    Auto,
    Stops(f64),
}

impl FromStr for Exposure {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let stops = text.parse().ok();
        match stops.filter(|stops: &f64| stops.abs() <= 32.0) {
            _ if text == "auto" => Ok(Self::Auto),
            Some(stops) => Ok(Self::Stops(stops)),
            None => Err("neither auto nor stops from -32 to 32".to_owned()),
        }
    }
}

#[derive(Debug, Default, Clone, Args)]
pub struct LevelArguments {
    /// Faces of each mesh at its coarsest polygon level, for the rim of the visual field, and
    /// at its finest: 500..5804, or 500.. for all faces it has [default: 500..]
    #[arg(long, value_name = "MIN..MAX", value_parser = faces)]
    faces: Option<(u32, Option<u32>)>,
    /// Number of polygon levels of each mesh [default: 19, or 12 in the compact layout]
    #[arg(long, value_name = "N", value_parser = whole::<u32>(PolygonLevels::RUNGS))]
    levels: Option<u32>,
}

impl LevelArguments {
    /// Returns the first of these arguments that was given.
    pub fn given(&self) -> Option<&'static str> {
        let faces = self.faces.is_some().then_some("--faces");
        faces.or(self.levels.is_some().then_some("--levels"))
    }

    pub fn polygon_levels(&self, layout: Layout) -> Result<PolygonLevels, Failure> {
        let (min, max) = self.faces.unwrap_or((PolygonLevels::FEWEST_FACES, None));
        let rungs = self.levels.unwrap_or(layout.polygon_levels());
        PolygonLevels::new(min..=max.unwrap_or(u32::MAX), rungs).or_misuse()
    }
}

#[derive(Debug, Clone, Args)]
pub struct EffectArguments {
    /// Effects to render: auto (those that the scene uses), all (every effect, with the same
    /// picture), -NAME to leave one out or +NAME to add one, as in
    /// --effects=-shadows,-reflection. `shisen explain` has the names
    #[arg(long, value_name = "LIST", default_value_t = Effects::AUTO,
          allow_hyphen_values = true)]
    pub effects: Effects,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Normals {
    /// Interpolated between vertices
    Smooth,
    /// One normal a triangle
    Flat,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum SimdChoice {
    /// The fastest that this processor has
    Auto,
    /// Plain code that runs anywhere
    Portable,
}

impl SimdChoice {
    pub fn path(self) -> Simd {
        match self {
            Self::Auto => Simd::detect(),
            Self::Portable => Simd::PORTABLE,
        }
    }
}

/// Lets arguments take the values of an enum of the library, by their names.
macro_rules! choices {
    ($name:ident { $($value:ident => $help:literal,)+ }) => {
        impl clap::ValueEnum for $name {
            fn value_variants<'a>() -> &'a [Self] {
                &[$(Self::$value),+]
            }

            fn to_possible_value(&self) -> Option<clap::builder::PossibleValue> {
                let help = match self {
                    $(Self::$value => $help,)+
                };
                Some(clap::builder::PossibleValue::new(self.name()).help(help))
            }
        }
    };
}
pub(in crate::cli) use choices;

choices!(Layout {
    Fast => "Nodes of eight children, for processors with wide vectors",
    Compact => "Nodes of four children, for microcontrollers",
});

/// Returns the parser of `--head-report`: how a head is turned, as an OSVR HDK measured it. Reads
/// two hexadecimal digits a byte, and skips white space.
pub fn head_report(text: &str) -> Result<Quat, String> {
    let digit = |c: char| {
        let digit = c.to_digit(16).map(|digit| digit as u8);
        digit.ok_or_else(|| {
            let c = c.escape_debug();
            format!("'{c}' is not a hexadecimal digit: give 32 of them, or 64 (16 or 32 bytes)")
        })
    };
    let digits = text.chars().filter(|c| !c.is_whitespace()).map(digit);
    let digits = digits.collect::<Result<Vec<u8>, _>>()?;
    let (pairs, []) = digits.as_chunks::<2>() else {
        let count = digits.len();
        return Err(format!(
            "{count} hexadecimal digits are no whole number of bytes: write two a byte"
        ));
    };
    let bytes: Vec<u8> = pairs.iter().map(|[high, low]| high << 4 | low).collect();
    let report = osvr_hdk::decode(&bytes).map_err(|error| error.to_string())?;
    Ok(report.head_orientation())
}

/// Returns the parser of columns and rows of pixels.
pub fn picture_size(text: &str) -> Result<[u32; 2], String> {
    let most = Wall::MOST_PIXELS;
    let side = |side: &str| {
        side.parse()
            .ok()
            .filter(|pixels| (1..=most).contains(pixels))
    };
    text.split_once(['x', '×'])
        .and_then(|(columns, rows)| Some([side(columns)?, side(rows)?]))
        .ok_or_else(|| format!("give columns and rows of 1 to {most} pixels, such as 1280x960"))
}

/// Returns the parser of `--faces`: the fewest and the most faces of a mesh, as `500..5804`, or
/// `500..` for all that it has.
fn faces(text: &str) -> Result<(u32, Option<u32>), String> {
    let number = |text: &str| text.trim().parse::<u32>().ok();
    let (min, max) = text
        .split_once("..")
        .and_then(|(min, max)| {
            let all = max.trim().is_empty();
            let max = if all { None } else { Some(number(max)?) };
            Some((number(min)?, max))
        })
        .ok_or("give the fewest and the most faces, such as 500..5804, or 500.. for all")?;
    FaceRange::new(min, max.unwrap_or(u32::MAX)).map_err(|error| error.to_string())?;
    Ok((min, max))
}

/// `--faces` where no mesh says how many faces it has.
pub fn face_range(text: &str) -> Result<FaceRange, String> {
    let (min, max) = faces(text)?;
    let max = max.ok_or("give the most faces, too, such as 500..5804")?;
    FaceRange::new(min, max).map_err(|error| error.to_string())
}

/// Returns the parser of seconds.
pub fn span(text: &str) -> Result<Duration, String> {
    let seconds = within(0.001..=86_400.0, "seconds from 0.001 to 86400, such as 1.5");
    seconds(text).map(Duration::from_secs_f64)
}

/// Returns the parser of an angle by which a viewer turns, degrees.
pub fn turn(text: &str) -> Result<f32, String> {
    within(0.0..=180.0, "degrees from 0 to 180")(text)
}

pub fn threads(text: &str) -> Result<NonZeroUsize, String> {
    whole(NonZeroUsize::MIN..=MOST_THREADS)(text)
}
