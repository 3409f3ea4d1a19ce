//! Commands to a device: start, stop, units, lists of items, the line's speed.
//! No function waits for the device.
//!
//! Each device's module makes a [`Script`] of commands and awaited answers. A
//! [`Session`] plays it by the caller's clock: [`Session::poll`] returns the next
//! action at once, [`Session::on_bytes`] and [`Session::on_event`] take what came
//! in. Without an answer in time the script is played again, [`TRIES`] times in
//! all; then the session reports the likely cause, above all a wrong line speed.
//!
//! ```
//! use shisen_tracker::command::{Action, Failure, Session};
//! use shisen_tracker::head::hatire;
//! use shisen_tracker::time::Micros;
//!
//! let mut session = Session::new(hatire::start(false));
//! assert_eq!(session.poll(Micros(0)), Action::Send(b"S"));
//! // No answer comes.
//! assert_eq!(session.poll(Micros(5)), Action::Wait(Micros(1_000_005)));
//! assert_eq!(session.poll(Micros(1_000_005)), Action::Send(b"S"));
//! ```
//!
//! Samples that come before all commands are sent have unknown units: [`SettingUp`] tells how
//! long to hold them back. A program that only listens finds the same faults with a [`Watch`].

mod failure;
mod setting_up;
mod watch;

pub use failure::Failure;
pub use setting_up::SettingUp;
pub use watch::Watch;

use crate::decoder::{Event, Message};
use crate::time::Micros;
use heapless::Vec;
use watch::Useless;

/// Most bytes of one command.
pub const MOST_COMMAND_BYTES: usize = 48;
/// Most bytes that a script sends.
const MOST_SCRIPT_BYTES: usize = 640;
/// Most steps of a script.
const MOST_STEPS: usize = 48;

/// Longest time without a record, or without any byte, before that is a fault.
pub const PATIENCE: Micros = Micros::from_millis(1_000);

/// Number of times that a script is played before it fails.
pub const TRIES: u8 = 3;

/// One command.
pub type Bytes = Vec<u8, MOST_COMMAND_BYTES>;

/// An answer that a script waits for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Awaited {
    /// A sample.
    Sample,
    /// A sample or a message.
    Record,
    /// The reply to the command with this number in
    /// [`Reply::to`](crate::decoder::Reply::to).
    Reply(u32),
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Step {
    /// Send this many of the script's bytes.
    Send(u16),
    /// Send nothing for this time, microseconds.
    Pause(u32),
    Speed(u32),
    Await {
        what: Awaited,
        /// Longest wait, microseconds.
        within: u32,
    },
}

/// Returns a span in half the memory of [`Micros`].
fn short(span: Micros) -> u32 {
    u32::try_from(span.0).unwrap_or(u32::MAX)
}

/// Commands for a device, and the answers to await.
///
/// It takes more than a kilobyte, so its methods fill it in place.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Script {
    bytes: Vec<u8, MOST_SCRIPT_BYTES>,
    steps: Vec<Step, MOST_STEPS>,
    /// The step at which a further try starts.
    again_from: usize,
    /// Whether a command or a step had no room.
    cut: bool,
}

impl Script {
    /// Returns a script without commands.
    pub fn new() -> Self {
        Self::default()
    }

    /// Returns a script that sends these bytes and awaits no answer.
    pub fn sending(bytes: &[u8]) -> Self {
        let mut script = Self::new();
        script.send(bytes);
        script
    }

    /// Adds a step: send these bytes.
    pub fn send(&mut self, bytes: &[u8]) -> &mut Self {
        self.cut |= self.bytes.extend_from_slice(bytes).is_err();
        self.step(Step::Send(bytes.len() as u16))
    }

    /// Adds a step: send nothing for this time, up to an hour.
    pub fn pause(&mut self, span: Micros) -> &mut Self {
        self.step(Step::Pause(short(span)))
    }

    /// Adds a step: change this end's line to this speed, baud.
    pub fn speed(&mut self, baud: u32) -> &mut Self {
        self.step(Step::Speed(baud))
    }

    /// Adds a step: wait for this answer, at most for `within`, up to an hour.
    pub fn expect(&mut self, what: Awaited, within: Micros) -> &mut Self {
        let within = short(within);
        self.step(Step::Await { what, within })
    }

    /// Marks the steps so far (a reset) as played only once, even if an answer fails to come.
    pub fn once_only(&mut self) -> &mut Self {
        self.again_from = self.steps.len();
        self
    }

    /// Returns the sum of the pauses in the part that is played only once (a reset).
    pub fn once_only_time(&self) -> Micros {
        let steps = self.steps.iter().take(self.again_from);
        steps.fold(Micros(0), |sum, step| match step {
            Step::Pause(span) => sum.after(Micros((*span).into())),
            _ => sum,
        })
    }

    /// Returns whether it sends any bytes.
    pub fn sends_bytes(&self) -> bool {
        !self.bytes.is_empty()
    }

    /// Returns whether all steps had room; a [`Session`] refuses an incomplete script.
    pub const fn is_complete(&self) -> bool {
        !self.cut
    }

    fn step(&mut self, step: Step) -> &mut Self {
        self.cut |= self.steps.push(step).is_err();
        self
    }

    /// Returns the bytes that a step sends.
    fn sent_by(&self, step: usize) -> &[u8] {
        let length = |step: &Step| match step {
            Step::Send(length) => usize::from(*length),
            Step::Pause(_) | Step::Speed(_) | Step::Await { .. } => 0,
        };
        let start: usize = self.steps.iter().take(step).map(length).sum();
        let end = start + self.steps.get(step).map_or(0, length);
        self.bytes.get(start..end).unwrap_or_default()
    }
}

/// The next action of a session's caller.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Action<'a> {
    /// Send these bytes, then poll again at once.
    Send(&'a [u8]),
    /// Change the line to this speed, baud, once all sent bytes are out; then poll
    /// again.
    Speed(u32),
    /// Wait until this time, or until bytes come in.
    Wait(Micros),
    /// All commands are sent and answered.
    Done,
    /// [`Session::tries`] tries failed.
    Failed(Failure),
}

/// Plays a [`Script`].
#[derive(Debug, Clone, Default)]
pub struct Session {
    script: Script,
    step: usize,
    /// When the step began; `None` before it is polled.
    since: Option<Micros>,
    tries: u8,
    /// Bytes since the last command was sent; the three counts below are since then, too.
    bytes: u64,
    useless: Useless,
    records: u64,
    samples: u64,
    /// Number and result of the last reply.
    reply: Option<(u32, u32)>,
    /// The first refusal of this try.
    refused: Option<Failure>,
    failed: Option<Failure>,
}

impl Session {
    /// Returns a session at the start of a script.
    pub fn new(script: Script) -> Self {
        let failed = (!script.is_complete()).then_some(Failure::TooLong);
        Self {
            script,
            failed,
            ..Self::default()
        }
    }

    /// Returns how many answers failed to come; after each but the third the script starts again.
    pub const fn tries(&self) -> u8 {
        self.tries
    }

    /// Returns whether all commands are sent; records before that may have other units.
    pub fn is_complete(&self) -> bool {
        let mut rest = self.script.steps.iter().skip(self.step);
        rest.all(|step| matches!(step, Step::Await { .. }))
    }

    /// Counts bytes that came in.
    pub fn on_bytes(&mut self, count: usize) {
        self.bytes = self.bytes.saturating_add(count as u64);
    }

    /// Takes note of a decoder's event.
    pub fn on_event(&mut self, event: &Event) {
        match event {
            Event::Sample(_) => self.samples = self.samples.saturating_add(1),
            Event::Message(Message::Reply(reply)) => {
                self.reply = Some((reply.to, reply.result));
                if reply.result != 0 {
                    self.refused.get_or_insert(Failure::Refused {
                        command: reply.to,
                        result: reply.result,
                        meaning: reply.meaning,
                    });
                }
            }
            Event::Message(_) => {}
            Event::Dropped(dropped) => return self.useless.note(*dropped, false),
        }
        self.records = self.records.saturating_add(1);
    }

    /// Returns the next action; after [`Action::Done`] or [`Action::Failed`] it stays the same.
    pub fn poll(&mut self, now: Micros) -> Action<'_> {
        // Each round but the last moves one step on, or back to the start of a try.
        for _ in 0..2 * MOST_STEPS {
            if let Some(failure) = self.failed {
                return Action::Failed(failure);
            }
            let Some(&step) = self.script.steps.get(self.step) else {
                return Action::Done;
            };
            match step {
                Step::Send(_) => {
                    let sending = self.step;
                    self.next();
                    (self.bytes, self.records, self.samples, self.reply) = (0, 0, 0, None);
                    self.useless = Useless::default();
                    return Action::Send(self.script.sent_by(sending));
                }
                Step::Speed(baud) => {
                    self.next();
                    return Action::Speed(baud);
                }
                Step::Pause(span) => {
                    let until = self.since.get_or_insert(now).after(Micros(span.into()));
                    if now < until {
                        return Action::Wait(until);
                    }
                    self.next();
                }
                Step::Await { what, within } => {
                    let until = self.since.get_or_insert(now).after(Micros(within.into()));
                    if self.came(what) {
                        self.next();
                    } else if now < until {
                        return Action::Wait(until);
                    } else {
                        self.again(what);
                    }
                }
            }
        }
        // Reached only if all waits of a script are over at once.
        Action::Wait(now)
    }

    fn next(&mut self) {
        self.step += 1;
        self.since = None;
    }

    fn came(&self, what: Awaited) -> bool {
        match what {
            Awaited::Sample => self.samples > 0,
            Awaited::Record => self.records > 0,
            Awaited::Reply(to) => self.reply == Some((to, 0)),
        }
    }

    /// Starts another try after a missing answer, or fails.
    fn again(&mut self, awaited: Awaited) {
        self.tries = self.tries.saturating_add(1);
        if self.tries < TRIES {
            self.step = self.script.again_from;
            self.since = None;
            self.refused = None;
            return;
        }
        self.failed = Some(match (self.refused, self.records, self.bytes) {
            (Some(refused), ..) => refused,
            (None, 0, 0) => Failure::Silent,
            (None, 0, bytes) => {
                let unusable = self.useless.most_of(bytes);
                unusable.unwrap_or(Failure::NoRecord { bytes })
            }
            (None, records, _) => Failure::NoAnswer { records, awaited },
        });
    }
}

#[cfg(test)]
mod tests;
