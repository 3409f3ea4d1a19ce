//! From a device's clock to the caller's.
//!
//! What arrives is late: arrival = device time + offset + delay, and the
//! delay is never below zero. So of all straight lines below the points
//! (device time, arrival − device time) the highest is the clock's, and the
//! samples that were delayed least are the ones that say where it is. The
//! estimator keeps the least delayed sample of each second, 16 of them, and
//! takes the edge of their lower hull above the middle (Zhang, Liu and Xia,
//! "Clock synchronization algorithms for network measurements", 2002).
//!
//! # How exact
//!
//! The least delay that a device ever has cannot be told from its clock's
//! offset: [`ClockConfig::least_delay`] is taken off, where it is known, or
//! [`ClockEstimator::set_offset`] finds it. Let
//! a sample in each second be delayed by at most e more than that, the
//! device's rate be constant, and the kept seconds span W. Then from the
//! fourth second on the rate is right to 2e/W, and a stamp to e, plus 2e/W of
//! the time since the last full second, plus 2 µs of rounding. Before, no rate
//! is known, and the stamps are right to e and the drift since the start.
//! (The hull is convex and its ends are at most e high, so its slope at the
//! middle is at most 2e/W.)
//!
//! # What else can happen
//!
//! A clock that wraps is followed, over gaps of any length. One that jumps,
//! either way, was restarted with its device: the second sample that says so
//! is believed, a single one is an [`Outlier`](ClockEvent::Outlier). One that
//! stands still is reported, and its samples keep the time at which it
//! stopped, so that they age.

use crate::sample::Sample;
use crate::time::{DeviceTime, Micros};

/// Seconds whose least delayed sample is kept.
const BLOCKS: usize = 16;
/// A block's length, microseconds.
const BLOCK: u64 = 1_000_000;
/// Blocks from which a rate is taken.
const LEAST_BLOCKS: usize = 4;
/// How long samples are late before the clock counts as stopped; a burst is over by then.
const SLIP: u64 = 1_000_000;
/// The longest least delay, microseconds.
const MOST_DELAY: u64 = 1_000_000;

/// What is known of a device's clock.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ClockConfig {
    /// From a measurement to the arrival of its last byte when nothing is in
    /// the way: exposure, processing and the line. Up to 1 s.
    pub least_delay: Micros,
    /// A step of the clock by more than this is a restart; 10 ms to 60 s.
    pub jump: Micros,
    /// A clock that stands still for longer is frozen; 10 ms to 60 s.
    pub frozen_after: Micros,
    /// The most that the clock runs fast or slow, parts per million; 1 to 10,000.
    pub most_drift: u32,
}

impl Default for ClockConfig {
    fn default() -> Self {
        Self {
            least_delay: Micros(0),
            jump: Micros(100_000),
            frozen_after: Micros(250_000),
            most_drift: 500,
        }
    }
}

/// A value of a [`ClockConfig`] that is out of range.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[error("the clock's {field} is {found}: give {least} to {most}")]
pub struct ClockConfigError {
    /// The value's name and unit.
    pub field: &'static str,
    /// The value.
    pub found: u64,
    /// The least it can be.
    pub least: u64,
    /// The most it can be.
    pub most: u64,
}

/// When a sample was measured, by the caller's clock.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Stamp {
    /// Time of the measurement; never after the arrival.
    pub time: Micros,
    /// What the time was taken from.
    pub source: StampSource,
}

/// What a [`Stamp`]'s time was taken from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum StampSource {
    /// The device's clock.
    Device,
    /// The time of arrival less the least delay: there is no device time.
    Arrival,
    /// The stamp before, repeated so that the sample does not pass for a new one:
    /// the device's time does not fit the ones before it.
    Suspect,
}

/// A change of a device's clock.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum ClockEvent {
    /// The clock jumped and went on from there: the device was restarted. The estimator starts
    /// again.
    Restarted {
        /// How far, microseconds; below zero is back.
        jump: i64,
    },
    /// A single time that fits nothing before or after.
    Outlier {
        /// How far it was off, microseconds; below zero is back.
        jump: i64,
    },
    /// The clock stands still although samples come.
    Frozen {
        /// For how long so far.
        since: Micros,
    },
    /// The clock runs again.
    Thawed {
        /// For how long it stood still.
        after: Micros,
    },
}

/// A device time, unwrapped and counted from the first, and the caller's clock less it: µs.
#[derive(Debug, Clone, Copy, Default)]
struct Point {
    device: i64,
    offset: i64,
}

/// The newest device time.
#[derive(Debug, Clone, Copy)]
struct NewestTime {
    raw: DeviceTime,
    device: i64,
    arrival: Micros,
    /// When the clock last moved.
    moved: Micros,
}

/// A device time that does not fit the ones before: the next sample confirms or refutes it.
#[derive(Debug, Clone, Copy)]
struct UnconfirmedTime {
    raw: DeviceTime,
    arrival: Micros,
    jump: i64,
}

/// The least delayed sample of the second that is under way.
#[derive(Debug, Clone, Copy)]
struct Open {
    start: Micros,
    least: Point,
}

/// Learns a device's clock from its samples. One for each device.
#[derive(Debug, Clone, Default)]
pub struct ClockEstimator {
    config: ClockConfig,
    /// The device time that is counted as 0, microseconds.
    origin: i64,
    last: Option<NewestTime>,
    suspect: Option<UnconfirmedTime>,
    open: Option<Open>,
    /// The least delayed samples of past seconds, the oldest first.
    blocks: [Point; BLOCKS],
    length: usize,
    line: Point,
    /// The slope of the offset against device time, parts per billion.
    rate: i64,
    late_since: Option<Micros>,
    frozen: bool,
    /// The newest stamp's time.
    stamped: Micros,
}

impl ClockEstimator {
    /// Returns an estimator of a clock that has shown no time yet.
    ///
    /// # Errors
    /// Values outside the ranges at [`ClockConfig`].
    pub fn new(config: ClockConfig) -> Result<Self, ClockConfigError> {
        let second = 1_000_000;
        for (field, found, least, most) in [
            ("least delay (µs)", config.least_delay.0, 0, MOST_DELAY),
            ("jump (µs)", config.jump.0, 10_000, 60 * second),
            (
                "time until it is frozen (µs)",
                config.frozen_after.0,
                10_000,
                60 * second,
            ),
            ("most drift (ppm)", config.most_drift.into(), 1, 10_000),
        ] {
            if !(least..=most).contains(&found) {
                return Err(ClockConfigError {
                    field,
                    found,
                    least,
                    most,
                });
            }
        }
        Ok(Self {
            config,
            ..Self::default()
        })
    }

    /// Returns how much faster the caller's clock runs than the device's, parts per billion;
    /// `None` in the first four seconds.
    pub fn rate(&self) -> Option<i64> {
        (self.length >= LEAST_BLOCKS).then_some(self.rate)
    }

    /// Returns whether the clock stands still.
    pub fn is_frozen(&self) -> bool {
        self.frozen
    }

    /// Takes note that at `now` the device's clock showed `offset` microseconds more than the
    /// caller's, as an exchange with the device says. It takes the place of
    /// [`ClockConfig::least_delay`], for clocks that do not wrap: a stamp is then as exact as the
    /// newest offset and the rate's drift since.
    pub fn set_offset(&mut self, now: Micros, offset: i64) {
        if self.last.is_some_and(|last| last.raw.wraps_at == 0) {
            let true_offset = self.origin.saturating_sub(offset);
            let device = signed(now).saturating_sub(true_offset);
            let delay = self.offset_at(device).saturating_sub(true_offset);
            self.config.least_delay = Micros(u64::try_from(delay).unwrap_or(0).min(MOST_DELAY));
        }
    }

    /// Returns when a sample was measured. Samples must come in the order of arrival.
    // Not inlined: keeps its code out of the decoders whose events it takes.
    #[inline(never)]
    pub fn stamp(&mut self, sample: &Sample, sink: &mut dyn FnMut(ClockEvent)) -> Stamp {
        let by_arrival = Stamp {
            time: sample.arrival.since(self.config.least_delay),
            source: StampSource::Arrival,
        };
        let Some(raw) = sample.device_time else {
            return by_arrival;
        };
        let arrival = sample.arrival;
        let Some(last) = self.last else {
            self.start(raw, arrival);
            return self.first(by_arrival);
        };
        if let Some(suspect) = self.suspect.take() {
            let step = step(suspect.raw, raw, arrival.since(suspect.arrival));
            let elapsed = signed(arrival.since(suspect.arrival));
            let agrees = step.is_some_and(|step| {
                step >= 0 && step.saturating_sub(elapsed).abs() <= signed(self.config.jump)
            });
            let fits = self.fits(last, raw, arrival).is_ok();
            if agrees && !fits {
                sink(ClockEvent::Restarted { jump: suspect.jump });
                self.start(raw, arrival);
                return self.first(by_arrival);
            }
            sink(ClockEvent::Outlier { jump: suspect.jump });
        }
        let step = match self.fits(last, raw, arrival) {
            Ok(step) => step,
            Err(jump) => {
                self.suspect = Some(UnconfirmedTime { raw, arrival, jump });
                return Stamp {
                    time: self.stamped,
                    source: StampSource::Suspect,
                };
            }
        };
        let device = last.device.saturating_add(step);
        self.watch(last, step, arrival, sink);
        if step > 0 {
            self.last = Some(NewestTime {
                raw,
                device,
                arrival,
                moved: arrival,
            });
        }
        if step != 0 {
            let offset = signed(arrival).saturating_sub(device);
            let late = offset.saturating_sub(self.offset_at(device));
            if late <= signed(self.config.jump) {
                self.late_since = None;
                self.add(Point { device, offset }, arrival);
            } else if arrival.since(*self.late_since.get_or_insert(arrival)).0 > SLIP {
                // It has been late for longer than SLIP: the clock had stood still.
                sink(ClockEvent::Restarted {
                    jump: late.saturating_neg(),
                });
                self.start(raw, arrival);
                return self.first(by_arrival);
            }
        }
        let time = device
            .saturating_add(self.offset_at(device))
            .saturating_sub(signed(self.config.least_delay));
        let time = u64::try_from(time).unwrap_or(0);
        self.stamped = Micros(time.min(by_arrival.time.0));
        Stamp {
            time: self.stamped,
            source: StampSource::Device,
        }
    }

    /// Forgets the clock, as after the device was unplugged.
    pub fn reset(&mut self) {
        self.last = None;
        self.suspect = None;
        self.frozen = false;
        self.length = 0;
    }

    fn start(&mut self, raw: DeviceTime, arrival: Micros) {
        self.origin = raw.microseconds as i64;
        self.last = Some(NewestTime {
            raw,
            device: 0,
            arrival,
            moved: arrival,
        });
        self.suspect = None;
        self.late_since = None;
        self.frozen = false;
        self.length = 0;
        self.rate = 0;
        let point = Point {
            device: 0,
            offset: signed(arrival),
        };
        self.line = point;
        self.open = Some(Open {
            start: arrival,
            least: point,
        });
    }

    /// Returns the first stamp of a clock, whose sample is taken for undelayed.
    fn first(&mut self, by_arrival: Stamp) -> Stamp {
        self.stamped = by_arrival.time;
        Stamp {
            source: StampSource::Device,
            ..by_arrival
        }
    }

    /// Returns the step from the last device time, or as an error how far off the time is. A time
    /// may be late, but not early.
    fn fits(&self, last: NewestTime, raw: DeviceTime, arrival: Micros) -> Result<i64, i64> {
        let elapsed = arrival.since(last.arrival);
        let jump = signed(self.config.jump);
        let drift = signed(elapsed).saturating_mul(self.config.most_drift.into()) / 1_000_000;
        let Some(step) = step(last.raw, raw, elapsed) else {
            return Err(i64::MAX);
        };
        if step < -jump {
            return Err(step.saturating_sub(signed(elapsed)));
        }
        let device = last.device.saturating_add(step);
        let offset = signed(arrival).saturating_sub(device);
        let early = self.offset_at(device).saturating_sub(offset);
        if early > jump.saturating_add(drift) {
            return Err(early);
        }
        Ok(step)
    }

    /// Reports a clock that stops or runs again.
    fn watch(
        &mut self,
        last: NewestTime,
        step: i64,
        arrival: Micros,
        sink: &mut dyn FnMut(ClockEvent),
    ) {
        let still = arrival.since(last.moved);
        if step == 0 {
            if still > self.config.frozen_after && !self.frozen {
                self.frozen = true;
                sink(ClockEvent::Frozen { since: still });
            }
        } else if self.frozen {
            self.frozen = false;
            sink(ClockEvent::Thawed { after: still });
        }
    }

    /// Returns the caller's clock less the device's, at a device time.
    fn offset_at(&self, device: i64) -> i64 {
        let since = device.saturating_sub(self.line.device);
        let drift = since.saturating_mul(self.rate) / 1_000_000_000;
        self.line.offset.saturating_add(drift)
    }

    fn add(&mut self, point: Point, arrival: Micros) {
        match &mut self.open {
            Some(open) if arrival.since(open.start).0 < BLOCK => {
                let drift = point.device.saturating_sub(open.least.device);
                let drift = drift.saturating_mul(self.rate) / 1_000_000_000;
                if point.offset <= open.least.offset.saturating_add(drift) {
                    open.least = point;
                }
            }
            open => {
                let full = open.replace(Open {
                    start: arrival,
                    least: point,
                });
                if let Some(full) = full {
                    self.keep(full.least);
                }
            }
        }
        // The line stays below all points.
        if point.offset < self.offset_at(point.device) {
            self.line = point;
        }
    }

    fn keep(&mut self, point: Point) {
        if self.length == BLOCKS {
            self.blocks.rotate_left(1);
            self.length -= 1;
        }
        if let Some(place) = self.blocks.get_mut(self.length) {
            *place = point;
            self.length += 1;
        }
        let kept = self.blocks.get(..self.length).unwrap_or_default();
        if kept.len() >= LEAST_BLOCKS
            && let Some((from, to)) = middle_edge(kept)
        {
            let rise = to.offset.saturating_sub(from.offset);
            let run = to.device.saturating_sub(from.device).max(1);
            let most = i64::from(self.config.most_drift) * 1_000;
            self.rate = (rise.saturating_mul(1_000_000_000) / run).clamp(-most, most);
        }
        // By the rate the point with the least delay.
        let rate = self.rate;
        let height = |p: &Point| {
            let drift = p.device.saturating_sub(point.device).saturating_mul(rate);
            p.offset.saturating_sub(drift / 1_000_000_000)
        };
        if let Some(least) = kept.iter().copied().min_by_key(height) {
            self.line = least;
        }
    }
}

fn signed(time: Micros) -> i64 {
    i64::try_from(time.0).unwrap_or(i64::MAX)
}

/// Returns how far the device's clock went, given how far the caller's did: of all
/// numbers of wraps the one that agrees best. `None` where the two are not of
/// the same clock.
fn step(from: DeviceTime, to: DeviceTime, elapsed: Micros) -> Option<i64> {
    if from.wraps_at != to.wraps_at {
        return None;
    }
    let plain = to.microseconds.wrapping_sub(from.microseconds) as i64;
    let Some(wrap) = i64::try_from(from.wraps_at).ok().filter(|&wrap| wrap > 0) else {
        return Some(plain);
    };
    let forward = plain.checked_rem_euclid(wrap)?;
    let missing = signed(elapsed).saturating_sub(forward);
    let half = wrap / 2;
    let wraps = missing.saturating_add(half).div_euclid(wrap);
    Some(forward.saturating_add(wraps.saturating_mul(wrap)))
}

/// Returns the ends of the lower hull's edge above the middle of ascending points.
fn middle_edge(points: &[Point]) -> Option<(Point, Point)> {
    let mut hull = [Point::default(); BLOCKS];
    let mut length = 0usize;
    for &point in points {
        loop {
            let redundant = match hull.get(..length)? {
                [.., top] if top.device >= point.device => true,
                [.., below, top] => {
                    let run = |p: Point| p.device.saturating_sub(below.device);
                    let rise = |p: Point| p.offset.saturating_sub(below.offset);
                    run(*top).saturating_mul(rise(point)) <= rise(*top).saturating_mul(run(point))
                }
                _ => false,
            };
            if !redundant {
                break;
            }
            length = length.saturating_sub(1);
        }
        *hull.get_mut(length)? = point;
        length += 1;
    }
    let hull = hull.get(..length)?;
    let (first, last) = (hull.first()?, hull.last()?);
    let middle = first.device.midpoint(last.device);
    hull.windows(2).find_map(|pair| match *pair {
        [from, to] if to.device >= middle => Some((from, to)),
        _ => None,
    })
}

#[cfg(test)]
mod tests;
