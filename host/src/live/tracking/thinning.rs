//! Chooses which samples are used of a tracker that sends more than an estimator is made for.

use shisen_tracker::time::Micros;

/// The least number of samples a second that are used of more; at most twice as many are.
const USED: u64 = 1_000;

/// The time over which the rate is measured; samples from a buffer, all at once, are no flood.
const OVER: Micros = Micros::from_millis(250);

/// The state of one sensor.
#[derive(Debug, Clone, Copy)]
pub(super) struct Thinning {
    since: Option<Micros>,
    counted: u64,
    /// One sample in this many is used, by the recent rate.
    pub(super) one_of: u64,
}

impl Thinning {
    /// No sample has come.
    pub(super) const NEW: Self = Self {
        since: None,
        counted: 0,
        one_of: 1,
    };

    /// Whether a sample is used that came at a time.
    pub(super) fn uses(&mut self, arrival: Micros) -> bool {
        let passed = arrival.since(*self.since.get_or_insert(arrival));
        if passed >= OVER {
            let a_second = 1_000_000 * self.counted / passed.0;
            self.one_of = (a_second / USED).max(1);
            (self.since, self.counted) = (Some(arrival), 0);
        }
        self.counted += 1;
        self.counted.is_multiple_of(self.one_of)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn used(thinning: &mut Thinning, arrivals: impl Iterator<Item = u64>) -> u64 {
        let used = arrivals.filter(|&arrival| thinning.uses(Micros(arrival)));
        used.count() as u64
    }

    #[test]
    fn a_flood_is_thinned_and_nothing_else() {
        let seconds = |rate: u64, from: u64| {
            let samples = from * rate..(from + 5) * rate;
            samples.map(move |sample| 1_000_000 * sample / rate)
        };
        for rate in [1, 60, 1_000, 1_999] {
            let used = used(&mut Thinning::NEW.clone(), seconds(rate, 0));
            assert_eq!(used, 5 * rate, "{rate}");
        }
        for rate in [2_000, 3_500, 10_000] {
            let mut thinning = Thinning::NEW;
            used(&mut thinning, seconds(rate, 0));
            let a_second = used(&mut thinning, seconds(rate, 5)) / 5;
            assert!((1_000..2_000).contains(&a_second), "{rate}: {a_second}");
            // Soon after it all count again.
            let calm = (0..1_000).map(|sample| 10_100_000 + 4_000 * sample);
            assert!(used(&mut thinning, calm) >= 850, "{rate}");
        }
        // A hundred samples at once, then nothing for a tenth of a second.
        let arrivals = (0..10_000).map(|sample| 100_000 * (sample / 100));
        assert_eq!(used(&mut Thinning::NEW.clone(), arrivals), 10_000);
    }
}
