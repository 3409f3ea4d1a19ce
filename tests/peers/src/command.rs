//! Other programs, and what they take.

use serde_json::Value;
use std::error::Error;
use std::ffi::OsStr;
use std::path::PathBuf;
use std::process::{Command, Output};

/// The command `shisen`.
#[derive(Debug, Clone)]
pub struct Shisen(pub PathBuf);

/// Processor seconds of all programs that have ended.
#[allow(unsafe_code)]
pub fn children_seconds() -> f64 {
    // SAFETY: zeros are a value of it, and it is filled in.
    let usage = unsafe {
        let mut usage: libc::rusage = std::mem::zeroed();
        libc::getrusage(libc::RUSAGE_CHILDREN, &raw mut usage);
        usage
    };
    let seconds = |time: libc::timeval| time.tv_sec as f64 + 1.0e-6 * time.tv_usec as f64;
    seconds(usage.ru_utime) + seconds(usage.ru_stime)
}

/// Runs a program to its end.
///
/// # Errors
/// Where it cannot be started or fails; with what it said last.
pub fn run(command: &mut Command) -> Result<Output, Box<dyn Error>> {
    let name = command.get_program().to_string_lossy().into_owned();
    let output = command
        .output()
        .map_err(|error| format!("{name}: {error}"))?;
    if output.status.success() {
        return Ok(output);
    }
    let said = String::from_utf8_lossy(&output.stderr);
    let last: Vec<_> = said
        .lines()
        .rev()
        .filter(|line| !line.is_empty())
        .take(2)
        .collect();
    Err(format!("{name}: {}: {}", output.status, last.join("; ")).into())
}

impl Shisen {
    /// A call of it with `--json`.
    pub fn command(&self, arguments: impl IntoIterator<Item = impl AsRef<OsStr>>) -> Command {
        let mut command = Command::new(&self.0);
        command.args(arguments).arg("--json");
        command
    }

    /// Its report.
    ///
    /// # Errors
    /// Where it fails.
    pub fn report(
        &self,
        arguments: impl IntoIterator<Item = impl AsRef<OsStr>>,
    ) -> Result<Value, Box<dyn Error>> {
        let output = run(&mut self.command(arguments))?;
        Ok(serde_json::from_slice(&output.stdout)?)
    }
}
