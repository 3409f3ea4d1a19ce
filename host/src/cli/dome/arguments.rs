//! Arguments that the commands of domes share.

use crate::cli::arguments::number;
use crate::cli::output::failure::Failure;
use crate::dome::{self, Design, Mapping, Mirror, MirrorError, Named, Projection};
use clap::builder::PossibleValue;
use clap::{Args, ValueEnum};

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

/// `--projection`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum ProjectionChoice {
    /// From infinity
    Parallel,
    /// From a viewpoint
    Perspective,
}

impl From<ProjectionChoice> for Projection {
    fn from(choice: ProjectionChoice) -> Self {
        match choice {
            ProjectionChoice::Parallel => Self::Parallel,
            ProjectionChoice::Perspective => Self::Perspective,
        }
    }
}

/// The name of a projection in reports.
pub(super) const fn projection_name(design: &Design) -> &'static str {
    match design.p {
        None => "parallel",
        Some(_) => "perspective",
    }
}

/// Which mirror: by its name or by its shape.
#[derive(Debug, Args)]
pub(super) struct MirrorArguments {
    /// A mirror of the paper's Table 1, or the best there is
    #[arg(long, value_name = "NAME", value_enum,
          conflicts_with_all = ["projection", "a", "p", "beta1"])]
    config: Option<ConfigChoice>,
    /// The least error by a projection, or by a projection under --a
    #[arg(long, value_enum)]
    projection: Option<ProjectionChoice>,
    /// Polar by equatorial radius of the mirror, from 0.01 to 100
    #[arg(
        long,
        value_name = "RATIO",
        requires = "projection",
        allow_hyphen_values = true,
        value_parser = number::<f64>
    )]
    a: Option<f64>,
    /// Viewpoint from the mirror's centre, equatorial radii, above --a
    #[arg(
        long,
        value_name = "RADII",
        requires = "a",
        conflicts_with = "beta1",
        allow_hyphen_values = true,
        value_parser = number::<f64>
    )]
    p: Option<f64>,
    /// Parametric angle of the mirror at the dome's rim, in place of --p: from
    /// 0.001 to atan(1/a), which is parallel projection
    #[arg(
        long,
        value_name = "RADIANS",
        requires = "a",
        allow_hyphen_values = true,
        value_parser = number::<f64>
    )]
    beta1: Option<f64>,
}

impl MirrorArguments {
    /// What they ask for, if anything.
    ///
    /// # Errors
    /// Of usage, where there is no such mirror.
    pub(super) fn design(&self) -> Result<Option<Design>, Failure> {
        let no_mirror = |error: MirrorError| Failure::usage(&error.to_string());
        if let Some(ConfigChoice(named)) = self.config {
            return Ok(Some(Design::of(named.mirror())));
        }
        let Some(projection) = self.projection.map(Projection::from) else {
            return Ok(None);
        };
        let Some(a) = self.a else {
            return Ok(Some(dome::best(projection)));
        };
        for (name, given) in [("--p", self.p), ("--beta1", self.beta1)] {
            if let (Projection::Parallel, Some(given)) = (projection, given) {
                return Err(Failure::usage(&format!(
                    "{name} is {given}: parallel projection has no viewpoint to choose, leave \
                     {name} out or give --projection perspective"
                )));
            }
        }
        let mirror = match (self.p, self.beta1) {
            (Some(p), _) => Mirror::perspective(a, p),
            (None, Some(beta1)) => Mirror::from_edge(a, beta1),
            (None, None) => dome::optimum(a, projection).map(|design| design.mirror),
        };
        Ok(Some(Design::of(mirror.map_err(no_mirror)?)))
    }

    /// The same, or Table 1 (1), which the paper's figures 18 to 20 show.
    ///
    /// # Errors
    /// As [`design`](Self::design).
    pub(super) fn design_or_first(&self) -> Result<Design, Failure> {
        let first = || Design::of(Named::Paper1.mirror());
        Ok(self.design()?.unwrap_or_else(first))
    }

    /// The name that was given; none for a mirror by its shape.
    pub(super) fn name(&self) -> Option<&'static str> {
        match (self.config, self.projection) {
            (Some(ConfigChoice(named)), _) => Some(named.name()),
            (None, None) => Some(Named::Paper1.name()),
            (None, Some(_)) => None,
        }
    }
}
