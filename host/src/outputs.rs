//! Screens on monitors: a full-screen window each, or a connector, presented on the refresh.
//!
//! [`Output`] says which screen is shown on which monitor, of one or several X servers or of this
//! machine's graphics cards. A frame is given to [`Outputs::prepare`], which fills a pixmap for each
//! monitor, and to [`Outputs::present`], which asks all displays to show it at one time and waits
//! until they have. Displays say when each frame was shown: that is the clock of frames from then on.

mod report;
mod spec;
#[cfg_attr(not(all(unix, feature = "window")), path = "outputs/no_windows.rs")]
mod windows;

pub use report::{OutputsReport, PaneReport};
pub use spec::{Backend, Corner, Output, OutputsName, Placing};
pub use windows::Outputs;
