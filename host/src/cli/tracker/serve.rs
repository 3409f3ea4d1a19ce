//! `shisen tracker mock` and `replay`: trackers for others to read.

use super::follow::EndArguments;
use super::monitor::show;
use super::sample::Records;
use super::{Interrupt, Recorded, goes_over_a_line, protocol};
use crate::cli::arguments::whole;
use crate::cli::output::failure::Failure;
use crate::cli::output::{say, warn};
use crate::tracker::pty::Pty;
use crate::tracker::serve::{Begin, LineState, SILENT};
use crate::tracker::{
    Feed, MockSpec, PAUSE, ProtocolSpec, Recording, ReplaySpec, Spec, Times, serve, simulated,
};
use clap::Args;
use miette::Diagnostic;
use shisen_tracker::mock::Source;
use shisen_tracker::protocol::Protocol;
use shisen_tracker::sample::Sample;
use shisen_tracker::time::Micros;
use std::io;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Simulates a viewer and a tracker
///
/// With --pty the tracker is behind a serial line: PATH becomes a link to it,
/// for `shisen tracker monitor 'serial:PATH?protocol=PROTOCOL'` or any other
/// program. It takes its device's commands, and streams until it is told to
/// stop. Without --pty it prints its samples, as monitor does.
#[derive(Debug, Args)]
pub(in crate::cli) struct MockArguments {
    /// What it speaks: link, fastrak, liberty, flock, hatire, osvr-hdk, iscan,
    /// asl, adhawk or hid, and its settings, as in fastrak?units=cm (see
    /// `shisen tracker --help`) [default: link on a line, and samples as they
    /// are otherwise]
    #[arg(long = "as", value_name = "PROTOCOL", value_parser = protocol)]
    protocol: Option<ProtocolSpec>,
    /// A name for the line's other end; a link that leads nowhere gives way
    #[arg(long, value_name = "PATH")]
    pty: Option<PathBuf>,
    /// Samples per second
    #[arg(long, value_name = "HZ", default_value_t = 500, value_parser = whole::<u64>(60..=10_000))]
    rate: u64,
    /// What decides all movements and all noise
    #[arg(long, value_name = "N", default_value_t = 1,
          value_parser = whole::<u64>(0..))]
    seed: u64,
    /// Hold the head still
    #[arg(long)]
    still: bool,
    /// What is looked at and when: see `shisen tracker calibrate`
    #[arg(long, value_name = "CSV")]
    targets: Option<PathBuf>,
    #[command(flatten)]
    end: EndArguments,
    /// Print one JSON object a sample, as monitor does
    #[arg(long, conflicts_with = "pty")]
    json: bool,
}

/// Plays a recording
///
/// With --to it is behind a serial line, as `shisen tracker mock` is; without,
/// its samples are printed, as monitor does. Behind a line it waits for whoever reads it,
/// so that the first record is not lost: it begins once somebody has opened the line and
/// told the device what to send, has asked for three records one by one, or has said
/// nothing for 3 s (0.4 s where devices are told nothing). --frames counts from there, --seconds from the command's start.
#[derive(Debug, Args)]
pub(in crate::cli) struct ReplayArguments {
    /// What `shisen tracker record` wrote
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// What the line speaks: link, fastrak, liberty, flock, hatire, iscan, asl or
    /// adhawk, and its settings, as for `shisen tracker mock` [default: link]
    #[arg(long = "as", value_name = "PROTOCOL", requires = "to", value_parser = protocol)]
    protocol: Option<ProtocolSpec>,
    /// A name for the line's other end; a link that leads nowhere gives way
    #[arg(long, value_name = "PTY")]
    to: Option<PathBuf>,
    #[command(flatten)]
    end: EndArguments,
    /// Print one JSON object a sample, as monitor does
    #[arg(long, conflicts_with = "to")]
    json: bool,
}

/// A recording that a protocol cannot say.
#[derive(Debug, Error, Diagnostic)]
#[error("{} holds no {what}, which is what a {protocol} sends", file.display())]
#[diagnostic(help(
    "choose another --as; link sends all that a recording has: shisen tracker replay {} --to PTY",
    file.display()
))]
struct Lacking {
    file: PathBuf,
    what: &'static str,
    protocol: &'static str,
}

/// A line that does not work.
#[derive(Debug, Error, Diagnostic)]
enum LineError {
    /// It cannot be made.
    #[error("no line can be made at {}: {reason}", path.display())]
    #[diagnostic(help(
        "give a path in a folder that you may write to, where there is nothing yet"
    ))]
    Open { path: PathBuf, reason: io::Error },
    /// Its name is another's.
    #[error("no line can be made at {}: {reason}", path.display())]
    #[diagnostic(help("end the program that serves it, or give another path"))]
    Busy { path: PathBuf, reason: io::Error },
    /// It broke.
    #[error("the line at {} broke: {reason}", path.display())]
    #[diagnostic(help("start it again"))]
    Broken { path: PathBuf, reason: io::Error },
}

/// Runs `shisen tracker mock`.
pub(super) fn mock(arguments: &MockArguments) -> Result<(), Failure> {
    let mut spec = MockSpec {
        seed: arguments.seed,
        rate: arguments.rate as u32,
        protocol: arguments.protocol.clone(),
        still: arguments.still,
        targets: arguments.targets.clone(),
        ..MockSpec::default()
    };
    let Some(path) = &arguments.pty else {
        let mut feed = Feed::open(&Spec::Mock(spec))?;
        return show(
            &mut feed,
            Records::new(None),
            &arguments.end,
            arguments.json,
        );
    };
    let protocol = on_a_line(spec.protocol.take())?;
    let tracker = simulated(&spec)?;
    line(path, tracker, &protocol, &arguments.end, Play::AtOnce)?;
    Ok(())
}

/// Runs `shisen tracker replay`.
pub(super) fn replay(arguments: &ReplayArguments) -> Result<(), Failure> {
    let Some(path) = &arguments.to else {
        let mut feed = Feed::open(&Spec::Replay(ReplaySpec {
            path: arguments.file.clone(),
            head: None,
            times: Times::default(),
        }))?;
        return show(
            &mut feed,
            Records::new(None),
            &arguments.end,
            arguments.json,
        );
    };
    let protocol = on_a_line(arguments.protocol.clone())?;
    let recording = Recording::read(&arguments.file)?;
    let samples: Vec<Sample> = recording.samples().copied().collect();
    check(&samples, protocol.protocol(), &arguments.file)?;
    tell_pauses(&samples);
    let samples = from_the_first(samples);
    let over = samples.last().map_or(Micros(0), |last| last.arrival);
    let recorded = samples.len() as u64;
    let samples = Recorded::new(samples);
    let play = Play::ToReader { over };
    let played = line(path, samples, &protocol, &arguments.end, play)?;
    if played.whole && played.sent < recorded {
        warn(&format!(
            "{} of {recorded} samples were not sent: the host asked for fewer, or did not read \
             them in time, or they lack what {protocol} says",
            recorded - played.sent
        ));
    }
    Ok(())
}

/// Warns of every time in which nothing is sent since nothing was recorded.
fn tell_pauses(samples: &[Sample]) {
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

/// The same samples, the first of which comes at once.
fn from_the_first(mut samples: Vec<Sample>) -> Vec<Sample> {
    let begin = samples.first().map_or(Micros(0), |first| first.arrival);
    for sample in &mut samples {
        sample.arrival = sample.arrival.since(begin);
    }
    samples
}

/// Whether samples have what a protocol's devices send: all, or, with a
/// warning, some. Eyes may be lost at times.
fn check(samples: &[Sample], protocol: &Protocol, file: &Path) -> Result<(), Failure> {
    let with = samples
        .iter()
        .filter(|sample| protocol.carries(sample))
        .count();
    let what = if protocol.has_eyes() {
        "gaze"
    } else {
        "head's pose with all that its records hold"
    };
    if with == 0 {
        let (file, protocol) = (file.into(), protocol.name());
        return Err(Lacking {
            file,
            what,
            protocol,
        }
        .into());
    }
    let without = samples.len() - with;
    if without > 0 && !protocol.has_eyes() {
        let sent = if protocol.says_untracked() {
            "are sent as not tracked"
        } else {
            "are left out"
        };
        warn(&format!(
            "{without} of {} samples hold no {what}: they {sent}",
            samples.len()
        ));
    }
    Ok(())
}

/// Says what a recording waits for.
fn tell_stage(stage: LineState, path: &Path, protocol: &ProtocolSpec) {
    let path = path.display();
    say(&match stage {
        LineState::NoReader => format!("waiting until somebody opens {path}"),
        LineState::SettingUp if protocol.is_told() => format!(
            "{path} was opened; waiting until the device is told what to send, or nothing is \
             said for {} s",
            SILENT.as_secs()
        ),
        LineState::SettingUp => format!("{path} was opened"),
        LineState::Sending => "the recording begins".to_owned(),
    });
}

fn on_a_line(protocol: Option<ProtocolSpec>) -> Result<ProtocolSpec, Failure> {
    match protocol {
        Some(protocol) => Ok(protocol),
        None => Ok(Protocol::NAMES[0].parse::<ProtocolSpec>()?),
    }
}

/// How long a line stays after its last record, for whoever reads it.
const LINGER: Micros = Micros::from_millis(500);

/// When a line begins and when it is over.
#[derive(Clone, Copy)]
enum Play {
    AtOnce,
    /// Once somebody reads; it is over so long after that.
    ToReader {
        over: Micros,
    },
}

/// What went over a line.
struct Played {
    /// Records.
    sent: u64,
    /// Nothing ended it before it was over.
    whole: bool,
}

fn line(
    path: &Path,
    source: impl Source<Item = Sample>,
    protocol: &ProtocolSpec,
    end: &EndArguments,
    play: Play,
) -> Result<Played, Failure> {
    goes_over_a_line(protocol)?;
    let interrupt = Interrupt::watched();
    let mut pty = Pty::open(path).map_err(|reason| {
        let path = path.into();
        if reason.kind() == io::ErrorKind::ResourceBusy {
            LineError::Busy { path, reason }
        } else {
            LineError::Open { path, reason }
        }
    })?;
    say(&format!(
        "{} speaks {protocol}, at {}",
        path.display(),
        pty.name().display()
    ));
    let last = end.span();
    let mut reached = |stage| tell_stage(stage, path, protocol);
    let (begin, over) = match play {
        Play::AtOnce => (Begin::AtOnce, None),
        Play::ToReader { over } => (Begin::WithReader(&mut reached), Some(over.after(LINGER))),
    };
    let mut played = Played {
        sent: 0,
        whole: false,
    };
    serve::serve(&mut pty, source, protocol, begin, &mut |turn| {
        let enough = end.frames.is_some_and(|most| turn.sent >= most);
        let late = last.is_some_and(|last| turn.now >= last);
        let over = over
            .zip(turn.played)
            .is_some_and(|(over, played)| played >= over);
        played = Played {
            sent: turn.sent,
            whole: over,
        };
        !(interrupt.came() || enough || late || over)
    })
    .map_err(|reason| LineError::Broken {
        path: path.into(),
        reason,
    })?;
    Ok(played)
}
