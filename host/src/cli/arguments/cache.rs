//! Baked scenes that are kept for the next start.
//!
//! An entry of the cache's folder is a file: the length of a record, the record in JSON, and the
//! baked scene. Its name is the hash of what was asked for; the record has the hashes of the files
//! that were read, which have to be as they were.

use crate::cli::arguments::source::{Ready, Shown};
use crate::cli::prelude::*;
use crate::files::{ReadFile, recorded, write_atomically};
use glam::DVec3;
use serde::Deserialize;
use shisen_core::scene::format;
use std::fs::File;
use std::io::{self, Read};
use std::time::SystemTime;
use xxhash_rust::xxh3::xxh3_64;

#[derive(Debug, Clone, Args)]
pub struct CacheArguments {
    #[arg(
        long,
        value_name = "DIR|off",
        help = "Folder in which baked scenes are kept for the next start, 4 GB at most; or off \
                [default: that of the variable SHISEN_CACHE, or shisen in the user's folder of \
                caches]"
    )]
    cache: Option<PathBuf>,
}

/// Most bytes of all entries together.
const MOST_BYTES: u64 = 4_000_000_000;

/// Most bytes of a record.
const MOST_RECORD_BYTES: u64 = 1 << 24;

const EXTENSION: &str = "kept";

/// What an entry has besides the baked scene.
#[derive(Serialize, Deserialize)]
struct Record {
    files: Vec<ReadFile>,
    shown: Shown,
    look: Option<[f64; 3]>,
    /// What was warned of while it was baked.
    warnings: Vec<String>,
}

impl CacheArguments {
    /// Returns what is kept for a request, or makes it and keeps it. `request` says in full what
    /// is asked for, but for the contents of files.
    pub fn kept(
        &self,
        request: &str,
        make: impl FnOnce() -> Result<Ready, Failure>,
    ) -> Result<Ready, Failure> {
        let folder = match self.folder() {
            Ok(Some(folder)) => folder,
            Ok(None) => return make(),
            Err(reason) => {
                unkept(&reason);
                return make();
            }
        };
        let path = folder.join(format!("{:016x}.{EXTENSION}", key(request)));
        if let Some(ready) = read(&path) {
            ready.shown.told.repeat();
            for warning in &ready.warnings {
                warn(warning);
            }
            return Ok(ready);
        }
        let (made, files) = recorded(make);
        let ready = made?;
        // What moves is not in the baked scene.
        if ready.is_new && ready.moving.is_none() && !files.is_empty() {
            let record = Record {
                files,
                shown: ready.shown.clone(),
                look: ready.look.map(|look| look.to_array()),
                warnings: ready.warnings.clone(),
            };
            if let Err(reason) = keep(&folder, &path, &record, &ready.baked) {
                unkept(&format!("{}: {reason}", folder.display()));
            }
        }
        Ok(ready)
    }

    fn folder(&self) -> Result<Option<PathBuf>, String> {
        let named = |name: &str| std::env::var_os(name).map(PathBuf::from);
        let given = self.cache.clone().or_else(|| named("SHISEN_CACHE"));
        match given.filter(|folder| !folder.as_os_str().is_empty()) {
            Some(off) if off.as_os_str() == "off" => return Ok(None),
            Some(folder) => return Ok(Some(folder)),
            None => {}
        }
        let absolute = |path: Option<PathBuf>| path.filter(|path| path.is_absolute());
        let (own, rest) = if cfg!(windows) {
            ("LOCALAPPDATA", None)
        } else {
            ("XDG_CACHE_HOME", absolute(named("HOME")))
        };
        let folder = absolute(named(own)).or_else(|| rest.map(|home| home.join(".cache")));
        let none = || "this user has no folder of caches".to_owned();
        folder
            .map(|folder| Some(folder.join("shisen")))
            .ok_or_else(none)
    }
}

fn unkept(reason: &str) {
    warn(&format!(
        "the baked scene is not kept for the next start: {reason}. Give a folder with --cache DIR, \
         or --cache off"
    ));
}

/// Returns the hash of a request to this program.
fn key(request: &str) -> u64 {
    let built = std::env::current_exe().and_then(std::fs::metadata);
    let built = built.and_then(|program| Ok((program.len(), program.modified()?)));
    let (version, format) = (env!("CARGO_PKG_VERSION"), format::VERSION);
    let folder = std::env::current_dir();
    xxh3_64(format!("{version} {format} {built:?} {folder:?} {request}").as_bytes())
}

/// Returns what an entry holds, if its files are as they were.
fn read(path: &Path) -> Option<Ready> {
    let mut file = File::open(path).ok()?;
    let mut length = [0; 8];
    file.read_exact(&mut length).ok()?;
    let length = u64::from_le_bytes(length);
    if length > MOST_RECORD_BYTES {
        return None;
    }
    let mut record = Vec::new();
    (&mut file).take(length).read_to_end(&mut record).ok()?;
    let record: Record = serde_json::from_slice(&record).ok()?;
    if !record.files.iter().all(ReadFile::is_unchanged) {
        return None;
    }
    let rest = file.metadata().ok()?.len().checked_sub(8 + length)?;
    let baked = BakedScene::read(&mut file, usize::try_from(rest).ok()?).ok()?;
    // The time of its last use decides when it is removed; without that, its age does.
    let _ = File::options()
        .append(true)
        .open(path)
        .and_then(|file| file.set_modified(SystemTime::now()));
    Some(Ready {
        baked,
        shown: record.shown,
        look: record.look.map(DVec3::from),
        warnings: record.warnings,
        moving: None,
        is_new: false,
    })
}

/// Writes an entry. Beyond the limit it removes the entries that were used least recently.
fn keep(folder: &Path, path: &Path, record: &Record, baked: &BakedScene) -> io::Result<()> {
    let record = serde_json::to_vec(record)?;
    let bytes = baked.as_bytes();
    let length = record.len() as u64;
    if length > MOST_RECORD_BYTES || length + bytes.len() as u64 > MOST_BYTES {
        return Err(io::Error::other("it is larger than all may be together"));
    }
    std::fs::create_dir_all(folder)?;
    write_atomically(path, |file| {
        file.write_all(&length.to_le_bytes())?;
        file.write_all(&record)?;
        file.write_all(bytes)
    })?;
    let mut entries = Vec::new();
    for entry in std::fs::read_dir(folder)? {
        let path = entry?.path();
        if path.extension().is_some_and(|one| one == EXTENSION)
            && let Ok(about) = path.metadata()
        {
            entries.push((about.modified()?, about.len(), path));
        }
    }
    entries.sort_unstable();
    let mut total: u64 = entries.iter().map(|(_, bytes, _)| bytes).sum();
    for (_, bytes, path) in entries {
        if total <= MOST_BYTES {
            break;
        }
        match std::fs::remove_file(&path) {
            // Another program was faster.
            Err(fault) if fault.kind() == io::ErrorKind::NotFound => {}
            removed => removed?,
        }
        total -= bytes;
    }
    Ok(())
}
