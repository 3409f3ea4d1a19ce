//! The lists of items that Polhemus' trackers put into their records, and how
//! each item is written.
//!
//! A record has no length and no names in it: only who knows the list that
//! the device was told can read it. So a decoder is made from an [`ItemList`],
//! and [`ItemList::command`] is what tells the device.

mod error;
mod item;
mod numbers;
mod values;

pub use error::ItemListError;
pub(crate) use numbers::{from_seven_bits, nearest_word, push_number, to_seven_bits};

use super::axes::{self, Axes};
use crate::decoder::{DropReason, Event, Message};
use crate::sample::{Head, Sample};
use crate::stream::{Step, Window};
use crate::time::DeviceTime;
use glam::{Quat, Vec3};
use heapless::Vec;
use item::{Content, Form, Item};
pub(crate) use item::{WORD_DEGREES, WORD_METRES};
use numbers::{word_bytes, write_extended, write_fixed, write_whole};
use values::Values;

/// Most items of a list: each thing that is measured, once, and room to spare.
pub const MOST_ITEMS: usize = 12;

/// Most bytes of a record, as FASTRAK's manual has it.
pub const MOST_RECORD_BYTES: usize = 254;

/// The bytes of a record.
pub type Record = Vec<u8, MOST_RECORD_BYTES>;

/// The head and the device's time that a record says.
type Read = (Head, Option<DeviceTime>);

/// How a list's numbers are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Format {
    /// Decimal digits.
    Ascii,
    /// Little-endian f32.
    #[default]
    Binary,
}

/// Units of length.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Units {
    /// Inches: what the devices start with.
    #[default]
    Inches,
    /// Centimetres.
    Centimetres,
}

impl Units {
    /// Returns metres that one of them has.
    pub const fn metres(self) -> f32 {
        match self {
            Self::Inches => 0.0254,
            Self::Centimetres => 0.01,
        }
    }
}

/// Whose numbers a list is made of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Family {
    /// [`fastrak`](super::fastrak), with the items that `InterSense` added.
    Fastrak,
    /// [`liberty`](super::liberty).
    Liberty,
}

/// A list of items that a device can send and a decoder can read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ItemList {
    items: Vec<Item, MOST_ITEMS>,
    format: Format,
    bytes: usize,
}

/// Why bytes cannot be read as a list's items.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum ItemError {
    /// The bytes do not have the items' form: likely no record at all.
    Shape,
    /// A number is one that the device may not send.
    Value(DropReason),
}

impl From<DropReason> for ItemError {
    fn from(reason: DropReason) -> Self {
        Self::Value(reason)
    }
}

/// How to understand the items' numbers.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Scale<'a> {
    pub(crate) units: Units,
    /// Metres that a word's 1 stands for in item 18.
    pub(crate) word_metres: f32,
    /// Degrees that a word's 1 stands for in item 19.
    pub(crate) word_degrees: f32,
    pub(crate) axes: &'a Axes,
}

impl<'a> Scale<'a> {
    /// With the usual words.
    pub(crate) const fn new(units: Units, axes: &'a Axes) -> Self {
        Self {
            units,
            word_metres: WORD_METRES,
            word_degrees: WORD_DEGREES,
            axes,
        }
    }
}

/// What stands before a record's items.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Header {
    /// Its own bytes.
    pub(crate) bytes: usize,
    /// Whose record it is, from 0.
    pub(crate) sensor: u8,
    /// A space, or what is wrong.
    pub(crate) status: u8,
    /// What the manual says about that.
    pub(crate) meaning: &'static str,
}

/// Returns the record behind a header. A fault is said where it is not the `last` of its sensor.
pub(crate) fn record(
    window: Window<'_>,
    header: Header,
    list: &ItemList,
    scale: Scale<'_>,
    last: &mut [u8],
) -> Step {
    let length = header.bytes + list.bytes();
    let Some(items) = window.bytes.get(header.bytes..length) else {
        return Step::More;
    };
    let Header { sensor, status, .. } = header;
    let measured = status == b' ';
    let (head, device_time) = match list.read(items, measured, scale) {
        Ok(read) => read,
        Err(ItemError::Shape) => return window.broken_off(),
        Err(ItemError::Value(reason)) => return window.unusable(length, reason),
    };
    let changed = last
        .get_mut(usize::from(sensor))
        .is_some_and(|last| core::mem::replace(last, status) != status);
    let fault = (changed && !measured).then_some(Message::Fault {
        code: u32::from(status),
        meaning: header.meaning,
    });
    let sample = Sample {
        device_time,
        sensor,
        head,
        ..Sample::arrived(window.arrival)
    };
    Step::Take(length, fault, Event::Sample(sample))
}

impl ItemList {
    /// Returns a list of these items, in this order.
    ///
    /// # Errors
    /// Where an item is unknown or named twice, none says a pose, the record is too long, or the
    /// last is not 0 or 1, which records are found by; items 18 to 20 stand alone, without it.
    pub fn new(family: Family, format: Format, numbers: &[u8]) -> Result<Self, ItemListError> {
        let mut items: Vec<Item, MOST_ITEMS> = Vec::new();
        for &number in numbers {
            let item = Item::new(family, format, number)?;
            let may_repeat = item.content == Content::Other;
            let said = |other: &Item| {
                other.number == number || (!may_repeat && other.content == item.content)
            };
            if !matches!(item.form, Form::Literal(_)) && items.iter().any(said) {
                return Err(ItemListError::Repeated { number });
            }
            items.push(item).map_err(|_| ItemListError::TooMany {
                items: numbers.len(),
            })?;
        }
        let has = |content| items.iter().any(|item| item.content == content);
        let cosines = (0..3).all(|row| has(Content::Cosines(row)));
        if !(has(Content::Position) || has(Content::Euler) || has(Content::Quaternion) || cosines) {
            return Err(ItemListError::NoPose);
        }
        let words = items.iter().filter(|item| item.form == Form::Word).count();
        if words == 0 {
            if !matches!(items.last(), Some(last) if matches!(last.form, Form::Literal(_))) {
                return Err(ItemListError::NoEnd);
            }
        } else if words < items.len() {
            return Err(ItemListError::Mixed);
        }
        let bytes = items.iter().map(|item| item.bytes()).sum();
        // The longest header is Liberty's, of eight bytes.
        if bytes > MOST_RECORD_BYTES - 8 {
            return Err(ItemListError::TooLong { bytes: bytes + 8 });
        }
        Ok(Self {
            items,
            format,
            bytes,
        })
    }

    /// Returns the usual list, in binary: position, quaternion, the time of a Liberty, a space.
    pub fn usual(family: Family) -> Self {
        let numbers: &[u8] = match family {
            Family::Fastrak => &[2, 11, 0],
            Family::Liberty => &[2, 7, 8, 0],
        };
        let format = Format::Binary;
        // Never empty: a test holds both lists to be lists.
        Self::new(family, format, numbers).unwrap_or(Self {
            items: Vec::new(),
            format,
            bytes: 0,
        })
    }

    /// Returns how its numbers are written.
    pub const fn format(&self) -> Format {
        self.format
    }

    /// Returns its items' numbers.
    pub fn numbers(&self) -> impl Iterator<Item = u8> {
        self.items.iter().map(|item| item.number)
    }

    /// Returns bytes of its items, without a record's header.
    pub const fn bytes(&self) -> usize {
        self.bytes
    }

    /// Returns whether it holds a position.
    pub fn has_position(&self) -> bool {
        self.items
            .iter()
            .any(|item| item.content == Content::Position)
    }

    /// Returns whether it holds a rotation, in any form.
    pub fn has_orientation(&self) -> bool {
        let turn = |item: &Item| {
            matches!(
                item.content,
                Content::Euler | Content::Quaternion | Content::Cosines(_)
            )
        };
        self.items.iter().any(turn)
    }

    /// Returns whether a head is tracked in all that the list holds.
    pub(crate) fn is_tracked(&self, head: &Head) -> bool {
        let position = head.position.is_some_and(|position| position.tracked);
        let orientation = head.orientation.is_some_and(|turn| turn.tracked);
        (position || !self.has_position()) && (orientation || !self.has_orientation())
    }

    /// Returns the command that makes a station send it, such as `O1,2,11,0` and a carriage return.
    pub fn command(&self, station: u8) -> crate::command::Bytes {
        let mut command = crate::command::Bytes::new();
        // 46 bytes at most: three a number and its comma.
        let _ = command.push(b'O');
        let _ = push_number(&mut command, station.into());
        for item in &self.items {
            let _ = command.push(b',');
            let _ = push_number(&mut command, item.number.into());
        }
        let _ = command.push(b'\r');
        command
    }

    /// Reads a record's items. `bytes` are [`ItemList::bytes`] long.
    fn read(&self, bytes: &[u8], tracked: bool, scale: Scale) -> Result<Read, ItemError> {
        // All of the form before any of the values: only what has the form
        // is a record.
        let mut values = Values::default();
        let mut rest = bytes;
        for item in &self.items {
            for place in 0..item.values() {
                let (value, after) = rest
                    .split_at_checked(item.value_bytes())
                    .ok_or(ItemError::Shape)?;
                values.put(*item, place, value)?;
                rest = after;
            }
        }
        values.pose(tracked, scale)
    }

    /// Adds a sample's items; what it lacks is no rotation, the origin and time 0.
    pub(crate) fn write(&self, sample: &Sample, scale: Scale, record: &mut Record) {
        let metres = sample.head.position.map_or(Vec3::ZERO, |p| p.value);
        let position = scale.axes.device_position(metres);
        let rotation = sample.head.orientation.map_or(Quat::IDENTITY, |q| q.value);
        let rotation = scale.axes.device_orientation(rotation);
        let columns = axes::columns(rotation);
        let euler = axes::euler_degrees(rotation);
        let microseconds = sample.device_time.map_or(0, |time| time.microseconds);
        for item in &self.items {
            let word = item.form == Form::Word;
            let whole = match item.content {
                Content::Time => microseconds / 1_000,
                _ => 0,
            };
            for place in 0..item.values() {
                let value = match item.content {
                    Content::Position if word => position[place.min(2)] / scale.word_metres,
                    Content::Position => position[place.min(2)] / scale.units.metres(),
                    Content::Euler if word => euler[place.min(2)] / scale.word_degrees,
                    Content::Euler => euler[place.min(2)],
                    Content::Cosines(row) => columns[place.min(2)][usize::from(row.min(2))],
                    Content::Quaternion => {
                        let [x, y, z, w] = rotation.to_array();
                        [w, x, y, z][place.min(3)]
                    }
                    Content::Time => {
                        (microseconds / 1_000) as f32 + (microseconds % 1_000) as f32 / 1_000.0
                    }
                    Content::Other => 0.0,
                };
                // The list's record fits, so nothing is cut off.
                let _ = match item.form {
                    Form::Literal(bytes) => record.extend_from_slice(bytes),
                    Form::Fixed(decimals) => write_fixed(value, decimals, record),
                    Form::Extended => write_extended(value, record),
                    Form::Whole(characters) => write_whole(whole, characters, record),
                    Form::SpaceAndDigit => record.extend_from_slice(b" 0"),
                    Form::Float => record.extend_from_slice(&value.to_le_bytes()),
                    Form::Word => {
                        let first = place == 0 && Some(item) == self.items.first();
                        record.extend_from_slice(&word_bytes(value, first))
                    }
                    Form::U32 => record.extend_from_slice(&(whole as u32).to_le_bytes()),
                    Form::Bytes(count) => {
                        record.extend_from_slice(&[0; 2][..usize::from(count.min(2))])
                    }
                };
            }
        }
    }
}

#[cfg(test)]
mod tests;
