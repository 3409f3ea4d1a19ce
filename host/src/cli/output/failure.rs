//! Why a command ends without having done what it was asked to.

use crate::files::Fault;
use clap::error::ErrorKind;
use miette::Diagnostic;
use std::error::Error as StdError;
use std::io::{self, Write};
use std::process::ExitCode;

/// Why a command ends early.
#[derive(Debug)]
pub enum Failure {
    /// The command line cannot be read, or asks for help. Boxed: clap's error is large and rare.
    Usage(Box<clap::Error>),
    /// Arguments that are right one by one and wrong together.
    Misused(String),
    /// A file, a device or the machine does not do what is needed.
    Failed(miette::Report),
}

/// Makes the error of a report that cannot be printed.
pub(super) fn no_output(reason: &io::Error) -> Fault {
    Fault::new(
        format!("cannot write to standard output: {reason}"),
        "free some space where the output goes, or send it elsewhere; all files are written",
    )
}

/// Turns errors into failures.
pub trait OrFail<T> {
    /// Returns the error as a fault of the machine or of a file: exit code 1.
    fn or_fail(self) -> Result<T, Failure>;

    /// Returns the error as a wrong use of the command line: exit code 2.
    fn or_misuse(self) -> Result<T, Failure>;
}

impl<T, E: StdError + Send + Sync + 'static> OrFail<T> for Result<T, E> {
    fn or_fail(self) -> Result<T, Failure> {
        self.map_err(Failure::from_error)
    }

    fn or_misuse(self) -> Result<T, Failure> {
        self.map_err(|error| Failure::usage(&error))
    }
}

/// A wrong use of arguments, with a message as `format!` takes it.
macro_rules! misuse {
    ($($message:tt)*) => {
        $crate::cli::output::failure::Failure::usage(&format!($($message)*))
    };
}
pub(in crate::cli) use misuse;

impl Failure {
    /// Returns a wrong use of arguments together.
    pub fn usage(message: &(impl ToString + ?Sized)) -> Self {
        Self::Misused(message.to_string())
    }

    /// Adds the usage of the command with the given names, the outermost first, to a wrong use
    /// of its arguments.
    #[must_use]
    pub fn with_usage(self, mut whole: clap::Command, names: &[String]) -> Self {
        let Self::Misused(message) = self else {
            return self;
        };
        // Tells each command the names before its own.
        whole.build();
        let mut asked = &mut whole;
        for name in names {
            asked = match asked.find_subcommand_mut(name) {
                Some(command) => command,
                None => return Self::Misused(message),
            };
        }
        let usage = asked.render_usage();
        let name = asked.get_bin_name().unwrap_or_else(|| asked.get_name());
        Self::Misused(format!(
            "{message}\n\n{}\n\nFor more information, try '{name} --help'.",
            usage.ansi()
        ))
    }

    /// Returns an error without a remedy beside its message.
    pub fn from_error(error: impl StdError + Send + Sync + 'static) -> Self {
        Self::Failed(miette::Report::from_err(error))
    }

    /// Prints the error to standard error, or help to standard output.
    pub fn print(&self) -> ExitCode {
        let error = match self {
            Self::Usage(error) => error,
            Self::Misused(message) => {
                let message = format!("{message}\n");
                &Box::new(clap::Error::raw(ErrorKind::ArgumentConflict, message))
            }
            Self::Failed(report) => {
                let _ = writeln!(io::stderr(), "Error: {report:?}");
                return ExitCode::FAILURE;
            }
        };
        let printed = error.print().and_then(|()| io::stdout().flush());
        match printed {
            // Help is a report, like any other.
            Err(reason) if !error.use_stderr() && reason.kind() != io::ErrorKind::BrokenPipe => {
                Self::from(no_output(&reason)).print()
            }
            // Where standard error is closed, nobody is left to tell.
            _ => u8::try_from(error.exit_code()).map_or(ExitCode::FAILURE, ExitCode::from),
        }
    }
}

impl<D: Diagnostic + Send + Sync + 'static> From<D> for Failure {
    fn from(fault: D) -> Self {
        Self::Failed(fault.into())
    }
}
