//! Values of arguments, and the arguments that commands share.

pub mod dispersion;
pub mod filling;
pub mod levels;
pub mod lod;
pub mod room;
pub mod source;
pub mod tracing;

use crate::bake::simplify::PolygonLevels;
use crate::bake::{BakedScene, Layout};
use crate::cave::{BuiltInCave, Cave, Wall};
use crate::cli::output::failure::Failure;
use crate::render::effects::Effects;
use crate::scene::builtin::PaperScene;
use clap::builder::{
    EnumValueParser, OsStringValueParser, PossibleValue, PossibleValuesParser, TypedValueParser,
};
use clap::{Arg, Args, Command, ValueEnum};
use serde::Serialize;
use shisen_core::Simd;
use shisen_core::gaze::{FaceRange, HeadPose};
use shisen_tracker::head::osvr_hdk;
use std::ffi::{OsStr, OsString};
use std::fmt;
use std::marker::PhantomData;
use std::num::NonZeroUsize;
use std::ops::{Bound, RangeBounds};
use std::path::PathBuf;
use std::str::FromStr;
use std::time::Duration;

/// The most threads that can be asked for.
const MOST_THREADS: NonZeroUsize = NonZeroUsize::new(1024).unwrap();

/// The values of an argument without those that a command refuses: these are in no list of
/// what there may be, and are read, so that the command says why it has no use for them.
#[derive(Debug, Clone)]
pub struct Without<T> {
    refused: &'static [&'static str],
    of: PhantomData<fn() -> T>,
}

impl<T> Without<T> {
    /// Without the values of these names.
    pub const fn new(refused: &'static [&'static str]) -> Self {
        let of = PhantomData;
        Self { refused, of }
    }
}

impl<T: ValueEnum + Clone + Send + Sync + 'static> TypedValueParser for Without<T> {
    type Value = T;

    fn parse_ref(
        &self,
        command: &Command,
        argument: Option<&Arg>,
        value: &OsStr,
    ) -> Result<T, clap::Error> {
        let read = EnumValueParser::new().parse_ref(command, argument, value);
        read.map_err(|error| {
            // What there may be instead, without those that are refused.
            let shown = self.possible_values().into_iter().flatten();
            let shown = PossibleValuesParser::new(shown).parse_ref(command, argument, value);
            shown.err().unwrap_or(error)
        })
    }

    fn possible_values(&self) -> Option<Box<dyn Iterator<Item = PossibleValue> + '_>> {
        let all = T::value_variants().iter();
        let values = all.filter_map(ValueEnum::to_possible_value);
        Some(Box::new(
            values.filter(|value| !self.refused.contains(&value.get_name())),
        ))
    }
}

/// `--scene`: a letter, a name or a file.
#[derive(Debug, Clone)]
pub enum SceneName {
    /// A built-in scene.
    Paper(PaperScene),
    /// Meridians and parallels on a sphere.
    Grid,
    /// A spectrum.
    Prism,
    /// Balls of quartz.
    Spheres,
    /// A description or a baked scene.
    File(PathBuf),
}

impl From<OsString> for SceneName {
    fn from(name: OsString) -> Self {
        match name.to_str().map(PaperScene::from_str) {
            Some(Ok(scene)) => Self::Paper(scene),
            _ if name.eq_ignore_ascii_case("grid") => Self::Grid,
            _ if name.eq_ignore_ascii_case("prism") => Self::Prism,
            _ if name.eq_ignore_ascii_case("spheres") => Self::Spheres,
            _ => Self::File(name.into()),
        }
    }
}

impl fmt::Display for SceneName {
    /// The letter, the name, or the path as given.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Paper(which) => f.write_str(which.name()),
            Self::Grid => f.write_str("grid"),
            Self::Prism => f.write_str("prism"),
            Self::Spheres => f.write_str("spheres"),
            Self::File(path) => path.display().fmt(f),
        }
    }
}

impl SceneName {
    /// Any text is a name.
    pub fn parser() -> impl TypedValueParser<Value = Self> {
        OsStringValueParser::new().map(Self::from)
    }
}

/// `--walls`: a name or a file.
#[derive(Debug, Clone)]
pub enum WallsName {
    /// A built-in room.
    BuiltIn(BuiltInCave),
    /// A TOML file of walls and domes.
    File(PathBuf),
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
    /// The room; `size`, in columns and rows, is for screens that do not say.
    ///
    /// # Errors
    /// A room that there is not, or a file that describes none.
    pub fn cave(&self, size: [u32; 2]) -> Result<Cave, Failure> {
        Ok(match self {
            Self::BuiltIn(which) => Cave::built_in(*which, size)?,
            Self::File(path) => Cave::load(path, size)?,
        })
    }

    /// Any text is a name.
    pub fn parser() -> impl TypedValueParser<Value = Self> {
        OsStringValueParser::new().map(Self::from)
    }
}

/// What the built-in scenes show.
#[derive(Debug, Clone, Args)]
pub struct Model {
    /// Mesh of the built-in scenes: an OBJ, PLY or glTF file [default: a
    /// quadruped that is built in]
    #[arg(long, value_name = "FILE")]
    pub mesh: Option<PathBuf>,
    /// Normals of the built-in scenes' mesh [default: smooth]
    #[arg(long, value_enum)]
    pub normals: Option<Normals>,
}

/// The polygon levels that meshes are baked at.
#[derive(Debug, Clone, Args)]
pub struct LevelArguments {
    /// Faces of each mesh at the coarsest of its polygon levels, which the rim
    /// of the visual field sees, and at the finest, such as 500..5804, or
    /// 500.. for all that it has [default: 500..]
    #[arg(long, value_name = "MIN..MAX")]
    faces: Option<Faces>,
    /// Polygon levels of each mesh, from MIN to MAX [default: 19, or 12 in the
    /// compact layout]
    #[arg(long, value_name = "N", value_parser = whole::<u32>(PolygonLevels::RUNGS))]
    levels: Option<u32>,
}

impl LevelArguments {
    /// Which of them somebody gave, if any.
    pub fn given(&self) -> Option<&'static str> {
        let faces = self.faces.is_some().then_some("--faces");
        faces.or(self.levels.is_some().then_some("--levels"))
    }

    /// What they ask for of a scene that is baked in `layout`.
    ///
    /// # Errors
    /// Of usage, where there are no such levels.
    pub fn polygon_levels(&self, layout: Layout) -> Result<PolygonLevels, Failure> {
        let (min, max) = match self.faces {
            Some(Faces { min, max }) => (min, max),
            None => (PolygonLevels::FEWEST_FACES, None),
        };
        let rungs = self.levels.unwrap_or(layout.polygon_levels());
        PolygonLevels::new(min..=max.unwrap_or(u32::MAX), rungs)
            .map_err(|error| Failure::usage(&error.to_string()))
    }
}

/// What is carried out of what scenes ask for.
#[derive(Debug, Clone, Args)]
pub struct EffectArguments {
    /// Effects to carry out: auto, what the scene asks for; all, everything that is
    /// built, which gives the same picture; -NAME to leave one out, +NAME to have
    /// one carried out anyway, such as --effects=-shadows,-reflection. Names:
    /// see `shisen explain`
    #[arg(long, value_name = "LIST", default_value_t = Effects::AUTO,
          allow_hyphen_values = true)]
    pub effects: Effects,
}

/// Effects, for reports.
#[derive(Debug, Serialize)]
pub struct EffectReport {
    /// Carried out.
    effects: Vec<&'static str>,
    /// That the scene asks for.
    effects_asked: Vec<&'static str>,
}

impl EffectReport {
    /// The names of what is carried out of a scene, and of what it asks for.
    pub fn new(effects: &Effects, baked: &BakedScene) -> Self {
        let asked = baked.effects();
        Self {
            effects: effects.of(asked).names().collect(),
            effects_asked: asked.names().collect(),
        }
    }
}

/// How a mesh is shaded.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Normals {
    /// Interpolated between vertices
    Smooth,
    /// One a triangle
    Flat,
}

/// An instruction set.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum SimdChoice {
    /// The fastest that this processor has
    Auto,
    /// Plain code that runs anywhere
    Portable,
}

impl SimdChoice {
    /// The path that it stands for on this machine.
    pub fn path(self) -> Simd {
        match self {
            Self::Auto => Simd::detect(),
            Self::Portable => Simd::PORTABLE,
        }
    }
}

/// `--layout`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LayoutChoice(pub Layout);

impl ValueEnum for LayoutChoice {
    fn value_variants<'a>() -> &'a [Self] {
        &[Self(Layout::Fast), Self(Layout::Compact)]
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        let help = match self.0 {
            Layout::Fast => "Nodes of eight children, for processors with wide vectors",
            Layout::Compact => "Nodes of four children, for microcontrollers",
        };
        Some(PossibleValue::new(self.0.name()).help(help))
    }
}

/// `--head-report`: how a head is turned, as an OSVR HDK measured it.
#[derive(Debug, Clone, Copy)]
pub struct HeadReport(osvr_hdk::Report);

impl HeadReport {
    /// The head at `position`, metres.
    pub fn pose_at(self, position: glam::Vec3) -> HeadPose {
        HeadPose {
            position,
            orientation: self.0.head_orientation(),
        }
    }
}

impl FromStr for HeadReport {
    type Err = String;

    /// Two hexadecimal digits a byte; white space does not count.
    fn from_str(text: &str) -> Result<Self, String> {
        let digits = text
            .chars()
            .filter(|c| !c.is_whitespace())
            .map(|c| {
                c.to_digit(16)
                    .map(|digit| digit as u8)
                    .ok_or_else(|| format!("'{}' is no hexadecimal digit", c.escape_debug()))
            })
            .collect::<Result<Vec<u8>, _>>()?;
        if digits.len() % 2 != 0 {
            return Err(format!(
                "{} hexadecimal digits are no whole number of bytes: write two a byte",
                digits.len()
            ));
        }
        let bytes: Vec<u8> = digits
            .chunks_exact(2)
            .map(|pair| pair[0] << 4 | pair[1])
            .collect();
        osvr_hdk::decode(&bytes)
            .map(Self)
            .map_err(|error| error.to_string())
    }
}

/// Columns and rows, as `1280x960`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PictureSize(pub [u32; 2]);

impl FromStr for PictureSize {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let side = |side: &str| {
            side.parse()
                .ok()
                .filter(|pixels| (1..=Wall::MOST_PIXELS).contains(pixels))
        };
        text.split_once(['x', '×'])
            .and_then(|(columns, rows)| Some(Self([side(columns)?, side(rows)?])))
            .ok_or_else(|| {
                let limit = Wall::MOST_PIXELS;
                format!("give columns and rows of 1 to {limit} pixels, such as 1280x960")
            })
    }
}

/// `--faces`: the fewest and the most faces of a mesh, as `500..5804`, or
/// `500..` for all that it has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Faces {
    /// At the rim of the visual field.
    min: u32,
    /// In its centre; none for all.
    max: Option<u32>,
}

impl FromStr for Faces {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
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
        Ok(Self { min, max })
    }
}

/// `--faces` where there is no mesh to say how many it has.
pub fn face_range(text: &str) -> Result<FaceRange, String> {
    let Faces { min, max } = text.parse()?;
    let max = max.ok_or("give the most faces, too, such as 500..5804")?;
    FaceRange::new(min, max).map_err(|error| error.to_string())
}

/// Between the pupils: metres.
pub fn interpupillary_distance(text: &str) -> Result<f64, String> {
    number_within(text, 0.0, 1.0).ok_or_else(|| "give metres from 0 to 1, such as 0.064".into())
}

/// How long something goes on, in seconds.
pub fn span(text: &str) -> Result<Duration, String> {
    number_within(text, 0.001, 86_400.0)
        .map(Duration::from_secs_f64)
        .ok_or_else(|| "give seconds from 0.001 to 86400, such as 1.5".into())
}

/// A perspective view's field: degrees.
pub fn field_of_view(text: &str) -> Result<f64, String> {
    number_within(text, 1.0, 179.0).ok_or_else(|| "give degrees from 1 to 179, such as 90".into())
}

/// The parser of a whole number within a range, `1..=8` or `1..`, which it names where
/// there is none.
pub fn whole<T>(
    range: impl RangeBounds<T> + Clone + Send + Sync + 'static,
) -> impl Fn(&str) -> Result<T, String> + Clone + Send + Sync + 'static
where
    T: FromStr + PartialOrd + fmt::Display + 'static,
{
    move |text| {
        let number = text.trim().parse().ok();
        number
            .filter(|number| range.contains(number))
            .ok_or_else(|| match (range.start_bound(), range.end_bound()) {
                (Bound::Included(least), Bound::Included(most)) => {
                    format!("give a whole number from {least} to {most}")
                }
                (Bound::Included(least), _) => format!("give a whole number from {least} on"),
                _ => "give a whole number".to_owned(),
            })
    }
}

/// Any number, whose range is told by what it is for.
pub fn number<T: FromStr>(text: &str) -> Result<T, String> {
    let number = text.trim().parse();
    number.map_err(|_| "give a number, such as 1.5".to_owned())
}

/// A number within a range, both ends included.
pub fn number_within(text: &str, low: f64, high: f64) -> Option<f64> {
    let number: f64 = text.trim().parse().ok()?;
    (low..=high).contains(&number).then_some(number)
}

/// How far a viewer turns: degrees.
pub fn turn(text: &str) -> Result<f32, String> {
    match text.parse() {
        Ok(degrees) if (0.0..=180.0).contains(&degrees) => Ok(degrees),
        _ => Err("give degrees from 0 to 180".to_owned()),
    }
}

/// `--threads`.
pub fn threads(text: &str) -> Result<NonZeroUsize, String> {
    whole(NonZeroUsize::MIN..=MOST_THREADS)(text)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;
    use std::path::Path;

    #[test]
    fn letters_and_names_come_before_files() {
        for (text, letter) in [("A", PaperScene::A), ("d", PaperScene::D)] {
            let name = SceneName::from(OsString::from(text));
            assert!(matches!(name, SceneName::Paper(scene) if scene == letter));
        }
        let name = SceneName::from(OsString::from("./A"));
        assert!(matches!(name, SceneName::File(path) if path == Path::new("./A")));
        let name = WallsName::from(OsString::from("cube"));
        assert!(matches!(name, WallsName::BuiltIn(BuiltInCave::Cube)));
        let name = WallsName::from(OsString::from("cube.toml"));
        assert!(matches!(name, WallsName::File(_)));
    }

    #[test]
    fn head_reports_are_bytes_in_hexadecimal() {
        // Sensor axes that are the reference's: the head looks along +Z of a
        // frame with +Z up, which is the room's +Y.
        let report: HeadReport = "01 07 0000 0000 0000 0040 AABBCCDDEEff".parse().unwrap();
        let pose = report.pose_at(Vec3::ONE);
        assert_eq!(pose.position, Vec3::ONE);
        let forward = pose.orientation * Vec3::NEG_Z;
        assert!(forward.distance(Vec3::Y) < 1e-6, "{forward}");
        for (text, expected) in [
            ("0g", "'g'"),
            ("010", "3 hexadecimal digits"),
            ("01", "1 bytes"),
            ("09070000000000000040000000000000", "version 9"),
            ("01070000000000000000000000000000", "norm 0"),
            ("", "0 bytes"),
        ] {
            let error = text.parse::<HeadReport>().unwrap_err();
            assert!(error.contains(expected), "{text}: {error}");
        }
    }

    #[test]
    fn ranges_of_faces_have_an_order() {
        let faces = |text: &str| text.parse::<Faces>();
        let (min, all) = (4, None);
        assert_eq!(faces(" 4 .. "), Ok(Faces { min, max: all }));
        let max = Some(8);
        assert_eq!(faces(" 4 .. 8 "), Ok(Faces { min, max }));
        assert_eq!(face_range("4..8"), Ok(FaceRange::new(4, 8).unwrap()));
        for text in ["", "4", "..8", "8..4", "0..4", "0..", "-1..4", "4..=8"] {
            assert!(faces(text).is_err() && face_range(text).is_err(), "{text}");
        }
        assert!(faces("1..4294967296").is_err());
        let error = face_range("4..").unwrap_err();
        assert!(error.contains("the most faces, too"), "{error}");
    }

    #[test]
    fn polygon_levels_are_the_layout_s_unless_asked_for() {
        let levels = |faces: Option<&str>, levels, layout| {
            let faces = faces.map(|text| text.parse().unwrap());
            LevelArguments { faces, levels }
                .polygon_levels(layout)
                .unwrap()
        };
        let new = |faces, rungs| PolygonLevels::new(faces, rungs).unwrap();
        let all = u32::MAX;
        assert_eq!(levels(None, None, Layout::Fast), new(500..=all, 19));
        assert_eq!(levels(None, None, Layout::Compact), new(500..=all, 12));
        assert_eq!(
            levels(Some("9.."), Some(3), Layout::Compact),
            new(9..=all, 3)
        );
        assert_eq!(levels(Some("9..20"), None, Layout::Fast), new(9..=20, 19));
    }

    #[test]
    fn numbers_out_of_range_are_refused() {
        assert_eq!("640x480".parse(), Ok(PictureSize([640, 480])));
        for text in ["0x1", "1x0", "640", "x", "-1x1", "16385x1", "1x1x1", ""] {
            assert!(text.parse::<PictureSize>().is_err(), "{text}");
        }
        for text in ["0", "-1", "1025", "two", ""] {
            assert!(threads(text).is_err(), "{text}");
        }
        assert_eq!(threads("1024").map(NonZeroUsize::get), Ok(1024));
        for text in ["nan", "inf", "-0.1", "1.01", ""] {
            assert!(interpupillary_distance(text).is_err(), "{text}");
        }
        assert_eq!(interpupillary_distance("0"), Ok(0.0));
        for text in ["nan", "0", "-1", "86401", "1s", ""] {
            assert!(span(text).is_err(), "{text}");
        }
        assert_eq!(span("1.5"), Ok(Duration::from_millis(1_500)));
        for text in ["nan", "0", "180", ""] {
            assert!(field_of_view(text).is_err(), "{text}");
        }
        assert_eq!(field_of_view("90"), Ok(90.0));
    }
}
