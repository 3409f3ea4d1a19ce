//! `shisen dome`: dome masters through a mirrored spheroid, and on domes.

mod arguments;
mod camera;
pub(super) mod compare;
pub(super) mod curve;
pub(super) mod design;
mod figure;
pub(super) mod map;
pub(super) mod nearfield;
pub(super) mod render;
pub(super) mod warp;

use crate::cli::output::failure::Failure;
use clap::Subcommand;

/// Dome masters through a mirrored spheroid, their errors, and warps for a dome's projectors
#[derive(Debug, Subcommand)]
pub(super) enum Dome {
    Design(design::Arguments),
    Curve(curve::Arguments),
    Map(map::Arguments),
    Nearfield(nearfield::Arguments),
    Render(Box<render::Arguments>),
    Compare(compare::Arguments),
    Warp(warp::Arguments),
}

pub(super) fn run(dome: &Dome) -> Result<(), Failure> {
    match dome {
        Dome::Design(arguments) => design::run(arguments),
        Dome::Curve(arguments) => curve::run(arguments),
        Dome::Map(arguments) => map::run(arguments),
        Dome::Nearfield(arguments) => nearfield::run(arguments),
        Dome::Render(arguments) => render::run(arguments),
        Dome::Compare(arguments) => compare::run(arguments),
        Dome::Warp(arguments) => warp::run(arguments),
    }
}
