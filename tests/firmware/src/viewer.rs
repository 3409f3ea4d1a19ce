//! Estimates where the viewer looks from the tracker's bytes.

use crate::board;
use crate::line::Line;
use crate::say;
use shisen_tracker::clock::{ClockConfig, ClockEstimator};
use shisen_tracker::decoder::{Decoder, Event};
use shisen_tracker::estimate::{self, Estimate, EstimatorConfig, GazeEstimator};
use shisen_tracker::link::Link;
use shisen_tracker::link::display::TrackerState;
use shisen_tracker::time::Micros;

/// Numbers of head poses and gazes that are kept: enough for trackers of up to 500 Hz.
const HEAD: usize = 24;
const EYES: usize = 64;

/// The tracker's decoder, clock and gaze estimator.
pub struct Viewer {
    line: Line,
    decoder: Link,
    clock: ClockEstimator,
    gaze: GazeEstimator<HEAD, EYES>,
    records: u32,
    dropped: u32,
    /// Bytes lost for lack of room, as last logged.
    lost: u32,
    /// Whether the tracker's silence was logged.
    waits: bool,
    instructions: u64,
    /// Arrival of the newest record's last byte, ticks.
    newest: Option<u64>,
}

impl Viewer {
    /// Returns a viewer without samples; never `None`, since the default settings are
    /// valid.
    pub fn new(line: Line) -> Option<Self> {
        Some(Self {
            line,
            decoder: Link::new(),
            clock: ClockEstimator::new(ClockConfig::default()).ok()?,
            gaze: GazeEstimator::with_histories(EstimatorConfig::default()).ok()?,
            records: 0,
            dropped: 0,
            lost: 0,
            waits: false,
            instructions: 0,
            newest: None,
        })
    }

    /// Takes the bytes that have come in.
    pub fn listen(&mut self) {
        let lost = self.line.lost();
        if lost != self.lost {
            self.lost = lost;
            say!(warn, "{} bytes of the tracker found no room", lost);
        }
        let mut buffer = [0; 64];
        // Takes at most a full queue, so that a fast line does not hold frames up.
        for _ in 0..4 {
            let arrival = self.line.newest();
            let bytes = self.line.take(&mut buffer);
            if bytes.is_empty() {
                return;
            }
            let before = board::ticks();
            self.take(bytes, arrival);
            self.instructions += board::instructions(before, board::ticks());
        }
    }

    fn take(&mut self, bytes: &[u8], arrival: u64) {
        let Self {
            decoder,
            clock,
            gaze,
            records,
            dropped,
            newest,
            ..
        } = self;
        decoder.feed(bytes, board::micros(arrival), &mut |event| match event {
            Event::Sample(sample) => {
                let stamp = clock.stamp(&sample, &mut |_event| {
                    say!(warn, "tracker's clock: {}", _event);
                });
                gaze.push(&sample, stamp.time, &mut |_| {});
                *records = records.saturating_add(1);
                *newest = Some(arrival);
            }
            Event::Message(message) => gaze.on_message(&message, &mut |_| {}),
            Event::Dropped(lost) => {
                *dropped = dropped.saturating_add(lost.bytes);
                say!(warn, "tracker: {}", lost);
            }
            _ => {}
        });
    }

    /// Returns where the viewer looks at a time.
    pub fn estimate(&mut self, time: Micros) -> Estimate {
        if self.records == 0 && !self.waits {
            self.waits = true;
            say!(
                info,
                "no record of the tracker yet: full quality everywhere"
            );
        }
        self.gaze.estimate(time, &mut |event| {
            if let estimate::Event::State {
                from: _from,
                to: _to,
                ..
            } = event
            {
                say!(info, "gaze: {} after {}", _to, _from);
            }
        })
    }

    /// Returns the arrival of the newest record's last byte, in ticks, if a record came since
    /// the last call.
    pub fn take_newest(&mut self) -> Option<u64> {
        self.newest.take()
    }

    /// Returns the number of records so far.
    pub const fn records(&self) -> u32 {
        self.records
    }

    /// Returns the counts so far.
    pub fn state(&self) -> TrackerState {
        TrackerState {
            records: self.records,
            dropped: self.dropped,
            overrun: self.line.lost(),
            instructions: self.instructions,
            stack_bytes: board::stack_used(),
        }
    }
}
