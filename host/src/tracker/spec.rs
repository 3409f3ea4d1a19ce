//! `SPEC`: which tracker, in one word of a command line.

mod read;

use super::protocol::ProtocolSpec;
use super::times::Times;
use shisen_tracker::clock::ClockConfig;
use shisen_tracker::hid::eye_tracker::Axes;
use shisen_tracker::mock::TrackerConfig;
use shisen_tracker::time::Micros;
use std::fmt;
use std::path::PathBuf;

/// Which tracker.
#[derive(Debug, Clone, PartialEq)]
pub struct Spec {
    /// The tracker.
    pub kind: TrackerKind,
    /// The sensor on the viewer's head; `None`: the first that sends.
    pub head: Option<u8>,
    /// How late the tracker is, and after how long its data are stale or stuck.
    pub times: Times,
}

/// A kind of tracker.
#[derive(Debug, Clone, PartialEq)]
pub enum TrackerKind {
    /// `mock`, `mock:seed=7&rate=200&as=fastrak`.
    Mock(MockSpec),
    /// `serial:/dev/ttyUSB0?protocol=fastrak&baud=115200&reset=1&units=cm`.
    Serial(SerialSpec),
    /// `hid:1532:0b00`, `hid:usage=0012`, `hid:/dev/hidraw0?origin=0,0.3,-0.5`.
    Hid(HidSpec),
    /// `replay:FILE`, `replay:FILE?head=2`: a file that `shisen tracker record` wrote.
    Replay(PathBuf),
}

impl From<TrackerKind> for Spec {
    /// The first sensor, and the usual times.
    fn from(kind: TrackerKind) -> Self {
        let (head, times) = (None, Times::default());
        Self { kind, head, times }
    }
}

impl Spec {
    /// How to read the tracker's clock, by the mock's delay or the specification's.
    pub fn clock(&self) -> ClockConfig {
        let usual = match &self.kind {
            TrackerKind::Mock(mock) => mock.delay,
            _ => Micros(0),
        };
        ClockConfig {
            least_delay: self.times.delay.unwrap_or(usual),
            ..ClockConfig::default()
        }
    }

    /// The protocol; `None` where the specification does not name it.
    pub(super) const fn protocol(&self) -> Option<&ProtocolSpec> {
        match &self.kind {
            TrackerKind::Mock(mock) => mock.protocol.as_ref(),
            TrackerKind::Serial(serial) => Some(&serial.protocol),
            TrackerKind::Hid(_) | TrackerKind::Replay(_) => None,
        }
    }
}

/// A simulated viewer and tracker.
#[derive(Debug, Clone, PartialEq)]
pub struct MockSpec {
    /// The seed of all movements and all noise.
    pub seed: u64,
    /// Samples per second: 60 to 10,000.
    pub rate: u32,
    /// The protocol that the samples pass through; `None` hands them on unchanged.
    pub protocol: Option<ProtocolSpec>,
    /// Whether the head is held still, as by a chin rest.
    pub still: bool,
    /// A table of targets: [`read_script`](super::calibration::read_script).
    pub targets: Option<PathBuf>,
    /// The time from a sample's measurement to its arrival.
    pub delay: Micros,
}

impl Default for MockSpec {
    /// Seed 1, 500 Hz, no protocol, looking around.
    fn default() -> Self {
        Self {
            seed: 1,
            rate: 500,
            protocol: None,
            still: false,
            targets: None,
            delay: TrackerConfig::default().latency,
        }
    }
}

/// A tracker on a serial line.
#[derive(Debug, Clone, PartialEq)]
pub struct SerialSpec {
    /// The port.
    pub path: String,
    /// The device's protocol.
    pub protocol: ProtocolSpec,
    /// The line's speed, baud.
    pub baud: u32,
    /// Whether the device is reset first, which can take 20 s.
    pub reset: bool,
    /// The speed to which both ends change once the line is open, baud.
    pub speed: Option<u32>,
    /// Whether the device is told to stop at the end.
    pub stop: bool,
    /// Whether the line's RTS is high; `None`: as
    /// [`Protocol::rts`](shisen_tracker::protocol::Protocol::rts) has it.
    pub rts: Option<bool>,
}

/// A human interface device.
#[derive(Debug, Clone, PartialEq)]
pub struct HidSpec {
    /// Which device.
    pub name: HidName,
    /// The axes of an eye tracker, which its descriptor does not say.
    pub axes: Axes,
}

/// Which human interface device.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum HidName {
    /// By USB vendor and product.
    Id(u16, u16),
    /// By its path.
    Path(String),
    /// By a usage of one of its collections; page 0x12 is eye and head trackers.
    Usage {
        /// The page.
        page: u16,
        /// The usage; `None`: any of the page.
        usage: Option<u16>,
    },
}

impl fmt::Display for HidName {
    /// As in a specification.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Id(vendor, product) => write!(f, "{vendor:04x}:{product:04x}"),
            Self::Path(path) => f.write_str(path),
            Self::Usage { page, usage: None } => write!(f, "usage={page:04x}"),
            Self::Usage {
                page,
                usage: Some(usage),
            } => write!(f, "usage={page:04x}:{usage:04x}"),
        }
    }
}

#[cfg(test)]
mod tests;
