//! The light of projectors on their screens.

use super::Frame;
use super::shape::hull;
use super::sheet::{Anchor, Sheet};
use crate::cave::{Cave, RoomError, Screen};
use crate::projection::{Map, Placement, Projector};
use glam::{DVec2, DVec3};

/// A projector and what it lights.
#[derive(Debug, Clone)]
pub struct Beam<'a> {
    /// The projector.
    pub projector: &'a Projector,
    /// Its screen.
    pub screen: Screen<'a>,
    /// The share of its picture that lies on the screen, 0 to 1.
    pub share: f64,
    /// Points that it lights: metres, in the room.
    lit: Vec<DVec3>,
}

impl<'a> Beam<'a> {
    /// Points a side of a picture that are followed to the screen.
    const POINTS: u32 = 48;

    /// Follows the light of each projector of a room.
    ///
    /// # Errors
    /// As [`Cave::screen_of`] and [`Map::new`].
    pub fn all(cave: &'a Cave) -> Result<Vec<Self>, RoomError> {
        let beams = cave.projectors.iter().map(|projector| {
            let screen = cave.screen_of(projector)?;
            let map = Map::new(screen, projector)?;
            let along = |number: u32| f64::from(number) / f64::from(Self::POINTS - 1);
            let points = (0..Self::POINTS).flat_map(|y| (0..Self::POINTS).map(move |x| [x, y]));
            let places = points.filter_map(|point| map.place(point.map(along).into()));
            let lit: Vec<DVec3> = places.map(|place| screen.point(place)).collect();
            Ok(Self {
                projector,
                screen,
                share: lit.len() as f64 / f64::from(Self::POINTS.pow(2)),
                lit,
            })
        });
        beams.collect()
    }

    /// Returns where the lens is, metres in the room, if the room says.
    pub fn lens(&self) -> Option<DVec3> {
        match &self.projector.placement {
            Placement::Lens(lens) => Some(lens.position),
            Placement::Flat(_) | Placement::Mesh(_) => None,
        }
    }

    pub(super) fn draw(&self, frame: &Frame, sheet: &mut Sheet) {
        let mut points: Vec<DVec2> = self.lit.iter().map(|&one| frame.at(one)).collect();
        let picture = hull(points.clone());
        sheet.shaded(&picture, "lit");
        let Some(lens) = self.lens() else {
            let middle = picture.iter().sum::<DVec2>() / picture.len().max(1) as f64;
            sheet.text(middle, Anchor::Middle, "device", &self.projector.name);
            return;
        };
        let lens = frame.at(lens);
        points.push(lens);
        sheet.shaded(&hull(points), "beam");
        sheet.circle(lens, 1.1, "lens");
        sheet.text(
            lens - 2.4 * DVec2::Y,
            Anchor::Middle,
            "device",
            &self.projector.name,
        );
    }
}
