//! VRPN, version 07: poses, buttons and analogs of one device of a server.
//!
//! # The connection
//!
//! A client connects to TCP port [`PORT`], sends [`COOKIE`] and reads. Or it listens on a TCP port
//! of its own and sends the text `<ip> <port>` and a zero byte to UDP port [`PORT`], every 2 s
//! until the server connects; then both send the cookie. A server sends poses by UDP
//! to a client that described a UDP port to it, which [`Encoder`] does not.
//! A client that wants to know whether the server lives describes the device and [`PING`] and
//! sends it once a second; the server answers with [`PONG`], and counts the pings that it gets
//! ([`Vrpn::take_pings`]).
//!
//! # Wire format
//!
//! A message is a header, a body, and padding of any bytes to a multiple of 8; all numbers are
//! big-endian:
//!
//! | Byte | Content |
//! |---|---|
//! | 0 | u32 length of header and body, without the padding |
//! | 4, 8 | i32 seconds since 1970, i32 microseconds; both 0: no time |
//! | 12 | i32 sender |
//! | 16 | i32 type; −1 describes a sender, −2 a type, both with the new id as sender |
//! | 20 | u32 count of the messages of this direction and transport |
//!
//! | Type's name | Body |
//! |---|---|
//! | description | u32 length, a name of at most 95 bytes and a zero byte |
//! | `vrpn_Tracker Pos_Quat` | i32 sensor, i32 any, f64 x, y, z, f64 qx, qy, qz, qw |
//! | `vrpn_Button Change` | i32 button, i32 0 or 1 |
//! | `vrpn_Button States` | i32 n, n × i32 0 or 1 |
//! | `vrpn_Analog Channel` | f64 n, n × f64 |
//! | `vrpn_Base text_message` | u32 severity, u32 level, 1024 bytes of text |
//! | `vrpn_Base ping_message`, `vrpn_Base pong_message` | – |
//!
//! Messages of other types and other senders are skipped, and not counted. Ids are what the peer
//! described them to be; each may be described at any time, and again.
//!
//! # Axes and times
//!
//! VRPN defines no axes: they are the device's, and [`Config::axes`] takes them to ours. Poses are
//! in metres, or in [`Config::metres`]. No flag says that a sensor is not tracked: most servers send nothing of it then.
//! Times are the server's, often of the arrival there; a message without a time gets none.

mod encode;

pub use encode::{Encoder, LONGEST_ENCODED};

use super::{Numbers, count_bytes, hand_over, rotation};
use crate::decoder::{Control, ControlState, Counts, Decoder, DropReason, Event, Message, Text};
use crate::head::axes::Axes;
use crate::link::body::Body;
use crate::sample::{Head, Reading, Sample};
use crate::time::{DeviceTime, Micros};
use crate::valid;
use glam::{Quat, Vec3};
use heapless::{String, Vec};

/// The server's TCP and UDP port.
pub const PORT: u16 = 3883;
/// The bytes that either side sends first: version 07.38, and no log is asked for.
pub const COOKIE: [u8; 24] = *b"vrpn: ver. 07.38  0\0\0\0\0\0";
/// The part of the cookie that both sides have in common.
const VERSION: &[u8] = b"vrpn: ver. 07.";
/// Most bytes of a sender's or a type's name.
pub const MOST_NAME_BYTES: usize = 95;
/// Number of other senders whose names are kept.
pub const MOST_SENDERS: usize = 8;
/// Number of sensors; those above are dropped.
pub const SENSORS: i32 = 64;

/// Bytes of a message's header.
const HEADER_BYTES: usize = 24;
/// Most bytes of a message, that of the reference implementation.
const LONGEST_MESSAGE: usize = 64_000;
/// Most bytes of a body that is read: a text message's, and 128 channels'.
const LONGEST_BODY: usize = 1_032;
/// Most channels of a message.
const MOST_CHANNELS: usize = 128;
/// Most buttons of a message.
const MOST_BUTTONS: i32 = 256;

const SENDER: i32 = -1;
const TYPE: i32 = -2;

/// The type of a pose.
pub const POSE: &str = "vrpn_Tracker Pos_Quat";
/// The type of a button that was pressed or released.
pub const BUTTON: &str = "vrpn_Button Change";
/// The type of all buttons' states.
pub const BUTTONS: &str = "vrpn_Button States";
/// The type of all analogs' values.
pub const ANALOG: &str = "vrpn_Analog Channel";
/// The type of a text.
pub const TEXT: &str = "vrpn_Base text_message";
/// The type of a client's question whether the device lives.
pub const PING: &str = "vrpn_Base ping_message";
/// The type of the answer.
pub const PONG: &str = "vrpn_Base pong_message";

/// The types that are read, in the order of [`Ids::types`].
const TYPES: [&str; 6] = [POSE, BUTTON, BUTTONS, ANALOG, TEXT, PING];

/// The name of a sender.
pub type Name = String<MOST_NAME_BYTES>;

/// How a device is read.
#[derive(Debug, Clone, PartialEq)]
pub struct Config {
    /// The sender's name, in which case matters.
    pub device: Name,
    /// The device's axes.
    pub axes: Axes,
    /// Metres of the device's unit.
    pub metres: f32,
}

impl Config {
    /// Returns a device whose axes and unit are ours; `None` for a longer name than VRPN has.
    pub fn new(device: &str) -> Option<Self> {
        Some(Self {
            device: device.try_into().ok()?,
            axes: Axes::SAME,
            metres: 1.0,
        })
    }
}

/// A message's header.
#[derive(Debug, Clone, Copy)]
struct Header {
    length: usize,
    time: Option<DeviceTime>,
    sender: i32,
    kind: i32,
    sequence: u32,
}

impl Header {
    fn read(bytes: &[u8]) -> Result<Self, DropReason> {
        let mut bytes = Body(bytes);
        let length = u32::from_be_bytes(bytes.take()?) as usize;
        if !(HEADER_BYTES..=LONGEST_MESSAGE).contains(&length) {
            return Err(DropReason::Length);
        }
        let (seconds, micros) = (integer(&mut bytes)?, integer(&mut bytes)?);
        let is_time =
            seconds >= 0 && (0..1_000_000).contains(&micros) && (seconds, micros) != (0, 0);
        let since = u64::from(seconds.unsigned_abs()) * 1_000_000;
        let time = DeviceTime::unwrapped(since + u64::from(micros.unsigned_abs()));
        Ok(Self {
            length,
            time: is_time.then_some(time),
            sender: integer(&mut bytes)?,
            kind: integer(&mut bytes)?,
            sequence: u32::from_be_bytes(bytes.take()?),
        })
    }

    /// Returns bytes of the body, and of the body with its padding.
    const fn body(&self) -> (usize, usize) {
        let body = self.length.saturating_sub(HEADER_BYTES);
        (body, body.next_multiple_of(8))
    }
}

fn integer(body: &mut Body<'_>) -> Result<i32, DropReason> {
    body.take().map(i32::from_be_bytes)
}

fn number(body: &mut Body<'_>) -> Result<f32, DropReason> {
    valid::within(f64::from_be_bytes(body.take()?) as f32, f32::MAX)
}

fn vector(body: &mut Body<'_>) -> Result<Vec3, DropReason> {
    Ok(Vec3::new(number(body)?, number(body)?, number(body)?))
}

/// The peer's ids.
#[derive(Debug, Clone, Default)]
struct Ids {
    device: Option<i32>,
    types: [Option<i32>; TYPES.len()],
    senders: Vec<(i32, Name), MOST_SENDERS>,
}

impl Ids {
    /// Takes note of a description.
    fn describe(&mut self, header: &Header, body: &[u8], device: &str) -> Result<(), DropReason> {
        let mut body = Body(body);
        let length = u32::from_be_bytes(body.take()?) as usize;
        let (&end, name) = body.0.split_last().ok_or(DropReason::Length)?;
        if length != body.0.len() || length > MOST_NAME_BYTES + 1 {
            return Err(DropReason::Length);
        }
        let name = core::str::from_utf8(name).map_err(|_| DropReason::Field)?;
        if end != 0 || header.sender < 0 || name.contains('\0') {
            return Err(DropReason::Field);
        }
        let id = header.sender;
        if header.kind == TYPE {
            for (known, at) in TYPES.iter().zip(&mut self.types) {
                rename(at, id, *known == name);
            }
            return Ok(());
        }
        rename(&mut self.device, id, device == name);
        self.senders.retain(|&(other, _)| other != id);
        if let Ok(name) = name.try_into() {
            // More senders than there is room for are only not listed.
            let _ = self.senders.push((id, name));
        }
        Ok(())
    }

    /// Returns the name of a message's type; `None` for one that is not read, or of another device.
    fn kind(&self, header: &Header) -> Option<&'static str> {
        let mut types = TYPES.iter().zip(&self.types);
        let kind = types.find(|(_, id)| **id == Some(header.kind))?.0;
        (self.device == Some(header.sender)).then_some(kind)
    }
}

/// Gives a name its id, or takes the id that another name has now.
fn rename(at: &mut Option<i32>, id: i32, is_it: bool) {
    if is_it {
        *at = Some(id);
    } else if *at == Some(id) {
        *at = None;
    }
}

/// The place in the byte stream.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Stage {
    Cookie,
    Messages,
    Lost,
}

/// Decodes what the peer of one connection sends.
#[derive(Debug, Clone)]
pub struct Vrpn {
    config: Config,
    counts: Counts,
    ids: Ids,
    pings: u32,
    datagrams: Numbers,
    stage: Stage,
    /// The cookie, or a message without its padding, as far as it came.
    buffer: Vec<u8, { HEADER_BYTES + LONGEST_BODY }>,
    /// Bytes to be skipped: padding, and bodies that are too long to be read.
    skip: usize,
}

impl Vrpn {
    /// Returns a decoder of a connection over which nothing came yet.
    pub fn new(config: Config) -> Self {
        Self {
            config,
            counts: Counts::default(),
            ids: Ids::default(),
            pings: 0,
            datagrams: Numbers::default(),
            stage: Stage::Cookie,
            buffer: Vec::new(),
            skip: 0,
        }
    }

    /// Returns whether the peer sent a cookie of version 07, and nothing wrong since.
    pub fn is_greeted(&self) -> bool {
        self.stage == Stage::Messages
    }

    /// Returns whether the stream cannot be read any further: close the connection.
    pub fn is_lost(&self) -> bool {
        self.stage == Stage::Lost
    }

    /// Returns whether the peer described the device. A server does so right after its cookie.
    pub fn has_device(&self) -> bool {
        self.ids.device.is_some()
    }

    /// Returns the names of the first [`MOST_SENDERS`] senders that the peer described.
    pub fn senders(&self) -> impl Iterator<Item = &str> {
        self.ids.senders.iter().map(|(_, name)| name.as_str())
    }

    /// Returns the number of pings since the last call; a server answers each with a [`PONG`].
    pub fn take_pings(&mut self) -> u32 {
        core::mem::take(&mut self.pings)
    }

    /// Takes a datagram of the same peer, which holds whole messages. A damaged one is dropped with
    /// all behind it.
    pub fn datagram(&mut self, bytes: &[u8], arrival: Micros, sink: &mut dyn FnMut(Event)) {
        count_bytes(&mut self.counts, bytes);
        let mut rest = bytes;
        while !rest.is_empty() {
            let whole = Header::read(rest).and_then(|header| {
                let (body, padded) = header.body();
                let (_, behind) = rest.split_at_checked(HEADER_BYTES).unwrap_or_default();
                let body = behind.get(..body).ok_or(DropReason::Length)?;
                Ok((header, body, behind.get(padded..).unwrap_or_default()))
            });
            match whole {
                Ok((header, body, behind)) => {
                    self.datagrams.is_new(header.sequence, &mut self.counts);
                    self.message(&header, body, arrival, sink);
                    rest = behind;
                }
                Err(reason) => return self.drop_bytes(rest.len(), reason, sink),
            }
        }
    }

    fn drop_bytes(&mut self, bytes: usize, reason: DropReason, sink: &mut dyn FnMut(Event)) {
        let event = Event::dropped(bytes as u32, reason);
        self.counts.note(&event);
        sink(event);
    }

    /// Takes the next byte of the stream.
    fn push(&mut self, byte: u8, arrival: Micros, sink: &mut dyn FnMut(Event)) {
        if self.skip > 0 {
            self.skip -= 1;
            return;
        }
        // Never full: emptied once a message is whole, and longer ones are skipped.
        let _ = self.buffer.push(byte);
        let Some((head, body)) = self.buffer.split_at_checked(HEADER_BYTES) else {
            return;
        };
        if self.stage == Stage::Cookie {
            if head.starts_with(VERSION) {
                self.stage = Stage::Messages;
            } else {
                self.lose(DropReason::Unknown, sink);
            }
            return self.buffer.clear();
        }
        let header = match Header::read(head) {
            Ok(header) => header,
            Err(reason) => return self.lose(reason, sink),
        };
        let (length, padded) = header.body();
        if length > LONGEST_BODY {
            self.skip = padded;
            self.buffer.clear();
        } else if body.len() == length {
            self.skip = padded - length;
            let message = core::mem::take(&mut self.buffer);
            let body = message.get(HEADER_BYTES..).unwrap_or_default();
            self.message(&header, body, arrival, sink);
        }
    }

    /// Gives up the stream.
    fn lose(&mut self, reason: DropReason, sink: &mut dyn FnMut(Event)) {
        self.stage = Stage::Lost;
        self.drop_bytes(self.buffer.len(), reason, sink);
        self.buffer.clear();
    }

    fn message(
        &mut self,
        header: &Header,
        body: &[u8],
        arrival: Micros,
        sink: &mut dyn FnMut(Event),
    ) {
        if matches!(header.kind, SENDER | TYPE) {
            let described = self.ids.describe(header, body, &self.config.device);
            if let Err(reason) = described {
                self.drop_bytes(header.length, reason, sink);
            }
        } else if let Some(kind) = self.ids.kind(header) {
            self.pings = self.pings.saturating_add(u32::from(kind == PING));
            let config = &self.config;
            hand_over(&mut self.counts, header.length, sink, |sink| {
                read(kind, header, body, config, arrival, sink)
            });
        }
    }
}

impl Decoder for Vrpn {
    fn feed(&mut self, bytes: &[u8], arrival: Micros, sink: &mut dyn FnMut(Event)) {
        count_bytes(&mut self.counts, bytes);
        let mut rest = bytes;
        while let Some((&byte, behind)) = rest.split_first() {
            if self.is_lost() {
                return self.drop_bytes(rest.len(), DropReason::OutOfStep, sink);
            }
            self.push(byte, arrival, sink);
            rest = behind;
        }
    }

    fn counts(&self) -> &Counts {
        &self.counts
    }

    /// Expects a new connection's cookie.
    fn reset(&mut self) {
        let cut = self.buffer.len();
        if cut > 0 {
            self.drop_bytes(cut, DropReason::Truncated, &mut |_| {});
        }
        let counts = self.counts;
        *self = Self::new(self.config.clone());
        self.counts = counts;
    }
}

/// Reads a body of one of the [`TYPES`].
fn read(
    kind: &str,
    header: &Header,
    body: &[u8],
    Config { axes, metres, .. }: &Config,
    arrival: Micros,
    sink: &mut dyn FnMut(Event),
) -> Result<(), DropReason> {
    let mut body = Body(body);
    let control = |number: usize, state| {
        Event::Message(Message::Control(Control {
            sensor: 0,
            number: number as u8,
            state,
            device_time: header.time,
        }))
    };
    let button = |number: usize, state: i32| match state {
        0 | 1 => Ok(control(number, ControlState::Button(state == 1))),
        _ => Err(DropReason::Field),
    };
    match kind {
        POSE => {
            let (sensor, _) = (integer(&mut body)?, integer(&mut body)?);
            if !(0..SENSORS).contains(&sensor) {
                return Err(DropReason::Field);
            }
            let position = valid::position(vector(&mut body)? * *metres)?;
            let Vec3 { x, y, z } = vector(&mut body)?;
            let orientation = rotation(Quat::from_xyzw(x, y, z, number(&mut body)?))?;
            sink(Event::Sample(Sample {
                device_time: header.time,
                sensor: sensor as u8,
                head: Head {
                    position: Some(Reading::tracked(axes.position(position))),
                    orientation: Some(Reading::tracked(axes.orientation(orientation))),
                    angular_velocity: None,
                },
                ..Sample::arrived(arrival)
            }));
        }
        BUTTON => {
            let (number, state) = (integer(&mut body)?, integer(&mut body)?);
            if !(0..MOST_BUTTONS).contains(&number) {
                return Err(DropReason::Field);
            }
            sink(button(number as usize, state)?);
        }
        BUTTONS => {
            let count = integer(&mut body)?;
            let states = body.0.as_chunks().0;
            if !(0..=MOST_BUTTONS).contains(&count) || states.len() != count as usize {
                return Err(DropReason::Field);
            }
            for (number, &state) in states.iter().enumerate() {
                sink(button(number, i32::from_be_bytes(state))?);
            }
            body.0 = body.0.get(4 * states.len()..).unwrap_or_default();
        }
        ANALOG => {
            let channels = body.0.len() / 8;
            let count = f64::from_be_bytes(body.take()?);
            if channels == 0 || channels > MOST_CHANNELS + 1 || count != (channels - 1) as f64 {
                return Err(DropReason::Field);
            }
            for channel in 0..channels - 1 {
                sink(control(channel, ControlState::Axis(number(&mut body)?)));
            }
        }
        TEXT => {
            let _: [u8; 8] = body.take()?;
            sink(Event::Message(Message::Text(Text::new(body.0))));
            body.0 = &[];
        }
        _ => {}
    }
    body.end()
}

#[cfg(test)]
mod tests;
