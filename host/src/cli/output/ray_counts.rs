//! Rays by kind, for reports.

use serde::Serialize;
use shisen_core::frame::Statistics;
use std::fmt;

/// How many rays of each kind were traced.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct RayCounts {
    /// From an eye.
    pub primary: u64,
    /// Off mirrors.
    pub reflected: u64,
    /// Through glass.
    pub refracted: u64,
    /// To lights.
    pub shadow: u64,
}

impl RayCounts {
    /// Off mirrors and through glass.
    pub const fn secondary(&self) -> u64 {
        self.reflected + self.refracted
    }

    /// Of all kinds.
    pub const fn all(&self) -> u64 {
        self.primary + self.secondary() + self.shadow
    }
}

impl From<Statistics> for RayCounts {
    fn from(statistics: Statistics) -> Self {
        Self {
            primary: statistics.primary,
            reflected: statistics.reflected,
            refracted: statistics.refracted,
            shadow: statistics.shadow,
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
        } = self;
        write!(
            f,
            "{primary} primary, {reflected} reflected, {refracted} refracted, {shadow} shadow"
        )
    }
}
