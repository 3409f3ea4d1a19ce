//! A device's protocol as a `SPEC` names it, with its settings, and what the device is
//! asked for.

use super::settings::{self, Options};
use crate::files::Fault;
use shisen_tracker::command::Script;
use shisen_tracker::decoder::Decoder;
use shisen_tracker::mock::Device;
use shisen_tracker::protocol::{Asked, Protocol, Reader};
use std::fmt;
use std::ops::RangeInclusive;
use std::str::FromStr;

/// A protocol with its settings, and what its device is asked for.
#[derive(Debug, Clone, PartialEq)]
pub struct ProtocolSpec {
    protocol: Protocol,
    asked: Asked,
}

impl FromStr for ProtocolSpec {
    type Err = Fault;

    /// `NAME`, or `NAME?key=value&…`, with settings.
    fn from_str(text: &str) -> Result<Self, Fault> {
        let (name, rest) = text.split_once('?').unwrap_or((text, ""));
        let mut spec = Self::named(name)?;
        let mut options = Options::read(rest)?;
        spec.set(&mut options)?;
        options.end("", "", Some(&spec.protocol))?;
        Ok(spec)
    }
}

impl fmt::Display for ProtocolSpec {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl ProtocolSpec {
    /// Returns the protocol with a name, with its usual settings.
    ///
    /// # Errors
    /// A name that no protocol has.
    pub fn named(name: &str) -> Result<Self, Fault> {
        let protocol = Protocol::named(name).ok_or_else(|| {
            let help = format!("give one of {}", Protocol::NAMES.join(", "));
            Fault::new(format!("there is no protocol {name:?}"), help)
        })?;
        Ok(Self {
            protocol,
            asked: Asked::default(),
        })
    }

    pub(super) fn set(&mut self, options: &mut Options<'_>) -> Result<(), Fault> {
        settings::set(&mut self.protocol, &mut self.asked, options)
    }

    /// Returns its name.
    pub const fn name(&self) -> &'static str {
        self.protocol.name()
    }

    /// Returns the protocol with its settings.
    pub const fn protocol(&self) -> &Protocol {
        &self.protocol
    }

    /// Returns a decoder; `None` where that takes the device's own description.
    pub fn decoder(&self) -> Option<Box<dyn Decoder + Send>> {
        let reader = Reader::new(&self.protocol)?;
        Some(Box::new(reader))
    }

    /// Returns a simulated device, with as many birds of a Flock as were set.
    pub fn device(&self) -> Device {
        Device::new(&self.protocol).with_birds(self.asked.first_bird, self.asked.birds)
    }

    /// Returns whether its device is told what to send; others send of themselves.
    pub fn is_told(&self) -> bool {
        self.start(false).sends_bytes()
    }

    /// Returns the script that makes its device send, after a reset where `reset` says so.
    pub fn start(&self, reset: bool) -> Script {
        self.protocol.start(&self.asked, reset)
    }

    /// Returns the first and the last sensor of its [`device`](Self::device).
    pub(super) fn simulated_sensors(&self) -> RangeInclusive<u8> {
        match &self.protocol {
            Protocol::Flock(config) => {
                let first = self.asked.first_bird - 1;
                first..=first + u8::from(config.group) * (self.asked.birds - 1)
            }
            _ => 0..=0,
        }
    }
}
