use super::*;
use crate::hid::eye_tracker::{Axes, EyeTracker, Mode, documented};
use crate::sample::{GazePoint, Reading, Sample};
use crate::testing::samples;
use embedded_hal::i2c::{ErrorKind, NoAcknowledgeSource};
use embedded_hal_mock::eh1::i2c::{Mock, Transaction};
use glam::Vec2;
use std::vec::Vec as List;

const ADDRESS: u8 = 0x2C;

/// Command register 5, data 6, report descriptor of 340 bytes at 2, inputs of 67 at 3.
const HID_DESCRIPTOR: [u8; 30] = [
    30, 0, 0x00, 0x01, 0x54, 0x01, 2, 0, 3, 0, 67, 0, 4, 0, 0, 0, 5, 0, 6, 0, 0xED, 0xDE, 0xED,
    0xFE, 1, 0, 0, 0, 0, 0,
];

const POWER: [u8; 4] = [5, 0, 0, 8];
const NAK: ErrorKind = ErrorKind::NoAcknowledge(NoAcknowledgeSource::Address);

fn read_descriptor() -> Transaction {
    Transaction::write_read(ADDRESS, [1, 0].into(), HID_DESCRIPTOR.into())
}

fn write(bytes: &[u8]) -> Transaction {
    Transaction::write(ADDRESS, bytes.into())
}

fn read(bytes: &[u8]) -> Transaction {
    Transaction::read(ADDRESS, bytes.into())
}

fn device(transactions: &[Transaction]) -> I2cHid<Mock> {
    I2cHid::new(Mock::new(transactions), ADDRESS, 1)
}

/// Returns what Linux does, byte for byte.
fn bringing_up() -> List<Transaction> {
    List::from([
        read_descriptor(),
        write(&POWER),
        write(&[5, 0, 0, 1]),
        Transaction::write_read(ADDRESS, [2, 0].into(), documented::DESCRIPTOR.into()),
        read(&[0, 0]),
        write(&POWER),
    ])
}

fn brought_up(more: &[Transaction]) -> (I2cHid<Mock>, [u8; 512]) {
    let mut device = device(&[&bringing_up()[..], more].concat());
    let mut buffer = [0; 512];
    let mut poll = |now, interrupt| {
        device
            .poll(Micros::from_millis(now), interrupt, &mut buffer)
            .unwrap()
    };
    let ready = Progress::Ready(340);
    let again = |at| Progress::Again(Micros::from_millis(at));
    assert_eq!(poll(1_000, Interrupt::Idle), again(1_060));
    assert_eq!(poll(1_059, Interrupt::Idle), again(1_060));
    assert_eq!(poll(1_060, Interrupt::Idle), again(2_060));
    assert_eq!(poll(1_061, Interrupt::Idle), again(2_060));
    assert_eq!(poll(1_070, Interrupt::Asserted), ready);
    assert_eq!(poll(1_080, Interrupt::Idle), ready);
    (device, buffer)
}

/// From the bus to a sample and to features, as a driver does it.
#[test]
fn an_eye_tracker_is_used() {
    let sample = Sample {
        gaze_point: Some(Reading::tracked(GazePoint::Plane(Vec2::new(0.25, 0.125)))),
        ..Sample::arrived(crate::testing::ARRIVAL)
    };
    let report = documented::tracking(&sample);
    let input = [&[67, 0][..], &report].concat();
    let capabilities = [&[24, 0, 0x11][..], &[1; 21]].concat();
    let (mut device, buffer) = brought_up(&[
        // Get feature 0x11, set feature 0x14 to 7.
        Transaction::write_read(
            ADDRESS,
            [5, 0, 0x3F, 2, 0x11, 6, 0].into(),
            capabilities.clone(),
        ),
        write(&[5, 0, 0x3F, 3, 0x14, 6, 0, 4, 0, 0x14, 7]),
        read(&input),
        write(&[5, 0, 1, 8]),
    ]);
    assert_eq!(buffer[..340], documented::DESCRIPTOR);
    let mut tracker = EyeTracker::new(&buffer[..340], Axes::default()).unwrap();
    let [Some((id, length)), .., Some((control, _))] = tracker.feature_reports() else {
        panic!("{tracker:?}");
    };
    let mut buffer = [0; 128];
    let found = device.get_feature(id, length, &mut buffer).unwrap();
    assert_eq!(found, Some(&capabilities[2..]));
    assert!(tracker.capabilities(found.unwrap()).is_ok());
    let mode = tracker.mode_request(Mode::ALL).unwrap();
    device.set_feature(control, &mode).unwrap();
    let report = device.input(&mut buffer).unwrap().unwrap();
    let found = samples(&mut tracker, report);
    assert_eq!(found[0].gaze_point, sample.gaze_point);
    device.sleep().unwrap();
    assert_eq!(device.input(&mut buffer), Err(I2cHidError::NotReady));
    device.release().done();
}

#[test]
fn short_ids_are_in_the_command() {
    let (mut device, _) = brought_up(&[
        Transaction::write_read(ADDRESS, [5, 0, 0x3E, 2, 6, 0].into(), [4, 0, 14, 9].into()),
        Transaction::write_read(ADDRESS, [5, 0, 0x30, 2, 6, 0].into(), [3, 0, 9, 0].into()),
        write(&[5, 0, 0x31, 3, 6, 0, 4, 0, 1, 8]),
        write(&[5, 0, 0x3F, 3, 15, 6, 0, 4, 0, 15, 8]),
    ]);
    let mut buffer = [0; 4];
    let found = device.get_feature(14, 2, &mut buffer).unwrap();
    assert_eq!(found, Some(&[14, 9][..]));
    // Shorter than asked for.
    let found = device.get_feature(0, 2, &mut buffer).unwrap();
    assert_eq!(found, Some(&[9][..]));
    device.set_feature(1, &[1, 8]).unwrap();
    device.set_feature(15, &[15, 8]).unwrap();
    device.release().done();
}

#[test]
fn the_length_of_an_input_is_checked() {
    let with_length = |length: u16| {
        let mut bytes = [7; 67];
        bytes[..2].copy_from_slice(&length.to_le_bytes());
        read(&bytes)
    };
    let lengths = [0, 0xFFFF, 2, 3, 67, 1, 68, 0x8000];
    let (mut device, _) = brought_up(&lengths.map(with_length));
    let mut buffer = [0; 100];
    for (length, expected) in [
        (0, Ok(None)),
        (0xFFFF, Ok(None)),
        (2, Ok(Some(0))),
        (3, Ok(Some(1))),
        (67, Ok(Some(65))),
        (1, Err(1)),
        (68, Err(68)),
        (0x8000, Err(0x8000)),
    ] {
        let found = device.input(&mut buffer);
        let expected = expected.map_err(|found| I2cHidError::Length { found, most: 67 });
        assert_eq!(found.map(|r| r.map(<[u8]>::len)), expected, "{length}");
    }
    let small = |needed, found| I2cHidError::Buffer { needed, found };
    assert_eq!(device.input(&mut buffer[..66]), Err(small(67, 66)));
    let found = device.get_feature(1, 8, &mut buffer[..9]);
    assert_eq!(found, Err(small(10, 9)));
    assert_eq!(device.set_feature(1, &[0; 129]), Err(small(129, 128)));
    device.release().done();
}

#[test]
fn a_device_that_sleeps_is_woken_twice() {
    let mut up = bringing_up();
    up.insert(1, write(&POWER).with_error(NAK));
    let mut slow = device(&up);
    let mut buffer = [0; 400];
    let mut poll = |now, interrupt| slow.poll(Micros::from_millis(now), interrupt, &mut buffer);
    assert!(matches!(poll(0, Interrupt::Idle), Ok(Progress::Again(_))));
    assert!(matches!(poll(60, Interrupt::Idle), Ok(Progress::Again(_))));
    assert_eq!(poll(61, Interrupt::Asserted), Ok(Progress::Ready(340)));
    slow.release().done();

    let mut gone = device(&[
        read_descriptor(),
        write(&POWER).with_error(NAK),
        write(&POWER).with_error(NAK),
        // The next call begins anew.
        read_descriptor().with_error(NAK),
    ]);
    for _ in 0..2 {
        let polled = gone.poll(Micros(0), Interrupt::Idle, &mut buffer);
        assert_eq!(polled, Err(I2cHidError::Bus(NAK)));
    }
    gone.release().done();
}

/// A device whose line is high at last, and those that never say that they have come back.
#[test]
fn a_reset_that_does_not_end_is_given_up() {
    for (length, last) in [
        ([67, 0], Interrupt::Idle),
        ([67, 0], Interrupt::Asserted),
        ([0xFF, 0xFF], Interrupt::Asserted),
    ] {
        let mut up = bringing_up();
        up.truncate(4);
        let reads = if last == Interrupt::Idle { 1 } else { 2 };
        up.extend((0..reads).map(|_| read(&length)));
        let mut device = device(&up);
        let mut buffer = [0; 400];
        let mut poll = |now, line| device.poll(Micros::from_millis(now), line, &mut buffer);
        assert!(poll(0, Interrupt::Idle).is_ok() && poll(60, Interrupt::Idle).is_ok());
        let soon = Micros::from_millis(1_059);
        assert_eq!(poll(1_058, Interrupt::Asserted), Ok(Progress::Again(soon)));
        let until = Micros::from_millis(1_060);
        assert_eq!(poll(1_059, Interrupt::Idle), Ok(Progress::Again(until)));
        assert_eq!(poll(1_060, last), Err(I2cHidError::ResetTimeout));
        device.release().done();
    }
}

#[test]
fn without_an_interrupt_line_the_reset_is_waited_for() {
    let mut device = device(&bringing_up());
    let mut buffer = [0; 400];
    let mut poll = |now| {
        device
            .poll(Micros::from_millis(now), Interrupt::NotWired, &mut buffer)
            .unwrap()
    };
    let again = |at| Progress::Again(Micros::from_millis(at));
    assert_eq!(poll(0), again(60));
    assert_eq!(poll(60), again(160));
    assert_eq!(poll(159), again(160));
    assert_eq!(poll(160), Progress::Ready(340));
    device.release().done();
}

#[test]
fn what_is_no_hid_device_is_refused() {
    let with = |at: usize, byte: u8| {
        let mut bytes = HID_DESCRIPTOR;
        bytes[at] = byte;
        let answer = Transaction::write_read(ADDRESS, [1, 0].into(), bytes.into());
        let mut device = device(&[answer]);
        let polled = device.poll(Micros(0), Interrupt::Idle, &mut [0; 340]);
        device.release().done();
        polled.unwrap_err()
    };
    let (length, version) = (29, 0x0100);
    assert_eq!(with(0, 29), I2cHidError::NotHid { length, version });
    let (length, version) = (30, 0x0200);
    assert_eq!(with(3, 2), I2cHidError::NotHid { length, version });
    // A report descriptor of 64 KiB.
    let (needed, found) = (0xFF54, 340);
    assert_eq!(with(5, 0xFF), I2cHidError::Buffer { needed, found });
    let text = std::format!("{}", with(0, 29));
    assert!(text.contains("but 29 and 0x0100"), "{text}");
}
