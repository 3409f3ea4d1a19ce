//! How many random bytes pass for records, decoder by decoder.

use crate::decoder::Decoder;
use crate::head::osvr_hdk;
use crate::hid::eye_tracker::documented::DESCRIPTOR;
use crate::hid::eye_tracker::{Axes, EyeTracker};
use crate::protocol::{Protocol, Reader};
use crate::testing::{ARRIVAL, Random, assert_usable, random_bytes, random_count};

/// A billion where `SHISEN_HEAVY` asks for it.
const HEAVY: u64 = 1_000_000_000;

/// Each decoder of a line as it is usually set up, and which part of random bytes
/// gives a sample, as its module and the README say.
#[test]
fn random_bytes_of_each_line_pass_as_often_as_said() {
    let rates = [
        ("link", f64::exp2(-45.0)),
        ("fastrak", 5.0e-13),
        ("liberty", 5.0e-21),
        ("flock", 1.5e-6),
        ("hatire", 5.0e-13),
        ("iscan", 3.0e-13),
        ("asl", f64::exp2(-39.0)),
        ("adhawk", f64::exp2(-36.0)),
    ];
    for ((name, rate), seed) in rates.into_iter().zip(900..) {
        let mut reader = Reader::new(&Protocol::named(name).unwrap()).unwrap();
        let fed = random_count(HEAVY);
        let passed = random_bytes(&mut reader, fed, seed);
        let said = rate * fed as f64;
        std::println!("{name}: {passed} of {fed} bytes, {said:.3} said");
        // Half as much again, and what chance adds.
        let most = 1.5 * said;
        assert!(
            passed as f64 <= most + 3.0 * most.sqrt(),
            "{name}: {passed}"
        );
    }
}

/// Feeds whole reports of a length, of which the first byte is `first` where one is
/// given, and gives back how many of how many pass.
fn reports(decoder: &mut impl Decoder, bytes: usize, first: Option<u8>, seed: u64) -> (f64, f64) {
    let mut random = Random(seed);
    let (mut passed, mut fed) = (0_u64, 0_u64);
    let mut report = [0; 72];
    while fed * (bytes as u64) < random_count(HEAVY) {
        for word in report.chunks_exact_mut(8) {
            word.copy_from_slice(&random.next().to_le_bytes());
        }
        report[0] = first.unwrap_or(report[0]);
        decoder.feed(&report[..bytes], ARRIVAL, &mut |event| {
            if let crate::decoder::Event::Sample(sample) = event {
                assert_usable(&sample);
                passed += 1;
            }
        });
        fed += 1;
    }
    std::println!("{passed} of {fed} reports of {bytes} bytes, first {first:02x?}");
    (passed as f64, fed as f64)
}

/// What the decoders of HID refuse themselves, of reports that USB's CRC-16 or
/// nothing guards.
#[test]
fn random_reports_pass_as_often_as_said() {
    // Within what chance explains.
    let near = |(passed, fed): (f64, f64), share: f64| {
        let said = share * fed;
        assert!(
            (passed - said).abs() <= 4.0 * said.sqrt(),
            "{passed} of {fed}"
        );
    };
    let hdk = osvr_hdk::OsvrHdk::new;
    near(reports(&mut hdk(), 16, None, 1), HDK);
    assert_eq!(reports(&mut hdk(), 15, None, 2).0, 0.0);
    let eye_tracker = || EyeTracker::new(&DESCRIPTOR, Axes::default()).unwrap();
    near(reports(&mut eye_tracker(), 65, None, 3), 1.0 / 256.0);
    let (passed, fed) = reports(&mut eye_tracker(), 65, Some(0x10), 4);
    assert_eq!(passed, fed);
    assert_eq!(reports(&mut eye_tracker(), 64, Some(0x10), 5).0, 0.0);
}

/// The share of random reports that an OSVR HDK's decoder takes.
const HDK: f64 = 0.000_29;
