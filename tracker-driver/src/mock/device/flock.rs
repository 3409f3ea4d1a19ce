//! What a Flock of Birds does when it is told something.

use super::{Device, Heard};
use crate::head::flock::{GROUP_MODE, Mode, TO_BIRD};
use crate::mock::wire::Format;

/// Parameters that are examined.
const STATUS: u8 = 0;
const CRYSTAL: u8 = 2;
const ERROR: u8 = 10;
const EXPANDED_ERROR: u8 = 16;
const ALL_UNITS: u8 = 36;

/// Bytes that [`ALL_UNITS`] is answered with.
const UNITS: usize = 14;
/// Of a unit.
const ACCESSIBLE: u8 = 1 << 7;
const RUNNING: u8 = 1 << 6;
const RECEIVER: u8 = 1 << 5;

/// The crystal of most birds, in MHz: the sources name none.
const MEGAHERTZ: u16 = 40;

/// The code of a command that does not exist.
const NO_COMMAND: u8 = 6;

/// What else a bird remembers.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct State {
    asleep: bool,
    /// The last error that was not asked for yet.
    error: u8,
}

impl Device {
    pub(super) fn flock(&mut self, first: u8, answer: &mut dyn FnMut(&[u8])) -> Heard {
        let streams = self.streams;
        let Format::Flock(config) = &mut self.format else {
            return Heard::Took(1);
        };
        // Bytes of the command and what belongs to it.
        let length = match first {
            b'P' | b'L' => 3,
            b'O' => 2,
            _ => 1,
        };
        let Some(command) = self.heard.get(..length) else {
            return Heard::More;
        };
        let mode = if config.letter == Some(first) {
            Some(config.mode)
        } else {
            Mode::ALL.into_iter().find(|mode| mode.command() == first)
        };
        let state = &mut self.flock;
        match *command {
            [b'P', GROUP_MODE, on] => config.group = on != 0,
            // Another parameter, or a hemisphere.
            [b'P' | b'L', ..] => {}
            [_, STATUS] => answer(&state.word(config.mode, streams).to_le_bytes()),
            [_, CRYSTAL] => answer(&MEGAHERTZ.to_le_bytes()),
            [_, ERROR] => answer(&[core::mem::take(&mut state.error)]),
            [_, EXPANDED_ERROR] => answer(&[core::mem::take(&mut state.error), 0]),
            [_, ALL_UNITS] => {
                let mut units = [0; UNITS];
                let running = if state.asleep { 0 } else { RUNNING };
                // The one bird, at address 1.
                units[0] = ACCESSIBLE | running | RECEIVER;
                answer(&units);
            }
            [_, _] => state.error = NO_COMMAND,
            [b'B'] => {
                self.streams = false;
                if !self.flock.asleep {
                    self.ask();
                }
            }
            [b'@'] => (self.streams, state.asleep) = (true, false),
            [b'G'] => (self.streams, state.asleep) = (false, true),
            [b'F'] => state.asleep = false,
            // The next command goes to a bird: there is one.
            [TO_BIRD..=u8::MAX] => {}
            _ => match mode {
                Some(mode) => config.mode = mode,
                None => state.error = NO_COMMAND,
            },
        }
        Heard::Took(length)
    }
}

impl State {
    /// Master, initialised, and how it is.
    fn word(self, mode: Mode, streams: bool) -> u16 {
        let mode: u16 = match mode {
            Mode::Position => 1,
            Mode::Angles => 2,
            Mode::Matrix => 3,
            Mode::PositionAngles => 4,
            Mode::PositionMatrix => 5,
            Mode::Quaternion => 7,
            Mode::PositionQuaternion => 8,
        };
        1 << 15
            | 1 << 14
            | u16::from(self.error != 0) << 13
            | u16::from(!self.asleep) << 12
            | u16::from(self.asleep) << 5
            | mode << 1
            | u16::from(streams)
    }
}
