//! Why a command ends without having done what it was asked to.

use crate::bake::BakeError;
use crate::files::{explain, explain_folder};
use clap::error::ErrorKind;
use miette::Diagnostic;
use shisen_core::scene::SceneError;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use thiserror::Error;

/// Why a command ends early.
#[derive(Debug)]
pub enum Failure {
    /// The command line itself is wrong, or asks for help. Boxed: the text is
    /// large and the case is rare.
    Usage(Box<clap::Error>),
    /// Each argument is right by itself, but not beside the others.
    Misused(String),
    /// Something that it names, or the machine, does not serve.
    Failed(miette::Report),
}

/// Faults that only the command can have.
#[derive(Debug, Error, Diagnostic)]
pub enum Fault {
    /// A scene that cannot be read.
    #[error("cannot read the scene in {}: {reason}", path.display())]
    #[diagnostic(help(
        "give A, B, C, D, grid, prism or spheres, the path of a TOML description, or that of a scene that `shisen bake` wrote"
    ))]
    ReadScene {
        /// The file.
        path: PathBuf,
        /// What the system said.
        reason: io::Error,
    },
    /// A mesh where a scene belongs.
    #[error("{} is a mesh, not a scene", path.display())]
    #[diagnostic(help(
        "place it in a built-in scene with --scene A --mesh FILE, or bake it first"
    ))]
    MeshAsScene {
        /// The file.
        path: PathBuf,
    },
    /// What is to be a baked scene and cannot be read.
    #[error("cannot read the baked scene in {}: {reason}", path.display())]
    #[diagnostic(help("give the path of a scene that `shisen bake` wrote"))]
    ReadBaked {
        /// The file.
        path: PathBuf,
        /// What the system said.
        reason: io::Error,
    },
    /// Neither text nor a baked scene.
    #[error("{} is neither a TOML description nor a baked scene", path.display())]
    #[diagnostic(help("if `shisen bake` wrote it, it has been damaged since: bake it again"))]
    NotAScene {
        /// The file.
        path: PathBuf,
    },
    /// A baked scene that the core refuses.
    #[error("{} cannot be used", path.display())]
    #[diagnostic(help("bake the scene, or bake it again, with `shisen bake`"))]
    Blob {
        /// The file.
        path: PathBuf,
        /// Why.
        source: SceneError,
    },
    /// A baked scene that is to be baked.
    #[error("{name} is baked already")]
    #[diagnostic(help("give what it was baked from"))]
    AlreadyBaked {
        /// The file.
        name: String,
    },
    /// A scene that was read but cannot be baked.
    #[error("{name} cannot be baked")]
    #[diagnostic(help("change what is named above, in the scene or in its mesh"))]
    Bake {
        /// What was read.
        name: String,
        /// Why.
        source: BakeError,
    },
    /// A scene that was read but has a mesh without such polygon levels.
    #[error("{name} cannot have these polygon levels")]
    #[diagnostic(help("give a larger MIN with --faces MIN..MAX"))]
    Levels {
        /// What was read.
        name: String,
        /// Why.
        source: BakeError,
    },
    /// A mesh that the built-in scenes cannot scale.
    #[error("{mesh}: the mesh is flat along x, so it cannot be scaled to the scene")]
    #[diagnostic(help("turn it so that it is long along x"))]
    Flat {
        /// What the mesh is called.
        mesh: String,
    },
    /// A file of rays that cannot be read.
    #[error("cannot read the rays in {}: {reason}", path.display())]
    #[diagnostic(help("give the path of a file of rays: six little-endian f32 each"))]
    ReadRays {
        /// The file.
        path: PathBuf,
        /// What the system said.
        reason: io::Error,
    },
    /// Bytes that are no whole number of rays, or none.
    #[error(
        "{} has {bytes} bytes, which is no whole number of rays above 0",
        path.display()
    )]
    #[diagnostic(help(
        "a ray takes 24 bytes: origin x, y, z and direction x, y, z as little-endian f32; there is no header"
    ))]
    RayBytes {
        /// The file.
        path: PathBuf,
        /// Its length.
        bytes: usize,
    },
    /// A folder that pictures cannot go to.
    #[error("the pictures cannot go to {}: {}", path.display(), explain_folder(reason))]
    #[diagnostic(help("give a folder that you may write to with --out"))]
    OutputFolder {
        /// The folder.
        path: PathBuf,
        /// What the system said.
        reason: io::Error,
    },
    /// A file that cannot be written.
    #[error("{}: cannot write: {}", path.display(), explain(reason))]
    Write {
        /// The file.
        path: PathBuf,
        /// What the system said.
        reason: io::Error,
    },
    /// Threads that the system does not give.
    #[error("cannot start {threads} threads: {reason}")]
    #[diagnostic(help("ask for fewer with --threads"))]
    Threads {
        /// How many were asked for.
        threads: usize,
        /// What the system said.
        reason: rayon::ThreadPoolBuildError,
    },
    /// Errors above what is promised.
    #[error("{failed} of {total} hard cases are beyond their bounds")]
    #[diagnostic(help(
        "this build computes something else than was tested: build it again with the compiler's own settings, and report it with the table above where that does not help"
    ))]
    HardCases {
        /// How many.
        failed: usize,
        /// Of how many.
        total: usize,
    },
    /// Standard output that takes nothing more.
    #[error("cannot write to standard output: {reason}")]
    #[diagnostic(help(
        "make room where it leads to, or let it lead elsewhere; files that were written are complete"
    ))]
    Print {
        /// What the system said.
        reason: io::Error,
    },
}

impl Fault {
    /// For the failure of writing `path`.
    pub fn write(path: &Path) -> impl FnOnce(io::Error) -> Self {
        move |reason| Self::Write {
            path: path.to_owned(),
            reason,
        }
    }
}

impl Failure {
    /// A fault of the command line that no single argument shows.
    pub fn usage(message: &str) -> Self {
        Self::Misused(message.to_owned())
    }

    /// Adds the usage of the command that was asked for: its names within the `whole` command
    /// line, from the outermost on.
    #[must_use]
    pub fn with_usage(self, mut whole: clap::Command, names: &[String]) -> Self {
        let Self::Misused(message) = self else {
            return self;
        };
        // So that each command knows the names before its own.
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

    /// What the command line's parser says, which may be the help asked for.
    pub fn from_clap(error: clap::Error) -> Self {
        Self::Usage(Box::new(error))
    }

    /// An error that has no remedy to show beside its message.
    pub fn from_error(error: impl std::error::Error + Send + Sync + 'static) -> Self {
        Self::Failed(miette::Report::from_err(error))
    }

    /// Prints it to standard error, or help to standard output.
    pub fn print(&self) -> ExitCode {
        match self {
            Self::Usage(error) => tell(error),
            Self::Misused(message) => tell(&clap::Error::raw(
                ErrorKind::ArgumentConflict,
                format!("{message}\n"),
            )),
            Self::Failed(report) => {
                let _ = writeln!(io::stderr(), "Error: {report:?}");
                ExitCode::FAILURE
            }
        }
    }
}

/// Says what is wrong with a command line, or the help asked for, and how that ends.
fn tell(error: &clap::Error) -> ExitCode {
    let said = error.print().and_then(|()| io::stdout().flush());
    match said {
        // Help is a report, as any other.
        Err(reason) if !error.use_stderr() && reason.kind() != io::ErrorKind::BrokenPipe => {
            Failure::from(Fault::Print { reason }).print()
        }
        // Nobody is left to tell where standard error is closed.
        _ => u8::try_from(error.exit_code()).map_or(ExitCode::FAILURE, ExitCode::from),
    }
}

impl<D: Diagnostic + Send + Sync + 'static> From<D> for Failure {
    fn from(fault: D) -> Self {
        Self::Failed(fault.into())
    }
}
