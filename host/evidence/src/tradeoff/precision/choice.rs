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

/// What to choose for a stage: what is built in where it keeps to its bound, as a program has
/// one precision, and where not, of the ways that are true enough the fastest. What the
/// others take is said beside it.
pub(super) fn of_one(comparison: &Comparison, times_count: bool) -> String {
    let limit = &comparison.limit;
    let bound = format!("{} ({})", brief(limit.error), limit.because);
    let is_enough = |point: &&Point| point.error() <= limit.error;
    let enough = comparison.points.iter().filter(is_enough);
    let by_time = |a: &&Point, b: &&Point| a.seconds.total_cmp(&b.seconds);
    let built_in = comparison.points.get(OURS).filter(is_enough);
    let Some(chosen) = built_in.or_else(|| enough.min_by(by_time)) else {
        return format!("No way has at most {bound}.");
    };
    if built_in.is_none() && !times_count {
        let all = comparison.points.iter();
        let all = all.map(|point| format!("{} by {}", point.name, largest(point)));
        return format!(
            "Off by {bound} or less is what is true enough: {}. {UNDECIDED}",
            all.collect::<Vec<_>>().join(", ")
        );
    }
    let why = if built_in.is_some() {
        "which keeps to its bound"
    } else {
        "the fastest of those that are true enough"
    };
    let others = comparison.points.iter();
    let others = others.filter(|point| point.name != chosen.name);
    let others: Vec<String> = others
        .map(|point| {
            let off = format!("{} by {}", point.name, largest(point));
            if times_count {
                let time = percent(point.seconds / chosen.seconds);
                format!("{off}, in {time} of its time")
            } else {
                off
            }
        })
        .collect();
    let told = if times_count {
        ""
    } else {
        " What they take is not told by this build, which is not optimised."
    };
    format!(
        "Choose {}, {why}, off by {bound} or less: by {} at most; {}.{told}",
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
        let one = "Choose built in, f32, which keeps to its bound, off by 1 (a bound) or less: by \
            0.1 at most; textbook, f32 by 2";
        for (double, spread, times_count, of_f64, of_all) in [
            (2.0, 0.01, true, "in 200 % of its time.", "takes 200 % of"),
            (
                0.5,
                0.01,
                true,
                "f64 by 0, in 50 % of its time.",
                "less careful formulas, takes 50 % of",
            ),
            (
                0.95,
                0.01,
                true,
                "in 95 % of its time.",
                "can be told (95 % of",
            ),
            (
                1.05,
                0.2,
                true,
                "in 105 % of its time.",
                "can be told (105 % of",
            ),
            (
                0.5,
                0.6,
                true,
                "in 50 % of its time.",
                "can be told (50 % of",
            ),
            (
                0.5,
                0.01,
                false,
                "f64 by 0. What they take is not told by this build, which is not optimised.",
                "not told by this build",
            ),
        ] {
            let (found, all) = says(double, spread, times_count);
            assert!(found.starts_with(one) && found.ends_with(of_f64), "{found}");
            let start = "Choose single precision as it is built in: all 1 stages keep";
            assert!(all.starts_with(start) && all.contains(of_all), "{all}");
        }
    }
    /// The stages say what the section says.
    #[test]
    fn where_what_is_built_in_is_not_enough_another_way_is_chosen() {
        let mut stage = stage([1.0, 0.5, 2.0], 0.01);
        stage.points[OURS].errors = vec![Some(3.0)];
        let found = of_one(&stage, true);
        assert!(
            found.starts_with("Choose f64, the fastest of those that are true enough, off by 1"),
            "{found}"
        );
        assert!(of_one(&stage, false).ends_with(UNDECIDED));
        stage.points[DOUBLE].errors = vec![Some(3.0)];
        assert_eq!(of_one(&stage, true), "No way has at most 1 (a bound).");
        assert!(of_all(&[stage], true).starts_with("Choose double precision for: one."));
    }
}
