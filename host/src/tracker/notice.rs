//! What a feed reports, and why a device cannot be used.

use super::spec::HidName;
use miette::Diagnostic;
use shisen_tracker::command::Failure;
use shisen_tracker::decoder::Event;
use shisen_tracker::hid::eye_tracker::{Capabilities, Configuration, LayoutError, Status};
use shisen_tracker::time::Micros;
use std::fmt;
use std::io;
use std::path::Path;
use thiserror::Error;

/// A report of a feed.
#[derive(Debug, Clone, PartialEq)]
#[allow(
    clippy::large_enum_variant,
    reason = "nearly all are samples, and events must not allocate"
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
    /// A device that is plugged in again refuses to open: why, and what to do, once a reason.
    Refused(String),
    /// Nothing comes that the decoder understands.
    Trouble(Trouble),
    /// The device was told to restart, and is silent for at most this long.
    Restarting(Micros),
    /// What a tracker on the network does, in a sentence.
    Said(String),
    /// The device's clock at a time showed so many microseconds more than the feed's.
    Offset {
        /// The time on the feed's clock.
        at: Micros,
        /// The difference.
        offset: i64,
    },
    /// A recording has a gap of this length, for which the feed waits.
    Pause(Micros),
}

/// What is wrong with a device or its line, and what may help.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Trouble {
    /// What is wrong.
    pub failure: Failure,
    /// The fields of records that come in, where the decoder expects another number.
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
    #[error("{0} cannot be opened: {1}")]
    #[diagnostic(help("{}", advice(.0, .1)))]
    Open(String, io::Error),
    #[error("no HID device {0} is plugged in")]
    #[diagnostic(help("plug it in; `shisen tracker list` shows what there is"))]
    NotFound(HidName),
    #[error("{} devices are {name}: {}", paths.len(), paths.join(", "))]
    #[diagnostic(help("give one by its path, such as hid:{}", paths.first().map_or("", |p| p)))]
    Several { name: HidName, paths: Vec<String> },
    #[error("{0}: {1}")]
    #[diagnostic(help("`shisen tracker list` marks the devices that are trackers"))]
    Layout(String, LayoutError),
}

impl LiveError {
    pub(super) fn is_absence(&self) -> bool {
        match self {
            Self::Open(_, reason) => reason.kind() == io::ErrorKind::NotFound,
            Self::NotFound(_) => true,
            _ => false,
        }
    }

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
        io::ErrorKind::PermissionDenied => permission(path),
        io::ErrorKind::ResourceBusy => "another program uses it: end that first".to_owned(),
        _ => "check the path and the device".to_owned(),
    }
}

const RULES: &str = "tracker-driver/udev/70-shisen-trackers.rules";

/// Vendor and product of the HID devices that the file names.
const NAMED: [(u16, u16); 2] = [(0x1532, 0x0b00), (0x03eb, 0x2421)];

/// Says which rule or which group is missing for the device at a path.
fn permission(path: &str) -> String {
    let name = Path::new(path).file_name().and_then(|name| name.to_str());
    let name = name.unwrap_or_default();
    if name.starts_with("hidraw") {
        let uevent = std::fs::read_to_string(format!("/sys/class/hidraw/{name}/device/uevent"));
        return hid_advice(uevent.ok().and_then(|uevent| parse(&uevent)));
    }
    if name.starts_with("ttyUSB") || name.starts_with("ttyACM") {
        return format!("a udev rule is missing: {INSTALL}; joining the group dialout does too");
    }
    format!(
        "{RULES} has no rule for such a port, only for ttyUSB and ttyACM: join the group that \
         owns it, which `ls -l {path}` shows (often dialout), and log in again"
    )
}

const INSTALL: &str = "copy tracker-driver/udev/70-shisen-trackers.rules to /etc/udev/rules.d, \
                       run `udevadm control --reload` and plug the device in again";

/// Returns the advice for a HID device, by its vendor and product where the system says them.
fn hid_advice(identity: Option<(u16, u16)>) -> String {
    let Some((vendor, product)) = identity.filter(|id| !NAMED.contains(id)) else {
        return format!("a udev rule is missing: {INSTALL}");
    };
    format!(
        "a udev rule is missing: {INSTALL}; where it is no tracker of usage page 0x12, the file \
         needs one line more: KERNEL==\"hidraw*\", ATTRS{{idVendor}}==\"{vendor:04x}\", \
         ATTRS{{idProduct}}==\"{product:04x}\", TAG+=\"uaccess\""
    )
}

/// Reads vendor and product from a line such as `HID_ID=0003:00001532:00000B00`.
fn parse(uevent: &str) -> Option<(u16, u16)> {
    let id = uevent
        .lines()
        .find_map(|line| line.strip_prefix("HID_ID="))?;
    let mut parts = id.split(':').skip(1);
    let mut number = || u16::try_from(u32::from_str_radix(parts.next()?, 16).ok()?).ok();
    Some((number()?, number()?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn advice_names_the_rules_of_the_file() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
        let rules = std::fs::read_to_string(root.join(RULES)).unwrap();
        for (vendor, product) in NAMED {
            let vendor = format!("ATTRS{{idVendor}}==\"{vendor:04x}\"");
            let ids = format!("{vendor}, ATTRS{{idProduct}}==\"{product:04x}\"");
            assert!(rules.contains(&ids), "{ids}");
        }
        assert_eq!(rules.matches("idVendor").count(), NAMED.len());
        assert!(rules.contains("ttyUSB[0-9]*|ttyACM[0-9]*"));
        for (advice, has, lacks) in [
            (permission("/dev/ttyUSB0"), "rules to /etc/udev", "idVendor"),
            (permission("/dev/ttyUSB0"), "dialout", "ls -l"),
            (
                permission("/dev/ttyS0"),
                "ls -l /dev/ttyS0",
                "rule is missing",
            ),
            (hid_advice(Some(NAMED[0])), "/etc/udev", "idVendor"),
            (hid_advice(Some((0x2104, 0x0313))), "\"2104\"", "dialout"),
            (hid_advice(Some((0x2104, 0x0313))), "\"0313\"", "dialout"),
        ] {
            assert!(advice.contains(has) && !advice.contains(lacks), "{advice}");
        }
        let uevent = "DRIVER=hid-generic\nHID_ID=0003:00001532:00000B00\nHID_NAME=x\n";
        assert_eq!(parse(uevent), Some((0x1532, 0x0b00)));
        assert_eq!(parse("HID_ID=0003:FFFFFFFF:0"), None);
        assert_eq!(parse("DRIVER=x"), None);
    }
}
