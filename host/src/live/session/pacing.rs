//! Which refresh a frame is for, and when it begins.

use std::time::{Duration, Instant};

/// Frames that say how long the next one takes: one of which the next is slower with a
/// probability of 1 in 129.
const REMEMBERED: usize = 128;

/// What is kept between the expected end of tracing and the refresh.
const MARGIN: Duration = Duration::from_micros(700);

/// The shortest time between refreshes.
const SHORTEST: Duration = Duration::from_micros(1);

/// The refreshes of a display, and how long frames take beside them. A frame is shown at
/// the first refresh after its last pixel, no two at the same one, and the next begins
/// when it is shown.
pub(super) struct Pacing {
    period: Duration,
    start: Instant,
    /// The next refresh: their numbers count from the start, which is none.
    next: u64,
    /// From taking the gaze to the last pixel, of the newest frames, a ring.
    traced: [Duration; REMEMBERED],
    known: usize,
}

/// What is expected of a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Aim {
    /// So late it may begin.
    pub(super) begin: Instant,
    /// When it will be shown.
    pub(super) display: Instant,
}

impl Pacing {
    /// Of a display with so long between its refreshes, which begin now.
    pub(super) fn new(period: Duration) -> Self {
        Self {
            period: period.max(SHORTEST),
            start: Instant::now(),
            next: 1,
            traced: [Duration::ZERO; REMEMBERED],
            known: 0,
        }
    }

    /// Begins anew at a time, with what is known of frames.
    pub(super) const fn begin(&mut self, now: Instant) {
        (self.start, self.next) = (now, 1);
    }

    /// Forgets how long frames took.
    pub(super) const fn forget(&mut self) {
        self.known = 0;
    }

    /// Learns how long a frame took.
    pub(super) fn learn(&mut self, traced: Duration) {
        self.traced[self.known % REMEMBERED] = traced;
        self.known += 1;
    }

    /// Between two refreshes.
    pub(super) const fn period(&self) -> Duration {
        self.period
    }

    /// The next refresh that shows a frame, at the earliest.
    pub(super) const fn next(&self) -> u64 {
        self.next
    }

    /// When a refresh is.
    pub(super) fn at(&self, refresh: u64) -> Instant {
        self.start + self.span(refresh)
    }

    /// How long so many refreshes last.
    const fn span(&self, refreshes: u64) -> Duration {
        let nanoseconds = self.period.as_nanos() as u64;
        Duration::from_nanos(refreshes.saturating_mul(nanoseconds))
    }

    /// Since when the loop goes.
    pub(super) fn elapsed(&self, now: Instant) -> Duration {
        now.saturating_duration_since(self.start)
    }

    /// How many refreshes a time lasts, the last one begun.
    fn refreshes(&self, time: Duration) -> u64 {
        time.as_nanos().div_ceil(self.period.as_nanos()) as u64
    }

    /// How many refreshes the next frame takes, and how long it may wait before it
    /// begins, so that those like the newest ones are shown no later for it. What takes
    /// more refreshes than half of these do was held up, and is not waited for.
    fn expected(&self) -> (u64, Duration) {
        let mut all = self.traced;
        let count = self.known.min(REMEMBERED);
        let newest = &mut all[..count];
        newest.sort_unstable();
        let Some(&median) = newest.get(count / 2) else {
            return (1, Duration::ZERO);
        };
        let refreshes = self.refreshes(median).max(1);
        let usual = newest
            .iter()
            .map(|&traced| (self.refreshes(traced).max(1), traced))
            .filter(|(of, _)| *of <= refreshes);
        let waits = usual.map(|(of, traced)| {
            let left = self.span(of).saturating_sub(traced);
            left.saturating_sub(traced / 10 + MARGIN)
        });
        (refreshes, waits.min().unwrap_or_default())
    }

    /// For the next frame.
    pub(super) fn aim(&self) -> Aim {
        let (refreshes, wait) = self.expected();
        Aim {
            begin: self.at(self.next.saturating_sub(1)) + wait,
            display: self.at(self.next + refreshes - 1),
        }
    }

    /// At which refresh a frame is shown that was done then.
    pub(super) fn shown(&self, done: Instant) -> u64 {
        self.refreshes(self.elapsed(done)).max(self.next)
    }

    /// At which one, where that was only then.
    pub(super) fn shown_late(&self, shown: u64, now: Instant) -> u64 {
        let under_way = self.elapsed(now).as_nanos() / self.period.as_nanos();
        shown.max(under_way as u64)
    }

    /// Goes on after a frame. Whoever held the loop up since costs whole refreshes: also
    /// the one under way where too little is left of it.
    pub(super) fn go_on(&mut self, shown: u64, now: Instant) {
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

    /// One of frames that took so many refreshes each.
    fn of(frames: impl IntoIterator<Item = f64>) -> Pacing {
        let mut pacing = Pacing::new(PERIOD);
        for frame in frames {
            pacing.learn(periods(frame));
        }
        pacing
    }

    /// Refreshes that the next frame takes, and refreshes that it waits.
    fn expected(frames: impl IntoIterator<Item = f64>) -> (u64, f64) {
        let (refreshes, wait) = of(frames).expected();
        (refreshes, wait.as_secs_f64() / PERIOD.as_secs_f64())
    }

    /// What of a refresh is left beside a frame.
    fn left(frame: f64) -> f64 {
        frame.ceil() - 1.1 * frame - 0.07
    }

    fn near((refreshes, wait): (u64, f64), wanted: (u64, f64)) {
        assert_eq!(refreshes, wanted.0);
        assert!((wait - wanted.1).abs() < 1.0e-6, "{wait} {wanted:?}");
    }

    #[test]
    fn frames_wait_for_the_slowest_that_is_in_time() {
        near(expected([]), (1, 0.0));
        near(expected([0.3, 0.5, 0.2]), (1, left(0.5)));
        // What took longer than there is costs no wait of the others.
        near(expected([0.3, 0.5, 0.2, 1.4, 7.9]), (1, left(0.5)));
        near(expected([0.97, 0.3]), (1, 0.0));
    }

    #[test]
    fn frames_that_take_several_refreshes_wait_for_the_last_of_these() {
        near(expected([2.4; 9]), (3, left(2.4)));
        let pacing = of([2.4; 9]);
        assert_eq!(pacing.aim().display, pacing.at(3));
        // None is shown a refresh later for it.
        near(
            expected([2.4, 2.4, 2.4, 1.6, 0.2]),
            (3, left(1.6).min(left(2.4))),
        );
        near(expected([2.4, 2.4, 1.95, 1.4]), (3, 0.0));
        near(expected([2.4, 2.4, 2.4, 51.99]), (3, left(2.4)));
    }

    #[test]
    fn only_the_newest_frames_are_looked_at() {
        let slow = std::iter::repeat_n(2.4, 1_000);
        near(expected(slow.chain([0.5; REMEMBERED])), (1, left(0.5)));
        let mut pacing = of([2.4; 5]);
        pacing.forget();
        assert_eq!(pacing.expected(), (1, Duration::ZERO));
    }

    /// Plays frames that take so long from when they begin on; refreshes that they were
    /// shown at.
    fn play(pacing: &mut Pacing, frames: impl IntoIterator<Item = f64>) -> Vec<u64> {
        let mut now = pacing.start;
        let mut shown = Vec::new();
        for frame in frames {
            let begin = now.max(pacing.aim().begin);
            let refresh = pacing.shown(begin + periods(frame));
            pacing.learn(periods(frame));
            now = pacing.at(refresh);
            assert!(now >= begin + periods(frame));
            pacing.go_on(refresh, now);
            shown.push(refresh);
        }
        shown
    }

    #[test]
    fn each_frame_has_the_first_refresh_after_it() {
        let mut pacing = of([0.5; 9]);
        assert_eq!(play(&mut pacing, [0.5; 5]), [1, 2, 3, 4, 5]);
        let mut pacing = of([2.4; 9]);
        let shown = play(&mut pacing, [2.4; 5]);
        assert_eq!(shown, [3, 6, 9, 12, 15]);
        // One that is held up skips refreshes, and those after it are in time.
        let mut pacing = of([0.5; 9]);
        let shown = play(&mut pacing, [0.5, 0.5, 5.2, 0.5, 0.5]);
        assert_eq!(shown, [1, 2, 8, 9, 10]);
    }

    #[test]
    fn what_is_shown_late_and_who_holds_the_loop_up_cost_whole_refreshes() {
        let mut pacing = of([0.5; 9]);
        let at = |pacing: &Pacing, refresh: f64| pacing.start + periods(refresh);
        assert_eq!(pacing.shown(at(&pacing, 3.2)), 4);
        assert_eq!(pacing.shown(at(&pacing, 0.2)), 1);
        assert_eq!(pacing.shown_late(4, at(&pacing, 4.1)), 4);
        assert_eq!(pacing.shown_late(4, at(&pacing, 6.1)), 6);
        // There is time for a frame until the next one, or there is not.
        pacing.go_on(4, at(&pacing, 4.9));
        assert_eq!(pacing.next(), 5);
        pacing.go_on(4, at(&pacing, 5.3));
        assert_eq!(pacing.next(), 6);
        pacing.go_on(4, at(&pacing, 5.9));
        assert_eq!(pacing.next(), 7);
    }

    #[test]
    fn no_rate_is_too_high() {
        let mut pacing = Pacing::new(Duration::ZERO);
        pacing.learn(Duration::from_mins(1));
        let shown = pacing.shown(pacing.start + Duration::from_mins(1));
        assert_eq!(shown, 60_000_000);
        pacing.go_on(shown, pacing.at(shown));
        assert!(pacing.aim().display > pacing.aim().begin);
    }
}
