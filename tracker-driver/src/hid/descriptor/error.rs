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
    /// The offset of the item that is wrong, in bytes.
    pub(super) offset: usize,
    pub(super) problem: Problem,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub(super) enum Problem {
    #[error("{found} bytes, where {MOST_BYTES} are the most")]
    TooLong { found: usize },
    #[error("the last item is cut off")]
    Truncated,
    #[error("an item {prefix:#04x} is not known")]
    UnknownItem { prefix: u8 },
    #[error("more than {MOST_COLLECTIONS} collections in one another")]
    CollectionsTooDeep,
    #[error("a collection ends that was not begun")]
    CollectionNotBegun,
    #[error("{open} collections do not end")]
    CollectionNotEnded { open: usize },
    #[error("more than {MOST_PUSHED} pushes")]
    PushedTooMuch,
    #[error("a pop without a push")]
    NothingPushed,
    #[error("more than {MOST_USAGES} usages before one main item")]
    TooManyUsages,
    #[error("a range of usages without both its ends in order")]
    UsageRange,
    #[error("more than {MOST_REPORTS} reports")]
    TooManyReports,
    #[error("report id {found}, not 1 to 255")]
    ReportId { found: u32 },
    #[error("some elements have a report id and this one has none")]
    ReportIdMissing,
    #[error("an element of {bits} bits, where {MOST_ELEMENT_BITS} are the most")]
    ElementTooLarge { bits: u32 },
    #[error("a report of {bits} bits, where {MOST_REPORT_BITS} are the most")]
    ReportTooLarge { bits: u64 },
    #[error("a logical minimum of {minimum} above the maximum, {maximum}")]
    LogicalRange { minimum: i32, maximum: i32 },
}
