//! A [`SwapLock`] over any way to send messages between machines.

use super::{
    FrameResult, GatheredResults, Look, Order, Purpose, Share, SwapError, SwapLock, Waits,
};
use crate::live::flight::RoomPlace;
use crate::live::governor::Decision;
use glam::{DVec3, Quat, Vec3};
use hdrhistogram::Histogram;
use shisen_core::gaze::HeadPose;
use std::time::{Duration, Instant};
use zerocopy::{FromBytes, IntoBytes};

/// Sends messages between machines; messages from one machine to another stay in order.
pub trait Wire {
    /// This machine's number, from 0.
    fn rank(&self) -> usize;

    /// Returns the number of machines, 1 or more.
    fn ranks(&self) -> usize;

    /// This machine's name, for people.
    fn name(&self) -> String;

    /// Sends a message without waiting until it arrives.
    fn send(&mut self, to: usize, message: &[u8]);

    /// Returns the next message from a machine, if one has come.
    fn poll(&mut self, from: usize) -> Option<Vec<u8>>;

    /// Ends the messages; called only where all machines end together.
    fn finish(&mut self) {}
}

const RESTART: &str = "see what has stopped there, and start all of them again";

/// Ratio of a machine's longest wait for an order to the leader's longest wait for a frame.
const PATIENCE: u32 = 10;

/// Machines that the leader keeps together.
#[derive(Debug)]
pub struct Cluster<T: Wire> {
    wire: T,
    wait: Duration,
    names: Vec<String>,
    /// When the newest order was sent or received.
    ordered: Instant,
    /// How long after all were ready the newest frame was shown here; zero where that is unknown.
    shown_after: Duration,
    waits: Waits,
}

// The first byte of a message.
const NAME: u8 = 1;
const ORDER: u8 = 2;
const DONE: u8 = 3;
const SWAP: u8 = 4;
const END: u8 = 5;

/// Returns a message of a kind and words of eight bytes. All machines have one byte order.
fn message(kind: u8, words: &[u64]) -> Vec<u8> {
    let mut bytes = vec![kind];
    bytes.extend_from_slice(words.as_bytes());
    bytes
}

fn words(bytes: &[u8]) -> Option<Vec<u64>> {
    let words = bytes.chunks(size_of::<u64>());
    words.map(|word| u64::read_from_bytes(word).ok()).collect()
}

const PURPOSES: [Purpose; 4] = [
    Purpose::Plain,
    Purpose::WarmUp,
    Purpose::Shown,
    Purpose::Compared,
];

impl Order {
    /// Returns the order in a message, with `u64::MAX` for no limit of steps.
    fn words(&self) -> Vec<u64> {
        let purpose = PURPOSES.iter().position(|one| *one == self.purpose);
        let Decision {
            steps,
            rung,
            whole_fovea,
        } = self.decision;
        let mut words = vec![
            self.frame,
            steps.unwrap_or(u64::MAX),
            rung as u64,
            whole_fovea.into(),
            purpose.unwrap_or_default() as u64,
            self.time.to_bits(),
        ];
        let place = self.place.position.extend(self.place.yaw).to_array();
        words.extend(place.map(f64::to_bits));
        let look = &self.look;
        let vectors = [look.head.position, look.position, look.forward, look.up];
        let vectors = vectors.map(|vector| vector.to_array());
        let turn = look.head.orientation.to_array();
        let numbers = vectors.into_iter().flatten();
        let numbers = numbers.chain(turn).chain([look.widen]);
        words.extend(numbers.map(|number| u64::from(number.to_bits())));
        words
    }

    fn read(bytes: &[u8]) -> Option<Self> {
        let words = words(bytes)?;
        let (&[frame, steps, rung, whole_fovea, purpose, time], rest) =
            words.split_first_chunk()?;
        let (place, look) = rest.split_first_chunk::<4>()?;
        let [x, y, z, yaw] = place.map(f64::from_bits);
        let look = look.iter().map(|&bits| f32::from_bits(bits as u32));
        let look: [f32; 17] = look.collect::<Vec<_>>().try_into().ok()?;
        let vector = |number: usize| Vec3::from_slice(&look[3 * number..]);
        Some(Self {
            frame,
            time: f64::from_bits(time),
            place: RoomPlace {
                position: DVec3::new(x, y, z),
                yaw,
            },
            look: Look {
                head: HeadPose {
                    position: vector(0),
                    orientation: Quat::from_slice(&look[12..]),
                },
                position: vector(1),
                forward: vector(2),
                up: vector(3),
                widen: look[16],
            },
            decision: Decision {
                steps: (steps != u64::MAX).then_some(steps),
                whole_fovea: whole_fovea != 0,
                rung: usize::try_from(rung).ok()?,
            },
            purpose: *PURPOSES.get(usize::try_from(purpose).ok()?)?,
        })
    }
}

impl FrameResult {
    /// Returns the result in a message, with the time since the order on the machine's own clock,
    /// and the time after which it showed the frame before.
    fn words(&self, ready: Duration, shown_after: Duration) -> Vec<u64> {
        let mut words = vec![
            self.frame,
            self.steps,
            self.need,
            self.tracing.as_nanos() as u64,
            self.tiles as u64,
            self.unfinished as u64,
            self.unfinished_fovea.into(),
            ready.as_nanos() as u64,
            shown_after.as_nanos() as u64,
        ];
        words.extend(&self.hashes);
        words
    }

    fn read(bytes: &[u8]) -> Option<(Self, [Duration; 2])> {
        let words = words(bytes)?;
        let (
            &[
                frame,
                steps,
                need,
                tracing,
                tiles,
                unfinished,
                fovea,
                ready,
                shown,
            ],
            hashes,
        ) = words.split_first_chunk()?;
        let result = Self {
            frame,
            steps,
            need,
            tracing: Duration::from_nanos(tracing),
            tiles: tiles as usize,
            unfinished: unfinished as usize,
            unfinished_fovea: fovea != 0,
            hashes: hashes.to_vec(),
        };
        Some((result, [ready, shown].map(Duration::from_nanos)))
    }
}

impl GatheredResults {
    pub(super) fn add(&mut self, one: &FrameResult) {
        let all = &mut self.all;
        all.frame = one.frame;
        all.steps += one.steps;
        all.need += one.need;
        all.tracing = all.tracing.max(one.tracing);
        all.tiles += one.tiles;
        all.unfinished += one.unfinished;
        all.unfinished_fovea |= one.unfinished_fovea;
        all.hashes.extend_from_slice(&one.hashes);
        if one.tracing >= self.slowest.tracing {
            self.slowest = FrameResult {
                hashes: Vec::new(),
                ..*one
            };
        }
    }
}

impl<T: Wire> Cluster<T> {
    /// Joins machines, each of which sends its name; `wait` is the longest wait for a frame.
    ///
    /// # Errors
    /// A machine that is silent or sends something else.
    pub fn new(wire: T, wait: Duration) -> Result<Self, SwapError> {
        let ranks = wire.ranks();
        // From 1 µs to an hour, to a thousandth.
        let times = Histogram::new_with_bounds(1, 3_600_000_000, 3)
            .map_err(|error| SwapError(error.to_string()))?;
        let mut cluster = Self {
            names: (0..ranks).map(|rank| format!("rank {rank}")).collect(),
            wire,
            wait,
            ordered: Instant::now(),
            shown_after: Duration::ZERO,
            waits: Waits {
                waited: times.clone(),
                spread: times.clone(),
                shown: times,
            },
        };
        let mut name = vec![NAME];
        name.extend_from_slice(cluster.wire.name().as_bytes());
        let own = cluster.wire.rank();
        let others = (0..ranks).filter(|rank| *rank != own);
        // Programs start one after another.
        let until = Instant::now() + wait * PATIENCE;
        for rank in others.clone() {
            cluster.wire.send(rank, &name);
        }
        for rank in others {
            let said = cluster.wait_for(rank, until)?;
            let said = cluster.contents(rank, &said, NAME)?;
            let said = String::from_utf8_lossy(said).into_owned();
            cluster.names[rank] = format!("rank {rank} ({said})");
        }
        Ok(cluster)
    }

    fn wait_for(&mut self, rank: usize, until: Instant) -> Result<Vec<u8>, SwapError> {
        loop {
            if let Some(message) = self.wire.poll(rank) {
                return Ok(message);
            }
            if Instant::now() >= until {
                let (name, wait) = (&self.names[rank], (self.wait * PATIENCE).as_secs_f64());
                let message = format!("{name} has said nothing for {wait} s: {RESTART}");
                return Err(SwapError(message));
            }
            pause();
        }
    }

    fn contents<'m>(
        &self,
        rank: usize,
        message: &'m [u8],
        kind: u8,
    ) -> Result<&'m [u8], SwapError> {
        match message.split_first() {
            Some((first, rest)) if *first == kind => Ok(rest),
            _ => Err(self.unknown(rank)),
        }
    }

    fn unknown(&self, rank: usize) -> SwapError {
        let name = &self.names[rank];
        SwapError(format!(
            "{name} sent a message of another version: start the same version on all machines"
        ))
    }

    fn receive_from_leader(&mut self) -> Result<Vec<u8>, SwapError> {
        self.wait_for(0, Instant::now() + self.wait * PATIENCE)
    }

    fn broadcast(&mut self, message: &[u8]) {
        for rank in 1..self.wire.ranks() {
            self.wire.send(rank, message);
        }
    }
}

/// Sleeps until a message may have come: shortly, since a wall waits for it.
fn pause() {
    std::thread::sleep(Duration::from_micros(20));
}

impl<T: Wire> SwapLock for Cluster<T> {
    fn share(&self) -> Share {
        let (rank, ranks) = (self.wire.rank(), self.wire.ranks());
        Share::new(rank, ranks).unwrap_or(Share::ALL)
    }

    fn order(&mut self, order: &Order) -> Result<(), SwapError> {
        self.broadcast(&message(ORDER, &order.words()));
        self.ordered = Instant::now();
        Ok(())
    }

    fn obey(&mut self) -> Result<Option<Order>, SwapError> {
        let message = self.receive_from_leader()?;
        if message == [END] {
            self.wire.finish();
            return Ok(None);
        }
        self.ordered = Instant::now();
        let order = Order::read(self.contents(0, &message, ORDER)?);
        order.map(Some).ok_or_else(|| self.unknown(0))
    }

    fn gather(&mut self, own: &FrameResult) -> Result<GatheredResults, SwapError> {
        let begun = Instant::now();
        let ready = begun - self.ordered;
        let mut gathered = GatheredResults::default();
        if self.wire.rank() > 0 {
            self.wire
                .send(0, &message(DONE, &own.words(ready, self.shown_after)));
            gathered.add(own);
            return Ok(gathered);
        }
        let ranks = self.wire.ranks();
        let mut found: Vec<Option<FrameResult>> = vec![None; ranks];
        found[0] = Some(own.clone());
        let (mut first, mut last) = (ready, ready);
        let mut shown = vec![self.shown_after];
        loop {
            for rank in 1..ranks {
                if found[rank].is_none()
                    && let Some(message) = self.wire.poll(rank)
                {
                    let done = FrameResult::read(self.contents(rank, &message, DONE)?);
                    let done = done.filter(|(done, _)| done.frame == own.frame);
                    let (done, [ready, after]) = done.ok_or_else(|| self.unknown(rank))?;
                    shown.push(after);
                    (first, last) = (first.min(ready), last.max(ready));
                    found[rank] = Some(done);
                }
            }
            if found.iter().all(Option::is_some) {
                break;
            }
            if begun.elapsed() >= self.wait {
                let missing = (0..ranks).filter(|rank| found[*rank].is_none());
                let missing: Vec<&str> = missing.map(|rank| self.names[rank].as_str()).collect();
                let (frame, wait, on) = (own.frame, self.wait.as_secs_f64(), missing.join(", "));
                let late = format!("frame {frame} is not there after {wait} s on {on}: {RESTART}");
                return Err(SwapError(late));
            }
            pause();
        }
        let waited = begun.elapsed().as_micros() as u64;
        self.waits.waited.saturating_record(waited.max(1));
        let spread = last.saturating_sub(first).as_micros() as u64;
        self.waits.spread.saturating_record(spread.max(1));
        if let (Some(first), Some(last)) = (shown.iter().min(), shown.iter().max())
            && !first.is_zero()
        {
            let spread = last.saturating_sub(*first).as_micros() as u64;
            self.waits.shown.saturating_record(spread.max(1));
        }
        for one in found.into_iter().flatten() {
            gathered.add(&one);
        }
        Ok(gathered)
    }

    fn swap(&mut self, frame: u64) -> Result<(), SwapError> {
        let message = message(SWAP, &[frame]);
        if self.wire.rank() == 0 {
            self.broadcast(&message);
            return Ok(());
        }
        if self.receive_from_leader()? == message {
            Ok(())
        } else {
            Err(self.unknown(0))
        }
    }

    fn note_shown(&mut self, after: Option<Duration>) {
        self.shown_after = after.unwrap_or_default();
    }

    fn end(&mut self) -> Result<(), SwapError> {
        self.broadcast(&[END]);
        self.wire.finish();
        Ok(())
    }

    fn waits(&self) -> Option<&Waits> {
        (self.wire.ranks() > 1 && self.wire.rank() == 0).then_some(&self.waits)
    }
}
