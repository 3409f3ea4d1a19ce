//! Reading and writing files: only regular files are read, and files appear complete or not at
//! all. [`description`] points at the line of a TOML file that is wrong.

pub mod description;

use miette::Diagnostic;
use serde::{Deserialize, Serialize};
use std::cell::RefCell;
use std::fs::File;
use std::io::{self, BufWriter, Read as _, Seek, Write};
use std::path::{Path, PathBuf};
use thiserror::Error;
use xxhash_rust::xxh3::xxh3_64;

/// What is wrong with an input, and what to do about it.
#[derive(Debug, Clone, PartialEq, Eq, Error, Diagnostic)]
#[error("{message}")]
pub struct Fault {
    message: String,
    #[help]
    help: Option<String>,
}

/// Returns an error and what to do about it, on one line.
pub fn with_help(error: &dyn Diagnostic) -> String {
    match error.help() {
        Some(help) => format!("{error}; {help}"),
        None => error.to_string(),
    }
}

impl Fault {
    /// Makes an error of a message and what to do.
    pub fn new(message: impl Into<String>, help: impl Into<String>) -> Self {
        let (message, help) = (message.into(), Some(help.into()));
        Self { message, help }
    }

    pub(crate) fn of(error: &impl Diagnostic) -> Self {
        let help = error.help().map(|help| help.to_string());
        let message = error.to_string();
        Self { message, help }
    }

    /// Makes the error of a file that cannot be written.
    pub fn write(path: &Path) -> impl FnOnce(io::Error) -> Self {
        move |reason| {
            let (what, help) = explain(&reason);
            Self::new(format!("{}: cannot write: {what}", path.display()), help)
        }
    }
}

/// What to do about a file that cannot be read.
pub(crate) const UNREAD: &str = "check the file's name and permissions";

/// A file that was read, or that was looked for.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct ReadFile {
    path: PathBuf,
    /// Hash of its bytes; none where it could not be read.
    hash: Option<u64>,
}

impl ReadFile {
    /// Returns whether reading it has the same outcome now.
    pub(crate) fn is_unchanged(&self) -> bool {
        self.hash == unrecorded(&self.path, MOST).ok().as_deref().map(xxh3_64)
    }
}

thread_local! {
    /// The files that this thread reads, where somebody asks.
    static READ: RefCell<Option<Vec<ReadFile>>> = const { RefCell::new(None) };
}

/// Runs a part of the program; returns what it returns and the files that its thread reads.
pub(crate) fn recorded<T>(part: impl FnOnce() -> T) -> (T, Vec<ReadFile>) {
    READ.set(Some(Vec::new()));
    let result = part();
    (result, READ.take().unwrap_or_default())
}

/// Most MiB of a file: a baked scene has no more.
pub const MOST: u64 = 4096;

/// Most MiB of a text that describes something.
pub const MOST_OF_TEXT: u64 = 64;

/// Reads a whole regular file of up to [`MOST`] MiB: a device or a pipe might never end.
///
/// # Errors
/// What the system says; [`io::ErrorKind::InvalidInput`] for anything that is not a regular file,
/// [`io::ErrorKind::FileTooLarge`] for a larger one, which is not read.
pub fn read(path: &Path) -> io::Result<Vec<u8>> {
    read_within(path, MOST)
}

/// As [`read`], for up to `most` MiB.
pub(crate) fn read_within(path: &Path, most: u64) -> io::Result<Vec<u8>> {
    let bytes = unrecorded(path, most);
    READ.with_borrow_mut(|files| {
        if let Some(files) = files {
            let hash = bytes.as_deref().ok().map(xxh3_64);
            let path = path.to_owned();
            files.push(ReadFile { path, hash });
        }
    });
    bytes
}

fn unrecorded(path: &Path, most: u64) -> io::Result<Vec<u8>> {
    let metadata = std::fs::metadata(path).map_err(in_words)?;
    if !metadata.is_file() {
        let words = "not a regular file";
        return Err(io::Error::new(io::ErrorKind::InvalidInput, words));
    }
    if metadata.len() > most << 20 {
        let has = metadata.len().div_ceil(1 << 20);
        let words = format!("it has {has} MiB, but at most {most} MiB of such a file are read");
        return Err(io::Error::new(io::ErrorKind::FileTooLarge, words));
    }
    std::fs::read(path).map_err(in_words)
}

/// Returns whether a regular file begins with these bytes.
pub(crate) fn begins_with<const N: usize>(path: &Path, bytes: &[u8; N]) -> bool {
    let is_file = std::fs::metadata(path).is_ok_and(|metadata| metadata.is_file());
    let mut first = [0; N];
    let read = || File::open(path)?.read_exact(&mut first);
    is_file && { read }().is_ok() && first == *bytes
}

/// Returns the reason in words of ours where it is a common one.
fn in_words(reason: io::Error) -> io::Error {
    let words = match reason.kind() {
        io::ErrorKind::NotFound => "there is no such file",
        io::ErrorKind::PermissionDenied => "you may not read it",
        io::ErrorKind::NotADirectory => "a part of the path is a file, not a folder",
        _ => return reason,
    };
    io::Error::new(reason.kind(), words)
}

/// As [`read`], for text in UTF-8 of up to [`MOST_OF_TEXT`] MiB.
///
/// # Errors
/// As [`read`]; [`io::ErrorKind::InvalidData`] for what is not UTF-8.
pub fn read_text(path: &Path) -> io::Result<String> {
    String::from_utf8(read_within(path, MOST_OF_TEXT)?)
        .map_err(|_| io::Error::new(io::ErrorKind::InvalidData, "not text in UTF-8"))
}

/// A file that encoders can write to.
pub trait WriteSeek: Write + Seek {}
impl<T: Write + Seek> WriteSeek for T {}

/// Writes a file under a temporary name beside `path`, then renames it, over
/// an existing file too, so that no reader sees half of it. A link is followed. A device or a pipe
/// stays what it is and gets all bytes at the end.
///
/// # Errors
///
/// What the system or `write` reports. A file that was at `path` before is still there, and the
/// temporary file is removed.
pub fn write_atomically(
    path: &Path,
    write: impl FnOnce(&mut dyn WriteSeek) -> io::Result<()>,
) -> io::Result<()> {
    // A path that cannot be resolved is new, or fails below.
    let target = std::fs::canonicalize(path);
    let path = target.as_deref().unwrap_or(path);
    let is_special = |meta: &std::fs::Metadata| !meta.is_file() && !meta.is_dir();
    if std::fs::metadata(path).is_ok_and(|meta| is_special(&meta)) {
        // Encoders go back in what they write, which a pipe does not.
        let mut whole = io::Cursor::new(Vec::new());
        write(&mut whole)?;
        let mut device = std::fs::OpenOptions::new().write(true).open(path)?;
        return device.write_all(whole.get_ref());
    }
    let folder = match path.parent() {
        Some(folder) if folder != Path::new("") => folder,
        _ => Path::new("."),
    };
    // A regular file with the permissions of the umask; temporary files are private by default.
    let file = tempfile::Builder::new().make_in(folder, |path| File::create_new(path))?;
    let mut file = BufWriter::new(file);
    write(&mut file)?;
    let file = file.into_inner().map_err(io::IntoInnerError::into_error)?;
    file.persist(path).map_err(|error| error.error)?;
    Ok(())
}

/// Returns what a failure to write a file means, and what to do about it.
pub fn explain(reason: &io::Error) -> (String, &'static str) {
    let (what, help) = match reason.kind() {
        io::ErrorKind::NotFound => ("the folder does not exist", "create it first"),
        io::ErrorKind::NotADirectory => (
            "a part of the path is a file, not a folder",
            "choose another path",
        ),
        io::ErrorKind::IsADirectory => ("a folder has this name", "choose another name"),
        io::ErrorKind::PermissionDenied => (
            "it, or the folder, is not writable",
            "change the permissions, or choose another path",
        ),
        io::ErrorKind::ReadOnlyFilesystem => {
            ("the file system is read-only", "choose another folder")
        }
        io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded => (
            "there is no space left",
            "free some space, or choose another folder",
        ),
        io::ErrorKind::AlreadyExists => ("a file has this name", "choose another name"),
        _ => return (reason.to_string(), "choose another path"),
    };
    (what.to_owned(), help)
}

/// Returns what a failure to make a folder means, and what to do about it.
pub fn explain_folder(reason: &io::Error) -> (String, &'static str) {
    match reason.kind() {
        io::ErrorKind::NotFound => (
            "no folder can be made there".to_owned(),
            "choose another folder",
        ),
        _ => explain(reason),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_too_large_is_not_read() {
        let file = tempfile::NamedTempFile::new().unwrap();
        for (most, is_text) in [(MOST, false), (MOST_OF_TEXT, true)] {
            file.as_file().set_len((most << 20) + 1).unwrap();
            let read = if is_text {
                read_text(file.path()).err()
            } else {
                read(file.path()).err()
            };
            let words = format!("it has {} MiB, but at most {most} MiB", most + 1);
            assert!(read.unwrap().to_string().starts_with(&words));
        }
    }

    #[cfg(unix)]
    #[test]
    fn what_is_no_regular_file_stays_what_it_is() {
        use std::os::unix::fs::FileTypeExt;
        let folder = tempfile::tempdir().unwrap();
        let put =
            |path: &Path, text: &str| write_atomically(path, |f| f.write_all(text.as_bytes()));

        // A link leads where it led.
        let (file, link) = (folder.path().join("file"), folder.path().join("link"));
        std::fs::write(&file, "before").unwrap();
        std::os::unix::fs::symlink(&file, &link).unwrap();
        put(&link, "after").unwrap();
        assert!(std::fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(std::fs::read_to_string(&file).unwrap(), "after");

        // Whoever reads a pipe gets all of it.
        let pipe = folder.path().join("pipe");
        let made = std::process::Command::new("mkfifo").arg(&pipe).status();
        assert!(made.unwrap().success());
        let other = pipe.clone();
        let reader = std::thread::spawn(move || std::fs::read_to_string(other).unwrap());
        put(&pipe, "through").unwrap();
        assert_eq!(reader.join().unwrap(), "through");
        let kind = std::fs::symlink_metadata(&pipe).unwrap().file_type();
        assert!(kind.is_fifo());

        // A device by a link, so that no test can take the machine's own away.
        let link = folder.path().join("device");
        std::os::unix::fs::symlink("/dev/null", &link).unwrap();
        put(&link, "away").unwrap();
        let kind = std::fs::metadata("/dev/null").unwrap().file_type();
        assert!(kind.is_char_device());
    }
}
