//! Which points are worth choosing.

use super::page::{brief, time};
use super::{Build, Comparison, Limit, Measure, Point};
use std::cmp::Ordering;
use std::fmt::Write as _;

/// Of points of an error and a cost each, those that no other is better than:
/// as good in one and better in the other. Of equal points all are on the
/// front; a number that is none is on none.
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
    /// Of points that were measured: finds the fronts, and what to choose.
    pub(super) fn new(
        (id, title): (&'static str, &'static str),
        about: impl Into<String>,
        measures: Vec<Measure>,
        limit: Limit,
        mut points: Vec<Point>,
    ) -> Self {
        let has_steps = points.iter().all(|point| point.steps.is_some());
        let fronts = {
            let front = |cost: &dyn Fn(&Point) -> f64| {
                let costs = points.iter().map(|one| (one.error(), cost(one)));
                pareto_front(&costs.collect::<Vec<_>>())
            };
            let by_steps = |one: &Point| one.steps.unwrap_or(0) as f64;
            (front(&|one| one.seconds), front(&by_steps))
        };
        for number in 0..points.len() {
            // The same work with the same result: the times differ by chance, and
            // the first stands for all.
            let same = |other: &Point| {
                let point = &points[number];
                has_steps && other.steps == point.steps && other.error() == point.error()
            };
            let first = !points[..number].iter().any(same);
            points[number].best_by_steps = first && has_steps && fronts.1[number];
            points[number].best_by_time = first && fronts.0[number];
        }
        // Where chance was against the first, it takes its place.
        for number in 0..points.len() {
            let best = fronts.0[number] && !points[number].best_by_time;
            let (steps, error) = (points[number].steps, points[number].error());
            let first = points
                .iter_mut()
                .find(|other| other.steps == steps && other.error() == error);
            if let (true, Some(first)) = (best, first) {
                first.best_by_time = true;
            }
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

    /// Says, too, what to choose within another limit of the same measure.
    pub(super) fn choose_within_too(&mut self, limit: Limit) {
        let other = within_too(
            &self.points,
            self.measures[0].label,
            &limit,
            Build::OPTIMISED,
        );
        self.choice.push(' ');
        self.choice.push_str(&other);
        self.other_limit = Some(limit);
    }
}

/// The sentence for another limit: what is the best within it, and its price beside that of
/// the nearest to the truth.
fn within_too(points: &[Point], measure: &str, limit: &Limit, times_count: bool) -> String {
    let cost = Cost::of_all(points);
    let within = within(limit, measure);
    if matches!(cost, Cost::Time) && !times_count {
        return format!("With {within}: as above.");
    }
    match (best_within(points, limit, cost), truest(points, cost)) {
        (Some(best), Some(truest)) => format!(
            "With {within}: {}, {}, {} of the {} of {} ({}).",
            best.name,
            brief(best.error()),
            percent(cost.number(best) / cost.number(truest)),
            cost.noun(),
            truest.name,
            brief(truest.error()),
        ),
        _ => format!("No setting has {within}."),
    }
}

/// A limit, for people.
fn within(limit: &Limit, measure: &str) -> String {
    format!(
        "at most {} ({}) of {measure}",
        brief(limit.error),
        limit.because
    )
}

/// What has an error.
fn numbers(points: &[Point]) -> impl Iterator<Item = &Point> + Clone {
    points.iter().filter(|point| point.error().is_finite())
}

/// The nearest to the truth.
fn truest(points: &[Point], cost: Cost) -> Option<&Point> {
    numbers(points).min_by(|a, b| by_error(a, b).then(cost.order(a, b)))
}

/// Of those within a limit that cost the same as the cheapest as far as can be told, the
/// nearest to the truth.
fn best_within<'p>(points: &'p [Point], limit: &Limit, cost: Cost) -> Option<&'p Point> {
    let inside = numbers(points).filter(|point| point.error() <= limit.error);
    let cheapest = inside.clone().min_by(|a, b| cost.order(a, b))?;
    inside
        .filter(|point| !cost.is_less(cheapest, point))
        .min_by(|a, b| by_error(a, b))
}

/// The cheapest point within the limit, beside the one that is nearest to the
/// truth and the next cheaper one: by steps where all points have them, which are
/// exact, else by time, where what chance may have put before another is not
/// before it, and where the build's times tell nothing, none is chosen by them.
fn choice(points: &[Point], measure: &str, limit: &Limit, times_count: bool) -> String {
    let cost = Cost::of_all(points);
    let Some(truest) = truest(points, cost) else {
        return "Nothing was measured.".to_owned();
    };
    let within = within(limit, measure);
    if matches!(cost, Cost::Time) && !times_count {
        let inside = numbers(points).filter(|point| point.error() <= limit.error);
        let those = inside.map(|one| format!("{} ({})", one.name, brief(one.error())));
        let those = match those.collect::<Vec<_>>() {
            none if none.is_empty() => "No setting has".to_owned(),
            one if one.len() == 1 => format!("{} has", one[0]),
            several => format!("{} have", several.join(", ")),
        };
        return format!("{those} {within}. {UNDECIDED}");
    }
    let Some(chosen) = best_within(points, limit, cost) else {
        return nearest(points, truest, cost, &within);
    };
    let best = cost.best();
    // Writing to a string does not fail.
    let mut text = format!(
        "Choose {}, {best} of all with {within}: {} in {}",
        chosen.name,
        brief(chosen.error()),
        cost.of(chosen),
    );
    if chosen.name != truest.name {
        let _ = write!(
            text,
            ", {} of that of {} ({})",
            percent(cost.number(chosen) / cost.number(truest)),
            truest.name,
            brief(truest.error()),
        );
    }
    let cheaper = numbers(points).filter(|point| cost.is_less(point, chosen));
    let nearest = cheaper
        .clone()
        .min_by(|a, b| by_error(a, b).then(cost.order(a, b)));
    let Some((nearest, as_near)) =
        nearest.and_then(|one| Some((one, cheapest_as_near(cheaper, one, cost)?)))
    else {
        let _ = write!(text, "; {}.", cost.nothing_less());
        return text;
    };
    let _ = write!(
        text,
        "; {} would take {} of it, with {}",
        as_near.name,
        percent(cost.number(as_near) / cost.number(chosen)),
        brief(as_near.error()),
    );
    let _ = if as_near.name == nearest.name {
        write!(text, ".")
    } else {
        write!(
            text,
            " ± {} as near as can be told as {} ({}).",
            brief(as_near.doubt(nearest)),
            nearest.name,
            brief(nearest.error()),
        )
    };
    text
}

/// Of what may be as near to the truth as another, by chance, what costs least.
fn cheapest_as_near<'a>(
    points: impl Iterator<Item = &'a Point>,
    nearest: &Point,
    cost: Cost,
) -> Option<&'a Point> {
    points
        .filter(|point| point.error() - point.doubt(nearest) <= nearest.error())
        .min_by(|a, b| cost.order(a, b))
}

impl Point {
    /// Its error may be less than another's by chance where it is above it by no more than
    /// this: twice the standard error of the difference, detail by detail.
    fn doubt(&self, other: &Self) -> f64 {
        let pairs = self.of_details.iter().zip(&other.of_details);
        let above: Vec<f64> = pairs.map(|(own, other)| own - other).collect();
        2.0 * deviation(&above) / libm::sqrt(above.len().max(1) as f64)
    }
}

pub(super) fn mean(of: &[f64]) -> f64 {
    of.iter().sum::<f64>() / of.len().max(1) as f64
}

/// The standard deviation.
pub(super) fn deviation(of: &[f64]) -> f64 {
    let middle = mean(of);
    let squares = of.iter().map(|one| (one - middle) * (one - middle));
    libm::sqrt(squares.sum::<f64>() / (of.len().max(2) - 1) as f64)
}

/// The choice where nothing is within the limit: of what is as near to the truth as
/// the nearest, as far as can be told, the one that costs least.
fn nearest(points: &[Point], truest: &Point, cost: Cost, within: &str) -> String {
    let Some(chosen) = cheapest_as_near(points.iter(), truest, cost) else {
        return "Nothing was measured.".to_owned();
    };
    let mut text = format!("No setting has {within}: choose {}, ", chosen.name);
    let (error, price) = (brief(chosen.error()), cost.of(chosen));
    // Writing to a string does not fail.
    let _ = if chosen.name == truest.name {
        write!(text, "the nearest, with {error} in {price}.")
    } else {
        write!(
            text,
            "with {error} ± {} as near as can be told, in {price}, {} of that of the nearest, {} ({}).",
            brief(chosen.doubt(truest)),
            percent(cost.number(chosen) / cost.number(truest)),
            truest.name,
            brief(truest.error()),
        )
    };
    text
}

/// Where times would choose, and those of this build do not count.
pub(super) const UNDECIDED: &str = "Choose by the times of an optimised build (cargo build \
    --release): this one is not, and its times do not tell which is the fastest.";

fn by_error(a: &Point, b: &Point) -> Ordering {
    a.error().total_cmp(&b.error())
}

/// What points are chosen by.
#[derive(Debug, Clone, Copy)]
enum Cost {
    Steps,
    Time,
}

impl Cost {
    /// Steps where all points have them, which are exact.
    fn of_all(points: &[Point]) -> Self {
        if points.iter().all(|point| point.steps.is_some()) {
            Self::Steps
        } else {
            Self::Time
        }
    }

    const fn noun(self) -> &'static str {
        match self {
            Self::Steps => "steps",
            Self::Time => "time",
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

    /// Whether one costs less than another beyond doubt: medians are farther
    /// apart than the times that they are of.
    fn is_less(self, one: &Point, other: &Point) -> bool {
        let doubt = match self {
            // What is within a hundredth costs the same to anybody: `best` says so.
            Self::Steps => 0.01 * self.number(one).max(self.number(other)),
            Self::Time => one.spread.max(other.spread),
        };
        self.number(one) + doubt < self.number(other)
    }

    fn of(self, point: &Point) -> String {
        match self {
            Self::Steps => format!("{} million steps", brief(1e-6 * self.number(point))),
            Self::Time => time(point.seconds),
        }
    }

    const fn best(self) -> &'static str {
        match self {
            Self::Steps => "within a hundredth of the fewest steps",
            Self::Time => "the fastest",
        }
    }

    const fn nothing_less(self) -> &'static str {
        match self {
            Self::Steps => "nothing takes fewer by more than that",
            Self::Time => "nothing is faster beyond the spread of times",
        }
    }
}

pub(super) fn percent(ratio: f64) -> String {
    format!("{:.0} %", 100.0 * ratio)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(name: &str, error: f64, seconds: f64) -> Point {
        let mut point = Point::new("all", name, []);
        point.errors = vec![Some(error)];
        point.seconds = seconds;
        point.steps = Some((1e6 * seconds) as u64);
        point
    }

    fn comparison(limit: f64, points: Vec<Point>) -> Comparison {
        let measures = vec![super::super::measure("off", "error")];
        let limit = Limit {
            error: limit,
            because: "a bound",
        };
        Comparison::new(("one", "One"), "", measures, limit, points)
    }

    #[test]
    fn the_front_is_what_nothing_beats() {
        let nan = f64::NAN;
        let found = pareto_front(&[
            (0.0, 9.0),
            (1.0, 5.0),
            (1.0, 6.0),
            (2.0, 5.0),
            (3.0, 1.0),
            (3.0, 1.0),
            (4.0, 1.0),
            (nan, 0.0),
            (0.0, f64::INFINITY),
        ]);
        let best = [true, true, false, false, true, true, false, false, false];
        assert_eq!(found, best);
        assert_eq!(pareto_front(&[]), Vec::<bool>::new());
    }

    #[test]
    fn time_and_steps_have_a_front_each() {
        let points = vec![point("slow", 0.0, 0.5), point("fast", 1.0, 0.1)];
        let found = comparison(0.5, points);
        let best = |of: fn(&Point) -> bool| found.points.iter().map(of).collect::<Vec<_>>();
        assert_eq!(best(|one| one.best_by_time), [true, true]);
        assert_eq!(best(|one| one.best_by_steps), [true, true]);
        let mut points = vec![point("slow", 0.0, 0.5), point("fast", 1.0, 0.1)];
        points[0].steps = Some(1);
        let found = comparison(0.5, points);
        let best = |of: fn(&Point) -> bool| found.points.iter().map(of).collect::<Vec<_>>();
        assert_eq!(best(|one| one.best_by_time), [true, true]);
        assert_eq!(best(|one| one.best_by_steps), [true, false]);
    }

    #[test]
    fn the_first_of_equal_work_stands_for_all() {
        let mut points = vec![point("one", 0.0, 0.5), point("two", 0.0, 0.4)];
        points[0].steps = Some(7);
        points[1].steps = Some(7);
        let found = comparison(1.0, points);
        let best = |of: fn(&Point) -> bool| found.points.iter().map(of).collect::<Vec<_>>();
        assert_eq!(best(|one| one.best_by_time), [true, false]);
        assert_eq!(best(|one| one.best_by_steps), [true, false]);
        assert!(found.choice.starts_with("Choose one"), "{}", found.choice);
    }

    #[test]
    fn the_choice_follows_from_the_numbers() {
        let points = |third: f64| {
            vec![
                point("full", 0.0, 1.0),
                point("half", 0.2, 0.5),
                point("rough", 1.0, third),
                point("bad", 2.0, 0.9),
            ]
        };
        let says = |limit: f64, third: f64| comparison(limit, points(third)).choice;
        let found = says(0.3, 0.25);
        assert!(found.starts_with("Choose half, within a hundredth of the fewest steps of all"));
        assert!(found.contains("in 0.5 million steps, 50 % of that of full (0)"));
        assert!(found.ends_with("; rough would take 50 % of it, with 1."));
        let found = says(1.0, 0.1);
        assert!(found.starts_with("Choose rough") && found.ends_with("fewer by more than that."));
        assert!(says(0.0, 0.1).starts_with("Choose full"));
        // More steps than what is truer: never chosen, whatever the limit.
        assert!(says(9.0, 0.6).starts_with("Choose half"));
        let none = comparison(-1.0, points(0.1)).choice;
        assert!(
            none.contains("choose full, the nearest, with 0 in 1 million steps"),
            "{none}"
        );
        // What may be as near, and costs less.
        let mut unsure = points(0.1);
        for (number, doubt) in [(0, 0.0), (1, 0.25), (2, 0.9)] {
            let middle = unsure[number].error();
            unsure[number].of_details = vec![middle - 0.5 * doubt, middle + 0.5 * doubt];
        }
        let found = comparison(-1.0, unsure.clone()).choice;
        assert!(
            found.ends_with(
                "choose half, with 0.2 ± 0.25 as near as can be told, in 0.5 million steps, 50 % of \
                 that of the nearest, full (0)."
            ),
            "{found}"
        );
    }

    #[test]
    fn another_limit_has_its_own_verdict() {
        let points = vec![
            point("full", 0.0, 1.0),
            point("half", 0.2, 0.5),
            point("rough", 1.0, 0.1),
        ];
        let found = |limit: f64| {
            let mut found = comparison(0.3, points.clone());
            let first = found.choice.clone();
            let because = "another bound";
            let limit = Limit {
                error: limit,
                because,
            };
            found.choose_within_too(limit.clone());
            assert_eq!(found.other_limit.unwrap().error, limit.error);
            found.choice.strip_prefix(&first).unwrap().to_owned()
        };
        assert_eq!(
            found(1.0),
            " With at most 1 (another bound) of error: rough, 1, 10 % of the steps of full (0)."
        );
        assert_eq!(
            found(0.0),
            " With at most 0 (another bound) of error: full, 0, 100 % of the steps of full (0)."
        );
        assert_eq!(
            found(-1.0),
            " No setting has at most -1 (another bound) of error."
        );
    }

    #[test]
    fn what_is_cheaper_is_named_by_what_can_be_told() {
        let with = |rough: [f64; 2]| {
            let mut points = vec![
                point("full", 0.0, 1.0),
                point("half", 0.2, 0.5),
                point("rough", 1.0, 0.1),
            ];
            points[1].of_details = vec![0.2, 0.2];
            points[2].of_details = rough.to_vec();
            comparison(0.1, points).choice
        };
        let found = with([0.1, 1.9]);
        assert!(
            found.ends_with(
                "; rough would take 10 % of it, with 1 ± 1.8 as near as can be told as half (0.2)."
            ),
            "{found}"
        );
        // Worse by the same in each detail is worse beyond doubt.
        let found = with([1.0, 1.0]);
        assert!(
            found.ends_with("; half would take 50 % of it, with 0.2."),
            "{found}"
        );
    }

    #[test]
    fn where_steps_are_counted_times_choose_nothing() {
        let mut points = vec![point("more", 0.0, 0.2), point("fewer", 0.1, 0.9)];
        (points[0].steps, points[1].steps) = (Some(1_000), Some(980));
        let found = comparison(0.5, points).choice;
        assert!(found.starts_with("Choose fewer"), "{found}");
        // A hundredth is no difference.
        let mut points = vec![point("more", 0.0, 0.2), point("fewer", 0.1, 0.9)];
        (points[0].steps, points[1].steps) = (Some(1_000), Some(991));
        let found = comparison(0.5, points).choice;
        assert!(found.starts_with("Choose more"), "{found}");
        let mut points = vec![point("near", 0.1, 0.9), point("far", 0.2, 0.1)];
        (points[0].steps, points[1].steps) = (Some(7), Some(7));
        let found = comparison(0.5, points).choice;
        assert!(found.starts_with("Choose near"), "{found}");
        assert!(found.ends_with("fewer by more than that."), "{found}");
    }

    #[test]
    fn without_steps_times_choose_beyond_their_spread() {
        let says_of = |spread: f64, times_count: bool| {
            let mut points = vec![
                point("true", 0.0, 1.00),
                point("near", 0.1, 0.52),
                point("far", 0.2, 0.50),
                point("out", 3.0, 0.49),
            ];
            for point in &mut points {
                (point.steps, point.spread) = (None, spread);
            }
            let limit = Limit {
                error: 0.5,
                because: "a bound",
            };
            choice(&points, "error", &limit, times_count)
        };
        let says = |spread: f64| says_of(spread, true);
        let found = says(0.001);
        assert!(
            found.starts_with("Choose far, the fastest of all"),
            "{found}"
        );
        assert!(
            found.ends_with("; out would take 98 % of it, with 3."),
            "{found}"
        );
        // By chance before it.
        let found = says(0.05);
        assert!(found.starts_with("Choose near, the fastest"), "{found}");
        assert!(
            found.ends_with("faster beyond the spread of times."),
            "{found}"
        );
        // Nothing can be told apart.
        assert!(says(0.6).starts_with("Choose true"));
        // A build whose times are not those of one in use chooses nothing by them.
        let found = says_of(0.001, false);
        assert!(
            found.starts_with("true (0), near (0.1), far (0.2) have at most 0.5")
                && found.ends_with(UNDECIDED),
            "{found}"
        );
    }
}
