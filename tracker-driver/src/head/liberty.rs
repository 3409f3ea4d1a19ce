//! Polhemus Liberty, Patriot and Latus in binary form: position and
//! orientation over a serial line.
//!
//! # Records
//!
//! From VRPN's `vrpn_Tracker_Liberty.C`, which reads only the tag, the
//! station and the items; the other bytes of the header are as the makers'
//! manuals name them, and have not been seen from a device. Numbers are
//! little-endian.
//!
//! | Byte | Content |
//! |---|---|
//! | 0 | `LY`, `PA` or `LU` |
//! | 2 | station, from 1 |
//! | 3 | the command that is answered: `C` or `P` for records ([`Config::records`]) |
//! | 4 | error; a space where there is none |
//! | 5 | reserved |
//! | 6 | u16: bytes that follow the header ([`Config::size`]) |
//! | 8… | the items of the list that the station was told |
//!
//! | Item | Content |
//! |---|---|
//! | 0 | a space |
//! | 2 | x, y, z: 3 f32 |
//! | 7 | quaternion, real part first: 4 f32 |
//! | 8 | u32: milliseconds since the clock was set to zero |
//! | 10 | u32: stylus, 0 or 1; left out of a sample |
//!
//! The list 2, 7, 8, 0 makes a record of 41 bytes, with item 10 of 45.
//!
//! An answer to another command is handed over as a [`Reply`](crate::decoder::Reply) to the
//! command's letter, with the error's character as its result. A record with
//! an error is handed over with its readings not tracked, and the error as a
//! [`Message::Fault`](crate::decoder::Message::Fault) when it changes.
//!
//! # Axes
//!
//! The same as for [`fastrak`](super::fastrak).
//!
//! # How strong the check is
//!
//! No checksum, but a tag, a station, a length, and numbers that must be a pose: random bytes pass
//! as a record with a probability of about 5 · 10⁻²¹ at each byte. A [`Size::Unused`] makes that
//! 65536 times more, a command that is not looked at 128 times. Two of three changed bytes leave a
//! valid record.

use super::axes::Axes;
use super::polhemus::{Family, Header, ItemList, MOST_RECORD_BYTES, Record, Scale, Units, record};
use crate::command::{Awaited, PATIENCE, Script};
use crate::decoder::{Counts, Decoder, DropReason, Event};
use crate::sample::Sample;
use crate::stream::{Step, Stream, Window};
use crate::time::Micros;

/// Bytes before a record's items.
const HEADER_BYTES: usize = 8;

/// Most stations that one device has: a Liberty 240/16's.
pub const MOST_STATIONS: u8 = 16;

/// Longest answer to a command that is read past, beside records.
const MOST_REPLY_BYTES: usize = 128;

/// The model of the device.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Model {
    /// Liberty: up to 240 records per second and station.
    #[default]
    Liberty,
    /// Patriot: 60.
    Patriot,
    /// Latus.
    Latus,
}

impl Model {
    const ALL: [Self; 3] = [Self::Liberty, Self::Patriot, Self::Latus];

    /// Returns the bytes that its records start with.
    pub const fn tag(self) -> [u8; 2] {
        match self {
            Self::Liberty => *b"LY",
            Self::Patriot => *b"PA",
            Self::Latus => *b"LU",
        }
    }
}

/// The meaning of bytes 6 and 7 of the header.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Size {
    /// How many bytes follow, the low byte first: as the manuals have it.
    #[default]
    LittleEndian,
    /// How many follow, the high byte first.
    BigEndian,
    /// Ignored, as in VRPN: a record's length follows from its list.
    Unused,
}

/// How a device is set up.
#[derive(Debug, Clone, PartialEq)]
pub struct Config {
    /// The items of every station.
    pub items: ItemList,
    /// Unit of lengths.
    pub units: Units,
    /// Stations, 1 to [`MOST_STATIONS`]; records of others are no records.
    pub stations: u8,
    /// The device's axes.
    pub axes: Axes,
    /// The model that [`Config::encode`] writes; the decoder takes all models.
    pub model: Model,
    /// Byte 3 of a record's header; others are answers. `None` does not look at it, as VRPN
    /// does not.
    pub records: Option<[u8; 2]>,
    /// The meaning of bytes 6 and 7 of the header.
    pub size: Size,
}

impl Default for Config {
    /// [The usual items](ItemList::usual), as [`Config::new`] has them.
    fn default() -> Self {
        Self::new(ItemList::usual(Family::Liberty))
    }
}

impl Config {
    /// Returns a configuration with these items: inches, every station, the device's own axes.
    pub const fn new(items: ItemList) -> Self {
        Self {
            items,
            units: Units::Inches,
            stations: MOST_STATIONS,
            axes: Axes::FORWARD_RIGHT_DOWN,
            model: Model::Liberty,
            records: Some(*b"CP"),
            size: Size::LittleEndian,
        }
    }

    /// Returns bytes of a record.
    pub const fn record_bytes(&self) -> usize {
        HEADER_BYTES + self.items.bytes()
    }

    /// Returns the record that a device sends of a sample. What it lacks is the origin, no rotation
    /// and time 0; that, or a held reading, gives the error `*`.
    pub fn encode(&self, sample: &Sample) -> Record {
        let tracked = self.items.is_tracked(&sample.head);
        let error = if tracked { b' ' } else { b'*' };
        let [first, second] = self.model.tag();
        let station = sample.sensor.min(MOST_STATIONS - 1) + 1;
        let size = self.items.bytes() as u16;
        let [sixth, seventh] = match self.size {
            Size::LittleEndian => size.to_le_bytes(),
            Size::BigEndian => size.to_be_bytes(),
            Size::Unused => [0; 2],
        };
        let [command, _] = self.records.unwrap_or(*b"CP");
        let mut record = Record::new();
        let header = [first, second, station, command, error, 0, sixth, seventh];
        let _ = record.extend_from_slice(&header);
        self.items
            .write(sample, Scale::new(self.units, &self.axes), &mut record);
        record
    }

    /// Makes the device send these records, its clock from zero; after a reset it is away for
    /// [`RESET_TIME`]. `P` ends a stream as in VRPN; `U1` and `U0` are the manuals'.
    pub fn start(&self, reset: bool) -> Script {
        let settle = Micros::from_millis(100);
        let mut script = Script::new();
        if reset {
            script.send(&[RESET, b'\r']).pause(RESET_TIME);
        }
        script.once_only().send(b"P").pause(settle).send(b"F1\r");
        // Said either way: what it was set to before is not known.
        script.send(match self.units {
            Units::Inches => b"U0\r",
            Units::Centimetres => b"U1\r",
        });
        for station in 1..=self.stations.clamp(1, MOST_STATIONS) {
            script.send(&self.items.command(station));
        }
        script
            .pause(settle)
            .send(b"Q0\r")
            .send(b"C\r")
            .expect(Awaited::Sample, PATIENCE);
        script
    }
}

pub(crate) const RESET: u8 = 0x19;

/// How long a device is away after a reset.
pub const RESET_TIME: Micros = Micros::from_millis(10_000);

/// Returns the script that ends the stream of records.
pub fn stop() -> Script {
    Script::sending(b"P")
}

/// Decodes the records of one device.
#[derive(Debug, Clone)]
pub struct Liberty {
    stream: Stream<MOST_RECORD_BYTES>,
    config: Config,
    /// Each station's last error.
    error: [u8; MOST_STATIONS as usize],
}

impl Liberty {
    /// Returns a decoder of a device that is set up this way.
    pub fn new(config: Config) -> Self {
        Self {
            stream: Stream::default(),
            config,
            error: [b' '; MOST_STATIONS as usize],
        }
    }
}

impl Decoder for Liberty {
    fn feed(&mut self, bytes: &[u8], arrival: Micros, sink: &mut dyn FnMut(Event)) {
        let (config, error) = (&self.config, &mut self.error);
        let step = |window: Window<'_>| config.step(error, window);
        self.stream.feed(bytes, arrival, sink, step);
    }

    fn counts(&self) -> &Counts {
        &self.stream.counts
    }

    fn reset(&mut self) {
        self.stream.reset();
    }
}

/// Returns whether byte `at` is there and not allowed.
fn lacks(bytes: &[u8], at: usize, allowed: impl Fn(u8) -> bool) -> bool {
    bytes.get(at).is_some_and(|&byte| !allowed(byte))
}

impl Config {
    /// Decides about the bytes of a window; `last` are the stations' last errors.
    fn step(&self, last: &mut [u8], window: Window<'_>) -> Step {
        let bytes = window.bytes;
        let nowhere = Step::Skip(DropReason::OutOfStep);
        let starts = |model: Model| bytes.iter().zip(model.tag()).all(|(&a, b)| a == b);
        let printable = |byte: u8| byte == b' ' || byte.is_ascii_graphic();
        let stations = self.stations;
        if !Model::ALL.into_iter().any(starts)
            || lacks(bytes, 2, |station| (1..=stations).contains(&station))
            || lacks(bytes, 3, |command| {
                self.records.is_none() || printable(command) || command < b' '
            })
            || lacks(bytes, 4, printable)
        {
            return nowhere;
        }
        let Some(&[_, _, station, command, error, _, sixth, seventh]) =
            bytes.first_chunk::<HEADER_BYTES>()
        else {
            return Step::More;
        };
        let is_record = self.records.is_none_or(|all| all.contains(&command));
        let size = match self.size {
            Size::LittleEndian => u16::from_le_bytes([sixth, seventh]).into(),
            Size::BigEndian => u16::from_be_bytes([sixth, seventh]).into(),
            Size::Unused if is_record => self.items.bytes(),
            // The length of other answers is not documented.
            Size::Unused => return nowhere,
        };
        let length = HEADER_BYTES + size;
        if !is_record {
            return match bytes.len() < length {
                _ if length > MOST_REPLY_BYTES => nowhere,
                true => Step::More,
                false => {
                    let result = if error == b' ' { 0 } else { u32::from(error) };
                    Step::Take(length, None, Event::reply(command.into(), result, ""))
                }
            };
        }
        if size != self.items.bytes() {
            // A stream of another list than the decoder was made for. Its
            // length is not relied on: it may be what is damaged.
            return Step::Skip(DropReason::Length);
        }
        let header = Header {
            bytes: HEADER_BYTES,
            sensor: station.saturating_sub(1),
            status: error,
            meaning: "",
        };
        record(
            window,
            header,
            &self.items,
            Scale::new(self.units, &self.axes),
            last,
        )
    }
}

#[cfg(test)]
mod tests;
