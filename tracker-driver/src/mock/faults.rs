//! Simulated faults between a tracker and its reader.

use super::random::Random;
use crate::time::Micros;
use heapless::Vec;

/// A source of items, in the order of their arrival.
pub trait Source {
    /// The type of its items.
    type Item;

    /// Returns the next item that arrives at `until` or before, if there is one.
    fn poll(&mut self, until: Micros) -> Option<Self::Item>;
}

/// Most bytes of a [`Chunk`].
pub const MOST_CHUNK_BYTES: usize = crate::head::polhemus::MOST_RECORD_BYTES;
const _: () = assert!(MOST_CHUNK_BYTES >= crate::link::LONGEST_FRAME);
const _: () = assert!(MOST_CHUNK_BYTES <= u8::MAX as usize);

/// Bytes that arrive together: a report, a packet, the contents of a port's buffer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Chunk {
    /// Time of their arrival.
    pub arrival: Micros,
    bytes: [u8; MOST_CHUNK_BYTES],
    length: u8,
}

impl Chunk {
    /// Returns a chunk of at most [`MOST_CHUNK_BYTES`] bytes; the rest is cut off.
    pub fn new(arrival: Micros, bytes: &[u8]) -> Self {
        let mut chunk = Self {
            arrival,
            bytes: [0; MOST_CHUNK_BYTES],
            length: 0,
        };
        for (to, from) in chunk.bytes.iter_mut().zip(bytes) {
            *to = *from;
            chunk.length += 1;
        }
        chunk
    }

    /// Returns the bytes.
    pub fn bytes(&self) -> &[u8] {
        self.bytes
            .get(..usize::from(self.length))
            .unwrap_or_default()
    }

    /// Flips one bit, or drops or doubles one byte.
    pub(super) fn corrupt(&mut self, random: &mut Random) {
        let length = usize::from(self.length);
        if length == 0 {
            return;
        }
        let at = random.bits() as usize % length;
        match random.bits() % 3 {
            0 => {
                if let Some(byte) = self.bytes.get_mut(at) {
                    *byte ^= 1 << (random.bits() % 8);
                }
            }
            1 => {
                self.bytes.copy_within(at + 1..length, at);
                self.length -= 1;
            }
            _ if length < MOST_CHUNK_BYTES => {
                self.bytes.copy_within(at..length, at + 1);
                self.length += 1;
            }
            _ => {}
        }
    }
}

/// The faults and their probabilities, from 0 to 1 for each item.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct FaultsConfig {
    /// Delay of all items; up to 10 s.
    pub delay: Micros,
    /// Most further delay of each item, random; up to 1 s.
    pub jitter: Micros,
    /// Probability that an item is lost.
    pub drop: f32,
    /// Probability that an item comes twice.
    pub duplicate: f32,
    /// Probability that an item comes after the next one.
    pub reorder: f32,
    /// Probability that an item is damaged.
    pub corrupt: f32,
    /// Probability that an item is repeated for [`stuck_for`](Self::stuck_for).
    pub stuck: f32,
    /// Duration of repetition; up to 60 s.
    pub stuck_for: Micros,
    /// Probability that from an item on nothing comes for
    /// [`disconnected_for`](Self::disconnected_for).
    pub disconnect: f32,
    /// Duration of silence; up to 60 s.
    pub disconnected_for: Micros,
    /// Whether jitter keeps the order, as a serial line does.
    pub in_order: bool,
}

/// A value of a [`FaultsConfig`] that is out of range.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[error("the faults' {field} is {found}: give 0 to {most}")]
pub struct FaultsConfigError {
    /// The value's name, and its unit where it has one.
    pub field: &'static str,
    /// The value; it may be NaN.
    pub found: f32,
    /// The most it can be; the least is 0.
    pub most: f32,
}

/// Most items that jitter delays at a time; further ones wait in the source.
const UNDER_WAY: usize = 64;
/// Most items that one item of the source leads to: itself, a copy, and one that it lets pass.
const MOST_OF_ONE: usize = 3;

/// A source whose items suffer faults.
#[derive(Debug, Clone)]
pub struct Faults<S> {
    source: S,
    config: FaultsConfig,
    random: Random,
    /// Items under way, in the order of their arrival.
    under_way: Vec<Chunk, UNDER_WAY>,
    /// Arrival of the source's newest item.
    reached: Option<Micros>,
    /// Arrival of the newest item handed over.
    handed: Micros,
    /// Latest arrival so far, for jitter that keeps the order.
    latest: Micros,
    /// The item that waits for the next one to pass.
    aside: Option<Chunk>,
    stuck: Option<(Chunk, Micros)>,
    disconnected_until: Option<Micros>,
}

impl<S: Source<Item = Chunk>> Faults<S> {
    /// Returns a source with these faults.
    ///
    /// # Errors
    /// Values outside the ranges at [`FaultsConfig`].
    pub fn new(source: S, config: FaultsConfig, seed: u64) -> Result<Self, FaultsConfigError> {
        let disconnected_for = config.disconnected_for.seconds();
        for (field, found, most) in [
            ("delay (s)", config.delay.seconds(), 10.0),
            ("jitter (s)", config.jitter.seconds(), 1.0),
            ("drop", config.drop, 1.0),
            ("duplicate", config.duplicate, 1.0),
            ("reorder", config.reorder, 1.0),
            ("corrupt", config.corrupt, 1.0),
            ("stuck", config.stuck, 1.0),
            ("stuck for (s)", config.stuck_for.seconds(), 60.0),
            ("disconnect", config.disconnect, 1.0),
            ("disconnected for (s)", disconnected_for, 60.0),
        ] {
            if !(0.0..=most).contains(&found) {
                return Err(FaultsConfigError { field, found, most });
            }
        }
        Ok(Self {
            source,
            config,
            random: Random::new(seed, 21),
            under_way: Vec::new(),
            reached: None,
            handed: Micros(0),
            latest: Micros(0),
            aside: None,
            stuck: None,
            disconnected_until: None,
        })
    }

    /// Returns the source without faults.
    pub fn source(&mut self) -> &mut S {
        &mut self.source
    }

    /// Applies the faults to an item.
    fn take(&mut self, mut item: Chunk) {
        let now = item.arrival;
        self.reached = Some(now);
        let config = self.config;
        // All random numbers are drawn for each item, so that one setting does not change others.
        let [drop, duplicate, reorder, corrupt, stuck, disconnect] = [
            config.drop,
            config.duplicate,
            config.reorder,
            config.corrupt,
            config.stuck,
            config.disconnect,
        ]
        .map(|probability| self.random.chance(probability));
        let jitter = self.random.uniform();
        let mut damage = Random::new(u64::from(self.random.bits()), 22);
        if disconnect && self.disconnected_until.is_none() {
            self.disconnected_until = Some(now.after(config.disconnected_for));
        }
        if self.disconnected_until.is_some_and(|until| now < until) {
            self.aside = None;
            return;
        }
        self.disconnected_until = None;
        if stuck && self.stuck.is_none() {
            self.stuck = Some((item, now.after(config.stuck_for)));
        }
        match self.stuck {
            Some((same, until)) if now < until => {
                item = Chunk {
                    arrival: now,
                    ..same
                }
            }
            _ => self.stuck = None,
        }
        if drop {
            return;
        }
        if corrupt {
            item.corrupt(&mut damage);
        }
        let late = (config.jitter.0 as f32 * jitter) as u64;
        let mut due = now.after(config.delay).after(Micros(late));
        if config.in_order {
            due = due.max(self.latest);
            self.latest = due;
        }
        item.arrival = due;
        if reorder && self.aside.is_none() {
            self.aside = Some(item);
            return;
        }
        self.send(&item);
        if duplicate {
            self.send(&item);
        }
        if let Some(mut passed) = self.aside.take() {
            passed.arrival = due.max(passed.arrival);
            self.send(&passed);
        }
    }

    /// Inserts an item behind all that arrive no later.
    fn send(&mut self, item: &Chunk) {
        let earlier = |other: &&Chunk| other.arrival <= item.arrival;
        let behind = self.under_way.iter().take_while(earlier).count();
        // There is room, as `poll` ensures.
        let _ = self.under_way.insert(behind, *item);
    }
}

impl<S: Source<Item = Chunk>> Source for Faults<S> {
    type Item = Chunk;

    fn poll(&mut self, until: Micros) -> Option<Chunk> {
        // Items that are only delayed stay in the source.
        let delay = self.config.delay;
        let sent = until.0.checked_sub(delay.0).map(Micros)?;
        loop {
            let next = self.under_way.first().map(|item| item.arrival);
            // No later item can arrive earlier.
            let settled = next
                .zip(self.reached)
                .is_some_and(|(next, reached)| next <= reached.after(delay));
            if !settled
                && self.under_way.len() <= UNDER_WAY - MOST_OF_ONE
                && let Some(item) = self.source.poll(sent)
            {
                self.take(item);
                continue;
            }
            next.filter(|due| *due <= until)?;
            let mut item = self.under_way.remove(0);
            self.handed = self.handed.max(item.arrival);
            item.arrival = self.handed;
            return Some(item);
        }
    }
}
