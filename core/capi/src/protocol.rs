//! The protocols that the library was built for, each with its device as it is
//! usually set up.

use crate::status::Status;
use shisen_tracker::command::Script;
use shisen_tracker::decoder::{Counts, Decoder, Event};
#[cfg(feature = "adhawk")]
use shisen_tracker::eye::adhawk;
#[cfg(feature = "asl")]
use shisen_tracker::eye::asl;
#[cfg(feature = "iscan")]
use shisen_tracker::eye::iscan;
#[cfg(feature = "fastrak")]
use shisen_tracker::head::fastrak;
#[cfg(feature = "flock")]
use shisen_tracker::head::flock;
#[cfg(feature = "hatire")]
use shisen_tracker::head::hatire;
#[cfg(feature = "liberty")]
use shisen_tracker::head::liberty;
#[cfg(feature = "link")]
use shisen_tracker::link;
use shisen_tracker::time::Micros;

#[cfg(not(any(
    feature = "adhawk",
    feature = "asl",
    feature = "fastrak",
    feature = "flock",
    feature = "hatire",
    feature = "iscan",
    feature = "liberty",
    feature = "link"
)))]
compile_error!("no tracker's protocol is chosen: give --features link, or another protocol's name");

/// A protocol that trackers speak.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u32)]
pub enum Protocol {
    /// Shisen's own link: all that a tracker can know of head and eyes.
    Link = 0,
    /// Polhemus FASTRAK and InterSense IS-600, IS-900: the head, in binary
    /// positions and quaternions, inches.
    Fastrak = 1,
    /// Polhemus Liberty and Patriot: the head, in binary positions, quaternions
    /// and times, inches.
    Liberty = 2,
    /// Ascension Flock of Birds, one bird: the head.
    Flock = 3,
    /// Hatire: the head.
    Hatire = 4,
    /// ISCAN: one eye, in raw units.
    Iscan = 5,
    /// ASL EYE-TRAC: one eye, in raw units.
    Asl = 6,
    /// AdHawk: both eyes, and how the head is turned.
    Adhawk = 7,
}

impl Protocol {
    pub(crate) const ALL: [Self; 8] = [
        Self::Link,
        Self::Fastrak,
        Self::Liberty,
        Self::Flock,
        Self::Hatire,
        Self::Iscan,
        Self::Asl,
        Self::Adhawk,
    ];

    pub(crate) fn of_number(number: u32) -> Result<Self, Status> {
        let found = Self::ALL.into_iter().find(|known| *known as u32 == number);
        found.ok_or(Status::UnknownChoice)
    }

    /// Whether its devices measure the head.
    pub(crate) const fn has_head(self) -> bool {
        !matches!(self, Self::Iscan | Self::Asl)
    }

    /// Whether its devices measure the eyes.
    pub(crate) const fn has_eyes(self) -> bool {
        matches!(self, Self::Link | Self::Iscan | Self::Asl | Self::Adhawk)
    }
}

/// A device and what reads it.
#[allow(
    clippy::large_enum_variant,
    reason = "one of them, which stays where it is"
)]
pub(crate) enum Device {
    #[cfg(feature = "link")]
    Link(link::Link),
    #[cfg(feature = "fastrak")]
    Fastrak(fastrak::Fastrak),
    #[cfg(feature = "liberty")]
    Liberty(liberty::Liberty),
    #[cfg(feature = "flock")]
    Flock(flock::Flock),
    #[cfg(feature = "hatire")]
    Hatire(hatire::Hatire),
    #[cfg(feature = "iscan")]
    Iscan(iscan::Iscan),
    #[cfg(feature = "asl")]
    Asl(asl::Asl),
    #[cfg(feature = "adhawk")]
    AdHawk(adhawk::AdHawk),
}

impl Device {
    pub(crate) fn new(protocol: Protocol) -> Result<Self, Status> {
        match protocol {
            #[cfg(feature = "link")]
            Protocol::Link => Ok(Self::Link(link::Link::new())),
            #[cfg(feature = "fastrak")]
            Protocol::Fastrak => Ok(Self::Fastrak(fastrak::Fastrak::new(
                fastrak::Config::default(),
            ))),
            #[cfg(feature = "liberty")]
            Protocol::Liberty => Ok(Self::Liberty(liberty::Liberty::new(
                liberty::Config::default(),
            ))),
            #[cfg(feature = "flock")]
            Protocol::Flock => Ok(Self::Flock(flock::Flock::new(flock::Config::default()))),
            #[cfg(feature = "hatire")]
            Protocol::Hatire => Ok(Self::Hatire(hatire::Hatire::new(hatire::Config::default()))),
            #[cfg(feature = "iscan")]
            Protocol::Iscan => Ok(Self::Iscan(iscan::Iscan::new(iscan::Config::default()))),
            #[cfg(feature = "asl")]
            Protocol::Asl => Ok(Self::Asl(asl::Asl::new(asl::Config::default()))),
            #[cfg(feature = "adhawk")]
            Protocol::Adhawk => Ok(Self::AdHawk(adhawk::AdHawk::new())),
            #[allow(unreachable_patterns, reason = "all of them can be built in")]
            _ => Err(Status::NotBuilt),
        }
    }

    /// What makes it send, so many samples a second where `hertz` says so and
    /// the protocol has words for it; a reset is a part of it only where
    /// `reset` says so.
    #[allow(
        unused_variables,
        reason = "not every protocol takes a rate or a reset"
    )]
    pub(crate) fn start(&self, hertz: Option<u16>, reset: bool) -> Script {
        match self {
            #[cfg(feature = "link")]
            Self::Link(_) => link::start(hertz),
            #[cfg(feature = "fastrak")]
            Self::Fastrak(_) => fastrak::Config::default().start(reset),
            #[cfg(feature = "liberty")]
            Self::Liberty(_) => liberty::Config::default().start(reset),
            #[cfg(feature = "flock")]
            Self::Flock(_) => flock::Config::default().start(1, 1, reset),
            #[cfg(feature = "hatire")]
            Self::Hatire(_) => hatire::start(reset),
            #[cfg(feature = "iscan")]
            Self::Iscan(_) => iscan::start(),
            #[cfg(feature = "asl")]
            Self::Asl(_) => asl::start(),
            #[cfg(feature = "adhawk")]
            Self::AdHawk(_) => {
                let hertz = hertz.unwrap_or(adhawk::USUAL_HERTZ);
                adhawk::start(adhawk::USUAL_FIELDS, hertz.into())
            }
        }
    }
}

/// What a device's own decoder does. Not by a table of methods: calls through
/// pointers cannot be bounded as closely.
macro_rules! by_its_decoder {
    ($device:expr, $decoder:ident => $act:expr) => {
        match $device {
            #[cfg(feature = "link")]
            Device::Link($decoder) => $act,
            #[cfg(feature = "fastrak")]
            Device::Fastrak($decoder) => $act,
            #[cfg(feature = "liberty")]
            Device::Liberty($decoder) => $act,
            #[cfg(feature = "flock")]
            Device::Flock($decoder) => $act,
            #[cfg(feature = "hatire")]
            Device::Hatire($decoder) => $act,
            #[cfg(feature = "iscan")]
            Device::Iscan($decoder) => $act,
            #[cfg(feature = "asl")]
            Device::Asl($decoder) => $act,
            #[cfg(feature = "adhawk")]
            Device::AdHawk($decoder) => $act,
        }
    };
}

// Not a part of its caller, who would keep the room of each decoder.
#[inline(never)]
fn feed(decoder: &mut impl Decoder, bytes: &[u8], arrival: Micros, sink: &mut dyn FnMut(Event)) {
    decoder.feed(bytes, arrival, sink);
}

impl Decoder for Device {
    fn feed(&mut self, bytes: &[u8], arrival: Micros, sink: &mut dyn FnMut(Event)) {
        by_its_decoder!(self, decoder => feed(decoder, bytes, arrival, sink));
    }

    fn counts(&self) -> &Counts {
        by_its_decoder!(self, decoder => decoder.counts())
    }

    fn reset(&mut self) {
        by_its_decoder!(self, decoder => decoder.reset());
    }

    fn on_sent(&mut self, command: &[u8], now: Micros) {
        by_its_decoder!(self, decoder => decoder.on_sent(command, now));
    }
}
