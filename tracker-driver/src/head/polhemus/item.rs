//! The items: what each says, and how it is written.

use super::{Family, Format, ItemListError};

/// What an item says.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Content {
    Position,
    Euler,
    /// Row 0, 1 or 2 of the matrix whose columns are the sensor's axes.
    Cosines(u8),
    Quaternion,
    /// Milliseconds.
    Time,
    /// A space, a line's end, stylus, buttons or joystick: checked for its form and left out.
    Other,
}

/// How an item's numbers are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Form {
    /// These bytes.
    Literal(&'static [u8]),
    /// `Sxxx.xx` or `Sx.xxxx`: seven characters with this many decimals.
    Fixed(u8),
    /// `Sx.xxxxxESxxb`: thirteen characters.
    Extended,
    /// A whole number, right-aligned in this many characters.
    Whole(u8),
    /// A space and `0` or `1`.
    SpaceAndDigit,
    /// Little-endian f32.
    Float,
    /// 14 bits, low seven first, for −1 to 1 of the item's full scale.
    Word,
    /// Little-endian u32.
    U32,
    /// This many bytes of any value.
    Bytes(u8),
}

/// Metres that are 1 in item 18, usually.
pub(crate) const WORD_METRES: f32 = 3.0;
/// Degrees that are 1 in item 19, usually.
pub(crate) const WORD_DEGREES: f32 = 180.0;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Item {
    pub(super) number: u8,
    pub(super) content: Content,
    pub(super) form: Form,
}

impl Item {
    /// Returns the item of this number, or whether the format is what keeps it out.
    pub(super) fn new(family: Family, format: Format, number: u8) -> Result<Self, ItemListError> {
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
            0 | 50 => (Content::Other, Form::Literal(b" ")),
            1 | 51 => (Content::Other, Form::Literal(b"\r\n")),
            2 => (Content::Position, float(Form::Fixed(2))),
            52 => (Content::Position, float(Form::Extended)),
            4 => (Content::Euler, float(Form::Fixed(2))),
            54 => (Content::Euler, float(Form::Extended)),
            5..=7 => (Content::Cosines(number - 5), float(Form::Fixed(4))),
            55..=57 => (Content::Cosines(number - 55), float(Form::Extended)),
            11 => (Content::Quaternion, float(Form::Fixed(4))),
            61 => (Content::Quaternion, float(Form::Extended)),
            16 | 66 => (Content::Other, Form::SpaceAndDigit),
            18 => word(Content::Position)?,
            19 => word(Content::Euler)?,
            20 => word(Content::Quaternion)?,
            21 => (Content::Time, float(Form::Whole(14))),
            22 => match format {
                Format::Ascii => (Content::Other, Form::Whole(3)),
                Format::Binary => (Content::Other, Form::Bytes(1)),
            },
            23 => match format {
                Format::Ascii => return Err(other_format),
                Format::Binary => (Content::Other, Form::Bytes(2)),
            },
            _ => return Err(ItemListError::Unknown { number }),
        })
    }

    fn of_liberty(format: Format, number: u8) -> Result<(Content, Form), ItemListError> {
        if format == Format::Ascii {
            return Err(ItemListError::Format { number, format });
        }
        Ok(match number {
            0 => (Content::Other, Form::Literal(b" ")),
            2 => (Content::Position, Form::Float),
            7 => (Content::Quaternion, Form::Float),
            8 => (Content::Time, Form::U32),
            10 => (Content::Other, Form::U32),
            _ => return Err(ItemListError::Unknown { number }),
        })
    }

    pub(super) const fn values(self) -> usize {
        match self.content {
            Content::Position | Content::Euler | Content::Cosines(_) => 3,
            Content::Quaternion => 4,
            Content::Time | Content::Other => 1,
        }
    }

    pub(super) const fn value_bytes(self) -> usize {
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

    pub(super) const fn bytes(self) -> usize {
        self.values() * self.value_bytes()
    }
}
