//! Measures the driver on a Cortex-M7: bytes of state, and instructions, which the
//! emulator's clock counts: each takes a nanosecond.
//!
//! Ends with an error if a cost exceeds its bound, which is a sixth above the value
//! measured when it was set.
#![no_std]
#![no_main]

use core::hint::black_box;
use cortex_m_rt::entry;
use cortex_m_semihosting::hprintln;
use shisen_firmware::measure;
use shisen_tracker::clock::{ClockConfig, ClockEstimator};
use shisen_tracker::decoder::{Decoder, Event};
use shisen_tracker::estimate::{EstimatorConfig, GazeEstimator};
use shisen_tracker::eye::{adhawk::AdHawk, asl, iscan::Iscan};
use shisen_tracker::head::fastrak::{self, Fastrak};
use shisen_tracker::head::flock::{self, Flock, Mode};
use shisen_tracker::head::polhemus::{Family, Format, ItemList};
use shisen_tracker::head::{hatire::Hatire, liberty::Liberty, osvr_hdk};
use shisen_tracker::hid::eye_tracker::{Axes, EyeTracker, documented};
use shisen_tracker::link::Link;
use shisen_tracker::mock::{Tracker, TrackerConfig, Viewer, ViewerConfig, Wire};
use shisen_tracker::protocol::Protocol;
use shisen_tracker::time::Micros;

/// Repetitions of a step, enough to measure it to an instruction or two.
const REPEATS: u32 = 40;
/// Records of each protocol.
const RECORDS: usize = 20;
/// Samples of the estimators: 2 s.
const SAMPLES: usize = 1_000;

/// Settings of a FASTRAK: the default, angles, a matrix, and text. Each has name, item
/// list, format and bound.
const FASTRAKS: [(&str, &[u8], Format, u32); 4] = [
    ("fastrak", &[2, 11, 0], Format::Binary, 3_500),
    ("fastrak-angles", &[2, 4, 0], Format::Binary, 3_750),
    ("fastrak-matrix", &[2, 5, 6, 7, 0], Format::Binary, 4_100),
    ("fastrak-text", &[2, 4, 0], Format::Ascii, 5_000),
];

/// Settings of a Flock of Birds, likewise.
const FLOCKS: [(&str, Mode, u32); 3] = [
    ("flock", Mode::PositionQuaternion, 1_000),
    ("flock-angles", Mode::PositionAngles, 1_100),
    ("flock-matrix", Mode::PositionMatrix, 1_250),
];

fn instructions(run: impl FnMut()) -> u32 {
    measure::instructions(REPEATS, run)
}

/// Returns the instructions of `step` on a copy of `state`, without those of the copy.
fn of_step<T: Clone>(state: &T, mut step: impl FnMut(&mut T)) -> u32 {
    let both = instructions(|| {
        let mut copy = black_box(state).clone();
        step(&mut copy);
        black_box(&copy);
    });
    let copied = instructions(|| {
        black_box(&black_box(state).clone());
    });
    both.saturating_sub(copied)
}

/// The mean and the largest of some costs.
#[derive(Default)]
struct Tally {
    count: u32,
    sum: u32,
    most: u32,
}

impl Tally {
    fn note(&mut self, instructions: u32) {
        self.count += 1;
        self.sum += instructions;
        self.most = self.most.max(instructions);
    }

    fn mean(&self) -> u32 {
        self.sum / self.count.max(1)
    }
}

fn tracker() -> Option<Tracker<'static>> {
    let viewer = Viewer::new(ViewerConfig::default(), 3);
    Tracker::new(TrackerConfig::default(), viewer, 3).ok()
}

/// The printed report, which holds whether all costs are within their bounds.
struct Report(bool);

impl Report {
    /// Measures a decoder that takes single bytes, or (`whole`) whole reports.
    fn decoder<D: Decoder + Clone>(
        &mut self,
        name: &str,
        protocol: Protocol,
        mut decoder: D,
        whole: bool,
        bound: u32,
    ) -> Option<()> {
        let mut wire = Wire::new(tracker()?, protocol);
        let mut source = tracker()?;
        let mut last = Tally::default();
        let mut byte = Tally::default();
        let mut bytes = 0;
        for _ in 0..RECORDS {
            let (_, sample) = source.next_sample();
            let chunk = wire.encode(&sample)?;
            bytes = chunk.bytes().len();
            for piece in chunk.bytes().chunks(if whole { bytes } else { 1 }) {
                let feed = |decoder: &mut D, found: &mut bool| {
                    decoder.feed(black_box(piece), Micros(1), &mut |event| {
                        *found |= matches!(black_box(event), Event::Sample(_));
                    });
                };
                let mut found = false;
                let cost = of_step(&decoder, |decoder| feed(decoder, &mut found));
                feed(&mut decoder, &mut found);
                if found { &mut last } else { &mut byte }.note(cost);
            }
        }
        let (mean, most) = (last.mean(), last.most);
        let (others, all) = (byte.mean(), (last.sum + byte.sum) / last.count.max(1));
        let state = size_of::<D>();
        let few = last.count as usize + 1 < RECORDS;
        let fits = most <= bound && !few;
        let verdict = if fits { "" } else { "  TOO MUCH" };
        hprintln!(
            "{name:<14} {bytes:>6} {mean:>7} {most:>7} {bound:>7} {others:>7} {all:>7} {state:>6}{verdict}"
        );
        self.0 &= fits;
        Some(())
    }

    fn row(&mut self, name: &str, tally: &Tally, bound: u32, state: usize) {
        let (mean, most) = (tally.mean(), tally.most);
        let fits = most <= bound && tally.count > 0;
        let verdict = if fits { "" } else { "  TOO MUCH" };
        hprintln!("{name:<16} {mean:>7} {most:>7} {bound:>7} {state:>23}{verdict}");
        self.0 &= fits;
    }

    fn decoders(&mut self) -> Option<()> {
        hprintln!("instructions         last byte to sample             each     whole  bytes of");
        hprintln!("protocol        bytes    mean    most   bound   other  record  state");
        let named = Protocol::named;
        self.decoder("link", named("link")?, Link::new(), false, 3_900)?;
        for (name, items, format, bound) in FASTRAKS {
            let items = ItemList::new(Family::Fastrak, format, items).ok()?;
            let config = fastrak::Config::new(items);
            let decoder = Fastrak::new(config.clone());
            self.decoder(name, Protocol::Fastrak(config), decoder, false, bound)?;
        }
        let Protocol::Liberty(config) = named("liberty")? else {
            return None;
        };
        let decoder = Liberty::new(config.clone());
        self.decoder("liberty", Protocol::Liberty(config), decoder, false, 3_600)?;
        for (name, mode, bound) in FLOCKS {
            let config = flock::Config {
                mode,
                ..flock::Config::default()
            };
            let decoder = Flock::new(config);
            self.decoder(name, Protocol::Flock(config), decoder, false, bound)?;
        }
        let decoder = Hatire::new(Default::default());
        self.decoder("hatire", named("hatire")?, decoder, false, 1_100)?;
        let decoder = Iscan::new(Default::default());
        self.decoder("iscan", named("iscan")?, decoder, false, 650)?;
        let decoder = asl::Asl::new(Default::default());
        self.decoder("asl", named("asl")?, decoder, false, 650)?;
        self.decoder("adhawk", named("adhawk")?, AdHawk::new(), false, 5_000)?;
        let decoder = osvr_hdk::OsvrHdk::new();
        self.decoder("osvr-hdk", named("osvr-hdk")?, decoder, true, 300)?;
        let hid = EyeTracker::new(&documented::DESCRIPTOR, Axes::default()).ok()?;
        self.decoder("hid", named("hid")?, hid, true, 4_700)?;
        let mut opened = Tally::default();
        opened.note(instructions(|| {
            let descriptor = black_box(&documented::DESCRIPTOR);
            black_box(EyeTracker::new(descriptor, Axes::default()).is_ok());
        }));
        hprintln!("");
        hprintln!("step                mean    most   bound         bytes of state");
        self.row("HID descriptor", &opened, 29_000, 0);
        Some(())
    }

    fn estimators(&mut self) -> Option<()> {
        let mut source = tracker()?;
        let mut clock = ClockEstimator::new(ClockConfig::default()).ok()?;
        let mut gaze = GazeEstimator::new(EstimatorConfig::default()).ok()?;
        let [mut stamp, mut push, mut estimate] = [(); 3].map(|()| Tally::default());
        for _ in 0..SAMPLES {
            let (_, sample) = source.next_sample();
            stamp.note(of_step(&clock, |clock| {
                black_box(clock.stamp(black_box(&sample), &mut |_| {}));
            }));
            let time = clock.stamp(&sample, &mut |_| {}).time;
            push.note(of_step(&gaze, |gaze| {
                gaze.push(black_box(&sample), black_box(time), &mut |_| {});
            }));
            gaze.push(&sample, time, &mut |_| {});
            let shown = time.after(Micros::from_millis(20));
            estimate.note(of_step(&gaze, |gaze| {
                black_box(gaze.estimate(black_box(shown), &mut |_| {}));
            }));
        }
        self.row("clock", &stamp, 1_100, size_of::<ClockEstimator>());
        self.row("sample to gaze", &push, 56_000, size_of::<GazeEstimator>());
        self.row("line of sight", &estimate, 4_300, 0);
        Some(())
    }
}

#[entry]
fn main() -> ! {
    let mut report = Report(true);
    measure::start();
    let done = report.decoders().and_then(|()| report.estimators());
    let fits = report.0 && done.is_some();
    hprintln!("{}", if fits { "all within bounds" } else { "FAILED" });
    measure::end(fits)
}
