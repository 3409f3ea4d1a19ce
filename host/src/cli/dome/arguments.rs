//! Arguments that the dome commands share.

use crate::cli::arguments::choices;
use crate::cli::prelude::*;
use crate::dome::{self, Design, Mapping, Mirror, Named, Projection};

choices!(Named {
    Paper1 => "Parallel projection, a = 1.288",
    Paper2 => "Perspective, a sphere",
    Paper3 => "Perspective, a = 2.35",
    BestParallel => "The least error in parallel projection",
    Best => "The least error of all",
});

choices!(Mapping {
    Mirror => "What the mirror shows, as in the paper",
    Exact => "The mirror's point that reflects the pixel's direction",
    True => "No mirror: an equidistant fisheye",
});

choices!(Projection {
    Parallel => "The viewpoint is at infinity",
    Perspective => "The viewpoint is near the mirror",
});

#[derive(Debug, Args)]
pub(super) struct MirrorArguments {
    /// Mirror of the paper's Table 1, or the best one
    #[arg(long, value_name = "NAME", value_enum,
          conflicts_with_all = ["projection", "a", "p", "beta1"])]
    config: Option<Named>,
    /// Projection, for the mirror of the least error, with --a of the least error for that shape
    #[arg(long, value_enum)]
    projection: Option<Projection>,
    /// Polar by equatorial radius of the mirror, from 0.01 to 100
    #[arg(long, value_name = "RATIO", requires = "projection", allow_hyphen_values = true,
          value_parser = number::<f64>)]
    a: Option<f64>,
    /// Viewpoint from the mirror's centre, equatorial radii, above --a
    #[arg(long, value_name = "RADII", requires = "a", conflicts_with = "beta1",
          allow_hyphen_values = true, value_parser = number::<f64>)]
    p: Option<f64>,
    /// Parametric angle of the mirror at the dome's rim, in place of --p, from 0.001 to atan(1/a),
    /// which is parallel projection
    #[arg(long, value_name = "RADIANS", requires = "a", allow_hyphen_values = true,
          value_parser = number::<f64>)]
    beta1: Option<f64>,
    /// How pixels become directions
    #[arg(long, value_enum, default_value = "mirror")]
    pub(super) mapping: Mapping,
}

impl MirrorArguments {
    /// Returns the mirror that is asked for, if any.
    pub(super) fn design(&self) -> Result<Option<Design>, Failure> {
        if let Some(named) = self.config {
            return Ok(Some(Design::of(named.mirror())));
        }
        let Some(projection) = self.projection else {
            return Ok(None);
        };
        let Some(a) = self.a else {
            return Ok(Some(dome::best(projection)));
        };
        for (name, given) in [("--p", self.p), ("--beta1", self.beta1)] {
            if let (Projection::Parallel, Some(given)) = (projection, given) {
                return Err(misuse!(
                    "{name} is {given}: parallel projection has no viewpoint to choose, leave \
                     {name} out or give --projection perspective"
                ));
            }
        }
        let mirror = match (self.p, self.beta1) {
            (Some(p), _) => Mirror::perspective(a, p),
            (None, Some(beta1)) => Mirror::from_edge(a, beta1),
            (None, None) => dome::optimum(a, projection).map(|design| design.mirror),
        };
        Ok(Some(Design::of(mirror.or_misuse()?)))
    }

    /// Returns the mirror that is asked for, or else Table 1 (1), that of the paper's figures 18 to
    /// 20.
    pub(super) fn design_or_first(&self) -> Result<Design, Failure> {
        let first = || Design::of(Named::Paper1.mirror());
        Ok(self.design()?.unwrap_or_else(first))
    }

    /// Returns the mirror's name; `None` for a mirror by its shape.
    pub(super) fn name(&self) -> Option<&'static str> {
        match (self.config, self.projection) {
            (Some(named), _) => Some(named.name()),
            (None, None) => Some(Named::Paper1.name()),
            (None, Some(_)) => None,
        }
    }
}
