//! Domes: screens that dome masters are shown on.

use super::RoomError;
use crate::cave::angle::sin_cos_degrees;
use glam::{DMat3, DVec2, DVec3};
use shisen_core::frame::{self, View};
use std::f64::consts::TAU;
use std::ops::RangeInclusive;

/// The inside of a dome as a screen: the part of a sphere within half the field of view of the
/// dome's zenith.
///
/// Its picture is a dome master, equidistant from the sphere's centre, with the right at the right
/// and, without tilt, the front at the bottom. Each pixel shows what the eye sees behind its place
/// on the dome, for an eye anywhere inside.
#[derive(Debug, Clone, PartialEq)]
pub struct DomeScreen {
    /// For file names and messages.
    pub name: String,
    /// The sphere's radius: metres, within [`Self::RADII`].
    pub radius: f64,
    /// The sphere's centre: metres, in the room.
    pub centre: DVec3,
    /// How far the zenith leans from straight up (+Y) towards the front (−Z),
    /// about the room's +X: degrees, −360 to 360.
    pub tilt_degrees: f64,
    /// The angle from rim to rim at the centre: degrees, above 0 to 360.
    pub field_of_view_degrees: f64,
    /// Columns, and rows, 1 to [`Wall::MOST_PIXELS`](crate::cave::Wall::MOST_PIXELS).
    pub size: u32,
}

impl DomeScreen {
    /// Radii that a dome may have: metres.
    pub const RADII: RangeInclusive<f64> =
        frame::DomeScreen::RADII.0 as f64..=frame::DomeScreen::RADII.1 as f64;

    /// The share of the radius within which a ray still starts on the sphere: projectors may stand
    /// on the rim.
    const AT_THE_SURFACE: f64 = 1.0e-9;

    /// Checks everything that views of the dome rely on.
    ///
    /// # Errors
    /// The first fault found: a name that is not usable in a file name, a
    /// radius, centre, tilt, field of view or size that is out of its range.
    pub fn validate(&self) -> Result<(), RoomError> {
        let (name, radius) = (&self.name, self.radius);
        let (tilt, field) = (self.tilt_degrees, self.field_of_view_degrees);
        let named = "pictures are named after their domes";
        RoomError::check_name("dome", name, named, "dome")?;
        // Formatted only for errors: views are made for each frame, without taking memory.
        let dome = format_args!("dome \"{name}\"");
        RoomError::check_radius(dome, radius)?;
        let centre = format_args!("{dome}: its centre is");
        RoomError::check_place("centre", centre, self.centre)?;
        if !(tilt.abs() <= 360.0) {
            return Err(RoomError::new(
                "tilt_degrees",
                format!("{dome} is tilted by {tilt}°"),
                "give degrees from -360 to 360: how far the zenith leans towards the front, 90 \
                 being straight ahead",
            ));
        }
        if !(field > 0.0 && field <= 360.0 && field as f32 > 0.0) {
            return Err(RoomError::new(
                "field_of_view_degrees",
                format!("{dome} has a field of view of {field}°"),
                "give degrees above 0, to 360; 180 is a hemisphere",
            ));
        }
        RoomError::check_pixels("size", dome, [self.size; 2])
    }

    /// Returns the angle from rim to rim at the centre: radians, above 0 to 2π.
    pub const fn field_of_view(&self) -> f64 {
        self.field_of_view_degrees.to_radians()
    }

    /// From rim to rim along the dome: metres.
    pub const fn width(&self) -> f64 {
        self.radius * self.field_of_view()
    }

    /// Returns the axes of [`shisen_core::capture`] in the room: the picture's right, its top, and
    /// away from the zenith.
    pub fn axes(&self) -> DMat3 {
        let (sin, cos) = sin_cos_degrees(self.tilt_degrees);
        let away = DVec3::new(0.0, -cos, sin);
        DMat3::from_cols(DVec3::X, DVec3::new(0.0, sin, cos), away)
    }

    /// Returns the rays from an eye at `eye` (metres, in the room) through the dome's pixels.
    ///
    /// # Errors
    /// As [`Self::validate`]; an eye that is not finite, farther from the centre than
    /// [`frame::DomeScreen::FARTHEST_EYE`] of the radius, or whose rays f32 cannot hold.
    pub fn view_from(&self, eye: DVec3) -> Result<View, RoomError> {
        self.validate()?;
        let distance = eye.distance(self.centre);
        let farthest = f64::from(frame::DomeScreen::FARTHEST_EYE) * self.radius;
        if !(distance <= farthest) {
            return Err(RoomError::new(
                "eye",
                format!(
                    "the eye at {:.4}, {:.4}, {:.4} is not inside dome \"{}\": it is \
                     {distance:.4} m from the centre",
                    eye.x, eye.y, eye.z, self.name
                ),
                format!(
                    "move the head to within {farthest:.4} m of the dome's centre, 0.99 of its \
                     radius, or give another centre or radius"
                ),
            ));
        }
        let (least, most) = frame::DomeScreen::RADII;
        let screen = frame::DomeScreen {
            pose: frame::DomePose {
                position: self.centre.as_vec3(),
                room_from_capture: self.axes().as_mat3(),
            },
            radius: (self.radius as f32).clamp(least, most),
            // 360 degrees round to a little more than 2π.
            field_of_view: (self.field_of_view() as f32).min(TAU as f32),
        };
        View::dome_screen(screen, eye.as_vec3(), self.size).map_err(|fault| {
            RoomError::new(
                "eye",
                format!("dome \"{}\" cannot be traced: {fault}", self.name),
                "move the head towards the dome's centre",
            )
        })
    }

    /// Returns the place on the dome, metres in the room, of (u, v) in the unit disc: u
    /// to the right of the picture and v to its top.
    pub fn point(&self, at: DVec2) -> DVec3 {
        let from_centre = at.length();
        let (sin, cos) = libm::sincos(0.5 * self.field_of_view() * from_centre);
        let outwards = at.normalize_or_zero() * sin;
        self.centre + self.radius * (self.axes() * outwards.extend(-cos))
    }

    /// Returns where in the picture a place is, seen from the centre: (u, v), in the
    /// unit disc where it is on the dome. `None` for the centre itself.
    pub fn place(&self, point: DVec3) -> Option<DVec2> {
        let direction = self.axes().transpose() * (point - self.centre).try_normalize()?;
        let across = direction.truncate();
        let angle = libm::atan2(across.length(), -direction.z);
        // Opposite to the zenith any direction will do.
        let way = across.try_normalize().unwrap_or(DVec2::X);
        Some(way * (angle / (0.5 * self.field_of_view())))
    }

    /// Returns the distances at which a ray of unit `direction` enters and leaves the sphere.
    fn crossings(&self, origin: DVec3, direction: DVec3) -> Option<[f64; 2]> {
        let from = origin - self.centre;
        let half = from.dot(direction);
        // By the distance of the line from the centre: keeps its digits far away.
        let nearest = from - half * direction;
        let left = self.radius * self.radius - nearest.length_squared();
        (left >= 0.0).then(|| [-half - left.sqrt(), -half + left.sqrt()])
    }

    /// Returns the distance to the first part of the dome that a ray of unit `direction` meets,
    /// from either side, and the place in the picture: (u, v).
    pub fn meet(&self, origin: DVec3, direction: DVec3) -> Option<(f64, DVec2)> {
        self.on_screen(origin, direction).map(|(t, at, _)| (t, at))
    }

    /// Returns the place in the picture, (u, v), where light from `origin` along the unit
    /// `direction` meets the inside. It may enter through the dome's opening, but not through the
    /// dome.
    pub fn lit(&self, origin: DVec3, direction: DVec3) -> Option<DVec2> {
        let (_, at, from_inside) = self.on_screen(origin, direction)?;
        from_inside.then_some(at)
    }

    /// Returns the first part of the dome that a ray meets: distance, place, and whether it is the
    /// inside.
    fn on_screen(&self, origin: DVec3, direction: DVec3) -> Option<(f64, DVec2, bool)> {
        let crossings = self.crossings(origin, direction)?;
        [false, true]
            .into_iter()
            .zip(crossings)
            .find_map(|(from_inside, t)| {
                let at = self.place(origin + t * direction)?;
                let met = t > Self::AT_THE_SURFACE * self.radius && at.length_squared() <= 1.0;
                met.then_some((t, at, from_inside))
            })
    }
}
