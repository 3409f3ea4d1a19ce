//! What makes birds send, what they are asked, and what they answer.

use super::{Config, PHASE};
use crate::command::{Awaited, PATIENCE, Script};
use crate::decoder::{Event, Message};
use crate::stream::{Step, Window};
use crate::time::Micros;

impl Config {
    /// Makes `birds` birds send this configuration's records; in group mode their addresses are
    /// from `first_address` on (2, where a transmitter alone has 1). With `reset` they configure
    /// themselves first, which takes 1.5 s. At last they are asked for the error that they met.
    pub fn start(&self, first_address: u8, birds: u8, reset: bool) -> Script {
        // The guide asks for 300 ms before and after.
        let settle = Micros::from_millis(300);
        let birds = birds.clamp(1, MOST_BIRDS);
        let mut script = Script::new();
        if reset {
            let units = first_address.saturating_sub(1).saturating_add(birds);
            script
                .send(b"B")
                .pause(settle)
                .send(&[b'P', AUTO_CONFIGURE, units])
                .pause(Micros::from_millis(1_000));
        }
        script
            .once_only()
            .send(b"B")
            .pause(settle)
            .send(&[self.run]);
        let mode = self.letter.unwrap_or(self.mode.command());
        // A bird that was left in group mode would send the others' records with its own.
        script.send(&[b'P', GROUP_MODE, self.group.into()]);
        if self.group {
            for bird in 0..birds {
                let address = first_address.saturating_add(bird).min(0x0F);
                script.send(&[TO_BIRD + address, mode]);
            }
        } else {
            script.send(&[mode]);
        }
        script
            .send(&[EXAMINE, ERROR])
            .pause(Micros::from_millis(50))
            .send(b"@")
            .expect(Awaited::Sample, PATIENCE);
        script
    }
}

/// Most birds that [`Config::start`] sets up: those that one byte addresses.
pub const MOST_BIRDS: u8 = 14;

const AUTO_CONFIGURE: u8 = 50;
/// The parameter that switches group mode.
pub(crate) const GROUP_MODE: u8 = 35;
/// The next command goes to the bird whose address is added.
pub(crate) const TO_BIRD: u8 = 0xF0;

/// Asks for a parameter.
pub(crate) const EXAMINE: u8 = b'O';
/// The parameters that are asked for, and how long their answers are.
pub(crate) const STATUS: u8 = 0;
pub(crate) const CRYSTAL: u8 = 2;
pub(crate) const ERROR: u8 = 10;
pub(crate) const EXPANDED_ERROR: u8 = 16;
pub(crate) const ALL_UNITS: u8 = 36;
/// The highest code of an error.
const HIGHEST_ERROR: u8 = 35;
/// In a status' low byte: records come without being asked for.
const STREAMS: u8 = 1;
/// Bytes that [`ALL_UNITS`] is answered with: one for each unit.
pub(crate) const UNITS: usize = 14;

/// Returns how long the answer is; `None` of a parameter that is not known here.
const fn answer_bytes(parameter: u8) -> Option<usize> {
    match parameter {
        ERROR => Some(1),
        STATUS | CRYSTAL | EXPANDED_ERROR => Some(2),
        ALL_UNITS => Some(UNITS),
        _ => None,
    }
}

/// Returns bytes of a command with what belongs to it, by its first.
pub(crate) const fn command_bytes(first: u8) -> usize {
    match first {
        b'P' | b'L' => 3,
        EXAMINE => 2,
        _ => 1,
    }
}

/// Returns what ends the stream of records and puts the birds to sleep.
pub fn stop() -> Script {
    let mut script = Script::sending(b"B");
    script.send(b"G");
    script
}

/// VRPN's meaning of an answer to `O` 10; empty where it has none.
pub const fn error_meaning(code: u8) -> &'static str {
    match code {
        0 => "none",
        1 => "the memory's test failed",
        2 => "writing the non-volatile memory failed",
        3 => "the system's configuration is damaged",
        4 => "the transmitter's configuration is damaged",
        5 => "the receiver's configuration is damaged",
        6 => "a command that does not exist",
        7 => "not the master",
        8 => "no bird is active",
        9 => "not initialised",
        10 => "receiving from another bird failed",
        11 => "the line overran or was out of frame",
        12 => "receiving from the host's bus failed",
        13 => "a bird does not answer",
        14 => "a bus command that does not exist",
        15 => "the bus' run-time error",
        16 => "the processor's speed is wrong",
        17 => "a slave has no data",
        18 => "a baud rate that does not exist",
        19 => "a slave did not acknowledge",
        20..=27 => "internal",
        28 => "no synchronisation with a screen",
        29 => "the transmitter is not active",
        30 => "the extended-range transmitter is not attached",
        31 => "the processor has no time left",
        32 => "the receiver is saturated",
        33 => "a slave's configuration is wrong",
        34 => "the extended-range controller's watchdog",
        35 => "the extended-range controller is too hot",
        _ => "",
    }
}

/// Returns what is made of bytes that may be an answer; `None` where they are not.
pub(super) fn answer(parameter: u8, window: Window<'_>, alone: bool) -> Option<Step> {
    let bytes = window.bytes;
    let length = answer_bytes(parameter)?;
    let &first = bytes.first()?;
    let second = bytes.get(1).copied();
    let second_begins = second.is_some_and(|byte| byte & PHASE != 0);
    // A status' high byte may be a record's first, which the byte behind it tells.
    let unclear = parameter == STATUS && first & STREAMS != 0 && second_begins;
    let is_one = match parameter {
        ALL_UNITS => true,
        _ if first & PHASE != 0 => false,
        ERROR | EXPANDED_ERROR if !alone || first > HIGHEST_ERROR => false,
        CRYSTAL | EXPANDED_ERROR => !second_begins,
        _ => !unclear || bytes.get(2).is_none_or(|byte| byte & PHASE != 0),
    };
    if !is_one {
        return None;
    }
    if bytes.len() < length + usize::from(unclear) {
        return Some(Step::More);
    }
    let said = match parameter {
        STATUS => Some(Message::State {
            code: u32::from(u16::from_le_bytes([first, second.unwrap_or_default()])),
            meaning: "",
        }),
        ERROR | EXPANDED_ERROR if first != 0 => Some(Message::Fault {
            code: u32::from(first),
            meaning: error_meaning(first),
        }),
        _ => None,
    };
    let reply = Event::reply(u32::from(EXAMINE), 0, "");
    Some(Step::Take(length, said, reply))
}
