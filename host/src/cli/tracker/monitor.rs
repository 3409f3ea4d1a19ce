//! `shisen tracker monitor`: what a tracker says, as it says it.

use super::super::failure::{Failure, Fault};
use super::follow::{EndArguments, follow};
use super::sample::{Record, Records};
use super::spec;
use clap::Args;
use shisen::tracker::Feed;
use shisen_tracker::decoder::Event;
use shisen_tracker::time::Micros;
use std::io::{self, IsTerminal, Write};

/// Shows what a tracker says
///
/// Prints a line a sample, at once; on a terminal one line that changes. What
/// happens to the device (plugged in, gone, silent, not understood) goes to
/// standard error.
///
/// With --json, one object a sample: number (from 0), `arrival_us` (since the
/// start), `device_us` (by the device's clock, null where it has none),
/// `late_us` (the delay beyond the least of the last seconds), sensor,
/// sequence, head (position (metres), orientation (x, y, z, w), each with its
/// value and whether it is tracked, `angular_velocity` (rad/s)), `gaze_frame`
/// (head or tracker), left, right and combined (null, or origin, direction,
/// `pupil_m`, `pupil_raw` and openness), `gaze_point` (kind (plane, normalized
/// or raw), value, tracked), `rate_hz`, lost, dropped and `dropped_bytes`.
#[derive(Debug, Args)]
pub(in crate::cli) struct Arguments {
    /// Which tracker: see `shisen tracker --help`
    #[arg(value_name = "SPEC")]
    spec: String,
    #[command(flatten)]
    end: EndArguments,
    /// Print one JSON object a sample
    #[arg(long)]
    json: bool,
}

/// Runs the command.
pub(super) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let mut feed = Feed::open(&spec(&arguments.spec)?)?;
    show(&mut feed, &arguments.end, arguments.json)
}

/// Shows a feed.
pub(super) fn show(feed: &mut Feed, end: &EndArguments, json: bool) -> Result<(), Failure> {
    let mut records = Records::new();
    let mut screen = Screen::new(json);
    let shown = follow(feed, end, &mut |feed, events| {
        let counts = feed.counts();
        for event in events {
            if let Event::Sample(sample) = event
                && !screen.print(&records.next(sample, &counts), sample.arrival)?
            {
                return Ok(false);
            }
        }
        Ok(true)
    });
    screen.end();
    shown
}

/// Standard output: one line that changes, or a line a record.
struct Screen {
    json: bool,
    live: bool,
    /// When the one line changed last.
    shown: Option<Micros>,
}

/// Nobody reads faster.
const LIVE_STEP: Micros = Micros(50_000);

impl Screen {
    fn new(json: bool) -> Self {
        let live = !json && io::stdout().is_terminal();
        let shown = None;
        Self { json, live, shown }
    }

    /// Whether anybody still reads.
    fn print(&mut self, record: &Record, now: Micros) -> Result<bool, Failure> {
        if self.live && self.shown.is_some_and(|last| now.since(last) < LIVE_STEP) {
            return Ok(true);
        }
        self.shown = Some(now);
        let mut stdout = io::stdout().lock();
        let written = if self.json {
            let text = serde_json::to_string(record).map_err(io::Error::from);
            text.and_then(|text| writeln!(stdout, "{text}"))
        } else if self.live {
            write!(stdout, "\r\x1b[K{record}")
        } else {
            writeln!(stdout, "{record}")
        };
        match written.and_then(|()| stdout.flush()) {
            Ok(()) => Ok(true),
            // Whoever closed the pipe has read all that was wanted.
            Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Ok(false),
            Err(reason) => Err(Fault::Print { reason }.into()),
        }
    }

    fn end(&self) {
        if self.live && self.shown.is_some() {
            let _ = writeln!(io::stdout());
        }
    }
}
