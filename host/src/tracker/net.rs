//! Trackers on the network: opened, listened to, and opened again when they break.

mod datagrams;
mod exchange;
mod lines;
mod lsl;
mod natnet;
mod socket;
mod spec;
mod vrpn;

pub(crate) use lsl::{Stream, streams};
pub(super) use spec::KINDS;
pub use spec::{Datagrams, GazeSpec, LslSpec, NetSpec, Server};
pub(crate) use vrpn::devices;

use super::notice::Notice;
use super::raw::{Piece, Tap};
use crate::files::{Fault, with_help};
use shisen_tracker::decoder::{Counts, DropReason, Event, Message};
use shisen_tracker::time::Micros;
use std::time::{Duration, Instant};

/// How long a peer may take to say what it has: at first, and when it is opened again.
const PATIENCE: [Duration; 2] = [Duration::from_secs(2), Duration::from_millis(500)];

/// The first and the longest wait before a peer that broke is opened again.
const BACK_OFF: [Micros; 2] = [Micros::from_millis(500), Micros::from_millis(10_000)];

/// Silence that is told, and by how much longer it has to last to be told again.
const SILENCE: Micros = Micros::from_millis(2_000);
const TOLD_AGAIN: u64 = 5;

/// A head farther from the origin, metres, is measured in other units.
const FARTHEST: f32 = 30.0;

/// The other end, while it lasts.
trait Peer: Send {
    /// Hands over what comes within 2 ms.
    ///
    /// # Errors
    /// Why nothing more will come.
    fn poll(
        &mut self,
        now: &dyn Fn() -> Micros,
        sink: &mut dyn FnMut(Notice),
    ) -> Result<(), String>;

    fn counts(&self) -> Counts;

    /// Returns whether it has said anything of late, as far as it says anything of itself.
    fn is_present(&self, _now: Micros) -> bool {
        true
    }

    /// Returns what to do where nothing comes.
    fn remedy(&self) -> String;

    /// Returns whether it has come to its end, and is not to be opened again.
    fn is_over(&self) -> bool {
        false
    }
}

/// A tracker on the network.
pub(super) struct Net {
    spec: NetSpec,
    name: String,
    tap: Tap,
    peer: Option<Box<dyn Peer>>,
    /// The counts of peers before.
    before: Counts,
    retry_at: Micros,
    back_off: Micros,
    /// Why it was not opened again.
    refusal: Option<String>,
    /// When the newest sample came, or the tracker was opened.
    heard: Micros,
    /// The silence that is told next.
    telling: Micros,
    is_far_told: bool,
    /// The counts when silence was told last.
    dropped: Counts,
    /// Whether silence is usual: a wand that nobody moves.
    may_be_silent: bool,
    /// Whether the delay of samples was given: exchanges with the device find no other.
    is_delay_given: bool,
    /// What is told first.
    first: Option<String>,
}

impl Net {
    /// Opens a tracker and waits until it says what it has.
    pub(super) fn open(spec: NetSpec, delay: Option<Micros>, tap: Tap) -> Result<Self, Fault> {
        let name = spec.to_string();
        let peer = spec.open(PATIENCE[0], &tap)?;
        let is_known = delay.is_some() || spec.knows_delay();
        let first = (!is_known).then(|| {
            format!(
                "{name} does not say how long its samples are under way: the fastest ones count as \
                 measured when they come; give delay=S, in seconds, if you know better"
            )
        });
        Ok(Self {
            spec,
            name,
            tap,
            peer: Some(peer),
            before: Counts::new(),
            retry_at: Micros(0),
            back_off: BACK_OFF[0],
            refusal: None,
            heard: Micros(0),
            telling: SILENCE,
            is_far_told: false,
            dropped: Counts::new(),
            may_be_silent: false,
            is_delay_given: delay.is_some(),
            first,
        })
    }

    /// Tells neither of silence nor of unknown delays.
    pub(super) fn be_quiet(&mut self) {
        self.may_be_silent = true;
        self.first = None;
    }

    pub(super) fn counts(&self) -> Counts {
        let counts = self.peer.as_ref().map(|peer| peer.counts());
        counts.map_or(self.before, |counts| self.before.plus(&counts))
    }

    /// Returns whether the other end is there.
    pub(super) fn is_present(&self, now: Micros) -> bool {
        let peer = self.peer.as_ref();
        peer.is_some_and(|peer| peer.is_present(now))
    }

    pub(super) fn is_over(&self) -> bool {
        self.peer.as_ref().is_some_and(|peer| peer.is_over())
    }

    /// Hands over what comes within 2 ms.
    pub(super) fn poll(&mut self, start: Instant, sink: &mut dyn FnMut(Notice)) {
        let now = || Micros(start.elapsed().as_micros() as u64);
        let Some(peer) = &mut self.peer else {
            return self.open_again(now(), sink);
        };
        self.first
            .take()
            .map(Notice::Said)
            .into_iter()
            .for_each(&mut *sink);
        let (is_delay_given, back_off) = (self.is_delay_given, &mut self.back_off);
        let mut newest = None;
        let mut farthest = 0.0_f32;
        let polled = peer.poll(&now, &mut |notice| {
            if let Notice::Decoded(Event::Sample(_) | Event::Message(_)) = &notice {
                *back_off = BACK_OFF[0];
            }
            if let Notice::Decoded(Event::Message(Message::Control(_))) = &notice {
                newest = newest.or(Some(now()));
            }
            if let Notice::Decoded(Event::Sample(sample)) = &notice {
                newest = Some(sample.arrival);
                let place = sample.head.position.filter(|place| place.tracked);
                farthest = farthest.max(place.map_or(0.0, |place| place.value.length()));
            }
            if !(is_delay_given && matches!(notice, Notice::Offset { .. })) {
                sink(notice);
            }
        });
        if !self.may_be_silent {
            self.watch(newest, now(), sink);
        }
        if farthest > FARTHEST && !std::mem::replace(&mut self.is_far_told, true) {
            sink(Notice::Said(format!(
                "{}: the head is {farthest:.0} m from the origin: it is taken for metres, and may be \
                 in other units",
                self.name
            )));
        }
        if let Err(reason) = polled {
            self.before = self.counts();
            self.peer = None;
            self.retry_at = now().after(self.back_off);
            // One that breaks before it has sent anything is left alone for longer.
            self.back_off = Micros(2 * self.back_off.0).min(BACK_OFF[1]);
            let path = self.name.clone();
            sink(Notice::Unplugged { path, reason });
        }
    }

    /// Tells of silence, and of its end.
    fn watch(&mut self, newest: Option<Micros>, now: Micros, sink: &mut dyn FnMut(Notice)) {
        let (name, silent) = (&self.name, now.since(self.heard));
        if let Some(newest) = newest {
            if self.telling > SILENCE {
                let seconds = newest.since(self.heard).seconds();
                sink(Notice::Said(format!(
                    "{name} sends again, after {seconds:.1} s"
                )));
            }
            (self.heard, self.telling) = (newest, SILENCE);
        } else if silent >= self.telling
            && let Some(peer) = self.peer.as_ref().filter(|peer| !peer.is_over())
        {
            let counts = self.before.plus(&peer.counts());
            let remedy = dropped_since(&self.dropped, &counts).unwrap_or_else(|| peer.remedy());
            let seconds = silent.seconds();
            sink(Notice::Said(format!(
                "no sample has come from {name} for {seconds:.0} s: {remedy}"
            )));
            self.dropped = counts;
            self.telling = Micros(TOLD_AGAIN * self.telling.0);
        }
    }

    fn open_again(&mut self, now: Micros, sink: &mut dyn FnMut(Notice)) {
        if now < self.retry_at {
            std::thread::sleep(socket::WAIT);
            return;
        }
        match self.spec.open(PATIENCE[1], &self.tap) {
            Ok(peer) => {
                self.peer = Some(peer);
                self.refusal = None;
                sink(Notice::Said(format!("{} is back", self.name)));
            }
            Err(fault) => {
                let reason = with_help(&fault);
                if self.refusal.as_ref() != Some(&reason) {
                    sink(Notice::Refused(reason.clone()));
                    self.refusal = Some(reason);
                }
                self.back_off = Micros(2 * self.back_off.0).min(BACK_OFF[1]);
                self.retry_at = now.after(self.back_off);
            }
        }
    }
}

impl NetSpec {
    /// Opens the peer, which may take as long as `patience` for each of its answers.
    fn open(&self, patience: Duration, tap: &Tap) -> Result<Box<dyn Peer>, Fault> {
        if !matches!(self, Self::NatNet { .. }) {
            tap.take(Piece::Opened, &[], Micros(0));
        }
        Ok(match self {
            Self::Vrpn { device, server } => {
                Box::new(vrpn::Client::open(device, server, patience, tap.clone())?)
            }
            Self::Datagrams { listen, protocol } => {
                Box::new(datagrams::Listener::open(*listen, protocol, tap.clone())?)
            }
            Self::NatNet { server, body, axes } => {
                let body = body.as_deref();
                Box::new(natnet::Client::open(server, body, *axes, patience, tap)?)
            }
            Self::Lsl(spec) => Box::new(lsl::Inlet::open(spec, patience)?),
            Self::Stdin => Box::new(lines::Lines::of_stdin()),
            Self::Lines(server) => Box::new(lines::Lines::connect(server, patience)?),
        })
    }
}

/// Says what became of bytes that came and gave no sample; `None` where none came.
pub(crate) fn dropped_since(before: &Counts, now: &Counts) -> Option<String> {
    let reasons = DropReason::ALL.into_iter().filter_map(|reason| {
        let count = now.dropped_for(reason) - before.dropped_for(reason);
        (count > 0).then(|| format!("{count} {}", reason.name()))
    });
    let reasons = reasons.collect::<Vec<_>>().join(", ");
    let is_far =
        now.dropped_for(DropReason::OutOfRange) > before.dropped_for(DropReason::OutOfRange);
    let hint = if is_far {
        "numbers are not finite, or the head is farther than 100 m: its unit may be millimetres"
    } else {
        "see that its protocol, version and settings are those of the SPEC"
    };
    (!reasons.is_empty()).then(|| format!("what comes is dropped ({reasons}); {hint}"))
}

#[cfg(all(test, unix))]
mod tests;
