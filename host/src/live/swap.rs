//! Several machines that show a frame together, each its own walls.
//!
//! The leader, the machine of rank 0, reads the tracker and sends the others an order for each
//! frame, never pixels. All render their share and show it when all have rendered theirs. A frame
//! depends on its order alone, and on no clock.

mod cluster;
#[cfg(feature = "cluster")]
mod mpi;

pub use cluster::{Cluster, Wire};
#[cfg(feature = "cluster")]
pub use mpi::Mpi;

use super::flight::RoomPlace;
use super::governor::Decision;
use glam::Vec3;
use hdrhistogram::Histogram;
use shisen_core::gaze::{HeadPose, LineOfSight};
use shisen_tracker::estimate::Estimate;
use std::time::Duration;
use thiserror::Error;

/// The head and the line of sight of a frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Look {
    /// The head, in the room.
    pub head: HeadPose,
    /// The point between the eyes: metres, in the room.
    pub position: Vec3,
    /// The line of sight, of length 1.
    pub forward: Vec3,
    /// The viewer's up direction, at right angles to it, of length 1.
    pub up: Vec3,
    /// The angle by which the field of full detail is widened, radians.
    pub widen: f32,
}

impl From<&Estimate> for Look {
    fn from(estimate: &Estimate) -> Self {
        let sight = estimate.line_of_sight;
        Self {
            head: estimate.head,
            position: sight.position(),
            forward: sight.forward(),
            up: sight.up(),
            widen: estimate.widen,
        }
    }
}

impl Look {
    /// Returns the same head with the eyes towards a direction of the room, which is certain, if
    /// given.
    #[must_use]
    pub fn towards(self, forward: Option<Vec3>) -> Self {
        let ups = [self.up, Vec3::Y, Vec3::NEG_Z];
        let along = |forward| ups.map(|up| LineOfSight::new(self.position, forward, up));
        match forward.and_then(|forward| along(forward).into_iter().flatten().next()) {
            None => self,
            Some(line) => Self {
                forward: line.forward(),
                up: line.up(),
                widen: 0.0,
                ..self
            },
        }
    }
}

/// The purpose of a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Purpose {
    /// Measures the cost without level of detail.
    Plain,
    /// Measures the cost.
    WarmUp,
    /// Is shown.
    Shown,
    /// Is compared by the hashes of its pictures.
    Compared,
}

/// The order to render a frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Order {
    /// The frame's number, from 0.
    pub frame: u64,
    /// Seconds of the scene's animations.
    pub time: f64,
    /// Where the room is in the scene.
    pub place: RoomPlace,
    /// The viewer's look.
    pub look: Look,
    /// The quality, and the budget on each machine.
    pub decision: Decision,
    /// The frame's purpose.
    pub purpose: Purpose,
}

/// The result of a frame on one machine, or on all.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct FrameResult {
    /// The frame's number.
    pub frame: u64,
    /// Steps taken.
    pub steps: u64,
    /// Steps that all of it would have taken, as far as is known.
    pub need: u64,
    /// The time of tracing; the longest of all machines.
    pub tracing: Duration,
    /// Number of tiles.
    pub tiles: usize,
    /// Tiles that were not finished.
    pub unfinished: usize,
    /// Whether an unfinished tile is within [`FOVEA`](super::FOVEA) of a line of sight.
    pub unfinished_fovea: bool,
    /// The hashes of its pictures, where they are compared.
    pub hashes: Vec<u64>,
}

/// The results of all machines.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct GatheredResults {
    /// The sum of all.
    pub all: FrameResult,
    /// The result of the machine that traced longest, without its hashes.
    pub slowest: FrameResult,
}

/// The pictures of a frame that a machine renders: a run of all pairs of a screen and an eye, by
/// screen, then eye.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Share {
    rank: usize,
    ranks: usize,
}

impl Share {
    /// All pictures.
    pub const ALL: Self = Self { rank: 0, ranks: 1 };

    /// Returns the share of one of `ranks` machines; `None` unless `rank` is below that.
    pub fn new(rank: usize, ranks: usize) -> Option<Self> {
        (rank < ranks).then_some(Self { rank, ranks })
    }

    /// Returns the machine's number, from 0.
    pub const fn rank(self) -> usize {
        self.rank
    }

    /// Returns the number of machines.
    pub const fn ranks(self) -> usize {
        self.ranks
    }

    /// Returns whether the machine renders a picture, one of `pictures`.
    pub const fn has(self, picture: usize, pictures: usize) -> bool {
        // Both factors are below 2⁶⁴.
        picture < pictures
            && picture as u128 * self.ranks as u128 / pictures as u128 == self.rank as u128
    }
}

/// Why machines do not show the same frame, and what to do.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("{0}")]
pub struct SwapError(pub(crate) String);

/// Keeps machines together: the leader, of rank 0, orders frames and the others render them.
/// The default methods are those of one machine alone. Errors are machines that are late, silent,
/// or of another version.
#[expect(clippy::missing_errors_doc, reason = "the trait names the errors")]
pub trait SwapLock {
    /// This machine's share.
    fn share(&self) -> Share {
        Share::ALL
    }

    /// Sends the next order to the others.
    fn order(&mut self, _: &Order) -> Result<(), SwapError> {
        Ok(())
    }

    /// Receives the next order; `None` at the end.
    fn obey(&mut self) -> Result<Option<Order>, SwapError> {
        Ok(None)
    }

    /// Reports the result of a frame here; the leader gets those of all machines, once done.
    fn gather(&mut self, own: &FrameResult) -> Result<GatheredResults, SwapError> {
        let mut gathered = GatheredResults::default();
        gathered.add(own);
        Ok(gathered)
    }

    /// Waits until all machines may show the frame.
    fn swap(&mut self, _: u64) -> Result<(), SwapError> {
        Ok(())
    }

    /// Notes how long after [`swap`](Self::swap) the frame was shown here, where that is known.
    fn note_shown(&mut self, _: Option<Duration>) {}

    /// Ends the session on all machines.
    fn end(&mut self) -> Result<(), SwapError> {
        Ok(())
    }

    /// Returns the waits of machines for each other, for the leader; `None` with one machine.
    fn waits(&self) -> Option<&Waits> {
        None
    }
}

/// The waits of machines for each other: microseconds of each frame.
#[derive(Debug, Clone)]
pub struct Waits {
    /// How long the leader waited for the last of the others after it was ready.
    pub waited: Histogram<u64>,
    /// From the first to the last machine to be ready, each counted from the order.
    pub spread: Histogram<u64>,
    /// From the first to the last machine that showed a frame, each counted from when all were
    /// ready; only of frames whose time all machines know.
    pub shown: Histogram<u64>,
}

/// A machine that shows all walls by itself.
#[derive(Debug, Clone, Copy, Default)]
pub struct SingleMachine;

impl SwapLock for SingleMachine {}

#[cfg(test)]
mod tests;
