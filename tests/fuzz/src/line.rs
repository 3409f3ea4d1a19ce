//! A decoder of every tracker protocol and what stands behind it: no panic, no
//! unusable number, every byte accounted for, and a line of sight that is one.
//! For the fuzz targets, and for the tests with damaged streams.

use glam::Vec3;
use shisen_tracker::clock::{ClockConfig, ClockEstimator};
use shisen_tracker::decoder::{Decoder, Event};
use shisen_tracker::estimate::{EstimatorConfig, GazeEstimator};
use shisen_tracker::mock::{Tracker, TrackerConfig, Viewer, ViewerConfig, Wire};
use shisen_tracker::protocol::{Protocol, Reader};
use shisen_tracker::sample::{Eye, GazePoint, Pupil, Sample};
use shisen_tracker::time::Micros;

/// Returns what reads a protocol.
pub(crate) fn decoder(protocol: &Protocol) -> Reader {
    Reader::new(protocol).expect("the documented descriptor")
}

/// Records of a protocol.
pub(crate) fn records(name: &str, seed: u64, count: usize) -> Vec<Vec<u8>> {
    let viewer = Viewer::new(ViewerConfig::default(), seed);
    let tracker = Tracker::new(TrackerConfig::default(), viewer, seed);
    let mut tracker = tracker.expect("the default configuration");
    let protocol = Protocol::named(name).expect("a name of the list");
    let mut wire = Wire::new(tracker.clone(), protocol);
    (0..count)
        .filter_map(|_| wire.encode(&tracker.next_sample().1))
        .map(|chunk| chunk.bytes().to_vec())
        .collect()
}

/// Checks that a sample's numbers are what [`Sample`] promises.
pub(crate) fn assert_usable(name: &str, sample: &Sample) {
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
pub(crate) struct Line {
    name: &'static str,
    pub(crate) decoder: Reader,
    clock: ClockEstimator,
    gaze: GazeEstimator,
    pub(crate) now: Micros,
    dropped: u64,
    /// That came of the bytes so far.
    pub(crate) samples: u64,
}

impl Line {
    /// Returns the line of a protocol, by its name.
    pub(crate) fn new(name: &'static str) -> Self {
        let protocol = Protocol::named(name).expect("a name of the list");
        Self {
            name,
            decoder: decoder(&protocol),
            clock: ClockEstimator::new(ClockConfig::default()).expect("the default"),
            gaze: GazeEstimator::new(EstimatorConfig::default()).expect("the default"),
            now: Micros(1_000_000),
            dropped: 0,
            samples: 0,
        }
    }

    /// Takes bytes, 2 ms after the last ones.
    pub(crate) fn feed(&mut self, bytes: &[u8]) {
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

    /// Checks what holds after a stream of `fed` bytes: each is reported exactly once.
    pub(crate) fn finish(&self, fed: usize) {
        let counts = self.decoder.counts();
        let name = self.name;
        assert_eq!(counts.bytes, fed as u64, "{name}");
        assert_eq!(counts.samples, self.samples, "{name}");
        assert_eq!(counts.dropped_bytes, self.dropped, "{name}");
        assert!(counts.dropped_bytes <= counts.bytes, "{name}: {counts:?}");
    }
}
