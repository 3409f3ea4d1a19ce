//! `shisen dome nearfield`: what surroundings near the mirror cost.

use super::arguments::MirrorArguments;
use super::figure::{Figure, chart, logarithmic};
use crate::cli::prelude::*;
use crate::dome::{self, Design, NearField, SizeErrors, Viewpoint, px_4096};
use crate::picture::chart::{Axis, Chart, Corner, Line};
use rayon::prelude::*;
use std::f64::consts::FRAC_PI_2;

/// Measures what surroundings near the mirror cost, as numbers for the paper's figures 18 to 20
#[derive(Debug, Args)]
pub(in crate::cli) struct Arguments {
    #[command(flatten)]
    mirror: MirrorArguments,
    /// Distances of the surroundings, equatorial radii; infinity is always added
    #[arg(long, value_name = "D,...", default_value = "1,2,3,10,100", value_delimiter = ',',
          allow_hyphen_values = true, value_parser = number::<f64>)]
    distance: Vec<f64>,
    /// Position of the eye
    #[arg(long, value_enum, default_value = "screen")]
    viewpoint: ViewpointChoice,
    /// Distances of the mirror from the world's origin, from 0 to 1e6 distances to the nearest
    /// surface
    #[arg(long, value_name = "L,...", default_value = "1,1000", value_delimiter = ',',
          allow_hyphen_values = true,
          value_parser = within(0.0..=1.0e6, "numbers from 0 to 1e6, such as 1,1000"))]
    world_offset: Vec<f64>,
    /// Folder of the charts; made if it does not exist
    #[arg(long, value_name = "DIR", default_value = "shisen-out")]
    out: PathBuf,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum ViewpointChoice {
    /// The screen's centre, S, as in the paper
    Screen,
    /// The best one for each distance
    Best,
}

/// The errors through surroundings near the mirror.
#[derive(Debug, Serialize, JsonSchema)]
pub(in crate::cli) struct Report {
    /// Name of the mirror; null for a mirror by its shape.
    config: Option<&'static str>,
    /// How pixels become directions: mirror, exact or true.
    mapping: &'static str,
    /// Position of the eye: screen or best.
    viewpoint: &'static str,
    /// Distance of the mirror's farthest point from the screen's centre.
    reach: f64,
    /// Spheres round the viewpoint.
    distances: Vec<AtDistance>,
    /// Best viewpoints for surroundings from a distance to infinity.
    viewpoints: Vec<BestViewpoint>,
    /// Errors by the mirror's size, seen from the screen's centre.
    sizes: Vec<SizeErrors>,
    /// Charts.
    figures: Vec<Figure>,
    #[serde(skip)]
    folder: String,
    #[serde(skip)]
    seen_from: &'static str,
}

#[derive(Debug, Serialize, JsonSchema)]
struct AtDistance {
    /// Radius of the sphere; null for infinity.
    distance: Option<f64>,
    /// Viewpoint from the screen's centre towards the zenith.
    offset: f64,
    /// Rings of the sphere.
    rings: Vec<SeenRing>,
    /// Largest displacement in the picture, pixels.
    max_px: f64,
    /// Place of the largest displacement, degrees from the zenith.
    max_r_d_deg: f64,
}

#[derive(Debug, Serialize, JsonSchema)]
struct SeenRing {
    /// Angle of the ring from the zenith, degrees.
    ring_deg: f64,
    /// Place of the ring in the picture, degrees; null outside the picture.
    r_d_deg: Option<f64>,
    /// Displacement of the ring, pixels; null outside the picture.
    px: Option<f64>,
}

#[derive(Debug, Serialize, JsonSchema)]
struct BestViewpoint {
    /// The nearest distance.
    distance: f64,
    /// Viewpoint from the screen's centre towards the zenith.
    offset: f64,
    /// Largest displacement seen from there, pixels.
    max_px: f64,
    /// Largest displacement seen from the screen's centre, pixels.
    screen_max_px: f64,
    /// How many times less the displacement is.
    gain: f64,
}

/// Decades of the mirror's size, up to 1, and sizes in each.
const DECADES: i32 = 7;
const STEPS: i32 = 2;

pub(in crate::cli) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let Design { mirror, .. } = arguments.mirror.design_or_first()?;
    let mapping = arguments.mirror.mapping;
    let near = NearField::new(mirror, mapping);
    let mut distances = arguments.distance.clone();
    distances.retain(|&distance| distance != f64::INFINITY);
    distances.sort_by(f64::total_cmp);
    distances.dedup();
    let mut viewpoints = Vec::new();
    for distance in distances {
        let best = dome::effective_viewpoint(&near, distance).or_misuse()?;
        viewpoints.push((distance, best));
    }
    let seen: Vec<(f64, NearField)> = viewpoints
        .iter()
        .map(|(distance, best)| match arguments.viewpoint {
            ViewpointChoice::Screen => (*distance, near.clone()),
            ViewpointChoice::Best => (*distance, near.clone().seen_from(best.offset)),
        })
        // What is at infinity looks the same from every viewpoint.
        .chain([(f64::INFINITY, near.clone())])
        .collect();
    let sizes = sizes(&near, &arguments.world_offset)?;
    make_writable(&arguments.out)?;
    let mut title = format!("mapping {}", mapping.name());
    if let Some(name) = arguments.mirror.name() {
        title = format!("{name}, {title}");
    }
    let (viewpoint, seen_from) = match arguments.viewpoint {
        ViewpointChoice::Screen => ("screen", "the screen's centre"),
        ViewpointChoice::Best => ("best", "the best viewpoint"),
    };
    let figures = [
        ("rings", rings_chart(&title, seen_from, &seen)),
        ("viewpoint", viewpoint_chart(&title, &near)),
        ("size", size_chart(&title, &sizes)),
    ];
    let figures = figures.into_iter().map(|(name, chart)| {
        let name = format!("nearfield-{name}");
        Figure::write(&arguments.out, &name, chart)
    });
    let report = Report {
        config: arguments.mirror.name(),
        mapping: mapping.name(),
        viewpoint,
        reach: near.reach(),
        distances: seen.iter().map(|(d, near)| at_distance(near, *d)).collect(),
        viewpoints: viewpoints
            .into_iter()
            .map(|(distance, found)| BestViewpoint {
                distance,
                offset: found.offset,
                max_px: px_4096(found.largest),
                screen_max_px: px_4096(found.from_screen),
                gain: found.gain(),
            })
            .collect(),
        sizes,
        figures: figures.collect::<Result<_, _>>()?,
        folder: arguments.out.display().to_string(),
        seen_from,
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

fn sizes(near: &NearField, offsets: &[f64]) -> Result<Vec<SizeErrors>, Failure> {
    let size = |i: i32| libm::pow(10.0, f64::from(i) / f64::from(STEPS));
    let sizes = |&offset: &f64| (-DECADES * STEPS..=0).map(move |i| (offset, size(i)));
    let each: Vec<(f64, f64)> = offsets.iter().flat_map(sizes).collect();
    let errors = each.par_iter();
    let errors = errors.map(|&(offset, size)| dome::size_errors(near, size, offset));
    errors.collect::<Result<_, _>>().or_misuse()
}

fn rings_chart(title: &str, seen_from: &str, seen: &[(f64, NearField)]) -> Chart {
    let rings = |(colour, (distance, near)): (usize, &(f64, NearField))| {
        let name = if distance.is_finite() {
            format!("D = {distance}")
        } else {
            "far away".to_owned()
        };
        let point = |i| {
            let r_d = FRAC_PI_2 * f64::from(i) / 180.0;
            let displaced = px_4096(r_d - near.angle(r_d, *distance));
            (f64::from(i) / 2.0, Some(displaced))
        };
        Line::new(name, colour, (0..=180).map(point))
    };
    let lines: Vec<_> = seen.iter().enumerate().map(rings).collect();
    let (mut low, mut high) = (0f64, 0f64);
    for (_, y) in lines.iter().flat_map(|line| &line.points) {
        low = low.min(y.unwrap_or(0.0));
        high = high.max(y.unwrap_or(0.0));
    }
    // An axis needs a length even if nothing is displaced.
    let room = (0.05 * (high - low)).max(1.0e-3);
    let title = format!("{title}: displacement, seen from {seen_from}");
    let place = Axis::linear("r_d_deg", "from the zenith, degrees", 0.0..90.0);
    let range = low - room..high + room;
    let displacement = Axis::linear("displacement_px", "towards the rim, pixels at 4096", range);
    chart(title, [place, displacement], lines, Corner::LowerLeft)
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
    let displaced = |name, colour, of: &dyn Fn(&Viewpoint) -> f64| {
        let px = |found: &Option<Viewpoint>| found.as_ref().map(|one| px_4096(of(one)));
        let points = found.iter().map(|(nearest, found)| (*nearest, px(found)));
        Line::new(name, colour, points)
    };
    let lines = vec![
        displaced("from the screen's centre", 0, &|found| found.from_screen),
        displaced("from the best viewpoint", 1, &|found| found.largest),
    ];
    // The axis begins at a whole decade.
    let values = lines.iter().flat_map(|line| &line.points);
    let least = values.filter_map(|(_, y)| *y).fold(1.0, f64::min);
    let least = libm::floor(libm::log10(least.max(1.0e-6)));
    let label = "nearest surface, equatorial radii";
    let nearest = Axis::linear("nearest", label, range.clone());
    let label = "largest displacement, pixels at 4096";
    let range = libm::pow(10.0, least)..1.0e3;
    let largest = Axis::linear("displacement_px", label, range);
    let axes = [nearest, largest].map(logarithmic);
    let title = format!("{title}: largest displacement");
    chart(title, axes, lines, Corner::UpperRight)
}

fn size_chart(title: &str, sizes: &[SizeErrors]) -> Chart {
    let mut lines = Vec::new();
    for (number, of_offset) in sizes.chunk_by(|a, b| a.offset == b.offset).enumerate() {
        let errors = |name: String, colour, of: &dyn Fn(&SizeErrors) -> Option<f64>| {
            let points = of_offset.iter().map(|one| (one.size, of(one)));
            Line::new(name, colour, points)
        };
        let at = of_offset.first().map_or(0.0, |one| one.offset);
        if number == 0 {
            lines.push(errors("near field".to_owned(), 6, &|one| one.near_field_px));
        }
        let own = format!("rounding, own frame, at {at}");
        lines.push(errors(own, 2 * number, &|one| Some(one.rounding_px)));
        let world = format!("rounding, as an object, at {at}");
        lines.push(errors(world, 2 * number + 1, &|one| one.world_px));
    }
    let sizes = libm::pow(10.0, f64::from(-DECADES))..1.0;
    let label = "equatorial radius by distance to the nearest surface";
    let size = Axis::linear("size", label, sizes);
    let error = Axis::linear("error_px", "largest error, pixels at 4096", 1.0e-6..1.0e6);
    let title = format!("{title}: errors in single precision");
    let axes = [size, error].map(logarithmic);
    chart(title, axes, lines, Corner::UpperRight)
}

fn pixels(px: Option<f64>, digits: usize) -> String {
    px.map_or_else(|| "-".to_owned(), |px| format!("{px:.digits$}"))
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (name, mapping) = (self.config.unwrap_or("this mirror"), self.mapping);
        write!(
            f,
            "{name}, mapping {mapping}, seen from {}: ",
            self.seen_from
        )?;
        writeln!(f, "displacement in pixels at 4096")?;
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
        writeln!(f, "surroundings from a distance to infinity:")?;
        let heading = "   nearest    best viewpoint   px from there  px from screen    gain";
        writeln!(f, "{heading}")?;
        for best in &self.viewpoints {
            write!(f, "{:>10}{:>18.6}", best.distance, best.offset)?;
            write!(f, "{:>16.3}{:>16.3}", best.max_px, best.screen_max_px)?;
            writeln!(f, "{:>8.2}", best.gain)?;
        }
        writeln!(f, "in single precision:")?;
        let heading =
            "  world at      size near field px   own frame adds px     as an object adds px";
        writeln!(f, "{heading}")?;
        for one in &self.sizes {
            let (near, world) = (pixels(one.near_field_px, 5), pixels(one.world_px, 5));
            write!(f, "{:>10}{:>10.1e}{near:>14}", one.offset, one.size)?;
            writeln!(f, "{:>20.5}{world:>24}", one.rounding_px)?;
        }
        let names = "nearfield-rings, nearfield-viewpoint and nearfield-size";
        write!(f, "{names} as .svg and .csv in {}", self.folder)
    }
}
