//! Files of pictures.

use crate::files::{Fault, explain_folder};
use std::path::Path;

/// Makes a folder and checks that files can be written to it, before pictures take time.
pub fn make_writable(folder: &Path) -> Result<(), Fault> {
    std::fs::create_dir_all(folder)
        .and_then(|()| tempfile::tempfile_in(folder))
        .map(drop)
        .map_err(|reason| {
            let (folder, (what, help)) = (folder.display(), explain_folder(&reason));
            let message = format!("the pictures cannot go to {folder}: {what}");
            Fault::new(message, format!("{help}, with --out"))
        })
}

/// Returns whether a path names a PNG file, and not a folder.
pub fn is_png(path: &Path) -> bool {
    let extension = path.extension();
    extension.is_some_and(|extension| extension.eq_ignore_ascii_case("png"))
}

/// Notes for a file, without time or place, so that equal pictures give equal files.
pub fn metadata(note: String) -> [(&'static str, String); 2] {
    let software = concat!("Shisen ", env!("CARGO_PKG_VERSION"));
    [("Software", software.to_owned()), ("Description", note)]
}

/// Returns a hash as 16 digits: a JSON number does not hold 64 bits.
pub fn hexadecimal(hash: u64) -> String {
    format!("{hash:016x}")
}
