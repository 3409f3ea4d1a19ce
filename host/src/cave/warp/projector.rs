//! Projectors, and the TOML files that describe them.

use crate::cave::RoomError;
use crate::cave::angle::sin_cos_degrees;
use crate::files::description::{FileError, Located, Source, read_description};
use glam::{DMat3, DVec2, DVec3};
use serde::Deserialize;
use std::path::Path;

/// A projector: a pinhole with lens shift, at a place in the room.
#[derive(Debug, Clone, PartialEq)]
pub struct Projector {
    /// For file names and messages.
    pub name: String,
    /// Metres, in the room.
    pub position: DVec3,
    /// To the picture's right, to its top, and against its light.
    pub axes: DMat3,
    /// The picture's left, right, lower and upper edge at distance 1, to the
    /// right and upwards from straight ahead.
    pub edges: [f64; 4],
    /// Columns and rows.
    pub resolution: [u32; 2],
}

const SYNTAX: &str = "a projector has name, position ([x, y, z] in metres), look ([x, y, z]) and, \
    if wanted, up, or else yaw_degrees, pitch_degrees and roll_degrees, horizontal_degrees or \
    throw, resolution ([columns, rows]) and, if wanted, vertical_degrees and lens_shift ([widths, \
    heights])";

impl Projector {
    /// Towards a point of the picture, 0 to 1 to the right and downwards from
    /// its upper left corner: of unit length.
    pub fn direction(&self, at: DVec2) -> DVec3 {
        let [left, right, down, up] = self.edges;
        let x = left + at.x * (right - left);
        let y = up + at.y * (down - up);
        (self.axes * DVec3::new(x, y, -1.0)).normalize()
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

    /// Reads a projector from a file.
    ///
    /// # Errors
    /// A file that cannot be read, or as [`Self::from_toml`].
    pub fn load(path: &Path) -> Result<Self, FileError<RoomError>> {
        let help = "give the path of a TOML file of a projector";
        let text = read_description(path, "the projector", help)?;
        Ok(Self::from_toml(&text, &path.to_string_lossy())?)
    }

    /// Returns a projector from the text of a file; `name` is what messages call it.
    ///
    /// ```toml
    /// name = "back"
    /// position = [0, -1.2, 2]         # metres, in the room
    /// look = [0, 0.6, -1]             # or yaw_degrees, pitch_degrees, roll_degrees
    /// up = [0, 1, 0]                  # optional
    /// horizontal_degrees = 60         # or throw, the distance by the width
    /// vertical_degrees = 40           # optional: square pixels
    /// lens_shift = [0, 0.5]           # optional: widths right, heights up
    /// resolution = [1920, 1200]
    /// ```
    ///
    /// # Errors
    /// The first fault and its place: text that is not TOML, unknown or missing keys, keys that
    /// exclude each other, a value out of its range.
    pub fn from_toml(text: &str, name: &str) -> Result<Self, Located<RoomError>> {
        let source = Source { name, text };
        let entry: Entry =
            source.parse(SYNTAX, |message, help| RoomError::new("", message, help))?;
        entry.projector().map_err(|fault| {
            // Without `up` in the file, `look` is along the room's up.
            let look = (fault.key == "up").then_some("look");
            let keys = [fault.key, look.unwrap_or_default()];
            let span = keys.into_iter().find_map(|key| source.span_of(None, key));
            Located::new(fault, &source, span)
        })
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Entry {
    name: String,
    position: [f64; 3],
    look: Option<[f64; 3]>,
    up: Option<[f64; 3]>,
    yaw_degrees: Option<f64>,
    pitch_degrees: Option<f64>,
    roll_degrees: Option<f64>,
    horizontal_degrees: Option<f64>,
    throw: Option<f64>,
    vertical_degrees: Option<f64>,
    lens_shift: Option<[f64; 2]>,
    resolution: [u32; 2],
}

impl Entry {
    fn projector(self) -> Result<Projector, RoomError> {
        let (axes, across) = (self.axes()?, self.half_width()?);
        let named = "files are named after projectors";
        RoomError::check_name("projector", &self.name, named, "left")?;
        let position = self.position.into();
        RoomError::check_place("position", format_args!("the projector is"), position)?;
        let resolution = self.resolution;
        RoomError::check_pixels("resolution", format_args!("the projector"), resolution)?;
        Ok(Projector {
            edges: self.edges(across)?,
            name: self.name,
            position,
            axes,
            resolution,
        })
    }

    fn edges(&self, across: f64) -> Result<[f64; 4], RoomError> {
        let [columns, rows] = self.resolution.map(f64::from);
        let upwards = match self.vertical_degrees {
            Some(degrees) => tangent("vertical_degrees", "vertical", degrees)?,
            None => across * rows / columns,
        };
        let [right, up] = self.lens_shift.unwrap_or_default();
        if ![right, up].iter().all(|part| part.abs() <= 2.0) {
            return Err(RoomError::new(
                "lens_shift",
                format!("the projector's lens is shifted by {right}, {up}"),
                "give picture widths and heights from -2 to 2, such as [0, 0.5]",
            ));
        }
        Ok([
            across * (2.0 * right - 1.0),
            across * (2.0 * right + 1.0),
            upwards * (2.0 * up - 1.0),
            upwards * (2.0 * up + 1.0),
        ])
    }

    /// To the picture's right, to its top, and against its light: along `look`, with the part of
    /// `up` that is square to it upwards, or level to the front (−Z), then turned to the right,
    /// upwards, and clockwise as it looks.
    fn axes(&self) -> Result<DMat3, RoomError> {
        let choice = |key, found| {
            RoomError::new(
                key,
                format!("{found} of look and up, and yaw_degrees, pitch_degrees and roll_degrees"),
                "give look, with up if wanted, or any of yaw_degrees, pitch_degrees and \
                 roll_degrees",
            )
        };
        let angles = [
            ("yaw_degrees", "yaw", self.yaw_degrees),
            ("pitch_degrees", "pitch", self.pitch_degrees),
            ("roll_degrees", "roll", self.roll_degrees),
        ];
        let turned = angles.iter().find(|(.., angle)| angle.is_some());
        match (self.look, turned) {
            (look, Some((key, ..))) if look.or(self.up).is_some() => Err(choice(key, "both")),
            (Some(look), _) => looking(look.into(), self.up.map_or(DVec3::Y, DVec3::from_array)),
            (None, None) => Err(choice("", "none")),
            (None, Some(_)) => {
                for (key, name, angle) in angles {
                    let degrees = angle.unwrap_or(0.0);
                    if !(degrees.abs() <= 360.0) {
                        let message = format!("the projector's {name} is {degrees}°");
                        let help = "give degrees from -360 to 360";
                        return Err(RoomError::new(key, message, help));
                    }
                }
                // Sines and cosines of yaw, pitch and roll.
                let turns = angles.map(|(.., angle)| sin_cos_degrees(angle.unwrap_or(0.0)));
                let [(sy, cy), (sp, cp), (sr, cr)] = turns;
                let ahead = DVec3::new(sy * cp, sp, -cy * cp);
                let level = DVec3::new(cy, 0.0, sy);
                let above = level.cross(ahead);
                let (right, up) = (cr * level - sr * above, cr * above + sr * level);
                Ok(DMat3::from_cols(right, up, -ahead))
            }
        }
    }

    fn half_width(&self) -> Result<f64, RoomError> {
        let choice = |key, found| {
            RoomError::new(
                key,
                format!("{found} of horizontal_degrees and throw"),
                "give horizontal_degrees, the field of view, or throw, the distance by the width",
            )
        };
        match (self.horizontal_degrees, self.throw) {
            (Some(degrees), None) => tangent("horizontal_degrees", "horizontal", degrees),
            (None, Some(ratio)) if (0.01..=100.0).contains(&ratio) => Ok(0.5 / ratio),
            (None, Some(ratio)) => Err(RoomError::new(
                "throw",
                format!("the projector's throw is {ratio}"),
                "give the distance by the picture's width, from 0.01 to 100",
            )),
            (Some(_), Some(_)) => Err(choice("throw", "both")),
            (None, None) => Err(choice("", "none")),
        }
    }
}

/// Returns the tangent of half a field of view, in degrees.
fn tangent(key: &'static str, direction: &str, degrees: f64) -> Result<f64, RoomError> {
    if (1.0..=179.0).contains(&degrees) {
        return Ok(libm::tan(0.5 * degrees.to_radians()));
    }
    let message = format!("the projector's {direction} field of view is {degrees}°");
    Err(RoomError::new(key, message, "give degrees from 1 to 179"))
}

/// Returns the axes of a projector that looks along a direction.
fn looking(look: DVec3, up: DVec3) -> Result<DMat3, RoomError> {
    let DVec3 { x, y, z } = look;
    let Some(ahead) = look.try_normalize() else {
        return Err(RoomError::new(
            "look",
            format!("the projector looks along {x}, {y}, {z}"),
            "give three numbers of which at least one is not 0, such as [0, 0, -1]",
        ));
    };
    let right = ahead.cross(up.normalize_or_zero());
    if !(right.length() >= 1.0e-6) {
        let DVec3 { x, y, z } = up;
        return Err(RoomError::new(
            "up",
            format!("what is up for the projector is {x}, {y}, {z}"),
            "give a direction that is not along where it looks",
        ));
    }
    let right = right.normalize();
    Ok(DMat3::from_cols(right, right.cross(ahead), -ahead))
}
