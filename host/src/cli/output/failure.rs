//! Why a command ends without having done what it was asked to.

use crate::bake::BakeError;
use crate::files::{explain, explain_folder};
use clap::error::ErrorKind;
use miette::Diagnostic;
use shisen_core::scene::SceneError;
use std::error::Error as StdError;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use thiserror::Error;

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

/// What can go wrong in the command itself.
#[derive(Debug, Error, Diagnostic)]
pub enum Fault {
    #[error("cannot read the scene in {}: {reason}", path.display())]
    #[diagnostic(help(
        "give A, B, C, D, grid, prism or spheres, the path of a TOML description, or the path of a scene that `shisen bake` wrote"
    ))]
    ReadScene { path: PathBuf, reason: io::Error },
    #[error("{} is a mesh, not a scene", path.display())]
    #[diagnostic(help(
        "place it in a built-in scene with --scene A --mesh FILE, or bake it first"
    ))]
    MeshAsScene { path: PathBuf },
    #[error("cannot read the baked scene in {}: {reason}", path.display())]
    #[diagnostic(help("give the path of a scene that `shisen bake` wrote"))]
    ReadBaked { path: PathBuf, reason: io::Error },
    #[error("{} is neither a TOML description nor a baked scene", path.display())]
    #[diagnostic(help("if `shisen bake` wrote it, it has been damaged since: bake it again"))]
    NotAScene { path: PathBuf },
    #[error("{} cannot be used", path.display())]
    #[diagnostic(help("bake the scene, or bake it again, with `shisen bake`"))]
    Blob { path: PathBuf, source: SceneError },
    #[error("{name} is baked already")]
    #[diagnostic(help("give what it was baked from"))]
    AlreadyBaked { name: String },
    #[error("{name} cannot be baked")]
    #[diagnostic(help("change the part of the scene or mesh that is named above"))]
    Bake { name: String, source: BakeError },
    #[error("{name} cannot have these polygon levels")]
    #[diagnostic(help("give a larger MIN with --faces MIN..MAX"))]
    Levels { name: String, source: BakeError },
    #[error("{mesh}: the mesh is flat along x, so it cannot be scaled to the scene")]
    #[diagnostic(help("turn the mesh so that its longest side is along x"))]
    Flat { mesh: String },
    #[error("cannot read the rays in {}: {reason}", path.display())]
    #[diagnostic(help("give the path of a file of rays, each six little-endian f32"))]
    ReadRays { path: PathBuf, reason: io::Error },
    #[error(
        "{} has {bytes} bytes, which is not a whole number of rays, or none",
        path.display()
    )]
    #[diagnostic(help(
        "a ray takes 24 bytes: origin x, y, z and direction x, y, z as little-endian f32; there is no header"
    ))]
    RayBytes { path: PathBuf, bytes: usize },
    #[error("the pictures cannot go to {}: {}", path.display(), explain_folder(reason))]
    #[diagnostic(help("give a folder that you may write to with --out"))]
    OutputFolder { path: PathBuf, reason: io::Error },
    #[error("{}: cannot write: {}", path.display(), explain(reason))]
    Write { path: PathBuf, reason: io::Error },
    #[error("cannot start {threads} threads: {reason}")]
    #[diagnostic(help("ask for fewer with --threads"))]
    Threads {
        threads: usize,
        reason: rayon::ThreadPoolBuildError,
    },
    #[error("{failed} of {total} hard cases exceed their error bounds")]
    #[diagnostic(help(
        "this build computes other results than the one that was tested: build it again with the compiler's default settings; if the cases still fail, report the table above"
    ))]
    HardCases { failed: usize, total: usize },
    #[error("cannot write to standard output: {reason}")]
    #[diagnostic(help(
        "free some space where the output goes, or send it elsewhere; all files are written"
    ))]
    Print { reason: io::Error },
}

impl Fault {
    /// Makes the error for a failure to write `path`.
    pub fn write(path: &Path) -> impl FnOnce(io::Error) -> Self {
        move |reason| Self::Write {
            path: path.to_owned(),
            reason,
        }
    }
}

/// Turns errors into failures.
pub trait OrFail<T> {
    /// The error is the machine's, or a file's.
    fn or_fail(self) -> Result<T, Failure>;

    /// The error is the command line's.
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
    /// A wrong use of arguments together.
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

    /// An error without a remedy beside its message.
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
                Self::from(Fault::Print { reason }).print()
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
