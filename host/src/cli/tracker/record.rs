//! `shisen tracker record`: what a tracker sends, into a file.

use super::TrackerName;
use super::drops::{by_reason, in_words};
use super::follow::{EndArguments, follow};
use crate::cli::prelude::*;
use crate::tracker::{Feed, Recorder};
use shisen_tracker::decoder::Event;
use std::collections::BTreeMap;

/// Records a tracker
#[derive(Debug, Args)]
pub(in crate::cli) struct Arguments {
    /// The tracker: see `shisen tracker --help`
    #[arg(value_name = "SPEC")]
    spec: TrackerName,
    /// File to write; an older one is overwritten at the first sample, with --raw at once
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// Keep the bytes as they come, with their times, and no samples; replay:FILE decodes them again
    #[arg(long)]
    raw: bool,
    #[command(flatten)]
    end: EndArguments,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

/// A recording.
#[derive(Debug, Serialize, JsonSchema)]
pub(in crate::cli) struct Report {
    /// File of the recording.
    file: String,
    /// Samples recorded.
    samples: u64,
    /// Messages recorded.
    messages: u64,
    /// Samples lost, by the device's count.
    lost: u64,
    /// Unused samples that came before the device was told what to send.
    held_back: u64,
    /// Drops of bytes.
    dropped: u64,
    /// Drops of bytes by reason.
    dropped_by: BTreeMap<&'static str, u32>,
}

pub(super) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let spec = arguments.spec.alone()?;
    let (mut feed, mut recorder) = if arguments.raw {
        let (feed, bytes) = Feed::open_raw(&arguments.spec.to_string(), spec)?;
        (feed, Recorder::of_bytes(&arguments.file, bytes)?)
    } else {
        (Feed::open(spec)?, Recorder::create(&arguments.file)?)
    };
    let (mut samples, mut messages) = (0, 0);
    let followed = follow(&mut feed, &arguments.end, None, &mut |feed, heard| {
        recorder.keep_bytes()?;
        let lost = feed.counts().lost;
        for event in &heard.events {
            samples += u64::from(matches!(event, Event::Sample(_)));
            messages += u64::from(matches!(event, Event::Message(_)));
            recorder.push(event, lost)?;
        }
        Ok(true)
    });
    // Samples before a failure are kept.
    recorder.finish()?;
    if arguments.raw && followed.is_err() {
        // A fault is found by bytes that give no sample.
        say(&format!("what came is in {}", arguments.file.display()));
    }
    followed?;
    if samples + messages == 0 && !arguments.raw {
        let message = format!("no sample came: {} is unchanged", arguments.file.display());
        let help = "record for longer; `shisen tracker monitor` shows what comes";
        return Err(Fault::new(message, help).into());
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
        let (file, samples, messages) = (&self.file, self.samples, self.messages);
        let (lost, dropped, reasons) = (self.lost, self.dropped, in_words(&self.dropped_by));
        write!(f, "{file}: {samples} samples, {messages} messages; ")?;
        write!(f, "lost {lost}, dropped {dropped}{reasons}")
    }
}
