//! `shisen cave`: one frame for the walls of a CAVE, or some that follow a tracker.

mod lod;
pub(super) mod pictures;
pub(super) mod report;
mod tracked;

use crate::bake::Layout;
use crate::cli::arguments::cache::CacheArguments;
use crate::cli::arguments::filling::{Fill, FillArguments};
use crate::cli::arguments::lod::{LodArguments, to_be_filled};
use crate::cli::arguments::room::{RoomArguments, ViewArguments};
use crate::cli::arguments::source::Ready;
use crate::cli::arguments::tracing::TracingArguments;
use crate::cli::arguments::{ModelArguments, SCENES, SceneName};
use crate::cli::output::progress::Progress;
use crate::cli::prelude::*;
use crate::cli::tracker::{Interrupt, names};
use crate::render::{self, Filling, Frame, Observer, Options};
use crate::show::stereo::Stereo;
use lod::LodPictures;
use pictures::Writer;
use report::{Head, Report, TrackedFrame, TrackedFrames};
use tracked::{Follower, TrackerArguments};

/// Renders a frame for the walls of a CAVE
#[derive(Debug, Args)]
#[command(mut_arg("lod", to_be_filled))]
pub(super) struct Arguments {
    /// A, B, C or D of the paper, gallery (a room with every effect), grid (meridians and parallels
    /// on a sphere of 100 m), prism (light through a slit, seen through a 60° prism), spheres (three
    /// balls of quartz), a model, a TOML description or a baked scene
    #[arg(long, value_name = SCENES, default_value = "A")]
    scene: SceneName,
    #[command(flatten)]
    model: ModelArguments,
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
    #[command(flatten)]
    cache: CacheArguments,
    /// Also write linear EXR files with alpha
    #[arg(long)]
    exr: bool,
    #[command(flatten)]
    view: ViewArguments,
    /// Also write both eyes' views for a display of one picture: sequential (one file an eye),
    /// side-by-side, top-bottom or anaglyph (for red-cyan glasses); mono writes none
    #[arg(long, value_name = "FORMAT", default_value_t = Stereo::Mono)]
    stereo: Stereo,
    /// Folder of the pictures; made if it does not exist
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
    fn writer<'w>(&self, folder: &'w Path, title: &'w str) -> Writer<'w> {
        Writer {
            folder,
            title,
            exr: self.exr,
            stereo: self.stereo,
        }
    }
}

pub(super) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let cave = arguments.room.cave()?;
    let pose = arguments.room.head();
    let mut eyes = arguments.room.eyes(pose);
    let (forward, up) = arguments.room.directions(pose);
    (arguments.room).check_camera(arguments.model.camera.as_deref())?;
    let mut observers = arguments.lod.observers(eyes.clone(), (forward, up), 0.0)?;
    let looked = arguments.fill.looked(&arguments.lod)?;
    arguments.room.check_stereo(arguments.stereo)?;
    // Checked before anything large is loaded or any file is written.
    arguments.room.check_eyes(&cave, pose)?;
    let mut cameras = arguments.view.cameras(&observers, (forward, up))?;
    let quiet = arguments.quiet;
    let model = arguments.model.within(&cave);
    let ready = (arguments.lod).ready(
        &arguments.scene,
        &model,
        &arguments.cache,
        Layout::Fast,
        quiet,
    )?;
    if let Some(look) = ready.look() {
        let (directions, pose) = (look.directions(), arguments.room.head_towards(Some(look)));
        arguments.room.check_eyes(&cave, pose)?;
        eyes = arguments.room.eyes(pose);
        observers = arguments.lod.observers(eyes.clone(), directions, 0.0)?;
        cameras = arguments.view.cameras(&observers, directions)?;
    }
    let Ready { baked, shown, .. } = ready;
    let (options, mut traced) = arguments.tracing.options(&baked)?;
    make_writable(&arguments.out)?;
    let frames = Frames {
        baked: &baked,
        cave: &cave,
        options: &options,
        quiet: arguments.quiet || arguments.json,
    };
    let mesh = shown.mesh.as_ref();
    let mesh = mesh.map_or(String::new(), |mesh| format!(", mesh {mesh}"));
    let title = format!("scene {}{mesh}", shown.scene);
    if !arguments.tracker.tracker.is_empty() {
        return follow(arguments, &frames, &title, shown.scene);
    }
    lod::check_acuity(&frames, &mut observers)?;
    if observers.iter().any(|one| one.foveation.is_some()) {
        traced.samples = arguments.tracing.foveated_samples(&options);
    }
    let fill = &arguments.fill;
    let frame = match looked {
        Some(look) => {
            let before = (arguments.lod).observers(eyes.clone(), look.directions(), 0.0)?;
            let previous = frames.render(&before, Filling::Background)?;
            frames.render(&observers, Filling::Previous(&previous))?
        }
        None if fill.fill == Fill::Capture => {
            frames.render(&observers, Filling::Capture(fill.capture.options()))?
        }
        None => frames.render(&observers, Filling::Background)?,
    };
    let full = arguments.lod.is_on().then(|| frames.in_full(&observers));
    let full = full.transpose()?;
    let lod_pictures = match &full {
        Some(full) => LodPictures::of_first(&frames, &observers, [&frame, full])?,
        None => None,
    };
    let writer = arguments.writer(&arguments.out, &title);
    let captured = writer.write_capture(frame.capture.as_ref())?;
    let written = writer.write(&frame, &cave, &observers, &cameras, lod_pictures.as_ref())?;
    let report = Report {
        seconds: frame.seconds,
        rays: frame.statistics.into(),
        steps: frame.statistics.steps,
        deepest_stack: frame.statistics.deepest_stack,
        frame_hash: hexadecimal(frame.hash()),
        written,
        traced,
        size: arguments.room.size,
        shown,
        lod: full
            .as_ref()
            .map(|full| lod::report(arguments, &frames, &observers, [&frame, full], captured))
            .transpose()?,
        folder: arguments.out.display().to_string(),
        screens: [cave.walls.len(), cave.domes.len(), cave.cylinders.len()],
        eyes: eyes.count(),
    };
    print(&report, arguments.json)
}

/// Renders frame after frame as a tracker moves.
fn follow(
    arguments: &Arguments,
    frames: &Frames<'_>,
    title: &str,
    scene: String,
) -> Result<(), Failure> {
    let TrackerArguments {
        frames: count, hz, ..
    } = arguments.tracker;
    if arguments.lod.is_foveated() {
        arguments.tracing.foveated_samples(frames.options);
    }
    let interrupt = Interrupt::watched();
    let head = arguments.room.head();
    let trackers = &arguments.tracker.tracker;
    let mut follower = Follower::new(trackers, &arguments.tracker, head, frames.cave, &interrupt)?;
    let mut seconds = 0.0;
    let mut reports = Vec::new();
    for number in 0..count {
        if interrupt.came() {
            break;
        }
        let estimate = follower.frame(number);
        let eyes = arguments.room.eyes(estimate.head);
        let sight = estimate.line_of_sight;
        let directions = (sight.forward().as_dvec3(), sight.up().as_dvec3());
        let observers = (arguments.lod).observers(eyes.clone(), directions, estimate.widen)?;
        for (_, position) in eyes {
            frames.cave.check_eye(position)?;
        }
        let cameras = arguments.view.cameras(&observers, directions)?;
        let frame = frames.render(&observers, Filling::Background)?;
        seconds += frame.seconds;
        let folder = arguments.out.join(format!("frame-{number:05}"));
        make_writable(&folder)?;
        let writer = arguments.writer(&folder, title);
        let written = writer.write(&frame, frames.cave, &observers, &cameras, None)?;
        let stereo = written.stereo.into_iter().flat_map(|stereo| stereo.images);
        let images = written.images.into_iter().map(|image| image.path);
        let images = images.chain(stereo);
        reports.push(TrackedFrame {
            frame: number,
            shown_us: estimate.for_time.0,
            head: Head {
                position: estimate.head.position.to_array(),
                orientation: estimate.head.orientation.to_array(),
            },
            gaze: sight.forward().to_array(),
            state: estimate.state.name(),
            widen: estimate.widen,
            blink: estimate.blink,
            gaze_age_us: estimate.gaze_age.map(|age| age.0),
            frame_hash: hexadecimal(frame.hash()),
            images: images.collect(),
        });
    }
    let report = TrackedFrames {
        tracker: names(trackers),
        hz,
        frames: reports,
        seconds,
        threads: frames.options.threads,
        size: arguments.room.size,
        scene,
    };
    print(&report, arguments.json)
}

/// What all frames of one run share.
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
        let frame = render::cave_filled(self.baked.scene(), cave, eyes, options, filling, &show);
        progress.finish();
        Ok(frame?)
    }

    /// Renders without anything that follows the gaze.
    fn in_full(&self, eyes: &[Observer]) -> Result<Frame, Failure> {
        let full = eyes.iter().map(|one| Observer::new(one.eye, one.place));
        let full: Vec<_> = full.collect();
        self.render(&full, Filling::Background)
    }
}
