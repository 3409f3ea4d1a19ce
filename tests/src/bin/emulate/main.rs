//! The command line of `tests/firmware/run`: the display controller in an emulator.

mod report;

use clap::Parser;
use glam::Vec3;
use report::{FrameReport, Report};
use shisen::bake::{BakedScene, Layout};
use shisen::cave::{Cave, DEFAULT_INTERPUPILLARY_DISTANCE, Wall};
use shisen::cli::arguments::source::{Loaded, Source, bake};
use shisen::cli::arguments::{LevelArguments, ModelArguments, SceneName, WallsName, turn};
use shisen::cli::numbers::whole;
use shisen::cli::output::failure::Failure;
use shisen::cli::output::picture_files::{make_writable, metadata};
use shisen::cli::output::print;
use shisen::cli::output::progress::Ticker;
use shisen::cli::program::{self, Examples, Program, Schemas, schema};
use shisen::cli::tracker::{Recorded, with_help};
use shisen::files::Fault;
use shisen::picture::Picture;
use shisen::render::frame_hash;
use shisen::tracker::{Recording, Spec, TrackerKind, simulated};
use shisen_core::frame::{FlatScreen, MAX_DEPTH};
use shisen_core::scene::EffectSet;
use shisen_tests::firmware::{
    FirmwareError, Image, MOST_SCREENS, Run, ShownFrame, TrackerBytes, Watched, reference, watch,
};
use shisen_tracker::link::display::{Rendering, Subject};
use shisen_tracker::mock::Wire;
use shisen_tracker::protocol::Protocol;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::str::FromStr;

impl Program for Arguments {
    const EXAMPLES: Examples = "\
# tests/firmware/run
  One frame of scene A:
    tests/firmware/run --frames 1
  A room and a model of one's own, for both eyes:
    tests/firmware/run --walls room.toml --mesh cow.obj --eyes 2 --frames 1
  What a recorded tracker makes of it, as JSON:
    tests/firmware/run --tracker replay:gaze.csv --json
";
    const SCHEMAS: Schemas = &[("", schema::<Report>)];

    fn run(&self) -> Result<(), Failure> {
        run(self)
    }
}

fn main() -> ExitCode {
    program::main::<Arguments>()
}

/// Runs the firmware and compares its frames with the host's
///
/// The board has the scene in its memory, reads the tracker on one serial port
/// and sends finished tiles on another. Each frame reports its gaze and its
/// budget; the host renders the same frame from these, in the same layout, and
/// both must be equal, bit for bit. Without --image the firmware is built
/// from tests/firmware. Needs qemu-system-arm.
///
/// The emulator counts instructions: a division is one, memory takes no time.
#[derive(Debug, Parser)]
#[command(name = "tests/firmware/run", bin_name = "tests/firmware/run")]
struct Arguments {
    /// An ELF file of the controller [default: it is built]
    #[arg(long, value_name = "ELF")]
    image: Option<PathBuf>,
    /// A, B, C or D of the paper, grid, prism, spheres, a TOML description or a
    /// scene baked in the compact layout
    #[arg(
        long,
        value_name = "A|B|C|D|grid|prism|spheres|FILE",
        default_value = "A"
    )]
    scene: SceneName,
    #[command(flatten)]
    model: ModelArguments,
    #[command(flatten)]
    levels: LevelArguments,
    /// mock, mock:… or replay:FILE, sent as our own link; none for a silent
    /// tracker
    #[arg(long, value_name = "SPEC", default_value = "mock:rate=120")]
    tracker: TrackerChoice,
    /// three-wall, cube or a TOML file of up to 6 walls
    #[arg(long, value_name = "NAME|FILE", default_value = "three-wall")]
    walls: WallsName,
    /// Pixels along each side of a wall without a size of its own
    #[arg(long, value_name = "PIXELS", default_value_t = 64,
          value_parser = whole::<u32>(1..=Wall::MOST_PIXELS))]
    size: u32,
    /// One eye in the middle of the head, or two
    #[arg(long, value_name = "1|2", default_value_t = 1,
          value_parser = whole::<u8>(1..=2))]
    eyes: u8,
    /// Whether detail follows the gaze: paper or off
    #[arg(long, value_name = "paper|off", default_value = "paper",
          value_parser = ["paper", "off"])]
    lod: String,
    /// Most reflections and refractions in a row
    #[arg(long, value_name = "N", default_value_t = 3,
          value_parser = whole::<u8>(0..=MAX_DEPTH))]
    depth: u8,
    /// Wavelengths that dispersive media distinguish; more than 1 needs a
    /// firmware with dispersion, which is then built
    #[arg(long, value_name = "N", default_value_t = 1,
          value_parser = whole::<u8>(1..=32))]
    wavelengths: u8,
    /// Steps that a frame may take [default: all that it needs]
    #[arg(long, value_name = "STEPS", value_parser = whole::<u64>(0..))]
    budget: Option<u64>,
    /// Steps of a slice, after which the board reads its ports
    #[arg(long, value_name = "STEPS", default_value_t = 10_000,
          value_parser = whole::<u32>(1..))]
    slice: u32,
    /// Degrees that the line of sight may move while a frame is rendered: beyond that the
    /// frame is cut short and the next begun; 0 finishes each frame
    #[arg(long, value_name = "DEGREES", default_value_t = 5.0, value_parser = turn)]
    restart: f32,
    /// Frames of the walls
    #[arg(long, value_name = "N", default_value_t = 3,
          value_parser = whole::<u32>(1..=100_000))]
    frames: u32,
    /// Pixels a side of a dome master from the room's origin, rendered after the frames
    #[arg(long, value_name = "PIXELS", value_parser = whole::<u16>(1..=512))]
    capture: Option<u16>,
    /// Folder for the pictures; created if it does not exist
    #[arg(long, value_name = "DIR", default_value = "shisen-out")]
    out: PathBuf,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

/// The value of `--tracker`.
#[derive(Debug, Clone)]
struct TrackerChoice(Option<Spec>);

impl FromStr for TrackerChoice {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if text == "none" {
            return Ok(Self(None));
        }
        let spec: Spec = text.parse().map_err(|error: Fault| with_help(&error))?;
        if spec.head.is_some() {
            return Err(
                "the board takes the first sensor for the viewer's head: leave head \
                        out"
                .to_owned(),
            );
        }
        match &spec.kind {
            TrackerKind::Mock(mock)
                if mock.protocol.as_ref().is_none_or(|p| p.name() == "link") => {}
            TrackerKind::Replay(_) => {}
            _ => {
                return Err("the board's tracker speaks our own link: give mock, \
                            replay:FILE or none"
                    .to_owned());
            }
        }
        Ok(Self(Some(spec)))
    }
}

impl TrackerChoice {
    fn bytes(&self) -> Result<Option<TrackerBytes>, Failure> {
        Ok(match self.0.as_ref().map(|spec| &spec.kind) {
            Some(TrackerKind::Replay(path)) => {
                let recording = Recording::read(path)?;
                let samples = Recorded::new(recording.samples().copied().collect());
                Some(Box::new(Wire::new(samples, Protocol::Link)))
            }
            Some(TrackerKind::Mock(spec)) => {
                Some(Box::new(Wire::new(simulated(spec)?, Protocol::Link)))
            }
            // Other files are refused when they are read.
            _ => None,
        })
    }
}

/// Runs the command.
fn run(arguments: &Arguments) -> Result<(), Failure> {
    let cave = arguments.walls.cave([arguments.size; 2])?;
    let screens = screens(&cave)?;
    let source = Source::load(&arguments.scene, &arguments.model)?;
    let baked = compact(source.scene, &source.shown.scene, &arguments.levels)?;
    let BakedScene::Compact(scene) = &baked else {
        return Err(Failure::usage(&format!(
            "{} was baked for hosts: bake it again with `shisen bake --layout compact`",
            source.shown.scene
        )));
    };
    // Checked before a firmware is built, which takes long.
    let tracker = arguments.tracker.bytes()?;
    let dispersion = arguments.wavelengths > 1;
    let image = arguments.image.as_ref().map(|path| Image::open(path));
    let image = image.transpose()?;
    make_writable(&arguments.out)?;
    let image = match image {
        Some(image) => image,
        None => Image::build(dispersion)?,
    };
    let rendering = Rendering {
        budget: arguments.budget.unwrap_or(u64::MAX),
        slice: arguments.slice,
        depth: arguments.depth,
        wavelengths: arguments.wavelengths,
        lod: arguments.lod == "paper",
        eye_distance: if arguments.eyes == 2 {
            DEFAULT_INTERPUPILLARY_DISTANCE as f32
        } else {
            0.0
        },
        display_delay: 20_000,
        restart_angle: arguments.restart.to_radians(),
    };
    let watched = watch(Run {
        image: &image,
        scene: baked.as_bytes(),
        screens: &screens,
        rendering,
        frames: arguments.frames,
        capture: arguments.capture.map(|size| (size, Vec3::ZERO)),
        tracker,
        patience: PATIENCE,
    })?;
    let linked = EffectSet::from_bits_truncate(watched.ready.linked);
    if dispersion && !linked.contains(EffectSet::DISPERSION) {
        return Err(Failure::from_error(FirmwareError::new(
            "the firmware has no code for wavelengths",
            "build it with the feature dispersion, leave out --image, or give --wavelengths 1",
        )));
    }
    let without = !linked.contains(EffectSet::DISPERSION);
    let again = |frame: &ShownFrame| {
        let pictures = reference(scene.scene(), &screens, &rendering, frame, without)?;
        let hash = frame_hash(pictures.iter().map(Picture::hash));
        Ok(FrameReport::new(frame, hash))
    };
    let frames = watched.frames.iter().map(again);
    let frames = frames.collect::<Result<Vec<_>, Failure>>()?;
    let equal = frames.iter().all(FrameReport::is_equal);
    let images = write(&arguments.out, &watched, &cave, arguments.eyes)?;
    let report = Report::new(&image, source.shown.scene, &watched, frames, images);
    print(&report, arguments.json)?;
    if equal {
        Ok(())
    } else {
        let what = "the firmware's frames are not the host's";
        Err(Failure::from_error(FirmwareError::other_sources(what)))
    }
}

/// Seconds of silence after which the firmware counts as hung.
const PATIENCE: f64 = 60.0;

/// Returns the walls of a room in the board's form.
fn screens(cave: &Cave) -> Result<Vec<FlatScreen>, Failure> {
    let is_flat = cave.domes.is_empty() && cave.cylinders.is_empty();
    if !is_flat || cave.walls.len() > MOST_SCREENS {
        return Err(Failure::usage(&format!(
            "the board shows up to {MOST_SCREENS} walls and nothing curved: give another --walls"
        )));
    }
    Ok(cave.walls.iter().map(Wall::flat_screen).collect())
}

fn compact(scene: Loaded, name: &str, levels: &LevelArguments) -> Result<BakedScene, Failure> {
    match scene {
        Loaded::Baked(baked) => match levels.given() {
            Some(argument) => Err(Failure::usage(&format!(
                "{argument} is for scenes that are not baked yet, and {name} is"
            ))),
            None => Ok(baked),
        },
        Loaded::Described(scene) => {
            let levels = levels.polygon_levels(Layout::Compact)?;
            let ticker = Ticker::start(format!("baking {name}"), false);
            let (baked, _) = bake(&scene, name, Layout::Compact, Some(&levels), &ticker)?;
            Ok(baked)
        }
    }
}

/// Writes the dome master and the last whole frame of the walls, or the last frame if none is whole.
fn write(folder: &Path, watched: &Watched, cave: &Cave, eyes: u8) -> Result<Vec<String>, Failure> {
    let mut images = Vec::new();
    let mut write = |name: String, picture: &Picture| {
        let path = folder.join(name);
        let note = metadata("a frame of the display controller's firmware".to_owned());
        picture
            .write_png(&path, &note)
            .map_err(Failure::from_error)?;
        images.push(path.display().to_string());
        Ok::<(), Failure>(())
    };
    let is_screens = |frame: &&ShownFrame| frame.start.subject == Subject::Screens;
    let is_whole = |frame: &&ShownFrame| frame.done.is_some_and(|done| !done.cut_short);
    let walls = || watched.frames.iter().filter(is_screens);
    if let Some(frame) = walls().rfind(is_whole).or(walls().next_back()) {
        let eyes: &[&str] = if eyes == 2 {
            &["left", "right"]
        } else {
            &["centre"]
        };
        let names = cave.walls.iter();
        let names =
            names.flat_map(|wall| eyes.iter().map(|eye| format!("{}-{eye}.png", wall.name)));
        for (name, picture) in names.zip(&frame.pictures) {
            write(name, picture)?;
        }
    }
    if let Some(frame) = watched.frames.iter().rfind(|frame| !is_screens(frame)) {
        for picture in &frame.pictures {
            write("dome.png".to_owned(), picture)?;
        }
    }
    Ok(images)
}
