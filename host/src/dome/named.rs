use super::design::best_viewpoint;
use super::mirror::{Mirror, Projection};

/// The named mirrors.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Named {
    /// Table 1 (1): parallel projection, a = 1.288.
    Paper1,
    /// Table 1 (2): perspective, a sphere, from the viewpoint that the table rounds to 1.277.
    Paper2,
    /// Table 1 (3): perspective, a = 2.35, from the viewpoint that the table rounds to 3.374.
    Paper3,
    /// The least error by parallel projection.
    BestParallel,
    /// The least error of all.
    Best,
}

named!(Named {
    Paper1 => "paper-1",
    Paper2 => "paper-2",
    Paper3 => "paper-3",
    BestParallel => "best-parallel",
    Best => "best",
});

/// The axis ratios that [`best`](super::best) finds.
const BEST_PARALLEL: f64 = 1.288_248_331_186;
const BEST: f64 = 4.504_149_71;

impl Named {
    /// Returns the mirror, with its exact viewpoint.
    pub fn mirror(self) -> Mirror {
        let (a, projection) = match self {
            Self::Paper1 => (1.288, Projection::Parallel),
            Self::Paper2 => (1.0, Projection::Perspective),
            Self::Paper3 => (2.35, Projection::Perspective),
            Self::BestParallel => (BEST_PARALLEL, Projection::Parallel),
            Self::Best => (BEST, Projection::Perspective),
        };
        best_viewpoint(a, projection).mirror
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Design, best};
    use super::*;
    use shisen_core::capture::SpheroidMirror;

    #[test]
    fn the_papers_viewpoints_are_rounded_to_its_table() {
        for (named, row) in [
            (Named::Paper1, "1.288 1.017 -"),
            (Named::Paper2, "1.000 0.930 1.277"),
            (Named::Paper3, "2.350 2.235 3.374"),
        ] {
            let Design { a, c1, p, .. } = Design::of(named.mirror());
            let p = p.map_or("-".to_owned(), |p| format!("{p:.3}"));
            assert_eq!(format!("{a:.3} {c1:.3} {p}"), row);
        }
    }

    #[test]
    fn single_precision_has_the_same_mirrors_and_the_solver_finds_the_best() {
        let singles = [
            SpheroidMirror::PAPER_PARALLEL,
            SpheroidMirror::PAPER_SPHERE,
            SpheroidMirror::PAPER_SPHEROID,
            SpheroidMirror::BEST_PARALLEL,
            SpheroidMirror::BEST,
        ];
        assert_eq!(Named::ALL.map(|one| one.mirror().single()), singles.map(Ok));
        for (named, projection) in [
            (Named::BestParallel, Projection::Parallel),
            (Named::Best, Projection::Perspective),
        ] {
            let (named, found) = (Design::of(named.mirror()), best(projection));
            assert!((named.a - found.a).abs() < 1.0e-8, "{named:?} {found:?}");
        }
    }
}
