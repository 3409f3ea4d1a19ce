//! Projectors, and their TOML.

use crate::cave::angle::sin_cos_degrees;
use crate::cave::{Wall, is_in_a_room, name_fault};
use crate::files::description::{Located, Source};
use glam::{DMat3, DVec2, DVec3};
use miette::Diagnostic;
use serde::Deserialize;
use std::ops::Range;
use std::path::{Path, PathBuf};
use thiserror::Error;
use toml::Spanned;

/// A pinhole that throws a picture.
#[derive(Debug, Clone, PartialEq)]
pub struct Projector {
    name: String,
    position: DVec3,
    /// To the picture's right, to its top, and against its light.
    axes: DMat3,
    /// The picture's left, right, lower and upper edge at distance 1.
    edges: [f64; 4],
    resolution: [u32; 2],
}

/// Which way a projector points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Aim {
    /// Along a direction, with another upwards in the picture as far as that is
    /// square to it; of any length but zero.
    Look {
        /// Where it points.
        look: DVec3,
        /// What is up.
        up: DVec3,
    },
    /// Level to the front (−Z), then turned: degrees, −360 to 360.
    Angles {
        /// To the right.
        yaw: f64,
        /// Then upwards.
        pitch: f64,
        /// Then clockwise as it looks.
        roll: f64,
    },
}

/// How wide a picture is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Throw {
    /// Between its left and right edge without lens shift: degrees, 1 to 179.
    Degrees(f64),
    /// Distance by width, 0.01 to 100.
    Ratio(f64),
}

/// What a projector's lens does.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lens {
    /// Across.
    pub throw: Throw,
    /// Between the lower and upper edge without lens shift: degrees, 1 to 179.
    /// `None` for square pixels.
    pub vertical_degrees: Option<f64>,
    /// How far the picture is moved to the right and upwards: in its widths and
    /// heights, −2 to 2 each.
    pub shift: DVec2,
}

/// Why there is no such projector.
#[derive(Debug, Clone, PartialEq, Error, Diagnostic)]
#[non_exhaustive]
pub enum ProjectorError {
    /// A name that cannot be part of a file's name.
    #[error("the projector name \"{}\" {reason}", .name.escape_debug())]
    #[diagnostic(help(
        "files are named after projectors: use letters, digits, '-' and '_', such as \"left\""
    ))]
    Name {
        /// The name.
        name: String,
        /// What is wrong with it.
        reason: &'static str,
    },
    /// A position that is not a place in a room.
    #[error("the projector is at {}, {}, {}", .position.x, .position.y, .position.z)]
    #[diagnostic(help("coordinates are metres from -{limit} to {limit}", limit = Wall::FARTHEST))]
    Position {
        /// Metres, in the room.
        position: DVec3,
    },
    /// A direction that points nowhere.
    #[error("the projector looks along {}, {}, {}", .look.x, .look.y, .look.z)]
    #[diagnostic(help("give three numbers of which at least one is not 0, such as [0, 0, -1]"))]
    Look {
        /// The direction.
        look: DVec3,
    },
    /// An up that does not say which way up the picture is.
    #[error("what is up for the projector is {}, {}, {}", .up.x, .up.y, .up.z)]
    #[diagnostic(help("give a direction that is not along where it looks"))]
    Up {
        /// The direction.
        up: DVec3,
    },
    /// An angle that is none.
    #[error("the projector's {angle} is {degrees}°")]
    #[diagnostic(help("give degrees from -360 to 360"))]
    Angle {
        /// "yaw", "pitch" or "roll".
        angle: &'static str,
        /// Degrees.
        degrees: f64,
    },
    /// A field of view that no lens has.
    #[error("the projector's {direction} field of view is {degrees}°")]
    #[diagnostic(help("give degrees from 1 to 179"))]
    FieldOfView {
        /// "horizontal" or "vertical".
        direction: &'static str,
        /// Degrees.
        degrees: f64,
    },
    /// A throw ratio that no lens has.
    #[error("the projector's throw is {ratio}")]
    #[diagnostic(help("give the distance by the picture's width, from 0.01 to 100"))]
    Throw {
        /// Distance by width.
        ratio: f64,
    },
    /// A lens shift that no lens has.
    #[error("the projector's lens is shifted by {}, {}", .shift.x, .shift.y)]
    #[diagnostic(help("give picture widths and heights from -2 to 2, such as [0, 0.5]"))]
    Shift {
        /// To the right and upwards, in widths and heights.
        shift: DVec2,
    },
    /// Too few or too many pixels.
    #[error("the projector has {} × {} pixels", .resolution[0], .resolution[1])]
    #[diagnostic(help("each side has 1 to {limit} pixels", limit = Wall::MOST_PIXELS))]
    Resolution {
        /// Columns and rows.
        resolution: [u32; 2],
    },
}

/// What is wrong in a projector's file.
#[derive(Debug, Clone, PartialEq, Error, Diagnostic)]
#[non_exhaustive]
pub enum ProjectorFault {
    /// Not TOML, or not the keys and types that a projector has.
    #[error("{message}")]
    #[diagnostic(help(
        "a projector has name, position ([x, y, z] in metres), look ([x, y, z]) and, if wanted, up, or else yaw_degrees, pitch_degrees and roll_degrees, horizontal_degrees or throw, resolution ([columns, rows]) and, if wanted, vertical_degrees and lens_shift ([widths, heights])"
    ))]
    Syntax {
        /// The TOML reader's message.
        message: String,
    },
    /// Keys of which one is needed and one only may be there.
    #[error("{found} of {keys}")]
    #[diagnostic(help("give {help}"))]
    Choice {
        /// "none" or "both".
        found: &'static str,
        /// Which keys.
        keys: &'static str,
        /// What to give.
        help: &'static str,
    },
    /// A projector that there is not.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Projector(#[from] ProjectorError),
}

/// Why a projector could not be had from a file.
#[derive(Debug, Error, Diagnostic)]
#[non_exhaustive]
pub enum ProjectorFileError {
    /// The file could not be read.
    #[error("cannot read the projector in {}", .path.display())]
    #[diagnostic(help("give the path of a TOML file of a projector"))]
    Read {
        /// Which file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// It was read, and there is a fault in it.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Fault(#[from] Located<ProjectorFault>),
}

impl Projector {
    /// A projector that is known to be usable.
    ///
    /// `name` is for file names and messages, `position` in metres in the room,
    /// `resolution` columns and rows, 1 to [`Wall::MOST_PIXELS`] each.
    ///
    /// # Errors
    /// The first fault found: see [`ProjectorError`].
    pub fn new(
        name: impl Into<String>,
        position: DVec3,
        aim: Aim,
        lens: Lens,
        resolution: [u32; 2],
    ) -> Result<Self, ProjectorError> {
        let name = name.into();
        if let Some(reason) = name_fault(&name) {
            return Err(ProjectorError::Name { name, reason });
        }
        if !is_in_a_room(position) {
            return Err(ProjectorError::Position { position });
        }
        let axes = aim.axes()?;
        if !resolution
            .iter()
            .all(|side| (1..=Wall::MOST_PIXELS).contains(side))
        {
            return Err(ProjectorError::Resolution { resolution });
        }
        Ok(Self {
            name,
            position,
            axes,
            edges: lens.edges(resolution)?,
            resolution,
        })
    }

    /// For file names and messages.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Metres, in the room.
    pub const fn position(&self) -> DVec3 {
        self.position
    }

    /// Columns and rows.
    pub const fn resolution(&self) -> [u32; 2] {
        self.resolution
    }

    /// To the picture's right, to its top, and against its light.
    pub const fn axes(&self) -> DMat3 {
        self.axes
    }

    /// The picture's left, right, lower and upper edge at distance 1, to the
    /// right and upwards from straight ahead.
    pub const fn edges(&self) -> [f64; 4] {
        self.edges
    }

    /// Towards a point of the picture, 0 to 1 to the right and downwards from
    /// its upper left corner: of unit length.
    pub fn direction(&self, at: DVec2) -> DVec3 {
        let [left, right, down, up] = self.edges;
        let x = left + at.x * (right - left);
        let y = up + at.y * (down - up);
        (self.axes * DVec3::new(x, y, -1.0)).normalize()
    }

    /// Yaw, pitch and roll of [`Aim::Angles`]: radians. Straight up and down the
    /// roll is 0.
    pub fn angles(&self) -> [f64; 3] {
        let (right, up, ahead) = (self.axes.x_axis, self.axes.y_axis, -self.axes.z_axis);
        let level = libm::hypot(ahead.x, ahead.z);
        let pitch = libm::atan2(ahead.y, level);
        if level < 1.0e-9 {
            return [libm::atan2(right.z, right.x), pitch, 0.0];
        }
        let yaw = libm::atan2(ahead.x, -ahead.z);
        // How high the right and the top are of what could be highest.
        [yaw, pitch, libm::atan2(-right.y, up.y)]
    }

    /// Reads a projector from a file.
    ///
    /// # Errors
    /// A file that cannot be read, or as [`Self::from_toml`].
    pub fn load(path: &Path) -> Result<Self, ProjectorFileError> {
        let text = crate::files::read_text(path).map_err(|source| ProjectorFileError::Read {
            path: path.to_owned(),
            source,
        })?;
        Ok(Self::from_toml(&text, &path.to_string_lossy())?)
    }

    /// A projector from the text of a file; `source_name` is what messages call
    /// it.
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
    /// The first fault found and its place: text that is not TOML, unknown or
    /// missing keys, keys that exclude each other, what [`Self::new`] rejects.
    pub fn from_toml(text: &str, source_name: &str) -> Result<Self, Located<ProjectorFault>> {
        let source = Source {
            name: source_name,
            text,
        };
        let entry: Entry = source.parse(|message| ProjectorFault::Syntax { message })?;
        let made = entry.aim().and_then(|aim| {
            let throw = entry.throw()?;
            let lens = Lens {
                throw,
                vertical_degrees: entry.vertical_degrees.as_ref().map(|v| *v.as_ref()),
                shift: entry
                    .lens_shift
                    .as_ref()
                    .map_or(DVec2::ZERO, |shift| DVec2::from_array(*shift.as_ref())),
            };
            let position = DVec3::from_array(*entry.position.as_ref());
            let name = entry.name.as_ref().clone();
            Ok(Self::new(
                name,
                position,
                aim,
                lens,
                *entry.resolution.as_ref(),
            )?)
        });
        made.map_err(|fault| {
            let span = entry.span_of(&fault);
            Located::new(fault, &source, span)
        })
    }
}

impl Aim {
    /// To the picture's right, to its top, and against its light.
    fn axes(self) -> Result<DMat3, ProjectorError> {
        match self {
            Self::Look { look, up } => {
                let ahead = look.try_normalize().ok_or(ProjectorError::Look { look })?;
                let right = ahead.cross(up.normalize_or_zero());
                if !(right.length() >= 1.0e-6) {
                    return Err(ProjectorError::Up { up });
                }
                let right = right.normalize();
                Ok(DMat3::from_cols(right, right.cross(ahead), -ahead))
            }
            Self::Angles { yaw, pitch, roll } => {
                for (angle, degrees) in [("yaw", yaw), ("pitch", pitch), ("roll", roll)] {
                    if !(degrees.abs() <= 360.0) {
                        return Err(ProjectorError::Angle { angle, degrees });
                    }
                }
                let (sin_yaw, cos_yaw) = sin_cos_degrees(yaw);
                let (sin_pitch, cos_pitch) = sin_cos_degrees(pitch);
                let (sin_roll, cos_roll) = sin_cos_degrees(roll);
                let ahead = DVec3::new(sin_yaw * cos_pitch, sin_pitch, -cos_yaw * cos_pitch);
                let level = DVec3::new(cos_yaw, 0.0, sin_yaw);
                let above = level.cross(ahead);
                Ok(DMat3::from_cols(
                    cos_roll * level - sin_roll * above,
                    cos_roll * above + sin_roll * level,
                    -ahead,
                ))
            }
        }
    }
}

impl Lens {
    /// The picture's left, right, lower and upper edge at distance 1.
    fn edges(self, resolution: [u32; 2]) -> Result<[f64; 4], ProjectorError> {
        let tangent = |direction, degrees: f64| {
            if (1.0..=179.0).contains(&degrees) {
                Ok(libm::tan(0.5 * degrees.to_radians()))
            } else {
                Err(ProjectorError::FieldOfView { direction, degrees })
            }
        };
        let across = match self.throw {
            Throw::Degrees(degrees) => tangent("horizontal", degrees)?,
            Throw::Ratio(ratio) if (0.01..=100.0).contains(&ratio) => 0.5 / ratio,
            Throw::Ratio(ratio) => return Err(ProjectorError::Throw { ratio }),
        };
        let [columns, rows] = resolution.map(f64::from);
        let upwards = match self.vertical_degrees {
            Some(degrees) => tangent("vertical", degrees)?,
            None => across * rows / columns,
        };
        let shift = self.shift;
        if !shift.to_array().iter().all(|part| part.abs() <= 2.0) {
            return Err(ProjectorError::Shift { shift });
        }
        Ok([
            across * (2.0 * shift.x - 1.0),
            across * (2.0 * shift.x + 1.0),
            upwards * (2.0 * shift.y - 1.0),
            upwards * (2.0 * shift.y + 1.0),
        ])
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Entry {
    name: Spanned<String>,
    position: Spanned<[f64; 3]>,
    look: Option<Spanned<[f64; 3]>>,
    up: Option<Spanned<[f64; 3]>>,
    yaw_degrees: Option<Spanned<f64>>,
    pitch_degrees: Option<Spanned<f64>>,
    roll_degrees: Option<Spanned<f64>>,
    horizontal_degrees: Option<Spanned<f64>>,
    throw: Option<Spanned<f64>>,
    vertical_degrees: Option<Spanned<f64>>,
    lens_shift: Option<Spanned<[f64; 2]>>,
    resolution: Spanned<[u32; 2]>,
}

impl Entry {
    /// The angles that are there.
    fn angles(&self) -> [&Option<Spanned<f64>>; 3] {
        [&self.yaw_degrees, &self.pitch_degrees, &self.roll_degrees]
    }

    fn aim(&self) -> Result<Aim, ProjectorFault> {
        let choice = |found| ProjectorFault::Choice {
            found,
            keys: "look and up, and yaw_degrees, pitch_degrees and roll_degrees",
            help: "look, with up if wanted, or any of yaw_degrees, pitch_degrees and roll_degrees",
        };
        let turned = self.angles().iter().any(|angle| angle.is_some());
        let looks = self.look.is_some() || self.up.is_some();
        match (&self.look, turned) {
            (_, true) if looks => Err(choice("both")),
            (Some(look), _) => Ok(Aim::Look {
                look: DVec3::from_array(*look.as_ref()),
                up: self
                    .up
                    .as_ref()
                    .map_or(DVec3::Y, |up| DVec3::from_array(*up.as_ref())),
            }),
            (None, true) => {
                let [yaw, pitch, roll] = self
                    .angles()
                    .map(|angle| angle.as_ref().map_or(0.0, |angle| *angle.as_ref()));
                Ok(Aim::Angles { yaw, pitch, roll })
            }
            (None, false) => Err(choice("none")),
        }
    }

    fn throw(&self) -> Result<Throw, ProjectorFault> {
        let choice = |found| ProjectorFault::Choice {
            found,
            keys: "horizontal_degrees and throw",
            help: "horizontal_degrees, the field of view, or throw, the distance by the width",
        };
        match (&self.horizontal_degrees, &self.throw) {
            (Some(degrees), None) => Ok(Throw::Degrees(*degrees.as_ref())),
            (None, Some(ratio)) => Ok(Throw::Ratio(*ratio.as_ref())),
            (Some(_), Some(_)) => Err(choice("both")),
            (None, None) => Err(choice("none")),
        }
    }

    /// The bytes of the value that a fault is about; `None` where it is about
    /// one that is missing.
    fn span_of(&self, fault: &ProjectorFault) -> Option<Range<usize>> {
        let number = |value: &Option<Spanned<f64>>| value.as_ref().map(Spanned::span);
        let ProjectorFault::Projector(fault) = fault else {
            let first = self.angles().into_iter().find_map(number);
            let both = self.throw.is_some() && self.horizontal_degrees.is_some();
            return if both { number(&self.throw) } else { first };
        };
        match fault {
            ProjectorError::Name { .. } => Some(self.name.span()),
            ProjectorError::Position { .. } => Some(self.position.span()),
            ProjectorError::Look { .. } => self.look.as_ref().map(Spanned::span),
            // Without one of its own, what is up is up in the room.
            ProjectorError::Up { .. } => self.up.as_ref().or(self.look.as_ref()).map(Spanned::span),
            ProjectorError::Angle { angle, .. } => match *angle {
                "yaw" => number(&self.yaw_degrees),
                "pitch" => number(&self.pitch_degrees),
                _ => number(&self.roll_degrees),
            },
            ProjectorError::FieldOfView { direction, .. } => match *direction {
                "horizontal" => number(&self.horizontal_degrees),
                _ => number(&self.vertical_degrees),
            },
            ProjectorError::Throw { .. } => number(&self.throw),
            ProjectorError::Shift { .. } => self.lens_shift.as_ref().map(Spanned::span),
            ProjectorError::Resolution { .. } => Some(self.resolution.span()),
        }
    }
}
