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
//! All numbers keep their bits, so that who knows the scene and the screens can
//! make the same frame again.

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

/// What a controller starts with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Ready {
    /// Bytes of the scene.
    pub scene_bytes: u32,
    /// The effects that the scene asks for, as bits.
    pub effects: u32,
    /// The effects that the firmware has, as bits.
    pub linked: u32,
    /// What is wrong with the scene; 0 for nothing.
    pub fault: u32,
    /// Bytes of code and constants.
    pub flash_bytes: u32,
    /// Bytes of static memory.
    pub static_bytes: u32,
    /// The part of the static memory for pixels and the order of tiles.
    pub picture_bytes: u32,
}

/// What a frame shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Subject {
    /// The screens, as the viewer's eyes see them.
    Screens,
    /// A dome master, taken from where the left eye is said to be.
    Capture {
        /// Pixels a side, 1 or more.
        size: u16,
    },
}

/// What a frame is made of, besides scene and screens.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrameStart {
    /// Counts frames, from 0.
    pub number: u32,
    /// How many orders were obeyed before it; wraps at 256.
    pub orders: u8,
    /// Pictures of it: screen by screen, and eye by eye in each.
    pub pictures: u8,
    /// What it shows.
    pub subject: Subject,
    /// Its place in [`State::ALL`](crate::estimate::State::ALL); `None` without a gaze.
    pub state: Option<u8>,
    /// Steps that it may take.
    pub budget: u64,
    /// The left eye and the right one: metres, in the room; the same for one.
    pub eyes: [Vec3; 2],
    /// Along the line of sight: a unit vector in the room.
    pub forward: Vec3,
    /// Towards the top of the head, at right angles to that: a unit vector in the room.
    pub up: Vec3,
    /// Radians by which the field of full detail is wider.
    pub widen: f32,
}

/// Pixels of one row of a picture.
#[derive(Debug, Clone, PartialEq)]
pub struct PixelRun {
    /// Which picture.
    pub picture: u8,
    /// The column of the first pixel.
    pub column: u16,
    /// The row of all of them.
    pub row: u16,
    /// From left to right.
    pub pixels: Vec<Pixel, MOST_PIXELS>,
}

/// What one call of the renderer took.
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
    /// When it was over, by the controller's clock.
    pub time: Micros,
}

/// What a frame took.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FrameDone {
    /// Its number.
    pub number: u32,
    /// Whether it was left early, since the viewer looks elsewhere; the tiles it has are whole.
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
    /// Instructions from the last byte of a new gaze to the first tile; 0 where there was none.
    pub latency: u32,
    /// The part of the latency until the frame was begun.
    pub age: u32,
    /// From that byte to the end of sending the first tile; 0 without latency.
    pub sent: u32,
}

/// What came from the tracker so far.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TrackerState {
    /// Samples.
    pub records: u32,
    /// Bytes of no record.
    pub dropped: u32,
    /// Bytes that came faster than they were taken.
    pub overrun: u32,
    /// Instructions of decoding and of estimating.
    pub instructions: u64,
    /// The deepest stack so far, bytes.
    pub stack_bytes: u32,
}

/// What a controller says.
#[derive(Debug, Clone, PartialEq)]
pub enum Report {
    /// It has started.
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

/// How a controller is to render.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rendering {
    /// Steps a frame.
    pub budget: u64,
    /// Steps a call.
    pub slice: u32,
    /// Bounces.
    pub depth: u8,
    /// Wavelengths that dispersive media tell apart; 1 for none.
    pub wavelengths: u8,
    /// Whether detail follows the gaze.
    pub lod: bool,
    /// Metres from eye to eye; 0 for one eye.
    pub eye_distance: f32,
    /// From the choice of the gaze to the light of the frame, microseconds.
    pub display_delay: u32,
    /// Radians by which the line of sight may move before a frame is cut short and the next
    /// begins; 0 or less: no frame is.
    pub restart_angle: f32,
}

/// An order to a controller, in force from the next frame on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Order {
    /// The number of screens; new ones show nothing until their place is ordered.
    Screens {
        /// How many.
        count: u8,
    },
    /// Where a screen is.
    Screen {
        /// Which.
        index: u8,
        /// Where.
        screen: FlatScreen,
    },
    /// How to render.
    Rendering(Rendering),
    /// The next frame is a dome master.
    Capture {
        /// Pixels a side.
        size: u16,
        /// Where it is taken: metres, in the room.
        place: Vec3,
    },
}

impl Encoder {
    /// The frame of a report.
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

    /// The frame of [`Report::Pixels`], of the first [`MOST_PIXELS`] pixels.
    pub fn pixels(&mut self, picture: u8, place: (u16, u16), pixels: &[Pixel]) -> Frame {
        let mut content = self.begin(PIXELS);
        picture.write(&mut content);
        [place.0, place.1].write(&mut content);
        for pixel in pixels.iter().take(MOST_PIXELS) {
            pixel.write(&mut content);
        }
        content.finish()
    }

    /// The frame of an order.
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

/// The decoder of what a controller says.
pub type Reports = Listener<Report>;

/// The decoder of orders to a controller.
pub type Orders = Listener<Order>;

#[cfg(test)]
mod tests;
