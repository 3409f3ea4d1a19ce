//! Eye and head trackers: where they are, and what comes from them.
//!
//! A [`Spec`] names a tracker, a [`Feed`] gives what it says; the mock and
//! recordings stand behind the same two. A [`calibration`] makes directions in the
//! room of what it says. [`serve`](serve::serve) is the other
//! end of a line: a tracker for others to read.

pub mod calibration;
mod feed;
mod hid;
mod live;
mod protocol;
#[cfg(unix)]
pub mod pty;
mod recording;
#[cfg(unix)]
pub mod serve;
mod settings;
mod spec;
mod times;

pub use feed::{Feed, FeedClock, FeedError, Notice, PAUSE, Senses, Trouble, simulated};
pub use hid::{Features, features};
pub use live::LiveError;
pub use protocol::{ProtocolSpec, UnknownProtocol};
pub use recording::{Recorder, Recording, RecordingError, RecordingFormat};
pub use settings::settings;
pub use spec::{HidName, HidSpec, MockSpec, ReplaySpec, SerialSpec, Spec, SpecError};
pub use times::Times;
