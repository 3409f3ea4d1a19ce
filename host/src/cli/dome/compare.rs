//! `shisen dome compare`: a mirror's dome master against the true one.

use super::arguments::MappingChoice;
use super::camera::{MirrorChoice, trace, view};
use crate::bake::Layout;
use crate::cli::arguments::source::bake;
use crate::cli::arguments::threads;
use crate::cli::arguments::whole;
use crate::cli::output::failure::Failure;
use crate::cli::output::picture_files::{hexadecimal, make_writable, metadata};
use crate::cli::output::print;
use crate::dome::Named;
use crate::picture::Picture;
use crate::render::Options;
use crate::scene::camera::DomeCamera;
use clap::Args;
use serde::Serialize;
use shisen_core::frame::{DomeProjection, MAX_SAMPLES, View};
use std::f32::consts::PI;
use std::fmt;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

/// Shows where a mirror's dome master is off the true one
///
/// Writes a PNG of meridians and parallels every 10° on a sphere about the
/// screen's centre: red where only the true dome master has a line, cyan where
/// only the mirror's has, white where both have.
///
/// With --json, one object: image (path), hash (16 hexadecimal digits over all
/// pixels), differing (pixels inside the rim where one has a line and the other
/// not, by more than half), `true_lines` and `simulated_lines` (pixels of lines),
/// pixels (inside the rim), config (null where there is no mirror), mapping, distance (mirror radii), viewpoint
/// (radii from the screen's centre), size, samples and seconds (of tracing both).
#[derive(Debug, Args)]
pub(in crate::cli) struct Arguments {
    #[command(flatten)]
    mirror: MirrorChoice,
    /// Radius of the sphere, in equatorial radii of the mirror
    #[arg(long, value_name = "RADII", default_value_t = 100.0, allow_hyphen_values = true,
          value_parser = super::camera::distance)]
    distance: f64,
    /// Columns and rows
    #[arg(long, value_name = "PIXELS", default_value_t = 1024,
          value_parser = whole::<u32>(1..=View::MOST_PIXELS))]
    size: u32,
    /// Rays a pixel
    #[arg(long, value_name = "N", default_value_t = 1,
          value_parser = whole::<u16>(1..=MAX_SAMPLES))]
    samples: u16,
    /// Threads to trace on [default: as many as the machine runs at once]
    #[arg(long, value_name = "N", value_parser = threads)]
    threads: Option<NonZeroUsize>,
    /// Folder of compare.png, made where it does not exist, or the picture
    /// itself
    #[arg(long, value_name = "DIR|FILE.png", default_value = "shisen-out")]
    out: PathBuf,
    /// Show no progress
    #[arg(long)]
    quiet: bool,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

/// How far the two are apart.
#[derive(Debug, Serialize)]
struct Report {
    image: String,
    hash: String,
    differing: u64,
    true_lines: u64,
    simulated_lines: u64,
    pixels: u64,
    config: Option<&'static str>,
    mapping: &'static str,
    distance: f64,
    viewpoint: f64,
    size: u32,
    samples: u16,
    seconds: f64,
}

/// Runs the command.
pub(super) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let MappingChoice(mapping) = arguments.mirror.mapping;
    // Both are taken from the camera's place, the mirror by its viewpoint.
    let camera = DomeCamera::UPRIGHT;
    let distance = arguments.distance;
    let optics = arguments.mirror.optics(false, PI, Some(distance))?;
    let simulated = view(optics.projection, &camera, arguments.size)?;
    let truth = DomeProjection::Equidistant { field_of_view: PI };
    let truth = view(truth, &camera, arguments.size)?;
    let scene = optics.grid(distance, &camera)?;
    let baked = bake(&scene, "grid", Layout::Fast, None)?;
    let path = path(&arguments.out);
    make_writable(path.parent().unwrap_or(Path::new("")))?;
    let mut options = Options {
        tile: 8,
        ..Options::default()
    };
    options.settings.samples = arguments.samples;
    if let Some(threads) = arguments.threads {
        options.threads = threads.get();
    }
    let quiet = arguments.quiet || arguments.json;
    let truth = trace(&baked, &truth, &options, quiet)?;
    let simulated = trace(&baked, &simulated, &options, quiet)?;
    let (config, mapping) = (optics.config.map(Named::name), mapping.name());
    let mut report = Report {
        image: path.display().to_string(),
        hash: String::new(),
        differing: 0,
        true_lines: 0,
        simulated_lines: 0,
        pixels: 0,
        config,
        mapping,
        distance,
        viewpoint: optics.viewpoint,
        size: arguments.size,
        samples: arguments.samples,
        seconds: truth.seconds + simulated.seconds,
    };
    let mut picture = simulated.picture;
    report.overlay(&truth.picture, &mut picture);
    report.hash = hexadecimal(picture.hash());
    let name = config.unwrap_or("no mirror");
    let note = format!("grid at {distance} radii, {name} ({mapping}): red true, cyan simulated");
    picture
        .write_png_with_alpha(&path, &metadata(note))
        .map_err(Failure::from_error)?;
    print(&report, arguments.json)
}

/// The picture that `--out` names.
fn path(out: &Path) -> PathBuf {
    let is_picture = out
        .extension()
        .is_some_and(|extension| extension.eq_ignore_ascii_case("png"));
    if is_picture {
        out.to_owned()
    } else {
        out.join("compare.png")
    }
}

impl Report {
    /// Counts where two pictures are apart, and puts the true one into the
    /// other's red.
    fn overlay(&mut self, truth: &Picture, simulated: &mut Picture) {
        for (pixel, &[of_true, _, _, alpha]) in simulated.pixels.iter_mut().zip(&truth.pixels) {
            let of_mirror = pixel[0];
            self.pixels += u64::from(alpha > 0.5);
            self.true_lines += u64::from(of_true > 0.5);
            self.simulated_lines += u64::from(of_mirror > 0.5);
            self.differing += u64::from((of_true - of_mirror).abs() > 0.5);
            *pixel = [of_true, of_mirror, of_mirror, pixel[3]];
        }
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{} ({}) at {} radii: {} of {} pixels differ\n{}",
            self.config.unwrap_or("no mirror"),
            self.mapping,
            self.distance,
            self.differing,
            self.pixels,
            self.image
        )
    }
}
