//! A progress bar on standard error, where somebody watches long work.

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::{self, IsTerminal};
use std::sync::Once;
use std::time::{Duration, Instant};

/// Work that is over sooner needs no bar.
const PATIENCE: Duration = Duration::from_millis(500);

/// How far a frame is.
pub struct Progress {
    bar: ProgressBar,
    start: Instant,
    wanted: bool,
    template: &'static str,
    appears: Once,
}

/// With the time that is left, where one part takes as long as another.
const EVEN: &str = "{bar:40} {percent:>3} %, {elapsed} elapsed, {eta} to go";

/// Without it, where it would jump.
const UNEVEN: &str = "{bar:40} {percent:>3} %, {elapsed} elapsed";

impl Progress {
    /// Shows nothing where `quiet` is set or standard error is no terminal.
    pub fn new(quiet: bool) -> Self {
        Self::with(quiet, EVEN)
    }

    /// The same of work whose parts take unlike times: it tells no time that is left.
    pub fn of_uneven_parts(quiet: bool) -> Self {
        Self::with(quiet, UNEVEN)
    }

    fn with(quiet: bool, template: &'static str) -> Self {
        Self {
            bar: ProgressBar::hidden(),
            start: Instant::now(),
            wanted: !quiet && io::stderr().is_terminal(),
            template,
            appears: Once::new(),
        }
    }

    /// Tells that `done` of `total` tiles are finished.
    pub fn show(&self, done: usize, total: usize) {
        if !self.wanted || self.start.elapsed() < PATIENCE {
            return;
        }
        self.appears.call_once(|| {
            self.bar.set_length(total as u64);
            // A template of our own that does not parse shows as the default.
            if let Ok(style) = ProgressStyle::with_template(self.template) {
                self.bar.set_style(style);
            }
            self.bar.set_draw_target(ProgressDrawTarget::stderr());
        });
        self.bar.set_position(done as u64);
    }

    /// Clears the bar away.
    pub fn finish(&self) {
        self.bar.finish_and_clear();
    }
}
