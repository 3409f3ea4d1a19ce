//! Walls and domes from a TOML file.
//!
//! ```toml
//! [[wall]]
//! name = "front"
//! lower_left  = [-1.5, -1.5, -1.5]
//! lower_right = [ 1.5, -1.5, -1.5]
//! upper_left  = [-1.5,  1.5, -1.5]
//! pixels = [1920, 1920]               # optional
//!
//! [[dome]]
//! name = "dome"
//! radius = 2.5                        # metres
//! centre = [0, -1.5, 0]               # of the sphere
//! tilt_degrees = 15                   # optional: how far the zenith leans to the front
//! field_of_view_degrees = 180         # optional: from rim to rim at the centre
//! size = 2048                         # optional: columns, and rows
//! ```
//!
//! A dome's tilt turns it about the room's +X: the zenith, straight up (+Y)
//! without, leans towards the front (−Z) by that angle.

use super::{Cave, DomeDescription, DomeScreen, DomeScreenError, Wall, WallError};
use crate::files::description::{Located, Source};
use glam::DVec3;
use miette::Diagnostic;
use serde::Deserialize;
use std::collections::HashSet;
use std::path::{Path, PathBuf};
use thiserror::Error;
use toml::Spanned;

/// What is wrong in a file of walls.
#[derive(Debug, Clone, PartialEq, Error, Diagnostic)]
#[non_exhaustive]
pub enum CaveFileFault {
    /// Not TOML, or not the keys and types that a wall has.
    #[error("{message}")]
    #[diagnostic(help(
        "a wall is a [[wall]] with name, lower_left, lower_right and upper_left ([x, y, z] in metres) and, if wanted, pixels ([columns, rows]); a dome is a [[dome]] with name, radius (metres), centre ([x, y, z]) and, if wanted, tilt_degrees, field_of_view_degrees and size (pixels)"
    ))]
    Syntax {
        /// The TOML reader's message.
        message: String,
    },
    /// A file without screens.
    #[error("the file describes no walls and no domes")]
    #[diagnostic(help(
        "add a [[wall]] with name, lower_left, lower_right and upper_left, or a [[dome]] with name, radius and centre"
    ))]
    NoWalls,
    /// A wall that cannot be used.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Wall(#[from] WallError),
    /// A dome that cannot be used.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Dome(#[from] DomeScreenError),
}

/// Why walls could not be had from a file.
#[derive(Debug, Error, Diagnostic)]
#[non_exhaustive]
pub enum CaveFileError {
    /// The file could not be read.
    #[error("cannot read the walls in {}", .path.display())]
    #[diagnostic(help("give three-wall, cube, dome or the path of a TOML file of walls"))]
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
    #[serde(default)]
    dome: Vec<DomeEntry>,
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

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct DomeEntry {
    name: Spanned<String>,
    radius: Spanned<f64>,
    centre: Spanned<[f64; 3]>,
    tilt_degrees: Option<Spanned<f64>>,
    field_of_view_degrees: Option<Spanned<f64>>,
    size: Option<Spanned<u32>>,
}

impl Cave {
    /// Reads a file of walls and domes. `size`, in columns and rows, is for the
    /// walls that name no pixels of their own; for such domes, its columns are.
    ///
    /// # Errors
    /// A file that cannot be read, or as [`Self::from_toml`].
    pub fn load(path: &Path, size: [u32; 2]) -> Result<Self, CaveFileError> {
        let text = crate::files::read_text(path).map_err(|source| CaveFileError::Read {
            path: path.to_owned(),
            source,
        })?;
        Ok(Self::from_toml(&text, &path.to_string_lossy(), size)?)
    }

    /// Walls from the text of a file; `source_name` is what messages call
    /// it. `size`, in columns and rows, is for the walls that name no pixels
    /// of their own; for such domes, its columns are.
    ///
    /// # Errors
    /// The first fault found and its place: text that is not TOML, unknown
    /// or missing keys, no screens, a wall that [`Wall::validate`] rejects, a
    /// dome that [`DomeScreen::new`] rejects, a name that is there twice.
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
        if entries.wall.is_empty() && entries.dome.is_empty() {
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
        let mut cave = Self {
            walls,
            domes: Vec::new(),
        };
        for entry in entries.dome {
            let dome = DomeScreen::new(entry.description(size[0]));
            cave = dome
                .and_then(|dome| cave.with_dome(dome))
                .map_err(|fault| {
                    let span = entry.span_of(&fault);
                    Located::new(fault.into(), &source, Some(span))
                })?;
        }
        Ok(cave)
    }
}

impl DomeEntry {
    /// `size` is for a dome that does not say.
    fn description(&self, size: u32) -> DomeDescription {
        let or = |value: &Option<Spanned<f64>>, default| {
            value.as_ref().map_or(default, |value| *value.as_ref())
        };
        DomeDescription {
            name: self.name.as_ref().clone(),
            radius: *self.radius.as_ref(),
            centre: DVec3::from_array(*self.centre.as_ref()),
            tilt_degrees: or(&self.tilt_degrees, 0.0),
            field_of_view_degrees: or(&self.field_of_view_degrees, 180.0),
            size: self.size.as_ref().map_or(size, |size| *size.as_ref()),
        }
    }

    /// The bytes of the value that a fault is about.
    fn span_of(&self, fault: &DomeScreenError) -> std::ops::Range<usize> {
        let number = |value: &Option<Spanned<f64>>| value.as_ref().map(Spanned::span);
        match fault {
            DomeScreenError::Radius { .. } => Some(self.radius.span()),
            DomeScreenError::Centre { .. } => Some(self.centre.span()),
            DomeScreenError::Tilt { .. } => number(&self.tilt_degrees),
            DomeScreenError::FieldOfView { .. } => number(&self.field_of_view_degrees),
            DomeScreenError::Size { .. } => self.size.as_ref().map(Spanned::span),
            _ => None,
        }
        .unwrap_or_else(|| self.name.span())
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
