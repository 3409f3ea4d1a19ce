use super::fields::*;
use super::messages::{EYE_EVENTS, SIDES};
use super::*;
use crate::decoder::{Control, ControlState, EyeEvent, MOST_MESSAGE_BYTES, Reply, Text};
use crate::protocol::Protocol;
use crate::sample::{Eye, GazeFrame, GazePoint, Head, Part, Parts, Pupil, Reading};
use crate::testing::{ARRIVAL, Random, dropped, events, hostile, mock_records, said, samples};
use crate::time::DeviceTime;
use glam::{Quat, Vec2, Vec3};
use proptest::prelude::*;
use std::vec::Vec as List;

fn unit_vector(random: &mut Random) -> Vec3 {
    let [x, y, z] = [(); 3].map(|()| random.unit() - 0.5);
    Vec3::new(x, y, z - 1.0).normalize()
}

/// Returns a sample that has each field or not, or all, tracked or not, by chance.
fn any_sample(random: &mut Random, all: bool) -> Sample {
    fn reading<T>(random: &mut Random, all: bool, value: T) -> Option<Reading<T>> {
        let tracked = random.next().is_multiple_of(2);
        let there = random.next().is_multiple_of(2) || all;
        there.then_some(Reading { value, tracked })
    }
    let maybe = |random: &mut Random| random.next().is_multiple_of(2) || all;
    let eye = |random: &mut Random| {
        let origin = Vec3::new(random.unit(), -random.unit(), -0.0);
        let direction = unit_vector(random);
        let size = random.unit();
        let pupil = [Pupil::Raw(size), Pupil::Diameter(size)];
        let pupil = pupil[usize::from(random.next().is_multiple_of(2))];
        Eye {
            origin: reading(random, all, origin),
            direction: reading(random, all, direction),
            pupil: maybe(random).then_some(pupil),
            openness: maybe(random).then_some(size),
        }
    };
    let (left, right, combined) = (eye(random), eye(random), eye(random));
    let microseconds = random.next();
    let time = if microseconds.is_multiple_of(3) && !all {
        DeviceTime::unwrapped(microseconds)
    } else {
        DeviceTime::micros_u32(microseconds as u32)
    };
    let axis = unit_vector(random);
    let point = Vec2::new(random.unit(), -3.0e8);
    let kinds = [GazePoint::Plane, GazePoint::Normalized, GazePoint::Raw];
    let point = kinds[(random.next() % 3) as usize](point);
    let frames = [GazeFrame::Head, GazeFrame::Tracker];
    Sample {
        device_time: maybe(random).then_some(time),
        sensor: random.next() as u8,
        sequence: maybe(random).then_some(random.next() as u32),
        head: Head {
            position: reading(random, all, axis * 1.7),
            orientation: reading(random, all, Quat::from_axis_angle(axis, 2.0)),
            angular_velocity: maybe(random).then_some(axis * -3.0),
        },
        gaze_frame: frames[usize::from(random.next().is_multiple_of(2))],
        left,
        right,
        combined,
        gaze_point: reading(random, all, point),
        ..Sample::arrived(ARRIVAL)
    }
}

/// Returns a sample with every field that there is.
fn full_sample() -> Sample {
    any_sample(&mut Random(7), true)
}

fn stream() -> List<List<u8>> {
    let mut random = Random(41);
    let mut encoder = Encoder::new();
    (0..20)
        .map(|_| encoder.sample(&any_sample(&mut random, false)).to_vec())
        .collect()
}

/// Written out by hand: version 1, kind 1, count 0; sequence 258, sensor 2.
#[test]
fn a_frame_has_the_documented_bytes() {
    let sample = Sample {
        sequence: Some(258),
        sensor: 2,
        ..Sample::arrived(ARRIVAL)
    };
    let content = [1, 1, 0, 4, 0, 0, 0, 0, 0, 0, 0, 2, 2, 1, 0, 0];
    let mut frame = Encoder::new().sample(&sample);
    let crc = 0xF7A4_u16;
    assert_eq!(
        frame,
        [
            0, 3, 1, 1, 2, 4, 1, 1, 1, 1, 1, 1, 4, 2, 2, 1, 1, 3, 0xA4, 0xF7, 0
        ]
    );
    assert_eq!(
        crc,
        crc::Crc::<u16>::new(&crc::CRC_16_IBM_3740).checksum(&content)
    );
    assert_eq!(samples(&mut Link::new(), &frame), [sample]);
    // The other delimiter is enough.
    frame.remove(0);
    assert_eq!(samples(&mut Link::new(), &frame), [sample]);
}

#[test]
fn the_longest_frame_is_the_stated_one() {
    let frame = Encoder::new().sample(&full_sample());
    assert_eq!(frame.len(), LONGEST_FRAME);
    assert_eq!(LONGEST_FRAME, 181);
    assert_eq!(samples(&mut Link::new(), &frame), [full_sample()]);
    let empty = Encoder::new().sample(&Sample::arrived(ARRIVAL));
    assert_eq!(empty.len(), 17);
}

#[test]
fn messages_survive_the_wire() {
    let time = Some(DeviceTime::millis_u32(9));
    let mut messages = List::from([
        Message::Text(Text::new(b"hello, there")),
        Message::Text(Text::new(&[b'x'; MOST_MESSAGE_BYTES])),
        Message::Text(Text::new(b"")),
        Message::Fault {
            code: 7,
            meaning: "",
        },
        Message::Unmeasured(Parts::NONE),
        Message::Unmeasured(Parts::NONE.with(Part::LeftPupil).with(Part::GazePoint)),
        Message::State {
            code: u32::MAX,
            meaning: "",
        },
        Message::Reply(Reply {
            to: 0x9C,
            result: 3,
            meaning: "",
        }),
    ]);
    for kind in EYE_EVENTS {
        for eye in SIDES {
            messages.push(Message::Eyes(EyeEvent {
                kind,
                eye,
                device_time: time.filter(|_| eye.is_some()),
                duration: eye.is_none().then_some(Micros(1 << 40)),
            }));
        }
    }
    for state in [ControlState::Button(true), ControlState::Axis(-0.25)] {
        for device_time in [time, None] {
            messages.push(Message::Control(Control {
                sensor: 33,
                number: 7,
                state,
                device_time,
            }));
        }
    }
    let mut encoder = Encoder::new();
    let mut decoder = Link::new();
    for message in messages {
        let frame = encoder.message(&message);
        assert_eq!(events(&mut decoder, &frame), [Event::Message(message)]);
    }
    assert_eq!(decoder.counts().lost, 0);
}

#[test]
fn commands_go_the_other_way() {
    let mut encoder = Encoder::new();
    let all = [Command::Start, Command::Rate { hertz: 500 }, Command::Stop];
    let mut bytes = List::from(*b"garbage");
    for command in all {
        bytes.extend(encoder.command(command));
        bytes.extend(encoder.sample(&full_sample()));
    }
    // No samples at all is not a rate.
    bytes.extend(encoder.command(Command::Rate { hertz: 0 }));
    let mut found = List::new();
    let mut commands = Commands::new();
    for byte in &bytes {
        commands.feed(&[*byte], &mut |command| found.push(command));
    }
    assert_eq!(found, all);
    let frame = encoder.command(Command::Start);
    assert_eq!(dropped(&mut Link::new(), &frame), [DropReason::Unknown]);
}

#[test]
fn it_is_started_and_stopped_by_commands() {
    for (script, expected) in [
        (start(None), &[Command::Start][..]),
        (
            start(Some(240)),
            &[Command::Rate { hertz: 240 }, Command::Start],
        ),
        (stop(), &[Command::Stop]),
    ] {
        let mut heard = List::new();
        let said = said(script).concat();
        Commands::new().feed(&said, &mut |command| heard.push(command));
        assert_eq!(heard, expected);
    }
}

#[test]
fn missing_and_repeated_frames_are_counted() {
    let mut encoder = Encoder::new();
    let mut decoder = Link::new();
    let frames: List<Frame> = (0..300).map(|_| encoder.sample(&full_sample())).collect();
    for (i, frame) in frames.iter().enumerate() {
        if (250..253).contains(&i) {
            continue;
        }
        assert_eq!(samples(&mut decoder, frame).len(), 1);
    }
    assert_eq!(decoder.counts().lost, 3);
    assert_eq!(dropped(&mut decoder, &frames[299]), [DropReason::Duplicate]);
    decoder.reset();
    assert_eq!(samples(&mut decoder, &frames[0]).len(), 1);
    assert_eq!(decoder.counts().lost, 3);
    assert_eq!(decoder.counts().samples, 298);
}

/// Returns a frame with any content, and a CRC that matches.
fn frame_of(content: &[u8]) -> Frame {
    let mut written = Content::new();
    written.push(content);
    written.finish()
}

#[test]
fn what_the_format_does_not_allow_is_refused() {
    let of = |content: &[u8]| dropped(&mut Link::new(), &frame_of(content));
    let sample = |valid: u32, tracked: u32, fields: &[f32]| {
        let mut content = List::from([VERSION, SAMPLE, 0]);
        content.extend(valid.to_le_bytes());
        content.extend(tracked.to_le_bytes());
        content.push(0);
        for field in fields {
            content.extend(field.to_le_bytes());
        }
        of(&content)
    };
    for (content, reason) in [
        (&[VERSION, SAMPLE][..], DropReason::Length),
        (&[VERSION + 1, SAMPLE, 0], DropReason::Unknown),
        (&[VERSION, 99, 0], DropReason::Unknown),
        (&[VERSION, SAMPLE, 0, 0], DropReason::Length),
        (&[VERSION, FAULT, 0, 1, 2, 3, 4, 5], DropReason::Length),
        (&[VERSION, EYES, 0, 7, 0, 0], DropReason::Field),
        (&[VERSION, EYES, 0, 0, 3, 0], DropReason::Field),
        (&[VERSION, EYES, 0, 0, 0, 2], DropReason::Field),
        (&[VERSION, EYES, 0, 0, 0, 8], DropReason::Field),
    ] {
        assert_eq!(of(content), [reason], "{content:?}");
    }
    assert_eq!(sample(0, 0, &[]), []);
    let kind = |kind: u32| kind << GAZE_POINT_KIND;
    for (valid, tracked, fields, reason) in [
        (0, 0, &[0.0][..], DropReason::Length),
        (POSITION, 0, &[0.0; 2], DropReason::Length),
        (1 << 25, 0, &[], DropReason::Field),
        (0, POSITION, &[], DropReason::Field),
        (SEQUENCE, SEQUENCE, &[1.0], DropReason::Field),
        (TIME_WRAPS, 0, &[], DropReason::Field),
        (RAW_PUPIL, 0, &[], DropReason::Field),
        (kind(1), 0, &[], DropReason::Field),
        (GAZE_POINT | kind(3), 0, &[1.0; 2], DropReason::Field),
        // The clock is past its end.
        (TIME | TIME_WRAPS, 0, &[1.0; 4], DropReason::Field),
        (ORIENTATION, 0, &[0.0; 4], DropReason::NotUnit),
        (DIRECTION, 0, &[0.0; 3], DropReason::NotUnit),
        (DIRECTION, 0, &[0.0, 0.9, 0.0], DropReason::NotUnit),
        (PUPIL, 0, &[-1.0], DropReason::OutOfRange),
        (OPENNESS, 0, &[1.1], DropReason::OutOfRange),
    ] {
        let found = sample(valid, tracked, fields);
        assert_eq!(found, [reason], "{valid:#x} {fields:?}");
    }
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        for (valid, numbers) in [
            (POSITION, 3),
            (ANGULAR_VELOCITY, 3),
            (ORIGIN, 3),
            (DIRECTION, 3),
            (PUPIL, 1),
            (OPENNESS, 1),
            (PUPIL | RAW_PUPIL, 1),
            (GAZE_POINT, 2),
            (ORIENTATION, 4),
        ] {
            let found = sample(valid, 0, &[bad; 4][..numbers]);
            assert_eq!(found, [DropReason::OutOfRange], "{valid:#x}");
        }
    }
}

#[test]
fn every_fault_costs_the_frames_it_touches() {
    let records = [stream(), mock_records(&Protocol::Link)];
    let tally = hostile(Link::new, &records, f64::exp2(-45.0));
    assert_eq!((tally.most_intact_lost, tally.wrong), (0, [0; 4]));
}

proptest! {
    #[test]
    fn samples_survive_the_wire(seed in 1_u64..) {
        let sample = any_sample(&mut Random(seed), false);
        let frame = Encoder::new().sample(&sample);
        let found = samples(&mut Link::new(), &frame);
        // As text, so that −0 is told from 0.
        prop_assert_eq!(std::format!("{:?}", found), std::format!("{:?}", [sample]));
    }
}
