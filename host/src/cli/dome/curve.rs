//! `shisen dome curve`: the paper's figures 10 to 16.

use super::figure::{Figure, chart, logarithmic};
use crate::cli::prelude::*;
use crate::dome::{self, Design, Mapping, MirrorError, Named, Projection};
use crate::picture::chart::{Axis, Chart, Corner, Line};
use rayon::prelude::*;
use std::f64::consts::FRAC_PI_2;
use std::ops::Range;

/// Draws how the error depends on the mirror's shape: the paper's figures 10 to 16
#[derive(Debug, Args)]
pub(in crate::cli) struct Arguments {
    /// Mirror to mark
    #[arg(long, value_name = "NAME", value_enum)]
    config: Option<Named>,
    /// How pixels become directions. Only mirror has errors
    #[arg(long, value_enum, default_value = "mirror")]
    mapping: Mapping,
    /// Axis ratios in each figure
    #[arg(long, value_name = "N", default_value_t = 300, value_parser = whole::<u32>(2..=10_000))]
    points: u32,
    /// Folder of the figures; made if it does not exist
    #[arg(long, value_name = "DIR", default_value = "shisen-out")]
    out: PathBuf,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

/// The figures that were drawn.
#[derive(Debug, Serialize, JsonSchema)]
pub(in crate::cli) struct Report {
    /// Figures. Errors are in percent of the picture's radius, viewpoints in equatorial radii from
    /// the mirror's centre, places in degrees from the zenith.
    figures: Vec<Figure>,
    #[serde(skip)]
    folder: String,
}

struct Shape {
    a: f64,
    best: Design,
    /// The local minimum that is not the least.
    other: Option<Design>,
}

const WHOLE: Range<f64> = 0.5..6.0;
const SMALL_ERRORS: Range<f64> = 1.25..6.0;
const FAR_VIEWPOINTS: Range<f64> = 1.2..1.4;
const PARALLEL: Range<f64> = 0.5..2.1;
const PARALLEL_BEST: Range<f64> = 1.28..1.3;

pub(super) fn run(arguments: &Arguments) -> Result<(), Failure> {
    make_writable(&arguments.out)?;
    let mapping = arguments.mapping;
    let charts = charts(arguments.points, mapping)?;
    let mut figures = Vec::new();
    for (number, mut chart) in (10..).zip(charts) {
        if let Some(named) = arguments.config {
            let design = Design::of(named.mirror()).mapped(mapping);
            mark(&mut chart, number, named.name(), &design);
        }
        let name = format!("figure-{number}");
        figures.push(Figure::write(&arguments.out, &name, chart)?);
    }
    let folder = arguments.out.display().to_string();
    print(&Report { figures, folder }, arguments.json)
}

/// Returns the charts of figures 10 to 16, with `count` axis ratios each.
fn charts(count: u32, mapping: Mapping) -> Result<[Chart; 7], Failure> {
    let whole = perspective(&WHOLE, count, mapping)?;
    let small = perspective(&SMALL_ERRORS, count, mapping)?;
    let far = perspective(&FAR_VIEWPOINTS, count, mapping)?;
    let error = |range| Axis::linear("error_percent", "largest error, % of the radius", range);
    let enlarged = |range: Range<f64>| match mapping {
        Mapping::Mirror => error(range),
        Mapping::Exact | Mapping::True => error(0.0..range.end),
    };
    let best = |title, shapes, ratios, y: Axis| {
        let is_error = y.name == "error_percent";
        let value = |design: &Design| {
            let error = is_error.then_some(design.error_percent);
            error.or(design.p)
        };
        let (axes, lines) = ([of_ratio(&ratios), y], both(shapes, value));
        chart(title, axes, lines, Corner::UpperRight)
    };
    let parallel = |title, range: Range<f64>, y| -> Result<Chart, Failure> {
        let point = |a| {
            let design = dome::optimum(a, Projection::Parallel)?.mapped(mapping);
            Ok::<_, MirrorError>((a, Some(design.error_percent)))
        };
        let points = ratios(&range, count).into_iter().map(point);
        let points = points.collect::<Result<Vec<_>, _>>().or_fail()?;
        let line = Line::new("parallel projection", 0, points);
        let axes = [of_ratio(&range), y];
        Ok(chart(title, axes, vec![line], Corner::LowerLeft))
    };
    let viewpoint = |range| Axis::linear("p", "viewpoint from the centre, p", range);
    let far_axis = logarithmic(viewpoint(1.0..1.0e4));
    let [errors, more] = ["Error by perspective", "Error by perspective, enlarged"];
    let viewpoints = "Viewpoint by perspective";
    let farther = "Viewpoint by perspective, enlarged";
    let title = "Error in parallel projection".to_owned();
    let enlarged_title = format!("{title}, enlarged");
    Ok([
        best(errors, &whole, WHOLE, error(0.0..2.0)),
        best(more, &small, SMALL_ERRORS, enlarged(0.1..0.14)),
        best(viewpoints, &whole, WHOLE, viewpoint(0.0..12.0)),
        best(farther, &far, FAR_VIEWPOINTS, far_axis),
        places(&whole),
        parallel(title, PARALLEL, error(0.0..22.0))?,
        parallel(enlarged_title, PARALLEL_BEST, enlarged(0.1..0.22))?,
    ])
}

fn mark(chart: &mut Chart, number: u32, name: &str, design: &Design) {
    let place = match (number, design.p) {
        (10 | 11, Some(_)) | (15 | 16, None) => design.error_percent,
        (12 | 13, Some(p)) => p,
        _ => return,
    };
    let marked = [(design.a, Some(place))];
    chart.lines.push(Line::new(name, 2, marked));
}

/// Axis ratios of a range, in equal steps of their logarithm.
fn ratios(range: &Range<f64>, count: u32) -> Vec<f64> {
    let step = |i: u32| f64::from(i) / f64::from(count - 1);
    let ratio = |i| match i {
        0 => range.start,
        i if i + 1 == count => range.end,
        i => range.start * libm::pow(range.end / range.start, step(i)),
    };
    (0..count).map(ratio).collect()
}

fn perspective(range: &Range<f64>, count: u32, mapping: Mapping) -> Result<Vec<Shape>, Failure> {
    let shape = |&a: &f64| -> Result<Shape, MirrorError> {
        let best = dome::optimum(a, Projection::Perspective)?;
        let mut local = dome::local_optima(a)?;
        local.retain(|local| local.error_percent > best.error_percent);
        Ok(Shape {
            a,
            best: best.mapped(mapping),
            other: local.pop().map(|other| other.mapped(mapping)),
        })
    };
    let shapes: Result<_, _> = ratios(range, count).par_iter().map(shape).collect();
    shapes.or_fail()
}

fn of_ratio(range: &Range<f64>) -> Axis {
    Axis::linear("a", "polar by equatorial radius, a", range.clone())
}

/// Returns the lines of the best viewpoint and of the other local minimum.
fn both(shapes: &[Shape], value: impl Fn(&Design) -> Option<f64>) -> Vec<Line> {
    let other = |shape: &Shape| (shape.a, shape.other.as_ref().and_then(&value));
    let other = Line::new("the other local minimum", 1, shapes.iter().map(other));
    let best = |shape: &Shape| (shape.a, value(&shape.best));
    let best = Line::new("best viewpoint", 0, shapes.iter().map(best));
    let faint = true;
    vec![Line { faint, ..other }, best]
}

/// Returns where the error is largest, to a thousandth: at one place or two.
fn places(shapes: &[Shape]) -> Chart {
    let places = |name, colour, wanted: &dyn Fn(f64) -> bool| {
        let point = |Shape { a, best, .. }: &Shape| {
            let largest = best.error_percent / 100.0 * FRAC_PI_2;
            let extrema = best.extrema.iter();
            let extrema = extrema.filter(|extremum| extremum.error.abs() >= 0.999 * largest);
            let mut places = extrema.map(|extremum| extremum.r_d.to_degrees());
            (*a, places.find(|&degrees| wanted(degrees)))
        };
        Line::new(name, colour, shapes.iter().map(point))
    };
    let lines = vec![
        places("towards the zenith", 0, &|degrees| degrees < 50.0),
        places("towards the rim", 1, &|degrees| degrees >= 50.0),
    ];
    let place = Axis::linear("r_d_deg", "from the zenith, degrees", 0.0..90.0);
    let title = "Place of the largest error by perspective";
    chart(title, [of_ratio(&WHOLE), place], lines, Corner::LowerRight)
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for figure in &self.figures {
            writeln!(f, "{}: {}", figure.name, figure.title)?;
        }
        write!(f, "as .svg and .csv in {}", self.folder)
    }
}
