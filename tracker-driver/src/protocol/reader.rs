//! The decoder of a protocol chosen at run time.

use super::Protocol;
use crate::decoder::{Counts, Decoder, Event};
use crate::eye::{adhawk::AdHawk, asl::Asl, iscan::Iscan};
use crate::head::fastrak::Fastrak;
use crate::head::flock::Flock;
use crate::head::hatire::Hatire;
use crate::head::liberty::Liberty;
use crate::head::osvr_hdk::OsvrHdk;
use crate::hid::eye_tracker::{EyeTracker, documented};
use crate::link::Link;
use crate::time::Micros;

/// The decoder of any [`Protocol`].
#[derive(Debug, Clone)]
pub struct Reader(Kind);

#[derive(Debug, Clone)]
// Large variants are fine: a program has one decoder, which it never moves.
#[allow(clippy::large_enum_variant)]
enum Kind {
    Link(Link),
    Fastrak(Fastrak),
    Liberty(Liberty),
    Flock(Flock),
    Hatire(Hatire),
    OsvrHdk(OsvrHdk),
    Iscan(Iscan),
    Asl(Asl),
    AdHawk(AdHawk),
    EyeTracker(EyeTracker),
}

impl Reader {
    /// Returns a decoder for a device with these settings; for a HID eye tracker,
    /// one for the [`documented`] descriptor. `None` if its axes are not valid.
    pub fn new(protocol: &Protocol) -> Option<Self> {
        Some(Self(match protocol.clone() {
            Protocol::Link => Kind::Link(Link::new()),
            Protocol::Fastrak(config) => Kind::Fastrak(Fastrak::new(config)),
            Protocol::Liberty(config) => Kind::Liberty(Liberty::new(config)),
            Protocol::Flock(config) => Kind::Flock(Flock::new(config)),
            Protocol::Hatire(config) => Kind::Hatire(Hatire::new(config)),
            Protocol::OsvrHdk => Kind::OsvrHdk(OsvrHdk::new()),
            Protocol::Iscan(config) => Kind::Iscan(Iscan::new(config)),
            Protocol::Asl(config) => Kind::Asl(Asl::new(config)),
            Protocol::AdHawk => Kind::AdHawk(AdHawk::new()),
            Protocol::EyeTracker(_, axes) => {
                Kind::EyeTracker(EyeTracker::new(&documented::DESCRIPTOR, axes).ok()?)
            }
        }))
    }
}

/// Calls a method of the decoder that `self` holds.
macro_rules! whichever {
    ($reader:expr, $decoder:ident => $call:expr) => {
        match $reader {
            Kind::Link($decoder) => $call,
            Kind::Fastrak($decoder) => $call,
            Kind::Liberty($decoder) => $call,
            Kind::Flock($decoder) => $call,
            Kind::Hatire($decoder) => $call,
            Kind::OsvrHdk($decoder) => $call,
            Kind::Iscan($decoder) => $call,
            Kind::Asl($decoder) => $call,
            Kind::AdHawk($decoder) => $call,
            Kind::EyeTracker($decoder) => $call,
        }
    };
}

impl Decoder for Reader {
    fn feed(&mut self, bytes: &[u8], arrival: Micros, sink: &mut dyn FnMut(Event)) {
        whichever!(&mut self.0, decoder => decoder.feed(bytes, arrival, sink));
    }

    fn counts(&self) -> &Counts {
        whichever!(&self.0, decoder => decoder.counts())
    }

    fn reset(&mut self) {
        whichever!(&mut self.0, decoder => decoder.reset());
    }

    fn on_sent(&mut self, command: &[u8], now: Micros) {
        whichever!(&mut self.0, decoder => decoder.on_sent(command, now));
    }

    fn fields_seen(&self) -> Option<usize> {
        whichever!(&self.0, decoder => decoder.fields_seen())
    }
}
