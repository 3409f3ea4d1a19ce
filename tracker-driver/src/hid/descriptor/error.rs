//! What is wrong with a report descriptor.

use super::{
    MOST_BYTES, MOST_COLLECTIONS, MOST_ELEMENT_BITS, MOST_PUSHED, MOST_REPORT_BITS, MOST_REPORTS,
    MOST_USAGES,
};

/// Why a descriptor was refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[error("HID report descriptor, byte {offset}: {problem}")]
pub struct DescriptorError {
    /// Where: the offset of the item, in bytes.
    pub offset: usize,
    /// What is wrong there.
    pub problem: Problem,
}

/// What can be wrong with a descriptor.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Problem {
    /// It has more than [`MOST_BYTES`] bytes.
    #[error("{found} bytes, where {MOST_BYTES} are the most")]
    TooLong {
        /// How many it has.
        found: usize,
    },
    /// Its last item is cut off.
    #[error("the last item is cut off")]
    Truncated,
    /// An item of a kind that the specification reserves.
    #[error("an item {prefix:#04x} is not known")]
    UnknownItem {
        /// Its first byte.
        prefix: u8,
    },
    /// More than [`MOST_COLLECTIONS`] collections in one another.
    #[error("more than {MOST_COLLECTIONS} collections in one another")]
    CollectionsTooDeep,
    /// A collection ends that was not begun.
    #[error("a collection ends that was not begun")]
    CollectionNotBegun,
    /// This many collections do not end.
    #[error("{open} collections do not end")]
    CollectionNotEnded {
        /// How many.
        open: usize,
    },
    /// More than [`MOST_PUSHED`] states are pushed.
    #[error("more than {MOST_PUSHED} pushes")]
    PushedTooMuch,
    /// A state is popped that was not pushed.
    #[error("a pop without a push")]
    NothingPushed,
    /// More than [`MOST_USAGES`] usages before one main item.
    #[error("more than {MOST_USAGES} usages before one main item")]
    TooManyUsages,
    /// A range of usages without its beginning or its end, or upside down.
    #[error("a range of usages without both its ends in order")]
    UsageRange,
    /// More than [`MOST_REPORTS`] reports.
    #[error("more than {MOST_REPORTS} reports")]
    TooManyReports,
    /// A report id of 0 or above 255.
    #[error("report id {found}, not 1 to 255")]
    ReportId {
        /// The id.
        found: u32,
    },
    /// An element without a report id, in a device that uses them.
    #[error("some elements have a report id and this one has none")]
    ReportIdMissing,
    /// An element of more than [`MOST_ELEMENT_BITS`] bits.
    #[error("an element of {bits} bits, where {MOST_ELEMENT_BITS} are the most")]
    ElementTooLarge {
        /// Its bits.
        bits: u32,
    },
    /// A report of more than [`MOST_REPORT_BITS`] bits.
    #[error("a report of {bits} bits, where {MOST_REPORT_BITS} are the most")]
    ReportTooLarge {
        /// Its bits.
        bits: u64,
    },
    /// A logical minimum above its maximum.
    #[error("a logical minimum of {minimum} above the maximum, {maximum}")]
    LogicalRange {
        /// The minimum.
        minimum: i32,
        /// The maximum.
        maximum: i32,
    },
}
