//! How a Hatire obeys commands.

use super::{Device, Reference};
use crate::head::hatire::{Config, RESET_TIME, TEXT_BYTES};
use crate::protocol::Protocol;
use crate::time::Micros;

/// Codes of text.
const INFO: u16 = 2_000;
const INITIALISING: u16 = 3_000;

impl Device {
    pub(super) fn hatire(
        &mut self,
        first: u8,
        now: Micros,
        answer: &mut dyn FnMut(&[u8]),
    ) -> usize {
        let Protocol::Hatire(config) = self.protocol else {
            return 1;
        };
        match first {
            b'R' => {
                say(&config, INITIALISING, b"RESET\n", answer);
                return self.restart(now, RESET_TIME);
            }
            b'C' => self.front = Reference::Next,
            b'V' => say(&config, INFO, b"SHISEN MOCK 0\n", answer),
            b'I' if self.streams => say(&config, INFO, b"SENDS\n", answer),
            b'I' => say(&config, INFO, b"STOPPED\n", answer),
            _ => self.set(first, b'S', b's'),
        }
        1
    }
}

fn say(config: &Config, code: u16, text: &[u8], answer: &mut dyn FnMut(&[u8])) {
    let mut padded = [0; TEXT_BYTES];
    for (to, &from) in padded.iter_mut().zip(text) {
        *to = from;
    }
    answer(&config.encode_text(code, &padded));
}
