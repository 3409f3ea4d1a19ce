//! From when on a device that is set up is believed.

use crate::time::Micros;

/// Holds the samples of a device back while it is set up.
///
/// What it sends before everything was said may be in other units than it is asked for. A device
/// that takes longer than is usual, or takes no commands at all, is believed in the end.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct SettingUp {
    /// From then on it is believed in any case, once it began.
    until: Option<Micros>,
}

impl SettingUp {
    /// How long samples are held back at most, where nothing is done that takes longer.
    pub const MOST: Micros = Micros::from_millis(800);

    /// Has not begun: what comes is believed once everything was said.
    pub const fn new() -> Self {
        Self { until: None }
    }

    /// Began at `now`, and takes `longer` than is usual: for a reset, or a change of speed.
    pub const fn since(now: Micros, longer: Micros) -> Self {
        Self {
            until: Some(now.after(longer).after(Self::MOST)),
        }
    }

    /// Begins at `now`, unless it had begun.
    pub fn begin(&mut self, now: Micros) {
        if self.until.is_none() {
            *self = Self::since(now, Micros(0));
        }
    }

    /// Returns whether samples that come at `now` are believed; `is_complete` is
    /// [`Session`](super::Session::is_complete)'s, or true where nothing is to be said.
    pub fn is_over(&self, is_complete: bool, now: Micros) -> bool {
        is_complete || self.until.is_some_and(|until| now >= until)
    }
}
