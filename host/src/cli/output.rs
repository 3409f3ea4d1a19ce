//! What a command says: its report on standard output, all else on standard error.

pub mod failure;
pub mod picture_files;
pub mod progress;
pub mod ray_counts;

use crate::files::Fault;
use failure::{Failure, no_output};
use serde::Serialize;
use std::fmt;
use std::io::{self, IsTerminal as _, StdoutLock, Write};
use std::sync::mpsc::{Sender, channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Writes to standard output and flushes it. Returns whether somebody still reads there.
pub fn write(
    writing: impl FnOnce(&mut StdoutLock<'static>) -> io::Result<()>,
) -> Result<bool, Fault> {
    let mut stdout = io::stdout().lock();
    match writing(&mut stdout).and_then(|()| stdout.flush()) {
        Ok(()) => Ok(true),
        // A reader that closed the pipe has read all it wanted.
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Ok(false),
        Err(reason) => Err(no_output(&reason)),
    }
}

/// Prints one of several reports, as a JSON object on a line or as text. Returns whether
/// somebody still reads.
pub fn print_one(report: &(impl Serialize + fmt::Display), json: bool) -> Result<bool, Fault> {
    let text = if json {
        serde_json::to_string(report).map_err(io::Error::from)
    } else {
        Ok(report.to_string())
    };
    write(|stdout| writeln!(stdout, "{}", text?))
}

/// Prints a command's only report.
pub fn print(report: &(impl Serialize + fmt::Display), json: bool) -> Result<(), Failure> {
    print_one(report, json)?;
    Ok(())
}

pub fn print_text(text: &str) -> Result<(), Failure> {
    write(|stdout| writeln!(stdout, "{text}"))?;
    Ok(())
}

/// Says something beside the report, on standard error.
pub fn say(text: &str) {
    // Where standard error is closed, nobody is left to tell.
    let _ = writeln!(io::stderr(), "{text}");
}

/// Warns of something unexpected that does not end the command.
pub fn warn(text: &str) {
    say(&format!("Warning: {text}"));
}

/// Warns on a thread of its own: the caller never waits for a reader of standard error.
pub struct Warner {
    warnings: Option<Sender<String>>,
    thread: Option<JoinHandle<()>>,
}

impl Warner {
    /// Longest wait for a reader at the end.
    const PATIENCE: Duration = Duration::from_secs(1);

    pub fn start() -> Self {
        let (warnings, due) = channel::<String>();
        let builder = std::thread::Builder::new().name("warnings".to_owned());
        let thread = builder.spawn(move || due.iter().for_each(|text| warn(&text)));
        Self {
            warnings: Some(warnings),
            thread: thread.ok(),
        }
    }

    pub fn warn(&self, text: String) {
        if let Some(warnings) = &self.warnings {
            // Without a thread nobody hears it, and the work goes on.
            let _ = warnings.send(text);
        }
    }
}

impl Drop for Warner {
    fn drop(&mut self) {
        drop(self.warnings.take());
        let last = Instant::now() + Self::PATIENCE;
        let is_busy = || {
            let thread = self.thread.as_ref();
            thread.is_some_and(|thread| !thread.is_finished())
        };
        while is_busy() && Instant::now() < last {
            std::thread::sleep(Duration::from_millis(1));
        }
    }
}

/// Returns a count and its noun, with an s unless the count is 1: 1 eye, 2 eyes.
pub fn counted(count: u64, noun: &str) -> String {
    let ending = if count == 1 { "" } else { "s" };
    format!("{count} {noun}{ending}")
}

/// Returns columns and rows of the terminal on standard error; `None` if it is not a terminal.
pub fn terminal_size() -> Option<[u16; 2]> {
    if !io::stderr().is_terminal() {
        return None;
    }
    #[cfg(unix)]
    {
        let size = rustix::termios::tcgetwinsize(io::stderr()).ok()?;
        let size = [size.ws_col, size.ws_row];
        (size[0] > 2 && size[1] > 2).then_some(size)
    }
    #[cfg(not(unix))]
    None
}
