//! The lists of items that Polhemus' trackers put into their records, and how
//! each item is written.
//!
//! A record has no length and no names in it: only who knows the list that
//! the device was told can read it. So a decoder is made from an [`ItemList`],
//! and [`ItemList::command`] is what tells the device.

use super::axes::{self, Axes};
use crate::decoder::DropReason;
use crate::sample::{Head, Reading};
use crate::time::DeviceTime;
use core::fmt;
use glam::{Quat, Vec3};
use heapless::Vec;

/// Most items of a list. A FASTRAK takes 32; 12 hold each thing it measures
/// once, with room to spare.
pub const MOST_ITEMS: usize = 12;

/// Most bytes of a record, as FASTRAK's manual has it.
pub const MOST_RECORD_BYTES: usize = 254;

/// How a list's numbers are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Format {
    /// Decimal digits.
    Ascii,
    /// Little-endian f32.
    #[default]
    Binary,
}

/// Units of length.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Units {
    /// Inches: what the devices start with.
    #[default]
    Inches,
    /// Centimetres.
    Centimetres,
}

impl Units {
    /// Metres that one of them has.
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

/// What an item says.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Content {
    Space,
    NewLine,
    Position,
    Euler,
    /// Row 0, 1 or 2 of the matrix whose columns are the sensor's axes.
    Cosines(u8),
    Quaternion,
    /// Milliseconds.
    Time,
    /// Stylus, buttons or joystick: checked for its form and left out.
    Switch,
}

/// How an item's numbers are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Form {
    /// These bytes.
    Literal(&'static [u8]),
    /// `Sxxx.xx` or `Sx.xxxx`: seven characters with so many decimals.
    Fixed(u8),
    /// `Sx.xxxxxESxxb`: thirteen characters.
    Extended,
    /// A whole number, right-aligned among so many characters.
    Whole(u8),
    /// A space and `0` or `1`.
    SpaceAndDigit,
    /// Little-endian f32.
    Float,
    /// 14 bits, low seven first, for −1 to 1 of the item's full scale.
    Word,
    /// Little-endian u32.
    U32,
    /// So many bytes of any value.
    Bytes(u8),
}

/// Metres that are 1 in item 18.
const WORD_METRES: f32 = 3.0;
/// Degrees that are 1 in item 19.
const WORD_DEGREES: f32 = 180.0;
/// Steps from 0 to 1 in the 14-bit form, two bits short of 16.
const WORD_ONE: f32 = 32_768.0;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Item {
    number: u8,
    content: Content,
    form: Form,
}

impl Item {
    /// The item of this number, or whether the format is what keeps it out.
    fn new(family: Family, format: Format, number: u8) -> Result<Self, ItemListError> {
        let (content, form) = match family {
            Family::Fastrak => Self::of_fastrak(format, number)?,
            Family::Liberty => Self::of_liberty(format, number)?,
        };
        Ok(Self {
            number,
            content,
            form,
        })
    }

    fn of_fastrak(format: Format, number: u8) -> Result<(Content, Form), ItemListError> {
        let other_format = ItemListError::Format { number, format };
        let float = |decimals: Form| match format {
            Format::Ascii => decimals,
            Format::Binary => Form::Float,
        };
        let word = |content| match format {
            Format::Ascii => Err(other_format),
            Format::Binary => Ok((content, Form::Word)),
        };
        Ok(match number {
            0 | 50 => (Content::Space, Form::Literal(b" ")),
            1 | 51 => (Content::NewLine, Form::Literal(b"\r\n")),
            2 => (Content::Position, float(Form::Fixed(2))),
            52 => (Content::Position, float(Form::Extended)),
            4 => (Content::Euler, float(Form::Fixed(2))),
            54 => (Content::Euler, float(Form::Extended)),
            5..=7 => (Content::Cosines(number - 5), float(Form::Fixed(4))),
            55..=57 => (Content::Cosines(number - 55), float(Form::Extended)),
            11 => (Content::Quaternion, float(Form::Fixed(4))),
            61 => (Content::Quaternion, float(Form::Extended)),
            16 | 66 => (Content::Switch, Form::SpaceAndDigit),
            18 => word(Content::Position)?,
            19 => word(Content::Euler)?,
            20 => word(Content::Quaternion)?,
            21 => (Content::Time, float(Form::Whole(14))),
            22 => match format {
                Format::Ascii => (Content::Switch, Form::Whole(3)),
                Format::Binary => (Content::Switch, Form::Bytes(1)),
            },
            23 => match format {
                Format::Ascii => return Err(other_format),
                Format::Binary => (Content::Switch, Form::Bytes(2)),
            },
            _ => return Err(ItemListError::Unknown { number }),
        })
    }

    fn of_liberty(format: Format, number: u8) -> Result<(Content, Form), ItemListError> {
        if format == Format::Ascii {
            return Err(ItemListError::Format { number, format });
        }
        Ok(match number {
            0 => (Content::Space, Form::Literal(b" ")),
            2 => (Content::Position, Form::Float),
            7 => (Content::Quaternion, Form::Float),
            8 => (Content::Time, Form::U32),
            10 => (Content::Switch, Form::U32),
            _ => return Err(ItemListError::Unknown { number }),
        })
    }

    const fn values(self) -> usize {
        match self.content {
            Content::Position | Content::Euler | Content::Cosines(_) => 3,
            Content::Quaternion => 4,
            Content::Space | Content::NewLine | Content::Time | Content::Switch => 1,
        }
    }

    const fn value_bytes(self) -> usize {
        match self.form {
            Form::Literal(bytes) => bytes.len(),
            Form::Fixed(_) => 7,
            Form::Extended => 13,
            Form::Whole(characters) => characters as usize,
            Form::SpaceAndDigit | Form::Word => 2,
            Form::Float | Form::U32 => 4,
            Form::Bytes(count) => count as usize,
        }
    }

    const fn bytes(self) -> usize {
        self.values() * self.value_bytes()
    }
}

/// A list of items that a device can be told and a decoder can read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ItemList {
    items: Vec<Item, MOST_ITEMS>,
    format: Format,
    bytes: usize,
}

/// Why a list of items was refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
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

/// Why bytes are not a list's items.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Misread {
    /// They are not in the items' form: likely no record at all.
    Shape,
    /// A number is none that the device may send.
    Value(DropReason),
}

impl From<DropReason> for Misread {
    fn from(reason: DropReason) -> Self {
        Self::Value(reason)
    }
}

/// What a record's items say.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Pose {
    pub(crate) head: Head,
    pub(crate) time: Option<DeviceTime>,
}

/// How to understand the items' numbers.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Scale<'a> {
    pub(crate) units: Units,
    pub(crate) axes: &'a Axes,
}

impl ItemList {
    /// A list of these items, in this order.
    ///
    /// # Errors
    ///
    /// Where an item is unknown or named twice, the list says nothing of a
    /// pose, the record would be too long, or the last item is not 0 or 1
    /// (a space or a line's end, which is what the start of a record is found
    /// by). Items 18, 19 and 20 stand alone, and then without an end.
    pub fn new(family: Family, format: Format, numbers: &[u8]) -> Result<Self, ItemListError> {
        let mut items: Vec<Item, MOST_ITEMS> = Vec::new();
        for &number in numbers {
            let item = Item::new(family, format, number)?;
            let may_repeat = matches!(
                item.content,
                Content::Space | Content::NewLine | Content::Switch
            );
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

    /// How its numbers are written.
    pub const fn format(&self) -> Format {
        self.format
    }

    /// Its items' numbers.
    pub fn numbers(&self) -> impl Iterator<Item = u8> {
        self.items.iter().map(|item| item.number)
    }

    /// Bytes of its items, without a record's header.
    pub const fn bytes(&self) -> usize {
        self.bytes
    }

    /// The command that makes a station send it: `O1,2,11,0` and a carriage
    /// return.
    pub fn command(&self, station: u8) -> crate::command::Bytes {
        let mut command = crate::command::Bytes::new();
        // 46 bytes at most: three a number and its comma.
        let _ = command.push(b'O');
        let _ = push_number(&mut command, station);
        for item in &self.items {
            let _ = command.push(b',');
            let _ = push_number(&mut command, item.number);
        }
        let _ = command.push(b'\r');
        command
    }

    /// Reads a record's items. `bytes` are [`ItemList::bytes`] long.
    pub(crate) fn read(&self, bytes: &[u8], tracked: bool, scale: Scale) -> Result<Pose, Misread> {
        // All of the form before any of the values: only what has the form
        // is a record.
        let mut values = Values::default();
        let mut rest = bytes;
        for item in &self.items {
            for place in 0..item.values() {
                let (value, after) = rest
                    .split_at_checked(item.value_bytes())
                    .ok_or(Misread::Shape)?;
                values.put(*item, place, value)?;
                rest = after;
            }
        }
        values.pose(tracked, scale)
    }

    /// Writes a record's items to the end of `record`, for a device that is
    /// where `pose` says; what it lacks is written as no rotation, the origin
    /// and time 0.
    pub(crate) fn write(&self, pose: &Pose, scale: Scale, record: &mut Vec<u8, MOST_RECORD_BYTES>) {
        let metres = pose.head.position.map_or(Vec3::ZERO, |p| p.value);
        let position = scale.axes.device_position(metres);
        let rotation = pose.head.orientation.map_or(Quat::IDENTITY, |q| q.value);
        let rotation = scale.axes.device_orientation(rotation);
        let columns = axes::columns(rotation);
        let euler = axes::euler_degrees(rotation);
        let microseconds = pose.time.map_or(0, |time| time.microseconds);
        for item in &self.items {
            let word = item.form == Form::Word;
            for place in 0..item.values() {
                let value = match item.content {
                    Content::Position if word => position[place.min(2)] / WORD_METRES,
                    Content::Position => position[place.min(2)] / scale.units.metres(),
                    Content::Euler if word => euler[place.min(2)] / WORD_DEGREES,
                    Content::Euler => euler[place.min(2)],
                    Content::Cosines(row) => columns[place.min(2)][usize::from(row.min(2))],
                    Content::Quaternion => {
                        let [x, y, z, w] = rotation.to_array();
                        [w, x, y, z][place.min(3)]
                    }
                    Content::Time => {
                        (microseconds / 1_000) as f32 + (microseconds % 1_000) as f32 / 1_000.0
                    }
                    Content::Space | Content::NewLine | Content::Switch => 0.0,
                };
                // The list's record fits, so nothing is cut off.
                let _ = match item.form {
                    Form::Literal(bytes) => record.extend_from_slice(bytes),
                    Form::Fixed(decimals) => write_fixed(value, decimals, record),
                    Form::Extended => write_extended(value, record),
                    Form::Whole(characters) => {
                        write_whole(microseconds / 1_000, characters, item.content, record)
                    }
                    Form::SpaceAndDigit => record.extend_from_slice(b" 0"),
                    Form::Float => record.extend_from_slice(&value.to_le_bytes()),
                    Form::Word => {
                        let first = place == 0 && Some(item) == self.items.first();
                        record.extend_from_slice(&word_bytes(value, first))
                    }
                    Form::U32 => {
                        let number = match item.content {
                            Content::Time => (microseconds / 1_000) as u32,
                            _ => 0,
                        };
                        record.extend_from_slice(&number.to_le_bytes())
                    }
                    Form::Bytes(count) => {
                        record.extend_from_slice(&[0; 2][..usize::from(count.min(2))])
                    }
                };
            }
        }
    }
}

/// The numbers of a record, in the device's units.
#[derive(Debug, Clone, Copy, Default)]
struct Values {
    position: Option<[f32; 3]>,
    /// The position is in parts of [`WORD_METRES`].
    words: bool,
    euler: Option<[f32; 3]>,
    cosines: [Option<[f32; 3]>; 3],
    /// Real part first.
    quaternion: Option<[f32; 4]>,
    milliseconds: Option<f32>,
    whole_milliseconds: Option<u32>,
}

impl Values {
    /// Takes one number of an item, if it has the item's form.
    fn put(&mut self, item: Item, place: usize, bytes: &[u8]) -> Result<(), Misread> {
        let value = match item.form {
            Form::Literal(literal) => return well_formed(bytes == literal),
            Form::SpaceAndDigit => return well_formed(matches!(bytes, [b' ', b'0' | b'1'])),
            Form::Bytes(_) => return Ok(()),
            Form::Fixed(decimals) => read_fixed(bytes, decimals).ok_or(Misread::Shape)?,
            Form::Extended => read_extended(bytes).ok_or(Misread::Shape)?,
            Form::Whole(_) => read_whole(bytes).ok_or(Misread::Shape)? as f32,
            Form::Float => f32::from_le_bytes(bytes.try_into().map_err(|_| Misread::Shape)?),
            Form::Word => {
                self.words = true;
                word_value(bytes).ok_or(Misread::Shape)?
            }
            Form::U32 => {
                let number = u32::from_le_bytes(bytes.try_into().map_err(|_| Misread::Shape)?);
                if item.content == Content::Time {
                    self.whole_milliseconds = Some(number);
                } else if number > 1 {
                    // A stylus button is up or down.
                    return Err(Misread::Shape);
                }
                return Ok(());
            }
        };
        let slot = match item.content {
            Content::Position => self.position.get_or_insert_default().get_mut(place),
            Content::Euler => self.euler.get_or_insert_default().get_mut(place),
            Content::Cosines(row) => self
                .cosines
                .get_mut(usize::from(row))
                .and_then(|row| row.get_or_insert_default().get_mut(place)),
            Content::Quaternion => self.quaternion.get_or_insert_default().get_mut(place),
            Content::Time => Some(self.milliseconds.get_or_insert_default()),
            Content::Space | Content::NewLine | Content::Switch => None,
        };
        if let Some(slot) = slot {
            *slot = value;
        }
        Ok(())
    }

    fn pose(&self, tracked: bool, scale: Scale) -> Result<Pose, Misread> {
        let metres = if self.words {
            WORD_METRES
        } else {
            scale.units.metres()
        };
        let position = self
            .position
            .map(|p| axes::plausible(Vec3::from_array(p) * metres))
            .transpose()?;
        // The best form that came; the others are checked all the same.
        let euler = self
            .euler
            .map(|angles| {
                let [a, e, r] = angles.map(|a| if self.words { a * WORD_DEGREES } else { a });
                axes::from_euler_degrees(a, e, r)
            })
            .transpose()?;
        let cosines = match self.cosines.map(|row| row.map(Vec3::from_array)) {
            [Some(x), Some(y), Some(z)] => {
                let rows = [x, y, z];
                let column = |i: usize| Vec3::new(rows[0][i], rows[1][i], rows[2][i]);
                Some(axes::from_columns([column(0), column(1), column(2)])?)
            }
            rows => {
                if rows.into_iter().flatten().any(|row| !row.is_finite()) {
                    return Err(Misread::Value(DropReason::OutOfRange));
                }
                None
            }
        };
        let quaternion = self
            .quaternion
            .map(|[w, x, y, z]| axes::unit_quaternion([x, y, z, w]))
            .transpose()?;
        let orientation = quaternion.or(cosines).or(euler);
        let time = match (self.milliseconds, self.whole_milliseconds) {
            (None, None) => None,
            (_, Some(milliseconds)) => Some(DeviceTime::millis_u32(milliseconds)),
            (Some(milliseconds), None) => {
                // A month, at which an f32 no longer tells 128 ms apart.
                if !(0.0..=2.6e9).contains(&milliseconds) {
                    return Err(Misread::Value(DropReason::OutOfRange));
                }
                let whole = milliseconds as u64;
                let part = (milliseconds - whole as f32) * 1_000.0;
                Some(DeviceTime::unwrapped(whole * 1_000 + part as u64))
            }
        };
        let reading = |tracked| move |value| Reading { value, tracked };
        Ok(Pose {
            head: Head {
                position: position
                    .map(|p| scale.axes.position(p))
                    .map(reading(tracked)),
                orientation: orientation.map(|q| Reading {
                    value: scale.axes.orientation(q),
                    tracked,
                }),
                angular_velocity: None,
            },
            time,
        })
    }
}

fn well_formed(is: bool) -> Result<(), Misread> {
    if is { Ok(()) } else { Err(Misread::Shape) }
}

/// The value of two bytes that hold seven bits each; the second's highest
/// bit is 0.
fn word_value(bytes: &[u8]) -> Option<f32> {
    let &[low, high] = bytes else { return None };
    if high & 0x80 != 0 {
        return None;
    }
    Some(f32::from(from_seven_bits(low, high)) / WORD_ONE)
}

/// The 14-bit word that two bytes of seven bits hold, in the upper bits of
/// the result.
pub(crate) fn from_seven_bits(low: u8, high: u8) -> i16 {
    (u16::from(low & 0x7F) << 2 | u16::from(high & 0x7F) << 9) as i16
}

/// The reverse of [`from_seven_bits`].
pub(crate) fn to_seven_bits(word: i16) -> [u8; 2] {
    let word = word as u16;
    [(word >> 2 & 0x7F) as u8, (word >> 9 & 0x7F) as u8]
}

/// `value`, from −1 to 1, in the nearest of 2¹⁴ steps.
pub(crate) fn nearest_word(value: f32) -> i16 {
    let steps = libm::roundf(value * WORD_ONE / 4.0).clamp(-8_192.0, 8_191.0);
    (steps as i16) << 2
}

fn word_bytes(value: f32, first: bool) -> [u8; 2] {
    let [low, high] = to_seven_bits(nearest_word(value));
    [if first { low | 0x80 } else { low }, high]
}

/// A number of `Sxxx.xx` or `Sx.xxxx`: blanks, a sign or none, digits, a
/// point and so many decimals.
fn read_fixed(bytes: &[u8], decimals: u8) -> Option<f32> {
    let point = bytes.len().checked_sub(usize::from(decimals) + 1)?;
    let (before, after) = bytes.split_at_checked(point)?;
    let before = before.trim_ascii_start();
    let negative = before.first() == Some(&b'-');
    let signless = before.strip_prefix(b"-").or(before.strip_prefix(b"+"));
    let before = signless.unwrap_or(before);
    let [b'.', after @ ..] = after else {
        return None;
    };
    if before.is_empty() {
        return None;
    }
    let all = digits(before, 0)?;
    let all = digits(after, all)?;
    // Five digits and a power of ten are exact: one rounding.
    let value = all as f32 / power_of_ten(u32::from(decimals));
    Some(if negative { -value } else { value })
}

/// A number of `Sx.xxxxxESxxb`.
fn read_extended(bytes: &[u8]) -> Option<f32> {
    let &[
        sign,
        one,
        b'.',
        a,
        b,
        c,
        d,
        e,
        b'E',
        exponent_sign,
        tens,
        ones,
        b' ',
    ] = bytes
    else {
        return None;
    };
    let is_negative = |sign: u8| match sign {
        b' ' | b'+' => Some(false),
        b'-' => Some(true),
        _ => None,
    };
    let mantissa = digits(&[one, a, b, c, d, e], 0)?;
    let exponent = digits(&[tens, ones], 0)? as i32;
    let exponent = if is_negative(exponent_sign)? {
        -exponent
    } else {
        exponent
    } - 5;
    let mantissa = mantissa as f32;
    let power = power_of_ten(exponent.unsigned_abs());
    let value = if exponent < 0 {
        mantissa / power
    } else {
        mantissa * power
    };
    Some(if is_negative(sign)? { -value } else { value })
}

/// A whole number, right-aligned.
fn read_whole(bytes: &[u8]) -> Option<u32> {
    let bytes = bytes.trim_ascii_start();
    if bytes.is_empty() {
        None
    } else {
        digits(bytes, 0)
    }
}

/// Decimal digits after those that `before` is made of; `None` where one is
/// no digit, or where they are too many.
fn digits(bytes: &[u8], before: u32) -> Option<u32> {
    bytes.iter().try_fold(before, |number, &byte| {
        let digit = byte.is_ascii_digit().then(|| u32::from(byte - b'0'))?;
        number.checked_mul(10)?.checked_add(digit)
    })
}

/// Exact up to 10¹⁰; infinite where f32 ends.
fn power_of_ten(exponent: u32) -> f32 {
    let mut power = 1.0;
    for _ in 0..exponent.min(110) {
        power *= 10.0;
    }
    power
}

type Written = Result<(), heapless::CapacityError>;

fn write_fixed(value: f32, decimals: u8, record: &mut Vec<u8, MOST_RECORD_BYTES>) -> Written {
    let scaled = libm::roundf(value * power_of_ten(u32::from(decimals)));
    let scaled = scaled.clamp(-99_999.0, 99_999.0) as i32;
    let mut text = *b"-     .";
    let mut number = scaled.unsigned_abs();
    text[0] = if scaled < 0 { b'-' } else { b' ' };
    let point = 6 - usize::from(decimals.min(5));
    for place in (1..7).rev() {
        text[place] = if place == point {
            b'.'
        } else {
            let digit = (number % 10) as u8;
            number /= 10;
            b'0' + digit
        };
    }
    record.extend_from_slice(&text)
}

fn write_extended(value: f32, record: &mut Vec<u8, MOST_RECORD_BYTES>) -> Written {
    let mut magnitude = if value.is_finite() { value.abs() } else { 0.0 };
    let mut exponent = 0_i32;
    // At most as often as f32 has powers of ten.
    for _ in 0..50 {
        if magnitude >= 10.0 {
            magnitude /= 10.0;
            exponent += 1;
        } else if magnitude < 1.0 && magnitude > 0.0 {
            magnitude *= 10.0;
            exponent -= 1;
        }
    }
    let mut mantissa = libm::roundf(magnitude * 100_000.0) as u32;
    if mantissa > 999_999 {
        mantissa /= 10;
        exponent += 1;
    }
    let digit = |power: u32| b'0' + (mantissa / power % 10) as u8;
    let power = exponent.unsigned_abs();
    record.extend_from_slice(&[
        if value < 0.0 { b'-' } else { b' ' },
        digit(100_000),
        b'.',
        digit(10_000),
        digit(1_000),
        digit(100),
        digit(10),
        digit(1),
        b'E',
        if exponent < 0 { b'-' } else { b'+' },
        b'0' + (power / 10 % 10) as u8,
        b'0' + (power % 10) as u8,
        b' ',
    ])
}

fn write_whole(
    milliseconds: u64,
    characters: u8,
    content: Content,
    record: &mut Vec<u8, MOST_RECORD_BYTES>,
) -> Written {
    let mut number = if content == Content::Time {
        milliseconds
    } else {
        0
    };
    let mut text = [b' '; 14];
    for place in text.iter_mut().rev() {
        *place = b'0' + (number % 10) as u8;
        number /= 10;
        if number == 0 {
            break;
        }
    }
    let from = text.len().saturating_sub(usize::from(characters));
    record.extend_from_slice(text.get(from..).unwrap_or_default())
}

/// Writes a number's decimal digits.
pub(crate) fn push_number(bytes: &mut crate::command::Bytes, number: u8) -> Result<(), u8> {
    if number >= 100 {
        bytes.push(b'0' + number / 100)?;
    }
    if number >= 10 {
        bytes.push(b'0' + number / 10 % 10)?;
    }
    bytes.push(b'0' + number % 10)
}

#[cfg(test)]
mod tests;
