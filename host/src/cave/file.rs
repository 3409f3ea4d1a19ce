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

use super::{Cave, DomeDescription, DomeScreen, RoomError, Wall};
use crate::files::description::{FileError, Located, Source, read_description};
use glam::DVec3;
use serde::Deserialize;
use std::path::Path;
use toml::Spanned;

const SYNTAX: &str = "a wall is a [[wall]] with name, lower_left, lower_right and upper_left \
    ([x, y, z] in metres) and, if wanted, pixels ([columns, rows]); a dome is a [[dome]] with name, \
    radius (metres), centre ([x, y, z]) and, if wanted, tilt_degrees, field_of_view_degrees and \
    size (pixels)";

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
    pub fn load(path: &Path, size: [u32; 2]) -> Result<Self, FileError<RoomError>> {
        let help = "give three-wall, cube, dome or the path of a TOML file of walls";
        let text = read_description(path, "the walls", help)?;
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
    ) -> Result<Self, Located<RoomError>> {
        let source = Source {
            name: source_name,
            text,
        };
        let entries: CaveEntry = source.parse(|message| RoomError::new("", message, SYNTAX))?;
        if entries.wall.is_empty() && entries.dome.is_empty() {
            let fault = RoomError::new(
                "",
                "the file describes no walls and no domes".to_owned(),
                "add a [[wall]] with name, lower_left, lower_right and upper_left, or a [[dome]] \
                 with name, radius and centre",
            );
            return Err(Located::new(fault, &source, None));
        }
        let mut cave = Self {
            walls: Vec::with_capacity(entries.wall.len()),
            domes: Vec::new(),
        };
        for entry in entries.wall {
            let place = |corner: &Spanned<[f64; 3]>| DVec3::from_array(*corner.as_ref());
            let wall = Wall {
                name: entry.name.as_ref().clone(),
                lower_left: place(&entry.lower_left),
                lower_right: place(&entry.lower_right),
                upper_left: place(&entry.upper_left),
                pixels: entry
                    .pixels
                    .as_ref()
                    .map_or(size, |pixels| *pixels.as_ref()),
            };
            cave.add_wall(wall).map_err(|fault| {
                let span = entry.span_of(fault.key);
                Located::new(fault, &source, Some(span))
            })?;
        }
        for entry in entries.dome {
            let dome = DomeScreen::new(entry.description(size[0]));
            cave = dome
                .and_then(|dome| cave.with_dome(dome))
                .map_err(|fault| {
                    let span = entry.span_of(fault.key);
                    Located::new(fault, &source, Some(span))
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

    /// The bytes of the value of a key.
    fn span_of(&self, key: &str) -> std::ops::Range<usize> {
        let number = |value: &Option<Spanned<f64>>| value.as_ref().map(Spanned::span);
        match key {
            "radius" => Some(self.radius.span()),
            "centre" => Some(self.centre.span()),
            "tilt_degrees" => number(&self.tilt_degrees),
            "field_of_view_degrees" => number(&self.field_of_view_degrees),
            "size" => self.size.as_ref().map(Spanned::span),
            _ => None,
        }
        .unwrap_or_else(|| self.name.span())
    }
}

impl WallEntry {
    /// The bytes of the value of a key.
    fn span_of(&self, key: &str) -> std::ops::Range<usize> {
        match (key, &self.pixels) {
            ("lower_left", _) => self.lower_left.span(),
            ("lower_right", _) => self.lower_right.span(),
            ("upper_left", _) => self.upper_left.span(),
            ("pixels", Some(pixels)) => pixels.span(),
            _ => self.name.span(),
        }
    }
}
