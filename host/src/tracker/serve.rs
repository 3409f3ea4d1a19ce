//! The device's end of a line: samples out, as a device writes them, and the
//! host's commands in.

use super::protocol::ProtocolSpec;
use super::pty::Pty;
use shisen_tracker::mock::{Device, Line, Source};
use shisen_tracker::sample::Sample;
use shisen_tracker::time::Micros;
use std::cell::Cell;
use std::fmt;
use std::io;
use std::time::{Duration, Instant};

/// When what is served begins.
pub enum Begin<'a> {
    /// At once, whether or not somebody reads.
    AtOnce,
    /// When a reader is there and has told the device what to send, has asked for
    /// [`POLLED`] records one by one, or has said nothing for [`SILENT`]; that of a device
    /// that is told nothing once it is there for [`SETTLED`].
    /// It is called with every stage that is reached.
    WithReader(&'a mut dyn FnMut(Stage)),
}

impl fmt::Debug for Begin<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::AtOnce => "AtOnce",
            Self::WithReader(_) => "WithReader",
        })
    }
}

/// How far a line is that waits for its reader.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stage {
    /// Nobody has opened it.
    Unread,
    /// Somebody has, and may have something to say.
    Untold,
    /// It has begun.
    Begun,
}

/// How long a reader is waited for that says nothing: it may still be opening the port,
/// or be silent for as long as it believes that the device restarts.
pub const SILENT: Duration = Duration::from_secs(3);

/// How long a reader has said nothing more when it has told a device all: longer than any
/// device is given between two commands, shorter than any is waited for after the last.
pub const SETTLED: Duration = Duration::from_millis(400);

/// So many records are asked for by a host that polls; one that sets a device up asks for
/// two at most.
pub const POLLED: u8 = 3;

/// How a line that is served stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Turn {
    /// Since it was opened.
    pub now: Micros,
    /// Since it began, if it did.
    pub played: Option<Micros>,
    /// Records that were sent.
    pub sent: u64,
}

/// Serves a line from a source of samples by the clock on the wall, for as
/// long as `goes_on` says so.
///
/// # Errors
/// Those of the line.
pub fn serve(
    pty: &mut Pty,
    source: impl Source<Item = Sample>,
    protocol: &ProtocolSpec,
    begin: Begin<'_>,
    goes_on: &mut dyn FnMut(Turn) -> bool,
) -> io::Result<()> {
    let begun = Cell::new(None);
    let source = Held {
        source,
        begun: &begun,
    };
    let mut line = Line::of(source, protocol.device());
    let mut audience = match begin {
        Begin::AtOnce => {
            begun.set(Some(Micros(0)));
            None
        }
        Begin::WithReader(reached) => {
            pty.release();
            reached(Stage::Unread);
            Some(Audience::new(protocol.is_told(), reached))
        }
    };
    let start = Instant::now();
    let mut sent = 0;
    loop {
        let now = Micros(start.elapsed().as_micros() as u64);
        let played = begun.get().map(|begun| now.since(begun));
        if !goes_on(Turn { now, played, sent }) {
            return Ok(());
        }
        let mut heard = [0; 256];
        let count = pty.receive(&mut heard)?;
        let mut answers = Vec::new();
        line.hear(&heard[..count], now, &mut |answer| {
            answers.extend_from_slice(answer);
        });
        if !answers.is_empty() {
            pty.send(&answers)?;
        }
        if let Some(waiting) = &mut audience
            && waiting.is_ready(pty, count > 0, line.device(), now)?
        {
            begun.set(Some(now));
            audience = None;
        }
        while let Some(record) = line.poll(now) {
            sent += u64::from(pty.send(record.bytes())?);
        }
        std::thread::sleep(Duration::from_micros(500));
    }
}

/// A source that begins some time after the clock that it is polled by.
struct Held<'a, S> {
    source: S,
    begun: &'a Cell<Option<Micros>>,
}

impl<S: Source<Item = Sample>> Source for Held<'_, S> {
    type Item = Sample;

    fn poll(&mut self, until: Micros) -> Option<Sample> {
        let begun = self.begun.get()?;
        let mut sample = self.source.poll(until.since(begun))?;
        sample.arrival = begun.after(sample.arrival);
        Some(sample)
    }
}

/// Whoever reads a line that has not begun.
struct Audience<'a> {
    /// Whether the device is told what to send.
    is_told: bool,
    reached: &'a mut dyn FnMut(Stage),
    /// Since when it is there, or the device is after a restart.
    since: Option<Micros>,
    /// When it last said something.
    heard: Option<Micros>,
}

impl<'a> Audience<'a> {
    fn new(is_told: bool, reached: &'a mut dyn FnMut(Stage)) -> Self {
        Self {
            is_told,
            reached,
            since: None,
            heard: None,
        }
    }

    /// Whether all that it wants is known; `spoke` where it has just said something.
    fn is_ready(
        &mut self,
        pty: &mut Pty,
        spoke: bool,
        device: &Device,
        now: Micros,
    ) -> io::Result<bool> {
        if !pty.is_read()? {
            // Whoever looked at it, and went, is no reader.
            if self.since.is_some() {
                (self.since, self.heard) = (None, None);
                (self.reached)(Stage::Unread);
            }
            return Ok(false);
        }
        if self.since.is_none() {
            self.since = Some(now);
            (self.reached)(Stage::Untold);
        }
        if device.restarts(now) {
            // It is told anew after that.
            (self.since, self.heard) = (Some(now), None);
            return Ok(false);
        }
        if spoke {
            self.heard = Some(now);
        }
        let over = |since: Option<Micros>, wait: Duration| {
            since.is_some_and(|since| now.since(since) >= Micros(wait.as_micros() as u64))
        };
        let ready = match self.heard {
            _ if device.asked() >= POLLED => true,
            Some(_) => over(self.heard, SETTLED) && device.is_to_send(now),
            None => over(self.since, if self.is_told { SILENT } else { SETTLED }),
        };
        if ready {
            pty.hold();
            (self.reached)(Stage::Begun);
        }
        Ok(ready)
    }
}
