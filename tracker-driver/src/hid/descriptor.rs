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
//! - *constant* elements are handed over like all others. They are mostly
//!   padding, but some devices call their values constant too: who has usages
//!   for them should read them.

use core::fmt;
use heapless::Vec;

/// Most bytes of a descriptor; Linux allows as many.
pub const MOST_BYTES: usize = 4_096;
/// Deepest nesting of collections.
pub const MOST_COLLECTIONS: usize = 16;
/// Most states that are pushed.
pub const MOST_PUSHED: usize = 8;
/// Most usages and ranges of usages before one main item.
pub const MOST_USAGES: usize = 64;
/// Most reports, counting input, output and feature reports of an id apart.
pub const MOST_REPORTS: usize = 32;
/// Most bits of one element.
pub const MOST_ELEMENT_BITS: u32 = 64;
/// Most bits of a report, its id not counted: 4 KiB.
pub const MOST_REPORT_BITS: u32 = 8 * 4_096;

/// A meaning: a page and a number on it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Usage {
    /// The page.
    pub page: u16,
    /// The usage on that page.
    pub id: u16,
}

impl Usage {
    const fn from_bits(bits: u32) -> Self {
        Self {
            page: (bits >> 16) as u16,
            id: bits as u16,
        }
    }
}

/// Which way a report goes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum ReportKind {
    /// From the device, when it likes.
    Input,
    /// To the device.
    Output,
    /// Both ways, when the host asks.
    Feature,
}

/// A collection that an element is in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Collection {
    /// 0 physical, 1 application, 2 logical, and others.
    pub kind: u8,
    /// What it is of, where it says.
    pub usage: Option<Usage>,
}

/// A unit, as the descriptor writes it: the system in bits 0 to 3, then in
/// four bits each the exponents of length, mass, time and others.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Unit(pub u32);

impl Unit {
    /// Centimetres.
    pub const CENTIMETRE: Self = Self(0x11);
    /// Inches.
    pub const INCH: Self = Self(0x13);
    /// Radians: rotation in the SI system.
    pub const RADIAN: Self = Self(0x12);
    /// Degrees: rotation in the English system.
    pub const DEGREE: Self = Self(0x14);
    /// Seconds, in the SI system.
    pub const SECOND: Self = Self(0x1001);
    /// Seconds, in the English system.
    pub const SECOND_ENGLISH: Self = Self(0x1003);
    /// Per second, in the SI system.
    pub const HERTZ: Self = Self(0xF001);
}

/// One value of a report, or one place for a value.
#[derive(Debug, Clone, Copy)]
pub struct Element<'a> {
    /// Which way the report goes.
    pub kind: ReportKind,
    /// The report's id; 0 where the device uses none.
    pub report_id: u8,
    /// The first bit, after the report id where there is one.
    pub bit_offset: u32,
    /// How many bits there are, 1 to [`MOST_ELEMENT_BITS`].
    pub bits: u32,
    /// What it means; `None` where it does not say, and in arrays, whose
    /// values say it.
    pub usage: Option<Usage>,
    /// The value never changes, or is padding.
    pub constant: bool,
    /// It has a value of its own, and is not a place in an array of usages.
    pub variable: bool,
    /// The value is a change.
    pub relative: bool,
    /// Smallest and largest value; one outside means that there is none. Of
    /// a value that is not below zero, both have to be read as unsigned.
    pub logical: [i32; 2],
    /// What the smallest and the largest value stand for; both 0 where that
    /// is themselves.
    pub physical: [i32; 2],
    /// The unit.
    pub unit: Unit,
    /// The power of ten that the unit is multiplied with, −8 to 7.
    pub unit_exponent: i8,
    /// The collections that it is in, the outermost first.
    pub collections: &'a [Collection],
}

impl Element<'_> {
    /// Whether values can be below zero.
    pub fn signed(&self) -> bool {
        self.logical[0] < 0
    }

    /// The usage of the innermost collection that has one.
    pub fn parent(&self) -> Option<Usage> {
        self.collections.iter().rev().find_map(|c| c.usage)
    }
}

/// How long a report is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ReportSize {
    /// Which way it goes.
    pub kind: ReportKind,
    /// Its id; 0 where the device uses none.
    pub report_id: u8,
    /// Its bits, without the id.
    pub bits: u32,
}

impl ReportSize {
    /// Its bytes, with the id where there is one.
    pub const fn bytes(&self) -> usize {
        self.bits.div_ceil(8) as usize + (self.report_id != 0) as usize
    }
}

/// What a descriptor holds besides its elements.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Reports {
    sizes: Vec<ReportSize, MOST_REPORTS>,
}

impl Reports {
    /// All reports, in the order in which they appear.
    pub fn as_slice(&self) -> &[ReportSize] {
        &self.sizes
    }

    /// The report that goes this way and has this id.
    pub fn find(&self, kind: ReportKind, report_id: u8) -> Option<&ReportSize> {
        self.sizes
            .iter()
            .find(|size| size.kind == kind && size.report_id == report_id)
    }
}

/// Why a descriptor was refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct DescriptorError {
    /// Where: the offset of the item, in bytes.
    pub offset: usize,
    /// What is wrong there.
    pub problem: Problem,
}

/// What can be wrong with a descriptor.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Problem {
    /// It has more than [`MOST_BYTES`] bytes.
    TooLong {
        /// How many it has.
        found: usize,
    },
    /// Its last item is cut off.
    Truncated,
    /// An item of a kind that the specification reserves.
    UnknownItem {
        /// Its first byte.
        prefix: u8,
    },
    /// More than [`MOST_COLLECTIONS`] collections in one another.
    CollectionsTooDeep,
    /// A collection ends that was not begun.
    CollectionNotBegun,
    /// This many collections do not end.
    CollectionNotEnded {
        /// How many.
        open: usize,
    },
    /// More than [`MOST_PUSHED`] states are pushed.
    PushedTooMuch,
    /// A state is popped that was not pushed.
    NothingPushed,
    /// More than [`MOST_USAGES`] usages before one main item.
    TooManyUsages,
    /// A range of usages without its beginning or its end, or upside down.
    UsageRange,
    /// More than [`MOST_REPORTS`] reports.
    TooManyReports,
    /// A report id of 0 or above 255.
    ReportId {
        /// The id.
        found: u32,
    },
    /// An element without a report id, in a device that uses them.
    ReportIdMissing,
    /// An element of more than [`MOST_ELEMENT_BITS`] bits.
    ElementTooLarge {
        /// Its bits.
        bits: u32,
    },
    /// A report of more than [`MOST_REPORT_BITS`] bits.
    ReportTooLarge {
        /// Its bits.
        bits: u64,
    },
    /// A logical minimum above its maximum.
    LogicalRange {
        /// The minimum.
        minimum: i32,
        /// The maximum.
        maximum: i32,
    },
}

impl fmt::Display for DescriptorError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "HID report descriptor, byte {}: ", self.offset)?;
        match self.problem {
            Problem::TooLong { found } => {
                write!(f, "{found} bytes, where {MOST_BYTES} are the most")
            }
            Problem::Truncated => write!(f, "the last item is cut off"),
            Problem::UnknownItem { prefix } => write!(f, "an item {prefix:#04x} is not known"),
            Problem::CollectionsTooDeep => {
                write!(f, "more than {MOST_COLLECTIONS} collections in one another")
            }
            Problem::CollectionNotBegun => write!(f, "a collection ends that was not begun"),
            Problem::CollectionNotEnded { open } => write!(f, "{open} collections do not end"),
            Problem::PushedTooMuch => write!(f, "more than {MOST_PUSHED} pushes"),
            Problem::NothingPushed => write!(f, "a pop without a push"),
            Problem::TooManyUsages => {
                write!(f, "more than {MOST_USAGES} usages before one main item")
            }
            Problem::UsageRange => write!(f, "a range of usages without both its ends in order"),
            Problem::TooManyReports => write!(f, "more than {MOST_REPORTS} reports"),
            Problem::ReportId { found } => write!(f, "report id {found}, not 1 to 255"),
            Problem::ReportIdMissing => {
                write!(f, "some elements have a report id and this one has none")
            }
            Problem::ElementTooLarge { bits } => write!(
                f,
                "an element of {bits} bits, where {MOST_ELEMENT_BITS} are the most"
            ),
            Problem::ReportTooLarge { bits } => write!(
                f,
                "a report of {bits} bits, where {MOST_REPORT_BITS} are the most"
            ),
            Problem::LogicalRange { minimum, maximum } => {
                write!(
                    f,
                    "a logical minimum of {minimum} above the maximum, {maximum}"
                )
            }
        }
    }
}

impl core::error::Error for DescriptorError {}

/// The global state.
#[derive(Debug, Clone, Copy, Default)]
struct Globals {
    usage_page: u16,
    logical_minimum: i32,
    /// As signed and as unsigned: which it is depends on the minimum.
    logical_maximum: Datum,
    physical: [i32; 2],
    unit_exponent: i8,
    unit: Unit,
    report_size: u32,
    report_id: u8,
    report_count: u32,
}

/// The data of an item.
#[derive(Debug, Clone, Copy, Default)]
struct Datum {
    unsigned: u32,
    signed: i32,
    bytes: usize,
}

impl Datum {
    fn new(bytes: &[u8]) -> Self {
        let (unsigned, signed) = match *bytes {
            [a] => (u32::from(a), i32::from(a as i8)),
            [a, b] => {
                let word = u16::from_le_bytes([a, b]);
                (u32::from(word), i32::from(word as i16))
            }
            [a, b, c, d] => {
                let word = u32::from_le_bytes([a, b, c, d]);
                (word, word as i32)
            }
            _ => (0, 0),
        };
        Self {
            unsigned,
            signed,
            bytes: bytes.len(),
        }
    }
}

/// The usages before a main item. Those without a page of their own get the
/// one that counts at the main item.
#[derive(Debug, Clone, Default)]
struct Locals {
    usages: Vec<UsageRange, MOST_USAGES>,
    /// Half a range.
    minimum: Option<Datum>,
    /// How many usages of the open delimiters have come; `None` outside.
    alternatives: Option<u32>,
}

#[derive(Debug, Clone, Copy)]
struct UsageRange {
    first: u32,
    last: u32,
    has_page: bool,
}

impl UsageRange {
    fn nth(self, n: u32, page: u16) -> Usage {
        let bits = self.first.saturating_add(n).min(self.last);
        let usage = Usage::from_bits(bits);
        if self.has_page {
            usage
        } else {
            Usage { page, ..usage }
        }
    }
}

impl Locals {
    fn add(&mut self, range: UsageRange) -> Result<(), Problem> {
        if let Some(alternatives) = &mut self.alternatives {
            *alternatives = alternatives.saturating_add(1);
            if *alternatives > 1 {
                return Ok(());
            }
        }
        self.usages.push(range).map_err(|_| Problem::TooManyUsages)
    }

    fn first(&self, page: u16) -> Option<Usage> {
        self.usages.first().map(|range| range.nth(0, page))
    }
}

/// Gives out the usages to the elements of a main item, one by one.
struct UsageCursor<'a> {
    ranges: &'a [UsageRange],
    n: u32,
    page: u16,
}

impl UsageCursor<'_> {
    fn next(&mut self) -> Option<Usage> {
        let (range, rest) = self.ranges.split_first()?;
        let usage = range.nth(self.n, self.page);
        if self.n < range.last - range.first {
            self.n += 1;
        } else if !rest.is_empty() {
            self.ranges = rest;
            self.n = 0;
        }
        Some(usage)
    }
}

/// What is known while going through a descriptor.
#[derive(Default)]
struct Walk {
    globals: Globals,
    pushed: Vec<Globals, MOST_PUSHED>,
    locals: Locals,
    collections: Vec<Collection, MOST_COLLECTIONS>,
    reports: Reports,
}

const INPUT: u8 = 0x80;
const OUTPUT: u8 = 0x90;
const FEATURE: u8 = 0xB0;
const COLLECTION: u8 = 0xA0;
const END_COLLECTION: u8 = 0xC0;
const LONG_ITEM: u8 = 0xFE;

const CONSTANT: u32 = 1 << 0;
const VARIABLE: u32 = 1 << 1;
const RELATIVE: u32 = 1 << 2;

/// Goes through a descriptor and hands every element to `visit`, in order.
///
/// The work is bounded by the limits of this module: an element of a report
/// is visited once, and no report has more than [`MOST_REPORT_BITS`].
///
/// # Errors
///
/// Where the descriptor breaks the specification or a limit; elements before
/// that place have been visited.
pub fn walk(
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
                let collection = Collection {
                    kind: datum.unsigned as u8,
                    usage: self.locals.first(self.globals.usage_page),
                };
                return self
                    .collections
                    .push(collection)
                    .map_err(|_| Problem::CollectionsTooDeep);
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
        if (report_id == 0) != self.reports.sizes.iter().all(|size| size.report_id == 0) {
            // The first report decides.
            if !self.reports.sizes.is_empty() {
                return Err(Problem::ReportIdMissing);
            }
        }
        let start = self.grow(kind, u64::from(bits) * u64::from(count))?;
        if bits == 0 {
            return Ok(());
        }
        let variable = flags & VARIABLE != 0;
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
                usage: if variable { usages.next() } else { None },
                constant: flags & CONSTANT != 0,
                variable,
                relative: flags & RELATIVE != 0,
                logical: [minimum, maximum],
                physical: globals.physical,
                unit: globals.unit,
                unit_exponent: globals.unit_exponent,
                collections: &self.collections,
            });
        }
        Ok(())
    }

    /// Makes the report longer; where its new bits begin.
    fn grow(&mut self, kind: ReportKind, bits: u64) -> Result<u32, Problem> {
        let report_id = self.globals.report_id;
        let is_it = |size: &ReportSize| size.kind == kind && size.report_id == report_id;
        if !self.reports.sizes.iter().any(is_it) {
            let size = ReportSize {
                kind,
                report_id,
                bits: 0,
            };
            let added = self.reports.sizes.push(size);
            added.map_err(|_| Problem::TooManyReports)?;
        }
        let size = self.reports.sizes.iter_mut().find(|size| is_it(size));
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
