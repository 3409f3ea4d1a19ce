//! `shisen spectrum`: the wavelengths that rays take, and their colours.

use crate::cli::medium::{NamedMedium, decimal, named_medium};
use crate::cli::prelude::*;
use crate::render::spectrum::{CIE_1931, Method};
use shisen_core::spectrum::{Matching, SpectralSample, SpectralTable, Wavelengths};

/// Says which wavelengths rays take, and the colour of each
#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// Number of wavelengths, from 1 to 64
    #[arg(long, value_name = "N", value_parser = whole::<u32>(1..=Wavelengths::MOST))]
    wavelengths: u32,
    /// How the wavelengths are chosen
    #[arg(long, value_enum, default_value = "comb")]
    method: MethodChoice,
    /// Range of the wavelengths in nanometres, from 360 to 830 [default: 400,700, or 380,750 with
    /// --method paper]
    #[arg(long, value_name = "NM", num_args = 1..=2, value_delimiter = ',',
          value_parser = number::<f32>)]
    range: Vec<f32>,
    /// Colour matching functions [default: wyman, or endo with --method paper]
    #[arg(long, value_enum)]
    matching: Option<MatchingChoice>,
    /// A medium of `shisen medium`, to whose known wavelengths --method paper keeps
    #[arg(long, value_name = "NAME", value_parser = named_medium)]
    medium: Option<NamedMedium>,
    /// Phase of a comb to show, from 0
    #[arg(long, value_name = "K", default_value_t = 0, value_parser = whole::<u32>(0..))]
    phase: u32,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum MethodChoice {
    /// The centres of equal parts of the range
    Fixed,
    /// The same, shifted from ray to ray
    Comb,
    /// As in Kishioka's paper, with a picture for each
    Paper,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum MatchingChoice {
    /// CIE 1931, fitted by Wyman, Sloan and Shirley
    Wyman,
    /// CIE 1931, from its table in steps of 5 nm
    Table,
    /// Endo's seven Gaussians
    Endo,
}

/// One phase of a table of wavelengths.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct Report {
    /// How the wavelengths were chosen: comb, fixed or paper.
    method: &'static str,
    /// Colour matching functions: wyman, table or endo.
    matching: &'static str,
    /// Range of the wavelengths, nanometres.
    range_nm: [f64; 2],
    /// The medium of --medium, or null.
    medium: Option<String>,
    /// Whether the medium's range is smaller than the range asked for.
    clamped: bool,
    /// Number of phases.
    phases: u32,
    /// The phase shown, from 0.
    phase: u32,
    /// Position of each wavelength in its part of the range, 0 to 1.
    offset: f64,
    /// Wavelengths, nanometres.
    wavelengths_nm: Vec<f64>,
    /// Red, green and blue of each wavelength.
    weights: Vec<[f64; 3]>,
    /// Largest distance of any phase's sum of weights from white, in any channel.
    white_error: f64,
}

pub(super) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let method = match arguments.method {
        MethodChoice::Fixed => Method::Fixed,
        MethodChoice::Comb => Method::Comb,
        MethodChoice::Paper => Method::Paper,
    };
    let range = match *arguments.range.as_slice() {
        [] => method.range(),
        [least, most] => [least, most],
        _ => {
            return Err(misuse!(
                "--range is one wavelength: give the shortest and the longest, such as 400,700"
            ));
        }
    };
    let asked = Wavelengths::new(arguments.wavelengths, range).or_misuse()?;
    let within = within_medium(arguments, method, asked)?;
    let matching = match arguments.matching {
        None => method.matching(),
        Some(MatchingChoice::Wyman) => Matching::Wyman,
        Some(MatchingChoice::Table) => Matching::Table(*CIE_1931),
        Some(MatchingChoice::Endo) => Matching::Endo,
    };
    let phases = method.phases();
    if arguments.phase >= phases {
        let (phase, name, last) = (arguments.phase, method.name(), phases - 1);
        return Err(misuse!(
            "--phase is {phase}: --method {name} has {phases}, give a number from 0 to {last}"
        ));
    }
    let mut storage = vec![SpectralSample::default(); SpectralTable::samples(within, phases)];
    let table = SpectralTable::new(within, phases, matching, &mut storage).or_fail()?;
    let shown = table.phase(arguments.phase);
    let weights = |sample: &SpectralSample| sample.weight.to_array().map(f64::from);
    let report = Report {
        method: method.name(),
        matching: match matching {
            Matching::Wyman => "wyman",
            Matching::Table(_) => "table",
            Matching::Endo => "endo",
        },
        range_nm: within.range().map(decimal),
        medium: arguments.medium.as_ref().map(|(name, _)| name.clone()),
        clamped: within != asked,
        phases,
        phase: arguments.phase,
        offset: table.offset(arguments.phase).into(),
        wavelengths_nm: shown.iter().map(|sample| sample.nm.into()).collect(),
        weights: shown.iter().map(weights).collect(),
        white_error: white_error(&table),
    };
    print(&report, arguments.json)
}

/// Returns the wavelengths at which the medium is known: the paper's method moves them there.
fn within_medium(
    arguments: &Arguments,
    method: Method,
    asked: Wavelengths,
) -> Result<Wavelengths, Failure> {
    let Some((name, medium)) = &arguments.medium else {
        return Ok(asked);
    };
    if method == Method::Paper {
        let within = asked.clamped_to(medium.range());
        return within.map_err(|error| misuse!("{name}: {error}"));
    }
    for nm in asked.range() {
        if let Err(error) = medium.index_in(nm) {
            return Err(misuse!("{name}: {error}: give a --range within it"));
        }
    }
    Ok(asked)
}

/// Returns the largest distance of any phase's sum from white.
fn white_error(table: &SpectralTable<'_>) -> f64 {
    let phases = (0..table.phases()).map(|phase| {
        let mut sum = [-1f64; 3];
        for sample in table.phase(phase) {
            for (sum, weight) in sum.iter_mut().zip(sample.weight.to_array()) {
                *sum += f64::from(weight);
            }
        }
        sum.map(f64::abs).into_iter().fold(0.0, f64::max)
    });
    phases.fold(0.0, f64::max)
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [least, most] = self.range_nm;
        let count = self.wavelengths_nm.len();
        write!(f, "{}: {count} from {least} to {most} nm", self.method)?;
        if let (true, Some(medium)) = (self.clamped, &self.medium) {
            write!(f, ", clamped to what {medium} is known for")?;
        }
        write!(f, ", colours by {}", self.matching)?;
        if self.phases > 1 {
            let (phase, phases, offset) = (self.phase, self.phases, self.offset);
            write!(f, "\nphase {phase} of {phases}: shifted by {offset} of ")?;
            write!(f, "the distance to the next wavelength")?;
        }
        f.write_str("\n        nm        red      green       blue")?;
        for (nm, [red, green, blue]) in self.wavelengths_nm.iter().zip(&self.weights) {
            write!(f, "\n{nm:>10.3}{red:>11.6}{green:>11.6}{blue:>11.6}")?;
        }
        match self.white_error {
            0.0 => write!(f, "\nsum: exactly white"),
            error => write!(f, "\nsum: at most {error:.1e} off white"),
        }
    }
}
