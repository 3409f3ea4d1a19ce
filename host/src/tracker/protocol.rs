//! The protocols by their names, each with its device as it is usually set
//! up.

use miette::Diagnostic;
use shisen_tracker::command::Script;
use shisen_tracker::decoder::Decoder;
use shisen_tracker::eye::{adhawk, asl, iscan};
use shisen_tracker::head::{fastrak, flock, hatire, liberty, osvr_hdk};
use shisen_tracker::hid::eye_tracker::{Axes, EyeTracker, documented};
use shisen_tracker::link;
use shisen_tracker::mock::Format;
use std::fmt;
use std::str::FromStr;
use thiserror::Error;

/// A protocol and its device.
#[derive(Debug, Clone, PartialEq)]
pub struct Protocol {
    name: &'static str,
    format: Format,
}

/// No protocol has this name.
#[derive(Debug, Clone, PartialEq, Eq, Error, Diagnostic)]
#[error("there is no protocol {name:?}")]
#[diagnostic(help("give one of {}", Format::NAMES.join(", ")))]
pub struct UnknownProtocol {
    name: String,
}

impl FromStr for Protocol {
    type Err = UnknownProtocol;

    fn from_str(name: &str) -> Result<Self, UnknownProtocol> {
        let known = Format::NAMES.into_iter().find(|&known| known == name);
        known
            .and_then(|name| {
                let format = Format::named(name)?;
                Some(Self { name, format })
            })
            .ok_or_else(|| UnknownProtocol { name: name.into() })
    }
}

impl fmt::Display for Protocol {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name)
    }
}

impl Protocol {
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
        !matches!(self.format, Format::OsvrHdk | Format::EyeTracker(_))
    }

    /// What reads it; `None` where that takes the device's own description.
    pub fn decoder(&self) -> Option<Box<dyn Decoder + Send>> {
        Some(match &self.format {
            Format::Link => Box::new(link::Link::new()),
            Format::Fastrak(config) => Box::new(fastrak::Fastrak::new(config.clone())),
            Format::Liberty(config) => Box::new(liberty::Liberty::new(config.clone())),
            Format::Flock(config) => Box::new(flock::Flock::new(*config)),
            Format::Hatire(config) => Box::new(hatire::Hatire::new(*config)),
            Format::OsvrHdk => Box::new(osvr_hdk::Decoder::new()),
            Format::Iscan(config) => Box::new(iscan::Iscan::new(*config)),
            Format::Asl(layout) => Box::new(asl::Asl::new(asl::Config {
                layout: *layout,
                ..asl::Config::default()
            })),
            Format::AdHawk => Box::new(adhawk::AdHawk::new()),
            Format::EyeTracker(_) => {
                let tracker = EyeTracker::new(&documented::DESCRIPTOR, Axes::default());
                Box::new(tracker.ok()?)
            }
            _ => return None,
        })
    }

    /// What makes its device send; a reset is a part of it only where `reset`
    /// says so.
    pub fn start(&self, reset: bool) -> Script {
        match &self.format {
            Format::Link => link::start(None),
            Format::Fastrak(config) => config.start(reset),
            Format::Liberty(config) => config.start(reset),
            Format::Flock(config) => config.start(1, 1, reset),
            Format::Hatire(_) => hatire::start(reset),
            Format::Iscan(_) => iscan::start(),
            Format::Asl(_) => asl::start(),
            // Directions, origins, pupils, and how the head is turned.
            Format::AdHawk => adhawk::start(0b1_0010_1110, 250.0),
            _ => Script::new(),
        }
    }

    /// The line's speed where nobody says otherwise.
    pub const fn baud(&self) -> u32 {
        match self.format {
            Format::Asl(_) => asl::BAUD,
            Format::Flock(_) => flock::BAUD,
            _ => 115_200,
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
                | Format::EyeTracker(_)
        )
    }
}
