//! What real peers sent: segments and datagrams, and what others made of them.

use crate::decoder::{Counts, Decoder, Event};
use crate::testing::{ARRIVAL, events};
use std::vec::Vec;

/// A segment or a datagram.
pub(super) struct Packet<'a> {
    pub(super) to_client: bool,
    pub(super) is_datagram: bool,
    pub(super) flow: u16,
    pub(super) bytes: &'a [u8],
}

/// Returns the packets of a capture: u8 `<` or `>`, u8 `T` or `U`, u16 flow, u32 microseconds, u32
/// length, bytes.
pub(super) fn packets(mut capture: &[u8]) -> Vec<Packet<'_>> {
    let mut packets = Vec::new();
    while let Some((head, rest)) = capture.split_first_chunk::<12>() {
        let length = u32::from_le_bytes(*head.last_chunk().unwrap()) as usize;
        let (bytes, rest) = rest.split_at(length);
        packets.push(Packet {
            to_client: head[0] == b'<',
            is_datagram: head[1] == b'U',
            flow: u16::from_le_bytes([head[2], head[3]]),
            bytes,
        });
        capture = rest;
    }
    packets
}

/// Returns the stream that a client received over TCP.
pub(super) fn stream(capture: &[u8]) -> Vec<u8> {
    let packets = packets(capture).into_iter();
    let received = packets.filter(|packet| packet.to_client && !packet.is_datagram);
    received.flat_map(|packet| packet.bytes.to_vec()).collect()
}

/// Returns the rows of a table, without its head, as their fields.
pub(super) fn rows(table: &str) -> Vec<Vec<&str>> {
    let rows = table.lines().skip(1);
    rows.map(|row| row.split(',').collect()).collect()
}

/// Returns a field's numbers, which blanks separate.
pub(super) fn numbers(field: &str) -> Vec<f64> {
    let numbers = field.split_whitespace();
    numbers.map(|number| number.parse().unwrap()).collect()
}

/// Returns a stream's events, which are the same in pieces of any size.
pub(super) fn in_pieces<D: Decoder>(new: impl Fn() -> D, stream: &[u8]) -> Vec<Event> {
    let whole = events(&mut new(), stream);
    for size in [1, 7, 64] {
        let mut decoder = new();
        let pieces = stream.chunks(size);
        let pieces: Vec<Event> = pieces.flat_map(|p| events(&mut decoder, p)).collect();
        assert_eq!(pieces, whole, "in pieces of {size}");
    }
    whole
}

/// Checks that a decoder's counts are those of its events.
pub(super) fn assert_counted(decoder: &impl Decoder, bytes: usize, events: &[Event]) {
    let mut counts = Counts {
        bytes: bytes as u64,
        lost: decoder.counts().lost,
        ..Counts::default()
    };
    for event in events {
        counts.note(event);
    }
    assert_eq!(*decoder.counts(), counts);
    assert!(counts.dropped_bytes <= counts.bytes);
}

/// Feeds a datagram with a fault at each byte between two intact ones, which must come through;
/// returns how many faults passed as another sample.
pub(super) fn faults<D: Decoder>(new: impl Fn() -> D, datagrams: &[&[u8]]) -> u32 {
    let mut wrong = 0;
    let [before, damaged, after] = datagrams else {
        panic!("three datagrams");
    };
    let intact = |decoder: &mut D, bytes| {
        let found = events(decoder, bytes);
        assert!(found.iter().any(|event| matches!(event, Event::Sample(_))));
        assert!(!found.iter().any(|event| matches!(event, Event::Dropped(_))));
    };
    let good = events(&mut new(), damaged);
    let step = if cfg!(miri) { 311 } else { 1 };
    for at in (0..damaged.len()).step_by(step) {
        for fault in 0..4 {
            let mut bytes = damaged.to_vec();
            match fault {
                0 => bytes.truncate(at),
                1 => drop(bytes.remove(at)),
                2 => bytes.insert(at, bytes[at]),
                _ => bytes[at] ^= 1 << (at % 8),
            }
            let mut decoder = new();
            intact(&mut decoder, before);
            let mut found = Vec::new();
            decoder.feed(&bytes, ARRIVAL, &mut |event| found.push(event));
            wrong += u32::from(found.iter().any(|event| {
                if let Event::Sample(sample) = event {
                    crate::testing::assert_usable(sample);
                }
                matches!(event, Event::Sample(_)) && !good.contains(event)
            }));
            let dropped = found.iter().any(|event| matches!(event, Event::Dropped(_)));
            assert!(!dropped || found.len() == 1, "{found:?}");
            intact(&mut decoder, after);
        }
    }
    wrong
}
