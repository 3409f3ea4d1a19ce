//! `shisen cave`: a frame for the walls of a CAVE.

mod lod;
mod pictures;
mod report;
mod stereo;
mod tracked;

use crate::bake::BakedScene;
use crate::cave::Cave;
use crate::cli::arguments::filling::{FillArguments, Wanted};
use crate::cli::arguments::lod::LodArguments;
use crate::cli::arguments::room::RoomArguments;
use crate::cli::arguments::source::Source;
use crate::cli::arguments::tracing::TracingArguments;
use crate::cli::arguments::{EffectReport, Model, PictureSize, SceneName, field_of_view};
use crate::cli::output::failure::Failure;
use crate::cli::output::picture_files::{hexadecimal, make_writable};
use crate::cli::output::print;
use crate::cli::output::progress::Progress;
use crate::cli::tracker::{Interrupt, TrackerName};
use crate::render::{self, Filling, Frame, Observer, Options};
use crate::show::overview::viewer::ViewerCamera;
use crate::show::stereo::Stereo;
use crate::with_scene;
use clap::Args;
use glam::DVec3;
use lod::{Filled, LodPictures};
use pictures::Writer;
use report::Report;
use std::path::PathBuf;
use tracked::{Follower, TrackerArguments};

/// Renders a frame for the walls of a CAVE
///
/// Writes a PNG a wall and eye, named after them (front-left.png), cave.png
/// (the walls of one eye unfolded) and viewer.png (what the viewer sees of
/// them, looking along --look). Of two eyes, these two show the left one. A
/// dome's PNG is a dome master for that eye, front at the bottom, transparent
/// outside the rim; it is among the walls everywhere else.
///
/// With --json, one object: seconds (of tracing), rays (primary, reflected,
/// refracted, shadow), steps (tree nodes visited and primitives tested),
/// `deepest_stack`, `frame_hash` (16 hexadecimal digits over all pixels),
/// images (wall, eye, path and hash each), exr (paths), cave and viewer
/// (paths), with --stereo stereo (format, `eye_order`, the first eye first, and
/// images, the paths of stereo-cave.png and stereo-viewer.png, or of one each an eye),
/// with --lod levels, polygons and difference (paths), threads, size,
/// scene, mesh (null where the scene file says), simd, depth, samples, effects
/// (the names of those carried out), `effects_asked` (of those that the scene
/// asks for), dispersion (null where it is not carried out: method, wavelengths and
/// each (of these, a ray takes) and `range_nm`) and lod (null without --lod): mode, faces (of each mesh's levels), field (wall, eye,
/// central, peripheral, outside, `mean_level` and `mean_bounces` each), fill
/// (mode, `outside_pixels`, `outside_rms`, of 255 codes, and `outside_psnr`,
/// decibels, against full tracing (null where nothing is outside or differs), and
/// capture, null without: size, seconds, rays, steps, which are part of the
/// frame's, and images, the paths of capture-ahead.png and capture-behind.png)
/// and, of tracing the same in full, `full_seconds`, `full_steps` and `full_rays`.
///
/// With --tracker each frame's pictures go to a folder of its own
/// (frame-00000), and the object is: tracker, hz, frames, seconds, threads,
/// size and scene. A frame has: frame, `shown_us` (since the start), head
/// (position, metres, and orientation, x, y, z, w), gaze (direction), state
/// (fresh, hold, widened, head direction or full quality), widen (radians by
/// which the field of --lod is wider), blink, `gaze_age_us`, `frame_hash` and
/// images (paths).
#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// A, B, C or D of the paper, grid (meridians and parallels on a sphere of
    /// 100 m), prism (light through a slit, seen through a 60° prism), spheres
    /// (three balls of quartz), a TOML description or a baked scene
    #[arg(long, value_name = "A|B|C|D|grid|prism|spheres|FILE", default_value = "A",
          value_parser = SceneName::parser())]
    scene: SceneName,
    #[command(flatten)]
    model: Model,
    #[command(flatten)]
    room: RoomArguments,
    #[command(flatten)]
    tracker: TrackerArguments,
    #[command(flatten)]
    lod: LodArguments,
    #[command(flatten)]
    fill: FillArguments,
    #[command(flatten)]
    tracing: TracingArguments,
    /// Write linear `OpenEXR` files with alpha, too
    #[arg(long)]
    exr: bool,
    /// Columns and rows of viewer.png
    #[arg(long, value_name = "WxH", default_value = "1280x960")]
    view_size: PictureSize,
    /// Horizontal field of view of viewer.png: degrees
    #[arg(long, value_name = "DEGREES", default_value_t = 90.0,
          allow_hyphen_values = true, value_parser = field_of_view)]
    view_fov: f64,
    /// Write what both eyes see for a display of one picture, too: sequential (one
    /// file an eye), side-by-side, top-bottom or anaglyph (for red-cyan glasses); mono
    /// writes none
    #[arg(long, value_name = "FORMAT", default_value_t = Stereo::Mono)]
    stereo: Stereo,
    /// Folder of the pictures; made where it does not exist
    #[arg(long, value_name = "DIR", default_value = "shisen-out")]
    out: PathBuf,
    /// Show no progress
    #[arg(long)]
    quiet: bool,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

impl Arguments {
    /// What each eye sees looking so, and what is up then.
    fn cameras(
        &self,
        eyes: &[Observer],
        (forward, up): (DVec3, DVec3),
    ) -> Result<Vec<ViewerCamera>, Failure> {
        let field_of_view = self.view_fov.to_radians();
        eyes.iter()
            .map(|eye| {
                ViewerCamera::new(eye.place, forward, up, field_of_view, self.view_size.0)
                    .map_err(Failure::from_error)
            })
            .collect()
    }
}

/// Runs the command.
pub(super) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let cave = arguments.room.cave()?;
    let pose = arguments.room.head();
    let eyes = arguments.room.eyes(pose);
    let (forward, up) = arguments.room.directions(pose);
    let observers = arguments.lod.observers(eyes.clone(), (forward, up), 0.0)?;
    let wanted = arguments.fill.wanted(arguments.lod.is_on())?;
    arguments.room.check_stereo(arguments.stereo)?;
    // Seen before anything large is loaded or any file is written.
    for (_, position) in eyes.clone() {
        cave.check_eye(position)?;
    }
    let cameras = arguments.cameras(&observers, (forward, up))?;
    let source = Source::load(&arguments.scene, &arguments.model)?;
    let baked = arguments.lod.baked(source.scene, &source.name)?;
    let (options, dispersion) = arguments.tracing.options(&baked)?;
    make_writable(&arguments.out)?;
    let frames = Frames {
        baked: &baked,
        cave: &cave,
        options: &options,
        quiet: arguments.quiet || arguments.json,
    };
    let title = match &source.mesh {
        Some(mesh) => format!("scene {}, mesh {mesh}", source.name),
        None => format!("scene {}", source.name),
    };
    if let Some(tracker) = &arguments.tracker.tracker {
        return follow(arguments, tracker, &frames, &title, source.name);
    }
    let frame = match wanted {
        Wanted::Background => frames.render(&observers, Filling::Background)?,
        Wanted::Capture(how) => frames.render(&observers, Filling::Capture(how))?,
        Wanted::Previous(look) => {
            let looked = look.basis();
            let before = arguments
                .lod
                .observers(eyes.clone(), (looked.forward, looked.up), 0.0)?;
            let previous = frames.render(&before, Filling::Background)?;
            frames.render(&observers, Filling::Previous(&previous))?
        }
    };
    let full = arguments.lod.is_on().then(|| frames.in_full(&observers));
    let full = full.transpose()?;
    let lod_pictures = match &full {
        Some(full) => lod_pictures(&baked, &cave, &observers, &options, (&frame, full))?,
        None => None,
    };
    let writer = Writer {
        folder: &arguments.out,
        title: &title,
        exr: arguments.exr,
        stereo: arguments.stereo,
    };
    let captured = writer.write_capture(frame.capture.as_ref())?;
    let written = writer.write(&frame, &cave, &observers, &cameras, lod_pictures.as_ref())?;
    let report = Report {
        seconds: frame.seconds,
        rays: frame.statistics.into(),
        steps: frame.statistics.steps,
        deepest_stack: frame.statistics.deepest_stack,
        frame_hash: hexadecimal(frame.hash()),
        written,
        threads: options.threads,
        size: arguments.room.size,
        scene: source.name,
        mesh: source.mesh,
        simd: baked.layout().simd(options.simd).name(),
        depth: arguments.tracing.depth,
        samples: arguments.tracing.samples,
        effects: EffectReport::new(&options.effects, &baked),
        dispersion,
        lod: match &full {
            Some(full) => {
                let filled = Filled {
                    wanted,
                    frame: &frame,
                    images: captured,
                };
                let depth = arguments.tracing.depth;
                let lod = &arguments.lod;
                Some(lod::report(
                    lod, &baked, &cave, &observers, depth, full, filled,
                )?)
            }
            None => None,
        },
        folder: arguments.out.display().to_string(),
        walls: cave.walls.len(),
        domes: cave.domes.len(),
        eyes: eyes.count(),
    };
    print(&report, arguments.json)
}

/// Renders one frame after another along a tracker.
fn follow(
    arguments: &Arguments,
    tracker: &TrackerName,
    frames: &Frames<'_>,
    title: &str,
    scene: String,
) -> Result<(), Failure> {
    let TrackerArguments {
        frames: count, hz, ..
    } = arguments.tracker;
    let interrupt = Interrupt::watched();
    let mut follower = Follower::new(
        tracker,
        &arguments.tracker,
        arguments.room.head(),
        &interrupt,
    )?;
    let mut seconds = 0.0;
    let mut reports = Vec::new();
    for number in 0..count {
        if interrupt.came() {
            break;
        }
        let estimate = follower.frame(number);
        let eyes = arguments.room.eyes(estimate.head);
        let sight = estimate.line_of_sight;
        let (forward, up) = (sight.forward().as_dvec3(), sight.up().as_dvec3());
        let observers = arguments
            .lod
            .observers(eyes.clone(), (forward, up), estimate.widen)?;
        for (_, position) in eyes {
            frames.cave.check_eye(position)?;
        }
        let cameras = arguments.cameras(&observers, (forward, up))?;
        let frame = frames.render(&observers, Filling::Background)?;
        seconds += frame.seconds;
        let writer = Writer {
            folder: &tracked::folder(&arguments.out, number)?,
            title,
            exr: arguments.exr,
            stereo: arguments.stereo,
        };
        let written = writer.write(&frame, frames.cave, &observers, &cameras, None)?;
        let stereo = written.stereo.into_iter().flat_map(|stereo| stereo.images);
        let images = written.images.into_iter().map(|image| image.path);
        let images = images.chain(stereo).collect();
        let hash = hexadecimal(frame.hash());
        reports.push(tracked::FrameReport::new(number, &estimate, hash, images));
    }
    let report = tracked::Report {
        tracker: tracker.to_string(),
        hz,
        frames: reports,
        seconds,
        threads: frames.options.threads,
        size: arguments.room.size,
        scene,
    };
    print(&report, arguments.json)
}

fn lod_pictures(
    baked: &BakedScene,
    cave: &Cave,
    observers: &[Observer],
    options: &Options,
    frames: (&Frame, &Frame),
) -> Result<Option<LodPictures>, Failure> {
    let Some((observer, lod)) = observers
        .first()
        .and_then(|one| Some((one, one.lod.as_ref()?)))
    else {
        return Ok(None);
    };
    let of = (observer, lod);
    let pictures = with_scene!(baked, |scene| LodPictures::new(
        &scene, cave, of, options, frames
    ));
    pictures.map(Some)
}

/// What the frames of one run have in common.
struct Frames<'r> {
    baked: &'r BakedScene,
    cave: &'r Cave,
    options: &'r Options,
    quiet: bool,
}

impl Frames<'_> {
    fn render(&self, eyes: &[Observer], filling: Filling<'_>) -> Result<Frame, Failure> {
        let Self { cave, options, .. } = self;
        let progress = Progress::new(self.quiet);
        let show = |done, total| progress.show(done, total);
        let frame = with_scene!(self.baked, |scene| render::cave_filled(
            &scene, cave, eyes, options, filling, &show
        ));
        progress.finish();
        Ok(frame?)
    }

    /// With nothing that follows the gaze.
    fn in_full(&self, eyes: &[Observer]) -> Result<Frame, Failure> {
        let full: Vec<_> = eyes
            .iter()
            .map(|one| Observer::new(one.eye, one.place))
            .collect();
        self.render(&full, Filling::Background)
    }
}
