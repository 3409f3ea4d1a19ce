//! `shisen room`: rooms measured with a tape, drawn to scale, and of other programs.

pub(super) mod import;
pub(super) mod measure;
pub(super) mod show;

use crate::cli::output::failure::Failure;
use clap::Subcommand;

/// Rooms of walls and domes: measured with a tape, drawn to scale, and of other programs
#[derive(Debug, Subcommand)]
pub(super) enum Room {
    Measure(measure::Arguments),
    Show(show::Arguments),
    Import(import::Arguments),
}

pub(super) fn run(room: &Room) -> Result<(), Failure> {
    match room {
        Room::Measure(arguments) => measure::run(arguments),
        Room::Show(arguments) => show::run(arguments),
        Room::Import(arguments) => import::run(arguments),
    }
}
