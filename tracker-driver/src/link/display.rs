//! Reports of a display controller and orders to it: the link's frames between a controller
//! that renders and the host that watches it.
//!
//! | Kind | Body |
//! |---|---|
//! | 32 ready | u32 bytes of the scene, u32 effects that it asks for, u32 those that are linked, u32 what is wrong with it (0 nothing), u32 bytes of flash, of static memory, of that for pictures |
//! | 33 frame | u32 number, u8 orders obeyed, u8 pictures, u8 state of the gaze (255 none), u16 pixels a side of a dome master (0: screens), u64 budget in steps, f32 x, y, z of the left eye, of the right eye, of the line of sight and of up, f32 radians by which the field is wider |
//! | 34 pixels | u8 picture, u16 column, u16 row, then up to 8 pixels to the right: f32 red, green, blue, alpha |
//! | 35 slice | u32 frame, u32 instructions, u32 steps, u8 whether it ended a tile, u64 the controller's clock, microseconds |
//! | 36 frame done | u32 number, u8 whether it was cut short, u32 whole tiles, u32 tiles given up, u64 steps, u64 primary rays, u64 all rays, u64 instructions of its slices, u32 instructions before the first slice, u32 instructions from the last byte of a new gaze to the first tile (0 none), u32 of these until the frame was begun, u32 until the tile was sent |
//! | 37 tracker | u32 records, u32 bytes dropped, u32 bytes that found no room, u64 instructions of decoding and estimating, u32 bytes of stack used so far |
//! | 48 screens, to the controller | u8 how many there are |
//! | 49 screen, to the controller | u8 which, u16 columns, u16 rows, f32 x, y, z of the first pixel's centre, of the step to the right and of the step down, metres in the room |
//! | 50 rendering, to the controller | u64 steps a frame, u32 steps a slice, u8 depth, u8 wavelengths, u8 whether detail follows the gaze, f32 metres from eye to eye (0: one eye), u32 microseconds from the gaze to the light, f32 radians that the gaze may move before a frame is cut short (0: any) |
//! | 51 capture, to the controller | u16 pixels a side of a dome master, f32 x, y, z of its place |
//!
//! All numbers keep their bits, so that a host with the same scene and screens can
//! render the same frame.

mod wire;

use super::Encoder;
use super::frame::{Frame, Listener};
use crate::time::Micros;
use glam::Vec3;
use heapless::Vec;
use shisen_core::frame::{FlatScreen, Pixel};
use wire::Field;

const READY: u8 = 32;
const FRAME: u8 = 33;
const PIXELS: u8 = 34;
const SLICE: u8 = 35;
const FRAME_DONE: u8 = 36;
const TRACKER: u8 = 37;
const SCREENS: u8 = 48;
const SCREEN: u8 = 49;
const RENDERING: u8 = 50;
const CAPTURE: u8 = 51;

/// Most pixels of a [`Report::Pixels`].
pub const MOST_PIXELS: usize = 8;

/// A controller's scene and memory, reported at its start.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Ready {
    /// Bytes of the scene.
    pub scene_bytes: u32,
    /// The effects that the scene asks for, as bits.
    pub effects: u32,
    /// The effects that the firmware has, as bits.
    pub linked: u32,
    /// Number of the scene's error; 0 for none.
    pub fault: u32,
    /// Bytes of code and constants.
    pub flash_bytes: u32,
    /// Bytes of static memory.
    pub static_bytes: u32,
    /// The part of the static memory for pixels and the order of tiles.
    pub picture_bytes: u32,
}

/// The subject of a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Subject {
    /// The screens, as the viewer's eyes see them.
    Screens,
    /// A dome master, taken from the reported place of the left eye.
    Capture {
        /// Pixels a side, 1 or more.
        size: u16,
    },
}

/// All that determines a frame, besides scene and screens.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrameStart {
    /// The frame's number, from 0.
    pub number: u32,
    /// Number of orders obeyed before it; wraps at 256.
    pub orders: u8,
    /// Number of its pictures, ordered by screen, then eye.
    pub pictures: u8,
    /// The frame's subject.
    pub subject: Subject,
    /// The gaze's state, as a place in [`State::ALL`](crate::estimate::State::ALL); `None`
    /// without a gaze.
    pub state: Option<u8>,
    /// Steps that it may take.
    pub budget: u64,
    /// The left eye and the right one: metres, in the room; the same for one.
    pub eyes: [Vec3; 2],
    /// The line of sight: a unit vector in the room.
    pub forward: Vec3,
    /// The head's up direction, at right angles to that: a unit vector in the room.
    pub up: Vec3,
    /// Angle by which the field of full detail is widened, radians.
    pub widen: f32,
}

/// Pixels of one row of a picture.
#[derive(Debug, Clone, PartialEq)]
pub struct PixelRun {
    /// The picture's number.
    pub picture: u8,
    /// The column of the first pixel.
    pub column: u16,
    /// The pixels' row.
    pub row: u16,
    /// The pixels from left to right.
    pub pixels: Vec<Pixel, MOST_PIXELS>,
}

/// Costs of a slice: one call of the renderer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Slice {
    /// The frame's number.
    pub frame: u32,
    /// Instructions.
    pub instructions: u32,
    /// Nodes visited and primitives tested.
    pub steps: u32,
    /// Whether it finished a tile.
    pub ended_tile: bool,
    /// Time of its end, by the controller's clock.
    pub time: Micros,
}

/// Costs of a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FrameDone {
    /// The frame's number.
    pub number: u32,
    /// Whether it was cut short because the viewer looks elsewhere; the tiles it has are whole.
    pub cut_short: bool,
    /// Tiles all of whose pixels were traced.
    pub whole: u32,
    /// Tiles that the budget did not finish.
    pub given_up: u32,
    /// Nodes visited and primitives tested.
    pub steps: u64,
    /// Rays from the eyes.
    pub primary: u64,
    /// All rays.
    pub rays: u64,
    /// Instructions of all slices.
    pub instructions: u64,
    /// Instructions before the first slice: gaze, views, order of tiles.
    pub preparation: u32,
    /// Instructions from the last byte of a new gaze to the first tile; 0 without a new gaze.
    pub latency: u32,
    /// The part of the latency until the frame was begun.
    pub age: u32,
    /// From that byte to the end of sending the first tile; 0 without latency.
    pub sent: u32,
}

/// Counts of the tracker's data so far.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TrackerState {
    /// Samples.
    pub records: u32,
    /// Bytes dropped between records.
    pub dropped: u32,
    /// Bytes lost because they were not taken in time.
    pub overrun: u32,
    /// Instructions of decoding and of estimating.
    pub instructions: u64,
    /// The deepest stack so far, bytes.
    pub stack_bytes: u32,
}

/// A report of a controller.
#[derive(Debug, Clone, PartialEq)]
pub enum Report {
    /// The controller has started.
    Ready(Ready),
    /// A frame begins.
    Frame(FrameStart),
    /// Some pixels of the frame.
    Pixels(PixelRun),
    /// A slice is over.
    Slice(Slice),
    /// The frame is over.
    FrameDone(FrameDone),
    /// The tracker's state.
    Tracker(TrackerState),
}

/// A controller's settings of rendering.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rendering {
    /// Most steps of a frame.
    pub budget: u64,
    /// Steps of a slice.
    pub slice: u32,
    /// Most bounces.
    pub depth: u8,
    /// Wavelengths that dispersive media distinguish; 1: no dispersion.
    pub wavelengths: u8,
    /// Whether detail follows the gaze.
    pub lod: bool,
    /// Distance of the eyes, metres; 0 for one eye.
    pub eye_distance: f32,
    /// Time from the estimate of the gaze to the display of the frame, microseconds.
    pub display_delay: u32,
    /// Angle by which the line of sight may move before a frame is cut short and the next begun,
    /// radians; 0 or less: no frame is cut short.
    pub restart_angle: f32,
}

/// An order to a controller, in force from the next frame on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Order {
    /// The number of screens; a new screen is invisible until an order gives its place.
    Screens {
        /// Number of screens.
        count: u8,
    },
    /// The place of a screen.
    Screen {
        /// The screen's index.
        index: u8,
        /// The screen's pixels in the room.
        screen: FlatScreen,
    },
    /// The settings of rendering.
    Rendering(Rendering),
    /// The next frame is a dome master.
    Capture {
        /// Pixels a side.
        size: u16,
        /// Its viewpoint: metres, in the room.
        place: Vec3,
    },
}

impl Encoder {
    /// Encodes a report as a frame of the link.
    pub fn report(&mut self, report: &Report) -> Frame {
        match report {
            Report::Ready(it) => self.frame(READY, it),
            Report::Frame(it) => self.frame(FRAME, it),
            Report::Pixels(it) => self.frame(PIXELS, it),
            Report::Slice(it) => self.frame(SLICE, it),
            Report::FrameDone(it) => self.frame(FRAME_DONE, it),
            Report::Tracker(it) => self.frame(TRACKER, it),
        }
    }

    fn frame(&mut self, kind: u8, body: &impl Field) -> Frame {
        let mut content = self.begin(kind);
        body.write(&mut content);
        content.finish()
    }

    /// Encodes the first [`MOST_PIXELS`] pixels as a frame of [`Report::Pixels`].
    pub fn pixels(&mut self, picture: u8, place: (u16, u16), pixels: &[Pixel]) -> Frame {
        let mut content = self.begin(PIXELS);
        picture.write(&mut content);
        [place.0, place.1].write(&mut content);
        for pixel in pixels.iter().take(MOST_PIXELS) {
            pixel.write(&mut content);
        }
        content.finish()
    }

    /// Encodes an order as a frame of the link.
    pub fn order(&mut self, order: &Order) -> Frame {
        match order {
            Order::Screens { count } => self.frame(SCREENS, count),
            Order::Screen { index, screen } => {
                let mut content = self.begin(SCREEN);
                index.write(&mut content);
                screen.write(&mut content);
                content.finish()
            }
            Order::Rendering(it) => self.frame(RENDERING, it),
            Order::Capture { size, place } => {
                let mut content = self.begin(CAPTURE);
                size.write(&mut content);
                place.write(&mut content);
                content.finish()
            }
        }
    }
}

/// The decoder of a controller's reports.
pub type Reports = Listener<Report>;

/// The decoder of orders to a controller.
pub type Orders = Listener<Order>;

#[cfg(test)]
mod tests;
