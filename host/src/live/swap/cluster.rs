//! A [`SwapLock`] over anything that takes messages from one machine to another.

use super::{Done, Gathered, Look, Order, Purpose, Share, SwapError, SwapLock, Waits};
use glam::{Quat, Vec3};
use hdrhistogram::Histogram;
use shisen_core::gaze::HeadPose;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::time::{Duration, Instant};
use zerocopy::{FromBytes, Immutable, IntoBytes, KnownLayout};

/// Takes messages from one machine to another, those from one in their order.
pub trait Wire {
    /// Which machine this is, from 0.
    fn rank(&self) -> usize;

    /// How many there are, 1 or more.
    fn ranks(&self) -> usize;

    /// What people call this machine.
    fn name(&self) -> String;

    /// Sends a message, and does not wait until it is there.
    fn send(&mut self, to: usize, message: &[u8]);

    /// The next message from another, if one is there.
    fn poll(&mut self, from: usize) -> Option<Vec<u8>>;

    /// There are no more messages: all machines end together. Where they do not, this
    /// is never called.
    fn finish(&mut self);
}

/// Messages between threads: a cluster without machines, for tests and for trying
/// things out.
#[derive(Debug)]
pub struct Channels {
    rank: usize,
    to: Vec<Sender<Vec<u8>>>,
    from: Vec<Receiver<Vec<u8>>>,
}

impl Channels {
    /// Most threads: each has a line to each.
    pub const MOST: usize = 64;

    /// The ends of `ranks` threads, [`MOST`](Self::MOST) at most, in the order of
    /// their ranks.
    pub fn new(ranks: usize) -> Vec<Self> {
        let ranks = ranks.min(Self::MOST);
        let mut ends: Vec<Self> = (0..ranks)
            .map(|rank| Self {
                rank,
                to: Vec::new(),
                from: Vec::new(),
            })
            .collect();
        for from in 0..ranks {
            for to in 0..ranks {
                let (sender, receiver) = channel();
                ends[from].to.push(sender);
                ends[to].from.push(receiver);
            }
        }
        ends
    }
}

impl Wire for Channels {
    fn rank(&self) -> usize {
        self.rank
    }

    fn ranks(&self) -> usize {
        self.to.len()
    }

    fn name(&self) -> String {
        "thread".to_owned()
    }

    fn send(&mut self, to: usize, message: &[u8]) {
        if let Some(to) = self.to.get(to) {
            // One that has ended hears nothing.
            let _ = to.send(message.to_owned());
        }
    }

    fn poll(&mut self, from: usize) -> Option<Vec<u8>> {
        self.from.get(from)?.try_recv().ok()
    }

    fn finish(&mut self) {}
}

/// How often longer one waits for what is ordered than for what was.
const PATIENCE: u32 = 10;

/// Machines that one of them keeps together.
#[derive(Debug)]
pub struct Cluster<T: Wire> {
    wire: T,
    /// How long a frame is waited for.
    wait: Duration,
    /// Of the machines, by rank.
    names: Vec<String>,
    /// When the newest order went out, or was here.
    ordered: Instant,
    waited: Histogram<u64>,
    spread: Histogram<u64>,
}

/// The first byte of a message.
const NAME: u8 = 1;
const ORDER: u8 = 2;
const DONE: u8 = 3;
const SWAP: u8 = 4;
const END: u8 = 5;

/// [`Order`], as it is sent; all ones for no end of steps. All machines have one
/// order of bytes.
#[derive(Debug, Clone, Copy, FromBytes, IntoBytes, Immutable, KnownLayout)]
#[repr(C)]
struct SentOrder {
    frame: u64,
    steps: u64,
    rung: u64,
    purpose: u64,
    head_position: [f32; 3],
    head_orientation: [f32; 4],
    position: [f32; 3],
    forward: [f32; 3],
    up: [f32; 3],
    widen: f32,
    whole_fovea: u32,
}

/// [`Done`], as it is sent, before its hashes.
#[derive(Debug, Clone, Copy, FromBytes, IntoBytes, Immutable, KnownLayout)]
#[repr(C)]
struct SentDone {
    frame: u64,
    steps: u64,
    need: u64,
    nanoseconds: u64,
    tiles: u64,
    unfinished: u64,
    unfinished_fovea: u64,
    /// From the order until it was ready, by its own clock.
    ready_nanoseconds: u64,
}

const PURPOSES: [Purpose; 4] = [
    Purpose::Plain,
    Purpose::WarmUp,
    Purpose::Shown,
    Purpose::Compared,
];

impl From<&Order> for SentOrder {
    fn from(order: &Order) -> Self {
        let Look {
            head,
            position,
            forward,
            up,
            widen,
        } = order.look;
        let purpose = PURPOSES.iter().position(|one| *one == order.purpose);
        Self {
            frame: order.frame,
            steps: order.steps.unwrap_or(u64::MAX),
            rung: order.rung as u64,
            purpose: purpose.unwrap_or_default() as u64,
            head_position: head.position.to_array(),
            head_orientation: head.orientation.to_array(),
            position: position.to_array(),
            forward: forward.to_array(),
            up: up.to_array(),
            widen,
            whole_fovea: order.whole_fovea.into(),
        }
    }
}

impl SentOrder {
    fn order(&self) -> Option<Order> {
        Some(Order {
            frame: self.frame,
            look: Look {
                head: HeadPose {
                    position: Vec3::from_array(self.head_position),
                    orientation: Quat::from_array(self.head_orientation),
                },
                position: Vec3::from_array(self.position),
                forward: Vec3::from_array(self.forward),
                up: Vec3::from_array(self.up),
                widen: self.widen,
            },
            rung: usize::try_from(self.rung).ok()?,
            steps: (self.steps != u64::MAX).then_some(self.steps),
            whole_fovea: self.whole_fovea != 0,
            purpose: *PURPOSES.get(usize::try_from(self.purpose).ok()?)?,
        })
    }
}

impl Done {
    fn sent(&self, ready: Duration) -> Vec<u8> {
        let head = SentDone {
            frame: self.frame,
            steps: self.steps,
            need: self.need,
            nanoseconds: self.tracing.as_nanos() as u64,
            tiles: self.tiles as u64,
            unfinished: self.unfinished as u64,
            unfinished_fovea: self.unfinished_fovea.into(),
            ready_nanoseconds: ready.as_nanos() as u64,
        };
        let mut bytes = vec![DONE];
        bytes.extend_from_slice(head.as_bytes());
        for hash in &self.hashes {
            bytes.extend_from_slice(hash.as_bytes());
        }
        bytes
    }

    /// What was sent, and how long it took to be ready.
    fn received(bytes: &[u8]) -> Option<(Self, Duration)> {
        let (head, rest) = SentDone::read_from_prefix(bytes).ok()?;
        let hashes = rest.chunks(size_of::<u64>());
        let done = Self {
            frame: head.frame,
            steps: head.steps,
            need: head.need,
            tracing: Duration::from_nanos(head.nanoseconds),
            tiles: head.tiles as usize,
            unfinished: head.unfinished as usize,
            unfinished_fovea: head.unfinished_fovea != 0,
            hashes: hashes
                .map(|bytes| u64::read_from_bytes(bytes).ok())
                .collect::<Option<_>>()?,
        };
        Some((done, Duration::from_nanos(head.ready_nanoseconds)))
    }
}

impl Gathered {
    /// Those of one machine more.
    fn add(&mut self, one: &Done) {
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
            self.slowest = Done {
                hashes: Vec::new(),
                ..*one
            };
        }
    }
}

impl<T: Wire> Cluster<T> {
    /// Of machines that say who they are within `wait`, which is also how long any
    /// frame is waited for.
    ///
    /// # Errors
    /// One that says nothing, or something else.
    pub fn new(wire: T, wait: Duration) -> Result<Self, SwapError> {
        let ranks = wire.ranks();
        // From 1 µs to an hour, to a thousandth: bounds that there can be.
        let times = Histogram::new_with_bounds(1, 3_600_000_000, 3)
            .map_err(|error| SwapError::Mpi(error.to_string()))?;
        let mut cluster = Self {
            names: (0..ranks).map(|rank| format!("rank {rank}")).collect(),
            wire,
            wait,
            ordered: Instant::now(),
            waited: times.clone(),
            spread: times,
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
            let said = cluster
                .wait_for(rank, until)
                .ok_or_else(|| SwapError::Silent {
                    name: cluster.names[rank].clone(),
                    wait: wait * PATIENCE,
                })?;
            let said = cluster.of_kind(rank, &said, NAME)?;
            let said = String::from_utf8_lossy(said).into_owned();
            cluster.names[rank] = format!("rank {rank} ({said})");
        }
        Ok(cluster)
    }

    /// The next message of a machine, if it comes in time.
    fn wait_for(&mut self, rank: usize, until: Instant) -> Option<Vec<u8>> {
        loop {
            if let Some(message) = self.wire.poll(rank) {
                return Some(message);
            }
            if Instant::now() >= until {
                return None;
            }
            pause();
        }
    }

    /// What a message says behind its kind.
    fn of_kind<'m>(&self, rank: usize, message: &'m [u8], kind: u8) -> Result<&'m [u8], SwapError> {
        match message.split_first() {
            Some((first, rest)) if *first == kind => Ok(rest),
            _ => Err(self.unknown(rank)),
        }
    }

    fn unknown(&self, rank: usize) -> SwapError {
        SwapError::Unknown {
            name: self.names[rank].clone(),
        }
    }

    /// What the machine that orders says next.
    fn heard(&mut self) -> Result<Vec<u8>, SwapError> {
        let wait = self.wait * PATIENCE;
        let said = self.wait_for(0, Instant::now() + wait);
        said.ok_or_else(|| SwapError::Silent {
            name: self.names[0].clone(),
            wait,
        })
    }

    fn tell_all(&mut self, message: &[u8]) {
        for rank in 1..self.wire.ranks() {
            self.wire.send(rank, message);
        }
    }
}

/// Until a message may have come: short, since a wall waits for it.
fn pause() {
    std::thread::sleep(Duration::from_micros(20));
}

impl<T: Wire> SwapLock for Cluster<T> {
    fn share(&self) -> Share {
        let (rank, ranks) = (self.wire.rank(), self.wire.ranks());
        Share::new(rank, ranks).unwrap_or(Share::ALL)
    }

    fn order(&mut self, order: &Order) -> Result<(), SwapError> {
        let mut message = vec![ORDER];
        message.extend_from_slice(SentOrder::from(order).as_bytes());
        self.tell_all(&message);
        self.ordered = Instant::now();
        Ok(())
    }

    fn obey(&mut self) -> Result<Option<Order>, SwapError> {
        let message = self.heard()?;
        if message == [END] {
            self.wire.finish();
            return Ok(None);
        }
        self.ordered = Instant::now();
        let sent = self.of_kind(0, &message, ORDER)?;
        let sent = SentOrder::read_from_bytes(sent).ok();
        let order = sent.and_then(|sent| sent.order());
        order.map(Some).ok_or_else(|| self.unknown(0))
    }

    fn gather(&mut self, own: &Done) -> Result<Gathered, SwapError> {
        let begun = Instant::now();
        let ready = begun - self.ordered;
        let mut gathered = Gathered::default();
        if self.wire.rank() > 0 {
            self.wire.send(0, &own.sent(ready));
            gathered.add(own);
            return Ok(gathered);
        }
        let ranks = self.wire.ranks();
        let mut found: Vec<Option<Done>> = vec![None; ranks];
        found[0] = Some(own.clone());
        let (mut first, mut last) = (ready, ready);
        loop {
            for rank in 1..ranks {
                if found[rank].is_none()
                    && let Some(message) = self.wire.poll(rank)
                {
                    let sent = self.of_kind(rank, &message, DONE)?;
                    let done = Done::received(sent).filter(|(done, _)| done.frame == own.frame);
                    let (done, ready) = done.ok_or_else(|| self.unknown(rank))?;
                    (first, last) = (first.min(ready), last.max(ready));
                    found[rank] = Some(done);
                }
            }
            let mut missing = (0..ranks).filter(|rank| found[*rank].is_none()).peekable();
            if missing.peek().is_none() {
                break;
            }
            if begun.elapsed() >= self.wait {
                return Err(SwapError::Late {
                    frame: own.frame,
                    wait: self.wait,
                    names: missing.map(|rank| self.names[rank].clone()).collect(),
                });
            }
            pause();
        }
        let waited = begun.elapsed().as_micros() as u64;
        self.waited.saturating_record(waited.max(1));
        let spread = last.saturating_sub(first).as_micros() as u64;
        self.spread.saturating_record(spread.max(1));
        for one in found.into_iter().flatten() {
            gathered.add(&one);
        }
        Ok(gathered)
    }

    fn swap(&mut self, frame: u64) -> Result<(), SwapError> {
        let mut message = vec![SWAP];
        message.extend_from_slice(frame.as_bytes());
        if self.wire.rank() == 0 {
            self.tell_all(&message);
            return Ok(());
        }
        if self.heard()? == message {
            Ok(())
        } else {
            Err(self.unknown(0))
        }
    }

    fn end(&mut self) -> Result<(), SwapError> {
        self.tell_all(&[END]);
        self.wire.finish();
        Ok(())
    }

    fn waits(&self) -> Option<Waits<'_>> {
        (self.wire.ranks() > 1 && self.wire.rank() == 0).then_some(Waits {
            waited: &self.waited,
            spread: &self.spread,
        })
    }
}
