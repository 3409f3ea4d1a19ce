//! In place of the window of `--view window`, where there is none: built without the
//! feature `window`, or for a system without X servers.

use super::watched::{Command, Watched};
use crate::cave::Cave;
use crate::cli::output::failure::Failure;
use crate::live::FrameRecord;
use crate::show::dashboard::{About, Frame};
use crate::show::stereo::Stereo;
use glam::Vec3;
use miette::Diagnostic;
use std::path::Path;
use thiserror::Error;

/// There is none.
#[derive(Debug, Error, Diagnostic)]
#[error("there is no window: this shisen was built without one")]
#[diagnostic(help(
    "build it with its feature `window`, on a system with X servers, or take --view png, which \
     writes the frames to files"
))]
struct NoWindow;

/// A window that cannot be.
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
