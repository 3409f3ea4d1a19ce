//! What the decoders' tests share: faults in a stream, random bytes, cuts, round trips.

use crate::command::{Action, Script, Session};
use crate::decoder::{Decoder, DropReason, Event};
use crate::mock::{Tracker, TrackerConfig, Viewer, ViewerConfig, Wire};
use crate::protocol::Protocol;
use crate::sample::{Pupil, Reading, Sample};
use crate::time::{DeviceTime, Micros};
use glam::{Quat, Vec2, Vec3};
use std::vec::Vec;

/// The arrival of all bytes.
pub(crate) const ARRIVAL: Micros = Micros(1_000_000);

/// Returns all events of some bytes.
pub(crate) fn events(decoder: &mut impl Decoder, bytes: &[u8]) -> Vec<Event> {
    let mut events = Vec::new();
    decoder.feed(bytes, ARRIVAL, &mut |event| events.push(event));
    events
}

/// Returns the samples among them.
pub(crate) fn samples(decoder: &mut impl Decoder, bytes: &[u8]) -> Vec<Sample> {
    let events = events(decoder, bytes).into_iter();
    let sample = |event| match event {
        Event::Sample(sample) => Some(sample),
        _ => None,
    };
    events.filter_map(sample).collect()
}

/// Why bytes were dropped, in order.
pub(crate) fn dropped(decoder: &mut impl Decoder, bytes: &[u8]) -> Vec<DropReason> {
    let events = events(decoder, bytes).into_iter();
    let reason = |event| match event {
        Event::Dropped(dropped) => Some(dropped.reason),
        _ => None,
    };
    events.filter_map(reason).collect()
}

/// Returns the event of bytes that were dropped.
pub(crate) const fn thrown(bytes: u32, reason: DropReason) -> Event {
    Event::dropped(bytes, reason)
}

/// Returns the event of a reply without a meaning.
pub(crate) fn reply(to: u32, result: u32) -> Event {
    Event::reply(to, result, "")
}

/// Returns the commands that a script sends to a device that streams samples.
pub(crate) fn said(script: Script) -> Vec<Vec<u8>> {
    let mut session = Session::new(script);
    let (mut now, mut said) = (Micros(0), Vec::new());
    loop {
        match session.poll(now) {
            Action::Send(bytes) => said.push(bytes.to_vec()),
            Action::Speed(_) => {}
            Action::Wait(until) => {
                session.on_event(&Event::Sample(Sample::arrived(now)));
                now = until;
            }
            Action::Done => return said,
            Action::Failed(failure) => panic!("{failure}"),
        }
    }
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

/// Returns a tracker of the mock's usual viewer.
pub(crate) fn tracker(config: TrackerConfig, seed: u64) -> Tracker<'static> {
    let viewer = Viewer::new(ViewerConfig::default(), seed);
    Tracker::new(config, viewer, seed).unwrap()
}

/// Returns a tracker of this many samples a second.
pub(crate) fn tracker_at(rate: u32, seed: u64) -> Tracker<'static> {
    let config = TrackerConfig {
        rate,
        ..TrackerConfig::default()
    };
    tracker(config, seed)
}

/// Returns a head that looks around and sways, 125 times a second.
pub(crate) fn moving_head(count: usize) -> Vec<Sample> {
    let samples = (0..count).map(|i| {
        let t = i as f32 * 0.008;
        let (x, z) = (0.31 * (3.0 * t).sin(), -0.4 * (2.0 * t).cos());
        let place = Vec3::new(x, 0.2 + 0.1 * t, z);
        let turn = Quat::from_rotation_y(1.3 * (2.0 * t).sin())
            * Quat::from_rotation_x(0.4 * (5.0 * t).cos())
            * Quat::from_rotation_z(0.1 + t);
        let mut sample = Sample::arrived(ARRIVAL);
        sample.device_time = Some(DeviceTime::unwrapped(1_000_000 + i as u64 * 8_000));
        sample.sequence = Some(i as u32);
        sample.head.position = Some(Reading::tracked(place));
        sample.head.orientation = Some(Reading::tracked(turn));
        sample
    });
    samples.collect()
}

/// How many records faults are put into.
const RECORDS: usize = if cfg!(miri) { 10 } else { 24 };

/// Returns the mock's records in a protocol, ten a second, no two the same.
pub(crate) fn mock_records(protocol: &Protocol) -> Vec<Vec<u8>> {
    let mut wire = Wire::new(tracker_at(60, 9), protocol.clone());
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
        if records.len() == RECORDS {
            break;
        }
    }
    records
}

/// Returns the records of a head that moves much, and the mock's.
pub(crate) fn head_records(
    protocol: &Protocol,
    encode: impl Fn(&Sample) -> Vec<u8>,
) -> [Vec<Vec<u8>>; 2] {
    let moving = moving_head(RECORDS).iter().map(encode).collect();
    [moving, mock_records(protocol)]
}

/// Samples of a moving head come back from the wire as close as this: metres and radians.
pub(crate) fn come_back<D: Decoder>(
    mut decoder: D,
    encode: impl Fn(&Sample) -> Vec<u8>,
    [metres, radians]: [f32; 2],
) {
    for sent in moving_head(if cfg!(miri) { 2 } else { 200 }) {
        let came = samples(&mut decoder, &encode(&sent));
        let [came] = came[..] else {
            panic!("{came:?}");
        };
        if let Some(place) = came.head.position {
            let off = place.value.distance(sent.head.position.unwrap().value);
            assert!(place.tracked && off <= metres, "{off} m");
        }
        if let Some(turn) = came.head.orientation {
            let (a, b) = (turn.value, sent.head.orientation.unwrap().value);
            let off = 2.0 * (a - b).length().min((a + b).length());
            assert!(turn.tracked && off <= radians, "{off} rad");
        }
        if let Some(time) = came.device_time {
            assert_eq!(time.microseconds, sent.device_time.unwrap().microseconds);
        }
        assert!(came.sequence.is_none() || came.sequence == sent.sequence);
    }
}

/// Returns all protocols of serial lines as is usual, and Flock's other modes.
pub(crate) fn serial_lines() -> Vec<(std::string::String, Protocol)> {
    use crate::head::flock::{self, Mode};
    let serial = Protocol::NAMES.map(|name| (name.into(), Protocol::named(name).unwrap()));
    let serial = serial.into_iter().filter(|(_, line)| line.is_serial());
    let modes = Mode::ALL.into_iter().map(|mode| {
        let config = flock::Config {
            mode,
            ..flock::Config::default()
        };
        (std::format!("{mode:?}"), Protocol::Flock(config))
    });
    serial.chain(modes).collect()
}

/// What can happen to one byte: a kind, by its place in [`Tally::wrong`], and another byte.
type Fault = (usize, u8);

/// Returns each kind, with telling bytes; with every byte where `SHISEN_HEAVY` asks for it.
fn all_faults() -> Vec<Fault> {
    let (flips, inserts): (Vec<u8>, Vec<u8>) = if is_heavy() {
        ((1..=255).collect(), (0..=255).collect())
    } else {
        (
            [0x01, 0x04, 0x10, 0x40, 0x55, 0x80, 0x82, 0x88, 0xA0, 0xFF].into(),
            [0x00, 0x01, 0x20, 0x44, 0x7F, 0x80, 0x9C, 0xAA, 0xC3, 0xFF].into(),
        )
    };
    let flips = flips.into_iter().map(|bits| (1, bits));
    let inserts = inserts.into_iter().map(|byte| (2, byte));
    let others = [(0, 0), (3, 0)].into_iter();
    others.chain(flips).chain(inserts).collect()
}

/// Returns the stream with a fault at this byte.
fn with_fault((kind, other): Fault, stream: &[u8], offset: usize) -> Vec<u8> {
    let byte = stream[offset];
    let instead: &[u8] = match kind {
        0 => &[],
        1 => &[byte ^ other],
        2 => &[other, byte],
        _ => &[byte, byte],
    };
    [&stream[..offset], instead, &stream[offset + 1..]].concat()
}

/// What faults of one byte did, by kind: dropped, flipped, inserted, doubled.
#[derive(Debug, Default)]
pub(crate) struct Tally {
    faults: [u32; 4],
    pub(crate) wrong: [u32; 4],
    pub(crate) most_intact_lost: usize,
}

impl Tally {
    /// Holds the parts of faults that make wrong samples, by kind, and the intact records lost to
    /// these bounds, and prints them.
    pub(crate) fn assert_within(&self, name: &str, bounds: [f32; 4], most_lost: usize) {
        let lost = self.most_intact_lost;
        let rates = [0, 1, 2, 3].map(|kind| self.wrong[kind] as f32 / self.faults[kind] as f32);
        std::println!("{name}: {rates:.3?}, intact records lost: {lost}");
        if cfg!(miri) {
            return;
        }
        assert!(lost <= most_lost, "{name}: {lost} lost");
        for ((rate, bound), some) in rates.iter().zip(bounds).zip(SOME) {
            // Where there is to be none, there is none of any.
            let exact = is_heavy() || bound == 0.0;
            let most = bound + if exact { 0.0 } else { some };
            assert!(*rate <= most, "{name}: {rates:?}, {bounds:?}");
        }
    }
}

/// How far the rates of some faults may be above those of all, by the kind of fault.
const SOME: [f32; 4] = [0.03, 0.12, 0.05, 0.03];

/// How many records come before the one that is damaged.
const CLEAN_HEAD: usize = 2;

/// How many records follow the one that is damaged.
const CLEAN_TAIL: usize = 6;

/// Holds a decoder to faults of one byte, any cut, and random bytes, of which this share may pass.
pub(crate) fn hostile<D: Decoder>(
    new: impl Fn() -> D,
    records: &[Vec<Vec<u8>>],
    share: f64,
) -> Tally {
    let mut tally = Tally::default();
    for records in records {
        every_fault(&new, records, &mut tally);
        any_split(&new, &damaged(records));
    }
    let fed = random_count(60_000_000);
    let passed = random_bytes(&mut new(), fed, 17) as f64;
    let most = 1.5 * share * fed as f64;
    assert!(passed <= most + 4.0 * most.sqrt(), "{passed} of {fed}");
    tally
}

/// Puts each fault at each offset; only the intact record before and the three after may be lost.
fn every_fault<D: Decoder>(new: impl Fn() -> D, records: &[Vec<u8>], tally: &mut Tally) {
    let truth = samples(&mut new(), &records.concat().repeat(2));
    let truth = &truth[..records.len()];
    for (i, sample) in truth.iter().enumerate() {
        assert!(!truth[..i].contains(sample), "record {i} is not unlike");
    }
    let faults = all_faults();
    let step = if cfg!(miri) { 37 } else { 1 };
    let places = records.iter().enumerate();
    let places = places.flat_map(|(i, record)| (0..record.len()).map(move |at| (i, at)));
    let places = places.filter(|&(i, _)| (CLEAN_HEAD..records.len() - CLEAN_TAIL).contains(&i));
    for (touched, at) in places.step_by(step) {
        let first = touched - CLEAN_HEAD;
        let seen = first..=touched + CLEAN_TAIL;
        let stream = records[seen.clone()].concat();
        let truth = &truth[seen];
        let offset = records[first..touched].concat().len() + at;
        for &fault in &faults {
            let found = samples(&mut new(), &with_fault(fault, &stream, offset));
            let place = |sample| truth.iter().position(|t| t == sample);
            let seen: Vec<Option<usize>> = found.iter().map(place).collect();
            tally.faults[fault.0] += 1;
            tally.wrong[fault.0] += seen.iter().filter(|s| s.is_none()).count() as u32;
            // The last of all may still wait for the one behind it.
            let lost: Vec<usize> = (0..truth.len() - 1)
                .filter(|&i| i != CLEAN_HEAD && !seen.contains(&Some(i)))
                .collect();
            let near = |i: &usize| (CLEAN_HEAD..=CLEAN_HEAD + 4).contains(&(i + 1));
            let what = (fault, at, touched, &lost);
            assert!(lost.iter().all(near), "{what:?}");
            tally.most_intact_lost = tally.most_intact_lost.max(lost.len());
        }
    }
}

/// Returns some records with a byte flipped, one missing, some too many, and much garbage behind.
fn damaged(records: &[Vec<u8>]) -> Vec<u8> {
    let mut records = records[..8].to_vec();
    let start = records[0][0];
    *records[1].last_mut().unwrap() ^= 0xFF;
    let middle = records[2].len() / 2;
    records[2].remove(middle);
    records[4].splice(..0, [start; 5]);
    [&records.concat()[..], &[7; 300], &[start; 300]].concat()
}

/// Any cut of the stream gives the same events.
fn any_split<D: Decoder>(new: impl Fn() -> D, stream: &[u8]) {
    let stream = &stream[..if cfg!(miri) { 150 } else { stream.len() }];
    let whole = events(&mut new(), stream);
    let sizes: &[usize] = if cfg!(miri) { &[1] } else { &[1, 2, 3, 7, 64] };
    for &size in sizes {
        let mut decoder = new();
        let pieces = stream.chunks(size);
        let pieces: Vec<Event> = pieces.flat_map(|p| events(&mut decoder, p)).collect();
        assert_eq!(pieces, whole, "in pieces of {size}");
    }
    let cuts = if cfg!(miri) { 3 } else { stream.len() };
    for cut in 0..cuts {
        let mut decoder = new();
        let pieces = [&stream[..cut], &[], &stream[cut..]];
        let pieces = pieces.map(|piece| events(&mut decoder, piece)).concat();
        assert_eq!(pieces, whole, "cut at {cut}");
    }
}

/// Returns whether tests are to be of their full sizes.
fn is_heavy() -> bool {
    std::env::var("SHISEN_HEAVY").is_ok_and(|value| !value.is_empty() && value != "0")
}

/// Returns how many random bytes a test feeds: a million, or `heavy` where `SHISEN_HEAVY` asks for
/// it.
pub(crate) fn random_count(heavy: u64) -> u64 {
    match (cfg!(miri), is_heavy()) {
        (true, _) => 1_000,
        (false, true) => heavy,
        (false, false) => 1_000_000,
    }
}

/// Feeds random bytes and returns how many usable samples came; every byte is accounted for.
fn random_bytes(decoder: &mut impl Decoder, count: u64, seed: u64) -> u64 {
    let mut random = Random(seed);
    let (mut found, mut reported) = (0, 0);
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
            Event::Dropped(dropped) => reported += u64::from(dropped.bytes),
            Event::Message(_) => (),
        });
    }
    let counts = decoder.counts();
    assert_eq!(counts.bytes, count.div_ceil(256) * 256);
    assert_eq!((counts.samples, counts.dropped_bytes), (found, reported));
    found
}

/// Asserts what a sample promises: numbers are finite, and directions have length 1.
pub(crate) fn assert_usable(sample: &Sample) {
    let eyes = [&sample.left, &sample.right, &sample.combined];
    let places = eyes.map(|eye| eye.origin.map(|origin| origin.value));
    let position = sample.head.position.map(|position| position.value);
    let vectors = [position, sample.head.angular_velocity];
    for vector in places.into_iter().chain(vectors).flatten() {
        assert!(vector.is_finite(), "{sample:?}");
    }
    let directions = eyes.map(|eye| eye.direction.map(|way| way.value.length()));
    let turn = sample.head.orientation.map(|turn| turn.value.length());
    for length in directions.into_iter().chain([turn]).flatten() {
        assert!((length - 1.0).abs() < 2e-3, "{sample:?}");
    }
    for eye in eyes {
        if let Some(Pupil::Diameter(size) | Pupil::Raw(size)) = eye.pupil {
            assert!(size.is_finite() && size >= 0.0, "{eye:?}");
        }
        assert!(eye.openness.is_none_or(|open| (0.0..=1.0).contains(&open)));
    }
    let point = sample.gaze_point.map(|point| point.value.numbers());
    assert!(point.is_none_or(Vec2::is_finite), "{sample:?}");
}
