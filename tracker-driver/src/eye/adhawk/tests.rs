use super::fields::NOT_MEASURED;
use super::*;
use crate::protocol::Protocol;
use crate::sample::{Eye, GazePoint, Part, Pupil, Reading, Sample};
use crate::testing::{
    ARRIVAL, Random, dropped, events, hostile, mock_records, reply, samples, thrown,
};
use crate::time::DeviceTime;
use glam::{Quat, Vec2, Vec3};
use std::vec::Vec as List;

fn unit(random: &mut Random) -> Vec3 {
    let (x, y) = (random.unit() - 0.5, random.unit() - 0.5);
    Vec3::new(x, y, -1.0).normalize()
}

fn eye(random: &mut Random, x: f32) -> Eye {
    Eye {
        origin: Some(Reading::tracked(Vec3::new(x, -0.01, 0.02))),
        direction: Some(Reading::tracked(unit(random))),
        pupil: Some(Pupil::Diameter(0.002 + 0.004 * random.unit())),
        openness: None,
    }
}

fn sample(random: &mut Random, microseconds: u64) -> Sample {
    Sample {
        device_time: Some(DeviceTime::unwrapped(microseconds)),
        left: eye(random, -0.03),
        right: eye(random, 0.03),
        combined: Eye {
            direction: Some(Reading::tracked(unit(random))),
            ..Eye::default()
        },
        ..Sample::arrived(ARRIVAL)
    }
}

fn stream() -> List<List<u8>> {
    let mut random = Random(3);
    (0..20)
        .map(|i| {
            let sample = sample(&mut random, 1_000_000 + 5_000 * i);
            encode(&sample).unwrap().to_vec()
        })
        .collect()
}

fn near(a: Option<Reading<Vec3>>, b: Option<Reading<Vec3>>) {
    match (a, b) {
        (Some(a), Some(b)) => assert!(a.value.distance(b.value) < 1e-6, "{a:?} {b:?}"),
        _ => assert_eq!(a, b),
    }
}

/// Written out by hand from the layout.
#[test]
fn a_packet_becomes_a_sample() {
    let mut bytes = List::from([0xAA, 24, 0x80, 0x01]);
    bytes.extend(2_500_900_u64.to_le_bytes());
    bytes.extend([2, 2]);
    for number in [0.0_f32, 0.0, -2.0] {
        bytes.extend(number.to_le_bytes());
    }
    bytes[1] = (bytes.len() - 3) as u8;
    let found = samples(&mut AdHawk::new(), &bytes);
    assert_eq!(
        found,
        [Sample {
            device_time: Some(DeviceTime::unwrapped(2_500)),
            left: Eye {
                direction: Some(Reading::tracked(Vec3::NEG_Z)),
                ..Eye::default()
            },
            ..Sample::arrived(ARRIVAL)
        }]
    );
}

#[test]
fn every_field_has_its_place() {
    let packet = packet_of(&[
        (1, &[0.0, 3.0, 0.0, 0.1]),
        (4, &[30.0, 0.0, 1.0, -30.0, 0.0, 1.0]),
        (3, &[31.0, 0.0, 2.0, -31.0, 0.0, 2.0]),
        (5, &[3.0, 0.0]),
        (7, &[0.25, 1.5]),
        (8, &[0.0, 1.0, 0.0, 0.0]),
    ]);
    let found = samples(&mut AdHawk::new(), &packet);
    let [sample] = found[..] else {
        panic!("{found:?}");
    };
    let place = |x| Some(Reading::tracked(Vec3::new(x, 0.0, 0.002)));
    near(sample.combined.direction, Some(Reading::tracked(Vec3::Y)));
    near(sample.right.origin, place(0.031));
    near(sample.left.origin, place(-0.031));
    assert_eq!(sample.right.pupil, Some(Pupil::Diameter(0.003)));
    assert_eq!(sample.left.pupil, None);
    let point = GazePoint::Normalized(Vec2::new(0.25, 1.5));
    assert_eq!(sample.gaze_point, Some(Reading::tracked(point)));
    let turn = Quat::from_xyzw(0.0, 1.0, 0.0, 0.0);
    assert_eq!(sample.head.orientation, Some(Reading::tracked(turn)));
    let packet = encode(&sample).unwrap();
    assert_eq!(samples(&mut AdHawk::new(), &packet), [sample]);
}

/// Returns a packet of both eyes with these fields.
fn packet_of(fields: &[(u8, &[f32])]) -> List<u8> {
    let mut bytes = List::from([0xAA, 0, 0x80, 0x01]);
    bytes.extend(1_000_u64.to_le_bytes());
    bytes.push(3);
    for (field, numbers) in fields {
        bytes.push(*field);
        for number in *numbers {
            bytes.extend(number.to_le_bytes());
        }
    }
    bytes[1] = (bytes.len() - 3) as u8;
    bytes
}

/// A field, the numbers of it that are missing, the part that they are, and what becomes of it.
type Case<'c> = (
    usize,
    core::ops::Range<usize>,
    Part,
    &'c dyn Fn(&mut Sample),
);

/// One field of one eye without a value, and each other field.
#[test]
fn what_was_not_measured_is_said_and_leaves_the_rest() {
    let nan = f32::NAN;
    let fields: [(u8, &[f32]); 6] = [
        (1, &[0.0, 0.0, -1.0, nan]),
        (2, &[0.0, 0.0, -1.0, 0.0, 1.0, 0.0]),
        (3, &[30.0, 0.0, 1.0, -30.0, 0.0, 1.0]),
        (5, &[3.0, 4.0]),
        (7, &[0.25, 0.5]),
        (8, &[0.0, 1.0, 0.0, 0.0]),
    ];
    let whole = samples(&mut AdHawk::new(), &packet_of(&fields))[0];
    assert!(whole.right.direction.unwrap().tracked && whole.left.direction.unwrap().tracked);
    let ahead = Some(Reading::held(Vec3::NEG_Z));
    let corner = Some(Reading::held(GazePoint::Normalized(Vec2::ZERO)));
    let cases: [Case<'_>; 10] = [
        (0, 0..3, Part::CombinedDirection, &|s| {
            s.combined.direction = ahead;
        }),
        (1, 0..3, Part::RightDirection, &|s| {
            s.right.direction = ahead;
        }),
        (1, 3..6, Part::LeftDirection, &|s| s.left.direction = ahead),
        (1, 4..5, Part::LeftDirection, &|s| s.left.direction = ahead),
        (2, 0..3, Part::RightOrigin, &|s| s.right.origin = None),
        (2, 3..6, Part::LeftOrigin, &|s| s.left.origin = None),
        (3, 0..1, Part::RightPupil, &|s| s.right.pupil = None),
        (3, 1..2, Part::LeftPupil, &|s| s.left.pupil = None),
        (4, 0..2, Part::GazePoint, &|s| s.gaze_point = corner),
        (5, 0..4, Part::HeadOrientation, &|s| {
            s.head.orientation = None;
        }),
    ];
    for (at, missing, part, lose) in cases {
        let mut numbers = fields[at].1.to_vec();
        numbers[missing].fill(nan);
        let mut damaged = fields;
        damaged[at].1 = &numbers;
        let packet = packet_of(&damaged);
        let mut expected = whole;
        lose(&mut expected);
        // It is said when it begins and when it ends, not with each packet.
        let stream = [&packet[..], &packet, &packet_of(&fields)].concat();
        let said = |parts| Event::Message(Message::Unmeasured(parts));
        assert_eq!(
            events(&mut AdHawk::new(), &stream),
            [
                said(Parts::NONE.with(part)),
                Event::Sample(expected),
                Event::Sample(expected),
                said(Parts::NONE),
                Event::Sample(whole),
            ],
            "{part:?}"
        );
    }
}

#[test]
fn events_become_messages() {
    let time = Some(DeviceTime::unwrapped(1_500_000));
    let blink = EyeEvent {
        kind: EyeEventKind::Blink,
        eye: None,
        device_time: time,
        duration: Some(Micros(250_000)),
    };
    assert_eq!(
        encode_event(&blink),
        [0xAA, 10, 0x80, 0x18, 1, 0, 0, 0xC0, 0x3F, 0, 0, 0x80, 0x3E]
    );
    let found = events(&mut AdHawk::new(), &encode_event(&blink));
    assert_eq!(found, [Event::Message(Message::Eyes(blink))]);
    let (kind, eye) = (EyeEventKind::Lost, Some(Side::Left));
    let lost = EyeEvent {
        kind,
        eye,
        duration: None,
        ..blink
    };
    let mut bad = encode_event(&lost);
    *bad.last_mut().unwrap() = 2;
    bad.extend_from_slice(&encode_event(&blink)).unwrap();
    assert_eq!(dropped(&mut AdHawk::new(), &bad), [DropReason::Field]);
}

#[test]
fn requests_are_the_devices_bytes() {
    let (mask, enable) = (1 << 1 | 1 << 5, true);
    let fields = Request::Fields { mask, enable };
    let (mask, enable) = (0b111, false);
    let events = Request::Events { mask, enable };
    for (request, number, bytes) in [
        (
            Request::Tracking(true),
            0x0102,
            &[5, 0, 2, 1, 0x9C, 1, 1][..],
        ),
        (Request::Tracking(false), 3, &[5, 0, 3, 0, 0x9C, 1, 0]),
        (Request::Status, 0, &[3, 0, 0, 0, 0x90]),
        (fields, 0, &[9, 0, 0, 0, 0x9B, 14, 0x22, 0, 0, 0, 1]),
        (
            Request::Rate { hertz: 250.0 },
            0,
            &[8, 0, 0, 0, 0x9B, 13, 0, 0, 0x7A, 0x43],
        ),
        (events, 0, &[9, 0, 0, 0, 0x9B, 5, 7, 0, 0, 0, 0]),
    ] {
        assert_eq!(request.encode(number), [&[0xAA], bytes].concat()[..]);
    }
}

#[test]
fn responses_and_states_become_messages() {
    let response = encode_response(7, Request::Status.kind(), 3, &[]);
    let found = events(&mut AdHawk::new(), &response);
    assert_eq!(found, [Event::reply(0x90, 3, "tracker not ready")]);
    assert_eq!(result_name(3), "tracker not ready");

    // With data, and other streams, only right behind a packet.
    let long = [0xAA, 6, 0, 0, 0, 0x9A, 0, 5, 5];
    let ready = [0xAA, 2, 0x80, 0x02, 1];
    let status = [0xAA, 2, 0x80, 0x16, 15];
    let temperature = [0xAA, 3, 0x80, 0x22, 1, 2];
    let unknown = [&long[..], &ready].concat();
    let found = events(&mut AdHawk::new(), &unknown);
    // The second is told of later.
    assert!(matches!(found[..], [Event::Dropped(_)]), "{found:?}");
    let all = [&response, &long[..], &ready, &status, &temperature].concat();
    let found = events(&mut AdHawk::new(), &all);
    let state = |code, meaning| Event::Message(Message::State { code, meaning });
    assert_eq!(
        found[1..],
        [
            reply(0x9A, 0),
            state(2, "trackers ready"),
            state(15, "busy"),
            thrown(6, DropReason::Unknown),
        ]
    );
}

#[test]
fn damage_is_named() {
    let good = encode(&sample(&mut Random(9), 5)).unwrap();
    let damaged = |offset: usize, bytes: &[u8]| {
        let mut bad = good.to_vec();
        bad[offset..offset + bytes.len()].copy_from_slice(bytes);
        dropped(&mut AdHawk::new(), &[&bad[..], &good].concat())[0]
    };
    let field = OVERHEAD + EYES_OVERHEAD;
    for (offset, bytes, reason) in [
        (0, &[0][..], DropReason::OutOfStep),
        (1, &[0], DropReason::Length),
        (1, &[126], DropReason::Length),
        (2, &[0xC0], DropReason::Length),
        (3, &[0x55], DropReason::Unknown),
        (12, &[4], DropReason::Field),
        (field, &[9], DropReason::Field),
        (
            field + 1,
            &f32::INFINITY.to_le_bytes(),
            DropReason::OutOfRange,
        ),
        (field + 1, &1e30_f32.to_le_bytes(), DropReason::OutOfRange),
        (
            field + 1,
            &(NOT_MEASURED + 1).to_le_bytes(),
            DropReason::OutOfRange,
        ),
        (field + 1, &[0; 12], DropReason::NotUnit),
        // The same field twice.
        (field + 17, &[1], DropReason::Field),
    ] {
        assert_eq!(damaged(offset, bytes), reason, "{offset} {bytes:?}");
    }
}

#[test]
fn spi_frames_hold_packets() {
    let mut frame = [0; SPI_FRAME_LENGTH];
    assert_eq!(spi_packets(&frame), &[] as &[u8]);
    frame[..5].copy_from_slice(&[0xAA, 2, 0, 8, 9]);
    assert_eq!(spi_packets(&frame), [8, 9]);
    frame[2] = 4;
    assert_eq!(spi_packets(&frame), &[] as &[u8]);
}

#[test]
fn every_fault_is_over_within_three_packets() {
    let records = [stream(), mock_records(&Protocol::AdHawk)];
    let found = hostile(AdHawk::new, &records, f64::exp2(-36.0));
    found.assert_within("AdHawk", [0.0, 0.76, 0.02, 0.02], 1);
}
