//! A record of what a viewer saw: what decides each frame, and hashes of what it was.
//!
//! [`Writer`] writes it frame by frame, [`Reader`] reads it. The format is described in
//! `host/doc/record.md`.

mod frame;
mod hashes;

pub use frame::RecordedFrame;
pub use hashes::{WallHash, of_pictures, of_tiles};

use crate::files::Fault;
use crate::live::Quality;
use serde::{Deserialize, Serialize};
use std::fs::File;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use xxhash_rust::xxh3::xxh3_64;

/// The first bytes of a record; the number is the format's version.
const MAGIC: &[u8] = b"shisen record 1\n";
const MAGIC_OF_ANY: &[u8] = b"shisen record ";

/// Bytes before and after what an entry holds: its kind and length, and its check.
const BEFORE: usize = 5;
const AFTER: usize = 4;

const SESSION: u8 = 1;
const FRAME: u8 = 2;
const RAW: u8 = 3;
const END: u8 = 4;

/// What the frames behind it have in common.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Setup {
    /// The version of the program that recorded.
    pub program: String,
    /// Its arguments, `run` and what follows.
    pub arguments: Vec<String>,
    /// The folder in which it ran, to which paths are relative.
    pub folder: String,
    /// What keys changed since: `scene B`, `detail`.
    pub changes: Vec<String>,
    /// What shows where the gaze skips rays: `background` or `previous`. With `previous` a frame
    /// builds on all since the session began.
    pub fill: String,
    /// The scene's name or path.
    pub scene: String,
    /// The hash of the baked scene, in hexadecimal.
    pub scene_hash: String,
    /// The room's file; `None`: a built-in one.
    pub walls: Option<String>,
    /// Pixels a side of a tile.
    pub tile: u32,
    /// The pictures, in their order.
    pub pictures: Vec<RecordedPicture>,
    /// The qualities that frames have by their numbers, from the best.
    pub rungs: Vec<Quality>,
}

/// A picture of each frame.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct RecordedPicture {
    /// The wall or projector.
    pub name: String,
    /// The eye: left, right or centre.
    pub eye: String,
    /// Columns and rows.
    pub size: [u32; 2],
}

impl Setup {
    /// Returns the rows of tiles of a picture.
    pub fn rows_of(&self, picture: &RecordedPicture) -> usize {
        picture.size[1].div_ceil(self.tile.max(1)) as usize
    }
}

/// An entry of a record.
#[derive(Debug, Clone, PartialEq)]
pub enum Entry {
    /// What the frames behind it have in common.
    Session(Box<Setup>),
    /// A frame.
    Frame(Box<RecordedFrame>),
    /// Bytes of a tracker, by its number, as `shisen tracker record --raw` writes them.
    Raw(u8, Vec<u8>),
    /// The record is whole.
    End,
}

/// Writes a record, entry after entry: what a program that is stopped has written is there.
#[derive(Debug)]
pub struct Writer {
    path: PathBuf,
    file: File,
    entry: Vec<u8>,
}

impl Writer {
    /// Creates the file.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn create(path: &Path) -> Result<Self, Fault> {
        let mut file = File::create(path).map_err(Fault::write(path))?;
        file.write_all(MAGIC).map_err(Fault::write(path))?;
        Ok(Self {
            path: path.to_owned(),
            file,
            entry: Vec::new(),
        })
    }

    /// Begins a session.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn session(&mut self, setup: &Setup) -> Result<(), Fault> {
        self.write(SESSION, |bytes| {
            serde_json::to_writer(bytes, setup).map_err(Into::into)
        })
    }

    /// Adds a frame of the session.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn frame(&mut self, frame: &RecordedFrame) -> Result<(), Fault> {
        self.write(FRAME, |bytes| {
            frame.write(bytes);
            Ok(())
        })
    }

    /// Adds bytes of a tracker.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn raw(&mut self, tracker: u8, from: &[u8]) -> Result<(), Fault> {
        self.write(RAW, |bytes| {
            bytes.push(tracker);
            bytes.extend_from_slice(from);
            Ok(())
        })
    }

    /// Ends the record.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn finish(mut self) -> Result<(), Fault> {
        self.write(END, |_| Ok(()))
    }

    fn write(
        &mut self,
        kind: u8,
        fill: impl FnOnce(&mut Vec<u8>) -> io::Result<()>,
    ) -> Result<(), Fault> {
        let entry = &mut self.entry;
        entry.clear();
        entry.extend_from_slice(&[kind, 0, 0, 0, 0]);
        let filled = fill(entry);
        let length = (entry.len() - BEFORE) as u32;
        entry[1..BEFORE].copy_from_slice(&length.to_le_bytes());
        let check = check(entry);
        entry.extend_from_slice(&check);
        let written = filled.and_then(|()| self.file.write_all(entry));
        written.map_err(Fault::write(&self.path))
    }
}

fn check(entry: &[u8]) -> [u8; AFTER] {
    (xxh3_64(entry) as u32).to_le_bytes()
}

/// Why the rest of a record, or one frame of it, cannot be read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Damage {
    /// It ends within an entry, or without its end.
    CutOff,
    /// A frame that is not what was written, by its number.
    Frame(u64),
    /// An entry that is not what was written and looks like no frame, before the frame of this number
    /// or in its place.
    Other(u64),
}

impl Damage {
    const fn at(kind: u8, number: u64) -> Self {
        match kind {
            FRAME => Self::Frame(number),
            _ => Self::Other(number),
        }
    }
}

/// Reads a record, entry after entry.
#[derive(Debug, Clone)]
pub struct Reader<'a> {
    rest: &'a [u8],
    setup: Option<Setup>,
    frames: u64,
    is_over: bool,
    is_lost: bool,
}

impl<'a> Reader<'a> {
    /// Returns the reader of a file's bytes.
    ///
    /// # Errors
    /// A file that is no record, or one of another version.
    pub fn new(path: &Path, bytes: &'a [u8]) -> Result<Self, Fault> {
        let refused = |what: &str, help: &str| {
            let message = format!("{}: {what}", path.display());
            Err(Fault::new(message, help))
        };
        let Some(rest) = bytes.strip_prefix(MAGIC) else {
            return if bytes.starts_with(MAGIC_OF_ANY) {
                let first = bytes.split(|byte| *byte == b'\n').next();
                let version = first.unwrap_or_default().get(MAGIC_OF_ANY.len()..);
                let version = String::from_utf8_lossy(version.unwrap_or_default()).into_owned();
                refused(
                    &format!("a record of version {version:.9}, and this program reads version 1"),
                    "take the program that recorded it, or record it again",
                )
            } else {
                let help = "give a file that `shisen run --record FILE` wrote";
                refused("no record", help)
            };
        };
        Ok(Self {
            rest,
            setup: None,
            frames: 0,
            is_over: false,
            is_lost: false,
        })
    }

    /// Returns the number of the frame that comes next.
    pub const fn frames(&self) -> u64 {
        self.frames
    }

    /// Returns whether what comes behind an altered entry could not be read.
    pub const fn is_lost(&self) -> bool {
        self.is_lost
    }

    /// Returns the next entry; `None` behind the last. Behind a frame that was altered others may
    /// come.
    pub fn entry(&mut self) -> Option<Result<Entry, Damage>> {
        if self.is_over {
            return None;
        }
        if self.rest.is_empty() {
            self.is_over = true;
            return Some(Err(Damage::CutOff));
        }
        let Some((entry, check_bytes)) = self.split() else {
            self.is_over = true;
            let damage = self.end_of_rest();
            self.is_lost = damage != Damage::CutOff;
            return Some(Err(damage));
        };
        let (before, held) = entry.split_at(BEFORE);
        let kind = before[0];
        self.rest = &self.rest[entry.len() + AFTER..];
        let number = self.frames;
        let entry = (check(entry) == *check_bytes).then(|| self.decode(kind, held));
        let Some(entry) = entry.flatten() else {
            // Another kind or length would lead nowhere.
            self.is_over = !matches!(kind, FRAME | RAW);
            self.is_lost = self.is_over;
            self.frames += u64::from(kind == FRAME);
            return Some(Err(Damage::at(kind, number)));
        };
        self.is_over = entry == Entry::End;
        if let (true, false) = (self.is_over, self.rest.is_empty()) {
            return Some(Err(Damage::Other(number)));
        }
        Some(Ok(entry))
    }

    /// Returns the next entry and its check.
    fn split(&self) -> Option<(&'a [u8], &'a [u8; AFTER])> {
        let (before, _) = self.rest.split_first_chunk::<BEFORE>()?;
        let [_, length @ ..] = *before;
        let end = BEFORE.checked_add(u32::from_le_bytes(length) as usize)?;
        let (entry, behind) = self.rest.split_at_checked(end)?;
        Some((entry, behind.first_chunk()?))
    }

    /// Returns whether a rest that holds no whole entry was cut off, or its length altered.
    fn end_of_rest(&self) -> Damage {
        let last = self.rest.len().checked_sub(BEFORE + AFTER);
        let end = last.and_then(|at| self.rest.get(at..));
        let is_whole = end.is_some_and(|end| {
            let (entry, check_bytes) = end.split_at(BEFORE);
            entry == [END, 0, 0, 0, 0] && check(entry) == *check_bytes
        });
        if is_whole {
            Damage::at(self.rest[0], self.frames)
        } else {
            Damage::CutOff
        }
    }

    /// Returns what an entry of the right check holds.
    fn decode(&mut self, kind: u8, held: &[u8]) -> Option<Entry> {
        match kind {
            SESSION => {
                let setup: Setup = serde_json::from_slice(held).ok()?;
                self.setup = Some(setup.clone());
                Some(Entry::Session(Box::new(setup)))
            }
            FRAME => {
                let frame = RecordedFrame::read(held, self.setup.as_ref()?)?;
                self.frames = frame.number.saturating_add(1);
                Some(Entry::Frame(Box::new(frame)))
            }
            RAW => {
                let (tracker, bytes) = held.split_first()?;
                Some(Entry::Raw(*tracker, bytes.to_vec()))
            }
            END => held.is_empty().then_some(Entry::End),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests;
