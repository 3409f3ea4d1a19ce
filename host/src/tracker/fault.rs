//! What is wrong with a `SPEC`, and what to write instead.

use miette::Diagnostic;
use shisen_tracker::command::Script;
use shisen_tracker::estimate::EstimatorConfigError;
use shisen_tracker::head::polhemus::ItemListError;
use shisen_tracker::protocol::{Asked, Protocol};
use std::ops::RangeInclusive;
use thiserror::Error;

/// The options of every tracker that are times, in seconds (`S`).
pub(super) const TIMES: &str = "stuck_after=S|never, head_stuck_after=S|never, hold_after=S, \
                                widen_after=S, head_after=S, full_after=S, head_hold_after=S, \
                                head_widen_after=S, head_full_after=S, longest_blink=S, delay=S";

/// A name that is no protocol's.
#[derive(Debug, Clone, PartialEq, Eq, Error, Diagnostic)]
#[error("there is no protocol {0:?}")]
#[diagnostic(help("give one of {}", Protocol::NAMES.join(", ")))]
pub struct UnknownProtocol(pub String);

/// A `SPEC` that names no tracker.
#[derive(Debug, Clone, PartialEq, Error, Diagnostic)]
#[non_exhaustive]
pub enum SpecError {
    /// It begins with another word than a kind of tracker.
    #[error("{0:?} is not a kind of tracker")]
    #[diagnostic(help(
        "give mock, mock:seed=7&rate=200&as=fastrak, serial:/dev/ttyUSB0?protocol=fastrak, hid:1532:0b00, hid:usage=0012 or replay:FILE"
    ))]
    Kind(String),
    /// A kind of tracker without a port, device or file.
    #[error("{0}: names no port, device or file")]
    #[diagnostic(help(
        "give serial:/dev/ttyUSB0?protocol=fastrak, hid:1532:0b00, hid:/dev/hidraw0 or replay:FILE"
    ))]
    Nothing(&'static str),
    /// An unknown option.
    #[error("{of} has no option {key:?}")]
    #[diagnostic(help("give {allowed}"))]
    Key {
        /// The protocol, or the kind of tracker.
        of: &'static str,
        /// The option.
        key: String,
        /// The options that it has.
        allowed: String,
    },
    /// An option that is given twice.
    #[error("{0:?} is given twice")]
    #[diagnostic(help("give it once"))]
    Twice(String),
    /// A list of items that no device can send.
    #[error("items: {0}")]
    #[diagnostic(help(
        "the items are those of the device's manual, in the order that it is to send"
    ))]
    Items(#[from] ItemListError),
    /// A value that the option cannot have.
    #[error("{key}={found:?} is not possible")]
    #[diagnostic(help("give {allowed}"))]
    Value {
        /// The option.
        key: &'static str,
        /// The value.
        found: String,
        /// The values that it can have.
        allowed: String,
    },
    /// A time that the estimator refuses.
    #[error("{0}")]
    #[diagnostic(help("the times are seconds: {TIMES}"))]
    Times(EstimatorConfigError),
    /// A choice of a sensor where the tracker has only one.
    #[error("{of} has one sensor, so head={head} cannot choose one")]
    #[diagnostic(help(
        "leave head out; those with several are link, fastrak, liberty and flock, and recordings"
    ))]
    OneSensor {
        /// The protocol, or the kind of tracker.
        of: &'static str,
        /// The sensor.
        head: u8,
    },
    /// A choice of a sensor that the mock does not have.
    #[error(
        "the mock's sensors are {} to {}, so head={head} does not exist",
        sensors.start(),
        sensors.end()
    )]
    #[diagnostic(help("choose one of them, or give more birds"))]
    NoSensor {
        /// The sensor.
        head: u8,
        /// The mock's sensors.
        sensors: RangeInclusive<u8>,
    },
    /// A protocol without a reset is to be reset.
    #[error("{0} has no command for a reset: reset=1 does nothing")]
    #[diagnostic(help("leave reset out; those with one are {}", names(has_reset)))]
    NoReset(&'static str),
    /// A protocol that cannot change the line's speed is to change it.
    #[error("{0} has no command that changes the line's speed: speed does nothing")]
    #[diagnostic(help(
        "leave speed out, and give baud=N as the device is set; that with one is fastrak"
    ))]
    NoSpeed(&'static str),
    /// A reset and a change of speed.
    #[error("a reset undoes a change of speed")]
    #[diagnostic(help("reset the device in a run of its own, and give speed in the next"))]
    ResetAndSpeed,
    /// A protocol that cannot stop its device is to stop it.
    #[error("{0} has no command that stops it: stop=1 does nothing")]
    #[diagnostic(help("leave stop out; those with one are {}", names(has_stop)))]
    NoStop(&'static str),
    /// An unknown protocol.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Protocol(#[from] UnknownProtocol),
    /// A protocol that does not go over a serial line.
    #[error("{0} does not go over a serial line")]
    #[diagnostic(help(
        "plug the device in and give hid:VENDOR:PRODUCT, or one of {}",
        names(Protocol::is_serial)
    ))]
    NotSerial(&'static str),
    /// An unknown protocol for a serial line.
    #[error("there is no protocol {0:?}")]
    #[diagnostic(help("give one of {}", names(Protocol::is_serial)))]
    UnknownOnSerial(String),
    /// A serial port without a protocol.
    #[error("serial:{0} does not name the protocol of its device")]
    #[diagnostic(help(
        "append ?protocol=NAME, NAME being one of {}",
        names(Protocol::is_serial)
    ))]
    NoProtocol(String),
}

/// Whether the devices of a protocol can be told to restart.
pub(super) fn has_reset(protocol: &Protocol) -> bool {
    let asked = Asked::default();
    protocol.start(&asked, true) != protocol.start(&asked, false)
}

/// Whether the devices of a protocol can be told to stop sending.
pub(super) fn has_stop(protocol: &Protocol) -> bool {
    protocol.stop() != Script::new()
}

/// The names of the protocols for which `has` holds.
fn names(has: fn(&Protocol) -> bool) -> String {
    let named = Protocol::NAMES.into_iter();
    let named = named.filter(|name| Protocol::named(name).is_some_and(|protocol| has(&protocol)));
    named.collect::<Vec<_>>().join(", ")
}
