//! A progress bar on standard error, where somebody watches long work.

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::{self, IsTerminal};
use std::sync::Once;
use std::time::{Duration, Instant};

/// Work that is over sooner needs no bar.
const PATIENCE: Duration = Duration::from_millis(500);

/// How far a frame is.
pub(super) struct Progress {
    bar: ProgressBar,
    start: Instant,
    wanted: bool,
    appears: Once,
}

impl Progress {
    /// Shows nothing where `quiet` is set or standard error is no terminal.
    pub(super) fn new(quiet: bool) -> Self {
        Self {
            bar: ProgressBar::hidden(),
            start: Instant::now(),
            wanted: !quiet && io::stderr().is_terminal(),
            appears: Once::new(),
        }
    }

    /// Tells that `done` of `total` tiles are finished.
    pub(super) fn show(&self, done: usize, total: usize) {
        if !self.wanted || self.start.elapsed() < PATIENCE {
            return;
        }
        self.appears.call_once(|| {
            self.bar.set_length(total as u64);
            // A template of our own that does not parse shows as the default.
            if let Ok(style) = ProgressStyle::with_template(
                "{bar:40} {percent:>3} %, {elapsed} elapsed, {eta} to go",
            ) {
                self.bar.set_style(style);
            }
            self.bar.set_draw_target(ProgressDrawTarget::stderr());
        });
        self.bar.set_position(done as u64);
    }

    /// Clears the bar away.
    pub(super) fn finish(&self) {
        self.bar.finish_and_clear();
    }
}
