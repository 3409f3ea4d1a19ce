//! `shisen tracker`: what trackers say, and trackers for others to read.

mod calibrate;
mod features;
mod follow;
mod happenings;
mod list;
mod monitor;
mod record;
#[cfg(unix)]
mod recorded;
mod said;
mod sample;
#[cfg(unix)]
mod serve;
mod show;

pub(super) use follow::with_drops;
pub(super) use happenings::Happenings;
#[cfg(unix)]
pub use recorded::Recorded;

use crate::cli::output::failure::Failure;
use crate::tracker::{ProtocolSpec, Spec};
use clap::Subcommand;
use miette::Diagnostic;
use shisen_tracker::estimate::Event;
use std::fmt;
use std::str::FromStr;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Eye and head trackers
///
/// SPEC is `mock`, `mock:seed=7&rate=200&as=fastrak` (`&still=1` holds the head,
/// `&targets=CSV` says what is looked at: see calibrate),
/// `serial:/dev/ttyUSB0?protocol=fastrak&baud=115200` (`&reset=1` resets the
/// device first; `&stop=1` stops it at the end; `&speed=115200` changes a fastrak and
/// the line from `baud` to that; `&rts=0` lowers the line's RTS, as it is for a flock, `&rts=1`
/// raises it), `hid:1532:0b00` (vendor and product), `hid:usage=0012` (usage page 0x12,
/// that of eye and head trackers; `hid:usage=0012:0001` its usage 1), `hid:/dev/hidraw0`
/// (`?axes=right,up,back` and `&origin=X,Y,Z` say where an eye tracker's coordinates
/// are) or `replay:FILE`.
/// Where there are several sensors (link, fastrak, liberty, flock, recordings),
/// `head=N` takes sensor N for the viewer's head in place of the first that is seen:
/// `replay:FILE?head=1`.
///
/// For commands that follow the gaze, every SPEC takes times in seconds: `stuck_after` and
/// `head_stuck_after` (a gaze or a head that stays the same to the last bit for longer is
/// stuck; or never), the gaze's ages `hold_after`, `widen_after`, `head_after` and
/// `full_after`, the head's `head_hold_after`, `head_widen_after` and `head_full_after`,
/// and `longest_blink`: `mock:hold_after=0.1&stuck_after=never`; and `delay`, from a
/// measurement to the arrival of its last byte at least, which no clock tells (0 to 1; a
/// simulated tracker's is 0.008).
#[derive(Debug, Subcommand)]
#[command(after_long_help = settings_help())]
pub(super) enum TrackerCommand {
    List(list::Arguments),
    Monitor(monitor::Arguments),
    Record(record::Arguments),
    Calibrate(calibrate::Arguments),
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
        TrackerCommand::Calibrate(arguments) => calibrate::run(arguments),
        #[cfg(unix)]
        TrackerCommand::Mock(arguments) => serve::mock(arguments),
        #[cfg(unix)]
        TrackerCommand::Replay(arguments) => serve::replay(arguments),
    }
}

/// Says that a sensor of the tracker is not taken for the viewer's head.
pub fn warn_of_sensors(event: &Event) {
    let Event::OtherSensor {
        taken,
        heard,
        ignored,
    } = event
    else {
        return;
    };
    crate::cli::output::warn(&if *heard {
        format!(
            "several sensors: {taken} is taken for the head, not {ignored}; choose another with \
             head=N in SPEC"
        )
    } else {
        format!(
            "sensor {ignored} is not the head: SPEC says head={taken}, which has not been heard \
             of so far; choose one that is there"
        )
    });
}

/// What a protocol's devices can be set up to.
fn settings_help() -> String {
    let intro = "A device that is not set up as usual: settings after its protocol, in SPEC \
                 (serial:/dev/ttyUSB0?protocol=fastrak&units=cm, mock:as=flock&range=72) and in \
                 --as (fastrak?units=cm). The usual value stands first:\n";
    let lines = crate::tracker::settings();
    let lines = lines.map(|(protocol, settings)| format!("\n  {protocol}: {settings}"));
    intro.to_owned() + &lines.collect::<String>()
}

/// `SPEC`: a tracker, as an argument names it.
#[derive(Debug, Clone)]
pub struct TrackerName {
    name: String,
    pub spec: Spec,
}

impl FromStr for TrackerName {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, String> {
        let spec = name.parse::<Spec>().map_err(|error| told(&error))?;
        let name = name.into();
        Ok(Self { name, spec })
    }
}

impl fmt::Display for TrackerName {
    /// As given.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.name)
    }
}

/// `--as`: a protocol, as an argument names it.
pub fn protocol(name: &str) -> Result<ProtocolSpec, String> {
    name.parse::<ProtocolSpec>().map_err(|error| told(&error))
}

/// Refuses protocols of devices that are on no serial line.
///
/// # Errors
/// Of usage: such a protocol.
pub fn goes_over_a_line(protocol: &ProtocolSpec) -> Result<(), Failure> {
    if protocol.protocol().is_serial() {
        return Ok(());
    }
    Err(Failure::usage(&format!(
        "{protocol} does not go over a serial line: its devices are HID. Choose another --as"
    )))
}

/// An error and what to do about it, on a line.
pub fn told(error: &dyn Diagnostic) -> String {
    match error.help() {
        Some(help) => format!("{error}; {help}"),
        None => error.to_string(),
    }
}

/// Set once somebody asks for an end: Ctrl-C, or the signals TERM and HUP.
#[derive(Clone)]
pub struct Interrupt(Arc<AtomicBool>);

impl Interrupt {
    pub fn watched() -> Self {
        let flag = Arc::new(AtomicBool::new(false));
        let set = Arc::clone(&flag);
        // It fails only where a handler is set already, and none is.
        let _ = ctrlc::set_handler(move || set.store(true, Ordering::Relaxed));
        Self(flag)
    }

    pub fn came(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}
