use super::super::polhemus::{Family, Format};
use super::*;
use crate::decoder::Message;
use crate::protocol::Protocol;
use crate::sample::Reading;
use crate::testing::{
    come_back, events, head_records, hostile, moving_head, reply, said, samples, thrown,
};
use crate::time::DeviceTime;
use glam::{Quat, Vec3};
use std::vec::Vec as StdVec;

fn config(items: &[u8]) -> Config {
    Config::new(ItemList::new(Family::Liberty, Format::Binary, items).unwrap())
}

/// Station 2 at 1, 2, 3 inches, not turned, 70,000 ms.
fn vector() -> StdVec<u8> {
    let mut record = StdVec::from(*b"LY\x02C \0\x21\0");
    for value in [1.0_f32, 2.0, 3.0, 1.0, 0.0, 0.0, 0.0] {
        record.extend_from_slice(&value.to_le_bytes());
    }
    record.extend_from_slice(&70_000_u32.to_le_bytes());
    record.push(b' ');
    record
}

#[test]
fn record_decodes_to_its_values() {
    let mut config = config(&[2, 7, 8, 0]);
    assert_eq!((config.record_bytes(), vector().len()), (41, 41));
    let found = samples(&mut Liberty::new(config.clone()), &vector());
    assert_eq!(found.len(), 1);
    let sample = found[0];
    let metres = Vec3::new(2.0, -3.0, -1.0) * 0.0254;
    assert_eq!(sample.head.position, Some(Reading::tracked(metres)));
    assert_eq!(
        sample.head.orientation,
        Some(Reading::tracked(Quat::IDENTITY))
    );
    assert_eq!(sample.device_time, Some(DeviceTime::millis_u32(70_000)));
    assert_eq!(sample.sensor, 1);
    assert_eq!(config.encode(&sample).as_slice(), vector());
    for model in Model::ALL {
        config.model = model;
        let record = config.encode(&sample);
        assert_eq!(record[..2], model.tag());
        assert_eq!(samples(&mut Liberty::new(config.clone()), &record), found);
    }
}

/// What of the header is not known from a device can be set otherwise.
#[test]
fn headers_that_are_otherwise() {
    let usual = config(&[2, 7, 8, 0]);
    let found = samples(&mut Liberty::new(usual.clone()), &vector());
    let read = |config: &Config, bytes: &[u8]| samples(&mut Liberty::new(config.clone()), bytes);
    let other = [
        (Some(*b"RQ"), Size::LittleEndian, *b"R \0\x21\0"),
        (Some(*b"CP"), Size::BigEndian, *b"C \0\0\x21"),
        (Some(*b"CP"), Size::Unused, *b"C \0\0\0"),
        (None, Size::Unused, *b"C \0\0\0"),
    ];
    for (records, size, header) in other {
        let config = Config {
            records,
            size,
            ..usual.clone()
        };
        let mut record = vector();
        record[3..8].copy_from_slice(&header);
        assert_eq!(config.encode(&found[0]).as_slice(), record);
        assert_eq!(read(&config, &record), found);
        assert_eq!(read(&usual, &record), []);
        // Twice, with something between that is none.
        let stream = [&record[..], b"LY\x01", &record].concat();
        assert_eq!(read(&config, &stream).len(), 2);
        // Bytes that are not looked at may be anything.
        record[3] = 0xC7;
        record[6..8].copy_from_slice(&[0x99, 0x77]);
        let passes = records.is_none() && size == Size::Unused;
        assert_eq!(read(&config, &record).len(), usize::from(passes));
    }
    // The answer to another command is told by the command alone.
    let config = Config {
        size: Size::Unused,
        ..usual
    };
    let stream = [b"LY\x01O \0\0\0", &vector()[..]].concat();
    assert_eq!(read(&config, &stream), found);
}

#[test]
fn stylus_is_up_or_down() {
    let config = config(&[2, 7, 8, 10, 0]);
    let mut record = config.encode(&moving_head(1)[0]).to_vec();
    for (state, count) in [(0, 1), (1, 1), (2, 0)] {
        record[40] = state;
        assert_eq!(
            samples(&mut Liberty::new(config.clone()), &record).len(),
            count
        );
    }
}

#[test]
fn errors_answers_and_other_lists_are_told_apart() {
    let mut failing = vector();
    failing[4] = b'f';
    let answer = b"LY\x01O*\0\0\0";
    let mut whoami = StdVec::from(*b"LY\x01\x16 \0\x14\0");
    whoami.extend_from_slice(&[b'x'; 20]);
    let mut other_list = vector();
    other_list[6] = 0x25;
    other_list.extend_from_slice(b"    ");
    let mut not_a_number = vector();
    not_a_number[8..12].copy_from_slice(&f32::NAN.to_le_bytes());
    let mut no_turn = vector();
    no_turn[20..24].copy_from_slice(&0.0_f32.to_le_bytes());
    let stream = [
        &failing[..],
        &failing,
        answer,
        &whoami,
        &other_list,
        &not_a_number,
        &no_turn,
        &vector(),
    ]
    .concat();
    let found = events(&mut Liberty::new(config(&[2, 7, 8, 0])), &stream);
    let fault = Event::Message(Message::Fault {
        code: u32::from(b'f'),
        meaning: "",
    });
    assert_eq!(found[0], fault);
    for place in [1, 2] {
        let Event::Sample(sample) = found[place] else {
            panic!("{found:?}");
        };
        assert!(!sample.head.position.unwrap().tracked);
    }
    assert_eq!(found[3], reply(u32::from(b'O'), u32::from(b'*')));
    assert_eq!(found[4], reply(0x16, 0));
    assert_eq!(found[5], thrown(45, DropReason::Length));
    assert_eq!(found[6], thrown(41, DropReason::OutOfRange));
    assert_eq!(found[7], thrown(41, DropReason::NotUnit));
    assert!(matches!(found[8..], [Event::Sample(_)]), "{found:?}");
}

#[test]
fn start_says_what_the_configuration_needs() {
    let mut config = config(&[2, 7, 8, 0]);
    config.stations = 1;
    let expected: [&[u8]; 6] = [b"P", b"F1\r", b"U0\r", b"O1,2,7,8,0\r", b"Q0\r", b"C\r"];
    assert_eq!(said(config.start(false)), expected);
    config.stations = MOST_STATIONS;
    config.units = Units::Centimetres;
    assert!(config.start(true).is_complete());
}

#[test]
fn every_fault_costs_little() {
    let lists: [&[u8]; 3] = [&[2, 7, 8, 0], &[2, 7, 8, 10, 0], &[7, 0]];
    for config in lists.map(config) {
        let encode = |sample: &Sample| config.encode(sample).to_vec();
        come_back(Liberty::new(config.clone()), encode, [1e-6, 2e-6]);
        let records = head_records(&Protocol::Liberty(config.clone()), encode);
        let found = hostile(|| Liberty::new(config.clone()), &records, 5e-21);
        found.assert_within("Liberty", [0.0, 0.65, 0.0, 0.0], 0);
    }
}
