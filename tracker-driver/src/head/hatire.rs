//! Hatire: head trackers that hobbyists build of a microcontroller and a
//! motion sensor, as opentrack's plugin of that name reads them; 115,200
//! baud.
//!
//! # Frames
//!
//! From opentrack's `tracker-hatire` and the sketch that comes with it.
//! Little-endian unless [`Config::big_endian`] says otherwise.
//!
//! | Byte | Content |
//! |---|---|
//! | 0 | AA AA |
//! | 2 | u16: code |
//! | 4 | 3 f32: yaw, pitch, roll in degrees |
//! | 16 | 3 f32: x, y, z, or the acceleration, or nothing but zeros |
//! | 28 | 55 55 |
//!
//! | Code | Frame |
//! |---|---|
//! | 0 to 999 | a sample; the code counts them. opentrack takes 1000 too |
//! | 2000 to 8999 | bytes 4 to 27 are text in ASCII: 3000 initialising, 5000 starting |
//! | from 9000 | the text of an error |
//!
//! Text becomes a [`Message::Text`], an error a [`Message::Fault`] and its
//! text.
//!
//! # Axes
//!
//! Each builder has their own. The default is the motion sensors' usual one: yaw grows to the
//! right, pitch upwards, roll clockwise as the wearer sees it, which is +X forward, +Y right,
//! +Z down. [`Config::axes`] changes the frames, [`Config::order`] and [`Config::reversed`]
//! which number is which angle. Bytes 16 to 27 are a position only where
//! [`Config::translation`] says so.
//!
//! # How strong the check is
//!
//! There is no checksum. Random bytes pass as a sample with a probability of 5 · 10⁻¹³ at each
//! byte: the marks, the code, and three angles within ±360. Three of four changed bytes leave a
//! valid frame.

use super::axes::{self, Axes};
use crate::command::{Awaited, PATIENCE, Script};
use crate::decoder::{Counts, Decoder, DropReason, Event, Message, Text};
use crate::sample::{Head, Reading, Sample};
use crate::stream::{Step, Stream, Window};
use crate::time::Micros;
use crate::valid;
use glam::{Quat, Vec3};

/// Bytes of a frame.
pub const FRAME_BYTES: usize = 30;

/// Baud of the line.
pub const BAUD: u32 = 115_200;

/// Highest code of a sample that opentrack takes.
const HIGHEST_COUNT: u16 = 1_000;
/// How many samples are counted before the count is back at 0.
const COUNTS: u32 = 1_000;
/// Bytes of a frame's text.
pub const TEXT_BYTES: usize = 24;
/// How long a device is away after a reset.
pub const RESET_TIME: Micros = Micros::from_millis(2_000);
const FIRST_TEXT: u16 = 2_000;
const FIRST_ERROR: u16 = 9_000;

/// The meaning of a frame's second three numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Translation {
    /// No positions: other values, or unused.
    #[default]
    None,
    /// A position in centimetres, opentrack's unit.
    Centimetres,
}

/// How a device is set up.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Config {
    /// Whether numbers have their highest byte first.
    pub big_endian: bool,
    /// The numbers of the frame, 0 to 2, that are azimuth, elevation and roll; higher ones are 2.
    pub order: [u8; 3],
    /// Whether azimuth, elevation and roll grow the other way.
    pub reversed: [bool; 3],
    /// The meaning of the other three numbers.
    pub translation: Translation,
    /// The device's axes.
    pub axes: Axes,
}

impl Default for Config {
    fn default() -> Self {
        Self {
            big_endian: false,
            order: [0, 1, 2],
            reversed: [false; 3],
            translation: Translation::None,
            axes: Axes::FORWARD_RIGHT_DOWN,
        }
    }
}

/// Makes the device send, after a reset where `reset` says so.
pub fn start(reset: bool) -> Script {
    let mut script = Script::new();
    if reset {
        script.send(b"R").pause(RESET_TIME);
    }
    script
        .once_only()
        .send(b"S")
        .expect(Awaited::Sample, PATIENCE);
    script
}

/// Returns the script that ends the stream.
pub fn stop() -> Script {
    Script::sending(b"s")
}

/// Returns the script that makes the head's present direction the device's front.
pub fn centre() -> Script {
    Script::sending(b"C")
}

/// Returns the sketch's meaning of an error code; empty if it has none.
pub const fn error_meaning(code: u16) -> &'static str {
    match code {
        9_007 => "the sensor is not connected",
        9_010 => "the sensor's buffer overran",
        9_011 => "the motion processor's program did not load",
        9_000..=9_006 => "the motion processor did not start",
        _ => "",
    }
}

/// A frame, in the device's own axes: degrees, and a position or an acceleration.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Frame {
    code: u16,
    rotation: [f32; 3],
    translation: [f32; 3],
}

impl Config {
    /// Converts the device's byte order to little-endian, or back.
    fn flip<const N: usize>(&self, mut bytes: [u8; N]) -> [u8; N] {
        if self.big_endian {
            bytes.reverse();
        }
        bytes
    }

    /// Takes a frame apart; `None` where its marks are not there.
    fn decode(&self, bytes: &[u8; FRAME_BYTES]) -> Option<Frame> {
        let [0xAA, 0xAA, c0, c1, numbers @ .., 0x55, 0x55] = bytes else {
            return None;
        };
        let mut values = [0.0; 6];
        for (value, bytes) in values.iter_mut().zip(numbers.chunks_exact(4)) {
            *value = f32::from_le_bytes(self.flip(bytes.try_into().ok()?));
        }
        let [yaw, pitch, roll, x, y, z] = values;
        Some(Frame {
            code: u16::from_le_bytes(self.flip([*c0, *c1])),
            rotation: [yaw, pitch, roll],
            translation: [x, y, z],
        })
    }

    fn encode_frame(&self, frame: &Frame) -> [u8; FRAME_BYTES] {
        let mut bytes = [0; FRAME_BYTES];
        let code = self.flip(frame.code.to_le_bytes());
        let numbers = frame.rotation.iter().chain(&frame.translation);
        let numbers = numbers.flat_map(|value| self.flip(value.to_le_bytes()));
        let all = [0xAA, 0xAA].into_iter().chain(code).chain(numbers);
        for (place, byte) in bytes.iter_mut().zip(all.chain([0x55, 0x55])) {
            *place = byte;
        }
        bytes
    }

    /// Returns the frame of a sample; what it lacks is the origin, no rotation and count 0.
    pub fn encode(&self, sample: &Sample) -> [u8; FRAME_BYTES] {
        let rotation = sample.head.orientation.map_or(Quat::IDENTITY, |q| q.value);
        let angles = axes::euler_degrees(self.axes.device_orientation(rotation));
        let mut frame = Frame {
            code: (sample.sequence.unwrap_or(0) % COUNTS) as u16,
            ..Frame::default()
        };
        for ((angle, place), reversed) in angles.into_iter().zip(self.order).zip(self.reversed) {
            if let Some(number) = frame.rotation.get_mut(usize::from(place.min(2))) {
                *number = if reversed { -angle } else { angle };
            }
        }
        if self.translation == Translation::Centimetres {
            let metres = sample.head.position.map_or(Vec3::ZERO, |p| p.value);
            frame.translation = (self.axes.device_position(metres) * 100.0).to_array();
        }
        self.encode_frame(&frame)
    }

    /// Returns the frame of a text, which zeros fill up.
    pub fn encode_text(&self, code: u16, text: &[u8; TEXT_BYTES]) -> [u8; FRAME_BYTES] {
        let mut bytes = self.encode_frame(&Frame {
            code,
            ..Frame::default()
        });
        if let Some(place) = bytes.get_mut(4..4 + TEXT_BYTES) {
            place.copy_from_slice(text);
        }
        bytes
    }

    /// Reads the head from a frame.
    fn head(&self, frame: &Frame) -> Result<Head, DropReason> {
        let mut angles = [0.0; 3];
        for ((angle, place), reversed) in angles.iter_mut().zip(self.order).zip(self.reversed) {
            let number = frame.rotation.get(usize::from(place.min(2)));
            let number = number.copied().unwrap_or_default();
            *angle = if reversed { -number } else { number };
        }
        let [azimuth, elevation, roll] = angles;
        let orientation = axes::from_euler_degrees(azimuth, elevation, roll)?;
        let position = match self.translation {
            Translation::None => None,
            Translation::Centimetres => {
                let metres = valid::position(Vec3::from_array(frame.translation) * 0.01)?;
                Some(Reading::tracked(self.axes.position(metres)))
            }
        };
        Ok(Head {
            position,
            orientation: Some(Reading::tracked(self.axes.orientation(orientation))),
            angular_velocity: None,
        })
    }
}

/// Decodes the frames of one device.
#[derive(Debug, Clone)]
pub struct Hatire {
    stream: Stream<FRAME_BYTES>,
    config: Config,
}

impl Hatire {
    /// Returns a decoder of a device that is set up this way.
    pub fn new(config: Config) -> Self {
        Self {
            stream: Stream::default(),
            config,
        }
    }
}

impl Decoder for Hatire {
    fn feed(&mut self, bytes: &[u8], arrival: Micros, sink: &mut dyn FnMut(Event)) {
        let config = &self.config;
        let numbers = [COUNTS, LARGEST_GAP];
        let step = |window: Window<'_>| config.step(window);
        self.stream
            .feed_numbered(numbers, bytes, arrival, sink, step);
    }

    fn counts(&self) -> &Counts {
        &self.stream.counts
    }

    fn reset(&mut self) {
        self.stream.reset();
    }
}

/// More samples than this cannot be missing: the count began anew, or does not count.
const LARGEST_GAP: u32 = 250;

/// Returns whether a frame holds text. Inlined, it makes the compiler copy each sample on its way.
#[inline(never)]
fn is_text(frame: &[u8; FRAME_BYTES]) -> bool {
    let [_, _, _, _, text @ .., _, _] = frame;
    text.iter()
        .all(|&byte| matches!(byte, 0 | b' ' | b'\t' | b'\r' | b'\n') || byte.is_ascii_graphic())
}

impl Config {
    fn step(&self, window: Window<'_>) -> Step {
        let bytes = window.bytes;
        if bytes.iter().take(2).any(|&byte| byte != 0xAA) {
            return Step::Skip(DropReason::OutOfStep);
        }
        let Some(whole) = bytes.first_chunk::<FRAME_BYTES>() else {
            return Step::More;
        };
        let Some(frame) = self.decode(whole) else {
            return window.broken_off();
        };
        match frame.code {
            ..=HIGHEST_COUNT => match self.head(&frame) {
                Err(reason) => window.unusable(FRAME_BYTES, reason),
                Ok(head) => {
                    let sample = Sample {
                        sequence: Some(u32::from(frame.code)),
                        head,
                        ..Sample::arrived(window.arrival)
                    };
                    Step::Take(FRAME_BYTES, None, Event::Sample(sample))
                }
            },
            FIRST_TEXT.. if !is_text(whole) => window.unusable(FRAME_BYTES, DropReason::Field),
            FIRST_TEXT.. => {
                let text = whole.get(4..4 + TEXT_BYTES).unwrap_or_default();
                let fault = (frame.code >= FIRST_ERROR).then(|| Message::Fault {
                    code: u32::from(frame.code),
                    meaning: error_meaning(frame.code),
                });
                let text = Event::Message(Message::Text(Text::new(text)));
                Step::Take(FRAME_BYTES, fault, text)
            }
            _ => window.unusable(FRAME_BYTES, DropReason::Unknown),
        }
    }
}

#[cfg(test)]
mod tests;
