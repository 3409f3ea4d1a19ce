//! Trackers for other programs: a device on a line, or a server on the network.
//!
//! [`serve`] is a device on a line; [`relay`] hands a feed's events to an [`Outlet`].

mod datagrams;
mod line;
mod lsl;
mod outlet;
mod vrpn;

pub use line::{LineState, Progress, SILENT, serve};
pub use outlet::{NetProtocol, Outlet, Relayed, Time, relay, utc};
