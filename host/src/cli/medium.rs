//! `shisen medium`: how a medium bends light of each wavelength.

use crate::cli::prelude::*;
use crate::render::spectrum::{self, UnknownMedium};
use crate::scene::builtin::minimum_deviation;
use shisen_core::spectrum::{Medium, line};

/// Says how a clear medium bends light of each wavelength
#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// fused-silica, quartz-o, quartz-e (the ordinary and the extraordinary ray), n-bk7, sf11,
    /// diamond or water
    #[arg(value_name = "NAME", value_parser = named_medium)]
    medium: NamedMedium,
    /// Wavelengths, nanometres [default: the lines F, d and C]
    #[arg(long, value_name = "NM", num_args = 1.., value_delimiter = ',',
          value_parser = number::<f32>)]
    wavelength: Vec<f32>,
    /// Angle between the sides of a prism, degrees above 0 and below 180
    #[arg(long, value_name = "DEGREES", default_value_t = 60.0, value_parser = prism)]
    prism: f64,
    /// Move wavelengths outside the medium's range to its end instead of refusing them
    #[arg(long)]
    clamp: bool,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

/// A medium and its name.
pub(super) type NamedMedium = (String, Medium);

pub(super) fn named_medium(name: &str) -> Result<NamedMedium, UnknownMedium> {
    Ok((name.to_owned(), spectrum::medium(name)?))
}

fn prism(text: &str) -> Result<f64, String> {
    let number: Option<f64> = text.trim().parse().ok();
    number
        .filter(|&degrees| degrees > 0.0 && degrees < 180.0)
        .ok_or_else(|| "give degrees above 0 and below 180, such as 60".into())
}

/// A medium.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct Report {
    /// The medium's name.
    name: String,
    /// Range of wavelengths for which the medium is known, nanometres.
    range_nm: [f64; 2],
    /// Abbe number; null if the medium is not known at one of the lines F, d and C.
    abbe: Option<f64>,
    /// Angle between the sides of the prism, degrees.
    prism_deg: f64,
    /// Whether a wavelength was moved into the range.
    clamped: bool,
    /// What happens to light of each wavelength.
    wavelengths: Vec<Bent>,
}

#[derive(Debug, Serialize, JsonSchema)]
struct Bent {
    /// Wavelength, nanometres.
    nm: f64,
    /// Index of refraction.
    n: f64,
    /// Least angle by which the prism turns the light, degrees; null if it reflects all light.
    minimum_deviation_deg: Option<f64>,
}

pub(super) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let (name, medium) = &arguments.medium;
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
        let n = medium.index_in(nm);
        let n = n.map_err(|error| misuse!("{name}: {error}; --clamp moves it to the end"))?;
        let deviation = minimum_deviation(n.into(), arguments.prism.to_radians());
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

/// Returns the double with the same shortest decimal digits as a single.
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
        let turned = format!("turned by a {}° prism", self.prism_deg);
        write!(f, "\n{:>10}{:>12}{turned:>24}", "nm", "n")?;
        for bent in &self.wavelengths {
            write!(f, "\n{:>10}{:>12.7}", bent.nm, bent.n)?;
            let turned = bent.minimum_deviation_deg;
            let turned = turned.map_or("all reflected".to_owned(), |angle| format!("{angle:.5}°"));
            write!(f, "{turned:>24}")?;
        }
        Ok(())
    }
}
