//! What a display controller reports, and what it is told: the link's frames
//! between a controller that renders and whoever watches it.
//!
//! | Kind | Body |
//! |---|---|
//! | 32 ready | u32 bytes of the scene, u32 effects that it asks for, u32 those that are linked, u32 what is wrong with it (0 nothing), u32 bytes of flash, of static memory, of that for pictures |
//! | 33 frame | u32 number, u8 orders obeyed, u8 pictures, u8 state of the gaze (255 none), u16 pixels a side of a dome master (0: screens), u64 budget in steps, f32 x, y, z of the left eye, of the right eye, of the line of sight and of up, f32 radians by which the field is wider |
//! | 34 pixels | u8 picture, u16 column, u16 row, then up to 8 pixels to the right: f32 red, green, blue, alpha |
//! | 35 slice | u32 frame, u32 instructions, u32 steps, u8 whether it ended a tile, u64 the controller's clock, microseconds |
//! | 36 frame done | u32 number, u32 whole tiles, u32 tiles given up, u64 steps, u64 primary rays, u64 all rays, u64 instructions of its slices, u32 instructions before the first slice, u32 instructions from the last byte of a new gaze to the first tile (0 none), u32 of these until the frame was begun, u32 until the tile was sent |
//! | 37 tracker | u32 records, u32 bytes dropped, u32 bytes that found no room, u64 instructions of decoding and estimating, u32 bytes of stack used so far |
//! | 48 screens, to the controller | u8 how many there are |
//! | 49 screen, to the controller | u8 which, u16 columns, u16 rows, f32 x, y, z of the first pixel's centre, of the step to the right and of the step down, metres in the room |
//! | 50 rendering, to the controller | u64 steps a frame, u32 steps a slice, u8 depth, u8 wavelengths, u8 whether detail follows the gaze, f32 metres from eye to eye (0: one eye), u32 microseconds from the gaze to the light |
//! | 51 capture, to the controller | u16 pixels a side of a dome master, f32 x, y, z of its place |
//!
//! All numbers keep their bits, so that who knows the scene and the screens can
//! make the same frame again.

use super::body::Body;
use super::frame::{Content, Frame, Frames, Received};
use super::{Encoder, VERSION};
use crate::decoder::DropReason;
use crate::time::Micros;
use glam::Vec3;
use heapless::Vec;
use shisen_core::frame::{FlatScreen, Pixel};

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
    /// Of these for pixels and the order of tiles.
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
    /// The state of the gaze, by its place in [`State::ALL`](crate::estimate::State::ALL);
    /// `None` where no detail follows it.
    pub state: Option<u8>,
    /// Steps that it may take.
    pub budget: u64,
    /// The left eye and the right one: metres, in the room. The same where
    /// there is one.
    pub eyes: [Vec3; 2],
    /// The line of sight, and the top of the head.
    pub forward: Vec3,
    /// Upwards.
    pub up: Vec3,
    /// Radians by which the field of full detail is wider.
    pub widen: f32,
}

/// Pixels of one row of a picture.
#[derive(Debug, Clone, PartialEq)]
pub struct PixelRun {
    /// Which picture.
    pub picture: u8,
    /// Of the first pixel.
    pub column: u16,
    /// Of all.
    pub row: u16,
    /// To the right.
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
    /// Instructions from the arrival of the last byte of a gaze that the frame
    /// before did not have to the end of the first tile; 0 where there was none.
    pub latency: u32,
    /// Of these, until the frame was begun, which chooses its gaze first: the
    /// bytes are decoded, and the frame before is finished. 0 where there was no
    /// latency.
    pub age: u32,
    /// From that byte to the end of sending the first tile; 0 where there was no
    /// latency.
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
}

/// What a controller is told, in force from the next frame on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Order {
    /// There are so many screens; more than there were show nothing until they
    /// are told.
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
        let mut content = self.begin(match report {
            Report::Ready(_) => READY,
            Report::Frame(_) => FRAME,
            Report::Pixels(_) => PIXELS,
            Report::Slice(_) => SLICE,
            Report::FrameDone(_) => FRAME_DONE,
            Report::Tracker(_) => TRACKER,
        });
        match report {
            Report::Ready(it) => {
                for number in [
                    it.scene_bytes,
                    it.effects,
                    it.linked,
                    it.fault,
                    it.flash_bytes,
                    it.static_bytes,
                    it.picture_bytes,
                ] {
                    content.u32(number);
                }
            }
            Report::Frame(it) => {
                content.u32(it.number);
                let size = match it.subject {
                    Subject::Screens => 0,
                    Subject::Capture { size } => size,
                };
                content.push(&[it.orders, it.pictures, it.state.unwrap_or(u8::MAX)]);
                content.push(&size.to_le_bytes());
                content.u64(it.budget);
                for vector in [it.eyes[0], it.eyes[1], it.forward, it.up] {
                    content.vector(vector);
                }
                content.f32(it.widen);
            }
            Report::Pixels(it) => content.pixels(it.picture, (it.column, it.row), &it.pixels),
            Report::Slice(it) => {
                for number in [it.frame, it.instructions, it.steps] {
                    content.u32(number);
                }
                content.push(&[u8::from(it.ended_tile)]);
                content.u64(it.time.0);
            }
            Report::FrameDone(it) => {
                for number in [it.number, it.whole, it.given_up] {
                    content.u32(number);
                }
                for number in [it.steps, it.primary, it.rays, it.instructions] {
                    content.u64(number);
                }
                for number in [it.preparation, it.latency, it.age, it.sent] {
                    content.u32(number);
                }
            }
            Report::Tracker(it) => {
                for number in [it.records, it.dropped, it.overrun] {
                    content.u32(number);
                }
                content.u64(it.instructions);
                content.u32(it.stack_bytes);
            }
        }
        content.finish()
    }

    /// The frame of [`Report::Pixels`], of the first [`MOST_PIXELS`] pixels.
    pub fn pixels(&mut self, picture: u8, place: (u16, u16), pixels: &[Pixel]) -> Frame {
        let mut content = self.begin(PIXELS);
        content.pixels(picture, place, pixels);
        content.finish()
    }

    /// The frame of an order.
    pub fn order(&mut self, order: &Order) -> Frame {
        let mut content = self.begin(match order {
            Order::Screens { .. } => SCREENS,
            Order::Screen { .. } => SCREEN,
            Order::Rendering(_) => RENDERING,
            Order::Capture { .. } => CAPTURE,
        });
        match order {
            Order::Screens { count } => content.push(&[*count]),
            Order::Screen { index, screen } => {
                content.push(&[*index]);
                for pixels in screen.size {
                    content.push(&(pixels as u16).to_le_bytes());
                }
                for vector in [screen.first_pixel, screen.column_step, screen.row_step] {
                    content.vector(vector);
                }
            }
            Order::Rendering(it) => {
                content.u64(it.budget);
                content.u32(it.slice);
                content.push(&[it.depth, it.wavelengths, u8::from(it.lod)]);
                content.f32(it.eye_distance);
                content.u32(it.display_delay);
            }
            Order::Capture { size, place } => {
                content.push(&size.to_le_bytes());
                content.vector(*place);
            }
        }
        content.finish()
    }
}

impl Content {
    fn pixels(&mut self, picture: u8, (column, row): (u16, u16), pixels: &[Pixel]) {
        self.push(&[picture]);
        self.push(&column.to_le_bytes());
        self.push(&row.to_le_bytes());
        for pixel in pixels.iter().take(MOST_PIXELS) {
            for channel in [pixel.red, pixel.green, pixel.blue, pixel.alpha] {
                self.f32(channel);
            }
        }
    }

    fn u32(&mut self, number: u32) {
        self.push(&number.to_le_bytes());
    }

    fn u64(&mut self, number: u64) {
        self.push(&number.to_le_bytes());
    }

    fn f32(&mut self, number: f32) {
        self.push(&number.to_le_bytes());
    }

    fn vector(&mut self, vector: Vec3) {
        for number in vector.to_array() {
            self.f32(number);
        }
    }
}

impl Body<'_> {
    fn u8(&mut self) -> Result<u8, DropReason> {
        let [byte] = self.take()?;
        Ok(byte)
    }

    fn u16(&mut self) -> Result<u16, DropReason> {
        self.take().map(u16::from_le_bytes)
    }

    fn flag(&mut self) -> Result<bool, DropReason> {
        match self.u8()? {
            0 => Ok(false),
            1 => Ok(true),
            _ => Err(DropReason::Field),
        }
    }

    /// Whatever its bits are.
    fn channel(&mut self) -> Result<f32, DropReason> {
        self.take().map(f32::from_le_bytes)
    }
}

fn read_report(kind: u8, body: &[u8]) -> Result<Report, DropReason> {
    let mut body = Body(body);
    let report = match kind {
        READY => Report::Ready(Ready {
            scene_bytes: body.u32()?,
            effects: body.u32()?,
            linked: body.u32()?,
            fault: body.u32()?,
            flash_bytes: body.u32()?,
            static_bytes: body.u32()?,
            picture_bytes: body.u32()?,
        }),
        FRAME => Report::Frame(FrameStart {
            number: body.u32()?,
            orders: body.u8()?,
            pictures: body.u8()?,
            state: Some(body.u8()?).filter(|&state| state != u8::MAX),
            subject: match body.u16()? {
                0 => Subject::Screens,
                size => Subject::Capture { size },
            },
            budget: body.u64()?,
            eyes: [body.vector()?, body.vector()?],
            forward: body.vector()?,
            up: body.vector()?,
            widen: body.number()?,
        }),
        PIXELS => Report::Pixels(read_pixels(&mut body)?),
        SLICE => Report::Slice(Slice {
            frame: body.u32()?,
            instructions: body.u32()?,
            steps: body.u32()?,
            ended_tile: body.flag()?,
            time: Micros(body.u64()?),
        }),
        FRAME_DONE => Report::FrameDone(FrameDone {
            number: body.u32()?,
            whole: body.u32()?,
            given_up: body.u32()?,
            steps: body.u64()?,
            primary: body.u64()?,
            rays: body.u64()?,
            instructions: body.u64()?,
            preparation: body.u32()?,
            latency: body.u32()?,
            age: body.u32()?,
            sent: body.u32()?,
        }),
        TRACKER => Report::Tracker(TrackerState {
            records: body.u32()?,
            dropped: body.u32()?,
            overrun: body.u32()?,
            instructions: body.u64()?,
            stack_bytes: body.u32()?,
        }),
        _ => return Err(DropReason::Unknown),
    };
    body.end()?;
    Ok(report)
}

fn read_pixels(body: &mut Body<'_>) -> Result<PixelRun, DropReason> {
    let mut run = PixelRun {
        picture: body.u8()?,
        column: body.u16()?,
        row: body.u16()?,
        pixels: Vec::new(),
    };
    while body.end().is_err() {
        let pixel = Pixel {
            red: body.channel()?,
            green: body.channel()?,
            blue: body.channel()?,
            alpha: body.channel()?,
        };
        run.pixels.push(pixel).map_err(|_| DropReason::Length)?;
    }
    Ok(run)
}

fn read_order(kind: u8, body: &[u8]) -> Result<Order, DropReason> {
    let mut body = Body(body);
    let order = match kind {
        SCREENS => Order::Screens { count: body.u8()? },
        SCREEN => {
            let index = body.u8()?;
            let size = [body.u16()?, body.u16()?].map(u32::from);
            let screen = FlatScreen {
                first_pixel: body.vector()?,
                column_step: body.vector()?,
                row_step: body.vector()?,
                size,
            };
            Order::Screen { index, screen }
        }
        RENDERING => Order::Rendering(Rendering {
            budget: body.u64()?,
            slice: body.u32()?,
            depth: body.u8()?,
            wavelengths: body.u8()?,
            lod: body.flag()?,
            eye_distance: body.number()?,
            display_delay: body.u32()?,
        }),
        CAPTURE => Order::Capture {
            size: body.u16()?,
            place: body.vector()?,
        },
        _ => return Err(DropReason::Unknown),
    };
    body.end()?;
    Ok(order)
}

/// The decoder of what one side says to the other: frames that are damaged, or
/// of other kinds, are counted and passed over.
#[derive(Debug, Clone, Default)]
struct Receiver {
    frames: Frames,
    dropped: u32,
}

impl Receiver {
    fn feed<T>(
        &mut self,
        bytes: &[u8],
        read: impl Fn(u8, &[u8]) -> Result<T, DropReason>,
        sink: &mut dyn FnMut(T),
    ) {
        for &byte in bytes {
            let Some(Received { content, .. }) = self.frames.push(byte) else {
                continue;
            };
            let read = content.and_then(|content| match content.bytes {
                [VERSION, kind, _, body @ ..] => read(*kind, body),
                _ => Err(DropReason::Unknown),
            });
            match read {
                Ok(it) => sink(it),
                Err(_) => self.dropped = self.dropped.saturating_add(1),
            }
        }
    }
}

/// The decoder of what a controller says.
#[derive(Debug, Clone, Default)]
pub struct Reports(Receiver);

impl Reports {
    /// A decoder that has seen nothing.
    pub fn new() -> Self {
        Self::default()
    }

    /// Takes the next bytes and hands each report to `sink`.
    pub fn feed(&mut self, bytes: &[u8], sink: &mut dyn FnMut(Report)) {
        self.0.feed(bytes, read_report, sink);
    }

    /// Frames that were no report.
    pub const fn dropped(&self) -> u32 {
        self.0.dropped
    }
}

/// The decoder of what a controller is told.
#[derive(Debug, Clone, Default)]
pub struct Orders(Receiver);

impl Orders {
    /// A decoder that has seen nothing.
    pub fn new() -> Self {
        Self::default()
    }

    /// Takes the next bytes and hands each order to `sink`.
    pub fn feed(&mut self, bytes: &[u8], sink: &mut dyn FnMut(Order)) {
        self.0.feed(bytes, read_order, sink);
    }

    /// Frames that were no order.
    pub const fn dropped(&self) -> u32 {
        self.0.dropped
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec::Vec;

    fn reports() -> [Report; 6] {
        let pixel = |red| Pixel {
            red,
            green: -0.0,
            blue: f32::from_bits(0x7fc0_1234),
            alpha: f32::MIN_POSITIVE / 2.0,
        };
        [
            Report::Ready(Ready {
                scene_bytes: 1,
                effects: 2,
                linked: 7,
                fault: 3,
                flash_bytes: 4,
                static_bytes: 5,
                picture_bytes: 6,
            }),
            Report::Frame(FrameStart {
                number: 7,
                orders: 255,
                pictures: 6,
                subject: Subject::Capture { size: 256 },
                state: None,
                budget: u64::MAX,
                eyes: [Vec3::X, Vec3::NEG_X],
                forward: Vec3::NEG_Z,
                up: Vec3::Y,
                widen: 0.25,
            }),
            Report::Pixels(PixelRun {
                picture: 5,
                column: 65_535,
                row: 258,
                pixels: [1.0, 2.0, 3.0].into_iter().map(pixel).collect(),
            }),
            Report::Slice(Slice {
                frame: 7,
                instructions: 1,
                steps: 2,
                ended_tile: true,
                time: Micros(1 << 33),
            }),
            Report::FrameDone(FrameDone {
                number: 7,
                whole: 1,
                given_up: 2,
                steps: 3,
                primary: 4,
                rays: 5,
                instructions: 6,
                preparation: 8,
                latency: 9,
                age: 10,
                sent: 11,
            }),
            Report::Tracker(TrackerState {
                records: 1,
                dropped: 2,
                overrun: 3,
                instructions: 4,
                stack_bytes: 5,
            }),
        ]
    }

    fn orders() -> [Order; 4] {
        let screen = FlatScreen {
            first_pixel: Vec3::ONE,
            column_step: Vec3::X,
            row_step: Vec3::NEG_Y,
            size: [64, 65_535],
        };
        [
            Order::Screens { count: 3 },
            Order::Screen { index: 2, screen },
            Order::Rendering(Rendering {
                budget: 1 << 40,
                slice: 10_000,
                depth: 3,
                wavelengths: 7,
                lod: true,
                eye_distance: 0.064,
                display_delay: 20_000,
            }),
            Order::Capture {
                size: 256,
                place: Vec3::NEG_Z,
            },
        ]
    }

    /// Of equal bits, NaN or not.
    fn same(a: &Report, b: &Report) -> bool {
        let mut encoders = [Encoder::new(), Encoder::new()];
        let [first, second] = &mut encoders;
        first.report(a) == second.report(b)
    }

    #[test]
    fn every_message_comes_through_with_its_bits() {
        let mut encoder = Encoder::new();
        let (mut line, mut back) = (Vec::new(), Vec::new());
        for report in &reports() {
            line.extend_from_slice(&encoder.report(report));
        }
        for order in &orders() {
            back.extend_from_slice(&encoder.order(order));
        }
        let (mut seen, mut told) = (Vec::new(), Vec::new());
        let (mut decoder, mut listener) = (Reports::new(), Orders::new());
        for byte in line {
            decoder.feed(&[byte], &mut |report| seen.push(report));
        }
        listener.feed(&back, &mut |order| told.push(order));
        assert_eq!(seen.len(), reports().len());
        assert!(reports().iter().zip(&seen).all(|(a, b)| same(a, b)));
        assert_eq!(told, orders());
        assert_eq!((decoder.dropped(), listener.dropped()), (0, 0));
    }

    #[test]
    fn damage_costs_the_frame_that_it_touches() {
        let mut encoder = Encoder::new();
        let mut line = Vec::new();
        let ends: Vec<usize> = orders()
            .iter()
            .map(|order| {
                line.extend_from_slice(&encoder.order(order));
                line.len()
            })
            .collect();
        for at in 0..line.len() {
            let mut damaged = line.clone();
            damaged[at] ^= 0x55;
            let mut told = Vec::new();
            Orders::new().feed(&damaged, &mut |order| told.push(order));
            let hurt = ends.iter().position(|&end| at < end).unwrap_or_default();
            for (number, order) in orders().iter().enumerate() {
                let touched = number == hurt;
                assert!(touched || told.contains(order), "{at} {number}");
            }
        }
    }

    #[test]
    fn bodies_of_other_lengths_are_no_messages() {
        let mut encoder = Encoder::new();
        for (kind, length) in [(SCREENS, 2), (SCREEN, 40), (RENDERING, 22), (CAPTURE, 15)] {
            let mut content = encoder.begin(kind);
            content.push(&[0; 64][..length]);
            let mut orders = Orders::new();
            orders.feed(&content.finish(), &mut |order| panic!("{order:?}"));
            assert_eq!(orders.dropped(), 1);
        }
        for (kind, length) in [(READY, 27), (FRAME, 71), (PIXELS, 20), (TRACKER, 25)] {
            let mut content = encoder.begin(kind);
            content.push(&[0; 80][..length]);
            let mut reports = Reports::new();
            reports.feed(&content.finish(), &mut |report| panic!("{report:?}"));
            assert_eq!(reports.dropped(), 1);
        }
        // More pixels than fit.
        let mut content = encoder.begin(PIXELS);
        content.push(&[0; 5 + 16 * 9]);
        let mut reports = Reports::new();
        reports.feed(&content.finish(), &mut |report| panic!("{report:?}"));
        assert_eq!(reports.dropped(), 1);
    }
}
