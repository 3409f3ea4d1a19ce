//! Lab Streaming Layer: streams of channels, found by questions over UDP, sent over TCP.
//!
//! # The way to a stream
//!
//! 1. Send a [`query`] to UDP port [`DISCOVERY_PORT`] of each of [`GROUPS`] and of 127.0.0.1, twice a
//!    second; [`read_reply`] reads each outlet's answer. One outlet answers several times: its
//!    [`Info::uid`] tells. One host is asked on its ports from [`FIRST_PORT`] on, [`PORTS`] of them.
//! 2. Connect to [`Info::data_port`] of the answer's sender, send [`FULL_INFO`] and read XML until the
//!    outlet closes; [`labels`] finds the channels' names in it.
//! 3. Connect again, send a [`feed_request`], and hand what comes to a [`Feed`].
//! 4. Times are the outlet's: send a [`time_request`] to UDP port [`Info::service_port`], eight of them
//!    64 ms apart every few seconds; of the [`read_echo`]s the one of the least round trip counts.
//!
//! A stream that sends nothing for 15 s is to be looked for again, by its source id: an outlet
//! that was restarted has another uid, other ports and often another clock.
//!
//! A feed is read in protocol 1.10 of either byte order, and 1.00. Neither has a check beside two
//! test patterns at the start, and no length: a lost byte ends the stream.

mod feed;

pub use feed::{Feed, MOST_CHANNELS, MOST_TEXT, Received, Record, Value};

use crate::decoder::DropReason;
use crate::time::Micros;
use core::fmt::Write;
use core::str::FromStr;
use heapless::String;

/// The UDP port that all outlets of a host share.
pub const DISCOVERY_PORT: u16 = 16_571;
/// The first of an outlet's usual ports, TCP and UDP.
pub const FIRST_PORT: u16 = 16_572;
/// Number of an outlet's usual ports.
pub const PORTS: u16 = 32;
/// The IPv4 addresses that are asked: the link's and the site's.
pub const GROUPS: [[u8; 4]; 4] = [
    [255, 255, 255, 255],
    [224, 0, 0, 1],
    [224, 0, 0, 183],
    [239, 255, 172, 215],
];
/// The request for a stream's description.
pub const FULL_INFO: &str = "LSL:fullinfo\r\n";
/// The request for samples in protocol 1.00.
pub const FEED_REQUEST_100: &str = "LSL:streamfeed\r\n360 0\r\n";
/// Most bytes of an answer to a query.
pub const LONGEST_REPLY: usize = 4_096;
/// Most bytes of a request.
pub const LONGEST_REQUEST: usize = 256;

/// The type of a stream's channels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// `float32`
    Float32,
    /// `double64`
    Double64,
    /// `string`
    Text,
    /// `int32`
    Int32,
    /// `int16`
    Int16,
    /// `int8`
    Int8,
    /// `int64`
    Int64,
}

impl Format {
    /// All formats with their names.
    pub const ALL: [(&'static str, Self); 7] = [
        ("float32", Self::Float32),
        ("double64", Self::Double64),
        ("string", Self::Text),
        ("int32", Self::Int32),
        ("int16", Self::Int16),
        ("int8", Self::Int8),
        ("int64", Self::Int64),
    ];

    /// Returns the bytes of a number; 0 for text.
    const fn bytes(self) -> u8 {
        match self {
            Self::Text => 0,
            Self::Int8 => 1,
            Self::Int16 => 2,
            Self::Float32 | Self::Int32 => 4,
            Self::Double64 | Self::Int64 => 8,
        }
    }
}

/// The description of a stream.
#[derive(Debug, Clone, PartialEq)]
pub struct Info {
    /// The stream's name.
    pub name: String<64>,
    /// The stream's type, such as `Gaze`; may be empty.
    pub kind: String<64>,
    /// The outlet's id, another one after each start.
    pub uid: String<40>,
    /// The device's id, the same after each start; may be empty.
    pub source_id: String<64>,
    /// The host's name.
    pub host: String<64>,
    /// Number of channels, 1 to [`MOST_CHANNELS`].
    pub channels: u8,
    /// The channels' type.
    pub format: Format,
    /// Samples per second; 0: irregular.
    pub rate: f64,
    /// TCP port of descriptions and samples.
    pub data_port: u16,
    /// UDP port of the time.
    pub service_port: u16,
}

/// Returns the datagram that asks for the streams that fit `selector`, such as `type='Gaze'` or
/// `name='eyes'` without quotes inside, or all if it is empty. Outlets answer to UDP `port` with
/// `id`. `None` for one that is too long.
pub fn query(selector: &str, port: u16, id: u32) -> Option<String<LONGEST_REQUEST>> {
    let mut text = String::new();
    write!(text, "LSL:shortinfo\r\n{selector}\r\n{port} {id}\r\n").ok()?;
    Some(text)
}

/// Returns the request for a stream's samples in protocol 1.10; the outlet keeps 360 that were not
/// read yet. `None` for a uid that is too long.
pub fn feed_request(uid: &str) -> Option<String<LONGEST_REQUEST>> {
    let mut text = String::new();
    write!(
        text,
        "LSL:streamfeed/110 {uid}\r\nNative-Byte-Order: 1234\r\nMax-Buffer-Length: 360\r\n\r\n"
    )
    .ok()?;
    Some(text)
}

/// Returns the datagram that asks for the outlet's time at `now`.
pub fn time_request(wave: u32, now: Micros) -> Option<String<LONGEST_REQUEST>> {
    let (seconds, micros) = (now.0 / 1_000_000, now.0 % 1_000_000);
    let mut text = String::new();
    write!(text, "LSL:timedata\r\n{wave} {seconds}.{micros:06}\r\n").ok()?;
    Some(text)
}

/// An answer to a [`time_request`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Echo {
    /// The number of the request.
    pub wave: u32,
    /// The outlet's clock less the caller's: microseconds, wrong by half the round trip at most.
    pub offset: i64,
    /// Time that the request and the answer were under way.
    pub round_trip: Micros,
}

/// Reads an answer to a time request, which came at `arrival`.
///
/// # Errors
/// An answer that is cut or no answer, or times that cannot be.
pub fn read_echo(datagram: &[u8], arrival: Micros) -> Result<Echo, DropReason> {
    let text = core::str::from_utf8(datagram).map_err(|_| DropReason::Field)?;
    let mut words = text.split_ascii_whitespace();
    let mut word = || words.next().ok_or(DropReason::Length);
    let wave = parse(word()?)?;
    let mut time = || {
        let seconds: f64 = parse(word()?)?;
        let micros = seconds * 1e6;
        if (0.0..9e15).contains(&micros) {
            Ok((micros + 0.5) as i64)
        } else {
            Err(DropReason::OutOfRange)
        }
    };
    let [sent, received, answered] = [time()?, time()?, time()?];
    let arrival = arrival.0.min(9e15 as u64) as i64;
    let round_trip = (arrival - sent) - (answered - received);
    if arrival < sent || answered < received || round_trip < 0 {
        return Err(DropReason::OutOfRange);
    }
    Ok(Echo {
        wave,
        offset: i64::midpoint(received - sent, answered - arrival),
        round_trip: Micros(round_trip as u64),
    })
}

/// Reads an answer to a [`query`]: the query's id, and the stream.
///
/// # Errors
/// What [`read_info`] says, and a datagram without an id or of more than [`LONGEST_REPLY`] bytes.
pub fn read_reply(datagram: &[u8]) -> Result<(u32, Info), DropReason> {
    if datagram.len() > LONGEST_REPLY {
        return Err(DropReason::Length);
    }
    let text = core::str::from_utf8(datagram).map_err(|_| DropReason::Field)?;
    let (id, xml) = text.split_once('\n').ok_or(DropReason::Length)?;
    Ok((parse(id)?, read_info(xml)?))
}

/// Reads a stream's description.
///
/// # Errors
/// One that is cut, lacks a name, a uid or a port, or has more channels or longer names than are
/// read.
pub fn read_info(xml: &str) -> Result<Info, DropReason> {
    if !xml.trim_ascii_end().ends_with("</info>") {
        return Err(DropReason::Truncated);
    }
    let field = |tag| elements(xml, tag).next();
    let needed = |tag| field(tag).filter(|text| !text.is_empty());
    let needed = |tag| needed(tag).ok_or(DropReason::Field);
    let optional = |tag| unescape(field(tag).unwrap_or_default());
    let format = needed("channel_format")?;
    let format = Format::ALL.iter().find(|(name, _)| *name == format);
    let channels: u8 = parse(needed("channel_count")?)?;
    let rate: f64 = parse(needed("nominal_srate")?)?;
    let ports = [needed("v4data_port")?, needed("v4service_port")?].map(parse::<u16>);
    let [data_port, service_port] = ports;
    let is_usable = (1..=MOST_CHANNELS).contains(&usize::from(channels))
        && (rate == 0.0 || (1e-3..=1e6).contains(&rate));
    let info = Info {
        name: unescape(needed("name")?)?,
        kind: optional("type")?,
        uid: unescape(needed("uid")?)?,
        source_id: optional("source_id")?,
        host: optional("hostname")?,
        channels,
        format: format.ok_or(DropReason::Unknown)?.1,
        rate,
        data_port: data_port?,
        service_port: service_port?,
    };
    if is_usable && info.data_port != 0 && info.service_port != 0 {
        Ok(info)
    } else {
        Err(DropReason::Field)
    }
}

/// Returns the channels' labels in a full description, in their order; those that are longer than
/// 64 bytes are empty.
pub fn labels(xml: &str) -> impl Iterator<Item = String<64>> {
    let labels = elements(xml, "label").take(MOST_CHANNELS);
    labels.map(|label| unescape(label).unwrap_or_default())
}

/// Returns the text of the elements of this name, up to the next `<`.
fn elements<'a>(xml: &'a str, tag: &str) -> impl Iterator<Item = &'a str> {
    let pieces = xml.split('<');
    pieces.filter_map(move |piece| piece.strip_prefix(tag)?.strip_prefix('>'))
}

/// Returns the text that an element's text stands for.
fn unescape<const N: usize>(text: &str) -> Result<String<N>, DropReason> {
    const ENTITIES: [(&str, char); 5] = [
        ("&lt;", '<'),
        ("&gt;", '>'),
        ("&quot;", '"'),
        ("&apos;", '\''),
        ("&amp;", '&'),
    ];
    let mut plain = String::new();
    let mut rest = text;
    while let Some(first) = rest.chars().next() {
        let entity = ENTITIES.iter().find(|(name, _)| rest.starts_with(name));
        let (length, stands_for) =
            entity.map_or((first.len_utf8(), first), |(name, c)| (name.len(), *c));
        plain.push(stands_for).map_err(|_| DropReason::Length)?;
        rest = rest.get(length..).unwrap_or_default();
    }
    Ok(plain)
}

fn parse<T: FromStr>(text: &str) -> Result<T, DropReason> {
    text.trim_ascii().parse().map_err(|_| DropReason::Field)
}

#[cfg(test)]
mod tests;
