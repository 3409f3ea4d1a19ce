//! The link of our own between a tracker and a host: for a bridge board that
//! gathers several trackers, for recordings, and for the mock.
//!
//! # Wire format
//!
//! A frame is [COBS] encoded between two zero bytes, so that zero bytes stand
//! nowhere else. Frames have one in front *and* one behind: a delimiter that
//! is lost between two frames does not cost either. All numbers are
//! little-endian; those of `f32` keep their bits.
//!
//! | Byte | Content |
//! |---|---|
//! | 0 | version: [`VERSION`] |
//! | 1 | kind, from the table below |
//! | 2 | counts the frames; wraps at 256 |
//! | 3 and on | body |
//! | last two | CRC-16/IBM-3740 of all before (polynomial 0x1021, from 0xFFFF) |
//!
//! | Kind | Body |
//! |---|---|
//! | 1 sample | u32 which fields there are, u32 which of them are tracked, u8 sensor, then those fields |
//! | 2 text | up to 64 bytes of ASCII |
//! | 3 fault | u32 code |
//! | 4 reply | u32 to which command, u32 result |
//! | 5 state | u32 code |
//! | 6 eyes | u8 event (0 blink, 1 closed, 2 opened, 3 lost, 4 found, 5 saccade, 6 fixation), u8 eye (0 either, 1 left, 2 right), u8 which there are: bit 0 u64 time, bit 1 u64 wraps at, bit 2 u64 duration, then those |
//! | 16 command, to the device | u8 0 stop, 1 start, or 2 and u16 samples per second |
//!
//! The fields of a sample, in their order:
//!
//! | Bit | Field | |
//! |---|---|---|
//! | 0 | device time | u64 microseconds |
//! | 1 | … wraps at, if it does | u64 microseconds |
//! | 2 | sequence | u32 |
//! | 3 | head position (t) | f32 x, y, z, metres |
//! | 4 | head orientation (t) | f32 x, y, z, w |
//! | 5 | head angular velocity | f32 x, y, z, rad/s |
//! | 6, 10, 14 | origin of the left, right, combined eye (t) | f32 x, y, z, metres |
//! | 7, 11, 15 | … direction (t) | f32 x, y, z |
//! | 8, 12, 16 | … pupil | f32 |
//! | 9, 13, 17 | … openness | f32, 0 to 1 |
//! | 18 | gaze point (t) | f32 x, y |
//! | 19 | set: the eyes are in the tracker's frame; otherwise in the head's | – |
//! | 20, 21, 22 | set: the left, right, combined pupil is raw; otherwise in metres | – |
//! | 23, 24 | gaze point: 0 on a plane, 1 normalized, 2 raw | – |
//! | 25 to 31 | 0 | – |
//!
//! Those with (t) have a tracked bit in the second word, at the same place.
//! A frame has [`LONGEST_FRAME`] bytes at most.
//!
//! Every version keeps the delimiters, the version's byte and the CRC at the
//! end, so that frames of a version to come are told apart from damage.
//!
//! # How far the decoder can be trusted
//!
//! A fault costs the frames that it touches and no other. CRC-16 notices
//! every change within 16 bits; a fault in a byte of the COBS encoding moves
//! two places of the frame, and passes once in 65,536. Random bytes pass for
//! a frame with a probability below 2⁻⁸ (delimiter) 2⁻⁸ (version) 2⁻⁵ (kind)
//! 2⁻⁸ (length) 2⁻¹⁶ (CRC) = 2⁻⁴⁵ at each byte. Over all single-byte faults
//! at all offsets of a stream of 20 samples no wrong sample came through
//! (`cargo test -p shisen-tracker link::tests::every`).
//!
//! [COBS]: https://doi.org/10.1109/90.769765

mod frame;

use crate::decoder::{
    Counts, Decoder, DropReason, Dropped, Event, EyeEvent, EyeEventKind, MOST_MESSAGE_BYTES,
    Message, Reply, Side, Text,
};
use crate::sample::{Eye, GazeFrame, GazePoint, Head, Pupil, Reading, Sample};
use crate::time::{DeviceTime, Micros};
use crate::valid;
use frame::{Content, Frames, Received};
pub use frame::{Frame, LONGEST_FRAME};
use glam::{Quat, Vec2, Vec3};

/// The version that is spoken here.
pub const VERSION: u8 = 1;

/// How far a direction or a quaternion may be from norm 1. Whoever sends one
/// has normalised it in `f32`; the bits are handed on as they came.
pub const NORM_TOLERANCE: f32 = 1.0e-3;

const SAMPLE: u8 = 1;
const TEXT: u8 = 2;
const FAULT: u8 = 3;
const REPLY: u8 = 4;
const STATE: u8 = 5;
const EYES: u8 = 6;
const COMMAND: u8 = 16;

/// Version, kind and count.
const HEADER_LENGTH: usize = 3;

const TIME: u32 = 1 << 0;
const TIME_WRAPS: u32 = 1 << 1;
const SEQUENCE: u32 = 1 << 2;
const POSITION: u32 = 1 << 3;
const ORIENTATION: u32 = 1 << 4;
const ANGULAR_VELOCITY: u32 = 1 << 5;
/// Of the left eye; the right and the combined one are 4 and 8 bits on.
const ORIGIN: u32 = 1 << 6;
const DIRECTION: u32 = 1 << 7;
const PUPIL: u32 = 1 << 8;
const OPENNESS: u32 = 1 << 9;
const BITS_PER_EYE: u32 = 4;
const GAZE_POINT: u32 = 1 << 18;
const TRACKER_FRAME: u32 = 1 << 19;
/// Of the left eye; the right and the combined one are 1 and 2 bits on.
const RAW_PUPIL: u32 = 1 << 20;
const GAZE_POINT_KIND: u32 = 23;
const UNUSED: u32 = !0 << 25;
/// The fields that can be tracked.
const TRACKABLE: u32 = POSITION
    | ORIENTATION
    | GAZE_POINT
    | (ORIGIN | DIRECTION) * (1 | 1 << BITS_PER_EYE | 1 << (2 * BITS_PER_EYE));

/// What a host asks of a device that speaks the link.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Command {
    /// No more samples.
    Stop,
    /// Samples, from now on.
    Start,
    /// This many samples per second.
    Rate {
        /// At least 1.
        hertz: u16,
    },
}

/// Writes frames and counts them.
#[derive(Debug, Clone, Default)]
pub struct Encoder {
    count: u8,
}

impl Encoder {
    /// An encoder whose first frame has count 0.
    pub fn new() -> Self {
        Self::default()
    }

    /// The frame of a sample. Its time of arrival is not sent: who receives
    /// it has another clock.
    ///
    /// What is not a number, or no unit vector, is sent like the rest, and
    /// refused by the decoder.
    pub fn sample(&mut self, sample: &Sample) -> Frame {
        let mut content = self.begin(SAMPLE);
        write_sample(&mut content, sample);
        content.finish()
    }

    /// The frame of a message. The meaning of a fault or a state is not sent,
    /// only its code.
    pub fn message(&mut self, message: &Message) -> Frame {
        let mut content;
        match message {
            Message::Text(text) => {
                content = self.begin(TEXT);
                content.push(text.as_str().as_bytes());
            }
            Message::Fault { code, .. } => {
                content = self.begin(FAULT);
                content.push(&code.to_le_bytes());
            }
            Message::State { code, .. } => {
                content = self.begin(STATE);
                content.push(&code.to_le_bytes());
            }
            Message::Reply(reply) => {
                content = self.begin(REPLY);
                content.push(&reply.to.to_le_bytes());
                content.push(&reply.result.to_le_bytes());
            }
            Message::Eyes(event) => {
                content = self.begin(EYES);
                write_eye_event(&mut content, event);
            }
        }
        content.finish()
    }

    /// The frame of a command, from the host to the device.
    pub fn command(&mut self, command: Command) -> Frame {
        let mut content = self.begin(COMMAND);
        match command {
            Command::Stop => content.push(&[0]),
            Command::Start => content.push(&[1]),
            Command::Rate { hertz } => {
                content.push(&[2]);
                content.push(&hertz.to_le_bytes());
            }
        }
        content.finish()
    }

    fn begin(&mut self, kind: u8) -> Content {
        let mut content = Content::default();
        content.push(&[VERSION, kind, self.count]);
        self.count = self.count.wrapping_add(1);
        content
    }
}

/// The decoder of what a device sends.
#[derive(Debug, Clone, Default)]
pub struct Link {
    frames: Frames,
    counts: Counts,
    /// The count and the CRC of the last intact frame.
    last: Option<(u8, u16)>,
}

impl Link {
    /// A decoder that has seen nothing.
    pub fn new() -> Self {
        Self::default()
    }

    /// Counts the frames that are missing; whether this one is the last one
    /// again.
    fn repeats(&mut self, count: u8, crc: u16) -> bool {
        let last = self.last.replace((count, crc));
        let Some((last_count, last_crc)) = last else {
            return false;
        };
        let lost = count.wrapping_sub(last_count).saturating_sub(1);
        self.counts.lost = self.counts.lost.saturating_add(u64::from(lost));
        count == last_count && crc == last_crc
    }

    fn event(&mut self, received: Received, arrival: Micros) -> Event {
        let dropped = |reason| {
            Event::Dropped(Dropped {
                bytes: received.bytes,
                reason,
            })
        };
        let content = match received.content {
            Ok(content) => content,
            Err(reason) => return dropped(reason),
        };
        let (content, crc) = (content.bytes(), content.crc());
        let [version, kind, count, body @ ..] = content else {
            return dropped(DropReason::Length);
        };
        if *version != VERSION {
            return dropped(DropReason::Unknown);
        }
        if self.repeats(*count, crc) {
            return dropped(DropReason::Duplicate);
        }
        let read = match *kind {
            SAMPLE => read_sample(body, arrival).map(Event::Sample),
            kind => read_message(kind, body).map(Event::Message),
        };
        read.unwrap_or_else(dropped)
    }
}

impl Decoder for Link {
    fn feed(&mut self, bytes: &[u8], arrival: Micros, sink: &mut dyn FnMut(Event)) {
        for &byte in bytes {
            self.counts.bytes = self.counts.bytes.saturating_add(1);
            if let Some(received) = self.frames.push(byte) {
                let event = self.event(received, arrival);
                self.counts.note(&event);
                sink(event);
            }
        }
    }

    fn counts(&self) -> &Counts {
        &self.counts
    }

    fn reset(&mut self) {
        let bytes = self.frames.reset();
        if bytes > 0 {
            self.counts.note(&Event::Dropped(Dropped {
                bytes,
                reason: DropReason::Truncated,
            }));
        }
        self.last = None;
    }
}

/// The decoder of what a host sends, for the device's side. It passes over
/// everything but commands.
#[derive(Debug, Clone, Default)]
pub struct Commands {
    frames: Frames,
}

impl Commands {
    /// A decoder that has seen nothing.
    pub fn new() -> Self {
        Self::default()
    }

    /// Takes the next bytes and hands each command to `sink`.
    pub fn feed(&mut self, bytes: &[u8], sink: &mut dyn FnMut(Command)) {
        for &byte in bytes {
            let Some(Received {
                content: Ok(content),
                ..
            }) = self.frames.push(byte)
            else {
                continue;
            };
            let command = match *content.bytes() {
                [VERSION, COMMAND, _, 0] => Command::Stop,
                [VERSION, COMMAND, _, 1] => Command::Start,
                [VERSION, COMMAND, _, 2, low, high] if low != 0 || high != 0 => Command::Rate {
                    hertz: u16::from_le_bytes([low, high]),
                },
                _ => continue,
            };
            sink(command);
        }
    }
}

/// The eyes of a sample and how far their bits are from the left one's.
fn eyes(sample: &Sample) -> [(u32, &Eye); 3] {
    [(0, &sample.left), (1, &sample.right), (2, &sample.combined)]
}

fn write_sample(content: &mut Content, sample: &Sample) {
    let mut bits = Bits::default();
    let time = sample.device_time;
    bits.field(TIME, time.is_some());
    bits.field(TIME_WRAPS, time.is_some_and(|time| time.wraps_at != 0));
    bits.field(SEQUENCE, sample.sequence.is_some());
    bits.reading(POSITION, sample.head.position.as_ref());
    bits.reading(ORIENTATION, sample.head.orientation.as_ref());
    bits.field(ANGULAR_VELOCITY, sample.head.angular_velocity.is_some());
    for (n, eye) in eyes(sample) {
        let shift = n * BITS_PER_EYE;
        bits.reading(ORIGIN << shift, eye.origin.as_ref());
        bits.reading(DIRECTION << shift, eye.direction.as_ref());
        bits.field(PUPIL << shift, eye.pupil.is_some());
        bits.field(RAW_PUPIL << n, matches!(eye.pupil, Some(Pupil::Raw(_))));
        bits.field(OPENNESS << shift, eye.openness.is_some());
    }
    bits.reading(GAZE_POINT, sample.gaze_point.as_ref());
    bits.field(TRACKER_FRAME, sample.gaze_frame == GazeFrame::Tracker);
    let point = sample.gaze_point.map(|point| match point.value {
        GazePoint::Plane(point) => (0, point),
        GazePoint::Normalized(point) => (1, point),
        GazePoint::Raw(point) => (2, point),
    });
    bits.valid |= point.map_or(0, |(kind, _)| kind << GAZE_POINT_KIND);

    content.push(&bits.valid.to_le_bytes());
    content.push(&bits.tracked.to_le_bytes());
    content.push(&[sample.sensor]);
    if let Some(time) = time {
        write_time(content, time);
    }
    if let Some(sequence) = sample.sequence {
        content.push(&sequence.to_le_bytes());
    }
    let Head {
        position,
        orientation,
        angular_velocity,
    } = sample.head;
    for part in position.iter().flat_map(|p| p.value.to_array()) {
        content.push(&part.to_le_bytes());
    }
    for part in orientation.iter().flat_map(|o| o.value.to_array()) {
        content.push(&part.to_le_bytes());
    }
    for part in angular_velocity.iter().flat_map(Vec3::to_array) {
        content.push(&part.to_le_bytes());
    }
    for (_, eye) in eyes(sample) {
        for vector in [eye.origin, eye.direction].iter().flatten() {
            for part in vector.value.to_array() {
                content.push(&part.to_le_bytes());
            }
        }
        if let Some(Pupil::Diameter(size) | Pupil::Raw(size)) = eye.pupil {
            content.push(&size.to_le_bytes());
        }
        if let Some(openness) = eye.openness {
            content.push(&openness.to_le_bytes());
        }
    }
    for part in point.iter().flat_map(|(_, point)| point.to_array()) {
        content.push(&part.to_le_bytes());
    }
}

fn write_time(content: &mut Content, time: DeviceTime) {
    content.push(&time.microseconds.to_le_bytes());
    if time.wraps_at != 0 {
        content.push(&time.wraps_at.to_le_bytes());
    }
}

/// The two words of bits before a sample's fields.
#[derive(Debug, Clone, Copy, Default)]
struct Bits {
    valid: u32,
    tracked: u32,
}

impl Bits {
    fn field(&mut self, bit: u32, there: bool) {
        self.valid |= if there { bit } else { 0 };
    }

    fn reading<T>(&mut self, bit: u32, reading: Option<&Reading<T>>) {
        self.field(bit, reading.is_some());
        self.tracked |= match reading {
            Some(reading) if reading.tracked => bit,
            _ => 0,
        };
    }
}

/// What is left of a body.
struct Body<'a>(&'a [u8]);

impl Body<'_> {
    fn take<const N: usize>(&mut self) -> Result<[u8; N], DropReason> {
        let (bytes, rest) = self.0.split_first_chunk().ok_or(DropReason::Length)?;
        self.0 = rest;
        Ok(*bytes)
    }

    fn u32(&mut self) -> Result<u32, DropReason> {
        self.take().map(u32::from_le_bytes)
    }

    fn u64(&mut self) -> Result<u64, DropReason> {
        self.take().map(u64::from_le_bytes)
    }

    /// A finite number.
    fn number(&mut self) -> Result<f32, DropReason> {
        let number = f32::from_le_bytes(self.take()?);
        valid::within(number, f32::MAX)
    }

    fn vector(&mut self) -> Result<Vec3, DropReason> {
        Ok(Vec3::new(self.number()?, self.number()?, self.number()?))
    }

    /// A time, and when its clock wraps if it does.
    fn time(&mut self, wraps: bool) -> Result<DeviceTime, DropReason> {
        let microseconds = self.u64()?;
        let wraps_at = if wraps { self.u64()? } else { 0 };
        if wraps && microseconds >= wraps_at {
            return Err(DropReason::Field);
        }
        Ok(DeviceTime {
            microseconds,
            wraps_at,
        })
    }

    /// Nothing may be left over.
    fn end(&self) -> Result<(), DropReason> {
        if self.0.is_empty() {
            Ok(())
        } else {
            Err(DropReason::Length)
        }
    }
}

/// A vector that has length 1, with the bits that it came with.
fn unit(vector: Vec3) -> Result<Vec3, DropReason> {
    let norm = valid::length(&valid::place(vector, 2.0)?.to_array());
    if (norm - 1.0).abs() > NORM_TOLERANCE {
        return Err(DropReason::NotUnit);
    }
    Ok(vector)
}

fn read_sample(body: &[u8], arrival: Micros) -> Result<Sample, DropReason> {
    let mut body = Body(body);
    let (valid, tracked) = (body.u32()?, body.u32()?);
    if valid & UNUSED != 0 || tracked & !(valid & TRACKABLE) != 0 {
        return Err(DropReason::Field);
    }
    let has = |bit| valid & bit != 0;
    let is_tracked = |bit| tracked & bit != 0;
    let [sensor] = body.take()?;
    let mut sample = Sample {
        sensor,
        ..Sample::arrived(arrival)
    };
    if has(TIME) {
        sample.device_time = Some(body.time(has(TIME_WRAPS))?);
    } else if has(TIME_WRAPS) {
        return Err(DropReason::Field);
    }
    if has(SEQUENCE) {
        sample.sequence = Some(body.u32()?);
    }
    if has(POSITION) {
        sample.head.position = Some(Reading {
            value: body.vector()?,
            tracked: is_tracked(POSITION),
        });
    }
    if has(ORIENTATION) {
        let [x, y, z, w] = [
            body.number()?,
            body.number()?,
            body.number()?,
            body.number()?,
        ];
        let value = Quat::from_xyzw(x, y, z, w);
        valid::rotation(value, NORM_TOLERANCE)?;
        sample.head.orientation = Some(Reading {
            value,
            tracked: is_tracked(ORIENTATION),
        });
    }
    if has(ANGULAR_VELOCITY) {
        sample.head.angular_velocity = Some(body.vector()?);
    }
    if has(TRACKER_FRAME) {
        sample.gaze_frame = GazeFrame::Tracker;
    }
    let sides = [&mut sample.left, &mut sample.right, &mut sample.combined];
    for (n, eye) in (0..).zip(sides) {
        let shift = n * BITS_PER_EYE;
        if has(ORIGIN << shift) {
            eye.origin = Some(Reading {
                value: body.vector()?,
                tracked: is_tracked(ORIGIN << shift),
            });
        }
        if has(DIRECTION << shift) {
            eye.direction = Some(Reading {
                value: unit(body.vector()?)?,
                tracked: is_tracked(DIRECTION << shift),
            });
        }
        if has(PUPIL << shift) {
            let size = body.number()?;
            if size < 0.0 {
                return Err(DropReason::OutOfRange);
            }
            let raw = has(RAW_PUPIL << n);
            eye.pupil = Some(if raw {
                Pupil::Raw(size)
            } else {
                Pupil::Diameter(size)
            });
        } else if has(RAW_PUPIL << n) {
            return Err(DropReason::Field);
        }
        if has(OPENNESS << shift) {
            let openness = body.number()?;
            if !(0.0..=1.0).contains(&openness) {
                return Err(DropReason::OutOfRange);
            }
            eye.openness = Some(openness);
        }
    }
    let kind = (valid >> GAZE_POINT_KIND) & 0b11;
    if has(GAZE_POINT) {
        let point = Vec2::new(body.number()?, body.number()?);
        let value = match kind {
            0 => GazePoint::Plane(point),
            1 => GazePoint::Normalized(point),
            2 => GazePoint::Raw(point),
            _ => return Err(DropReason::Field),
        };
        sample.gaze_point = Some(Reading {
            value,
            tracked: is_tracked(GAZE_POINT),
        });
    } else if kind != 0 {
        return Err(DropReason::Field);
    }
    body.end()?;
    Ok(sample)
}

const HAS_TIME: u8 = 1 << 0;
const HAS_WRAP: u8 = 1 << 1;
const HAS_DURATION: u8 = 1 << 2;

/// In the order of their numbers.
const EYE_EVENTS: [EyeEventKind; 7] = [
    EyeEventKind::Blink,
    EyeEventKind::Closed,
    EyeEventKind::Opened,
    EyeEventKind::Lost,
    EyeEventKind::Found,
    EyeEventKind::Saccade,
    EyeEventKind::Fixation,
];

/// In the order of their numbers.
const SIDES: [Option<Side>; 3] = [None, Some(Side::Left), Some(Side::Right)];

fn write_eye_event(content: &mut Content, event: &EyeEvent) {
    let kind = EYE_EVENTS.iter().position(|&kind| kind == event.kind);
    let side = SIDES.iter().position(|&side| side == event.eye);
    let mut has = 0;
    if let Some(time) = event.device_time {
        has |= HAS_TIME | if time.wraps_at == 0 { 0 } else { HAS_WRAP };
    }
    if event.duration.is_some() {
        has |= HAS_DURATION;
    }
    let number = |place: Option<usize>| place.map_or(u8::MAX, |place| place as u8);
    content.push(&[number(kind), number(side), has]);
    if let Some(time) = event.device_time {
        write_time(content, time);
    }
    if let Some(duration) = event.duration {
        content.push(&duration.0.to_le_bytes());
    }
}

fn read_eye_event(body: &mut Body<'_>) -> Result<EyeEvent, DropReason> {
    let [kind, side, has] = body.take()?;
    if has & !(HAS_TIME | HAS_WRAP | HAS_DURATION) != 0 || has & (HAS_TIME | HAS_WRAP) == HAS_WRAP {
        return Err(DropReason::Field);
    }
    let kind = EYE_EVENTS.get(usize::from(kind));
    let side = SIDES.get(usize::from(side));
    let device_time = if has & HAS_TIME == 0 {
        None
    } else {
        Some(body.time(has & HAS_WRAP != 0)?)
    };
    let duration = if has & HAS_DURATION == 0 {
        None
    } else {
        Some(Micros(body.u64()?))
    };
    Ok(EyeEvent {
        kind: *kind.ok_or(DropReason::Field)?,
        eye: *side.ok_or(DropReason::Field)?,
        device_time,
        duration,
    })
}

fn read_message(kind: u8, body: &[u8]) -> Result<Message, DropReason> {
    let mut body = Body(body);
    let message = match kind {
        TEXT if body.0.len() <= MOST_MESSAGE_BYTES => {
            return Ok(Message::Text(Text::new(body.0)));
        }
        TEXT => return Err(DropReason::Length),
        FAULT => Message::Fault {
            code: body.u32()?,
            meaning: "",
        },
        REPLY => Message::Reply(Reply {
            to: body.u32()?,
            result: body.u32()?,
        }),
        STATE => Message::State {
            code: body.u32()?,
            meaning: "",
        },
        EYES => Message::Eyes(read_eye_event(&mut body)?),
        // Commands too: they are none of the host's.
        _ => return Err(DropReason::Unknown),
    };
    body.end()?;
    Ok(message)
}

#[cfg(test)]
mod tests;
