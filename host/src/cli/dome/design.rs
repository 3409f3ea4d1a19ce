//! `shisen dome design`: the mirror that takes the truest dome master.

use super::arguments::{MappingChoice, MirrorArguments, projection_name};
use crate::cli::prelude::*;
use crate::dome::{Design, Mapping};

/// Designs the mirror that takes the truest dome master
#[derive(Debug, Args)]
pub(in crate::cli) struct Arguments {
    #[command(flatten)]
    mirror: MirrorArguments,
    /// How pixels become directions. Only mirror has errors
    #[arg(long, value_enum, default_value = "mirror")]
    mapping: MappingChoice,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
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
    /// Polar by equatorial radius.
    a: f64,
    /// Viewpoint from the mirror's centre; null in parallel projection.
    p: Option<f64>,
    /// Screen from the mirror's centre.
    c1: f64,
    /// Half the width of the screen.
    b1: f64,
    /// Distance from the viewpoint to the screen; null in parallel projection.
    d1: Option<f64>,
    /// Parametric angle of the mirror at the dome's rim, radians.
    beta1: f64,
    /// The camera's full field of view, degrees; only by perspective.
    #[serde(skip_serializing_if = "Option::is_none")]
    fov: Option<f64>,
    /// Width of the whole screen; only in parallel projection.
    #[serde(skip_serializing_if = "Option::is_none")]
    width: Option<f64>,
    /// Largest difference between angle and place, percent of the picture's radius.
    error_percent: f64,
    /// The same, pixels of a picture of 4096 columns.
    error_px_4096: f64,
    /// Places of the largest differences to either side, degrees from the zenith.
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

pub(in crate::cli) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let Some(design) = arguments.mirror.design()? else {
        return Err(misuse!(
            "no mirror to design: give --projection parallel or perspective, or a mirror's name \
             with --config"
        ));
    };
    let config = arguments.mirror.name();
    let MappingChoice(mapping) = arguments.mapping;
    let report = Report::of(&design.mapped(mapping), config, mapping);
    print(&report, arguments.json)
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(config) = self.config {
            write!(f, "{config}: ")?;
        }
        writeln!(f, "{} projection", self.projection)?;
        for (name, value, meaning) in [
            ("a", Some(self.a), "polar by equatorial radius"),
            ("p", self.p, "viewpoint, from the mirror's centre"),
            ("c1", Some(self.c1), "screen, from the mirror's centre"),
            ("b1", Some(self.b1), "half the screen's width"),
            ("d1", self.d1, "from the viewpoint to the screen"),
            ("beta1", Some(self.beta1), "radians, the edge on the mirror"),
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
