//! `shisen tracker calibrate`: from what a tracker says to where eyes look.

use super::follow::{EndArguments, follow};
use super::show::Shown;
use super::{TrackerName, warn_of_sensors};
use crate::cave::look::Point;
use crate::cli::output::failure::{Failure, Fault};
use crate::cli::output::{print, say};
use crate::files::write_atomically;
use crate::tracker::calibration::{
    CalibrationFile, EYES, Fits, Gatherer, SeenTarget, TimedTarget, device_name, estimation,
    read_script,
};
use crate::tracker::{Feed, Notice};
use clap::{Args, ValueEnum};
use miette::Diagnostic;
use serde::Serialize;
use shisen_core::gaze::HeadPose;
use shisen_tracker::decoder::Event;
use shisen_tracker::estimate::Model;
use shisen_tracker::time::Micros;
use std::fmt;
use std::path::PathBuf;
use thiserror::Error;

/// Calibrates an eye tracker
///
/// Takes what the tracker says while the viewer looks at targets, fits a
/// calibration to it, and writes FILE, for --calibration of `shisen tracker
/// monitor`, `shisen cave` and `shisen run`. With --targets the targets are somewhere in the
/// room, and SPEC can also be a recording (replay:FILE); without, nine of them are
/// shown on this terminal, two seconds each, and it has to fill the [screen] of
/// --setup. Of several sensors the first that is seen is the viewer's head, or the
/// one that `head=N` in SPEC names.
///
/// With --json, one object: file, device (null of a recording that --device says
/// nothing of), model, targets (place (metres, in the room), direction (from the
/// eyes, in the head's axes), samples and `left`, `right` and `combined` (null, or
/// measured (what the tracker said, the mean) and `residual_deg`) each) and left,
/// right and combined (null, or `rms_deg`, `largest_deg` and worst (which target,
/// from 0)).
#[derive(Debug, Args)]
pub(in crate::cli) struct Arguments {
    /// Which tracker: see `shisen tracker --help`
    #[arg(value_name = "SPEC")]
    spec: TrackerName,
    /// Where to; what was there is overwritten
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// What is looked at and when: a table with the columns `start_s`, `end_s`
    /// (seconds since the tracker was opened, or on the recording's clock), x, y
    /// and z (metres, in the room)
    #[arg(long, value_name = "CSV")]
    targets: Option<PathBuf>,
    /// What is fitted: shift, scale, turn and shear, or these and a bend
    #[arg(long, value_enum, default_value = "affine")]
    model: FittedModel,
    /// A calibration file whose head, [screen] and [`room_from_tracker`] are used
    /// and kept
    #[arg(long, value_name = "TOML")]
    setup: Option<PathBuf>,
    /// Where the head is, as far as the tracker does not say: metres, in the
    /// room [default: as --setup says, or else 0,0,0]
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true)]
    head: Option<Point>,
    /// The device that a recording is of, such as iscan [default: as SPEC says]
    #[arg(long, value_name = "NAME")]
    device: Option<String>,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

/// `--model`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum FittedModel {
    /// 3 targets or more, not on a line
    Affine,
    /// 6 targets or more, not on a conic
    SecondOrder,
}

/// There is nothing to look at.
#[derive(Debug, Error, Diagnostic)]
enum NoTargets {
    /// A recording, or the mock.
    #[error("the targets can be shown to nobody: {spec} is no device")]
    #[diagnostic(help("give what was looked at with --targets CSV"))]
    NotLive {
        /// What it is.
        spec: String,
    },
    /// It is not known where the terminal is.
    #[error("it is not known where this terminal is in the room")]
    #[diagnostic(help(
        "give --setup TOML with a [screen] (corner = [x, y, z] and size = [w, h], metres) that this terminal fills, or --targets CSV"
    ))]
    NoScreen,
    /// There is no terminal.
    #[error("standard error is no terminal to show targets on")]
    #[diagnostic(help("give --targets CSV"))]
    NoTerminal,
}

/// Runs the command.
pub(super) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let mut file = match &arguments.setup {
        Some(path) => CalibrationFile::load(path)?,
        None => CalibrationFile::default(),
    };
    if let Some(head) = arguments.head {
        file.head = head.0.as_vec3();
    }
    file.model = match arguments.model {
        FittedModel::Affine => Model::Affine,
        FittedModel::SecondOrder => Model::SecondOrder,
    };
    let spec = &arguments.spec.spec;
    let timed = arguments.targets.as_deref().map(read_script).transpose()?;
    let mut feed = Feed::open(spec)?;
    file.device = arguments.device.clone().or_else(|| device_name(spec));
    // What was fitted before does not count: of that, this is the repetition.
    file.targets.clear();
    let head = HeadPose {
        position: file.head,
        ..HeadPose::IDENTITY
    };
    let config = estimation(spec, feed.senses(spec), head, Some(&file.clone().into()));
    let (targets, shown) = match timed {
        Some(targets) => (targets, None),
        None if !feed.is_live() => {
            let spec = arguments.spec.to_string();
            return Err(NoTargets::NotLive { spec }.into());
        }
        None => {
            let screen = file.screen.ok_or(NoTargets::NoScreen)?;
            let shown = Shown::new(&screen, feed.now()).ok_or(NoTargets::NoTerminal)?;
            (shown.targets(), Some(shown))
        }
    };
    let mut gatherer = Gatherer::new(config, targets);
    if feed.is_live() {
        gather(&mut feed, &mut gatherer, shown)?;
    } else {
        let end = gatherer.targets().last().map_or(Micros(0), |last| last.end);
        feed.poll(end, &mut |notice| {
            if let Notice::Decoded(event) = notice
                && let Event::Sample(sample) = event
            {
                gatherer.push(&sample, &mut |event| warn_of_sensors(&event));
            }
        });
    }
    file.targets = gatherer.finish()?;
    let text = file.to_toml()?;
    write_atomically(&arguments.file, |file| file.write_all(text.as_bytes()))
        .map_err(Fault::write(&arguments.file))?;
    let fits = file.fit()?;
    let name = arguments.file.display().to_string();
    print(&Report::new(name, &file, &fits), arguments.json)
}

/// Listens to a device while the targets are looked at.
fn gather(
    feed: &mut Feed,
    gatherer: &mut Gatherer,
    mut shown: Option<Shown>,
) -> Result<(), Failure> {
    let targets = gatherer.targets().to_vec();
    let end = targets.last().map_or(Micros(0), |last| last.end);
    let mut told = 0;
    let forever = EndArguments::default();
    follow(feed, &forever, &mut |feed, heard| {
        let now = feed.now();
        match (&mut shown, targets.get(told)) {
            (Some(shown), _) => shown.show(now),
            (None, Some(target)) if now >= target.start => {
                told += 1;
                let TimedTarget { place, .. } = target;
                say(&format!(
                    "target {told} of {}: {} {} {} m",
                    targets.len(),
                    place.x,
                    place.y,
                    place.z
                ));
            }
            _ => {}
        }
        for event in &heard.events {
            if let Event::Sample(sample) = event {
                gatherer.push(sample, &mut |event| warn_of_sensors(&event));
            }
        }
        Ok(now < end)
    })
}

#[derive(Debug, Serialize)]
struct Report {
    file: String,
    device: Option<String>,
    model: &'static str,
    targets: Vec<TargetReport>,
    left: Option<EyeReport>,
    right: Option<EyeReport>,
    combined: Option<EyeReport>,
}

#[derive(Debug, Serialize)]
struct TargetReport {
    place: Option<[f32; 3]>,
    direction: [f32; 3],
    samples: Option<u32>,
    left: Option<MeasuredReport>,
    right: Option<MeasuredReport>,
    combined: Option<MeasuredReport>,
}

#[derive(Debug, Serialize)]
struct MeasuredReport {
    measured: [f32; 2],
    residual_deg: f32,
}

#[derive(Debug, Serialize)]
struct EyeReport {
    rms_deg: f32,
    largest_deg: f32,
    worst: usize,
}

impl Report {
    fn new(name: String, file: &CalibrationFile, fits: &Fits) -> Self {
        let [left, right, combined] = fits.map(|fit| {
            let residual = fit?.residual();
            Some(EyeReport {
                rms_deg: residual.rms.to_degrees(),
                largest_deg: residual.largest.to_degrees(),
                worst: residual.worst,
            })
        });
        let target = |seen: &SeenTarget| TargetReport::new(file, fits, seen);
        Self {
            file: name,
            device: file.device.clone(),
            model: crate::tracker::calibration::model_name(file.model),
            targets: file.targets.iter().map(target).collect(),
            left,
            right,
            combined,
        }
    }
}

impl TargetReport {
    fn new(file: &CalibrationFile, fits: &Fits, seen: &SeenTarget) -> Self {
        let residuals = file.residuals(fits, seen);
        let [left, right, combined] = std::array::from_fn(|eye| {
            let (measured, off) = seen.measured[eye].zip(residuals[eye])?;
            Some(MeasuredReport {
                measured: measured.to_array(),
                residual_deg: off.to_degrees(),
            })
        });
        Self {
            place: seen.place.map(|place| place.to_array()),
            direction: seen.direction.to_array(),
            samples: seen.samples,
            left,
            right,
            combined,
        }
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (number, target) in self.targets.iter().enumerate() {
            write!(f, "target {}", number + 1)?;
            if let Some([x, y, z]) = target.place {
                write!(f, " at {x:.3} {y:.3} {z:.3} m")?;
            }
            if let Some(samples) = target.samples {
                write!(f, ", {samples} samples")?;
            }
            let eyes = [&target.left, &target.right, &target.combined];
            for (eye, measured) in EYES.into_iter().zip(eyes) {
                if let Some(MeasuredReport {
                    measured: [x, y],
                    residual_deg,
                }) = measured
                {
                    write!(f, ", {eye} {x:.3} {y:.3} ({residual_deg:.3}° off)")?;
                }
            }
            writeln!(f)?;
        }
        for (eye, fit) in EYES
            .into_iter()
            .zip([&self.left, &self.right, &self.combined])
        {
            if let Some(fit) = fit {
                writeln!(
                    f,
                    "{eye}: {:.3}° rms, {:.3}° at most, of target {}",
                    fit.rms_deg,
                    fit.largest_deg,
                    fit.worst + 1
                )?;
            }
        }
        write!(f, "{}: {} model", self.file, self.model)
    }
}
