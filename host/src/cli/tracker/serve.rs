//! `shisen tracker mock` and `replay`: trackers for other programs.

use super::follow::EndArguments;
use super::monitor::show;
use super::{Interrupt, Recorded, protocol, require_serial};
use crate::cli::prelude::*;
use crate::tracker::pty::Pty;
use crate::tracker::serve::{LineState, SILENT};
use crate::tracker::{
    Feed, MockSpec, PAUSE, ProtocolSpec, Recording, TrackerKind, serve, simulated,
};
use shisen_tracker::mock::Source;
use shisen_tracker::protocol::Protocol;
use shisen_tracker::sample::Sample;
use shisen_tracker::time::Micros;
use std::io;

/// Simulates a viewer and a tracker
#[derive(Debug, Args)]
pub(in crate::cli) struct MockArguments {
    /// Protocol of the device: link, fastrak, liberty, flock, hatire, osvr-hdk, iscan, asl, adhawk
    /// or hid, and its settings, as in fastrak?units=cm (see `shisen tracker --help`) [default:
    /// link on a line, and none otherwise]
    #[arg(long = "as", value_name = "PROTOCOL", value_parser = protocol)]
    protocol: Option<ProtocolSpec>,
    /// Path for the line's other end; replaces a link that leads nowhere
    #[arg(long, value_name = "PATH")]
    pty: Option<PathBuf>,
    /// Samples per second
    #[arg(long, value_name = "HZ", default_value_t = 500, value_parser = whole::<u64>(60..=10_000))]
    rate: u64,
    /// Seed of all movements and noise
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = whole::<u64>(0..))]
    seed: u64,
    /// Hold the head still
    #[arg(long)]
    still: bool,
    /// Table of targets to look at: see `shisen tracker calibrate`
    #[arg(long, value_name = "CSV")]
    targets: Option<PathBuf>,
    #[command(flatten)]
    end: EndArguments,
    /// Print one JSON object a sample, as monitor does
    #[arg(long, conflicts_with = "pty")]
    json: bool,
}

/// Plays a recording
#[derive(Debug, Args)]
pub(in crate::cli) struct ReplayArguments {
    /// File of `shisen tracker record`
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// Protocol on the line: link, fastrak, liberty, flock, hatire, iscan, asl or adhawk, and its
    /// settings, as for `shisen tracker mock` [default: link]
    #[arg(long = "as", value_name = "PROTOCOL", requires = "to", value_parser = protocol)]
    protocol: Option<ProtocolSpec>,
    /// Path for the line's other end; replaces a link that leads nowhere
    #[arg(long, value_name = "PTY")]
    to: Option<PathBuf>,
    #[command(flatten)]
    end: EndArguments,
    /// Print one JSON object a sample, as monitor does
    #[arg(long, conflicts_with = "to")]
    json: bool,
}

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
        let mut feed = Feed::open(&TrackerKind::Mock(spec).into())?;
        return show(&mut feed, None, &arguments.end, arguments.json);
    };
    let protocol = on_a_line(spec.protocol.take())?;
    let tracker = simulated(&spec)?;
    line(path, tracker, &protocol, &arguments.end, None)?;
    Ok(())
}

pub(super) fn replay(arguments: &ReplayArguments) -> Result<(), Failure> {
    let Some(path) = &arguments.to else {
        let mut feed = Feed::open(&TrackerKind::Replay(arguments.file.clone()).into())?;
        return show(&mut feed, None, &arguments.end, arguments.json);
    };
    let protocol = on_a_line(arguments.protocol.clone())?;
    let recording = Recording::read(&arguments.file)?;
    let mut samples: Vec<Sample> = recording.samples().copied().collect();
    check(&samples, protocol.protocol(), &arguments.file)?;
    warn_of_pauses(&samples);
    let begin = samples.first().map_or(Micros(0), |first| first.arrival);
    for sample in &mut samples {
        sample.arrival = sample.arrival.since(begin);
    }
    let over = samples.last().map_or(Micros(0), |last| last.arrival);
    let recorded = samples.len() as u64;
    let samples = Recorded::new(samples);
    let played = line(path, samples, &protocol, &arguments.end, Some(over))?;
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
        let help = format!("{help}: shisen tracker replay {file} --to PTY");
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

fn on_a_line(protocol: Option<ProtocolSpec>) -> Result<ProtocolSpec, Failure> {
    Ok(protocol.map_or_else(|| Protocol::NAMES[0].parse(), Ok)?)
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
    require_serial(protocol)?;
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
