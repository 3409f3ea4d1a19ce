//! The fuzz targets of `tests/fuzz` on their seeds and on these damaged: without an engine
//! that is guided by coverage, and with any compiler.

use crate::fuzzed::{run, seeds};
use shisen_tests::rays::Random;
use shisen_tests::sizes::cases;
use std::fs;
use std::path::Path;

/// The targets. Each is a file of that name, with underscores.
fn targets() -> Vec<String> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/fuzz_targets");
    let entries = fs::read_dir(folder).expect("the folder of the targets");
    let name = |entry: std::io::Result<fs::DirEntry>| {
        let path = entry.expect("a file").path();
        let name = path.file_stem().expect("a name").to_string_lossy();
        name.replace('_', "-")
    };
    let mut targets: Vec<String> = entries.map(name).collect();
    targets.sort();
    targets
}

#[test]
fn targets_hold_on_seeds_and_on_these_damaged() {
    let count = cases("damaged seeds of each fuzz target", 500, 2_000);
    let seeds = seeds();
    let targets = targets();
    assert!(
        seeds
            .iter()
            .all(|(name, seed)| targets.contains(&(*name).to_owned()) && !seed.is_empty())
    );
    let mut random = Random::new(8);
    for target in targets {
        let own = seeds.iter().find(|(name, _)| *name == target);
        // Those without a seed start from others'.
        let start = |random: &mut Random| match own {
            Some((_, seed)) => seed,
            None => &seeds[random.below(seeds.len())].1,
        };
        run(&target, start(&mut random));
        run(&target, &[]);
        for _ in 0..count {
            let mut bytes = start(&mut random).clone();
            for _ in 0..=random.below(4) {
                damage(&mut bytes, &mut random);
            }
            run(&target, &bytes);
        }
    }
}

/// One change of those that fuzzers make.
fn damage(bytes: &mut Vec<u8>, random: &mut Random) {
    if bytes.is_empty() {
        bytes.push(random.bits() as u8);
        return;
    }
    let at = random.below(bytes.len());
    match random.below(6) {
        0 => bytes[at] ^= 1 << random.below(8),
        1 => bytes[at] = [0, 1, 0x7F, 0x80, 0xFF][random.below(5)],
        2 => bytes.truncate(at),
        3 => drop(bytes.drain(at..bytes.len().min(at + 1 + random.below(16)))),
        4 => {
            let mut lines: Vec<&[u8]> = bytes.split(|&byte| byte == b'\n').collect();
            let [one, other] = [0; 2].map(|_| random.below(lines.len()));
            lines.swap(one, other);
            *bytes = lines.join(&b'\n');
        }
        _ => {
            let piece = bytes[at..bytes.len().min(at + 1 + random.below(64))].to_vec();
            let to = random.below(bytes.len());
            bytes.splice(to..to, piece);
        }
    }
}
