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
//! | 7 unmeasured | u16 which parts, in the order of [`Part::ALL`](crate::sample::Part::ALL) |
//! | 8 control | u8 sensor, u8 number, u8 which: bit 0 u64 time, bit 1 u64 wraps at, bit 3 an axis; f32 the axis' value, or 0 or 1 for a button; then the times |
//! | 32 to 37, 48 to 51 | between a display controller and the host that watches it: [`display`] |
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
//! A fault costs the frames that it touches and no other; none of one byte lets a wrong sample
//! through. Random bytes pass for a frame with a probability below 2⁻⁴⁵ at each byte.
//!
//! [COBS]: https://doi.org/10.1109/90.769765

pub(crate) mod body;
pub mod display;
mod fields;
mod frame;
mod messages;

use crate::command::{Awaited, PATIENCE, Script};
use crate::decoder::{Counts, Decoder, DropReason, Event, Message};
use crate::sample::Sample;
use crate::time::Micros;
use crate::valid;
use fields::{read_sample, write_sample};
use frame::{Content, Frames, LinkMessage, Received};
pub use frame::{Frame, LONGEST_FRAME, Listener};
use messages::{read_message, write_control, write_eye_event};

/// The version that is spoken here.
pub const VERSION: u8 = 1;

/// How far a direction or a quaternion may be from norm 1; its bits stay as they came.
pub const NORM_TOLERANCE: f32 = valid::UNIT_TOLERANCE;

const SAMPLE: u8 = 1;
const TEXT: u8 = 2;
const FAULT: u8 = 3;
const REPLY: u8 = 4;
const STATE: u8 = 5;
const EYES: u8 = 6;
const UNMEASURED: u8 = 7;
const CONTROL: u8 = 8;
const COMMAND: u8 = 16;

/// Version, kind and count.
const HEADER_LENGTH: usize = 3;

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
    /// Returns an encoder whose first frame has count 0.
    pub fn new() -> Self {
        Self::default()
    }

    /// Returns the frame of a sample, without its time of arrival. What is no number or unit vector
    /// is sent, and refused by the decoder.
    pub fn sample(&mut self, sample: &Sample) -> Frame {
        let mut content = self.begin(SAMPLE);
        write_sample(&mut content, sample);
        content.finish()
    }

    /// Returns the frame of a message; of a fault, a state or a reply only the code.
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
            Message::Unmeasured(parts) => {
                content = self.begin(UNMEASURED);
                content.push(&parts.bits().to_le_bytes());
            }
            Message::Control(control) => {
                content = self.begin(CONTROL);
                write_control(&mut content, control);
            }
        }
        content.finish()
    }

    /// Returns the frame of a command, from the host to the device.
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
        let mut content = Content::new();
        content.push(&[VERSION, kind, self.count]);
        self.count = self.count.wrapping_add(1);
        content
    }
}

/// Returns what makes a device send samples, `hertz` a second where that is given.
pub fn start(hertz: Option<u16>) -> Script {
    let mut encoder = Encoder::new();
    let mut script = Script::new();
    if let Some(hertz) = hertz {
        script.send(&encoder.command(Command::Rate { hertz }));
    }
    script
        .send(&encoder.command(Command::Start))
        .expect(Awaited::Sample, PATIENCE);
    script
}

/// Returns what makes it stop.
pub fn stop() -> Script {
    Script::sending(&Encoder::new().command(Command::Stop))
}

/// The decoder of what a device sends.
#[derive(Debug, Clone, Default)]
pub struct Link {
    frames: Frames,
    log: Log,
}

/// What has come so far.
#[derive(Debug, Clone, Default)]
struct Log {
    counts: Counts,
    /// The count and the CRC of the last intact frame.
    last: Option<(u8, u16)>,
}

impl Link {
    /// Returns a decoder that has seen nothing.
    pub fn new() -> Self {
        Self::default()
    }
}

impl Log {
    /// Counts the frames that are missing; whether this one is the last again.
    fn repeats(&mut self, count: u8, crc: u16) -> bool {
        let last = self.last.replace((count, crc));
        let Some((last_count, last_crc)) = last else {
            return false;
        };
        let lost = count.wrapping_sub(last_count).saturating_sub(1);
        self.counts.lost = self.counts.lost.saturating_add(u64::from(lost));
        count == last_count && crc == last_crc
    }

    // Not inlined: keeps its stack frame out of the caller's.
    #[inline(never)]
    fn event(&mut self, received: Received<'_>, arrival: Micros) -> Event {
        let dropped = |reason| Event::dropped(received.bytes, reason);
        let (content, crc) = match received.content {
            Ok(content) => content,
            Err(reason) => return dropped(reason),
        };
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
            let counted = &mut self.log.counts.bytes;
            *counted = counted.saturating_add(1);
            if let Some(received) = self.frames.push(byte) {
                let event = self.log.event(received, arrival);
                self.log.counts.note(&event);
                sink(event);
            }
        }
    }

    fn counts(&self) -> &Counts {
        &self.log.counts
    }

    fn reset(&mut self) {
        let bytes = self.frames.reset();
        if bytes > 0 {
            let cut = Event::dropped(bytes, DropReason::Truncated);
            self.log.counts.note(&cut);
        }
        self.log.last = None;
    }
}

/// The decoder of a host's commands, for the device's side.
pub type Commands = Listener<Command>;

impl LinkMessage for Command {
    fn read(kind: u8, body: &[u8]) -> Result<Self, DropReason> {
        match (kind, body) {
            (COMMAND, [0]) => Ok(Self::Stop),
            (COMMAND, [1]) => Ok(Self::Start),
            (COMMAND, &[2, low, high]) if low != 0 || high != 0 => Ok(Self::Rate {
                hertz: u16::from_le_bytes([low, high]),
            }),
            _ => Err(DropReason::Unknown),
        }
    }
}

#[cfg(test)]
mod tests;
