//! `shisen room`: rooms from other programs' files.

pub(super) mod import;

use crate::cli::output::failure::Failure;
use clap::Subcommand;

/// Rooms of walls and domes from other programs' files
#[derive(Debug, Subcommand)]
pub(super) enum Room {
    Import(import::Arguments),
}

pub(super) fn run(room: &Room) -> Result<(), Failure> {
    match room {
        Room::Import(arguments) => import::run(arguments),
    }
}
