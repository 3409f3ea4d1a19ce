//! Arguments that the commands of domes share.

use clap::ValueEnum;
use clap::builder::PossibleValue;
use shisen::dome::{Mapping, Named};

/// `--config`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::cli) struct ConfigChoice(pub(in crate::cli) Named);

impl ValueEnum for ConfigChoice {
    fn value_variants<'a>() -> &'a [Self] {
        &[
            Self(Named::Paper1),
            Self(Named::Paper2),
            Self(Named::Paper3),
            Self(Named::BestParallel),
            Self(Named::Best),
        ]
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        let help = match self.0 {
            Named::Paper1 => "Parallel projection, a = 1.288",
            Named::Paper2 => "Perspective, a sphere",
            Named::Paper3 => "Perspective, a = 2.35",
            Named::BestParallel => "The least error by parallel projection",
            Named::Best => "The least error of all",
        };
        Some(PossibleValue::new(self.0.name()).help(help))
    }
}

/// `--mapping`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::cli) struct MappingChoice(pub(in crate::cli) Mapping);

impl ValueEnum for MappingChoice {
    fn value_variants<'a>() -> &'a [Self] {
        &[
            Self(Mapping::Mirror),
            Self(Mapping::Exact),
            Self(Mapping::True),
        ]
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        let help = match self.0 {
            Mapping::Mirror => "What the mirror shows, as in the paper",
            Mapping::Exact => "The mirror's point whose direction is the pixel's",
            Mapping::True => "No mirror, an equidistant fisheye",
        };
        Some(PossibleValue::new(self.0.name()).help(help))
    }
}
