//! What pictures are shown on, and what their rays go through.

use super::{CylinderScreen, DomeScreen, RoomError, Wall, WallPlane};
use crate::projection::DirectProjector;
use glam::{DMat3, DVec2, DVec3};
use shisen_core::frame::View;

/// What a picture's rays go through.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Pictured<'a> {
    /// The pixels of a screen.
    Screen(Screen<'a>),
    /// The pixels of a projector.
    Projector(&'a DirectProjector),
}

impl<'a> Pictured<'a> {
    /// Returns the screen's or the projector's name.
    pub fn name(self) -> &'a str {
        match self {
            Self::Screen(screen) => screen.name(),
            Self::Projector(projector) => &projector.name,
        }
    }

    /// Returns the columns and rows of its picture.
    pub const fn size(self) -> [u32; 2] {
        match self {
            Self::Screen(screen) => screen.size(),
            Self::Projector(projector) => projector.pixels,
        }
    }

    /// Returns the number of its pixels, for one eye.
    pub fn pixels(self) -> u64 {
        self.size().map(u64::from).iter().product()
    }

    /// Returns the rays from an eye at `eye` (metres, in the room) through its pixels.
    ///
    /// # Errors
    /// As [`Screen::view_from`] and [`DirectProjector::view_from`].
    pub fn view_from(self, eye: DVec3) -> Result<View, RoomError> {
        match self {
            Self::Screen(screen) => screen.view_from(eye),
            Self::Projector(projector) => projector.view_from(eye),
        }
    }
}

/// What a picture is shown on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Screen<'a> {
    /// A flat one.
    Wall(&'a Wall),
    /// A dome's inside.
    Dome(&'a DomeScreen),
    /// A cylinder's inside.
    Cylinder(&'a CylinderScreen),
}

impl<'a> Screen<'a> {
    /// Returns the name for file names and messages.
    pub fn name(self) -> &'a str {
        match self {
            Self::Wall(wall) => &wall.name,
            Self::Dome(dome) => &dome.name,
            Self::Cylinder(cylinder) => &cylinder.name,
        }
    }

    /// Returns what it is: a word for messages.
    pub const fn kind(self) -> &'static str {
        match self {
            Self::Wall(_) => "wall",
            Self::Dome(_) => "dome",
            Self::Cylinder(_) => "cylinder",
        }
    }

    /// Returns the columns and rows of its picture.
    pub const fn size(self) -> [u32; 2] {
        match self {
            Self::Wall(wall) => wall.pixels,
            Self::Dome(dome) => [dome.size; 2],
            Self::Cylinder(cylinder) => cylinder.pixels,
        }
    }

    /// Returns the number of its pixels, for one eye.
    pub fn pixels(self) -> u64 {
        let [columns, rows] = self.size();
        u64::from(columns) * u64::from(rows)
    }

    /// Returns whether its picture shows something at a place: (s, t) from its upper left corner, 0
    /// to 1 to the right and downwards.
    pub fn has(self, place: DVec2) -> bool {
        match self {
            Self::Wall(_) | Self::Cylinder(_) => {
                place.cmpge(DVec2::ZERO).all() && place.cmple(DVec2::ONE).all()
            }
            Self::Dome(_) => in_disc(place).length_squared() <= 1.0,
        }
    }

    /// Returns where a place of its picture is in the room: metres.
    pub fn point(self, place: DVec2) -> DVec3 {
        match self {
            Self::Wall(wall) => wall.upper_left + place.x * wall.across() - place.y * wall.upward(),
            Self::Dome(dome) => dome.point(in_disc(place)),
            Self::Cylinder(cylinder) => cylinder.point(place),
        }
    }

    /// Returns the place of its picture that is nearest to a point of the room, metres; `None` for
    /// points without one.
    pub fn place(self, point: DVec3) -> Option<DVec2> {
        match self {
            Self::Wall(wall) => {
                let (across, upward) = (wall.across(), wall.upward());
                let axes = DMat3::from_cols(across, -upward, across.cross(upward));
                let place = (axes.inverse() * (point - wall.upper_left)).truncate();
                place.is_finite().then_some(place)
            }
            Self::Dome(dome) => dome.place(point).map(of_disc),
            Self::Cylinder(cylinder) => cylinder.place(point),
        }
    }

    /// Returns the place of its picture where light from `origin` along the unit `direction` meets
    /// it: a wall from either side, a dome or a cylinder from inside or past its edges.
    pub fn lit(self, origin: DVec3, direction: DVec3) -> Option<DVec2> {
        match self {
            Self::Wall(wall) => {
                let (_, s, t) = WallPlane::new(wall).ok()?.intersect(origin, direction)?;
                Some(DVec2::new(s, t))
            }
            Self::Dome(dome) => dome.lit(origin, direction).map(of_disc),
            Self::Cylinder(cylinder) => cylinder.lit(origin, direction),
        }
    }

    /// Returns the rays from an eye at `eye` (metres, in the room) through its pixels.
    ///
    /// # Errors
    /// As [`Wall::view_from`], [`DomeScreen::view_from`] and [`CylinderScreen::view_from`].
    pub fn view_from(self, eye: DVec3) -> Result<View, RoomError> {
        match self {
            Self::Wall(wall) => wall.view_from(eye),
            Self::Dome(dome) => dome.view_from(eye),
            Self::Cylinder(cylinder) => cylinder.view_from(eye),
        }
    }
}

/// Returns a place of a dome's picture as (u, v) in the unit disc.
fn in_disc(place: DVec2) -> DVec2 {
    (2.0 * place - 1.0) * DVec2::new(1.0, -1.0)
}

fn of_disc(place: DVec2) -> DVec2 {
    0.5 * place * DVec2::new(1.0, -1.0) + 0.5
}

impl<'a> From<&'a Wall> for Screen<'a> {
    fn from(wall: &'a Wall) -> Self {
        Self::Wall(wall)
    }
}

impl<'a> From<&'a Wall> for Pictured<'a> {
    fn from(wall: &'a Wall) -> Self {
        Self::Screen(Screen::Wall(wall))
    }
}

impl<'a> From<Screen<'a>> for Pictured<'a> {
    fn from(screen: Screen<'a>) -> Self {
        Self::Screen(screen)
    }
}

impl<'a> From<&'a CylinderScreen> for Screen<'a> {
    fn from(cylinder: &'a CylinderScreen) -> Self {
        Self::Cylinder(cylinder)
    }
}

impl<'a> From<&'a DomeScreen> for Screen<'a> {
    fn from(dome: &'a DomeScreen) -> Self {
        Self::Dome(dome)
    }
}
