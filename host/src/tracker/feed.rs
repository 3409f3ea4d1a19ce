//! What a tracker says, whichever it is.

use super::calibration::{ScriptError, read_script, scripted};
use super::hid::Features;
use super::live::{Live, LiveError};
use super::protocol::ProtocolSpec;
use super::recording::{Recording, RecordingError};
use super::spec::{MockSpec, Spec};
use miette::Diagnostic;
use shisen_tracker::command::Failure;
use shisen_tracker::decoder::{Counts, Decoder, Event};
use shisen_tracker::mock::{
    Line, Source, Tracker, TrackerConfig, TrackerConfigError, Viewer, ViewerConfig,
};
use shisen_tracker::sample::Sample;
use shisen_tracker::time::Micros;
use std::collections::VecDeque;
use std::fmt;
use std::time::Instant;
use thiserror::Error;

/// Something that a feed has to say.
#[derive(Debug, Clone, PartialEq)]
#[allow(
    clippy::large_enum_variant,
    reason = "nearly all are samples, and none of these is to take memory of its own"
)]
pub enum Notice {
    /// A decoder handed this over.
    Decoded(Event),
    /// The device is there, at this path.
    Plugged(String),
    /// An eye tracker says what it is, right after it was plugged in.
    Described(Box<Features>),
    /// The device is gone; the feed looks for it.
    Unplugged {
        /// Where it was.
        path: String,
        /// What the system said.
        reason: String,
    },
    /// The device is there again but cannot be used; said when that is so for a
    /// while, and again where the reason is another.
    Refused {
        /// Why, and what to do about it.
        reason: String,
    },
    /// Nothing comes that can be understood.
    Trouble(Trouble),
    /// The device was told to restart, and says nothing for so long at most.
    Restarting(Micros),
    /// A recording holds nothing for so long, which is waited for.
    Pause(Micros),
}

/// What is wrong with a device or its line, and what may help.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Trouble {
    /// What is wrong.
    pub failure: Failure,
    /// How many fields the records have that come in, where these are not as many as the
    /// decoder was told ([`Decoder::fields_seen`]).
    pub fields_seen: Option<usize>,
}

impl fmt::Display for Trouble {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.failure.fmt(f)?;
        match self.fields_seen {
            None => Ok(()),
            Some(fields) => write!(
                f,
                "; records of {fields} outputs seem to come in: name as many in SPEC (outputs=)"
            ),
        }
    }
}

/// Why there is no feed.
#[derive(Debug, Error, Diagnostic)]
#[non_exhaustive]
pub enum FeedError {
    /// The mock refuses its configuration.
    #[error("{0}")]
    #[diagnostic(help("change the mock's options"))]
    Mock(TrackerConfigError),
    /// The mock's targets cannot be read.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Script(#[from] ScriptError),
    /// A device that cannot be used.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Live(#[from] LiveError),
    /// A recording that cannot be read.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Recording(#[from] RecordingError),
}

/// The clock of a [`Feed`], which arrivals are told by.
#[derive(Debug, Clone, Copy)]
pub struct FeedClock {
    start: Instant,
    begin: Micros,
}

impl FeedClock {
    /// A time of the system's clock on this one; one before the feed was opened is
    /// that of its opening.
    pub fn at(&self, instant: Instant) -> Micros {
        let since = instant.saturating_duration_since(self.start);
        self.begin.after(Micros(since.as_micros() as u64))
    }
}

/// A tracker that says something from time to time.
pub struct Feed {
    start: Instant,
    /// What its clock showed then.
    begin: Micros,
    kind: Kind,
}

enum Kind {
    /// Samples as they are, and how many so far.
    Samples(Box<Tracker<'static>>, Counts),
    Bytes(Box<Line<Tracker<'static>>>, Box<dyn Decoder + Send>),
    Replay(Replay),
    Live(Box<Live>),
}

/// A recording that is played.
struct Replay {
    /// Each with the counts at it.
    events: VecDeque<(Event, Counts)>,
    /// The last that were reached.
    counts: Counts,
    /// When the last sample came, or the first will.
    last: Micros,
    /// That the next sample is long in coming was said.
    said: bool,
}

/// From how long on a recording that holds nothing is told of.
pub const PAUSE: Micros = Micros::from_millis(2_000);

impl Replay {
    fn new(recording: Recording) -> Self {
        let last = recording.begin();
        let events = recording.events.into_iter().zip(recording.counts);
        Self {
            events: events.collect(),
            counts: Counts::new(),
            last,
            said: false,
        }
    }

    fn poll(&mut self, until: Micros, sink: &mut dyn FnMut(Notice)) {
        while let Some((event, _)) = self.events.front() {
            if let Event::Sample(sample) = event {
                let pause = sample.arrival.since(self.last);
                if pause > PAUSE && !self.said && until >= self.last {
                    self.said = true;
                    sink(Notice::Pause(pause));
                }
                if sample.arrival > until {
                    return;
                }
                self.last = sample.arrival;
                self.said = false;
            }
            if let Some((event, counts)) = self.events.pop_front() {
                self.counts = counts;
                sink(Notice::Decoded(event));
            }
        }
    }
}

/// The simulated tracker of a specification.
///
/// # Errors
/// A rate that it refuses, and targets that cannot be read.
pub fn simulated(spec: &MockSpec) -> Result<Tracker<'static>, FeedError> {
    let config = TrackerConfig {
        rate: spec.rate,
        latency: spec.delay(),
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
    Tracker::new(config, viewer, spec.seed).map_err(FeedError::Mock)
}

impl fmt::Debug for Feed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Feed")
            .field("begin", &self.begin)
            .finish_non_exhaustive()
    }
}

impl Feed {
    /// Of a tracker; its time begins now.
    ///
    /// # Errors
    /// A device that is not there or may not be used, and a file that is no
    /// recording.
    pub fn open(spec: &Spec) -> Result<Self, FeedError> {
        let kind = match spec {
            Spec::Mock(spec) => {
                let tracker = simulated(spec)?;
                match spec.protocol.as_ref().and_then(|p| Some((p, p.decoder()?))) {
                    Some((protocol, decoder)) => {
                        let line = Line::of(tracker, protocol.device());
                        Kind::Bytes(Box::new(line), decoder)
                    }
                    None => Kind::Samples(Box::new(tracker), Counts::new()),
                }
            }
            Spec::Replay(spec) => Kind::Replay(Replay::new(Recording::read(&spec.path)?)),
            Spec::Serial(spec) => Kind::Live(Box::new(Live::serial(spec.clone())?)),
            Spec::Hid(spec) => Kind::Live(Box::new(Live::hid(spec.clone())?)),
        };
        let begin = match &kind {
            Kind::Replay(replay) => replay.last,
            _ => Micros(0),
        };
        let start = Instant::now();
        Ok(Self { start, begin, kind })
    }

    /// What its clock showed when it was opened: 0, but for a recording, which
    /// begins with its first sample.
    pub const fn begin(&self) -> Micros {
        self.begin
    }

    /// Its clock, for those who have another thread's times.
    pub const fn clock(&self) -> FeedClock {
        FeedClock {
            start: self.start,
            begin: self.begin,
        }
    }

    /// What its clock shows.
    pub fn now(&self) -> Micros {
        self.clock().at(Instant::now())
    }

    /// Whether it goes by the clock on the wall: a device, that is. The others
    /// can be asked for any time.
    pub const fn is_live(&self) -> bool {
        matches!(self.kind, Kind::Live(_))
    }

    /// Whether nothing more will come.
    pub fn is_over(&self) -> bool {
        matches!(&self.kind, Kind::Replay(replay) if replay.events.is_empty())
    }

    /// Whether its device is being reset, which takes up to 20 s in which
    /// nothing comes.
    pub fn is_resetting(&self) -> bool {
        matches!(&self.kind, Kind::Live(live) if live.is_resetting())
    }

    /// Samples that came before their device was told what to send, and are not handed on.
    pub const fn held_back(&self) -> u64 {
        match &self.kind {
            Kind::Live(live) => live.held_back(),
            _ => 0,
        }
    }

    /// What became of the bytes, or the samples, so far.
    pub fn counts(&self) -> Counts {
        match &self.kind {
            Kind::Samples(_, counts) => *counts,
            Kind::Replay(replay) => replay.counts,
            Kind::Bytes(_, decoder) => *decoder.counts(),
            Kind::Live(live) => live.counts(),
        }
    }

    /// What came by `until`. A device is listened to for 2 ms instead.
    pub fn poll(&mut self, until: Micros, sink: &mut dyn FnMut(Notice)) {
        match &mut self.kind {
            Kind::Samples(tracker, counts) => {
                while let Some(sample) = tracker.poll(until) {
                    counts.samples += 1;
                    sink(Notice::Decoded(Event::Sample(sample)));
                }
            }
            Kind::Bytes(line, decoder) => {
                while let Some(chunk) = line.poll(until) {
                    decoder.feed(chunk.bytes(), chunk.arrival, &mut |event| {
                        sink(Notice::Decoded(event));
                    });
                }
            }
            Kind::Replay(replay) => replay.poll(until, sink),
            Kind::Live(live) => live.poll(self.start, sink),
        }
    }

    /// What has a head, and what has eyes: by the protocol, or by what was
    /// recorded.
    pub fn senses(&self, spec: &Spec) -> Senses {
        let of = |spec: Option<&ProtocolSpec>| Senses {
            head: spec.is_none_or(|spec| spec.protocol().has_head()),
            eyes: spec.is_none_or(|spec| spec.protocol().has_eyes()),
        };
        match (spec, &self.kind) {
            (Spec::Mock(spec), _) => of(spec.protocol.as_ref()),
            (Spec::Serial(spec), _) => of(Some(&spec.protocol)),
            (_, Kind::Live(live)) => of(live.protocol()),
            (_, Kind::Replay(replay)) => {
                let any = |has: fn(&Sample) -> bool| {
                    let mut events = replay.events.iter();
                    events.any(|(event, _)| matches!(event, Event::Sample(sample) if has(sample)))
                };
                Senses {
                    head: any(|s| s.head.orientation.is_some()),
                    eyes: any(|s| {
                        let eyes = [&s.left, &s.right, &s.combined];
                        s.gaze_point.is_some() || eyes.iter().any(|eye| eye.direction.is_some())
                    }),
                }
            }
            _ => of(None),
        }
    }
}

/// What a tracker measures.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Senses {
    /// How the head is turned.
    pub head: bool,
    /// Where the eyes look.
    pub eyes: bool,
}
