//! The points that are worth choosing.

use super::page::{brief, time};
use super::{Build, Comparison, Limit, Measure, Point};
use std::cmp::Ordering;

/// Returns which points, of an error and a cost each, are on the Pareto front: no other point
/// is as good in one and better in the other. Equal points are all on it; a point with a
/// number that is not finite is not.
pub fn pareto_front(points: &[(f64, f64)]) -> Vec<bool> {
    let beats = |a: (f64, f64), b: (f64, f64)| a.0 <= b.0 && a.1 <= b.1 && (a.0 < b.0 || a.1 < b.1);
    points
        .iter()
        .map(|&point| {
            let is_number = |(error, cost): (f64, f64)| error.is_finite() && cost.is_finite();
            let beaten = |&other: &(f64, f64)| is_number(other) && beats(other, point);
            is_number(point) && !points.iter().any(beaten)
        })
        .collect()
}

impl Comparison {
    pub(super) fn new(
        (id, title): (&'static str, &'static str),
        about: impl Into<String>,
        measures: Vec<Measure>,
        limit: Limit,
        mut points: Vec<Point>,
    ) -> Self {
        let has_steps = points.iter().all(|point| point.steps.is_some());
        let front = |cost: &dyn Fn(&Point) -> f64| {
            let costs = points.iter().map(|one| (one.error(), cost(one)));
            pareto_front(&costs.collect::<Vec<_>>())
        };
        let by_time = front(&|one| one.seconds);
        let by_steps = front(&|one| one.steps.map_or(f64::NAN, |steps| steps as f64));
        for number in 0..points.len() {
            // Same work, same result: times differ by chance, and the first stands for all.
            let (steps, error) = (points[number].steps, points[number].error());
            let is_twin = |other: &Point| other.steps == steps && other.error() == error;
            let first = points.iter().position(is_twin).filter(|_| has_steps);
            let first = &mut points[first.unwrap_or(number)];
            first.best_by_time |= by_time[number];
            first.best_by_steps |= has_steps && by_steps[number];
        }
        let choice = choice(&points, measures[0].label, &limit, Build::OPTIMISED);
        Self {
            id,
            title,
            about: about.into(),
            measures,
            limit,
            other_limit: None,
            choice,
            points,
            charts: Vec::new(),
            logarithmic: false,
        }
    }

    pub(super) fn with_other_limit(mut self, limit: Limit) -> Self {
        let label = self.measures[0].label;
        let other = choice(&self.points, label, &limit, Build::OPTIMISED);
        self.choice = format!("{} {other}", self.choice);
        self.other_limit = Some(limit);
        self
    }

    pub(super) fn logarithmic(mut self) -> Self {
        self.logarithmic = true;
        self
    }
}

/// Returns a sentence that names the cheapest point within the limit, or the nearest to the truth
/// where no point is. The cost is steps where all points have them, which are exact, and else
/// time, by which nothing is chosen where the build's times do not count.
pub(super) fn choice(points: &[Point], label: &str, limit: &Limit, times_count: bool) -> String {
    let cost = Cost::common(points);
    let numbers = points.iter().filter(|point| point.error().is_finite());
    let nearest = |a: &&Point, b: &&Point| by_error(a, b).then(cost.order(a, b));
    let Some(truest) = numbers.clone().min_by(nearest) else {
        return "Nothing was measured.".to_owned();
    };
    let within = format!(
        "at most {} ({}) of {label}",
        brief(limit.error),
        limit.because
    );
    let inside = numbers.filter(|point| point.error() <= limit.error);
    if matches!(cost, Cost::Time) && !times_count {
        let names = inside.map(|one| format!("{} ({})", one.name, brief(one.error())));
        let names: Vec<String> = names.collect();
        return format!("Settings with {within}: {}. {UNDECIDED}", names.join(", "));
    }
    let Some(cheapest) = inside.clone().min_by(|a, b| cost.order(a, b)) else {
        return format!(
            "No setting has {within}: choose {}, the nearest, with {} in {}.",
            truest.name,
            brief(truest.error()),
            cost.text(truest)
        );
    };
    // Points that cost the same as far as can be told.
    let equal = inside.filter(|point| !cost.is_less(cheapest, point));
    let chosen = equal.min_by(|a, b| by_error(a, b)).unwrap_or(cheapest);
    let beside = if chosen.name == truest.name {
        String::new()
    } else {
        let part = percent(cost.number(chosen) / cost.number(truest));
        let error = brief(truest.error());
        format!(", {part} of that of {} ({error})", truest.name)
    };
    format!(
        "Choose {}, the cheapest with {within}: {} in {}{beside}.",
        chosen.name,
        brief(chosen.error()),
        cost.text(chosen)
    )
}

/// The advice of a build whose times choose nothing.
pub(super) const UNDECIDED: &str = "Choose by the times of an optimised build (cargo build \
    --release): this one is not, and its times do not tell which is the fastest.";

fn by_error(a: &Point, b: &Point) -> Ordering {
    a.error().total_cmp(&b.error())
}

#[derive(Debug, Clone, Copy)]
enum Cost {
    Steps,
    Time,
}

impl Cost {
    fn common(points: &[Point]) -> Self {
        if points.iter().all(|point| point.steps.is_some()) {
            Self::Steps
        } else {
            Self::Time
        }
    }

    fn number(self, point: &Point) -> f64 {
        match self {
            Self::Steps => point.steps.unwrap_or(u64::MAX) as f64,
            Self::Time => point.seconds,
        }
    }

    fn order(self, a: &Point, b: &Point) -> Ordering {
        self.number(a).total_cmp(&self.number(b))
    }

    /// Returns whether one costs less than another beyond doubt: by more than a hundredth of the
    /// steps, or than the spread of the times.
    fn is_less(self, one: &Point, other: &Point) -> bool {
        let doubt = match self {
            Self::Steps => 0.01 * self.number(one).max(self.number(other)),
            Self::Time => one.spread.max(other.spread),
        };
        self.number(one) + doubt < self.number(other)
    }

    fn text(self, point: &Point) -> String {
        match self {
            Self::Steps => format!("{} million steps", brief(1e-6 * self.number(point))),
            Self::Time => time(point.seconds),
        }
    }
}

pub(super) fn percent(ratio: f64) -> String {
    format!("{:.0} %", 100.0 * ratio)
}

#[cfg(test)]
mod tests {
    use super::super::limit;
    use super::*;

    const LIMIT: Limit = limit(0.3, "a bound");

    fn point(name: &str, error: f64, seconds: f64) -> Point {
        Point {
            errors: vec![Some(error)],
            seconds,
            steps: Some((1e6 * seconds) as u64),
            ..Point::new("all", name, [])
        }
    }

    fn comparison(points: Vec<Point>) -> Comparison {
        let measures = vec![super::super::measure("off", "error")];
        Comparison::new(("one", "One"), "", measures, LIMIT, points)
    }

    #[test]
    fn the_front_is_what_nothing_beats() {
        let found = pareto_front(&[
            (0.0, 9.0),
            (1.0, 5.0),
            (1.0, 6.0),
            (2.0, 5.0),
            (3.0, 1.0),
            (3.0, 1.0),
            (4.0, 1.0),
            (f64::NAN, 0.0),
            (0.0, f64::INFINITY),
        ]);
        let best = [true, true, false, false, true, true, false, false, false];
        assert_eq!(found, best);
        assert_eq!(pareto_front(&[]), Vec::<bool>::new());
    }

    #[test]
    fn time_and_steps_have_a_front_each() {
        let best = |steps: [u64; 2], errors: [f64; 2]| {
            let mut points = vec![point("one", errors[0], 0.5), point("two", errors[1], 0.1)];
            (points[0].steps, points[1].steps) = (Some(steps[0]), Some(steps[1]));
            let points = comparison(points).points;
            [0, 1].map(|place| (points[place].best_by_time, points[place].best_by_steps))
        };
        assert_eq!(best([5, 1], [0.0, 1.0]), [(true, true); 2]);
        assert_eq!(best([1, 5], [0.0, 1.0]), [(true, true), (true, false)]);
        // The first of equal work stands for all, however fast the second was.
        assert_eq!(best([7, 7], [0.0, 0.0]), [(true, true), (false, false)]);
    }

    #[test]
    fn the_choice_follows_from_the_numbers() {
        let points = [
            point("full", 0.0, 1.0),
            point("half", 0.2, 0.5),
            point("near", 0.1, 0.503),
            point("rough", 1.0, 0.25),
        ];
        let says = |error: f64| choice(&points, "error", &Limit { error, ..LIMIT }, true);
        // A hundredth of the steps is no difference.
        let near = "Choose near, the cheapest with at most 0.3 (a bound) of error: 0.1 in 0.503 \
                    million steps, 50 % of that of full (0).";
        assert_eq!(says(0.3), near);
        let none = "No setting has at most -1 (a bound) of error: choose full, the nearest, with 0 \
                    in 1 million steps.";
        assert_eq!(says(-1.0), none);
        let other = Limit {
            error: 2.0,
            ..LIMIT
        };
        let both = comparison(points.to_vec()).with_other_limit(other).choice;
        assert!(both.starts_with("Choose near, ") && both.contains(". Choose rough, "));
        assert_eq!(choice(&[], "error", &LIMIT, true), "Nothing was measured.");
    }

    #[test]
    fn without_steps_times_choose_beyond_their_spread() {
        let says = |spread: f64, times_count: bool| {
            let points = [
                point("true", 0.0, 1.00),
                point("near", 0.1, 0.52),
                point("far", 0.2, 0.50),
                point("out", 3.0, 0.49),
            ];
            let points = points.map(|one| Point {
                steps: None,
                spread,
                ..one
            });
            choice(&points, "error", &LIMIT, times_count)
        };
        assert!(says(0.001, true).starts_with("Choose far, "));
        assert!(says(0.05, true).starts_with("Choose near, "));
        assert!(says(0.6, true).starts_with("Choose true, "));
        // The times of a build that is not optimised choose nothing.
        let found = says(0.001, false);
        assert!(found.contains("of error: true (0), near (0.1), far (0.2). "));
        assert!(found.ends_with(UNDECIDED), "{found}");
    }
}
