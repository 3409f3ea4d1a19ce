use super::*;
use crate::testing::Random;
use std::vec::Vec;

/// A device whose clock runs `ppm` fast; samples take 2 ms and up to `jitter` µs more.
struct Device {
    ppm: i64,
    jitter: u64,
    random: Random,
    wrap: Option<u64>,
    start: u64,
}

impl Device {
    /// Returns the sample measured at `time`.
    fn sample(&mut self, time: u64) -> Sample {
        // The greater of two: few are early, as on a busy bus.
        let part = (self.random.next() % 1_001).max(self.random.next() % 1_001);
        let delay = 2_000 + self.jitter * part / 1_000;
        let shown = self.start as i64 + time as i64 + time as i64 * self.ppm / 1_000_000;
        let mut sample = Sample::arrived(Micros(time + delay));
        sample.device_time = Some(match self.wrap {
            Some(wraps_at) => DeviceTime {
                microseconds: shown as u64 % wraps_at,
                wraps_at,
            },
            None => DeviceTime::unwrapped(shown as u64),
        });
        sample
    }
}

fn device(ppm: i64, jitter: u64) -> Device {
    Device {
        ppm,
        jitter,
        random: Random(1),
        wrap: None,
        start: 77_000_000,
    }
}

fn clock() -> ClockEstimator {
    ClockEstimator::new(ClockConfig {
        least_delay: Micros(2_000),
        ..ClockConfig::default()
    })
    .unwrap()
}

/// Feeds `times`; returns the time and error of each stamp, and the events.
fn follow(
    clock: &mut ClockEstimator,
    device: &mut Device,
    times: impl Iterator<Item = u64>,
) -> (Vec<(u64, i64)>, Vec<ClockEvent>) {
    let mut events = Vec::new();
    let errors = times
        .map(|time| {
            let sample = device.sample(time);
            let stamp = clock.stamp(&sample, &mut |event| events.push(event));
            assert!(stamp.time <= sample.arrival);
            (time, stamp.time.0 as i64 - time as i64)
        })
        .collect();
    (errors, events)
}

/// Every 4 ms. An interpreter takes its time.
fn seconds(from: u64, to: u64) -> impl Iterator<Item = u64> {
    let step = if cfg!(miri) { 100_000 } else { 4_000 };
    (from * 1_000_000..to * 1_000_000).step_by(step)
}

fn worst(errors: &[(u64, i64)]) -> i64 {
    errors.iter().map(|(_, error)| error.abs()).max().unwrap()
}

/// The bound of the module's documentation, with the e that came up.
#[test]
fn jitter_and_drift_stay_within_the_bound() {
    if cfg!(miri) {
        return;
    }
    for ppm in [-100, 100] {
        for jitter in [1_000, 10_000, 50_000] {
            let mut of_times = device(ppm, jitter);
            // The worst of all seconds: the most delayed of the least delayed.
            let excess = (2..60)
                .map(|second| {
                    seconds(second, second + 1)
                        .map(|t| of_times.sample(t).arrival.0 - t - 2_000)
                        .min()
                        .unwrap()
                })
                .max()
                .unwrap() as i64;
            let mut clock = clock();
            let (errors, events) = follow(&mut clock, &mut device(ppm, jitter), seconds(0, 60));
            assert!(events.is_empty(), "{events:?}");
            let late: Vec<_> = errors
                .iter()
                .copied()
                .filter(|e| e.0 > 18_000_000)
                .collect();
            let worst = worst(&late);
            let bound = excess + 2 * excess / 15 * 2 + 2 + 1;
            assert!(worst <= bound, "{worst} > {bound}");
            let rate = clock.rate().unwrap();
            assert!(
                (rate + ppm * 1_000).abs() <= 2 * excess * 1_000 / 14 + 50,
                "{rate}"
            );
        }
    }
}

#[test]
fn an_offset_that_the_device_tells_finds_the_least_delay() {
    for ppm in [-100, 100] {
        let mut clock = ClockEstimator::new(ClockConfig::default()).unwrap();
        let mut device = device(ppm, 3_000);
        for second in (0..10).step_by(2) {
            follow(&mut clock, &mut device, seconds(second, second + 2));
            let now = (second + 2) * 1_000_000;
            let shown = device.start as i64 + now as i64 * ppm / 1_000_000;
            clock.set_offset(Micros(now), shown);
        }
        let (errors, events) = follow(&mut clock, &mut device, seconds(10, 12));
        assert!(
            events.is_empty() && worst(&errors) < 300,
            "{}",
            worst(&errors)
        );
    }
}

#[test]
fn wraps_are_followed_over_gaps() {
    for wrap in [DeviceTime::micros_u32(0), DeviceTime::millis_u32(0)] {
        let wraps_at = wrap.wraps_at;
        let mut device = Device {
            wrap: Some(wraps_at),
            start: wraps_at - 3_000_000,
            ..device(0, 100)
        };
        let mut clock = clock();
        let (errors, events) = follow(&mut clock, &mut device, seconds(1, 8));
        assert!(events.is_empty(), "{events:?}");
        assert!(worst(&errors) <= 110, "{}", worst(&errors));
        // Silence of more than two wraps of the shorter.
        let after = 8 + 9_000;
        let (errors, events) = follow(&mut clock, &mut device, seconds(after, after + 3));
        assert!(events.is_empty(), "{events:?}");
        assert!(worst(&errors) <= 110, "{}", worst(&errors));
    }
}

#[test]
fn a_restart_is_told_and_followed() {
    // Back to nothing, and far ahead; with a 32-bit clock too.
    for (wrap, start) in [
        (None, 0),
        (None, 77_000_000 + 3_600_000_000),
        (Some(1 << 32), 60 * 60_000_000),
        (Some(1 << 32), 1_000),
    ] {
        let mut device = Device {
            wrap,
            ..device(50, 200)
        };
        let mut clock = clock();
        follow(&mut clock, &mut device, seconds(1, 10));
        device.start = start;
        let (errors, events) = follow(&mut clock, &mut device, seconds(12, 20));
        assert!(
            matches!(events[..], [ClockEvent::Restarted { jump }] if jump.abs() > 1_000_000),
            "{events:?}"
        );
        // The first is not believed yet, and must not pass for a new one.
        assert!(errors[0].1 < -1_000_000);
        assert!(worst(&errors[1..]) <= 500, "{}", worst(&errors[1..]));
    }
}

#[test]
fn one_wrong_time_is_an_outlier() {
    let mut clock = clock();
    let mut device = device(0, 100);
    follow(&mut clock, &mut device, seconds(1, 6));
    let rate = clock.rate();
    let mut events = Vec::new();
    let mut wrong = device.sample(6_000_000);
    wrong.device_time = Some(DeviceTime::unwrapped(u64::MAX - 5));
    let stamp = clock.stamp(&wrong, &mut |event| events.push(event));
    assert_eq!(stamp.source, StampSource::Suspect);
    assert!(stamp.time < Micros(6_000_000));
    assert!(events.is_empty());
    let right = device.sample(6_004_000);
    let stamp = clock.stamp(&right, &mut |event| events.push(event));
    assert_eq!(stamp.source, StampSource::Device);
    assert!(stamp.time.0.abs_diff(6_004_000) <= 110);
    assert!(
        matches!(events[..], [ClockEvent::Outlier { .. }]),
        "{events:?}"
    );
    assert_eq!(clock.rate(), rate);
}

#[test]
fn a_frozen_clock_is_told_and_its_samples_age() {
    let mut clock = clock();
    let mut device = device(0, 0);
    follow(&mut clock, &mut device, seconds(1, 6));
    let frozen = device.sample(6_000_000).device_time;
    let mut events = Vec::new();
    let mut stamps = Vec::new();
    for time in seconds(6, 8) {
        let mut sample = device.sample(time);
        sample.device_time = frozen;
        stamps.push(clock.stamp(&sample, &mut |event| events.push(event)).time);
    }
    assert!(
        matches!(events[..], [ClockEvent::Frozen { .. }]),
        "{events:?}"
    );
    assert!(clock.is_frozen());
    assert!(
        stamps.iter().all(|s| s.0.abs_diff(6_000_000) <= 5),
        "{stamps:?}"
    );
    // It goes on from where it stopped: late for a second, then believed.
    device.start -= 2_000_000;
    let (errors, more) = follow(&mut clock, &mut device, seconds(8, 12));
    assert!(
        matches!(
            more[..],
            [ClockEvent::Thawed { .. }, ClockEvent::Restarted { .. }]
        ),
        "{more:?}"
    );
    assert!(errors.last().unwrap().1.abs() <= 5);
    assert!(errors.iter().all(|(_, error)| *error <= 5));
}

#[test]
fn a_pause_of_the_line_is_no_restart() {
    let mut clock = clock();
    let mut device = device(0, 0);
    follow(&mut clock, &mut device, seconds(1, 6));
    let mut events = Vec::new();
    for time in seconds(6, 8) {
        let mut sample = device.sample(time);
        // All at once when the line is back.
        sample.arrival = Micros(8_000_000 + (time - 6_000_000) / 100);
        let stamp = clock.stamp(&sample, &mut |event| events.push(event));
        assert!(stamp.time.0.abs_diff(time) <= 5, "{time} {stamp:?}");
    }
    let (errors, more) = follow(&mut clock, &mut device, seconds(9, 12));
    assert!(events.is_empty() && more.is_empty());
    assert!(worst(&errors) <= 5);
}

#[test]
fn extreme_times_do_no_harm() {
    let mut clock = clock();
    for (i, time) in [0, u64::MAX, 1 << 63, 0, u64::MAX / 2, 3]
        .into_iter()
        .enumerate()
    {
        for wraps_at in [0, 1, 2, u64::MAX, 1 << 63] {
            let mut sample = Sample::arrived(Micros(u64::MAX - 9 + i as u64));
            sample.device_time = Some(DeviceTime {
                microseconds: time,
                wraps_at,
            });
            let stamp = clock.stamp(&sample, &mut |_| {});
            assert!(stamp.time <= sample.arrival);
        }
    }
}

#[test]
fn configurations_are_checked() {
    let error = ClockEstimator::new(ClockConfig {
        jump: Micros(5),
        ..ClockConfig::default()
    })
    .unwrap_err();
    assert_eq!(
        std::format!("{error}"),
        "the clock's jump (µs) is 5: give 10000 to 60000000"
    );
}
