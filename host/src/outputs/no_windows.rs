//! In place of windows, for builds without them.

use super::{Backend, Output, OutputsReport, Placing};
use crate::cave::Eye;
use crate::live::Refresh;
use crate::picture::Picture;
use crate::projection::Projection;
use crate::show::stereo::Stereo;
use miette::Diagnostic;
use std::convert::Infallible;
use std::time::Instant;
use thiserror::Error;

/// Windows on monitors, of which this build has none.
#[derive(Debug)]
pub struct Outputs(Infallible);

/// Why there are no windows.
#[derive(Debug, Error, Diagnostic)]
#[error("this build shows no windows")]
#[diagnostic(help("build it for Unix with the feature window, which is on by default"))]
pub struct NoWindows;

#[allow(
    missing_docs,
    clippy::missing_errors_doc,
    reason = "those of a build with windows"
)]
impl Outputs {
    pub fn open(
        _: &[Output],
        _: &[(&str, Eye)],
        _: &[Projection],
        _: Stereo,
        _: Backend,
        _: Placing,
    ) -> Result<Self, NoWindows> {
        Err(NoWindows)
    }

    pub fn said(&mut self) -> impl Iterator<Item = String> + '_ {
        std::iter::empty()
    }

    pub fn hz(&self) -> f64 {
        match self.0 {}
    }

    pub fn prepare(&mut self, _: &[Picture]) {
        match self.0 {}
    }

    pub fn prepare_own(&mut self, _: impl FnMut(&Output, [u32; 2], u64) -> Vec<u32>) {
        match self.0 {}
    }

    pub fn prepare_again(&mut self) -> bool {
        match self.0 {}
    }

    pub fn present(&mut self, _: Instant) -> Option<Refresh> {
        match self.0 {}
    }

    pub fn is_open(&self) -> bool {
        match self.0 {}
    }

    pub fn report(&self) -> OutputsReport {
        match self.0 {}
    }
}
