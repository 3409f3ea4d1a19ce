use super::*;
use crate::testing::thrown;
use core::f32::consts::FRAC_1_SQRT_2;
use std::format;

/// Version 1, sequence 7: no rotation.
const VERSION_1: [u8; 16] = [
    0x01, 7, 0, 0, 0, 0, 0, 0, 0x00, 0x40, 0xAA, 0xBB, 0xCC, 0xDD, 0xEE, 0xFF,
];
/// Version 2, sequence 255: i = −1; 1, −1.5 and −64 rad/s.
const VERSION_2: [u8; 16] = [
    0x02, 255, 0x00, 0xC0, 0, 0, 0, 0, 0, 0, 0x00, 0x02, 0x00, 0xFD, 0x00, 0x80,
];
/// Version 3, sequence 0: three parts −0.5, one 0.5; 63.998 rad/s, −1/512 rad/s and 0.
const VERSION_3: [u8; 16] = [
    0x33, 0, 0x00, 0xE0, 0x00, 0xE0, 0x00, 0xE0, 0x00, 0x20, 0xFF, 0x7F, 0xFF, 0xFF, 0, 0,
];

fn padded(report: [u8; 16]) -> [u8; 32] {
    let mut padded = [0x5A; 32];
    padded[..16].copy_from_slice(&report);
    padded
}

#[test]
fn each_version_is_decoded_and_encoded() {
    let v = |x, y, z| Some(Vec3::new(x, y, z));
    for (bytes, sequence, [x, y, z, w], angular_velocity) in [
        (VERSION_1, 7, [0.0, 0.0, 0.0, 1.0], None),
        (VERSION_2, 255, [-1.0, 0.0, 0.0, 0.0], v(1.0, -1.5, -64.0)),
        (
            VERSION_3,
            0,
            [-0.5, -0.5, -0.5, 0.5],
            v(32_767.0 / 512.0, -1.0 / 512.0, 0.0),
        ),
    ] {
        let report = Report {
            sequence,
            orientation: Quat::from_xyzw(x, y, z, w),
            angular_velocity,
        };
        assert_eq!(decode(&bytes), Ok(report));
        assert_eq!(decode(&padded(bytes)), Ok(report));
        let encoded = encode(&report);
        assert_eq!(decode(&encoded), Ok(report));
        assert_eq!(encoded[1..10], bytes[1..10]);
    }
}

#[test]
fn every_other_length_and_version_is_refused() {
    let bytes = [padded(VERSION_1), padded(VERSION_1)].concat();
    for found in (0..=33).filter(|&length| length != 16 && length != 32) {
        let refused = Err(ReportError::Length { found });
        assert_eq!(decode(&bytes[..found]), refused);
    }
    for version in [0, 4, 5, 15] {
        let mut bytes = VERSION_1;
        bytes[0] = 0x30 | version;
        let refused = decode(&bytes).unwrap_err();
        assert_eq!(refused, ReportError::UnknownVersion { version });
        assert!(format!("{refused}").contains(&format!("version {version}")));
    }
}

#[test]
fn norm_is_held_to_its_tolerance() {
    let with_real = |real: i16| {
        let mut bytes = VERSION_1;
        bytes[8..10].copy_from_slice(&real.to_le_bytes());
        decode(&bytes)
    };
    // 16384 × 0.01 = 163.84.
    for real in [16_384 - 163, 16_384 + 163, -16_384 - 163] {
        let orientation = with_real(real).unwrap().orientation;
        assert_eq!(orientation.w.abs(), 1.0);
    }
    for real in [16_384 - 164, 16_384 + 164, 0, i16::MIN, i16::MAX] {
        let norm = f32::from(real).abs() / 16_384.0;
        assert_eq!(
            with_real(real),
            Err(ReportError::NotUnit { sequence: 7, norm })
        );
    }
}

/// The sensor's +X points right, +Y down, +Z forward; the reference is Z up.
#[test]
fn head_has_the_heads_axes() {
    let head = |i: f32, j: f32, k: f32, real: f32| {
        let report = Report {
            sequence: 0,
            orientation: Quat::from_xyzw(i, j, k, real),
            angular_velocity: Some(Vec3::new(1.0, 2.0, 3.0)),
        };
        report.sample(Micros(0)).head
    };
    let turn = |head: Head| head.orientation.unwrap().value;
    let near = |a: Vec3, b: Vec3| assert!(a.distance(b) < 1e-6, "{a} is not {b}");

    // The sensor's axes are the reference's: its forward is the sky.
    let up = head(0.0, 0.0, 0.0, 1.0);
    near(turn(up) * Vec3::NEG_Z, Vec3::Y);
    near(turn(up) * Vec3::X, Vec3::X);

    // A quarter turn about −X brings the sensor's +Z from up to the
    // reference's +Y, level: that is the reference's forward, −Z once Y is up.
    let level = head(-FRAC_1_SQRT_2, 0.0, 0.0, FRAC_1_SQRT_2);
    near(turn(level) * Vec3::NEG_Z, Vec3::NEG_Z);
    near(turn(level) * Vec3::Y, Vec3::Y);

    // From there a quarter turn to the left about the reference's up.
    let left = Quat::from_xyzw(0.0, 0.0, FRAC_1_SQRT_2, FRAC_1_SQRT_2)
        * Quat::from_xyzw(-FRAC_1_SQRT_2, 0.0, 0.0, FRAC_1_SQRT_2);
    let left = head(left.x, left.y, left.z, left.w);
    near(turn(left) * Vec3::NEG_Z, Vec3::NEG_X);
    near(turn(left) * Vec3::Y, Vec3::Y);

    assert_eq!(up.angular_velocity, Some(Vec3::new(1.0, -2.0, -3.0)));
}

/// Returns what a decoder makes of one report.
fn event(decoder: &mut OsvrHdk, report: &[u8]) -> Event {
    let mut events = std::vec::Vec::new();
    decoder.feed(report, Micros(9), &mut |event| events.push(event));
    assert_eq!(events.len(), 1);
    events[0]
}

#[test]
fn decoder_counts_gaps_across_the_wrap() {
    let mut decoder = OsvrHdk::new();
    let numbered = |sequence: u8| {
        let mut bytes = VERSION_1;
        bytes[1] = sequence;
        bytes
    };
    // 254 is first; 255 and 0 follow on; 1 is a repeat once; 2 and 3 are
    // missing; from 4 to 3 all others are.
    for sequence in [254, 255, 0, 1, 4, 3] {
        let report = numbered(sequence);
        let sample = decode(&report).unwrap().sample(Micros(9));
        assert_eq!(event(&mut decoder, &report), Event::Sample(sample));
        if sequence == 1 {
            let repeated = thrown(16, DropReason::Duplicate);
            assert_eq!(event(&mut decoder, &report), repeated);
        }
    }
    let counts = decoder.counts();
    assert_eq!((counts.samples, counts.lost), (6, 2 + 254));
    assert_eq!(counts.dropped_for(DropReason::Duplicate), 1);
    assert_eq!((counts.bytes, counts.dropped_bytes), (7 * 16, 16));
    decoder.reset();
    event(&mut decoder, &numbered(100));
    // One of no use counts as arrived.
    let mut damaged = numbered(101);
    damaged[9] = 0;
    for (report, reason) in [
        (&damaged[..], DropReason::NotUnit),
        (&[0; 3], DropReason::Length),
        (&[0x0F; 16], DropReason::Unknown),
    ] {
        assert_eq!(
            event(&mut decoder, report),
            thrown(report.len() as u32, reason)
        );
    }
    event(&mut decoder, &numbered(102));
    assert_eq!(decoder.counts().lost, 256);
}
