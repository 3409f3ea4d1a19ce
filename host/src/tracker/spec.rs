//! `SPEC`: which tracker, in one word of a command line.

mod error;
mod read;

pub use error::SpecError;

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
pub enum Spec {
    /// `mock`, `mock:seed=7&rate=200&as=fastrak`.
    Mock(MockSpec),
    /// `serial:/dev/ttyUSB0?protocol=fastrak&baud=115200&reset=1&units=cm`.
    Serial(SerialSpec),
    /// `hid:1532:0b00`, `hid:usage=0012`, `hid:/dev/hidraw0?origin=0,0.3,-0.5`.
    Hid(HidSpec),
    /// `replay:FILE`, `replay:FILE?head=2`.
    Replay(ReplaySpec),
}

impl Spec {
    /// The sensor that is the viewer's head, where somebody says so.
    pub const fn head(&self) -> Option<u8> {
        match self {
            Self::Mock(spec) => spec.head,
            Self::Serial(spec) => spec.head,
            Self::Hid(_) => None,
            Self::Replay(spec) => spec.head,
        }
    }

    /// After how long data are stale, and count as stuck, where somebody says so.
    pub const fn times(&self) -> &Times {
        match self {
            Self::Mock(spec) => &spec.times,
            Self::Serial(spec) => &spec.times,
            Self::Hid(spec) => &spec.times,
            Self::Replay(spec) => &spec.times,
        }
    }

    /// How to read its clock. Of a simulated tracker it is known how late it is; of others
    /// nothing is but what somebody says.
    pub fn clock(&self) -> ClockConfig {
        match self {
            Self::Mock(spec) => spec.times.clock(spec.delay()),
            _ => self.times().clock(Micros(0)),
        }
    }
}

/// A simulated viewer and tracker.
#[derive(Debug, Clone, PartialEq)]
pub struct MockSpec {
    /// What decides all movements and all noise.
    pub seed: u64,
    /// Samples per second: 60 to 10,000.
    pub rate: u32,
    /// The protocol that the samples pass through; none hands them on as they
    /// are.
    pub protocol: Option<ProtocolSpec>,
    /// The head is held still, as by a chin rest.
    pub still: bool,
    /// A table of what is looked at, and when: see
    /// [`read_script`](super::calibration::read_script).
    pub targets: Option<PathBuf>,
    /// The sensor that is the viewer's head, as its samples name it: 0 alone comes.
    pub head: Option<u8>,
    /// After how long its data are stale.
    pub times: Times,
}

impl MockSpec {
    /// From the measurement of a sample to its arrival.
    pub fn delay(&self) -> Micros {
        self.times
            .delay()
            .unwrap_or(TrackerConfig::default().latency)
    }
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
            head: None,
            times: Times::default(),
        }
    }
}

/// A tracker on a serial line.
#[derive(Debug, Clone, PartialEq)]
pub struct SerialSpec {
    /// The port.
    pub path: String,
    /// What the device speaks.
    pub protocol: ProtocolSpec,
    /// How fast.
    pub baud: u32,
    /// Whether the device is reset first, which can take 20 s.
    pub reset: bool,
    /// The speed that the line is changed to at both ends, once it is open.
    pub speed: Option<u32>,
    /// Whether the device is told to stop when nobody listens any more.
    pub stop: bool,
    /// The sensor that is the viewer's head, as its samples name it; the first
    /// that is seen where nobody says so.
    pub head: Option<u8>,
    /// Whether the line's RTS is to be high; where nobody says so it is as
    /// [`Protocol::rts`](shisen_tracker::protocol::Protocol::rts) has it.
    pub rts: Option<bool>,
    /// After how long its data are stale.
    pub times: Times,
}

/// A recording.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ReplaySpec {
    /// What `shisen tracker record` wrote.
    pub path: PathBuf,
    /// The sensor that is the viewer's head, as its samples name it; the first
    /// that is seen where nobody says so.
    pub head: Option<u8>,
    /// After how long its data are stale.
    pub times: Times,
}

/// A human interface device.
#[derive(Debug, Clone, PartialEq)]
pub struct HidSpec {
    /// Which.
    pub name: HidName,
    /// The coordinates of an eye tracker; its descriptor does not say.
    pub axes: Axes,
    /// After how long its data are stale.
    pub times: Times,
}

/// Which human interface device.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum HidName {
    /// By USB's vendor and product.
    Id(u16, u16),
    /// By its path.
    Path(String),
    /// By what it says that it is: a usage page and, where one is given, a usage of
    /// one of its collections. 0x12 is that of eye and head trackers.
    Usage {
        /// The page.
        page: u16,
        /// The usage; any of the page where there is none.
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
