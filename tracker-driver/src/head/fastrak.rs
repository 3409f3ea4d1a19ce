//! Polhemus FASTRAK, and `InterSense` IS-600 and IS-900, which speak its
//! language: position and orientation of up to four (`InterSense`: twelve)
//! stations over a serial line.
//!
//! # Records
//!
//! From FASTRAK's [manual] (OPM00PI002 Rev. G, "System Data Record" and the
//! commands `O`, `S` and `T`), `InterSense`'s IS-900 user guide ("Fastrak
//! System and Data Records") and VRPN's `vrpn_Tracker_Fastrak.C`.
//!
//! | Byte | Content |
//! |---|---|
//! | 0 | `0` |
//! | 1 | station: `1` to `4`; IS-900 hexadecimal up to `C` |
//! | 2 | status: a space, or the letter of an error |
//! | 3… | the items of the list that the station was told, in its order |
//!
//! | Item | Content | ASCII | Binary |
//! |---|---|---|---|
//! | 0, 50 | space | 1 character | 20 |
//! | 1, 51 | line's end | 2 | 0D 0A |
//! | 2 | x, y, z | 3 × `Sxxx.xx` | 3 f32 |
//! | 4 | azimuth, elevation, roll: degrees | 3 × `Sxxx.xx` | 3 f32 |
//! | 5, 6, 7 | rows of the matrix whose columns are the receiver's axes | 3 × `Sx.xxxx` | 3 f32 |
//! | 11 | quaternion, real part first | 4 × `Sx.xxxx` | 4 f32 |
//! | 16, 66 | stylus | space, `0` or `1` | the same |
//! | 52, 54, 55 to 57, 61 | as 2, 4, 5 to 7, 11 | `Sx.xxxxxESxxb` each | f32 each |
//! | 18, 19, 20 | position, angles, quaternion; stand alone | – | 14 bits each: ±3 m, ±180°, ±1 |
//! | 21 | time: milliseconds (IS-900) | 14 characters | f32 |
//! | 22 | buttons (IS-900) | 3 characters | 1 byte |
//! | 23 | joystick (IS-900) | – | 2 bytes |
//!
//! Numbers are little-endian. Items 16, 22, 23 and 66 are checked for their form and left out
//! of a sample. Of several forms of the orientation the quaternion is taken before the matrix
//! and that before the angles. The station's time is an f32: after 16,777 s it tells whole
//! milliseconds only, after 9 hours less. A record whose status is a letter is handed over with
//! its readings not tracked, and the letter as a [`Message::Fault`] when it changes.
//!
//! Answers to commands start with `2`. The status record is handed over as a
//! [`Message::Text`] such as `21S3F9…`, whose `3F9` are hexadecimal flags: bit 0 binary,
//! 1 centimetres, 2 compensated, 3 continuous; a command error as a [`Message::Reply`] to the
//! letter of the command, with the error's number without its sign.
//!
//! # Axes
//!
//! The transmitter's +X points forward, +Y to the right and +Z down, as do
//! the receiver's: the manual's glossary has azimuth and roll grow clockwise
//! and elevation upwards. [`Config::axes`] changes that for a transmitter
//! that hangs.
//!
//! # How strong the check is
//!
//! There is no checksum. A record is believed for its first three bytes, the list's spaces and
//! line ends, and for what its numbers can be: finite, a position within
//! [`FARTHEST_POSITION`](super::axes::FARTHEST_POSITION), a quaternion or matrix that is a
//! rotation. Random bytes pass as a record with a probability of 5 · 10⁻¹³ at each byte with the
//! list 2, 11, 0 in binary form, 2 · 10⁻⁷ with 18, 19, and below 10⁻⁴⁰ in ASCII. Three of four
//! changed bytes of a binary record leave another that is valid.
//!
//! [manual]: https://manualshive.com/ru/manual/polhemus/3space-fastrak/1573695

use super::axes::Axes;
use super::polhemus::{
    Family, Format, Header, ItemList, MOST_RECORD_BYTES, Record, Scale, Units, WORD_DEGREES,
    WORD_METRES, push_number, record,
};
use crate::command::{Awaited, Bytes, PATIENCE, Script};
use crate::decoder::{Counts, Decoder, DropReason, Event, Message, Text};
use crate::sample::Sample;
use crate::stream::{Step, Stream, Window};
use crate::time::Micros;

/// Bytes before a record's items.
const HEADER_BYTES: usize = 3;

/// Most stations that one device has: an IS-900's.
pub const MOST_STATIONS: u8 = 12;

/// Longest answer that is read; the longest that the manual has is 55 bytes.
const MOST_REPLY_BYTES: usize = 96;

/// Baud rates that the devices have.
pub const BAUD_RATES: [u32; 7] = [2_400, 4_800, 9_600, 19_200, 38_400, 57_600, 115_200];

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
    /// How long a device is away after a reset: a FASTRAK 10 s, an IS-900 20 s.
    pub reset_time: Micros,
    /// Length of a 1 in item 18: metres, above 0.
    pub word_metres: f32,
    /// Angle of a 1 in item 19: degrees, above 0.
    pub word_degrees: f32,
}

impl Default for Config {
    /// Returns a FASTRAK with [the usual items](ItemList::usual), as [`Config::new`] has it.
    fn default() -> Self {
        Self::new(ItemList::usual(Family::Fastrak))
    }
}

impl Config {
    /// Returns a FASTRAK with these items: inches, four stations, its own axes.
    pub const fn new(items: ItemList) -> Self {
        Self {
            items,
            units: Units::Inches,
            stations: 4,
            axes: Axes::FORWARD_RIGHT_DOWN,
            reset_time: Micros::from_millis(10_000),
            word_metres: WORD_METRES,
            word_degrees: WORD_DEGREES,
        }
    }

    /// Returns bytes of a record.
    pub const fn record_bytes(&self) -> usize {
        HEADER_BYTES + self.items.bytes()
    }

    fn scale(&self) -> Scale<'_> {
        Scale {
            units: self.units,
            word_metres: self.word_metres,
            word_degrees: self.word_degrees,
            axes: &self.axes,
        }
    }

    /// Returns the record that a device sends of a sample. What it lacks is the origin, no rotation
    /// and time 0; that, or a held reading, gives the status `k`.
    pub fn encode(&self, sample: &Sample) -> Record {
        let station = sample.sensor.min(MOST_STATIONS - 1) + 1;
        let tracked = self.items.is_tracked(&sample.head);
        let status = if tracked { b' ' } else { b'k' };
        let mut record = Record::new();
        let _ = record.extend_from_slice(&[b'0', station_letter(station), status]);
        self.items.write(sample, self.scale(), &mut record);
        record
    }

    /// Makes the device send these records; a reset first, if any, takes [`Config::reset_time`].
    pub fn start(&self, reset: bool) -> Script {
        let settle = Micros::from_millis(100);
        let mut script = Script::new();
        if reset {
            script.send(&[RESET]).pause(self.reset_time);
        }
        let units = match self.units {
            Units::Inches => b"U",
            Units::Centimetres => b"u",
        };
        let format = match self.items.format() {
            Format::Ascii => b"F",
            Format::Binary => b"f",
        };
        script
            .once_only()
            // Not while it sends: what is under way has to pass.
            .send(b"c")
            .pause(settle)
            .send(format)
            .send(units);
        for station in 1..=self.stations.clamp(1, MOST_STATIONS) {
            script
                .send(&self.items.command(station))
                .pause(Micros::from_millis(50));
        }
        script.send(b"C").expect(Awaited::Sample, PATIENCE);
        script
    }
}

pub(crate) const RESET: u8 = 0x19;

/// Returns the script that ends the stream of records.
pub fn stop() -> Script {
    Script::sending(b"c")
}

/// Changes the line's speed at both ends to one of [`BAUD_RATES`], 8N1, and asks for the
/// status there. `None` for another speed.
pub fn change_speed(baud: u32) -> Option<Script> {
    if !BAUD_RATES.contains(&baud) {
        return None;
    }
    let mut command = Bytes::new();
    let _ = command.push(b'o');
    let _ = push_number(&mut command, (baud / 100) as u16);
    let _ = command.extend_from_slice(b",N,8,0\r");
    let settle = Micros::from_millis(200);
    let mut script = Script::sending(b"c");
    script
        .pause(settle)
        .send(&command)
        .pause(settle)
        .speed(baud)
        .once_only()
        .send(b"S")
        .expect(Awaited::Record, PATIENCE);
    Some(script)
}

/// Returns the manual's meaning of a status letter; empty for others.
pub const fn fault_meaning(letter: u8) -> &'static str {
    match letter {
        b'a' => "X driver at its limit",
        b'b' => "Y driver at its limit",
        b'c' => "Z driver at its limit",
        b'd' => "x gain at its limit",
        b'e' => "y gain at its limit",
        b'f' => "z gain at its limit",
        b'g' => "coil gain at its limit",
        b'j' => "signal saturated",
        b'k' => "signal low",
        b'l' => "largest signal element is zero",
        b'm' => "checksum of the EEPROM is wrong",
        b's' => "unit position vector was reset",
        b't' => "fault in the compensation's structure",
        b'u' => "compensation point out of bounds",
        b'v' => "no synchronisation with a screen",
        b'w' => "writing the EEPROM failed",
        b'x' => "receiver outside its motion box",
        b'y' => "angles outside their envelope",
        b'A'..=b'Z' => "hardware self-test failed",
        _ => "",
    }
}

fn station_number(letter: u8) -> Option<u8> {
    let number = char::from(letter.to_ascii_uppercase()).to_digit(16)? as u8;
    (1..=MOST_STATIONS).contains(&number).then_some(number)
}

fn station_letter(number: u8) -> u8 {
    match number {
        0..=9 => b'0' + number,
        _ => b'A' + number.saturating_sub(10).min(5),
    }
}

/// Decodes the records of one device.
#[derive(Debug, Clone)]
pub struct Fastrak {
    stream: Stream<MOST_RECORD_BYTES>,
    config: Config,
    /// Each station's last status.
    status: [u8; MOST_STATIONS as usize],
}

impl Fastrak {
    /// Returns a decoder of a device that is set up this way.
    pub fn new(config: Config) -> Self {
        Self {
            stream: Stream::default(),
            config,
            status: [b' '; MOST_STATIONS as usize],
        }
    }
}

impl Decoder for Fastrak {
    fn feed(&mut self, bytes: &[u8], arrival: Micros, sink: &mut dyn FnMut(Event)) {
        let (config, status) = (&self.config, &mut self.status);
        let step = |window: Window<'_>| config.step(status, window);
        self.stream.feed(bytes, arrival, sink, step);
    }

    fn counts(&self) -> &Counts {
        &self.stream.counts
    }

    fn reset(&mut self) {
        self.stream.reset();
    }
}

impl Config {
    /// Decides about the bytes of a window; `last` are the stations' last statuses.
    fn step(&self, last: &mut [u8], window: Window<'_>) -> Step {
        let bytes = window.bytes;
        let nowhere = Step::Skip(DropReason::OutOfStep);
        match bytes {
            [b'0', ..] => {}
            [b'2', ..] => return look_at_reply(bytes),
            _ => return nowhere,
        }
        let station = match bytes.get(1).map(|&letter| station_number(letter)) {
            None => return Step::More,
            Some(Some(station)) if station <= self.stations => station,
            Some(_) => return nowhere,
        };
        let status = match bytes.get(2) {
            None => return Step::More,
            Some(&status) if status == b' ' || status.is_ascii_alphabetic() => status,
            Some(_) => return nowhere,
        };
        let header = Header {
            bytes: HEADER_BYTES,
            sensor: station - 1,
            status,
            meaning: fault_meaning(status),
        };
        record(window, header, &self.items, self.scale(), last)
    }
}

/// Returns an answer: `2`, station or a space, a letter, and text up to the line's end.
fn look_at_reply(bytes: &[u8]) -> Step {
    const ERROR: &[u8] = b"*ERROR*";
    let nowhere = Step::Skip(DropReason::OutOfStep);
    let (Some(&station), Some(&kind)) = (bytes.get(1), bytes.get(2)) else {
        return Step::More;
    };
    let body = bytes.get(3..).unwrap_or_default();
    let station_known = station == b' ' || station_number(station).is_some();
    let kind_known = match kind {
        b'S' => body.iter().take(3).all(u8::is_ascii_hexdigit),
        b'E' => body
            .iter()
            .zip(ERROR)
            .all(|(found, wanted)| found == wanted),
        _ => false,
    };
    if !(station_known && kind_known) {
        return nowhere;
    }
    let printable = |&byte: &u8| byte == b' ' || byte.is_ascii_graphic();
    let text = body.iter().take_while(|byte| printable(byte)).count();
    let length = 3 + text + 2;
    match body.get(text..) {
        _ if length > MOST_REPLY_BYTES => nowhere,
        None | Some([] | [b'\r']) => Step::More,
        Some([b'\r', b'\n', ..]) => {
            let body = body.get(..text).unwrap_or_default();
            match kind {
                // FASTRAK has 50 characters here, IS-900 one fewer.
                b'S' if text == 50 || text == 49 => status_record(length, bytes, body),
                b'E' if text > ERROR.len() => Step::Take(length, None, error_record(body)),
                _ => nowhere,
            }
        }
        Some(_) => nowhere,
    }
}

fn status_record(length: usize, bytes: &[u8], body: &[u8]) -> Step {
    // Three digits, or blanks: the built-in test's error.
    let code = body.get(3..6).unwrap_or_default().trim_ascii();
    let code = code.iter().try_fold(0_u32, |code, &digit| {
        let digit = char::from(digit).to_digit(10)?;
        Some(10 * code + digit)
    });
    let fault = code.filter(|&code| code != 0).map(|code| Message::Fault {
        code,
        meaning: u8::try_from(code).map_or("", fault_meaning),
    });
    let text = bytes.get(..3 + body.len()).unwrap_or_default();
    let text = Event::Message(Message::Text(Text::new(text)));
    Step::Take(length, fault, text)
}

/// `*ERROR*`, the command, `*ERROR* EC`, the error's number.
fn error_record(body: &[u8]) -> Event {
    let command = body.get(7).copied().unwrap_or_default();
    let code = body
        .windows(2)
        .position(|pair| pair == b"EC")
        .and_then(|at| body.get(at + 2..))
        .map(|rest| {
            let digits = rest.trim_ascii_start();
            let digits = digits.strip_prefix(b"-").unwrap_or(digits);
            let digits = digits.iter().map_while(|&b| char::from(b).to_digit(10));
            digits.fold(0_u32, |code, digit| {
                code.saturating_mul(10).saturating_add(digit)
            })
        });
    // An error without a number is still one.
    let result = code.filter(|&code| code != 0).unwrap_or(99);
    Event::reply(command.into(), result, error_meaning(result))
}

/// Returns the manual's meaning of a command error's number, without its sign.
pub const fn error_meaning(result: u32) -> &'static str {
    match result {
        1 => "a field is missing",
        2 => "a field is not a number",
        3 => "a field is out of range",
        4 => "the frequency is not configured",
        5 => "the buffer is full",
        _ => "unknown",
    }
}

#[cfg(test)]
mod tests;
