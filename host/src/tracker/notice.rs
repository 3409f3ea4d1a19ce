//! What a feed reports, and why a device cannot be used.

mod permission;

use super::spec::HidName;
use miette::Diagnostic;
use shisen_tracker::command::Failure;
use shisen_tracker::decoder::Event;
use shisen_tracker::hid::eye_tracker::{Capabilities, Configuration, LayoutError, Status};
use shisen_tracker::time::Micros;
use std::fmt;
use std::io;
use thiserror::Error;

/// A report of a feed.
#[derive(Debug, Clone, PartialEq)]
#[allow(
    clippy::large_enum_variant,
    reason = "nearly all are samples, and none of these is to take memory of its own"
)]
pub enum Notice {
    /// What the decoder read.
    Decoded(Event),
    /// The device was plugged in, at this path.
    Plugged(String),
    /// What an eye tracker says of itself, right after it was plugged in.
    Described(Box<Features>),
    /// The device was unplugged; the feed looks for it.
    Unplugged {
        /// Its path.
        path: String,
        /// The system's message.
        reason: String,
    },
    /// The device is plugged in again but has refused to open for a while. Sent once for
    /// each reason; holds the reason and what to do about it.
    Refused(String),
    /// Nothing comes that the decoder understands.
    Trouble(Trouble),
    /// The device was told to restart, and is silent for at most this long.
    Restarting(Micros),
    /// A recording has a gap of this length, for which the feed waits.
    Pause(Micros),
}

/// What is wrong with a device or its line, and what may help.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Trouble {
    /// What is wrong.
    pub failure: Failure,
    /// The number of fields in the records that come in, where the decoder expects another
    /// ([`Decoder::fields_seen`](shisen_tracker::decoder::Decoder::fields_seen)).
    pub fields_seen: Option<usize>,
}

impl fmt::Display for Trouble {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.failure.fmt(f)?;
        self.fields_seen.map_or(Ok(()), |fields| {
            write!(
                f,
                "; records of {fields} outputs seem to come in: name as many in SPEC (outputs=)"
            )
        })
    }
}

/// What an eye tracker of usage page 0x12 says of itself in its feature reports.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Features {
    /// What it can do.
    pub capabilities: Option<Capabilities>,
    /// How it is set up.
    pub configuration: Option<Configuration>,
    /// Its state.
    pub status: Option<Status>,
    /// Reports of its descriptor that could not be read, and why.
    pub unread: Vec<String>,
    /// Why it refused the request to send all that it has; `None` where it did not.
    pub refused: Option<String>,
}

/// Why a device cannot be used.
#[derive(Debug, Error, Diagnostic)]
pub(super) enum LiveError {
    /// A path that the system does not open.
    #[error("{0} cannot be opened: {1}")]
    #[diagnostic(help("{}", advice(.0, .1)))]
    Open(String, io::Error),
    /// No such device is plugged in.
    #[error("no HID device {0} is plugged in")]
    #[diagnostic(help("plug it in; `shisen tracker list` shows what there is"))]
    NotFound(HidName),
    /// Several devices have the name.
    #[error("{} devices are {name}: {}", paths.len(), paths.join(", "))]
    #[diagnostic(help("give one by its path, such as hid:{}", paths.first().map_or("", |p| p)))]
    Several { name: HidName, paths: Vec<String> },
    /// A path of a device that is no tracker.
    #[error("{0}: {1}")]
    #[diagnostic(help("`shisen tracker list` marks the devices that are trackers"))]
    Layout(String, LayoutError),
}

impl LiveError {
    /// Whether no such device is plugged in.
    pub(super) fn is_absence(&self) -> bool {
        match self {
            Self::Open(_, reason) => reason.kind() == io::ErrorKind::NotFound,
            Self::NotFound(_) => true,
            _ => false,
        }
    }

    /// What is wrong and what to do, on one line.
    pub(super) fn full_text(&self) -> String {
        match self.help() {
            Some(help) => format!("{self}: {help}"),
            None => self.to_string(),
        }
    }
}

fn advice(path: &str, reason: &io::Error) -> String {
    match reason.kind() {
        io::ErrorKind::NotFound => {
            "plug the device in, or give another path; `shisen tracker list` shows what there is"
                .to_owned()
        }
        io::ErrorKind::PermissionDenied => permission::advice(path),
        io::ErrorKind::ResourceBusy => "another program uses it: end that first".to_owned(),
        _ => "check the path and the device".to_owned(),
    }
}
