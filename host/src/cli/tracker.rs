//! `shisen tracker`: what trackers say, and trackers for others to read.

mod follow;
mod list;
mod monitor;
mod record;
mod sample;
#[cfg(unix)]
mod serve;

use super::failure::Failure;
use clap::Subcommand;
use shisen::tracker::Spec;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Eye and head trackers
///
/// SPEC is `mock`, `mock:seed=7&rate=200&as=fastrak`,
/// `serial:/dev/ttyUSB0?protocol=fastrak&baud=115200` (`&reset=1` resets the
/// device first), `hid:1532:0b00`, `hid:/dev/hidraw0` or `replay:FILE`.
#[derive(Debug, Subcommand)]
pub(super) enum TrackerCommand {
    List(list::Arguments),
    Monitor(monitor::Arguments),
    Record(record::Arguments),
    #[cfg(unix)]
    Mock(serve::MockArguments),
    #[cfg(unix)]
    Replay(serve::ReplayArguments),
}

/// Runs the command.
pub(super) fn run(command: &TrackerCommand) -> Result<(), Failure> {
    match command {
        TrackerCommand::List(arguments) => list::run(arguments),
        TrackerCommand::Monitor(arguments) => monitor::run(arguments),
        TrackerCommand::Record(arguments) => record::run(arguments),
        #[cfg(unix)]
        TrackerCommand::Mock(arguments) => serve::mock(arguments),
        #[cfg(unix)]
        TrackerCommand::Replay(arguments) => serve::replay(arguments),
    }
}

/// A tracker, as an argument names it.
///
/// # Errors
/// A name that is none.
pub(super) fn spec(name: &str) -> Result<Spec, Failure> {
    Ok(name.parse::<Spec>()?)
}

/// Set once somebody asks for an end: Ctrl-C, or the signals TERM and HUP.
#[derive(Clone)]
struct Interrupt(Arc<AtomicBool>);

impl Interrupt {
    fn new() -> Self {
        let flag = Arc::new(AtomicBool::new(false));
        let set = Arc::clone(&flag);
        // It fails only where a handler is set already, and none is.
        let _ = ctrlc::set_handler(move || set.store(true, Ordering::Relaxed));
        Self(flag)
    }

    fn came(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}
