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

    /// Draws the light. Returns where the name belongs: the lens, or the middle of the light.
    pub(super) fn draw(&self, frame: &Frame, sheet: &mut Sheet) -> DVec2 {
        let mut points: Vec<DVec2> = self.lit.iter().map(|&one| frame.at(one)).collect();
        let picture = hull(points.clone());
        sheet.shaded(&picture, "lit");
        let Some(lens) = self.lens().map(|lens| frame.at(lens)) else {
            return picture.iter().sum::<DVec2>() / picture.len().max(1) as f64;
        };
        points.push(lens);
        sheet.shaded(&hull(points), "beam");
        lens
    }
}

/// Draws lenses and writes the names of projectors beside them, so that no two of them, and none
/// and one of the places `taken`, overlap if there is room.
pub(super) fn write_names(beams: &[Beam<'_>], at: &[DVec2], taken: &[DVec2], sheet: &mut Sheet) {
    // Half the size of a letter, and that of a dot or an angle that names keep clear of.
    let (letter, clear) = (DVec2::new(0.75, 1.5), DVec2::new(5.0, 1.8));
    let dots = at.iter().map(|&place| (place, DVec2::splat(1.3)));
    let mut boxes: Vec<(DVec2, DVec2)> = taken.iter().map(|&place| (place, clear)).collect();
    boxes.extend(dots);
    let mut named: Vec<(DVec2, String)> = Vec::new();
    for (beam, &place) in beams.iter().zip(at) {
        let name = &beam.projector.name;
        match named
            .iter_mut()
            .find(|(other, _)| other.distance(place) < 1.0)
        {
            Some((_, names)) => *names = format!("{names}, {name}"),
            None => named.push((place, name.clone())),
        }
        if beam.lens().is_some() {
            sheet.circle(place, 1.1, "lens");
        }
    }
    for (place, names) in named {
        let half = letter * DVec2::new(names.chars().count() as f64, 1.0);
        let beside = half.x + 1.8;
        let ways = [
            (0.0, -3.2),
            (0.0, 3.2),
            (beside, 0.0),
            (-beside, 0.0),
            (0.0, -6.4),
            (0.0, 6.4),
        ];
        let middles = ways.map(|way| place + DVec2::from(way));
        let is_free = |middle: &DVec2| {
            let mut all = boxes.iter();
            all.all(|(other, size)| (middle - other).abs().cmpge(half + size).any())
        };
        let middle = middles.into_iter().find(is_free).unwrap_or(middles[0]);
        boxes.push((middle, half));
        sheet.text(middle + DVec2::Y, Anchor::Middle, "device", &names);
    }
}
