use super::*;
use crate::decoder::Message;
use crate::protocol::Protocol;
use crate::testing::{
    come_back, events, head_records, hostile, moving_head, reply, said, samples, thrown,
};
use std::vec::Vec as StdVec;

fn config(mode: Mode, group: bool) -> Config {
    Config {
        mode,
        group,
        ..Config::default()
    }
}

/// The manual's example: a position.
#[test]
fn example_decodes_to_its_words() {
    let record = [0xC8, 0x08, 0x51, 0x19, 0x59, 0x2A];
    assert_eq!(words(&record)[..4], [0x1120, 0x3344, 0x5564, 0]);
    let found = samples(&mut Flock::new(config(Mode::Position, false)), &record);
    let device = Vec3::new(4_384.0, 13_124.0, 21_860.0) * (36.0 * 0.0254 / 32_768.0);
    let position = found[0].head.position.unwrap().value;
    assert!(position.distance(Vec3::new(device.y, -device.z, -device.x)) < 1e-7);
    assert_eq!(found[0].head.orientation, None);
}

/// A quaternion that is none; with its last part 0 it is one.
#[test]
fn a_vector_without_a_turn_is_refused() {
    let mut vector = [
        0x80, 0x10, 0x00, 0x60, 0x27, 0x02, 0x7F, 0x3F, 0x00, 0x00, 0x00, 0x00, 0x00, 0x60,
    ];
    let config = config(Mode::PositionQuaternion, false);
    assert_eq!(words(&vector)[3..7], [32_764, 0, 0, -16_384]);
    let refused = thrown(14, DropReason::NotUnit);
    assert_eq!(events(&mut Flock::new(config), &vector), [refused]);
    vector[13] = 0;
    let found = samples(&mut Flock::new(config), &vector);
    assert_eq!(found[0].head.orientation.unwrap().value, Quat::IDENTITY);
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
    let matrix = |sine: f32| [0.0, sine, 0.0, -sine, 0.0, 0.0, 0.0, 0.0, 1.0];
    right(Mode::Matrix, true, &matrix(1.0));
    right(Mode::Matrix, false, &matrix(-1.0));
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
    let sent = moving_head(1)[0];
    let found = samples(&mut Flock::new(whole), &whole.encode(&sent));
    let turn = found[0].head.orientation.unwrap().value;
    assert!(turn.dot(sent.head.orientation.unwrap().value).abs() > 1.0 - 1e-6);
    // Half as large to a device of the usual scale.
    let [small, large] = [whole, usual].map(|config| words(&config.encode(&sent))[4]);
    assert!((2 * i32::from(small) - i32::from(large)).abs() <= 8);
    let said = |config: Config| said(config.start(1, 1, false)).concat();
    assert_eq!(said(usual), b"BFP\x23\x00YO\x0A@");
    assert_eq!(said(whole), b"BFP\x23\x00yO\x0A@");
}

#[test]
fn birds_of_a_group_are_sensors() {
    let config = config(Mode::PositionQuaternion, true);
    let mut sample = moving_head(1)[0];
    sample.sensor = 125;
    let found = samples(&mut Flock::new(config), &config.encode(&sample));
    assert_eq!(found[0].sensor, 125);
    for address in [0, 127] {
        let mut record = config.encode(&sample);
        record[14] = address;
        let refused = thrown(15, DropReason::Field);
        assert_eq!(events(&mut Flock::new(config), &record), [refused]);
    }
}

#[test]
fn a_record_that_breaks_off_is_truncated() {
    let config = config(Mode::PositionAngles, false);
    let record = config.encode(&moving_head(1)[0]);
    let stream = [&record[..5], &record, &[0x10, 0x20], &record].concat();
    let found = events(&mut Flock::new(config), &stream);
    assert_eq!(found[0], thrown(5, DropReason::Truncated));
    assert!(matches!(found[1], Event::Sample(_)));
    assert_eq!(found[2], thrown(2, DropReason::OutOfStep));
    assert!(matches!(found[3..], [Event::Sample(_)]));
}

#[test]
fn start_and_stop_say_what_the_guide_says() {
    let said = |script| said(script).concat();
    let alone = config(Mode::PositionQuaternion, false).start(1, 1, false);
    assert_eq!(said(alone), b"BFP\x23\x00]O\x0A@");
    let flock = config(Mode::PositionQuaternion, true).start(2, 2, true);
    let expected = [
        b'B', b'P', 50, 3, b'B', b'F', b'P', 35, 1, 0xF2, b']', 0xF3, b']', b'O', 10, b'@',
    ];
    assert_eq!(said(flock), expected);
    let most = config(Mode::PositionMatrix, true).start(255, 255, true);
    assert!(most.is_complete());
    assert_eq!(said(stop()), b"BG");
    assert_eq!(error_meaning(13), "a bird does not answer");
}

/// Returns each mode alone, and two in a group.
fn forms() -> impl Iterator<Item = Config> {
    let forms = Mode::ALL.into_iter().map(|mode| (mode, false));
    let forms = forms.chain([(Mode::Angles, true), (Mode::PositionQuaternion, true)]);
    // The interpreter takes minutes for all of them.
    let forms = forms.step_by(if cfg!(miri) { 5 } else { 1 });
    forms.map(|(mode, group)| config(mode, group))
}

#[test]
fn every_fault_costs_its_record_only() {
    for config in forms() {
        // The share of values that can be, and of wrong samples at once and confirmed.
        let (values, bounds) = match config.mode {
            Mode::Angles | Mode::Position | Mode::PositionAngles => {
                (1.0, [[0.0, 0.50, 0.50, 0.84], [0.0, 0.50, 0.09, 0.0]])
            }
            Mode::Quaternion | Mode::PositionQuaternion => {
                (0.025, [[0.0, 0.38, 0.09, 0.09], [0.0, 0.38, 0.05, 0.0]])
            }
            Mode::Matrix | Mode::PositionMatrix => (1e-9, [[0.0, 0.29, 0.03, 0.0]; 2]),
        };
        let share = 0.5_f64.powi(config.record_bytes() as i32) * values;
        let encode = |sample: &Sample| config.encode(sample).to_vec();
        for reversed in [true, false] {
            // Half a step on each of three axes.
            let config = Config { reversed, ..config };
            let encode = |sample: &Sample| config.encode(sample).to_vec();
            come_back(Flock::new(config), encode, [0.9144 / 8_192.0, 8e-4]);
        }
        let records = head_records(&Protocol::Flock(config), encode);
        for confirm in [false, true] {
            let config = Config { confirm, ..config };
            let at = usize::from(confirm);
            hostile(|| Flock::new(config), &records, share).assert_within("Flock", bounds[at], at);
        }
    }
}

/// What was not asked for, or comes too late, is garbage.
#[test]
fn answers_are_read_where_they_were_asked_for() {
    let config = Config::default();
    let record = config.encode(&moving_head(1)[0]);
    let reply = reply(b'O'.into(), 0);
    let fault = Event::Message(Message::Fault {
        code: 6,
        meaning: "a command that does not exist",
    });
    let state = Event::Message(Message::State {
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

/// Nor is an answer that was cut short; the record behind it is not touched.
#[test]
fn no_answer_is_invented() {
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
        let expected = thrown(noise.len() as u32, DropReason::OutOfStep);
        assert_eq!(heard[0], expected);
        assert!(
            matches!(heard[1..], [Event::Sample(_)]),
            "{question:?} {noise:?}: {heard:?}"
        );
    }
}
