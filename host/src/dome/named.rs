use shisen_core::capture::SpheroidMirror;

/// A mirror that has a name.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Named {
    /// Table 1 (1): parallel projection, a = 1.288.
    Paper1,
    /// Table 1 (2): perspective, a sphere, from the viewpoint that the table
    /// rounds to 1.277.
    Paper2,
    /// Table 1 (3): perspective, a = 2.35, from the viewpoint that the table
    /// rounds to 3.374.
    Paper3,
    /// The least error by parallel projection.
    BestParallel,
    /// The least error of all.
    Best,
}

impl Named {
    /// In the order of the paper, then of projections.
    pub const ALL: [Self; 5] = [
        Self::Paper1,
        Self::Paper2,
        Self::Paper3,
        Self::BestParallel,
        Self::Best,
    ];

    /// As the command line has it.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Paper1 => "paper-1",
            Self::Paper2 => "paper-2",
            Self::Paper3 => "paper-3",
            Self::BestParallel => "best-parallel",
            Self::Best => "best",
        }
    }

    /// As the core has it.
    pub const fn core(self) -> SpheroidMirror {
        match self {
            Self::Paper1 => SpheroidMirror::PAPER_PARALLEL,
            Self::Paper2 => SpheroidMirror::PAPER_SPHERE,
            Self::Paper3 => SpheroidMirror::PAPER_SPHEROID,
            Self::BestParallel => SpheroidMirror::BEST_PARALLEL,
            Self::Best => SpheroidMirror::BEST,
        }
    }
}
