//! Projectors on a room's screens: what each has to show so that the screens' pictures appear on
//! them, over all projectors, as if each screen were one display.
//!
//! A room file gives a screen its projectors ([`Cave::from_toml`]). [`Projection::all`] finds, once,
//! which place of its screen's picture each pixel of a projector lights ([`Map`]: exact, by pose and
//! lens, pins, or a mesh) and its share of the light there ([`Blend`]), which adds up to 1 in linear
//! light. [`Projection::show`] then makes a projector's pixels of a frame.
//!
//! ```
//! use shisen::cave::Cave;
//! use shisen::picture::Picture;
//! use shisen::projection::Projection;
//!
//! let room = r#"
//!     [[wall]]
//!     name = "front"
//!     lower_left  = [-1.8, 0, -2]
//!     lower_right = [ 1.8, 0, -2]
//!     upper_left  = [-1.8, 1.5, -2]
//!     pixels = [36, 15]
//!
//!     [[projector]]
//!     name = "left"
//!     position = [-0.8, 0.75, 0]
//!     look = [0, 0, -1]
//!     throw = 1
//!     resolution = [64, 48]
//! "#;
//! let room = Cave::from_toml(room, "room.toml", [16, 16])?;
//! let projections = Projection::all(&room)?;
//! let front = Picture::new(36, 15)?;
//! let mut codes = vec![0; 64 * 48];
//! projections[0].show(&front, &mut codes)?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! [`warp`] writes maps and weights for other programs.

pub mod warp;

mod blend;
mod direct;
mod entry;
mod homography;
mod map;
mod mesh;
mod projector;
mod show;
mod transfer;

pub use blend::Blend;
pub use direct::DirectProjector;
pub(crate) use entry::{ProjectorEntry, SYNTAX, fault_at};
pub use homography::Homography;
pub use map::Map;
pub use mesh::Mesh;
pub use projector::{Lens, Placement, Projector};
pub use show::Projection;
pub use transfer::Transfer;

use crate::cave::{Cave, RoomError, Screen};
use blend::Member;
use glam::DVec2;

impl Cave {
    /// Adds a projector.
    ///
    /// # Errors
    /// A name that another projector has, a screen that is not there, light that does not meet it;
    /// as [`Map::new`].
    pub fn add_projector(&mut self, projector: Projector) -> Result<(), RoomError> {
        let name = projector.name.to_lowercase();
        if self
            .projectors
            .iter()
            .any(|one| one.name.to_lowercase() == name)
        {
            let message = format!("two projectors are named \"{}\"", projector.name);
            return Err(RoomError::new(
                "name",
                message,
                "give each projector its own name",
            ));
        }
        if self
            .screens()
            .any(|screen| screen.name().to_lowercase() == name)
        {
            return Err(RoomError::new(
                "name",
                format!("projector \"{}\" is named as a screen is", projector.name),
                "give it a name of its own: outputs show either by its name",
            ));
        }
        Map::new(self.screen_of(&projector)?, &projector)?;
        self.projectors.push(projector);
        Ok(())
    }

    /// Returns the screen of a projector.
    ///
    /// # Errors
    /// A screen that is not there, or none where the room has several.
    pub fn screen_of(&self, projector: &Projector) -> Result<Screen<'_>, RoomError> {
        let named = &projector.screen;
        let mut found = self.screens().filter(|screen| {
            let name = named.as_deref();
            name.is_none_or(|name| screen.name() == name)
        });
        if let (Some(screen), None) = (found.next(), found.next()) {
            return Ok(screen);
        }
        let names: Vec<&str> = self.screens().map(Screen::name).collect();
        let message = match named {
            Some(screen) => format!(
                "projector \"{}\" is for the screen \"{screen}\", which is not there",
                projector.name
            ),
            None => format!(
                "projector \"{}\" is for none of several screens",
                projector.name
            ),
        };
        let help = format!("give screen, one of: {}", names.join(", "));
        Err(RoomError::new("screen", message, help))
    }

    /// Returns a sentence about each projector's mesh that has holes or folds.
    ///
    /// # Errors
    /// As [`Map::new`].
    pub fn uneven_meshes(&self) -> Result<Vec<String>, RoomError> {
        let with_mesh = |one: &&Projector| matches!(one.placement, Placement::Mesh(_));
        let flaws = self.projectors.iter().filter(with_mesh).map(|projector| {
            let map = Map::new(self.screen_of(projector)?, projector)?;
            Ok(map.flaws(projector))
        });
        Ok(flaws
            .collect::<Result<Vec<_>, RoomError>>()?
            .into_iter()
            .flatten()
            .collect())
    }

    /// Returns the outlines of the pictures of the other projectors that light a projector's screen
    /// for the same eye, as far as it shows them: in its own picture, 0 to 1.
    ///
    /// # Errors
    /// As [`Self::blends`].
    pub fn outlines(&self, projector: &str) -> Result<Vec<Vec<DVec2>>, RoomError> {
        /// Points along an edge.
        const POINTS: u32 = 256;
        let corners = [DVec2::ZERO, DVec2::X, DVec2::ONE, DVec2::Y, DVec2::ZERO];
        let edges = corners.windows(2).map(|edge| (edge[0], edge[1]));
        let edge: Vec<DVec2> = edges
            .flat_map(|(from, to)| {
                let part = move |number| f64::from(number) / f64::from(POINTS);
                (0..POINTS).map(move |number| from.lerp(to, part(number)))
            })
            .collect();
        for blend in self.blends()? {
            let mut members = blend.members.iter();
            let Some(own) = members.find(|one| one.projector.name == projector) else {
                continue;
            };
            let others = blend.members.iter().filter(|one| one.number != own.number);
            let outline = |other: &Member<'_>| {
                let points = edge
                    .iter()
                    .filter_map(|&at| own.map.at(other.map.place(at)?));
                points.collect()
            };
            return Ok(others.map(outline).collect());
        }
        Ok(Vec::new())
    }

    /// Returns which projectors light a screen together: one blend for each screen and eye.
    ///
    /// # Errors
    /// As [`Map::new`]; projectors for one eye beside some for both on one screen; overlaps that
    /// files' own weights do not blend.
    pub fn blends(&self) -> Result<Vec<Blend<'_>>, RoomError> {
        let mut groups: Vec<Vec<Member<'_>>> = Vec::new();
        for (number, projector) in self.projectors.iter().enumerate() {
            let screen = self.screen_of(projector)?;
            let map = Map::new(screen, projector)?;
            let member = Member {
                projector,
                map,
                number,
            };
            let others = groups
                .iter_mut()
                .filter(|group| group[0].map.screen() == screen);
            let mut others: Vec<_> = others.collect();
            let clash = others
                .iter()
                .find(|group| group[0].projector.eye.is_some() != projector.eye.is_some());
            if let Some(group) = clash {
                let message = format!(
                    "of the projectors on screen \"{}\", only some are for one eye: \"{}\" and \
                     \"{}\" differ",
                    screen.name(),
                    group[0].projector.name,
                    projector.name
                );
                let help = "give eye = \"left\" or \"right\" to all of them, or to none";
                return Err(RoomError::new("eye", message, help));
            }
            let eye = projector.eye;
            match others
                .iter_mut()
                .find(|group| group[0].projector.eye == eye)
            {
                Some(group) => group.push(member),
                None => groups.push(vec![member]),
            }
        }
        groups.into_iter().map(Blend::new).collect()
    }
}

#[cfg(test)]
mod tests;
