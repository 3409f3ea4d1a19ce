use super::*;
use crate::protocol::Protocol;
use crate::testing::{come_back, events, head_records, hostile, samples, thrown};

/// Code 7; 10.5, −3.25 and 1 degrees.
const VECTOR: [u8; 30] = [
    0xAA, 0xAA, 0x07, 0x00, 0x00, 0x00, 0x28, 0x41, 0x00, 0x00, 0x50, 0xC0, 0x00, 0x00, 0x80, 0x3F,
    0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0x55, 0x55,
];

fn big_endian() -> Config {
    Config {
        big_endian: true,
        translation: Translation::Centimetres,
        ..Config::default()
    }
}

#[test]
fn vector_decodes_to_its_values() {
    let config = Config::default();
    let frame = Frame {
        code: 7,
        rotation: [10.5, -3.25, 1.0],
        translation: [0.0; 3],
    };
    assert_eq!(config.decode(&VECTOR), Some(frame));
    assert_eq!(config.encode_frame(&frame), VECTOR);
    let found = samples(&mut Hatire::new(config), &VECTOR);
    assert_eq!(found[0].sequence, Some(7));
    assert_eq!(found[0].head.position, None);
    let front = found[0].head.orientation.unwrap().value * Vec3::NEG_Z;
    // To the right and a little down.
    assert!((front.x.atan2(-front.z).to_degrees() - 10.5).abs() < 1e-4);
    assert!((front.y.asin().to_degrees() + 3.25).abs() < 1e-4);
    // The same, highest byte first.
    let config = big_endian();
    let bytes = config.encode_frame(&frame);
    assert_eq!(bytes[2..8], [0x00, 0x07, 0x41, 0x28, 0x00, 0x00]);
    assert_eq!(config.decode(&bytes), Some(frame));
}

#[test]
fn order_and_signs_are_the_builders() {
    let config = Config {
        order: [1, 2, 0],
        reversed: [false, true, false],
        ..Config::default()
    };
    let frame = Frame {
        rotation: [0.0, 30.0, 20.0],
        ..Frame::default()
    };
    let found = samples(&mut Hatire::new(config), &config.encode_frame(&frame));
    let front = found[0].head.orientation.unwrap().value * Vec3::NEG_Z;
    assert!((front.x.atan2(-front.z).to_degrees() - 30.0).abs() < 1e-4);
    assert!((front.y.asin().to_degrees() + 20.0).abs() < 1e-4);
    let back = config.decode(&config.encode(&found[0])).unwrap();
    for (a, b) in back.rotation.into_iter().zip(frame.rotation) {
        assert!((a - b).abs() < 1e-4, "{back:?}");
    }
}

fn text(code: u16, text: &[u8]) -> [u8; 30] {
    let mut bytes = VECTOR;
    bytes[2..4].copy_from_slice(&code.to_le_bytes());
    bytes[4..28].fill(0);
    bytes[4..4 + text.len()].copy_from_slice(text);
    bytes
}

#[test]
fn text_and_errors_are_messages() {
    let stream = [
        text(5000, b"HAT START\n"),
        text(9007, b"ERROR CONNECT 7\n"),
        text(1500, b""),
        text(1000, b""),
        text(1001, b""),
        // The other byte order makes texts of most samples, but not of letters.
        text(5000, &[0x41, 0x20, 0x80, 0x00]),
    ]
    .concat();
    let found = events(&mut Hatire::new(Config::default()), &stream);
    let dropped = |reason| thrown(30, reason);
    let [
        Event::Message(Message::Text(first)),
        Event::Message(Message::Fault {
            code: 9007,
            meaning,
        }),
        Event::Message(Message::Text(second)),
        unknown,
        Event::Sample(_),
        beyond,
        no_letters,
    ] = found[..]
    else {
        panic!("{found:?}");
    };
    assert_eq!(first.as_str(), "HAT START");
    assert_eq!(second.as_str(), "ERROR CONNECT 7");
    assert_eq!(meaning, "the sensor is not connected");
    assert_eq!([unknown, beyond], [dropped(DropReason::Unknown); 2]);
    assert_eq!(no_letters, dropped(DropReason::Field));
}

#[test]
fn numbers_that_are_no_angles_are_dropped() {
    for value in [f32::NAN, f32::INFINITY, -361.0] {
        for at in [4, 8, 12] {
            let mut bytes = VECTOR;
            bytes[at..at + 4].copy_from_slice(&value.to_le_bytes());
            let dropped = thrown(30, DropReason::OutOfRange);
            let stream = [VECTOR, bytes].concat();
            let found = events(&mut Hatire::new(Config::default()), &stream);
            assert_eq!(found[1..], [dropped]);
        }
        // What is no position does not matter until it is said to be one.
        let frame = Frame {
            translation: [0.0, value * 1e3, 0.0],
            ..Frame::default()
        };
        let config = Config::default();
        let found = samples(&mut Hatire::new(config), &config.encode_frame(&frame));
        assert_eq!(found.len(), 1);
        let config = big_endian();
        assert!(samples(&mut Hatire::new(config), &config.encode_frame(&frame)).is_empty());
    }
}

#[test]
fn the_count_says_what_is_missing() {
    let mut decoder = Hatire::new(Config::default());
    let mut feed = |code: u16| {
        let mut bytes = VECTOR;
        bytes[2..4].copy_from_slice(&code.to_le_bytes());
        decoder.feed(&bytes, Micros(0), &mut |_| {});
        decoder.counts().lost
    };
    assert_eq!(
        [997, 998, 999, 0, 3, 253].map(&mut feed),
        [0, 0, 0, 0, 2, 2 + 249]
    );
    // The same again, one that stands still, a restart.
    assert_eq!([253, 253, 253, 0, 1].map(&mut feed), [251; 5]);
    decoder.reset();
    decoder.feed(&VECTOR, Micros(0), &mut |_| {});
    assert_eq!(decoder.counts().lost, 251);
}

#[test]
fn every_fault_costs_little() {
    for config in [Config::default(), big_endian()] {
        let encode = |sample: &Sample| config.encode(sample).to_vec();
        come_back(Hatire::new(config), encode, [1e-5, 4e-6]);
        let records = head_records(&Protocol::Hatire(config), encode);
        let found = hostile(|| Hatire::new(config), &records, 5e-13);
        found.assert_within("Hatire", [0.0, 0.73, 0.0, 0.0], 0);
    }
}
