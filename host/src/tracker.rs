//! Eye and head trackers: devices, mocks and recordings.
//!
//! A [`Spec`] names a tracker and a [`Feed`] hands over its events. A calibration turns
//! them into directions in the room; a [`ComposedGaze`] takes those of several trackers.
//! [`serve`] is the other end: a tracker for other programs.

pub(crate) mod calibration;
mod feed;
mod hid;
mod live;
mod net;
mod notice;
mod port;
mod protocol;
#[cfg(unix)]
pub mod pty;
mod raw;
mod recording;
mod script;
#[cfg(unix)]
pub mod serve;
mod settings;
mod source;
mod spec;
mod times;
mod wand;

pub use feed::{Feed, FeedClock, PAUSE, Senses, simulated};
pub(crate) use hid::features;
pub use net::{Datagrams, GazeSpec, LslSpec, NetSpec, Server};
pub(crate) use net::{Stream, devices, dropped_since, streams};
pub use notice::{Features, Notice, Trouble};
pub use protocol::ProtocolSpec;
pub use raw::RawBytes;
pub use recording::{Recorder, Recording};
pub use settings::settings;
pub use source::{ComposedGaze, Intake, Role, Source, TrackerEvent};
pub use spec::{HidName, HidSpec, MockSpec, SerialSpec, Spec, TrackerKind};
pub use times::Times;
pub(crate) use wand::check_controls;
pub use wand::{By, Flight, Navigation, Steering, Wand};
