//! A parser of HID report descriptors that needs no memory of its own and
//! ends, whatever it is given.
//!
//! [`walk`] goes through a descriptor once and hands over every element of
//! every report: which report it is in, at which bits, what it means. What to
//! keep of it is the caller's choice.
//!
//! After "Device Class Definition for Human Interface Devices" 1.11, section
//! 6.2.2. Where the specification leaves a choice, or devices do not keep to
//! it, this is done as Linux does:
//!
//! - the usage page that counts is the one at the main item;
//! - the last usage serves all elements that are left;
//! - a logical maximum is unsigned where the minimum is not below zero;
//! - of alternative usages in delimiters, the first counts;
//! - long items are passed over;
//! - *constant* elements are handed over like all others. They are mostly padding, but
//!   some devices call their values constant too: those with a usage are to be read.

mod error;
mod state;

pub(super) use error::DescriptorError;

use error::Problem;
use heapless::Vec;
use state::{Datum, Globals, Locals, UsageCursor, UsageRange};

/// Most bytes of a descriptor; Linux allows as many.
const MOST_BYTES: usize = 4_096;
/// Deepest nesting of collections.
const MOST_COLLECTIONS: usize = 16;
/// Most states that are pushed.
const MOST_PUSHED: usize = 8;
/// Most usages and ranges of usages before one main item.
const MOST_USAGES: usize = 64;
/// Most reports, counting input, output and feature reports of an id apart.
const MOST_REPORTS: usize = 32;
const MOST_ELEMENT_BITS: u32 = 64;
/// Most bits of a report, its id not counted: 4 KiB.
const MOST_REPORT_BITS: u32 = 8 * 4_096;

/// A meaning: a page and a number on it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Usage {
    pub(super) page: u16,
    pub(super) id: u16,
}

/// Which way a report goes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum ReportKind {
    /// From the device, when it likes.
    Input,
    /// To the device.
    Output,
    /// Both ways, when the host asks.
    Feature,
}

/// A unit: the system in bits 0 to 3, then exponents of length, mass, time and others.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Unit(pub(super) u32);

impl Unit {
    pub(super) const CENTIMETRE: Self = Self(0x11);
    pub(super) const INCH: Self = Self(0x13);
    pub(super) const RADIAN: Self = Self(0x12);
    pub(super) const DEGREE: Self = Self(0x14);
    /// Seconds, in the SI system.
    pub(super) const SECOND: Self = Self(0x1001);
    /// Seconds, in the English system.
    pub(super) const SECOND_ENGLISH: Self = Self(0x1003);
}

/// One value of a report, or one place for a value.
#[derive(Debug, Clone, Copy)]
pub(super) struct Element<'a> {
    pub(super) kind: ReportKind,
    /// 0 where the device uses no ids.
    pub(super) report_id: u8,
    /// The first bit, after the report id where there is one.
    pub(super) bit_offset: u32,
    /// 1 to [`MOST_ELEMENT_BITS`].
    pub(super) bits: u32,
    /// `None` where it does not say, and in arrays, whose values say it.
    pub(super) usage: Option<Usage>,
    /// Smallest and largest value; one outside means that there is none.
    pub(super) logical: [i32; 2],
    /// What those two stand for; both 0 where that is themselves.
    pub(super) physical: [i32; 2],
    pub(super) unit: Unit,
    /// The power of ten that the unit is multiplied with, −8 to 7.
    pub(super) unit_exponent: i8,
    /// The usages of the collections that it is in, the outermost first.
    pub(super) collections: &'a [Option<Usage>],
    /// Constant, variable, relative: the item's own bits.
    #[cfg(test)]
    flags: u32,
}

impl Element<'_> {
    /// Returns the usage of the innermost collection that has one.
    pub(super) fn parent(&self) -> Option<Usage> {
        self.collections.iter().rev().find_map(|usage| *usage)
    }
}

/// How long a report is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct ReportSize {
    pub(super) kind: ReportKind,
    /// 0 where the device uses no ids.
    pub(super) report_id: u8,
    /// Its bits, without the id.
    pub(super) bits: u32,
}

impl ReportSize {
    /// Returns its bytes, with the id where there is one.
    pub(super) const fn bytes(self) -> usize {
        self.bits.div_ceil(8) as usize + (self.report_id != 0) as usize
    }
}

/// All reports of a descriptor, in the order in which they appear.
pub(super) type Reports = Vec<ReportSize, MOST_REPORTS>;

/// What is known while going through a descriptor.
#[derive(Default)]
struct Walk {
    globals: Globals,
    pushed: Vec<Globals, MOST_PUSHED>,
    locals: Locals,
    /// The usages of the open collections.
    collections: Vec<Option<Usage>, MOST_COLLECTIONS>,
    reports: Reports,
}

const INPUT: u8 = 0x80;
const OUTPUT: u8 = 0x90;
const FEATURE: u8 = 0xB0;
const COLLECTION: u8 = 0xA0;
const END_COLLECTION: u8 = 0xC0;
const LONG_ITEM: u8 = 0xFE;

const VARIABLE: u32 = 1 << 1;

/// Hands every element to `visit`, in order, also of a descriptor that is refused later.
pub(super) fn walk(
    descriptor: &[u8],
    mut visit: impl FnMut(&Element<'_>),
) -> Result<Reports, DescriptorError> {
    let at = |offset, problem| DescriptorError { offset, problem };
    if descriptor.len() > MOST_BYTES {
        let found = descriptor.len();
        return Err(at(0, Problem::TooLong { found }));
    }
    let mut walk = Walk::default();
    let mut rest = descriptor;
    while let [prefix, behind @ ..] = rest {
        let offset = descriptor.len() - rest.len();
        let length = match (*prefix, behind) {
            (LONG_ITEM, [length, _tag, ..]) => 2 + usize::from(*length),
            (LONG_ITEM, _) => return Err(at(offset, Problem::Truncated)),
            // Two bits for 0, 1, 2 or 4 bytes.
            (prefix, _) => (1 << (prefix & 3)) >> 1,
        };
        let (data, behind) = behind
            .split_at_checked(length)
            .ok_or(at(offset, Problem::Truncated))?;
        rest = behind;
        if *prefix != LONG_ITEM {
            walk.item(*prefix, Datum::new(data), &mut visit)
                .map_err(|problem| at(offset, problem))?;
        }
    }
    match walk.collections.len() {
        0 => Ok(walk.reports),
        open => Err(at(descriptor.len(), Problem::CollectionNotEnded { open })),
    }
}

impl Walk {
    fn item(
        &mut self,
        prefix: u8,
        datum: Datum,
        visit: &mut impl FnMut(&Element<'_>),
    ) -> Result<(), Problem> {
        match (prefix >> 2) & 3 {
            0 => {
                let done = self.main(prefix, datum, visit);
                self.locals = Locals::default();
                done
            }
            1 => self.global(prefix, datum),
            2 => self.local(prefix, datum),
            _ => Err(Problem::UnknownItem { prefix }),
        }
    }

    fn main(
        &mut self,
        prefix: u8,
        datum: Datum,
        visit: &mut impl FnMut(&Element<'_>),
    ) -> Result<(), Problem> {
        if self.locals.minimum.is_some() {
            return Err(Problem::UsageRange);
        }
        let kind = match prefix & 0xF0 {
            INPUT => ReportKind::Input,
            OUTPUT => ReportKind::Output,
            FEATURE => ReportKind::Feature,
            COLLECTION => {
                let usage = self.locals.first(self.globals.usage_page);
                let begun = self.collections.push(usage);
                return begun.map_err(|_| Problem::CollectionsTooDeep);
            }
            END_COLLECTION => {
                let ended = self.collections.pop();
                return ended.map(|_| ()).ok_or(Problem::CollectionNotBegun);
            }
            _ => return Err(Problem::UnknownItem { prefix }),
        };
        self.elements(kind, datum.unsigned, visit)
    }

    fn elements(
        &mut self,
        kind: ReportKind,
        flags: u32,
        visit: &mut impl FnMut(&Element<'_>),
    ) -> Result<(), Problem> {
        let globals = self.globals;
        let (bits, count) = (globals.report_size, globals.report_count);
        if bits > MOST_ELEMENT_BITS {
            return Err(Problem::ElementTooLarge { bits });
        }
        let minimum = globals.logical_minimum;
        let maximum = if minimum < 0 {
            globals.logical_maximum.signed
        } else {
            // As far as it fits; what is larger is never reached.
            i32::try_from(globals.logical_maximum.unsigned).unwrap_or(i32::MAX)
        };
        if minimum > maximum {
            return Err(Problem::LogicalRange { minimum, maximum });
        }
        let report_id = globals.report_id;
        if (report_id == 0) != self.reports.iter().all(|size| size.report_id == 0) {
            // The first report decides.
            if !self.reports.is_empty() {
                return Err(Problem::ReportIdMissing);
            }
        }
        let start = self.grow(kind, u64::from(bits) * u64::from(count))?;
        if bits == 0 {
            return Ok(());
        }
        let is_variable = flags & VARIABLE != 0;
        let mut usages = UsageCursor {
            ranges: &self.locals.usages,
            n: 0,
            page: globals.usage_page,
        };
        for n in 0..count {
            visit(&Element {
                kind,
                report_id,
                bit_offset: start + n * bits,
                bits,
                usage: if is_variable { usages.next() } else { None },
                logical: [minimum, maximum],
                physical: globals.physical,
                unit: globals.unit,
                unit_exponent: globals.unit_exponent,
                collections: &self.collections,
                #[cfg(test)]
                flags,
            });
        }
        Ok(())
    }

    /// Makes the report longer; where its new bits begin.
    fn grow(&mut self, kind: ReportKind, bits: u64) -> Result<u32, Problem> {
        let report_id = self.globals.report_id;
        let is_it = |size: &ReportSize| size.kind == kind && size.report_id == report_id;
        if !self.reports.iter().any(is_it) {
            let size = ReportSize {
                kind,
                report_id,
                bits: 0,
            };
            let added = self.reports.push(size);
            added.map_err(|_| Problem::TooManyReports)?;
        }
        let size = self.reports.iter_mut().find(|size| is_it(size));
        let size = size.ok_or(Problem::TooManyReports)?;
        let bits = u64::from(size.bits) + bits;
        if bits > u64::from(MOST_REPORT_BITS) {
            return Err(Problem::ReportTooLarge { bits });
        }
        let start = size.bits;
        size.bits = bits as u32;
        Ok(start)
    }

    fn global(&mut self, prefix: u8, datum: Datum) -> Result<(), Problem> {
        let globals = &mut self.globals;
        match prefix & 0xF0 {
            0x00 => globals.usage_page = datum.unsigned as u16,
            0x10 => globals.logical_minimum = datum.signed,
            0x20 => globals.logical_maximum = datum,
            0x30 => globals.physical[0] = datum.signed,
            0x40 => globals.physical[1] = datum.signed,
            // Four bits, in two's complement; some write the whole byte.
            0x50 => {
                globals.unit_exponent = match datum.signed {
                    nibble @ 8..=15 => nibble as i8 - 16,
                    other => other.clamp(-8, 7) as i8,
                };
            }
            0x60 => globals.unit = Unit(datum.unsigned),
            0x70 => globals.report_size = datum.unsigned,
            0x80 => {
                globals.report_id = match datum.unsigned {
                    found @ (0 | 256..) => return Err(Problem::ReportId { found }),
                    id => id as u8,
                };
            }
            0x90 => globals.report_count = datum.unsigned,
            0xA0 => {
                let pushed = self.pushed.push(self.globals);
                return pushed.map_err(|_| Problem::PushedTooMuch);
            }
            0xB0 => self.globals = self.pushed.pop().ok_or(Problem::NothingPushed)?,
            _ => return Err(Problem::UnknownItem { prefix }),
        }
        Ok(())
    }

    fn local(&mut self, prefix: u8, datum: Datum) -> Result<(), Problem> {
        let has_page = datum.bytes == 4;
        match prefix & 0xF0 {
            0x00 => self.locals.add(UsageRange {
                first: datum.unsigned,
                last: datum.unsigned,
                has_page,
            }),
            0x10 => {
                self.locals.minimum = Some(datum);
                Ok(())
            }
            0x20 => {
                let first = self.locals.minimum.take().ok_or(Problem::UsageRange)?;
                if first.unsigned > datum.unsigned || (first.bytes == 4) != has_page {
                    return Err(Problem::UsageRange);
                }
                self.locals.add(UsageRange {
                    first: first.unsigned,
                    last: datum.unsigned,
                    has_page,
                })
            }
            0xA0 => {
                self.locals.alternatives = (datum.unsigned != 0).then_some(0);
                Ok(())
            }
            // Designators and strings.
            0x30..=0x90 => Ok(()),
            _ => Err(Problem::UnknownItem { prefix }),
        }
    }
}

#[cfg(test)]
mod tests;
