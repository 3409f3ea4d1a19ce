//! How a FASTRAK obeys commands.

use super::{Device, MOST_ANSWER, line, relist};
use crate::head::fastrak::{BAUD_RATES, Config, RESET};
use crate::head::polhemus::{Family, Format, ItemListError, MOST_ITEMS, Units};
use crate::protocol::Protocol;
use crate::time::Micros;
use heapless::Vec;

/// What follows the flags: no error, `F3`, the first of four sensors, version and name.
const STATUS: &[u8] = b"    F31  00.00 SHISEN MOCK                     \r\n";
/// A status of the first station, and those of its ten flags that are always set.
const BEFORE_FLAGS: &[u8] = b"21S3F";

const SAVE: u8 = 0x0B;

/// What the device starts with when nobody has saved anything else.
const FACTORY_ITEMS: [u8; 3] = [2, 4, 1];

/// Why a command is refused: the manual's number without its sign.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Code {
    Missing = 1,
    NoNumber = 2,
    Range = 3,
    Buffer = 5,
    Unknown = 99,
}

impl Device {
    pub(super) fn fastrak(
        &mut self,
        first: u8,
        now: Micros,
        answer: &mut dyn FnMut(&[u8]),
    ) -> Option<usize> {
        let streams = self.streams;
        let Protocol::Fastrak(config) = &mut self.protocol else {
            return Some(1);
        };
        let format = |config: &mut Config, format| {
            // A list with items that ASCII does not have stays binary.
            let _ = relist(&mut config.items, Family::Fastrak, Some(format), None);
        };
        match first {
            b'P' => self.ask(),
            b'C' | b'c' => self.set(first, b'C', b'c'),
            b'S' => answer(&status(config, streams)),
            b'U' => config.units = Units::Inches,
            b'u' => config.units = Units::Centimetres,
            b'F' => format(config, Format::Ascii),
            b'f' => format(config, Format::Binary),
            b'W' => {
                config.units = Units::Inches;
                let usual = Some(Format::Ascii);
                let _ = relist(
                    &mut config.items,
                    Family::Fastrak,
                    usual,
                    Some(&FACTORY_ITEMS),
                );
            }
            SAVE => self.saved = (self.protocol.clone(), self.streams),
            RESET => {
                let usual = config.reset_time;
                return Some(self.restart(now, usual));
            }
            // What the answer to `T` looks like is not known; the ends of lines
            // that some hosts send behind a letter mean nothing.
            b'T' | b'\r' | b'\n' => {}
            // Lists of items, the line's speed, filters, stations, and frames.
            b'O' | b'o' | b'x' | b'v' | b'H' | b'e' | b'l' | b'A' | b'G' | b'N' | b'V' | b'Q'
            | b'r' => {
                let line = line(&self.heard)?;
                if let Err(code) = take_line(config, &line) {
                    answer(&error(&line, code));
                }
                return Some(line.len() + 1);
            }
            _ => answer(&error(&[first], Code::Unknown)),
        }
        Some(1)
    }

    /// Says that a command was longer than any.
    pub(super) fn refuse_long(&self, answer: &mut dyn FnMut(&[u8])) {
        answer(&error(&self.heard, Code::Buffer));
    }
}

fn take_line(config: &mut Config, line: &[u8]) -> Result<(), Code> {
    let Some((letter, rest)) = line.split_first() else {
        return Ok(());
    };
    let mut fields = rest.split(|&byte| byte == b',');
    let stations = 1..=u32::from(config.stations);
    let station = |text| number(text).map(|station| (station, stations.contains(&station)));
    match letter {
        b'O' => {
            let (station, true) = station(fields.next())? else {
                return Err(Code::Range);
            };
            let mut numbers: Vec<u8, MOST_ITEMS> = Vec::new();
            for text in fields {
                let number = u8::try_from(number(Some(text))?).map_err(|_| Code::Range)?;
                numbers.push(number).map_err(|_| Code::Buffer)?;
            }
            if numbers.is_empty() {
                return Err(Code::Missing);
            }
            let mut items = config.items.clone();
            relist(&mut items, Family::Fastrak, None, Some(&numbers)).map_err(|why| match why {
                ItemListError::TooMany { .. } | ItemListError::TooLong { .. } => Code::Buffer,
                _ => Code::Range,
            })?;
            // The mock's records are all of station 1.
            if station == 1 {
                config.items = items;
            }
        }
        b'o' => {
            let hundreds = number(fields.next())?;
            let known = BAUD_RATES.iter().any(|&baud| baud / 100 == hundreds);
            if !known || !matches!(fields.next(), None | Some(b"N" | b"O" | b"E")) {
                return Err(Code::Range);
            }
        }
        b'x' | b'v' => {
            for _ in 0..4 {
                let text = fields.next().unwrap_or_default();
                if text.is_empty() {
                    return Err(Code::Missing);
                }
                let value = core::str::from_utf8(text).ok();
                let value = value.and_then(|text| text.trim().parse::<f32>().ok());
                if !value.is_some_and(f32::is_finite) {
                    return Err(Code::NoNumber);
                }
            }
        }
        b'H' if !station(fields.next())?.1 => return Err(Code::Range),
        _ => {}
    }
    Ok(())
}

fn number(text: Option<&[u8]>) -> Result<u32, Code> {
    let text = text.unwrap_or_default().trim_ascii();
    if text.is_empty() {
        return Err(Code::Missing);
    }
    if !text.iter().all(u8::is_ascii_digit) {
        return Err(Code::NoNumber);
    }
    let text = core::str::from_utf8(text).unwrap_or_default();
    text.parse().map_err(|_| Code::Range)
}

fn status(config: &Config, streams: bool) -> Vec<u8, MOST_ANSWER> {
    let flags = u8::from(config.items.format() == Format::Binary)
        | u8::from(config.units == Units::Centimetres) << 1
        | u8::from(streams) << 3;
    let digit = b"0123456789ABCDEF".get(usize::from(flags)).copied();
    let mut status = Vec::new();
    let _ = status.extend_from_slice(BEFORE_FLAGS);
    let _ = status.push(digit.unwrap_or(b'0'));
    let _ = status.extend_from_slice(STATUS);
    status
}

/// `2 E*ERROR*O*ERROR* EC-3*PS1*FL0*ST0`: the letter of the command and the code; place,
/// field and station are not looked for.
fn error(command: &[u8], code: Code) -> Vec<u8, MOST_ANSWER> {
    let letter = command.first().filter(|letter| letter.is_ascii_graphic());
    let (tens, ones) = (code as u8 / 10, code as u8 % 10);
    let mut record = Vec::new();
    let _ = record.extend_from_slice(b"2 E*ERROR*");
    let _ = record.push(letter.copied().unwrap_or(b'?'));
    let _ = record.extend_from_slice(b"*ERROR* EC-");
    if tens > 0 {
        let _ = record.push(b'0' + tens);
    }
    let _ = record.push(b'0' + ones);
    let _ = record.extend_from_slice(b"*PS1*FL0*ST0\r\n");
    record
}
