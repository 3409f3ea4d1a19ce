//! What is wrong with a `SPEC`, and what can stand there.

use crate::tracker::protocol::{ProtocolSpec, UnknownProtocol};
use miette::Diagnostic;
use shisen_tracker::estimate::EstimatorConfigError;
use shisen_tracker::head::polhemus::ItemListError;
use shisen_tracker::protocol::Protocol;
use std::ops::RangeInclusive;
use thiserror::Error;

/// A `SPEC` that names no tracker.
#[derive(Debug, Clone, PartialEq, Error, Diagnostic)]
#[non_exhaustive]
pub enum SpecError {
    /// Another word in front.
    #[error("{found:?} is no kind of tracker")]
    #[diagnostic(help(
        "give mock, mock:seed=7&rate=200&as=fastrak, serial:/dev/ttyUSB0?protocol=fastrak, hid:1532:0b00, hid:usage=0012 or replay:FILE"
    ))]
    Kind {
        /// What stands there.
        found: String,
    },
    /// Nothing after the word.
    #[error("{kind}: says not which")]
    #[diagnostic(help(
        "give serial:/dev/ttyUSB0?protocol=fastrak, hid:1532:0b00, hid:/dev/hidraw0 or replay:FILE"
    ))]
    Nothing {
        /// The word.
        kind: &'static str,
    },
    /// An option that there is not.
    #[error("{of} has no option {key:?}")]
    #[diagnostic(help("give {allowed}"))]
    Key {
        /// The protocol, or the kind of tracker.
        of: &'static str,
        /// The option.
        key: String,
        /// Those that there are.
        allowed: String,
    },
    /// An option that is given twice.
    #[error("{key:?} is given twice")]
    #[diagnostic(help("give it once"))]
    Twice {
        /// The option.
        key: String,
    },
    /// A list of items that no device can send.
    #[error("items: {0}")]
    #[diagnostic(help(
        "the items are those of the device's manual, in the order that it is to send"
    ))]
    Items(#[from] ItemListError),
    /// An option's value that it cannot have.
    #[error("{key}={found:?} is not possible")]
    #[diagnostic(help("give {allowed}"))]
    Value {
        /// The option.
        key: &'static str,
        /// Its value.
        found: String,
        /// Those that it can have.
        allowed: &'static str,
    },
    /// A time of the estimator's that it refuses.
    #[error("{0}")]
    #[diagnostic(help("the times are seconds: {}", crate::tracker::times::ALLOWED))]
    Times(EstimatorConfigError),
    /// A sensor is chosen where there is one.
    #[error("{of} has one sensor: head={head} chooses none")]
    #[diagnostic(help(
        "leave head out; those with several are link, fastrak, liberty and flock, and recordings"
    ))]
    OneSensor {
        /// The protocol, or the kind of tracker.
        of: &'static str,
        /// The sensor.
        head: u8,
    },
    /// A sensor is chosen that the mock does not have.
    #[error(
        "the mock's sensors are {} to {}: head={head} chooses none",
        sensors.start(),
        sensors.end()
    )]
    #[diagnostic(help("choose one of them, or give more birds"))]
    NoSensor {
        /// The sensor.
        head: u8,
        /// Those that there are.
        sensors: RangeInclusive<u8>,
    },
    /// A reset is asked for where there is none.
    #[error("{of} has no command for a reset: reset=1 does nothing")]
    #[diagnostic(help(
        "leave reset out; those with one are {}",
        names(ProtocolSpec::has_reset)
    ))]
    NoReset {
        /// The protocol.
        of: &'static str,
    },
    /// A change of speed is asked for where there is none.
    #[error("{of} has no command that changes the line's speed: speed does nothing")]
    #[diagnostic(help(
        "leave speed out, and give baud=N as the device is set; that with one is fastrak"
    ))]
    NoSpeed {
        /// The protocol.
        of: &'static str,
    },
    /// A reset and a change of speed.
    #[error("a reset undoes a change of speed")]
    #[diagnostic(help("reset the device in a run of its own, and give speed in the next"))]
    ResetAndSpeed,
    /// A stop is asked for where there is none.
    #[error("{of} has no command that stops it: stop=1 does nothing")]
    #[diagnostic(help("leave stop out; those with one are {}", names(ProtocolSpec::has_stop)))]
    NoStop {
        /// The protocol.
        of: &'static str,
    },
    /// A protocol that there is not.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Protocol(#[from] UnknownProtocol),
    /// A protocol that goes over no serial line.
    #[error("{name} does not go over a serial line")]
    #[diagnostic(help(
        "plug the device in and give hid:VENDOR:PRODUCT, or one of {}",
        names(|spec| spec.protocol().is_serial())
    ))]
    NotSerial {
        /// The protocol.
        name: &'static str,
    },
    /// A protocol of a serial line that there is not.
    #[error("there is no protocol {name:?}")]
    #[diagnostic(help("give one of {}", names(|spec| spec.protocol().is_serial())))]
    UnknownOnSerial {
        /// What was given.
        name: String,
    },
    /// A serial port without a protocol.
    #[error("serial:{path} says not which protocol its device speaks")]
    #[diagnostic(help(
        "append ?protocol=NAME, NAME being one of {}",
        names(|spec| spec.protocol().is_serial())
    ))]
    NoProtocol {
        /// The port.
        path: String,
    },
}

fn names(of: fn(&ProtocolSpec) -> bool) -> String {
    let named = Protocol::NAMES
        .into_iter()
        .filter(|name| ProtocolSpec::named(name).is_ok_and(|protocol| of(&protocol)));
    named.collect::<Vec<_>>().join(", ")
}
