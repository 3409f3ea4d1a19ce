//! What a projector is: its screen, its geometry, and its light.

use super::homography::Homography;
use super::mesh::Mesh;
use super::transfer::Transfer;
use crate::cave::{Eye, RoomError};
use glam::{DMat3, DVec2, DVec3};
use std::sync::Arc;

/// A projector of a room.
#[derive(Debug, Clone, PartialEq)]
pub struct Projector {
    /// For file names and messages.
    pub name: String,
    /// The screen's name; `None` for the room's only one.
    pub screen: Option<String>,
    /// The eye that it shows pictures to: one of a pair of passive stereo. `None` for both.
    pub eye: Option<Eye>,
    /// Columns and rows.
    pub resolution: [u32; 2],
    /// Which point of the screen each of its pixels lights.
    pub placement: Placement,
    /// Its light for each code: of red, green and blue.
    pub gamma: [Transfer; 3],
    /// Its light at code 0, as a share of its white: 0 to [`Self::MOST_BLACK`].
    pub black: f64,
    /// Factors on red, green and blue light: above 0, to 1.
    pub gain: [f64; 3],
    /// The exponent of its weight in overlaps, [`Self::BLENDS`]: 1 is the smoothest, more is
    /// steeper.
    pub blend: f64,
}

/// How a projector's picture comes onto a screen.
#[derive(Debug, Clone, PartialEq)]
pub enum Placement {
    /// By its pose and its lens: onto any screen.
    Lens(Lens),
    /// By pins, or one to one onto a part of a screen's picture.
    Flat(Homography),
    /// By the nodes of a mesh, from a file.
    Mesh(Arc<Mesh>),
}

/// A pinhole with lens shift, at a place in the room.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lens {
    /// Metres, in the room.
    pub position: DVec3,
    /// To the picture's right, to its top, and against its light.
    pub axes: DMat3,
    /// The picture's left, right, lower and upper edge at distance 1, to the
    /// right and upwards from straight ahead.
    pub edges: [f64; 4],
}

impl Projector {
    /// Greatest [`black`](Self::black).
    pub const MOST_BLACK: f64 = 0.5;
    /// Least and greatest [`blend`](Self::blend).
    pub const BLENDS: [f64; 2] = [0.5, 8.0];

    /// Returns the pose and lens.
    ///
    /// # Errors
    /// A projector that is placed in another way.
    pub fn lens(&self) -> Result<&Lens, RoomError> {
        match &self.placement {
            Placement::Lens(lens) => Ok(lens),
            Placement::Flat(_) | Placement::Mesh(_) => Err(RoomError::new(
                "position",
                format!("projector \"{}\" has no position and lens", self.name),
                "give position, look and horizontal_degrees or throw",
            )),
        }
    }
}

impl Lens {
    /// Returns the axes of the picture's coordinates, from 0 to 1 to the right and downwards: its
    /// width, its height, and its upper left corner, all at distance 1.
    pub(super) fn frame(&self) -> DMat3 {
        let [left, right, down, up] = self.edges;
        let steps = DMat3::from_cols(
            DVec3::new(right - left, 0.0, 0.0),
            DVec3::new(0.0, down - up, 0.0),
            DVec3::new(left, up, -1.0),
        );
        self.axes * steps
    }

    /// Towards a point of the picture, 0 to 1 to the right and downwards from
    /// its upper left corner: of unit length.
    pub fn direction(&self, at: DVec2) -> DVec3 {
        (self.frame() * at.extend(1.0)).normalize()
    }

    /// Returns the point of the picture that lights a place in the room, also outside 0 to 1; `None`
    /// for places behind the lens.
    pub(super) fn at(&self, point: DVec3) -> Option<DVec2> {
        let [left, right, down, up] = self.edges;
        let DVec3 { x, y, z } = self.axes.transpose() * (point - self.position);
        let (x, y) = (x / -z, y / -z);
        let at = DVec2::new((x - left) / (right - left), (y - up) / (down - up));
        (z < 0.0 && at.is_finite()).then_some(at)
    }

    /// Yaw to the right, then pitch upwards, then roll clockwise as it looks: radians. Straight up
    /// and down the roll is 0.
    pub fn angles(&self) -> [f64; 3] {
        let (right, up, ahead) = (self.axes.x_axis, self.axes.y_axis, -self.axes.z_axis);
        let level = libm::hypot(ahead.x, ahead.z);
        let pitch = libm::atan2(ahead.y, level);
        if level < 1.0e-9 {
            return [libm::atan2(right.z, right.x), pitch, 0.0];
        }
        let yaw = libm::atan2(ahead.x, -ahead.z);
        // By the heights of the right and of the top.
        [yaw, pitch, libm::atan2(-right.y, up.y)]
    }
}
