use super::*;
use crate::clock::{ClockConfig, ClockEstimator};
use crate::decoder::{Decoder, Event};
use crate::estimate::{EstimatorConfig, GazeEstimator, State};
use crate::protocol::{Protocol, Reader};
use crate::rotation::angle;
use crate::sample::Sample;
use crate::time::Micros;
use glam::Vec3;
use std::vec::Vec;

fn viewer(seed: u64) -> Viewer<'static> {
    Viewer::new(ViewerConfig::default(), seed)
}

fn median(mut values: Vec<f32>) -> f32 {
    values.sort_by(f32::total_cmp);
    values[values.len() / 2]
}

/// Peak speeds are 1.875·A/D, D being the duration by Carpenter's main sequence.
#[test]
#[cfg_attr(miri, ignore = "minutes")]
fn saccades_are_on_the_main_sequence() {
    let config = ViewerConfig {
        jitter: 0.0,
        ..ViewerConfig::default()
    };
    let mut viewer = Viewer::new(config, 5);
    let (mut ratios, mut micro, mut large) = (Vec::new(), 0, 0);
    let mut time = 0;
    while time < 600_000_000 {
        let truth = viewer.truth(Micros(time)).unwrap();
        if matches!(truth.kind, Kind::Saccade | Kind::Microsaccade) {
            let at = |t| viewer.clone().truth(Micros(t)).unwrap().direction;
            let middle = truth.start.0.midpoint(truth.end.0);
            let speed = angle(at(middle - 500), at(middle + 500)) / 0.001;
            let lasts = config.base_duration + config.duration_per_amplitude * truth.amplitude;
            let expected = 1.875 * truth.amplitude / lasts;
            ratios.push(speed / expected);
            if truth.kind == Kind::Microsaccade {
                micro += 1;
                assert!(truth.amplitude < 0.05, "{}", truth.amplitude);
            } else {
                large += 1;
            }
        }
        time = truth.end.0;
    }
    assert!(large > 1_000 && micro > 150, "{large} {micro}");
    let off = ratios.iter().map(|r| (r.ln()).powi(2)).sum::<f32>() / ratios.len() as f32;
    assert!((median(ratios) - 1.0).abs() < 0.02);
    assert!((off.sqrt() - 0.06).abs() < 0.02, "{}", off.sqrt());
}

fn samples(seed: u64, count: usize) -> Vec<Sample> {
    let mut tracker = Tracker::new(TrackerConfig::default(), viewer(seed), seed).unwrap();
    (0..count).map(|_| tracker.next_sample().1).collect()
}

#[test]
fn the_same_seed_gives_the_same_samples() {
    let count = if cfg!(miri) { 10 } else { 3_000 };
    assert_eq!(samples(7, count), samples(7, count));
    assert_ne!(samples(7, count), samples(8, count));
    // And the same on every machine: a sum over the bits, from one run.
    if !cfg!(miri) {
        let mut sum = 0u64;
        for sample in samples(7, 3_000) {
            for eye in [sample.left, sample.right] {
                let direction = eye.direction.map_or(Vec3::ZERO, |d| d.value);
                for part in direction.to_array() {
                    sum = sum.rotate_left(5) ^ u64::from(part.to_bits());
                }
            }
        }
        assert_eq!(sum, SUM);
    }
}

const SUM: u64 = 13_820_931_247_104_716_465;

/// Chunks that hold their numbers, 500 a second, from 8 ms on.
#[derive(Clone)]
struct Numbered(u64);

impl Source for Numbered {
    type Item = Chunk;

    fn poll(&mut self, until: Micros) -> Option<Chunk> {
        let arrival = Micros(8_000 + 2_000 * self.0);
        let due = arrival <= until;
        self.0 += u64::from(due);
        due.then(|| Chunk::new(arrival, &(self.0 - 1).to_le_bytes()))
    }
}

fn number(chunk: &Chunk) -> u64 {
    u64::from_le_bytes(chunk.bytes().try_into().unwrap())
}

/// Returns the chunks that come through faults, polled at some intervals.
fn faulty(config: FaultsConfig, interval: u64, seconds: u64) -> Vec<Chunk> {
    let mut faults = Faults::new(Numbered(0), config, 6).unwrap();
    let mut chunks = Vec::new();
    let mut time = 0;
    while time < seconds * 1_000_000 {
        time += interval;
        while let Some(chunk) = faults.poll(Micros(time)) {
            assert!(chunk.arrival <= Micros(time));
            chunks.push(chunk);
        }
    }
    chunks
}

#[test]
fn faults_do_what_they_are_called() {
    if cfg!(miri) {
        return;
    }
    let with = |change: fn(&mut FaultsConfig)| {
        let mut config = FaultsConfig::default();
        change(&mut config);
        faulty(config, 1_000, 10)
    };
    let plain = with(|_| {});
    assert_eq!(plain.len(), 4_997);
    let share = |found: usize| found as f32 / plain.len() as f32;

    let delayed = with(|c| c.delay = Micros(500_000));
    assert_eq!(delayed.len(), plain.len() - 250);
    for (late, plain) in delayed.iter().zip(&plain) {
        assert_eq!(late.arrival, plain.arrival.after(Micros(500_000)));
        assert_eq!(number(late), number(plain));
    }

    let dropped = with(|c| c.drop = 0.2);
    assert!((share(dropped.len()) - 0.8).abs() < 0.03);
    let doubled = with(|c| c.duplicate = 0.1);
    assert!((share(doubled.len()) - 1.1).abs() < 0.03);

    let passes = |chunks: &[Chunk]| {
        let pairs = chunks.windows(2);
        pairs.filter(|p| number(&p[0]) > number(&p[1])).count()
    };
    let reordered = with(|c| c.reorder = 0.1);
    assert!((share(passes(&reordered)) - 0.09).abs() < 0.03);

    let jittered = with(|c| c.jitter = Micros(20_000));
    assert!(passes(&jittered) > 500);
    assert!(jittered.windows(2).all(|p| p[0].arrival <= p[1].arrival));
    let late = |c: &Chunk| c.arrival.0 - number(c) * 2_000 - 8_000;
    assert!(jittered.iter().all(|c| late(c) <= 20_000));
    assert!(jittered.iter().any(|c| late(c) > 19_000));
    let line = with(|c| (c.jitter, c.in_order) = (Micros(20_000), true));
    assert_eq!(passes(&line), 0);

    // One bit flips, or one byte is lost or doubled.
    let corrupt = with(|c| c.corrupt = 0.1);
    assert_eq!(corrupt.len(), plain.len());
    let changed = corrupt.iter().zip(&plain).filter(|(c, p)| c != p);
    assert!((share(changed.count()) - 0.1).abs() < 0.03);
    assert!(corrupt.iter().all(|c| (7..=9).contains(&c.bytes().len())));

    let stuck = with(|c| (c.stuck, c.stuck_for) = (0.001, Micros(300_000)));
    assert_eq!(stuck.len(), plain.len());
    let pairs = stuck.windows(2);
    let same = pairs.filter(|p| number(&p[0]) == number(&p[1])).count();
    assert!((149..3_000).contains(&same) && same % 149 == 0, "{same}");

    let unplugged = with(|c| (c.disconnect, c.disconnected_for) = (0.001, Micros(1_000_000)));
    let pairs = unplugged.windows(2);
    let gap = pairs.map(|p| p[1].arrival.since(p[0].arrival)).max();
    assert!(gap >= Some(Micros(1_000_000)), "{gap:?}");

    for drop in [1.5, f32::NAN] {
        let config = FaultsConfig {
            drop,
            ..FaultsConfig::default()
        };
        assert!(Faults::new(Numbered(0), config, 1).is_err());
    }
}

#[test]
fn how_often_it_is_polled_changes_nothing() {
    let all = FaultsConfig {
        delay: Micros(30_000),
        jitter: Micros(30_000),
        drop: 0.05,
        duplicate: 0.05,
        reorder: 0.05,
        corrupt: 0.05,
        stuck: 0.001,
        stuck_for: Micros(50_000),
        disconnect: 0.001,
        disconnected_for: Micros(50_000),
        in_order: false,
    };
    let seconds = if cfg!(miri) { 0 } else { 5 };
    let polled = |interval| {
        let mut chunks = faulty(all, interval, seconds);
        chunks.retain(|chunk| chunk.arrival <= Micros(seconds * 1_000_000));
        chunks
    };
    let often = polled(500);
    assert!(often == polled(7_000) && often == polled(1_000_000));
}

/// All faults at once: a gaze that is called fresh is new, and most are right.
#[test]
fn what_is_called_fresh_is_fresh() {
    if cfg!(miri) {
        return;
    }
    let config = TrackerConfig {
        clock_start: 1 << 31,
        clock_drift: 80,
        clock_wraps_at: 1 << 32,
        ..TrackerConfig::default()
    };
    let faults = FaultsConfig {
        jitter: Micros(10_000),
        drop: 0.02,
        duplicate: 0.01,
        reorder: 0.01,
        corrupt: 0.005,
        stuck: 0.000_2,
        stuck_for: Micros(2_000_000),
        disconnect: 0.000_1,
        disconnected_for: Micros(2_000_000),
        in_order: true,
        ..FaultsConfig::default()
    };
    let tracker = Tracker::new(config, viewer(4), 4).unwrap();
    let wire = Wire::new(tracker, Protocol::Link);
    let mut source = Faults::new(wire, faults, 4).unwrap();
    let mut reader = Reader::new(&Protocol::Link).unwrap();
    let mut truth = viewer(4);
    let mut clock = ClockEstimator::new(ClockConfig {
        least_delay: Micros(8_000),
        ..ClockConfig::default()
    })
    .unwrap();
    let mut estimator = GazeEstimator::new(EstimatorConfig::default()).unwrap();
    let (mut fresh, mut right, mut states) = (0u32, 0u32, [0u32; 5]);
    let mut newest = Micros(0);
    for frame in 1..6_000u64 {
        let now = Micros(frame * 10_000);
        while let Some(chunk) = source.poll(now) {
            reader.feed(chunk.bytes(), chunk.arrival, &mut |event| {
                let Event::Sample(sample) = event else {
                    return;
                };
                let stamp = clock.stamp(&sample, &mut |_| {});
                estimator.push(&sample, stamp.time, &mut |_| {});
                if sample.left.direction.is_some() {
                    // When it was measured, by the mock's own count.
                    newest = newest.max(Micros(u64::from(sample.sequence.unwrap()) * 2_000));
                }
            });
        }
        let estimate = estimator.estimate(now, &mut |_| {});
        states[estimate.state as usize] += 1;
        let sight = estimate.line_of_sight;
        assert!(sight.forward().is_finite() && sight.position().is_finite());
        assert!(estimate.head.position.is_finite());
        if estimate.state == State::Fresh {
            fresh += 1;
            assert!(now.since(newest) < Micros(110_000), "{frame}");
            let truth = truth.truth(now).unwrap();
            right += u32::from(angle(sight.forward(), truth.direction) < 0.017);
        }
    }
    std::println!("frames by state, from fresh: {states:?}; right to 1°: {right} of {fresh}");
    assert!(fresh > 3_000 && right * 10 > fresh * 8);
    // Head and eyes come and go together: the head's direction is never left.
    let never = State::HeadDirection as usize;
    let reached = |(i, frames): (usize, &u32)| (*frames > 0) == (i != never);
    assert!(states.iter().enumerate().all(reached), "{states:?}");
}
