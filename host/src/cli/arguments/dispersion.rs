//! Arguments of commands whose pictures may have wavelengths.

use crate::bake::BakedScene;
use crate::cli::arguments::{Without, number, whole};
use crate::cli::output::failure::Failure;
use crate::cli::output::warn;
use crate::render::Options;
use crate::render::spectrum::{Dispersion, Method};
use clap::{Arg, Args, ValueEnum};
use serde::Serialize;
use shisen_core::scene::EffectSet;
use shisen_core::spectrum::{Medium, Wavelengths};

/// How many wavelengths, and which.
#[derive(Debug, Clone, Args)]
pub struct DispersionArguments {
    /// Wavelengths where the scene asks for dispersion, 1 to 64; 1 for none
    /// [default: 14]
    #[arg(long, value_name = "N",
          value_parser = whole::<u32>(1..=Wavelengths::MOST))]
    wavelengths: Option<u32>,
    /// How rays take them
    #[arg(long, value_name = "METHOD", value_enum, default_value = "comb")]
    dispersion: MethodChoice,
    /// Wavelengths that each ray of a comb takes: with several, edges without
    /// colours stay so with fewer rays a pixel [default: 1]
    #[arg(long, value_name = "N",
          value_parser = whole::<u8>(1..=Wavelengths::MOST as u8))]
    each: Option<u8>,
    /// The range that they are in, such as 400,700: nanometres, from 360 to 830
    /// [default: 400,700, or with --dispersion paper 380,750 as far as the media
    /// are known]
    #[arg(
        long,
        value_name = "LOW,HIGH",
        num_args = 1..=2,
        value_delimiter = ',',
        value_parser = number::<f32>
    )]
    range: Option<Vec<f32>>,
}

/// `--dispersion`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum MethodChoice {
    /// A ray takes one, or some, where it enters the glass, those of a pixel in
    /// turns
    Comb,
    /// The same, each ray all of them
    Split,
    /// As in Kishioka's paper: a picture each, of a part of the samples, at least
    /// one
    Paper,
    /// The same in the colours of the others
    Fixed,
}

/// The argument `--dispersion` of what is about one frame, in which no method has a place
/// that makes a picture of each wavelength.
pub fn in_one_frame(dispersion: Arg) -> Arg {
    dispersion.value_parser(Without::<MethodChoice>::new(&["paper", "fixed"]))
}

/// The argument `--range` beside that one.
pub fn range_in_one_frame(range: Arg) -> Arg {
    range.help(
        "The range that they are in, such as 400,700: nanometres, from 360 to 830 \
         [default: 400,700]",
    )
}

impl From<MethodChoice> for Method {
    fn from(choice: MethodChoice) -> Self {
        match choice {
            MethodChoice::Comb => Self::Comb,
            MethodChoice::Split => Self::Split,
            MethodChoice::Paper => Self::Paper,
            MethodChoice::Fixed => Self::Fixed,
        }
    }
}

/// Dispersion, for reports.
#[derive(Debug, Serialize)]
pub struct DispersionReport {
    /// `comb`, `split`, `paper` or `fixed`.
    method: &'static str,
    /// How many.
    wavelengths: usize,
    /// Of these, those that each ray takes, if not more because there are fewer
    /// rays a pixel than wavelengths.
    each: usize,
    /// That they are in.
    range_nm: [f32; 2],
}

impl DispersionArguments {
    /// Sets what they ask for, for a scene of which some effects are carried out;
    /// nothing to report where dispersion is not one of them.
    ///
    /// # Errors
    /// Of usage: a number or a range that cannot be, or at which a medium of
    /// the scene is not known.
    pub fn set(
        &self,
        baked: &BakedScene,
        options: &mut Options,
    ) -> Result<Option<DispersionReport>, Failure> {
        let method = Method::from(self.dispersion);
        let count = self.wavelengths.unwrap_or(Dispersion::WAVELENGTHS);
        let range = match self.range.as_deref() {
            Some(&[low, high]) => Some([low, high]),
            Some(_) => {
                return Err(Failure::usage(
                    "--range takes two numbers, the shortest and the longest wavelength in \
                     nanometres: such as 400,700",
                ));
            }
            None => None,
        };
        let usage = |error: &dyn std::error::Error| Failure::usage(&error.to_string());
        let mut dispersion = Dispersion::of(method, count, range).map_err(|error| usage(&error))?;
        if let Some(each) = self.each {
            if method != Method::Comb {
                return Err(Failure::usage(&format!(
                    "--each is for --dispersion comb, and this is --dispersion {}",
                    method.name()
                )));
            }
            if let Dispersion::Comb(wavelengths, of) = &mut dispersion {
                let count = wavelengths.count();
                if usize::from(each) > count {
                    return Err(Failure::usage(&format!(
                        "--each is {each}, and there are {count} wavelengths: give at most {count}, \
                         or more --wavelengths"
                    )));
                }
                *of = each;
            }
        }
        let asked = baked.effects();
        if dispersion == Dispersion::Off {
            options.effects = options.effects.less(EffectSet::DISPERSION);
        }
        let carried_out = options.effects.of(asked).intersection(asked);
        if !carried_out.contains(EffectSet::DISPERSION) {
            options.dispersion = dispersion;
            return Ok(None);
        }
        let media = baked.media();
        if let (Dispersion::Images(wavelengths, matching), None) = (dispersion, range) {
            let mut clamped = wavelengths;
            for known in media.iter().map(Medium::range) {
                clamped = clamped.clamped_to(known).map_err(|error| usage(&error))?;
            }
            if clamped != wavelengths {
                let [low, high] = clamped.range();
                warn(&format!(
                    "the media of the scene are known from {low} to {high} nm: the wavelengths \
                     keep to that"
                ));
            }
            dispersion = Dispersion::Images(clamped, matching);
        }
        if let Some(wavelengths) = dispersion.wavelengths() {
            check_known(media, wavelengths.range())?;
        }
        let each = match dispersion {
            Dispersion::Comb(_, each) => usize::from(each),
            _ => 1,
        };
        let report = dispersion
            .wavelengths()
            .map(|wavelengths| DispersionReport {
                method: method.name(),
                wavelengths: wavelengths.count(),
                each: each.min(wavelengths.count()),
                range_nm: wavelengths.range(),
            });
        options.dispersion = dispersion;
        Ok(report)
    }
}

/// Whether media are known over a whole range: nanometres.
///
/// # Errors
/// Of usage: one that is not.
fn check_known(media: &[Medium], [low, high]: [f32; 2]) -> Result<(), Failure> {
    for medium in media {
        let [from, to] = medium.range();
        if low < from || high > to {
            let named = Medium::NAMED.iter().find(|(_, known)| known == medium);
            let name = named.map_or("a medium of the scene file", |(name, _)| name);
            return Err(Failure::usage(&format!(
                "the wavelengths are {low} to {high} nm, but {name} is known from {from} to {to} \
                 nm: give a --range within"
            )));
        }
    }
    Ok(())
}
