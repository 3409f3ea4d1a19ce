//! `shisen dome map`: angles and their places in a dome master.

use super::arguments::MirrorArguments;
use crate::cli::prelude::*;
use crate::dome::px_4096;

/// Maps angles to places in the dome master and back
#[derive(Debug, Args)]
pub(in crate::cli) struct Arguments {
    #[command(flatten)]
    mirror: MirrorArguments,
    /// Distance from one row to the next, degrees from 0.001 to 90
    #[arg(long, value_name = "DEGREES", default_value_t = 10.0,
          value_parser = within(0.001..=90.0, "degrees from 0.001 to 90, such as 10"))]
    step: f64,
    /// Compute in the tracer's single precision
    #[arg(long)]
    f32: bool,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

/// Places and angles, from 0 to 90 degrees.
#[derive(Debug, Serialize, JsonSchema)]
pub(in crate::cli) struct Report {
    /// Name of the mirror; null for a mirror by its shape.
    config: Option<&'static str>,
    /// How pixels become directions: mirror, exact or true.
    mapping: &'static str,
    /// Whether the numbers are in single precision.
    f32: bool,
    /// Distance from one row to the next, degrees.
    step_deg: f64,
    /// The direction seen at each place.
    r_d_to_theta: Vec<Row>,
    /// The place of each direction.
    theta_to_r_d: Vec<Row>,
}

#[derive(Debug, Serialize, JsonSchema)]
struct Row {
    /// Distance from the picture's centre, degrees.
    r_d_deg: f64,
    /// Angle to the zenith, degrees.
    theta_deg: f64,
    /// The result less the given number, pixels of a picture of 4096 columns.
    error_px: f64,
}

pub(in crate::cli) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let design = arguments.mirror.design_or_first()?;
    let mapping = arguments.mirror.mapping;
    let mirror = &design.mirror;
    let single = arguments.f32.then(|| mirror.single());
    let single = single.transpose().or_misuse()?;
    let theta = |angle: f64| match &single {
        Some(mirror) => mapping.single_theta(mirror, angle as f32).map(f64::from),
        None => Some(mapping.theta(mirror, angle)),
    };
    let r_d = |angle: f64| match &single {
        Some(mirror) => mapping.single_r_d(mirror, angle as f32).map(f64::from),
        None => Some(mapping.r_d(mirror, angle)),
    };
    let angles = angles(arguments.step);
    let to_theta = |&(degrees, angle): &(f64, f64)| {
        let theta = theta(angle)?;
        Some(Row {
            r_d_deg: degrees,
            theta_deg: theta.to_degrees(),
            error_px: px_4096(theta - angle),
        })
    };
    let to_place = |&(degrees, angle): &(f64, f64)| {
        let r_d = r_d(angle)?;
        Some(Row {
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

/// Degrees and radians from 0 to 90°, which is always the last. Radians are at most π/2 in single
/// precision, too.
fn angles(step: f64) -> Vec<(f64, f64)> {
    // Multiples of the step are rounded.
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
