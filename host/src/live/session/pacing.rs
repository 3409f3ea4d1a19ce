//! Pacing: the refresh of each frame, and when it begins.

use super::Refresh;
use std::time::{Duration, Instant};

/// Frames that predict the next one's time, which is longer with a probability of 1 in 129.
const REMEMBERED: usize = 128;

/// The time kept between the expected end of tracing and the refresh.
const MARGIN: Duration = Duration::from_micros(700);

const SHORTEST: Duration = Duration::from_micros(1);

/// The time before a refresh at which a display has a frame: at first, and at least.
const LEADS: [Duration; 2] = [Duration::from_millis(2), Duration::from_millis(1)];

pub(super) struct Pacing {
    pub(super) period: Duration,
    /// How long before its refresh a frame is done at the latest.
    lead: Duration,
    start: Instant,
    /// The next refresh, counted from 1 after the start.
    pub(super) next: u64,
    /// The newest frames' times from the gaze to the last pixel, a ring.
    traced: [Duration; REMEMBERED],
    known: usize,
}

pub(super) struct Schedule {
    pub(super) begin: Instant,
    pub(super) display: Instant,
}

impl Pacing {
    pub(super) fn new(period: Duration) -> Self {
        Self {
            period: period.max(SHORTEST),
            lead: Duration::ZERO,
            start: Instant::now(),
            next: 1,
            traced: [Duration::ZERO; REMEMBERED],
            known: 0,
        }
    }

    pub(super) const fn begin(&mut self, now: Instant) {
        (self.start, self.next) = (now, 1);
    }

    pub(super) const fn forget(&mut self) {
        self.known = 0;
    }

    /// Keeps a lead from now on, for a display that is given frames before their refresh.
    pub(super) const fn keep_lead(&mut self) {
        [self.lead, _] = LEADS;
    }

    /// Learns whether a display showed a frame late that it had in time: longer leads are given
    /// back slowly, so that one frame in some 200 is late where the least lead does not do.
    pub(super) fn learn_lead(&mut self, is_late: bool) {
        self.lead = if is_late {
            (self.lead * 3 / 2).min(self.period / 2)
        } else {
            (self.lead * 511 / 512).max(LEADS[1].min(self.lead))
        };
    }

    pub(super) fn learn(&mut self, traced: Duration) {
        self.traced[self.known % REMEMBERED] = traced + self.lead;
        self.known += 1;
    }

    pub(super) fn at(&self, refresh: u64) -> Instant {
        self.start + self.span(refresh)
    }

    /// Returns the time in which a frame of this many refreshes is done.
    pub(super) const fn time(&self, refreshes: u64) -> Duration {
        self.span(refreshes).saturating_sub(self.lead)
    }

    const fn span(&self, refreshes: u64) -> Duration {
        let nanoseconds = self.period.as_nanos() as u64;
        Duration::from_nanos(refreshes.saturating_mul(nanoseconds))
    }

    pub(super) fn elapsed(&self, now: Instant) -> Duration {
        now.saturating_duration_since(self.start)
    }

    fn refreshes(&self, time: Duration) -> u64 {
        time.as_nanos().div_ceil(self.period.as_nanos()) as u64
    }

    /// Returns the refreshes that the next frame takes, and how long it may wait before it begins
    /// without being shown later. Frames that took more refreshes than the median were held up.
    fn expected(&self) -> (u64, Duration) {
        let mut all = self.traced;
        let count = self.known.min(REMEMBERED);
        let newest = &mut all[..count];
        newest.sort_unstable();
        let Some(&median) = newest.get(count / 2) else {
            return (1, Duration::ZERO);
        };
        let refreshes = self.refreshes(median).max(1);
        let waits = newest.iter().filter_map(|&traced| {
            let own = self.refreshes(traced).max(1);
            let left = self.span(own).saturating_sub(traced);
            (own <= refreshes).then(|| left.saturating_sub(traced / 10 + MARGIN))
        });
        (refreshes, waits.min().unwrap_or_default())
    }

    pub(super) fn schedule(&self) -> Schedule {
        let (refreshes, wait) = self.expected();
        Schedule {
            begin: self.at(self.next.saturating_sub(1)) + wait,
            display: self.at(self.next + refreshes - 1),
        }
    }

    /// Returns the refresh at which a frame that is done at a time is shown.
    pub(super) fn shown(&self, done: Instant) -> u64 {
        self.refreshes(self.elapsed(done) + self.lead)
            .max(self.next)
    }

    /// Returns the refresh at which a frame is shown that was meant for `shown` but is only shown
    /// now.
    pub(super) fn shown_late(&self, shown: u64, now: Instant) -> u64 {
        let under_way = self.elapsed(now).as_nanos() / self.period.as_nanos();
        shown.max(under_way as u64)
    }

    /// Follows the refreshes of a display. Returns the number of the refresh.
    pub(super) fn follow(&mut self, refresh: Refresh) -> u64 {
        let since = self.elapsed(refresh.at).as_secs_f64() / self.period.as_secs_f64();
        let number = since.round() as u64;
        self.period = refresh.period.max(SHORTEST);
        let start = refresh.at.checked_sub(self.span(number));
        self.start = start.unwrap_or(self.start);
        number
    }

    /// Advances after a frame; a delay since then costs whole refreshes.
    pub(super) fn advance(&mut self, shown: u64, now: Instant) {
        self.next = shown + 1;
        if self.at(self.next) < now {
            let (_, wait) = self.expected();
            let least = self.period.saturating_sub(wait);
            self.next = self.refreshes(self.elapsed(now) + least);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PERIOD: Duration = Duration::from_millis(10);

    fn periods(count: f64) -> Duration {
        PERIOD.mul_f64(count)
    }

    fn after(frames: &[f64]) -> Pacing {
        let mut pacing = Pacing::new(PERIOD);
        for &frame in frames {
            pacing.learn(periods(frame));
        }
        pacing
    }

    #[test]
    fn frames_wait_for_the_slowest_that_is_in_time() {
        // Time that a frame leaves of a refresh, less a tenth of the refresh and the margin.
        let left = |frame: f64| frame.ceil() - 1.1 * frame - 0.07;
        let long_ago = [vec![2.4; 1_000], vec![0.5; REMEMBERED]].concat();
        for (frames, refreshes, wait) in [
            (vec![], 1, 0.0),
            (vec![0.3, 0.5, 0.2], 1, left(0.5)),
            // Longer frames were held up.
            (vec![0.3, 0.5, 0.2, 1.4, 7.9], 1, left(0.5)),
            (vec![0.97, 0.3], 1, 0.0),
            (vec![2.4; 9], 3, left(2.4)),
            (vec![2.4, 2.4, 2.4, 1.6, 0.2], 3, left(1.6).min(left(2.4))),
            (vec![2.4, 2.4, 1.95, 1.4], 3, 0.0),
            (vec![2.4, 2.4, 2.4, 51.99], 3, left(2.4)),
            (long_ago, 1, left(0.5)),
        ] {
            let pacing = after(&frames);
            let (found, waits) = pacing.expected();
            let waits = waits.as_secs_f64() / PERIOD.as_secs_f64();
            assert_eq!(found, refreshes, "{frames:?}");
            assert!((waits - wait).abs() < 1.0e-6, "{frames:?}: {waits} {wait}");
            assert_eq!(pacing.schedule().display, pacing.at(refreshes));
        }
        let mut pacing = after(&[2.4; 5]);
        pacing.forget();
        assert_eq!(pacing.expected(), (1, Duration::ZERO));
    }

    #[test]
    fn each_frame_has_the_first_refresh_after_it() {
        for (frames, expected) in [
            ([0.5; 5], [1, 2, 3, 4, 5]),
            ([2.4; 5], [3, 6, 9, 12, 15]),
            // A frame that is held up skips refreshes, so that later frames are in time.
            ([0.5, 0.5, 5.2, 0.5, 0.5], [1, 2, 8, 9, 10]),
        ] {
            let mut pacing = after(&[frames[0]; 9]);
            let mut now = pacing.start;
            let shown = frames.map(|frame| {
                let done = now.max(pacing.schedule().begin) + periods(frame);
                let refresh = pacing.shown(done);
                pacing.learn(periods(frame));
                now = pacing.at(refresh);
                assert!(now >= done);
                pacing.advance(refresh, now);
                refresh
            });
            assert_eq!(shown, expected);
        }
    }

    #[test]
    fn delays_cost_whole_refreshes() {
        let mut pacing = after(&[0.5; 9]);
        let start = pacing.start;
        let at = |refresh: f64| start + periods(refresh);
        assert_eq!([pacing.shown(at(3.2)), pacing.shown(at(0.2))], [4, 1]);
        let late = [4.1, 6.1].map(|now| pacing.shown_late(4, at(now)));
        assert_eq!(late, [4, 6]);
        // There is time for a frame until the next refresh, or there is not.
        for (now, next) in [(4.9, 5), (5.3, 6), (5.9, 7)] {
            pacing.advance(4, at(now));
            assert_eq!(pacing.next, next);
        }
        // A frame that is done within the lead is for the refresh after, and late frames begin
        // earlier: as long as others are in time, by less and less.
        let begin = pacing.schedule().begin;
        pacing.keep_lead();
        assert_eq!([pacing.shown(at(7.7)), pacing.shown(at(7.9))], [8, 9]);
        for (is_late, count, lead) in [
            (true, 1, 0.3),
            (true, 9, 0.5),
            (false, 200, 0.34),
            (false, 2_000, 0.1),
        ] {
            (0..count).for_each(|_| pacing.learn_lead(is_late));
            pacing.learn(periods(0.5));
            let found = pacing.time(1).as_secs_f64() / PERIOD.as_secs_f64();
            assert!((found - (1.0 - lead)).abs() < 0.01, "{found} {lead}");
        }
        assert!(pacing.schedule().begin < begin);
        // A display's refreshes are the truth.
        let refresh = Refresh {
            shown: at(7.4),
            at: at(7.3),
            period: periods(0.9),
        };
        assert_eq!(pacing.follow(refresh), 7);
        assert_eq!(pacing.at(8), at(7.3) + periods(0.9));
        // No rate is too high.
        let mut pacing = Pacing::new(Duration::ZERO);
        pacing.learn(Duration::from_mins(1));
        let shown = pacing.shown(pacing.start + Duration::from_mins(1));
        assert_eq!(shown, 60_000_000);
        pacing.advance(shown, pacing.at(shown));
        assert!(pacing.schedule().display > pacing.schedule().begin);
    }
}
