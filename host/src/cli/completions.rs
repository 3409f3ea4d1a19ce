//! `shisen completions`: what a shell completes command lines by.

use super::Shisen;
use crate::cli::output;
use crate::cli::output::failure::Failure;
use clap::{Args, CommandFactory as _};
use clap_complete::Shell;
use std::io::Write as _;

/// Prints a script that completes command lines in a shell
///
/// It knows commands, arguments and the values that these list as possible. Where a shell
/// looks for such scripts is in its manual; the examples are where bash, zsh and fish have it
/// on most systems. Make the folder with mkdir -p where there is none yet.
#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// For which shell
    #[arg(value_enum)]
    shell: Shell,
}

/// Runs the command.
pub(super) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let mut script = Vec::new();
    clap_complete::generate(
        arguments.shell,
        &mut Shisen::command(),
        "shisen",
        &mut script,
    );
    output::write(|stdout| stdout.write_all(&script))?;
    Ok(())
}
