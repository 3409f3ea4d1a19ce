//! Lists that no device can be told.

use super::{Format, MOST_ITEMS, MOST_RECORD_BYTES};
use core::fmt;

/// Why a list of items was refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum ItemListError {
    /// The device has no such item, or none that is described.
    Unknown {
        /// The item.
        number: u8,
    },
    /// The item does not exist in the list's format.
    Format {
        /// The item.
        number: u8,
        /// The list's format.
        format: Format,
    },
    /// Two items say the same.
    Repeated {
        /// The second.
        number: u8,
    },
    /// More than [`MOST_ITEMS`].
    TooMany {
        /// How many.
        items: usize,
    },
    /// A record of more than [`MOST_RECORD_BYTES`].
    TooLong {
        /// Its bytes.
        bytes: usize,
    },
    /// Neither a position nor a whole orientation.
    NoPose,
    /// The last item is neither a space nor a line's end.
    NoEnd,
    /// Items 18 to 20 among others.
    Mixed,
}

impl fmt::Display for ItemListError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Unknown { number } => write!(
                f,
                "item {number} is not one whose form is known: FASTRAK and IS-900 have 0, 1, 2, \
                 4 to 7, 11, 16, 18 to 23, 50 to 52, 54 to 57, 61 and 66, Liberty and Patriot 0, \
                 2, 7, 8 and 10"
            ),
            Self::Format {
                number,
                format: Format::Ascii,
            } => write!(
                f,
                "item {number} is known in binary form only: take binary records, or leave it out"
            ),
            Self::Format { number, .. } => {
                write!(f, "item {number} does not exist in binary form")
            }
            Self::Repeated { number } => write!(
                f,
                "item {number} says what an item before it has said: name it once"
            ),
            Self::TooMany { items } => {
                write!(f, "a list of {items} items: at most {MOST_ITEMS} are taken")
            }
            Self::TooLong { bytes } => write!(
                f,
                "a record of {bytes} bytes: devices send at most {MOST_RECORD_BYTES}; leave \
                 items out"
            ),
            Self::NoPose => write!(
                f,
                "a list without position or orientation: name item 2, and 4, 11, or 5, 6 and 7 \
                 together (Liberty: 2 and 7)"
            ),
            Self::NoEnd => write!(
                f,
                "the last item is no end to know the record by: add item 0, a space, or item 1, \
                 a line's end"
            ),
            Self::Mixed => write!(
                f,
                "items 18 to 20, the 16-bit forms, come without any other item"
            ),
        }
    }
}

impl core::error::Error for ItemListError {}
