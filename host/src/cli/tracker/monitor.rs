//! `shisen tracker monitor`: what a tracker says, as it says it.

use super::TrackerName;
use super::follow::{EndArguments, follow};
use super::sample::{Record, Records};
use crate::cli::output;
use crate::cli::output::failure::Failure;
use crate::tracker::Feed;
use crate::tracker::calibration::{Calibrated, estimation};
use clap::Args;
use shisen_tracker::decoder::Event;
use shisen_tracker::estimate::GazeEstimator;
use shisen_tracker::time::Micros;
use std::io::{self, IsTerminal, Write};
use std::path::PathBuf;

/// Shows what a tracker says
///
/// Prints a line a sample, at once; on a terminal one line that changes. What
/// happens to the device (plugged in, gone, refused, silent, not understood), what it
/// says of itself (an eye tracker's capabilities, configuration and status, faults, states, texts, refused commands, eyes lost and found), what
/// happens to its clock (jumps, single wrong times, a standstill) and, with --calibration, to the
/// gaze (samples that are not used, and why) goes to standard error, each kind once
/// a second at most.
///
/// With --json, one object a sample: number (from 0), `arrival_us` (since the
/// start), `device_us` (by the device's clock, null where it has none),
/// `late_us` (the delay beyond the least of the last seconds; null where there
/// is no device time, or none that moves), clock (the device's: runs, stands
/// still or none), sensor, sequence, head (position (metres), orientation (x, y, z, w), each with its
/// value and whether it is tracked, `angular_velocity` (rad/s)), `gaze_frame`
/// (head or tracker), left, right and combined (null, or origin, direction,
/// `pupil_m`, `pupil_raw` and openness), `gaze_point` (kind (plane, normalized
/// or raw), value, tracked), `line_of_sight` (null without --calibration:
/// position (metres) and direction in the room, and state, as `shisen cave` has
/// it), `rate_hz`, lost, `held_back` (samples that came before the device was told what
/// to send, and are not used), dropped, `dropped_by` (how often, by reason),
/// `dropped_bytes`, device: null but in the first record after an eye tracker of
/// usage page 0x12 was plugged in, which has what `shisen tracker list` has as its
/// features, and said: what the device said since the record before, 64 things at most,
/// each with its kind: fault and state (code, and meaning, as its manual has it), text
/// (text), reply (to a command, by its number; result, 0 where it agrees; meaning) and eyes
/// (event: blink, closed, opened, lost, found, saccade or fixation; eye: left, right or null
/// for both; `device_us`; `duration_us`, null but of what is over). The plain line ends with
/// what happened to the eyes.
#[derive(Debug, Args)]
pub(in crate::cli) struct Arguments {
    /// Which tracker: see `shisen tracker --help`
    #[arg(value_name = "SPEC")]
    spec: TrackerName,
    /// What `shisen tracker calibrate` wrote for it: says where the viewer looks
    #[arg(long, value_name = "TOML")]
    calibration: Option<PathBuf>,
    #[command(flatten)]
    end: EndArguments,
    /// Print one JSON object a sample
    #[arg(long)]
    json: bool,
}

/// Runs the command.
pub(super) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let spec = &arguments.spec.spec;
    let calibration = arguments.calibration.as_deref();
    let calibrated = calibration.map(|path| Calibrated::load(path, spec));
    let calibrated = calibrated.transpose()?;
    let mut feed = Feed::open(spec)?;
    let sight = calibrated.map(|calibrated| {
        let head = calibrated.head();
        let config = estimation(spec, feed.senses(spec), head, Some(&calibrated));
        GazeEstimator::new(config).map_err(Failure::from_error)
    });
    let records = Records::new(sight.transpose()?);
    show(&mut feed, records, &arguments.end, arguments.json)
}

/// Shows a feed.
pub(super) fn show(
    feed: &mut Feed,
    mut records: Records,
    end: &EndArguments,
    json: bool,
) -> Result<(), Failure> {
    let mut screen = Screen::new(json);
    let shown = follow(feed, end, &mut |feed, heard| {
        let counts = feed.counts();
        records.hold_back(feed.held_back());
        if let Some(features) = &heard.features {
            records.describe(features);
        }
        for event in &heard.events {
            match event {
                Event::Sample(sample) => {
                    let record = records.next(sample, &counts);
                    let goes_on = screen.print(&record, sample.arrival)?;
                    if !goes_on {
                        return Ok(false);
                    }
                }
                Event::Message(message) => records.hear(message, feed.now()),
                _ => {}
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
        Ok(if self.live {
            output::write(|stdout| write!(stdout, "\r\x1b[K{record}"))?
        } else {
            output::print_one(record, self.json)?
        })
    }

    fn end(&self) {
        if self.live && self.shown.is_some() {
            // What ended it matters more.
            let _ = output::write(|stdout| writeln!(stdout));
        }
    }
}
