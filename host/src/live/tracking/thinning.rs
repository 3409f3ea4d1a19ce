//! Chooses which samples are used of a tracker that sends more than an estimator is made for.

use shisen_tracker::time::Micros;

/// The least number of samples a second that are used of more; at most twice as many are.
const USED: u64 = 1_000;

/// The time over which the rate is measured; samples from a buffer, all at once, are no flood.
const OVER: Micros = Micros::from_millis(250);

#[derive(Debug, Clone, Copy)]
pub(super) struct Thinning {
    since: Option<Micros>,
    counted: u64,
    /// One sample in this many is used, by the recent rate.
    pub(super) one_of: u64,
}

impl Thinning {
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
