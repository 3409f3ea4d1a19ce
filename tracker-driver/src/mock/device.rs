//! The device's side of a line: how a simulated tracker obeys its host.

mod adhawk;
mod fastrak;
mod flock;
mod hatire;
mod liberty;

use crate::decoder::EyeEventKind;
use crate::eye::iscan;
use crate::head::polhemus::{Family, Format, ItemList, ItemListError, MOST_ITEMS};
use crate::link;
use crate::protocol::Protocol;
use crate::rotation::{compose, inverse};
use crate::sample::Sample;
use crate::time::Micros;
use glam::Quat;
use heapless::Vec;

/// Most bytes of a command that are kept.
const MOST_HEARD: usize = 64;
/// Most bytes of an answer.
const MOST_ANSWER: usize = 64;

/// The device at the other end of the line, as far as it takes commands.
///
/// It streams from the start until it is stopped, in the form of [`Device::protocol`], which
/// commands change. A reset makes it silent and deaf for a while, then it
/// is as it was at the start, or as it was last saved (`^K` of a FASTRAK).
///
/// | Device | Commands |
/// |---|---|
/// | link | start, stop, rate |
/// | FASTRAK | `P` `C` `c` `F` `f` `U` `u` `O` `S` `W`, `^K` `^Y`; set-up that changes no record (`o` `x` `v` `H` `e` …) is taken; others, and a list that it cannot send, are answered with an error record |
/// | Liberty | `P` `C` `F1` `U0` `U1` `O` `Q0`, `^V` `^Y`; others pass |
/// | Flock | `B` `@` `G` `F`, the modes, `P` 35, `O` 0, 2, 10, 16, 36; others are error 6, which `O` 10 tells |
/// | Hatire | `S` `s` `R` `C` `V` `I`; others pass |
/// | ISCAN | start, stop; others pass |
/// | `AdHawk` | 0x90, 0x9A, 0x9B of the properties 2, 5, 13 and 14, 0x9C; others are result 8 |
///
/// Not answered, as what the answers look like is not known: FASTRAK's `T`,
/// Flock's `O` 6. Liberty's `F0` is passed over: its records in ASCII are not
/// known here.
#[derive(Debug, Clone)]
pub struct Device {
    protocol: Protocol,
    /// What a reset leaves: the protocol, and whether it streams.
    saved: (Protocol, bool),
    heard: Vec<u8, MOST_HEARD>,
    /// The line up to its end was refused for its length.
    overlong: bool,
    link: link::Commands,
    streams: bool,
    /// Records that were asked for one by one.
    asked: u8,
    /// The end of its restart.
    away_until: Option<Micros>,
    rate: Option<u32>,
    /// With a rate: no record before this time.
    next: Micros,
    clock: Zero<u64>,
    front: Zero<Quat>,
    adhawk: adhawk::Properties,
    flock: flock::State,
}

/// Something that is measured from where it was at a command.
#[derive(Debug, Clone, Copy, Default)]
enum Zero<T> {
    /// Measured from its own zero.
    #[default]
    None,
    /// Measured from its value in the next sample.
    Next,
    At(T),
}

impl<T: Copy> Zero<T> {
    /// From what the present value is to be taken, if from anything.
    fn of(&mut self, present: T) -> Option<T> {
        if matches!(self, Self::Next) {
            *self = Self::At(present);
        }
        match self {
            Self::At(zero) => Some(*zero),
            Self::None | Self::Next => None,
        }
    }
}

impl Device {
    /// A device that streams records of this protocol.
    pub fn new(protocol: &Protocol) -> Self {
        Self {
            protocol: protocol.clone(),
            saved: (protocol.clone(), true),
            heard: Vec::new(),
            overlong: false,
            link: link::Commands::new(),
            streams: true,
            asked: 0,
            away_until: None,
            rate: None,
            next: Micros(0),
            clock: Zero::None,
            front: Zero::None,
            adhawk: adhawk::Properties::default(),
            flock: flock::State::default(),
        }
    }

    /// How it writes its records, which commands change.
    pub const fn protocol(&self) -> &Protocol {
        &self.protocol
    }

    /// Whether it sends records without being asked for each.
    pub const fn streams(&self) -> bool {
        self.streams
    }

    /// Records that were asked for one by one, and are due.
    pub const fn asked(&self) -> u8 {
        self.asked
    }

    /// Whether a record is due at `now`: it streams or was asked, and does not restart.
    pub fn is_to_send(&self, now: Micros) -> bool {
        (self.streams || self.asked > 0) && !self.restarts(now)
    }

    /// Whether it restarts: it sends nothing and hears nothing.
    pub fn restarts(&self, now: Micros) -> bool {
        self.away_until.is_some_and(|until| now < until)
    }

    /// The samples per second that the host asked for, if it did.
    pub const fn rate(&self) -> Option<u32> {
        self.rate
    }

    /// The sample to send; `None` while it is stopped or restarts, and above the rate.
    pub fn measure(&mut self, sample: &Sample) -> Option<Sample> {
        let now = sample.arrival;
        if self.restarts(now) {
            return None;
        }
        if self.asked > 0 {
            self.asked -= 1;
        } else if !self.streams || now < self.next {
            return None;
        } else if let Some(rate) = self.rate {
            // In step with the rate, not with the samples before: where that is no
            // part of theirs, some follow each other sooner than others.
            let period = Micros(1_000_000 / u64::from(rate.max(1)));
            let next = self.next.after(period);
            self.next = if next > now { next } else { now.after(period) };
        }
        let mut sent = *sample;
        if let Some(time) = &mut sent.device_time
            && let Some(zero) = self.clock.of(time.microseconds)
        {
            // A clock that has wrapped counts from then on.
            time.microseconds = time.microseconds.saturating_sub(zero);
        }
        if let Some(turn) = &mut sent.head.orientation
            && let Some(front) = self.front.of(turn.value)
        {
            turn.value = compose(inverse(front), turn.value);
        }
        if self.protocol == Protocol::AdHawk {
            self.adhawk.leave_out(&mut sent);
        }
        Some(sent)
    }

    /// Takes what the host said by `now`, and hands over the answers.
    pub fn feed(&mut self, bytes: &[u8], now: Micros, answer: &mut dyn FnMut(&[u8])) {
        if self.protocol == Protocol::Link {
            let (streams, rate) = (&mut self.streams, &mut self.rate);
            return self.link.feed(bytes, &mut |command| match command {
                link::Command::Stop => *streams = false,
                link::Command::Start => *streams = true,
                link::Command::Rate { hertz } => *rate = Some(hertz.into()),
            });
        }
        for &byte in bytes {
            if self.restarts(now) {
                return;
            }
            if self.overlong {
                // The rest of a line that was refused.
                self.overlong = byte != b'\r';
                continue;
            }
            if self.heard.push(byte).is_err() {
                // No command is as long.
                if matches!(self.protocol, Protocol::Fastrak(_)) {
                    self.refuse_long(answer);
                    self.overlong = byte != b'\r';
                }
                self.heard.clear();
                continue;
            }
            while !self.heard.is_empty() {
                let Some(count) = self.step(now, answer) else {
                    break;
                };
                let count = count.min(self.heard.len());
                self.heard.rotate_left(count);
                self.heard.truncate(self.heard.len() - count);
            }
        }
    }

    /// Obeys the first command; returns its bytes, `None` while it is not complete.
    fn step(&mut self, now: Micros, answer: &mut dyn FnMut(&[u8])) -> Option<usize> {
        let &first = self.heard.first()?;
        match self.protocol {
            Protocol::Link | Protocol::OsvrHdk | Protocol::Asl(_) | Protocol::EyeTracker(..) => {
                Some(1)
            }
            Protocol::Fastrak(_) => self.fastrak(first, now, answer),
            Protocol::Liberty(_) => self.liberty(now, answer),
            Protocol::Flock(_) => self.flock(first, answer),
            Protocol::Hatire(_) => Some(self.hatire(first, now, answer)),
            Protocol::Iscan(_) => {
                self.set(first, iscan::START[0], iscan::STOP[0]);
                Some(1)
            }
            Protocol::AdHawk => self.adhawk(first, answer),
        }
    }

    /// Whether it reports this event: our own link does, an `AdHawk` where the host asked.
    pub(super) fn tells(&self, kind: EyeEventKind, now: Micros) -> bool {
        let has_it = match self.protocol {
            Protocol::Link => true,
            Protocol::AdHawk => self.adhawk.tells(kind),
            _ => false,
        };
        has_it && self.streams && !self.restarts(now)
    }

    fn set(&mut self, byte: u8, start: u8, stop: u8) {
        if byte == start || byte == stop {
            self.streams = byte == start;
        }
    }

    /// One record, whether it streams or not.
    fn ask(&mut self) {
        self.asked = self.asked.saturating_add(1);
    }

    /// Restarts as it was saved, and is away for nine tenths of the usual time.
    fn restart(&mut self, now: Micros, usual: Micros) -> usize {
        (self.protocol, self.streams) = self.saved.clone();
        (self.asked, self.rate, self.next) = (0, None, Micros(0));
        (self.clock, self.front) = (Zero::None, Zero::None);
        self.away_until = Some(now.after(Micros(usual.0 / 10 * 9)));
        self.heard.len()
    }
}

/// The bytes of the first line, without its end.
fn line(heard: &[u8]) -> Option<Vec<u8, MOST_HEARD>> {
    let end = heard.iter().position(|&byte| byte == b'\r')?;
    Vec::from_slice(heard.get(..end)?).ok()
}

/// Changes a list's format or its items, where that makes a list.
fn relist(
    items: &mut ItemList,
    family: Family,
    format: Option<Format>,
    numbers: Option<&[u8]>,
) -> Result<(), ItemListError> {
    let same: Vec<u8, MOST_ITEMS> = items.numbers().collect();
    let format = format.unwrap_or(items.format());
    *items = ItemList::new(family, format, numbers.unwrap_or(&same))?;
    Ok(())
}

#[cfg(test)]
mod tests;
