//! A calibration file: what is known of a tracker where it stands.
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
//! [sensor_from_eyes]            # optional: where the eyes' axes are on the tracked sensor
//! position = [0.0, -0.1, 0.05]  # between the eyes, metres in the sensor's axes
//! orientation = [0.0, 0.0, 0.0, 1.0]
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
//! combined = [1030.0, 730.0]    # what the tracker measured; also left and right
//! ```
//!
//! The calibration is fitted to the targets whenever the file is read. The numbers of left,
//! right and combined are those of [`Measured`](shisen_tracker::estimate::Measured).

mod estimation;
mod gather;

pub(crate) use super::script::{TimedTarget, read_script};
pub(crate) use estimation::{composed, estimation};
pub(crate) use gather::Gatherer;

use super::hid::usb_id;
use super::protocol::ProtocolSpec;
use super::spec::{HidName, Spec, TrackerKind};
use crate::files::Fault;
use crate::files::description::{FileError, Located, Source, read_description};
use glam::{Quat, Vec2, Vec3};
use miette::Diagnostic;
use serde::Deserialize;
use shisen_core::gaze::HeadPose;
use shisen_tracker::estimate::{
    Calibration, CalibrationError, EstimatorConfig, EstimatorConfigError, Model, RoomFromTracker,
    Screen, Target,
};
use std::fmt::{self, Write};
use std::path::Path;
use thiserror::Error;
use toml::Spanned;

const SYNTAX: &str = "a calibration file has device, model, head, [room_from_tracker] and \
                      [sensor_from_eyes] (position and orientation), [screen] (corner, size and, if wanted, right and down) and \
                      [[target]] (direction, and of left, right and combined what the tracker \
                      says); all of them are optional";

fn misplaced(reason: EstimatorConfigError) -> Fault {
    let help = "lengths are metres, in the room: +X right, +Y up, −Z ahead";
    Fault::new(reason.to_string(), help)
}

fn nowhere() -> Fault {
    let help = "give three numbers, or leave it out: it is for people";
    Fault::new("a target's place is not finite", help)
}

/// Targets that make no calibration of an eye.
#[derive(Debug, Clone, Copy, PartialEq, Error, Diagnostic)]
#[error("{eye}: {reason}")]
#[diagnostic(help(
    "targets: 3 or more, not on a line, for an affine model; 6 or more, nine in a square at best, for a second-order one"
))]
pub(crate) struct FitError {
    pub(crate) eye: &'static str,
    pub(crate) reason: CalibrationError,
}

/// The eyes that are calibrated, in the order of [`SeenTarget::measured`].
pub(crate) const EYES: [&str; 3] = ["left", "right", "combined"];

/// A target, and what the tracker measured while the viewer looked at it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct SeenTarget {
    /// The target's place: metres, in the room.
    pub(crate) place: Option<Vec3>,
    /// The direction from the middle between the eyes, in the head's axes.
    pub(crate) direction: Vec3,
    pub(crate) samples: Option<u32>,
    pub(crate) measured: [Option<Vec2>; 3],
}

impl SeenTarget {
    fn target(&self, eye: usize) -> Option<Target> {
        self.measured[eye].map(|measured| Target {
            measured,
            direction: self.direction,
        })
    }

    fn is_nowhere(&self) -> bool {
        self.place.is_some_and(|place| !place.is_finite())
    }
}

/// What is known of a tracker where it stands.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct CalibrationFile {
    /// The device; `None` for any.
    pub(crate) device: Option<String>,
    pub(crate) model: Model,
    /// Where the viewer's head rests: metres, in the room.
    pub(crate) head: Vec3,
    /// Where the tracker's axes are; `None`: as the command line says.
    pub(crate) room_from_tracker: Option<RoomFromTracker>,
    /// Where the axes between the eyes are on the sensor that is tracked.
    pub(crate) sensor_from_eyes: Option<HeadPose>,
    pub(crate) screen: Option<Screen>,
    pub(crate) targets: Vec<SeenTarget>,
}

impl Default for CalibrationFile {
    fn default() -> Self {
        Self {
            device: None,
            model: Model::Affine,
            head: Vec3::ZERO,
            room_from_tracker: None,
            sensor_from_eyes: None,
            screen: None,
            targets: Vec::new(),
        }
    }
}

/// The calibrations of left, right and combined; `None` where nothing was measured.
pub(crate) type Fits = [Option<Calibration>; 3];

/// Returns the name of a model in files and on command lines.
pub(crate) const fn model_name(model: Model) -> &'static str {
    match model {
        Model::Affine => "affine",
        Model::SecondOrder => "second-order",
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Entry {
    device: Option<String>,
    model: Option<Spanned<String>>,
    head: Option<[f32; 3]>,
    room_from_tracker: Option<Spanned<RoomEntry>>,
    sensor_from_eyes: Option<Spanned<RoomEntry>>,
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
    pub(crate) fn load(path: &Path) -> Result<Self, FileError<Fault>> {
        let help = "give the path of a file that `shisen tracker calibrate` wrote";
        let text = read_description(path, "the calibration", help)?;
        Ok(Self::from_toml(&text, &path.to_string_lossy())?)
    }

    /// Reads a file's text; messages call it `source_name`.
    pub(crate) fn from_toml(text: &str, source_name: &str) -> Result<Self, Located<Fault>> {
        let source = Source {
            name: source_name,
            text,
        };
        let entry: Entry = source.parse(SYNTAX, Fault::new)?;
        let mut file = Self {
            device: entry.device,
            head: entry.head.map_or(Vec3::ZERO, Vec3::from_array),
            ..Self::default()
        };
        let located = |fault, span| Located::new(fault, &source, span);
        match &entry.model {
            Some(model) => {
                let found = model.as_ref();
                let named = |one: &Model| model_name(*one) == found.as_str();
                let known = [Model::Affine, Model::SecondOrder].into_iter().find(named);
                file.model = known.ok_or_else(|| {
                    let message = format!("there is no model {found:?}");
                    let fault = Fault::new(message, "give affine or second-order");
                    located(fault, Some(model.span()))
                })?;
            }
            None if !entry.target.is_empty() => {
                let help = "give model = \"affine\" or model = \"second-order\"";
                let fault = Fault::new("there are targets and no model", help);
                return Err(located(fault, None));
            }
            None => {}
        }
        let misplaced = |span| move |reason| located(misplaced(reason), span);
        if let Some(room) = &entry.room_from_tracker {
            file.room_from_tracker = Some(RoomFromTracker {
                position: Vec3::from_array(room.as_ref().position),
                orientation: Quat::from_array(room.as_ref().orientation),
            });
            file.check().map_err(misplaced(Some(room.span())))?;
        }
        if let Some(sensor) = &entry.sensor_from_eyes {
            let RoomEntry {
                position,
                orientation,
            } = sensor.as_ref();
            let (position, turn) = (Vec3::from_array(*position), Quat::from_array(*orientation));
            let is_pose = position.is_finite() && (turn.length() - 1.0).abs() < 0.1;
            file.sensor_from_eyes = Some(HeadPose {
                position,
                orientation: turn.normalize(),
            });
            if !is_pose {
                let help = "give metres, and a rotation x, y, z, w";
                let fault = Fault::new("sensor_from_eyes is no pose", help);
                return Err(located(fault, Some(sensor.span())));
            }
        }
        if let Some(screen) = &entry.screen {
            let entry = screen.as_ref();
            file.screen = Some(Screen {
                corner: Vec3::from_array(entry.corner),
                right: entry.right.map_or(Vec3::X, Vec3::from_array),
                down: entry.down.map_or(Vec3::NEG_Y, Vec3::from_array),
                size: Vec2::from_array(entry.size),
            });
            file.check().map_err(misplaced(Some(screen.span())))?;
        }
        file.check().map_err(misplaced(None))?;
        file.targets = entry.target.iter().map(|t| t.as_ref().seen()).collect();
        if let Some(at) = file.targets.iter().position(SeenTarget::is_nowhere) {
            let span = Some(entry.target[at].span());
            return Err(located(nowhere(), span));
        }
        if let Err(error) = file.fit() {
            let at = file.target_of(&error).map(|at| entry.target[at].span());
            return Err(located(Fault::of(&error), at));
        }
        Ok(file)
    }

    fn check(&self) -> Result<(), EstimatorConfigError> {
        let mut config = EstimatorConfig::default();
        self.place(&mut config);
        config.check()
    }

    /// Returns the number of the target that an error is about.
    fn target_of(&self, error: &FitError) -> Option<usize> {
        let (CalibrationError::NotFinite { target } | CalibrationError::NotAhead { target }) =
            error.reason
        else {
            return None;
        };
        let eye = EYES.iter().position(|&eye| eye == error.eye)?;
        let all = self.targets.iter().enumerate();
        let mut measured = all.filter(|(_, seen)| seen.measured[eye].is_some());
        measured.nth(target).map(|(index, _)| index)
    }

    /// Fits a calibration to each eye's measurements.
    pub(crate) fn fit(&self) -> Result<Fits, FitError> {
        let mut fits = Fits::default();
        for (index, eye) in EYES.into_iter().enumerate() {
            let seen = self.targets.iter();
            let targets: Vec<Target> = seen.filter_map(|seen| seen.target(index)).collect();
            if !targets.is_empty() {
                let fitted = Calibration::fit(self.model, &targets);
                fits[index] = Some(fitted.map_err(|reason| FitError { eye, reason })?);
            }
        }
        Ok(fits)
    }

    /// Returns the angle from each eye's calibrated direction to a target, radians.
    pub(crate) fn residuals(fits: &Fits, seen: &SeenTarget) -> [Option<f32>; 3] {
        std::array::from_fn(|eye| {
            let (fit, target) = fits[eye].as_ref().zip(seen.target(eye))?;
            Some(fit.residual_of(&[target]).largest)
        })
    }

    /// Puts the file's places into a configuration.
    fn place(&self, config: &mut EstimatorConfig) {
        config.resting_head.position = self.head;
        if let Some(room) = self.room_from_tracker {
            config.room_from_tracker = room;
        }
        config.screen = self.screen.or(config.screen);
    }

    /// Writes the text that [`from_toml`](Self::from_toml) reads.
    pub(crate) fn to_toml(&self) -> Result<String, Fault> {
        let fits = self.fit().map_err(|error| Fault::of(&error))?;
        self.check().map_err(misplaced)?;
        if self.targets.iter().any(SeenTarget::is_nowhere) {
            return Err(nowhere());
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
            if let Some(residual) = fit.as_ref().map(Calibration::residual) {
                let [rms, largest] = [residual.rms, residual.largest].map(f32::to_degrees);
                writeln!(to, "# {eye}: {rms:.3}° rms, {largest:.3}° at most")?;
            }
        }
        if let Some(room) = self.room_from_tracker {
            writeln!(to, "\n[room_from_tracker]")?;
            writeln!(to, "position = {:?}", room.position.to_array())?;
            writeln!(to, "orientation = {:?}", room.orientation.to_array())?;
        }
        if let Some(sensor) = self.sensor_from_eyes {
            writeln!(to, "\n[sensor_from_eyes]")?;
            writeln!(to, "position = {:?}", sensor.position.to_array())?;
            writeln!(to, "orientation = {:?}", sensor.orientation.to_array())?;
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
            let residuals = Self::residuals(fits, seen);
            for (eye, (measured, off)) in EYES.iter().zip(seen.measured.iter().zip(residuals)) {
                if let Some((measured, off)) = measured.zip(off) {
                    let off = off.to_degrees();
                    writeln!(to, "{eye} = {:?} # {off:.3}° off", measured.to_array())?;
                }
            }
        }
        Ok(())
    }
}

/// Returns a device's name in calibration files: protocol or USB id; `None` for a recording.
pub(crate) fn device_name(spec: &Spec) -> Option<String> {
    match &spec.kind {
        TrackerKind::Hid(hid) => {
            let on_usb = usb_id(&hid.name).map(|(vendor, product)| HidName::Id(vendor, product));
            Some(format!("hid:{}", on_usb.as_ref().unwrap_or(&hid.name)))
        }
        TrackerKind::Replay(_) => None,
        TrackerKind::Net(net) => Some(net.kind().to_owned()),
        _ => Some(spec.protocol().map_or("mock", ProtocolSpec::name).into()),
    }
}

/// A calibration file and its fits.
pub(crate) struct Calibrated {
    file: CalibrationFile,
    fits: Fits,
}

impl From<CalibrationFile> for Calibrated {
    /// Leaves out targets that make no calibration.
    fn from(file: CalibrationFile) -> Self {
        let fits = file.fit().unwrap_or_default();
        Self { file, fits }
    }
}

impl Calibrated {
    /// Reads the calibration of a tracker.
    pub(crate) fn load(path: &Path, spec: &Spec) -> Result<Self, FileError<Fault>> {
        let file = CalibrationFile::load(path)?;
        if let (Some(calibrated), Some(found)) = (&file.device, device_name(spec))
            && *calibrated != found
        {
            let message = format!("it is the calibration of {calibrated}, and this is {found}");
            let help = "give the file that `shisen tracker calibrate` wrote for this device, or \
                        calibrate it";
            let (name, text) = (&path.to_string_lossy(), "");
            let fault = Fault::new(message, help);
            return Err(Located::new(fault, &Source { name, text }, None).into());
        }
        Ok(file.into())
    }

    /// Returns where the axes between the eyes are on the sensor.
    pub(crate) const fn sensor_from_eyes(&self) -> Option<HeadPose> {
        self.file.sensor_from_eyes
    }

    /// Returns where the viewer's head rests.
    pub(crate) const fn head(&self) -> HeadPose {
        HeadPose {
            position: self.file.head,
            ..HeadPose::IDENTITY
        }
    }
}
