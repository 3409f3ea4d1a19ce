//! ISCAN eye trackers on a serial line, 115,200 baud, 8N1.
//!
//! # Wire format
//!
//! From the `MWorks` driver (`plugins/core/ISCAN/ISCAN/ISCANDevice.cpp` in
//! mworks/mworks). The host sends 0x80 to start or 0x81 to stop; the device
//! streams little-endian words of 16 bits:
//!
//! | Word | Content |
//! |---|---|
//! | 0 | 0x4444 |
//! | 1 to 6 | the outputs chosen on the device, each in tenths of its unit |
//!
//! There is no length, no checksum and no time. A record ends where the next
//! one begins; which outputs are chosen is set up on the device, and told to
//! the decoder as [`Outputs`].
//!
//! # How far the decoder can be trusted
//!
//! A record right after another is handed over with its last byte: waiting for the next header
//! would cost a sample period. A record after anything else waits for it, and with
//! [`Config::confirm`] every record does; then a damaged header costs the record before it too.
//! A header cannot stand inside a record: words above [`Config::largest_word`] are refused, and
//! none can be set that would let 0x44 be a word's upper byte. Random bytes look like a record
//! of 5 outputs, header and next header, with a probability of 3 · 10⁻¹³ at each byte. A byte that
//! was dropped is always noticed; one that was inserted or changed only where a word becomes too
//! large.

use super::numbers;
use crate::command::{Awaited, PATIENCE, Script};
use crate::decoder::{Counts, Decoder, DropReason, Event};
use crate::sample::{Eye, GazePoint, Pupil, Reading, Sample};
use crate::stream::{Step, Stream, Window};
use crate::time::Micros;
use glam::Vec2;
use heapless::Vec;

pub(crate) const START: [u8; 1] = [0x80];
pub(crate) const STOP: [u8; 1] = [0x81];

/// Makes the device stream.
pub fn start() -> Script {
    let mut script = Script::sending(&START);
    script.expect(Awaited::Sample, PATIENCE);
    script
}

/// Makes it stop.
pub fn stop() -> Script {
    Script::sending(&STOP)
}

/// The speed of the line.
pub const BAUD: u32 = 115_200;

/// Most outputs of a record.
pub const MOST_OUTPUTS: usize = 6;

/// Most bytes of a record.
pub const LONGEST_RECORD: usize = 2 + 2 * MOST_OUTPUTS;

const HEADER: u8 = 0x44;

/// The largest word whose upper byte cannot be taken for half a header.
const LARGEST_WORD: u16 = 0x43FF;

/// A word counts tenths.
const TENTHS: f32 = 10.0;

/// One of the words of a record.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Output {
    /// Where the pupil is in the eye camera's picture, to the right.
    PupilHorizontal,
    /// Where the pupil is in the eye camera's picture, down.
    PupilVertical,
    /// The pupil's diameter in the eye camera's picture.
    PupilDiameter,
    /// The point of regard, to the right.
    GazeHorizontal,
    /// The point of regard, down.
    GazeVertical,
    /// Anything else; it is passed over.
    Other,
}

/// The outputs that were chosen on the device, in the order of the record.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Outputs {
    outputs: [Output; MOST_OUTPUTS],
    count: usize,
}

impl Outputs {
    /// Returns a configuration with these outputs.
    ///
    /// # Errors
    /// Where there are none or more than [`MOST_OUTPUTS`].
    pub fn new(outputs: &[Output]) -> Result<Self, OutputsError> {
        let found = outputs.len();
        if !(1..=MOST_OUTPUTS).contains(&found) {
            return Err(OutputsError { found });
        }
        let mut chosen = [Output::Other; MOST_OUTPUTS];
        for (to, from) in chosen.iter_mut().zip(outputs) {
            *to = *from;
        }
        Ok(Self {
            outputs: chosen,
            count: found,
        })
    }

    /// Returns the outputs.
    pub fn as_slice(&self) -> &[Output] {
        self.outputs.get(..self.count).unwrap_or_default()
    }

    /// Returns bytes of a record.
    pub const fn record_length(&self) -> usize {
        2 + 2 * self.count
    }
}

impl Default for Outputs {
    /// Returns the pupil's place and diameter and the point of regard.
    fn default() -> Self {
        Self {
            outputs: [
                Output::PupilHorizontal,
                Output::PupilVertical,
                Output::PupilDiameter,
                Output::GazeHorizontal,
                Output::GazeVertical,
                Output::Other,
            ],
            count: 5,
        }
    }
}

/// A record cannot have this many outputs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[error("{found} ISCAN outputs: list those that are chosen on the device, 1 to {MOST_OUTPUTS}")]
pub struct OutputsError {
    /// How many were given.
    pub found: usize,
}

/// What the stream cannot tell of itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Config {
    /// The words of a record.
    pub outputs: Outputs,
    /// Larger words, in tenths, are damage; at most 0x43FF (1740.7).
    pub largest_word: u16,
    /// Hand a record over only once the next header has come; a damaged one costs it.
    pub confirm: bool,
    /// A point of regard or a pupil at 0, 0 means that the eye was not found: a guess.
    pub zero_is_lost: bool,
}

impl Default for Config {
    fn default() -> Self {
        Self {
            outputs: Outputs::default(),
            largest_word: LARGEST_WORD,
            confirm: false,
            zero_is_lost: true,
        }
    }
}

impl Config {
    fn limit(&self) -> u16 {
        self.largest_word.min(LARGEST_WORD)
    }
}

/// The decoder: one eye as [`Sample::combined`]. The gaze is the point of regard, or the
/// pupil's place where that is no output; both need a calibration.
#[derive(Debug, Clone, Default)]
pub struct Iscan {
    config: Config,
    stream: Stream<{ LONGEST_RECORD + 2 }>,
    spacing: HeaderSpacing,
}

/// Counts the outputs between headers: the device may send another number than is configured.
#[derive(Debug, Clone, Copy, Default)]
struct HeaderSpacing {
    /// Bytes that were dropped from the last header on.
    skipped: Option<u8>,
    /// Outputs between the last two headers.
    outputs: Option<u8>,
}

impl HeaderSpacing {
    /// Takes note of the step that followed from these bytes.
    fn note(&mut self, window: &[u8], step: &Step) {
        match step {
            Step::Skip(_) => {
                // Fewer than four bytes after a header, these are part of it or of its first word.
                let is_header = self.skipped.is_none_or(|bytes| bytes >= 4);
                self.skipped = if is_header && window.starts_with(&[HEADER; 2]) {
                    let words = self.skipped.and_then(|bytes| bytes.checked_sub(2));
                    let words = words.filter(|bytes| bytes.is_multiple_of(2));
                    let outputs = words.map(|bytes| bytes / 2);
                    let possible = |count: &u8| (1..=MOST_OUTPUTS as u8).contains(count);
                    self.outputs = outputs.filter(possible).or(self.outputs);
                    Some(1)
                } else {
                    self.skipped.and_then(|bytes| bytes.checked_add(1))
                };
            }
            Step::More | Step::Wait => {}
            Step::Take(..) | Step::Discard(..) => *self = Self::default(),
        }
    }
}

impl Iscan {
    /// Returns a decoder for a device with these settings.
    pub fn new(config: Config) -> Self {
        Self {
            config,
            ..Self::default()
        }
    }
}

impl Decoder for Iscan {
    fn feed(&mut self, bytes: &[u8], arrival: Micros, sink: &mut dyn FnMut(Event)) {
        let (config, spacing) = (&self.config, &mut self.spacing);
        self.stream.feed(bytes, arrival, sink, |window| {
            let step = step(config, window);
            spacing.note(window.bytes, &step);
            step
        });
    }

    fn counts(&self) -> &Counts {
        &self.stream.counts
    }

    fn reset(&mut self) {
        self.stream.reset();
        self.spacing = HeaderSpacing::default();
    }

    /// Returns the number of outputs between the last two headers, while no record can be read.
    fn fields_seen(&self) -> Option<usize> {
        self.spacing.outputs.map(usize::from)
    }
}

fn step(config: &Config, window: Window<'_>) -> Step {
    let words = match window.bytes {
        [HEADER] => return Step::More,
        [HEADER, HEADER, words @ ..] => words,
        _ => return Step::Skip(DropReason::OutOfStep),
    };
    let length = config.outputs.record_length();
    let (words, behind) = words
        .split_at_checked(length - 2)
        .unwrap_or((words, &[] as &[u8]));
    for word in words.chunks_exact(2) {
        if word == [HEADER; 2] {
            return Step::Skip(DropReason::Truncated);
        }
        if word_at(word) > config.limit() {
            return Step::Skip(DropReason::Field);
        }
    }
    if words.len() < length - 2 {
        return Step::More;
    }
    match behind {
        [] if window.in_step && !config.confirm => (),
        [] | [HEADER] => return Step::Wait,
        [HEADER, HEADER, ..] => (),
        _ => return Step::Skip(DropReason::Length),
    }
    let sample = sample(config, words, window.arrival);
    Step::Take(length, None, Event::Sample(sample))
}

fn word_at(bytes: &[u8]) -> u16 {
    bytes.first_chunk().map_or(0, |b| u16::from_le_bytes(*b))
}

fn sample(config: &Config, words: &[u8], arrival: Micros) -> Sample {
    let value = |output: Output| {
        let index = config.outputs.as_slice().iter().position(|&o| o == output);
        let word = words.chunks_exact(2).nth(index?)?;
        Some(f32::from(word_at(word)) / TENTHS)
    };
    let point = |horizontal, vertical| {
        let point = Vec2::new(value(horizontal)?, value(vertical)?);
        Some((point, config.zero_is_lost && point == Vec2::ZERO))
    };
    let gaze = point(Output::GazeHorizontal, Output::GazeVertical);
    let pupil = point(Output::PupilHorizontal, Output::PupilVertical);
    let lost = [gaze, pupil].iter().flatten().any(|&(_, lost)| lost);
    let reading = |(point, _)| Reading {
        value: GazePoint::Raw(point),
        tracked: !lost,
    };
    Sample {
        combined: Eye {
            pupil: value(Output::PupilDiameter)
                .filter(|&diameter| !lost && diameter > 0.0)
                .map(Pupil::Raw),
            ..Eye::default()
        },
        gaze_point: gaze.or(pupil).map(reading),
        ..Sample::arrived(arrival)
    }
}

/// Returns the record that a device sends for a sample: zero for what it lacks, rounded to tenths,
/// 0 to [`Config::largest_word`].
pub fn encode(sample: &Sample, config: &Config) -> Vec<u8, LONGEST_RECORD> {
    let (gaze, pupil) = numbers(sample);
    let mut record = Vec::new();
    // The vector holds the longest record.
    let _ = record.extend_from_slice(&[HEADER; 2]);
    for output in config.outputs.as_slice() {
        let value = match output {
            Output::GazeHorizontal | Output::PupilHorizontal => gaze.x,
            Output::GazeVertical | Output::PupilVertical => gaze.y,
            Output::PupilDiameter => pupil,
            Output::Other => 0.0,
        };
        let word = (libm::roundf(value * TENTHS) as u16).min(config.limit());
        let _ = record.extend_from_slice(&word.to_le_bytes());
    }
    record
}

#[cfg(test)]
mod tests;
