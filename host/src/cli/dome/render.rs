//! `shisen dome render`: dome masters of a scene.

use super::camera::{DISTANCE, MirrorChoice, Optics, distance, trace, view};
use crate::bake::{AnyScene, Layout, Stage, StageMemory};
use crate::cave::look::Point;
use crate::cli::arguments::cache::CacheArguments;
use crate::cli::arguments::source::{Loaded, Ready, Shown, Source, is_model};
use crate::cli::arguments::tracing::{TracingArguments, TracingReport};
use crate::cli::arguments::{ModelArguments, SCENES, SceneName};
use crate::cli::output::progress::Ticker;
use crate::cli::output::ray_counts::RayCounts;
use crate::cli::prelude::*;
use crate::dome::{Mapping, Named};
use crate::scene::camera::{CameraPath, DomeCamera};
use crate::with_scene;
use shisen_core::frame::{Statistics, View};
use shisen_core::scene::PoseError;

/// Renders dome masters of a scene, through a mirrored spheroid or without
#[derive(Debug, Args)]
#[command(mut_arg("mapping", |mapping| mapping.default_value("exact")))]
pub(in crate::cli) struct Arguments {
    /// A, B, C or D of Mochizuki and Makino, gallery (a room with every effect), grid (meridians
    /// and parallels every 10° on a sphere about the screen's centre), prism (light through a slit,
    /// seen through a 60° prism), spheres (three balls of quartz), a model, a TOML description or a
    /// baked scene
    #[arg(long, value_name = SCENES, default_value = "A")]
    scene: SceneName,
    #[command(flatten)]
    model: ModelArguments,
    #[command(flatten)]
    mirror: MirrorChoice,
    /// Columns and rows
    #[arg(long, value_name = "PIXELS", default_value_t = 4096,
          value_parser = whole::<u32>(1..=View::MOST_PIXELS))]
    size: u32,
    /// Field of view of --mapping true, degrees above 0 to 360 [default: 180]
    #[arg(long, value_name = "DEGREES", allow_hyphen_values = true, value_parser = number::<f64>)]
    fov: Option<f64>,
    /// Leave left and right exchanged, as in a mirror
    #[arg(long)]
    mirrored: bool,
    /// Radius of the grid, equatorial radii of the mirror [default: 100]
    #[arg(long, value_name = "RADII", value_parser = distance)]
    distance: Option<f64>,
    /// Position of the camera, metres, in place of the scene's cameras [default: 0,0,0 if the scene
    /// has none]
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true)]
    at: Option<Point>,
    /// Angle by which the zenith leans to the front, with or in place of --at, degrees
    #[arg(long, value_name = "DEGREES",
          value_parser = within(-360.0..=360.0, "degrees from -360 to 360, such as 30"))]
    tilt: Option<f64>,
    /// Number of pictures [default: to the last [[camera]], else 1]
    #[arg(long, value_name = "N", value_parser = whole::<u32>(1..=99_999))]
    frames: Option<u32>,
    /// Frames per second of a scene that moves: the first is at 0 s
    #[arg(long, value_name = "FPS", default_value_t = 60.0,
          value_parser = within(0.001..=1e6, "frames per second from 0.001 to 1,000,000"))]
    fps: f64,
    #[command(flatten)]
    tracing: TracingArguments,
    #[command(flatten)]
    cache: CacheArguments,
    #[command(flatten)]
    output: Output,
    #[arg(
        long,
        value_name = "DIR|FILE.png",
        default_value = "shisen-out",
        help = "Folder of the pictures, made if it does not exist, or their name: \
                  shots/Zoo.png stands for shots/Zoo_00001.png and on"
    )]
    out: PathBuf,
}

#[derive(Debug, Args)]
struct Output {
    /// Also write linear EXR files with alpha
    #[arg(long)]
    exr: bool,
    /// Show no progress
    #[arg(long)]
    quiet: bool,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

/// The pictures and what they took.
#[derive(Debug, Serialize, JsonSchema)]
pub(in crate::cli) struct Report {
    /// Pictures.
    images: Vec<Image>,
    /// Files of the same pictures in linear colours; empty without --exr.
    exr: Vec<String>,
    /// Time to trace all frames.
    seconds: f64,
    /// Rays by kind.
    rays: RayCounts,
    /// Tree nodes visited and primitives tested.
    steps: u64,
    /// Columns and rows.
    size: u32,
    /// Number of pictures.
    frames: u32,
    /// How pixels become directions: mirror, exact or true.
    mapping: &'static str,
    /// Name of the mirror; null without a mirror.
    config: Option<&'static str>,
    /// Radius of the mirror, metres; null without a mirror.
    mirror_size: Option<f32>,
    /// Viewpoint from the screen's centre, mirror radii; null without a mirror.
    viewpoint: Option<f64>,
    /// Field of view, degrees.
    fov: f64,
    /// Whether left and right are exchanged.
    mirrored: bool,
    /// Radius of the grid, mirror radii; null for other scenes.
    distance: Option<f64>,
    #[serde(flatten)]
    shown: Shown,
    #[serde(flatten)]
    traced: TracingReport,
}

#[derive(Debug, Serialize, JsonSchema)]
struct Image {
    /// Number of the frame, from 1.
    frame: u32,
    /// File of the picture.
    path: String,
    /// Hash of all pixels, 16 hexadecimal digits.
    hash: Option<String>,
}

// Longer than 80 lines: the report takes a line a field.
pub(super) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let field_of_view = field_of_view(arguments)?;
    let is_grid = matches!(arguments.scene, SceneName::Grid);
    let distance = is_grid.then(|| arguments.distance.unwrap_or(DISTANCE));
    let optics = (arguments.mirror).optics(arguments.mirrored, field_of_view, distance)?;
    let placed = (arguments.at.is_some() || arguments.tilt.is_some()).then(|| {
        let position = arguments.at.map_or(glam::DVec3::ZERO, |at| at.0);
        DomeCamera::tilted(position, arguments.tilt.unwrap_or(0.0).to_radians())
    });
    let camera = placed.unwrap_or(DomeCamera::UPRIGHT);
    // A dome shows nothing that is lower than its camera.
    let model = ModelArguments {
        floor: Some(camera.position.y),
        ..arguments.model.clone()
    };
    // Checked before anything large is loaded.
    view(optics.projection, &camera, arguments.size)?;
    let (ready, path) = load(arguments, &model, &optics, distance, &camera)?;
    let Ready {
        baked,
        moving,
        shown,
        ..
    } = ready;
    let path = placed.map_or(path, |_| CameraPath::default());
    let (folder, named) = match arguments.out.parent() {
        Some(folder) if is_png(&arguments.out) => (folder, &*arguments.out),
        _ => (&*arguments.out, Path::new(&shown.scene)),
    };
    let stem = named.file_stem().unwrap_or("dome".as_ref());
    let file = |frame: u32, extension: &str| {
        folder.join(format!("{}_{frame:05}.{extension}", stem.display()))
    };
    let (mut options, traced) = arguments.tracing.options(&baked)?;
    make_writable(folder)?;
    // Tiles are bands of rows: small ones spread evenly over the threads.
    options.tile = 8;
    let Output { quiet, json, .. } = arguments.output;
    let frames = arguments.frames.unwrap_or(path.frames());
    if frames > 1 && path.frames() <= 1 && moving.is_none() {
        if let Some(time) = arguments.model.time {
            return Err(misuse!(
                "--time {time} lets the scene stand still, so that all {frames} pictures would be \
                 equal: leave out --time or --frames"
            ));
        }
        warn(&format!("nothing moves: all {frames} pictures are equal"));
    }
    let (mut images, mut exr) = (Vec::new(), Vec::new());
    let (mut statistics, mut seconds) = (Statistics::default(), 0.0);
    let mut take = |frame: u32, scene: AnyScene<'_>| -> Result<(), Failure> {
        let camera = path.camera(frame).unwrap_or(camera);
        let view = view(optics.projection, &camera, arguments.size)?;
        let found = trace(scene, &view, &options, quiet || json)?;
        statistics.add(&found.statistics);
        seconds += found.seconds;
        let title = format!("dome master of scene {}, frame {frame}", shown.scene);
        let path = file(frame, "png");
        let (picture, notes) = (&found.picture, metadata(title));
        picture.write_png_with_alpha(&path, &notes).or_fail()?;
        images.push(Image {
            frame,
            path: path.display().to_string(),
            // Takes time, so only if somebody reads it.
            hash: json.then(|| hexadecimal(picture.hash())),
        });
        if arguments.output.exr {
            let path = file(frame, "exr");
            picture.write_exr(&path, &notes).or_fail()?;
            exr.push(path.display().to_string());
        }
        Ok(())
    };
    with_scene!(baked.scene(), |scene| match &moving {
        None => (1..=frames).try_for_each(|frame| take(frame, scene.into()))?,
        Some(moving) => {
            let mut memory = StageMemory::of(&scene, moving);
            let mut stage = Stage::new(scene, moving, &mut memory).map_err(too_far(1, 0.0))?;
            for frame in 1..=frames {
                let time = f64::from(frame - 1) / arguments.fps;
                stage.set_time(time).map_err(too_far(frame, time))?;
                take(frame, stage.scene().into())?;
            }
        }
    });
    let report = Report {
        images,
        exr,
        seconds,
        rays: statistics.into(),
        steps: statistics.steps,
        size: arguments.size,
        frames,
        mapping: arguments.mirror.mapping.name(),
        config: optics.config.map(Named::name),
        mirror_size: optics.config.map(|_| optics.radius),
        viewpoint: optics.config.map(|_| optics.viewpoint),
        fov: arguments.fov.unwrap_or(180.0),
        mirrored: arguments.mirrored,
        distance,
        shown,
        traced,
    };
    print(&report, json)
}

/// Tells of a frame, at a time in seconds, whose pose the core refuses.
fn too_far(frame: u32, time: f64) -> impl Fn(PoseError) -> Fault {
    move |error| {
        let help = "change the animation so that every object stays within 1e12 m, or give fewer \
                    --frames";
        Fault::new(format!("frame {frame}, at {time} s: {error}"), help)
    }
}

/// Returns the scene, and the way of its cameras.
fn load(
    arguments: &Arguments,
    model: &ModelArguments,
    optics: &Optics,
    distance: Option<f64>,
    camera: &DomeCamera,
) -> Result<(Ready, CameraPath), Failure> {
    let mut path = CameraPath::default();
    let mut make = || {
        let name = &arguments.scene;
        let ticker = Ticker::start(format!("reading {name}"), arguments.output.quiet);
        let mut source = Source::load(name, model)?;
        if let Some(distance) = distance {
            source.scene = Loaded::Described(Box::new(optics.grid(distance, camera)?));
        }
        if let Loaded::Described(scene) = &source.scene {
            path = scene.camera.clone();
        }
        source.baked(Layout::Fast, None, &ticker)
    };
    // Other scenes have cameras, which are not kept.
    let is_model = matches!(&arguments.scene, SceneName::File(path) if is_model(path));
    let ready = if is_model {
        let request = format!("dome {:?} {model:?}", arguments.scene);
        arguments.cache.kept(&request, make)
    } else {
        make()
    };
    Ok((ready?, path))
}

/// Checks arguments; returns the field of view, radians. A mirror's is half of all directions.
fn field_of_view(arguments: &Arguments) -> Result<f32, Failure> {
    if arguments.distance.is_some() && !matches!(arguments.scene, SceneName::Grid) {
        return Err(misuse!("--distance is for --scene grid"));
    }
    let mirror = arguments.mirror.mapping != Mapping::True;
    if mirror && arguments.fov.is_some() {
        return Err(misuse!(
            "--fov is for --mapping true: a mirror shows 180 degrees"
        ));
    }
    if !mirror && arguments.mirrored {
        return Err(misuse!(
            "--mirrored is for --mapping mirror or exact: there is no mirror"
        ));
    }
    let degrees = arguments.fov.unwrap_or(180.0);
    if degrees > 0.0 && degrees <= 360.0 {
        // 360 degrees are rounded to a little more than 2π.
        return Ok((degrees.to_radians() as f32).min(std::f32::consts::TAU));
    }
    Err(misuse!(
        "the field of view is {degrees} degrees: give --fov above 0, to 360"
    ))
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let masters = counted(self.frames.into(), "dome master");
        write!(f, "{}: {masters}", self.shown)?;
        match self.config {
            Some(config) => write!(f, " by {config} ({})", self.mapping)?,
            None => write!(f, " of {} degrees without a mirror", self.fov)?,
        }
        let threads = counted(self.traced.threads as u64, "thread");
        let (size, seconds, simd) = (self.size, self.seconds, self.traced.simd);
        write!(f, ", {size} × {size}, traced in {seconds:.3} s ")?;
        writeln!(f, "on {threads} ({simd})")?;
        write!(f, "rays: {}", self.rays)?;
        for image in &self.images {
            write!(f, "\n{}", image.path)?;
        }
        Ok(())
    }
}
