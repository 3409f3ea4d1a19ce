//! Arguments of commands whose pictures may have wavelengths.

use crate::cli::arguments::{choices, without};
use crate::cli::prelude::*;
use crate::render::Options;
use crate::render::spectrum::{Dispersion, Method};
use clap::Arg;
use shisen_core::scene::EffectSet;
use shisen_core::spectrum::{Medium, Wavelengths};

#[derive(Debug, Clone, Args)]
pub struct DispersionArguments {
    /// Number of wavelengths, if the scene asks for dispersion: 1 to 64, 1 for no dispersion
    /// [default: 14]
    #[arg(long, value_name = "N", value_parser = whole::<u32>(1..=Wavelengths::MOST))]
    wavelengths: Option<u32>,
    /// How rays take the wavelengths
    #[arg(long, value_name = "METHOD", value_enum, default_value = "comb")]
    dispersion: Method,
    /// Wavelengths that each ray of a comb takes. With several, edges without colours stay
    /// colourless with fewer rays a pixel [default: 1]
    #[arg(long, value_name = "N", value_parser = whole::<u8>(1..=Wavelengths::MOST as u8))]
    each: Option<u8>,
    /// Range of the wavelengths in nanometres, from 360 to 830 [default: 400,700, or with
    /// --dispersion paper 380,750 as far as the media are known]
    #[arg(long, value_name = "LOW,HIGH", num_args = 1..=2, value_delimiter = ',',
          value_parser = number::<f32>)]
    range: Option<Vec<f32>>,
}

choices!(Method {
    Comb => "A ray takes one or some where it enters glass, those of a pixel in turns",
    Split => "Each ray takes all of them where it enters glass",
    Paper => "As in Kishioka's paper: a picture for each, with a part of the samples",
    Fixed => "As paper, in the colours of the other methods",
});

/// `--dispersion` for commands that render one frame: without the methods that render a picture
/// for each wavelength.
pub fn in_one_frame(dispersion: Arg) -> Arg {
    dispersion.value_parser(without::<Method>(&["paper", "fixed"]))
}

/// `--range` for the same commands.
pub fn range_in_one_frame(range: Arg) -> Arg {
    range.help("Range of the wavelengths in nanometres, from 360 to 830 [default: 400,700]")
}

/// Dispersion, for reports.
#[derive(Debug, Serialize, JsonSchema)]
pub struct DispersionReport {
    /// comb, split, paper or fixed.
    method: &'static str,
    /// Number of wavelengths.
    wavelengths: usize,
    /// Wavelengths that each ray takes; more where a pixel has fewer rays than wavelengths.
    each: usize,
    /// Range of the wavelengths, nanometres.
    range_nm: [f32; 2],
}

impl DispersionArguments {
    /// Sets the options for a scene; `None` if its dispersion is not rendered.
    pub fn set(
        &self,
        baked: &BakedScene,
        options: &mut Options,
    ) -> Result<Option<DispersionReport>, Failure> {
        let method = self.dispersion;
        let count = self.wavelengths.unwrap_or(Dispersion::WAVELENGTHS);
        let range = match self.range.as_deref() {
            Some(&[low, high]) => Some([low, high]),
            Some(_) => {
                return Err(misuse!(
                    "--range takes two numbers, the shortest and the longest wavelength in \
                     nanometres, such as 400,700"
                ));
            }
            None => None,
        };
        let mut dispersion = Dispersion::of(method, count, range).or_misuse()?;
        if let Some(each) = self.each {
            if method != Method::Comb {
                let name = method.name();
                return Err(misuse!("--each is for --dispersion comb, not for {name}"));
            }
            if let Dispersion::Comb(wavelengths, of) = &mut dispersion {
                let count = wavelengths.count();
                if usize::from(each) > count {
                    return Err(misuse!(
                        "--each is {each}, and there are {count} wavelengths: give at most {count}, \
                         or more --wavelengths"
                    ));
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
                clamped = clamped.clamped_to(known).or_misuse()?;
            }
            if clamped != wavelengths {
                let [low, high] = clamped.range();
                warn(&format!(
                    "the scene's media are known from {low} to {high} nm: wavelengths are taken \
                     from this range"
                ));
            }
            dispersion = Dispersion::Images(clamped, matching);
        }
        options.dispersion = dispersion;
        let Some(wavelengths) = dispersion.wavelengths() else {
            return Ok(None);
        };
        check_known(media, wavelengths.range())?;
        let each = match dispersion {
            Dispersion::Comb(_, each) => usize::from(each),
            _ => 1,
        };
        Ok(Some(DispersionReport {
            method: method.name(),
            wavelengths: wavelengths.count(),
            each: each.min(wavelengths.count()),
            range_nm: wavelengths.range(),
        }))
    }
}

/// Checks that all media are known over a range, nanometres.
fn check_known(media: &[Medium], [low, high]: [f32; 2]) -> Result<(), Failure> {
    for medium in media {
        let [from, to] = medium.range();
        if low < from || high > to {
            let named = Medium::NAMED.iter().find(|(_, known)| known == medium);
            let name = named.map_or("a medium of the scene file", |(name, _)| name);
            return Err(misuse!(
                "the wavelengths are {low} to {high} nm, but {name} is known from {from} to {to} \
                 nm: give a --range within"
            ));
        }
    }
    Ok(())
}
