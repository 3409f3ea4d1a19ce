//! Cylinders: curved screens that stand upright.

use super::{RoomError, Wall};
use crate::cave::angle::sin_cos_degrees;
use glam::{DMat3, DVec2, DVec3};
use shisen_core::frame::{self, View};
use std::f64::consts::TAU;

/// The inside of a part of an upright cylinder as a screen.
///
/// Its picture's columns are at equal azimuths, its rows at equal heights; the first pixel is at the
/// upper left as seen from the axis.
#[derive(Debug, Clone, PartialEq)]
pub struct CylinderScreen {
    /// For file names and messages.
    pub name: String,
    /// Metres, within [`DomeScreen::RADII`](super::DomeScreen::RADII).
    pub radius: f64,
    /// A point of the axis: metres, in the room.
    pub centre: DVec3,
    /// The left and the right edge's azimuth, from straight ahead (−Z) to the right: degrees, −360
    /// to 360, up to 360 apart.
    pub azimuth_degrees: [f64; 2],
    /// The lower and the upper edge's height over the centre: metres.
    pub height: [f64; 2],
    /// Columns and rows.
    pub pixels: [u32; 2],
}

impl CylinderScreen {
    /// Greatest distance of an edge or an eye from the centre: radii.
    pub const HIGHEST: f64 = frame::CylinderScreen::HIGHEST as f64;

    /// Checks everything that views of the cylinder rely on.
    ///
    /// # Errors
    /// The first fault found: a name that is not usable in a file name, a radius, centre, azimuth,
    /// height or number of pixels that is out of its range.
    pub fn validate(&self) -> Result<(), RoomError> {
        let (name, radius) = (&self.name, self.radius);
        let named = "pictures are named after their cylinders";
        RoomError::check_name("cylinder", name, named, "curve")?;
        // Formatted only for errors: views are made for each frame, without taking memory.
        let cylinder = format_args!("cylinder \"{name}\"");
        RoomError::check_radius(cylinder, radius)?;
        let centre = format_args!("{cylinder}: its centre is");
        RoomError::check_place("centre", centre, self.centre)?;
        let [left, right] = self.azimuth_degrees;
        if !(left.abs() <= 360.0 && right.abs() <= 360.0 && left < right && right - left <= 360.0) {
            return Err(RoomError::new(
                "azimuth_degrees",
                format!("{cylinder} goes from {left}° to {right}°"),
                "give the left edge's azimuth and a greater one, up to 360 more, for the right: \
                 degrees from -360 to 360, 0 being straight ahead and 90 to the right",
            ));
        }
        let [low, high] = self.height;
        let highest = Self::HIGHEST * radius;
        if !(low.abs() <= highest && high.abs() <= highest && high - low >= Wall::CLOSEST) {
            return Err(RoomError::new(
                "height",
                format!("{cylinder} goes from {low} m to {high} m over its centre"),
                format!("give the lower edge's height and a greater one, within {highest} m"),
            ));
        }
        RoomError::check_pixels("pixels", cylinder, self.pixels)
    }

    /// Returns the angle from edge to edge: radians, above 0 to 2π.
    pub fn angle(&self) -> f64 {
        let [left, right] = self.azimuth_degrees;
        (right - left).to_radians()
    }

    /// Along the cylinder from edge to edge: metres.
    pub fn width(&self) -> f64 {
        self.radius * self.angle()
    }

    /// Returns the axes in the room: to the right of the picture's middle, up, and towards the axis.
    pub fn axes(&self) -> DMat3 {
        let [left, right] = self.azimuth_degrees;
        let (sin, cos) = sin_cos_degrees(0.5 * (left + right));
        let right = DVec3::new(cos, 0.0, sin);
        DMat3::from_cols(right, DVec3::Y, DVec3::new(-sin, 0.0, cos))
    }

    /// Returns the rays from an eye at `eye` (metres, in the room) through the cylinder's pixels.
    ///
    /// # Errors
    /// As [`Self::validate`]; an eye that is not finite, farther from the axis than
    /// [`frame::DomeScreen::FARTHEST_EYE`] of the radius, or whose rays f32 cannot hold.
    pub fn view_from(&self, eye: DVec3) -> Result<View, RoomError> {
        self.validate()?;
        let away = eye - self.centre;
        let distance = libm::hypot(away.x, away.z);
        let farthest = f64::from(frame::DomeScreen::FARTHEST_EYE) * self.radius;
        if !(distance <= farthest) {
            return Err(RoomError::new(
                "eye",
                format!(
                    "the eye at {:.4}, {:.4}, {:.4} is not inside cylinder \"{}\": it is \
                     {distance:.4} m from the axis",
                    eye.x, eye.y, eye.z, self.name
                ),
                format!(
                    "move the head to within {farthest:.4} m of the cylinder's axis, 0.99 of its \
                     radius, or give another centre or radius"
                ),
            ));
        }
        let screen = frame::CylinderScreen {
            pose: frame::DomePose {
                position: self.centre.as_vec3(),
                room_from_capture: self.axes().as_mat3(),
            },
            radius: self.radius as f32,
            // 360 degrees round to a little more than 2π.
            angle: (self.angle() as f32).min(TAU as f32),
            heights: self.height.map(|height| height as f32),
        };
        View::cylinder_screen(screen, eye.as_vec3(), self.pixels).map_err(|fault| {
            RoomError::new(
                "eye",
                format!("cylinder \"{}\" cannot be traced: {fault}", self.name),
                "move the head towards the cylinder's centre",
            )
        })
    }

    /// Returns where a place of the picture is in the room: (s, t) from its upper left corner, 0 to
    /// 1 to the right and downwards; metres.
    pub fn point(&self, place: DVec2) -> DVec3 {
        let (sin, cos) = libm::sincos((place.x - 0.5) * self.angle());
        let [low, high] = self.height;
        let up = high - place.y * (high - low);
        self.centre + self.axes() * DVec3::new(self.radius * sin, up, -self.radius * cos)
    }

    /// Returns where in the picture a point of the room is, seen from the axis: 0 to 1 where it is
    /// on the cylinder. `None` for the axis itself.
    pub fn place(&self, point: DVec3) -> Option<DVec2> {
        let DVec3 { x, y, z } = self.axes().transpose() * (point - self.centre);
        let [low, high] = self.height;
        let place = DVec2::new(
            libm::atan2(x, -z) / self.angle() + 0.5,
            (high - y) / (high - low),
        );
        (x != 0.0 || z != 0.0).then_some(place)
    }

    /// Returns the distance to the first part of the cylinder that a ray of unit `direction` meets,
    /// from either side, and the place in the picture.
    pub fn meet(&self, origin: DVec3, direction: DVec3) -> Option<(f64, DVec2)> {
        self.on_screen(origin, direction).map(|(t, at, _)| (t, at))
    }

    /// Returns the place in the picture where light from `origin` along the unit `direction` meets
    /// the inside. It may enter past the edges, but not through the cylinder.
    pub fn lit(&self, origin: DVec3, direction: DVec3) -> Option<DVec2> {
        let (_, at, from_inside) = self.on_screen(origin, direction)?;
        from_inside.then_some(at)
    }

    /// Returns the first part of the cylinder that a ray meets: distance, place, and whether it is
    /// the inside.
    fn on_screen(&self, origin: DVec3, direction: DVec3) -> Option<(f64, DVec2, bool)> {
        let from = (origin - self.centre) * DVec3::new(1.0, 0.0, 1.0);
        let along = direction * DVec3::new(1.0, 0.0, 1.0);
        let speed = along.length();
        let half = from.dot(along) / speed;
        // By the distance of the line from the axis: keeps its digits far away.
        let nearest = from - half * along / speed;
        let left = self.radius * self.radius - nearest.length_squared();
        if !(left >= 0.0) {
            return None;
        }
        let ways = [(false, -half - left.sqrt()), (true, -half + left.sqrt())];
        ways.into_iter().find_map(|(from_inside, way)| {
            let t = way / speed;
            let at = self.place(origin + t * direction)?;
            let is_inside = at.cmpge(DVec2::ZERO).all() && at.cmple(DVec2::ONE).all();
            (t > 1.0e-9 * self.radius && is_inside).then_some((t, at, from_inside))
        })
    }
}
