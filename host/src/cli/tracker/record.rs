//! `shisen tracker record`: what a tracker says, into a file.

use super::TrackerName;
use super::follow::{EndArguments, follow};
use super::sample::{ByReason, by_reason};
use crate::cli::output::failure::Failure;
use crate::cli::output::print;
use crate::tracker::{Feed, Recorder};
use clap::Args;
use miette::Diagnostic;
use serde::Serialize;
use shisen_tracker::decoder::Event;
use std::collections::BTreeMap;
use std::fmt;
use std::path::PathBuf;
use thiserror::Error;

/// Records a tracker
///
/// A file with the extension .csv is a table with a line a sample; any other
/// holds frames of our own link. Ends at --frames, --seconds or Ctrl-C.
///
/// With --json, one object: file, samples, messages, lost, `held_back` (samples that
/// came before the device was told what to send, and are not used), dropped and
/// `dropped_by` (how often, by reason).
#[derive(Debug, Args)]
pub(in crate::cli) struct Arguments {
    /// Which tracker: see `shisen tracker --help`
    #[arg(value_name = "SPEC")]
    spec: TrackerName,
    /// Where to; what was there is overwritten with the first sample
    #[arg(value_name = "FILE")]
    file: PathBuf,
    #[command(flatten)]
    end: EndArguments,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Serialize)]
struct Report {
    file: String,
    samples: u64,
    messages: u64,
    lost: u64,
    held_back: u64,
    dropped: u64,
    dropped_by: BTreeMap<&'static str, u32>,
}

/// It ended before anything came.
#[derive(Debug, Error, Diagnostic)]
#[error("no sample came: {} is as it was", file.display())]
#[diagnostic(help("record for longer; `shisen tracker monitor` shows what comes"))]
struct Nothing {
    file: PathBuf,
}

/// Runs the command.
pub(super) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let mut feed = Feed::open(&arguments.spec.spec)?;
    let mut recorder = Recorder::create(&arguments.file)?;
    let (mut samples, mut messages) = (0, 0);
    let followed = follow(&mut feed, &arguments.end, &mut |feed, heard| {
        let lost = feed.counts().lost;
        for event in &heard.events {
            samples += u64::from(matches!(event, Event::Sample(_)));
            messages += u64::from(matches!(event, Event::Message(_)));
            recorder.push(event, lost)?;
        }
        Ok(true)
    });
    // What came before a failure is kept.
    recorder.finish()?;
    followed?;
    if samples + messages == 0 {
        let file = arguments.file.clone();
        return Err(Nothing { file }.into());
    }
    let counts = feed.counts();
    let report = Report {
        file: arguments.file.display().to_string(),
        samples,
        messages,
        lost: counts.lost,
        held_back: feed.held_back(),
        dropped: counts.dropped.iter().map(|&count| u64::from(count)).sum(),
        dropped_by: by_reason(&counts),
    };
    print(&report, arguments.json)
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            file,
            samples,
            messages,
            lost,
            held_back: _,
            dropped,
            dropped_by,
        } = self;
        write!(
            f,
            "{file}: {samples} samples, {messages} messages; lost {lost}, dropped {dropped}{}",
            ByReason(dropped_by)
        )
    }
}
