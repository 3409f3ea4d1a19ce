//! The interface of all decoders: events, messages, counts.
//!
//! Each protocol's module says how strong its check is; its tests bound the wrong samples of each
//! fault of one byte (dropped, changed, inserted, doubled) and the intact records that it costs.
//! `SHISEN_HEAVY=1` has them try each byte and value.

use crate::sample::{Parts, Sample};
use crate::time::{DeviceTime, Micros};

/// A state machine that takes bytes and hands out events. It keeps a bounded piece of the
/// stream, never waits, finds records again after any garbage, and reports the garbage.
pub trait Decoder {
    /// Takes the next bytes of the stream, of which the last came in at
    /// `arrival`, and hands each event to `sink`, in the order of the bytes.
    fn feed(&mut self, bytes: &[u8], arrival: Micros, sink: &mut dyn FnMut(Event));

    /// Returns counts of the bytes and events so far.
    fn counts(&self) -> &Counts;

    /// Forgets the record under way, as after a gap in the stream; the counts stay.
    fn reset(&mut self);

    /// Takes note of a command that was sent at `now`: a [`Flock`](crate::head::flock::Flock)'s
    /// answers to `O` cannot be told from garbage otherwise. Most decoders ignore it.
    fn on_sent(&mut self, _command: &[u8], _now: Micros) {}

    /// Returns the number of fields in an ISCAN's records if the decoder expects another; `None`
    /// if records can be read, and for other devices.
    fn fields_seen(&self) -> Option<usize> {
        None
    }
}

/// An event that a decoder hands out.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Event {
    /// A sample of a sensor.
    Sample(Sample),
    /// A message of the device that is not a sample.
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

/// Bytes that were dropped.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Dropped {
    /// Number of bytes.
    pub bytes: u32,
    /// The reason.
    pub reason: DropReason,
}

/// Why bytes were dropped.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum DropReason {
    /// Bytes between records that do not start a record.
    OutOfStep,
    /// A record broke off before its end.
    Truncated,
    /// The protocol has no record of this length.
    Length,
    /// The record's checksum does not match.
    Checksum,
    /// A field holds a value that the protocol does not allow.
    Field,
    /// A number is infinite, NaN, or not one the sensor can measure.
    OutOfRange,
    /// A direction or a quaternion has no length.
    NotUnit,
    /// An unknown version or kind of record.
    Unknown,
    /// The record repeats the one before.
    Duplicate,
}

impl DropReason {
    /// All reasons, in the order of [`Counts::dropped`].
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

    /// Returns the reason in words, for a report.
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

/// A message that a device sends beside its samples.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Message {
    /// The device reports a fault, by its own number or letter.
    Fault {
        /// The number in the device's manual.
        code: u32,
        /// The manual's meaning of it; empty if the manual has none.
        meaning: &'static str,
    },
    /// Text for a person.
    Text(Text),
    /// The device answers a command.
    Reply(Reply),
    /// The device reports its state, which is not a fault.
    State {
        /// The number in the device's manual.
        code: u32,
        /// The manual's meaning of it; empty if the manual has none.
        meaning: &'static str,
    },
    /// The device itself found an event in the eyes' movement.
    Eyes(EyeEvent),
    /// From the next sample on the device sends exactly these parts without a value,
    /// since it does not measure them: an eye that is shut.
    Unmeasured(Parts),
    /// A person pressed a button or moved an axis.
    Control(Control),
}

/// A button or an axis that a person moves: a wand's, a Flystick's.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Control {
    /// The sensor that the control is on, as in [`Sample::sensor`]; 0 if the protocol has none.
    pub sensor: u8,
    /// The control's number among the sensor's buttons or axes, from 0.
    pub number: u8,
    /// The state that it has now.
    pub state: ControlState,
    /// Time by the device's clock.
    pub device_time: Option<DeviceTime>,
}

/// The state of a [`Control`].
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ControlState {
    /// Whether the button is pressed.
    Button(bool),
    /// The axis' finite value, from −1 to 1 on most devices.
    Axis(f32),
}

/// An event in the eyes' movement that a device found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct EyeEvent {
    /// The kind of event.
    pub kind: EyeEventKind,
    /// The eye; `None` if the device does not distinguish them.
    pub eye: Option<Side>,
    /// Time by the device's clock.
    pub device_time: Option<DeviceTime>,
    /// Duration of an event that is over.
    pub duration: Option<Micros>,
}

/// A kind of event in an eye's movement.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum EyeEventKind {
    /// The eye closed and opened again.
    Blink,
    /// The eye closed.
    Closed,
    /// The eye opened.
    Opened,
    /// The device cannot find the eye any more.
    Lost,
    /// The device found the eye again.
    Found,
    /// The eye jumped.
    Saccade,
    /// The eye rested.
    Fixation,
}

/// One of the two eyes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Side {
    /// The left eye.
    Left,
    /// The right eye.
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
    /// Reads the text up to its first zero byte, trimmed; other bytes than printable ASCII become `?`.
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

    /// Returns the text.
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
    /// The command, by its number in the protocol.
    pub to: u32,
    /// The result; 0 if the device agrees.
    pub result: u32,
    /// The manual's meaning of a refusal; empty if the manual has none.
    pub meaning: &'static str,
}

/// Counts of a decoder's bytes and events; each count stops at its largest value.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Counts {
    /// Bytes received.
    pub bytes: u64,
    /// Samples handed over.
    pub samples: u64,
    /// Messages handed over.
    pub messages: u64,
    /// Records that the device's own count says are missing.
    pub lost: u64,
    /// Number of times that bytes were dropped, in the order of [`DropReason::ALL`].
    pub dropped: [u32; DropReason::ALL.len()],
    /// Bytes dropped.
    pub dropped_bytes: u64,
}

impl Counts {
    /// Counts before the first byte.
    pub fn new() -> Self {
        Self::default()
    }

    /// Returns the sum of these counts and those of another decoder of the same device.
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

    /// Returns how many times bytes were dropped for this reason.
    pub fn dropped_for(&self, reason: DropReason) -> u32 {
        self.dropped[reason as usize]
    }

    /// Counts an event.
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
