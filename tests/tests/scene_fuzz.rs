//! Damaged scene files: each is refused with a word why, or gives pixels that
//! are numbers.

use crate::fuzzed::scenes;
use proptest::prelude::*;
use proptest::sample::Index;
use shisen_tests::sizes::cases;

/// A little of everything that a scene file can say.
const SCENE: &str = include_str!("../fuzz/src/scene.toml");

/// What a number is replaced by.
const NUMBERS: [&str; 18] = [
    "nan",
    "-nan",
    "inf",
    "-inf",
    "1e999",
    "-1e999",
    "0",
    "-0.0",
    "1e-320",
    "1e-45",
    "1e-6",
    "1e6",
    "1e18",
    "-1e30",
    "3.5e38",
    "9223372036854775807",
    "0x7f",
    "\"1\"",
];

#[derive(Debug, Clone)]
enum Damage {
    Truncate(Index),
    Flip(Index, u8),
    DeleteLine(Index),
    RepeatLine(Index),
    SwapLines(Index, Index),
    Number(Index, &'static str),
}

fn damage() -> impl Strategy<Value = Damage> {
    let place = any::<Index>;
    let number = || prop::sample::select(NUMBERS.to_vec());
    prop_oneof![
        1 => place().prop_map(Damage::Truncate),
        2 => (place(), 0..7u8).prop_map(|(at, bit)| Damage::Flip(at, bit)),
        2 => place().prop_map(Damage::DeleteLine),
        1 => place().prop_map(Damage::RepeatLine),
        1 => (place(), place()).prop_map(|(a, b)| Damage::SwapLines(a, b)),
        6 => (place(), number()).prop_map(|(at, number)| Damage::Number(at, number)),
    ]
}

/// Where the numbers of a text are.
fn numbers(text: &str) -> Vec<(usize, usize)> {
    let part = |c: char| c.is_ascii_digit() || matches!(c, '.' | '-');
    let mut found = Vec::new();
    let mut start = None;
    for (at, c) in text.char_indices().chain([(text.len(), '\n')]) {
        match start {
            None if part(c) => start = Some(at),
            Some(from) if !part(c) => {
                found.push((from, at));
                start = None;
            }
            _ => {}
        }
    }
    found
}

fn apply(damage: &Damage, text: &mut String) {
    if text.is_empty() {
        return;
    }
    let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
    match damage {
        Damage::Truncate(at) => text.truncate(at.index(text.len())),
        Damage::Flip(at, bit) => {
            let mut bytes = text.clone().into_bytes();
            bytes[at.index(text.len())] ^= 1 << bit;
            *text = String::from_utf8(bytes).expect("ASCII, but for its highest bit");
        }
        Damage::DeleteLine(at) => {
            lines.remove(at.index(lines.len()));
            *text = lines.join("\n");
        }
        Damage::RepeatLine(at) => {
            let line = lines[at.index(lines.len())].clone();
            lines.push(line);
            *text = lines.join("\n");
        }
        Damage::SwapLines(a, b) => {
            let (a, b) = (a.index(lines.len()), b.index(lines.len()));
            lines.swap(a, b);
            *text = lines.join("\n");
        }
        Damage::Number(at, number) => {
            let places = numbers(text);
            if !places.is_empty() {
                let (from, to) = places[at.index(places.len())];
                text.replace_range(from..to, number);
            }
        }
    }
}

#[test]
fn damaged_scene_files_are_refused_or_seen() {
    let count = cases("damaged scene files", 2_000, 20_000);
    let mut config = ProptestConfig::with_cases(count as u32);
    config.failure_persistence = None;
    let damages = prop::collection::vec(damage(), 1..4);
    let mut runner = proptest::test_runner::TestRunner::new(config);
    let outcome = runner.run(&damages, |damages| {
        let mut text = SCENE.to_owned();
        for damage in &damages {
            apply(damage, &mut text);
        }
        scenes::file(&text);
        Ok(())
    });
    outcome.unwrap_or_else(|error| panic!("{error}"));
}

/// Every number alone, by every other: as many are refused as are taken.
#[test]
fn every_number_of_a_scene_file_replaced() {
    assert!(scenes::file(SCENE), "the whole one");
    let (mut taken, mut refused) = (0, 0);
    for (from, to) in numbers(SCENE) {
        for number in NUMBERS {
            let mut text = SCENE.to_owned();
            text.replace_range(from..to, number);
            let is_scene = scenes::file(&text);
            assert!(
                !(is_scene
                    && matches!(number, "nan" | "-nan" | "inf" | "-inf" | "1e999" | "-1e999")),
                "{number} for byte {from} of the scene file was taken"
            );
            *(if is_scene { &mut taken } else { &mut refused }) += 1;
        }
    }
    assert!(
        taken > 200 && refused > 200,
        "{taken} taken, {refused} refused"
    );
}
