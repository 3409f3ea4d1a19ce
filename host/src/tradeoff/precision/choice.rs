//! What to choose: a precision for a stage, and one for all of them.

use super::super::front::{UNDECIDED, percent};
use super::super::page::brief;
use super::{Comparison, DOUBLE, NAIVE, OURS, Point};

/// The largest error, for people.
fn largest(point: &Point) -> String {
    match point.errors.first().copied().flatten() {
        Some(error) => brief(error),
        None => "no number".to_owned(),
    }
}

/// What to choose for a stage: of the ways that are true enough the fastest, or the
/// first, which is what is built in, of those that take as long as far as can be told.
pub(super) fn of_one(comparison: &Comparison, times_count: bool) -> String {
    let limit = &comparison.limit;
    let bound = format!("{} ({})", brief(limit.error), limit.because);
    let enough = || {
        let all = comparison.points.iter();
        all.filter(|point| point.error() <= limit.error)
    };
    let by_time = |a: &&Point, b: &&Point| a.seconds.total_cmp(&b.seconds);
    let Some(fastest) = enough().min_by(by_time) else {
        return format!("No way has at most {bound}.");
    };
    if !times_count {
        let all = comparison.points.iter();
        let all = all.map(|point| format!("{} by {}", point.name, largest(point)));
        return format!(
            "Off by {bound} or less is what is true enough: {}. {UNDECIDED}",
            all.collect::<Vec<_>>().join(", ")
        );
    }
    let doubt = |point: &Point| {
        let spread = point.spread.max(fastest.spread);
        spread.max(LEAST_DOUBT * point.seconds)
    };
    let as_fast = |point: &&Point| fastest.seconds + doubt(point) >= point.seconds;
    let chosen = enough().find(as_fast).unwrap_or(fastest);
    let rank = if enough().filter(as_fast).count() > 1 {
        "as fast, as far as times tell, as any"
    } else {
        "the fastest"
    };
    let others: Vec<String> = comparison
        .points
        .iter()
        .filter(|point| point.name != chosen.name)
        .map(|point| {
            format!(
                "{} by {}, in {} of its time",
                point.name,
                largest(point),
                percent(point.seconds / chosen.seconds)
            )
        })
        .collect();
    format!(
        "Choose {}, {rank} of those that are off by {bound} or less: by {} at most; {}.",
        chosen.name,
        largest(chosen),
        others.join(", ")
    )
}

/// What to choose for all stages together: a program has one precision.
pub(super) fn of_all(comparisons: &[Comparison], times_count: bool) -> String {
    let titles = |of: &dyn Fn(&Comparison) -> bool| -> Vec<String> {
        let those = comparisons.iter().filter(|one| of(one));
        those.map(|one| one.title.to_lowercase()).collect()
    };
    let is_enough = |one: &Comparison, way: usize| {
        let point = one.points.get(way);
        point.is_some_and(|point| point.error() <= one.limit.error)
    };
    let lacking = titles(&|one| !is_enough(one, OURS));
    if !lacking.is_empty() {
        return format!(
            "Choose double precision for: {}. What is built in is not true enough there.",
            lacking.join(", ")
        );
    }
    let naive = titles(&|one| !is_enough(one, NAIVE));
    let naive = if naive.is_empty() {
        "the textbook's formulas keep to them, too".to_owned()
    } else {
        format!(
            "the textbook's formulas are not true enough for: {}",
            naive.join(", ")
        )
    };
    let sum = |way: usize, of: fn(&Point) -> f64| -> f64 {
        let points = comparisons.iter().filter_map(|one| one.points.get(way));
        points.map(of).sum()
    };
    let (single, double) = (sum(OURS, |one| one.seconds), sum(DOUBLE, |one| one.seconds));
    let doubt = [OURS, DOUBLE].map(|way| sum(way, |one| one.spread));
    let doubt = (doubt[0].max(doubt[1]) / single).max(LEAST_DOUBT);
    let ratio = double / single;
    let time = if !times_count {
        "what double precision takes is not told by this build, which is not optimised".to_owned()
    } else if ratio > 1.0 + doubt {
        format!(
            "double precision takes {} of their time together",
            percent(ratio)
        )
    } else if ratio < 1.0 - doubt {
        format!(
            "double precision, which needs less careful formulas, takes {} of their time together \
             where rays go one by one on a processor like this; in vectors it has half the lanes",
            percent(ratio)
        )
    } else {
        format!(
            "double precision takes as long as far as can be told ({} of their time together)",
            percent(ratio)
        )
    };
    format!(
        "Choose single precision as it is built in: all {} stages keep to their bounds, and {time}; \
         {naive}.",
        comparisons.len(),
    )
}

/// What times are apart by chance at the least, as a part of them: a machine runs at
/// one speed now and at another in the next run.
const LEAST_DOUBT: f64 = 0.1;

#[cfg(test)]
mod tests {
    use super::super::{Limit, measure};
    use super::*;

    /// Of all stages one: what is built in, the textbook's and double precision.
    fn stage(seconds: [f64; 3], spread: f64) -> Comparison {
        let points = ["built in, f32", "textbook, f32", "f64"];
        let points = points.into_iter().zip(seconds).zip([0.1, 2.0, 0.0]);
        let points = points.map(|((name, seconds), error)| Point {
            errors: vec![Some(error)],
            seconds,
            spread,
            ..Point::new("one", name, [])
        });
        let measures = vec![measure("largest", "largest")];
        let limit = Limit {
            error: 1.0,
            because: "a bound",
        };
        Comparison::new(("one", "One"), "", measures, limit, points.collect())
    }

    #[test]
    fn times_choose_beyond_their_doubt_and_in_an_optimised_build_alone() {
        let says = |double: f64, spread: f64, times_count: bool| {
            let stage = stage([1.0, 0.5, double], spread);
            (of_one(&stage, times_count), of_all(&[stage], times_count))
        };
        // Whatever the times are, what is enough stays chosen for all stages.
        for (double, spread, times_count, of_one, of_all) in [
            (
                2.0,
                0.01,
                true,
                "Choose built in, f32, the fastest",
                "takes 200 % of",
            ),
            (
                0.5,
                0.01,
                true,
                "Choose f64, the fastest",
                "less careful formulas, takes 50 % of",
            ),
            (
                0.95,
                0.01,
                true,
                "Choose built in, f32, as fast, as",
                "can be told (95 % of",
            ),
            (
                1.05,
                0.2,
                true,
                "Choose built in, f32, as fast, as",
                "can be told (105 % of",
            ),
            (
                0.5,
                0.6,
                true,
                "Choose built in, f32, as fast, as",
                "can be told (50 % of",
            ),
            (
                0.5,
                0.01,
                false,
                "Off by 1 (a bound) or less",
                "not told by this build",
            ),
        ] {
            let (one, all) = says(double, spread, times_count);
            assert!(one.starts_with(of_one), "{one}");
            assert_eq!(one.ends_with(UNDECIDED), !times_count, "{one}");
            let start = "Choose single precision as it is built in: all 1 stages keep";
            assert!(all.starts_with(start) && all.contains(of_all), "{all}");
        }
    }
}
