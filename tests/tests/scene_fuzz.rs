//! Scene files with other numbers: each is refused with a word why, or gives pixels that are
//! numbers. Other damage is done to them by `fuzz_targets`.

use crate::fuzzed::scenes;

/// A little of everything that a scene file can say.
const SCENE: &str = include_str!("../fuzz/src/scene.toml");

/// What a number is replaced by: at first six that are not finite.
const NUMBERS: &str = "nan -nan inf -inf 1e999 -1e999 0 -0.0 1e-320 1e-45 1e-6 1e6 1e18 -1e30 3.5e38 \
                       9223372036854775807 0x7f \"1\"";

/// Returns where the numbers of a text are.
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

/// Every number alone, by every other: as many are refused as are taken.
#[test]
fn every_number_of_a_scene_file_replaced() {
    assert!(scenes::file(SCENE), "the whole one");
    let (mut taken, mut refused) = (0, 0);
    for (from, to) in numbers(SCENE) {
        for (place, number) in NUMBERS.split(' ').enumerate() {
            let mut text = SCENE.to_owned();
            text.replace_range(from..to, number);
            let is_scene = scenes::file(&text);
            let is_finite = place >= 6;
            assert!(!is_scene || is_finite, "{number} for byte {from} was taken");
            *(if is_scene { &mut taken } else { &mut refused }) += 1;
        }
    }
    assert!(
        taken > 200 && refused > 200,
        "{taken} taken, {refused} refused"
    );
}
