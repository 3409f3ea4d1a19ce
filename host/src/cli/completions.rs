//! `shisen completions`: scripts with which shells complete command lines.

use super::Shisen;
use crate::cli::output;
use crate::cli::output::failure::Failure;
use clap::{Args, CommandFactory as _};
use clap_complete::Shell;
use std::io::Write as _;

/// Prints a script that completes command lines in a shell
#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// The shell
    #[arg(value_enum)]
    shell: Shell,
}

pub(super) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let (mut command, mut script) = (Shisen::command(), Vec::new());
    clap_complete::generate(arguments.shell, &mut command, "shisen", &mut script);
    output::write(|stdout| stdout.write_all(&script))?;
    Ok(())
}
