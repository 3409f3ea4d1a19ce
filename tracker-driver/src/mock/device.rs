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

/// A simulated device at the other end of the line, which obeys commands.
///
/// It streams from the start until it is stopped, in the form of [`Device::protocol`], which
/// commands change. After a reset it neither sends nor hears for a while, and is then in its
/// first state, or the one last saved (`^K` of a FASTRAK).
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
/// Not answered, since the form of the answers is not known: FASTRAK's `T`, Flock's
/// `O` 6. Liberty's `F0` is ignored: the form of its ASCII records is not known.
#[derive(Debug, Clone)]
pub struct Device {
    protocol: Protocol,
    /// State after a reset: the protocol, and whether the device streams.
    saved: (Protocol, bool),
    heard: Vec<u8, MOST_HEARD>,
    /// Whether the rest of a line is skipped, since the line was too long.
    overlong: bool,
    link: link::Commands,
    streams: bool,
    /// Number of single records that the host asked for.
    asked: u8,
    /// When its restart ends.
    away_until: Option<Micros>,
    rate: Option<u32>,
    /// Earliest time of the next record, if a rate is set.
    next: Micros,
    clock: Reference<u64>,
    front: Reference<Quat>,
    adhawk: adhawk::Properties,
    flock: flock::State,
}

/// The value from which a quantity is measured: a command may set it to the present one.
#[derive(Debug, Clone, Copy, Default)]
enum Reference<T> {
    /// The quantity's own zero.
    #[default]
    None,
    /// The value in the next sample.
    Next,
    /// This value.
    At(T),
}

impl<T: Copy> Reference<T> {
    /// Returns the value to subtract from the present one, if any.
    fn of(&mut self, present: T) -> Option<T> {
        if matches!(self, Self::Next) {
            *self = Self::At(present);
        }
        match self {
            Self::At(value) => Some(*value),
            Self::None | Self::Next => None,
        }
    }
}

impl Device {
    /// Returns a device that streams records of this protocol.
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
            clock: Reference::None,
            front: Reference::None,
            adhawk: adhawk::Properties::default(),
            flock: flock::State::default(),
        }
    }

    /// Returns the form of its records, which commands change.
    pub const fn protocol(&self) -> &Protocol {
        &self.protocol
    }

    /// Returns whether it sends records without a request for each.
    pub const fn streams(&self) -> bool {
        self.streams
    }

    /// Returns how many single records the host asked for and has not got.
    pub const fn asked(&self) -> u8 {
        self.asked
    }

    /// Returns whether a record is due at `now`: it streams or was asked, and does not restart.
    pub fn is_to_send(&self, now: Micros) -> bool {
        (self.streams || self.asked > 0) && !self.restarts(now)
    }

    /// Returns whether it restarts: it then sends and hears nothing.
    pub fn restarts(&self, now: Micros) -> bool {
        self.away_until.is_some_and(|until| now < until)
    }

    /// Returns the samples per second that the host asked for, if it did.
    pub const fn rate(&self) -> Option<u32> {
        self.rate
    }

    /// Returns the sample to send; `None` while the device is stopped or restarts, or if the
    /// sample comes too early for the rate.
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
            // The next time follows from the rate, not from this sample: where the rate
            // does not divide the tracker's, intervals differ and their mean is right.
            let period = Micros(1_000_000 / u64::from(rate.max(1)));
            let next = self.next.after(period);
            self.next = if next > now { next } else { now.after(period) };
        }
        let mut sent = *sample;
        if let Some(time) = &mut sent.device_time
            && let Some(zero) = self.clock.of(time.microseconds)
        {
            // A clock that has wrapped since then starts again from 0.
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

    /// Takes the host's bytes up to `now`, and hands the answers to `answer`.
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
                // A command is never this long.
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

    /// Obeys the first command; returns its length, `None` while it is not complete.
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

    /// Returns whether it reports this event: our own link does, an `AdHawk` if the host asked.
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

    /// Adds a request for one record.
    fn ask(&mut self) {
        self.asked = self.asked.saturating_add(1);
    }

    /// Restarts in its saved state, and is silent for nine tenths of the usual time.
    fn restart(&mut self, now: Micros, usual: Micros) -> usize {
        (self.protocol, self.streams) = self.saved.clone();
        (self.asked, self.rate, self.next) = (0, None, Micros(0));
        (self.clock, self.front) = (Reference::None, Reference::None);
        self.away_until = Some(now.after(Micros(usual.0 / 10 * 9)));
        self.heard.len()
    }
}

/// Returns the bytes of the first line, without its end.
fn line(heard: &[u8]) -> Option<Vec<u8, MOST_HEARD>> {
    let end = heard.iter().position(|&byte| byte == b'\r')?;
    Vec::from_slice(heard.get(..end)?).ok()
}

/// Changes a list's format or its items, if the result is a valid list.
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
