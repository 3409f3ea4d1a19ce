//! A device's protocol as a `SPEC` names it, with its settings, and what the device is
//! asked for.

use super::settings::{self, Options};
use super::spec::SpecError;
use miette::Diagnostic;
use shisen_tracker::command::Script;
use shisen_tracker::decoder::Decoder;
use shisen_tracker::mock::Device;
use shisen_tracker::protocol::{Asked, Protocol, Reader};
use std::fmt;
use std::ops::RangeInclusive;
use std::str::FromStr;
use thiserror::Error;

/// A protocol with its settings, and what its device is asked for.
#[derive(Debug, Clone, PartialEq)]
pub struct ProtocolSpec {
    protocol: Protocol,
    asked: Asked,
}

/// No protocol has this name.
#[derive(Debug, Clone, PartialEq, Eq, Error, Diagnostic)]
#[error("there is no protocol {name:?}")]
#[diagnostic(help("give one of {}", Protocol::NAMES.join(", ")))]
pub struct UnknownProtocol {
    name: String,
}

impl FromStr for ProtocolSpec {
    type Err = SpecError;

    /// `NAME`, or `NAME?key=value&…`, with settings.
    fn from_str(text: &str) -> Result<Self, SpecError> {
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
    /// By its name, set up as is usual.
    ///
    /// # Errors
    /// A name that none has.
    pub fn named(name: &str) -> Result<Self, UnknownProtocol> {
        let protocol = Protocol::named(name);
        let protocol = protocol.ok_or_else(|| UnknownProtocol { name: name.into() })?;
        Ok(Self {
            protocol,
            asked: Asked::default(),
        })
    }

    /// Takes those of the options that are its settings.
    ///
    /// # Errors
    /// A value that its setting cannot have.
    pub(super) fn set(&mut self, options: &mut Options<'_>) -> Result<(), SpecError> {
        settings::set(&mut self.protocol, &mut self.asked, options)
    }

    /// What it is called.
    pub const fn name(&self) -> &'static str {
        self.protocol.name()
    }

    /// The protocol, set up.
    pub const fn protocol(&self) -> &Protocol {
        &self.protocol
    }

    /// What reads it; `None` where that takes the device's own description.
    pub fn decoder(&self) -> Option<Box<dyn Decoder + Send>> {
        let reader = Reader::new(&self.protocol)?;
        Some(Box::new(reader))
    }

    /// The device, simulated: as many birds of a Flock as were set.
    pub fn device(&self) -> Device {
        Device::new(&self.protocol).with_birds(self.asked.first_bird, self.asked.birds)
    }

    /// Whether its device is told what to send; others send of themselves.
    pub fn is_told(&self) -> bool {
        self.start(false).says_anything()
    }

    /// What makes its device send; a reset is a part of it only where `reset`
    /// says so.
    pub fn start(&self, reset: bool) -> Script {
        self.protocol.start(&self.asked, reset)
    }

    /// Whether its devices can be told to restart.
    pub fn has_reset(&self) -> bool {
        self.start(true) != self.start(false)
    }

    /// Whether its devices can be told to send no more.
    pub fn has_stop(&self) -> bool {
        self.protocol.stop() != Script::new()
    }

    /// The sensors of its [`device`](Self::device), the first and the last.
    pub(super) const fn simulated_sensors(&self) -> RangeInclusive<u8> {
        match &self.protocol {
            Protocol::Flock(config) if config.group => {
                let first = self.asked.first_bird - 1;
                first..=first + (self.asked.birds - 1)
            }
            Protocol::Flock(_) => self.asked.first_bird - 1..=self.asked.first_bird - 1,
            _ => 0..=0,
        }
    }
}
