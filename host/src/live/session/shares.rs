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

    /// Records a frame's part.
    pub(super) fn record(&mut self, share: f64) {
        if let Some(shares) = &mut self.0 {
            shares.saturating_record((share * 1.0e6) as u64);
        }
    }

    /// The median; `None` without frames.
    pub(super) fn median(&self) -> Option<f64> {
        let shares = self.0.as_ref().filter(|shares| !shares.is_empty())?;
        // The lower end of its class, so that a budget that was kept is not 1.0004.
        let median = shares.lowest_equivalent(shares.value_at_quantile(0.5));
        Some(median as f64 * 1.0e-6)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_median_is_that_of_the_frames() {
        for (parts, median) in [(vec![1.0], 1.0), (vec![0.2, 0.5, 9.0], 0.5)] {
            let mut shares = Shares::new();
            assert_eq!(shares.median(), None);
            for part in parts {
                shares.record(part);
            }
            let found = shares.median().unwrap();
            assert!(found <= median && found > 0.999 * median, "{found}");
            for _ in 0..9 {
                shares.record(f64::INFINITY);
            }
            assert!(shares.median() > Some(999.0));
        }
    }
}
