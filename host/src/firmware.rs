//! The firmware of a display controller, run in an emulator of a Cortex-M7 and
//! compared with the host, bit for bit.

mod emulator;
mod image;
mod reference;

pub use emulator::EmulatorError;
pub use image::{Image, ImageError};
pub use reference::{ReferenceError, reference};

use crate::cave::Wall;
use crate::picture::{Picture, PictureError};
use emulator::{Emulator, Port};
use miette::Diagnostic;
use shisen_core::frame::{FlatScreen, FrameJob};
use shisen_tracker::link::Encoder;
use shisen_tracker::link::display::{
    FrameDone, FrameStart, Order, PixelRun, Ready, Rendering, Report, Reports, Slice, Subject,
    TrackerState,
};
use shisen_tracker::mock::{Chunk, Source};
use shisen_tracker::time::Micros;
use std::collections::VecDeque;
use std::time::{Duration, Instant};
use thiserror::Error;
use xxhash_rust::xxh3::Xxh3;

/// Where tracker bytes come from, by the controller's clock.
pub type TrackerBytes = Box<dyn Source<Item = Chunk>>;

/// What a controller is to do.
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

/// Bytes of orders that a controller takes at a time: they wait while it renders.
const MOST_ORDER_BYTES: usize = 240;

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
    /// As [`Frame::hash`](crate::render::Frame::hash).
    pub fn hash(&self) -> u64 {
        hash(&self.pictures)
    }
}

/// XXH3-64 over the pictures' hashes, in order.
pub fn hash(pictures: &[Picture]) -> u64 {
    let mut hash = Xxh3::new();
    for picture in pictures {
        hash.update(&picture.hash().to_le_bytes());
    }
    hash.digest()
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

/// Why a controller could not be watched.
#[derive(Debug, Error, Diagnostic)]
#[non_exhaustive]
pub enum FirmwareError {
    /// The emulator.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Emulator(#[from] EmulatorError),
    /// It said nothing for too long.
    #[error("the firmware has sent nothing that was asked for in {seconds} s: {so_far}")]
    #[diagnostic(help("is it an image of tests/firmware, built from the same sources?"))]
    Silent {
        /// How long.
        seconds: f64,
        /// What had come.
        so_far: String,
    },
    /// It says what cannot be.
    #[error("the firmware reports {what}")]
    #[diagnostic(help("build firmware and command from the same sources"))]
    Nonsense {
        /// What.
        what: String,
    },
    /// More than it has room for.
    #[error(
        "{what} of {tiles} tiles of {TILE}x{TILE} pixels, and the firmware has room for {MOST_TILES}"
    )]
    #[diagnostic(help(
        "give fewer pixels, walls or eyes; MOST_TILES of tests/firmware says how many"
    ))]
    TooLarge {
        /// A frame or a dome master.
        what: &'static str,
        /// How many it has.
        tiles: usize,
    },
    /// A picture too large.
    #[error(transparent)]
    Picture(#[from] PictureError),
}

impl FirmwareError {
    fn nonsense(what: impl Into<String>) -> Self {
        Self::Nonsense { what: what.into() }
    }
}

/// A wall as a controller has it.
pub fn flat_screen(wall: &Wall) -> FlatScreen {
    let [columns, rows] = wall.pixels;
    let column_step = (wall.lower_right - wall.lower_left) / f64::from(columns);
    let row_step = (wall.lower_left - wall.upper_left) / f64::from(rows);
    let first = wall.upper_left + 0.5 * (column_step + row_step);
    FlatScreen {
        first_pixel: first.as_vec3(),
        column_step: column_step.as_vec3(),
        row_step: row_step.as_vec3(),
        size: wall.pixels,
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
    let Run {
        mut tracker,
        patience,
        ..
    } = run;
    let mut heard = Instant::now();
    let mut decoder = Reports::new();
    while !session.is_done() {
        let bytes = emulator.receive(Port::Display)?;
        // Frames that were not asked for are no answer.
        if session.advanced {
            session.advanced = false;
            heard = Instant::now();
        }
        if bytes.is_empty() || heard.elapsed() > Duration::from_secs_f64(patience) {
            session.log(&emulator.log()?);
            if heard.elapsed() > Duration::from_secs_f64(patience) {
                return Err(FirmwareError::Silent {
                    seconds: patience,
                    so_far: session.so_far(),
                });
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
    session.log(&emulator.log()?);
    Ok(Watched {
        ready: session.ready.unwrap_or(NOTHING),
        frames: session.frames,
        tracker: session.tracker,
        log: session.log,
        damaged: decoder.dropped(),
    })
}

const NOTHING: Ready = Ready {
    scene_bytes: 0,
    effects: 0,
    linked: 0,
    fault: 0,
    flash_bytes: 0,
    static_bytes: 0,
    picture_bytes: 0,
};

/// What has been heard so far.
struct Session {
    encoder: Encoder,
    sizes: Vec<[u32; 2]>,
    two_eyes: bool,
    /// Orders given before the first frame that counts.
    orders: u8,
    /// Those of them that have not been sent, in pieces that the controller has room for:
    /// how many are sent with each, and its bytes.
    unsent: VecDeque<(u8, Vec<u8>)>,
    /// Orders sent.
    sent: u8,
    /// Orders that the newest frame had obeyed.
    obeyed: u8,
    wanted: u32,
    capture: Option<Order>,
    ready: Option<Ready>,
    frames: Vec<ShownFrame>,
    /// The one that is coming in, if it counts.
    current: Option<ShownFrame>,
    tracker: Option<TrackerState>,
    log: Vec<String>,
    now: Micros,
    asked_for_capture: bool,
    /// Frames that have ended, whether or not they count.
    ended: u32,
    /// Whether something has come that was asked for.
    advanced: bool,
}

impl Session {
    fn new(run: &Run<'_>) -> Result<Self, FirmwareError> {
        let sizes: Vec<_> = run.screens.iter().map(|screen| screen.size).collect();
        if sizes.is_empty() || sizes.len() > MOST_SCREENS {
            return Err(FirmwareError::nonsense(format!(
                "room for 1 to {MOST_SCREENS} screens, and there are {}",
                sizes.len()
            )));
        }
        let two_eyes = run.rendering.eye_distance != 0.0;
        let eyes = if two_eyes { 2 } else { 1 };
        let frame = eyes * FrameJob::tiles_of(sizes.iter().copied(), TILE);
        let capture = run.capture.map(|(size, _)| [u32::from(size); 2]);
        let dome = FrameJob::tiles_of(capture.into_iter(), TILE);
        for (what, tiles) in [("a frame", frame), ("a dome master", dome)] {
            if tiles > MOST_TILES {
                return Err(FirmwareError::TooLarge { what, tiles });
            }
        }
        let mut session = Self {
            encoder: Encoder::new(),
            two_eyes,
            orders: sizes.len() as u8 + 2,
            unsent: VecDeque::new(),
            sent: 0,
            obeyed: 0,
            sizes,
            wanted: run.frames,
            capture: run
                .capture
                .map(|(size, place)| Order::Capture { size, place }),
            ready: None,
            frames: Vec::new(),
            current: None,
            tracker: None,
            log: Vec::new(),
            now: Micros(0),
            asked_for_capture: false,
            ended: 0,
            advanced: false,
        };
        session.plan(run);
        Ok(session)
    }

    /// What it is to be told at first.
    fn plan(&mut self, run: &Run<'_>) {
        let count = Order::Screens {
            count: run.screens.len() as u8,
        };
        let screens = (0..)
            .zip(run.screens)
            .map(|(index, &screen)| Order::Screen { index, screen });
        let all = std::iter::once(count)
            .chain(screens)
            .chain([Order::Rendering(run.rendering)]);
        for order in all {
            let bytes = self.encoder.order(&order).to_vec();
            match self.unsent.back_mut() {
                Some((count, piece)) if piece.len() + bytes.len() <= MOST_ORDER_BYTES => {
                    *count += 1;
                    piece.extend(bytes);
                }
                _ => self.unsent.push_back((1, bytes)),
            }
        }
    }

    /// What it is told next: a piece of the first orders once those before are obeyed, then
    /// that for a dome master once the frames have come.
    fn next_order(&mut self) -> Option<Vec<u8>> {
        self.ready?;
        if self.obeyed >= self.sent
            && let Some((count, piece)) = self.unsent.pop_front()
        {
            self.sent += count;
            return Some(piece);
        }
        if self.asked_for_capture || (self.frames.len() as u32) < self.wanted {
            return None;
        }
        self.asked_for_capture = true;
        let order = self.capture?;
        Some(self.encoder.order(&order).to_vec())
    }

    fn is_done(&self) -> bool {
        let all = self.wanted + u32::from(self.capture.is_some());
        self.ready.is_some() && self.frames.len() as u32 >= all
    }

    fn so_far(&self) -> String {
        let frames = match self.ready {
            None => "it has not started".to_owned(),
            Some(_) if self.ended == 1 => "1 frame has come".to_owned(),
            Some(_) => format!("{} frames have come", self.ended),
        };
        match self.log.last() {
            Some(line) => format!("{frames}, and the last line of its log is \"{line}\""),
            None => frames,
        }
    }

    fn log(&mut self, lines: &[String]) {
        self.log.extend_from_slice(lines);
    }

    fn take(&mut self, report: Report) -> Result<(), FirmwareError> {
        match report {
            Report::Ready(ready) => {
                self.ready = Some(ready);
                self.advanced = true;
            }
            Report::Frame(start) => self.begin(start)?,
            Report::Pixels(run) => self.pixels(&run)?,
            Report::Slice(slice) => {
                self.now = slice.time;
                if let Some(frame) = &mut self.current {
                    frame.slices.push(slice);
                    self.advanced = true;
                }
            }
            Report::FrameDone(done) => {
                if let Some(frame) = &mut self.current {
                    frame.done = Some(done);
                }
                self.end();
            }
            Report::Tracker(state) => self.tracker = Some(state),
        }
        Ok(())
    }

    fn end(&mut self) {
        self.ended += 1;
        self.frames.extend(self.current.take());
    }

    fn begin(&mut self, start: FrameStart) -> Result<(), FirmwareError> {
        // Without a scene nothing says that a frame is over but the next.
        if self.current.is_some() {
            self.end();
        }
        if start.orders > self.obeyed {
            self.obeyed = start.orders;
            self.advanced = true;
        }
        let sizes: Vec<[u32; 2]> = match start.subject {
            Subject::Capture { size } => vec![[u32::from(size); 2]],
            // Those of before the orders came do not count.
            Subject::Screens if start.orders < self.orders => return Ok(()),
            Subject::Screens if self.frames.len() as u32 >= self.wanted => return Ok(()),
            Subject::Screens => {
                let eyes = if self.two_eyes { 2 } else { 1 };
                let all = self.sizes.iter().flat_map(|&size| vec![size; eyes]);
                all.collect()
            }
        };
        let rendered = self.ready.is_none_or(|ready| ready.fault == 0);
        if rendered && usize::from(start.pictures) != sizes.len() {
            return Err(FirmwareError::nonsense(format!(
                "{} pictures in a frame of {}",
                start.pictures,
                sizes.len()
            )));
        }
        let pictures = sizes
            .iter()
            .map(|&[columns, rows]| Picture::new(columns, rows));
        self.current = Some(ShownFrame {
            start,
            pictures: pictures.collect::<Result<_, _>>()?,
            slices: Vec::new(),
            done: None,
        });
        Ok(())
    }

    fn pixels(&mut self, run: &PixelRun) -> Result<(), FirmwareError> {
        let Some(frame) = &mut self.current else {
            return Ok(());
        };
        let picture = frame.pictures.get_mut(usize::from(run.picture));
        let picture = picture.ok_or_else(|| FirmwareError::nonsense("pixels of no picture"))?;
        for (x, pixel) in (u32::from(run.column)..).zip(&run.pixels) {
            let y = u32::from(run.row);
            if picture.pixel(x, y).is_none() {
                return Err(FirmwareError::nonsense(format!("a pixel at {x}, {y}")));
            }
            picture.set_pixel(x, y, [pixel.red, pixel.green, pixel.blue, pixel.alpha]);
        }
        self.advanced = true;
        Ok(())
    }
}
