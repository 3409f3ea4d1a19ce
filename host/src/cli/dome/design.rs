//! `shisen dome design`: the mirror that takes the truest dome master.

use super::arguments::MirrorArguments;
use crate::cli::prelude::*;
use crate::dome::Design;
use clap::Arg;

/// Designs the mirror that takes the truest dome master
#[derive(Debug, Args)]
#[command(mut_args(with_errors))]
pub(in crate::cli) struct Arguments {
    #[command(flatten)]
    mirror: MirrorArguments,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

fn with_errors(argument: Arg) -> Arg {
    if argument.get_id() != "mapping" {
        return argument;
    }
    argument.help("How pixels become directions. Only mirror has errors")
}

/// A mirror and its viewpoint. Lengths are in equatorial radii of the mirror.
#[derive(Debug, Serialize, JsonSchema)]
pub(in crate::cli) struct Report {
    /// Name of the mirror; null for a mirror by its shape.
    config: Option<&'static str>,
    /// How pixels become directions: mirror, exact or true.
    mapping: &'static str,
    /// parallel or perspective.
    projection: &'static str,
    #[serde(flatten)]
    design: Design,
    /// The camera's full field of view, degrees; only by perspective.
    #[serde(skip_serializing_if = "Option::is_none")]
    fov: Option<f64>,
    /// Width of the whole screen; only in parallel projection.
    #[serde(skip_serializing_if = "Option::is_none")]
    width: Option<f64>,
    /// Places of the largest differences to either side, degrees from the zenith.
    extrema: Vec<f64>,
}

pub(in crate::cli) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let Some(design) = arguments.mirror.design()? else {
        return Err(misuse!(
            "no mirror to design: give --projection parallel or perspective, or a mirror's name \
             with --config"
        ));
    };
    let mapping = arguments.mirror.mapping;
    let design = design.mapped(mapping);
    let (parallel, extrema) = (design.p.is_none(), design.extrema.iter());
    let report = Report {
        config: arguments.mirror.name(),
        mapping: mapping.name(),
        projection: if parallel { "parallel" } else { "perspective" },
        fov: (!parallel).then(|| design.field_of_view.to_degrees()),
        width: parallel.then_some(2.0 * design.b1),
        extrema: extrema.map(|one| one.r_d.to_degrees()).collect(),
        design,
    };
    print(&report, arguments.json)
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(config) = self.config {
            write!(f, "{config}: ")?;
        }
        writeln!(f, "{} projection", self.projection)?;
        let one = &self.design;
        for (name, value, meaning) in [
            ("a", Some(one.a), "polar by equatorial radius"),
            ("p", one.p, "viewpoint, from the mirror's centre"),
            ("c1", Some(one.c1), "screen, from the mirror's centre"),
            ("b1", Some(one.b1), "half the screen's width"),
            ("d1", one.d1, "from the viewpoint to the screen"),
            ("beta1", Some(one.beta1), "radians, the edge on the mirror"),
            ("fov", self.fov, "degrees, the camera's field of view"),
            ("width", self.width, "the camera's width of view"),
        ] {
            if let Some(value) = value {
                writeln!(f, "{name:<6}{value:>16.9}  {meaning}")?;
            }
        }
        write!(
            f,
            "error {:>16.9}  % of the picture's radius: {:.6} pixels at 4096, {}",
            one.error_percent,
            one.error_px_4096,
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
