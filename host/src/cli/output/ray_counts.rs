//! Rays by kind, for reports.

use crate::cli::prelude::*;
use shisen_core::frame::Statistics;

/// Traced rays of each kind.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
pub struct RayCounts {
    /// Rays from an eye.
    pub primary: u64,
    /// Rays off mirrors.
    pub reflected: u64,
    /// Rays through glass.
    pub refracted: u64,
    /// Rays to lights.
    pub shadow: u64,
    /// Points that rays from an eye see, whose light was computed.
    pub lit: u64,
    /// Parts of the pictures with a colour of their own, where their size follows the gaze.
    pub leaves: u64,
}

impl RayCounts {
    pub const fn all(&self) -> u64 {
        self.primary + self.reflected + self.refracted + self.shadow
    }
}

impl From<Statistics> for RayCounts {
    fn from(statistics: Statistics) -> Self {
        Self {
            primary: statistics.primary,
            reflected: statistics.reflected,
            refracted: statistics.refracted,
            shadow: statistics.shadow,
            lit: statistics.lit,
            leaves: statistics.leaves,
        }
    }
}

impl fmt::Display for RayCounts {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            primary,
            reflected,
            refracted,
            shadow,
            lit,
            leaves,
        } = self;
        write!(f, "{primary} primary, {reflected} reflected, ")?;
        write!(f, "{refracted} refracted, {shadow} shadow")?;
        if *leaves > 0 {
            write!(f, "; {leaves} leaves, {lit} points lit")?;
        }
        Ok(())
    }
}
