//! The live loop: frames that follow a tracker, each in its time.
//!
//! A frame begins with the newest gaze ([`LiveTracker`]), is made as good as fits
//! ([`Governor`]), rendered within a budget of steps on threads that stay
//! ([`with_engine`]), and what it took is kept ([`Latencies`]).

pub mod quantiles;

mod budget;
mod engine;
mod governor;
mod latency;
mod quality;
mod session;
mod swap;
mod tracking;

pub use budget::{BudgetError, FrameBudget, Table2};
pub use engine::{Engine, Rendered, eyes_of, with_engine};
pub use governor::{Allowance, Decision, Governor, Taken};
pub use latency::{Latencies, Leg, Stamps, Summary};
pub use quality::{FOVEA, Quality};
pub use session::{
    FrameRecord, Latch, SessionError, SessionReport, SessionSettings, Stage, follow, run,
};
#[cfg(feature = "cluster")]
pub use swap::Mpi;
pub use swap::{
    Alone, Channels, Cluster, Done, Gathered, Look, Order, Purpose, Share, SwapError, SwapLock,
    Waits, Wire,
};
pub use tracking::{Happening, Latched, LiveTracker};
