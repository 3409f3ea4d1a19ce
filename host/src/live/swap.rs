//! Several machines that show a frame together, each its own walls.
//!
//! One of them, of rank 0, reads the tracker and tells the others of each frame what
//! it is of: who looks from where, how well, within how many steps. Never pixels. All
//! render their share, say so, and show it when all have: no wall is a frame ahead of
//! another. What they render is a function of what they are told alone; none reads a
//! clock for it.

mod cluster;
#[cfg(feature = "cluster")]
mod mpi;

pub use cluster::{Channels, Cluster, Wire};
#[cfg(feature = "cluster")]
pub use mpi::Mpi;

use glam::Vec3;
use hdrhistogram::Histogram;
use shisen_core::gaze::{HeadPose, LineOfSight};
use shisen_tracker::estimate::Estimate;
use std::time::Duration;
use thiserror::Error;

/// Who looks, and where.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Look {
    /// The head, in the room.
    pub head: HeadPose,
    /// Between the eyes: metres, in the room.
    pub position: Vec3,
    /// The line of sight, of length 1.
    pub forward: Vec3,
    /// What is up for the viewer: at right angles to it, of length 1.
    pub up: Vec3,
    /// By how much the field of full detail is widened: radians.
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
    /// The same head with the eyes towards a direction of the room, if one is given. Of
    /// that nothing is unsure.
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

/// What a frame is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Purpose {
    /// To measure what it takes in full, without level of detail.
    Plain,
    /// To measure what it takes.
    WarmUp,
    /// To be shown.
    Shown,
    /// To be compared: its pictures' hashes are wanted.
    Compared,
}

/// What everybody renders next.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Order {
    /// Counted from 0 by whoever orders.
    pub frame: u64,
    /// For whom.
    pub look: Look,
    /// Which rung of [`Quality::LADDER`](super::Quality::LADDER).
    pub rung: usize,
    /// At most so many steps on each machine; `None` where there is no end.
    pub steps: Option<u64>,
    /// Whether the [`FOVEA`](super::FOVEA) is finished all the same, with more of them.
    pub whole_fovea: bool,
    /// What for.
    pub purpose: Purpose,
}

/// What a frame took on one machine, or on all.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Done {
    /// Its number.
    pub frame: u64,
    /// Steps that it took.
    pub steps: u64,
    /// Steps that all of it would have taken, as far as is known.
    pub need: u64,
    /// What tracing took; of all, the longest.
    pub tracing: Duration,
    /// Tiles.
    pub tiles: usize,
    /// Tiles that were not finished.
    pub unfinished: usize,
    /// Whether one of these is within [`FOVEA`](super::FOVEA) of a line of sight.
    pub unfinished_fovea: bool,
    /// Of its pictures, where they are to be compared.
    pub hashes: Vec<u64>,
}

/// What all machines took.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Gathered {
    /// Together.
    pub all: Done,
    /// The one that took longest, without its hashes.
    pub slowest: Done,
}

/// Which pictures of a frame a machine renders: of all pairs of a screen and an eye,
/// by screen, then eye, as many beside one another as are its share.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Share {
    rank: usize,
    ranks: usize,
}

impl Share {
    /// All of them.
    pub const ALL: Self = Self { rank: 0, ranks: 1 };

    /// That of one of `ranks` machines, which are 1 at least and counted from 0.
    pub const fn new(rank: usize, ranks: usize) -> Option<Self> {
        if rank < ranks {
            Some(Self { rank, ranks })
        } else {
            None
        }
    }

    /// Which machine it is.
    pub const fn rank(self) -> usize {
        self.rank
    }

    /// How many there are.
    pub const fn ranks(self) -> usize {
        self.ranks
    }

    /// Whether it renders a picture of so many.
    pub const fn has(self, picture: usize, pictures: usize) -> bool {
        // What there is of either is less than 2⁶⁴.
        picture < pictures
            && picture as u128 * self.ranks as u128 / pictures as u128 == self.rank as u128
    }
}

/// Why machines no longer show the same.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum SwapError {
    /// Some have not said in time that they have rendered a frame.
    #[error(
        "frame {frame} is not there after {} s on {}: see what has stopped there, and start all \
         of them again",
        wait.as_secs_f64(),
        names.join(", ")
    )]
    Late {
        /// Which frame.
        frame: u64,
        /// How long they were waited for.
        wait: Duration,
        /// Their ranks and machines.
        names: Vec<String>,
    },
    /// The one that orders says nothing.
    #[error(
        "{name} has said nothing for {} s: see what has stopped there, and start all of them again",
        wait.as_secs_f64()
    )]
    Silent {
        /// Its rank and machine.
        name: String,
        /// How long.
        wait: Duration,
    },
    /// Something came that is no message of this version's.
    #[error(
        "{name} says what this shisen does not understand: start the same version on all machines"
    )]
    Unknown {
        /// Rank and machine.
        name: String,
    },
    /// More machines than pictures.
    #[error(
        "{ranks} processes are too many for {pictures} pictures (walls times eyes): start at most as many"
    )]
    TooMany {
        /// Processes.
        ranks: usize,
        /// Pictures.
        pictures: usize,
    },
    /// There is no MPI.
    #[error("MPI cannot be started: {0}")]
    Mpi(String),
}

/// Keeps machines together. The machine of rank 0 orders, the others obey.
pub trait SwapLock {
    /// Which machine this is.
    fn share(&self) -> Share;

    /// Tells the others what to render next.
    ///
    /// # Errors
    /// Those of whatever is between them.
    fn order(&mut self, order: &Order) -> Result<(), SwapError>;

    /// What to render next; `None` where there is nothing more.
    ///
    /// # Errors
    /// [`SwapError::Silent`] and [`SwapError::Unknown`].
    fn obey(&mut self) -> Result<Option<Order>, SwapError>;

    /// Says what a frame took here; what it took everywhere, once it is there
    /// everywhere, for whoever orders.
    ///
    /// # Errors
    /// [`SwapError::Late`] and [`SwapError::Unknown`].
    fn gather(&mut self, own: &Done) -> Result<Gathered, SwapError>;

    /// All show the frame now.
    ///
    /// # Errors
    /// [`SwapError::Silent`] and [`SwapError::Unknown`].
    fn swap(&mut self, frame: u64) -> Result<(), SwapError>;

    /// There is nothing more.
    ///
    /// # Errors
    /// Those of whatever is between them.
    fn end(&mut self) -> Result<(), SwapError>;

    /// What machines wait for each other, as whoever orders knows it; `None` where
    /// there is one machine.
    fn waits(&self) -> Option<Waits<'_>>;
}

/// What machines wait for each other: microseconds, a frame each.
#[derive(Debug, Clone, Copy)]
pub struct Waits<'h> {
    /// How long whoever orders waited for the last of the others, once it was ready
    /// itself.
    pub waited: &'h Histogram<u64>,
    /// How much longer the last took to be ready than the first: from an order to what
    /// is said of it, each by its own clock.
    pub spread: &'h Histogram<u64>,
}

/// One machine alone.
#[derive(Debug, Clone, Copy, Default)]
pub struct Alone;

impl SwapLock for Alone {
    fn share(&self) -> Share {
        Share::ALL
    }

    fn order(&mut self, _: &Order) -> Result<(), SwapError> {
        Ok(())
    }

    fn obey(&mut self) -> Result<Option<Order>, SwapError> {
        Ok(None)
    }

    fn gather(&mut self, own: &Done) -> Result<Gathered, SwapError> {
        Ok(Gathered {
            all: own.clone(),
            slowest: Done {
                hashes: Vec::new(),
                ..*own
            },
        })
    }

    fn swap(&mut self, _: u64) -> Result<(), SwapError> {
        Ok(())
    }

    fn end(&mut self) -> Result<(), SwapError> {
        Ok(())
    }

    fn waits(&self) -> Option<Waits<'_>> {
        None
    }
}

#[cfg(test)]
mod tests;
