//! How far ahead the gaze is predicted, how far off that is, and how much wider a
//! field has to be for it.

mod viewers;

use super::frames::{Lod, Room, Way, baked};
use super::page::brief;
use super::{Bench, Cause, Comparison, Limit, Measure, Point, Section, Topic, measure};
use rayon::iter::{IntoParallelRefIterator, ParallelIterator};
use shisen::bake::Baked;
use shisen::picture::chart::{Axis, Chart, Line, Names};
use shisen::render;
use shisen_core::gaze::VisualField;
use std::cmp::Ordering;
use std::fmt::Write as _;
use viewers::{FRAME, GazeError, RATE, gaze};

/// From a sample to the light that follows it: milliseconds, and what the
/// comparison is called.
const LATENCIES: [(u32, &str, &str); 4] = [
    (20, "latency-20ms", "How far ahead to predict, 20 ms late"),
    (50, "latency-50ms", "How far ahead to predict, 50 ms late"),
    (10, "latency-10ms", "How far ahead to predict, 10 ms late"),
    (
        100,
        "latency-100ms",
        "How far ahead to predict, 100 ms late",
    ),
];

pub(super) fn section(bench: &Bench<'_>) -> Result<Section, Cause> {
    let size = bench.effort.pick(128, 256);
    let seconds = bench.effort.pick(20, 60);
    let latencies = bench.effort.pick(&LATENCIES[..2], &LATENCIES[..]);
    let room = Room::new(bench, size)?;
    let scene = baked(bench)?;
    let mut comparisons = Vec::new();
    for (number, latency) in latencies.iter().enumerate() {
        let part = |share: f64| (number as f64 + share) / latencies.len() as f64;
        let share = (part(0.0), part(1.0));
        comparisons.push(horizons(bench, (&room, &scene), latency, seconds, share)?);
    }
    let about = format!(
        "A simulated viewer (fixations, saccades, pursuit, blinks) before a simulated tracker of \
         {RATE} samples a second with 0.1° of noise, three of {seconds} s each, the same on every \
         run. Errors are angles between the estimate for the time of display and the viewer's \
         line of sight then, while data are fresh and eyes open. The widening is something else: \
         a frame stands for {:.0} ms, in which the eye moves on, and its field of full detail \
         has to hold that of the true gaze all the time. So much wider it is in 95 % (99 %) of \
         frames, and so much wider that of the first section's frame ({size}² pixels a wall) is \
         made: time and steps are that frame's. Beside it stands how many frames of two other \
         viewers the widening for 95 % holds.",
        1e3 * f64::from(FRAME) / f64::from(RATE),
    );
    let title = "Latency and prediction";
    Ok(Section::new(Topic::Latency, title, about, comparisons))
}

/// How far ahead to predict at one latency.
fn horizons(
    bench: &Bench<'_>,
    (room, scene): (&Room, &Baked),
    &(latency, id, title): &(u32, &'static str, &'static str),
    seconds: u64,
    (from, to): (f64, f64),
) -> Result<Comparison, Cause> {
    let horizons: &[u32] = bench.effort.pick(
        &[0, 10, 20, 60, 200],
        &[0, 5, 10, 20, 40, 60, 80, 100, 150, 200],
    );
    // Beside one another: none of these is timed.
    let each = horizons.par_iter().map(|&horizon| {
        let gaze = gaze(latency, horizon, seconds)?;
        Ok((horizon, gaze))
    });
    let asked = render::pool(bench.threads)?.install(|| each.collect::<Result<Vec<_>, Cause>>())?;
    let middle = 0.5 * (from + to);
    (bench.progress)(middle);
    let measured = bench.in_turns(&asked, (middle, to), |(_, gaze)| {
        let frame = room.frame(scene, &widened(gaze.widening(0.95)))?;
        Ok((frame.seconds, frame.statistics.steps))
    })?;
    let mut points = Vec::new();
    for ((horizon, gaze), (time, steps)) in asked.iter().zip(measured) {
        let surer = room.frame(scene, &widened(gaze.widening(0.99)))?;
        points.push({
            let name = match horizon {
                0 => "no prediction".to_owned(),
                _ => format!("up to {horizon} ms"),
            };
            let settings = [
                ("latency_ms", latency.into()),
                ("horizon_ms", (*horizon).into()),
                ("rate_hz", RATE.into()),
            ];
            let mut errors = gaze.errors();
            errors.push(Some(1e-6 * surer.statistics.steps as f64));
            Point {
                errors,
                seconds: time.median,
                spread: time.spread,
                steps: Some(steps),
                ..Point::new("horizon", name, settings)
            }
        });
    }
    let limit = Limit {
        error: LIMIT,
        because: "the fovea's radius",
    };
    let mut comparison = Comparison::new(
        (id, title),
        format!(
            "Up to the horizon pursuit is continued at its velocity, and a saccade along its \
             course; what is shown is {latency} ms later than the sample. A nearer gaze needs a \
             narrower field, which takes less time."
        ),
        MEASURES.to_vec(),
        limit,
        points,
    );
    comparison.choice = choice(&comparison.points);
    comparison.charts.push(by_horizon(latency, &asked));
    comparison.charts.push(widenings(latency, &asked));
    Ok(comparison)
}

/// The frame with a field of full detail that is so many degrees wider.
fn widened(degrees: f64) -> Way<'static> {
    let field = VisualField::PAPER.wider(degrees.to_radians() as f32);
    let lod = field.map(|field| Lod {
        field,
        ..Lod::PAPER
    });
    Way { lod, ..Way::FULL }
}

/// Places among [`MEASURES`].
const ERROR: usize = 0;
const MEDIAN: usize = 1;
const WIDENING: usize = 7;
const SURER: usize = 8;
const SURER_STEPS: usize = 11;

/// So far off at most in 95 % of moments a gaze may be: degrees.
const LIMIT: f64 = 1.0;

/// The horizon whose frames take the fewest steps for a field that holds that of the
/// true gaze; of those that take the same, within a hundredth, the nearest gaze, in 95 %
/// of moments and then in half of them; of those that are equally near in three digits
/// the shortest horizon, which has the least to go wrong.
fn choice(points: &[Point]) -> String {
    let number = |point: &Point, place: usize| point.errors[place].unwrap_or(f64::INFINITY);
    let steps = |point: &Point| point.steps.unwrap_or(u64::MAX);
    let horizon = |point: &Point| point.settings["horizon_ms"].as_u64();
    let measured = || points.iter().filter(|one| one.errors[ERROR].is_some());
    let Some(fewest) = measured().map(steps).min() else {
        return "Nothing was measured.".to_owned();
    };
    let cheap = measured().filter(|one| steps(one) as f64 <= 1.01 * fewest as f64);
    let Some(chosen) = cheap.clone().min_by(|a, b| {
        let by = |place: usize| {
            let [a, b] = [a, b].map(|one| number(one, place));
            let same = brief(a) == brief(b);
            if same {
                Ordering::Equal
            } else {
                a.total_cmp(&b)
            }
        };
        by(ERROR).then(by(MEDIAN)).then(horizon(a).cmp(&horizon(b)))
    }) else {
        return "Nothing was measured.".to_owned();
    };
    let of = |point: &Point| {
        format!(
            "a field {}° wider holds that of the true gaze in 95 % of frames ({} million steps; \
             {}° and {} for 99 %), and the gaze is off by {}° or less in 95 % of moments, by {}° in half of them",
            brief(number(point, WIDENING)),
            brief(1e-6 * steps(point) as f64),
            brief(number(point, SURER)),
            brief(number(point, SURER_STEPS)),
            brief(number(point, ERROR)),
            brief(number(point, MEDIAN)),
        )
    };
    let begin = if measured().all(|one| number(one, ERROR) > LIMIT) {
        format!("No setting has at most {LIMIT}° in 95 % of moments: choose")
    } else {
        "Choose".to_owned()
    };
    let mut text = format!("{begin} {}: {}", chosen.name, of(chosen));
    let as_near = |one: &&Point| brief(number(one, ERROR)) == brief(number(chosen, ERROR));
    let same: Vec<&str> = cheap
        .filter(|one| one.name != chosen.name && as_near(one))
        .map(|one| one.name.as_str())
        .collect();
    if !same.is_empty() {
        // Writing to a string does not fail.
        let _ = write!(
            text,
            " ({} are as near in 95 %, to three digits)",
            same.join(", ")
        );
    }
    let without = points.iter().find(|one| horizon(one) == Some(0));
    if let Some(without) = without.filter(|one| one.name != chosen.name) {
        // Writing to a string does not fail.
        let _ = write!(text, "; with {}, {}", without.name, of(without));
    }
    text + "."
}

const MEASURES: [Measure; 12] = [
    measure("error_95_degrees", "error that 95 % keep to, °"),
    measure("median_degrees", "median, °"),
    measure("99_degrees", "99 %, °"),
    measure("fixation_95_degrees", "fixation, 95 %, °"),
    measure("pursuit_95_degrees", "pursuit, 95 %, °"),
    measure("saccade_95_degrees", "saccade, 95 %, °"),
    measure("landing_95_degrees", "landing, 95 %, °"),
    measure("widening_95_degrees", "wider for 95 % of frames, °"),
    measure("widening_99_degrees", "for 99 %, °"),
    measure("held_95_percent", "others' frames held, %"),
    measure("estimate_us", "estimate, µs"),
    measure("steps_99_millions", "10⁶ steps for 99 %"),
];

/// What the eyes do, and how far off the gaze is then.
fn by_horizon(latency: u32, asked: &[(u32, GazeError)]) -> Chart {
    let names = ["fixation", "pursuit", "saccade", "landing"];
    let mut lines = vec![Line {
        name: "all".to_owned(),
        points: asked
            .iter()
            .map(|(horizon, gaze)| (f64::from(*horizon), gaze.errors()[ERROR]))
            .collect(),
        colour: 6,
        faint: false,
        dots: false,
    }];
    for (class, name) in names.into_iter().enumerate() {
        let point =
            |(horizon, gaze): &(u32, GazeError)| (f64::from(*horizon), gaze.errors()[3 + class]);
        lines.push(Line {
            name: name.to_owned(),
            points: asked.iter().map(point).collect(),
            colour: class,
            faint: false,
            dots: false,
        });
    }
    chart(
        format!("Error by horizon, {latency} ms late"),
        ("error_95_degrees", "95 % are nearer, °"),
        lines,
    )
}

/// By how much a field has to be wider, beside how far off the gaze is.
fn widenings(latency: u32, asked: &[(u32, GazeError)]) -> Chart {
    let line = |(colour, (name, place)): (usize, (&str, usize))| Line {
        name: name.to_owned(),
        points: asked
            .iter()
            .map(|(horizon, gaze)| (f64::from(*horizon), gaze.errors()[place]))
            .collect(),
        colour,
        faint: false,
        dots: false,
    };
    let names = [
        ("error, 95 % of moments", ERROR),
        ("widening, 95 % of frames", WIDENING),
        ("widening, 99 % of frames", SURER),
    ];
    chart(
        format!("Field by horizon, {latency} ms late"),
        ("degrees", "degrees"),
        names.into_iter().enumerate().map(line).collect(),
    )
}

fn chart(title: String, (name, label): (&'static str, &'static str), lines: Vec<Line>) -> Chart {
    let ends = |of: fn(&(f64, Option<f64>)) -> Option<f64>| {
        let numbers = lines.iter().flat_map(|line| &line.points);
        numbers.filter_map(of).fold(0.1, f64::max)
    };
    let (farthest, most) = (ends(|point| Some(point.0)), ends(|point| point.1));
    Chart {
        title,
        x: Axis {
            name: "horizon_ms",
            label: "horizon, ms",
            range: 0.0..farthest,
            logarithmic: false,
        },
        y: Axis {
            name,
            label,
            range: 0.0..1.1 * most,
            logarithmic: false,
        },
        lines,
        names: Names::Below,
        notes: Vec::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_choice_follows_from_the_numbers_and_not_from_their_order() {
        let point = |name: &str, horizon: u32, error: f64, steps: u64| {
            let mut point = Point::new("horizon", name, [("horizon_ms", horizon.into())]);
            point.errors = vec![Some(error); MEASURES.len()];
            point.steps = Some(steps);
            point
        };
        let mut points = vec![
            point("no prediction", 0, 2.0, 1_100),
            point("up to 200 ms", 200, 1.0, 1_001),
            point("up to 60 ms", 60, 1.0, 1_000),
            point("up to 10 ms", 10, 1.5, 1_005),
        ];
        for _ in 0..2 {
            let found = choice(&points);
            assert!(found.starts_with("Choose up to 60 ms: "), "{found}");
            assert!(
                found.contains(
                    "(up to 200 ms are as near in 95 %, to three digits); with no prediction,"
                ),
                "{found}"
            );
            points.reverse();
        }
        // A difference that is not seen is none.
        for point in &mut points {
            let short = point.settings["horizon_ms"] == 60;
            point.errors[MEDIAN] = Some(if short { 0.083_81 } else { 0.083_79 });
        }
        let found = choice(&points);
        assert!(found.starts_with("Choose up to 60 ms: "), "{found}");
        // What is too far off is said to be.
        let mut far = points.clone();
        for one in &mut far {
            one.errors[ERROR] = Some(1.01);
        }
        let found = choice(&far);
        assert!(
            found.starts_with("No setting has at most 1° in 95 % of moments: choose up to "),
            "{found}"
        );
        // Without an error nothing is chosen.
        for point in &mut points {
            point.errors[ERROR] = None;
        }
        assert_eq!(choice(&points), "Nothing was measured.");
    }
}
