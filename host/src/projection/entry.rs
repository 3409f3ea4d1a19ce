//! The TOML of projectors: a file of one, or `[[projector]]` of a room's.

use super::homography::Homography;
use super::mesh::Mesh;
use super::projector::{Lens, Placement, Projector};
use super::transfer::Transfer;
use crate::cave::angle::sin_cos_degrees;
use crate::cave::{Eye, RoomError};
use crate::files::description::{FileError, Located, Source, read_description};
use glam::{DMat3, DVec2, DVec3};
use serde::Deserialize;
use std::path::Path;
use std::sync::Arc;

/// The keys of a projector, for messages.
pub(crate) const SYNTAX: &str = "a projector has name, resolution ([columns, rows]) and one of: \
    position ([x, y, z] in metres) with look ([x, y, z]) and, if wanted, up, or else yaw_degrees, \
    pitch_degrees and roll_degrees, and with horizontal_degrees or throw and, if wanted, \
    vertical_degrees and lens_shift ([widths, heights]); corner_pins ([[[x, y], [s, t]], …]); mesh \
    (a file); part ([left, top, right, bottom]); and, if wanted, screen, eye, gamma, black, gain \
    and blend";

impl Projector {
    /// Reads a projector from a file.
    ///
    /// # Errors
    /// A file that cannot be read, or as [`Self::from_toml`].
    pub fn load(path: &Path) -> Result<Self, FileError<RoomError>> {
        let help = "give the path of a TOML file of a projector";
        let text = read_description(path, "the projector", help)?;
        Ok(Self::from_toml(&text, &path.to_string_lossy())?)
    }

    /// Returns a projector from the text of a file with the keys of a room file's `[[projector]]`
    /// ([`Cave::from_toml`](crate::cave::Cave::from_toml)); `name` is what messages call it, and
    /// where a mesh's path starts.
    ///
    /// # Errors
    /// The first fault and its place: text that is not TOML, unknown or missing keys, keys that
    /// exclude each other, a value out of its range, a mesh that cannot be read.
    pub fn from_toml(text: &str, name: &str) -> Result<Self, Located<RoomError>> {
        let source = Source { name, text };
        let entry: ProjectorEntry =
            source.parse(SYNTAX, |message, help| RoomError::new("", message, help))?;
        let projector = entry.projector(source.folder());
        projector.map_err(|fault| fault_at(fault, &source, None))
    }
}

/// Points a projector's fault at its key: in the top table of the text, or in an entry of a list.
pub(crate) fn fault_at(
    fault: RoomError,
    source: &Source<'_>,
    list: Option<(&str, usize)>,
) -> Located<RoomError> {
    // Without `up` in the file, `look` is along the room's up.
    let look = (fault.key == "up").then_some("look");
    let name = list.map(|_| "name");
    let keys = [
        fault.key,
        look.unwrap_or_default(),
        name.unwrap_or_default(),
    ];
    let span = keys.into_iter().find_map(|key| source.span_of(list, key));
    Located::new(fault, source, span)
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ProjectorEntry {
    name: String,
    screen: Option<String>,
    eye: Option<EyeEntry>,
    position: Option<[f64; 3]>,
    look: Option<[f64; 3]>,
    up: Option<[f64; 3]>,
    yaw_degrees: Option<f64>,
    pitch_degrees: Option<f64>,
    roll_degrees: Option<f64>,
    horizontal_degrees: Option<f64>,
    throw: Option<f64>,
    vertical_degrees: Option<f64>,
    lens_shift: Option<[f64; 2]>,
    corner_pins: Option<Vec<[[f64; 2]; 2]>>,
    mesh: Option<String>,
    part: Option<[f64; 4]>,
    resolution: [u32; 2],
    gamma: Option<GammaEntry>,
    black: Option<f64>,
    gain: Option<GainEntry>,
    blend: Option<f64>,
}

#[derive(Deserialize, Clone, Copy)]
#[serde(rename_all = "lowercase")]
enum EyeEntry {
    Left,
    Right,
}

#[derive(Deserialize)]
#[serde(
    untagged,
    expecting = "`gamma` must be a number, \"srgb\", a list of lights from 0 to 1, or a table of \
                 these for red, green and blue"
)]
enum GammaEntry {
    All(ChannelEntry),
    Each {
        red: ChannelEntry,
        green: ChannelEntry,
        blue: ChannelEntry,
    },
}

#[derive(Deserialize, Clone)]
#[serde(untagged)]
enum ChannelEntry {
    Number(f64),
    Name(String),
    Curve(Vec<f64>),
}

#[derive(Deserialize)]
#[serde(
    untagged,
    expecting = "`gain` must be a number, or three: of red, green and blue"
)]
enum GainEntry {
    All(f64),
    Each([f64; 3]),
}

impl ProjectorEntry {
    /// Returns the projector; a mesh's path starts at `folder`.
    pub(crate) fn projector(self, folder: &Path) -> Result<Projector, RoomError> {
        let named = "files are named after projectors";
        RoomError::check_name("projector", &self.name, named, "left")?;
        let resolution = self.resolution;
        RoomError::check_pixels("resolution", format_args!("the projector"), resolution)?;
        let gamma = self
            .gamma
            .as_ref()
            .map_or(Ok(DEFAULT_GAMMA), GammaEntry::transfers)?;
        let placement = self.placement(folder)?;
        Ok(Projector {
            placement,
            gamma,
            black: within(
                "black",
                self.black.unwrap_or(0.0),
                [0.0, Projector::MOST_BLACK],
            )?,
            gain: self.gain()?,
            blend: within("blend", self.blend.unwrap_or(1.0), Projector::BLENDS)?,
            name: self.name,
            screen: self.screen,
            eye: self.eye.map(|eye| match eye {
                EyeEntry::Left => Eye::Left,
                EyeEntry::Right => Eye::Right,
            }),
            resolution,
        })
    }

    fn gain(&self) -> Result<[f64; 3], RoomError> {
        let gain = match self.gain {
            None => [1.0; 3],
            Some(GainEntry::All(gain)) => [gain; 3],
            Some(GainEntry::Each(gains)) => gains,
        };
        for gain in gain {
            within("gain", gain, [1.0e-3, 1.0])?;
        }
        Ok(gain)
    }

    fn placement(&self, folder: &Path) -> Result<Placement, RoomError> {
        let of_lens = [
            ("look", self.look.is_some()),
            ("up", self.up.is_some()),
            ("yaw_degrees", self.yaw_degrees.is_some()),
            ("pitch_degrees", self.pitch_degrees.is_some()),
            ("roll_degrees", self.roll_degrees.is_some()),
            ("horizontal_degrees", self.horizontal_degrees.is_some()),
            ("throw", self.throw.is_some()),
            ("vertical_degrees", self.vertical_degrees.is_some()),
            ("lens_shift", self.lens_shift.is_some()),
        ];
        let ways = [
            ("position", self.position.is_some()),
            ("corner_pins", self.corner_pins.is_some()),
            ("mesh", self.mesh.is_some()),
            ("part", self.part.is_some()),
        ];
        let help = "give one of position (with look and horizontal_degrees or throw), corner_pins, \
                    mesh, and part ([0, 0, 1, 1] is the whole screen)";
        let mut given = ways.into_iter().filter(|(_, is_given)| *is_given);
        let Some((way, _)) = given.next() else {
            let message = "none of position, corner_pins, mesh and part".to_owned();
            return Err(RoomError::new("", message, help));
        };
        if let Some((other, _)) = given.next() {
            return Err(RoomError::new(
                other,
                format!("both of {way} and {other}"),
                help,
            ));
        }
        let stray = of_lens.into_iter().find(|(_, is_given)| *is_given);
        if let (None, Some((key, _))) = (self.position, stray) {
            let message = format!("`{key}` is for projectors with a position, not with {way}");
            return Err(RoomError::new(key, message, help));
        }
        if let Some(position) = self.position {
            return self.lens(position.into()).map(Placement::Lens);
        }
        if let Some(pins) = &self.corner_pins {
            return self.pinned(pins).map(Placement::Flat);
        }
        if let Some(mesh) = &self.mesh {
            let mesh = Mesh::load(&folder.join(mesh), &self.name, self.resolution)?;
            return Ok(Placement::Mesh(Arc::new(mesh)));
        }
        let part = self.part.unwrap_or_default();
        let [left, top, right, bottom] = part;
        let is_inside = part.iter().all(|edge| (0.0..=1.0).contains(edge));
        let flat = Homography::of_part(part);
        let flat = flat.filter(|_| is_inside && left < right && top < bottom);
        flat.map(Placement::Flat).ok_or_else(|| {
            RoomError::new(
                "part",
                format!("the projector's part is {left}, {top}, {right}, {bottom}"),
                "give left, top, right and bottom from 0 to 1, from the upper left corner of the \
                 screen's picture",
            )
        })
    }

    fn lens(&self, position: DVec3) -> Result<Lens, RoomError> {
        let (axes, across) = (self.axes()?, self.half_width()?);
        RoomError::check_place("position", format_args!("the projector is"), position)?;
        Ok(Lens {
            position,
            axes,
            edges: self.edges(across)?,
        })
    }

    fn pinned(&self, pins: &[[[f64; 2]; 2]]) -> Result<Homography, RoomError> {
        let pixels = DVec2::from(self.resolution.map(f64::from));
        let mut pins: Vec<[DVec2; 2]> = pins.iter().map(|pin| pin.map(DVec2::from)).collect();
        let fault = |message| {
            let help = "give four or more pins [[x, y], [s, t]]: x and y in the projector's picture, \
                        all in pixels or all from 0 to 1, s and t on the screen, from 0 to 1, both \
                        from the upper left corner";
            RoomError::new("corner_pins", message, help)
        };
        if pins.len() < 4 {
            return Err(fault(format!("there are {} corner pins", pins.len())));
        }
        let is_share =
            |point: DVec2| point.cmpge(DVec2::ZERO).all() && point.cmple(DVec2::ONE).all();
        if !pins.iter().all(|[at, _]| is_share(*at)) {
            for [at, _] in &mut pins {
                *at /= pixels;
            }
        }
        let outside = pins
            .iter()
            .position(|pin| !pin.iter().all(|point| is_share(*point)));
        if let Some(number) = outside {
            return Err(fault(format!(
                "corner pin {} is outside its pictures",
                number + 1
            )));
        }
        Homography::of_pins(&pins)
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

/// What a projector without `gamma` is taken for.
const DEFAULT_GAMMA: [Transfer; 3] = [Transfer::Srgb, Transfer::Srgb, Transfer::Srgb];

impl GammaEntry {
    fn transfers(&self) -> Result<[Transfer; 3], RoomError> {
        Ok(match self {
            Self::All(channel) => {
                let transfer = channel.transfer()?;
                [transfer.clone(), transfer.clone(), transfer]
            }
            Self::Each { red, green, blue } => {
                [red.transfer()?, green.transfer()?, blue.transfer()?]
            }
        })
    }
}

impl ChannelEntry {
    fn transfer(&self) -> Result<Transfer, RoomError> {
        match self {
            Self::Number(gamma) => Ok(Transfer::Gamma(within("gamma", *gamma, Transfer::GAMMAS)?)),
            Self::Name(name) if name == "srgb" => Ok(Transfer::Srgb),
            Self::Name(name) => Err(RoomError::new(
                "gamma",
                format!("there is no gamma \"{name}\""),
                "give \"srgb\", a number such as 2.2, or a list of lights",
            )),
            Self::Curve(lights) => {
                let rises = lights.windows(2).all(|pair| pair[0] < pair[1]);
                let ends = (lights.first(), lights.last());
                if rises && ends == (Some(&0.0), Some(&1.0)) {
                    return Ok(Transfer::Curve(lights.clone()));
                }
                Err(RoomError::new(
                    "gamma",
                    "the gamma's curve does not rise from 0 to 1".to_owned(),
                    "list the light at codes of equal steps, without the black's, as shares of \
                     white's: [0, 0.02, …, 1]",
                ))
            }
        }
    }
}

/// Returns a value that is within its range.
fn within(key: &'static str, value: f64, [least, most]: [f64; 2]) -> Result<f64, RoomError> {
    if (least..=most).contains(&value) {
        return Ok(value);
    }
    let message = format!("the projector's {key} is {value}");
    Err(RoomError::new(
        key,
        message,
        format!("give a number from {least} to {most}"),
    ))
}

#[cfg(test)]
mod tests;
