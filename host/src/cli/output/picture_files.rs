//! What commands that write pictures have in common.

use crate::cli::output::failure::Fault;
use std::path::Path;

/// Makes the folder and finds out whether files can be written to it, before
/// time goes into pictures.
pub fn make_writable(folder: &Path) -> Result<(), Fault> {
    std::fs::create_dir_all(folder)
        .and_then(|()| tempfile::tempfile_in(folder))
        .map(drop)
        .map_err(|reason| Fault::OutputFolder {
            path: folder.to_owned(),
            reason,
        })
}

/// What is noted in a file: no time or place, so that equal pictures give
/// equal files.
pub fn metadata(note: String) -> [(&'static str, String); 2] {
    let software = concat!("Shisen ", env!("CARGO_PKG_VERSION"));
    [("Software", software.to_owned()), ("Description", note)]
}

/// A hash as reports show it: 64 bits are more than a JSON number holds.
pub fn hexadecimal(hash: u64) -> String {
    format!("{hash:016x}")
}
