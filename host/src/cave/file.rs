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

use super::{Cave, DomeScreen, RoomError, Wall};
use crate::files::description::{FileError, Located, Source, read_description};
use serde::Deserialize;
use std::fmt::Write as _;
use std::path::Path;

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
    name: String,
    lower_left: [f64; 3],
    lower_right: [f64; 3],
    upper_left: [f64; 3],
    pixels: Option<[u32; 2]>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct DomeEntry {
    name: String,
    radius: f64,
    centre: [f64; 3],
    tilt_degrees: Option<f64>,
    field_of_view_degrees: Option<f64>,
    size: Option<u32>,
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

    /// As [`Self::load`], from the text of a file; `name` is what messages call it.
    ///
    /// # Errors
    /// The first fault and its place: text that is not TOML, unknown or missing keys, no screens, a
    /// wall that [`Wall::validate`] or a dome that [`DomeScreen::validate`] rejects, a name twice.
    pub fn from_toml(text: &str, name: &str, size: [u32; 2]) -> Result<Self, Located<RoomError>> {
        let source = Source { name, text };
        let entries: CaveEntry =
            source.parse(SYNTAX, |message, help| RoomError::new("", message, help))?;
        if entries.wall.is_empty() && entries.dome.is_empty() {
            let fault = RoomError::new(
                "",
                "the file describes no walls and no domes".to_owned(),
                "add a [[wall]] with name, lower_left, lower_right and upper_left, or a [[dome]] \
                 with name, radius and centre",
            );
            return Err(Located::new(fault, &source, None));
        }
        let mut cave = Self::default();
        let located = |list, number, fault: RoomError| {
            let list = Some((list, number));
            let span = source.span_of(list, fault.key);
            let span = span.or_else(|| source.span_of(list, "name"));
            Located::new(fault, &source, span)
        };
        for (number, entry) in entries.wall.into_iter().enumerate() {
            let wall = Wall {
                name: entry.name,
                lower_left: entry.lower_left.into(),
                lower_right: entry.lower_right.into(),
                upper_left: entry.upper_left.into(),
                pixels: entry.pixels.unwrap_or(size),
            };
            let added = cave.add_wall(wall);
            added.map_err(|fault| located("wall", number, fault))?;
        }
        for (number, entry) in entries.dome.into_iter().enumerate() {
            let dome = DomeScreen {
                name: entry.name,
                radius: entry.radius,
                centre: entry.centre.into(),
                tilt_degrees: entry.tilt_degrees.unwrap_or(0.0),
                field_of_view_degrees: entry.field_of_view_degrees.unwrap_or(180.0),
                size: entry.size.unwrap_or(size[0]),
            };
            let added = cave.add_dome(dome);
            added.map_err(|fault| located("dome", number, fault))?;
        }
        Ok(cave)
    }
}

impl Wall {
    /// Returns the wall as an entry of a file, to hundredths of a millimetre.
    pub(super) fn to_toml(&self, pixels: Option<[u32; 2]>) -> String {
        // Names have no quotes and no backslashes: file names cannot have them.
        let mut text = format!("[[wall]]\nname = \"{}\"\n", self.name);
        for (key, place) in [
            ("lower_left ", self.lower_left),
            ("lower_right", self.lower_right),
            ("upper_left ", self.upper_left),
        ] {
            // No minus before a zero.
            let [x, y, z] = place
                .to_array()
                .map(|metres| (metres * 1e5).round() / 1e5 + 0.0);
            let _ = writeln!(text, "{key} = [{x:.5}, {y:.5}, {z:.5}]");
        }
        if let Some([columns, rows]) = pixels {
            let _ = writeln!(text, "pixels = [{columns}, {rows}]");
        }
        text
    }
}
