//! How far ahead the gaze is predicted, how far off the prediction is, and how much wider a
//! field has to be.

mod viewers;

use super::frames::{Follow, Lod, Room, Way, baked};
use super::{Bench, Cause, Comparison, Limit, Measure, Point, Section, limit, measure};
use rayon::iter::{IntoParallelRefIterator, ParallelIterator};
use shisen::bake::Baked;
use shisen::picture::chart::{Axis, Chart, Line, Names};
use shisen::render;
use shisen_core::gaze::VisualField;
use viewers::{FRAME, GazeError, RATE, gaze};

/// Milliseconds from a sample to the light that follows it, and the comparison's id and title.
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
        comparisons.push(horizons(bench, &room, &scene, latency, seconds, share)?);
    }
    let about = format!(
        "A simulated viewer (fixations, saccades, pursuit, blinks) before a simulated tracker of \
         {RATE} samples a second with 0.1° of noise, three of {seconds} s each, the same on every \
         run. Errors are angles between the estimate for the time of display and the viewer's line \
         of sight then, while data are fresh and eyes open. The widening: a frame is shown for \
         {:.0} ms, in which the eye moves on, and its field of full detail has to hold that of the \
         true gaze all the time. It has to be so much wider for 95 % (99 %) of the frames. Time and \
         steps are those of the first section's frame ({size}² pixels a wall) with a field as wide. \
         Beside them stands the share of the frames of two other viewers for which the widening for \
         95 % is enough.",
        1e3 * f64::from(FRAME) / f64::from(RATE),
    );
    let title = "Latency and prediction";
    Ok(Section::new("latency", title, about, comparisons))
}

fn horizons(
    bench: &Bench<'_>,
    room: &Room,
    scene: &Baked,
    &(latency, id, title): &(u32, &'static str, &'static str),
    seconds: u64,
    (from, to): (f64, f64),
) -> Result<Comparison, Cause> {
    let horizons: &[u32] = bench.effort.pick(
        &[0, 10, 20, 60, 200],
        &[0, 5, 10, 20, 40, 60, 80, 100, 150, 200],
    );
    // In parallel: none of these is timed.
    let each = horizons.par_iter().map(|&horizon| {
        let gaze = gaze(latency, horizon, seconds)?;
        Ok((horizon, gaze))
    });
    let gazes = render::pool(bench.threads)?.install(|| each.collect::<Result<Vec<_>, Cause>>())?;
    let middle = 0.5 * (from + to);
    (bench.progress)(middle);
    let measured = bench.in_turns(&gazes, (middle, to), |(_, gaze)| {
        let frame = room.frame(scene, &widened(gaze.widening(0.95)))?;
        Ok((frame.seconds, frame.statistics.steps))
    })?;
    let mut points = Vec::new();
    for ((horizon, gaze), time) in gazes.iter().zip(measured) {
        let surer = room.frame(scene, &widened(gaze.widening(0.99)))?;
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
        let point = Point::new("horizon", name, settings);
        points.push(point.measured(errors, &time, Some(time.first)));
    }
    let about = format!(
        "Up to the horizon pursuit is continued at its velocity, and a saccade along its course; \
         light is {latency} ms later than its sample. A better estimate needs a narrower field, \
         which takes less time."
    );
    let mut comparison = Comparison::new((id, title), about, MEASURES.to_vec(), LIMIT, points);
    let horizons = |name: &str, colour, place: usize| {
        let point =
            |(horizon, gaze): &(u32, GazeError)| (f64::from(*horizon), gaze.errors()[place]);
        Line::new(name, colour, gazes.iter().map(point))
    };
    comparison.charts = vec![
        chart(
            format!("Error by horizon, {latency} ms late"),
            ("error_95_degrees", "95 % are nearer, °"),
            vec![
                horizons("all", 6, 0),
                horizons("fixation", 0, 3),
                horizons("pursuit", 1, 4),
                horizons("saccade", 2, 5),
                horizons("landing", 3, 6),
            ],
        ),
        chart(
            format!("Field by horizon, {latency} ms late"),
            ("degrees", "degrees"),
            vec![
                horizons("error, 95 % of moments", 0, 0),
                horizons("widening, 95 % of frames", 1, 7),
                horizons("widening, 99 % of frames", 2, 8),
            ],
        ),
    ];
    Ok(comparison)
}

/// Returns a frame whose field of full detail is wider by these degrees.
fn widened(degrees: f64) -> Way<'static> {
    let field = VisualField::PAPER.wider(degrees.to_radians() as f32);
    let lod = field.map(|field| {
        Follow::Levels(Lod {
            field,
            ..Lod::PAPER
        })
    });
    Way { lod, ..Way::FULL }
}

const LIMIT: Limit = limit(1.0, "the fovea's radius");

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

fn chart(title: String, y: (&'static str, &'static str), lines: Vec<Line>) -> Chart {
    let ends = |number: fn(&(f64, Option<f64>)) -> Option<f64>| {
        let points = lines.iter().flat_map(|line| &line.points);
        points.filter_map(number).fold(0.1, f64::max)
    };
    let (farthest, most) = (ends(|point| Some(point.0)), ends(|point| point.1));
    Chart {
        title,
        x: Axis::linear("horizon_ms", "horizon, ms", 0.0..farthest),
        y: Axis::linear(y.0, y.1, 0.0..1.1 * most),
        lines,
        names: Names::Below,
        notes: Vec::new(),
    }
}
