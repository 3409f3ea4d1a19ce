//! The refreshes of a display, by the counts and times of those that were seen.

use super::monitors::Monitor;
use std::time::{Duration, Instant};

/// Refreshes from which the period is measured rather than taken from the mode.
const MEASURED: u64 = 60;

/// One part in this many of an error moves the clock: servers note times late by a millisecond or
/// two.
const SMOOTH: f64 = 8.0;

/// Counts refreshes and predicts their times.
#[derive(Debug, Clone, Copy)]
pub(super) struct RefreshClock {
    period: Duration,
    /// A refresh as it was seen, from which the period is measured.
    first: Option<(Instant, u64)>,
    /// The newest refresh, smoothed.
    newest: Option<(Instant, u64)>,
}

impl RefreshClock {
    /// Returns a clock of a nominal rate, above 0.
    fn new(hz: f64) -> Self {
        Self {
            period: Duration::from_secs_f64(1.0 / hz),
            first: None,
            newest: None,
        }
    }

    /// Returns a clock of the rate of a monitor's mode, or of 60 Hz.
    pub(super) fn of(monitor: &Monitor) -> Self {
        Self::new(monitor.hz.unwrap_or(60.0))
    }

    pub(super) const fn period(&self) -> Duration {
        self.period
    }

    /// Takes the time of the refresh of a number, as the server says. Numbers that go back start
    /// the clock anew.
    pub(super) fn hear(&mut self, at: Instant, number: u64) {
        let Some((first, of)) = self.first.filter(|&(_, first)| first <= number) else {
            self.first = Some((at, number));
            self.newest = Some((at, number));
            return;
        };
        if number - of >= MEASURED {
            self.period = at
                .saturating_duration_since(first)
                .div_f64((number - of) as f64);
        }
        let predicted = self.at(number).unwrap_or(at);
        let (late, early) = (
            at.saturating_duration_since(predicted),
            predicted.saturating_duration_since(at),
        );
        let smoothed = if late.max(early) > self.period / 2 {
            at
        } else {
            let sooner = predicted.checked_sub(early.div_f64(SMOOTH));
            sooner.unwrap_or(predicted) + late.div_f64(SMOOTH)
        };
        self.newest = Some((smoothed, number));
    }

    /// Returns the time of a refresh; `None` before the first.
    pub(super) fn at(&self, number: u64) -> Option<Instant> {
        let (newest, of) = self.newest?;
        let span = |count: u64| self.period.mul_f64(count as f64);
        if number >= of {
            newest.checked_add(span(number - of))
        } else {
            newest.checked_sub(span(of - number))
        }
    }

    /// Returns the number of the first refresh at or after a time, a quarter of a period early
    /// being at it; `None` before the first that was seen.
    pub(super) fn first_after(&self, time: Instant) -> Option<u64> {
        let (newest, of) = self.newest?;
        let ahead = time.saturating_duration_since(newest).as_secs_f64();
        let refreshes = ahead / self.period.as_secs_f64() - 0.25;
        Some(of + refreshes.max(0.0).ceil() as u64)
    }
}

/// A time of the system's monotonic clock in two forms.
#[derive(Debug, Clone, Copy)]
pub(super) struct Epoch {
    instant: Instant,
    microseconds: u64,
}

impl Epoch {
    pub(super) fn now() -> Self {
        let time = rustix::time::clock_gettime(rustix::time::ClockId::Monotonic);
        let [seconds, nanoseconds] =
            [time.tv_sec, time.tv_nsec].map(|part| u64::try_from(part).unwrap_or(0));
        Self {
            instant: Instant::now(),
            microseconds: seconds * 1_000_000 + nanoseconds / 1_000,
        }
    }

    /// Returns the time of a count of microseconds of the monotonic clock, as displays give it.
    pub(super) fn instant(&self, microseconds: u64) -> Instant {
        let span = Duration::from_micros(microseconds.abs_diff(self.microseconds));
        if microseconds >= self.microseconds {
            self.instant + span
        } else {
            self.instant.checked_sub(span).unwrap_or(self.instant)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_period_is_that_of_the_refreshes_and_times_are_smooth() {
        let start = Instant::now();
        let at = |milliseconds: f64| start + Duration::from_secs_f64(1.0e-3 * milliseconds);
        // 100 Hz as a mode says 60, with times that are up to 2 ms late.
        let mut clock = RefreshClock::new(60.0);
        assert_eq!(clock.first_after(start), None);
        for number in 0..600_u64 {
            let late = [0.0, 2.0, 1.0, 0.5, 1.5][number as usize % 5];
            clock.hear(at(10.0 * number as f64 + late), 7_000 + number);
        }
        let hz = 1.0 / clock.period().as_secs_f64();
        assert!((hz - 100.0).abs() < 0.1, "{hz}");
        let next = clock.at(7_600).expect("it was heard of");
        let off = next.duration_since(start).as_secs_f64() - 6.001;
        assert!(off.abs() < 1.0e-3, "{off}");
        // A time shortly after a refresh is at it, and one in between before the next.
        assert_eq!(clock.first_after(at(6_002.0)), Some(7_600));
        assert_eq!(clock.first_after(at(6_006.0)), Some(7_601));
        // Another mode counts anew.
        clock.hear(at(6_500.0), 3);
        assert_eq!(clock.at(3), Some(at(6_500.0)));
    }
}
