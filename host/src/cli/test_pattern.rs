//! `shisen test-pattern`: pictures that show whether a room is set up right.

use crate::cave::Screen;
use crate::cli::arguments::room::{RoomArguments, ViewArguments};
use crate::cli::cave::pictures::Writer;
use crate::cli::prelude::*;
use crate::picture::{Picture, PictureError};
use crate::render::{Frame, Observer, WallPicture};
use crate::show::overview::viewer::ViewerCamera;
use crate::show::pattern::{Drawing, OutputView, PATTERNS, Pattern, Refresh, ScreenView};
use crate::show::stereo::Stereo;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use shisen_core::frame::Statistics;

/// Writes a test picture for the screens of a room
#[derive(Debug, Args)]
#[command(after_long_help = remedies())]
pub(super) struct Arguments {
    /// Name of the pattern
    #[arg(value_name = "NAME", required_unless_present = "list", value_parser = pattern())]
    pattern: Option<Pattern>,
    /// Print all patterns, their purpose, and what to do when one looks wrong
    #[arg(long, conflicts_with = "pattern")]
    list: bool,
    #[command(flatten)]
    room: RoomArguments,
    #[command(flatten)]
    view: ViewArguments,
    /// Also write both eyes' views for a display of one picture: sequential (one file an eye),
    /// side-by-side, top-bottom or anaglyph (for red-cyan glasses); mono writes none
    #[arg(long, value_name = "FORMAT", default_value_t = Stereo::Mono)]
    stereo: Stereo,
    /// Folder of the pictures; made if it does not exist
    #[arg(long, value_name = "DIR", default_value = "shisen-out")]
    out: PathBuf,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

/// Returns the parser of a pattern's name.
fn pattern() -> impl TypedValueParser<Value = Pattern> {
    let names = PATTERNS.map(|one| PossibleValue::new(one.name).help(one.purpose));
    PossibleValuesParser::new(names)
        .try_map(|name| Pattern::named(&name).copied().ok_or("no such pattern"))
}

/// Returns what to look for in each pattern, for the long help.
fn remedies() -> String {
    let lines = PATTERNS.map(|one| format!("  {}: {}", one.name, one.look_for));
    format!("What to look for:\n{}", lines.join("\n"))
}

/// A test picture.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct Report {
    #[serde(flatten)]
    pattern: Description,
    /// Pictures of screens, one for each eye.
    images: Vec<Image>,
    /// Files of all screens in one picture.
    overviews: Vec<String>,
}

/// All test pictures.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct List {
    /// The patterns, in the order in which a room is set up.
    patterns: Vec<Description>,
}

#[derive(Debug, Serialize, JsonSchema)]
struct Description {
    /// Name of the pattern.
    name: &'static str,
    /// screen, in a screen's picture, or output, in an output's own pixels.
    place: &'static str,
    /// Whether it changes from refresh to refresh.
    is_moving: bool,
    /// Purpose of the pattern.
    purpose: &'static str,
    /// What is seen if all is well, and what to do if not.
    look_for: &'static str,
}

#[derive(Debug, Serialize, JsonSchema)]
struct Image {
    /// Name of the wall or dome.
    screen: String,
    /// left, right or centre; null for both.
    eye: Option<&'static str>,
    /// File of the picture.
    path: String,
}

impl From<&Pattern> for Description {
    fn from(pattern: &Pattern) -> Self {
        let (place, is_moving) = match pattern.drawing {
            Drawing::Screen { .. } => ("screen", false),
            Drawing::Output { is_moving, .. } => ("output", is_moving),
        };
        Self {
            name: pattern.name,
            place,
            is_moving,
            purpose: pattern.purpose,
            look_for: pattern.look_for,
        }
    }
}

pub(super) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let Some(pattern) = &arguments.pattern else {
        let patterns = PATTERNS.iter().map(Description::from).collect();
        return print(&List { patterns }, arguments.json);
    };
    let cave = arguments.room.cave()?;
    let name = pattern.name;
    let (images, overviews) = match pattern.drawing {
        Drawing::Screen { draw, is_stereo } => {
            let is_single = arguments.room.eyes(arguments.room.head()).count() == 1;
            if is_stereo && is_single {
                return Err(misuse!("pattern {name} takes two eyes: leave --eyes 1 out"));
            }
            arguments.room.check_stereo(arguments.stereo)?;
            write_screens(arguments, &cave, name, draw)?
        }
        Drawing::Output { draw, .. } => {
            if arguments.stereo != Stereo::Mono {
                return Err(misuse!(
                    "pattern {name} is the same for both eyes: leave --stereo out"
                ));
            }
            let draw = |output: &OutputView<'_>| draw(output, Refresh::default());
            make_writable(&arguments.out)?;
            let write = |(number, screen): (usize, Screen<'_>)| {
                let output = OutputView {
                    name: screen.name(),
                    number,
                    size: screen.size(),
                    neighbours: &[],
                };
                let path = arguments.out.join(format!("{}.png", screen.name()));
                let notes = metadata(format!("test pattern {name}, output {}", screen.name()));
                let written = draw(&output).write_png(&path, &notes);
                written.map_err(Fault::write(&path))?;
                Ok::<_, Failure>(Image {
                    screen: screen.name().to_owned(),
                    eye: None,
                    path: path.display().to_string(),
                })
            };
            let images = cave.screens().enumerate().map(write);
            (images.collect::<Result<_, _>>()?, Vec::new())
        }
    };
    let report = Report {
        pattern: pattern.into(),
        images,
        overviews,
    };
    print(&report, arguments.json)
}

/// Writes a pattern of the screens' pictures; returns their files, and those of all screens.
fn write_screens(
    arguments: &Arguments,
    cave: &Cave,
    name: &str,
    draw: fn(&ScreenView<'_>) -> Result<Picture, PictureError>,
) -> Result<(Vec<Image>, Vec<String>), Failure> {
    let pose = arguments.room.head();
    arguments.room.check_eyes(cave, pose)?;
    let viewer = arguments.room.viewer(pose);
    let eyes = arguments.room.eyes(pose);
    let observers: Vec<_> = eyes.map(|(eye, place)| Observer::new(eye, place)).collect();
    let directions = arguments.room.directions(pose);
    let cameras: Vec<ViewerCamera> = arguments.view.cameras(&observers, directions)?;
    make_writable(&arguments.out)?;
    let mut pictures = Vec::new();
    for (wall, screen) in cave.screens().enumerate() {
        for eye in observers.iter().map(|one| one.eye) {
            let view = ScreenView {
                screen,
                viewer,
                eye,
            };
            pictures.push(WallPicture {
                wall,
                eye,
                picture: draw(&view).or_fail()?,
                statistics: Statistics::default(),
            });
        }
    }
    let frame = Frame {
        pictures,
        statistics: Statistics::default(),
        seconds: 0.0,
        capture: None,
    };
    let writer = Writer {
        folder: &arguments.out,
        title: &format!("test pattern {name}"),
        exr: false,
        stereo: arguments.stereo,
    };
    let written = writer.write(&frame, cave, &observers, &cameras, None)?;
    let images = written.images.into_iter().map(|image| Image {
        screen: image.wall,
        eye: Some(image.eye),
        path: image.path,
    });
    let stereo = written.stereo.into_iter().flat_map(|stereo| stereo.images);
    let overviews = [written.cave, written.viewer].into_iter().chain(stereo);
    Ok((images.collect(), overviews.collect()))
}

impl fmt::Display for Description {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{} ({}): {}", self.name, self.place, self.purpose)?;
        write!(f, "  {}", self.look_for)
    }
}

impl fmt::Display for List {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let texts: Vec<_> = self.patterns.iter().map(Description::to_string).collect();
        f.write_str(&texts.join("\n"))
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}", self.pattern)?;
        let files = self.images.iter().map(|image| &image.path);
        let files: Vec<_> = files.chain(&self.overviews).map(String::as_str).collect();
        f.write_str(&files.join("\n"))
    }
}
