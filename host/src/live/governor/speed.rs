//! Converts time to steps.
//!
//! A frame costs a constant overhead for its pixels and time in proportion to its steps. The
//! rate is that of recent frames; the overhead depends on the walls and the scene, and is
//! measured before the first frame is shown.

const REMEMBERED: usize = 128;

/// Remembered frames whose delay may exceed the provision: 2 in 129 frames are late.
const SLOWER: usize = 1;

/// Steps a second assumed before the first frame: about those of a slow machine.
const UNKNOWN_RATE: f64 = 1.0e7;

/// Least ratio of steps between two frames from which the overhead is measured.
const APART: f64 = 1.5;

/// The cost of a frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrameCost {
    /// Steps.
    pub steps: u64,
    /// Seconds.
    pub seconds: f64,
}

#[derive(Debug, Clone)]
pub(in crate::live) struct Speed {
    /// Constant cost of a frame, as the number of steps that take as long.
    overhead: f64,
    frames: [(f64, f64); REMEMBERED],
    count: usize,
}

impl Speed {
    pub(super) const UNKNOWN: Self = Self {
        overhead: 0.0,
        frames: [(0.0, 0.0); REMEMBERED],
        count: 0,
    };

    pub(super) fn learn(&mut self, cost: FrameCost) {
        let rate = cost.steps as f64 / cost.seconds;
        if rate > 0.0 && rate.is_finite() {
            self.frames[self.count % REMEMBERED] = (cost.steps as f64, cost.seconds);
            self.count += 1;
        }
    }

    pub(in crate::live) fn compare(&mut self, many: FrameCost, few: FrameCost) {
        let (most, least) = (many.steps as f64, few.steps as f64);
        if !(most > APART * least && many.seconds > few.seconds && few.seconds > 0.0) {
            return;
        }
        // Time is linear in steps.
        let per_second = (most - least) / (many.seconds - few.seconds);
        self.overhead = (few.seconds * per_second - least).clamp(0.0, most);
    }

    /// Sorts a quantity of the remembered frames; returns the one that `place` of their count gives.
    fn ranked(
        &self,
        quantity: impl Fn((f64, f64)) -> f64,
        place: impl Fn(usize) -> usize,
    ) -> Option<f64> {
        let count = self.count.min(REMEMBERED);
        let mut all = [0.0; REMEMBERED];
        for (one, frame) in all.iter_mut().zip(self.frames) {
            *one = quantity(frame);
        }
        let known = all.get_mut(..count)?;
        known.sort_unstable_by(f64::total_cmp);
        known.get(place(count)).copied()
    }

    /// Returns the median rate of the remembered frames, overhead included: steps a second.
    fn rate(&self) -> Option<f64> {
        let rate = |(steps, seconds): (f64, f64)| (self.overhead + steps) / seconds;
        self.ranked(rate, |count| count / 2)
    }

    /// Returns the delay, seconds, that all remembered frames but one kept, without those above `most`.
    fn delay(&self, rate: f64, most: f64) -> f64 {
        let delay = |(steps, seconds): (f64, f64)| {
            let delay = (seconds - (self.overhead + steps) / rate).max(0.0);
            if delay > most { 0.0 } else { delay }
        };
        let delay = self.ranked(delay, |count| count.saturating_sub(1 + SLOWER));
        delay.unwrap_or(0.0)
    }

    /// Returns the steps that fit into a time, with provision for delays up to `most`.
    pub(super) fn steps_in(&self, seconds: f64, most: f64) -> u64 {
        let Some(rate) = self.rate() else {
            return (seconds * UNKNOWN_RATE) as u64;
        };
        // The cast turns negative numbers into 0.
        ((seconds - self.delay(rate, most)) * rate - self.overhead) as u64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_overhead_is_told_from_the_steps() {
        // A millisecond, and one for each 100,000 steps.
        let cost = |steps: u64, times: f64| FrameCost {
            steps,
            seconds: times * (1.0e-3 + 1.0e-8 * steps as f64),
        };
        let mut speed = Speed::UNKNOWN;
        speed.compare(cost(500_000, 1.0), cost(20_000, 1.0));
        assert!((speed.overhead - 1.0e5).abs() < 1.0, "{}", speed.overhead);
        // The last machine is half as fast.
        for (steps, times) in [(30_000, 1.0), (300_000, 1.0), (30_000, 2.0)] {
            for _ in 0..REMEMBERED {
                speed.learn(cost(steps, times));
            }
            let found = speed.steps_in(3.0e-3 * times, 1.0e-3) as f64;
            assert!((found - 2.0e5).abs() < 10.0, "{found}");
        }
    }
}
