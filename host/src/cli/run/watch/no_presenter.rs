//! Replaces the window of `--view window` in builds without the feature `window` and on systems
//! without X servers.

use super::{Ending, Ends, Shared};
use crate::cli::prelude::*;
use crate::show::stereo::Stereo;
use std::sync::Arc;
use std::thread::JoinHandle;

pub(super) fn start(
    _: &Cave,
    _: Stereo,
    _: &Path,
    _: Arc<Shared>,
    _: Ends,
) -> Result<JoinHandle<Ending>, Failure> {
    let help = "build it with its feature `window`, on a system with X servers, or take --view \
                png, which writes the frames to files";
    Err(Fault::new(
        "there is no window: this shisen was built without one",
        help,
    )
    .into())
}

pub(in crate::cli::run) const fn is_possible() -> bool {
    false
}

pub(in crate::cli::run) const fn refresh() -> Option<u32> {
    None
}
