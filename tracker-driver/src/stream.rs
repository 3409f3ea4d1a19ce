//! Shared by the decoders of unframed byte streams: a window over the bytes that
//! may still become a record, and counts of the bytes that did not.
//!
//! The protocol looks at the window after every byte and says what the bytes at its
//! start are. Nothing depends on how the stream was cut into pieces.

use crate::decoder::{Counts, DropReason, Dropped, Event, Message};
use crate::time::Micros;
use core::cell::Cell;

/// Report a dropped run once it reaches this many bytes; shorter ones when a record has come.
const LONGEST_RUN: u32 = 256;

/// A protocol's verdict on the bytes at the start of the window.
#[derive(Debug, Clone, Copy, PartialEq)]
// An event is large, and cannot be boxed.
#[allow(clippy::large_enum_variant)]
pub(crate) enum Step {
    /// Possibly the beginning of a record: more bytes are needed.
    More,
    /// Possibly a whole record: the bytes behind it will tell.
    Wait,
    /// A record of this many bytes: a message to hand over first, if any, and its event.
    Take(usize, Option<Message>, Event),
    /// A record of this many bytes that cannot be used: all are dropped.
    Discard(usize, DropReason),
    /// No record: the first byte is dropped.
    Skip(DropReason),
}

/// The window over a stream that a protocol sees.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Window<'a> {
    /// Bytes that are neither in a record nor dropped yet; at least one.
    pub(crate) bytes: &'a [u8],
    /// Whether the byte before the first one ended a record.
    pub(crate) in_step: bool,
    /// When the last byte came in; for a record that waited, its own last byte.
    pub(crate) arrival: Micros,
}

impl Window<'_> {
    /// Returns the step for a record that cannot be used. Out of step a true record may begin
    /// among its bytes, so only the first byte is dropped.
    pub(crate) fn unusable(self, length: usize, reason: DropReason) -> Step {
        if self.in_step {
            Step::Discard(length, reason)
        } else {
            Step::Skip(reason)
        }
    }

    /// Returns the step for bytes that begin like a record and go on otherwise.
    pub(crate) fn broken_off(self) -> Step {
        Step::Skip(if self.in_step {
            DropReason::Truncated
        } else {
            DropReason::OutOfStep
        })
    }
}

/// The last N bytes of a stream: room for the protocol's longest record and for the bytes that it
/// looks at behind one.
#[derive(Debug, Clone)]
pub(crate) struct Stream<const N: usize> {
    bytes: [u8; N],
    length: usize,
    in_step: bool,
    /// Arrival of the last byte of a whole record that waits for the bytes behind it.
    whole: Option<Micros>,
    /// Dropped bytes that are not reported yet.
    run: Option<Dropped>,
    /// The last sample's number, in protocols that number samples.
    number: Option<u32>,
    /// Counts of all bytes.
    pub(crate) counts: Counts,
}

impl<const N: usize> Default for Stream<N> {
    fn default() -> Self {
        Self {
            bytes: [0; N],
            length: 0,
            in_step: false,
            whole: None,
            run: None,
            number: None,
            counts: Counts::default(),
        }
    }
}

impl<const N: usize> Stream<N> {
    /// Takes bytes, the last of which came in at `arrival`, and asks `step` about each window.
    pub(crate) fn feed(
        &mut self,
        bytes: &[u8],
        arrival: Micros,
        sink: &mut dyn FnMut(Event),
        mut step: impl FnMut(Window<'_>) -> Step,
    ) {
        for &byte in bytes {
            self.counts.bytes = self.counts.bytes.saturating_add(1);
            if let Some(free) = self.bytes.get_mut(self.length) {
                *free = byte;
                self.length += 1;
            }
            let mut start = 0;
            while let Some(window) = self.bytes.get(start..self.length)
                && !window.is_empty()
            {
                let full = window.len() == N;
                let window = Window {
                    bytes: window,
                    in_step: self.in_step,
                    arrival: self.whole.unwrap_or(arrival),
                };
                let step = step(window);
                self.whole = matches!(step, Step::Wait).then_some(window.arrival);
                let taken = match step {
                    Step::More | Step::Wait if !full => break,
                    // Avoids a standstill where a protocol asks for more than the
                    // window holds.
                    Step::More | Step::Wait => self.skip(DropReason::Length, sink),
                    Step::Skip(reason) => self.skip(reason, sink),
                    Step::Take(taken, first, event) => {
                        if let Some(first) = first {
                            self.hand_over(Event::Message(first), sink);
                        }
                        self.hand_over(event, sink);
                        taken
                    }
                    Step::Discard(taken, reason) => {
                        self.hand_over(Event::dropped(taken as u32, reason), sink);
                        taken
                    }
                };
                start += taken.max(1);
            }
            if start > 0 {
                // Byte by byte: functions that move ranges have a path to a panic, which
                // the compiler does not always remove.
                let bytes = Cell::from_mut(&mut self.bytes[..]).as_slice_of_cells();
                let left = self.length.saturating_sub(start);
                for (to, from) in bytes.iter().zip(bytes.iter().skip(start)).take(left) {
                    to.set(from.get());
                }
                self.length = left;
            }
        }
    }

    /// Does what `feed` does, and counts samples that are missing by their numbers, which wrap at
    /// `wraps_at`; after a gap of more than `most` the device has restarted.
    pub(crate) fn feed_numbered(
        &mut self,
        [wraps_at, most]: [u32; 2],
        bytes: &[u8],
        arrival: Micros,
        sink: &mut dyn FnMut(Event),
        mut step: impl FnMut(Window<'_>) -> Step,
    ) {
        let (mut last, mut lost) = (self.number, 0);
        self.feed(bytes, arrival, sink, |window| {
            let step = step(window);
            if let Step::Take(_, _, Event::Sample(sample)) = &step
                && let Some(number) = sample.sequence
            {
                let before = last.replace(number);
                let gap = before.map_or(0, |last| {
                    (number + wraps_at - last % wraps_at - 1) % wraps_at
                });
                lost += if gap <= most { u64::from(gap) } else { 0 };
            }
            step
        });
        self.number = last;
        self.counts.lost = self.counts.lost.saturating_add(lost);
    }

    #[allow(clippy::large_types_passed_by_value, reason = "it is handed on")]
    fn hand_over(&mut self, event: Event, sink: &mut dyn FnMut(Event)) {
        self.tell(sink);
        self.counts.note(&event);
        self.in_step = true;
        sink(event);
    }

    /// Drops the first byte.
    fn skip(&mut self, reason: DropReason, sink: &mut dyn FnMut(Event)) -> usize {
        self.in_step = false;
        self.throw_away(reason, sink);
        1
    }

    /// Adds a byte to the run of dropped ones; any reason but `OutOfStep` begins a new run.
    fn throw_away(&mut self, reason: DropReason, sink: &mut dyn FnMut(Event)) {
        if reason != DropReason::OutOfStep {
            self.tell(sink);
        }
        let run = self.run.get_or_insert(Dropped { bytes: 0, reason });
        run.bytes += 1;
        if run.bytes >= LONGEST_RUN {
            self.tell(sink);
        }
    }

    fn tell(&mut self, sink: &mut dyn FnMut(Event)) {
        if let Some(run) = self.run.take() {
            let event = Event::Dropped(run);
            self.counts.note(&event);
            sink(event);
        }
    }

    /// Forgets the bytes in the window, and counts them as truncated.
    pub(crate) fn reset(&mut self) {
        self.tell(&mut |_| ());
        if self.length > 0 {
            let cut = Event::dropped(self.length as u32, DropReason::Truncated);
            self.counts.note(&cut);
        }
        self.length = 0;
        self.in_step = false;
        self.whole = None;
        self.number = None;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{reply, thrown};
    use std::vec::Vec;

    const ARRIVAL: Micros = Micros(5);

    /// Decodes a toy protocol: a record is a count and that many bytes of 9; 0xFF is never valid.
    fn step(window: Window<'_>) -> Step {
        let taken = |length, first| {
            let reply = reply(window.bytes[0].into(), window.in_step.into());
            Step::Take(length, first, reply)
        };
        match *window.bytes {
            [0xFF, ..] => Step::Skip(DropReason::Field),
            [count @ 1..=4, ref rest @ ..] => {
                let count = usize::from(count);
                if rest.iter().take(count).any(|&b| b != 9) {
                    Step::Skip(DropReason::Truncated)
                } else if rest.len() < count {
                    Step::More
                } else {
                    taken(1 + count, None)
                }
            }
            [5, ..] => Step::More,
            [6, ..] => taken(1, Some(STATE)),
            _ => Step::Skip(DropReason::OutOfStep),
        }
    }

    const STATE: Message = Message::State {
        code: 6,
        meaning: "",
    };

    #[test]
    fn each_byte_is_of_a_record_or_reported_before_the_next() {
        use DropReason::{Field, Length, OutOfStep, Truncated};
        for (bytes, expected) in [
            (
                &[7, 7, 1, 9, 2, 9, 1, 9, 0xFF, 0xFF, 0, 0, 1, 9][..],
                &[
                    thrown(2, OutOfStep),
                    reply(1, 0),
                    thrown(2, Truncated),
                    reply(1, 0),
                    thrown(1, Field),
                    thrown(3, Field),
                    reply(1, 0),
                ][..],
            ),
            // A record right after another is in step.
            (&[1, 9, 1, 9], &[reply(1, 0), reply(1, 1)]),
            // A record may say two things.
            (
                &[7, 6, 1, 9],
                &[
                    thrown(1, OutOfStep),
                    Event::Message(STATE),
                    reply(6, 0),
                    reply(1, 1),
                ],
            ),
            // A protocol cannot wait for more than the window holds.
            (
                &[5, 1, 9, 1, 9, 1, 9],
                &[thrown(1, Length), reply(1, 0), reply(1, 1), reply(1, 1)],
            ),
            // Garbage is reported in parts.
            (&[0; 600], &[thrown(256, OutOfStep); 2]),
        ] {
            let mut stream = Stream::<6>::default();
            let mut events = Vec::new();
            stream.feed(bytes, ARRIVAL, &mut |event| events.push(event), step);
            assert_eq!(events, expected);
            let mut counts = Counts {
                bytes: bytes.len() as u64,
                ..Counts::default()
            };
            for event in &events {
                counts.note(event);
            }
            assert_eq!(stream.counts, counts);
        }
    }

    #[test]
    fn reset_counts_what_it_forgets() {
        let mut stream = Stream::<6>::default();
        stream.feed(&[8, 8, 4, 9, 9], ARRIVAL, &mut |_| (), step);
        stream.reset();
        assert_eq!(stream.counts.dropped_bytes, 5);
        assert_eq!(stream.counts.dropped_for(DropReason::Truncated), 1);
        let mut seen = Vec::new();
        stream.feed(&[9, 9, 1, 9], ARRIVAL, &mut |event| seen.push(event), step);
        assert_eq!(seen, [thrown(2, DropReason::OutOfStep), reply(1, 0)]);
    }
}
