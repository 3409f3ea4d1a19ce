use super::super::polhemus::{Family, Format};
use super::*;
use crate::protocol::Protocol;
use crate::sample::Reading;
use crate::testing::{ARRIVAL, come_back, events, head_records, hostile, said, samples, thrown};
use glam::{Quat, Vec3};
use std::vec::Vec as StdVec;

fn config(format: Format, items: &[u8]) -> Config {
    Config::new(ItemList::new(Family::Fastrak, format, items).unwrap())
}

fn decoder(format: Format, items: &[u8]) -> Fastrak {
    Fastrak::new(config(format, items))
}

/// Station 1 at 1, 2, 3, not turned: the list 2, 11, 0.
const VECTOR: [u8; 32] = [
    0x30, 0x31, 0x20, 0x00, 0x00, 0x80, 0x3F, 0x00, 0x00, 0x00, 0x40, 0x00, 0x00, 0x40, 0x40, 0x00,
    0x00, 0x80, 0x3F, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x20,
];

#[test]
fn vector_decodes_to_its_values() {
    let only = |config: Config| {
        let events = events(&mut Fastrak::new(config), &VECTOR);
        let [Event::Sample(sample)] = events[..] else {
            panic!("{events:?}");
        };
        sample
    };
    let mut config = config(Format::Binary, &[2, 11, 0]);
    assert_eq!(config.record_bytes(), 32);
    let sample = only(config.clone());
    // 1 forward, 2 to the right, 3 down.
    let inches = Vec3::new(2.0, -3.0, -1.0);
    assert_eq!(
        sample.head.position,
        Some(Reading::tracked(inches * 0.0254))
    );
    assert_eq!(
        sample.head.orientation,
        Some(Reading::tracked(Quat::IDENTITY))
    );
    assert_eq!((sample.sensor, sample.arrival), (0, ARRIVAL));
    assert_eq!((sample.device_time, sample.sequence), (None, None));
    assert_eq!(config.encode(&sample).as_slice(), VECTOR);
    config.units = Units::Centimetres;
    let position = only(config.clone()).head.position.unwrap().value;
    assert!(position.distance(inches * 0.01) < 1e-8);
    config.axes = Axes::SAME;
    let position = only(config).head.position.unwrap().value;
    assert!(position.distance(Vec3::new(0.01, 0.02, 0.03)) < 1e-8);
}

#[test]
fn default_ascii_record_is_read() {
    let record = b"02    1.00 -12.50 100.25  90.00   0.00   0.00\r\n";
    let config = config(Format::Ascii, &[2, 4, 1]);
    assert_eq!((record.len(), config.record_bytes()), (47, 47));
    let samples = samples(&mut Fastrak::new(config), record);
    assert_eq!(samples.len(), 1);
    assert_eq!(samples[0].sensor, 1);
    let position = samples[0].head.position.unwrap().value;
    assert!(position.distance(Vec3::new(-12.5, -100.25, -1.0) * 0.0254) < 1e-6);
    // Azimuth 90 degrees is to the right.
    let turn = samples[0].head.orientation.unwrap().value;
    assert!((turn * Vec3::NEG_Z).distance(Vec3::X) < 1e-6);
}

/// The interpreter takes minutes for all of them.
const FEWER: usize = if cfg!(miri) { 6 } else { 1 };

/// Lists, how close a sample comes back (metres, radians), the share of random bytes that pass.
fn lists() -> [(Config, [f32; 2], f64); 9] {
    let binary = |items: &[u8]| config(Format::Binary, items);
    let ascii = |items: &[u8]| config(Format::Ascii, items);
    [
        (binary(&[2, 11, 0]), [1e-6, 1e-5], 5e-13),
        (binary(&[2, 4, 1]), [1e-6, 1e-5], 5e-12),
        (
            binary(&[52, 55, 56, 57, 16, 21, 22, 23, 0]),
            [1e-6, 1e-5],
            0.0,
        ),
        (binary(&[11, 1]), [0.0, 1e-5], 1e-10),
        (binary(&[18, 20]), [4e-4, 4e-4], 2e-9),
        (binary(&[18, 19]), [4e-4, 1e-3], 2e-7),
        (ascii(&[2, 4, 1]), [2.5e-4, 3e-4], 0.0),
        (ascii(&[2, 11, 16, 1]), [2.5e-4, 3e-4], 0.0),
        (ascii(&[52, 61, 66, 21, 22, 51]), [1e-5, 1e-4], 0.0),
    ]
}

#[test]
fn status_letters_are_faults_and_untracked() {
    let config = config(Format::Binary, &[2, 11, 0]);
    let record = |(status, station): (u8, u8)| {
        let mut record = VECTOR;
        (record[1], record[2]) = (station, status);
        record
    };
    let sent = [
        (b' ', b'1'),
        (b'j', b'1'),
        (b'j', b'1'),
        (b'j', b'2'),
        (b' ', b'1'),
        (b'Q', b'1'),
    ];
    let stream = sent.map(record).concat();
    let found = events(&mut Fastrak::new(config), &stream).into_iter();
    // What is said of each: whether it is tracked, or a fault.
    let said = found.map(|event| match event {
        Event::Sample(sample) => Ok(sample.head.position.unwrap().tracked),
        Event::Message(Message::Fault { code, meaning }) if !meaning.is_empty() => Err(code as u8),
        other => panic!("{other:?}"),
    });
    let (j, q) = (Err(b'j'), Err(b'Q'));
    let untracked = Ok(false);
    assert!(said.eq([
        Ok(true),
        j,
        untracked,
        untracked,
        j,
        untracked,
        Ok(true),
        q,
        untracked
    ]));
}

#[test]
fn answers_are_told_from_records() {
    let status = [&b"21S3F9107 F31  2.10  "[..], &[b'x'; 55 - 2 - 21], b"\r\n"].concat();
    let error = b"21E*ERROR*O*ERROR* EC-3*PS4*FL2*ST0\r\n";
    let stream = [&VECTOR[..], &status, &VECTOR, error, &VECTOR].concat();
    let usual = || decoder(Format::Binary, &[2, 11, 0]);
    let found = events(&mut usual(), &stream);
    let mut reader = usual();
    let pieces = stream.chunks(1).flat_map(|byte| events(&mut reader, byte));
    assert_eq!(pieces.collect::<StdVec<_>>(), found);
    let [
        Event::Sample(_),
        Event::Message(Message::Fault { code: 107, meaning }),
        Event::Message(Message::Text(text)),
        Event::Sample(_),
        Event::Message(Message::Reply(reply)),
        Event::Sample(_),
    ] = found[..]
    else {
        panic!("{found:?}");
    };
    assert_eq!(meaning, "signal low");
    assert!(text.as_str().starts_with("21S3F9107 F3"));
    assert_eq!((reply.to, reply.result), (b'O'.into(), 3));
    assert_eq!(reply.meaning, "a field is out of range");
}

#[test]
fn numbers_that_are_no_pose_are_dropped() {
    let with = |at: usize, value: f32| {
        let mut record = VECTOR;
        record[at..at + 4].copy_from_slice(&value.to_le_bytes());
        record
    };
    for (record, reason) in [
        (with(3, f32::NAN), DropReason::OutOfRange),
        (with(7, f32::INFINITY), DropReason::OutOfRange),
        (with(7, 1.0e6), DropReason::OutOfRange),
        (with(15, f32::NAN), DropReason::OutOfRange),
        (with(15, 0.0), DropReason::NotUnit),
        (with(19, 1.0), DropReason::NotUnit),
    ] {
        // In step, at once; out of step, when the next record comes.
        let dropped = thrown(32, reason);
        let stream = [VECTOR, record].concat();
        let found = events(&mut decoder(Format::Binary, &[2, 11, 0]), &stream);
        assert_eq!(found[1..], [dropped]);
        let stream = [&[0xFF][..], &record, &VECTOR].concat();
        let found = events(&mut decoder(Format::Binary, &[2, 11, 0]), &stream);
        assert!(found.contains(&dropped), "{found:?}");
        assert!(matches!(found.last(), Some(Event::Sample(_))));
    }
}

#[test]
fn stations_that_are_not_there_are_no_records() {
    let mut config = config(Format::Binary, &[2, 11, 0]);
    let mut record = VECTOR;
    record[1] = b'C';
    assert!(samples(&mut Fastrak::new(config.clone()), &record).is_empty());
    config.stations = 12;
    let found = samples(&mut Fastrak::new(config.clone()), &record);
    assert_eq!(found[0].sensor, 11);
    assert_eq!(config.encode(&found[0]).as_slice(), record);
}

#[test]
fn start_says_what_the_configuration_needs() {
    let mut config = config(Format::Binary, &[2, 11, 0]);
    config.stations = 2;
    config.units = Units::Centimetres;
    let script = config.start(true);
    assert_eq!(script.once_only_time(), config.reset_time);
    let expected: [&[u8]; 7] = [
        b"\x19",
        b"c",
        b"f",
        b"u",
        b"O1,2,11,0\r",
        b"O2,2,11,0\r",
        b"C",
    ];
    assert_eq!(said(script), expected);
}

#[test]
fn every_script_fits() {
    let items = [52, 54, 55, 56, 57, 61, 66, 50, 50, 51, 21, 51];
    let mut config = config(Format::Binary, &items);
    config.stations = MOST_STATIONS;
    assert!(config.start(true).is_complete());
    assert_eq!(change_speed(14_400), None);
    let expected: [&[u8]; 3] = [b"c", b"o1152,N,8,0\r", b"S"];
    assert_eq!(said(change_speed(115_200).unwrap()), expected);
}

#[test]
fn every_fault_costs_little() {
    for (config, off, share) in lists().into_iter().step_by(FEWER) {
        let encode = |sample: &Sample| config.encode(sample).to_vec();
        come_back(Fastrak::new(config.clone()), encode, off);
        let records = head_records(&Protocol::Fastrak(config.clone()), encode);
        let found = hostile(|| Fastrak::new(config.clone()), &records, share);
        let items: StdVec<u8> = config.items.numbers().collect();
        let (bounds, lost) = match (config.items.format(), &items[..]) {
            (_, [18, 19]) => ([0.81, 0.62, 0.54, 0.67], 1),
            (_, [18, 20]) => ([0.0, 0.52, 0.04, 0.05], 1),
            (Format::Ascii, _) => ([0.0, 0.03, 0.0, 0.0], 0),
            (Format::Binary, _) => ([0.0, 0.73, 0.0, 0.0], 0),
        };
        found.assert_within("FASTRAK", bounds, lost);
    }
}
