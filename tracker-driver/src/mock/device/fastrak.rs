//! What a FASTRAK does when it is told something.

use super::{Device, Heard, MOST_ANSWER, line, relist};
use crate::head::fastrak::{BAUD_RATES, Config, RESET};
use crate::head::polhemus::{Family, Format, ItemListError, MOST_ITEMS, Units};
use crate::protocol::Protocol;
use crate::time::Micros;
use heapless::Vec;

/// What follows the flags in the status: no error, the constant `F3`, the first
/// sensor of four, and the version and name of a device that there is not.
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

/// A refusal, of the field (from 0, behind the letter) that is wrong.
#[derive(Debug, Clone, Copy)]
struct Refusal {
    code: Code,
    field: u8,
}

impl Device {
    pub(super) fn fastrak(
        &mut self,
        first: u8,
        now: Micros,
        answer: &mut dyn FnMut(&[u8]),
    ) -> Heard {
        let streams = self.streams;
        let Protocol::Fastrak(config) = &mut self.protocol else {
            return Heard::Took(1);
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
            SAVE => {
                self.saved.protocol = self.protocol.clone();
                self.saved.streams = self.streams;
            }
            RESET => {
                let usual = config.reset_time;
                return self.restart(now, usual);
            }
            // What the answer to `T` looks like is not known; the ends of lines
            // that some hosts send behind a letter mean nothing.
            b'T' | b'\r' | b'\n' => {}
            // Lists of items, the line's speed, filters, stations, and frames.
            b'O' | b'o' | b'x' | b'v' | b'H' | b'e' | b'l' | b'A' | b'G' | b'N' | b'V' | b'Q'
            | b'r' => {
                let Some(line) = line(&self.heard) else {
                    return Heard::More;
                };
                if let Err(refusal) = take_line(config, &line) {
                    answer(&error(&line, refusal));
                }
                return Heard::Took(line.len() + 1);
            }
            _ => {
                let refusal = Refusal {
                    code: Code::Unknown,
                    field: 0,
                };
                answer(&error(&[first], refusal));
            }
        }
        Heard::Took(1)
    }

    /// Says that a command was longer than any.
    pub(super) fn refuse_long(&self, answer: &mut dyn FnMut(&[u8])) {
        let refusal = Refusal {
            code: Code::Buffer,
            field: 0,
        };
        answer(&error(&self.heard, refusal));
    }
}

fn take_line(config: &mut Config, line: &[u8]) -> Result<(), Refusal> {
    let refused = |code, field| Refusal { code, field };
    let Some((letter, rest)) = line.split_first() else {
        return Ok(());
    };
    let fields = || rest.split(|&byte| byte == b',').zip(0_u8..);
    let station = || match number(rest.split(|&byte| byte == b',').next()) {
        Ok(station) if (1..=config.stations.into()).contains(&station) => Ok(station),
        Ok(_) => Err(refused(Code::Range, 0)),
        Err(code) => Err(refused(code, 0)),
    };
    match letter {
        b'O' => {
            let station = station()?;
            let mut numbers: Vec<u8, MOST_ITEMS> = Vec::new();
            for (text, field) in fields().skip(1) {
                let number = number(Some(text)).map_err(|code| refused(code, field))?;
                let number = u8::try_from(number).map_err(|_| refused(Code::Range, field))?;
                let pushed = numbers.push(number);
                pushed.map_err(|_| refused(Code::Buffer, field))?;
            }
            if numbers.is_empty() {
                return Err(refused(Code::Missing, 1));
            }
            // The mock's records are all of station 1.
            let mut items = config.items.clone();
            relist(&mut items, Family::Fastrak, None, Some(&numbers)).map_err(|why| {
                let at = match why {
                    ItemListError::Unknown { number }
                    | ItemListError::Format { number, .. }
                    | ItemListError::Repeated { number } => {
                        numbers.iter().rposition(|&found| found == number)
                    }
                    _ => None,
                };
                let code = match why {
                    ItemListError::TooMany { .. } | ItemListError::TooLong { .. } => Code::Buffer,
                    _ => Code::Range,
                };
                refused(code, at.map_or(numbers.len(), |at| at + 1) as u8)
            })?;
            if station == 1 {
                config.items = items;
            }
        }
        b'o' => {
            let hundreds = number(fields().next().map(|(text, _)| text));
            let hundreds = hundreds.map_err(|code| refused(code, 0))?;
            if !BAUD_RATES.iter().any(|&baud| baud / 100 == hundreds) {
                return Err(refused(Code::Range, 0));
            }
            match fields().nth(1) {
                None | Some((b"N" | b"O" | b"E", _)) => {}
                Some(_) => return Err(refused(Code::Range, 1)),
            }
        }
        b'x' | b'v' => {
            for field in 0..4 {
                let text = fields().nth(field).map_or(&b""[..], |(text, _)| text);
                if text.is_empty() {
                    return Err(refused(Code::Missing, field as u8));
                }
                let value = core::str::from_utf8(text).ok();
                let value = value.and_then(|text| text.trim().parse::<f32>().ok());
                if !value.is_some_and(f32::is_finite) {
                    return Err(refused(Code::NoNumber, field as u8));
                }
            }
        }
        b'H' => {
            station()?;
        }
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

/// Commands whose first field is a station.
const OF_STATIONS: &[u8] = b"OHelAGNVQr";

/// `2 E*ERROR*O*ERROR* EC-3*PS4*FL2*ST0`: the letter of the command, the code,
/// where the field begins (the letter is at 0) and its number, and the station
/// from 0.
fn error(command: &[u8], refusal: Refusal) -> Vec<u8, MOST_ANSWER> {
    let letter = command.first().filter(|letter| letter.is_ascii_graphic());
    let field = usize::from(refusal.field);
    let commas = command
        .iter()
        .zip(0_u8..)
        .filter(|(byte, _)| **byte == b',');
    let comma = field
        .checked_sub(1)
        .and_then(|before| commas.clone().nth(before));
    // Behind the last field where it is missing.
    let place = match (field, comma) {
        (0, _) => 1,
        (_, Some((_, at))) => at.saturating_add(1),
        (_, None) => command.len().min(MOST_ANSWER) as u8,
    };
    let of_station = letter.is_some_and(|letter| OF_STATIONS.contains(letter));
    let station = command
        .get(1)
        .filter(|station| of_station && (b'1'..=b'9').contains(station));
    let mut record = Vec::new();
    let _ = record.extend_from_slice(b"2 E*ERROR*");
    let _ = record.push(letter.copied().unwrap_or(b'?'));
    let _ = record.extend_from_slice(b"*ERROR* EC-");
    push(&mut record, refusal.code as u8);
    let _ = record.extend_from_slice(b"*PS");
    push(&mut record, place);
    let _ = record.extend_from_slice(b"*FL");
    push(&mut record, refusal.field);
    let _ = record.extend_from_slice(b"*ST");
    push(&mut record, station.map_or(0, |station| station - b'1'));
    let _ = record.extend_from_slice(b"\r\n");
    record
}

/// A number below 100.
fn push(record: &mut Vec<u8, MOST_ANSWER>, number: u8) {
    if number > 9 {
        let _ = record.push(b'0' + number / 10 % 10);
    }
    let _ = record.push(b'0' + number % 10);
}
