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

/// The job of a controller.
#[expect(missing_debug_implementations, reason = "sources of bytes have none")]
pub struct Run<'a> {
    /// The controller's firmware.
    pub image: &'a Image,
    /// The bytes of the scene, in the compact layout.
    pub scene: &'a [u8],
    /// The screens; at most [`MOST_SCREENS`].
    pub screens: &'a [FlatScreen],
    /// The quality and budget of frames.
    pub rendering: Rendering,
    /// Number of frames of the screens to receive.
    pub frames: u32,
    /// A dome master to receive after the frames: pixels a side, and its centre in the room.
    pub capture: Option<(u16, glam::Vec3)>,
    /// The tracker; `None`: the controller hears no tracker.
    pub tracker: Option<TrackerBytes>,
    /// Seconds without a report after which the controller counts as hung.
    pub patience: f64,
}

/// Screens that a controller has room for.
pub const MOST_SCREENS: usize = 6;

/// Tiles of a frame, of 16² pixels each, that a controller has room for.
pub const MOST_TILES: usize = 768;

/// Pixels a side of a controller's tiles.
const TILE: u32 = 16;

/// A frame that came from a controller.
#[derive(Debug, Clone, PartialEq)]
pub struct ShownFrame {
    /// The report at its start: screen, eye and gaze.
    pub start: FrameStart,
    /// The frame's pictures.
    pub pictures: Vec<Picture>,
    /// The steps and instructions of each slice.
    pub slices: Vec<Slice>,
    /// The report at its end; `None` where nothing was rendered.
    pub done: Option<FrameDone>,
}

impl ShownFrame {
    /// Returns the same hash as [`Frame::hash`](shisen::render::Frame::hash).
    pub fn hash(&self) -> u64 {
        frame_hash(self.pictures.iter().map(Picture::hash))
    }
}

/// What came from a controller.
#[derive(Debug, Clone, PartialEq)]
pub struct Watched {
    /// The report after its start.
    pub ready: Ready,
    /// The requested frames, in order.
    pub frames: Vec<ShownFrame>,
    /// The newest report about its tracker.
    pub tracker: Option<TrackerState>,
    /// The lines of its log.
    pub log: Vec<String>,
    /// Number of damaged frames of the link.
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
    /// Returns an error that says what is wrong, and what helps.
    pub fn new(what: impl Into<String>, help: &'static str) -> Self {
        let what = what.into();
        Self { what, help }
    }

    /// Returns an error for firmware and command built from different sources.
    pub fn other_sources(what: impl Into<String>) -> Self {
        Self::new(what, "build firmware and command from the same sources")
    }

    /// Returns an error for a report that the firmware cannot send.
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

/// Runs a controller until the requested frames have come.
///
/// # Errors
/// A job that the controller has no room for, an emulator that does not start, a firmware that
/// sends no reports or wrong ones.
pub fn watch(run: Run<'_>) -> Result<Watched, FirmwareError> {
    let mut session = Session::new(&run)?;
    let mut emulator = Emulator::start(run.image, run.scene)?;
    let (mut tracker, patience) = (run.tracker, Duration::from_secs_f64(run.patience));
    let mut heard = Instant::now();
    let mut decoder = Reports::new();
    while !session.is_done() {
        let bytes = emulator.receive(Port::Display)?;
        // Only a report of a requested frame shows that the controller still works.
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
        // Sends what the tracker has sent by the controller's time.
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
