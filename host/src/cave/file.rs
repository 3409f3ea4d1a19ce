//! Walls, domes, cylinders and projectors from a TOML file.
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
//!
//! [[cylinder]]                        # stands upright
//! name = "curve"
//! radius = 3                          # metres
//! centre = [0, 0, 0]                  # a point of the axis
//! azimuth_degrees = [-80, 80]         # from straight ahead (−Z) to the right
//! height = [0, 2.2]                   # of the edges over the centre
//! pixels = [4096, 1080]               # optional
//!
//! [[projector]]                       # optional
//! name = "left"
//! screen = "front"                    # optional for the only screen
//! resolution = [1920, 1200]
//! position = [-0.8, 0, 1]             # by pose and lens: metres, in the room
//! look = [0, 0, -1]                   # or yaw_degrees, pitch_degrees, roll_degrees
//! up = [0, 1, 0]                      # optional
//! throw = 1.2                         # distance by width, or horizontal_degrees
//! vertical_degrees = 40               # optional: square pixels
//! lens_shift = [0, 0.5]               # optional: widths right, heights up
//! gamma = 2.2                         # optional: else "srgb"
//! black = 0.0005                      # optional: light at code 0, of white's
//! gain = [1, 0.97, 1]                 # optional: one, or of red, green and blue
//! blend = 1                           # optional: exponent in overlaps
//! eye = "left"                        # optional: of passive stereo's pairs
//! ```
//!
//! In place of its pose and lens, a projector has one of
//!
//! ```toml
//! # Four or more: a point of its picture, in pixels or all from 0 to 1, and of the screen's, 0 to 1,
//! # both from the upper left corner.
//! corner_pins = [[[12, 8], [0, 0]], [[1900, 20], [0.6, 0]], [[1890, 1180], [0.6, 1]], [[20, 1190], [0, 1]]]
//! # A file beside the room's: Bourke's text, PFM, or MPCDI as archive, XML or folder.
//! mesh = "left.mpcdi"
//! # One to one onto a part of the screen's picture: its left, upper, right and lower edges.
//! part = [0, 0, 0.5, 1]
//! ```
//!
//! A `gamma` is a number, "srgb", or the light, 0 to 1, at codes of equal steps; or a table of these
//! for `red`, `green` and `blue`. A mesh's points are metres in the room. Where the mesh's file has
//! weights, they are the projector's; else the projectors of a screen are blended.
//!
//! A dome's tilt turns it about the room's +X: the zenith, straight up (+Y)
//! without, leans towards the front (−Z) by that angle.

use super::{Cave, CylinderScreen, DomeScreen, RoomError, Wall};
use crate::files::description::{FileError, Located, Source, read_description};
use crate::projection::{self, ProjectorEntry};
use serde::Deserialize;
use std::fmt::Write as _;
use std::path::Path;

const SYNTAX: &str = "a wall is a [[wall]] with name, lower_left, lower_right and upper_left \
    ([x, y, z] in metres) and, if wanted, pixels ([columns, rows]); a dome is a [[dome]] with name, \
    radius (metres), centre ([x, y, z]) and, if wanted, tilt_degrees, field_of_view_degrees and \
    size (pixels); a cylinder is a [[cylinder]] with name, radius, centre, azimuth_degrees \
    ([left, right]), height ([low, high] in metres) and, if wanted, pixels";

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct CaveEntry {
    #[serde(default)]
    wall: Vec<WallEntry>,
    #[serde(default)]
    dome: Vec<DomeEntry>,
    #[serde(default)]
    cylinder: Vec<CylinderEntry>,
    #[serde(default)]
    projector: Vec<ProjectorEntry>,
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

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct CylinderEntry {
    name: String,
    radius: f64,
    centre: [f64; 3],
    azimuth_degrees: [f64; 2],
    height: [f64; 2],
    pixels: Option<[u32; 2]>,
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
    /// screen whose `validate` rejects it, a name twice, a
    /// projector that [`Self::add_projector`] or [`Self::blends`] rejects.
    pub fn from_toml(text: &str, name: &str, size: [u32; 2]) -> Result<Self, Located<RoomError>> {
        let source = Source { name, text };
        let syntax = format!("{SYNTAX}; {}", projection::SYNTAX);
        let entries: CaveEntry =
            source.parse(&syntax, |message, help| RoomError::new("", message, help))?;
        let counts = [
            entries.wall.len(),
            entries.dome.len(),
            entries.cylinder.len(),
        ];
        if counts == [0; 3] {
            let fault = RoomError::new(
                "",
                "the file describes no walls and no domes".to_owned(),
                "add a [[wall]] with name, lower_left, lower_right and upper_left, a [[dome]] with \
                 name, radius and centre, or a [[cylinder]]",
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
        for (number, entry) in entries.cylinder.into_iter().enumerate() {
            let cylinder = CylinderScreen {
                name: entry.name,
                radius: entry.radius,
                centre: entry.centre.into(),
                azimuth_degrees: entry.azimuth_degrees,
                height: entry.height,
                pixels: entry.pixels.unwrap_or(size),
            };
            let added = cave.add_cylinder(cylinder);
            added.map_err(|fault| located("cylinder", number, fault))?;
        }
        for (number, entry) in entries.projector.into_iter().enumerate() {
            let projector = entry.projector(source.folder());
            let added = projector.and_then(|projector| cave.add_projector(projector));
            let list = Some(("projector", number));
            added.map_err(|fault| projection::fault_at(fault, &source, list))?;
        }
        cave.check_projectors(&source)?;
        Ok(cave)
    }

    /// Refuses projectors that do not go together.
    fn check_projectors(&self, source: &Source<'_>) -> Result<(), Located<RoomError>> {
        let Err(fault) = self.blends() else {
            return Ok(());
        };
        Err(projection::fault_at(
            fault,
            source,
            Some(("projector", self.projectors.len() - 1)),
        ))
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
