//! The parts of their budgets that frames took.

use hdrhistogram::Histogram;

/// The largest part, in millionths.
const MOST: u64 = 1_000_000_000;

/// A histogram of parts of budgets, which takes no memory while it is filled.
pub(super) struct Shares(Option<Histogram<u64>>);

impl Shares {
    pub(super) fn new() -> Self {
        // Never an error: the bounds are constants.
        Self(Histogram::new_with_bounds(1, MOST, 3).ok())
    }

    pub(super) fn record(&mut self, share: f64) {
        if let Some(shares) = &mut self.0 {
            shares.saturating_record((share * 1.0e6) as u64);
        }
    }

    pub(super) fn median(&self) -> Option<f64> {
        let shares = self.0.as_ref().filter(|shares| !shares.is_empty())?;
        // The lower end of its class, so that a budget that was kept is not 1.0004.
        let median = shares.lowest_equivalent(shares.value_at_quantile(0.5));
        Some(median as f64 * 1.0e-6)
    }
}
