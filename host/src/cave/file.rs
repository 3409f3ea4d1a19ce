//! Walls from a TOML file.
//!
//! ```toml
//! [[wall]]
//! name = "front"
//! lower_left  = [-1.5, -1.5, -1.5]
//! lower_right = [ 1.5, -1.5, -1.5]
//! upper_left  = [-1.5,  1.5, -1.5]
//! pixels = [1920, 1920]               # optional
//! ```

use super::{Cave, Wall, WallError};
use crate::description::{Located, Source};
use glam::DVec3;
use miette::Diagnostic;
use serde::Deserialize;
use std::collections::HashSet;
use std::path::{Path, PathBuf};
use thiserror::Error;
use toml::Spanned;

/// What is wrong in a file of walls.
#[derive(Debug, Clone, PartialEq, Error, Diagnostic)]
pub enum CaveFileFault {
    /// Not TOML, or not the keys and types that a wall has.
    #[error("{message}")]
    #[diagnostic(help(
        "a wall is a [[wall]] with name, lower_left, lower_right and upper_left ([x, y, z] in metres) and, if wanted, pixels ([columns, rows])"
    ))]
    Syntax {
        /// The TOML reader's message.
        message: String,
    },
    /// A file without walls.
    #[error("the file describes no walls")]
    #[diagnostic(help("add a [[wall]] with name, lower_left, lower_right and upper_left"))]
    NoWalls,
    /// A wall that cannot be used.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Wall(#[from] WallError),
}

/// Why walls could not be had from a file.
#[derive(Debug, Error, Diagnostic)]
pub enum CaveFileError {
    /// The file could not be read.
    #[error("cannot read the walls in {}", .path.display())]
    #[diagnostic(help("give three-wall, cube or the path of a TOML file of walls"))]
    Read {
        /// Which file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// It was read, and there is a fault in it.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Fault(#[from] Located<CaveFileFault>),
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct CaveEntry {
    #[serde(default)]
    wall: Vec<WallEntry>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct WallEntry {
    name: Spanned<String>,
    lower_left: Spanned<[f64; 3]>,
    lower_right: Spanned<[f64; 3]>,
    upper_left: Spanned<[f64; 3]>,
    pixels: Option<Spanned<[u32; 2]>>,
}

impl Cave {
    /// Reads a file of walls. `size`, in columns and rows, is for the walls
    /// that name no pixels of their own.
    ///
    /// # Errors
    /// A file that cannot be read, or as [`Self::from_toml`].
    pub fn load(path: &Path, size: [u32; 2]) -> Result<Self, CaveFileError> {
        let text = crate::input::read_text(path).map_err(|source| CaveFileError::Read {
            path: path.to_owned(),
            source,
        })?;
        Ok(Self::from_toml(&text, &path.to_string_lossy(), size)?)
    }

    /// Walls from the text of a file; `source_name` is what messages call
    /// it. `size`, in columns and rows, is for the walls that name no pixels
    /// of their own.
    ///
    /// # Errors
    /// The first fault found and its place: text that is not TOML, unknown
    /// or missing keys, no walls, a wall that [`Wall::validate`] rejects, a
    /// name that is there twice.
    pub fn from_toml(
        text: &str,
        source_name: &str,
        size: [u32; 2],
    ) -> Result<Self, Located<CaveFileFault>> {
        let source = Source {
            name: source_name,
            text,
        };
        let entries: CaveEntry = source.parse(|message| CaveFileFault::Syntax { message })?;
        if entries.wall.is_empty() {
            return Err(Located::new(CaveFileFault::NoWalls, &source, None));
        }
        let mut names = HashSet::new();
        let mut walls = Vec::with_capacity(entries.wall.len());
        for entry in entries.wall {
            let pixels = entry
                .pixels
                .as_ref()
                .map_or(size, |pixels| *pixels.as_ref());
            let wall = Wall {
                name: entry.name.as_ref().clone(),
                lower_left: DVec3::from_array(*entry.lower_left.as_ref()),
                lower_right: DVec3::from_array(*entry.lower_right.as_ref()),
                upper_left: DVec3::from_array(*entry.upper_left.as_ref()),
                pixels,
            };
            let mut checked = wall.validate();
            if checked.is_ok() && !names.insert(wall.name.to_lowercase()) {
                checked = Err(WallError::DuplicateName {
                    wall: wall.name.clone(),
                });
            }
            if let Err(fault) = checked {
                let span = entry.span_of(&fault);
                return Err(Located::new(fault.into(), &source, Some(span)));
            }
            walls.push(wall);
        }
        Ok(Self { walls })
    }
}

impl WallEntry {
    /// The bytes of the value that a fault is about.
    fn span_of(&self, fault: &WallError) -> std::ops::Range<usize> {
        match fault {
            WallError::Corner { corner, .. } => match *corner {
                "lower left" => self.lower_left.span(),
                "lower right" => self.lower_right.span(),
                _ => self.upper_left.span(),
            },
            WallError::ZeroSize { dimension, .. } if *dimension == "width" => {
                self.lower_right.span()
            }
            WallError::ZeroSize { .. } | WallError::Collinear { .. } => self.upper_left.span(),
            WallError::Pixels { .. } => self
                .pixels
                .as_ref()
                .map_or_else(|| self.name.span(), Spanned::span),
            _ => self.name.span(),
        }
    }
}
