use super::*;
use crate::clock::{ClockConfig, ClockEstimator};
use crate::estimate::{EstimatorConfig, GazeEstimator, State};
use crate::rotation::angle;
use crate::sample::Sample;
use crate::time::Micros;
use glam::Vec3;
use std::vec::Vec;

fn viewer(seed: u64) -> Viewer<'static> {
    Viewer::new(ViewerConfig::default(), seed)
}

/// All parts of the movement in this many seconds, by their start.
fn parts(seconds: u64) -> Vec<Truth> {
    let mut viewer = viewer(3);
    let mut parts: Vec<Truth> = Vec::new();
    let mut time = 0;
    while time < seconds * 1_000_000 {
        let truth = viewer.truth(Micros(time)).unwrap();
        time = truth.end.0;
        parts.push(truth);
    }
    parts
}

fn median(mut values: Vec<f32>) -> f32 {
    values.sort_by(f32::total_cmp);
    values[values.len() / 2]
}

#[test]
fn fixations_are_log_normal() {
    if cfg!(miri) {
        return;
    }
    // Microsaccades do not end a fixation.
    let mut lengths = Vec::new();
    let mut start = None;
    for part in parts(1_200) {
        match part.kind {
            Kind::Fixation | Kind::Microsaccade => _ = start.get_or_insert(part.start),
            _ => {
                if let Some(start) = start.take() {
                    lengths.push(part.start.since(start).seconds());
                }
            }
        }
    }
    assert!(lengths.len() > 2_000);
    let logs: Vec<f32> = lengths.iter().map(|l| l.ln()).collect();
    let mean = logs.iter().sum::<f32>() / logs.len() as f32;
    let square = logs.iter().map(|l| (l - mean) * (l - mean)).sum::<f32>();
    let deviation = (square / logs.len() as f32).sqrt();
    let median = median(lengths);
    assert!((median - 0.25).abs() < 0.02, "{median}");
    assert!((deviation - 0.35).abs() < 0.06, "{deviation}");
}

/// Carpenter's main sequence: 436°/s at 10° and 577°/s at 20°. And another, of slower
/// eyes.
#[test]
fn saccades_are_on_the_main_sequence() {
    if cfg!(miri) {
        return;
    }
    for (base_duration, duration_per_amplitude) in [(0.021, 0.126_05), (0.035, 0.2)] {
        on_the_main_sequence(ViewerConfig {
            jitter: 0.0,
            base_duration,
            duration_per_amplitude,
            ..ViewerConfig::default()
        });
    }
}

/// Peak speed, by differences of a millisecond, against 1.875·A/D with D of
/// the main sequence.
fn on_the_main_sequence(config: ViewerConfig) {
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

#[test]
fn blinks_come_as_often_as_asked_for() {
    if cfg!(miri) {
        return;
    }
    for (blinks, blink) in [(15.0, 0.17), (30.0, 0.4)] {
        blinking(ViewerConfig {
            blinks,
            blink,
            ..ViewerConfig::default()
        });
    }
}

fn blinking(config: ViewerConfig) {
    let mut viewer = Viewer::new(config, 9);
    let (mut blinks, mut shut, mut open) = (0u32, 0u32, true);
    let mut lengths = Vec::new();
    for ms in 0..600_000u64 {
        let openness = viewer.truth(Micros::from_millis(ms)).unwrap().openness;
        assert!((0.0..=1.0).contains(&openness));
        if openness < 0.99 {
            blinks += u32::from(open);
            shut += 1;
        } else if !open {
            lengths.push(shut as f32);
            shut = 0;
        }
        open = openness >= 0.99;
    }
    let a_minute = f64::from(blinks) / 10.0;
    let median = median(lengths);
    // The time that eyes are shut is no pause.
    let asked = 60.0 / (60.0 / f64::from(config.blinks) + f64::from(config.blink));
    assert!((a_minute - asked).abs() < 0.2 * asked, "{a_minute}");
    let part = median / (1_000.0 * config.blink);
    assert!((0.76..1.24).contains(&part), "{median}");
}

#[test]
fn the_truth_goes_on_without_steps() {
    let count = if cfg!(miri) { 50 } else { 60_000 };
    let mut viewer = viewer(1);
    let mut last = viewer.truth(Micros(0)).unwrap();
    for ms in 1..count {
        let truth = viewer.truth(Micros::from_millis(ms)).unwrap();
        // 900°/s, and the jitter.
        assert!(angle(truth.direction, last.direction) < 0.018, "{ms}");
        assert!((truth.head.position - last.head.position).length() < 0.001);
        assert!((truth.direction.length() - 1.0).abs() < 1e-5);
        last = truth;
    }
    // What is past stays known for a while, and the same.
    let again = viewer.truth(Micros::from_millis(count - 2));
    assert!(again.is_some());
    if count > 1_000 {
        assert_eq!(viewer.truth(Micros(0)), None);
    }
}

#[test]
fn a_script_is_followed() {
    let script = [
        ScriptedTarget {
            at: Micros(0),
            direction: Vec3::NEG_Z,
        },
        ScriptedTarget {
            at: Micros(1_000_000),
            direction: Vec3::new(0.3, 0.0, -1.0),
        },
        ScriptedTarget {
            at: Micros(2_000_000),
            direction: Vec3::new(0.0, 0.2, -1.0),
        },
    ];
    let mut viewer = Viewer::with_script(ViewerConfig::default(), 4, &script);
    for (ms, target) in [(900, 0), (1_120, 1), (1_990, 1), (2_120, 2), (4_000, 2)] {
        let truth = viewer.truth(Micros::from_millis(ms)).unwrap();
        let off = angle(truth.direction, script[target].direction.normalize());
        // A microsaccade and the jitter.
        assert!(off < 0.04, "{ms}: {off}");
    }
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

/// The samples of a tracker behind faults, polled at some intervals.
fn faulty(config: FaultsConfig, interval: u64, seconds: u64) -> Vec<Sample> {
    let tracker = Tracker::new(TrackerConfig::default(), viewer(2), 2).unwrap();
    let mut faults = Faults::new(tracker, config, 6).unwrap();
    let mut samples = Vec::new();
    let mut time = 0;
    while time < seconds * 1_000_000 {
        time += interval;
        while let Some(sample) = faults.poll(Micros(time)) {
            assert!(sample.arrival <= Micros(time));
            samples.push(sample);
        }
    }
    samples
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
        assert_eq!(late.sequence, plain.sequence);
    }

    let dropped = with(|c| c.drop = 0.2);
    assert!((share(dropped.len()) - 0.8).abs() < 0.03);
    let doubled = with(|c| c.duplicate = 0.1);
    assert!((share(doubled.len()) - 1.1).abs() < 0.03);

    let passes = |samples: &[Sample]| {
        let pairs = samples.windows(2);
        pairs.filter(|p| p[0].sequence > p[1].sequence).count()
    };
    let reordered = with(|c| c.reorder = 0.1);
    assert!((share(passes(&reordered)) - 0.09).abs() < 0.03);

    let jittered = with(|c| c.jitter = Micros(20_000));
    assert!(passes(&jittered) > 500);
    assert!(jittered.windows(2).all(|p| p[0].arrival <= p[1].arrival));
    let late = |s: &Sample| s.arrival.0 - u64::from(s.sequence.unwrap()) * 2_000 - 8_000;
    assert!(jittered.iter().all(|s| late(s) <= 20_000));
    assert!(jittered.iter().any(|s| late(s) > 19_000));
    let line = with(|c| (c.jitter, c.in_order) = (Micros(20_000), true));
    assert_eq!(passes(&line), 0);

    // Some are of an eye that is lost and has nothing to damage.
    let corrupt = with(|c| c.corrupt = 0.1);
    let changed = corrupt.iter().zip(&plain).filter(|(c, p)| c != p).count();
    assert!((share(changed) - 0.1).abs() < 0.03);

    let stuck = with(|c| (c.stuck, c.stuck_for) = (0.001, Micros(300_000)));
    assert_eq!(stuck.len(), plain.len());
    let pairs = stuck.windows(2);
    let same = pairs.filter(|p| p[0].sequence == p[1].sequence).count();
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
        let tracker = Tracker::new(TrackerConfig::default(), viewer(2), 2).unwrap();
        assert!(Faults::new(tracker, config, 1).is_err());
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
    let often = faulty(all, 500, seconds);
    // NaN is not itself.
    let end = Micros(seconds * 1_000_000);
    let text = |samples: &[Sample]| {
        let samples = samples.iter().filter(|s| s.arrival <= end);
        samples.map(|s| std::format!("{s:?}")).collect::<Vec<_>>()
    };
    assert!(text(&often) == text(&faulty(all, 7_000, seconds)));
    assert!(text(&often) == text(&faulty(all, 1_000_000, seconds)));
}

#[test]
fn chunks_are_damaged_by_a_byte() {
    let mut random = Random::new(1, 1);
    let bytes: Vec<u8> = (0..40).collect();
    for _ in 0..if cfg!(miri) { 20 } else { 2_000 } {
        let mut chunk = Chunk::new(Micros(0), &bytes);
        assert_eq!(chunk.bytes(), bytes);
        chunk.corrupt(&mut random);
        assert_ne!(chunk.bytes(), bytes);
        assert!(chunk.bytes().len().abs_diff(bytes.len()) <= 1);
    }
    let mut empty = Chunk::new(Micros(0), &[]);
    empty.corrupt(&mut random);
    assert!(empty.bytes().is_empty());
    let full = [7; MOST_CHUNK_BYTES + 9];
    let mut chunk = Chunk::new(Micros(0), &full);
    assert_eq!(chunk.bytes().len(), MOST_CHUNK_BYTES);
    for _ in 0..20 {
        chunk.corrupt(&mut random);
        assert!(chunk.bytes().len() <= MOST_CHUNK_BYTES);
    }
}

/// All faults at once, through clock and estimator: whatever is called fresh
/// is new, and most of it is right.
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
    let mut source = Faults::new(tracker, faults, 4).unwrap();
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
        while let Some(sample) = source.poll(now) {
            let stamp = clock.stamp(&sample, &mut |_| {});
            estimator.push(&sample, stamp.time, &mut |_| {});
            if sample.left.direction.is_some() {
                // When it was measured, by the mock's own count.
                newest = newest.max(Micros(u64::from(sample.sequence.unwrap()) * 2_000));
            }
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
