//! Where a value is in a report, and its unit and range.

use super::super::descriptor::{Element, ReportKind, ReportSize, Reports, Unit, Usage};
use super::super::usages::PAGE;
use super::ReportError;
use crate::time::DeviceTime;

/// Powers of ten from −8 on, as exponents of units have them.
const POWERS: [f32; 16] = [
    1.0e-8, 1.0e-7, 1.0e-6, 1.0e-5, 1.0e-4, 1.0e-3, 1.0e-2, 1.0e-1, 1.0, 1.0e1, 1.0e2, 1.0e3,
    1.0e4, 1.0e5, 1.0e6, 1.0e7,
];

const METRES_PER_CENTIMETRE: f32 = 0.01;
const METRES_PER_INCH: f32 = 0.0254;
const RADIANS_PER_DEGREE: f32 = 0.017_453_292;
/// Largest angle of a head, radians: two whole turns.
const LARGEST_ANGLE: f32 = 12.6;

/// A value of a report.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Field {
    bit_offset: u32,
    bits: u32,
    logical: [i32; 2],
    /// Physical value of the smallest logical one, and the step to the next.
    physical: Option<(f32, f32)>,
    unit: Unit,
    exponent: i8,
}

impl Field {
    pub(super) fn new(element: &Element<'_>) -> Self {
        let [low, high] = element.physical;
        let [smallest, largest] = element.logical;
        let range = (largest as f32) - (smallest as f32);
        let given = low != high && range > 0.0 && element.physical != element.logical;
        Self {
            bit_offset: element.bit_offset,
            bits: element.bits,
            logical: element.logical,
            physical: given.then(|| (low as f32, (high as f32 - low as f32) / range)),
            unit: element.unit,
            exponent: element.unit_exponent,
        }
    }

    /// Returns the bits from a report without its id.
    fn raw(self, body: &[u8]) -> Option<u64> {
        let (first, shift) = ((self.bit_offset / 8) as usize, self.bit_offset % 8);
        let count = (shift + self.bits).div_ceil(8) as usize;
        let bytes = body.get(first..first.checked_add(count)?)?;
        let mut value = 0;
        let mut place = 0;
        for &byte in bytes {
            let byte = u64::from(byte);
            // Nine bytes hold an element of 64 bits that is not aligned.
            value |= match place {
                0 => byte >> shift,
                _ => byte.checked_shl(place - shift).unwrap_or(0),
            };
            place += 8;
        }
        Some(value & (u64::MAX >> (64 - self.bits.clamp(1, 64))))
    }

    /// Writes bits into a report without its id; bits that do not fit are cut off.
    pub(super) fn write(self, body: &mut [u8], value: u64) {
        for n in 0..self.bits.min(64) {
            let at = self.bit_offset + n;
            if let Some(byte) = body.get_mut((at / 8) as usize) {
                let bit = 1 << (at % 8);
                *byte = *byte & !bit | if value >> n & 1 == 0 { 0 } else { bit };
            }
        }
    }

    /// Returns the value; `None` if it is outside its range.
    fn logical(self, body: &[u8]) -> Option<i64> {
        let raw = self.raw(body)?;
        let [smallest, largest] = self.logical.map(i64::from);
        let value = if smallest < 0 {
            let unused = 64 - self.bits.clamp(1, 64);
            (raw << unused) as i64 >> unused
        } else {
            i64::try_from(raw).ok()?
        };
        (smallest..=largest).contains(&value).then_some(value)
    }

    /// Returns the value in the device's unit, with its exponent.
    fn value(self, body: &[u8]) -> Option<f32> {
        let logical = self.logical(body)?;
        let value = match self.physical {
            Some((low, step)) => low + (logical - i64::from(self.logical[0])) as f32 * step,
            None => logical as f32,
        };
        Some(value * POWERS.get(usize::try_from(self.exponent + 8).ok()?)?)
    }

    /// Returns whether it is a length.
    pub(super) fn is_length(self) -> bool {
        matches!(self.unit, Unit::CENTIMETRE | Unit::INCH)
    }

    pub(super) fn read_metres(field: Option<Self>, body: &[u8]) -> Option<f32> {
        let field = field?;
        let unit = match field.unit {
            Unit::CENTIMETRE => METRES_PER_CENTIMETRE,
            Unit::INCH => METRES_PER_INCH,
            _ => return None,
        };
        Some(field.value(body)? * unit)
    }

    pub(super) fn read_radians(field: Option<Self>, body: &[u8]) -> Option<f32> {
        let field = field?;
        let unit = match field.unit {
            Unit::RADIAN => 1.0,
            Unit::DEGREE => RADIANS_PER_DEGREE,
            _ => return None,
        };
        Some(field.value(body)? * unit).filter(|angle| angle.abs() <= LARGEST_ANGLE)
    }

    /// Reads a value in any unit.
    pub(super) fn read_value(field: Option<Self>, body: &[u8]) -> Option<f32> {
        field?.value(body)
    }

    /// Reads a number without a unit.
    pub(super) fn read_number(field: Option<Self>, body: &[u8]) -> Option<u32> {
        u32::try_from(field?.logical(body)?).ok()
    }

    /// Reads a time, in microseconds if it has no unit; its range may be that of its single bytes.
    pub(super) fn read_time(field: Option<Self>, body: &[u8]) -> Option<DeviceTime> {
        let field = field?;
        let exponent = match field.unit {
            Unit::SECOND | Unit::SECOND_ENGLISH => i32::from(field.exponent) + 6,
            Unit(0) => 0,
            _ => return None,
        };
        let power = 10_u64.checked_pow(exponent.unsigned_abs())?;
        let scaled = |time: u64| match exponent {
            0.. => time.saturating_mul(power),
            _ => time.checked_div(power).unwrap_or(0),
        };
        let wraps_at = 1_u64.checked_shl(field.bits).map_or(0, scaled);
        Some(DeviceTime {
            microseconds: scaled(field.raw(body)?),
            wraps_at,
        })
    }
}

/// The key of a field: the usage of the collection around the element, or [`ANYWHERE`], and the
/// element's own usage.
pub(super) type Key = (u16, u16);

pub(super) const ANYWHERE: u16 = 0;

pub(super) const fn anywhere<const N: usize>(usages: [u16; N]) -> [Key; N] {
    let mut keys = [(ANYWHERE, 0); N];
    let mut n = 0;
    while n < N {
        keys[n].1 = usages[n];
        n += 1;
    }
    keys
}

fn fits((parent, usage): Key, element: &Element<'_>) -> bool {
    let on_page = |id| Some(Usage { page: PAGE, id });
    element.usage == on_page(usage) && (parent == ANYWHERE || element.parent() == on_page(parent))
}

/// Fields of one report.
#[derive(Debug, Clone)]
pub(super) struct Group<const N: usize> {
    size: ReportSize,
    /// The fields in the order of the keys.
    pub(super) fields: [Option<Field>; N],
}

impl<const N: usize> Group<N> {
    /// Returns a set without fields.
    pub(super) fn new(kind: ReportKind) -> Self {
        Self {
            size: ReportSize {
                kind,
                report_id: 0,
                bits: 0,
            },
            fields: [None; N],
        }
    }

    /// Takes an element if it is one of the fields; bytes of one usage in a row are one field.
    pub(super) fn offer(&mut self, element: &Element<'_>, keys: &[Key; N]) {
        let first = self.fields.iter().all(Option::is_none);
        if element.kind != self.size.kind || (!first && element.report_id != self.size.report_id) {
            return;
        }
        let mut fields = keys.iter().zip(&mut self.fields);
        let Some((_, field)) = fields.find(|(key, _)| fits(**key, element)) else {
            return;
        };
        self.size.report_id = element.report_id;
        match field {
            None => *field = Some(Field::new(element)),
            Some(field)
                if element.bits == 8
                    && field.bit_offset + field.bits == element.bit_offset
                    && field.bits + element.bits <= 64 =>
            {
                field.bits += element.bits;
            }
            Some(_) => (),
        }
    }

    /// Looks up the length of the report.
    pub(super) fn measure(&mut self, reports: &Reports) {
        let id = (self.size.kind, self.size.report_id);
        let size = reports
            .iter()
            .find(|size| (size.kind, size.report_id) == id);
        if let Some(size) = size
            && self.fields.iter().any(Option::is_some)
        {
            self.size = *size;
        }
    }

    /// Returns the size of the report with the fields, if there are any.
    pub(super) fn size(&self) -> Option<ReportSize> {
        (self.size.bits > 0).then_some(self.size)
    }

    /// Returns the report without its id, if it is the one with the fields.
    pub(super) fn body<'a>(&self, report: &'a [u8]) -> Result<&'a [u8], ReportError> {
        let size = self.size().ok_or(ReportError::NotDescribed)?;
        let body = match (size.report_id, report) {
            (0, body) => body,
            (expected, [found, body @ ..]) if *found == expected => body,
            (expected, [found, ..]) => {
                return Err(ReportError::ReportId {
                    expected,
                    found: *found,
                });
            }
            (_, []) => &[],
        };
        if report.len() < size.bytes() {
            return Err(ReportError::Length {
                expected: size.bytes(),
                found: report.len(),
            });
        }
        Ok(body)
    }
}
