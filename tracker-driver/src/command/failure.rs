//! Failures of a device or its line, and their texts.

use super::{Awaited, MOST_SCRIPT_BYTES, MOST_STEPS};
use crate::decoder::DropReason;
use core::fmt;

/// A failure of a device or its line.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Failure {
    /// No bytes come in.
    #[error(
        "nothing comes in: check that the device is on and the cable is the right one, with its \
         lines crossed or not"
    )]
    Silent,
    /// Bytes come in without a record.
    #[error(
        "{bytes} bytes came in, and no record among them: the line's speed, the protocol or its \
         settings (list of items, outputs, format) are not the device's; try another baud rate, \
         and compare the settings with the device's"
    )]
    NoRecord {
        /// Number of bytes.
        bytes: u64,
    },
    /// Records come in whole, and few or none of them can be used.
    #[error(
        "{records} records came in whole and cannot be used ({}): {}",
        .reason.name(), advice(*.reason)
    )]
    Unusable {
        /// Number of records that cannot be used.
        records: u32,
        /// Why the last of them cannot be used.
        reason: DropReason,
    },
    /// Records came in, and then the line fell silent within one.
    #[error(
        "the line fell silent within a record, {bytes} bytes behind the last whole one: check \
         that the device is still on and its cable holds"
    )]
    BrokenOff {
        /// Bytes behind the last whole record.
        bytes: u64,
    },
    /// Records come in, but much else as well.
    #[error(
        "{dropped} of {bytes} bytes in a second belong to no record: the protocol, its settings \
         (list of items, outputs, format) or the line's speed is not the device's, or the line \
         is disturbed"
    )]
    Unlike {
        /// Bytes of a second that belong to no record.
        dropped: u64,
        /// Bytes of that second.
        bytes: u64,
    },
    /// Records come in, but not the one that was awaited.
    #[error(fmt = write_no_answer)]
    NoAnswer {
        /// Number of records.
        records: u64,
        /// The awaited answer.
        awaited: Awaited,
    },
    /// The device refused a command.
    #[error(fmt = write_refused)]
    Refused {
        /// The command's number in the protocol.
        command: u32,
        /// The device's reason, by its number.
        result: u32,
        /// The manual's meaning of that; empty if the manual has none.
        meaning: &'static str,
    },
    /// The script has more steps or bytes than a session plays.
    #[error("more commands than fit: at most {MOST_STEPS} steps and {MOST_SCRIPT_BYTES} bytes")]
    TooLong,
}

#[allow(clippy::trivially_copy_pass_by_ref, reason = "thiserror calls it so")]
fn write_no_answer(records: &u64, awaited: &Awaited, f: &mut fmt::Formatter<'_>) -> fmt::Result {
    match awaited {
        Awaited::Sample | Awaited::Record => write!(
            f,
            "{records} records came in, but none of a sensor: check the list of items and which \
             sensors are plugged in"
        ),
        Awaited::Reply(command) => write!(
            f,
            "{records} records came in, but no answer to command {}: commands do not reach the \
             device, or it takes none; check the cable's line to the device",
            Named(*command)
        ),
    }
}

#[allow(clippy::trivially_copy_pass_by_ref, reason = "thiserror calls it so")]
fn write_refused(
    command: &u32,
    result: &u32,
    meaning: &str,
    f: &mut fmt::Formatter<'_>,
) -> fmt::Result {
    write!(f, "the device refused command {}", Named(*command))?;
    if meaning.is_empty() {
        return write!(f, " with code {result}");
    }
    write!(f, ": {meaning} (code {result})")
}

/// A command's name: its letter, or its number.
struct Named(u32);

impl fmt::Display for Named {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match u8::try_from(self.0) {
            Ok(letter) if letter.is_ascii_graphic() => write!(f, "'{}'", letter as char),
            _ => write!(f, "{:#x}", self.0),
        }
    }
}

/// Returns advice about records that cannot be used.
const fn advice(reason: DropReason) -> &'static str {
    match reason {
        DropReason::NotUnit => {
            "check that sensor and transmitter are plugged in, and that the list or format is the \
             device's"
        }
        DropReason::OutOfRange => {
            "check the list of items, the order of bytes and which sensors are plugged in"
        }
        DropReason::Duplicate => "the device repeats itself: switch it off and on",
        DropReason::Unknown => "the device is of another version, or says something else",
        _ => "check that its settings, or its description, are the device's",
    }
}
