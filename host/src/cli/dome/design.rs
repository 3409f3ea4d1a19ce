//! `shisen dome design`: the mirror that takes the truest dome master.

use super::arguments::{MappingChoice, MirrorArguments, projection_name};
use crate::cli::output::failure::Failure;
use crate::cli::output::print;
use crate::dome::{Design, Mapping};
use clap::Args;
use serde::Serialize;
use std::fmt;

/// Designs the mirror that takes the truest dome master
///
/// With --projection alone, the least error of all axis ratios; with --a the
/// viewpoint of the least error; with --p or --beta1 that mirror. By
/// perspective the best viewpoint may be at infinity: that is parallel
/// projection. Lengths are in equatorial radii of the mirror, distances from
/// its centre but for d1.
///
/// With --json, one object: config (the name given, or null), mapping,
/// projection (parallel or perspective), a, p (the viewpoint), c1 (the screen), b1 (half
/// the screen's width), d1 (from the viewpoint to the screen), beta1 (radians),
/// fov (the camera's full field of view, degrees), `error_percent` (the largest
/// difference between angle and place, of the picture's radius),
/// `error_px_4096` (the same in pixels of a picture of 4096 columns) and
/// extrema (where it is reached on either side, degrees from the zenith in the
/// picture). In parallel projection p and d1 are null, and instead of fov there
/// is width, the whole screen's.
#[derive(Debug, Args)]
pub(in crate::cli) struct Arguments {
    #[command(flatten)]
    mirror: MirrorArguments,
    /// How pixels become directions: but by the mirror there is no error
    #[arg(long, value_enum, default_value = "mirror")]
    mapping: MappingChoice,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

/// A design.
#[derive(Debug, Serialize)]
struct Report {
    config: Option<&'static str>,
    mapping: &'static str,
    projection: &'static str,
    a: f64,
    p: Option<f64>,
    c1: f64,
    b1: f64,
    d1: Option<f64>,
    /// Radians.
    beta1: f64,
    /// Degrees; by perspective.
    #[serde(skip_serializing_if = "Option::is_none")]
    fov: Option<f64>,
    /// Radii; in parallel projection.
    #[serde(skip_serializing_if = "Option::is_none")]
    width: Option<f64>,
    error_percent: f64,
    error_px_4096: f64,
    /// Degrees.
    extrema: Vec<f64>,
}

impl Report {
    fn of(design: &Design, config: Option<&'static str>, mapping: Mapping) -> Self {
        let parallel = design.p.is_none();
        let degrees = |e: &crate::dome::Extremum| e.r_d.to_degrees();
        Self {
            config,
            mapping: mapping.name(),
            projection: projection_name(design),
            a: design.a,
            p: design.p,
            c1: design.c1,
            b1: design.b1,
            d1: design.d1,
            beta1: design.beta1,
            fov: (!parallel).then(|| design.field_of_view.to_degrees()),
            width: parallel.then_some(2.0 * design.b1),
            error_percent: design.error_percent,
            error_px_4096: design.error_px_4096,
            extrema: design.extrema.iter().map(degrees).collect(),
        }
    }
}

/// Runs the command.
pub(in crate::cli) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let Some(design) = arguments.mirror.design()? else {
        return Err(Failure::usage(
            "no mirror to design: give --projection parallel or perspective, or a mirror's name \
             with --config",
        ));
    };
    let config = arguments.mirror.name();
    let MappingChoice(mapping) = arguments.mapping;
    let report = Report::of(&design.mapped(mapping), config, mapping);
    print(&report, arguments.json)
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let row = |f: &mut fmt::Formatter<'_>, name: &str, value: f64, what: &str| {
            writeln!(f, "{name:<6}{value:>16.9}  {what}")
        };
        if let Some(config) = self.config {
            writeln!(f, "{config}: {} projection", self.projection)?;
        } else {
            writeln!(f, "{} projection", self.projection)?;
        }
        row(f, "a", self.a, "polar by equatorial radius")?;
        if let Some(p) = self.p {
            row(f, "p", p, "viewpoint, from the mirror's centre")?;
        }
        row(f, "c1", self.c1, "screen, from the mirror's centre")?;
        row(f, "b1", self.b1, "half the screen's width")?;
        if let Some(d1) = self.d1 {
            row(f, "d1", d1, "from the viewpoint to the screen")?;
        }
        row(f, "beta1", self.beta1, "radians, the edge on the mirror")?;
        if let Some(fov) = self.fov {
            row(f, "fov", fov, "degrees, the camera's field of view")?;
        }
        if let Some(width) = self.width {
            row(f, "width", width, "the camera's width of view")?;
        }
        write!(
            f,
            "error {:>16.9}  % of the picture's radius: {:.6} pixels at 4096, {}",
            self.error_percent,
            self.error_px_4096,
            match self.extrema.len() {
                0 => "by its mapping",
                1 => "extremum at",
                _ => "extrema at",
            }
        )?;
        for (i, degrees) in self.extrema.iter().enumerate() {
            let and = if i == 0 { "" } else { " and" };
            write!(f, "{and} {degrees:.4}°")?;
        }
        Ok(())
    }
}
