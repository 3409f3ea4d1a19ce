//! `shisen dome`: dome masters through a mirrored spheroid.

mod arguments;
mod camera;
mod compare;
mod curve;
mod design;
mod figure;
mod map;
mod nearfield;
mod render;

use super::failure::Failure;
use clap::Subcommand;

/// Dome masters through a mirrored spheroid, and how true they are
#[derive(Debug, Subcommand)]
pub(super) enum Dome {
    Design(design::Arguments),
    Curve(curve::Arguments),
    Map(map::Arguments),
    Nearfield(nearfield::Arguments),
    Render(Box<render::Arguments>),
    Compare(compare::Arguments),
}

/// Runs the command.
pub(super) fn run(dome: &Dome) -> Result<(), Failure> {
    match dome {
        Dome::Design(arguments) => design::run(arguments),
        Dome::Curve(arguments) => curve::run(arguments),
        Dome::Map(arguments) => map::run(arguments),
        Dome::Nearfield(arguments) => nearfield::run(arguments),
        Dome::Render(arguments) => render::run(arguments),
        Dome::Compare(arguments) => compare::run(arguments),
    }
}
