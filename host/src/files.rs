//! Files that are read whole, and only such as have an end; files that appear complete or
//! not at all.

use std::io::{self, BufWriter, Seek, Write};
use std::path::Path;

/// Reads a whole regular file: a device or a pipe might never end.
///
/// # Errors
/// What the system says; [`io::ErrorKind::InvalidInput`] for anything that is
/// not a regular file.
pub fn read(path: &Path) -> io::Result<Vec<u8>> {
    if std::fs::metadata(path)?.is_file() {
        std::fs::read(path)
    } else {
        Err(io::Error::new(
            io::ErrorKind::InvalidInput,
            "not a regular file",
        ))
    }
}

/// As [`read`], for text in UTF-8.
///
/// # Errors
/// As [`read`]; [`io::ErrorKind::InvalidData`] for what is not UTF-8.
pub fn read_text(path: &Path) -> io::Result<String> {
    String::from_utf8(read(path)?)
        .map_err(|_| io::Error::new(io::ErrorKind::InvalidData, "not text in UTF-8"))
}

/// What encoders ask of a file.
pub trait WriteSeek: Write + Seek {}
impl<T: Write + Seek> WriteSeek for T {}

/// Writes a file under a temporary name beside `path`, then renames it, over
/// an existing file too, so that nobody ever sees half of it.
///
/// # Errors
///
/// What the system or `write` reports. Whatever was at `path` before still
/// is, and the temporary file is gone.
pub fn write_atomically(
    path: &Path,
    write: impl FnOnce(&mut dyn WriteSeek) -> io::Result<()>,
) -> io::Result<()> {
    let folder = match path.parent() {
        Some(folder) if folder != Path::new("") => folder,
        _ => Path::new("."),
    };
    let mut builder = tempfile::Builder::new();
    // Temporary files are the owner's alone unless told otherwise; what was
    // asked for is a regular file, as far as the umask lets it.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    let mut file = BufWriter::new(builder.tempfile_in(folder)?);
    write(&mut file)?;
    let file = file.into_inner().map_err(io::IntoInnerError::into_error)?;
    file.persist(path).map_err(|error| error.error)?;
    Ok(())
}

/// What a failure to write a file means, and what to do about it.
pub fn explain(reason: &io::Error) -> String {
    let advice = match reason.kind() {
        io::ErrorKind::NotFound => "the folder does not exist; create it first",
        io::ErrorKind::NotADirectory => "a part of the path is a file, not a folder",
        io::ErrorKind::IsADirectory => "a folder has this name; choose another",
        io::ErrorKind::PermissionDenied => "the folder is not writable; change its permissions",
        io::ErrorKind::ReadOnlyFilesystem => "the file system is read-only; choose another folder",
        io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded => {
            "there is no space left; free some, or choose another folder"
        }
        _ => return reason.to_string(),
    };
    format!("{advice} ({reason})")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_regular_files_are_read() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("a");
        std::fs::write(&file, b"\xff").unwrap();
        assert_eq!(read(&file).unwrap(), b"\xff");
        assert_eq!(
            read_text(&file).unwrap_err().kind(),
            io::ErrorKind::InvalidData
        );
        assert_eq!(
            read(folder.path()).unwrap_err().kind(),
            io::ErrorKind::InvalidInput
        );
        #[cfg(unix)]
        assert_eq!(
            read(Path::new("/dev/zero")).unwrap_err().kind(),
            io::ErrorKind::InvalidInput
        );
        assert_eq!(
            read(&folder.path().join("b")).unwrap_err().kind(),
            io::ErrorKind::NotFound
        );
    }
}
