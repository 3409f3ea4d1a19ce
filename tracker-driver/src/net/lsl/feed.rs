//! The decoder of a stream's samples.

use super::Format;
use crate::decoder::{Counts, DropReason, Event, Message};
use crate::net::count_bytes;
use crate::time::{DeviceTime, Micros};
use heapless::Vec;

/// Most channels of a stream.
pub const MOST_CHANNELS: usize = 64;
/// Most bytes of a channel's text that are kept, and half of those of a record's.
pub const MOST_TEXT: usize = 256;
/// Most bytes of a text, or of the description in protocol 1.00, that are skipped.
const LONGEST_TEXT: u64 = 65_536;
/// Most bytes of the header.
const LONGEST_HEADER: u32 = 4_096;
/// Most bytes of a line of the header that are read.
const LONGEST_LINE: usize = 128;
/// Bytes of the first line up to its number.
const STATUS: usize = 11;
/// The first byte of protocol 1.00.
const MAGIC: u8 = 0x7F;
/// The version of that protocol's numbers.
const ARCHIVE_VERSION: u64 = 9;
/// The time of both test patterns.
const PATTERN_TIME: f64 = 123_456.789;
/// What the test patterns' numbers begin at.
const PATTERN_OFFSETS: [i64; 2] = [4, 2];

/// What a feed hands over.
#[derive(Debug, Clone, Copy)]
// An event is large, and cannot be boxed.
#[allow(clippy::large_enum_variant)]
pub enum Received<'a> {
    /// A sample of all channels.
    Record(Record<'a>),
    /// The outlet's refusal, a [`Message::Fault`], or bytes that were dropped.
    Event(Event),
}

/// A sample of all channels.
#[derive(Debug, Clone, Copy)]
pub struct Record<'a> {
    feed: &'a Feed,
    /// The outlet's time: finite seconds, not below 0.
    pub time: f64,
    /// Whether the time is the last one and a period: the outlet sent none.
    pub is_deduced: bool,
    /// When its last byte came in.
    pub arrival: Micros,
}

impl<'a> Record<'a> {
    /// Returns the outlet's time, to a microsecond.
    pub fn device_time(&self) -> DeviceTime {
        DeviceTime::unwrapped((self.time * 1e6 + 0.5) as u64)
    }

    /// Returns the channels' values in their order.
    pub fn values(&self) -> impl Iterator<Item = Value<'a>> {
        let feed = self.feed;
        let values = feed.values.iter();
        values.map(move |&bits| match feed.format {
            Format::Float32 => Value::Number(f64::from(f32::from_bits(bits as u32))),
            Format::Double64 => Value::Number(f64::from_bits(bits)),
            Format::Int8 => Value::Integer(i64::from(bits as i8)),
            Format::Int16 => Value::Integer(i64::from(bits as i16)),
            Format::Int32 => Value::Integer(i64::from(bits as i32)),
            Format::Int64 => Value::Integer(bits as i64),
            Format::Text => {
                let (start, length) = ((bits >> 32) as usize, bits as u32 as usize);
                let text = feed.text.get(start..start.saturating_add(length));
                Value::Text(text.unwrap_or_default())
            }
        })
    }
}

/// The value of a channel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Value<'a> {
    /// Any number, also infinite and NaN.
    Number(f64),
    /// A whole number.
    Integer(i64),
    /// Bytes of a text, cut at [`MOST_TEXT`].
    Text(&'a [u8]),
}

/// The place in the byte stream.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Stage {
    /// The header's first line, and its others.
    Status,
    Header,
    /// Protocol 1.00: its first byte, version, description's length, description, two numbers.
    Magic,
    Version,
    InfoLength,
    Info(u64),
    Class(u8),
    Tag,
    Time,
    Channel,
    /// So many bytes of a channel's text are to come, and so many were kept.
    Text(u64, u32),
    Lost,
}

/// What a byte completed.
enum Done {
    Nothing,
    Record,
    Refused(u32),
}

/// Decodes the samples of one connection.
#[derive(Debug, Clone)]
pub struct Feed {
    format: Format,
    channels: u8,
    /// Seconds from one sample to the next; 0: irregular.
    period: f64,
    counts: Counts,
    stage: Stage,
    /// Bytes since the last whole record.
    pending: u32,
    line: Vec<u8, LONGEST_LINE>,
    is_archive: bool,
    is_big_endian: bool,
    number: Number,
    patterns: usize,
    time: f64,
    is_deduced: bool,
    /// A number's bits, or a text's place and length.
    values: Vec<u64, MOST_CHANNELS>,
    text: Vec<u8, { 2 * MOST_TEXT }>,
}

impl Feed {
    /// Returns a decoder of a stream of 1 to [`MOST_CHANNELS`] channels and this many samples a
    /// second; 0: irregular.
    pub fn new(format: Format, channels: u8, rate: f64) -> Self {
        let channels = channels.clamp(1, MOST_CHANNELS as u8);
        let period = if rate > 0.0 { 1.0 / rate } else { 0.0 };
        Self::begin(format, channels, period, Counts::default())
    }

    const fn begin(format: Format, channels: u8, period: f64, counts: Counts) -> Self {
        Self {
            format,
            channels,
            period,
            counts,
            stage: Stage::Status,
            pending: 0,
            line: Vec::new(),
            is_archive: false,
            is_big_endian: false,
            number: Number::NONE,
            patterns: 0,
            time: 0.0,
            is_deduced: false,
            values: Vec::new(),
            text: Vec::new(),
        }
    }

    /// Returns whether the stream cannot be read any further: close the connection.
    pub fn is_lost(&self) -> bool {
        self.stage == Stage::Lost
    }

    /// Returns counts of the bytes and records so far.
    pub const fn counts(&self) -> &Counts {
        &self.counts
    }

    /// Takes the next bytes, the last of which came in at `arrival`.
    pub fn feed(
        &mut self,
        bytes: &[u8],
        arrival: Micros,
        sink: &mut dyn for<'a> FnMut(Received<'a>),
    ) {
        count_bytes(&mut self.counts, bytes);
        let mut rest = bytes;
        while let Some((&byte, behind)) = rest.split_first() {
            if self.is_lost() {
                return self.hand_over(
                    Event::dropped(rest.len() as u32, DropReason::OutOfStep),
                    sink,
                );
            }
            rest = behind;
            self.pending = self.pending.saturating_add(1);
            match self.push(byte) {
                Ok(Done::Nothing) => {}
                Ok(Done::Record) => self.end_record(arrival, sink),
                Ok(Done::Refused(code)) => {
                    let meaning = match code {
                        404 => "the stream is not there any more",
                        505 => "the outlet does not speak protocol 1.10",
                        _ => "",
                    };
                    self.stage = Stage::Lost;
                    self.hand_over(Event::Message(Message::Fault { code, meaning }), sink);
                }
                Err(reason) => {
                    self.stage = Stage::Lost;
                    self.drop_record(reason, sink);
                }
            }
        }
    }

    fn hand_over(&mut self, event: Event, sink: &mut dyn for<'a> FnMut(Received<'a>)) {
        self.counts.note(&event);
        sink(Received::Event(event));
    }

    fn drop_record(&mut self, reason: DropReason, sink: &mut dyn for<'a> FnMut(Received<'a>)) {
        let bytes = core::mem::take(&mut self.pending);
        self.hand_over(Event::dropped(bytes, reason), sink);
    }

    /// Expects a new connection's header.
    pub fn reset(&mut self) {
        if self.pending > 0 && !self.is_lost() {
            self.drop_record(DropReason::Truncated, &mut |_| {});
        }
        *self = Self::begin(self.format, self.channels, self.period, self.counts);
    }

    fn push(&mut self, byte: u8) -> Result<Done, DropReason> {
        match self.stage {
            Stage::Status if byte == MAGIC && self.pending == 1 => {
                (self.is_archive, self.stage) = (true, Stage::Version);
            }
            Stage::Status | Stage::Header => return self.header(byte),
            Stage::Magic if byte == MAGIC => self.stage = Stage::Version,
            Stage::Magic | Stage::Lost => return Err(DropReason::Unknown),
            Stage::Info(left) => {
                self.stage = if left > 1 {
                    Stage::Info(left - 1)
                } else {
                    Stage::Class(0)
                };
            }
            Stage::Text(left, kept) => return Ok(self.text_byte(byte, left, kept)),
            stage => {
                let width = match stage {
                    _ if self.is_archive => Width::Archive,
                    Stage::Tag => Width::Bytes(1),
                    Stage::Time => Width::Bytes(8),
                    _ if self.format == Format::Text => Width::Prefix,
                    _ => Width::Bytes(self.format.bytes()),
                };
                if let Some(number) = self.number.push(byte, width, self.is_big_endian)? {
                    return self.take(stage, number);
                }
            }
        }
        Ok(Done::Nothing)
    }

    /// Takes the number that a stage waited for.
    fn take(&mut self, stage: Stage, number: u64) -> Result<Done, DropReason> {
        self.stage = match stage {
            Stage::Version if number == ARCHIVE_VERSION => Stage::InfoLength,
            Stage::Version => return Err(DropReason::Unknown),
            Stage::InfoLength if (1..=LONGEST_TEXT).contains(&number) => Stage::Info(number),
            Stage::InfoLength => return Err(DropReason::Length),
            Stage::Class(0) if number == 0 => Stage::Class(1),
            Stage::Class(1) if number == 0 => Stage::Tag,
            Stage::Tag if number == 1 => {
                self.is_deduced = true;
                self.time += self.period;
                Stage::Channel
            }
            Stage::Tag if number == 2 => Stage::Time,
            Stage::Time => {
                (self.is_deduced, self.time) = (false, f64::from_bits(number));
                Stage::Channel
            }
            Stage::Channel if self.format == Format::Text => {
                if number > LONGEST_TEXT {
                    return Err(DropReason::Length);
                }
                let start = self.text.len() as u64;
                // No more values than channels: a record ends with its last.
                let _ = self.values.push(start << 32);
                if number == 0 {
                    return Ok(self.end_value());
                }
                Stage::Text(number, 0)
            }
            Stage::Channel => {
                let _ = self.values.push(number);
                return Ok(self.end_value());
            }
            _ => return Err(DropReason::Field),
        };
        Ok(Done::Nothing)
    }

    fn text_byte(&mut self, byte: u8, left: u64, kept: u32) -> Done {
        let is_kept = kept < MOST_TEXT as u32 && self.text.push(byte).is_ok();
        if is_kept && let Some(value) = self.values.last_mut() {
            *value += 1;
        }
        self.stage = Stage::Text(left.saturating_sub(1), kept + u32::from(is_kept));
        if left > 1 {
            return Done::Nothing;
        }
        self.end_value()
    }

    fn end_value(&mut self) -> Done {
        if self.values.len() < usize::from(self.channels) {
            self.stage = Stage::Channel;
            return Done::Nothing;
        }
        self.stage = Stage::Tag;
        Done::Record
    }

    fn end_record(&mut self, arrival: Micros, sink: &mut dyn for<'a> FnMut(Received<'a>)) {
        let record = Record {
            feed: self,
            time: self.time,
            is_deduced: self.is_deduced,
            arrival,
        };
        if let Some(&offset) = PATTERN_OFFSETS.get(self.patterns) {
            let is_right = record.is_pattern(offset);
            self.patterns += 1;
            // No time is deduced from a pattern's.
            self.time = f64::NAN;
            if !is_right {
                self.stage = Stage::Lost;
                self.drop_record(DropReason::Field, sink);
            }
        } else if (0.0..9e9).contains(&self.time) {
            sink(Received::Record(record));
            self.counts.samples = self.counts.samples.saturating_add(1);
        } else {
            self.drop_record(DropReason::OutOfRange, sink);
        }
        self.pending = 0;
        self.values.clear();
        self.text.clear();
    }

    /// Takes the header's next byte.
    fn header(&mut self, byte: u8) -> Result<Done, DropReason> {
        if self.pending > LONGEST_HEADER {
            return Err(DropReason::Length);
        }
        if byte != b'\n' {
            // The rest of a longer line is not read.
            let _ = self.line.push(byte);
            // A refusal has no end of line.
            if self.stage == Stage::Status && self.line.len() == STATUS {
                return self.status();
            }
            return Ok(Done::Nothing);
        }
        let line = core::mem::take(&mut self.line);
        let line = line.trim_ascii();
        if self.stage == Stage::Status {
            if line.len() < STATUS {
                return Err(DropReason::Unknown);
            }
            self.stage = Stage::Header;
        } else if line.is_empty() {
            self.stage = if self.is_archive {
                Stage::Magic
            } else {
                Stage::Tag
            };
        } else if let Some(colon) = line.iter().position(|&byte| byte == b':') {
            let (key, value) = line.split_at_checked(colon).unwrap_or_default();
            let value = value.get(1..).unwrap_or_default().trim_ascii();
            if key.eq_ignore_ascii_case(b"Byte-Order") {
                // 0 is the order that was asked for.
                self.is_big_endian = match value {
                    b"0" | b"1234" => false,
                    b"4321" => true,
                    _ => return Err(DropReason::Field),
                };
            } else if key.eq_ignore_ascii_case(b"Data-Protocol-Version") {
                self.is_archive = match value {
                    b"100" => true,
                    b"110" => false,
                    _ => return Err(DropReason::Unknown),
                };
            }
        }
        Ok(Done::Nothing)
    }

    /// Reads the beginning of the first line, such as `LSL/110 200`.
    fn status(&self) -> Result<Done, DropReason> {
        let code = match *self.line {
            [b'L', b'S', b'L', b'/', b'1', _, _, b' ', a, b, c] => [a, b, c],
            _ => return Err(DropReason::Unknown),
        };
        if !code.iter().all(u8::is_ascii_digit) {
            return Err(DropReason::Unknown);
        }
        let code = code
            .iter()
            .fold(0, |code, digit| code * 10 + u32::from(digit - b'0'));
        Ok(match code {
            200 => Done::Nothing,
            code => Done::Refused(code),
        })
    }
}

impl Record<'_> {
    /// Returns whether it is the test pattern of this offset, bit by bit.
    fn is_pattern(&self, offset: i64) -> bool {
        let mut expected = (0..).map(|channel| {
            let sign = if channel % 2 == 0 { 1 } else { -1 };
            let number = |base: i64| sign * (base + offset + channel);
            let small = |base: i64, most: i64| sign * ((base + offset + channel) % most);
            match self.feed.format {
                Format::Float32 => Value::Number(number(0) as f64),
                Format::Double64 => Value::Number(number(16_777_217) as f64),
                Format::Int8 => Value::Integer(small(1, i64::from(i8::MAX))),
                Format::Int16 => Value::Integer(small(257, i64::from(i16::MAX))),
                Format::Int32 => Value::Integer(number(65_537)),
                Format::Int64 => Value::Integer(number(2_147_483_649)),
                Format::Text => Value::Integer(sign * (channel + 10)),
            }
        });
        let is_value = |value| {
            let number = match value {
                Value::Text(text) => core::str::from_utf8(text)
                    .ok()
                    .and_then(|text| text.parse().ok())
                    .map(Value::Integer),
                number => Some(number),
            };
            number == expected.next()
        };
        self.time == PATTERN_TIME && !self.is_deduced && self.values().all(is_value)
    }
}

/// How a number's length is known.
#[derive(Debug, Clone, Copy)]
enum Width {
    /// So many bytes.
    Bytes(u8),
    /// A byte before it says 1, 2, 4 or 8.
    Prefix,
    /// A byte before it says how many, little-endian, below 0 of a number below 0.
    Archive,
}

/// The bytes of a number, as far as they came.
#[derive(Debug, Clone)]
struct Number {
    bytes: Vec<u8, 8>,
    /// Number of its bytes; 0: not known yet.
    wanted: u8,
    is_negative: bool,
}

impl Number {
    const NONE: Self = Self {
        bytes: Vec::new(),
        wanted: 0,
        is_negative: false,
    };

    /// Takes the next byte; returns the number, its missing bytes filled by the sign, after its last.
    fn push(
        &mut self,
        byte: u8,
        width: Width,
        is_big_endian: bool,
    ) -> Result<Option<u64>, DropReason> {
        if self.wanted == 0 {
            let count = byte as i8;
            match width {
                Width::Bytes(bytes) => self.wanted = bytes,
                Width::Archive if count == 0 => return Ok(Some(0)),
                Width::Archive if count.unsigned_abs() <= 8 => {
                    (self.wanted, self.is_negative) = (count.unsigned_abs(), count < 0);
                    return Ok(None);
                }
                Width::Prefix if matches!(byte, 1 | 2 | 4 | 8) => {
                    self.wanted = byte;
                    return Ok(None);
                }
                _ => return Err(DropReason::Field),
            }
        }
        // It has room: at most 8 are wanted.
        let _ = self.bytes.push(byte);
        if self.bytes.len() < usize::from(self.wanted) {
            return Ok(None);
        }
        let number = core::mem::replace(self, Self::NONE);
        let mut bytes = [if number.is_negative { 0xFF } else { 0 }; 8];
        let places = bytes.iter_mut().zip(&number.bytes);
        places.for_each(|(place, byte)| *place = *byte);
        if is_big_endian
            && !matches!(width, Width::Archive)
            && let Some(own) = bytes.get_mut(..number.bytes.len())
        {
            own.reverse();
        }
        Ok(Some(u64::from_le_bytes(bytes)))
    }
}
