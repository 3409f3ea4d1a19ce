//! What a tracker says, whichever it is.

use super::calibration::{ScriptError, read_script, scripted};
use super::hid::Features;
use super::live::{Live, LiveError};
use super::protocol::Protocol;
use super::recording::{Recording, RecordingError};
use super::spec::{MockSpec, Spec};
use miette::Diagnostic;
use shisen_tracker::command::Failure;
use shisen_tracker::decoder::{Counts, Decoder, Event};
use shisen_tracker::mock::{MockError, Source, Tracker, TrackerConfig, Viewer, ViewerConfig, Wire};
use shisen_tracker::sample::Sample;
use shisen_tracker::time::Micros;
use std::collections::VecDeque;
use std::time::Instant;
use thiserror::Error;

/// Something that a feed has to say.
#[derive(Debug, Clone, PartialEq)]
pub enum Notice {
    /// A decoder handed this over.
    Decoded(Box<Event>),
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
    Trouble(Failure),
}

/// Why there is no feed.
#[derive(Debug, Error, Diagnostic)]
pub enum FeedError {
    /// The mock refuses its configuration.
    #[error("{0}")]
    #[diagnostic(help("change the mock's options"))]
    Mock(MockError),
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

/// A tracker that says something from time to time.
pub struct Feed {
    start: Instant,
    kind: Kind,
}

enum Kind {
    /// Samples as they are, and how many so far.
    Samples(Box<Tracker<'static>>, Counts),
    Bytes(Box<Wire<Tracker<'static>>>, Box<dyn Decoder + Send>),
    /// Each with the counts at it, and the last that were reached.
    Replay(VecDeque<(Event, Counts)>, Counts),
    Live(Box<Live>),
}

/// The simulated tracker of a specification.
///
/// # Errors
/// A rate that it refuses, and targets that cannot be read.
pub fn simulated(spec: &MockSpec) -> Result<Tracker<'static>, FeedError> {
    let config = TrackerConfig {
        rate: spec.rate,
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
                        let wire = Wire::new(tracker, protocol.format().clone());
                        Kind::Bytes(Box::new(wire), decoder)
                    }
                    None => Kind::Samples(Box::new(tracker), Counts::new()),
                }
            }
            Spec::Replay(spec) => {
                let recording = Recording::read(&spec.path)?;
                let events = recording.events.into_iter().zip(recording.counts);
                Kind::Replay(events.collect(), Counts::new())
            }
            Spec::Serial(spec) => Kind::Live(Box::new(Live::serial(spec.clone())?)),
            Spec::Hid(spec) => Kind::Live(Box::new(Live::hid(spec.clone())?)),
        };
        let start = Instant::now();
        Ok(Self { start, kind })
    }

    /// When it was opened, which is time 0 on its clock.
    pub const fn opened(&self) -> Instant {
        self.start
    }

    /// Since it was opened.
    pub fn now(&self) -> Micros {
        Micros(self.start.elapsed().as_micros() as u64)
    }

    /// Whether it goes by the clock on the wall: a device, that is. The others
    /// can be asked for any time.
    pub const fn is_live(&self) -> bool {
        matches!(self.kind, Kind::Live(_))
    }

    /// Whether nothing more will come.
    pub fn is_over(&self) -> bool {
        matches!(&self.kind, Kind::Replay(events, _) if events.is_empty())
    }

    /// Whether its device is being reset, which takes up to 20 s in which
    /// nothing comes.
    pub fn is_resetting(&self) -> bool {
        matches!(&self.kind, Kind::Live(live) if live.is_resetting())
    }

    /// What became of the bytes, or the samples, so far.
    pub fn counts(&self) -> Counts {
        match &self.kind {
            Kind::Samples(_, counts) | Kind::Replay(_, counts) => *counts,
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
                    sink(Notice::Decoded(Box::new(Event::Sample(sample))));
                }
            }
            Kind::Bytes(wire, decoder) => {
                while let Some(chunk) = wire.poll(until) {
                    decoder.feed(chunk.bytes(), chunk.arrival, &mut |event| {
                        sink(Notice::Decoded(Box::new(event)));
                    });
                }
            }
            Kind::Replay(events, counts) => {
                while let Some((event, now)) = events.pop_front_if(
                    |(event, _)| !matches!(event, Event::Sample(sample) if sample.arrival > until),
                ) {
                    *counts = now;
                    sink(Notice::Decoded(Box::new(event)));
                }
            }
            Kind::Live(live) => live.poll(self.start, sink),
        }
    }

    /// What has a head, and what has eyes: by the protocol, or by what was
    /// recorded.
    pub fn senses(&self, spec: &Spec) -> Senses {
        let of = |protocol: Option<&Protocol>| Senses {
            head: protocol.is_none_or(Protocol::has_head),
            eyes: protocol.is_none_or(Protocol::has_eyes),
        };
        match (spec, &self.kind) {
            (Spec::Mock(spec), _) => of(spec.protocol.as_ref()),
            (Spec::Serial(spec), _) => of(Some(&spec.protocol)),
            (_, Kind::Live(live)) => of(live.protocol()),
            (_, Kind::Replay(events, _)) => {
                let any = |has: fn(&Sample) -> bool| {
                    let mut events = events.iter();
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
