//! `shisen completions`: what a shell completes command lines by.

use super::Shisen;
use super::failure::{Failure, Fault};
use clap::{Args, CommandFactory as _};
use clap_complete::Shell;
use std::io::{self, Write as _};

/// Prints a script that completes command lines in a shell
///
/// It knows commands, arguments and the values that these list. Where a shell looks for
/// such scripts is in its manual; the examples are where most systems have it.
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
    let mut stdout = io::stdout().lock();
    match stdout.write_all(&script).and_then(|()| stdout.flush()) {
        // Whoever closed the pipe has read all that was wanted.
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => {
            Err(Fault::Print { reason: error }.into())
        }
        _ => Ok(()),
    }
}
