//! What the decoders' tests share: faults in a stream, random bytes, cuts.

use crate::decoder::{Decoder, DropReason, Event};
use crate::protocol::Protocol;
use crate::sample::{Eye, GazePoint, Pupil, Reading, Sample};
use crate::time::{DeviceTime, Micros};
use glam::{Quat, Vec3};
use std::vec::Vec;

/// When everything comes in.
pub(crate) const ARRIVAL: Micros = Micros(1_000_000);

/// All events of some bytes.
pub(crate) fn events(decoder: &mut impl Decoder, bytes: &[u8]) -> Vec<Event> {
    let mut events = Vec::new();
    decoder.feed(bytes, ARRIVAL, &mut |event| events.push(event));
    events
}

/// The samples among them.
pub(crate) fn samples(decoder: &mut impl Decoder, bytes: &[u8]) -> Vec<Sample> {
    let only = |event| match event {
        Event::Sample(sample) => Some(sample),
        _ => None,
    };
    events(decoder, bytes)
        .into_iter()
        .filter_map(only)
        .collect()
}

/// Why bytes were dropped, in order.
pub(crate) fn dropped(decoder: &mut impl Decoder, bytes: &[u8]) -> Vec<DropReason> {
    let only = |event| match event {
        Event::Dropped(dropped) => Some(dropped.reason),
        _ => None,
    };
    events(decoder, bytes)
        .into_iter()
        .filter_map(only)
        .collect()
}

/// Pseudo-random numbers (xorshift, Marsaglia).
pub(crate) struct Random(pub(crate) u64);

impl Random {
    pub(crate) fn next(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0
    }

    /// From 0 to just below 1.
    pub(crate) fn unit(&mut self) -> f32 {
        (self.next() >> 40) as f32 / 16_777_216.0
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
            let mut sample = Sample::arrived(ARRIVAL);
            sample.device_time = Some(DeviceTime::unwrapped(1_000_000 + i as u64 * 8_000));
            sample.sequence = Some(i as u32);
            sample.head.position = Some(Reading::tracked(place));
            sample.head.orientation = Some(Reading::tracked(turn));
            sample
        })
        .collect()
}

/// A head as the mock's tracker sees it, with its noise: ten times a second, so that
/// no two of them are alike in a coarse form.
pub(crate) fn mock_head(count: usize) -> Vec<Sample> {
    use crate::mock::{Tracker, TrackerConfig, Viewer, ViewerConfig};
    let config = TrackerConfig {
        rate: 60,
        ..TrackerConfig::default()
    };
    let viewer = Viewer::new(ViewerConfig::default(), 9);
    let mut tracker = Tracker::new(config, viewer, 9).unwrap();
    let mut samples = core::iter::repeat_with(|| tracker.next_sample().1).step_by(6);
    let heads = samples.by_ref().skip(1).take(count).map(|mut sample| {
        sample.arrival = ARRIVAL;
        sample
    });
    heads.collect()
}

/// What the mock says in a protocol of that name, ten times a second: records of which
/// no two are alike, so without the further ones of a blink.
pub(crate) fn mock_records(name: &str, count: usize) -> Vec<Vec<u8>> {
    use crate::mock::{Tracker, TrackerConfig, Viewer, ViewerConfig, Wire};
    let config = TrackerConfig {
        rate: 60,
        ..TrackerConfig::default()
    };
    let viewer = Viewer::new(ViewerConfig::default(), 9);
    let tracker = Tracker::new(config, viewer, 9).unwrap();
    let mut wire = Wire::new(tracker, Protocol::named(name).unwrap());
    let mut records: Vec<Vec<u8>> = Vec::new();
    for i in 0.. {
        let (_, mut sample) = wire.source().next_sample();
        sample.arrival = ARRIVAL;
        if i % 6 == 0
            && let Some(record) = wire.encode(&sample)
            && !records.iter().any(|other| other == record.bytes())
        {
            records.push(record.bytes().into());
        }
        if records.len() == count {
            break;
        }
    }
    records
}

/// All protocols of serial lines as is usual, and Flock's other modes, which believe
/// more.
pub(crate) fn serial_lines() -> Vec<(std::string::String, Protocol)> {
    use crate::head::flock::{self, Mode};
    let serial = Protocol::NAMES[..]
        .iter()
        .filter(|name| !["osvr-hdk", "hid"].contains(name));
    let serial = serial.map(|name| ((*name).into(), Protocol::named(name).unwrap()));
    let modes = Mode::ALL.into_iter().map(|mode| {
        let config = flock::Config {
            mode,
            ..flock::Config::default()
        };
        (std::format!("{mode:?}"), Protocol::Flock(config))
    });
    serial.chain(modes).collect()
}

/// The angle between two rotations, radians, while it is small.
pub(crate) fn angle(a: Quat, b: Quat) -> f32 {
    2.0 * (a - b).length().min((a + b).length())
}

/// What can happen to one byte.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Fault {
    Dropped,
    /// Its bits exclusive-or this.
    Flipped(u8),
    /// This before it.
    Inserted(u8),
    Duplicated,
}

impl Fault {
    /// Each kind, with bytes that mean something to one protocol or another;
    /// with every byte where `SHISEN_HEAVY` asks for it.
    pub(crate) fn all() -> Vec<Self> {
        let (flips, inserts): (Vec<u8>, Vec<u8>) = if is_heavy() {
            ((1..=255).collect(), (0..=255).collect())
        } else {
            let flips = (0..8).map(|bit| 1 << bit).chain([0xFF, 0x55]);
            let inserts = [0x00, 0x01, 0x20, 0x44, 0x5A, 0x7F, 0x80, 0xAA, 0xFF];
            (flips.collect(), inserts.into())
        };
        [Self::Dropped, Self::Duplicated]
            .into_iter()
            .chain(flips.into_iter().map(Self::Flipped))
            .chain(inserts.into_iter().map(Self::Inserted))
            .collect()
    }

    pub(crate) fn apply(self, stream: &[u8], offset: usize) -> Vec<u8> {
        let (before, after) = stream.split_at(offset);
        let (byte, rest) = (after[0], &after[1..]);
        let instead = match self {
            Self::Dropped => Vec::new(),
            Self::Flipped(bits) => [byte ^ bits].to_vec(),
            Self::Inserted(other) => [other, byte].to_vec(),
            Self::Duplicated => [byte, byte].to_vec(),
        };
        [before, &instead, rest].concat()
    }

    /// The place in [`Tally::wrong`].
    fn kind(self) -> usize {
        match self {
            Self::Dropped => 0,
            Self::Flipped(_) => 1,
            Self::Inserted(_) => 2,
            Self::Duplicated => 3,
        }
    }
}

/// What single-byte faults did: for each kind of fault (dropped, flipped,
/// inserted, duplicated) how many there were and how many wrong samples came
/// through, and the most intact records that any of them cost.
#[derive(Debug, Default)]
pub(crate) struct Tally {
    pub(crate) faults: [u32; 4],
    pub(crate) wrong: [u32; 4],
    pub(crate) most_intact_lost: usize,
}

impl Tally {
    /// Both together.
    pub(crate) fn and(mut self, other: &Self) -> Self {
        for kind in 0..4 {
            self.faults[kind] += other.faults[kind];
            self.wrong[kind] += other.wrong[kind];
        }
        self.most_intact_lost = self.most_intact_lost.max(other.most_intact_lost);
        self
    }

    /// Holds what all faults did against the row of that name in a module's
    /// docs, and prints that row as it should be. The docs tell of all faults:
    /// where only some were done, rates are not compared.
    pub(crate) fn assert_stated(&self, name: &str, docs: &str) {
        let lost = self.most_intact_lost;
        let rates = self.rates();
        let cells = rates.map(|rate| std::format!("{rate:.3} | ")).concat();
        std::println!("//! | {name} | {cells}{lost} |");
        let begin = std::format!("//! | {name} | ");
        let row = docs.lines().find_map(|line| line.strip_prefix(&begin[..]));
        let row = row.unwrap_or_else(|| panic!("{name} is not in the table"));
        let stated: Vec<f32> = row
            .split('|')
            .flat_map(|cell| cell.trim().parse())
            .collect();
        assert_eq!(stated.len(), 5, "{name}: {row}");
        assert!(lost as f32 <= stated[4], "{name}: {lost} lost, {row}");
        if is_heavy() && !cfg!(miri) {
            for (rate, stated) in rates.iter().zip(&stated) {
                assert!((rate - stated).abs() < 0.001, "{name}: {rates:?}, {row}");
            }
        }
    }

    /// Where only some faults were done: their rates.
    pub(crate) fn assert_usual(&self, name: &str, expected: [f32; 4]) {
        if is_heavy() || cfg!(miri) {
            return;
        }
        let rates = self.rates();
        for (rate, expected) in rates.iter().zip(expected) {
            assert!((rate - expected).abs() < 0.005, "{name}: {rates:?}");
        }
    }

    /// Wrong samples for each fault of a kind.
    pub(crate) fn rates(&self) -> [f32; 4] {
        let mut rates = [0.0; 4];
        for (rate, (wrong, faults)) in rates.iter_mut().zip(self.wrong.iter().zip(self.faults)) {
            *rate = *wrong as f32 / faults as f32;
        }
        rates
    }
}

/// How many records come before the one that is damaged.
const CLEAN_HEAD: usize = 2;

/// How many records follow the one that is damaged.
const CLEAN_TAIL: usize = 6;

/// Puts each fault at each offset of a stream of records, each of which is
/// one sample and no two the same, and looks at what comes out. The decoder
/// is in step before the fault: it sees the records from [`CLEAN_HEAD`] before
/// it to [`CLEAN_TAIL`] behind it.
///
/// An intact record is one that the fault did not touch. Of these only the
/// one before (which may be waiting for what is touched) and the three after
/// may be lost; how many are is in [`Tally::most_intact_lost`].
pub(crate) fn every_fault<D: Decoder>(new: impl Fn() -> D, records: &[Vec<u8>]) -> Tally {
    let truth = samples(&mut new(), &records.concat().repeat(2));
    let truth = &truth[..records.len()];
    for (i, sample) in truth.iter().enumerate() {
        assert!(!truth[..i].contains(sample), "record {i} is not unlike");
    }
    let mut tally = Tally::default();
    let faults = Fault::all();
    let step = if cfg!(miri) { 37 } else { 1 };
    let places = records.iter().enumerate();
    let places = places.flat_map(|(i, record)| (0..record.len()).map(move |at| (i, at)));
    let places = places.filter(|&(i, _)| (CLEAN_HEAD..records.len() - CLEAN_TAIL).contains(&i));
    for (touched, at) in places.step_by(step) {
        let first = touched - CLEAN_HEAD;
        let seen = first..=touched + CLEAN_TAIL;
        let stream = records[seen.clone()].concat();
        let truth = &truth[seen];
        let touched = CLEAN_HEAD;
        let offset = records[first..first + touched].concat().len() + at;
        for &fault in &faults {
            let found = samples(&mut new(), &fault.apply(&stream, offset));
            let seen: Vec<Option<usize>> = found
                .iter()
                .map(|sample| truth.iter().position(|t| t == sample))
                .collect();
            tally.faults[fault.kind()] += 1;
            tally.wrong[fault.kind()] += seen.iter().filter(|s| s.is_none()).count() as u32;
            // The last of all may still wait for the one behind it.
            let lost: Vec<usize> = (0..truth.len() - 1)
                .filter(|&i| i != touched && !seen.contains(&Some(i)))
                .collect();
            for &i in &lost {
                assert!(
                    (touched..=touched + 4).contains(&(i + 1)),
                    "{fault:?} at {at} of record {}: lost {lost:?}, touched {touched}",
                    first + touched
                );
            }
            tally.most_intact_lost = tally.most_intact_lost.max(lost.len());
        }
    }
    tally
}

/// [`every_fault`] of a head that moves much, and of the mock's.
pub(crate) fn every_fault_of_heads<D: Decoder>(
    new: impl Fn() -> D,
    encode: impl Fn(&Sample) -> Vec<u8>,
) -> Tally {
    let count = if cfg!(miri) { 10 } else { 24 };
    [moving_head(count), mock_head(count)]
        .iter()
        .map(|heads| heads.iter().map(&encode).collect::<Vec<_>>())
        .map(|records| every_fault(&new, &records))
        .fold(Tally::default(), |all, found| all.and(&found))
}

/// Any cut of the stream gives the same events.
pub(crate) fn any_split<D: Decoder>(new: impl Fn() -> D, stream: &[u8]) {
    let stream = if cfg!(miri) {
        stream.get(..150).unwrap_or(stream)
    } else {
        stream
    };
    let whole = events(&mut new(), stream);
    let sizes: &[usize] = if cfg!(miri) { &[1] } else { &[1, 2, 3, 7, 64] };
    for &size in sizes {
        let mut decoder = new();
        let pieces: Vec<Event> = stream
            .chunks(size)
            .flat_map(|piece| events(&mut decoder, piece))
            .collect();
        assert_eq!(pieces, whole, "in pieces of {size}");
    }
    let cuts = if cfg!(miri) { 3 } else { stream.len() };
    for cut in 0..cuts {
        let mut decoder = new();
        let mut pieces = events(&mut decoder, &stream[..cut]);
        pieces.extend(events(&mut decoder, &[]));
        pieces.extend(events(&mut decoder, &stream[cut..]));
        assert_eq!(pieces, whole, "cut at {cut}");
    }
}

/// Whether tests are to be of their full sizes.
fn is_heavy() -> bool {
    std::env::var("SHISEN_HEAVY").is_ok_and(|value| !value.is_empty() && value != "0")
}

/// How many random bytes a test feeds: a million, or the whole number where
/// `SHISEN_HEAVY` asks for it; few in miri.
pub(crate) fn random_count(heavy: u64) -> u64 {
    match (cfg!(miri), is_heavy()) {
        (true, _) => 1_000,
        (false, true) => heavy,
        (false, false) => 1_000_000,
    }
}

/// Feeds random bytes and gives back how many samples came of them, all of
/// which hold usable numbers; every byte is accounted for.
pub(crate) fn random_bytes(decoder: &mut impl Decoder, count: u64, seed: u64) -> u64 {
    let mut random = Random(seed);
    let mut found = 0;
    let mut told = 0;
    let mut chunk = [0; 256];
    for _ in 0..count.div_ceil(256) {
        for bytes in chunk.chunks_exact_mut(8) {
            bytes.copy_from_slice(&random.next().to_le_bytes());
        }
        decoder.feed(&chunk, ARRIVAL, &mut |event| match event {
            Event::Sample(sample) => {
                assert_usable(&sample);
                found += 1;
            }
            Event::Dropped(dropped) => told += u64::from(dropped.bytes),
            Event::Message(_) => (),
        });
    }
    let counts = decoder.counts();
    assert_eq!(counts.bytes, count.div_ceil(256) * 256);
    assert_eq!(counts.samples, found);
    assert_eq!(counts.dropped_bytes, told);
    found
}

/// What a sample promises.
pub(crate) fn assert_usable(sample: &Sample) {
    let head = &sample.head;
    if let Some(position) = head.position {
        assert!(position.value.is_finite(), "{sample:?}");
    }
    if let Some(orientation) = head.orientation {
        assert!(
            (orientation.value.length() - 1.0).abs() < 2e-3,
            "{sample:?}"
        );
    }
    if let Some(velocity) = head.angular_velocity {
        assert!(velocity.is_finite(), "{sample:?}");
    }
    for eye in [&sample.left, &sample.right, &sample.combined] {
        assert_usable_eye(eye);
    }
    match sample.gaze_point.map(|point| point.value) {
        Some(GazePoint::Plane(p) | GazePoint::Normalized(p) | GazePoint::Raw(p)) => {
            assert!(p.is_finite(), "{sample:?}");
        }
        None => (),
    }
}

fn assert_usable_eye(eye: &Eye) {
    if let Some(origin) = eye.origin {
        assert!(origin.value.is_finite(), "{eye:?}");
    }
    if let Some(direction) = eye.direction {
        assert!((direction.value.length() - 1.0).abs() < 2e-3, "{eye:?}");
    }
    if let Some(Pupil::Diameter(size) | Pupil::Raw(size)) = eye.pupil {
        assert!(size.is_finite() && size >= 0.0, "{eye:?}");
    }
    if let Some(openness) = eye.openness {
        assert!((0.0..=1.0).contains(&openness), "{eye:?}");
    }
}
