//! `shisen tracker`: what trackers send, and trackers for other programs.

mod announcer;
pub(super) mod calibrate;
pub(super) mod doctor;
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
pub use crate::files::with_help;
use crate::live::{LiveTracker, Report};
use crate::tracker::calibration::{Calibrated, composed, estimation};
use crate::tracker::{
    By, ComposedGaze, Feed, Intake, LslSpec, Navigation, NetSpec, ProtocolSpec, RawBytes, Role,
    Source, Spec, TrackerKind, Wand,
};
use announcer::Announcer;
use clap::Subcommand;
use glam::{DVec2, Quat};
use shisen_core::gaze::HeadPose;
use shisen_tracker::clock::ClockEstimator;
use shisen_tracker::estimate::{Event, GazeEstimator, Screen, Sensors};
use shisen_tracker::mock;
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
    Doctor(doctor::Arguments),
    Monitor(monitor::Arguments),
    Record(record::Arguments),
    Calibrate(calibrate::Arguments),
    #[cfg(unix)]
    Serve(serve::Arguments),
}

pub(super) fn run(command: &TrackerCommand) -> Result<(), Failure> {
    match command {
        TrackerCommand::List(arguments) => list::run(arguments),
        TrackerCommand::Doctor(arguments) => doctor::run(arguments),
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
    /// What it is read for: `head=SPEC` or `gaze=SPEC`, or all.
    pub role: Role,
    /// The tracker.
    pub spec: Spec,
}

impl FromStr for TrackerName {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, String> {
        let roles = [("head=", Role::Head), ("gaze=", Role::Gaze)];
        let part = roles
            .iter()
            .find_map(|(start, role)| Some((*role, name.strip_prefix(start)?)));
        let (role, spec) = part.unwrap_or((Role::All, name));
        let spec = spec.parse::<Spec>().map_err(|error| with_help(&error))?;
        let name = name.into();
        Ok(Self { name, role, spec })
    }
}

impl From<Spec> for TrackerName {
    fn from(spec: Spec) -> Self {
        let (name, role) = (String::new(), Role::All);
        Self { name, role, spec }
    }
}

impl TrackerName {
    /// Returns the tracker of a command that has one alone.
    ///
    /// # Errors
    /// A part of a viewer.
    pub fn alone(&self) -> Result<&Spec, Failure> {
        match self.role.name() {
            None => Ok(&self.spec),
            Some(role) => Err(misuse!(
                "leave {role}= out: here one tracker is read, with all that it has"
            )),
        }
    }
}

/// Returns the trackers' names, as they were given.
pub fn names(trackers: &[TrackerName]) -> String {
    let names: Vec<&str> = trackers.iter().map(|one| one.name.as_str()).collect();
    names.join(" ")
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

/// A viewer's trackers with the gaze and what is announced of them.
pub(super) struct Opened {
    /// The head's before the gaze's.
    pub(super) sources: Vec<(Source, Announcer)>,
    pub(super) gaze: ComposedGaze,
    /// What steers, and the number of the source that it is on.
    wand: Option<(Wand, usize)>,
    /// The bytes of each tracker, where they are kept.
    pub(super) raw: Vec<RawBytes>,
}

impl Opened {
    /// Opens the trackers of a viewer, whose origin is at `head` unless their calibrations say where
    /// they are. `room` has the screens that gazes may be on; with `is_raw` their bytes are kept.
    pub(super) fn new(
        trackers: &[TrackerName],
        calibration: Option<&Path>,
        head: HeadPose,
        room: &Cave,
        is_raw: bool,
    ) -> Result<Self, Failure> {
        let mut trackers: Vec<&TrackerName> = trackers.iter().collect();
        trackers.sort_by_key(|one| one.role == Role::Gaze);
        let roles: Vec<Role> = trackers.iter().map(|one| one.role).collect();
        if !matches!(roles[..], [_] | [Role::Head, Role::Gaze]) {
            return Err(misuse!(
                "several trackers are a head and a gaze: --tracker head=SPEC --tracker gaze=SPEC"
            ));
        }
        if calibration.is_some() && trackers.len() > 1 {
            return Err(misuse!(
                "--calibration is for one tracker: append calibration=FILE to the SPEC that it is of"
            ));
        }
        let (mut sources, mut configs) = (Vec::new(), Vec::new());
        let mut raw = Vec::new();
        for TrackerName { name, role, spec } in trackers {
            let path = calibration.or(spec.calibration.as_deref());
            let calibrated = path.map(|path| Calibrated::load(path, spec)).transpose()?;
            let screen = screen(spec, room)?;
            let feed = if is_raw {
                let (feed, bytes) = Feed::open_raw(name, spec)?;
                raw.push(bytes);
                feed
            } else {
                Feed::open(spec)?
            };
            let mut senses = feed.senses(spec);
            senses.head &= *role != Role::Gaze;
            senses.eyes &= *role != Role::Head;
            let mut config = estimation(spec, senses, head, calibrated.as_ref());
            // The intake chooses the sensor.
            config.sensors = Sensors::All;
            config.screen = screen.or(config.screen);
            configs.push(config);
            let clock = ClockEstimator::new(spec.clock()).or_fail()?;
            let intake = Intake::new(*role, clock, spec, calibrated.as_ref());
            sources.push((Source { feed, intake }, Announcer::of(*role)));
        }
        let mut config = configs[0];
        if let ([(first, _), (second, _)], [of_head, of_gaze]) = (&mut sources[..], &configs[..]) {
            config = composed(of_head, of_gaze);
            let turns = [of_head, of_gaze].map(|one| one.room_from_tracker.orientation);
            let (own, others) = (second.feed.clock(), first.feed.clock());
            second.feed.start_with(&others);
            let turn = turns[0].conjugate() * turns[1];
            second.intake.follow(&own, &others, turn);
        }
        Ok(Self {
            sources,
            gaze: ComposedGaze::new(GazeEstimator::new(config).or_fail()?),
            wand: None,
            raw,
        })
    }

    /// Adds what steers the viewer.
    pub(super) fn steered_by(mut self, navigation: &Navigation) -> Result<Self, Failure> {
        let config = self.gaze.estimator.config();
        let place = config.room_from_tracker;
        let head = HeadPose {
            position: place.position,
            orientation: place.orientation,
        };
        let spec = match &navigation.by {
            By::Keyboard => return Ok(self),
            By::Tracker => {
                self.wand = Some((navigation.wand(head.orientation), 0));
                return Ok(self);
            }
            By::Wand(spec) => spec,
        };
        let path = spec.calibration.as_deref();
        let calibrated = path.map(|path| Calibrated::load(path, spec)).transpose()?;
        let mut feed = Feed::open(spec).map_err(|error| {
            let fault = format!("--navigate: {error}");
            let help = error
                .help()
                .map(|help| help.to_string())
                .unwrap_or_default();
            Fault::new(
                fault,
                format!("{help}; where the --tracker is on it, --navigate tracker"),
            )
        })?;
        feed.let_be_silent();
        let own = feed.clock();
        let first = self.sources.first().map(|(source, _)| source.feed.clock());
        let clock = ClockEstimator::new(spec.clock()).or_fail()?;
        let mut intake = Intake::new(Role::Wand, clock, spec, calibrated.as_ref());
        if let Some(first) = first {
            feed.start_with(&first);
            intake.follow(&own, &first, Quat::IDENTITY);
        }
        let place =
            estimation(spec, feed.senses(spec), head, calibrated.as_ref()).room_from_tracker;
        self.wand = Some((navigation.wand(place.orientation), self.sources.len()));
        let announcer = Announcer::of(Role::Wand);
        self.sources.push((Source { feed, intake }, announcer));
        Ok(self)
    }

    /// Listens on threads of its own.
    pub(super) fn listen(self) -> Result<LiveTracker, Failure> {
        let sources = self.sources.into_iter().map(|(source, mut announcer)| {
            let report: Report = Box::new(move |happening| announcer.announce(happening));
            (source, report)
        });
        LiveTracker::start(sources.collect(), self.gaze, self.wand).or_fail()
    }
}

/// Returns the wall on which a specification says that its gaze is.
fn screen(spec: &Spec, room: &Cave) -> Result<Option<Screen>, Failure> {
    let TrackerKind::Net(NetSpec::Lsl(LslSpec { gaze, .. })) = &spec.kind else {
        return Ok(None);
    };
    let Some(name) = &gaze.screen else {
        return Ok(None);
    };
    let wall = room.walls.iter().find(|wall| wall.name == *name);
    let wall = wall.ok_or_else(|| {
        let walls: Vec<&str> = room.walls.iter().map(|wall| wall.name.as_str()).collect();
        let message = format!("screen={name}: the room has no wall of this name");
        Fault::new(message, format!("give one of {}", walls.join(", ")))
    })?;
    let (across, upward) = (wall.across(), wall.upward());
    Ok(Some(Screen {
        corner: wall.upper_left.as_vec3(),
        right: across.normalize().as_vec3(),
        down: -upward.normalize().as_vec3(),
        size: DVec2::new(across.length(), upward.length()).as_vec2(),
    }))
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

impl mock::Source for Recorded {
    type Item = Sample;

    fn poll(&mut self, until: Micros) -> Option<Sample> {
        self.0.next_if(|sample| sample.arrival <= until)
    }
}
