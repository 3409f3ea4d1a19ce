//! The events of a tracker of any kind.

use super::live::Live;
use super::net::Net;
use super::notice::Notice;
use super::protocol::ProtocolSpec;
use super::raw::{Piece, RawBytes, Tap};
use super::recording::Recording;
use super::script::{read_script, scripted};
use super::spec::{MockSpec, Spec, TrackerKind};
use crate::files::Fault;
use shisen_tracker::decoder::{Counts, Decoder, Event};
use shisen_tracker::mock::{Line, Source, Tracker, TrackerConfig, Viewer, ViewerConfig};
use shisen_tracker::protocol::Protocol;
use shisen_tracker::sample::Sample;
use shisen_tracker::time::Micros;
use std::collections::VecDeque;
use std::fmt;
use std::time::Instant;

/// The clock of a [`Feed`], on which samples arrive.
#[derive(Debug, Clone, Copy)]
pub struct FeedClock {
    start: Instant,
    /// What the clock shows at the start.
    begin: Micros,
}

impl FeedClock {
    /// Returns what the clock showed at the start.
    pub const fn begin(&self) -> Micros {
        self.begin
    }

    /// Converts a time of the system's clock; earlier ones become the feed's opening.
    pub fn at(&self, instant: Instant) -> Micros {
        let since = instant.saturating_duration_since(self.start);
        self.begin.after(Micros(since.as_micros() as u64))
    }
}

/// An open tracker, whose events are polled.
pub struct Feed {
    clock: FeedClock,
    kind: Kind,
}

enum Kind {
    /// Samples that pass through no protocol, and their count.
    Samples(Box<Tracker<'static>>, Counts),
    Bytes(Box<Line<Tracker<'static>>>, Box<dyn Decoder + Send>, Tap),
    Replay(Replay),
    Live(Box<Live>),
    Net(Box<Net>),
}

struct Replay {
    events: VecDeque<(Event, Counts)>,
    counts: Counts,
    /// When the last sample came, or the first will.
    last: Micros,
    pause_reported: bool,
}

/// Gaps of a recording longer than this are reported.
pub const PAUSE: Micros = Micros::from_millis(2_000);

impl Replay {
    fn new(recording: Recording) -> Self {
        Self {
            last: recording.begin(),
            events: recording.events.into(),
            counts: Counts::new(),
            pause_reported: false,
        }
    }

    fn poll(&mut self, until: Micros, sink: &mut dyn FnMut(Notice)) {
        while let Some((event, _)) = self.events.front() {
            if let Event::Sample(sample) = event {
                let pause = sample.arrival.since(self.last);
                if pause > PAUSE && !self.pause_reported && until >= self.last {
                    self.pause_reported = true;
                    sink(Notice::Pause(pause));
                }
                if sample.arrival > until {
                    return;
                }
                self.last = sample.arrival;
                self.pause_reported = false;
            }
            if let Some((event, counts)) = self.events.pop_front() {
                self.counts = counts;
                sink(Notice::Decoded(event));
            }
        }
    }
}

/// Creates the simulated tracker of a specification.
///
/// # Errors
/// A rate that the tracker refuses, and targets that cannot be read.
pub fn simulated(spec: &MockSpec) -> Result<Tracker<'static>, Fault> {
    let config = TrackerConfig {
        rate: spec.rate,
        latency: spec.delay,
        ..TrackerConfig::default()
    };
    let mut moves = ViewerConfig::default();
    if spec.still {
        (moves.head_sway, moves.head_turn) = (0.0, 0.0);
    }
    let viewer = match &spec.targets {
        // Kept until the program ends, as the tracker itself is.
        Some(path) => {
            let script = scripted(&read_script(path)?).leak();
            Viewer::with_script(moves, spec.seed, script)
        }
        None => Viewer::new(moves, spec.seed),
    };
    Tracker::new(config, viewer, spec.seed)
        .map_err(|reason| Fault::new(reason.to_string(), "change the mock's options"))
}

impl fmt::Debug for Feed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Feed").finish_non_exhaustive()
    }
}

impl Feed {
    /// Opens a tracker. Its clock starts now, at 0, or at a recording's first sample.
    ///
    /// # Errors
    /// A device that cannot be opened, and a file that is no recording.
    pub fn open(spec: &Spec) -> Result<Self, Fault> {
        Self::tapped(spec, Tap::default())
    }

    /// Opens a tracker by its SPEC, and keeps the bytes that come.
    ///
    /// # Errors
    /// As [`Self::open`]; a tracker whose bytes are not kept.
    pub fn open_raw(name: &str, spec: &Spec) -> Result<(Self, RawBytes), Fault> {
        let (bytes, tap) = RawBytes::new(name, spec)?;
        Ok((Self::tapped(spec, tap)?, bytes))
    }

    fn tapped(spec: &Spec, tap: Tap) -> Result<Self, Fault> {
        let kind = match &spec.kind {
            TrackerKind::Mock(spec) => {
                let tracker = simulated(spec)?;
                match spec.protocol.as_ref().and_then(|p| Some((p, p.decoder()?))) {
                    Some((protocol, decoder)) => {
                        let line = Line::of(tracker, protocol.device());
                        Kind::Bytes(Box::new(line), decoder, tap)
                    }
                    None => Kind::Samples(Box::new(tracker), Counts::new()),
                }
            }
            TrackerKind::Replay(path) => Kind::Replay(Replay::new(Recording::read(path)?)),
            TrackerKind::Net(net) => {
                Kind::Net(Box::new(Net::open(net.clone(), spec.times.delay, tap)?))
            }
            device => {
                let live = Live::open(device.clone(), tap).map_err(|error| Fault::of(&error))?;
                Kind::Live(Box::new(live))
            }
        };
        let begin = match &kind {
            Kind::Replay(replay) => replay.last,
            _ => Micros(0),
        };
        let start = Instant::now();
        let clock = FeedClock { start, begin };
        Ok(Self { clock, kind })
    }

    /// Returns what the clock showed when the feed was opened.
    pub const fn begin(&self) -> Micros {
        self.clock.begin
    }

    /// Starts the clock anew, when another's started.
    pub(crate) const fn start_with(&mut self, other: &FeedClock) {
        self.clock.start = other.start;
    }

    /// Returns the feed's clock, to convert times of other threads.
    pub const fn clock(&self) -> FeedClock {
        self.clock
    }

    /// Returns what the clock shows.
    pub fn now(&self) -> Micros {
        self.clock.at(Instant::now())
    }

    /// Returns whether it is a device, which polls only the present; others poll any time.
    pub const fn is_live(&self) -> bool {
        matches!(self.kind, Kind::Live(_) | Kind::Net(_))
    }

    /// Takes silence for usual.
    pub(crate) fn let_be_silent(&mut self) {
        if let Kind::Net(net) = &mut self.kind {
            net.be_quiet();
        }
    }

    /// Returns whether what sends is there, as far as that is known.
    pub(crate) fn is_present(&self) -> bool {
        match &self.kind {
            Kind::Net(net) => net.is_present(self.now()),
            _ => !self.is_over(),
        }
    }

    /// Returns whether nothing more will come.
    pub fn is_over(&self) -> bool {
        match &self.kind {
            Kind::Replay(replay) => replay.events.is_empty(),
            Kind::Net(net) => net.is_over(),
            _ => false,
        }
    }

    /// Returns whether the device is silent because it restarts, for up to 20 s.
    pub fn is_resetting(&self) -> bool {
        matches!(&self.kind, Kind::Live(live) if live.is_resetting())
    }

    /// Returns samples that were dropped because they came before the device was set up.
    pub const fn held_back(&self) -> u64 {
        match &self.kind {
            Kind::Live(live) => live.held_back(),
            _ => 0,
        }
    }

    /// Counts of bytes, samples and faults so far.
    pub fn counts(&self) -> Counts {
        match &self.kind {
            Kind::Samples(_, counts) => *counts,
            Kind::Replay(replay) => replay.counts,
            Kind::Bytes(_, decoder, _) => *decoder.counts(),
            Kind::Live(live) => live.counts(),
            Kind::Net(net) => net.counts(),
        }
    }

    /// Hands over what came by `until`. A device is read for 2 ms instead.
    pub fn poll(&mut self, until: Micros, sink: &mut dyn FnMut(Notice)) {
        match &mut self.kind {
            Kind::Samples(tracker, counts) => {
                while let Some(sample) = tracker.poll(until) {
                    counts.samples += 1;
                    sink(Notice::Decoded(Event::Sample(sample)));
                }
            }
            Kind::Bytes(line, decoder, tap) => {
                while let Some(chunk) = line.poll(until) {
                    tap.take(Piece::Came, chunk.bytes(), chunk.arrival);
                    decoder.feed(chunk.bytes(), chunk.arrival, &mut |event| {
                        sink(Notice::Decoded(event));
                    });
                }
            }
            Kind::Replay(replay) => replay.poll(until, sink),
            Kind::Live(live) => live.poll(self.clock.start, sink),
            Kind::Net(net) => net.poll(self.clock.start, sink),
        }
    }

    /// Returns what the tracker measures, by its protocol or by what was recorded.
    pub fn senses(&self, spec: &Spec) -> Senses {
        if let Kind::Replay(replay) = &self.kind {
            let any = |has: fn(&Sample) -> bool| {
                let mut events = replay.events.iter();
                events.any(|(event, _)| matches!(event, Event::Sample(sample) if has(sample)))
            };
            return Senses {
                head: any(|s| s.head.orientation.is_some()),
                eyes: any(|s| {
                    let eyes = [&s.left, &s.right, &s.combined];
                    s.gaze_point.is_some() || eyes.iter().any(|eye| eye.direction.is_some())
                }),
            };
        }
        if let TrackerKind::Net(net) = &spec.kind {
            let [head, eyes] = net.senses();
            return Senses { head, eyes };
        }
        let protocol = spec.protocol().map(ProtocolSpec::protocol);
        Senses {
            head: protocol.is_none_or(Protocol::has_head),
            eyes: protocol.is_none_or(Protocol::has_eyes),
        }
    }
}

/// What a tracker measures.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Senses {
    /// Whether it measures how the head is turned.
    pub head: bool,
    /// Whether it measures where the eyes look.
    pub eyes: bool,
}
