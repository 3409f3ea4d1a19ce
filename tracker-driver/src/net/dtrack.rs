//! ART `DTrack`: bodies and Flysticks, in lines of text.
//!
//! A datagram is one frame, to a UDP port that is set at the controller; 5000 is usual. Nothing
//! has to be sent. Lines end with CR, LF or both; the first is `fr`, the others come in any order:
//!
//! | Line | Content |
//! |---|---|
//! | `fr <u32>` | count of the frames |
//! | `ts <s>` | seconds since midnight, UTC |
//! | `ts2 <s> <µs> <µs>` | UTC since 1970; from the measurement until it was sent |
//! | `6d <n>` | n × `[id quality][x y z and angles][matrix]` |
//! | `6df <n>` | n × `[id quality buttons][x y z and angles][matrix]` |
//! | `6df2 <n> <n>` | n × `[id quality buttons axes][x y z][matrix][buttons' bits, axes]` |
//!
//! Other lines are skipped. Lengths are in millimetres; the matrix has the body's axes in the
//! room as its columns, one column after the other.
//!
//! A body is a sample's sensor by its id, a Flystick by its id and [`FIRST_FLYSTICK`]. A body
//! that is not tracked is absent from its frame, and a Flystick's quality is −1: a sensor that was
//! there before then gets a sample without a head. Buttons and axes are handed over when they
//! change. The hat of `6df` becomes the axes 0, +1 to the left, and 1, +1 up, as in `6df2`.
//!
//! # Axes
//!
//! Those of the room's calibration: with "powerwall" +Y points up, with "normal" +Z does.
//! [`Config::axes`] takes them, and the body's, to ours.
//!
//! # How strong the check is
//!
//! Only that of UDP: a changed digit leaves a valid number. A matrix must be a rotation within
//! 1 %, which leaves few changed digits of it.

use super::{Numbers, count_bytes};
use crate::decoder::{Control, ControlState, Counts, Decoder, DropReason, Event, Message};
use crate::head::axes::{Axes, columns, from_columns};
use crate::sample::{Reading, Sample};
use crate::time::{DeviceTime, Micros};
use crate::valid;
use core::fmt;
use core::str::FromStr;
use glam::{Quat, Vec3};
use heapless::Vec;

/// The usual UDP port.
pub const PORT: u16 = 5_000;
/// Most bytes of a datagram.
pub const LONGEST_DATAGRAM: usize = 8_192;
/// Number of bodies.
pub const BODIES: u8 = 32;
/// The sensor of the first Flystick.
pub const FIRST_FLYSTICK: u8 = BODIES;
/// Number of Flysticks.
pub const FLYSTICKS: u8 = 4;
/// Number of a Flystick's buttons.
const BUTTONS: u32 = 16;
/// Number of a Flystick's axes.
const AXES: usize = 8;
/// The time of day is back at zero after so many microseconds.
const DAY: u64 = 86_400_000_000;

/// How a controller is read.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Config {
    /// The room's axes, and the bodies'.
    pub axes: Axes,
}

impl Default for Config {
    fn default() -> Self {
        Self { axes: Axes::SAME }
    }
}

/// The values of a whole frame.
#[derive(Debug, Clone, Copy, Default)]
struct Frame {
    number: u32,
    time: Option<DeviceTime>,
    latency: Option<Micros>,
}

/// A body or a Flystick in a frame.
struct Target {
    sensor: u8,
    /// The position in metres and the rotation, in the room's axes; `None`: not tracked.
    pose: Option<(Vec3, Quat)>,
    /// A Flystick's controls.
    hand: Option<Hand>,
}

/// The controls of a Flystick.
#[derive(Debug, Clone, Default)]
struct Hand {
    buttons: u32,
    /// Number of those bits.
    count: u8,
    axes: Vec<f32, AXES>,
}

impl Hand {
    /// Returns the controls that are another way than `before`, by number.
    fn changes(&self, before: &Self) -> impl Iterator<Item = (u8, ControlState)> {
        let other = self.buttons ^ before.buttons;
        let count = before.count;
        let button = move |n| (n >= count || other >> n & 1 != 0).then_some(n);
        let buttons = (0..self.count).filter_map(button);
        let buttons = buttons.map(|n| (n, ControlState::Button(self.buttons >> n & 1 != 0)));
        let mut old = before.axes.clone().into_iter();
        let axes = (0..).zip(self.axes.iter().copied());
        let axes = axes.filter(move |(_, value)| old.next() != Some(*value));
        buttons.chain(axes.map(|(n, value)| (n, ControlState::Axis(value))))
    }
}

/// Decodes the datagrams of one controller.
#[derive(Debug, Clone, Default)]
pub struct DTrack {
    config: Config,
    counts: Counts,
    numbers: Numbers,
    latency: Option<Micros>,
    /// A bit for each sensor that was there.
    known: u64,
    hands: [Hand; FLYSTICKS as usize],
}

impl DTrack {
    /// Returns a decoder of a controller whose room has these axes.
    pub fn new(config: Config) -> Self {
        Self {
            config,
            ..Self::default()
        }
    }

    /// Returns the time from the measurement until the newest frame was sent, where it says so.
    pub const fn latency(&self) -> Option<Micros> {
        self.latency
    }

    /// Reads a datagram whole, and counts its frame.
    fn check<'a>(&mut self, bytes: &'a [u8]) -> Result<(&'a str, Frame), DropReason> {
        if bytes.len() > LONGEST_DATAGRAM {
            return Err(DropReason::Length);
        }
        let text = core::str::from_utf8(bytes).map_err(|_| DropReason::Field)?;
        let frame = read(text, &mut |_| {})?;
        if self.numbers.is_new(frame.number, &mut self.counts) {
            Ok((text, frame))
        } else {
            Err(DropReason::Duplicate)
        }
    }
}

impl Decoder for DTrack {
    /// Takes one whole datagram.
    fn feed(&mut self, bytes: &[u8], arrival: Micros, sink: &mut dyn FnMut(Event)) {
        count_bytes(&mut self.counts, bytes);
        let checked = self.check(bytes);
        let mut noted = |event: Event| {
            self.counts.note(&event);
            sink(event);
        };
        let (text, frame) = match checked {
            Ok(checked) => checked,
            Err(reason) => return noted(Event::dropped(bytes.len() as u32, reason)),
        };
        self.latency = frame.latency;
        let sample = Sample {
            device_time: frame.time,
            sequence: Some(frame.number),
            ..Sample::arrived(arrival)
        };
        let axes = &self.config.axes;
        let mut there = 0;
        let _ = read(text, &mut |target: Target| {
            let sensor = target.sensor;
            if there >> sensor & 1 != 0 {
                // The first of two lines counts.
                return;
            }
            there |= 1 << sensor;
            let mut sample = Sample { sensor, ..sample };
            if let Some((position, orientation)) = target.pose {
                sample.head.position = Some(Reading::tracked(axes.position(position)));
                sample.head.orientation = Some(Reading::tracked(axes.orientation(orientation)));
            }
            noted(Event::Sample(sample));
            let place = usize::from(sensor.wrapping_sub(FIRST_FLYSTICK));
            if let (Some(hand), Some(before)) = (target.hand, self.hands.get_mut(place)) {
                for (number, state) in hand.changes(before) {
                    noted(Event::Message(Message::Control(Control {
                        sensor,
                        number,
                        state,
                        device_time: frame.time,
                    })));
                }
                *before = hand;
            }
        });
        for sensor in 0..BODIES + FLYSTICKS {
            if (self.known & !there) >> sensor & 1 != 0 {
                noted(Event::Sample(Sample { sensor, ..sample }));
            }
        }
        self.known |= there;
    }

    fn counts(&self) -> &Counts {
        &self.counts
    }

    fn reset(&mut self) {
        let counts = self.counts;
        *self = Self::new(self.config);
        self.counts = counts;
    }
}

/// A body's number and its pose in our axes.
pub type Body = (u8, Vec3, Quat);

/// Writes a frame of bodies that were measured at a time since 1970.
///
/// # Errors
/// Those of `to`.
pub fn encode(to: &mut impl fmt::Write, number: u32, time: Micros, bodies: &[Body]) -> fmt::Result {
    let (seconds, micros) = (time.0 % DAY / 1_000_000, time.0 % 1_000_000);
    let count = bodies.len();
    write!(
        to,
        "fr {number}\r\nts {seconds}.{micros:06}\r\n6dcal {count}\r\n6d {count}"
    )?;
    for (id, place, turn) in bodies {
        let [x, y, z] = columns(*turn);
        let place = *place * 1e3;
        let cos = libm::sqrtf(x.x * x.x + y.x * y.x);
        let angles = [
            libm::atan2f(-z.y, z.z),
            libm::atan2f(z.x, cos),
            libm::atan2f(-y.x, x.x),
        ];
        write!(
            to,
            " [{id} 1.000][{:.3} {:.3} {:.3}",
            place.x, place.y, place.z
        )?;
        for angle in angles {
            write!(to, " {:.4}", angle.to_degrees())?;
        }
        to.write_str("]")?;
        let numbers = [x, y, z].map(|column| column.to_array());
        let numbers = numbers.as_flattened().iter();
        for (before, number) in core::iter::once("[")
            .chain(core::iter::repeat(" "))
            .zip(numbers)
        {
            write!(to, "{before}{number:.6}")?;
        }
        to.write_str("]")?;
    }
    to.write_str("\r\n")
}

/// Reads a frame's lines and hands its targets to `sink`.
fn read(text: &str, sink: &mut dyn FnMut(Target)) -> Result<Frame, DropReason> {
    let mut lines = text.split(['\r', '\n']).filter(|line| !line.is_empty());
    let first = lines.next().and_then(|line| line.strip_prefix("fr "));
    let mut frame = Frame {
        number: parse(first.ok_or(DropReason::Unknown)?)?,
        ..Frame::default()
    };
    for line in lines {
        let (key, rest) = line.split_once(' ').unwrap_or((line, ""));
        let mut line = Line(rest);
        match key {
            "ts" if frame.latency.is_none() => {
                let seconds: f64 = parse(line.word())?;
                let microseconds = (seconds * 1e6 + 0.5) as u64;
                if !(seconds >= 0.0 && microseconds < DAY) {
                    return Err(DropReason::Field);
                }
                frame.time = Some(DeviceTime {
                    microseconds,
                    wraps_at: DAY,
                });
            }
            "ts2" => {
                let mut word = || parse::<u32>(line.word()).map(u64::from);
                let (seconds, microseconds, latency) = (word()?, word()?, word()?);
                let time = DeviceTime::unwrapped(seconds * 1_000_000 + microseconds);
                frame.time = Some(time);
                frame.latency = Some(Micros(latency));
            }
            "6d" => {
                for _ in 0..line.count(BODIES)? {
                    let head = line.block::<2>()?;
                    sink(line.target(&head, 0, BODIES)?);
                }
            }
            "6df" => {
                for _ in 0..line.count(FLYSTICKS)? {
                    let head = line.block::<3>()?;
                    let target = line.target(&head, FIRST_FLYSTICK, FLYSTICKS)?;
                    let buttons = whole(head.get(2), 0xFF)?;
                    let bit = |bit: u32| f32::from((buttons >> bit & 1) as u8);
                    let axes = [bit(5) - bit(7), bit(6) - bit(4)];
                    let hand = Hand {
                        buttons: buttons & 0xF,
                        count: 4,
                        axes: axes.into_iter().collect(),
                    };
                    sink(Target {
                        hand: Some(hand),
                        ..target
                    });
                }
            }
            "6df2" => {
                let _calibrated: u32 = parse(line.word())?;
                for _ in 0..line.count(FLYSTICKS)? {
                    let head = line.block::<4>()?;
                    let target = line.target(&head, FIRST_FLYSTICK, FLYSTICKS)?;
                    let count = whole(head.get(2), BUTTONS)?;
                    let axes = whole(head.get(3), AXES as u32)? as usize;
                    let values = line.block::<{ 1 + AXES }>()?;
                    let (bits, values) = values.split_at(usize::from(count > 0).min(values.len()));
                    let hand = Hand {
                        buttons: bits
                            .first()
                            .map_or(Ok(0), |bits| whole(Some(bits), 0xFFFF))?,
                        count: count as u8,
                        axes: values.iter().copied().take(axes).collect(),
                    };
                    if hand.axes.len() != axes || bits.is_empty() != (count == 0) {
                        return Err(DropReason::Length);
                    }
                    sink(Target {
                        hand: Some(hand),
                        ..target
                    });
                }
            }
            _ => {}
        }
    }
    Ok(frame)
}

/// The rest of a line.
struct Line<'a>(&'a str);

impl<'a> Line<'a> {
    /// Takes what comes before the next blank.
    fn word(&mut self) -> &'a str {
        let (word, rest) = self.0.split_once(' ').unwrap_or((self.0, ""));
        self.0 = rest;
        word
    }

    /// Takes a number of targets.
    fn count(&mut self, most: u8) -> Result<u8, DropReason> {
        let count: u8 = parse(self.word())?;
        (count <= most).then_some(count).ok_or(DropReason::Field)
    }

    /// Takes a block of numbers in brackets; those behind the first `N` are only checked.
    fn block<const N: usize>(&mut self) -> Result<Vec<f32, N>, DropReason> {
        let begun = self.0.trim_start().strip_prefix('[');
        let (inside, behind) = begun
            .and_then(|begun| begun.split_once(']'))
            .ok_or(DropReason::Length)?;
        self.0 = behind;
        let mut numbers = Vec::new();
        for word in inside.split_ascii_whitespace() {
            let _ = numbers.push(valid::within(parse(word)?, f32::MAX)?);
        }
        Ok(numbers)
    }

    /// Takes a target's position and matrix, behind its first block `head`.
    fn target(&mut self, head: &[f32], first: u8, sensors: u8) -> Result<Target, DropReason> {
        let sensor = first + whole(head.first(), u32::from(sensors) - 1)? as u8;
        let is_tracked = *head.get(1).ok_or(DropReason::Length)? >= 0.0;
        let (place, matrix) = (self.block::<3>()?, self.block::<9>()?);
        let place: [f32; 3] = place.into_array().map_err(|_| DropReason::Length)?;
        let matrix: [f32; 9] = matrix.into_array().map_err(|_| DropReason::Length)?;
        let position = valid::position(Vec3::from_array(place) * 1e-3)?;
        let [xx, xy, xz, yx, yy, yz, zx, zy, zz] = matrix;
        let columns = [[xx, xy, xz], [yx, yy, yz], [zx, zy, zz]].map(Vec3::from_array);
        let pose = is_tracked.then(|| Ok((position, from_columns(columns)?)));
        Ok(Target {
            sensor,
            pose: pose.transpose()?,
            hand: None,
        })
    }
}

/// Returns a number's text as a number.
fn parse<T: FromStr>(text: &str) -> Result<T, DropReason> {
    text.trim_ascii().parse().map_err(|_| DropReason::Field)
}

/// Returns a whole number, up to `most`.
fn whole(number: Option<&f32>, most: u32) -> Result<u32, DropReason> {
    let number = *number.ok_or(DropReason::Length)?;
    let rounded = number as u32;
    (rounded as f32 == number && rounded <= most)
        .then_some(rounded)
        .ok_or(DropReason::Field)
}

#[cfg(test)]
mod tests;
