//! Where each point of a projector's picture lies in its screen's, and which point lights a place.

use super::homography::Homography;
use super::mesh::{Cells, Flaws, Mesh, Shares, Targets};
use super::projector::{Lens, Placement, Projector};
use crate::cave::{RoomError, Screen, WallPlane};
use glam::DVec2;
use std::sync::Arc;

/// A projector's light on its screen. Points are of the projector's picture, places of the screen's:
/// both from the upper left corner, 0 to 1 to the right and downwards.
#[derive(Debug)]
pub struct Map<'a> {
    screen: Screen<'a>,
    pub(super) kind: Kind,
}

#[derive(Debug)]
pub(super) enum Kind {
    Flat(Homography),
    Curved(Lens),
    Mesh(Cells, Arc<Mesh>),
}

impl<'a> Map<'a> {
    /// A grid of this many points a side finds out whether a projector covers anything.
    const TRIED: u32 = 64;

    /// Returns the map of a projector onto a screen.
    ///
    /// # Errors
    /// Light that does not meet the screen; pins on a dome.
    pub fn new(screen: Screen<'a>, projector: &Projector) -> Result<Self, RoomError> {
        let (name, on) = (&projector.name, screen.name());
        let kind = match (&projector.placement, screen) {
            (Placement::Lens(lens), Screen::Wall(wall)) => {
                let map = Homography::of_lens(lens, &WallPlane::new(wall)?);
                map.map(Kind::Flat).ok_or_else(|| {
                    RoomError::new(
                        "position",
                        format!("projector \"{name}\" is in the plane of wall \"{on}\""),
                        "move it before the wall, or behind",
                    )
                })?
            }
            (Placement::Lens(lens), Screen::Dome(_) | Screen::Cylinder(_)) => Kind::Curved(*lens),
            (Placement::Flat(map), _) => Kind::Flat(*map),
            (Placement::Mesh(mesh), _) => {
                let places = match &mesh.targets {
                    Targets::Places(places) => places.clone(),
                    Targets::Points(points) => {
                        let place = |point| screen.place(point).unwrap_or(DVec2::NAN);
                        points.iter().copied().map(place).collect()
                    }
                };
                let cells = Cells::new(mesh.size, mesh.at.clone(), places).ok_or_else(|| {
                    RoomError::new(
                        "mesh",
                        format!("the mesh of projector \"{name}\" folds all over, or is noise"),
                        "export it again, smoothed",
                    )
                })?;
                Kind::Mesh(cells, mesh.clone())
            }
        };
        let map = Self { screen, kind };
        map.check(projector)?;
        Ok(map)
    }

    fn check(&self, projector: &Projector) -> Result<(), RoomError> {
        let along = |number: u32| (f64::from(number) + 0.5) / f64::from(Self::TRIED);
        let points = (0..Self::TRIED).flat_map(|y| (0..Self::TRIED).map(move |x| [x, y]));
        let mut places = points.map(|point| self.place(point.map(along).into()));
        if places.any(|place| place.is_some()) {
            return Ok(());
        }
        let (key, help) = match &projector.placement {
            Placement::Lens(_) => (
                "position",
                "turn it towards the screen with look, or yaw_degrees and pitch_degrees, and place \
                 it where its light meets the screen (a dome's from inside or through its opening)",
            ),
            Placement::Flat(_) => ("corner_pins", "measure the corner pins again"),
            Placement::Mesh(_) => ("mesh", "check that the mesh is of this screen"),
        };
        Err(RoomError::new(
            key,
            format!(
                "projector \"{}\" does not see {} \"{}\": none of its light meets it",
                projector.name,
                self.screen.kind(),
                self.screen.name()
            ),
            help,
        ))
    }

    /// Returns the screen.
    pub const fn screen(&self) -> Screen<'a> {
        self.screen
    }

    /// Returns the place that a point's light meets; `None` where it misses the screen's picture.
    pub fn place(&self, at: DVec2) -> Option<DVec2> {
        let place = match &self.kind {
            Kind::Flat(map) => map.place(at)?,
            Kind::Curved(lens) => self.screen.lit(lens.position, lens.direction(at))?,
            Kind::Mesh(cells, _) => cells.place(at)?,
        };
        // Rounded just outside is inside.
        let nearest = place.clamp(DVec2::ZERO, DVec2::ONE);
        let is_rounded =
            !matches!(self.screen, Screen::Dome(_)) && nearest.distance(place) < 1.0e-6;
        let place = if is_rounded { nearest } else { place };
        self.screen.has(place).then_some(place)
    }

    /// Returns the point that lights a place; `None` if none does.
    pub fn at(&self, place: DVec2) -> Option<DVec2> {
        let at = self.at_or_beyond(place)?;
        is_inside(at).then_some(at)
    }

    /// As [`Self::at`], also for places that the picture would light if it were larger; meshes end
    /// where they end.
    pub(super) fn at_or_beyond(&self, place: DVec2) -> Option<DVec2> {
        /// How far apart in the screen's picture light may land and still be the same.
        const SAME: f64 = 1.0e-6;
        match &self.kind {
            Kind::Flat(map) => map.at(place),
            Kind::Curved(lens) => {
                let at = lens.at(self.screen.point(place))?;
                let lit = self.screen.lit(lens.position, lens.direction(at))?;
                (lit.distance(place) < SAME).then_some(at)
            }
            Kind::Mesh(cells, _) => cells.lighting(place),
        }
    }

    /// Returns the factor on the picture's light and the light that is added at a point, where the
    /// mesh's file gives them; `light` is of a code.
    pub(super) fn own_share(&self, at: DVec2, light: impl Fn(f64) -> f64) -> Option<[f64; 2]> {
        let Kind::Mesh(cells, mesh) = &self.kind else {
            return None;
        };
        match &mesh.shares {
            Shares::Blended => None,
            Shares::Nodes(factors) => {
                let factor = cells.at(at).map_or(0.0, |found| found.mean(factors));
                Some([light(factor), 0.0])
            }
            Shares::Maps(alpha, beta) => {
                let beta = beta.as_ref().map_or(0.0, |beta| beta.at(at));
                Some([alpha.at(at) * (1.0 - beta), beta])
            }
        }
    }

    /// Returns a sentence about a mesh's holes and folds, if it has any.
    pub(super) fn flaws(&self, projector: &Projector) -> Option<String> {
        let Kind::Mesh(cells, _) = &self.kind else {
            return None;
        };
        let Flaws { holes, folds } = cells.flaws();
        let flaws = [
            (holes, "nodes inside it that are not drawn, and stay dark"),
            (folds, "cells folded over others"),
        ];
        let flaws = flaws.into_iter().filter(|(count, _)| *count > 0);
        let flaws: Vec<String> = flaws
            .map(|(count, what)| format!("{what}: {count}"))
            .collect();
        (!flaws.is_empty()).then(|| {
            format!(
                "the mesh of projector \"{}\" is uneven ({}): measure it again there",
                projector.name,
                flaws.join("; ")
            )
        })
    }

    /// Returns whether the mesh's file gives the projector's share.
    pub(super) fn has_own_shares(&self) -> bool {
        matches!(&self.kind, Kind::Mesh(_, mesh) if mesh.shares != Shares::Blended)
    }
}

/// Returns whether both coordinates are 0 to 1.
pub(super) fn is_inside(at: DVec2) -> bool {
    at.cmpge(DVec2::ZERO).all() && at.cmple(DVec2::ONE).all()
}
