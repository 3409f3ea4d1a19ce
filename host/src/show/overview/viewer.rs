//! What the viewer sees looking at the screens: a perspective view from the
//! eye, so that a person can check on a desk what a CAVE would show.

use crate::cave::{DegenerateWall, DomeScreen, Screen, WallPlane};
use crate::picture::{Picture, PictureError};
use glam::{DVec2, DVec3};
use rayon::prelude::*;
use std::f64::consts::{PI, SQRT_2};
use thiserror::Error;

/// Where there is no screen: linear dark grey that shows in files without
/// alpha, and no coverage.
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

/// Why there is no such camera.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[non_exhaustive]
pub enum CameraError {
    /// The eye is not at a finite place.
    #[error("the viewer's eye is at {eye}: give it finite coordinates, in metres")]
    Eye {
        /// Where it is.
        eye: DVec3,
    },
    /// The view direction has no length.
    #[error("the view direction is {forward}: give it a finite length above 0")]
    Direction {
        /// The direction.
        forward: DVec3,
    },
    /// The up direction has no length, or does not say which way up the
    /// picture is.
    #[error(
        "the up direction {up} is zero, not finite or parallel to the view direction {forward}: \
         choose another"
    )]
    Up {
        /// The view direction.
        forward: DVec3,
        /// The up direction.
        up: DVec3,
    },
    /// The field of view is not one of a perspective view.
    #[error(
        "the horizontal field of view is {} degrees: choose one above 0 and below 180",
        radians.to_degrees()
    )]
    FieldOfView {
        /// The field of view.
        radians: f64,
    },
    /// The picture has no pixels.
    #[error("the viewer's picture is {} × {} pixels: choose at least 1 × 1", size[0], size[1])]
    Size {
        /// Columns and rows.
        size: [u32; 2],
    },
}

/// Why the view could not be drawn.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ViewError {
    /// A wall has no area.
    #[error(transparent)]
    Wall(#[from] DegenerateWall),
    /// The picture is too large.
    #[error(transparent)]
    Picture(#[from] PictureError),
}

impl ViewerCamera {
    /// A camera at `eye` (metres, in the room) looking along `forward` with
    /// `up` upwards; neither needs to be of unit length or perpendicular to
    /// the other. The field of view is in radians, between 0 and π; `size` is
    /// columns and rows.
    ///
    /// # Errors
    ///
    /// When a vector is not finite or zero, `up` is parallel to `forward`, the
    /// field of view is outside its range or the size is zero.
    pub fn new(
        eye: DVec3,
        forward: DVec3,
        up: DVec3,
        horizontal_field_of_view: f64,
        size: [u32; 2],
    ) -> Result<Self, CameraError> {
        if !eye.is_finite() {
            return Err(CameraError::Eye { eye });
        }
        let direction = forward
            .try_normalize()
            .ok_or(CameraError::Direction { forward })?;
        let right = direction.cross(up.normalize_or_zero());
        if right.length() < 1e-9 {
            return Err(CameraError::Up { forward, up });
        }
        let right = right.normalize();
        if !(horizontal_field_of_view > 0.0 && horizontal_field_of_view < PI) {
            return Err(CameraError::FieldOfView {
                radians: horizontal_field_of_view,
            });
        }
        let [columns, rows] = size;
        if columns == 0 || rows == 0 {
            return Err(CameraError::Size { size });
        }
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

    /// The unit direction from the eye through a point of the picture, in
    /// pixels from its upper left corner: pixel `i`'s centre is at `i + 0.5`.
    pub fn ray(&self, x: f64, y: f64) -> DVec3 {
        let [columns, rows] = self.size.map(f64::from);
        let right = (2.0 * x / columns - 1.0) * self.half_right;
        let down = (2.0 * y / rows - 1.0) * self.half_down;
        (self.forward + right + down).normalize()
    }
}

/// Draws what the camera sees of the screens and their pictures: for every
/// pixel's centre the nearest screen, its picture interpolated bilinearly;
/// [`NO_WALL`] where there is none. A screen is drawn from behind too.
///
/// # Errors
///
/// When a wall has no area or the camera's picture is too large.
pub fn render<'a, S>(
    camera: &ViewerCamera,
    screens: &[(S, &'a Picture)],
) -> Result<Picture, ViewError>
where
    S: Into<Screen<'a>> + Copy,
{
    let surfaces = screens
        .iter()
        .map(|&(screen, picture)| Ok((Surface::new(screen.into())?, picture)))
        .collect::<Result<Vec<_>, DegenerateWall>>()?;
    let [columns, rows] = camera.size;
    let mut view = Picture::new(columns, rows)?;
    view.pixels
        .par_chunks_exact_mut(columns as usize)
        .enumerate()
        .for_each(|(y, row)| {
            for (x, pixel) in row.iter_mut().enumerate() {
                let direction = camera.ray(x as f64 + 0.5, y as f64 + 0.5);
                *pixel = nearest(&surfaces, camera.eye, direction);
            }
        });
    Ok(view)
}

/// Where a picture is shown.
enum Surface<'a> {
    Wall(WallPlane),
    Dome(&'a DomeScreen),
}

impl<'a> Surface<'a> {
    fn new(screen: Screen<'a>) -> Result<Self, DegenerateWall> {
        Ok(match screen {
            Screen::Wall(wall) => Self::Wall(WallPlane::new(wall)?),
            Screen::Dome(dome) => Self::Dome(dome),
        })
    }

    /// Where a ray meets it: the ray's parameter, above 0, and the place in its
    /// picture, in pixels from the upper left corner.
    fn intersect(
        &self,
        picture: &Picture,
        eye: DVec3,
        direction: DVec3,
    ) -> Option<(f64, f64, f64)> {
        let size = DVec2::new(f64::from(picture.width), f64::from(picture.height));
        match self {
            Self::Wall(plane) => {
                let (distance, x, y) = plane.intersect(eye, direction)?;
                Some((distance, x * size.x, y * size.y))
            }
            Self::Dome(dome) => {
                let (distance, at) = dome.meet(eye, direction)?;
                // Next to the rim as far inwards as all four pixels around are
                // inside: what is outside has no colour.
                let half = 0.5 * size.min_element();
                let from_centre = (at.length() * half).min((half - SQRT_2).max(0.0));
                let from_centre = at.normalize_or_zero() * from_centre * DVec2::new(1.0, -1.0);
                let place = 0.5 * size + from_centre;
                Some((distance, place.x, place.y))
            }
        }
    }
}

fn nearest(surfaces: &[(Surface, &Picture)], eye: DVec3, direction: DVec3) -> [f32; 4] {
    surfaces
        .iter()
        .filter_map(|(surface, picture)| {
            let (distance, x, y) = surface.intersect(picture, eye, direction)?;
            Some((distance, x, y, picture))
        })
        .min_by(|a, b| a.0.total_cmp(&b.0))
        .map_or(NO_WALL, |(_, x, y, picture)| picture.sample(x, y))
}

#[cfg(test)]
mod tests;
