//! `shisen dome curve`: the paper's figures 10 to 16.

use super::arguments::{ConfigChoice, MappingChoice};
use super::figure::Figure;
use crate::cli::arguments::whole;
use crate::cli::output::failure::Failure;
use crate::cli::output::picture_files::make_writable;
use crate::cli::output::print;
use crate::dome::{self, Design, Mapping, MirrorError, Projection};
use crate::picture::chart::{Axis, Chart, Corner, Line, Names};
use clap::Args;
use rayon::prelude::*;
use serde::Serialize;
use std::fmt;
use std::ops::Range;
use std::path::PathBuf;

/// Draws how the error depends on the mirror's shape: the paper's figures 10
/// to 16
///
/// For each axis ratio, the viewpoint that makes the largest error least. By
/// perspective: the error (figures 10 and 11), the viewpoint (12 and 13) and
/// the place of the largest error (14); the other local minimum, which a local
/// search may take for the least, is drawn faintly. In parallel projection:
/// the error (15 and 16). Axis ratios go on beyond the paper's, to where the
/// error is least. The mirror of --config is a dot in the figures of its
/// projection. Writes figure-10.csv and figure-10.svg to figure-16.
///
/// With --json, one object: figures, each with name, title, x and y (what they
/// are), csv and svg (paths) and lines (name, x and y each; y is null where
/// there is no such number, as the viewpoint in parallel projection). Errors
/// are in percent of the picture's radius, viewpoints in equatorial radii from
/// the mirror's centre, places in degrees from the zenith.
#[derive(Debug, Args)]
pub(in crate::cli) struct Arguments {
    /// A mirror to mark
    #[arg(long, value_name = "NAME", value_enum)]
    config: Option<ConfigChoice>,
    /// How pixels become directions: but by the mirror the errors are 0, and
    /// nowhere largest
    #[arg(long, value_enum, default_value = "mirror")]
    mapping: MappingChoice,
    /// Axis ratios in each figure
    #[arg(long, value_name = "N", default_value_t = 300,
          value_parser = whole::<u32>(2..=10_000))]
    points: u32,
    /// Folder of the figures; made where it does not exist
    #[arg(long, value_name = "DIR", default_value = "shisen-out")]
    out: PathBuf,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

/// What was drawn.
#[derive(Debug, Serialize)]
struct Report {
    figures: Vec<Figure>,
    /// As given.
    #[serde(skip)]
    folder: String,
}

/// An axis ratio's viewpoints.
struct Shape {
    a: f64,
    best: Design,
    /// The local minimum that is not the least.
    other: Option<Design>,
}

/// The axis ratios of the figures: whole, and where something happens.
const WHOLE: Range<f64> = 0.5..6.0;
const SMALL_ERRORS: Range<f64> = 1.25..6.0;
const FAR_VIEWPOINTS: Range<f64> = 1.2..1.4;
const PARALLEL: Range<f64> = 0.5..2.1;
const PARALLEL_BEST: Range<f64> = 1.28..1.3;

/// Runs the command.
pub(in crate::cli) fn run(arguments: &Arguments) -> Result<(), Failure> {
    make_writable(&arguments.out)?;
    let count = arguments.points;
    let MappingChoice(mapping) = arguments.mapping;
    let whole = perspective(&WHOLE, count, mapping)?;
    let small_errors = perspective(&SMALL_ERRORS, count, mapping)?;
    let far_viewpoints = perspective(&FAR_VIEWPOINTS, count, mapping)?;
    let enlarged = |range: Range<f64>| match mapping {
        Mapping::Mirror => range,
        Mapping::Exact | Mapping::True => 0.0..range.end,
    };
    let mut charts = [
        (10, errors("Error by perspective", &whole, &WHOLE, 0.0..2.0)),
        (
            11,
            errors(
                "Error by perspective, enlarged",
                &small_errors,
                &SMALL_ERRORS,
                enlarged(0.1..0.14),
            ),
        ),
        (
            12,
            viewpoints(
                "Viewpoint by perspective",
                &whole,
                &WHOLE,
                (0.0..12.0, false),
            ),
        ),
        (
            13,
            viewpoints(
                "Viewpoint by perspective, enlarged",
                &far_viewpoints,
                &FAR_VIEWPOINTS,
                (1.0..1.0e4, true),
            ),
        ),
        (14, places(&whole)),
        (
            15,
            parallel_errors(
                "Error in parallel projection",
                (count, mapping),
                &PARALLEL,
                0.0..22.0,
            )?,
        ),
        (
            16,
            parallel_errors(
                "Error in parallel projection, enlarged",
                (count, mapping),
                &PARALLEL_BEST,
                enlarged(0.1..0.22),
            )?,
        ),
    ];
    if let Some(ConfigChoice(named)) = arguments.config {
        let design = Design::of(named.mirror()).mapped(mapping);
        for (number, chart) in &mut charts {
            mark(chart, *number, named.name(), &design);
        }
    }
    let write = |(number, chart): (u32, Chart)| {
        Figure::write(&arguments.out, &format!("figure-{number}"), chart)
    };
    let report = Report {
        figures: charts.into_iter().map(write).collect::<Result<_, _>>()?,
        folder: arguments.out.display().to_string(),
    };
    print(&report, arguments.json)
}

/// Marks a mirror in a figure of its projection.
fn mark(chart: &mut Chart, number: u32, name: &str, design: &Design) {
    let place = match (number, design.p) {
        (10 | 11, Some(_)) | (15 | 16, None) => design.error_percent,
        (12 | 13, Some(p)) => p,
        _ => return,
    };
    chart.lines.push(Line {
        name: name.to_owned(),
        points: vec![(design.a, Some(place))],
        colour: 2,
        faint: false,
        dots: false,
    });
}

/// Axis ratios of a range, evenly by their logarithm.
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
    shapes.map_err(Failure::from_error)
}

fn of_ratio(range: &Range<f64>) -> Axis {
    Axis {
        name: "a",
        label: "polar by equatorial radius, a",
        range: range.clone(),
        logarithmic: false,
    }
}

fn of_error(range: Range<f64>) -> Axis {
    Axis {
        name: "error_percent",
        label: "largest error, % of the radius",
        range,
        logarithmic: false,
    }
}

/// The best viewpoint's line, and that of the other local minimum.
fn both(shapes: &[Shape], of: impl Fn(&Design) -> Option<f64>) -> Vec<Line> {
    let line = |name: &str, colour, faint, of: &dyn Fn(&Shape) -> Option<f64>| Line {
        name: name.to_owned(),
        points: shapes.iter().map(|shape| (shape.a, of(shape))).collect(),
        colour,
        faint,
        dots: false,
    };
    vec![
        line("the other local minimum", 1, true, &|shape| {
            shape.other.as_ref().and_then(&of)
        }),
        line("best viewpoint", 0, false, &|shape| of(&shape.best)),
    ]
}

fn errors(title: &str, shapes: &[Shape], ratios: &Range<f64>, range: Range<f64>) -> Chart {
    Chart {
        title: title.to_owned(),
        x: of_ratio(ratios),
        y: of_error(range),
        lines: both(shapes, |design| Some(design.error_percent)),
        names: Names::In(Corner::UpperRight),
        notes: Vec::new(),
    }
}

fn viewpoints(
    title: &str,
    shapes: &[Shape],
    ratios: &Range<f64>,
    (range, logarithmic): (Range<f64>, bool),
) -> Chart {
    Chart {
        title: title.to_owned(),
        x: of_ratio(ratios),
        y: Axis {
            name: "p",
            label: "viewpoint from the centre, p",
            range,
            logarithmic,
        },
        lines: both(shapes, |design| design.p),
        names: Names::In(Corner::UpperRight),
        notes: Vec::new(),
    }
}

/// Where the error is largest, to a thousandth of it: at one place or two.
fn places(shapes: &[Shape]) -> Chart {
    let line = |name: &str, colour, wanted: &dyn Fn(f64) -> bool| Line {
        name: name.to_owned(),
        points: shapes
            .iter()
            .map(|Shape { a, best, .. }| {
                let largest = best.error_percent / 100.0 * std::f64::consts::FRAC_PI_2;
                let mut places = best
                    .extrema
                    .iter()
                    .filter(|extremum| extremum.error.abs() >= 0.999 * largest)
                    .map(|extremum| extremum.r_d.to_degrees());
                (*a, places.find(|&degrees| wanted(degrees)))
            })
            .collect(),
        colour,
        faint: false,
        dots: false,
    };
    Chart {
        title: "Place of the largest error by perspective".to_owned(),
        x: of_ratio(&WHOLE),
        y: Axis {
            name: "r_d_deg",
            label: "from the zenith, degrees",
            range: 0.0..90.0,
            logarithmic: false,
        },
        lines: vec![
            line("towards the zenith", 0, &|degrees| degrees < 50.0),
            line("towards the rim", 1, &|degrees| degrees >= 50.0),
        ],
        names: Names::In(Corner::LowerRight),
        notes: Vec::new(),
    }
}

fn parallel_errors(
    title: &str,
    (count, mapping): (u32, Mapping),
    range: &Range<f64>,
    errors: Range<f64>,
) -> Result<Chart, Failure> {
    let point = |a| {
        let design = dome::optimum(a, Projection::Parallel)?.mapped(mapping);
        Ok::<_, MirrorError>((a, Some(design.error_percent)))
    };
    let points: Result<_, _> = ratios(range, count).into_iter().map(point).collect();
    Ok(Chart {
        title: title.to_owned(),
        x: of_ratio(range),
        y: of_error(errors),
        lines: vec![Line {
            name: "parallel projection".to_owned(),
            points: points.map_err(Failure::from_error)?,
            colour: 0,
            faint: false,
            dots: false,
        }],
        names: Names::In(Corner::LowerLeft),
        notes: Vec::new(),
    })
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for figure in &self.figures {
            writeln!(f, "{}: {}", figure.name, figure.title)?;
        }
        write!(f, "as .svg and .csv in {}", self.folder)
    }
}
