//! Damaged streams of every tracker protocol, as the mock sends them and as
//! lines break them: no panic, no unusable number, every byte accounted for,
//! and the decoder back in step. What still comes through goes on to the clock
//! and the estimator, whose line of sight stays one.

use glam::Vec3;
use proptest::prelude::*;
use proptest::sample::Index;
use shisen_tests::sizes::cases;
use shisen_tracker::clock::{ClockConfig, ClockEstimator};
use shisen_tracker::decoder::{Decoder, Event};
use shisen_tracker::estimate::{EstimatorConfig, GazeEstimator};
use shisen_tracker::eye::{adhawk::AdHawk, asl, iscan::Iscan};
use shisen_tracker::head::{
    fastrak::Fastrak, flock::Flock, hatire::Hatire, liberty::Liberty, osvr_hdk,
};
use shisen_tracker::hid::eye_tracker::{Axes, EyeTracker, Mode, documented};
use shisen_tracker::link::Link;
use shisen_tracker::mock::{Format, Tracker, TrackerConfig, Viewer, ViewerConfig, Wire};
use shisen_tracker::sample::{Eye, GazePoint, Pupil, Sample};
use shisen_tracker::time::Micros;

fn decoder(format: &Format) -> Box<dyn Decoder> {
    match format.clone() {
        Format::Link => Box::new(Link::new()),
        Format::Fastrak(config) => Box::new(Fastrak::new(config)),
        Format::Liberty(config) => Box::new(Liberty::new(config)),
        Format::Flock(config) => Box::new(Flock::new(config)),
        Format::Hatire(config) => Box::new(Hatire::new(config)),
        Format::OsvrHdk => Box::new(osvr_hdk::Decoder::new()),
        Format::Iscan(config) => Box::new(Iscan::new(config)),
        Format::Asl(layout) => Box::new(asl::Asl::new(asl::Config {
            layout,
            ..asl::Config::default()
        })),
        Format::AdHawk => Box::new(AdHawk::new()),
        Format::EyeTracker(_) => {
            let tracker = EyeTracker::new(&documented::DESCRIPTOR, Axes::default());
            Box::new(tracker.expect("the documented descriptor"))
        }
        other => panic!("no decoder for {other:?}"),
    }
}

/// Records of a protocol.
fn records(name: &str, seed: u64, count: usize) -> Vec<Vec<u8>> {
    let viewer = Viewer::new(ViewerConfig::default(), seed);
    let tracker = Tracker::new(TrackerConfig::default(), viewer, seed);
    let mut tracker = tracker.expect("the default configuration");
    let format = Format::named(name).expect("a name of the list");
    let mut wire = Wire::new(tracker.clone(), format);
    (0..count)
        .filter_map(|_| wire.encode(&tracker.next_sample().1))
        .map(|chunk| chunk.bytes().to_vec())
        .collect()
}

/// What can happen to a stream; the places are parts of its length.
#[derive(Debug, Clone)]
enum Damage {
    Flip(Index, u8),
    Set(Index, u8),
    Insert(Index, Vec<u8>),
    Cut(Index, usize),
    /// A piece of the stream itself, elsewhere.
    Splice(Index, Index, usize),
    /// A value that means much in one protocol or another, all over a piece.
    Fill(Index, usize, u8),
}

fn damage() -> impl Strategy<Value = Damage> {
    let telling = prop::sample::select(vec![
        0x00, 0x01, 0x10, 0x20, 0x30, 0x44, 0x55, 0x7F, 0x80, 0xAA, 0xFF,
    ]);
    let any_index = any::<Index>;
    prop_oneof![
        (any_index(), 1_u8..).prop_map(|(at, bits)| Damage::Flip(at, bits)),
        (any_index(), any::<u8>()).prop_map(|(at, byte)| Damage::Set(at, byte)),
        (any_index(), prop::collection::vec(any::<u8>(), 1..200))
            .prop_map(|(at, bytes)| Damage::Insert(at, bytes)),
        (any_index(), 1_usize..200).prop_map(|(at, count)| Damage::Cut(at, count)),
        (any_index(), any_index(), 1_usize..200)
            .prop_map(|(from, to, count)| Damage::Splice(from, to, count)),
        (any_index(), 1_usize..64, telling)
            .prop_map(|(at, count, byte)| Damage::Fill(at, count, byte)),
    ]
}

impl Damage {
    fn apply(&self, stream: &mut Vec<u8>) {
        let length = stream.len();
        if length == 0 {
            return;
        }
        let piece = |at: &Index, count: usize| {
            let at = at.index(length);
            at..length.min(at + count)
        };
        match self {
            Self::Flip(at, bits) => stream[at.index(length)] ^= bits,
            Self::Set(at, byte) => stream[at.index(length)] = *byte,
            Self::Insert(at, bytes) => {
                let at = at.index(length);
                stream.splice(at..at, bytes.iter().copied());
            }
            Self::Cut(at, count) => drop(stream.drain(piece(at, *count))),
            Self::Splice(from, to, count) => {
                let copy = stream[piece(from, *count)].to_vec();
                let to = to.index(length);
                stream.splice(to..to, copy);
            }
            Self::Fill(at, count, byte) => stream[piece(at, *count)].fill(*byte),
        }
    }
}

/// The numbers of a sample are what [`Sample`] promises.
fn assert_usable(name: &str, sample: &Sample) {
    let head = &sample.head;
    let unit = |length: f32| (length - 1.0).abs() < 2e-3;
    let place = |eye: &Eye| eye.origin.is_none_or(|origin| origin.value.is_finite());
    let way = |eye: &Eye| eye.direction.is_none_or(|way| unit(way.value.length()));
    let open = |eye: &Eye| eye.openness.is_none_or(|open| (0.0..=1.0).contains(&open));
    let pupil = |eye: &Eye| match eye.pupil {
        Some(Pupil::Diameter(size) | Pupil::Raw(size)) => size.is_finite() && size >= 0.0,
        None => true,
    };
    let point = match sample.gaze_point.map(|point| point.value) {
        Some(GazePoint::Plane(p) | GazePoint::Normalized(p) | GazePoint::Raw(p)) => p.is_finite(),
        None => true,
    };
    let eyes = [&sample.left, &sample.right, &sample.combined];
    let usable = head.position.is_none_or(|place| place.value.is_finite())
        && head
            .orientation
            .is_none_or(|turn| unit(turn.value.length()))
        && head.angular_velocity.is_none_or(Vec3::is_finite)
        && eyes
            .into_iter()
            .all(|eye| place(eye) && way(eye) && open(eye) && pupil(eye))
        && point;
    assert!(usable, "{name}: {sample:?}");
}

/// A decoder and what stands behind it.
struct Line {
    name: &'static str,
    decoder: Box<dyn Decoder>,
    clock: ClockEstimator,
    gaze: GazeEstimator,
    now: Micros,
    dropped: u64,
    samples: u64,
}

impl Line {
    fn new(name: &'static str) -> Self {
        let format = Format::named(name).expect("a name of the list");
        Self {
            name,
            decoder: decoder(&format),
            clock: ClockEstimator::new(ClockConfig::default()).expect("the default"),
            gaze: GazeEstimator::new(EstimatorConfig::default()).expect("the default"),
            now: Micros(1_000_000),
            dropped: 0,
            samples: 0,
        }
    }

    fn feed(&mut self, bytes: &[u8]) {
        let Self {
            name, clock, gaze, ..
        } = self;
        let (dropped, samples) = (&mut self.dropped, &mut self.samples);
        self.now = self.now.after(Micros(2_000));
        self.decoder
            .feed(bytes, self.now, &mut |event| match event {
                Event::Sample(sample) => {
                    *samples += 1;
                    assert_usable(name, &sample);
                    let time = clock.stamp(&sample, &mut |_| {}).time;
                    gaze.push(&sample, time, &mut |_| {});
                }
                Event::Dropped(piece) => *dropped += u64::from(piece.bytes),
                _ => {}
            });
        let shown = self.now.after(Micros(20_000));
        let sight = gaze.estimate(shown, &mut |_| {}).line_of_sight;
        let (eye, forward) = (sight.position(), sight.forward());
        assert!(eye.is_finite(), "{name}: {sight:?}");
        assert!((forward.length() - 1.0).abs() < 1e-3, "{name}: {sight:?}");
    }

    /// After a stream of so many bytes: none is told twice or not at all.
    fn finish(&self, fed: usize) {
        let counts = self.decoder.counts();
        let name = self.name;
        assert_eq!(counts.bytes, fed as u64, "{name}");
        assert_eq!(counts.samples, self.samples, "{name}");
        assert_eq!(counts.dropped_bytes, self.dropped, "{name}");
        assert!(counts.dropped_bytes <= counts.bytes, "{name}: {counts:?}");
    }
}

/// Streams of bytes; a HID device sends whole reports.
const STREAMS: [&str; 8] = [
    "link", "fastrak", "liberty", "flock", "hatire", "iscan", "asl", "adhawk",
];
const REPORTS: [&str; 2] = ["osvr-hdk", "hid"];
/// Intact records behind the damage, of which the first three may be lost, and
/// the last may wait for the one behind it.
const INTACT: usize = 8;

proptest! {
    #![proptest_config(ProptestConfig::with_cases(cases("tracker fuzz", 200, 20_000) as u32))]

    #[test]
    fn damaged_streams(
        seed in 1_u64..1_000,
        damages in prop::collection::vec(damage(), 1..8),
        sizes in prop::collection::vec(1_usize..100, 1..20),
    ) {
        for name in STREAMS {
            let records = records(name, seed, 12 + INTACT);
            let mut stream = records[..12].concat();
            for damage in &damages {
                damage.apply(&mut stream);
            }
            let mut line = Line::new(name);
            let mut rest = &stream[..];
            for &size in sizes.iter().cycle() {
                let (piece, behind) = rest.split_at(size.min(rest.len()));
                line.feed(piece);
                rest = behind;
                if rest.is_empty() {
                    break;
                }
            }
            let before = line.samples;
            for record in &records[12..] {
                line.feed(record);
            }
            line.finish(stream.len() + records[12..].concat().len());
            let found = line.samples - before;
            prop_assert!(found + 4 >= INTACT as u64, "{}: {} of {}", name, found, INTACT);
        }
    }

    #[test]
    fn damaged_reports(
        seed in 1_u64..1_000,
        damages in prop::collection::vec((0_usize..12, damage()), 1..8),
    ) {
        for name in REPORTS {
            let mut records = records(name, seed, 12 + INTACT);
            for (i, damage) in &damages {
                damage.apply(&mut records[*i]);
            }
            let mut line = Line::new(name);
            let mut before = 0;
            for (i, record) in records.iter().enumerate() {
                if i == 12 {
                    before = line.samples;
                }
                line.feed(record);
            }
            line.finish(records.concat().len());
            // The first may have the number of a damaged one.
            prop_assert!(line.samples - before + 1 >= INTACT as u64, "{}", name);
        }
    }

    #[test]
    fn damaged_descriptors(
        damages in prop::collection::vec(damage(), 1..6),
        reports in prop::collection::vec(prop::collection::vec(any::<u8>(), 0..100), 1..10),
    ) {
        let mut descriptor = documented::DESCRIPTOR.to_vec();
        for damage in &damages {
                damage.apply(&mut descriptor);
            }
        if let Ok(mut tracker) = EyeTracker::new(&descriptor, Axes::default()) {
            let intact = records("hid", 1, 3);
            for report in reports.iter().chain(&intact) {
                tracker.feed(report, Micros(1), &mut |event| {
                    if let Event::Sample(sample) = event {
                        assert_usable("hid", &sample);
                    }
                });
                let _ = tracker.capabilities(report);
                let _ = tracker.configuration(report);
                let _ = tracker.status(report);
            }
            if let Some(request) = tracker.mode_request(Mode::ALL) {
                let (_, size) = tracker.feature_reports()[3].expect("it has one");
                prop_assert_eq!(request.len(), size);
            }
        }
    }
}
