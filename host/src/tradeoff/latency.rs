//! How far ahead the gaze is predicted, how far off that is, and how much wider a
//! field has to be for it.

use super::frames::{Lod, Room, Way, baked};
use super::{Bench, Cause, Comparison, Limit, Measure, Point, Section, Topic, measure, timed};
use crate::bake::Baked;
use crate::chart::{Axis, Chart, Corner, Line};
use crate::quantiles::quantile_of;
use shisen_core::gaze::VisualField;
use shisen_tracker::estimate::{EstimatorConfig, GazeEstimator, GazePrediction, State};
use shisen_tracker::mock::{Kind, Tracker, TrackerConfig, Viewer, ViewerConfig};
use shisen_tracker::time::Micros;

/// Samples a second.
const RATE: u32 = 500;

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
         line of sight then, while data are fresh and eyes open. By the one that 95 % of the \
         moments keep to, the field of the first section's frame ({size}² pixels a wall) is made \
         wider: time and steps are that frame's."
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
    let mut asked = Vec::new();
    for (number, &horizon) in horizons.iter().enumerate() {
        asked.push((horizon, gaze(latency, horizon, seconds)?));
        let done = (number + 1) as f64 / horizons.len() as f64;
        (bench.progress)(from + 0.5 * (to - from) * done);
    }
    let middle = 0.5 * (from + to);
    let measured = bench.in_turns(&asked, (middle, to), |(_, gaze)| {
        let field = VisualField::PAPER.wider(gaze.widening().to_radians() as f32);
        let lod = field.map(|field| Lod {
            field,
            ..Lod::PAPER
        });
        let frame = room.frame(scene, &Way { lod, ..Way::FULL })?;
        Ok((frame.seconds, frame.statistics.steps))
    })?;
    let points = asked
        .iter()
        .zip(measured)
        .map(|((horizon, gaze), (time, steps))| {
            let name = match horizon {
                0 => "no prediction".to_owned(),
                _ => format!("up to {horizon} ms"),
            };
            let settings = [
                ("latency_ms", latency.into()),
                ("horizon_ms", (*horizon).into()),
                ("rate_hz", RATE.into()),
            ];
            Point {
                errors: gaze.errors(),
                seconds: time.median,
                spread: time.spread,
                steps: Some(steps),
                ..Point::new("horizon", name, settings)
            }
        });
    let limit = Limit {
        error: 1.0,
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
        points.collect(),
    );
    comparison.charts.push(by_horizon(latency, &asked));
    Ok(comparison)
}

const MEASURES: [Measure; 8] = [
    measure("widening_degrees", "error that 95 % keep to, °"),
    measure("median_degrees", "median, °"),
    measure("99_degrees", "99 %, °"),
    measure("fixation_95_degrees", "fixation, 95 %, °"),
    measure("pursuit_95_degrees", "pursuit, 95 %, °"),
    measure("saccade_95_degrees", "saccade, 95 %, °"),
    measure("landing_95_degrees", "landing, 95 %, °"),
    measure("estimate_us", "an estimate, µs"),
];

/// Angles from the truth, degrees.
struct GazeError {
    /// In fixation, in pursuit, on the way of a saccade, and in the time of the
    /// latency after its landing.
    classes: [Vec<f64>; 4],
    /// For a sample and its estimate.
    seconds: f64,
}

impl GazeError {
    fn all(&self, part: f64) -> f64 {
        quantile_of(self.classes.concat(), part)
    }

    /// By how much a field has to be wider.
    fn widening(&self) -> f64 {
        self.all(0.95)
    }

    /// By [`MEASURES`].
    fn errors(&self) -> Vec<Option<f64>> {
        let of_class = |class: &Vec<f64>| {
            let any = !class.is_empty();
            any.then(|| quantile_of(class.clone(), 0.95))
        };
        let mut errors = vec![
            Some(self.widening()),
            Some(self.all(0.5)),
            Some(self.all(0.99)),
        ];
        errors.extend(self.classes.iter().map(of_class));
        errors.push(Some(1e6 * self.seconds));
        errors
    }
}

/// The estimator with this horizon, milliseconds, 0 for no prediction, on three
/// viewers.
fn gaze(latency: u32, horizon: u32, seconds: u64) -> Result<GazeError, Cause> {
    let late = Micros::from_millis(latency.into());
    let prediction = GazePrediction {
        horizon: Micros::from_millis(horizon.into()),
        ..GazePrediction::default()
    };
    let config = EstimatorConfig {
        prediction: (horizon > 0).then_some(prediction),
        ..EstimatorConfig::default()
    };
    let mut classes: [Vec<f64>; 4] = Default::default();
    let (mut time_taken, mut samples) = (0.0, 0u32);
    for seed in 1..=3 {
        let tracker = TrackerConfig {
            rate: RATE,
            latency: Micros(0),
            ..TrackerConfig::default()
        };
        let viewer = Viewer::new(ViewerConfig::default(), seed);
        let mut tracker = Tracker::new(tracker, viewer, seed)?;
        let mut estimator = GazeEstimator::new(config)?;
        let mut landed = Micros(0);
        while tracker.next_time() < Micros::from_millis(1_000 * seconds) {
            let (time, sample) = tracker.next_sample();
            let shown = time.after(late);
            let (taken, estimate) = timed(|| {
                estimator.push(&sample, time, &mut |_| {});
                estimator.estimate(shown, &mut |_| {})
            });
            time_taken += taken;
            samples += 1;
            let Some(truth) = tracker.viewer().truth(shown) else {
                continue;
            };
            if truth.kind == Kind::Saccade {
                landed = truth.end;
            }
            // The first second is for the filters.
            if estimate.state != State::Fresh || truth.openness < 1.0 || time.0 < 1_000_000 {
                continue;
            }
            let class = match truth.kind {
                Kind::Saccade => 2,
                _ if shown.since(landed) < late => 3,
                Kind::Pursuit => 1,
                Kind::Fixation | Kind::Microsaccade => 0,
            };
            let (found, truth) = (estimate.line_of_sight.forward(), truth.direction);
            let (found, truth) = (found.as_dvec3(), truth.as_dvec3());
            let off = libm::atan2(found.cross(truth).length(), found.dot(truth));
            classes[class].push(off.to_degrees());
        }
    }
    Ok(GazeError {
        classes,
        seconds: time_taken / f64::from(samples.max(1)),
    })
}

/// What the eyes do, and how far off the gaze is then.
fn by_horizon(latency: u32, asked: &[(u32, GazeError)]) -> Chart {
    let names = ["fixation", "pursuit", "saccade", "landing"];
    let mut lines = vec![Line {
        name: "all".to_owned(),
        points: asked
            .iter()
            .map(|(horizon, gaze)| (f64::from(*horizon), Some(gaze.widening())))
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
    let numbers = lines.iter().flat_map(|line| &line.points);
    let most = numbers.filter_map(|point| point.1).fold(0.1, f64::max);
    Chart {
        title: format!("Error by horizon, {latency} ms late"),
        x: Axis {
            name: "horizon_ms",
            label: "horizon, ms",
            range: 0.0..asked.iter().map(|one| f64::from(one.0)).fold(1.0, f64::max),
            logarithmic: false,
        },
        y: Axis {
            name: "error_95_degrees",
            label: "95 % are nearer, °",
            range: 0.0..1.25 * most,
            logarithmic: false,
        },
        lines,
        names: Corner::UpperRight,
        notes: Vec::new(),
    }
}
