use super::*;
use crate::command::{Action, Script, Session};
use crate::decoder::{Dropped, Message, Reply};
use crate::testing::{
    Fault, Tally, angle, any_split, events, every_fault_of_heads, moving_head, random_bytes,
    random_count, samples,
};
use std::vec::Vec as StdVec;

fn config(mode: Mode, group: bool) -> Config {
    Config {
        mode,
        group,
        ..Config::default()
    }
}

/// The manual's example.
#[test]
fn example_decodes_to_its_words() {
    let record = config(Mode::Position, false)
        .words(&[0xC8, 0x08, 0x51, 0x19, 0x59, 0x2A])
        .unwrap();
    assert_eq!(record.words[..4], [0x1120, 0x3344, 0x5564, 0]);
    assert_eq!(record.address, None);
    let found = samples(
        &mut Flock::new(config(Mode::Position, false)),
        &[0xC8, 0x08, 0x51, 0x19, 0x59, 0x2A],
    );
    let device = Vec3::new(4_384.0, 13_124.0, 21_860.0) * (36.0 * 0.0254 / 32_768.0);
    let position = found[0].head.position.unwrap().value;
    assert!(position.distance(Vec3::new(device.y, -device.z, -device.x)) < 1e-7);
    assert_eq!(found[0].head.orientation, None);
}

/// 9, −18 and 1.3 inches; a quaternion that is none.
#[test]
fn vector_decodes_to_its_words_and_is_refused() {
    let vector = [
        0x80, 0x10, 0x00, 0x60, 0x27, 0x02, 0x7F, 0x3F, 0x00, 0x00, 0x00, 0x00, 0x00, 0x60,
    ];
    let config = config(Mode::PositionQuaternion, false);
    let words = config.words(&vector).unwrap().words;
    assert_eq!(words[3..7], [32_764, 0, 0, -16_384]);
    let inches = [words[0], words[1], words[2]].map(|word| f32::from(word) * 36.0 / 32_768.0);
    assert_eq!(inches[..2], [9.0, -18.0]);
    assert!((inches[2] - 1.3).abs() < 36.0 / 8_192.0);
    let reason = DropReason::NotUnit;
    let dropped = Event::Dropped(Dropped { bytes: 14, reason });
    assert_eq!(events(&mut Flock::new(config), &vector), [dropped]);
    // With its last part 0 it is a pose.
    let mut record = vector;
    record[13] = 0;
    let found = samples(&mut Flock::new(config), &record);
    let position = found[0].head.position.unwrap().value;
    let expected = Vec3::new(inches[1], -inches[2], -inches[0]) * 0.0254;
    assert!(position.distance(expected) < 1e-7);
    assert_eq!(found[0].head.orientation.unwrap().value, Quat::IDENTITY);
}

#[test]
fn records_have_the_lengths_of_the_manual() {
    let bytes = Mode::ALL.map(|mode| config(mode, false).record_bytes());
    assert_eq!(bytes, [6, 6, 18, 8, 12, 24, 14]);
    assert_eq!(config(Mode::PositionQuaternion, true).record_bytes(), 15);
    assert_eq!(config(Mode::PositionAngles, true).record_bytes(), 13);
}

/// A bird that is turned to the right, in each form of the rotation.
#[test]
fn forms_of_a_rotation_agree() {
    let quarter = core::f32::consts::FRAC_1_SQRT_2;
    let encode = |parts: &[f32]| {
        let mut record: StdVec<u8> = parts
            .iter()
            .flat_map(|&part| to_seven_bits(nearest_word(part)))
            .collect();
        record[0] |= PHASE;
        record
    };
    let right = |mode: Mode, reversed: bool, parts: &[f32]| {
        let config = Config {
            reversed,
            ..config(mode, false)
        };
        let found = samples(&mut Flock::new(config), &encode(parts));
        let turn = found[0].head.orientation.unwrap().value;
        let front = turn * Vec3::NEG_Z;
        assert!(front.distance(Vec3::X) < 2e-3, "{mode:?} {front}");
    };
    // Azimuth, clockwise from above.
    right(Mode::Angles, true, &[0.5, 0.0, 0.0]);
    right(Mode::Quaternion, true, &[quarter, 0.0, 0.0, -quarter]);
    right(Mode::Quaternion, false, &[quarter, 0.0, 0.0, quarter]);
    // The bird's X axis is the transmitter's Y: the first row.
    right(
        Mode::Matrix,
        true,
        &[0.0, 1.0, 0.0, -1.0, 0.0, 0.0, 0.0, 0.0, 1.0],
    );
    right(
        Mode::Matrix,
        false,
        &[0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0],
    );
}

/// A device whose angles are scaled otherwise, and whose mode has another letter.
#[test]
fn letters_and_the_scale_of_angles_can_be_others() {
    let usual = config(Mode::PositionAngles, false);
    let whole = Config {
        half_turn: 360.0,
        letter: Some(b'y'),
        ..usual
    };
    for sent in moving_head(20) {
        let turn = |config: Config, record: &[u8]| {
            let found = samples(&mut Flock::new(config), record);
            found[0].head.orientation.unwrap().value
        };
        let truth = sent.head.orientation.unwrap().value;
        let record = whole.encode(&sent);
        assert!(angle(turn(whole, &record), truth) < 2e-3);
        assert!(angle(turn(usual, &usual.encode(&sent)), truth) < 1e-3);
        // Half as large to a device of the usual scale.
        let words = |config: Config| config.words(&config.encode(&sent)).unwrap().words;
        let (small, large) = (words(whole), words(usual));
        for (small, large) in small[3..6].iter().zip(&large[3..6]) {
            assert!((2 * i32::from(*small) - i32::from(*large)).abs() <= 8);
        }
    }
    let said = |config: Config| {
        let mut session = Session::new(config.start(1, 1, false));
        let (mut said, mut now) = (StdVec::new(), Micros(0));
        while said.last() != Some(&b'@') {
            match session.poll(now) {
                Action::Send(bytes) => said.extend_from_slice(bytes),
                Action::Wait(until) => now = until,
                other => panic!("{other:?}"),
            }
        }
        said
    };
    assert_eq!(said(usual), b"BFP\x23\x00YO\x0A@");
    assert_eq!(said(whole), b"BFP\x23\x00yO\x0A@");
}

#[test]
fn birds_of_a_group_are_sensors() {
    let config = config(Mode::PositionQuaternion, true);
    let mut sample = moving_head(1)[0];
    for sensor in [0, 1, 125] {
        sample.sensor = sensor;
        let record = config.encode(&sample);
        assert_eq!(record.len(), 15);
        let found = samples(&mut Flock::new(config), &record);
        assert_eq!(found[0].sensor, sensor);
    }
    for address in [0, 127] {
        let mut record = config.encode(&sample);
        record[14] = address;
        let reason = DropReason::Field;
        let dropped = Event::Dropped(Dropped { bytes: 15, reason });
        assert_eq!(events(&mut Flock::new(config), &record), [dropped]);
    }
}

#[test]
fn a_record_that_breaks_off_is_truncated() {
    let config = config(Mode::PositionAngles, false);
    let record = config.encode(&moving_head(1)[0]);
    let stream = [&record[..5], &record, &[0x10, 0x20], &record].concat();
    let found = events(&mut Flock::new(config), &stream);
    let dropped = |bytes, reason| Event::Dropped(Dropped { bytes, reason });
    assert_eq!(found[0], dropped(5, DropReason::Truncated));
    assert!(matches!(found[1], Event::Sample(_)));
    assert_eq!(found[2], dropped(2, DropReason::OutOfStep));
    assert!(matches!(found[3..], [Event::Sample(_)]));
}

#[test]
fn start_and_stop_say_what_the_guide_says() {
    let said = |script: Script| {
        assert!(script.is_complete());
        let mut session = Session::new(script);
        let mut now = Micros(0);
        let mut said = StdVec::new();
        loop {
            match session.poll(now) {
                Action::Send(bytes) => said.extend_from_slice(bytes),
                Action::Wait(until) if said.last() == Some(&b'@') => return (said, until),
                Action::Wait(until) => now = until,
                Action::Done => return (said, now),
                other => panic!("{other:?}"),
            }
        }
    };
    let alone = config(Mode::PositionQuaternion, false).start(1, 1, false);
    assert_eq!(said(alone).0, b"BFP\x23\x00]O\x0A@");
    let flock = config(Mode::PositionQuaternion, true).start(2, 2, true);
    let expected = [
        b'B', b'P', 50, 3, b'B', b'F', b'P', 35, 1, 0xF2, b']', 0xF3, b']', b'O', 10, b'@',
    ];
    assert_eq!(said(flock).0, expected);
    let most = config(Mode::PositionMatrix, true).start(255, 255, true);
    assert!(most.is_complete());
    assert_eq!(said(stop()).0, b"BG");
    assert_eq!(error_meaning(13), "a bird does not answer");
}

fn forms() -> impl Iterator<Item = Config> {
    let forms = Mode::ALL
        .into_iter()
        .flat_map(|mode| [(mode, false), (mode, true)]);
    // The interpreter takes minutes for all of them.
    let forms = forms.step_by(if cfg!(miri) { 9 } else { 1 });
    forms.map(|(mode, group)| config(mode, group))
}

fn records(config: &Config, count: usize) -> StdVec<StdVec<u8>> {
    let record = |sample| config.encode(sample).to_vec();
    moving_head(count).iter().map(record).collect()
}

#[test]
fn encoded_samples_come_back() {
    for config in forms() {
        for reversed in [true, false] {
            let config = Config { reversed, ..config };
            let sent = moving_head(if cfg!(miri) { 2 } else { 200 });
            let came = samples(
                &mut Flock::new(config),
                &records(&config, sent.len()).concat(),
            );
            assert_eq!(came.len(), sent.len());
            for (sent, came) in sent.iter().zip(&came) {
                if let Some(position) = came.head.position {
                    let off = position.value.distance(sent.head.position.unwrap().value);
                    // Half a step on each of three axes.
                    assert!(off < 0.9144 / 8_192.0, "{off}");
                }
                if let Some(turn) = came.head.orientation {
                    let off = angle(turn.value, sent.head.orientation.unwrap().value);
                    assert!(off < 8e-4, "{off} {:?}", config.mode);
                }
            }
        }
    }
}

/// The phase bit is all that guards a record's inside: no more may pass than it lets.
#[test]
fn every_fault_costs_its_record_only() {
    let docs = include_str!("../flock.rs");
    let share = |of: fn(&Fault) -> Option<bool>| {
        let low: StdVec<bool> = Fault::all().iter().filter_map(of).collect();
        low.iter().filter(|&&low| low).count() as f32 / low.len() as f32
    };
    // Of the bytes' changes, and of the foreign bytes, those that keep the bit clear.
    let unflipped = share(|fault| match fault {
        Fault::Flipped(bits) => Some(bits & PHASE == 0),
        _ => None,
    });
    let low = share(|fault| match fault {
        Fault::Inserted(byte) => Some(byte & PHASE == 0),
        _ => None,
    });
    for config in forms() {
        let group = if config.group { ", group" } else { "" };
        let name = std::format!("{:?}{group}", config.mode);
        let encode = |sample: &Sample| config.encode(sample).to_vec();
        let bytes = config.record_bytes() as f32;
        // Behind the start a low byte moves the rest; a high one is a start itself,
        // and in the true one's place right behind it.
        let behind = (bytes - 1.0) / bytes;
        let in_place = (1.0 - low) / bytes;
        let within = |found: &Tally, most: [f32; 4]| {
            for (rate, most) in found.rates().iter().zip(most) {
                assert!(*rate <= most + 1e-6, "{name}: {found:?}, {most}");
            }
        };
        let found = every_fault_of_heads(|| Flock::new(config), encode);
        found.assert_stated(&name, docs);
        assert_eq!(found.most_intact_lost, 0, "{name}");
        let inserted = low * behind + in_place;
        within(&found, [0.0, unflipped, inserted, (bytes - 2.0) / bytes]);
        let confirmed = Config {
            confirm: true,
            ..config
        };
        let found = every_fault_of_heads(|| Flock::new(confirmed), encode);
        found.assert_stated(&std::format!("{name}, confirmed"), docs);
        // A byte between two records costs the one before it.
        assert_eq!(found.most_intact_lost, 1, "{name}");
        within(&found, [0.0, unflipped, in_place, 0.0]);
    }
}

#[test]
fn a_stream_may_come_in_any_pieces() {
    for config in forms() {
        let mut stream = records(&config, if cfg!(miri) { 4 } else { 40 }).concat();
        stream[config.record_bytes() + 5] ^= 0xFF;
        stream.remove(2 * config.record_bytes() + 3);
        stream.extend_from_slice(&[0x10; 600][..if cfg!(miri) { 40 } else { 600 }]);
        any_split(|| Flock::new(config), &stream);
    }
}

#[test]
fn random_bytes_pass_as_often_as_stated() {
    for (seed, config) in forms().enumerate() {
        let fed = random_count(60_000_000);
        let passed = random_bytes(&mut Flock::new(config), fed, 40 + seed as u64);
        let values = match config.mode {
            Mode::Angles | Mode::Position | Mode::PositionAngles => 1.0,
            Mode::Quaternion | Mode::PositionQuaternion => 0.025,
            Mode::Matrix | Mode::PositionMatrix => 1e-9,
        };
        let stated = 0.5_f64.powi(config.record_bytes() as i32) * values;
        let rate = passed as f64 / fed as f64;
        std::println!(
            "{:?} {}: {passed} of {fed}: {rate:.2e}, stated {stated:.2e}",
            config.mode,
            config.group
        );
        let enough = stated * fed as f64;
        assert!(
            passed as f64 <= enough + 4.0 * enough.sqrt() + 1.0,
            "{passed} {enough}"
        );
    }
}

#[test]
fn a_confirmed_record_has_its_own_arrival() {
    let config = Config {
        confirm: true,
        ..Config::default()
    };
    let record = config.encode(&moving_head(1)[0]);
    let mut decoder = Flock::new(config);
    let mut found = StdVec::new();
    for start in [0, 50_000, 100_000] {
        for (n, byte) in (0..).zip(&record) {
            decoder.feed(&[*byte], Micros(start + n), &mut |event| match event {
                Event::Sample(sample) => found.push(sample.arrival),
                other => panic!("{other:?}"),
            });
        }
    }
    assert_eq!(found, [Micros(13), Micros(50_013)]);
}

/// What was asked for is no garbage, among records or without them; what was not asked
/// for, or comes too late, is.
#[test]
fn answers_are_read_where_they_were_asked_for() {
    let config = Config::default();
    let record = config.encode(&moving_head(1)[0]);
    let said = |message| Event::Message(message);
    let reply = said(Message::Reply(Reply {
        to: u32::from(b'O'),
        result: 0,
        meaning: "",
    }));
    let fault = said(Message::Fault {
        code: 6,
        meaning: "a command that does not exist",
    });
    let state = said(Message::State {
        code: 0xD011,
        meaning: "",
    });
    for (question, answer, expected) in [
        (&b"O\x00"[..], &[0x11, 0xD0][..], &[state, reply][..]),
        (b"BFO\x02", &[40, 0], &[reply]),
        // The parameter's value is no question.
        (b"P\x4F\x0AO\x0A", &[6], &[fault, reply]),
        (b"O\x0A", &[0], &[reply]),
        (b"O\x10", &[6, 1], &[fault, reply]),
    ] {
        let mut decoder = Flock::new(config);
        let mut heard = StdVec::new();
        let mut feed = |decoder: &mut Flock, bytes: &[u8], now| {
            decoder.feed(bytes, now, &mut |event| heard.push(event));
        };
        // A record is under way when the question is put, and one is before the answer.
        feed(&mut decoder, &record[..5], Micros(0));
        decoder.on_sent(question, Micros(0));
        feed(&mut decoder, &record[5..], Micros(10));
        feed(&mut decoder, &record, Micros(20));
        for byte in answer {
            feed(&mut decoder, &[*byte], Micros(30));
        }
        feed(&mut decoder, &record, Micros(40));
        assert_eq!(&heard[2..2 + expected.len()], expected);
        let samples = heard.iter().filter(|e| matches!(e, Event::Sample(_)));
        assert_eq!(samples.count(), 3, "{heard:?}");
        assert_eq!(decoder.counts().dropped_bytes, 0);
        // Nobody asked again, and then too long ago.
        decoder.feed(answer, Micros(50), &mut |_| {});
        decoder.on_sent(question, Micros(60));
        let late = Micros(61).after(PATIENCE);
        decoder.feed(answer, late, &mut |_| {});
        decoder.feed(&record, late, &mut |_| {});
        let dropped = decoder.counts().dropped_bytes;
        assert_eq!(dropped, 2 * answer.len() as u64, "{question:?}");
    }
    // As a record begins.
    let mut decoder = Flock::new(config);
    let mut heard = StdVec::new();
    decoder.on_sent(b"BO\x24", Micros(0));
    let units = [0xE0, 0xC0, 0xE0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0];
    decoder.feed(&units, Micros(1), &mut |event| heard.push(event));
    assert_eq!(heard, [reply]);
    assert_eq!(decoder.counts().dropped_bytes, 0);
}

/// Noise that cannot be the answer, and an answer that was cut short: neither is told as
/// one, and the record behind it is not touched.
#[test]
fn what_cannot_be_an_answer_is_none() {
    let config = Config::default();
    let record = config.encode(&moving_head(1)[0]);
    for (question, noise) in [
        (b"O\x0A", &[98][..]),
        (b"O\x0A", &[98, 5]),
        (b"O\x0A", &[36]),
        (b"O\x10", &[98, 0]),
        (b"O\x10", &[6]),
        (b"O\x02", &[40]),
        (b"O\x00", &[0x11]),
    ] {
        let mut decoder = Flock::new(config);
        decoder.on_sent(question, Micros(0));
        let mut heard = StdVec::new();
        let stream = [noise, &record].concat();
        decoder.feed(&stream, Micros(1), &mut |event| heard.push(event));
        let reason = DropReason::OutOfStep;
        let bytes = noise.len() as u32;
        assert_eq!(heard[0], Event::Dropped(Dropped { bytes, reason }));
        assert!(
            matches!(heard[1..], [Event::Sample(_)]),
            "{question:?} {noise:?}: {heard:?}"
        );
    }
}
