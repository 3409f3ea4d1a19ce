//! Parts of budgets.

use hdrhistogram::Histogram;

/// Millionths that are told apart.
const MOST: u64 = 1_000_000_000;

/// Of each frame's budget a part. It takes no memory while it is filled.
pub(super) struct Shares(Option<Histogram<u64>>);

impl Shares {
    /// Of no frame yet.
    pub(super) fn new() -> Self {
        // Bounds and digits that it takes: they are constants.
        Self(Histogram::new_with_bounds(1, MOST, 3).ok())
    }

    /// Takes a frame's.
    pub(super) fn record(&mut self, share: f64) {
        if let Some(shares) = &mut self.0 {
            shares.saturating_record((share * 1.0e6) as u64);
        }
    }

    /// That of half of the frames is no larger; `None` of none.
    pub(super) fn median(&self) -> Option<f64> {
        let shares = self.0.as_ref().filter(|shares| !shares.is_empty())?;
        // Of those that are not told apart the least: what was kept is not 1.0004.
        let median = shares.lowest_equivalent(shares.value_at_quantile(0.5));
        Some(median as f64 * 1.0e-6)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_median_is_that_of_what_was_taken() {
        let mut shares = Shares::new();
        assert_eq!(shares.median(), None);
        for percent in 0..=100 {
            shares.record(f64::from(percent) * 0.01);
        }
        assert!((shares.median().unwrap() - 0.5).abs() < 1.0e-3);
        let mut whole = Shares::new();
        whole.record(1.0);
        assert!((0.999..=1.0).contains(&whole.median().unwrap()));
        for _ in 0..1_000 {
            shares.record(f64::INFINITY);
        }
        assert!((shares.median().unwrap() / 1_000.0 - 1.0).abs() < 1.0e-3);
    }
}
