//! `shisen dome nearfield`: what surroundings near the mirror cost.

use super::arguments::{MappingChoice, MirrorArguments};
use super::figure::Figure;
use crate::cli::arguments::{number, number_within};
use crate::cli::output::failure::Failure;
use crate::cli::output::picture_files::make_writable;
use crate::cli::output::print;
use crate::dome::{self, Design, NearField, NearestError, SizeErrors, Viewpoint, px_4096};
use crate::picture::chart::{Axis, Chart, Corner, Line, Names};
use clap::{Args, ValueEnum};
use rayon::prelude::*;
use serde::Serialize;
use std::f64::consts::FRAC_PI_2;
use std::fmt;
use std::ops::Range;
use std::path::PathBuf;

/// Measures what surroundings near the mirror cost: the paper's figures 18 to
/// 20 as numbers, and the trade-off that it leaves open
///
/// All displacements are in pixels of a picture of 4096 columns, all distances
/// in equatorial radii of the mirror from the viewpoint. The mirror is Table 1
/// (1) unless --config or --projection says otherwise. Writes .csv and .svg
/// each of three charts.
///
/// nearfield-rings: how far from its place each ring of a sphere round the
/// viewpoint is seen. The viewpoint is the screen's centre, as in the paper, or
/// the best one.
///
/// nearfield-viewpoint: a mirror has no single viewpoint. The best one makes
/// the largest displacement least, over the whole picture and surroundings
/// anywhere from the nearest distance to infinity.
///
/// nearfield-size: the smaller the mirror, the farther the surroundings, but
/// the fewer bits are left of its shape. In single precision, the largest
/// error of rays from a mirror that is traced in its own frame, as here, and
/// from one that is an object of the world, for sizes of 1e-7 to 1 of the
/// distance to the nearest surface, seen from the screen's centre.
///
/// What remains: with the directions exact (--mapping exact), displacement
/// falls as the mirror's size and rounding does not grow, so a mirror of 1e-6
/// of the nearest distance has neither. A large mirror, as for a photograph,
/// keeps the displacement from the best viewpoint, because its rays do not meet
/// in one point.
///
/// With --json, one object: config (null for a mirror by its shape), mapping,
/// viewpoint, reach (of the mirror from the screen's centre), distances
/// (distance, null for infinity; offset, of the viewpoint from the screen's
/// centre towards the zenith; rings: `ring_deg`, `r_d_deg` and px each, null
/// where a ring is outside the picture; `max_px` and `max_r_d_deg`, of the
/// whole picture at this distance), viewpoints (distance, the nearest; offset,
/// of the best one; `max_px` and `screen_max_px`, from there and from the
/// screen's centre; gain, how many times less), sizes (offset, from the world's
/// origin, and size, both in distances to the nearest surface; `near_field_px`,
/// null where the mirror reaches through the surface; `rounding_px`;
/// `world_px`, as an object of the world, null where no ray meets the mirror;
/// `world_missed`, the share of rays that do not) and figures (name, title, x
/// and y, csv and svg: paths, and lines: name, x and y each).
#[derive(Debug, Args)]
pub(in crate::cli) struct Arguments {
    #[command(flatten)]
    mirror: MirrorArguments,
    /// How pixels become directions
    #[arg(long, value_enum, default_value = "mirror")]
    mapping: MappingChoice,
    /// Distances of the surroundings: equatorial radii. Infinity is always
    /// there
    #[arg(
        long,
        value_name = "D,...",
        default_value = "1,2,3,10,100",
        value_delimiter = ',',
        allow_hyphen_values = true,
        value_parser = number::<f64>
    )]
    distance: Vec<f64>,
    /// Where the eye is
    #[arg(long, value_enum, default_value = "screen")]
    viewpoint: ViewpointChoice,
    /// Distances of the mirror from the world's origin, in distances to the
    /// nearest surface, from 0 to 1e6
    #[arg(long, value_name = "L,...", default_value = "1,1000",
          value_delimiter = ',', allow_hyphen_values = true, value_parser = world_offset)]
    world_offset: Vec<f64>,
    /// Folder of the charts; made where it does not exist
    #[arg(long, value_name = "DIR", default_value = "shisen-out")]
    out: PathBuf,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

/// `--viewpoint`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum ViewpointChoice {
    /// The screen's centre, S, as in the paper
    Screen,
    /// The best one for each distance
    Best,
}

impl ViewpointChoice {
    const fn name(self) -> &'static str {
        match self {
            Self::Screen => "screen",
            Self::Best => "best",
        }
    }
}

fn world_offset(text: &str) -> Result<f64, String> {
    number_within(text, 0.0, 1.0e6)
        .ok_or_else(|| "give numbers from 0 to 1e6, such as 1,1000".into())
}

/// What surroundings cost.
#[derive(Debug, Serialize)]
struct Report {
    config: Option<&'static str>,
    mapping: &'static str,
    viewpoint: &'static str,
    reach: f64,
    distances: Vec<AtDistance>,
    viewpoints: Vec<BestViewpoint>,
    sizes: Vec<Errors>,
    figures: Vec<Figure>,
    /// As given.
    #[serde(skip)]
    folder: String,
}

/// A sphere round the viewpoint.
#[derive(Debug, Serialize)]
struct AtDistance {
    /// None for infinity.
    distance: Option<f64>,
    offset: f64,
    rings: Vec<SeenRing>,
    max_px: f64,
    max_r_d_deg: f64,
}

/// A ring of such a sphere.
#[derive(Debug, Serialize)]
struct SeenRing {
    ring_deg: f64,
    r_d_deg: Option<f64>,
    px: Option<f64>,
}

/// The best viewpoint for surroundings from a distance on.
#[derive(Debug, Serialize)]
struct BestViewpoint {
    distance: f64,
    offset: f64,
    max_px: f64,
    screen_max_px: f64,
    gain: f64,
}

/// Both errors of a mirror's size.
#[derive(Debug, Serialize)]
struct Errors {
    offset: f64,
    size: f64,
    near_field_px: Option<f64>,
    rounding_px: f64,
    world_px: Option<f64>,
    world_missed: f64,
}

/// The mirror's sizes: so many steps of each decade, from the smallest to 1.
const DECADES: i32 = 7;
const STEPS: i32 = 2;

/// Runs the command.
pub(in crate::cli) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let Design { mirror, .. } = arguments.mirror.design_or_first()?;
    let mapping = arguments.mapping.0;
    let near = NearField::new(mirror, mapping);
    let mut distances = arguments.distance.clone();
    distances.retain(|&distance| distance != f64::INFINITY);
    distances.sort_by(f64::total_cmp);
    distances.dedup();
    let best = |&distance: &f64| {
        let found = dome::effective_viewpoint(&near, distance)?;
        Ok((distance, found))
    };
    let viewpoints: Result<Vec<(f64, Viewpoint)>, NearestError> =
        distances.iter().map(best).collect();
    let viewpoints = viewpoints.map_err(|error| Failure::usage(&error.to_string()))?;
    let seen: Vec<(f64, NearField)> = viewpoints
        .iter()
        .map(|(distance, best)| match arguments.viewpoint {
            ViewpointChoice::Screen => (*distance, near.clone()),
            ViewpointChoice::Best => (*distance, near.clone().seen_from(best.offset)),
        })
        // Nothing at infinity depends on where it is seen from.
        .chain([(f64::INFINITY, near.clone())])
        .collect();
    let sizes = sizes(&near, &arguments.world_offset)?;
    make_writable(&arguments.out)?;
    let title = match arguments.mirror.name() {
        Some(name) => format!("{name}, mapping {}", mapping.name()),
        None => format!("mapping {}", mapping.name()),
    };
    let charts = [
        (
            "nearfield-rings",
            rings_chart(&title, arguments.viewpoint, &seen),
        ),
        ("nearfield-viewpoint", viewpoint_chart(&title, &near)),
        ("nearfield-size", size_chart(&title, &sizes)),
    ];
    let write = |(name, chart): (&str, Chart)| Figure::write(&arguments.out, name, chart);
    let report = Report {
        config: arguments.mirror.name(),
        mapping: mapping.name(),
        viewpoint: arguments.viewpoint.name(),
        reach: near.reach(),
        distances: seen.iter().map(|(d, near)| at_distance(near, *d)).collect(),
        viewpoints: viewpoints.into_iter().map(best_viewpoint).collect(),
        sizes: sizes.into_iter().map(Errors::from).collect(),
        figures: charts.into_iter().map(write).collect::<Result<_, _>>()?,
        folder: arguments.out.display().to_string(),
    };
    print(&report, arguments.json)
}

fn at_distance(near: &NearField, distance: f64) -> AtDistance {
    let rings = (1..=8).map(|i| {
        let ring_deg = f64::from(10 * i);
        let ring = ring_deg.to_radians();
        let r_d = near.ring(ring, distance);
        SeenRing {
            ring_deg,
            r_d_deg: r_d.map(f64::to_degrees),
            px: r_d.map(|r_d| px_4096((r_d - ring).abs())),
        }
    });
    let largest = near.largest(distance);
    AtDistance {
        distance: distance.is_finite().then_some(distance),
        offset: near.offset(),
        rings: rings.collect(),
        max_px: largest.px_4096(),
        max_r_d_deg: largest.r_d.to_degrees(),
    }
}

fn best_viewpoint((distance, found): (f64, Viewpoint)) -> BestViewpoint {
    BestViewpoint {
        distance,
        offset: found.offset,
        max_px: px_4096(found.largest),
        screen_max_px: px_4096(found.from_screen),
        gain: found.gain(),
    }
}

impl From<SizeErrors> for Errors {
    fn from(errors: SizeErrors) -> Self {
        Self {
            offset: errors.offset,
            size: errors.size,
            near_field_px: errors.near_field,
            rounding_px: errors.rounding,
            world_px: errors.world,
            world_missed: errors.missed,
        }
    }
}

fn sizes(near: &NearField, offsets: &[f64]) -> Result<Vec<SizeErrors>, Failure> {
    let each: Vec<(f64, f64)> = offsets
        .iter()
        .flat_map(|&offset| {
            let size = |i: i32| libm::pow(10.0, f64::from(i) / f64::from(STEPS));
            (-DECADES * STEPS..=0).map(move |i| (offset, size(i)))
        })
        .collect();
    each.par_iter()
        .map(|&(offset, size)| dome::size_errors(near, size, offset))
        .collect::<Result<_, _>>()
        .map_err(|error| Failure::usage(&error.to_string()))
}

fn rings_chart(title: &str, viewpoint: ViewpointChoice, seen: &[(f64, NearField)]) -> Chart {
    let line = |(colour, (distance, near)): (usize, &(f64, NearField))| Line {
        name: if distance.is_finite() {
            format!("D = {distance}")
        } else {
            "far away".to_owned()
        },
        points: (0..=180)
            .map(|i| {
                let r_d = FRAC_PI_2 * f64::from(i) / 180.0;
                let displaced = px_4096(r_d - near.angle(r_d, *distance));
                (f64::from(i) / 2.0, Some(displaced))
            })
            .collect(),
        colour,
        faint: false,
        dots: false,
    };
    let lines: Vec<Line> = seen.iter().enumerate().map(line).collect();
    let (mut low, mut high) = (0f64, 0f64);
    for (_, y) in lines.iter().flat_map(|line| &line.points) {
        low = low.min(y.unwrap_or(0.0));
        high = high.max(y.unwrap_or(0.0));
    }
    // A picture without any displacement has an axis, too.
    let room = (0.05 * (high - low)).max(1.0e-3);
    Chart {
        title: format!(
            "{title}: displacement, seen from {}",
            match viewpoint {
                ViewpointChoice::Screen => "the screen's centre",
                ViewpointChoice::Best => "the best viewpoint",
            }
        ),
        x: Axis {
            name: "r_d_deg",
            label: "from the zenith, degrees",
            range: 0.0..90.0,
            logarithmic: false,
        },
        y: Axis {
            name: "displacement_px",
            label: "towards the rim, pixels at 4096",
            range: low - room..high + room,
            logarithmic: false,
        },
        lines,
        names: Names::In(Corner::LowerLeft),
        notes: Vec::new(),
    }
}

fn viewpoint_chart(title: &str, near: &NearField) -> Chart {
    const COUNT: i32 = 40;
    let range = 1.02 * near.reach().max(0.1)..1.0e3;
    let nearest = |i: i32| {
        let part = f64::from(i) / f64::from(COUNT);
        range.start * libm::pow(range.end / range.start, part)
    };
    let found: Vec<(f64, Option<Viewpoint>)> = (0..=COUNT)
        .into_par_iter()
        .map(|i| (nearest(i), dome::effective_viewpoint(near, nearest(i)).ok()))
        .collect();
    let line = |name: &str, colour, of: &dyn Fn(&Viewpoint) -> f64| Line {
        name: name.to_owned(),
        points: found
            .iter()
            .map(|(nearest, found)| (*nearest, found.as_ref().map(|found| px_4096(of(found)))))
            .collect(),
        colour,
        faint: false,
        dots: false,
    };
    let lines = vec![
        line("from the screen's centre", 0, &|found| found.from_screen),
        line("from the best viewpoint", 1, &|found| found.largest),
    ];
    // Whole decades; none where nothing is displaced.
    let values = lines.iter().flat_map(|line| &line.points);
    let least = values.filter_map(|(_, y)| *y).fold(1.0, f64::min);
    let least = libm::floor(libm::log10(least.max(1.0e-6)));
    Chart {
        title: format!("{title}: largest displacement"),
        x: Axis {
            name: "nearest",
            label: "nearest surface, equatorial radii",
            range: range.clone(),
            logarithmic: true,
        },
        y: Axis {
            name: "displacement_px",
            label: "largest displacement, pixels at 4096",
            range: libm::pow(10.0, least)..1.0e3,
            logarithmic: true,
        },
        lines,
        names: Names::In(Corner::UpperRight),
        notes: Vec::new(),
    }
}

fn size_chart(title: &str, sizes: &[SizeErrors]) -> Chart {
    let mut lines = Vec::new();
    for (number, of_offset) in sizes.chunk_by(|a, b| a.offset == b.offset).enumerate() {
        let line = |name: String, colour, of: &dyn Fn(&SizeErrors) -> Option<f64>| Line {
            name,
            points: of_offset.iter().map(|one| (one.size, of(one))).collect(),
            colour,
            faint: false,
            dots: false,
        };
        let at = of_offset.first().map_or(0.0, |one| one.offset);
        if number == 0 {
            lines.push(line("near field".to_owned(), 6, &|one| one.near_field));
        }
        let own = format!("rounding, own frame, at {at}");
        lines.push(line(own, 2 * number, &|one| Some(one.rounding)));
        let world = format!("rounding, as an object, at {at}");
        lines.push(line(world, 2 * number + 1, &|one| one.world));
    }
    let range = |from: i32| Range {
        start: libm::pow(10.0, f64::from(from)),
        end: 1.0,
    };
    Chart {
        title: format!("{title}: errors in single precision"),
        x: Axis {
            name: "size",
            label: "equatorial radius by distance to the nearest surface",
            range: range(-DECADES),
            logarithmic: true,
        },
        y: Axis {
            name: "error_px",
            label: "largest error, pixels at 4096",
            range: 1.0e-6..1.0e6,
            logarithmic: true,
        },
        lines,
        names: Names::In(Corner::UpperRight),
        notes: Vec::new(),
    }
}

/// A number of pixels, or a dash where there is none.
fn pixels(px: Option<f64>, digits: usize) -> String {
    px.map_or_else(|| "-".to_owned(), |px| format!("{px:.digits$}"))
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "{}, mapping {}, seen from {}: displacement in pixels at 4096",
            self.config.unwrap_or("this mirror"),
            self.mapping,
            match self.viewpoint {
                "best" => "the best viewpoint",
                _ => "the screen's centre",
            }
        )?;
        write!(f, "{:>10}", "distance")?;
        for degrees in 1..=8 {
            write!(f, "{degrees:>7}0°")?;
        }
        writeln!(f, "{:>10}", "largest")?;
        for at in &self.distances {
            let distance = at.distance.map_or("∞".to_owned(), |d| d.to_string());
            write!(f, "{distance:>10}")?;
            for ring in &at.rings {
                write!(f, "{:>9}", pixels(ring.px, 2))?;
            }
            writeln!(f, "{:>10.3}", at.max_px)?;
        }
        writeln!(
            f,
            "surroundings from a distance on:\n{:>10}{:>18}{:>16}{:>16}{:>8}",
            "nearest", "best viewpoint", "px from there", "px from screen", "gain"
        )?;
        for best in &self.viewpoints {
            writeln!(
                f,
                "{:>10}{:>18.6}{:>16.3}{:>16.3}{:>8.2}",
                best.distance, best.offset, best.max_px, best.screen_max_px, best.gain
            )?;
        }
        writeln!(
            f,
            "in single precision:\n{:>10}{:>10}{:>14}{:>20}{:>24}",
            "world at", "size", "near field px", "own frame adds px", "as an object adds px"
        )?;
        for size in &self.sizes {
            writeln!(
                f,
                "{:>10}{:>10.1e}{:>14}{:>20.5}{:>24}",
                size.offset,
                size.size,
                pixels(size.near_field_px, 5),
                size.rounding_px,
                pixels(size.world_px, 5)
            )?;
        }
        write!(
            f,
            "nearfield-rings, nearfield-viewpoint and nearfield-size as .svg and .csv in {}",
            self.folder
        )
    }
}
