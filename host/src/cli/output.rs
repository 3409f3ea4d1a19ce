//! What a command says: its report on standard output, all else on standard error.

pub mod failure;
pub mod picture_files;
pub mod progress;
pub mod ray_counts;

use crate::cli::output::failure::{Failure, Fault};
use serde::Serialize;
use std::fmt;
use std::io::{self, StdoutLock, Write};

/// Writes to standard output, and at once; whether anybody still reads there.
///
/// # Errors
/// Of `what`, but for a pipe that somebody closed.
pub fn write(what: impl FnOnce(&mut StdoutLock<'static>) -> io::Result<()>) -> Result<bool, Fault> {
    let mut stdout = io::stdout().lock();
    match what(&mut stdout).and_then(|()| stdout.flush()) {
        Ok(()) => Ok(true),
        // Whoever closed the pipe has read all that was wanted.
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Ok(false),
        Err(reason) => Err(Fault::Print { reason }),
    }
}

/// Prints a report: as one JSON object on one line, or as text; whether anybody still reads.
///
/// # Errors
/// As [`write`].
pub fn print_one(report: &(impl Serialize + fmt::Display), json: bool) -> Result<bool, Fault> {
    let text = if json {
        serde_json::to_string(report).map_err(io::Error::from)
    } else {
        Ok(report.to_string())
    };
    write(|stdout| writeln!(stdout, "{}", text?))
}

/// Prints a command's only report.
///
/// # Errors
/// As [`write`].
pub fn print(report: &(impl Serialize + fmt::Display), json: bool) -> Result<(), Failure> {
    print_one(report, json)?;
    Ok(())
}

/// Says something beside the report.
pub fn say(what: &str) {
    // Nobody is left to tell where standard error is closed.
    let _ = writeln!(io::stderr(), "{what}");
}

/// Says what may not be as expected though the command goes on.
pub fn warn(of: &str) {
    say(&format!("Warning: {of}"));
}

/// So many of something that an s makes several of: 1 eye, 2 eyes.
pub fn counted(count: u64, what: &str) -> String {
    let ending = if count == 1 { "" } else { "s" };
    format!("{count} {what}{ending}")
}
