//! Progress of long work on standard error: a bar, or a line every two seconds.

use crate::live::lock;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::{self, IsTerminal};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex, Once};
use std::time::{Duration, Instant};

/// Least time of work that gets a bar.
const PATIENCE: Duration = Duration::from_millis(500);

/// A progress bar that appears after a while.
pub struct Progress {
    bar: ProgressBar,
    start: Instant,
    wanted: bool,
    template: &'static str,
    appears: Once,
}

/// The bar of work with equal parts, with the time to go.
const EVEN: &str = "{bar:40} {percent:>3} %, {elapsed} elapsed, {eta} to go";

/// The bar of work with unequal parts, whose time to go would jump.
const UNEVEN: &str = "{bar:40} {percent:>3} %, {elapsed} elapsed";

impl Progress {
    /// Makes a bar that shows nothing if `quiet`, or if standard error is no terminal.
    pub fn new(quiet: bool) -> Self {
        Self {
            bar: ProgressBar::hidden(),
            start: Instant::now(),
            wanted: !quiet && io::stderr().is_terminal(),
            template: EVEN,
            appears: Once::new(),
        }
    }

    /// Makes a bar for work with unequal parts.
    pub fn of_uneven_parts(quiet: bool) -> Self {
        Self {
            template: UNEVEN,
            ..Self::new(quiet)
        }
    }

    /// Shows that `done` of `total` parts are finished.
    pub fn show(&self, done: usize, total: usize) {
        if !self.wanted || self.start.elapsed() < PATIENCE {
            return;
        }
        self.appears.call_once(|| {
            self.bar.set_length(total as u64);
            // A template that did not parse would show as the default.
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

/// Says on standard error every two seconds how far long work is, also where that is no terminal.
pub struct Ticker {
    /// The name of the work, with how far it is.
    what: Arc<Mutex<String>>,
    /// Dropping it ends the thread, which is not joined: it may wait for a reader.
    _stop: Sender<()>,
}

impl Ticker {
    const PERIOD: Duration = Duration::from_secs(2);

    /// Starts with the work's name; says nothing if `quiet`.
    pub fn start(what: String, quiet: bool) -> Self {
        let what = Arc::new(Mutex::new(what));
        let (stop, stopped) = channel();
        let shown = Arc::clone(&what);
        let tick = move || {
            let start = Instant::now();
            while stopped.recv_timeout(Self::PERIOD) == Err(RecvTimeoutError::Timeout) {
                let seconds = start.elapsed().as_secs();
                super::say(&format!("{} ({seconds} s)", lock(&shown)));
            }
        };
        if !quiet {
            // Without a thread there is no progress, and the work goes on.
            let builder = std::thread::Builder::new().name("progress".to_owned());
            let _ = builder.spawn(tick);
        }
        Self { what, _stop: stop }
    }

    /// Changes the name of the work, with how far it is.
    pub fn set(&self, what: String) {
        *lock(&self.what) = what;
    }
}
