//! `shisen run`: frames that follow a tracker, each in its time.

mod report;

use super::failure::{Failure, Fault};
use super::live::{Audience, LiveArguments};
use super::picture_files::make_writable;
use super::print;
use super::tracker::{Interrupt, TrackerName, whole};
use clap::{Args, ValueEnum};
use report::{Around, Report};
use shisen::cave::{Cave, Eye};
use shisen::live::{FrameRecord, Latch, SessionSettings, eyes_of};
use shisen::net;
use shisen::picture::Picture;
use shisen::render::Observer;
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Follows a tracker frame after frame, within a budget
///
/// Each frame takes the newest gaze, is made as good as fits into its budget, and
/// is shown at a refresh of the display. What does not fit is chosen before the
/// frame begins: bounces, then faces, then the rim of the visual field. A frame
/// whose budget ends before it is finished lacks its rim, never what is looked at.
///
/// Ctrl-C ends it, with its report.
///
/// With --json, one object: scene, mesh, tracker, size, threads, simd, lod, hz,
/// budget, `budget_ms` and `budget_steps` (the last frame's allowance, null where it
/// is not by time or by steps), `plain_ms` (a frame in full, where the budget is a
/// part of that), latch, seconds, frames, `late_frames` (not there at their refresh),
/// `over_budget_frames` (more steps than allowed), `frames_with_unfinished_fovea` (a
/// tile within 5° of the line of sight not finished), `frames_with_unfinished_tiles`,
/// `lowered_share` (of the frames, those whose quality was lowered),
/// `quality_changes`, rungs (depth, faces, field, sampling and frames of each quality, the best
/// first), `blind_frames` (the head was where a screen is not seen), `median_steps`,
/// samples, `dropped_bytes`, `motion_to_wall_ms` (frames, least, p50, p95, p99, most;
/// null without samples), stages (the same of `sample_to_arrive`, `arrive_to_latch`,
/// `latch_to_first_ray`, `first_ray_to_done`, `done_to_present`,
/// `arrive_to_first_ray` and `motion_to_wall`), `involuntary_switches` (how often the
/// system took the processor away) and `stolen_seconds` (of all processors, by
/// whatever this machine runs on); null where the system does not say.
#[derive(Debug, Args)]
#[command(mut_arg("lod", |lod| lod.default_value("paper").hide_default_value(false)
    .help("What follows the gaze: detail falls with the distance from the line of sight, and \
           nothing outside the visual field is traced")))]
pub(super) struct Arguments {
    #[command(flatten)]
    live: LiveArguments,
    /// The tracker: mock, mock:seed=7&rate=200&as=fastrak, serial:PORT?protocol=NAME,
    /// hid:VENDOR:PRODUCT or replay:FILE; --head is where its origin is
    #[arg(long, value_name = "SPEC", default_value = "mock")]
    tracker: TrackerName,
    /// When a frame takes the gaze
    #[arg(long, value_enum, default_value = "late")]
    latch: LatchName,
    /// End after so many seconds
    #[arg(long, value_name = "S", allow_negative_numbers = true, value_parser = whole::<1, 86_400>)]
    seconds: Option<u64>,
    /// End after so many frames
    #[arg(long, value_name = "N", allow_negative_numbers = true,
          value_parser = whole::<1, { u64::MAX }>)]
    frames: Option<u64>,
    /// What becomes of the frames
    #[arg(long, value_enum, default_value = "none")]
    view: View,
    /// Folder of the pictures of --view png; made where it does not exist
    #[arg(long, value_name = "DIR", default_value = "shisen-out")]
    out: PathBuf,
    /// Write what each frame was, one JSON object a line: `due_us`, `sample_us`,
    /// `arrive_us`, `latch_us`, `first_ray_us`, `done_us`, `present_us` (since the
    /// tracker was opened), frame, late, position, forward, state, `budget_steps`,
    /// steps, `need_steps`, rung, tiles, `unfinished_tiles` and `unfinished_fovea`
    #[arg(long, value_name = "FILE")]
    record: Option<PathBuf>,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

/// `--latch`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum LatchName {
    /// As soon as the frame before is shown
    Early,
    /// As late as the last frames allow
    Late,
}

/// `--view`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum View {
    /// They are measured, and forgotten
    None,
    /// A PNG each: the walls of one eye, unfolded
    Png,
}

/// Runs the command.
pub(super) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let log = arguments.record.as_deref().map(Log::create).transpose()?;
    let prepared = arguments.live.prepare()?;
    if arguments.view == View::Png {
        make_writable(&arguments.out)?;
    }
    let interrupt = Interrupt::new();
    let tracker = arguments.live.listen(&arguments.tracker.spec)?;
    let settings = prepared.settings(SessionSettings {
        latch: match arguments.latch {
            LatchName::Early => Latch::Early,
            LatchName::Late => Latch::Late,
        },
        frames: arguments.frames,
        ..SessionSettings::default()
    });
    let mut frames = Frames {
        arguments,
        cave: &prepared.cave,
        interrupt: &interrupt,
        end: None,
        log,
        shown: 0,
        failure: None,
    };
    let (report, interference) = prepared.play(&tracker, &settings, &mut frames)?;
    if let Some(failure) = frames.failure {
        return Err(failure);
    }
    if let Some(log) = frames.log {
        log.finish()?;
    }
    let around = Around {
        threads: prepared.options.threads,
        simd: prepared.simd().name(),
        scene: prepared.scene,
        mesh: prepared.mesh,
        dropped_bytes: tracker.counts().dropped_bytes,
        interference,
    };
    print(
        &Report::new(around, arguments, &settings, &report),
        arguments.json,
    )
}

/// What becomes of frames.
struct Frames<'s> {
    arguments: &'s Arguments,
    cave: &'s Cave,
    interrupt: &'s Interrupt,
    /// Some seconds after the first frame.
    end: Option<Instant>,
    log: Option<Log>,
    shown: u64,
    failure: Option<Failure>,
}

impl Frames<'_> {
    fn write(&self, pictures: &[Picture], eyes: &[Observer]) -> Result<(), Failure> {
        let eye = eyes.first().map_or(Eye::Centre, |one| one.eye);
        let pictures = eyes_of(self.cave, eyes).zip(pictures);
        let seen: Vec<_> = pictures
            .filter(|((_, of), _)| *of == eye)
            .filter_map(|((screen, _), picture)| Some((self.cave.screens().nth(screen)?, picture)))
            .collect();
        let net = net::unfold(&seen).map_err(Failure::from_error)?;
        let name = format!("frame-{:06}.png", self.shown);
        net.write_png(&self.arguments.out.join(name), &[])
            .map_err(Failure::from_error)
    }
}

impl Audience for Frames<'_> {
    fn wants_pictures(&self) -> bool {
        self.arguments.view == View::Png
    }

    fn see(&mut self, pictures: &[Picture], eyes: &[Observer]) {
        if self.wants_pictures()
            && let Err(failure) = self.write(pictures, eyes)
        {
            self.failure.get_or_insert(failure);
        }
        self.shown += 1;
    }

    fn hear(&mut self, record: &FrameRecord) -> bool {
        if let Some(log) = &mut self.log
            && let Err(failure) = log.write(record)
        {
            self.failure.get_or_insert(failure);
        }
        let now = Instant::now();
        let span = self.arguments.seconds.map(Duration::from_secs);
        let end = span.map(|span| *self.end.get_or_insert(now + span));
        let over = end.is_some_and(|end| now >= end);
        !(over || self.failure.is_some() || self.interrupt.came())
    }
}

/// The file of `--record`.
struct Log {
    path: PathBuf,
    file: BufWriter<File>,
}

impl Log {
    fn create(path: &Path) -> Result<Self, Failure> {
        let file = File::create(path).map_err(|reason| Fault::Write {
            path: path.to_owned(),
            reason,
        })?;
        Ok(Self {
            path: path.to_owned(),
            file: BufWriter::with_capacity(1 << 20, file),
        })
    }

    fn write(&mut self, record: &FrameRecord) -> Result<(), Failure> {
        let written = serde_json::to_writer(&mut self.file, record).map_err(Into::into);
        let written = written.and_then(|()| self.file.write_all(b"\n"));
        written.map_err(|reason| self.failed(reason))
    }

    fn finish(mut self) -> Result<(), Failure> {
        let flushed = self.file.flush();
        flushed.map_err(|reason| self.failed(reason))
    }

    fn failed(&self, reason: std::io::Error) -> Failure {
        Fault::Write {
            path: self.path.clone(),
            reason,
        }
        .into()
    }
}
