//! From a record's numbers to a pose.

use super::super::axes;
use super::item::{Content, Form, Item};
use super::numbers::{read_extended, read_fixed, read_whole, word_value};
use super::{ItemError, Read, Scale};
use crate::decoder::DropReason;
use crate::sample::{Head, Reading};
use crate::time::DeviceTime;
use crate::valid;
use glam::{Quat, Vec3};

/// The numbers of a record, in the device's units.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Values {
    position: Option<[f32; 3]>,
    /// The position is in parts of [`Scale::word_metres`], angles of its degrees.
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
    pub(super) fn put(&mut self, item: Item, place: usize, bytes: &[u8]) -> Result<(), ItemError> {
        let value = match item.form {
            Form::Literal(literal) => return well_formed(bytes == literal),
            Form::SpaceAndDigit => return well_formed(matches!(bytes, [b' ', b'0' | b'1'])),
            Form::Bytes(_) => return Ok(()),
            Form::Fixed(decimals) => read_fixed(bytes, decimals).ok_or(ItemError::Shape)?,
            Form::Extended => read_extended(bytes).ok_or(ItemError::Shape)?,
            Form::Whole(_) => read_whole(bytes).ok_or(ItemError::Shape)? as f32,
            Form::Float => f32::from_le_bytes(bytes.try_into().map_err(|_| ItemError::Shape)?),
            Form::Word => {
                self.words = true;
                word_value(bytes).ok_or(ItemError::Shape)?
            }
            Form::U32 => {
                let number = u32::from_le_bytes(bytes.try_into().map_err(|_| ItemError::Shape)?);
                if item.content == Content::Time {
                    self.whole_milliseconds = Some(number);
                } else if number > 1 {
                    // A stylus button is up or down.
                    return Err(ItemError::Shape);
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
            Content::Other => None,
        };
        if let Some(slot) = slot {
            *slot = value;
        }
        Ok(())
    }

    pub(super) fn pose(&self, tracked: bool, scale: Scale) -> Result<Read, ItemError> {
        let metres = if self.words {
            scale.word_metres
        } else {
            scale.units.metres()
        };
        let position = self
            .position
            .map(|p| valid::position(Vec3::from_array(p) * metres))
            .transpose()?;
        // The best form that came; the others are checked all the same.
        let degrees = if self.words { scale.word_degrees } else { 1.0 };
        let euler = self.euler.map(|angles| {
            let [a, e, r] = angles.map(|angle| angle * degrees);
            axes::from_euler_degrees(a, e, r)
        });
        let euler = euler.transpose()?;
        let cosines = match self.cosines.map(|row| row.map(Vec3::from_array)) {
            [Some(x), Some(y), Some(z)] => {
                let rows = [x, y, z];
                let column = |i: usize| Vec3::new(rows[0][i], rows[1][i], rows[2][i]);
                Some(axes::from_columns([column(0), column(1), column(2)])?)
            }
            rows => {
                if rows.into_iter().flatten().any(|row| !row.is_finite()) {
                    return Err(ItemError::Value(DropReason::OutOfRange));
                }
                None
            }
        };
        let quaternion = self
            .quaternion
            .map(|[w, x, y, z]| valid::sent_rotation(Quat::from_xyzw(x, y, z, w)))
            .transpose()?;
        let orientation = quaternion.or(cosines).or(euler);
        let time = match (self.milliseconds, self.whole_milliseconds) {
            (None, None) => None,
            (_, Some(milliseconds)) => Some(DeviceTime::millis_u32(milliseconds)),
            (Some(milliseconds), None) => {
                // A month, at which an f32 no longer tells 128 ms apart.
                if !(0.0..=2.6e9).contains(&milliseconds) {
                    return Err(ItemError::Value(DropReason::OutOfRange));
                }
                let whole = milliseconds as u64;
                let part = (milliseconds - whole as f32) * 1_000.0;
                Some(DeviceTime::unwrapped(whole * 1_000 + part as u64))
            }
        };
        let head = Head {
            position: position.map(|p| Reading {
                value: scale.axes.position(p),
                tracked,
            }),
            orientation: orientation.map(|q| Reading {
                value: scale.axes.orientation(q),
                tracked,
            }),
            angular_velocity: None,
        };
        Ok((head, time))
    }
}

fn well_formed(is: bool) -> Result<(), ItemError> {
    if is { Ok(()) } else { Err(ItemError::Shape) }
}
