//! ASL EYE-TRAC 5000 and 6000 eye trackers that stream on a serial line,
//! 57,600 baud, 8N1.
//!
//! # Wire format
//!
//! From `asl.c`, the reader that `dotsReadableEyeASL` of the Gold lab's
//! snow-dots uses. The fields of a frame:
//!
//! | Field | Bytes |
//! |---|---|
//! | status | 1: 0x80 |
//! | frame number, where [`Layout::Numbered`] | 2, upper first; wraps at 65,536 |
//! | pupil diameter | 2, upper first, two's complement |
//! | nothing | 1: 0 |
//! | horizontal gaze | 2, upper first, two's complement |
//! | vertical gaze | 2, upper first, two's complement |
//!
//! Only a frame's first byte has its top bit set. The others' top bits are
//! collected: after every seven bytes of fields, and after the last one, comes
//! a byte whose bit i is the top bit of the ith of them. A frame is 12 bytes,
//! or 10 without the frame number. There is no time and no checksum.
//!
//! # How far the decoder can be trusted
//!
//! A frame begins where its top bit says, so a fault costs the frames that it touches and no
//! other. Checked are the top bits, the byte that is nothing, the bits of the last byte that
//! stand for no field, and that a frame out of step is followed by another: it is handed over
//! with that one's first byte, and has the time of its own last. Random bytes pass for a frame
//! of 12 with a probability of 2⁻³⁹ at each byte, and once in 866 bytes of a line that is read at
//! another speed. A changed byte that stays below 0x80 is mostly not noticed.

use super::numbers;
use crate::command::{Awaited, PATIENCE, Script};
use crate::decoder::{Counts, Decoder, DropReason, Event};
use crate::sample::{Eye, GazePoint, Pupil, Reading, Sample};
use crate::stream::{Step, Stream, Window};
use crate::time::Micros;
use glam::Vec2;
use heapless::Vec;

/// Returns what waits for the device's stream: it sends without being asked, and has
/// no command to stop it.
pub fn start() -> Script {
    let mut script = Script::new();
    script.expect(Awaited::Sample, PATIENCE);
    script
}

/// The speed of the line.
pub const BAUD: u32 = 57_600;

/// Most bytes of a frame.
pub const LONGEST_FRAME: usize = 12;

/// The status byte of every frame.
const STATUS: u8 = 0x80;
const TOP_BIT: u8 = 0x80;

/// How many bytes of fields share one byte of top bits.
const GROUP: usize = 7;

/// More frames than this cannot be missing: the count began anew.
const LARGEST_GAP: u32 = 1_000;

/// Which fields a frame has.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Layout {
    /// Without the frame number: 10 bytes.
    Base,
    /// With the frame number: 12 bytes.
    #[default]
    Numbered,
}

impl Layout {
    /// Returns bytes of a frame.
    pub const fn frame_length(self) -> usize {
        match self {
            Self::Base => 10,
            Self::Numbered => LONGEST_FRAME,
        }
    }

    /// Returns bytes of a frame's fields.
    const fn fields_length(self) -> usize {
        self.frame_length() - 2
    }
}

/// What the stream cannot tell of itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Config {
    /// Which fields the device sends.
    pub layout: Layout,
    /// A pupil of 0 means that the eye was not found: a guess, no eye has such a pupil.
    pub zero_is_lost: bool,
}

impl Default for Config {
    fn default() -> Self {
        Self {
            layout: Layout::default(),
            zero_is_lost: true,
        }
    }
}

/// The decoder: one eye as [`Sample::combined`], gaze and pupil in the device's own units.
#[derive(Debug, Clone, Default)]
pub struct Asl {
    config: Config,
    /// A frame, and the byte behind it.
    stream: Stream<{ LONGEST_FRAME + 1 }>,
}

impl Asl {
    /// Returns a decoder for a device that is set up like this.
    pub fn new(config: Config) -> Self {
        Self {
            config,
            ..Self::default()
        }
    }
}

impl Decoder for Asl {
    fn feed(&mut self, bytes: &[u8], arrival: Micros, sink: &mut dyn FnMut(Event)) {
        let config = self.config;
        let numbers = [1 << 16, LARGEST_GAP];
        let step = |window: Window<'_>| step(config, window);
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

fn step(config: Config, window: Window<'_>) -> Step {
    let [STATUS, rest @ ..] = window.bytes else {
        return Step::Skip(DropReason::OutOfStep);
    };
    let length = config.layout.frame_length();
    if rest
        .iter()
        .take(length - 1)
        .any(|&byte| byte & TOP_BIT != 0)
    {
        return window.broken_off();
    }
    let Some(frame) = window.bytes.get(..length) else {
        return Step::More;
    };
    match window.bytes.get(length) {
        None if !window.in_step => return Step::Wait,
        Some(&next) if next != STATUS => return Step::Skip(DropReason::Length),
        _ => (),
    }
    let fields = fields(frame, config.layout);
    match fields.and_then(|fields| sample(config, &fields, window.arrival)) {
        Ok(sample) => Step::Take(length, None, Event::Sample(sample)),
        Err(reason) => Step::Skip(reason),
    }
}

/// Returns the fields' bytes with their top bits.
fn fields(frame: &[u8], layout: Layout) -> Result<[u8; LONGEST_FRAME - 2], DropReason> {
    let mut fields = [0; LONGEST_FRAME - 2];
    let groups = frame.chunks(GROUP + 1).zip(fields.chunks_mut(GROUP));
    for (group, fields) in groups {
        let Some((&top_bits, bytes)) = group.split_last() else {
            continue;
        };
        if bytes.len() < GROUP && top_bits >> bytes.len() != 0 {
            return Err(DropReason::Field);
        }
        for (i, (field, &byte)) in fields.iter_mut().zip(bytes).enumerate() {
            *field = byte | ((top_bits >> i) & 1) << 7;
        }
    }
    // Before the four bytes of the gaze, in either layout.
    match fields.get(layout.fields_length() - 5) {
        Some(0) => Ok(fields),
        _ => Err(DropReason::Field),
    }
}

fn sample(
    config: Config,
    fields: &[u8; LONGEST_FRAME - 2],
    arrival: Micros,
) -> Result<Sample, DropReason> {
    let (number, values) = match (config.layout, *fields) {
        (Layout::Numbered, [_, n1, n0, p1, p0, _, h1, h0, v1, v0]) => {
            let number = u32::from(u16::from_be_bytes([n1, n0]));
            (Some(number), [[p1, p0], [h1, h0], [v1, v0]])
        }
        (Layout::Base, [_, p1, p0, _, h1, h0, v1, v0, _, _]) => {
            (None, [[p1, p0], [h1, h0], [v1, v0]])
        }
    };
    let [pupil, horizontal, vertical] = values.map(|value| f32::from(i16::from_be_bytes(value)));
    if pupil < 0.0 {
        return Err(DropReason::OutOfRange);
    }
    let found = pupil > 0.0 || !config.zero_is_lost;
    let point = Reading {
        value: GazePoint::Raw(Vec2::new(horizontal, vertical)),
        tracked: found,
    };
    Ok(Sample {
        sequence: number,
        combined: Eye {
            pupil: (pupil > 0.0).then_some(Pupil::Raw(pupil)),
            ..Eye::default()
        },
        gaze_point: Some(point),
        ..Sample::arrived(arrival)
    })
}

/// Returns the frame that a device sends for a sample: zero for what it lacks, rounded, within 16
/// bits.
pub fn encode(sample: &Sample, layout: Layout) -> Vec<u8, LONGEST_FRAME> {
    let (gaze, pupil) = numbers(sample);
    let [[p1, p0], [h1, h0], [v1, v0]] =
        [pupil.max(0.0), gaze.x, gaze.y].map(|value| (libm::roundf(value) as i16).to_be_bytes());
    let [n1, n0] = (sample.sequence.unwrap_or(0) as u16).to_be_bytes();
    let numbered = [STATUS, n1, n0, p1, p0, 0, h1, h0, v1, v0];
    let base = [STATUS, p1, p0, 0, h1, h0, v1, v0];
    let fields: &[u8] = match layout {
        Layout::Numbered => &numbered,
        Layout::Base => &base,
    };
    let mut frame = Vec::new();
    for (i, group) in fields.chunks(GROUP).enumerate() {
        let mut top_bits = 0;
        for (j, &byte) in group.iter().enumerate() {
            // The first byte of all keeps its own.
            let first = i == 0 && j == 0;
            top_bits |= if first { 0 } else { (byte >> 7) << j };
            // The vector holds the longest frame.
            let _ = frame.push(if first { byte } else { byte & !TOP_BIT });
        }
        let _ = frame.push(top_bits);
    }
    frame
}

#[cfg(test)]
mod tests;
