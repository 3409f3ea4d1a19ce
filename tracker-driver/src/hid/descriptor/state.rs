//! The state that items leave to those behind them: global, which lasts, and local, which
//! is for the next main item.

use super::{MOST_USAGES, Problem, Unit, Usage};
use heapless::Vec;

/// The global state.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Globals {
    pub(super) usage_page: u16,
    pub(super) logical_minimum: i32,
    /// As signed and as unsigned: which it is depends on the minimum.
    pub(super) logical_maximum: Datum,
    pub(super) physical: [i32; 2],
    pub(super) unit_exponent: i8,
    pub(super) unit: Unit,
    pub(super) report_size: u32,
    pub(super) report_id: u8,
    pub(super) report_count: u32,
}

/// The data of an item.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Datum {
    pub(super) unsigned: u32,
    pub(super) signed: i32,
    pub(super) bytes: usize,
}

impl Datum {
    pub(super) fn new(bytes: &[u8]) -> Self {
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

/// The usages before a main item, those without a page on the one at that item.
#[derive(Debug, Clone, Default)]
pub(super) struct Locals {
    pub(super) usages: Vec<UsageRange, MOST_USAGES>,
    /// Half a range.
    pub(super) minimum: Option<Datum>,
    /// How many usages of the open delimiters have come; `None` outside.
    pub(super) alternatives: Option<u32>,
}

#[derive(Debug, Clone, Copy)]
pub(super) struct UsageRange {
    pub(super) first: u32,
    pub(super) last: u32,
    pub(super) has_page: bool,
}

impl UsageRange {
    pub(super) fn nth(self, n: u32, page: u16) -> Usage {
        let bits = self.first.saturating_add(n).min(self.last);
        Usage {
            page: if self.has_page {
                (bits >> 16) as u16
            } else {
                page
            },
            id: bits as u16,
        }
    }
}

impl Locals {
    pub(super) fn add(&mut self, range: UsageRange) -> Result<(), Problem> {
        if let Some(alternatives) = &mut self.alternatives {
            *alternatives = alternatives.saturating_add(1);
            if *alternatives > 1 {
                return Ok(());
            }
        }
        self.usages.push(range).map_err(|_| Problem::TooManyUsages)
    }

    pub(super) fn first(&self, page: u16) -> Option<Usage> {
        self.usages.first().map(|range| range.nth(0, page))
    }
}

/// Gives out the usages to the elements of a main item, one by one.
pub(super) struct UsageCursor<'a> {
    pub(super) ranges: &'a [UsageRange],
    pub(super) n: u32,
    pub(super) page: u16,
}

impl UsageCursor<'_> {
    pub(super) fn next(&mut self) -> Option<Usage> {
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
