//! `AdHawk` eye trackers, API 2.0: a worn tracker that scans the eyes with
//! micromirrors.
//!
//! # Wire format
//!
//! From the maker's SDK (`adhawkmicrosystems/embedded_sdk`, `src/packet.h`,
//! `spi_master.c`, `request.c`, `ah_api_decoders.c`, `inc/ah_types*.h`); all
//! numbers are little-endian. Packets come one after the other on a serial
//! line, or in SPI frames ([`spi_packets`]):
//!
//! | Byte | Content |
//! |---|---|
//! | 0 | 0xAA |
//! | 1, 2 | bits 0 to 9: length of the payload, 1 to 125; bit 15: a stream; the rest 0 |
//! | 3 and on | payload |
//!
//! | Payload of | Content |
//! |---|---|
//! | a request | u16 its number, u8 type, arguments ([`Request`]) |
//! | a response | u16 the request's number, u8 its type, u8 result (0: done), data |
//! | stream 0x01, eyes | u8 0x01, u64 nanoseconds since the device started, u8 eyes (1 right, 2 left, 3 both), then fields |
//! | stream 0x18, events | u8 0x18, u8 kind, f32 seconds since the device started, data |
//!
//! | Field | After its type, a byte | Becomes |
//! |---|---|---|
//! | 1 gaze | f32 x, y, z, vergence | `combined.direction` |
//! | 2 gaze of each eye | f32 x, y, z for each | `direction` |
//! | 3 centre of each eye | f32 x, y, z for each, millimetres | `origin` |
//! | 4 pupil of each eye | f32 x, y, z for each, millimetres | `origin`, without field 3 |
//! | 5 pupil of each eye | f32 diameter for each, millimetres | `pupil` |
//! | 6 gaze in the scene camera's picture | f32 x, y, two scales | (passed over) |
//! | 7 gaze on the screen | f32 x, y | `gaze_point`, 0 to 1 |
//! | 8 inertial sensor | f32 x, y, z, w | `head.orientation` |
//!
//! NaN, as C writes it (0x7FC00000 or 0xFFC00000), stands for what was not measured: the headers
//! say nothing of an eye that is not seen. What it stands in is then not tracked (a direction, a
//! gaze point) or not there (the rest), the packet's other fields stay, and a
//! [`Message::Unmeasured`] says so whenever it begins, changes or ends.
//!
//! The right eye comes before the left; one eye alone has one value. +X is to the right, +Y up
//! and +Z behind, as in a [`Head`](crate::sample::Head). The headers are silent about three
//! things: that the screen's gaze counts from 0 to 1, that an event's eye 0 is the right one, and
//! that the inertial sensor's axes are the head's.
//!
//! # How far the decoder can be trusted
//!
//! There is no checksum. A packet of eyes counts only where its fields fill it exactly, each at
//! most once, and hold usable numbers or NaN. Random bytes pass for one with a probability below
//! 2⁻³⁶ at each byte; three of four changed bytes leave a valid packet.

mod encode;
mod fields;
mod request;

pub use encode::{encode, encode_event, encode_response};
#[cfg(any(feature = "mock", test))]
pub(crate) use request::{
    EYE_TRACKING, GET_TRACKER_STATUS, PROPERTY_EVENTS, PROPERTY_FIELDS, PROPERTY_RATE,
    SET_PROPERTY, SYSTEM_CONTROL,
};
pub use request::{Request, USUAL_FIELDS, USUAL_HERTZ, start, stop};

use crate::decoder::{Counts, Decoder, DropReason, Event, EyeEvent, EyeEventKind, Message, Side};
use crate::sample::Parts;
use crate::stream::{Step, Stream, Window};
use crate::time::{DeviceTime, Micros};
use fields::{eye_fields, number};
use heapless::Vec;

/// Most bytes of a packet.
pub const LONGEST_PACKET: usize = 128;

/// Bytes of an SPI frame.
pub const SPI_FRAME_LENGTH: usize = 1_024;

/// How long the device may take to answer a request.
pub const RESPONSE_TIMEOUT: Micros = Micros::from_millis(1_000);

/// The bytes of a packet.
pub type Packet = Vec<u8, LONGEST_PACKET>;

pub(crate) const START_OF_PACKET: u8 = 0xAA;
/// Before the payload.
const OVERHEAD: usize = 3;
const LENGTH_BITS: u16 = 0x03FF;
const STREAM_BIT: u16 = 0x8000;

const EYES: u8 = 0x01;
const TRACKERS_READY: u8 = 0x02;
const TRACKER_STATUS: u8 = 0x16;
const EVENTS: u8 = 0x18;
/// Before the fields of stream 0x01.
const EYES_OVERHEAD: usize = 10;

const RIGHT: u8 = 1;
const LEFT: u8 = 2;
const BOTH: u8 = 3;

const MILLIMETRE: f32 = 1.0e-3;
const NANOSECONDS_PER_MICROSECOND: u64 = 1_000;

/// Returns what a response's result means; empty where that is not known.
pub fn result_name(result: u32) -> &'static str {
    match result {
        0 => "done",
        1 => "failed",
        2 => "argument not allowed",
        3 => "tracker not ready",
        4 => "eyes not found",
        5 => "right eye not found",
        6 => "left eye not found",
        7 => "not calibrated",
        8 => "not supported",
        9 => "session already running",
        10 => "no session",
        11 => "timed out",
        12 => "unexpected response",
        13 => "hardware fault",
        14 => "camera fault",
        15 => "busy",
        16 => "communication error",
        17 => "device calibration required",
        18 => "not finished",
        19 => "inactive interface",
        20 => "tracker disconnected",
        _ => "",
    }
}

/// The largest result that is known.
const LAST_RESULT: u8 = 20;

/// Returns the packets in an SPI frame, for the decoder; none in an empty or damaged one.
pub fn spi_packets(frame: &[u8]) -> &[u8] {
    match frame {
        [START_OF_PACKET, low, high, packets @ ..] => {
            let length = usize::from(u16::from_le_bytes([*low, *high]));
            packets.get(..length).unwrap_or_default()
        }
        _ => &[],
    }
}

/// The decoder.
#[derive(Debug, Clone, Default)]
pub struct AdHawk {
    stream: Stream<LONGEST_PACKET>,
    /// The parts that the last packet of eyes had no values of.
    unmeasured: Parts,
}

impl AdHawk {
    /// Returns a decoder that has seen nothing.
    pub fn new() -> Self {
        Self::default()
    }
}

impl Decoder for AdHawk {
    fn feed(&mut self, bytes: &[u8], arrival: Micros, sink: &mut dyn FnMut(Event)) {
        let unmeasured = &mut self.unmeasured;
        self.stream
            .feed(bytes, arrival, sink, |window| step(window, unmeasured));
    }

    fn counts(&self) -> &Counts {
        &self.stream.counts
    }

    fn reset(&mut self) {
        self.stream.reset();
        self.unmeasured = Parts::NONE;
    }
}

fn step(window: Window<'_>, unmeasured: &mut Parts) -> Step {
    let [START_OF_PACKET, rest @ ..] = window.bytes else {
        return Step::Skip(DropReason::OutOfStep);
    };
    let Some((header, begun)) = rest.split_first_chunk() else {
        return Step::More;
    };
    let header = u16::from_le_bytes(*header);
    let length = usize::from(header & LENGTH_BITS);
    let clear = header & !(LENGTH_BITS | STREAM_BIT) == 0;
    if !(clear && (1..=LONGEST_PACKET - OVERHEAD).contains(&length)) {
        return Step::Skip(DropReason::Length);
    }
    let begun = begun.get(..length).unwrap_or(begun);
    let stream = header & STREAM_BIT != 0;
    if begun.len() < length {
        return match promises(begun, length, stream, window.in_step) {
            Ok(()) => Step::More,
            Err(reason) => Step::Skip(reason),
        };
    }
    let read = match begun {
        _ if !stream => response(begun, length, window.in_step),
        [EYES, eyes @ ..] => match eye_fields(eyes, window.arrival) {
            Ok((sample, parts)) => {
                let changed = core::mem::replace(unmeasured, parts) != parts;
                let said = changed.then_some(Message::Unmeasured(parts));
                return Step::Take(OVERHEAD + length, said, Event::Sample(sample));
            }
            Err(reason) => Err(reason),
        },
        [EVENTS, event @ ..] => eye_event(event, length - 1),
        [kind, data @ ..] if window.in_step => Ok(other_stream(*kind, data)),
        _ => Err(DropReason::Unknown),
    };
    match read {
        Err(reason) => Step::Skip(reason),
        Ok(None) => Step::Discard(OVERHEAD + length, DropReason::Unknown),
        Ok(Some(event)) => Step::Take(OVERHEAD + length, None, event),
    }
}

/// Returns whether a payload that has begun can become a packet; fields are looked at when all are
/// there.
fn promises(begun: &[u8], length: usize, stream: bool, in_step: bool) -> Result<(), DropReason> {
    match begun {
        _ if !stream => response(begun, length, in_step).map(|_| ()),
        [EYES, ..] if length < EYES_OVERHEAD => Err(DropReason::Length),
        [EYES, rest @ ..] => match rest.get(EYES_OVERHEAD - 2).copied() {
            Some(RIGHT | LEFT | BOTH) | None => Ok(()),
            Some(_) => Err(DropReason::Field),
        },
        [EVENTS, event @ ..] => eye_event(event, length - 1).map(|_| ()),
        [_, ..] if !in_step => Err(DropReason::Unknown),
        _ => Ok(()),
    }
}

/// Returns a response, `begun` of `length` bytes; `None` where more is needed.
fn response(begun: &[u8], length: usize, in_step: bool) -> Result<Option<Event>, DropReason> {
    // Out of step, only the shortest are taken for one: data would hide
    // the next packet behind whatever looks like a header.
    if length < 4 || (!in_step && length > 4) {
        return Err(DropReason::Length);
    }
    let [_, _, kind, result, ..] = *begun else {
        return match begun {
            [_, _, kind] if !REQUESTS.contains(kind) => Err(DropReason::Unknown),
            _ => Ok(None),
        };
    };
    if !REQUESTS.contains(&kind) {
        return Err(DropReason::Unknown);
    }
    if result > LAST_RESULT {
        return Err(DropReason::Field);
    }
    let result = u32::from(result);
    let meaning = if result == 0 { "" } else { result_name(result) };
    Ok((begun.len() == length).then_some(Event::reply(kind.into(), result, meaning)))
}

/// The types of requests, from the calibration's to the network's.
const REQUESTS: core::ops::RangeInclusive<u8> = 0x71..=0xC5;

/// Streams that are no samples; `None` for those that are not known here.
fn other_stream(kind: u8, data: &[u8]) -> Option<Event> {
    let state = match (kind, data) {
        (TRACKERS_READY, _) => Message::State {
            code: u32::from(TRACKERS_READY),
            meaning: "trackers ready",
        },
        (TRACKER_STATUS, [status, ..]) if *status <= LAST_RESULT => Message::State {
            code: u32::from(*status),
            meaning: result_name(u32::from(*status)),
        },
        _ => return None,
    };
    Some(Event::Message(state))
}

/// Returns what an event's data is: its kind, its bytes, and what they begin with.
fn event_layout(kind: u8) -> Option<(EyeEventKind, usize, Data)> {
    Some(match kind {
        1 => (EyeEventKind::Blink, 4, Data::Duration),
        2 => (EyeEventKind::Closed, 1, Data::Eye),
        3 => (EyeEventKind::Opened, 1, Data::Eye),
        4 => (EyeEventKind::Lost, 1, Data::Eye),
        5 => (EyeEventKind::Found, 1, Data::Eye),
        6 => (EyeEventKind::Saccade, 16, Data::Duration),
        15 => (EyeEventKind::Fixation, 24, Data::Duration),
        _ => return None,
    })
}

/// How an event's data begin.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Data {
    Duration,
    Eye,
}

/// The longest time that an event can say: a year, in seconds.
const LONGEST_TIME: f32 = 3.2e7;

fn micros(seconds: f32) -> Result<u64, DropReason> {
    if (0.0..=LONGEST_TIME).contains(&seconds) {
        Ok((seconds * 1.0e6) as u64)
    } else {
        Err(DropReason::OutOfRange)
    }
}

/// Returns an event, `begun` of `length` bytes; `None` where more is needed.
fn eye_event(begun: &[u8], length: usize) -> Result<Option<Event>, DropReason> {
    let [kind, rest @ ..] = begun else {
        return Ok(None);
    };
    let (kind, data_length, layout) = event_layout(*kind).ok_or(DropReason::Unknown)?;
    if length != 1 + 4 + data_length {
        return Err(DropReason::Length);
    }
    if rest.len() < length - 1 {
        return Ok(None);
    }
    let time = micros(number(rest, 0))?;
    let (eye, duration) = match (layout, rest.get(4)) {
        (Data::Duration, _) => (None, Some(Micros(micros(number(rest, 1))?))),
        (Data::Eye, Some(0)) => (Some(Side::Right), None),
        (Data::Eye, Some(1)) => (Some(Side::Left), None),
        (Data::Eye, _) => return Err(DropReason::Field),
    };
    Ok(Some(Event::Message(Message::Eyes(EyeEvent {
        kind,
        eye,
        device_time: Some(DeviceTime::unwrapped(time)),
        duration,
    }))))
}

#[cfg(test)]
mod tests;
