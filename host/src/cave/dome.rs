//! Domes: screens that dome masters are shown on.

use super::{Wall, is_in_a_room, name_fault};
use crate::cave::angle::sin_cos_degrees;
use glam::{DMat3, DVec2, DVec3};
use miette::Diagnostic;
use shisen_core::frame;
use std::f64::consts::TAU;
use thiserror::Error;

/// A dome's inside as a screen: the part of a sphere that is within half of
/// the field of view around the dome's zenith.
///
/// Its picture is a dome master, equidistant as seen from the sphere's centre,
/// right at the right and, of a dome without tilt, the front at the bottom.
/// What it shows is what an eye sees behind each place of the dome, wherever in
/// the dome the eye is.
#[derive(Debug, Clone, PartialEq)]
pub struct DomeScreen {
    name: String,
    radius: f64,
    centre: DVec3,
    field_of_view_degrees: f64,
    size: u32,
    /// Of its picture in the room: see [`DomeScreen::axes`].
    axes: DMat3,
}

/// Why there is no such dome, or not from where the eye is.
#[derive(Debug, Clone, PartialEq, Error, Diagnostic)]
#[non_exhaustive]
pub enum DomeScreenError {
    /// A name that cannot be part of a file's name.
    #[error("the dome name \"{}\" {reason}", .dome.escape_debug())]
    #[diagnostic(help(
        "pictures are named after their domes: use letters, digits, '-' and '_', such as \"dome\""
    ))]
    Name {
        /// The name.
        dome: String,
        /// What is wrong with it.
        reason: &'static str,
    },
    /// A dome and a wall, or two domes, whose pictures would overwrite each
    /// other.
    #[error("a dome is named \"{dome}\" as another screen is")]
    #[diagnostic(help(
        "pictures are named after their screens: give each its own name, different in more than upper and lower case"
    ))]
    DuplicateName {
        /// The dome's name.
        dome: String,
    },
    /// A size that no dome has.
    #[error("dome \"{dome}\" has a radius of {radius} m")]
    #[diagnostic(help(
        "give metres from {least} to {most}",
        least = DomeScreen::RADII.0,
        most = DomeScreen::RADII.1
    ))]
    Radius {
        /// The dome's name.
        dome: String,
        /// Metres.
        radius: f64,
    },
    /// A centre that is not a place in a room.
    #[error("dome \"{dome}\": its centre is at {}, {}, {}", .centre.x, .centre.y, .centre.z)]
    #[diagnostic(help("coordinates are metres from -{limit} to {limit}", limit = Wall::FARTHEST))]
    Centre {
        /// The dome's name.
        dome: String,
        /// Metres, in the room.
        centre: DVec3,
    },
    /// A tilt that is none.
    #[error("dome \"{dome}\" is tilted by {degrees}°")]
    #[diagnostic(help(
        "give degrees from -360 to 360: how far the zenith leans towards the front, 90 being straight ahead"
    ))]
    Tilt {
        /// The dome's name.
        dome: String,
        /// Degrees.
        degrees: f64,
    },
    /// A part of a sphere that there is not.
    #[error("dome \"{dome}\" has a field of view of {degrees}°")]
    #[diagnostic(help("give degrees above 0, to 360; 180 is a hemisphere"))]
    FieldOfView {
        /// The dome's name.
        dome: String,
        /// Degrees.
        degrees: f64,
    },
    /// Too few or too many pixels.
    #[error("dome \"{dome}\" has {size} × {size} pixels")]
    #[diagnostic(help("each side has 1 to {limit} pixels", limit = Wall::MOST_PIXELS))]
    Size {
        /// The dome's name.
        dome: String,
        /// Columns, and rows.
        size: u32,
    },
    /// An eye outside, or too near to the dome's surface.
    #[error(
        "the eye at {:.4}, {:.4}, {:.4} is not inside dome \"{dome}\": it is {distance:.4} m from the centre",
        .eye.x, .eye.y, .eye.z
    )]
    #[diagnostic(help(
        "move the head to within {farthest:.4} m of the dome's centre, 0.99 of its radius, or give another centre or radius"
    ))]
    Eye {
        /// The dome's name.
        dome: String,
        /// Where the eye is, metres.
        eye: DVec3,
        /// From the dome's centre to the eye, metres.
        distance: f64,
        /// The most that it may be.
        farthest: f64,
    },
}

/// What a dome is described by; [`DomeScreen::new`] checks it.
#[derive(Debug, Clone, PartialEq)]
pub struct DomeDescription {
    /// For file names and messages.
    pub name: String,
    /// Of the sphere: metres, within [`DomeScreen::RADII`].
    pub radius: f64,
    /// Of the sphere: metres, in the room.
    pub centre: DVec3,
    /// How far the zenith leans from straight up (+Y) towards the front (−Z),
    /// about the room's +X: degrees, −360 to 360.
    pub tilt_degrees: f64,
    /// Across the dome, from rim to rim, at its centre: degrees, above 0 to 360.
    pub field_of_view_degrees: f64,
    /// Columns, and rows, 1 to [`Wall::MOST_PIXELS`].
    pub size: u32,
}

impl DomeScreen {
    /// Least and greatest radius: metres.
    pub const RADII: (f64, f64) = (
        frame::DomeScreen::RADII.0 as f64,
        frame::DomeScreen::RADII.1 as f64,
    );

    /// How far off, of the radius, a ray that starts on the sphere is past it:
    /// projectors may stand on the rim.
    const AT_THE_SURFACE: f64 = 1.0e-9;

    /// A dome that is known to be usable.
    ///
    /// # Errors
    /// The first fault found: a name that is not usable in a file name, a
    /// radius, centre, tilt, field of view or size that is out of its range.
    pub fn new(description: DomeDescription) -> Result<Self, DomeScreenError> {
        let DomeDescription {
            name,
            radius,
            centre,
            tilt_degrees,
            field_of_view_degrees,
            size,
        } = description;
        let fault = if let Some(reason) = name_fault(&name) {
            Some(DomeScreenError::Name {
                dome: name.clone(),
                reason,
            })
        } else {
            let dome = name.clone();
            let (least, most) = (Self::RADII.0 as f32, Self::RADII.1 as f32);
            // As the tracer has it, rounded.
            if !(least..=most).contains(&(radius as f32)) {
                Some(DomeScreenError::Radius { dome, radius })
            } else if !is_in_a_room(centre) {
                Some(DomeScreenError::Centre { dome, centre })
            } else if !(tilt_degrees.abs() <= 360.0) {
                let degrees = tilt_degrees;
                Some(DomeScreenError::Tilt { dome, degrees })
            } else if !(field_of_view_degrees > 0.0
                && field_of_view_degrees <= 360.0
                && field_of_view_degrees as f32 > 0.0)
            {
                let degrees = field_of_view_degrees;
                Some(DomeScreenError::FieldOfView { dome, degrees })
            } else if !(1..=Wall::MOST_PIXELS).contains(&size) {
                Some(DomeScreenError::Size { dome, size })
            } else {
                None
            }
        };
        match fault {
            Some(fault) => Err(fault),
            None => Ok(Self {
                name,
                radius,
                centre,
                field_of_view_degrees,
                size,
                axes: axes(tilt_degrees),
            }),
        }
    }

    /// For file names and messages.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Of the sphere: metres.
    pub const fn radius(&self) -> f64 {
        self.radius
    }

    /// Of the sphere: metres, in the room.
    pub const fn centre(&self) -> DVec3 {
        self.centre
    }

    /// Across the dome at its centre: radians, above 0 to 2π.
    pub const fn field_of_view(&self) -> f64 {
        self.field_of_view_degrees.to_radians()
    }

    /// Columns, and rows.
    pub const fn size(&self) -> u32 {
        self.size
    }

    /// From rim to rim along the dome: metres.
    pub const fn width(&self) -> f64 {
        self.radius * self.field_of_view()
    }

    /// The picture's right, its top, and what is behind it, against the zenith:
    /// the axes of [`shisen_core::capture`] in the room.
    pub const fn axes(&self) -> DMat3 {
        self.axes
    }

    /// The dome as the tracer takes it, for an eye at `eye`: metres, in the
    /// room.
    ///
    /// # Errors
    /// An eye that is not finite, or farther from the centre than
    /// [`frame::DomeScreen::FARTHEST_EYE`] of the radius.
    pub fn view_from(&self, eye: DVec3) -> Result<frame::DomeScreen, DomeScreenError> {
        let distance = eye.distance(self.centre);
        let farthest = f64::from(frame::DomeScreen::FARTHEST_EYE) * self.radius;
        if !(distance <= farthest) {
            return Err(DomeScreenError::Eye {
                dome: self.name.clone(),
                eye,
                distance,
                farthest,
            });
        }
        let (least, most) = frame::DomeScreen::RADII;
        Ok(frame::DomeScreen {
            pose: frame::DomePose {
                position: self.centre.as_vec3(),
                room_from_capture: self.axes.as_mat3(),
            },
            radius: (self.radius as f32).clamp(least, most),
            // 360 degrees round to a little more than 2π.
            field_of_view: (self.field_of_view() as f32).min(TAU as f32),
        })
    }

    /// The place on the dome, metres in the room, of (u, v) in the unit disc: u
    /// to the right of the picture and v to its top.
    pub fn point(&self, at: DVec2) -> DVec3 {
        let from_centre = at.length();
        let (sin, cos) = libm::sincos(0.5 * self.field_of_view() * from_centre);
        let outwards = at.normalize_or_zero() * sin;
        self.centre + self.radius * (self.axes * outwards.extend(-cos))
    }

    /// Where in the picture a place is, seen from the centre: (u, v), in the
    /// unit disc where it is on the dome. `None` for the centre itself.
    pub fn place(&self, point: DVec3) -> Option<DVec2> {
        let direction = self.axes.transpose() * (point - self.centre).try_normalize()?;
        let across = direction.truncate();
        let angle = libm::atan2(across.length(), -direction.z);
        // Straight away from the zenith all ways are the same; take one.
        let way = across.try_normalize().unwrap_or(DVec2::X);
        Some(way * (angle / (0.5 * self.field_of_view())))
    }

    /// Where a ray comes to the sphere from outside and where it leaves it: in
    /// the ray's own length, of unit `direction`.
    fn crossings(&self, origin: DVec3, direction: DVec3) -> Option<[f64; 2]> {
        let from = origin - self.centre;
        let half = from.dot(direction);
        // By the distance of the line, which loses no digits far away.
        let nearest = from - half * direction;
        let left = self.radius * self.radius - nearest.length_squared();
        (left >= 0.0).then(|| [-half - left.sqrt(), -half + left.sqrt()])
    }

    /// How far off the first part of the dome is that a ray meets, from either
    /// side, and where in the picture: (u, v). `direction` is of unit length.
    pub fn meet(&self, origin: DVec3, direction: DVec3) -> Option<(f64, DVec2)> {
        self.on_screen(origin, direction).map(|(t, at, _)| (t, at))
    }

    /// Where in the picture light arrives on the inside that starts at `origin`
    /// along the unit `direction`: (u, v). It may come in through what the
    /// field of view leaves open, but not through the dome itself.
    pub fn lit(&self, origin: DVec3, direction: DVec3) -> Option<DVec2> {
        let (_, at, from_inside) = self.on_screen(origin, direction)?;
        from_inside.then_some(at)
    }

    /// The first part of the dome that a ray meets: how far off, where, and
    /// whether on the inside.
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

/// The picture's right, its top, and what is behind it.
fn axes(tilt_degrees: f64) -> DMat3 {
    let (sin, cos) = sin_cos_degrees(tilt_degrees);
    let zenith = DVec3::new(0.0, cos, -sin);
    let top = DVec3::new(0.0, sin, cos);
    DMat3::from_cols(DVec3::X, top, -zenith)
}
