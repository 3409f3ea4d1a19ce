//! The fuzz targets of `tests/fuzz` on their seeds and on these damaged: without an engine
//! that is guided by coverage, and with any compiler.

use crate::fuzzed::{run, seeds, targets};
use shisen_tests::rays::Random;
use shisen_tests::sizes::cases;

#[test]
fn targets_hold_on_seeds_and_on_these_damaged() {
    let count = cases("damaged seeds of each fuzz target", 500, 2_000);
    let seeds = seeds();
    assert!(
        seeds
            .iter()
            .all(|(name, seed)| targets().any(|target| target == *name) && !seed.is_empty())
    );
    let mut random = Random::new(8);
    for target in targets() {
        let own = seeds.iter().find(|(name, _)| *name == target);
        // Those without a seed start from others'.
        let start = |random: &mut Random| match own {
            Some((_, seed)) => seed,
            None => &seeds[random.below(seeds.len())].1,
        };
        run(target, start(&mut random));
        run(target, &[]);
        for _ in 0..count {
            let mut bytes = start(&mut random).clone();
            for _ in 0..=random.below(4) {
                damage(&mut bytes, &mut random);
            }
            run(target, &bytes);
        }
    }
}

/// Bytes that mean much in one format or another.
const TELLING: [u8; 12] = [
    0x00, 0x01, 0x10, 0x20, 0x30, 0x44, 0x55, 0x7F, 0x80, 0xAA, 0xF0, 0xFF,
];

/// Makes one change of those that fuzzers make.
pub(crate) fn damage(bytes: &mut Vec<u8>, random: &mut Random) {
    if bytes.is_empty() {
        bytes.push(random.bits() as u8);
        return;
    }
    let at = random.below(bytes.len());
    let end = bytes.len().min(at + 1 + random.below(64));
    match random.below(8) {
        0 => bytes[at] ^= 1 << random.below(8),
        1 => bytes[at] = TELLING[random.below(TELLING.len())],
        2 => bytes.truncate(at),
        3 => drop(bytes.drain(at..bytes.len().min(at + 1 + random.below(16)))),
        4 => {
            let mut lines: Vec<&[u8]> = bytes.split(|&byte| byte == b'\n').collect();
            let [one, other] = [0; 2].map(|_| random.below(lines.len()));
            lines.swap(one, other);
            *bytes = lines.join(&b'\n');
        }
        5 => bytes[at..end].fill(TELLING[random.below(TELLING.len())]),
        6 => drop(bytes.splice(at..at, (at..end).map(|_| random.bits() as u8))),
        _ => {
            let piece = bytes[at..end].to_vec();
            let to = random.below(bytes.len());
            bytes.splice(to..to, piece);
        }
    }
}
