//! `shisen dome render`: dome masters of a scene.

use super::camera::{DISTANCE, MirrorChoice, distance, trace, view};
use crate::bake::Layout;
use crate::cave::look::Point;
use crate::cli::arguments::dispersion::DispersionReport;
use crate::cli::arguments::source::{Loaded, Source, bake};
use crate::cli::arguments::tracing::TracingArguments;
use crate::cli::arguments::{EffectReport, Model, SceneName, number, number_within, whole};
use crate::cli::output::failure::Failure;
use crate::cli::output::picture_files::{hexadecimal, make_writable, metadata};
use crate::cli::output::ray_counts::RayCounts;
use crate::cli::output::{counted, print};
use crate::dome::{Mapping, Named};
use crate::scene::camera::{CameraPath, DomeCamera};
use clap::Args;
use serde::Serialize;
use shisen_core::frame::{Statistics, View};
use std::fmt;
use std::path::{Path, PathBuf};

/// Renders dome masters of a scene, through a mirrored spheroid or without
///
/// Writes a PNG with alpha a frame, `Name_00001.png` and on, along the
/// [[camera]]s of the scene's description; of another scene, one from --at.
/// Front is at the bottom of the picture, right at the right. What is outside
/// the rim is transparent.
///
/// With --json, one object: images (frame, path and hash each, the hash 16
/// hexadecimal digits over all pixels), exr (paths), seconds (of tracing),
/// rays (primary, reflected, refracted, shadow), steps (tree nodes visited and
/// primitives tested), size, frames, mapping, config, `mirror_size` (metres),
/// viewpoint (radii from the screen's centre; these three null without a
/// mirror), `fov` (degrees), mirrored, distance (null but for the grid), scene,
/// mesh (null where there is none to choose), threads, simd, depth, samples,
/// effects (the names of those carried out), `effects_asked` (of those that the
/// scene asks for) and dispersion (null where it is not carried out: method,
/// wavelengths, each and `range_nm`).
#[derive(Debug, Args)]
#[command(mut_arg("mapping", |mapping| mapping.default_value("exact")))]
pub(in crate::cli) struct Arguments {
    /// A, B, C or D of Mochizuki and Makino, grid (meridians and parallels every
    /// 10° on a sphere about the screen's centre), prism (light through a slit,
    /// seen through a 60° prism), spheres (three balls of quartz), a TOML
    /// description or a baked scene
    #[arg(long, value_name = "A|B|C|D|grid|prism|spheres|FILE", default_value = "A",
          value_parser = SceneName::parser())]
    scene: SceneName,
    #[command(flatten)]
    model: Model,
    #[command(flatten)]
    mirror: MirrorChoice,
    /// Columns and rows
    #[arg(long, value_name = "PIXELS", default_value_t = 4096,
          value_parser = whole::<u32>(1..=View::MOST_PIXELS))]
    size: u32,
    /// Field of view of --mapping true: degrees, above 0 to 360 [default: 180]
    #[arg(long, value_name = "DEGREES", allow_hyphen_values = true,
          value_parser = number::<f64>)]
    fov: Option<f64>,
    /// Leave left and right exchanged, as a mirror shows them
    #[arg(long)]
    mirrored: bool,
    /// Radius of the grid, in equatorial radii of the mirror [default: 100]
    #[arg(long, value_name = "RADII", allow_hyphen_values = true, value_parser = distance)]
    distance: Option<f64>,
    /// Where the pictures are taken, in place of the scene's cameras: metres
    /// [default: 0,0,0 where the scene has none]
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true)]
    at: Option<Point>,
    /// How far the zenith leans to the front, with or in place of --at: degrees
    #[arg(long, value_name = "DEGREES", allow_hyphen_values = true, value_parser = tilt)]
    tilt: Option<f64>,
    /// Pictures, from the first [default: to the last [[camera]], else 1]
    #[arg(long, value_name = "N", value_parser = whole::<u32>(1..=99_999))]
    frames: Option<u32>,
    #[command(flatten)]
    tracing: TracingArguments,
    #[command(flatten)]
    output: Output,
    /// Folder of the pictures, made where it does not exist, or their name: of
    /// shots/Zoo.png they are `shots/Zoo_00001.png` and on
    #[arg(long, value_name = "DIR|FILE.png", default_value = "shisen-out")]
    out: PathBuf,
}

/// What goes where, beside the pictures.
#[derive(Debug, Args)]
struct Output {
    /// Write linear `OpenEXR` files with alpha, too
    #[arg(long)]
    exr: bool,
    /// Show no progress
    #[arg(long)]
    quiet: bool,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

/// `--tilt`.
fn tilt(text: &str) -> Result<f64, String> {
    number_within(text, -360.0, 360.0)
        .ok_or_else(|| "give degrees from -360 to 360, such as 30".to_owned())
}

/// What was rendered and what it took.
#[derive(Debug, Serialize)]
struct Report {
    images: Vec<Image>,
    /// The same pictures, linear; empty where nobody asked for them.
    exr: Vec<String>,
    /// Of tracing alone, all frames.
    seconds: f64,
    rays: RayCounts,
    steps: u64,
    size: u32,
    frames: u32,
    mapping: &'static str,
    config: Option<&'static str>,
    mirror_size: Option<f32>,
    viewpoint: Option<f64>,
    fov: f64,
    mirrored: bool,
    distance: Option<f64>,
    scene: String,
    mesh: Option<String>,
    threads: usize,
    simd: &'static str,
    depth: u8,
    samples: u16,
    #[serde(flatten)]
    effects: EffectReport,
    dispersion: Option<DispersionReport>,
}

#[derive(Debug, Serialize)]
struct Image {
    frame: u32,
    path: String,
    /// `None` without --json.
    hash: Option<String>,
}

/// Where pictures go: a folder and what their names begin with.
struct Names {
    folder: PathBuf,
    stem: String,
}

impl Names {
    /// By `--out`, else after the scene.
    fn new(out: &Path, scene: &str) -> Self {
        let is_picture = out
            .extension()
            .is_some_and(|extension| extension.eq_ignore_ascii_case("png"));
        let stem = |path: &Path| {
            path.file_stem().map_or_else(
                || "dome".to_owned(),
                |stem| stem.to_string_lossy().into_owned(),
            )
        };
        if is_picture {
            Self {
                folder: out.parent().unwrap_or(Path::new("")).to_owned(),
                stem: stem(out),
            }
        } else {
            Self {
                folder: out.to_owned(),
                stem: stem(Path::new(scene)),
            }
        }
    }

    fn path(&self, frame: u32, extension: &str) -> PathBuf {
        let name = format!("{}_{frame:05}.{extension}", self.stem);
        self.folder.join(name)
    }
}

/// Runs the command.
pub(super) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let field_of_view = field_of_view(arguments)?;
    let is_grid = matches!(arguments.scene, SceneName::Grid);
    if arguments.distance.is_some() && !is_grid {
        return Err(Failure::usage("--distance is for --scene grid"));
    }
    let distance = is_grid.then(|| arguments.distance.unwrap_or(DISTANCE));
    let mirror = &arguments.mirror;
    let optics = mirror.optics(arguments.mirrored, field_of_view, distance)?;
    let placed = placed(arguments);
    // Seen before anything large is loaded.
    let camera = placed.unwrap_or(DomeCamera::UPRIGHT);
    view(optics.projection, &camera, arguments.size)?;
    let mut source = Source::load(&arguments.scene, &arguments.model)?;
    if let Some(distance) = distance {
        source.scene = Loaded::Described(optics.grid(distance, &camera)?);
    }
    let (baked, path) = match source.scene {
        Loaded::Baked(baked) => (baked, CameraPath::default()),
        Loaded::Described(scene) => {
            let baked = bake(&scene, &source.name, Layout::Fast, None)?;
            (baked, scene.camera)
        }
    };
    let path = if placed.is_some() {
        CameraPath::default()
    } else {
        path
    };
    let names = Names::new(&arguments.out, &source.name);
    let (mut options, dispersion) = arguments.tracing.options(&baked)?;
    make_writable(&names.folder)?;
    // Bands of rows: few enough for short ones to be shared out.
    options.tile = 8;
    let quiet = arguments.output.quiet || arguments.output.json;
    let frames = arguments.frames.unwrap_or(path.frames());
    let (mut images, mut exr) = (Vec::new(), Vec::new());
    let (mut statistics, mut seconds) = (Statistics::default(), 0.0);
    for frame in 1..=frames {
        let camera = path.camera(frame).or(placed);
        let camera = camera.unwrap_or(DomeCamera::UPRIGHT);
        let view = view(optics.projection, &camera, arguments.size)?;
        let found = trace(&baked, &view, &options, quiet)?;
        statistics.add(&found.statistics);
        seconds += found.seconds;
        let title = format!("dome master of scene {}, frame {frame}", source.name);
        let path = names.path(frame, "png");
        found
            .picture
            .write_png_with_alpha(&path, &metadata(title.clone()))
            .map_err(Failure::from_error)?;
        images.push(Image {
            frame,
            path: path.display().to_string(),
            // Of all its pixels, so only where somebody reads it.
            hash: (arguments.output.json).then(|| hexadecimal(found.picture.hash())),
        });
        if arguments.output.exr {
            let path = names.path(frame, "exr");
            found
                .picture
                .write_exr(&path, &metadata(title))
                .map_err(Failure::from_error)?;
            exr.push(path.display().to_string());
        }
    }
    let config = optics.config;
    let report = Report {
        images,
        exr,
        seconds,
        rays: statistics.into(),
        steps: statistics.steps,
        size: arguments.size,
        frames,
        mapping: arguments.mirror.mapping.0.name(),
        config: config.map(Named::name),
        mirror_size: config.map(|_| optics.radius),
        viewpoint: config.map(|_| optics.viewpoint),
        fov: arguments.fov.unwrap_or(180.0),
        mirrored: arguments.mirrored,
        distance,
        scene: source.name,
        mesh: source.mesh,
        threads: options.threads,
        simd: baked.layout().simd(options.simd).name(),
        depth: arguments.tracing.depth,
        samples: arguments.tracing.samples,
        effects: EffectReport::new(&options.effects, &baked),
        dispersion,
    };
    print(&report, arguments.output.json)
}

/// The field of view, radians: a mirror's is half of all directions.
fn field_of_view(arguments: &Arguments) -> Result<f32, Failure> {
    let mirror = arguments.mirror.mapping.0 != Mapping::True;
    if mirror && arguments.fov.is_some() {
        return Err(Failure::usage(
            "--fov is for --mapping true: through the mirror it is 180 degrees",
        ));
    }
    if !mirror && arguments.mirrored {
        return Err(Failure::usage(
            "--mirrored is for --mapping mirror or exact: there is no mirror",
        ));
    }
    let degrees = arguments.fov.unwrap_or(180.0);
    if degrees > 0.0 && degrees <= 360.0 {
        // 360 degrees round to a little more than 2π.
        return Ok((degrees.to_radians() as f32).min(std::f32::consts::TAU));
    }
    Err(Failure::usage(&format!(
        "the field of view is {degrees} degrees: give --fov above 0, to 360"
    )))
}

/// The camera that arguments place, in place of the scene's.
fn placed(arguments: &Arguments) -> Option<DomeCamera> {
    if arguments.at.is_none() && arguments.tilt.is_none() {
        return None;
    }
    let position = arguments.at.map_or(glam::DVec3::ZERO, |at| at.0);
    let tilt = arguments.tilt.unwrap_or(0.0).to_radians();
    Some(DomeCamera::tilted(position, tilt))
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let masters = counted(self.frames.into(), "dome master");
        write!(f, "scene {}: {masters}", self.scene)?;
        match self.config {
            Some(config) => write!(f, " by {config} ({})", self.mapping)?,
            None => write!(f, " of {} degrees without a mirror", self.fov)?,
        }
        writeln!(
            f,
            ", {0} × {0}, traced in {1:.3} s on {2} ({3})",
            self.size,
            self.seconds,
            counted(self.threads as u64, "thread"),
            self.simd
        )?;
        write!(f, "rays: {}", self.rays)?;
        for image in &self.images {
            write!(f, "\n{}", image.path)?;
        }
        Ok(())
    }
}
