//! Other programs.

use std::error::Error;
use std::ffi::OsStr;
use std::path::PathBuf;
use std::process::{Command, Output};

#[derive(Debug, Clone)]
pub struct Shisen(pub PathBuf);

pub fn run(command: &mut Command) -> Result<Output, Box<dyn Error>> {
    let name = command.get_program().to_string_lossy().into_owned();
    let output = command
        .output()
        .map_err(|error| format!("{name}: {error}"))?;
    if output.status.success() {
        return Ok(output);
    }
    let said = String::from_utf8_lossy(&output.stderr);
    let lines = said.lines().rev().filter(|line| !line.is_empty());
    let last: Vec<_> = lines.take(2).collect();
    Err(format!("{name}: {}: {}", output.status, last.join("; ")).into())
}

impl Shisen {
    /// Returns a call of the command with `--json`.
    pub fn command(&self, arguments: impl IntoIterator<Item = impl AsRef<OsStr>>) -> Command {
        let mut command = Command::new(&self.0);
        command.args(arguments).arg("--json");
        command
    }
}
