//! A simulated device on a line: sends samples and obeys the host's commands.

use crate::tracker::protocol::ProtocolSpec;
use crate::tracker::pty::Pty;
use shisen_tracker::mock::{Device, Line, Source};
use shisen_tracker::sample::Sample;
use shisen_tracker::time::Micros;
use std::cell::Cell;
use std::io;
use std::time::{Duration, Instant};

/// The state of a line that waits for a reader.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LineState {
    /// No program has opened the line.
    NoReader,
    /// A reader has opened the line and may still set the device up.
    SettingUp,
    /// The device sends.
    Sending,
}

/// The wait for a silent reader, which may wait for the device to restart.
pub const SILENT: Duration = Duration::from_secs(3);

/// The silence that ends a set-up: longer than between commands, shorter than for answers.
const SETTLED: Duration = Duration::from_millis(400);

/// Records asked for one by one that show that the host polls; a set-up asks for at most two.
const POLLED: u8 = 3;

/// The progress of a device on a line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Progress {
    /// The time since the line was opened.
    pub now: Micros,
    /// The time since the device started to send; `None` before.
    pub played: Option<Micros>,
    /// The number of records sent.
    pub sent: u64,
}

/// Serves a line from a source of samples in real time, as long as `keep_going` returns true.
///
/// The device sends at once, or with `reached` when a reader has opened the line and is done with
/// set-up: it has told the device what to send, has asked for `POLLED` records one by one, or has
/// been silent for [`SILENT`] (`SETTLED` for a device that takes no commands). `reached` is called
/// with every state that the line reaches.
///
/// # Errors
/// Errors of the line.
pub fn serve(
    pty: &mut Pty,
    source: impl Source<Item = Sample>,
    protocol: &ProtocolSpec,
    reached: Option<&mut dyn FnMut(LineState)>,
    keep_going: &mut dyn FnMut(Progress) -> bool,
) -> io::Result<()> {
    let begun = Cell::new(reached.is_none().then_some(Micros(0)));
    let source = DelayedSource {
        source,
        begun: &begun,
    };
    let mut line = Line::of(source, protocol.device());
    let mut reader = reached.map(|reached| {
        pty.release();
        reached(LineState::NoReader);
        Reader {
            is_told: protocol.is_told(),
            reached,
            since: None,
            heard: None,
        }
    });
    let start = Instant::now();
    let mut sent = 0;
    loop {
        let now = Micros(start.elapsed().as_micros() as u64);
        let played = begun.get().map(|begun| now.since(begun));
        if !keep_going(Progress { now, played, sent }) {
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
        if let Some(waiting) = &mut reader
            && waiting.is_ready(pty, count > 0, line.device(), now)?
        {
            begun.set(Some(now));
            reader = None;
        }
        while let Some(record) = line.poll(now) {
            sent += u64::from(pty.send(record.bytes())?);
        }
        std::thread::sleep(Duration::from_micros(500));
    }
}

/// A source that starts later than the clock that it is polled by.
struct DelayedSource<'a, S> {
    source: S,
    begun: &'a Cell<Option<Micros>>,
}

impl<S: Source<Item = Sample>> Source for DelayedSource<'_, S> {
    type Item = Sample;

    fn poll(&mut self, until: Micros) -> Option<Sample> {
        let begun = self.begun.get()?;
        let mut sample = self.source.poll(until.since(begun))?;
        sample.arrival = begun.after(sample.arrival);
        Some(sample)
    }
}

/// The reader of a line whose device does not send yet.
struct Reader<'a> {
    is_told: bool,
    reached: &'a mut dyn FnMut(LineState),
    /// When the reader came, or the device last restarted.
    since: Option<Micros>,
    heard: Option<Micros>,
}

impl Reader<'_> {
    /// Returns whether the reader is done with set-up; `spoke` where it has just sent something.
    fn is_ready(
        &mut self,
        pty: &mut Pty,
        spoke: bool,
        device: &Device,
        now: Micros,
    ) -> io::Result<bool> {
        if !pty.is_read()? {
            // A program that opened and closed the line is no reader.
            if self.since.is_some() {
                (self.since, self.heard) = (None, None);
                (self.reached)(LineState::NoReader);
            }
            return Ok(false);
        }
        if self.since.is_none() {
            self.since = Some(now);
            (self.reached)(LineState::SettingUp);
        }
        if device.restarts(now) {
            // The reader sets it up anew after that.
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
            (self.reached)(LineState::Sending);
        }
        Ok(ready)
    }
}
