use super::*;
use crate::protocol::Protocol;
use crate::testing::{ARRIVAL, Random, dropped, hostile, mock_records, samples};
use std::vec::Vec as List;

/// Pupil at 256.3, 120, 45.6 wide; point of regard 300, 0.1.
const RECORD: [u8; 12] = [
    0x44, 0x44, 0x03, 0x0A, 0xB0, 0x04, 0xC8, 0x01, 0xB8, 0x0B, 0x01, 0x00,
];

fn confirmed() -> Config {
    Config {
        confirm: true,
        ..Config::default()
    }
}

fn record(words: &[u16]) -> List<u8> {
    let words = words.iter().flat_map(|word| word.to_le_bytes());
    [0x44, 0x44].into_iter().chain(words).collect()
}

/// Twenty records of five outputs up to 512.
fn stream() -> List<List<u8>> {
    let mut random = Random(5);
    let mut word = || 1 + (random.next() % 5_120) as u16;
    (0..20)
        .map(|_| record(&[word(), word(), word(), word(), word()]))
        .collect()
}

#[test]
fn a_record_becomes_a_sample() {
    let mut decoder = Iscan::new(Config::default());
    // The first waits for the header behind it, the second for nothing.
    assert_eq!(samples(&mut decoder, &RECORD), []);
    let found = samples(&mut decoder, &RECORD);
    assert_eq!(found.len(), 2);
    assert_eq!(found[0], found[1]);
    assert_eq!(
        found[0],
        Sample {
            combined: Eye {
                pupil: Some(Pupil::Raw(45.6)),
                ..Eye::default()
            },
            gaze_point: Some(Reading::tracked(GazePoint::Raw(Vec2::new(300.0, 0.1)))),
            ..Sample::arrived(ARRIVAL)
        }
    );
    assert_eq!(decoder.counts().samples, 2);
    assert_eq!(decoder.counts().dropped_bytes, 0);
}

#[test]
fn outputs_are_found_by_their_place() {
    let outputs = Outputs::new(&[
        Output::Other,
        Output::PupilVertical,
        Output::PupilHorizontal,
    ])
    .unwrap();
    let mut decoder = Iscan::new(Config {
        outputs,
        ..Config::default()
    });
    let bytes = [record(&[9, 20, 30]), record(&[9, 20, 30])].concat();
    let found = samples(&mut decoder, &bytes);
    let point = GazePoint::Raw(Vec2::new(3.0, 2.0));
    assert_eq!(found[0].gaze_point, Some(Reading::tracked(point)));
    assert_eq!(found[0].combined, Eye::default());
}

#[test]
fn outputs_are_one_to_six() {
    let new = |found| Outputs::new(&List::from([Output::Other; 9])[..found]);
    assert!((1..=6).all(|count| new(count).is_ok()));
    for found in [0, 7] {
        assert_eq!(new(found), Err(OutputsError { found }));
    }
}

#[test]
fn an_eye_that_was_not_found_has_no_gaze() {
    for (words, zero_is_lost, gaze, pupil) in [
        ([10, 10, 5, 0, 0], true, false, false),
        ([0, 0, 5, 10, 10], true, false, false),
        ([10, 10, 0, 10, 10], true, true, false),
        ([10, 0, 5, 0, 10], true, true, true),
        ([0; 5], false, true, false),
    ] {
        let config = Config {
            zero_is_lost,
            ..Config::default()
        };
        let bytes = record(&words).repeat(2);
        let found = samples(&mut Iscan::new(config), &bytes);
        assert_eq!(found[0].gaze_point.unwrap().tracked, gaze, "{words:?}");
        assert_eq!(found[0].combined.pupil.is_some(), pupil, "{words:?}");
    }
}

#[test]
fn damage_is_named() {
    let damaged = |largest_word, first: &[u16]| {
        let mut decoder = Iscan::new(Config {
            largest_word,
            ..Config::default()
        });
        assert_eq!(dropped(&mut decoder, &record(first)), []);
        // Reported with the next record.
        dropped(&mut decoder, &record(&[1; 5]).repeat(2))
    };
    for (largest_word, words, reason) in [
        (LARGEST_WORD, &[1, 2, 0x4400, 3, 4][..], DropReason::Field),
        (LARGEST_WORD, &[1, 2], DropReason::Truncated),
        (LARGEST_WORD, &[1, 2, 3, 4, 5, 6], DropReason::Length),
        (100, &[1, 101, 3, 4, 5], DropReason::Field),
    ] {
        assert_eq!(damaged(largest_word, words), [reason]);
    }
}

#[test]
fn every_fault_is_over_within_three_records() {
    let mock = mock_records(&Protocol::Iscan(Config::default()));
    let records = [stream(), mock];
    for (config, bounds, lost) in [
        (Config::default(), [0.0, 0.32, 0.09, 0.10], 0),
        (confirmed(), [0.0, 0.32, 0.0, 0.0], 1),
    ] {
        let found = hostile(|| Iscan::new(config), &records, 3.0e-13);
        found.assert_within("ISCAN", bounds, lost);
    }
}

#[test]
fn outputs_of_another_number_are_counted() {
    let of = |count: usize| Config {
        outputs: Outputs::new(&[Output::GazeHorizontal; MOST_OUTPUTS][..count]).unwrap(),
        ..Config::default()
    };
    let mut seen = Sample::arrived(Micros(0));
    // 0x0344 in tenths: half a header in every word.
    let point = GazePoint::Raw(Vec2::splat(83.6));
    seen.gaze_point = Some(Reading::tracked(point));
    for told in 1..=MOST_OUTPUTS {
        for sent in 1..=MOST_OUTPUTS {
            let mut decoder = Iscan::new(of(told));
            for _ in 0..3 {
                decoder.feed(&encode(&seen, &of(sent)), Micros(0), &mut |_| {});
            }
            let found = decoder.fields_seen();
            assert_eq!(found, (told != sent).then_some(sent), "{told} {sent}");
            assert_eq!(decoder.counts().samples > 0, told == sent);
            decoder.reset();
            assert_eq!(decoder.fields_seen(), None);
        }
    }
}
