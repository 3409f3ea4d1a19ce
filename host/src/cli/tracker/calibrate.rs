//! `shisen tracker calibrate`: fits a calibration to what a tracker sends.

use super::follow::{EndArguments, follow};
use super::show::Shown;
use super::{TrackerName, warn_of_sensors};
use crate::cave::look::Point;
use crate::cli::prelude::*;
use crate::files::write_atomically;
use crate::tracker::calibration::{
    CalibrationFile, EYES, Fits, Gatherer, SeenTarget, device_name, estimation, read_script,
};
use crate::tracker::{Feed, Notice};
use shisen_core::gaze::HeadPose;
use shisen_tracker::decoder::Event;
use shisen_tracker::estimate::Model;
use shisen_tracker::time::Micros;

/// Calibrates an eye tracker
#[derive(Debug, Args)]
pub(in crate::cli) struct Arguments {
    /// The tracker: see `shisen tracker --help`
    #[arg(value_name = "SPEC")]
    spec: TrackerName,
    /// File to write; an older one is overwritten
    #[arg(value_name = "FILE")]
    file: PathBuf,
    #[arg(
        long,
        value_name = "CSV",
        help = "Table of targets with the columns start_s, end_s \
          (seconds since the tracker was opened, or on the recording's clock), x, y and z (metres, \
          in the room)"
    )]
    targets: Option<PathBuf>,
    /// What to fit: shift, scale, turn and shear, or these and a bend
    #[arg(long, value_enum, default_value = "affine")]
    model: FittedModel,
    #[arg(
        long,
        value_name = "TOML",
        help = "Calibration file whose head, [screen] and \
          [room_from_tracker] are used and kept"
    )]
    setup: Option<PathBuf>,
    /// Position of the head in the room, metres, unless the tracker says it [default: as --setup
    /// says, or else 0,0,0]
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true)]
    head: Option<Point>,
    /// Device of a recording, such as iscan [default: as SPEC says]
    #[arg(long, value_name = "NAME")]
    device: Option<String>,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum FittedModel {
    /// 3 targets or more, not on a line
    Affine,
    /// 6 targets or more, not on a conic
    SecondOrder,
}

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
    let spec = arguments.spec.alone()?;
    let timed = arguments.targets.as_deref().map(read_script).transpose()?;
    let mut feed = Feed::open(spec)?;
    file.device = arguments.device.clone().or_else(|| device_name(spec));
    // The new targets replace those of an earlier calibration.
    file.targets.clear();
    let head = HeadPose {
        position: file.head,
        ..HeadPose::IDENTITY
    };
    let config = estimation(spec, feed.senses(spec), head, Some(&file.clone().into()));
    let (targets, shown) = match timed {
        Some(targets) => (targets, None),
        None if !feed.is_live() => {
            let spec = &arguments.spec;
            let message =
                format!("{spec} is a recording, so no targets can be shown to its viewer");
            let help = "say with --targets CSV what the viewer looked at";
            return Err(Fault::new(message, help).into());
        }
        None => {
            let message = "nothing says where this terminal is in the room";
            let help = "give --setup TOML with a [screen] (corner = [x, y, z] and size = [w, h], \
                        metres) that this terminal fills, or --targets CSV";
            let screen = file.screen.ok_or_else(|| Fault::new(message, help))?;
            let message = "targets cannot be shown: standard error is not a terminal";
            let shown = Shown::new(&screen, feed.now());
            let shown = shown.ok_or_else(|| Fault::new(message, "give --targets CSV"))?;
            (shown.targets(), Some(shown))
        }
    };
    let mut gatherer = Gatherer::new(&config, targets);
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

/// Listens to a device while the viewer looks at the targets.
fn gather(
    feed: &mut Feed,
    gatherer: &mut Gatherer,
    mut shown: Option<Shown>,
) -> Result<(), Failure> {
    let targets = gatherer.targets().to_vec();
    let end = targets.last().map_or(Micros(0), |last| last.end);
    let mut announced = 0;
    let forever = EndArguments::default();
    follow(feed, &forever, None, &mut |feed, heard| {
        let now = feed.now();
        match (&mut shown, targets.get(announced)) {
            (Some(shown), _) => shown.show(now),
            (None, Some(target)) if now >= target.start => {
                announced += 1;
                let (count, [x, y, z]) = (targets.len(), target.place.to_array());
                say(&format!("target {announced} of {count}: {x} {y} {z} m"));
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

/// A calibration.
#[derive(Debug, Serialize, JsonSchema)]
pub(in crate::cli) struct Report {
    /// File of the calibration.
    file: String,
    /// Name of the device; null for a recording without --device.
    device: Option<String>,
    /// affine or second-order.
    model: &'static str,
    /// What the viewer looked at.
    targets: Vec<TargetReport>,
    #[serde(flatten)]
    eyes: Eyes<EyeReport>,
}

/// A value for each eye that the tracker measures, or null.
#[derive(Debug, Serialize, JsonSchema)]
struct Eyes<T> {
    /// The left eye.
    left: Option<T>,
    /// The right eye.
    right: Option<T>,
    /// Both eyes together.
    combined: Option<T>,
}

#[derive(Debug, Serialize, JsonSchema)]
struct TargetReport {
    /// Position in the room, metres, or null.
    place: Option<[f32; 3]>,
    /// Direction from the eyes, in the axes of the head.
    direction: [f32; 3],
    /// Number of samples, or null.
    samples: Option<u32>,
    #[serde(flatten)]
    eyes: Eyes<MeasuredReport>,
}

#[derive(Debug, Serialize, JsonSchema)]
struct MeasuredReport {
    /// Mean of the measurements.
    measured: [f32; 2],
    /// Error of the calibration, degrees.
    residual_deg: f32,
}

#[derive(Debug, Serialize, JsonSchema)]
struct EyeReport {
    /// Root mean square of the errors, degrees.
    rms_deg: f32,
    /// Largest error, degrees.
    largest_deg: f32,
    /// Target of the largest error, from 0.
    worst: usize,
}

impl<T> Eyes<T> {
    fn new([left, right, combined]: [Option<T>; 3]) -> Self {
        Self {
            left,
            right,
            combined,
        }
    }

    fn named(&self) -> impl Iterator<Item = (&'static str, &T)> {
        let eyes = [&self.left, &self.right, &self.combined];
        let eyes = EYES.into_iter().zip(eyes);
        eyes.filter_map(|(name, eye)| Some((name, eye.as_ref()?)))
    }
}

impl Report {
    fn new(name: String, file: &CalibrationFile, fits: &Fits) -> Self {
        let eyes = fits.map(|fit| {
            let residual = fit?.residual();
            Some(EyeReport {
                rms_deg: residual.rms.to_degrees(),
                largest_deg: residual.largest.to_degrees(),
                worst: residual.worst,
            })
        });
        let target = |seen: &SeenTarget| {
            let residuals = CalibrationFile::residuals(fits, seen);
            let eyes = std::array::from_fn(|eye| {
                let (measured, off) = seen.measured[eye].zip(residuals[eye])?;
                Some(MeasuredReport {
                    measured: measured.to_array(),
                    residual_deg: off.to_degrees(),
                })
            });
            TargetReport {
                place: seen.place.map(|place| place.to_array()),
                direction: seen.direction.to_array(),
                samples: seen.samples,
                eyes: Eyes::new(eyes),
            }
        };
        Self {
            file: name,
            device: file.device.clone(),
            model: crate::tracker::calibration::model_name(file.model),
            targets: file.targets.iter().map(target).collect(),
            eyes: Eyes::new(eyes),
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
            for (eye, found) in target.eyes.named() {
                let ([x, y], off) = (found.measured, found.residual_deg);
                write!(f, ", {eye} {x:.3} {y:.3} ({off:.3}° off)")?;
            }
            writeln!(f)?;
        }
        for (eye, fit) in self.eyes.named() {
            let (rms, most, worst) = (fit.rms_deg, fit.largest_deg, fit.worst + 1);
            write!(f, "{eye}: {rms:.3}° rms, at most {most:.3}°, ")?;
            writeln!(f, "for target {worst}")?;
        }
        write!(f, "{}: {} model", self.file, self.model)
    }
}
