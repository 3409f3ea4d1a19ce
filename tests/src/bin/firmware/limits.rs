//! What the firmware may take at most, from the file of limits, and what it took.

use crate::Wrong;
use shisen_tests::limits::limits;
use std::io::Write as _;

/// Limits of a slice and of a gaze, in instructions.
pub(crate) struct Limits {
    pub(crate) per_step: u64,
    /// For a slice besides its steps.
    pub(crate) per_slice: u64,
    /// From a gaze that is known to the end of its first tile.
    pub(crate) gaze_to_tile: u64,
    /// From the last byte of a gaze that is elsewhere to the end of its first tile.
    pub(crate) restart: u64,
}

impl Limits {
    pub(crate) fn read(path: &str) -> Result<Self, Wrong> {
        let number = |table: &str, key: &str| {
            let number = limits(path, table)?.get(key).copied();
            number.ok_or_else(|| Wrong::from(format!("{path} has no number {table}.{key}")))
        };
        Ok(Self {
            per_step: number("time", "instructions_a_step")?,
            per_slice: number("time", "instructions_a_slice")?,
            gaze_to_tile: number("budget", "gaze_to_tile")?,
            restart: number("budget", "restart")?,
        })
    }
}

/// A file of names and numbers, a line each, for the budget sheet.
pub(crate) struct Measured(pub(crate) String);

impl Measured {
    pub(crate) fn add(&self, name: &str, number: u64) -> Result<(), Wrong> {
        let mut options = std::fs::OpenOptions::new();
        let file = options.append(true).create(true).open(&self.0);
        let written = file.and_then(|mut file| writeln!(file, "{name} {number}"));
        written.map_err(|error| format!("{} cannot be written: {error}", self.0).into())
    }
}
