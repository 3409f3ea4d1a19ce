//! A simulated viewer behind a simulated tracker, and the faults of the line between.
//!
//! - [`Viewer`] moves head and eyes as people do, and knows where the line of
//!   sight is at any time of its recent past and future;
//! - [`Tracker`] measures it, with noise, blinks and a clock of its own, and
//!   gives [`Sample`](crate::sample::Sample)s;
//! - [`Wire`] turns samples into the bytes of a protocol, which
//!   [`Reader`](crate::protocol::Reader) decodes;
//! - [`Device`] hears what a host says to the device, and [`Line`] is both: the
//!   device's end of a line, which `uart::DeviceEnd` puts on a port;
//! - [`Faults`] stands between a source of bytes and its reader: delay, jitter,
//!   drop, duplicate, reorder, corrupt, stuck, disconnect.
//!
//! All of it is decided by a seed: the same seed gives the same bytes, on any
//! machine and however it is polled. Memory is bounded, nothing is allocated.

mod device;
mod eye_events;
mod faults;
mod line;
mod movement;
mod noise;
mod random;
mod tracker;
mod wire;

pub use device::Device;
pub use faults::{Chunk, Faults, FaultsConfig, FaultsConfigError, MOST_CHUNK_BYTES, Source};
pub use line::Line;
pub use movement::{Kind, ScriptedTarget, Truth, Viewer, ViewerConfig};
pub use random::Random;
pub use tracker::{Tracker, TrackerConfig, TrackerConfigError};
pub use wire::{RAW_CENTRE, RAW_PER_METRE, Wire};

#[cfg(test)]
mod tests;
