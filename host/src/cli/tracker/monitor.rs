//! `shisen tracker monitor`: what a tracker sends, as it comes.

use super::TrackerName;
use super::follow::{EndArguments, follow};
use super::sample::{Record, Records};
use crate::cli::output;
use crate::cli::prelude::*;
use crate::tracker::calibration::{Calibrated, estimation};
use crate::tracker::{Feed, Intake, Role};
use shisen_tracker::clock::{ClockConfig, ClockEstimator};
use shisen_tracker::decoder::Event;
use shisen_tracker::estimate::{GazeEstimator, Sensors};
use shisen_tracker::time::Micros;
use std::io::{self, IsTerminal, Write};

/// Shows what a tracker sends
#[derive(Debug, Args)]
pub(in crate::cli) struct Arguments {
    /// The tracker: see `shisen tracker --help`
    #[arg(value_name = "SPEC")]
    spec: TrackerName,
    /// File of `shisen tracker calibrate`, to show where the viewer looks
    #[arg(long, value_name = "TOML")]
    calibration: Option<PathBuf>,
    #[command(flatten)]
    end: EndArguments,
    /// Print one JSON object a sample
    #[arg(long)]
    json: bool,
}

pub(super) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let spec = arguments.spec.alone()?;
    let calibration = arguments
        .calibration
        .as_deref()
        .or(spec.calibration.as_deref());
    let calibrated = calibration.map(|path| Calibrated::load(path, spec));
    let calibrated = calibrated.transpose()?;
    let mut feed = Feed::open(spec)?;
    let clock = ClockEstimator::new(ClockConfig::default()).or_fail()?;
    let intake = Intake::new(Role::All, clock, spec, calibrated.as_ref());
    let sight = calibrated.map(|calibrated| {
        let head = calibrated.head();
        let mut config = estimation(spec, feed.senses(spec), head, Some(&calibrated));
        // The intake chooses the sensor.
        config.sensors = Sensors::All;
        GazeEstimator::new(config).or_fail()
    });
    let json = arguments.json;
    let mut records = Records::new(intake, sight.transpose()?);
    let mut screen = Screen {
        json,
        live: !json && io::stdout().is_terminal(),
        shown: None,
    };
    let shown = follow(&mut feed, &arguments.end, spec.head, &mut |feed, heard| {
        let counts = feed.counts();
        records.held_back = feed.held_back();
        if heard.features.is_some() {
            records.described.clone_from(&heard.features);
        }
        if let Some((at, offset)) = heard.offset {
            records.hear_offset(at, offset);
        }
        for event in &heard.events {
            match event {
                Event::Sample(sample) if spec.head.is_some_and(|own| own != sample.sensor) => {}
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
    if screen.live && screen.shown.is_some() {
        // The error that ended the command matters more.
        let _ = output::write(|stdout| writeln!(stdout));
    }
    shown
}

/// Standard output: one line that changes, or a line for each record.
struct Screen {
    json: bool,
    live: bool,
    /// When the line changed last.
    shown: Option<Micros>,
}

/// Least time between two changes of the line.
const LIVE_STEP: Micros = Micros(50_000);

impl Screen {
    /// Prints a record; returns whether somebody still reads.
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
}
