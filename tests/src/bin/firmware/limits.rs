//! What the firmware may take at most, from the file of limits, and what it took.

use crate::Wrong;
use std::fmt::Write as _;
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
    pub(crate) fn read(path: &Path) -> Result<Self, Wrong> {
        let name = path.display();
        let text = std::fs::read_to_string(path);
        let text = text.map_err(|error| format!("{name} cannot be read: {error}"))?;
        let all: toml::Table = text.parse().map_err(|error| format!("{name}: {error}"))?;
        let number = |table: &str, key: &str| {
            let number = all.get(table).and_then(|table| table.get(key));
            let number = number.and_then(toml::Value::as_integer);
            let number = number.and_then(|number| u64::try_from(number).ok());
            number.ok_or_else(|| format!("{name} has no number {table}.{key}"))
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
        let mut text = String::new();
        for (name, number) in lines {
            // Writing to a string cannot fail.
            let _ = writeln!(text, "{name} {number}");
        }
        let file = std::fs::OpenOptions::new()
            .append(true)
            .create(true)
            .open(&self.0);
        file.and_then(|mut file| std::io::Write::write_all(&mut file, text.as_bytes()))
            .map_err(|error| format!("{} cannot be written: {error}", self.0.display()))
    }
}
