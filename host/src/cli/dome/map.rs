//! `shisen dome map`: angles and their places in a dome master.

use super::arguments::{MappingChoice, MirrorArguments};
use crate::cli::arguments::number_within;
use crate::cli::output::failure::Failure;
use crate::cli::output::print;
use crate::dome::{Design, Mapping, px_4096};
use clap::Args;
use serde::Serialize;
use shisen_core::capture::SpheroidMirror;
use std::fmt;

/// Maps angles to places in the dome master and back
///
/// For surroundings far away: θ is the angle to the zenith, `r_d` the distance
/// from the picture's centre with 90° at its rim. A true dome master has them
/// equal. The mirror is Table 1 (1) unless --config or --projection says
/// otherwise.
///
/// With --json, one object: config (null for a mirror by its shape), mapping,
/// f32 (whether in single precision), `step_deg`, `r_d_to_theta` (`r_d_deg`,
/// `theta_deg` and `error_px`, their difference in pixels of a picture of 4096
/// columns, each) and `theta_to_r_d` (`theta_deg`, `r_d_deg` and `error_px`
/// each), from 0 to 90 degrees.
#[derive(Debug, Args)]
pub(in crate::cli) struct Arguments {
    #[command(flatten)]
    mirror: MirrorArguments,
    /// How pixels become directions
    #[arg(long, value_enum, default_value = "mirror")]
    mapping: MappingChoice,
    /// From one row to the next: degrees, from 0.001 to 90
    #[arg(long, value_name = "DEGREES", default_value_t = 10.0, allow_hyphen_values = true,
          value_parser = step)]
    step: f64,
    /// Compute in the tracer's single precision
    #[arg(long)]
    f32: bool,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

fn step(text: &str) -> Result<f64, String> {
    number_within(text, 0.001, 90.0)
        .ok_or_else(|| "give degrees from 0.001 to 90, such as 10".into())
}

/// Both tables.
#[derive(Debug, Serialize)]
struct Report {
    config: Option<&'static str>,
    mapping: &'static str,
    f32: bool,
    step_deg: f64,
    r_d_to_theta: Vec<ToTheta>,
    theta_to_r_d: Vec<ToPlace>,
}

/// What is seen at a place.
#[derive(Debug, Serialize)]
struct ToTheta {
    r_d_deg: f64,
    theta_deg: f64,
    error_px: f64,
}

/// Where something is seen.
#[derive(Debug, Serialize)]
struct ToPlace {
    theta_deg: f64,
    r_d_deg: f64,
    error_px: f64,
}

/// The mapping in either precision, radians.
enum Precision {
    Double(Design),
    Single(SpheroidMirror),
}

impl Precision {
    fn theta(&self, mapping: Mapping, r_d: f64) -> Option<f64> {
        match self {
            Self::Double(design) => Some(mapping.theta(&design.mirror, r_d)),
            Self::Single(mirror) => mapping.single_theta(mirror, r_d as f32).map(f64::from),
        }
    }

    fn r_d(&self, mapping: Mapping, theta: f64) -> Option<f64> {
        match self {
            Self::Double(design) => Some(mapping.r_d(&design.mirror, theta)),
            Self::Single(mirror) => mapping.single_r_d(mirror, theta as f32).map(f64::from),
        }
    }
}

/// Runs the command.
pub(in crate::cli) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let design = arguments.mirror.design_or_first()?;
    let MappingChoice(mapping) = arguments.mapping;
    let precision = if arguments.f32 {
        let single = design.mirror.single();
        Precision::Single(single.map_err(|error| Failure::usage(&error.to_string()))?)
    } else {
        Precision::Double(design)
    };
    let angles = angles(arguments.step);
    let to_theta = |&(degrees, angle): &(f64, f64)| {
        let theta = precision.theta(mapping, angle)?;
        Some(ToTheta {
            r_d_deg: degrees,
            theta_deg: theta.to_degrees(),
            error_px: px_4096(theta - angle),
        })
    };
    let to_place = |&(degrees, angle): &(f64, f64)| {
        let r_d = precision.r_d(mapping, angle)?;
        Some(ToPlace {
            theta_deg: degrees,
            r_d_deg: r_d.to_degrees(),
            error_px: px_4096(r_d - angle),
        })
    };
    let report = Report {
        config: arguments.mirror.name(),
        mapping: mapping.name(),
        f32: arguments.f32,
        step_deg: arguments.step,
        r_d_to_theta: angles.iter().filter_map(to_theta).collect(),
        theta_to_r_d: angles.iter().filter_map(to_place).collect(),
    };
    print(&report, arguments.json)
}

/// Degrees and radians from 0 to 90°, which is the last even where no step
/// leads to it. Radians are at most π/2 in single precision too.
fn angles(step: f64) -> Vec<(f64, f64)> {
    // A step's multiples are rounded.
    let count = libm::ceil((90.0 - 1.0e-9) / step) as u32;
    let mut degrees: Vec<f64> = (0..count).map(|i| f64::from(i) * step).collect();
    degrees.push(90.0);
    let radians = |degrees: f64| (degrees, degrees.to_radians());
    degrees.into_iter().map(radians).collect()
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let config = self.config.unwrap_or("this mirror");
        let precision = if self.f32 { ", single precision" } else { "" };
        writeln!(f, "{config}, mapping {}{precision}: degrees", self.mapping)?;
        write!(f, "{:>12}{:>15}{:>15}", "", "r_d to θ", "θ to r_d")?;
        for (to_theta, to_place) in self.r_d_to_theta.iter().zip(&self.theta_to_r_d) {
            write!(
                f,
                "\n{:>12.3}{:>15.8}{:>15.8}",
                to_theta.r_d_deg, to_theta.theta_deg, to_place.r_d_deg
            )?;
        }
        Ok(())
    }
}
