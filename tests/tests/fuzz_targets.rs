//! The fuzz targets of `tests/fuzz` on their seeds and on these damaged: without an engine
//! that is guided by coverage, and with any compiler.

use crate::fuzzed::{run, seeds};
use shisen_tests::rays::Random;
use shisen_tests::sizes::cases;
use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

/// The targets. Each is a file and a program, whose names have underscores.
fn targets() -> BTreeSet<String> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/fuzz_targets");
    let target = |entry: fs::DirEntry| {
        let path = entry.path();
        let name = path.file_stem().expect("a name").to_string_lossy();
        let name = name.replace('_', "-");
        let text = fs::read_to_string(&path).expect("a target");
        assert!(text.contains(&format!("run(\"{name}\", bytes)")), "{text}");
        name
    };
    let entries = fs::read_dir(folder).expect("the folder of the targets");
    entries
        .map(|entry| target(entry.expect("a file")))
        .collect()
}

#[test]
fn each_target_is_a_program_and_most_have_a_seed() {
    let targets = targets();
    let manifest = include_str!("../fuzz/Cargo.toml");
    for name in &targets {
        let name = name.replace('-', "_");
        assert!(
            manifest.contains(&format!("path = \"fuzz_targets/{name}.rs\"")),
            "{name}"
        );
    }
    let mut without = targets.clone();
    for (name, seed) in seeds() {
        assert!(
            without.remove(name),
            "a seed for {name}, which is no target"
        );
        assert!(!seed.is_empty(), "{name}");
    }
    // What comes from a host, and lists of numbers, are short enough to be found.
    assert_eq!(Vec::from_iter(&without), ["device", "items"]);
}

#[test]
fn targets_hold_on_seeds_and_on_these_damaged() {
    let count = cases("damaged seeds of each fuzz target", 1_000, 20_000);
    let seeds = seeds();
    let mut random = Random::new(8);
    for target in targets() {
        let of_target = seeds.iter().find(|(name, _)| *name == target);
        // Where there is none, what others start from.
        let start = |random: &mut Random| match of_target {
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
    match random.below(5) {
        0 => bytes[at] ^= 1 << random.below(8),
        1 => bytes[at] = [0, 1, 0x7F, 0x80, 0xFF][random.below(5)],
        2 => bytes.truncate(at),
        3 => drop(bytes.drain(at..bytes.len().min(at + 1 + random.below(16)))),
        _ => {
            let piece = bytes[at..bytes.len().min(at + 1 + random.below(64))].to_vec();
            let to = random.below(bytes.len());
            bytes.splice(to..to, piece);
        }
    }
}
