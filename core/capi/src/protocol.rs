//! The protocols that the library was built for, each with its device's usual
//! settings.

use crate::status::Status;
use shisen_tracker::command::Script;
use shisen_tracker::decoder::{Counts, Decoder, Event};
use shisen_tracker::time::Micros;
#[allow(unused_imports, reason = "those of the protocols that are built in")]
use shisen_tracker::{
    eye::{adhawk, asl, iscan},
    head::{fastrak, flock, hatire, liberty},
    link,
};

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

    /// Returns whether its devices measure the head.
    pub(crate) const fn has_head(self) -> bool {
        !matches!(self, Self::Iscan | Self::Asl)
    }

    /// Returns whether its devices measure the eyes.
    pub(crate) const fn has_eyes(self) -> bool {
        matches!(self, Self::Link | Self::Iscan | Self::Asl | Self::Adhawk)
    }
}

/// Defines `Device` from the feature, the decoder and the start script of each protocol. A script
/// asks for `$hertz` samples a second if the protocol has a command for that, and begins with a
/// reset if `$reset`.
///
/// No trait object: the stack of calls through pointers cannot be bounded as closely.
macro_rules! devices {
    ($(
        $feature:literal $name:ident($decoder:ty) = $new:expr,
        |$hertz:pat_param, $reset:pat_param| $start:expr;
    )*) => {
        #[allow(
            clippy::large_enum_variant,
            reason = "one of them, which stays where it is"
        )]
        pub(crate) enum Device {
            $(#[cfg(feature = $feature)] $name($decoder),)*
        }

        impl Device {
            pub(crate) fn new(protocol: Protocol) -> Result<Self, Status> {
                match protocol {
                    $(#[cfg(feature = $feature)] Protocol::$name => Ok(Self::$name($new)),)*
                    #[allow(unreachable_patterns, reason = "all of them can be built in")]
                    _ => Err(Status::NotBuilt),
                }
            }

            pub(crate) fn start(&self, hertz: Option<u16>, reset: bool) -> Script {
                match self {
                    $(
                        #[cfg(feature = $feature)]
                        Self::$name(_) => {
                            let ($hertz, $reset) = (hertz, reset);
                            $start
                        }
                    )*
                }
            }
        }

        impl Decoder for Device {
            fn feed(&mut self, bytes: &[u8], arrival: Micros, sink: &mut dyn FnMut(Event)) {
                match self {
                    $(
                        #[cfg(feature = $feature)]
                        Self::$name(decoder) => feed(decoder, bytes, arrival, sink),
                    )*
                }
            }

            fn counts(&self) -> &Counts {
                match self {
                    $(#[cfg(feature = $feature)] Self::$name(decoder) => decoder.counts(),)*
                }
            }

            fn reset(&mut self) {
                match self {
                    $(#[cfg(feature = $feature)] Self::$name(decoder) => decoder.reset(),)*
                }
            }

            fn on_sent(&mut self, command: &[u8], now: Micros) {
                match self {
                    $(#[cfg(feature = $feature)] Self::$name(own) => own.on_sent(command, now),)*
                }
            }
        }
    };
}

devices! {
    "link" Link(link::Link) = link::Link::new(), |hertz, _| link::start(hertz);
    "fastrak" Fastrak(fastrak::Fastrak) = fastrak::Fastrak::new(fastrak::Config::default()),
    |_, reset| fastrak::Config::default().start(reset);
    "liberty" Liberty(liberty::Liberty) = liberty::Liberty::new(liberty::Config::default()),
    |_, reset| liberty::Config::default().start(reset);
    "flock" Flock(flock::Flock) = flock::Flock::new(flock::Config::default()),
    |_, reset| flock::Config::default().start(1, 1, reset);
    "hatire" Hatire(hatire::Hatire) = hatire::Hatire::new(hatire::Config::default()),
    |_, reset| hatire::start(reset);
    "iscan" Iscan(iscan::Iscan) = iscan::Iscan::new(iscan::Config::default()),
    |_, _| iscan::start();
    "asl" Asl(asl::Asl) = asl::Asl::new(asl::Config::default()), |_, _| asl::start();
    "adhawk" Adhawk(adhawk::AdHawk) = adhawk::AdHawk::new(),
    |hertz, _| adhawk::start(
        adhawk::USUAL_FIELDS,
        hertz.unwrap_or(adhawk::USUAL_HERTZ).into(),
    );
}

// Not a part of its caller, who would keep the room of each decoder.
#[inline(never)]
fn feed(decoder: &mut impl Decoder, bytes: &[u8], arrival: Micros, sink: &mut dyn FnMut(Event)) {
    decoder.feed(bytes, arrival, sink);
}
