//! `shisen tracker`: what trackers send, and trackers for other programs.

mod announcer;
pub(super) mod calibrate;
mod drops;
mod features;
mod follow;
pub(super) mod list;
mod monitor;
pub(super) mod record;
pub(super) mod sample;
#[cfg(unix)]
mod serve;
mod show;

use crate::cli::prelude::*;
use crate::live::LiveTracker;
use crate::tracker::calibration::{Calibrated, estimation};
use crate::tracker::{Feed, ProtocolSpec, Spec};
use announcer::Announcer;
use clap::Subcommand;
use shisen_core::gaze::HeadPose;
use shisen_tracker::clock::ClockEstimator;
use shisen_tracker::estimate::{Event, GazeEstimator};
use shisen_tracker::mock::Source;
use shisen_tracker::sample::Sample;
use shisen_tracker::time::Micros;
use std::iter::Peekable;
use std::str::FromStr;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::vec::IntoIter;

/// Eye and head trackers
#[derive(Debug, Subcommand)]
#[command(after_long_help = settings_help())]
pub(super) enum TrackerCommand {
    List(list::Arguments),
    Monitor(monitor::Arguments),
    Record(record::Arguments),
    Calibrate(calibrate::Arguments),
    #[cfg(unix)]
    Serve(serve::Arguments),
}

pub(super) fn run(command: &TrackerCommand) -> Result<(), Failure> {
    match command {
        TrackerCommand::List(arguments) => list::run(arguments),
        TrackerCommand::Monitor(arguments) => monitor::run(arguments),
        TrackerCommand::Record(arguments) => record::run(arguments),
        TrackerCommand::Calibrate(arguments) => calibrate::run(arguments),
        #[cfg(unix)]
        TrackerCommand::Serve(arguments) => serve::run(arguments),
    }
}

/// Warns of a sensor that is not taken for the viewer's head.
pub fn warn_of_sensors(event: &Event) {
    let &Event::OtherSensor {
        taken,
        heard,
        ignored,
    } = event
    else {
        return;
    };
    warn(&if heard {
        format!(
            "several sensors: {taken} is taken for the head, not {ignored}; choose another with \
             head=N in SPEC"
        )
    } else {
        format!(
            "sensor {ignored} is not the head: SPEC says head={taken}, which has sent nothing so \
             far; choose a sensor that sends"
        )
    });
}

fn settings_help() -> String {
    let intro = "Settings of a device that is not set up as usual follow its protocol, in SPEC \
                 (serial:/dev/ttyUSB0?protocol=fastrak&units=cm, mock:as=flock&range=72) and in \
                 --as (fastrak?units=cm). The usual value comes first:\n";
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
        let spec = name.parse::<Spec>().map_err(|error| with_help(&error))?;
        let name = name.into();
        Ok(Self { name, spec })
    }
}

impl fmt::Display for TrackerName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.name)
    }
}

/// `--as`: a protocol, as an argument names it.
pub fn protocol(name: &str) -> Result<ProtocolSpec, String> {
    let protocol = name.parse::<ProtocolSpec>();
    protocol.map_err(|error| with_help(&error))
}

pub fn require_serial(protocol: &ProtocolSpec) -> Result<(), Failure> {
    if protocol.protocol().is_serial() {
        return Ok(());
    }
    Err(misuse!(
        "{protocol} does not go over a serial line: its devices are HID. Choose another --as"
    ))
}

/// Returns an error and what to do about it, on one line.
pub fn with_help(error: &dyn Diagnostic) -> String {
    match error.help() {
        Some(help) => format!("{error}; {help}"),
        None => error.to_string(),
    }
}

/// A tracker with its clock, its gaze and what is announced of it.
pub(super) struct Opened {
    pub(super) feed: Feed,
    pub(super) clock: ClockEstimator,
    pub(super) estimator: GazeEstimator,
    pub(super) announcer: Announcer,
}

impl Opened {
    /// Opens a tracker whose origin is at `head`, unless the calibration says where it is.
    pub(super) fn new(
        spec: &Spec,
        calibration: Option<&Path>,
        head: HeadPose,
    ) -> Result<Self, Failure> {
        let calibrated = calibration.map(|path| Calibrated::load(path, spec));
        let calibrated = calibrated.transpose()?;
        let feed = Feed::open(spec)?;
        let config = estimation(spec, feed.senses(spec), head, calibrated.as_ref());
        Ok(Self {
            feed,
            estimator: GazeEstimator::new(config).or_fail()?,
            clock: ClockEstimator::new(spec.clock()).or_fail()?,
            announcer: Announcer::default(),
        })
    }

    /// Listens on a thread of its own.
    pub(super) fn listen(mut self) -> Result<LiveTracker, Failure> {
        let announce = move |happening| self.announcer.announce(happening);
        LiveTracker::start(self.feed, self.clock, self.estimator, announce).or_fail()
    }
}

/// A flag that Ctrl-C sets, as do the signals TERM and HUP.
#[derive(Clone)]
pub struct Interrupt(Arc<AtomicBool>);

impl Interrupt {
    pub fn watched() -> Self {
        let flag = Arc::new(AtomicBool::new(false));
        let set = Arc::clone(&flag);
        // This fails only where a handler is set already, and none is.
        let _ = ctrlc::set_handler(move || set.store(true, Ordering::Relaxed));
        Self(flag)
    }

    pub fn came(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

/// Recorded samples in the order of their arrival, each at its time.
pub struct Recorded(Peekable<IntoIter<Sample>>);

impl Recorded {
    pub fn new(samples: Vec<Sample>) -> Self {
        Self(samples.into_iter().peekable())
    }
}

impl Source for Recorded {
    type Item = Sample;

    fn poll(&mut self, until: Micros) -> Option<Sample> {
        self.0.next_if(|sample| sample.arrival <= until)
    }
}
