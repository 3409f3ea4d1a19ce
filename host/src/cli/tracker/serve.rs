//! `shisen tracker serve`: a tracker for other programs.

use super::announcer::Announcer;
use super::follow::EndArguments;
use super::{Interrupt, Recorded, TrackerName, protocol, require_serial};
use crate::cli::prelude::*;
use crate::tracker::pty::Pty;
use crate::tracker::serve::{self, LineState, NetProtocol, SILENT, relay, utc};
use crate::tracker::{Feed, Notice, PAUSE, ProtocolSpec, Recording, TrackerEvent, TrackerKind};
use shisen_tracker::clock::ClockEstimator;
use shisen_tracker::decoder::Event;
use shisen_tracker::mock::Source;
use shisen_tracker::protocol::Protocol;
use shisen_tracker::sample::Sample;
use shisen_tracker::time::Micros;
use std::collections::VecDeque;
use std::io;

/// Sends a tracker's samples to other programs
#[derive(Debug, Args)]
pub(in crate::cli) struct Arguments {
    /// The tracker: mock, replay:FILE, a device or another (see `shisen tracker --help`)
    #[arg(value_name = "SPEC")]
    spec: TrackerName,
    /// What other programs read: vrpn, lsl (or vrpn?name=NAME, lsl?name=NAME), dtrack, opentrack,
    /// or on a serial line link, fastrak, liberty, flock, hatire, iscan, asl or adhawk, and its
    /// settings, as in fastrak?units=cm (see `shisen tracker --help`)
    #[arg(long = "as", value_name = "PROTOCOL", default_value = "link", value_parser = served)]
    protocol: Served,
    /// Where: of a serial line the path for its other end, which replaces a link that leads
    /// nowhere; of vrpn and lsl an address of this machine and, for vrpn, a port [default:
    /// 127.0.0.1, 3883]; of dtrack and opentrack the address and port of the other program
    /// [default: 127.0.0.1, 5000 or 4242]
    #[arg(long, value_name = "WHERE")]
    to: Option<String>,
    #[command(flatten)]
    end: EndArguments,
}

/// What other programs read.
#[derive(Debug, Clone)]
enum Served {
    Line(Box<ProtocolSpec>),
    Net(NetProtocol),
}

fn served(name: &str) -> Result<Served, String> {
    if let Ok(net) = name.parse() {
        return Ok(Served::Net(net));
    }
    let line = protocol(name).map(|line| Served::Line(Box::new(line)));
    line.map_err(|error| format!("{error}, {}", NetProtocol::NAMES.join(", ")))
}

impl fmt::Display for Served {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Line(protocol) => protocol.fmt(f),
            Self::Net(_) => f.write_str("the network"),
        }
    }
}

pub(super) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let protocol = match &arguments.protocol {
        Served::Net(protocol) => return on_network(arguments, protocol),
        Served::Line(protocol) => protocol,
    };
    require_serial(protocol)?;
    let Some(path) = &arguments.to else {
        return Err(misuse!(
            "--as {protocol} goes over a serial line: give the path for its other end with --to"
        ));
    };
    let (path, end) = (Path::new(path), &arguments.end);
    if let TrackerKind::Replay(file) = &arguments.spec.alone()?.kind {
        return recording(file, path, protocol, end);
    }
    let relayed = Relayed {
        feed: Feed::open(arguments.spec.alone()?)?,
        announcer: Announcer::default(),
        samples: VecDeque::new(),
    };
    line(path, relayed, protocol, end, None)?;
    Ok(())
}

/// The samples of a feed.
struct Relayed {
    feed: Feed,
    announcer: Announcer,
    samples: VecDeque<Sample>,
}

impl Source for Relayed {
    type Item = Sample;

    fn poll(&mut self, until: Micros) -> Option<Sample> {
        if self.samples.is_empty() {
            let (samples, announcer) = (&mut self.samples, &mut self.announcer);
            self.feed.poll(until, &mut |notice| match notice {
                Notice::Decoded(Event::Sample(sample)) => samples.push_back(sample),
                Notice::Decoded(_) => {}
                other => announcer.announce(TrackerEvent::Feed(other)),
            });
        }
        self.samples.pop_front()
    }
}

/// Sends over the network.
fn on_network(arguments: &Arguments, protocol: &NetProtocol) -> Result<(), Failure> {
    let mut outlet = protocol.open(arguments.to.as_deref())?;
    let interrupt = Interrupt::watched();
    say(&outlet.description());
    let spec = arguments.spec.alone()?;
    if let (true, TrackerKind::Replay(file)) = (protocol.has_readers(), &spec.kind) {
        Recording::read(file)?;
        say("waiting until somebody reads");
        let begun = Instant::now();
        let is_over = || {
            arguments
                .end
                .seconds
                .is_some_and(|most| begun.elapsed() >= most)
        };
        while outlet.readers() == Some(0) {
            if interrupt.came() || is_over() {
                return Ok(());
            }
            outlet.attend(utc()).or_fail()?;
            std::thread::sleep(Duration::from_millis(1));
        }
    }
    let mut feed = Feed::open(spec)?;
    let clock = ClockEstimator::new(spec.clock()).or_fail()?;
    let mut announcer = Announcer::default();
    let (end, begin) = (&arguments.end, feed.begin());
    let last = end.span().map(|span| begin.after(span));
    let sent = relay(
        &mut feed,
        clock,
        outlet.as_mut(),
        &mut |notice| announcer.announce(TrackerEvent::Feed(notice)),
        &mut |relayed| {
            let enough = end.frames.is_some_and(|most| relayed.samples >= most);
            let late = last.is_some_and(|last| relayed.now >= last);
            !(interrupt.came() || enough || late)
        },
    );
    Ok(sent.map_err(|reason| {
        Fault::new(format!("nothing more can be sent: {reason}"), "check --to")
    })?)
}

/// Plays a recording on a line, and begins once somebody reads.
fn recording(
    file: &Path,
    path: &Path,
    protocol: &ProtocolSpec,
    end: &EndArguments,
) -> Result<(), Failure> {
    let recording = Recording::read(file)?;
    let mut samples: Vec<Sample> = recording.samples().copied().collect();
    check(&samples, protocol.protocol(), file)?;
    warn_of_pauses(&samples);
    let begin = samples.first().map_or(Micros(0), |first| first.arrival);
    for sample in &mut samples {
        sample.arrival = sample.arrival.since(begin);
    }
    let over = samples.last().map_or(Micros(0), |last| last.arrival);
    let recorded = samples.len() as u64;
    let samples = Recorded::new(samples);
    let played = line(path, samples, protocol, end, Some(over))?;
    if let Some(sent) = played.filter(|&sent| sent < recorded) {
        warn(&format!(
            "{} of {recorded} samples were not sent: the reader asked for fewer, or did not read \
             them in time, or they lack what {protocol} sends",
            recorded - sent
        ));
    }
    Ok(())
}

/// Warns of pauses in the recording.
fn warn_of_pauses(samples: &[Sample]) {
    for pair in samples.windows(2) {
        let [before, after] = [pair[0].arrival, pair[1].arrival];
        if after.since(before) > PAUSE {
            warn(&format!(
                "the recording holds nothing for {:.1} s, from {:.1} s after its first sample on: \
                 nothing is sent then",
                after.since(before).seconds(),
                before.since(samples[0].arrival).seconds()
            ));
        }
    }
}

/// Checks that samples have what a protocol's devices send. Warns if some do not; eyes may be lost
/// at times.
fn check(samples: &[Sample], protocol: &Protocol, file: &Path) -> Result<(), Failure> {
    let carries = |sample: &&Sample| protocol.carries(sample);
    let with = samples.iter().filter(carries).count();
    let what = if protocol.has_eyes() {
        "gaze"
    } else {
        "head's pose with all that its records hold"
    };
    if with == 0 {
        let (file, name) = (file.display(), protocol.name());
        let message = format!("{file} holds no {what}, which is what a {name} sends");
        let help = "choose another --as; link sends all that a recording has";
        let help = format!("{help}: shisen tracker serve replay:{file} --to PATH");
        return Err(Fault::new(message, help).into());
    }
    let without = samples.len() - with;
    if without > 0 && !protocol.has_eyes() {
        let sent = if protocol.says_untracked() {
            "are sent as not tracked"
        } else {
            "are left out"
        };
        let all = samples.len();
        warn(&format!(
            "{without} of {all} samples hold no {what}: they {sent}"
        ));
    }
    Ok(())
}

/// How long a line stays after its last record, for its reader.
const LINGER: Micros = Micros::from_millis(500);

/// Plays samples on a line: at once, or, with the time of the last, once somebody reads. Returns the
/// number of samples sent, if all were played.
fn line(
    path: &Path,
    source: impl Source<Item = Sample>,
    protocol: &ProtocolSpec,
    end: &EndArguments,
    over: Option<Micros>,
) -> Result<Option<u64>, Failure> {
    let interrupt = Interrupt::watched();
    let shown = path.display();
    let mut pty = Pty::open(path).map_err(|reason| {
        let help = if reason.kind() == io::ErrorKind::ResourceBusy {
            "end the program that serves it, or give another path"
        } else {
            "give a path that does not exist yet, in a folder that you may write to"
        };
        Fault::new(format!("no line can be made at {shown}: {reason}"), help)
    })?;
    let name = pty.name().display();
    say(&format!("{shown} speaks {protocol}, at {name}"));
    let last = end.span();
    let mut reached = |stage| {
        say(&match stage {
            LineState::NoReader => format!("waiting until somebody opens {shown}"),
            LineState::SettingUp if protocol.is_told() => format!(
                "{shown} was opened; waiting until the device is told what to send, or nothing is \
                 said for {} s",
                SILENT.as_secs()
            ),
            LineState::SettingUp => format!("{shown} was opened"),
            LineState::Sending => "the recording begins".to_owned(),
        });
    };
    let reached = over.map(|_| &mut reached as &mut dyn FnMut(LineState));
    let over = over.map(|over| over.after(LINGER));
    let (mut sent, mut whole) = (0, false);
    serve::serve(&mut pty, source, protocol, reached, &mut |turn| {
        let enough = end.frames.is_some_and(|most| turn.sent >= most);
        let late = last.is_some_and(|last| turn.now >= last);
        let both = over.zip(turn.played);
        whole = both.is_some_and(|(over, played)| played >= over);
        sent = turn.sent;
        !(interrupt.came() || enough || late || whole)
    })
    .map_err(|reason| {
        let message = format!("the line at {shown} broke: {reason}");
        Fault::new(message, "start it again")
    })?;
    Ok(whole.then_some(sent))
}
