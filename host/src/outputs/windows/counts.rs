//! Counts of what monitors showed.

use super::Showing;
use crate::outputs::{Output, OutputsReport, PaneReport};
use hdrhistogram::Histogram;
use std::time::Duration;

#[derive(Debug, Clone, Copy, Default)]
struct Count {
    shown: u64,
    late: u64,
    repeated: u64,
    missed: u64,
    newest: Option<u64>,
}

pub(super) struct Counts {
    panes: Vec<Count>,
    compared: u64,
    parted: u64,
    spread_us: Option<Histogram<u64>>,
}

impl Counts {
    pub(super) fn new(panes: usize) -> Self {
        Self {
            panes: vec![Count::default(); panes],
            compared: 0,
            parted: 0,
            spread_us: Histogram::new_with_bounds(1, 10_000_000, 3).ok(),
        }
    }

    pub(super) fn note_hidden(&mut self, pane: usize) {
        self.panes[pane].missed += 1;
    }

    pub(super) fn note_shown(&mut self, pane: usize, refresh: u64, late: bool) {
        let count = &mut self.panes[pane];
        count.shown += 1;
        count.late += u64::from(late);
        let since = count
            .newest
            .map(|newest| refresh.saturating_sub(newest + 1));
        count.repeated += since.unwrap_or(0);
        count.newest = Some(refresh);
    }

    /// Compares when outputs showed the newest frame, by the longest of their periods.
    /// With one clock, equal numbers are the same refresh.
    pub(super) fn count(&mut self, panes: &[Showing], period: Duration, has_one_clock: bool) {
        for (count, shown) in self.panes.iter_mut().zip(panes) {
            count.missed += u64::from(shown.awaited.is_some());
        }
        let times = || panes.iter().filter_map(|shown| shown.newest);
        if panes.len() < 2 || times().count() < panes.len() {
            return;
        }
        let bounds = times().map(|(at, _)| at);
        let (Some(first), Some(last)) = (bounds.clone().min(), bounds.max()) else {
            return;
        };
        let spread = last - first;
        self.compared += 1;
        // Times are noted late.
        let numbers = || times().map(|(_, number)| number);
        let same = has_one_clock && numbers().min() == numbers().max();
        self.parted += u64::from(!same && spread >= period / 2);
        if let Some(spreads) = &mut self.spread_us {
            spreads.saturating_record(spread.as_micros() as u64);
        }
    }

    pub(super) fn report(&self, pane: usize, output: &Output, hz: f64) -> PaneReport {
        let count = &self.panes[pane];
        PaneReport {
            shows: output.show.clone(),
            monitor: output.monitor.clone(),
            direct: None,
            hz,
            shown: count.shown,
            late: count.late,
            repeated: count.repeated,
            missed: count.missed,
            wrong_eyes: None,
        }
    }

    pub(super) fn all(&self, outputs: Vec<PaneReport>) -> OutputsReport {
        let spreads = self.spread_us.as_ref().filter(|_| self.compared > 0);
        OutputsReport {
            outputs,
            compared_frames: self.compared,
            parted_frames: self.parted,
            spread_ms: spreads.map(|spreads| {
                [0.5, 0.99, 1.0].map(|share| spreads.value_at_quantile(share) as f64 * 1.0e-3)
            }),
        }
    }
}
