//! `shisen medium`: how a medium bends light of each wavelength.

use crate::cli::arguments::number;
use crate::cli::output::failure::Failure;
use crate::cli::output::print;
use crate::render::spectrum::{self, UnknownMedium};
use clap::Args;
use clap::builder::{StringValueParser, TypedValueParser};
use serde::Serialize;
use shisen_core::spectrum::{Medium, line};
use std::fmt;

/// Says how a clear medium bends light of each wavelength
///
/// Indices of refraction are those that the tracer has, in single precision. A
/// prism turns light least where it passes symmetrically; where that angle is
/// missing, the prism reflects all of the light.
///
/// With --json, one object: name, `range_nm` (the least and the greatest
/// wavelength that the medium is known for), abbe (Abbe's number, null where
/// the medium is not known at one of the lines F, d and C), `prism_deg`, clamped
/// (whether a wavelength was moved into the range) and wavelengths: nm, n (the
/// index of refraction) and `minimum_deviation_deg` (null where all light is
/// reflected) each.
#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// fused-silica, quartz-o, quartz-e (the ordinary and the extraordinary
    /// ray), n-bk7, sf11, diamond or water
    #[arg(value_name = "NAME", value_parser = NamedMedium::parser())]
    medium: NamedMedium,
    /// Wavelengths: nanometres [default: the lines F, d and C]
    #[arg(long, value_name = "NM", num_args = 1.., value_delimiter = ',',
          value_parser = number::<f32>)]
    wavelength: Vec<f32>,
    /// Angle between the sides of a prism: degrees, above 0 and below 180
    #[arg(long, value_name = "DEGREES", default_value_t = 60.0,
          value_parser = prism)]
    prism: f64,
    /// Take wavelengths outside the medium's range at its end instead of
    /// refusing them
    #[arg(long)]
    clamp: bool,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

/// A built-in medium and its name.
#[derive(Debug, Clone)]
pub(super) struct NamedMedium {
    pub(super) name: String,
    pub(super) medium: Medium,
}

impl NamedMedium {
    /// Any text that is a name.
    pub(super) fn parser() -> impl TypedValueParser<Value = Self> {
        StringValueParser::new().try_map(|name| {
            let medium = spectrum::medium(&name)?;
            Ok::<Self, UnknownMedium>(Self { name, medium })
        })
    }
}

fn prism(text: &str) -> Result<f64, String> {
    let number: Option<f64> = text.trim().parse().ok();
    number
        .filter(|&degrees| degrees > 0.0 && degrees < 180.0)
        .ok_or_else(|| "give degrees above 0 and below 180, such as 60".into())
}

/// A medium.
#[derive(Debug, Serialize)]
struct Report {
    name: String,
    range_nm: [f64; 2],
    abbe: Option<f64>,
    prism_deg: f64,
    clamped: bool,
    wavelengths: Vec<Bent>,
}

/// Light of a wavelength in it.
#[derive(Debug, Serialize)]
struct Bent {
    nm: f64,
    n: f64,
    minimum_deviation_deg: Option<f64>,
}

/// Runs the command.
pub(super) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let NamedMedium { name, medium } = &arguments.medium;
    let [least, most] = medium.range();
    let asked = match arguments.wavelength.as_slice() {
        [] => &[line::F, line::D, line::C],
        asked => asked,
    };
    let mut clamped = false;
    let bent = |&asked: &f32| {
        let nm = if arguments.clamp && !asked.is_nan() {
            asked.clamp(least, most)
        } else {
            asked
        };
        clamped |= nm != asked;
        let n = medium.index_in(nm).map_err(|error| {
            Failure::usage(&format!("{name}: {error}; --clamp takes it at the end"))
        })?;
        let deviation = spectrum::minimum_deviation(n.into(), arguments.prism.to_radians());
        Ok::<_, Failure>(Bent {
            nm: decimal(nm),
            n: n.into(),
            minimum_deviation_deg: deviation.map(f64::to_degrees),
        })
    };
    let wavelengths = asked.iter().map(bent).collect::<Result<_, _>>()?;
    let report = Report {
        name: name.clone(),
        range_nm: medium.range().map(decimal),
        abbe: medium.abbe().map(f64::from),
        prism_deg: arguments.prism,
        clamped,
        wavelengths,
    };
    print(&report, arguments.json)
}

/// The number as it was written, not as it was rounded.
pub(super) fn decimal(single: f32) -> f64 {
    single.to_string().parse().unwrap_or(f64::from(single))
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [least, most] = self.range_nm;
        write!(f, "{}: {least} to {most} nm", self.name)?;
        if let Some(abbe) = self.abbe {
            write!(f, ", Abbe number {abbe:.3}")?;
        }
        if self.clamped {
            write!(f, ", wavelengths moved into this range")?;
        }
        write!(
            f,
            "\n{:>10}{:>12}{:>24}",
            "nm",
            "n",
            format!("turned by a {}° prism", self.prism_deg)
        )?;
        for bent in &self.wavelengths {
            write!(f, "\n{:>10}{:>12.7}", bent.nm, bent.n)?;
            match bent.minimum_deviation_deg {
                Some(degrees) => write!(f, "{:>24}", format!("{degrees:.5}°"))?,
                None => write!(f, "{:>24}", "all reflected")?,
            }
        }
        Ok(())
    }
}
