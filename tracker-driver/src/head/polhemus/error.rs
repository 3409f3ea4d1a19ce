//! Item lists that cannot be sent to a device.

use super::{Format, MOST_ITEMS, MOST_RECORD_BYTES};

/// Why a list of items was refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum ItemListError {
    /// The device has no such item, or none that is described.
    #[error(
        "item {number} is not one whose form is known: FASTRAK and IS-900 have 0, 1, 2, 4 to 7, \
         11, 16, 18 to 23, 50 to 52, 54 to 57, 61 and 66, Liberty and Patriot 0, 2, 7, 8 and 10"
    )]
    Unknown {
        /// The item.
        number: u8,
    },
    /// The item does not exist in the list's format.
    #[error(
        "item {number} {}",
        match .format {
            Format::Ascii => "is known in binary form only: take binary records, or leave it out",
            Format::Binary => "does not exist in binary form",
        }
    )]
    Format {
        /// The item.
        number: u8,
        /// The list's format.
        format: Format,
    },
    /// Two items say the same.
    #[error("item {number} says what an item before it has said: name it once")]
    Repeated {
        /// The second.
        number: u8,
    },
    /// More than [`MOST_ITEMS`].
    #[error("a list of {items} items: at most {MOST_ITEMS} are taken")]
    TooMany {
        /// The number of items.
        items: usize,
    },
    /// A record of more than [`MOST_RECORD_BYTES`].
    #[error("a record of {bytes} bytes: devices send at most {MOST_RECORD_BYTES}; leave items out")]
    TooLong {
        /// Its bytes.
        bytes: usize,
    },
    /// Neither a position nor a whole orientation.
    #[error(
        "a list without position or orientation: name item 2, and 4, 11, or 5, 6 and 7 together \
         (Liberty: 2 and 7)"
    )]
    NoPose,
    /// The last item is neither a space nor a line's end.
    #[error(
        "the last item is no end to know the record by: add item 0, a space, or item 1, a line's \
         end"
    )]
    NoEnd,
    /// Items 18 to 20 among others.
    #[error("items 18 to 20, the 16-bit forms, come without any other item")]
    Mixed,
}
