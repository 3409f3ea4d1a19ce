//! The live loop: frames that follow a tracker, each within its budget.
//!
//! A frame begins with the newest gaze ([`LiveTracker`]), gets the best quality that fits
//! ([`Governor`]), is rendered within a budget of steps on threads that stay
//! ([`with_engine`]), and its latencies are recorded ([`Latencies`]).

pub mod quantiles;

mod budget;
mod engine;
mod flight;
mod governor;
mod latency;
mod quality;
mod session;
mod swap;
mod tracking;

use std::sync::{Mutex, MutexGuard, PoisonError};

pub use budget::{BudgetError, FrameBudget, Table2};
pub use engine::{Cut, Engine, Rendered, Undescribed, eyes_of, with_engine};
pub use flight::RoomPlace;
pub use governor::{Allowance, Decision, FrameCost, Governor};
pub use latency::{FrameRecord, Latencies, Leg, Summary};
pub use quality::{FOVEA, Quality};
pub use session::{
    Display, Latch, Observe, Refresh, SessionError, SessionReport, SessionSettings, follow, run,
};
#[cfg(feature = "cluster")]
pub use swap::Mpi;
pub use swap::{
    Cluster, FrameResult, GatheredResults, Look, Order, Purpose, Share, SingleMachine, SwapError,
    SwapLock, Waits, Wire,
};
pub use tracking::{LatchedGaze, LiveTracker, Report, SourceState};

pub(crate) fn lock<T>(one: &Mutex<T>) -> MutexGuard<'_, T> {
    one.lock().unwrap_or_else(PoisonError::into_inner)
}
