//! The protocols by their names, each with its device as it is usually set
//! up.

use super::settings::{self, Options};
use super::spec::SpecError;
use miette::Diagnostic;
use shisen_tracker::command::Script;
use shisen_tracker::decoder::Decoder;
use shisen_tracker::eye::{adhawk, asl, iscan};
use shisen_tracker::head::{fastrak, flock, hatire, liberty};
use shisen_tracker::link;
use shisen_tracker::mock::{Device, Format, Reader};
use std::fmt;
use std::ops::RangeInclusive;
use std::str::FromStr;
use thiserror::Error;

/// A protocol and its device.
#[derive(Debug, Clone, PartialEq)]
pub struct Protocol {
    name: &'static str,
    format: Format,
    asked: Asked,
}

/// What a device is asked for beside its format.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Asked {
    /// Samples per second; where there is none, the device's own.
    pub(super) rate: Option<u16>,
    /// The address of the first of the birds.
    pub(super) first_bird: u8,
    /// How many there are.
    pub(super) birds: u8,
}

/// No protocol has this name.
#[derive(Debug, Clone, PartialEq, Eq, Error, Diagnostic)]
#[error("there is no protocol {name:?}")]
#[diagnostic(help("give one of {}", Format::NAMES.join(", ")))]
pub struct UnknownProtocol {
    name: String,
}

impl FromStr for Protocol {
    type Err = SpecError;

    /// `NAME`, or `NAME?key=value&…`, with settings.
    fn from_str(text: &str) -> Result<Self, SpecError> {
        let (name, rest) = text.split_once('?').unwrap_or((text, ""));
        let mut protocol = Self::named(name)?;
        let mut options = Options::read(rest)?;
        protocol.set(&mut options)?;
        options.end("", "", Some((protocol.name, &protocol.format)))?;
        Ok(protocol)
    }
}

impl fmt::Display for Protocol {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name)
    }
}

impl Protocol {
    /// By its name, set up as is usual.
    ///
    /// # Errors
    /// A name that none has.
    pub fn named(name: &str) -> Result<Self, UnknownProtocol> {
        let known = Format::NAMES.into_iter().find(|&known| known == name);
        known
            .and_then(|name| {
                let format = Format::named(name)?;
                let asked = Asked {
                    rate: None,
                    first_bird: 1,
                    birds: 1,
                };
                Some(Self {
                    name,
                    format,
                    asked,
                })
            })
            .ok_or_else(|| UnknownProtocol { name: name.into() })
    }

    /// Takes those of the options that are its settings.
    ///
    /// # Errors
    /// A value that its setting cannot have.
    pub(super) fn set(&mut self, options: &mut Options<'_>) -> Result<(), SpecError> {
        settings::set(&mut self.format, &mut self.asked, options)
    }

    /// What it is called.
    pub const fn name(&self) -> &'static str {
        self.name
    }

    /// How its bytes are written.
    pub const fn format(&self) -> &Format {
        &self.format
    }

    /// Whether it goes over a serial line; the others are reports of human
    /// interface devices.
    pub const fn is_serial(&self) -> bool {
        !matches!(self.format, Format::OsvrHdk | Format::EyeTracker(..))
    }

    /// What reads it; `None` where that takes the device's own description.
    pub fn decoder(&self) -> Option<Box<dyn Decoder + Send>> {
        let reader = Reader::new(&self.format)?;
        Some(Box::new(reader))
    }

    /// The device, simulated: as many birds of a Flock as were set.
    pub fn device(&self) -> Device {
        Device::new(&self.format).with_birds(self.asked.first_bird, self.asked.birds)
    }

    /// Whether its device is told what to send; others send of themselves.
    pub fn is_told(&self) -> bool {
        self.start(false).says_anything()
    }

    /// What makes its device send; a reset is a part of it only where `reset`
    /// says so.
    pub fn start(&self, reset: bool) -> Script {
        match &self.format {
            Format::Link => link::start(self.asked.rate),
            Format::Fastrak(config) => config.start(reset),
            Format::Liberty(config) => config.start(reset),
            Format::Flock(config) => config.start(self.asked.first_bird, self.asked.birds, reset),
            Format::Hatire(_) => hatire::start(reset),
            Format::Iscan(_) => iscan::start(),
            Format::Asl(_) => asl::start(),
            // Directions, origins, pupils, and how the head is turned.
            Format::AdHawk => {
                let rate = self.asked.rate.unwrap_or(250);
                adhawk::start(0b1_0010_1110, rate.into())
            }
            _ => Script::new(),
        }
    }

    /// What makes its device send no more; nothing where no command does.
    pub fn stop(&self) -> Script {
        match &self.format {
            Format::Link => link::stop(),
            Format::Fastrak(_) => fastrak::stop(),
            Format::Liberty(_) => liberty::stop(),
            Format::Flock(_) => flock::stop(),
            Format::Hatire(_) => hatire::stop(),
            Format::Iscan(_) => iscan::stop(),
            Format::AdHawk => adhawk::stop(),
            _ => Script::new(),
        }
    }

    /// What changes the line's speed at both ends, which some devices do.
    pub fn change_speed(&self, baud: u32) -> Option<Script> {
        match &self.format {
            Format::Fastrak(_) => fastrak::change_speed(baud),
            _ => None,
        }
    }

    /// The line's speed where nobody says otherwise.
    pub const fn baud(&self) -> u32 {
        match self.format {
            Format::Asl(_) => asl::BAUD,
            Format::Flock(_) => flock::BAUD,
            Format::Hatire(_) => hatire::BAUD,
            Format::Iscan(_) => iscan::BAUD,
            _ => 115_200,
        }
    }

    /// Where the line's RTS has to be, where it means anything to its devices: a
    /// Flock's is in reset while it is high.
    pub const fn rts(&self) -> Option<bool> {
        match self.format {
            Format::Flock(_) => Some(false),
            _ => None,
        }
    }

    /// Whether its devices can be told to restart.
    pub fn has_reset(&self) -> bool {
        self.start(true) != self.start(false)
    }

    /// Whether its devices can be told to send no more.
    pub fn has_stop(&self) -> bool {
        self.stop() != Script::new()
    }

    /// Whether its devices can have several sensors, of which one is the viewer's
    /// head.
    pub const fn has_sensors(&self) -> bool {
        matches!(
            self.format,
            Format::Link | Format::Fastrak(_) | Format::Liberty(_) | Format::Flock(_)
        )
    }

    /// The sensors of its [`device`](Self::device), the first and the last.
    pub(super) const fn simulated_sensors(&self) -> RangeInclusive<u8> {
        match &self.format {
            Format::Flock(config) if config.group => {
                let first = self.asked.first_bird - 1;
                first..=first + (self.asked.birds - 1)
            }
            Format::Flock(_) => self.asked.first_bird - 1..=self.asked.first_bird - 1,
            _ => 0..=0,
        }
    }

    /// Whether its devices measure the head.
    pub const fn has_head(&self) -> bool {
        !matches!(self.format, Format::Iscan(_) | Format::Asl(_))
    }

    /// Whether its devices measure the eyes.
    pub const fn has_eyes(&self) -> bool {
        matches!(
            self.format,
            Format::Link
                | Format::Iscan(_)
                | Format::Asl(_)
                | Format::AdHawk
                | Format::EyeTracker(..)
        )
    }
}
