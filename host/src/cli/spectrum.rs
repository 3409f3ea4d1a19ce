//! `shisen spectrum`: the wavelengths that rays take, and their colours.

use crate::cli::arguments::{number, whole};
use crate::cli::medium::{NamedMedium, decimal};
use crate::cli::output::failure::Failure;
use crate::cli::output::print;
use crate::render::spectrum::{CIE_1931, Method};
use clap::builder::PossibleValue;
use clap::{Args, ValueEnum};
use serde::Serialize;
use shisen_core::spectrum::{Matching, SpectralSample, SpectralTable, Wavelengths};
use std::fmt;

/// Says which wavelengths rays take, and what light of each counts for
///
/// The weights are linear sRGB, negative where the display cannot show so pure
/// a colour, and sum to its white. A comb's wavelengths are all shifted alike,
/// from ray to ray by another part of the way from one to the next; each of its
/// phases is one such shift, with weights of its own that sum to white.
///
/// With --json, one object: method, matching, `range_nm`, medium (null without
/// --medium), clamped (whether the medium's range is in the way), phases, phase
/// (the one shown), offset (where in their n equal parts of the range the
/// wavelengths are, 0 to 1), `wavelengths_nm`, weights (red, green and blue of
/// each) and `white_error` (the most that the sum of any phase's weights is off
/// the white, in any channel).
#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// How many, from 1 to 64
    #[arg(long, value_name = "N", value_parser = whole::<u32>(1..=Wavelengths::MOST))]
    wavelengths: u32,
    /// How they are chosen
    #[arg(long, value_enum, default_value = "comb")]
    method: MethodChoice,
    /// The range that they are in, such as 400,700: nanometres, from 360 to 830
    /// [default: 400,700, or 380,750 with --method paper]
    #[arg(long, value_name = "NM", num_args = 1..=2, value_delimiter = ',',
          value_parser = number::<f32>)]
    range: Vec<f32>,
    /// The colour of each [default: wyman, or endo with --method paper]
    #[arg(long, value_enum)]
    matching: Option<MatchingChoice>,
    /// A medium that is known for none but some wavelengths, see `shisen
    /// medium`: --method paper keeps to these
    #[arg(long, value_name = "NAME", value_parser = NamedMedium::parser())]
    medium: Option<NamedMedium>,
    /// Which phase of a comb to show, from 0
    #[arg(long, value_name = "K", default_value_t = 0, value_parser = whole::<u32>(0..))]
    phase: u32,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

/// `--method`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct MethodChoice(Method);

impl ValueEnum for MethodChoice {
    fn value_variants<'a>() -> &'a [Self] {
        &[Self(Method::Fixed), Self(Method::Comb), Self(Method::Paper)]
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        let help = match self.0 {
            Method::Fixed => "The centres of equal parts of the range",
            Method::Comb | Method::Split => "The same, shifted from ray to ray",
            Method::Paper => "As in Kishioka's paper, an image each",
        };
        Some(PossibleValue::new(self.0.name()).help(help))
    }
}

/// `--matching`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum MatchingChoice {
    /// CIE 1931 by Wyman, Sloan and Shirley's fit
    Wyman,
    /// CIE 1931 by its table of 5 nm
    Table,
    /// Endo's seven Gaussians
    Endo,
}

impl From<MatchingChoice> for Matching<'static> {
    fn from(choice: MatchingChoice) -> Self {
        match choice {
            MatchingChoice::Wyman => Self::Wyman,
            MatchingChoice::Table => Self::Table(CIE_1931),
            MatchingChoice::Endo => Self::Endo,
        }
    }
}

/// The name of colours in reports.
const fn matching_name(matching: Matching<'_>) -> &'static str {
    match matching {
        Matching::Wyman => "wyman",
        Matching::Table(_) => "table",
        Matching::Endo => "endo",
    }
}

/// A phase of a table.
#[derive(Debug, Serialize)]
struct Report {
    method: &'static str,
    matching: &'static str,
    range_nm: [f64; 2],
    medium: Option<String>,
    clamped: bool,
    phases: u32,
    phase: u32,
    offset: f64,
    wavelengths_nm: Vec<f64>,
    weights: Vec<[f64; 3]>,
    white_error: f64,
}

/// Runs the command.
pub(super) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let MethodChoice(method) = arguments.method;
    let asked = wavelengths(arguments, method)?;
    let within = within_medium(arguments, method, asked)?;
    let matching = arguments.matching.map_or(method.matching(), Matching::from);
    let phases = method.phases();
    if arguments.phase >= phases {
        return Err(Failure::usage(&format!(
            "--phase is {}: --method {} has {phases}, give a number from 0 to {}",
            arguments.phase,
            method.name(),
            phases - 1
        )));
    }
    let mut storage = vec![SpectralSample::default(); SpectralTable::samples(within, phases)];
    let table =
        SpectralTable::new(within, phases, matching, &mut storage).map_err(Failure::from_error)?;
    let shown = table.phase(arguments.phase);
    let weights = |sample: &SpectralSample| sample.weight.to_array().map(f64::from);
    let report = Report {
        method: method.name(),
        matching: matching_name(matching),
        range_nm: within.range().map(decimal),
        medium: arguments.medium.as_ref().map(|named| named.name.clone()),
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

/// Those asked for.
fn wavelengths(arguments: &Arguments, method: Method) -> Result<Wavelengths, Failure> {
    let range = match *arguments.range.as_slice() {
        [] => method.range(),
        [least, most] => [least, most],
        _ => {
            return Err(Failure::usage(
                "--range is one wavelength: give the least and the greatest, such as 400,700",
            ));
        }
    };
    Wavelengths::new(arguments.wavelengths, range)
        .map_err(|error| Failure::usage(&error.to_string()))
}

/// As many where the medium is known: the paper's method moves them there.
fn within_medium(
    arguments: &Arguments,
    method: Method,
    asked: Wavelengths,
) -> Result<Wavelengths, Failure> {
    let Some(NamedMedium { name, medium }) = &arguments.medium else {
        return Ok(asked);
    };
    if method == Method::Paper {
        let within = asked.clamped_to(medium.range());
        return within.map_err(|error| Failure::usage(&format!("{name}: {error}")));
    }
    for nm in asked.range() {
        if let Err(error) = medium.index_in(nm) {
            return Err(Failure::usage(&format!(
                "{name}: {error}: give a --range within it"
            )));
        }
    }
    Ok(asked)
}

/// The most that any phase is off the white.
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
        write!(f, "{}: {count} of {least} to {most} nm", self.method)?;
        if let (true, Some(medium)) = (self.clamped, &self.medium) {
            write!(f, ", clamped to what {medium} is known for")?;
        }
        write!(f, ", colours by {}", self.matching)?;
        if self.phases > 1 {
            write!(
                f,
                "\nphase {} of {}: shifted by {} of the way from one to the next",
                self.phase, self.phases, self.offset
            )?;
        }
        write!(
            f,
            "\n{:>10}{:>11}{:>11}{:>11}",
            "nm", "red", "green", "blue"
        )?;
        for (nm, [red, green, blue]) in self.wavelengths_nm.iter().zip(&self.weights) {
            write!(f, "\n{nm:>10.3}{red:>11.6}{green:>11.6}{blue:>11.6}")?;
        }
        match self.white_error {
            0.0 => write!(f, "\nsum: white, exactly"),
            error => write!(f, "\nsum: off the white by {error:.1e} at most"),
        }
    }
}
