//! How many steps there is time for.
//!
//! A frame takes some time for its pixels, whether they have rays or not, and the more
//! the more steps it takes: overhead and steps, at one rate. The rate is that of late;
//! the overhead, which is a matter of the walls and the scene, is measured before the
//! first frame that is shown.

/// How many frames are remembered.
const REMEMBERED: usize = 128;

/// How many of these may have taken longer than the next is given: a frame that takes
/// all of its steps is late with a probability of 2 in 129, as far as what holds frames
/// up stays as it is.
const SLOWER: usize = 1;

/// Steps a second before anything is known: a frame of a thousandth of a second of a
/// slow machine finds out.
const UNKNOWN_RATE: f64 = 1.0e7;

/// How many times the steps of a small frame a large one has to take for the time of both
/// to tell what is the same in them.
const APART: f64 = 1.5;

/// What a frame took.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Taken {
    /// Steps.
    pub steps: u64,
    /// Seconds that these took.
    pub seconds: f64,
}

/// What is known of the time that steps take.
#[derive(Debug, Clone)]
pub(super) struct Speed {
    /// What a frame takes whatever its steps are: as many steps as take that long.
    overhead: f64,
    /// Steps and seconds of the newest frames, a ring.
    frames: [(f64, f64); REMEMBERED],
    count: usize,
}

impl Speed {
    /// Nothing is known.
    pub(super) const UNKNOWN: Self = Self {
        overhead: 0.0,
        frames: [(0.0, 0.0); REMEMBERED],
        count: 0,
    };

    /// Takes a frame's.
    pub(super) fn learn(&mut self, taken: Taken) {
        let rate = taken.steps as f64 / taken.seconds;
        if rate > 0.0 && rate.is_finite() {
            self.frames[self.count % REMEMBERED] = (taken.steps as f64, taken.seconds);
            self.count += 1;
        }
    }

    /// Learns the overhead of a frame of many steps and one of few.
    pub(super) fn compare(&mut self, many: Taken, few: Taken) {
        let (most, least) = (many.steps as f64, few.steps as f64);
        if !(most > APART * least && many.seconds > few.seconds && few.seconds > 0.0) {
            return;
        }
        // Both are on one line.
        let per_second = (most - least) / (many.seconds - few.seconds);
        self.overhead = (few.seconds * per_second - least).clamp(0.0, most);
    }

    /// Of the frames that are remembered, the one with so many below it.
    fn ranked(
        &self,
        of: impl Fn((f64, f64)) -> f64,
        below: impl Fn(usize) -> usize,
    ) -> Option<f64> {
        let count = self.count.min(REMEMBERED);
        let mut all = [0.0; REMEMBERED];
        for (one, frame) in all.iter_mut().zip(self.frames) {
            *one = of(frame);
        }
        let known = all.get_mut(..count)?;
        known.sort_unstable_by(f64::total_cmp);
        known.get(below(count)).copied()
    }

    /// Steps per second, the overhead's too: the median of the newest frames. `None`
    /// before the first.
    fn rate(&self) -> Option<f64> {
        let rate = |(steps, seconds): (f64, f64)| (self.overhead + steps) / seconds;
        self.ranked(rate, |count| count / 2)
    }

    /// What the next frame may take longer than by the [rate](Self::rate): seconds.
    /// Of the newest frames all but one took no more. Delays above `most` are left out.
    fn delay(&self, rate: f64, most: f64) -> f64 {
        let delay = |(steps, seconds): (f64, f64)| {
            let delay = (seconds - (self.overhead + steps) / rate).max(0.0);
            if delay > most { 0.0 } else { delay }
        };
        let delay = self.ranked(delay, |count| count.saturating_sub(1 + SLOWER));
        delay.unwrap_or(0.0)
    }

    /// Steps that there are in so many seconds, where delays of up to `most` are provided
    /// for.
    pub(super) fn steps_in(&self, seconds: f64, most: f64) -> u64 {
        let Some(rate) = self.rate() else {
            return (seconds * UNKNOWN_RATE) as u64;
        };
        // A cast cuts off what is below 0.
        ((seconds - self.delay(rate, most)) * rate - self.overhead) as u64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Frames of a million steps that take so many seconds each.
    fn timed(seconds: impl Iterator<Item = f64>) -> Speed {
        let mut speed = Speed::UNKNOWN;
        for seconds in seconds {
            let steps = 1_000_000;
            speed.learn(Taken { steps, seconds });
        }
        speed
    }

    #[test]
    fn time_becomes_steps_by_the_rate_less_the_delays() {
        // One in eight takes 5 ms more.
        let slow = |frame: u32| {
            if frame.is_multiple_of(8) {
                1.5e-2
            } else {
                1.0e-2
            }
        };
        let speed = timed((0..200).map(slow));
        let rate = speed.rate().unwrap();
        assert!((rate - 1.0e8).abs() < 1.0, "{rate}");
        assert!((speed.delay(rate, 1.0) - 5.0e-3).abs() < 1.0e-9);
        // The same delay is as long where frames are short.
        for seconds in [0.1, 0.012] {
            let steps = (seconds - 5.0e-3) * 1.0e8;
            assert!((speed.steps_in(seconds, 0.006) as f64 - steps).abs() < 2.0);
        }
        assert_eq!(speed.steps_in(1.0e-3, 1.0), 0);
    }

    #[test]
    fn one_long_delay_costs_nothing_and_two_do() {
        let with = |late: &'static [u32]| {
            let speed = timed((0..128).map(move |frame| {
                if late.contains(&frame) {
                    1.4e-2
                } else {
                    1.0e-2
                }
            }));
            move |most| speed.delay(1.0e8, most)
        };
        assert!(with(&[70])(1.0) < 1.0e-9);
        assert!((with(&[20, 70])(1.0) - 4.0e-3).abs() < 1.0e-9);
        // What is longer than what is provided for is not made up for.
        assert!(with(&[20, 70])(3.0e-3) < 1.0e-9);
    }

    #[test]
    fn what_every_frame_takes_is_told_from_what_steps_take() {
        // A millisecond, and one for each 100,000 steps.
        let taken = |steps: u64| Taken {
            steps,
            seconds: 1.0e-3 + 1.0e-8 * steps as f64,
        };
        let mut speed = Speed::UNKNOWN;
        speed.compare(taken(500_000), taken(20_000));
        assert!((speed.overhead - 1.0e5).abs() < 1.0, "{}", speed.overhead);
        // Whatever the frames were that the rate is from.
        for steps in [30_000, 300_000] {
            for _ in 0..REMEMBERED {
                speed.learn(taken(steps));
            }
            let found = speed.steps_in(3.0e-3, 1.0e-3) as f64;
            assert!((found - 2.0e5).abs() < 10.0, "{found}");
        }
        // A machine that is half as fast takes twice as long for both.
        for _ in 0..REMEMBERED {
            let Taken { steps, seconds } = taken(30_000);
            let seconds = 2.0 * seconds;
            speed.learn(Taken { steps, seconds });
        }
        let found = speed.steps_in(6.0e-3, 1.0e-3) as f64;
        assert!((found - 2.0e5).abs() < 10.0, "{found}");
        assert_eq!(speed.steps_in(1.5e-3, 1.0e-3), 0);
    }

    #[test]
    fn frames_too_much_alike_tell_nothing_of_what_is_the_same_in_them() {
        let taken = |steps: u64, seconds: f64| Taken { steps, seconds };
        for (many, few) in [
            (taken(100, 1.0), taken(90, 0.5)),
            (taken(100, 1.0), taken(50, 1.0)),
            (taken(100, 0.5), taken(50, 1.0)),
            (taken(100, 1.0), taken(0, 0.0)),
            (taken(100, f64::NAN), taken(50, 0.5)),
        ] {
            let mut speed = Speed::UNKNOWN;
            speed.compare(many, few);
            assert_eq!(speed.overhead, 0.0, "{many:?} {few:?}");
        }
        // Fewer steps that take less than their share: none.
        let mut speed = Speed::UNKNOWN;
        speed.compare(taken(100, 1.0), taken(50, 0.25));
        assert_eq!(speed.overhead, 0.0);
    }
}
