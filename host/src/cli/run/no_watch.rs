//! Replaces the window of `--view window` in builds without the feature `window` and on systems
//! without X servers.

use super::frames::{Command, Watched};
use crate::cave::Cave;
use crate::cli::prelude::*;
use crate::live::FrameRecord;
use crate::show::dashboard::{About, Frame};
use crate::show::stereo::Stereo;
use glam::Vec3;

#[derive(Debug, Error, Diagnostic)]
#[error("there is no window: this shisen was built without one")]
#[diagnostic(help(
    "build it with its feature `window`, on a system with X servers, or take --view png, which \
     writes the frames to files"
))]
struct NoWindow;

pub(super) enum Watch {}

impl Watch {
    pub(super) fn open(_: &Cave, _: Stereo, _: &Path) -> Result<Self, Failure> {
        Err(NoWindow.into())
    }

    pub(super) fn begin(&mut self, _: About) {
        match *self {}
    }

    pub(super) fn set_fill(&mut self, _: &str) {
        match *self {}
    }

    pub(super) fn is_wanted(&mut self) -> bool {
        match *self {}
    }

    pub(super) fn frame(&mut self) -> Option<&mut Frame> {
        match *self {}
    }

    pub(super) fn hear(&mut self, _: &FrameRecord) {
        match *self {}
    }

    pub(super) fn gaze(&self) -> Option<Vec3> {
        match *self {}
    }

    pub(super) fn command(&mut self) -> Option<Command> {
        match *self {}
    }

    pub(super) fn is_open(&self) -> bool {
        match *self {}
    }

    pub(super) fn was_closed(&mut self) -> bool {
        match *self {}
    }

    pub(super) fn finish(self) -> Watched {
        match self {}
    }
}
