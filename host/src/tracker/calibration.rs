//! What is known of a tracker where it stands: a calibration file.
//!
//! ```toml
//! device = "iscan"              # optional: refused with another device
//! model = "affine"              # or "second-order"; optional without targets
//! head = [0.0, 0.0, 0.0]        # optional: where the viewer's head rests, metres
//!
//! [room_from_tracker]           # optional: where the tracker's axes are
//! position = [0.0, 1.2, -1.0]
//! orientation = [0.0, 0.0, 0.0, 1.0]      # x, y, z, w
//!
//! [screen]                      # optional: the plane of gaze points
//! corner = [-1.0, 0.5, -1.0]    # upper left, metres in the room
//! right = [1.0, 0.0, 0.0]       # optional: along the upper edge
//! down = [0.0, -1.0, 0.0]       # optional: along the left edge
//! size = [2.0, 1.0]             # metres
//!
//! [[target]]                    # any number of them
//! place = [0.3, 0.2, -1.0]      # optional: metres in the room, for people
//! direction = [0.28, 0.19, -0.94]         # from the eyes, in the head's axes
//! samples = 400                 # optional: for people
//! combined = [1030.0, 730.0]    # what the tracker said; so left and right
//! ```
//!
//! Of the targets the calibration is fitted anew whenever the file is read. The
//! numbers of left, right and combined are [`Measured`]'s.

mod estimation;
mod gather;
mod script;

pub use estimation::estimation;
pub use gather::{GatherError, Gatherer, SETTLE};
pub(super) use script::scripted;
pub use script::{ScriptError, TimedTarget, read_script};

use super::hid::usb_id;
use super::{HidName, Spec};
use crate::files::description::{Located, Source};
use glam::{Quat, Vec2, Vec3};
use miette::Diagnostic;
use serde::Deserialize;
use shisen_core::gaze::HeadPose;
use shisen_tracker::estimate::{
    Calibration, CalibrationError, EstimatorConfig, EstimatorConfigError, Measured, Model,
    RoomFromTracker, Screen, Target,
};
use std::fmt::{self, Write};
use std::path::{Path, PathBuf};
use thiserror::Error;
use toml::Spanned;

/// What is wrong in a calibration file.
#[derive(Debug, Clone, PartialEq, Error, Diagnostic)]
#[non_exhaustive]
pub enum CalibrationFault {
    /// Not TOML, or not the keys and types that it has.
    #[error("{message}")]
    #[diagnostic(help(
        "a calibration file has device, model, head, [room_from_tracker] (position and orientation), [screen] (corner, size and, if wanted, right and down) and [[target]] (direction, and of left, right and combined what the tracker says); all of them are optional"
    ))]
    Syntax {
        /// The TOML reader's message.
        message: String,
    },
    /// A model that there is not.
    #[error("there is no model {found:?}")]
    #[diagnostic(help("give affine or second-order"))]
    Model {
        /// What stands there.
        found: String,
    },
    /// Targets and nothing to fit to them.
    #[error("there are targets and no model")]
    #[diagnostic(help("give model = \"affine\" or model = \"second-order\""))]
    NoModel,
    /// The targets make no calibration.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Fit(#[from] FitError),
    /// A screen or a tracker's place that cannot be.
    #[error("{0}")]
    #[diagnostic(help("lengths are metres, in the room: +X right, +Y up, −Z ahead"))]
    Place(EstimatorConfigError),
    /// The place of a target that is none.
    #[error("a target's place is no number of metres")]
    #[diagnostic(help("give three numbers, or leave it out: it is for people"))]
    TargetPlace,
}

/// Why a calibration cannot be used.
#[derive(Debug, Error, Diagnostic)]
#[non_exhaustive]
pub enum CalibrationFileError {
    /// The file could not be read.
    #[error("cannot read the calibration in {}: {reason}", path.display())]
    #[diagnostic(help("give the path of a file that `shisen tracker calibrate` wrote"))]
    Read {
        /// Which file.
        path: PathBuf,
        /// What the system said.
        reason: std::io::Error,
    },
    /// It was read, and there is a fault in it.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Fault(#[from] Located<CalibrationFault>),
    /// It was made for another device.
    #[error("{} is the calibration of {calibrated}, and this is {found}", path.display())]
    #[diagnostic(help(
        "give the file that `shisen tracker calibrate` wrote for this device, or calibrate it"
    ))]
    Device {
        /// The file.
        path: PathBuf,
        /// The file's device.
        calibrated: String,
        /// The device that is there.
        found: String,
    },
}

/// Targets that make no calibration of an eye.
#[derive(Debug, Clone, Copy, PartialEq, Error, Diagnostic)]
#[error("{eye}: {reason}")]
#[diagnostic(help(
    "targets: 3 or more, not on a line, for an affine model; 6 or more, nine in a square at best, for a second-order one"
))]
pub struct FitError {
    /// left, right or combined.
    pub eye: &'static str,
    /// Why.
    pub reason: CalibrationError,
}

/// The three that are calibrated, in the order of [`SeenTarget::measured`].
pub const EYES: [&str; 3] = ["left", "right", "combined"];

/// A target, and what the tracker said while it was looked at.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SeenTarget {
    /// Where it was: metres, in the room.
    pub place: Option<Vec3>,
    /// From the middle between the eyes, in the head's axes.
    pub direction: Vec3,
    /// Of how many samples.
    pub samples: Option<u32>,
    /// The mean of what it said, of left, right and combined.
    pub measured: [Option<Vec2>; 3],
}

impl SeenTarget {
    /// Whether it has a place that is no number.
    fn is_nowhere(&self) -> bool {
        self.place.is_some_and(|place| !place.is_finite())
    }
}

/// What is known of a tracker where it stands.
#[derive(Debug, Clone, PartialEq)]
pub struct CalibrationFile {
    /// Which device it is; `None` for any.
    pub device: Option<String>,
    /// What is fitted.
    pub model: Model,
    /// Where the viewer's head rests: metres, in the room.
    pub head: Vec3,
    /// Where the tracker's axes are; `None` where somebody else says so.
    pub room_from_tracker: Option<RoomFromTracker>,
    /// The plane of gaze points.
    pub screen: Option<Screen>,
    /// What was looked at.
    pub targets: Vec<SeenTarget>,
}

impl Default for CalibrationFile {
    /// Nothing is known.
    fn default() -> Self {
        Self {
            device: None,
            model: Model::Affine,
            head: Vec3::ZERO,
            room_from_tracker: None,
            screen: None,
            targets: Vec::new(),
        }
    }
}

/// Calibrations of left, right and combined, where they were measured.
pub type Fits = [Option<Calibration>; 3];

/// A model's name, as files and command lines have it.
pub const fn model_name(model: Model) -> &'static str {
    match model {
        Model::Affine => "affine",
        Model::SecondOrder => "second-order",
    }
}

/// What a file says; all of it is optional.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Entry {
    device: Option<String>,
    model: Option<Spanned<String>>,
    head: Option<[f32; 3]>,
    room_from_tracker: Option<Spanned<RoomEntry>>,
    screen: Option<Spanned<ScreenEntry>>,
    #[serde(default)]
    target: Vec<Spanned<TargetEntry>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RoomEntry {
    position: [f32; 3],
    orientation: [f32; 4],
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ScreenEntry {
    corner: [f32; 3],
    right: Option<[f32; 3]>,
    down: Option<[f32; 3]>,
    size: [f32; 2],
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct TargetEntry {
    place: Option<[f32; 3]>,
    direction: [f32; 3],
    samples: Option<u32>,
    left: Option<[f32; 2]>,
    right: Option<[f32; 2]>,
    combined: Option<[f32; 2]>,
}

impl TargetEntry {
    fn seen(&self) -> SeenTarget {
        SeenTarget {
            place: self.place.map(Vec3::from_array),
            direction: Vec3::from_array(self.direction),
            samples: self.samples,
            measured: [self.left, self.right, self.combined].map(|of| of.map(Vec2::from_array)),
        }
    }
}

impl CalibrationFile {
    /// Reads a file.
    ///
    /// # Errors
    /// A file that cannot be read, or as [`from_toml`](Self::from_toml).
    pub fn load(path: &Path) -> Result<Self, CalibrationFileError> {
        let text = crate::files::read_text(path);
        let text = text.map_err(|reason| CalibrationFileError::Read {
            path: path.to_owned(),
            reason,
        })?;
        Ok(Self::from_toml(&text, &path.to_string_lossy())?)
    }

    /// Of a file's text; `source_name` is what messages call it.
    ///
    /// # Errors
    /// The first fault found and its place: text that is not TOML, unknown or
    /// missing keys, a model that there is not, a screen or a tracker that
    /// cannot be where it is said to be, targets that make no calibration.
    pub fn from_toml(text: &str, source_name: &str) -> Result<Self, Located<CalibrationFault>> {
        let source = Source {
            name: source_name,
            text,
        };
        let entry: Entry = source.parse(|message| CalibrationFault::Syntax { message })?;
        let mut file = Self {
            device: entry.device,
            head: entry.head.map_or(Vec3::ZERO, Vec3::from_array),
            ..Self::default()
        };
        match &entry.model {
            Some(model) => {
                let found = model.as_ref();
                let named = |one: &Model| model_name(*one) == found.as_str();
                let known = [Model::Affine, Model::SecondOrder].into_iter().find(named);
                file.model = known.ok_or_else(|| {
                    let found = found.clone();
                    Located::new(
                        CalibrationFault::Model { found },
                        &source,
                        Some(model.span()),
                    )
                })?;
            }
            None if !entry.target.is_empty() => {
                return Err(Located::new(CalibrationFault::NoModel, &source, None));
            }
            None => {}
        }
        let misplaced = |span| {
            let source = &source;
            move |reason| Located::new(CalibrationFault::Place(reason), source, span)
        };
        if let Some(room) = &entry.room_from_tracker {
            let RoomEntry {
                position,
                orientation,
            } = *room.as_ref();
            file.room_from_tracker = Some(RoomFromTracker {
                position: Vec3::from_array(position),
                orientation: Quat::from_array(orientation),
            });
            file.check().map_err(misplaced(Some(room.span())))?;
        }
        if let Some(screen) = &entry.screen {
            let ScreenEntry {
                corner,
                right,
                down,
                size,
            } = *screen.as_ref();
            file.screen = Some(Screen {
                corner: Vec3::from_array(corner),
                right: right.map_or(Vec3::X, Vec3::from_array),
                down: down.map_or(Vec3::NEG_Y, Vec3::from_array),
                size: Vec2::from_array(size),
            });
            file.check().map_err(misplaced(Some(screen.span())))?;
        }
        file.check().map_err(misplaced(None))?;
        file.targets = entry.target.iter().map(|t| t.as_ref().seen()).collect();
        if let Some(at) = file.targets.iter().position(SeenTarget::is_nowhere) {
            let span = Some(entry.target[at].span());
            return Err(Located::new(CalibrationFault::TargetPlace, &source, span));
        }
        if let Err(error) = file.fit() {
            let at = file.target_of(&error).map(|at| entry.target[at].span());
            return Err(Located::new(error.into(), &source, at));
        }
        Ok(file)
    }

    fn check(&self) -> Result<(), EstimatorConfigError> {
        let mut config = EstimatorConfig::default();
        self.place(&mut config);
        config.check()
    }

    /// Which of the file's targets an error is about.
    fn target_of(&self, error: &FitError) -> Option<usize> {
        let (CalibrationError::NotFinite { target } | CalibrationError::NotAhead { target }) =
            error.reason
        else {
            return None;
        };
        let eye = EYES.iter().position(|&eye| eye == error.eye)?;
        let of_eye = |(_, seen): &(usize, &SeenTarget)| seen.measured[eye].is_some();
        let mut of_eye = self.targets.iter().enumerate().filter(of_eye);
        of_eye.nth(target).map(|(index, _)| index)
    }

    /// The calibrations of what was measured; none where nothing was.
    ///
    /// # Errors
    /// The first eye whose targets make none.
    pub fn fit(&self) -> Result<Fits, FitError> {
        let mut fits = Fits::default();
        for (index, eye) in EYES.into_iter().enumerate() {
            let of = |seen: &SeenTarget| {
                let measured = seen.measured[index]?;
                let direction = seen.direction;
                Some(Target {
                    measured,
                    direction,
                })
            };
            let targets: Vec<Target> = self.targets.iter().filter_map(of).collect();
            if !targets.is_empty() {
                let fitted = Calibration::fit(self.model, &targets);
                fits[index] = Some(fitted.map_err(|reason| FitError { eye, reason })?);
            }
        }
        Ok(fits)
    }

    /// How far each eye's direction is from a target by its calibration,
    /// radians.
    pub fn residuals(&self, fits: &Fits, seen: &SeenTarget) -> [Option<f32>; 3] {
        std::array::from_fn(|eye| {
            let (fit, measured) = fits[eye].as_ref().zip(seen.measured[eye])?;
            let direction = seen.direction;
            let target = Target {
                measured,
                direction,
            };
            Some(fit.residual_of(&[target]).largest)
        })
    }

    /// Sets what the file says of places.
    fn place(&self, config: &mut EstimatorConfig) {
        config.resting_head.position = self.head;
        if let Some(room) = self.room_from_tracker {
            config.room_from_tracker = room;
        }
        config.screen = self.screen.or(config.screen);
    }

    /// The file's text, which [`CalibrationFile::from_toml`] reads again.
    ///
    /// # Errors
    /// Targets that make no calibration, and places that cannot be.
    pub fn to_toml(&self) -> Result<String, CalibrationFault> {
        let fits = self.fit()?;
        self.check().map_err(CalibrationFault::Place)?;
        if self.targets.iter().any(SeenTarget::is_nowhere) {
            return Err(CalibrationFault::TargetPlace);
        }
        let mut text = String::from(
            "# Written by `shisen tracker calibrate`. The calibration is fitted to the\n\
             # targets anew when this is read; what follows a # is for people.\n",
        );
        // Writing to a string does not fail.
        let _ = self.write(&fits, &mut text);
        Ok(text)
    }

    fn write(&self, fits: &Fits, to: &mut String) -> fmt::Result {
        if let Some(device) = &self.device {
            writeln!(to, "device = {device:?}")?;
        }
        writeln!(to, "model = {:?}", model_name(self.model))?;
        writeln!(to, "head = {:?}", self.head.to_array())?;
        for (eye, fit) in EYES.into_iter().zip(fits) {
            if let Some(fit) = fit {
                let residual = fit.residual();
                writeln!(
                    to,
                    "# {eye}: {:.3}° rms, {:.3}° at most",
                    residual.rms.to_degrees(),
                    residual.largest.to_degrees()
                )?;
            }
        }
        if let Some(room) = self.room_from_tracker {
            writeln!(to, "\n[room_from_tracker]")?;
            writeln!(to, "position = {:?}", room.position.to_array())?;
            writeln!(to, "orientation = {:?}", room.orientation.to_array())?;
        }
        if let Some(screen) = self.screen {
            writeln!(to, "\n[screen]")?;
            writeln!(to, "corner = {:?}", screen.corner.to_array())?;
            writeln!(to, "right = {:?}", screen.right.to_array())?;
            writeln!(to, "down = {:?}", screen.down.to_array())?;
            writeln!(to, "size = {:?}", screen.size.to_array())?;
        }
        for seen in &self.targets {
            writeln!(to, "\n[[target]]")?;
            if let Some(place) = seen.place {
                writeln!(to, "place = {:?}", place.to_array())?;
            }
            writeln!(to, "direction = {:?}", seen.direction.to_array())?;
            if let Some(samples) = seen.samples {
                writeln!(to, "samples = {samples}")?;
            }
            let residuals = self.residuals(fits, seen);
            for (eye, (measured, off)) in EYES.into_iter().zip(seen.measured.iter().zip(residuals))
            {
                if let Some((measured, off)) = measured.zip(off) {
                    let off = off.to_degrees();
                    writeln!(to, "{eye} = {:?} # {off:.3}° off", measured.to_array())?;
                }
            }
        }
        Ok(())
    }
}

/// A device by the name that calibrations know it by: its protocol's, or what
/// it is on USB. `None` of a recording, which does not say.
pub fn device_name(spec: &Spec) -> Option<String> {
    match spec {
        Spec::Mock(mock) => {
            let protocol = mock.protocol.as_ref();
            Some(protocol.map_or("mock", |protocol| protocol.name()).into())
        }
        Spec::Serial(serial) => Some(serial.protocol.name().into()),
        Spec::Hid(hid) => {
            let on_usb = usb_id(&hid.name).map(|(vendor, product)| HidName::Id(vendor, product));
            Some(format!("hid:{}", on_usb.as_ref().unwrap_or(&hid.name)))
        }
        Spec::Replay(_) => None,
    }
}

/// A calibration, made for a device.
#[derive(Debug, Clone, PartialEq)]
pub struct Calibrated {
    file: CalibrationFile,
    fits: Fits,
}

impl From<CalibrationFile> for Calibrated {
    /// Targets that make no calibration are left out.
    fn from(file: CalibrationFile) -> Self {
        let fits = file.fit().unwrap_or_default();
        Self { file, fits }
    }
}

impl Calibrated {
    /// Reads the calibration of a tracker.
    ///
    /// # Errors
    /// As [`CalibrationFile::load`], and a file of another device.
    pub fn load(path: &Path, spec: &Spec) -> Result<Self, CalibrationFileError> {
        let file = CalibrationFile::load(path)?;
        if let (Some(calibrated), Some(found)) = (&file.device, device_name(spec))
            && *calibrated != found
        {
            return Err(CalibrationFileError::Device {
                path: path.to_owned(),
                calibrated: calibrated.clone(),
                found,
            });
        }
        Ok(file.into())
    }

    /// Where the viewer's head rests, by the file.
    pub const fn head(&self) -> HeadPose {
        HeadPose {
            position: self.file.head,
            ..HeadPose::IDENTITY
        }
    }
}

/// Of left, right and combined, what a sample says.
fn measured(
    config: &EstimatorConfig,
    sample: &shisen_tracker::sample::Sample,
    head: &HeadPose,
) -> [Option<Vec2>; 3] {
    let Measured {
        left,
        right,
        combined,
    } = Measured::of(config, sample, head);
    [left, right, combined]
}
