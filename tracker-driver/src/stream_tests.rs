//! What every decoder of a stream has to stand: single-byte faults at every
//! place, any split of the stream, and random bytes.

use crate::decoder::{Decoder, Event};
use crate::sample::Sample;
use crate::time::{DeviceTime, Micros};
use glam::{Quat, Vec3};
use std::vec::Vec;

/// Numbers that look random and are the same each time: SplitMix64.
pub(crate) struct Random(pub(crate) u64);

impl Random {
    pub(crate) fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (self.0 ^ self.0 >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ z >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ z >> 31
    }

    pub(crate) fn below(&mut self, limit: usize) -> usize {
        (self.next() % limit as u64) as usize
    }
}

/// A head that looks around and sways, 125 times a second.
pub(crate) fn moving_head(count: usize) -> Vec<Sample> {
    (0..count)
        .map(|i| {
            let t = i as f32 * 0.008;
            let place = Vec3::new(
                0.31 * (3.0 * t).sin(),
                0.2 + 0.1 * t,
                -0.4 * (2.0 * t).cos(),
            );
            let turn = Quat::from_rotation_y(1.3 * (2.0 * t).sin())
                * Quat::from_rotation_x(0.4 * (5.0 * t).cos())
                * Quat::from_rotation_z(0.1 + t);
            let mut sample = Sample::arrived(Micros(0));
            sample.device_time = Some(DeviceTime::unwrapped(1_000_000 + i as u64 * 8_000));
            sample.sequence = Some(i as u32);
            sample.head.position = Some(crate::sample::Reading::tracked(place));
            sample.head.orientation = Some(crate::sample::Reading::tracked(turn));
            sample
        })
        .collect()
}

/// The angle between two rotations, radians; for small ones.
pub(crate) fn angle(a: Quat, b: Quat) -> f32 {
    2.0 * (a - b).length().min((a + b).length())
}

/// All that a decoder makes of a stream.
pub(crate) fn events(mut decoder: impl Decoder, bytes: &[u8]) -> Vec<Event> {
    let mut events = Vec::new();
    decoder.feed(bytes, Micros(7), &mut |event| events.push(event));
    events
}

/// Its samples.
pub(crate) fn samples(decoder: impl Decoder, bytes: &[u8]) -> Vec<Sample> {
    let sample = |event| match event {
        Event::Sample(sample) => Some(sample),
        _ => None,
    };
    events(decoder, bytes)
        .into_iter()
        .filter_map(sample)
        .collect()
}

/// What single-byte faults did to a stream.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct Damage {
    /// Bytes dropped, doubled or slipped in.
    pub(crate) slips: u32,
    /// Bits flipped.
    pub(crate) flips: u32,
    /// Most records in a row that were lost though no fault touched them.
    pub(crate) longest_loss: usize,
    /// Faults after which such records were lost.
    pub(crate) with_loss: u32,
    /// Samples after a slip that no record has.
    pub(crate) false_after_slips: u32,
    /// Samples after a flip that no record has: that of the flipped bit.
    pub(crate) false_after_flips: u32,
}

impl Damage {
    /// A row of the table in a module's docs.
    pub(crate) fn print(&self, name: &str) {
        std::println!(
            "//! | {name} | {} slips, {} flips | {} | {} | {} |",
            self.slips,
            self.flips,
            self.longest_loss,
            self.false_after_slips,
            self.false_after_flips
        );
    }
}

/// Does every single-byte fault to a stream of these records, at every place
/// that has four records behind it.
pub(crate) fn damage<D: Decoder>(make: impl Fn() -> D, records: &[Vec<u8>]) -> Damage {
    let stream = records.concat();
    let expected = samples(make(), &stream);
    assert_eq!(expected.len(), records.len(), "every record is decoded");
    let mut starts = std::vec![0];
    for record in records {
        starts.push(starts.last().unwrap() + record.len());
    }
    let end = starts[records.len() - 4];
    let mut random = Random(5);
    let mut damage = Damage::default();
    let places = (0..end).step_by(if cfg!(miri) { 97 } else { 1 });
    for place in places {
        let touched = starts.partition_point(|&start| start <= place) - 1;
        let (before, after) = stream.split_at(place);
        let mut slips = std::vec![
            [before, &after[1..]].concat(),
            [before, &after[..1], after].concat(),
        ];
        for foreign in [0, 0x20, b'0', 0xAA, 0xFF, random.next() as u8] {
            slips.push([before, &[foreign], after].concat());
        }
        damage.slips += slips.len() as u32;
        damage.flips += 8;
        for slipped in slips {
            damage.false_after_slips += compare(&make, &slipped, &expected, touched, &mut damage);
        }
        for bit in 0..8 {
            let mut flipped = stream.clone();
            flipped[place] ^= 1 << bit;
            damage.false_after_flips += compare(&make, &flipped, &expected, touched, &mut damage);
        }
    }
    damage
}

/// How many samples of `stream` are none of those expected; notes how many of
/// these are missing.
fn compare<D: Decoder>(
    make: &impl Fn() -> D,
    stream: &[u8],
    expected: &[Sample],
    touched: usize,
    damage: &mut Damage,
) -> u32 {
    let mut came = std::vec![false; expected.len()];
    came[touched] = true;
    let mut from = 0;
    let mut strangers = 0;
    for sample in samples(make(), stream) {
        check(&sample);
        match expected[from..].iter().position(|e| *e == sample) {
            Some(at) => {
                came[from + at] = true;
                from += at + 1;
            }
            None => strangers += 1,
        }
    }
    let mut run = 0;
    let mut longest = 0;
    for came in came {
        run = if came { 0 } else { run + 1 };
        longest = longest.max(run);
    }
    damage.longest_loss = damage.longest_loss.max(longest);
    damage.with_loss += u32::from(longest > 0);
    strangers
}

/// That a sample holds nothing that its type does not allow.
pub(crate) fn check(sample: &Sample) {
    if let Some(position) = sample.head.position {
        assert!(position.value.is_finite(), "{sample:?}");
        assert!(position.value.abs().max_element() < 200.0, "{sample:?}");
    }
    if let Some(orientation) = sample.head.orientation {
        assert!(orientation.value.is_normalized(), "{sample:?}");
    }
}

/// That a stream gives the same events however it is cut.
pub(crate) fn any_split<D: Decoder>(make: impl Fn() -> D, stream: &[u8]) {
    let whole = events(make(), stream);
    assert!(!whole.is_empty());
    let mut random = Random(11);
    for longest in [1, 2, 7, 64] {
        let mut decoder = make();
        let mut pieces = Vec::new();
        let mut rest = stream;
        while !rest.is_empty() {
            let (piece, after) = rest.split_at((1 + random.below(longest)).min(rest.len()));
            decoder.feed(piece, Micros(7), &mut |event| pieces.push(event));
            rest = after;
        }
        assert_eq!(pieces, whole, "in pieces of up to {longest}");
        let counts = decoder.counts();
        assert_eq!(counts.bytes, stream.len() as u64);
        let count = |what: fn(&Event) -> bool| pieces.iter().filter(|e| what(e)).count() as u64;
        assert_eq!(counts.samples, count(|e| matches!(e, Event::Sample(_))));
        assert_eq!(counts.messages, count(|e| matches!(e, Event::Message(_))));
    }
}

/// Feeds random bytes, a million (`SHISEN_HEAVY=1`: a hundred million), and
/// returns how many they were and how many passed as samples.
pub(crate) fn random_bytes(mut decoder: impl Decoder, seed: u64) -> (u64, u64) {
    let heavy = std::env::var_os("SHISEN_HEAVY").is_some();
    let count: u64 = match (cfg!(miri), heavy) {
        (true, _) => 512,
        (_, true) => 100_000_000,
        _ => 1_000_000,
    };
    let mut random = Random(seed);
    let mut passed = 0;
    let mut dropped = 0;
    for _ in 0..count / 256 {
        let mut piece = [0; 256];
        for chunk in piece.chunks_exact_mut(8) {
            chunk.copy_from_slice(&random.next().to_le_bytes());
        }
        decoder.feed(&piece, Micros(0), &mut |event| match event {
            Event::Sample(sample) => {
                check(&sample);
                passed += 1;
            }
            Event::Dropped(piece) => dropped += u64::from(piece.bytes),
            Event::Message(_) => {}
        });
    }
    let fed = count / 256 * 256;
    assert_eq!(decoder.counts().bytes, fed);
    assert_eq!(decoder.counts().dropped_bytes, dropped);
    assert!(dropped <= fed);
    (fed, passed)
}
