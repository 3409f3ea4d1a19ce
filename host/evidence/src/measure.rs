//! Measuring in turns: each way runs once a round, so that a machine that slows down slows
//! all ways alike.

use shisen::live::quantiles::{median, median_ratio, quartiles};
use std::time::Instant;

/// Several times of the same work, and the result of its first run.
#[derive(Debug, Clone)]
pub struct Timed<T> {
    /// Seconds, by round.
    pub seconds: Vec<f64>,
    /// The result of the first run.
    pub first: T,
}

impl<T> Timed<T> {
    /// Returns the median time, seconds.
    pub fn median(&self) -> f64 {
        median(self.seconds.clone())
    }

    /// Returns the time between the quartiles, seconds.
    pub fn spread(&self) -> f64 {
        let [low, high] = quartiles(self.seconds.clone());
        high - low
    }

    /// Returns the median ratio of this time to another one of the same round.
    pub fn ratio_to<U>(&self, other: &Timed<U>) -> f64 {
        median_ratio(&self.seconds, &other.seconds)
    }
}

/// Runs all ways in turns for a number of rounds; `run` returns seconds and a result.
///
/// # Errors
/// The first error of a run.
pub fn in_turns<W, T, E>(
    ways: &[W],
    rounds: usize,
    run: impl FnMut(&W) -> Result<(f64, T), E>,
) -> Result<Vec<Timed<T>>, E> {
    in_turns_while(ways, |round| round < rounds, run)
}

/// Runs all ways in turns, round after round from 0, as long as `goes_on` returns true.
///
/// # Errors
/// The first error of a run.
pub fn in_turns_while<W, T, E>(
    ways: &[W],
    goes_on: impl Fn(usize) -> bool,
    mut run: impl FnMut(&W) -> Result<(f64, T), E>,
) -> Result<Vec<Timed<T>>, E> {
    let mut timed: Vec<Timed<T>> = Vec::new();
    for _ in (0..).take_while(|&round| goes_on(round)) {
        for (number, way) in ways.iter().enumerate() {
            let (seconds, first) = run(way)?;
            match timed.get_mut(number) {
                Some(one) => one.seconds.push(seconds),
                None => timed.push(Timed {
                    seconds: vec![seconds],
                    first,
                }),
            }
        }
    }
    Ok(timed)
}

/// Returns the seconds that a call takes, and its result.
pub fn timed<T>(run: impl FnOnce() -> T) -> (f64, T) {
    let start = Instant::now();
    let found = run();
    (start.elapsed().as_secs_f64(), found)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ways_take_turns() {
        let mut order = Vec::new();
        let run = |&way: &u32| {
            order.push(way);
            Ok::<_, ()>((f64::from(way) * order.len() as f64, order.len()))
        };
        let found = in_turns(&[2, 1], 3, run).unwrap();
        assert_eq!(order, [2, 1, 2, 1, 2, 1]);
        assert_eq!(found[0].seconds, [2.0, 6.0, 10.0]);
        assert_eq!((found[0].first, found[1].first), (1, 2));
        assert_eq!((found[0].median(), found[0].spread()), (6.0, 4.0));
        assert_eq!(found[0].ratio_to(&found[1]), 1.5);
        assert!(in_turns(&[1], 2, |_| Err::<(f64, ()), _>("no")).is_err());
    }
}
