//! What the decoders and the watch make of a line that is read at another speed
//! than the device sends at: level by level, as a UART would.

use crate::command::{Failure, Watch};
use crate::decoder::{Decoder, Event};
use crate::mock::{Source, Wire};
use crate::protocol::{Protocol, Reader};
use crate::testing::{assert_usable, serial_lines, tracker_at};
use crate::time::Micros;
use std::vec::Vec;

/// The speed that is listened at, in parts of the speed that is sent at.
const RATIOS: [(u64, u64); 8] = [
    (1, 4),
    (1, 3),
    (1, 2),
    (2, 3),
    (3, 2),
    (2, 1),
    (3, 1),
    (4, 1),
];

/// The levels of a line: a start bit, eight bits from the lowest, a stop bit.
struct Levels {
    bits: Vec<bool>,
    baud: u64,
}

impl Levels {
    /// Returns what the mock sends in some seconds, with or without pauses between its records.
    fn of(protocol: &Protocol, seconds: u64, pauses: bool) -> Self {
        let baud = 115_200;
        let mut wire = Wire::new(tracker_at(125, 6), protocol.clone());
        let mut bits = Vec::new();
        let until = (seconds * baud) as usize;
        while bits.len() < until {
            let Some(record) = wire.poll(Micros(u64::MAX / 2)) else {
                break;
            };
            if pauses {
                let start = (record.arrival.0 * baud / 1_000_000) as usize;
                bits.resize(bits.len().max(start), true);
            }
            for &byte in record.bytes() {
                bits.push(false);
                bits.extend((0..8).map(|bit| byte >> bit & 1 == 1));
                bits.push(true);
            }
        }
        bits.truncate(until);
        Self { bits, baud }
    }

    /// Returns what a UART reads at another speed, and when; a byte without a stop bit is kept, or
    /// becomes 0 as on Linux.
    fn read(&self, (listened, sent): (u64, u64), kept: bool) -> Vec<(Micros, u8)> {
        // In parts of a bit that both speeds have whole, and half, numbers of.
        let (bit, read_bit) = (2 * listened, 2 * sent);
        let end = self.bits.len() as u64 * bit;
        let level = |at: u64| self.bits.get((at / bit) as usize).copied().unwrap_or(true);
        let mut bytes = Vec::new();
        let mut at = 0;
        while at < end {
            // Edges are where bits begin.
            if level(at) || (at > 0 && !level(at - 1)) {
                at = (at / bit + 1) * bit;
                continue;
            }
            let sample = |i: u64| level(at + read_bit / 2 + i * read_bit);
            if sample(0) {
                // Too short for a start.
                at = (at / bit + 1) * bit;
                continue;
            }
            let byte = (0..8).fold(0, |byte, i| byte | u8::from(sample(1 + i)) << i);
            let stop = at + read_bit / 2 + 9 * read_bit;
            let time = Micros(stop * 1_000_000 / (bit * self.baud));
            bytes.push((time, if level(stop) || kept { byte } else { 0 }));
            at = stop;
        }
        bytes
    }
}

/// Returns what the watch says at last, and the samples.
fn listen(protocol: &Protocol, bytes: &[(Micros, u8)], until: Micros) -> (Option<Failure>, u64) {
    let mut reader = Reader::new(protocol).unwrap();
    let mut watch = Watch::new();
    let mut samples = 0;
    for &(time, byte) in bytes {
        watch.trouble(time);
        watch.on_bytes(1, time);
        reader.feed(&[byte], time, &mut |event| {
            watch.on_event(&event, time);
            if let Event::Sample(sample) = event {
                assert_usable(&sample);
                samples += 1;
            }
        });
    }
    (watch.trouble(until), samples)
}

/// The watch says that there are no records or, with false ones, that most belongs to none.
#[test]
fn a_wrong_speed_is_told_as_such() {
    let seconds = if cfg!(miri) { 1 } else { 5 };
    let end = Micros::from_millis(1_000 * seconds);
    for (name, protocol) in serial_lines() {
        for pauses in [true, false] {
            let levels = Levels::of(&protocol, seconds, pauses);
            let (verdict, samples) = listen(&protocol, &levels.read((1, 1), true), end);
            let reads = verdict.is_none() && samples > 80 * seconds;
            assert!(reads, "{name}: {verdict:?}");
            for (ratio, kept) in RATIOS.into_iter().flat_map(|r| [(r, true), (r, false)]) {
                let (verdict, samples) = listen(&protocol, &levels.read(ratio, kept), end);
                let case = std::format!("{name} {pauses} {ratio:?} {kept}: {samples}");
                match verdict {
                    Some(Failure::NoRecord { .. }) => (),
                    Some(Failure::Unlike { .. }) => assert!(samples > 0, "{case}"),
                    other => panic!("{case}, {other:?}"),
                }
                // These check too little.
                let may = matches!(protocol, Protocol::Flock(_) | Protocol::Asl(_));
                assert!(samples == 0 || may, "{case}");
            }
        }
    }
}
