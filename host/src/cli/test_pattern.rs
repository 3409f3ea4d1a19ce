//! `shisen test-pattern`: pictures that show whether a room is set up right.

use crate::cave::{Eye, Screen};
use crate::cli::arguments::outputs::OutputsArguments;
use crate::cli::arguments::room::{RoomArguments, ViewArguments};
use crate::cli::arguments::span;
use crate::cli::cave::pictures::Writer;
use crate::cli::prelude::*;
use crate::cli::show::hold;
use crate::outputs::{Outputs, OutputsReport};
use crate::picture::{Picture, PictureError};
use crate::projection::Projection;
use crate::render::{Frame, Observer, WallPicture};
use crate::show::overview::viewer::ViewerCamera;
use crate::show::pattern::{Drawing, OutputView, PATTERNS, Pattern, Refresh, ScreenView};
use crate::show::stereo::Stereo;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use glam::DVec2;
use shisen_core::frame::Statistics;
use std::collections::HashMap;
use std::sync::mpsc::{Receiver, channel};

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
    /// side-by-side, top-bottom or anaglyph (for red-cyan glasses); mono writes none. With --outputs
    /// it is how monitors show two eyes
    #[arg(long, value_name = "FORMAT", default_value_t = Stereo::Mono)]
    stereo: Stereo,
    #[command(flatten)]
    outputs: OutputsArguments,
    /// With --outputs, end after S seconds [default: at Ctrl-C]
    #[arg(long, value_name = "S", value_parser = span, requires = "outputs")]
    seconds: Option<Duration>,
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
    /// What the monitors of --outputs showed, or null.
    outputs: Option<OutputsReport>,
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
    if let Drawing::Screen { is_stereo, .. } = pattern.drawing {
        let is_single = arguments.room.eyes(arguments.room.head()).count() == 1;
        if is_stereo && is_single {
            return Err(misuse!("pattern {name} takes two eyes: leave --eyes 1 out"));
        }
        arguments.room.check_stereo(arguments.stereo)?;
    }
    if arguments.outputs.is_given() {
        let report = Report {
            pattern: pattern.into(),
            images: Vec::new(),
            overviews: Vec::new(),
            outputs: Some(show(arguments, &cave, pattern)?),
        };
        return print(&report, arguments.json);
    }
    let (images, overviews) = match pattern.drawing {
        Drawing::Screen { draw, .. } => write_screens(arguments, &cave, name, draw)?,
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
        outputs: None,
    };
    print(&report, arguments.json)
}

/// Shows a pattern on monitors.
fn show(arguments: &Arguments, cave: &Cave, pattern: &Pattern) -> Result<OutputsReport, Failure> {
    let room = &arguments.room;
    let pose = room.head();
    room.check_eyes(cave, pose)?;
    let screens: Vec<Screen<'_>> = cave.screens().collect();
    let names: Vec<&str> = screens.iter().map(|screen| screen.name()).collect();
    let eyes = room.eyes(pose).map(|(eye, _)| eye);
    let views: Vec<ScreenView<'_>> = (screens.iter())
        .flat_map(|&screen| {
            let viewer = room.viewer(pose);
            eyes.clone().map(move |eye| ScreenView {
                screen,
                viewer,
                eye,
            })
        })
        .collect();
    let of: Vec<(&str, Eye)> = views
        .iter()
        .map(|view| (view.screen.name(), view.eye))
        .collect();
    let projections = Projection::all(cave)?;
    let opened = (arguments.outputs).open(&names, &of, &projections, arguments.stereo)?;
    let Some(mut outputs) = opened else {
        return Err(misuse!("give --outputs"));
    };
    let seconds = arguments.seconds;
    match pattern.drawing {
        Drawing::Screen { draw, .. } => {
            let pictures = views.iter().map(|view| draw(view).or_fail());
            let pictures = pictures.collect::<Result<Vec<_>, _>>()?;
            outputs.prepare(&pictures);
            Ok(hold(&mut outputs, seconds, |outputs| {
                if outputs.prepare_again() {
                    outputs.prepare(&pictures);
                }
            }))
        }
        Drawing::Output { draw, is_moving } => {
            let outlines = neighbours(cave, &projections)?;
            let all: Vec<&str> = projections
                .iter()
                .map(Projection::name)
                .chain(names)
                .collect();
            let events = is_moving.then(enters);
            let paint = |outputs: &mut Outputs| {
                let is_event = (events.as_ref()).is_some_and(|enters| enters.try_recv().is_ok());
                outputs.prepare_own(|output, size, msc| {
                    let name = output.show.as_str();
                    let view = OutputView {
                        name,
                        number: all.iter().position(|one| *one == name).unwrap_or_default(),
                        size,
                        neighbours: outlines.get(name).map_or(&[], Vec::as_slice),
                    };
                    draw(&view, Refresh { msc, is_event }).pixels().to_vec()
                });
            };
            paint(&mut outputs);
            if is_moving {
                say("the pattern takes a line of standard input, such as Enter, for an event");
                Ok(hold(&mut outputs, seconds, paint))
            } else {
                Ok(hold(&mut outputs, seconds, |outputs| {
                    if outputs.prepare_again() {
                        paint(outputs);
                    }
                }))
            }
        }
    }
}

/// Returns the lines of standard input as they come.
fn enters() -> Receiver<()> {
    let (send, receive) = channel();
    // It ends with the program: nothing else stops a read.
    std::thread::spawn(move || {
        for _ in std::io::stdin().lines() {
            if send.send(()).is_err() {
                return;
            }
        }
    });
    receive
}

/// Returns the outlines of other projectors in each projector's pixels, by its name.
fn neighbours(
    cave: &Cave,
    projections: &[Projection],
) -> Result<HashMap<String, Vec<Vec<DVec2>>>, Failure> {
    let all = projections.iter().map(|projection| {
        let size = DVec2::from(projection.resolution().map(f64::from));
        let outlines = cave.outlines(projection.name())?.into_iter();
        let outlines = outlines.map(|outline| outline.into_iter().map(|at| at * size).collect());
        Ok((projection.name().to_owned(), outlines.collect()))
    });
    all.collect()
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
        f.write_str(&files.join("\n"))?;
        (self.outputs.iter()).try_for_each(|outputs| outputs.fmt(f))
    }
}
