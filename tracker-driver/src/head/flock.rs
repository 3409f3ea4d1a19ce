//! Ascension Flock of Birds, and what speaks its language (laserBIRD, 6D
//! bird): position and orientation over a serial line.
//!
//! # Records
//!
//! From Ascension's laserBIRD guide and VRPN's `vrpn_Flock.C`. A record is
//! words, and in group mode the address of the bird behind them. Each word is
//! two bytes of seven bits, low first; the highest bit is set in a record's
//! first byte and in no other, which is how a record's start is known.
//!
//! | Mode | Command | Words |
//! |---|---|---|
//! | [`Mode::Angles`] | `W` | z, y, x angle |
//! | [`Mode::Position`] | `V` | x, y, z |
//! | [`Mode::Matrix`] | `X` | 11, 12, 13, 21 … 33 |
//! | [`Mode::Quaternion`] | `\` | real part, 1, 2, 3 |
//! | [`Mode::PositionAngles`] | `Y` | x, y, z; z, y, x angle |
//! | [`Mode::PositionMatrix`] | `Z` | x, y, z; 11 … 33 |
//! | [`Mode::PositionQuaternion`] | `]` | x, y, z; real part, 1, 2, 3 |
//!
//! A word is a two's complement number of 16 bits whose lowest two are not
//! sent. 32768 stands for [`Config::range`], [`Config::half_turn`] (180°) or 1.
//!
//! The first four commands, the one that wakes the birds and the scale of the angles are
//! generally known, not from those sources: [`Config::letter`], [`Config::run`] and
//! [`Config::half_turn`] are for a device that has others.
//!
//! # Answers
//!
//! The birds' answers to `O` (examine) are bare bytes without a start. The decoder reads them
//! where it is told of the question ([`Decoder::on_sent`]) and they come within [`PATIENCE`],
//! and drops them as out of step otherwise. While a record may come no answer is taken for
//! one, nor a record for an answer, but to `O` 36: ask that while no records come. Each answer
//! is a [`Reply`](crate::decoder::Reply) to `O` with result 0, and before it:
//!
//! | Parameter | Bytes | Message |
//! |---|---|---|
//! | 0, status | 2 | [`Message::State`](crate::decoder::Message::State), the word |
//! | 2, crystal | 2 | |
//! | 10, error | 1 | [`Message::Fault`](crate::decoder::Message::Fault) where there was one, of [`error_meaning`] |
//! | 16, error and its unit | 2 | as 10 |
//! | 36, all units | 14 | |
//!
//! A record behind an answer that was cut short is not taken for its rest, nor noise for an
//! answer that it cannot be: an error's code is one of 36 and has no noise before it, a crystal
//! and an error's unit have no highest bit. Of random bytes right after a question more than a
//! quarter pass for an error's code. A status whose low byte says that records stream may have
//! a highest bit: its answer waits for the byte behind it.
//!
//! # The line's RTS
//!
//! RTS, where it is wired, holds the birds in reset while it is high, which it is on most
//! systems when a port is opened: lower it (`serial::Serial::set_rts`). VRPN raises it for a
//! second, lowers it and waits two.
//!
//! # Axes
//!
//! The transmitter's +X points forward, +Y to the right, +Z down, as do a bird's. Quaternion
//! and matrix are the reverse of other trackers': they turn the transmitter's axes to the
//! bird's components, as in VRPN; [`Config::reversed`] is for a device that does not. The
//! angles are the bird's in the transmitter's frame: azimuth about Z, then elevation about Y,
//! then roll about X. A bird is a sample's sensor by its address less one; without group mode
//! it is sensor 0.
//!
//! # How strong the check is
//!
//! A record's start cannot be mistaken, its inside not be checked: no checksum. Random bytes
//! pass as a record of n bytes with a probability of 2⁻ⁿ at each byte, times what the values
//! can be: a quaternion 0.025, a matrix below 10⁻⁹, angles and positions anything, a bird's
//! address 0.98. That is 1.6 % for angles alone, 0.00015 % for position and quaternion.
//!
//! On a line that is read at another speed than the device sends at, angles or a position pass
//! once in 14 bytes at most, both once in 42, a quaternion once in 1,600; a
//! [`Watch`](crate::command::Watch) says so. Angles and a position cannot be told from each other,
//! nor an ASL eye tracker's frames from both together. Half of the changed bytes leave a valid
//! record. A byte too many does not touch the next record; [`Config::confirm`] notices it.

pub(crate) mod command;

pub use command::{MOST_BIRDS, error_meaning, stop};

use super::axes::{self, Axes};
use super::polhemus::{from_seven_bits, nearest_word, to_seven_bits};
use crate::command::PATIENCE;
use crate::decoder::{Counts, Decoder, DropReason, Event};
use crate::rotation::inverse;
use crate::sample::{Head, Reading, Sample};
use crate::stream::{Step, Stream, Window};
use crate::time::Micros;
use crate::valid;
use command::{EXAMINE, answer, command_bytes};
use glam::{Quat, Vec3};
use heapless::Vec;

/// The line's speed, as VRPN has it; a device's switches may say others, up to 115,200.
pub const BAUD: u32 = 38_400;
/// Most words of a record: position and matrix.
const MOST_WORDS: usize = 12;
/// Most bytes of a record: those, and a bird's address.
pub const MOST_RECORD_BYTES: usize = 2 * MOST_WORDS + 1;

/// The bit that is set in a record's first byte only.
const PHASE: u8 = 0x80;
/// The word that would stand for 1: one above the largest.
const ONE: f32 = 32_768.0;
/// Highest address of a bird.
pub const HIGHEST_ADDRESS: u8 = 126;

/// The contents of a record.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Mode {
    /// Three angles.
    Angles,
    /// A position.
    Position,
    /// A rotation's matrix.
    Matrix,
    /// A rotation's quaternion.
    Quaternion,
    /// Position and three angles.
    PositionAngles,
    /// Position and matrix.
    PositionMatrix,
    /// Position and quaternion.
    #[default]
    PositionQuaternion,
}

impl Mode {
    /// All modes.
    pub const ALL: [Self; 7] = [
        Self::Angles,
        Self::Position,
        Self::Matrix,
        Self::Quaternion,
        Self::PositionAngles,
        Self::PositionMatrix,
        Self::PositionQuaternion,
    ];

    /// Returns the command that chooses it.
    pub const fn command(self) -> u8 {
        match self {
            Self::Angles => b'W',
            Self::Position => b'V',
            Self::Matrix => b'X',
            Self::Quaternion => b'\\',
            Self::PositionAngles => b'Y',
            Self::PositionMatrix => b'Z',
            Self::PositionQuaternion => b']',
        }
    }

    /// Returns whether its records hold a position.
    pub const fn has_position(self) -> bool {
        !matches!(self, Self::Angles | Self::Matrix | Self::Quaternion)
    }

    /// Returns whether its records hold a rotation, in any form.
    pub const fn has_orientation(self) -> bool {
        !matches!(self, Self::Position)
    }

    /// Returns the number of words of a record.
    pub const fn words(self) -> usize {
        let turn = match self {
            Self::Position => 0,
            Self::Angles | Self::PositionAngles => 3,
            Self::Quaternion | Self::PositionQuaternion => 4,
            Self::Matrix | Self::PositionMatrix => 9,
        };
        turn + if self.has_position() { 3 } else { 0 }
    }
}

/// The distance that is just out of a position's reach.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Range {
    /// 36 inches: a standard transmitter.
    #[default]
    Inches36,
    /// 72 inches: a standard transmitter with scaling 1.
    Inches72,
    /// 144 inches: the extended-range transmitter.
    Inches144,
}

impl Range {
    /// In metres.
    pub const fn metres(self) -> f32 {
        match self {
            Self::Inches36 => 36.0 * 0.0254,
            Self::Inches72 => 72.0 * 0.0254,
            Self::Inches144 => 144.0 * 0.0254,
        }
    }
}

/// How a device is set up.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Config {
    /// Contents of its records.
    pub mode: Mode,
    /// Whether each record ends with the address of its bird.
    pub group: bool,
    /// How far positions reach.
    pub range: Range,
    /// Whether quaternion and matrix are the reverse of `device_from_sensor`.
    pub reversed: bool,
    /// The command that chooses the mode, where it is not [`Mode::command`]'s.
    pub letter: Option<u8>,
    /// The command that wakes the birds: `F`.
    pub run: u8,
    /// Angle of a word of 32768: degrees, above 0 and up to 360.
    pub half_turn: f32,
    /// The device's axes.
    pub axes: Axes,
    /// Whether a record is handed over only when the next one has begun behind it: that notices
    /// a byte too many, delays each sample, and loses a record before a damaged byte.
    pub confirm: bool,
}

impl Default for Config {
    fn default() -> Self {
        Self {
            mode: Mode::default(),
            group: false,
            range: Range::default(),
            reversed: true,
            letter: None,
            run: b'F',
            half_turn: 180.0,
            axes: Axes::FORWARD_RIGHT_DOWN,
            confirm: false,
        }
    }
}

impl Config {
    /// Returns bytes of a record.
    pub const fn record_bytes(&self) -> usize {
        2 * self.mode.words() + self.group as usize
    }

    /// Reads the head from a record's words.
    fn head(&self, words: [i16; MOST_WORDS]) -> Result<Head, DropReason> {
        let parts = words.map(|word| f32::from(word) / ONE);
        let [x, y, z, ..] = parts;
        let position = self.mode.has_position().then(|| {
            let device = Vec3::new(x, y, z) * self.range.metres();
            Reading::tracked(self.axes.position(device))
        });
        let turn = parts
            .get(if self.mode.has_position() { 3 } else { 0 }..)
            .unwrap_or_default();
        let straight = |q: Quat| if self.reversed { inverse(q) } else { q };
        let device = match (self.mode, turn) {
            (Mode::Angles | Mode::PositionAngles, &[z, y, x, ..]) => {
                let [z, y, x] = [z, y, x].map(|part| part * self.half_turn);
                Some(axes::from_euler_degrees(z, y, x)?)
            }
            (Mode::Quaternion | Mode::PositionQuaternion, &[w, x, y, z, ..]) => {
                Some(straight(valid::sent_rotation(Quat::from_xyzw(x, y, z, w))?))
            }
            (Mode::Matrix | Mode::PositionMatrix, &[xx, xy, xz, yx, yy, yz, zx, zy, zz, ..]) => {
                let columns = [
                    Vec3::new(xx, yx, zx),
                    Vec3::new(xy, yy, zy),
                    Vec3::new(xz, yz, zz),
                ];
                Some(straight(axes::from_columns(columns)?))
            }
            _ => None,
        };
        Ok(Head {
            position,
            orientation: device.map(|q| Reading::tracked(self.axes.orientation(q))),
            angular_velocity: None,
        })
    }

    /// Returns the record that a device sends of a sample: bird 1's of sensor 0. What it lacks is
    /// the origin and no rotation; what is out of range stops at its end.
    pub fn encode(&self, sample: &Sample) -> Vec<u8, MOST_RECORD_BYTES> {
        let metres = sample.head.position.map_or(Vec3::ZERO, |p| p.value);
        let position = self.axes.device_position(metres) / self.range.metres();
        let rotation = sample.head.orientation.map_or(Quat::IDENTITY, |q| q.value);
        let rotation = self.axes.device_orientation(rotation);
        let reverse = if self.reversed {
            inverse(rotation)
        } else {
            rotation
        };
        let mut parts: Vec<f32, MOST_WORDS> = Vec::new();
        if self.mode.has_position() {
            let _ = parts.extend_from_slice(&position.to_array());
        }
        let _ = match self.mode {
            Mode::Position => Ok(()),
            Mode::Angles | Mode::PositionAngles => {
                parts.extend_from_slice(&axes::euler_degrees(rotation).map(|a| a / self.half_turn))
            }
            Mode::Quaternion | Mode::PositionQuaternion => {
                parts.extend_from_slice(&[reverse.w, reverse.x, reverse.y, reverse.z])
            }
            Mode::Matrix | Mode::PositionMatrix => {
                let [x, y, z] = axes::columns(reverse);
                parts.extend_from_slice(&[x.x, y.x, z.x, x.y, y.y, z.y, x.z, y.z, z.z])
            }
        };
        let mut record = Vec::new();
        for &part in &parts {
            let _ = record.extend_from_slice(&to_seven_bits(nearest_word(part)));
        }
        if self.group {
            let _ = record.push(sample.sensor.min(HIGHEST_ADDRESS - 1) + 1);
        }
        if let Some(first) = record.first_mut() {
            *first |= PHASE;
        }
        record
    }
}

/// Returns a record's words; those that it does not have are 0.
fn words(record: &[u8]) -> [i16; MOST_WORDS] {
    let mut words = [0; MOST_WORDS];
    for (word, &[low, high]) in words.iter_mut().zip(record.as_chunks().0) {
        *word = from_seven_bits(low, high);
    }
    words
}

/// Decodes the records of one line.
#[derive(Debug, Clone)]
pub struct Flock {
    stream: Stream<{ MOST_RECORD_BYTES + 1 }>,
    config: Config,
    /// A parameter that was asked for, and when.
    asked: Option<(u8, Micros)>,
    /// Whether the newest bytes since that question belong to no record.
    noisy: bool,
}

impl Flock {
    /// Returns a decoder of a device that is set up this way.
    pub fn new(config: Config) -> Self {
        Self {
            stream: Stream::default(),
            config,
            asked: None,
            noisy: false,
        }
    }
}

impl Decoder for Flock {
    fn feed(&mut self, bytes: &[u8], arrival: Micros, sink: &mut dyn FnMut(Event)) {
        let Self {
            stream,
            config,
            asked,
            noisy,
        } = self;
        *asked = asked.filter(|&(_, at)| arrival.since(at) <= PATIENCE);
        stream.feed(bytes, arrival, sink, |window| {
            let awaited = asked.and_then(|(parameter, _)| answer(parameter, window, !*noisy));
            if let Some(step) = awaited {
                if step != Step::More {
                    *asked = None;
                }
                return step;
            }
            let step = config.step(window);
            if !matches!(step, Step::More | Step::Wait) {
                *noisy = matches!(step, Step::Skip(_));
            }
            step
        });
    }

    fn counts(&self) -> &Counts {
        &self.stream.counts
    }

    fn reset(&mut self) {
        self.stream.reset();
        (self.asked, self.noisy) = (None, false);
    }

    /// The last question counts.
    fn on_sent(&mut self, command: &[u8], now: Micros) {
        let mut rest = command;
        while let Some(&first) = rest.first() {
            if let [EXAMINE, parameter, ..] = *rest {
                (self.asked, self.noisy) = (Some((parameter, now)), false);
            }
            rest = rest.get(command_bytes(first)..).unwrap_or_default();
        }
    }
}

impl Config {
    fn step(&self, window: Window<'_>) -> Step {
        let bytes = window.bytes;
        let Some((&first, rest)) = bytes.split_first() else {
            return Step::More;
        };
        if first & PHASE == 0 {
            return Step::Skip(DropReason::OutOfStep);
        }
        let length = self.record_bytes();
        let inside = rest.get(..length - 1).unwrap_or(rest);
        if let Some(next) = inside.iter().position(|byte| byte & PHASE != 0) {
            return Step::Discard(next + 1, DropReason::Truncated);
        }
        let Some(record) = bytes.get(..length) else {
            return Step::More;
        };
        match bytes.get(length) {
            None if self.confirm => return Step::Wait,
            Some(next) if self.confirm && next & PHASE == 0 => {
                return Step::Discard(length, DropReason::Length);
            }
            _ => {}
        }
        // The record's ends are certain.
        let unusable = |reason| Step::Discard(length, reason);
        let sensor = match record.get(2 * self.mode.words()) {
            None => 0,
            Some(address @ 1..=HIGHEST_ADDRESS) => address - 1,
            Some(_) => return unusable(DropReason::Field),
        };
        match self.head(words(record)) {
            Err(reason) => unusable(reason),
            Ok(head) => {
                let sample = Sample {
                    sensor,
                    head,
                    ..Sample::arrived(window.arrival)
                };
                Step::Take(length, None, Event::Sample(sample))
            }
        }
    }
}

#[cfg(test)]
mod tests;
