//! How many random HID reports pass for samples.

use crate::decoder::{Decoder, Event};
use crate::head::osvr_hdk;
use crate::hid::eye_tracker::documented::DESCRIPTOR;
use crate::hid::eye_tracker::{Axes, EyeTracker};
use crate::testing::{ARRIVAL, Random, assert_usable, random_count};

/// Random bytes where `SHISEN_HEAVY` asks for all.
const HEAVY: u64 = 1_000_000_000;

/// The share of random reports that an OSVR HDK's decoder takes.
const HDK: f64 = 0.000_29;

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
            if let Event::Sample(sample) = event {
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
