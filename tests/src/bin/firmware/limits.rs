//! What the firmware may take at most, from the file of limits, and what it took.

use crate::Wrong;
use shisen_tests::limits::limits;
use std::io::Write as _;
use std::path::{Path, PathBuf};

/// Limits of a slice and of a gaze, in instructions.
pub(crate) struct Limits {
    /// For each step of a slice.
    pub(crate) per_step: u64,
    /// For a slice besides.
    pub(crate) per_slice: u64,
    /// From a gaze that is known to the end of its first tile.
    pub(crate) gaze_to_tile: u64,
    /// From the last byte of a gaze that is elsewhere to the end of its first tile.
    pub(crate) restart: u64,
}

impl Limits {
    /// # Errors
    /// A file that cannot be read, or a number that is not there.
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
pub(crate) struct Measured(PathBuf);

impl Measured {
    pub(crate) fn new(path: &Path) -> Self {
        Self(path.to_owned())
    }

    /// Adds lines to it.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub(crate) fn add(&self, lines: &[(&str, u64)]) -> Result<(), Wrong> {
        let lines = lines
            .iter()
            .map(|(name, number)| format!("{name} {number}\n"));
        let text: String = lines.collect();
        let file = std::fs::OpenOptions::new()
            .append(true)
            .create(true)
            .open(&self.0);
        let written = file.and_then(|mut file| file.write_all(text.as_bytes()));
        written.map_err(|error| format!("{} cannot be written: {error}", self.0.display()).into())
    }
}
