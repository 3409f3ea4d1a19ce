//! Which samples of a tracker that sends more than an estimator is made for are used.

use shisen_tracker::time::Micros;

/// Samples of a sensor a second that are used of more, or less than twice as many: those
/// that a [`GazeEstimator`](shisen_tracker::estimate::GazeEstimator) keeps reach back
/// for so long that velocities are taken over all of their windows, or most of them.
const USED: u64 = 1_000;

/// Over how long a rate is taken. What lay in a buffer and comes at once is no flood.
const OVER: Micros = Micros::from_millis(250);

/// One sensor's.
#[derive(Debug, Clone, Copy)]
pub(super) struct Thinning {
    since: Option<Micros>,
    counted: u64,
    one_of: u64,
}

impl Thinning {
    /// Nothing has come.
    pub(super) const NEW: Self = Self {
        since: None,
        counted: 0,
        one_of: 1,
    };

    /// Of how many samples one is used, by the rate of late.
    pub(super) const fn one_of(&self) -> u64 {
        self.one_of
    }

    /// Whether a sample that came then is used.
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
    use crate::live::quantiles::median;
    use shisen_tracker::estimate::{EstimatorConfig, GazeEstimator};
    use shisen_tracker::mock::{Tracker, TrackerConfig, Viewer, ViewerConfig};

    fn used(thinning: &mut Thinning, arrivals: impl Iterator<Item = u64>) -> usize {
        arrivals
            .filter(|&arrival| thinning.uses(Micros(arrival)))
            .count()
    }

    #[test]
    fn what_trackers_send_is_used_and_of_a_flood_a_part() {
        for rate in [1, 60, 240, 1_000, 1_999] {
            let arrivals = (0..5 * rate).map(|sample| 1_000_000 * sample / rate);
            let mut thinning = Thinning::NEW;
            let used = used(&mut thinning, arrivals);
            assert_eq!(used as u64, 5 * rate, "{rate}");
        }
        for rate in [2_000, 3_500, 10_000] {
            let mut thinning = Thinning::NEW;
            let arrivals = |from: u64| {
                let samples = from * rate..(from + 5) * rate;
                samples.map(move |sample| 1_000_000 * sample / rate)
            };
            used(&mut thinning, arrivals(0));
            let a_second = used(&mut thinning, arrivals(5)) / 5;
            assert!((1_000..2_000).contains(&a_second), "{rate}: {a_second}");
            // When it is over for the time that its rate is taken over, or two of these,
            // all count again.
            let calm = (0..1_000).map(|sample| 10_100_000 + 4_000 * sample);
            assert!(used(&mut thinning, calm) >= 850, "{rate}");
        }
    }

    #[test]
    fn what_comes_at_once_is_no_flood() {
        let mut thinning = Thinning::NEW;
        // Hundred samples, then nothing for a tenth of a second.
        let arrivals = (0..10_000).map(|sample| 100_000 * (sample / 100));
        assert_eq!(used(&mut thinning, arrivals), 10_000);
    }

    /// How far the gaze is off 20 ms after a sample, at the median: degrees.
    fn off(rate: u32, thinned: bool) -> f64 {
        let viewer = || Viewer::new(ViewerConfig::default(), 5);
        let config = TrackerConfig {
            rate,
            latency: Micros(0),
            ..TrackerConfig::default()
        };
        let mut tracker = Tracker::new(config, viewer(), 5).unwrap();
        let mut estimator: GazeEstimator = GazeEstimator::new(EstimatorConfig::default()).unwrap();
        let (mut thinning, mut truth) = (Thinning::NEW, viewer());
        let mut off = Vec::new();
        for number in 0..8 * rate {
            let (time, sample) = tracker.next_sample();
            if !thinned || thinning.uses(sample.arrival) {
                estimator.push(&sample, time, &mut |_| {});
            }
            let display = time.after(Micros::from_millis(20));
            if number.is_multiple_of(rate / 50)
                && let Some(truth) = truth.truth(display)
            {
                let found = estimator.estimate(display, &mut |_| {});
                let found = found.line_of_sight.forward();
                off.push(
                    truth
                        .direction
                        .as_dvec3()
                        .angle_between(found.as_dvec3())
                        .to_degrees(),
                );
            }
        }
        median(off)
    }

    #[test]
    fn a_flood_makes_no_gaze_worse() {
        let [usual, all, part] = [(1_000, false), (10_000, false), (10_000, true)]
            .map(|(rate, thinned)| off(rate, thinned));
        println!("off by {usual:.4}° at 1,000 Hz, {all:.4}° and {part:.4}° of 10,000 Hz");
        assert!(part <= 1.05 * usual, "{part} {usual}");
        assert!(part <= all, "{part} {all}");
    }
}
