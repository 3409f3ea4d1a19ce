//! How a Liberty or a Patriot obeys commands.

use super::{Device, Reference, line, relist};
use crate::head::liberty::{RESET, RESET_TIME};
use crate::head::polhemus::{Family, MOST_ITEMS, Units};
use crate::protocol::Protocol;
use crate::time::Micros;
use heapless::Vec;

const WHO_ARE_YOU: u8 = 0x16;

/// The answer to that begins with `0`; what follows is the mock's own.
const NAME: &[u8] = b"0 SHISEN MOCK\r\n";

impl Device {
    pub(super) fn liberty(&mut self, now: Micros, answer: &mut dyn FnMut(&[u8])) -> Option<usize> {
        if self.heard.first() == Some(&b'P') {
            // It ends a stream, too; an end of line behind it passes.
            self.streams = false;
            self.ask();
            return Some(1);
        }
        let line = line(&self.heard)?;
        let Protocol::Liberty(config) = &mut self.protocol else {
            return Some(line.len() + 1);
        };
        match line.as_slice() {
            [b'C', ..] => self.streams = true,
            b"U0" => config.units = Units::Inches,
            b"U1" => config.units = Units::Centimetres,
            b"Q0" => self.clock = Reference::Next,
            [WHO_ARE_YOU] => answer(NAME),
            [RESET] => return Some(self.restart(now, RESET_TIME)),
            command => {
                if let Some(numbers) = of_first_station(command) {
                    // One that makes no list changes nothing: how a refusal
                    // looks is not known.
                    let _ = relist(&mut config.items, Family::Liberty, None, Some(&numbers));
                }
            }
        }
        Some(line.len() + 1)
    }
}

/// Returns the numbers of the command `O` for station 1, up to its end.
fn of_first_station(command: &[u8]) -> Option<Vec<u8, MOST_ITEMS>> {
    let text = core::str::from_utf8(command).ok()?.strip_prefix("O1,")?;
    let mut numbers = Vec::new();
    for number in text.split(',') {
        numbers.push(number.parse().ok()?).ok()?;
    }
    Some(numbers)
}
