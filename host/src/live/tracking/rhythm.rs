//! Predicts when the next sample comes.

use shisen_tracker::time::Micros;

const NEWEST: u64 = 8;

/// Divisor of the mean interval: the next sample may come sooner by that part.
const SOONER: u64 = 8;

/// Multiple of the mean interval above which an interval is an interruption and is not counted.
const INTERRUPTION: u64 = 4;

pub(super) struct Rhythm {
    newest: Option<Micros>,
    /// Mean interval of recent samples, nanoseconds; 0 if unknown.
    between: u64,
}

impl Rhythm {
    pub(super) const NEW: Self = Self {
        newest: None,
        between: 0,
    };

    pub(super) fn hear(&mut self, came: Micros) {
        let before = self.newest.replace(came);
        let Some(since) = before.map(|before| came.since(before).0.saturating_mul(1_000)) else {
            return;
        };
        if self.between == 0 {
            self.between = since;
        } else if since <= self.between.saturating_mul(INTERRUPTION) {
            self.between = self.between - self.between / NEWEST + since / NEWEST;
        }
    }

    /// Returns whether no other sample is expected before a time. An overdue one may still come.
    pub(super) fn is_last_before(&self, until: Micros) -> bool {
        let soonest = self.between - self.between / SOONER;
        self.between > 0
            && self
                .newest
                .is_some_and(|newest| newest.0.saturating_add(soonest / 1_000) > until.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Milliseconds after samples at these intervals for which no other is expected.
    fn silence(intervals: impl IntoIterator<Item = u64>) -> u64 {
        let mut rhythm = Rhythm::NEW;
        let mut now = Micros(5_000_000);
        let later = |now: Micros, by: u64| Micros(now.0 + 1_000 * by);
        rhythm.hear(now);
        for interval in intervals {
            now = later(now, interval);
            rhythm.hear(now);
        }
        let until = |after: &u64| rhythm.is_last_before(later(now, *after));
        (0..1_000).take_while(until).count() as u64
    }

    #[test]
    fn the_next_sample_is_expected_a_little_early() {
        assert_eq!([silence([16; 40]), silence([100])], [14, 88]);
        // Neither an interruption nor a buffer's samples, all at once, change the mean.
        assert_eq!(silence([16; 40].into_iter().chain([700])), 14);
        let buffered = [16; 40].into_iter().chain([0; 3]).chain([16; 40]);
        assert_eq!(silence(buffered), 14);
        let slower = silence([16; 40].into_iter().chain([32; 40]));
        assert!((27..=28).contains(&slower), "{slower}");
        let faster = silence([32; 40].into_iter().chain([16; 40]));
        assert!((14..=15).contains(&faster), "{faster}");
        let mut rhythm = Rhythm::NEW;
        for time in [0, u64::MAX, 0, u64::MAX, u64::MAX] {
            rhythm.hear(Micros(time));
            assert!(!rhythm.is_last_before(Micros(u64::MAX)));
        }
    }
}
