//! The walls of a CAVE, its domes and cylinders, and the eyes before them.
//!
//! A wall is three corners and a number of pixels: its viewer stands on the side from which lower
//! left, lower right and upper left run counter-clockwise. The picture's first row is at the upper
//! edge, its first column at the left one, and pixel (x, y) has its centre x + ½ columns and y + ½
//! rows from there. A dome is part of a sphere seen from inside; its picture is a dome master. A cylinder stands upright.
//!
//! [`Cave::load`] reads screens and their projectors from a file, [`look`] reads directions.
//! [`crate::projection`] makes what projectors have to show.

pub(crate) mod angle;
pub mod import;
pub mod look;
pub mod measure;
pub mod plan;

mod cylinder;
mod dome;
mod file;
mod remarks;
mod screen;
mod view;
mod viewer;
mod wall_plane;

pub use cylinder::CylinderScreen;
pub use dome::DomeScreen;
pub use screen::{Pictured, Screen};
pub use viewer::{DEFAULT_INTERPUPILLARY_DISTANCE, Eye, Viewer};
pub(crate) use wall_plane::WallPlane;

use crate::files::description::UnknownName;
use crate::projection::{DirectProjector, Projector};
use glam::DVec3;
use miette::Diagnostic;
use std::fmt;
use std::str::FromStr;
use thiserror::Error;

/// A flat screen, by three corners as its viewer sees them.
#[derive(Debug, Clone, PartialEq)]
pub struct Wall {
    /// Returns the name for file names and messages.
    pub name: String,
    /// Metres, in the room.
    pub lower_left: DVec3,
    /// Metres, in the room.
    pub lower_right: DVec3,
    /// Metres, in the room. The picture's first pixel is at this corner.
    pub upper_left: DVec3,
    /// Columns and rows.
    pub pixels: [u32; 2],
}

/// Why a screen or a projector cannot be used, or not from where the eye is.
#[derive(Debug, Clone, PartialEq, Eq, Error, Diagnostic)]
#[error("{message}")]
pub struct RoomError {
    /// The key of a room's or projector's file that is wrong, such as `radius`; `eye` for an eye
    /// that does not see the screen.
    pub key: &'static str,
    message: String,
    #[help]
    help: String,
}

impl RoomError {
    pub(crate) fn new(key: &'static str, message: String, help: impl Into<String>) -> Self {
        let help = help.into();
        Self { key, message, help }
    }

    /// Refuses names that cannot be part of a file's name on some system. `named` says which files
    /// are named after it.
    pub(crate) fn check_name(
        what: &str,
        name: &str,
        named: &str,
        example: &str,
    ) -> Result<(), Self> {
        let is_special = |c: char| c.is_control() || "/\\:*?\"<>|".contains(c);
        let reason = if name.is_empty() {
            "is empty"
        } else if name.len() > Wall::LONGEST_NAME {
            "is longer than 100 bytes"
        } else if name.starts_with('.') {
            "starts with a full stop, which hides files"
        } else if name.trim() != name || name.ends_with('.') {
            "starts or ends with a character that file systems drop"
        } else if name.chars().any(is_special) {
            "has a character that file names cannot have"
        } else {
            return Ok(());
        };
        let message = format!("the {what} name \"{}\" {reason}", name.escape_debug());
        let help = format!("{named}: use letters, digits, '-' and '_', such as \"{example}\"");
        Err(Self::new("name", message, help))
    }

    /// Refuses places that are not in a room. `whose` starts the message.
    pub(crate) fn check_place(
        key: &'static str,
        whose: fmt::Arguments<'_>,
        place: DVec3,
    ) -> Result<(), Self> {
        if is_in_a_room(place) {
            return Ok(());
        }
        Err(Self::new(
            key,
            format!("{whose} at {}, {}, {}", place.x, place.y, place.z),
            format!("coordinates are metres from -{0} to {0}", Wall::FARTHEST),
        ))
    }

    fn check_radius(whose: fmt::Arguments<'_>, radius: f64) -> Result<(), Self> {
        let [least, most] = [*DomeScreen::RADII.start(), *DomeScreen::RADII.end()];
        // Rounded as the tracer rounds it.
        if (least as f32..=most as f32).contains(&(radius as f32)) {
            return Ok(());
        }
        Err(Self::new(
            "radius",
            format!("{whose} has a radius of {radius} m"),
            format!("give metres from {least} to {most}"),
        ))
    }

    pub(crate) fn check_pixels(
        key: &'static str,
        whose: fmt::Arguments<'_>,
        pixels: [u32; 2],
    ) -> Result<(), Self> {
        let mut sides = pixels.into_iter();
        if sides.all(|side| (1..=Wall::MOST_PIXELS).contains(&side)) {
            return Ok(());
        }
        Err(Self::new(
            key,
            format!("{whose} has {} × {} pixels", pixels[0], pixels[1]),
            format!("each side has 1 to {} pixels", Wall::MOST_PIXELS),
        ))
    }
}

impl Wall {
    /// Largest magnitude of a corner's or an eye's coordinate, metres.
    pub const FARTHEST: f64 = 1.0e6;
    /// Most pixels along a side.
    pub const MOST_PIXELS: u32 = 16_384;
    /// Shortest edge, and the distance from its plane up to which an eye counts as in it, metres.
    pub const CLOSEST: f64 = 1.0e-6;
    /// Most bytes in a name; leaves room for the eye and the file type.
    const LONGEST_NAME: usize = 100;

    /// Returns a usable wall. Corners are metres in the room, as the wall's viewer sees them;
    /// `pixels` are columns and rows, 1 to [`Self::MOST_PIXELS`] each.
    ///
    /// # Errors
    /// As [`Self::validate`].
    pub fn new(
        name: impl Into<String>,
        lower_left: DVec3,
        lower_right: DVec3,
        upper_left: DVec3,
        pixels: [u32; 2],
    ) -> Result<Self, RoomError> {
        let wall = Self {
            name: name.into(),
            lower_left,
            lower_right,
            upper_left,
            pixels,
        };
        wall.validate()?;
        Ok(wall)
    }

    /// Checks everything that views of the wall rely on.
    ///
    /// # Errors
    /// The first fault: a name that no file can have, a corner that is not finite or beyond
    /// [`Self::FARTHEST`], no width or height, corners on one line, a number of pixels out of range.
    pub fn validate(&self) -> Result<(), RoomError> {
        let named = "pictures are named after their walls";
        RoomError::check_name("wall", &self.name, named, "front")?;
        self.check_corners()?;
        let wall = format_args!("wall \"{}\"", self.name);
        RoomError::check_pixels("pixels", wall, self.pixels)
    }

    fn check_corners(&self) -> Result<(), RoomError> {
        // Formatted only for errors: views are made for each frame, without taking memory.
        let name = &self.name;
        let wall = format_args!("wall \"{name}\"");
        for (key, corner, place) in [
            ("lower_left", "lower left", self.lower_left),
            ("lower_right", "lower right", self.lower_right),
            ("upper_left", "upper left", self.upper_left),
        ] {
            let whose = format_args!("wall \"{name}\": its {corner} corner is");
            RoomError::check_place(key, whose, place)?;
        }
        let (across, upward) = (self.across(), self.upward());
        for (key, dimension, length) in [
            ("lower_right", "width", across.length()),
            ("upper_left", "height", upward.length()),
        ] {
            if length < Self::CLOSEST {
                return Err(RoomError::new(
                    key,
                    format!("{wall} has no {dimension}: it measures {length} m"),
                    "lower_left, lower_right and upper_left are three different corners, as the \
                     viewer sees them",
                ));
            }
        }
        if across.normalize().cross(upward.normalize()).length() < 1.0e-9 {
            return Err(RoomError::new(
                "upper_left",
                format!("{wall}: its three corners lie on one line"),
                "move upper_left off the line through lower_left and lower_right",
            ));
        }
        Ok(())
    }

    pub(crate) fn across(&self) -> DVec3 {
        self.lower_right - self.lower_left
    }

    pub(crate) fn upward(&self) -> DVec3 {
        self.upper_left - self.lower_left
    }
}

fn is_in_a_room(position: DVec3) -> bool {
    position.abs().cmple(DVec3::splat(Wall::FARTHEST)).all()
}

/// The screens of one room.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Cave {
    /// In the order of their pictures.
    pub walls: Vec<Wall>,
    /// In the order of their pictures, which come after the walls'.
    pub domes: Vec<DomeScreen>,
    /// In the order of their pictures, which come last.
    pub cylinders: Vec<CylinderScreen>,
    /// In the order of the file.
    pub projectors: Vec<Projector>,
    /// The projectors whose own pixels are traced: [`Self::trace_directly`].
    pub(crate) direct: Vec<DirectProjector>,
}

/// A room that needs no file: a 3 m cube centred on the origin, or a dome over its floor.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BuiltInCave {
    /// `three-wall`: front, right and floor.
    ThreeWall,
    /// `cube`: front, left, right, back, floor and ceiling.
    Cube,
    /// `dome`: a hemisphere of 2.5 m whose rim is level with the floor and whose
    /// centre is 1.5 m under the origin.
    Dome,
}

named!(BuiltInCave { ThreeWall => "three-wall", Cube => "cube", Dome => "dome" });

impl FromStr for BuiltInCave {
    type Err = UnknownName;

    fn from_str(name: &str) -> Result<Self, UnknownName> {
        let mut all = Self::ALL.into_iter();
        all.find(|cave| cave.name() == name)
            .ok_or_else(|| UnknownName {
                kind: "CAVE",
                given: name.into(),
                known: "three-wall, cube or dome",
            })
    }
}

impl Cave {
    /// Returns a room of usable walls with names of their own.
    ///
    /// # Errors
    /// The first wall that [`Wall::validate`] rejects or whose name another
    /// has already, upper and lower case being the same.
    pub fn new(walls: Vec<Wall>) -> Result<Self, RoomError> {
        let mut cave = Self::default();
        for wall in walls {
            cave.add_wall(wall)?;
        }
        Ok(cave)
    }

    /// Adds a wall.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn add_wall(&mut self, wall: Wall) -> Result<(), RoomError> {
        wall.validate()?;
        let message = format!("two walls are named \"{}\"", wall.name);
        self.check_new(&wall.name, message, "walls")?;
        self.walls.push(wall);
        Ok(())
    }

    /// Adds a dome.
    ///
    /// # Errors
    /// A dome that [`DomeScreen::validate`] rejects or whose name another screen has already, upper
    /// and lower case being the same.
    pub fn add_dome(&mut self, dome: DomeScreen) -> Result<(), RoomError> {
        dome.validate()?;
        let message = format!("a dome is named \"{}\" as another screen is", dome.name);
        self.check_new(&dome.name, message, "screens")?;
        self.domes.push(dome);
        Ok(())
    }

    /// Adds a cylinder.
    ///
    /// # Errors
    /// A cylinder that [`CylinderScreen::validate`] rejects or whose name another screen has already,
    /// upper and lower case being the same.
    pub fn add_cylinder(&mut self, cylinder: CylinderScreen) -> Result<(), RoomError> {
        cylinder.validate()?;
        let name = &cylinder.name;
        let message = format!("a cylinder is named \"{name}\" as another screen is");
        self.check_new(name, message, "screens")?;
        self.cylinders.push(cylinder);
        Ok(())
    }

    fn check_new(&self, name: &str, message: String, owners: &str) -> Result<(), RoomError> {
        let name = name.to_lowercase();
        if self.screens().all(|one| one.name().to_lowercase() != name) {
            return Ok(());
        }
        let help = format!(
            "pictures are named after their {owners}: give each its own name, different in more \
             than upper and lower case"
        );
        Err(RoomError::new("name", message, help))
    }

    /// Returns all screens, in the order of their pictures: walls, then domes, then cylinders.
    pub fn screens(&self) -> impl Iterator<Item = Screen<'_>> {
        let walls = self.walls.iter().map(Screen::Wall);
        let domes = self.domes.iter().map(Screen::Dome);
        walls
            .chain(domes)
            .chain(self.cylinders.iter().map(Screen::Cylinder))
    }

    /// Returns what its pictures are of: screens, then projectors whose own pixels are traced.
    pub fn pictured(&self) -> impl Iterator<Item = Pictured<'_>> {
        let is_lit = |screen: &Screen<'_>| {
            let mut direct = self.direct.iter();
            direct.any(|projector| projector.screen().name() == screen.name())
        };
        let screens = self.screens().filter(move |screen| !is_lit(screen));
        let direct = self.direct.iter().map(Pictured::Projector);
        screens.map(Pictured::Screen).chain(direct)
    }

    /// Returns the height of the lowest corner of a wall, edge of a cylinder, or centre of a dome:
    /// metres, in the room.
    pub fn floor(&self) -> f64 {
        let heights = self.screens().map(|screen| match screen {
            Screen::Wall(wall) => {
                let (left, right) = (wall.lower_left.y, wall.lower_right.y);
                left.min(right)
                    .min(wall.upper_left.y)
                    .min(wall.upper_left.y + right - left)
            }
            Screen::Dome(dome) => dome.centre.y,
            Screen::Cylinder(cylinder) => cylinder.centre.y + cylinder.height[0],
        });
        heights.fold(f64::INFINITY, f64::min)
    }

    /// Checks that an eye at `eye` (metres, in the room) sees the front of all screens.
    ///
    /// # Errors
    /// The first screen that it does not: [`Screen::view_from`].
    pub fn check_eye(&self, eye: DVec3) -> Result<(), RoomError> {
        let mut screens = self.screens();
        screens.try_for_each(|screen| screen.view_from(eye).map(drop))
    }

    /// Returns a built-in room, every wall with `pixels` columns and rows, a dome with
    /// as many columns and rows as `pixels` has columns.
    ///
    /// # Errors
    /// A side that is 0 or above [`Wall::MOST_PIXELS`].
    pub fn built_in(which: BuiltInCave, pixels: [u32; 2]) -> Result<Self, RoomError> {
        match which {
            BuiltInCave::ThreeWall => Self::cube(pixels, false),
            BuiltInCave::Cube => Self::cube(pixels, true),
            BuiltInCave::Dome => {
                let mut cave = Self::new(Vec::new())?;
                cave.add_dome(DomeScreen {
                    name: "dome".to_owned(),
                    radius: 2.5,
                    centre: DVec3::new(0.0, -1.5, 0.0),
                    tilt_degrees: 0.0,
                    field_of_view_degrees: 180.0,
                    size: pixels[0],
                })?;
                Ok(cave)
            }
        }
    }

    fn cube(pixels: [u32; 2], is_whole: bool) -> Result<Self, RoomError> {
        // Seen from the middle. Of the floor and the ceiling, the edge at
        // the front wall is the upper one and the lower one.
        let cube = [
            ("front", [-1., -1., -1.], [1., -1., -1.], [-1., 1., -1.]),
            ("left", [-1., -1., 1.], [-1., -1., -1.], [-1., 1., 1.]),
            ("right", [1., -1., -1.], [1., -1., 1.], [1., 1., -1.]),
            ("back", [1., -1., 1.], [-1., -1., 1.], [1., 1., 1.]),
            ("floor", [-1., -1., 1.], [1., -1., 1.], [-1., -1., -1.]),
            ("ceiling", [-1., 1., -1.], [1., 1., -1.], [-1., 1., 1.]),
        ];
        let mut cave = Self::default();
        for (name, lower_left, lower_right, upper_left) in cube {
            if is_whole || ["front", "right", "floor"].contains(&name) {
                let [a, b, c] = [lower_left, lower_right, upper_left].map(|c| 1.5 * DVec3::from(c));
                cave.add_wall(Wall::new(name, a, b, c, pixels)?)?;
            }
        }
        Ok(cave)
    }
}

#[cfg(test)]
mod tests;
