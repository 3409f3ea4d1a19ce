use super::documented::DESCRIPTOR;
use super::*;
use crate::testing::{ARRIVAL, dropped, events, samples};
use crate::time::DeviceTime;
use std::vec::Vec as List;

fn tracker() -> EyeTracker {
    EyeTracker::new(&DESCRIPTOR, Axes::default()).unwrap()
}

/// 5 s; gaze 0.3, 0.2 m; left eye −0.03, 0.1, 0.65; head 0, 0.12, 0.7, turned to 0, 0.12, −0.3.
fn report() -> List<u8> {
    let gaze = &[300_000, 200_000][..];
    let (left, right) = ([-30_000, 100_000, 650_000], [i32::MAX; 3]);
    let (head, towards) = ([0, 120_000, 700_000], [0, 120_000, -300_000]);
    let mut report = List::from([0x10]);
    report.extend(5_000_000_u64.to_le_bytes());
    for value in [gaze, &left, &right, &head, &towards].concat() {
        report.extend(value.to_le_bytes());
    }
    report
}

/// Returns the report with other values from a place on.
fn report_with(place: usize, values: &[i32]) -> List<u8> {
    let mut report = report();
    for (n, value) in (place..).zip(values) {
        report[9 + 4 * n..13 + 4 * n].copy_from_slice(&value.to_le_bytes());
    }
    report
}

/// Returns whether a head looks this way and is level.
fn faces(head: &Head, forward: Vec3) -> bool {
    let turn = head.orientation.unwrap().value;
    (turn * Vec3::NEG_Z).distance(forward) < 1e-6 && (turn * Vec3::Y).distance(Vec3::Y) < 1e-6
}

fn near(found: Option<Reading<Vec3>>, expected: Vec3) {
    let found = found.unwrap();
    assert!(found.tracked);
    assert!(found.value.distance(expected) < 1e-6, "{found:?}");
}

#[test]
fn a_report_becomes_a_sample() {
    let mut tracker = tracker();
    let found = samples(&mut tracker, &report());
    let [sample] = found[..] else {
        panic!("{found:?}");
    };
    assert_eq!(sample.device_time, Some(DeviceTime::unwrapped(5_000_000)));
    assert_eq!(sample.arrival, ARRIVAL);
    assert_eq!(sample.gaze_frame, GazeFrame::Tracker);
    let Some(Reading {
        value: GazePoint::Plane(point),
        tracked: true,
    }) = sample.gaze_point
    else {
        panic!("{sample:?}");
    };
    assert!(point.distance(Vec2::new(0.3, 0.2)) < 1e-6);
    near(sample.left.origin, Vec3::new(-0.03, 0.1, 0.65));
    assert!(sample.right.is_empty());
    near(sample.head.position, Vec3::new(0.0, 0.12, 0.7));
    assert!(faces(&sample.head, Vec3::NEG_Z));
    assert_eq!((tracker.counts().samples, tracker.counts().bytes), (1, 65));
    // A device that counts down and into the screen, from 0.2 m above.
    let axes = Axes {
        rotation: Quat::from_xyzw(1.0, 0.0, 0.0, 0.0),
        origin: Vec3::new(0.0, 0.2, 0.0),
    };
    let mut tracker = EyeTracker::new(&DESCRIPTOR, axes).unwrap();
    let sample = samples(&mut tracker, &self::report())[0];
    near(sample.left.origin, Vec3::new(-0.03, 0.1, -0.65));
    assert!(faces(&sample.head, Vec3::Z));
}

#[test]
fn what_is_out_of_range_is_not_there() {
    for value in [i32::MAX, i32::MIN, 2_000_001, -2_000_001] {
        for place in 0..14 {
            // The right eye too, so that all are there but one.
            let mut report = report_with(5, &[1; 3]);
            report[9 + 4 * place..13 + 4 * place].copy_from_slice(&value.to_le_bytes());
            let sample = samples(&mut tracker(), &report)[0];
            let point = sample.gaze_point.unwrap();
            assert_eq!(point.tracked, place >= 2);
            assert_eq!(sample.left.origin.is_some(), !(2..5).contains(&place));
            assert_eq!(sample.right.origin.is_some(), !(5..8).contains(&place));
            assert_eq!(sample.head.position.is_some(), !(8..11).contains(&place));
            assert_eq!(sample.head.orientation.is_some(), place < 8);
        }
    }
    // At the ends of the range it is.
    let sample = samples(&mut tracker(), &report_with(0, &[2_000_000, -2_000_000]))[0];
    let point = GazePoint::Plane(Vec2::new(2.0, -2.0));
    assert_eq!(sample.gaze_point, Some(Reading::tracked(point)));
}

#[test]
fn a_head_without_a_direction_has_no_orientation() {
    let turned_to = |place| samples(&mut tracker(), &report_with(11, place))[0].head;
    // Itself; straight above; to the left.
    assert_eq!(turned_to(&[0, 120_000, 700_000]).orientation, None);
    assert_eq!(turned_to(&[0, 900_000, 700_000]).orientation, None);
    assert!(faces(
        &turned_to(&[-500_000, 120_000, 700_000]),
        Vec3::NEG_X
    ));
}

#[test]
fn other_reports_are_told_apart() {
    let ready = documented::status(&Status {
        configuration: Some(1),
        ..Status::default()
    });
    let (code, meaning) = (1, "ready");
    let state = Event::Message(Message::State { code, meaning });
    assert_eq!(events(&mut tracker(), &ready), [state]);
    let short = &report()[..64];
    assert_eq!(dropped(&mut tracker(), short), [DropReason::Length]);
    assert_eq!(dropped(&mut tracker(), &[0x10]), [DropReason::Length]);
    assert_eq!(dropped(&mut tracker(), &[0x55; 65]), [DropReason::Unknown]);
    assert_eq!(events(&mut tracker(), &[]), []);
    // Padded to the longest report of a device.
    let padded = [&report()[..], &[0; 31]].concat();
    assert_eq!(samples(&mut tracker(), &padded).len(), 1);
}

#[test]
fn features_are_read() {
    let tracker = tracker();
    assert_eq!(tracker.report_id(), 0x10);
    assert_eq!(
        tracker.feature_reports(),
        [
            Some((0x11, 22)),
            Some((0x12, 19)),
            Some((0x13, 4)),
            Some((0x14, 2))
        ]
    );
    // By hand: the sample device's distances.
    let mut report = List::from([0x11, 1]);
    for value in [50_000_u32, 65_000, 90_000, 500_000, 300_000] {
        report.extend(value.to_le_bytes());
    }
    let found = tracker.capabilities(&report).unwrap();
    assert_eq!(found.quality, Some(1));
    assert!((found.nearest.unwrap() - 0.05).abs() < 1e-6);
    // To a micrometre.
    assert_eq!(documented::capabilities(&found)[..], report[..]);

    let report = [
        0x12, 0x34, 0x12, 0x78, 0x56, 4, 3, 2, 1, 7, 0, 0x40, 0x42, 0x0F, 0, 0x20, 0xA1, 7, 0,
    ];
    let found = tracker.configuration(&report).unwrap();
    assert_eq!(found.manufacturer, Some(0x1234));
    assert_eq!(found.product, Some(0x5678));
    assert!((found.screen_width.unwrap() - 1.0).abs() < 1e-6);
    assert_eq!(documented::configuration(&found), report);

    let status = tracker.status(&[0x13, 4, 0x2C, 0x01]).unwrap();
    assert_eq!(status.configuration, Some(4));
    assert_eq!(status.sampling_frequency, Some(300.0));
    assert_eq!(status_name(4), "the user has to be calibrated");
    // A status of 9 is outside its range.
    let status = tracker.status(&[0x13, 9, 0, 0]).unwrap();
    assert_eq!(status.configuration, None);

    assert_eq!(tracker.mode_request(Mode::ALL).unwrap(), [0x14, 7]);
    assert_eq!(tracker.mode_request(Mode::STOP).unwrap(), [0x14, 0]);
    let gaze = Mode {
        gaze_point: true,
        ..Mode::STOP
    };
    assert_eq!(tracker.mode_request(gaze).unwrap(), [0x14, 1]);
}

#[test]
fn features_of_another_report_are_refused() {
    let tracker = tracker();
    let (expected, found) = (0x11, 0x12);
    let other = Err(ReportError::ReportId { expected, found });
    assert_eq!(tracker.capabilities(&[0x12; 22]), other);
    let (expected, found) = (22, 21);
    let short = Err(ReportError::Length { expected, found });
    assert_eq!(tracker.capabilities(&[0x11; 21]), short);
    let (expected, found) = (19, 0);
    let empty = Err(ReportError::Length { expected, found });
    assert_eq!(tracker.configuration(&[]), empty);
}

/// A head tracker with inches, milliseconds in 32 bits, and values not aligned to bytes.
#[test]
fn another_layout_is_read_by_its_descriptor() {
    #[rustfmt::skip]
    let descriptor = [
        0x05, 0x12, 0x09, 0x02, 0xA1, 0x01,
        0x09, 0x10, 0xA1, 0x02,
        // Four bits that mean nothing, then the head: inches × 10⁻², 12 bits,
        // −1000 to 1000.
        0x75, 4, 0x95, 1, 0x81, 0x01,
        0x09, 0x27, 0xA1, 0x00,
        0x65, 0x13, 0x55, 0x0E, 0x16, 0x18, 0xFC, 0x26, 0xE8, 0x03,
        0x75, 12, 0x95, 3, 0x09, 0x21, 0x09, 0x22, 0x09, 0x23, 0x81, 0x02,
        0xC0,
        // Gaze without a unit: 0 to 255 is 0 to 1,000.
        0x09, 0x24, 0xA1, 0x00,
        0x65, 0, 0x55, 0, 0x15, 0, 0x26, 0xFF, 0, 0x35, 0, 0x46, 0xE8, 0x03,
        0x75, 8, 0x95, 2, 0x09, 0x21, 0x09, 0x22, 0x81, 0x02,
        0x35, 0, 0x45, 0,
        0xC0,
        // Milliseconds.
        0x66, 0x01, 0x10, 0x55, 0x0D, 0x75, 32, 0x95, 1, 0x09, 0x20, 0x81, 0x02,
        0xC0, 0xC0,
    ];
    let mut tracker = EyeTracker::new(&descriptor, Axes::default()).unwrap();
    assert_eq!(tracker.report_id(), 0);
    assert_eq!(tracker.feature_reports(), [None; 4]);
    assert_eq!(tracker.mode_request(Mode::ALL), None);
    assert_eq!(
        tracker.capabilities(&[0; 64]),
        Err(ReportError::NotDescribed)
    );
    // X −1000, y 500, z 1: twelve bits each, from bit 4.
    let [x, y, z] = [-1_000_i64, 500, 1].map(|value| value as u64 & 0xFFF);
    let head = (0xF | x << 4 | y << 16 | z << 28).to_le_bytes();
    let report = [&head[..5], &[255, 51], &3_000_u32.to_le_bytes()].concat();
    let sample = samples(&mut tracker, &report)[0];
    near(sample.head.position, Vec3::new(-10.0, 5.0, 0.01) * 0.0254);
    assert_eq!(sample.head.orientation, None);
    let Some(GazePoint::Raw(point)) = sample.gaze_point.map(|point| point.value) else {
        panic!("{sample:?}");
    };
    assert!(point.distance(Vec2::new(1_000.0, 200.0)) < 1e-3);
    let time = sample.device_time.unwrap();
    assert_eq!(time, DeviceTime::millis_u32(3_000));
}

/// A head tracker that says angles, and one that says nothing else.
#[test]
fn angles_turn_the_head() {
    #[rustfmt::skip]
    let place = [
        0x09, 0x27, 0xA1, 0x00,
        0x65, 0x11, 0x55, 0x0E, 0x16, 0x18, 0xFC, 0x26, 0xE8, 0x03,
        0x75, 16, 0x95, 3, 0x09, 0x21, 0x09, 0x22, 0x09, 0x23, 0x81, 0x02,
        0xC0,
    ];
    // Tenths of a degree, −1800 to 1800.
    #[rustfmt::skip]
    let degrees = [
        0x65, 0x14, 0x55, 0x0F, 0x16, 0xF8, 0xF8, 0x26, 0x08, 0x07,
        0x75, 16, 0x95, 3, 0x09, 0x29, 0x09, 0x2A, 0x09, 0x2B, 0x81, 0x02,
    ];
    // Milliradians about Y alone.
    #[rustfmt::skip]
    let radians = [
        0x65, 0x12, 0x55, 0x0D, 0x16, 0x00, 0xF0, 0x26, 0x00, 0x10,
        0x75, 16, 0x95, 1, 0x09, 0x2A, 0x81, 0x02,
    ];
    let tracker = |parts: &[&[u8]], axes| {
        let mut all = List::from([0x05, 0x12, 0x09, 0x02, 0xA1, 0x01, 0x09, 0x10, 0xA1, 0x02]);
        all.extend(parts.concat());
        all.extend([0xC0, 0xC0]);
        EyeTracker::new(&all, axes).unwrap()
    };
    let bytes = |values: &[i16]| -> List<u8> {
        let bytes = values.iter().flat_map(|value| value.to_le_bytes());
        bytes.collect()
    };
    let turn = |tracker: &mut EyeTracker, values: &[i16]| {
        let sample = samples(tracker, &bytes(values))[0];
        sample.head.orientation.map(|turn| turn.value)
    };
    let mut both = tracker(&[&place, &degrees], Axes::default());
    let values = [100, 0, 0, 200, 300, -100];
    let expected = Quat::from_euler(
        glam::EulerRot::YXZ,
        30f32.to_radians(),
        20f32.to_radians(),
        -10f32.to_radians(),
    );
    let found = turn(&mut both, &values).unwrap();
    assert!(found.dot(expected).abs() > 1.0 - 1e-6, "{found}");
    // Out of range: no turn, and still a place.
    let sample = samples(&mut both, &bytes(&[100, 0, 0, 200, 1_801, 0]))[0];
    assert_eq!(sample.head.orientation, None);
    near(sample.head.position, Vec3::X * 0.01);
    // Angles alone, about one axis; a device that is turned about X counts the
    // other way round.
    let turned = Axes {
        rotation: Quat::from_xyzw(1.0, 0.0, 0.0, 0.0),
        origin: Vec3::ZERO,
    };
    for (axes, angle) in [(Axes::default(), 0.5), (turned, -0.5)] {
        let found = turn(&mut tracker(&[&radians], axes), &[500]).unwrap();
        assert!(found.dot(Quat::from_rotation_y(angle)).abs() > 1.0 - 1e-6);
    }
}

#[test]
fn what_is_no_tracker_is_refused() {
    let of = |descriptor: &[u8]| EyeTracker::new(descriptor, Axes::default()).unwrap_err();
    assert_eq!(of(&[]), LayoutError::NoTrackingData);
    // A mouse's two axes.
    let mouse = [
        0x05, 0x01, 0x09, 0x02, 0xA1, 0x01, 0x75, 8, 0x95, 2, 0x09, 0x30, 0x09, 0x31, 0x81, 0x06,
        0xC0,
    ];
    assert_eq!(of(&mouse), LayoutError::NoTrackingData);
    let cut = of(&DESCRIPTOR[..339]);
    assert!(matches!(cut, LayoutError::Descriptor(_)), "{cut:?}");
    let rotation = Quat::from_xyzw(0.0, f32::NAN, 0.0, 1.0);
    let origin = Vec3::splat(f32::INFINITY);
    let usual = Axes::default();
    for axes in [Axes { rotation, ..usual }, Axes { origin, ..usual }] {
        let refused = EyeTracker::new(&DESCRIPTOR, axes).unwrap_err();
        assert_eq!(refused, LayoutError::Axes);
    }
}

/// Here the time is not as in the sample.
#[test]
fn unnamed_values_are_not_guessed() {
    let mut descriptor = List::from(DESCRIPTOR);
    // Seven bytes of time in place of eight.
    assert_eq!(descriptor[26..28], [0x95, 0x08]);
    descriptor[27] = 7;
    let mut tracker = EyeTracker::new(&descriptor, Axes::default()).unwrap();
    let mut report = report();
    report.remove(8);
    let sample = samples(&mut tracker, &report)[0];
    near(sample.left.origin, Vec3::new(-0.03, 0.1, 0.65));
    assert_eq!(sample.head, Head::default());
    let time = sample.device_time.unwrap();
    assert_eq!((time.microseconds, time.wraps_at), (5_000_000, 1 << 56));
}
