//! `shisen dome`: dome masters through a mirrored spheroid.

mod arguments;
mod camera;
mod compare;
mod render;

use super::failure::Failure;
use clap::Subcommand;

/// Dome masters through a mirrored spheroid, and how true they are
#[derive(Debug, Subcommand)]
pub(super) enum Dome {
    Render(Box<render::Arguments>),
    Compare(compare::Arguments),
}

/// Runs the command.
pub(super) fn run(dome: &Dome) -> Result<(), Failure> {
    match dome {
        Dome::Render(arguments) => render::run(arguments),
        Dome::Compare(arguments) => compare::run(arguments),
    }
}
