use shisen_core::capture;

/// How a dome master's pixels become directions.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Mapping {
    /// The paper's: the picture is what the mirror shows of the screen.
    #[default]
    Mirror,
    /// The mirror's, with the screen's point chosen for each pixel so that its
    /// direction is exact. Its origin is still the mirror's.
    Exact,
    /// A lens that can only be computed: no mirror, one viewpoint.
    True,
}

impl Mapping {
    /// The nearer to a photograph, the earlier.
    pub const ALL: [Self; 3] = [Self::Mirror, Self::Exact, Self::True];

    /// As the command line has it.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Mirror => "mirror",
            Self::Exact => "exact",
            Self::True => "true",
        }
    }

    /// The core's, where there is a mirror.
    pub const fn core(self) -> Option<capture::Mapping> {
        match self {
            Self::Mirror => Some(capture::Mapping::Screen),
            Self::Exact => Some(capture::Mapping::Exact),
            Self::True => None,
        }
    }
}
