//! The protocols of all devices behind one type, for programs that learn at run time
//! which one a device speaks.
//!
//! A [`Protocol`] is how a device is set up, and knows what is said to it; a [`Reader`] is
//! its decoder. A program that knows its device takes the decoder of that module, and has no
//! code of the others.
//!
//! ```
//! use shisen_tracker::decoder::Decoder;
//! use shisen_tracker::protocol::{Asked, Protocol, Reader};
//! use shisen_tracker::time::Micros;
//!
//! let protocol = Protocol::named("hatire").expect("one of the names");
//! assert_eq!(protocol.baud(), 115_200);
//! assert!(protocol.start(&Asked::default(), false).sends_bytes());
//! let mut reader = Reader::new(&protocol).expect("axes that are a rotation");
//! reader.feed(b"noise", Micros(0), &mut |_| {});
//! assert_eq!(reader.counts().bytes, 5);
//! ```

mod reader;

pub use reader::Reader;

use crate::command::Script;
use crate::estimate::Screen;
use crate::eye::{adhawk, asl, iscan};
use crate::head::{fastrak, flock, hatire, liberty};
use crate::hid::eye_tracker;
use crate::link;
use glam::{Vec2, Vec3};

/// Bits per second of the lines whose devices have no usual speed of their own.
const BAUD: u32 = 115_200;

/// A protocol, and how the device that speaks it is set up.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
// One of them at a time, and it stays where it is.
#[allow(clippy::large_enum_variant)]
pub enum Protocol {
    /// Our own link: everything that a sample has.
    Link,
    /// Polhemus FASTRAK, IS-600, IS-900: the head.
    Fastrak(fastrak::Config),
    /// Polhemus Liberty, Patriot: the head.
    Liberty(liberty::Config),
    /// Ascension Flock of Birds: the head.
    Flock(flock::Config),
    /// Hatire: the head.
    Hatire(hatire::Config),
    /// The OSVR HDK's HID reports: how the head is turned.
    OsvrHdk,
    /// ISCAN: one eye, in raw units.
    Iscan(iscan::Config),
    /// ASL EYE-TRAC: one eye, in raw units.
    Asl(asl::Config),
    /// `AdHawk`: both eyes, and how the head is turned.
    AdHawk,
    /// A HID eye tracker of the [documented](eye_tracker::documented) layout: the head and a point on
    /// this screen, in coordinates that these axes take to the tracker's.
    EyeTracker(Screen, eye_tracker::Axes),
}

/// Requests to a device beside its protocol's settings.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Asked {
    /// Samples per second, where the protocol can ask for them; `None`: as usual.
    pub rate: Option<u16>,
    /// The address of the first of a Flock's birds, from 1.
    pub first_bird: u8,
    /// How many birds there are.
    pub birds: u8,
}

impl Default for Asked {
    /// Returns the usual rate, and one bird.
    fn default() -> Self {
        Self {
            rate: None,
            first_bird: 1,
            birds: 1,
        }
    }
}

impl Protocol {
    /// The names that [`named`](Self::named) takes.
    pub const NAMES: [&'static str; 10] = [
        "link", "fastrak", "liberty", "flock", "hatire", "osvr-hdk", "iscan", "asl", "adhawk",
        "hid",
    ];

    /// Returns a device by its name, set up as is usual: positions and quaternions,
    /// binary, timestamps where there are any; a screen of 2 m × 1 m, 1 m
    /// ahead of the origin. `None` for other names.
    pub fn named(name: &str) -> Option<Self> {
        Some(match name {
            "link" => Self::Link,
            "fastrak" => Self::Fastrak(fastrak::Config::default()),
            "liberty" => Self::Liberty(liberty::Config::default()),
            "flock" => Self::Flock(flock::Config::default()),
            "hatire" => Self::Hatire(hatire::Config::default()),
            "osvr-hdk" => Self::OsvrHdk,
            "iscan" => Self::Iscan(iscan::Config::default()),
            "asl" => Self::Asl(asl::Config::default()),
            "adhawk" => Self::AdHawk,
            "hid" => Self::EyeTracker(
                Screen {
                    corner: Vec3::new(-1.0, 0.5, -1.0),
                    right: Vec3::X,
                    down: Vec3::NEG_Y,
                    size: Vec2::new(2.0, 1.0),
                },
                eye_tracker::Axes::default(),
            ),
            _ => return None,
        })
    }

    /// Returns the name that it has in [`NAMES`](Self::NAMES).
    pub const fn name(&self) -> &'static str {
        match self {
            Self::Link => "link",
            Self::Fastrak(_) => "fastrak",
            Self::Liberty(_) => "liberty",
            Self::Flock(_) => "flock",
            Self::Hatire(_) => "hatire",
            Self::OsvrHdk => "osvr-hdk",
            Self::Iscan(_) => "iscan",
            Self::Asl(_) => "asl",
            Self::AdHawk => "adhawk",
            Self::EyeTracker(..) => "hid",
        }
    }

    /// Returns whether it goes over a serial line; the others are HID reports.
    pub const fn is_serial(&self) -> bool {
        !matches!(self, Self::OsvrHdk | Self::EyeTracker(..))
    }

    /// Returns whether its devices can have several sensors, one of them the viewer's head.
    pub const fn has_sensors(&self) -> bool {
        matches!(
            self,
            Self::Link | Self::Fastrak(_) | Self::Liberty(_) | Self::Flock(_)
        )
    }

    /// Returns whether its devices measure the head.
    pub const fn has_head(&self) -> bool {
        !matches!(self, Self::Iscan(_) | Self::Asl(_))
    }

    /// Returns whether its devices measure the eyes.
    pub const fn has_eyes(&self) -> bool {
        matches!(
            self,
            Self::Link | Self::Iscan(_) | Self::Asl(_) | Self::AdHawk | Self::EyeTracker(..)
        )
    }

    /// Returns the script that makes its device send, after a reset if `reset`; it may be empty.
    pub fn start(&self, asked: &Asked, reset: bool) -> Script {
        match self {
            Self::Link => link::start(asked.rate),
            Self::Fastrak(config) => config.start(reset),
            Self::Liberty(config) => config.start(reset),
            Self::Flock(config) => config.start(asked.first_bird, asked.birds, reset),
            Self::Hatire(_) => hatire::start(reset),
            Self::Iscan(_) => iscan::start(),
            Self::Asl(_) => asl::start(),
            Self::AdHawk => {
                let hertz = asked.rate.unwrap_or(adhawk::USUAL_HERTZ);
                adhawk::start(adhawk::USUAL_FIELDS, hertz.into())
            }
            Self::OsvrHdk | Self::EyeTracker(..) => Script::new(),
        }
    }

    /// Returns the script that makes its device stop; empty if no command does.
    pub fn stop(&self) -> Script {
        match self {
            Self::Link => link::stop(),
            Self::Fastrak(_) => fastrak::stop(),
            Self::Liberty(_) => liberty::stop(),
            Self::Flock(_) => flock::stop(),
            Self::Hatire(_) => hatire::stop(),
            Self::Iscan(_) => iscan::stop(),
            Self::AdHawk => adhawk::stop(),
            Self::Asl(_) | Self::OsvrHdk | Self::EyeTracker(..) => Script::new(),
        }
    }

    /// Returns the script that changes the line's speed, bits per second; `None` if no command does.
    pub fn change_speed(&self, baud: u32) -> Option<Script> {
        match self {
            Self::Fastrak(_) => fastrak::change_speed(baud),
            _ => None,
        }
    }

    /// Returns the line's default speed: bits per second.
    pub const fn baud(&self) -> u32 {
        match self {
            Self::Asl(_) => asl::BAUD,
            Self::Flock(_) => flock::BAUD,
            Self::Hatire(_) => hatire::BAUD,
            Self::Iscan(_) => iscan::BAUD,
            _ => BAUD,
        }
    }

    /// Returns the level that the line's RTS needs; a Flock is in reset while it is high.
    pub const fn rts(&self) -> Option<bool> {
        match self {
            Self::Flock(_) => Some(false),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_name_is_that_of_what_it_names() {
        for name in Protocol::NAMES {
            assert_eq!(Protocol::named(name).unwrap().name(), name);
        }
        assert_eq!(Protocol::named("vrpn"), None);
    }
}
