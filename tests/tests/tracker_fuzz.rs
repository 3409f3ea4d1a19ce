//! Damaged streams of every tracker protocol, as the mock sends them and as
//! lines break them: no panic, no unusable number, every byte accounted for,
//! and the decoder back in step. What still comes through goes on to the clock
//! and the estimator, whose line of sight stays one.

use crate::fuzz_targets::damage;
use crate::fuzzed::line::{Line, records};
use shisen_tests::rays::Random;
use shisen_tests::sizes::cases;

/// Streams of bytes; a HID device sends whole reports.
const STREAMS: [&str; 8] = [
    "link", "fastrak", "liberty", "flock", "hatire", "iscan", "asl", "adhawk",
];
const REPORTS: [&str; 2] = ["osvr-hdk", "hid"];
/// Intact records behind the damage, of which the first three may be lost, and
/// the last may wait for the one behind it.
const INTACT: usize = 8;

/// Records before these, some damages of which are done to each.
const DAMAGED: usize = 12;

/// Calls what is given with random numbers of a seed of their own, and a seed of the mock's.
fn each_case(mut run: impl FnMut(u64, &mut Random, u64)) {
    for seed in 0..cases("tracker fuzz", 200, 2_000) as u64 {
        let mut random = Random::new(seed);
        let mock = 1 + random.below(999) as u64;
        run(seed, &mut random, mock);
    }
}

#[test]
fn damaged_streams() {
    each_case(|seed, random, mock| {
        for name in STREAMS {
            let records = records(name, mock, DAMAGED + INTACT);
            let (damaged, intact) = records.split_at(DAMAGED);
            let mut stream = damaged.concat();
            for _ in 0..=random.below(7) {
                damage(&mut stream, random);
            }
            let mut line = Line::new(name);
            let mut rest = &stream[..];
            while !rest.is_empty() {
                let (piece, behind) = rest.split_at(rest.len().min(1 + random.below(99)));
                line.feed(piece);
                rest = behind;
            }
            let before = line.samples;
            for record in intact {
                line.feed(record);
            }
            line.finish(stream.len() + intact.concat().len());
            let found = line.samples - before;
            let what = format!("{name}, seed {seed}: {found} of {INTACT}");
            assert!(found + 4 >= INTACT as u64, "{what}");
        }
    });
}

#[test]
fn damaged_reports() {
    each_case(|seed, random, mock| {
        for name in REPORTS {
            let mut records = records(name, mock, DAMAGED + INTACT);
            for _ in 0..=random.below(7) {
                damage(&mut records[random.below(DAMAGED)], random);
            }
            let mut line = Line::new(name);
            let mut before = 0;
            for (i, record) in records.iter().enumerate() {
                if i == DAMAGED {
                    before = line.samples;
                }
                line.feed(record);
            }
            line.finish(records.concat().len());
            // The first may have the number of a damaged one.
            let found = line.samples - before;
            assert!(found + 1 >= INTACT as u64, "{name}, seed {seed}");
        }
    });
}
