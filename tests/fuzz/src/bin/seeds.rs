//! Writes records of each protocol to a folder, one of its own for each target.

use std::path::Path;

fn main() -> std::io::Result<()> {
    let folder = std::env::args_os().nth(1).expect("a folder is named");
    for (name, bytes) in shisen_fuzz::seeds() {
        let folder = Path::new(&folder).join(name.replace('-', "_"));
        std::fs::create_dir_all(&folder)?;
        std::fs::write(folder.join("seed"), bytes)?;
    }
    Ok(())
}
