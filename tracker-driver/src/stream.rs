//! What the decoders of unframed byte streams share: a window over the bytes
//! that may still become a record, and the account of those that did not.
//!
//! The protocol looks at the window after every byte and says what it makes
//! of its front. Nothing depends on how the stream was cut into pieces.

use crate::decoder::{Counts, DropReason, Dropped, Event, Message};
use crate::time::Micros;
use core::cell::Cell;

/// Report a dropped run once it reaches this many bytes, so that a line at the wrong speed is
/// not silent; a shorter one is reported when the next record has come.
const LONGEST_RUN: u32 = 256;

/// What a protocol makes of the front of the window.
#[derive(Debug, Clone, Copy, PartialEq)]
// An event is large, and cannot be boxed.
#[allow(clippy::large_enum_variant)]
pub(crate) enum Step {
    /// The beginning of a record, perhaps.
    More,
    /// A record of this many bytes.
    Take(usize, Event),
    /// A record of this many bytes that says something else first.
    TakeBoth(usize, Message, Event),
    /// A record of this many bytes that cannot be used: they are thrown away
    /// together.
    Discard(usize, DropReason),
    /// No record: the first byte is thrown away.
    Skip(DropReason),
}

/// What a protocol sees of the stream.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Front<'a> {
    /// The bytes that have not become anything yet; at least one.
    pub(crate) bytes: &'a [u8],
    /// The byte before the first one ended a record: this one should begin
    /// the next.
    pub(crate) in_step: bool,
}

impl Front<'_> {
    /// What looks like a record of this many bytes, but cannot be used. Out
    /// of step it may be none, and a true one may begin among its bytes.
    pub(crate) fn unusable(self, length: usize, reason: DropReason) -> Step {
        if self.in_step {
            Step::Discard(length, reason)
        } else {
            Step::Skip(reason)
        }
    }

    /// What looks like a record at first, and then does not.
    pub(crate) fn broken_off(self) -> Step {
        Step::Skip(if self.in_step {
            DropReason::Truncated
        } else {
            DropReason::OutOfStep
        })
    }
}

/// The arrival of the last byte of a whole record that waits for the bytes behind it, which
/// tell whether it is one.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Whole(Option<Micros>);

impl Whole {
    /// No record waits.
    pub(crate) const NONE: Self = Self(None);

    /// Asks `step` about a front of which `length` bytes would be the record, with the time
    /// when that came.
    pub(crate) fn ask(
        &mut self,
        front: Front<'_>,
        length: usize,
        arrival: Micros,
        step: impl FnOnce(Front<'_>, Micros) -> Step,
    ) -> Step {
        let arrival = self.0.unwrap_or(arrival);
        let step = step(front, arrival);
        let waits = matches!(step, Step::More) && front.bytes.len() >= length;
        self.0 = waits.then_some(arrival);
        step
    }
}

impl Step {
    /// A record of this many bytes that may say something else first.
    // It goes into the step by value.
    #[allow(clippy::large_types_passed_by_value)]
    pub(crate) fn take(length: usize, first: Option<Message>, event: Event) -> Self {
        match first {
            Some(first) => Self::TakeBoth(length, first, event),
            None => Self::Take(length, event),
        }
    }
}

/// The last bytes of a stream, `N` at most: as many as the protocol's longest
/// record, and what it looks at behind it.
#[derive(Debug, Clone)]
pub(crate) struct Stream<const N: usize> {
    bytes: [u8; N],
    length: usize,
    in_step: bool,
    /// Dropped bytes that are not reported yet.
    run: Option<Dropped>,
    /// The account of all bytes.
    pub(crate) counts: Counts,
}

impl<const N: usize> Default for Stream<N> {
    fn default() -> Self {
        Self {
            bytes: [0; N],
            length: 0,
            in_step: false,
            run: None,
            counts: Counts::default(),
        }
    }
}

impl<const N: usize> Stream<N> {
    /// Takes bytes and asks `step` about every new front.
    pub(crate) fn feed(
        &mut self,
        bytes: &[u8],
        sink: &mut dyn FnMut(Event),
        mut step: impl FnMut(Front<'_>) -> Step,
    ) {
        for &byte in bytes {
            self.counts.bytes = self.counts.bytes.saturating_add(1);
            if let Some(free) = self.bytes.get_mut(self.length) {
                *free = byte;
                self.length += 1;
            }
            let mut start = 0;
            while let Some(front) = self.bytes.get(start..self.length)
                && !front.is_empty()
            {
                let (in_step, full) = (self.in_step, front.len() == N);
                let front = Front {
                    bytes: front,
                    in_step,
                };
                let taken = match step(front) {
                    Step::More if !full => break,
                    // A protocol that asks for more than the window holds
                    // would stand still.
                    Step::More => self.skip(DropReason::Length, sink),
                    Step::Skip(reason) => self.skip(reason, sink),
                    Step::Take(taken, event) => {
                        self.hand_over(event, sink);
                        taken
                    }
                    Step::TakeBoth(taken, first, event) => {
                        self.hand_over(Event::Message(first), sink);
                        self.hand_over(event, sink);
                        taken
                    }
                    Step::Discard(taken, reason) => {
                        let bytes = taken as u32;
                        self.hand_over(Event::Dropped(Dropped { bytes, reason }), sink);
                        taken
                    }
                };
                start += taken.max(1);
            }
            if start > 0 {
                // Byte by byte: what moves ranges panics where they are wrong, and
                // compilers do not always see that these are not.
                let bytes = Cell::from_mut(&mut self.bytes[..]).as_slice_of_cells();
                let left = self.length.saturating_sub(start);
                for (to, from) in bytes.iter().zip(bytes.iter().skip(start)).take(left) {
                    to.set(from.get());
                }
                self.length = left;
            }
        }
    }

    #[allow(clippy::large_types_passed_by_value, reason = "it is handed on")]
    fn hand_over(&mut self, event: Event, sink: &mut dyn FnMut(Event)) {
        self.tell(sink);
        self.counts.note(&event);
        self.in_step = true;
        sink(event);
    }

    /// The first byte is none of a record.
    fn skip(&mut self, reason: DropReason, sink: &mut dyn FnMut(Event)) -> usize {
        self.in_step = false;
        self.throw_away(reason, sink);
        1
    }

    /// One byte more of the run. A cause of its own begins another run; bytes
    /// that merely belong to no record go with what came before them.
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

    /// Forgets what has come in; it counts as cut off.
    pub(crate) fn reset(&mut self) {
        self.tell(&mut |_| ());
        if self.length > 0 {
            self.counts.note(&Event::Dropped(Dropped {
                bytes: self.length as u32,
                reason: DropReason::Truncated,
            }));
        }
        self.length = 0;
        self.in_step = false;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::decoder::Reply;
    use std::vec::Vec;

    /// Records are a count and as many bytes of 9; 0xFF is a known evil.
    fn step(front: Front<'_>) -> Step {
        match *front.bytes {
            [0xFF, ..] => Step::Skip(DropReason::Field),
            [count @ 1..=4, ref rest @ ..] => {
                if rest.iter().take(usize::from(count)).any(|&b| b != 9) {
                    Step::Skip(DropReason::Truncated)
                } else if rest.len() < usize::from(count) {
                    Step::More
                } else {
                    let reply = Reply {
                        to: u32::from(count),
                        result: u32::from(front.in_step),
                        meaning: "",
                    };
                    Step::Take(
                        1 + usize::from(count),
                        Event::Message(Message::Reply(reply)),
                    )
                }
            }
            [5, ..] => Step::More,
            [6, ..] => {
                let state = Message::State {
                    code: 6,
                    meaning: "",
                };
                let reply = Reply {
                    to: 6,
                    result: 0,
                    meaning: "",
                };
                Step::TakeBoth(1, state, Event::Message(Message::Reply(reply)))
            }
            _ => Step::Skip(DropReason::OutOfStep),
        }
    }

    fn events(bytes: &[u8]) -> (Vec<Event>, Counts) {
        let mut stream = Stream::<6>::default();
        let mut events = Vec::new();
        stream.feed(bytes, &mut |event| events.push(event), step);
        (events, stream.counts)
    }

    fn dropped(bytes: u32, reason: DropReason) -> Event {
        Event::Dropped(Dropped { bytes, reason })
    }

    fn taken(to: u32, result: u32) -> Event {
        Event::Message(Message::Reply(Reply {
            to,
            result,
            meaning: "",
        }))
    }

    #[test]
    fn what_is_thrown_away_is_told_before_the_next_record() {
        let (events, counts) = events(&[7, 7, 1, 9, 2, 9, 1, 9, 0xFF, 0xFF, 0, 0, 1, 9]);
        assert_eq!(
            events,
            [
                dropped(2, DropReason::OutOfStep),
                taken(1, 0),
                dropped(2, DropReason::Truncated),
                taken(1, 0),
                dropped(1, DropReason::Field),
                dropped(3, DropReason::Field),
                taken(1, 0),
            ]
        );
        assert_eq!(counts.bytes, 14);
        assert_eq!(counts.dropped_bytes, 8);
        assert_eq!(counts.messages, 3);
    }

    #[test]
    fn a_record_right_after_another_is_in_step() {
        assert_eq!(events(&[1, 9, 1, 9]).0, [taken(1, 0), taken(1, 1)]);
    }

    #[test]
    fn a_record_may_say_two_things() {
        let (events, counts) = events(&[7, 6, 1, 9]);
        let state = Event::Message(Message::State {
            code: 6,
            meaning: "",
        });
        let expected = [
            dropped(1, DropReason::OutOfStep),
            state,
            taken(6, 0),
            taken(1, 1),
        ];
        assert_eq!(events, expected);
        assert_eq!(counts.messages, 3);
    }

    #[test]
    fn nothing_waits_for_more_than_the_window_holds() {
        let (events, counts) = events(&[5, 1, 9, 1, 9, 1, 9]);
        assert_eq!(
            events,
            [
                dropped(1, DropReason::Length),
                taken(1, 0),
                taken(1, 1),
                taken(1, 1)
            ]
        );
        assert_eq!(counts.dropped_for(DropReason::Length), 1);
    }

    #[test]
    fn garbage_is_told_of_in_parts() {
        let (events, _) = events(&[0; 600]);
        assert_eq!(events, [dropped(256, DropReason::OutOfStep); 2]);
    }

    #[test]
    fn reset_counts_what_it_forgets() {
        let mut stream = Stream::<6>::default();
        stream.feed(&[8, 8, 4, 9, 9], &mut |_| (), step);
        stream.reset();
        assert_eq!(stream.counts.dropped_bytes, 5);
        assert_eq!(stream.counts.dropped_for(DropReason::Truncated), 1);
        let mut seen = Vec::new();
        stream.feed(&[9, 9, 1, 9], &mut |event| seen.push(event), step);
        assert_eq!(seen, [dropped(2, DropReason::OutOfStep), taken(1, 0)]);
    }
}
