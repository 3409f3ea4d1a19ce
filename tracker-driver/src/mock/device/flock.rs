//! How a Flock of Birds obeys commands.

use super::Device;
use crate::head::flock::command::{
    ALL_UNITS, CRYSTAL, ERROR, EXPANDED_ERROR, GROUP_MODE, STATUS, TO_BIRD, UNITS, command_bytes,
};
use crate::head::flock::{MOST_BIRDS, Mode};
use crate::protocol::Protocol;
use crate::sample::Sample;
use glam::Vec3;

/// Bits of a unit in the answer to [`ALL_UNITS`].
const ACCESSIBLE: u8 = 1 << 7;
const RUNNING: u8 = 1 << 6;
const RECEIVER: u8 = 1 << 5;

/// The birds' crystal, MHz: that of most birds, as our sources do not name it.
const MEGAHERTZ: u16 = 40;

/// Error code for a command that does not exist.
const NO_COMMAND: u8 = 6;

/// Distance of each bird in a group to the right of the one before, metres.
const APART: f32 = 0.1;

/// The birds' state that is not in their protocol.
#[derive(Debug, Clone, Copy)]
pub(super) struct State {
    asleep: bool,
    /// The code of the last error that the host has not asked for; 0 for none.
    error: u8,
    /// The address of the first bird.
    first: u8,
    /// Number of birds.
    birds: u8,
}

impl Default for State {
    /// Returns one bird, at address 1.
    fn default() -> Self {
        Self {
            asleep: false,
            error: 0,
            first: 1,
            birds: 1,
        }
    }
}

impl Device {
    /// Returns a Flock of Birds with `birds` birds, 1 to [`MOST_BIRDS`], with the addresses from
    /// `first` on; in group mode it sends a record of each, 0.1 m to the right of the one
    /// before. Other devices stay as they are.
    #[must_use]
    pub fn with_birds(mut self, first: u8, birds: u8) -> Self {
        let birds = birds.clamp(1, MOST_BIRDS);
        self.flock.first = first.clamp(1, MOST_BIRDS + 1 - birds);
        self.flock.birds = birds;
        self
    }

    /// Returns what its `n`th sensor, from 0, measures; `None` if fewer sensors send.
    pub(in crate::mock) fn nth_sensor(&self, sample: &Sample, n: u8) -> Option<Sample> {
        let birds = match &self.protocol {
            Protocol::Flock(config) if config.group => self.flock.birds,
            _ => 1,
        };
        let mut measured = *sample;
        if let Protocol::Flock(_) = self.protocol {
            let address = self.flock.first.saturating_add(n);
            measured.sensor = measured.sensor.saturating_add(address.saturating_sub(1));
            if let Some(place) = &mut measured.head.position {
                place.value += Vec3::X * (APART * f32::from(n));
            }
        }
        (n < birds).then_some(measured)
    }

    pub(super) fn flock(&mut self, first: u8, answer: &mut dyn FnMut(&[u8])) -> Option<usize> {
        let streams = self.streams;
        let Protocol::Flock(config) = &mut self.protocol else {
            return Some(1);
        };
        let length = command_bytes(first);
        let command = self.heard.get(..length)?;
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
                let State { first, birds, .. } = *state;
                for (unit, address) in units.iter_mut().zip(1..first.saturating_add(birds)) {
                    // The addresses before the birds' are transmitters.
                    let receiver = if address < first { 0 } else { RECEIVER };
                    *unit = ACCESSIBLE | running | receiver;
                }
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
            [run] if run == config.run => state.asleep = false,
            // Names the bird for the next command; all birds of a group are set up alike.
            [TO_BIRD..=u8::MAX] => {}
            _ => match mode {
                Some(mode) => config.mode = mode,
                None => state.error = NO_COMMAND,
            },
        }
        Some(length)
    }
}

impl State {
    /// Returns the status word: master, initialised, and its present state.
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
