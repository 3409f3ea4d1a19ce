//! A perspective view of the screens from the viewer's eye, to check on a desk what a CAVE shows.

use crate::cave::{CylinderScreen, DomeScreen, RoomError, Screen, WallPlane};
use crate::picture::Picture;
use crate::show::ShowError;
use glam::{DVec2, DVec3};
use rayon::prelude::*;
use std::f64::consts::{PI, SQRT_2};
use thiserror::Error;

/// The colour where there is no screen: dark grey, for files without alpha, and no coverage.
pub const NO_WALL: [f32; 4] = [0.02, 0.02, 0.02, 0.0];

/// A pinhole camera at the viewer's eye, with square pixels.
#[derive(Debug, Clone, PartialEq)]
pub struct ViewerCamera {
    eye: DVec3,
    forward: DVec3,
    /// From the picture's centre to its right edge, at distance 1.
    half_right: DVec3,
    /// From the picture's centre to its lower edge, at distance 1.
    half_down: DVec3,
    size: [u32; 2],
}

/// Why a camera is impossible, and what to give instead.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("{0}")]
pub struct CameraError(String);

impl ViewerCamera {
    /// Returns a camera at `eye` (metres, in the room) looking along `forward` with `up` upwards,
    /// of any lengths and not necessarily perpendicular. The field of view is in radians, between 0
    /// and π; `size` is columns and rows.
    ///
    /// # Errors
    /// An eye or a direction without finite numbers or of no length, directions along each other,
    /// a field of view or a size out of its range.
    pub fn new(
        eye: DVec3,
        forward: DVec3,
        up: DVec3,
        horizontal_field_of_view: f64,
        size: [u32; 2],
    ) -> Result<Self, CameraError> {
        let direction = forward.normalize_or_zero();
        let right = direction.cross(up.normalize_or_zero());
        let (degrees, [columns, rows]) = (horizontal_field_of_view.to_degrees(), size);
        let fault = if !eye.is_finite() {
            format!("the viewer's eye is at {eye}: give it finite coordinates, in metres")
        } else if direction == DVec3::ZERO {
            format!("the view direction is {forward}: give it a finite length above 0")
        } else if right.length() < 1e-9 {
            format!(
                "the up direction {up} is zero, not finite or parallel to the view direction \
                 {forward}: choose another"
            )
        } else if !(degrees > 0.0 && horizontal_field_of_view < PI) {
            format!(
                "the horizontal field of view is {degrees} degrees: choose one above 0 and below \
                 180"
            )
        } else if columns == 0 || rows == 0 {
            format!("the viewer's picture is {columns} × {rows} pixels: choose at least 1 × 1")
        } else {
            String::new()
        };
        if !fault.is_empty() {
            return Err(CameraError(fault));
        }
        let right = right.normalize();
        let half_width = (0.5 * horizontal_field_of_view).tan();
        let half_height = half_width * f64::from(rows) / f64::from(columns);
        Ok(Self {
            eye,
            forward: direction,
            half_right: half_width * right,
            half_down: half_height * direction.cross(right),
            size,
        })
    }

    /// Returns the unit direction from the eye through a point of the picture, in pixels from its
    /// upper left corner: the centre of pixel `i` is at `i + 0.5`.
    pub fn ray(&self, x: f64, y: f64) -> DVec3 {
        let [columns, rows] = self.size.map(f64::from);
        let right = (2.0 * x / columns - 1.0) * self.half_right;
        let down = (2.0 * y / rows - 1.0) * self.half_down;
        (self.forward + right + down).normalize()
    }
}

/// Draws what the camera sees: for every pixel's centre the nearest screen, its picture
/// interpolated bilinearly, or [`NO_WALL`]. Screens are also drawn from behind.
///
/// # Errors
/// A wall without area; a picture that is too large.
pub fn render<'a, S>(
    camera: &ViewerCamera,
    screens: &[(S, &'a Picture)],
) -> Result<Picture, ShowError>
where
    S: Into<Screen<'a>> + Copy,
{
    let surfaces = screens.iter();
    let surfaces = surfaces.map(|one| Ok((Surface::new(one.0.into())?, one.1)));
    let surfaces = surfaces.collect::<Result<Vec<_>, RoomError>>()?;
    let [columns, rows] = camera.size;
    let mut view = Picture::new(columns, rows)?;
    let rows = view.pixels.par_chunks_exact_mut(columns as usize);
    rows.enumerate().for_each(|(y, row)| {
        for (x, pixel) in row.iter_mut().enumerate() {
            let direction = camera.ray(x as f64 + 0.5, y as f64 + 0.5);
            *pixel = nearest(&surfaces, camera.eye, direction);
        }
    });
    Ok(view)
}

enum Surface<'a> {
    Wall(WallPlane),
    Dome(&'a DomeScreen),
    Cylinder(&'a CylinderScreen),
}

impl<'a> Surface<'a> {
    fn new(screen: Screen<'a>) -> Result<Self, RoomError> {
        Ok(match screen {
            Screen::Wall(wall) => Self::Wall(WallPlane::new(wall)?),
            Screen::Dome(dome) => Self::Dome(dome),
            Screen::Cylinder(cylinder) => Self::Cylinder(cylinder),
        })
    }

    /// Returns where a ray meets the surface: the ray's parameter, above 0, and the place in
    /// pixels.
    fn meet(&self, picture: &Picture, eye: DVec3, direction: DVec3) -> Option<(f64, DVec2)> {
        let size = DVec2::new(f64::from(picture.width), f64::from(picture.height));
        match self {
            Self::Wall(plane) => {
                let (distance, x, y) = plane.intersect(eye, direction)?;
                Some((distance, DVec2::new(x, y) * size))
            }
            Self::Cylinder(cylinder) => {
                let (distance, at) = cylinder.meet(eye, direction)?;
                Some((distance, at * size))
            }
            Self::Dome(dome) => {
                let (distance, at) = dome.meet(eye, direction)?;
                // At the rim, moved inwards until all four pixels around are inside: those
                // outside have no colour.
                let half = 0.5 * size.min_element();
                let from_centre = (at.length() * half).min((half - SQRT_2).max(0.0));
                let from_centre = at.normalize_or_zero() * from_centre * DVec2::new(1.0, -1.0);
                Some((distance, 0.5 * size + from_centre))
            }
        }
    }
}

fn nearest(surfaces: &[(Surface, &Picture)], eye: DVec3, direction: DVec3) -> [f32; 4] {
    let hits = surfaces.iter().filter_map(|(surface, picture)| {
        let (distance, place) = surface.meet(picture, eye, direction)?;
        Some((distance, place, picture))
    });
    let nearest = hits.min_by(|a, b| a.0.total_cmp(&b.0));
    nearest.map_or(NO_WALL, |(_, place, picture)| {
        picture.sample(place.x, place.y)
    })
}

#[cfg(test)]
mod tests;
