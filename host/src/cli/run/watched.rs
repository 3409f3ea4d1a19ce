//! What the loop hears of a window.

use crate::cli::play::Change;
use serde::Serialize;

/// What a key asks of the loop.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(
    not(all(unix, feature = "window")),
    allow(dead_code, reason = "without a window there are no keys")
)]
pub(super) enum Command {
    /// Something else to be shown.
    Change(Change),
    /// The next way to fill what the gaze skips.
    Fill,
    /// No more frames.
    End,
}

/// What became of a window.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub(super) struct Watched {
    /// Frames shown.
    pub(super) shown: u64,
    /// Frames that it had no time for, or that came after its end.
    pub(super) dropped: u64,
    /// Whether it was there at the end.
    pub(super) is_open: bool,
}
