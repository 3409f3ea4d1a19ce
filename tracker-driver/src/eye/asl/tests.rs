use super::*;
use crate::protocol::Protocol;
use crate::testing::{ARRIVAL, Random, dropped, hostile, mock_records, samples};
use std::vec::Vec as List;

/// Frame 33,023, pupil 496, gaze −5, 300.
const FRAME: [u8; 12] = [
    0x80, 0x00, 0x7F, 0x01, 0x70, 0x00, 0x7F, 0x56, 0x7B, 0x01, 0x2C, 0x01,
];

/// Returns the sample of one frame, which waits for the beginning of the next.
fn sample_of(mut decoder: Asl, frame: &[u8]) -> Sample {
    assert_eq!(samples(&mut decoder, frame), []);
    let [sample] = samples(&mut decoder, &[STATUS])[..] else {
        panic!("not one sample");
    };
    sample
}

fn base() -> Config {
    Config {
        layout: Layout::Base,
        ..Config::default()
    }
}

fn looking_at(number: u32, pupil: f32, x: f32, y: f32) -> Sample {
    Sample {
        sequence: Some(number),
        combined: Eye {
            pupil: Some(Pupil::Raw(pupil)),
            ..Eye::default()
        },
        gaze_point: Some(Reading::tracked(GazePoint::Raw(Vec2::new(x, y)))),
        ..Sample::arrived(ARRIVAL)
    }
}

/// Twenty frames around the wrap of a byte and of the count.
fn stream() -> List<List<u8>> {
    let mut random = Random(11);
    (0..20_u16)
        .map(|i| {
            let mut value = |range| (random.next() % range) as f32;
            let (pupil, x, y) = (1.0 + value(2_000), value(1_200) - 600.0, value(900) - 300.0);
            let number = 65_526_u16.wrapping_add(i);
            encode(
                &looking_at(u32::from(number), pupil, x, y),
                Layout::Numbered,
            )
            .to_vec()
        })
        .collect()
}

#[test]
fn a_frame_becomes_a_sample() {
    let expected = looking_at(33_023, 496.0, -5.0, 300.0);
    assert_eq!(sample_of(Asl::default(), &FRAME), expected);
    assert_eq!(encode(&expected, Layout::Numbered), FRAME);
}

/// Out of step a frame waits for the next, and keeps the time of its own last byte.
#[test]
fn the_first_frame_waits_for_the_next() {
    let mut decoder = Asl::default();
    let mut found = List::new();
    let mut feed = |bytes: &[u8], arrival| {
        decoder.feed(bytes, Micros(arrival), &mut |event| match event {
            Event::Sample(sample) => found.push(sample.arrival.0),
            _ => panic!("{event:?}"),
        });
        found.len()
    };
    assert_eq!(feed(&FRAME, 1), 0);
    assert_eq!(feed(&FRAME[..1], 2), 1);
    assert_eq!(feed(&FRAME[1..], 3), 2);
    assert_eq!(feed(&FRAME, 4), 3);
    assert_eq!(found, [1, 3, 4]);
    let other = [&FRAME[..], &[0x00], &FRAME, &FRAME].concat();
    let reason = DropReason::Length;
    assert_eq!(dropped(&mut Asl::default(), &other), [reason]);
}

#[test]
fn the_short_layout_has_no_frame_number() {
    let expected = Sample {
        sequence: None,
        ..looking_at(0, 496.0, -5.0, 300.0)
    };
    let frame = encode(&expected, Layout::Base);
    // Top bits: the fourth and fifth of the fields' bytes, and the last.
    assert_eq!(
        frame,
        [0x80, 0x01, 0x70, 0x00, 0x7F, 0x7B, 0x01, 0x34, 0x2C, 0x00]
    );
    assert_eq!(sample_of(Asl::new(base()), &frame), expected);
}

#[test]
fn an_eye_that_was_not_found_has_no_gaze() {
    let frame = encode(&looking_at(1, 0.0, 5.0, 6.0), Layout::Numbered);
    let found = sample_of(Asl::default(), &frame);
    let point = GazePoint::Raw(Vec2::new(5.0, 6.0));
    assert_eq!(found.gaze_point, Some(Reading::held(point)));
    assert_eq!(found.combined.pupil, None);
}

#[test]
fn damage_is_named() {
    let damaged = |offset: usize, byte: u8| {
        let mut frame = FRAME;
        frame[offset] = byte;
        dropped(
            &mut Asl::default(),
            &[FRAME, FRAME, frame, FRAME, FRAME].concat(),
        )
    };
    assert_eq!(damaged(0, 0x81), [DropReason::OutOfStep]);
    assert_eq!(damaged(0, 0x00), [DropReason::OutOfStep]);
    // The byte that is nothing, its top bit, and the last byte's free bits.
    assert_eq!(damaged(5, 1), [DropReason::Field]);
    assert_eq!(damaged(7, 0x76), [DropReason::Field]);
    assert_eq!(damaged(11, 0x09), [DropReason::Field]);
    assert_eq!(damaged(4, 0xF0), [DropReason::Truncated]);
    // A pupil below zero.
    assert_eq!(damaged(7, 0x5E), [DropReason::OutOfRange]);
    let cut = [&FRAME[..], &FRAME[..6], &FRAME, &FRAME].concat();
    assert_eq!(dropped(&mut Asl::default(), &cut), [DropReason::Truncated]);
}

#[test]
fn every_fault_costs_the_frames_it_touches() {
    let share = f64::exp2(-39.0);
    let mock = |config| mock_records(&Protocol::Asl(config));
    let found = hostile(Asl::default, &[stream(), mock(Config::default())], share);
    found.assert_within("ASL", [0.0, 0.35, 0.02, 0.03], 0);
    let short = hostile(|| Asl::new(base()), &[mock(base())], share);
    assert_eq!(short.most_intact_lost, 0);
}
