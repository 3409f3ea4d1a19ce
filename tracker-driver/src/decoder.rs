//! What all decoders of byte streams have in common.
//!
//! Each protocol's module says how strong its check is; its tests bound the wrong samples of each
//! fault of one byte (dropped, changed, inserted, doubled) and the intact records that it costs.
//! `SHISEN_HEAVY=1` has them try each byte and value.

use crate::sample::{Parts, Sample};
use crate::time::{DeviceTime, Micros};

/// A state machine that bytes go into and events come out of. It keeps a bounded piece of
/// the stream, never waits for more, is back in step after any garbage, and reports that.
pub trait Decoder {
    /// Takes the next bytes of the stream, of which the last came in at
    /// `arrival`, and hands each event to `sink`, in the order of the bytes.
    fn feed(&mut self, bytes: &[u8], arrival: Micros, sink: &mut dyn FnMut(Event));

    /// What became of the bytes so far.
    fn counts(&self) -> &Counts;

    /// Forgets the record under way, as after a gap in the stream; the counts stay.
    fn reset(&mut self);

    /// Takes note of a command that was sent at `now`: a [`Flock`](crate::head::flock::Flock)'s
    /// answers to `O` are told from garbage by that. Most decoders have nothing to note.
    fn on_sent(&mut self, _command: &[u8], _now: Micros) {}

    /// How many fields an ISCAN's records have where these are not as many as the decoder was
    /// told; `None` where records are read, and of other devices.
    fn fields_seen(&self) -> Option<usize> {
        None
    }
}

/// What a decoder found.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Event {
    /// A record of a sensor.
    Sample(Sample),
    /// The device said something that is no sample.
    Message(Message),
    /// Bytes that belong to no record, or a record that cannot be used.
    Dropped(Dropped),
}

impl Event {
    pub(crate) const fn dropped(bytes: u32, reason: DropReason) -> Self {
        Self::Dropped(Dropped { bytes, reason })
    }

    pub(crate) const fn reply(to: u32, result: u32, meaning: &'static str) -> Self {
        Self::Message(Message::Reply(Reply {
            to,
            result,
            meaning,
        }))
    }
}

/// Bytes that were thrown away.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Dropped {
    /// How many.
    pub bytes: u32,
    /// Why.
    pub reason: DropReason,
}

/// Why bytes were thrown away.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum DropReason {
    /// Between records: what stands there starts none.
    OutOfStep,
    /// A record broke off before its end.
    Truncated,
    /// The record's length is not one that the protocol has.
    Length,
    /// The record's checksum does not match.
    Checksum,
    /// A field holds a value that the protocol does not allow.
    Field,
    /// A number is infinite, NaN, or not one the sensor can measure.
    OutOfRange,
    /// A direction or a quaternion has no length.
    NotUnit,
    /// A version or a kind of record that is not known here.
    Unknown,
    /// The record repeats the one before.
    Duplicate,
}

impl DropReason {
    /// All of them, in the order of [`Counts::dropped`].
    pub const ALL: [Self; 9] = [
        Self::OutOfStep,
        Self::Truncated,
        Self::Length,
        Self::Checksum,
        Self::Field,
        Self::OutOfRange,
        Self::NotUnit,
        Self::Unknown,
        Self::Duplicate,
    ];

    /// In words, for a report.
    pub const fn name(self) -> &'static str {
        match self {
            Self::OutOfStep => "out of step",
            Self::Truncated => "truncated",
            Self::Length => "wrong length",
            Self::Checksum => "wrong checksum",
            Self::Field => "field not allowed",
            Self::OutOfRange => "out of range",
            Self::NotUnit => "no direction",
            Self::Unknown => "unknown kind",
            Self::Duplicate => "repeated",
        }
    }
}

/// Something that a device says beside its samples.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Message {
    /// The device reports a fault, by its own number or letter.
    Fault {
        /// As the device's manual lists it.
        code: u32,
        /// What the manual says about it; empty where it says nothing.
        meaning: &'static str,
    },
    /// Text for a person.
    Text(Text),
    /// The device answers a command.
    Reply(Reply),
    /// The device says how it is; no fault.
    State {
        /// As the device's manual lists it.
        code: u32,
        /// What the manual says about it; empty where it says nothing.
        meaning: &'static str,
    },
    /// The device found something in the eyes' movement by itself.
    Eyes(EyeEvent),
    /// From the next sample on the device sends these parts, and others no longer,
    /// without a value, since it does not measure them: an eye that is shut.
    Unmeasured(Parts),
}

/// What a device found in the eyes' movement.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct EyeEvent {
    /// What happened.
    pub kind: EyeEventKind,
    /// To which eye; `None` where the device does not tell them apart.
    pub eye: Option<Side>,
    /// When, by the device's clock.
    pub device_time: Option<DeviceTime>,
    /// How long it took, where it is over.
    pub duration: Option<Micros>,
}

/// What can happen to an eye.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum EyeEventKind {
    /// It closed and opened again.
    Blink,
    /// It closed.
    Closed,
    /// It opened.
    Opened,
    /// The device cannot find it any more.
    Lost,
    /// The device found it again.
    Found,
    /// It jumped.
    Saccade,
    /// It rested.
    Fixation,
}

/// One of the two eyes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Side {
    /// The left one.
    Left,
    /// The right one.
    Right,
}

/// Most bytes of a [`Text`] that are kept.
pub const MOST_MESSAGE_BYTES: usize = 64;

/// Text that a device sent: printable ASCII, cut at [`MOST_MESSAGE_BYTES`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Text {
    bytes: [u8; MOST_MESSAGE_BYTES],
    length: u8,
}

impl Text {
    /// The text up to its first zero byte, trimmed; what is not printable ASCII becomes `?`.
    pub fn new(bytes: &[u8]) -> Self {
        let end = bytes.iter().position(|&b| b == 0).unwrap_or(bytes.len());
        let mut text = Self {
            bytes: [0; MOST_MESSAGE_BYTES],
            length: 0,
        };
        for (to, &from) in text.bytes.iter_mut().zip(bytes[..end].trim_ascii()) {
            let printable = from == b' ' || from.is_ascii_graphic();
            *to = if printable { from } else { b'?' };
            text.length += 1;
        }
        text
    }

    /// The text.
    pub fn as_str(&self) -> &str {
        let text = self.bytes.get(..usize::from(self.length));
        core::str::from_utf8(text.unwrap_or_default()).unwrap_or_default()
    }
}

#[cfg(feature = "defmt")]
impl defmt::Format for Text {
    fn format(&self, f: defmt::Formatter<'_>) {
        defmt::write!(f, "{=str}", self.as_str());
    }
}

/// A device's answer to a command.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Reply {
    /// Which command, as the protocol numbers them.
    pub to: u32,
    /// 0 where the device agrees.
    pub result: u32,
    /// What the manual says about a refusal; empty where it says nothing.
    pub meaning: &'static str,
}

/// What became of the bytes that a decoder took; each count stops at its largest value.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Counts {
    /// Bytes taken.
    pub bytes: u64,
    /// Samples handed over.
    pub samples: u64,
    /// Messages handed over.
    pub messages: u64,
    /// Records that the device's own count says are missing.
    pub lost: u64,
    /// Times that bytes were thrown away, in the order of [`DropReason::ALL`].
    pub dropped: [u32; DropReason::ALL.len()],
    /// Bytes thrown away.
    pub dropped_bytes: u64,
}

impl Counts {
    /// No bytes taken yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// These and others, of the same device read by another decoder.
    #[must_use]
    pub fn plus(&self, others: &Self) -> Self {
        let mut dropped = self.dropped;
        for (count, more) in dropped.iter_mut().zip(others.dropped) {
            *count = count.saturating_add(more);
        }
        Self {
            bytes: self.bytes.saturating_add(others.bytes),
            samples: self.samples.saturating_add(others.samples),
            messages: self.messages.saturating_add(others.messages),
            lost: self.lost.saturating_add(others.lost),
            dropped,
            dropped_bytes: self.dropped_bytes.saturating_add(others.dropped_bytes),
        }
    }

    /// How often bytes were thrown away for this reason.
    pub fn dropped_for(&self, reason: DropReason) -> u32 {
        self.dropped[reason as usize]
    }

    /// Adds what an event says.
    pub(crate) fn note(&mut self, event: &Event) {
        match event {
            Event::Sample(_) => self.samples = self.samples.saturating_add(1),
            Event::Message(_) => self.messages = self.messages.saturating_add(1),
            Event::Dropped(dropped) => {
                let count = &mut self.dropped[dropped.reason as usize];
                *count = count.saturating_add(1);
                self.dropped_bytes = self.dropped_bytes.saturating_add(u64::from(dropped.bytes));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_is_printable_and_bounded() {
        assert_eq!(Text::new(b" DMP\x07 ok\r\n\0junk").as_str(), "DMP? ok");
        assert_eq!(Text::new(&[b'a'; 200]).as_str().len(), MOST_MESSAGE_BYTES);
        assert_eq!(Text::new(b"").as_str(), "");
    }
}
