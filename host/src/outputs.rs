//! Screens on monitors: a full-screen window each, presented on the refresh.
//!
//! [`Output`] says which screen is shown on which monitor, of one or several X servers. A frame is
//! given to [`Outputs::prepare`], which fills a pixmap of each window, and to [`Outputs::present`],
//! which asks all servers to show it at one time and waits until they have. Servers say when each
//! frame was shown: that is the clock of frames from then on.

mod report;
mod spec;
#[cfg_attr(not(all(unix, feature = "window")), path = "outputs/no_windows.rs")]
mod windows;

pub use report::{OutputsReport, PaneReport};
pub use spec::{Corner, Output, OutputsName, Placing};
pub use windows::Outputs;
