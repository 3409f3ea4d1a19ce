//! The firmware of a display controller, run in an emulator of a Cortex-M7 and
//! compared with the host, bit for bit.

mod emulator;
mod image;
mod reference;
mod session;

pub use image::Image;
pub use reference::reference;

use emulator::{Emulator, Port};
use miette::Diagnostic;
use session::Session;
use shisen::picture::Picture;
use shisen::render::frame_hash;
use shisen_core::frame::FlatScreen;
use shisen_tracker::link::display::{
    FrameDone, FrameStart, Ready, Rendering, Reports, Slice, TrackerState,
};
use shisen_tracker::mock::{Chunk, Source};
use std::time::{Duration, Instant};
use std::{fmt, io};
use thiserror::Error;

/// Where tracker bytes come from, by the controller's clock.
pub type TrackerBytes = Box<dyn Source<Item = Chunk>>;

/// What a controller is to do.
#[expect(missing_debug_implementations, reason = "sources of bytes have none")]
pub struct Run<'a> {
    /// Its firmware.
    pub image: &'a Image,
    /// The bytes of its scene, in the compact layout.
    pub scene: &'a [u8],
    /// Its screens; at most [`MOST_SCREENS`].
    pub screens: &'a [FlatScreen],
    /// How it renders.
    pub rendering: Rendering,
    /// Frames of the screens to take.
    pub frames: u32,
    /// Then a dome master, of so many pixels a side, from a place in the room.
    pub capture: Option<(u16, glam::Vec3)>,
    /// The tracker; none says nothing.
    pub tracker: Option<TrackerBytes>,
    /// Seconds without a word from it after which it counts as hung.
    pub patience: f64,
}

/// Screens that a controller has room for.
pub const MOST_SCREENS: usize = 6;

/// Tiles of a frame, of 16² pixels each, that a controller has room for.
pub const MOST_TILES: usize = 768;

/// Pixels a side of a controller's tiles.
const TILE: u32 = 16;

/// A frame as it came from a controller.
#[derive(Debug, Clone, PartialEq)]
pub struct ShownFrame {
    /// What it was made of.
    pub start: FrameStart,
    /// Its pictures.
    pub pictures: Vec<Picture>,
    /// What its slices took.
    pub slices: Vec<Slice>,
    /// What it took; `None` where nothing was rendered.
    pub done: Option<FrameDone>,
}

impl ShownFrame {
    /// As [`Frame::hash`](shisen::render::Frame::hash).
    pub fn hash(&self) -> u64 {
        frame_hash(self.pictures.iter().map(Picture::hash))
    }
}

/// What came from a controller.
#[derive(Debug, Clone, PartialEq)]
pub struct Watched {
    /// What it said at first.
    pub ready: Ready,
    /// The frames asked for, in their order.
    pub frames: Vec<ShownFrame>,
    /// The newest that it said of its tracker.
    pub tracker: Option<TrackerState>,
    /// Its log, line by line.
    pub log: Vec<String>,
    /// Frames of the link that were damaged.
    pub damaged: u32,
}

/// Why a controller could not be watched, and what helps.
#[derive(Debug, Error, Diagnostic)]
#[error("{what}")]
pub struct FirmwareError {
    what: String,
    #[help]
    help: &'static str,
}

impl FirmwareError {
    /// What is wrong, and what helps.
    pub fn new(what: impl Into<String>, help: &'static str) -> Self {
        let what = what.into();
        Self { what, help }
    }

    /// What cannot be of one whose sources are the command's.
    pub fn other_sources(what: impl Into<String>) -> Self {
        Self::new(what, "build firmware and command from the same sources")
    }

    fn nonsense(what: impl fmt::Display) -> Self {
        Self::other_sources(format!("the firmware reports {what}"))
    }
}

impl From<io::Error> for FirmwareError {
    fn from(error: io::Error) -> Self {
        let what = format!("the emulator's ports do not work: {error}");
        Self::new(what, "is there room for temporary files?")
    }
}

/// Runs a controller until the frames asked for have come.
///
/// # Errors
/// More than it has room for, an emulator that does not start, a firmware that says
/// nothing or nonsense.
pub fn watch(run: Run<'_>) -> Result<Watched, FirmwareError> {
    let mut session = Session::new(&run)?;
    let mut emulator = Emulator::start(run.image, run.scene)?;
    let (mut tracker, patience) = (run.tracker, Duration::from_secs_f64(run.patience));
    let mut heard = Instant::now();
    let mut decoder = Reports::new();
    while !session.is_done() {
        let bytes = emulator.receive(Port::Display)?;
        // Frames that were not asked for are no answer.
        if session.advanced {
            session.advanced = false;
            heard = Instant::now();
        }
        let is_silent = heard.elapsed() > patience;
        if bytes.is_empty() || is_silent {
            session.log.extend(emulator.log()?);
            if is_silent {
                let (seconds, so_far) = (patience.as_secs_f64(), session.so_far());
                return Err(FirmwareError::new(
                    format!(
                        "the firmware has sent nothing that was asked for in {seconds} s: {so_far}"
                    ),
                    "is it an image of tests/firmware, built from the same sources?",
                ));
            }
            continue;
        }
        let mut reports = Vec::new();
        decoder.feed(&bytes, &mut |report| reports.push(report));
        for report in reports {
            session.take(report)?;
        }
        // What a tracker sends by the time that it is there.
        while let Some(chunk) = tracker.as_mut().and_then(|t| t.poll(session.now)) {
            emulator.send(Port::Tracker, chunk.bytes())?;
        }
        if let Some(order) = session.next_order() {
            emulator.send(Port::Display, &order)?;
        }
    }
    session.log.extend(emulator.log()?);
    let ready = session.ready;
    Ok(Watched {
        ready: ready.ok_or_else(|| FirmwareError::nonsense("frames before it is ready"))?,
        frames: session.frames,
        tracker: session.tracker,
        log: session.log,
        damaged: decoder.dropped(),
    })
}
