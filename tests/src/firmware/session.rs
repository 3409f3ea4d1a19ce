//! A session with a controller: the reports that have come, and the next order.

use super::{FirmwareError, MOST_SCREENS, MOST_TILES, Run, ShownFrame, TILE};
use shisen::picture::Picture;
use shisen_core::frame::FrameJob;
use shisen_tracker::link::Encoder;
use shisen_tracker::link::display::{
    FrameStart, Order, PixelRun, Ready, Report, Subject, TrackerState,
};
use shisen_tracker::time::Micros;
use std::collections::VecDeque;

/// Most bytes of orders that a controller can hold while it renders.
const MOST_ORDER_BYTES: usize = 240;

pub(super) struct Session {
    encoder: Encoder,
    sizes: Vec<[u32; 2]>,
    two_eyes: bool,
    /// Number of orders that the first kept frame must have obeyed.
    orders: u8,
    /// Orders that have not been sent, in pieces that the controller has room for: the number of
    /// orders in each, and its bytes.
    unsent: VecDeque<(u8, Vec<u8>)>,
    sent: u8,
    /// Orders that the newest frame had obeyed.
    obeyed: u8,
    wanted: u32,
    capture: Option<Order>,
    pub(super) ready: Option<Ready>,
    pub(super) frames: Vec<ShownFrame>,
    /// The frame that is coming in, if it is kept.
    current: Option<ShownFrame>,
    pub(super) tracker: Option<TrackerState>,
    pub(super) log: Vec<String>,
    pub(super) now: Micros,
    asked_for_capture: bool,
    /// Number of frames that have ended, kept or not.
    ended: u32,
    /// Whether a report of a requested frame has come.
    pub(super) advanced: bool,
}

impl Session {
    pub(super) fn new(run: &Run<'_>) -> Result<Self, FirmwareError> {
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
                return Err(FirmwareError::new(
                    format!(
                        "{what} of {tiles} tiles of {TILE}x{TILE} pixels, and the firmware has \
                         room for {MOST_TILES}"
                    ),
                    "give fewer pixels, walls or eyes; MOST_TILES of tests/firmware says how many",
                ));
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

    /// Returns the next order: a piece of the first orders once those before are obeyed, then the
    /// order for a dome master once the frames have come.
    pub(super) fn next_order(&mut self) -> Option<Vec<u8>> {
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

    pub(super) fn is_done(&self) -> bool {
        let all = self.wanted + u32::from(self.capture.is_some());
        self.ready.is_some() && self.frames.len() as u32 >= all
    }

    pub(super) fn so_far(&self) -> String {
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

    pub(super) fn take(&mut self, report: Report) -> Result<(), FirmwareError> {
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
        // Without a scene, only the next frame's start shows that a frame is over.
        if self.current.is_some() {
            self.end();
        }
        if start.orders > self.obeyed {
            self.obeyed = start.orders;
            self.advanced = true;
        }
        let sizes: Vec<[u32; 2]> = match start.subject {
            Subject::Capture { size } => vec![[u32::from(size); 2]],
            // Frames from before the orders came are not kept.
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
            pictures: pictures
                .collect::<Result<_, _>>()
                .map_err(FirmwareError::nonsense)?,
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
