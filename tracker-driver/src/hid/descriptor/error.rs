//! What is wrong with a report descriptor.

use super::{
    MOST_BYTES, MOST_COLLECTIONS, MOST_ELEMENT_BITS, MOST_PUSHED, MOST_REPORT_BITS, MOST_REPORTS,
    MOST_USAGES,
};
use core::fmt;

/// Why a descriptor was refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct DescriptorError {
    /// Where: the offset of the item, in bytes.
    pub offset: usize,
    /// What is wrong there.
    pub problem: Problem,
}

/// What can be wrong with a descriptor.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Problem {
    /// It has more than [`MOST_BYTES`] bytes.
    TooLong {
        /// How many it has.
        found: usize,
    },
    /// Its last item is cut off.
    Truncated,
    /// An item of a kind that the specification reserves.
    UnknownItem {
        /// Its first byte.
        prefix: u8,
    },
    /// More than [`MOST_COLLECTIONS`] collections in one another.
    CollectionsTooDeep,
    /// A collection ends that was not begun.
    CollectionNotBegun,
    /// This many collections do not end.
    CollectionNotEnded {
        /// How many.
        open: usize,
    },
    /// More than [`MOST_PUSHED`] states are pushed.
    PushedTooMuch,
    /// A state is popped that was not pushed.
    NothingPushed,
    /// More than [`MOST_USAGES`] usages before one main item.
    TooManyUsages,
    /// A range of usages without its beginning or its end, or upside down.
    UsageRange,
    /// More than [`MOST_REPORTS`] reports.
    TooManyReports,
    /// A report id of 0 or above 255.
    ReportId {
        /// The id.
        found: u32,
    },
    /// An element without a report id, in a device that uses them.
    ReportIdMissing,
    /// An element of more than [`MOST_ELEMENT_BITS`] bits.
    ElementTooLarge {
        /// Its bits.
        bits: u32,
    },
    /// A report of more than [`MOST_REPORT_BITS`] bits.
    ReportTooLarge {
        /// Its bits.
        bits: u64,
    },
    /// A logical minimum above its maximum.
    LogicalRange {
        /// The minimum.
        minimum: i32,
        /// The maximum.
        maximum: i32,
    },
}

impl fmt::Display for DescriptorError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "HID report descriptor, byte {}: ", self.offset)?;
        match self.problem {
            Problem::TooLong { found } => {
                write!(f, "{found} bytes, where {MOST_BYTES} are the most")
            }
            Problem::Truncated => write!(f, "the last item is cut off"),
            Problem::UnknownItem { prefix } => write!(f, "an item {prefix:#04x} is not known"),
            Problem::CollectionsTooDeep => {
                write!(f, "more than {MOST_COLLECTIONS} collections in one another")
            }
            Problem::CollectionNotBegun => write!(f, "a collection ends that was not begun"),
            Problem::CollectionNotEnded { open } => write!(f, "{open} collections do not end"),
            Problem::PushedTooMuch => write!(f, "more than {MOST_PUSHED} pushes"),
            Problem::NothingPushed => write!(f, "a pop without a push"),
            Problem::TooManyUsages => {
                write!(f, "more than {MOST_USAGES} usages before one main item")
            }
            Problem::UsageRange => write!(f, "a range of usages without both its ends in order"),
            Problem::TooManyReports => write!(f, "more than {MOST_REPORTS} reports"),
            Problem::ReportId { found } => write!(f, "report id {found}, not 1 to 255"),
            Problem::ReportIdMissing => {
                write!(f, "some elements have a report id and this one has none")
            }
            Problem::ElementTooLarge { bits } => write!(
                f,
                "an element of {bits} bits, where {MOST_ELEMENT_BITS} are the most"
            ),
            Problem::ReportTooLarge { bits } => write!(
                f,
                "a report of {bits} bits, where {MOST_REPORT_BITS} are the most"
            ),
            Problem::LogicalRange { minimum, maximum } => {
                write!(
                    f,
                    "a logical minimum of {minimum} above the maximum, {maximum}"
                )
            }
        }
    }
}

impl core::error::Error for DescriptorError {}
