//! Noticing what is wrong with a line by listening to it.

use super::{Failure, PATIENCE};
use crate::decoder::{DropReason, Dropped, Event};
use crate::time::Micros;

/// Notices that nothing comes in, or nothing that can be understood, or much that cannot:
/// where most bytes of a second, or some behind most of its records, belong to no record,
/// the records are chance, or of another form.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Watch {
    /// Whether the transport delimits records.
    delimited: bool,
    /// When the last record came, or the watch began.
    since: Option<Micros>,
    /// Whether a record has come.
    any: bool,
    /// Bytes since then.
    bytes: u64,
    /// The arrival of the last byte.
    heard: Micros,
    useless: Useless,
    second: Second,
    /// What the last whole second was like, if it was like another protocol's.
    unlike: Option<Failure>,
}

/// The counts of the second under way.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
struct Second {
    start: Micros,
    bytes: u64,
    dropped: u64,
    /// Times that bytes were dropped.
    drops: u32,
    useless: Useless,
    records: u32,
}

/// One drop says nothing: a line may be joined in mid-record.
const LEAST_DROPS: u32 = 2;

impl Watch {
    /// Returns a watch that begins with its first call.
    pub fn new() -> Self {
        Self::default()
    }

    /// Returns a watch of a transport that delimits records, as HID does: no speed can be wrong.
    pub fn of_reports() -> Self {
        Self {
            delimited: true,
            ..Self::default()
        }
    }

    /// Counts bytes that came in.
    pub fn on_bytes(&mut self, count: usize, now: Micros) {
        self.at(now);
        self.heard = now;
        self.bytes = self.bytes.saturating_add(count as u64);
        self.second.bytes = self.second.bytes.saturating_add(count as u64);
    }

    /// Takes note of a decoder's event.
    pub fn on_event(&mut self, event: &Event, now: Micros) {
        let second = &mut self.second;
        match event {
            Event::Sample(_) | Event::Message(_) => {
                second.records = second.records.saturating_add(1);
                self.since = Some(now);
                self.any = true;
                self.bytes = 0;
                self.useless = Useless::default();
            }
            Event::Dropped(dropped) => {
                self.useless.note(*dropped, self.delimited);
                // These are records, if of no use.
                if !matches!(dropped.reason, DropReason::Duplicate | DropReason::Unknown) {
                    second.useless.note(*dropped, self.delimited);
                    second.drops = second.drops.saturating_add(1);
                    second.dropped = second.dropped.saturating_add(dropped.bytes.into());
                }
            }
        }
    }

    /// Returns what is wrong: no record for [`PATIENCE`], or a last second unlike this protocol's.
    pub fn trouble(&mut self, now: Micros) -> Option<Failure> {
        let since = self.at(now);
        if now.since(since) < PATIENCE {
            return self.unlike;
        }
        Some(match (self.bytes, self.useless.most_of(self.bytes)) {
            (0, _) => Failure::Silent,
            (_, Some(unusable)) => unusable,
            (bytes, None) if self.any && now.since(self.heard) >= SILENCE => {
                Failure::BrokenOff { bytes }
            }
            (bytes, None) => Failure::NoRecord { bytes },
        })
    }

    /// Returns the time of the last record; judges a second that is over.
    fn at(&mut self, now: Micros) -> Micros {
        let since = *self.since.get_or_insert_with(|| {
            self.second.start = now;
            now
        });
        if now.since(self.second.start) >= SECOND {
            self.unlike = self.second.unlike();
            self.second = Second {
                start: now,
                ..Second::default()
            };
        }
        since
    }
}

const SECOND: Micros = Micros::from_millis(1_000);

/// A device that has sent records pauses less within one.
const SILENCE: Micros = Micros::from_millis(500);

impl Second {
    fn unlike(&self) -> Option<Failure> {
        let most_bytes = self.dropped.saturating_mul(2) > self.bytes;
        let most_records = self.drops > self.records / 2;
        let unlike = self.drops >= LEAST_DROPS && (most_bytes || most_records);
        let failure = self.useless.most_of(self.dropped);
        unlike.then_some(failure.unwrap_or(Failure::Unlike {
            dropped: self.dropped,
            bytes: self.bytes,
        }))
    }
}

/// Records that came whole and could not be used.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Useless {
    records: u32,
    bytes: u64,
    reason: Option<DropReason>,
}

impl Useless {
    /// On a transport that delimits records, all are whole.
    pub(super) fn note(&mut self, dropped: Dropped, delimited: bool) {
        // What chance makes of bytes at another speed rarely fails for these.
        let whole = matches!(
            dropped.reason,
            DropReason::Field
                | DropReason::OutOfRange
                | DropReason::NotUnit
                | DropReason::Unknown
                | DropReason::Duplicate
        );
        if whole || delimited {
            self.records = self.records.saturating_add(1);
            self.bytes = self.bytes.saturating_add(dropped.bytes.into());
            self.reason = Some(dropped.reason);
        }
    }

    /// Returns the failure to report if they are the most of these bytes.
    pub(super) fn most_of(&self, bytes: u64) -> Option<Failure> {
        let reason = self.reason?;
        let most = self.bytes.saturating_mul(2) > bytes;
        most.then_some(Failure::Unusable {
            records: self.records,
            reason,
        })
    }
}
