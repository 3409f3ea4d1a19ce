//! Damaged streams of every tracker protocol, as the mock sends them and as
//! lines break them: no panic, no unusable number, every byte accounted for,
//! and the decoder back in step. What still comes through goes on to the clock
//! and the estimator, whose line of sight stays one.

use crate::fuzzed::line::{Line, records};
use proptest::prelude::*;
use proptest::sample::Index;
use shisen_tests::sizes::cases;

/// What can happen to a stream; the places are parts of its length.
#[derive(Debug, Clone)]
enum Damage {
    Flip(Index, u8),
    Set(Index, u8),
    Insert(Index, Vec<u8>),
    Cut(Index, usize),
    /// A piece of the stream itself, elsewhere.
    Splice(Index, Index, usize),
    /// A value that means much in one protocol or another, all over a piece.
    Fill(Index, usize, u8),
}

fn damage() -> impl Strategy<Value = Damage> {
    let telling = prop::sample::select(vec![
        0x00, 0x01, 0x10, 0x20, 0x30, 0x44, 0x55, 0x7F, 0x80, 0xAA, 0xFF,
    ]);
    let any_index = any::<Index>;
    prop_oneof![
        (any_index(), 1_u8..).prop_map(|(at, bits)| Damage::Flip(at, bits)),
        (any_index(), any::<u8>()).prop_map(|(at, byte)| Damage::Set(at, byte)),
        (any_index(), prop::collection::vec(any::<u8>(), 1..200))
            .prop_map(|(at, bytes)| Damage::Insert(at, bytes)),
        (any_index(), 1_usize..200).prop_map(|(at, count)| Damage::Cut(at, count)),
        (any_index(), any_index(), 1_usize..200)
            .prop_map(|(from, to, count)| Damage::Splice(from, to, count)),
        (any_index(), 1_usize..64, telling)
            .prop_map(|(at, count, byte)| Damage::Fill(at, count, byte)),
    ]
}

impl Damage {
    fn apply(&self, stream: &mut Vec<u8>) {
        let length = stream.len();
        if length == 0 {
            return;
        }
        let piece = |at: &Index, count: usize| {
            let at = at.index(length);
            at..length.min(at + count)
        };
        match self {
            Self::Flip(at, bits) => stream[at.index(length)] ^= bits,
            Self::Set(at, byte) => stream[at.index(length)] = *byte,
            Self::Insert(at, bytes) => {
                let at = at.index(length);
                stream.splice(at..at, bytes.iter().copied());
            }
            Self::Cut(at, count) => drop(stream.drain(piece(at, *count))),
            Self::Splice(from, to, count) => {
                let copy = stream[piece(from, *count)].to_vec();
                let to = to.index(length);
                stream.splice(to..to, copy);
            }
            Self::Fill(at, count, byte) => stream[piece(at, *count)].fill(*byte),
        }
    }
}

/// Streams of bytes; a HID device sends whole reports.
const STREAMS: [&str; 8] = [
    "link", "fastrak", "liberty", "flock", "hatire", "iscan", "asl", "adhawk",
];
const REPORTS: [&str; 2] = ["osvr-hdk", "hid"];
/// Intact records behind the damage, of which the first three may be lost, and
/// the last may wait for the one behind it.
const INTACT: usize = 8;

proptest! {
    #![proptest_config(ProptestConfig::with_cases(cases("tracker fuzz", 200, 2_000) as u32))]

    #[test]
    fn damaged_streams(
        seed in 1_u64..1_000,
        damages in prop::collection::vec(damage(), 1..8),
        sizes in prop::collection::vec(1_usize..100, 1..20),
    ) {
        for name in STREAMS {
            let records = records(name, seed, 12 + INTACT);
            let mut stream = records[..12].concat();
            for damage in &damages {
                damage.apply(&mut stream);
            }
            let mut line = Line::new(name);
            let mut rest = &stream[..];
            for &size in sizes.iter().cycle() {
                let (piece, behind) = rest.split_at(size.min(rest.len()));
                line.feed(piece);
                rest = behind;
                if rest.is_empty() {
                    break;
                }
            }
            let before = line.samples;
            for record in &records[12..] {
                line.feed(record);
            }
            line.finish(stream.len() + records[12..].concat().len());
            let found = line.samples - before;
            prop_assert!(found + 4 >= INTACT as u64, "{}: {} of {}", name, found, INTACT);
        }
    }

    #[test]
    fn damaged_reports(
        seed in 1_u64..1_000,
        damages in prop::collection::vec((0_usize..12, damage()), 1..8),
    ) {
        for name in REPORTS {
            let mut records = records(name, seed, 12 + INTACT);
            for (i, damage) in &damages {
                damage.apply(&mut records[*i]);
            }
            let mut line = Line::new(name);
            let mut before = 0;
            for (i, record) in records.iter().enumerate() {
                if i == 12 {
                    before = line.samples;
                }
                line.feed(record);
            }
            line.finish(records.concat().len());
            // The first may have the number of a damaged one.
            prop_assert!(line.samples - before + 1 >= INTACT as u64, "{}", name);
        }
    }
}
