//! Projectors whose own pixels are traced, rather than their screen's.

use super::homography::Homography;
use super::map::{Kind, Map};
use super::projector::{Lens, Projector};
use crate::cave::{Cave, CylinderScreen, DomeScreen, RoomError, Screen, Wall, WallPlane};
use glam::{DMat3, DVec2, DVec3};
use shisen_core::frame::{Beam, View};

/// A projector's pixels as a picture that eyes look at, each on the place of the screen that it
/// lights.
#[derive(Debug, Clone, PartialEq)]
pub struct DirectProjector {
    /// The projector's name.
    pub(crate) name: String,
    /// Columns and rows.
    pub(crate) pixels: [u32; 2],
    on: Lit,
}

#[derive(Debug, Clone, PartialEq)]
enum Lit {
    Wall(Wall, Homography),
    Dome(DomeScreen, Lens),
    Cylinder(CylinderScreen, Lens),
}

impl Cave {
    /// Lets rays go through the pixels of some of the projectors. Their screens then have no
    /// pictures of their own.
    ///
    /// # Errors
    /// As [`Self::can_be_direct`].
    pub fn trace_directly(&mut self, names: &[String]) -> Result<(), RoomError> {
        self.direct = Vec::new();
        for projector in &self.projectors {
            if names.contains(&projector.name) {
                self.direct.push(self.can_be_direct(projector)?);
            }
        }
        Ok(())
    }

    /// Returns a projector's pixels as a picture.
    ///
    /// # Errors
    /// A projector by a mesh, or by pins on a curved screen: its pixels' directions have no closed
    /// form.
    pub fn can_be_direct(&self, projector: &Projector) -> Result<DirectProjector, RoomError> {
        if projector.resolution.contains(&1) {
            return Err(RoomError::new(
                "resolution",
                format!(
                    "projector \"{}\" has one column or row of pixels",
                    projector.name
                ),
                "give --project warp",
            ));
        }
        let map = Map::new(self.screen_of(projector)?, projector)?;
        let on = match (map.screen(), &map.kind) {
            (Screen::Wall(wall), Kind::Flat(map)) => Lit::Wall(wall.clone(), *map),
            (Screen::Dome(dome), Kind::Curved(lens)) => Lit::Dome(dome.clone(), *lens),
            (Screen::Cylinder(cylinder), Kind::Curved(lens)) => {
                Lit::Cylinder(cylinder.clone(), *lens)
            }
            _ => {
                return Err(RoomError::new(
                    "",
                    format!(
                        "no rays can be traced through the pixels of projector \"{}\": it is \
                         placed by a mesh, or by pins on a curved screen",
                        projector.name
                    ),
                    "give --project warp, or give the projector's position and lens",
                ));
            }
        };
        Ok(DirectProjector {
            name: projector.name.clone(),
            pixels: projector.resolution,
            on,
        })
    }
}

impl DirectProjector {
    /// Returns the screen that it lights.
    pub fn screen(&self) -> Screen<'_> {
        match &self.on {
            Lit::Wall(wall, _) => Screen::Wall(wall),
            Lit::Dome(dome, _) => Screen::Dome(dome),
            Lit::Cylinder(cylinder, _) => Screen::Cylinder(cylinder),
        }
    }

    /// Returns the rays from an eye at `eye` (metres, in the room) to the places that its pixels
    /// light. Those of pixels that light no place of the screen go past it.
    ///
    /// # Errors
    /// As [`Screen::view_from`]; a lens or an eye whose rays f32 cannot hold.
    pub fn view_from(&self, eye: DVec3) -> Result<View, RoomError> {
        let of_screen = self.screen().view_from(eye)?;
        let fault = |fault: &dyn std::fmt::Display| {
            RoomError::new(
                "eye",
                format!("projector \"{}\" cannot be traced: {fault}", self.name),
                "move the head away from the screen, or give --project warp",
            )
        };
        let (centre, radius, lens) = match &self.on {
            Lit::Wall(wall, map) => {
                // From the eye to homogeneous places of the wall's picture: a linear map.
                let plane = WallPlane::new(wall)?;
                let to_wall = DMat3::from_cols(plane.right, plane.down, plane.upper_left - eye);
                let [first, column, row] = self.steps(to_wall * map.to_screen());
                let view = View::new(eye.as_vec3(), first, column, row, self.pixels);
                return view.map_err(|error| fault(&error));
            }
            Lit::Dome(dome, lens) => (dome.centre, dome.radius, lens),
            Lit::Cylinder(cylinder, lens) => (cylinder.centre, cylinder.radius, lens),
        };
        let [first_pixel, column_step, row_step] = self.steps(lens.frame());
        let view = of_screen.lit_by(Beam {
            lens: ((lens.position - centre) / radius).as_vec3(),
            first_pixel,
            column_step,
            row_step,
            size: self.pixels,
        });
        view.map_err(|error| fault(&error))
    }

    /// Returns where the first pixel's centre is, and the steps to its neighbours to the right and
    /// below, by a map from the picture's coordinates, 0 to 1. The longest of a corner is 1.
    fn steps(&self, map: DMat3) -> [glam::Vec3; 3] {
        let [columns, rows] = self.pixels.map(f64::from);
        let corners = [DVec2::ZERO, DVec2::X, DVec2::Y, DVec2::ONE];
        let lengths = corners.map(|corner| (map * corner.extend(1.0)).length());
        let unit = lengths.into_iter().fold(0.0, f64::max);
        let (column, row) = (map.x_axis / columns, map.y_axis / rows);
        let first = map.z_axis + 0.5 * (column + row);
        [first, column, row].map(|step| (step / unit).as_vec3())
    }
}
