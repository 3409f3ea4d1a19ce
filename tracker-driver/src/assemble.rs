//! Cutting a stream of bytes into records, and getting back in step.
//!
//! A [`Protocol`] looks at the bytes that stand at the front of the stream
//! and says whether they are a record; [`Assembler`] keeps those bytes, moves
//! on, and counts. Bytes that start no record are thrown away one at a time,
//! so that a record that begins among them is found.

use crate::decoder::{Counts, DropReason, Dropped, Event, Message};
use crate::sample::Sample;
use crate::time::Micros;

/// So many bytes thrown away in a row are one event; a longer row is several.
const LONGEST_ROW: u32 = 256;

/// What stands at the front of the stream.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Look {
    /// What may become a record: it takes more bytes to say.
    More,
    /// No record starts here.
    Nowhere(DropReason),
    /// A record that cannot be used. Whether it is one at all is in doubt
    /// when the bytes before it were none.
    Unusable {
        /// Its bytes.
        length: usize,
        /// What is wrong.
        reason: DropReason,
    },
    /// The start of a record that certainly broke off.
    Broken {
        /// Its bytes.
        length: usize,
    },
    /// A record.
    Record {
        /// Its bytes.
        length: usize,
        /// What it says, in this order.
        says: Says,
    },
}

/// What a record says.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Says {
    /// First this,
    pub(crate) fault: Option<Message>,
    /// then this,
    pub(crate) message: Option<Message>,
    /// then this.
    pub(crate) sample: Option<Sample>,
}

/// How a device's records look.
pub(crate) trait Protocol {
    /// What stands at the front of `bytes`, which are never empty and never
    /// more than the assembler's room. With [`Assembler`]'s room full it must
    /// not be [`Look::More`].
    ///
    /// A record is looked at once when it is whole, so `self` may remember
    /// what came before.
    fn look(&mut self, bytes: &[u8], arrival: Micros) -> Look;
}

/// A window of `ROOM` bytes on a stream.
#[derive(Debug, Clone)]
pub(crate) struct Assembler<const ROOM: usize> {
    bytes: [u8; ROOM],
    /// The bytes from `start` up to `end` are those not yet decided on.
    start: usize,
    end: usize,
    /// Whether the bytes before `start` were a record.
    in_step: bool,
    /// Thrown away and not yet reported.
    row: Option<Dropped>,
    counts: Counts,
}

impl<const ROOM: usize> Assembler<ROOM> {
    pub(crate) const fn new() -> Self {
        Self {
            bytes: [0; ROOM],
            start: 0,
            end: 0,
            in_step: true,
            row: None,
            counts: Counts::new(),
        }
    }

    pub(crate) const fn counts(&self) -> &Counts {
        &self.counts
    }

    pub(crate) fn counts_mut(&mut self) -> &mut Counts {
        &mut self.counts
    }

    /// Forgets the bytes at hand.
    pub(crate) fn reset(&mut self) {
        self.start = 0;
        self.end = 0;
        self.in_step = true;
        self.row = None;
    }

    pub(crate) fn feed(
        &mut self,
        bytes: &[u8],
        arrival: Micros,
        protocol: &mut impl Protocol,
        sink: &mut dyn FnMut(Event),
    ) {
        self.counts.bytes = self.counts.bytes.saturating_add(bytes.len() as u64);
        for &byte in bytes {
            if self.end == ROOM {
                // Room is left: a full window is decided on when it fills.
                self.bytes.copy_within(self.start..self.end, 0);
                self.end -= self.start;
                self.start = 0;
            }
            if let Some(place) = self.bytes.get_mut(self.end) {
                *place = byte;
                self.end += 1;
            }
            self.decide(arrival, protocol, sink);
        }
    }

    /// Takes from the front whatever can be decided on. Each round but the
    /// last takes a byte or more.
    fn decide(
        &mut self,
        arrival: Micros,
        protocol: &mut impl Protocol,
        sink: &mut dyn FnMut(Event),
    ) {
        while self.start < self.end {
            let window = self.bytes.get(self.start..self.end).unwrap_or_default();
            let length = match protocol.look(window, arrival) {
                Look::More if window.len() < ROOM => return,
                Look::More => {
                    self.drop_bytes(1, DropReason::OutOfStep, sink);
                    1
                }
                Look::Nowhere(reason) => {
                    self.drop_bytes(1, reason, sink);
                    1
                }
                Look::Unusable { length, reason } => {
                    // Out of step these may be other bytes that look like a
                    // record: a true one may start among them.
                    let whole = self.in_step;
                    self.end_row(sink);
                    self.drop_bytes(if whole { length } else { 1 }, reason, sink);
                    if whole {
                        self.end_row(sink);
                        self.in_step = true;
                    }
                    if whole { length } else { 1 }
                }
                Look::Broken { length } => {
                    self.end_row(sink);
                    self.drop_bytes(length, DropReason::Truncated, sink);
                    self.end_row(sink);
                    length
                }
                Look::Record { length, says } => {
                    self.end_row(sink);
                    self.in_step = true;
                    for message in [says.fault, says.message].into_iter().flatten() {
                        self.tell(Event::Message(message), sink);
                    }
                    if let Some(sample) = says.sample {
                        self.tell(Event::Sample(sample), sink);
                    }
                    length
                }
            };
            // A length of 0 would loop for ever.
            self.start = (self.start + length.max(1)).min(self.end);
        }
        self.start = 0;
        self.end = 0;
    }

    /// Adds bytes to the row of those thrown away.
    fn drop_bytes(&mut self, count: usize, reason: DropReason, sink: &mut dyn FnMut(Event)) {
        self.in_step = false;
        let row = self.row.get_or_insert(Dropped { bytes: 0, reason });
        row.bytes = row.bytes.saturating_add(count as u32);
        if row.bytes >= LONGEST_ROW {
            self.end_row(sink);
        }
    }

    /// Reports the row of bytes thrown away, if there is one.
    fn end_row(&mut self, sink: &mut dyn FnMut(Event)) {
        if let Some(row) = self.row.take() {
            self.tell(Event::Dropped(row), sink);
        }
    }

    fn tell(&mut self, event: Event, sink: &mut dyn FnMut(Event)) {
        self.counts.note(&event);
        sink(event);
    }
}
