//! `shisen dome compare`: a mirror's dome master against the true one.

use super::camera::{MirrorChoice, trace, view};
use crate::bake::Layout;
use crate::cli::arguments::source::bake;
use crate::cli::arguments::threads;
use crate::cli::output::progress::Ticker;
use crate::cli::prelude::*;
use crate::dome::Named;
use crate::render::Options;
use crate::scene::camera::DomeCamera;
use shisen_core::frame::{DomeProjection, MAX_SAMPLES, View};
use std::f32::consts::PI;
use std::num::NonZeroUsize;

/// Shows where a mirror's dome master differs from the true one
#[derive(Debug, Args)]
pub(in crate::cli) struct Arguments {
    #[command(flatten)]
    mirror: MirrorChoice,
    /// Radius of the sphere, equatorial radii of the mirror
    #[arg(long, value_name = "RADII", default_value_t = 100.0,
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
    /// Threads to trace with [default: one for each processor]
    #[arg(long, value_name = "N", value_parser = threads)]
    threads: Option<NonZeroUsize>,
    /// Folder of compare.png, made if it does not exist, or the picture itself
    #[arg(long, value_name = "DIR|FILE.png", default_value = "shisen-out")]
    out: PathBuf,
    /// Show no progress
    #[arg(long)]
    quiet: bool,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

/// The difference between the two pictures.
#[derive(Debug, Serialize, JsonSchema)]
pub(in crate::cli) struct Report {
    /// File of the picture.
    image: String,
    /// Hash of all pixels, 16 hexadecimal digits.
    hash: String,
    /// Pixels within the rim that have a line in only one picture, by more than half.
    differing: u64,
    /// Pixels of lines in the true picture.
    true_lines: u64,
    /// Pixels of lines in the mirror's picture.
    simulated_lines: u64,
    /// Pixels within the rim.
    pixels: u64,
    /// Name of the mirror; null without a mirror.
    config: Option<&'static str>,
    /// How pixels become directions: mirror, exact or true.
    mapping: &'static str,
    /// Radius of the sphere, mirror radii.
    distance: f64,
    /// Viewpoint from the screen's centre, mirror radii.
    viewpoint: f64,
    /// Columns and rows.
    size: u32,
    /// Rays a pixel.
    samples: u16,
    /// Time to trace both pictures.
    seconds: f64,
}

pub(super) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let mapping = arguments.mirror.mapping;
    // Both pictures are taken from the camera's position, the mirror's from its viewpoint.
    let camera = DomeCamera::UPRIGHT;
    let distance = arguments.distance;
    let optics = arguments.mirror.optics(false, PI, Some(distance))?;
    let simulated = view(optics.projection, &camera, arguments.size)?;
    let truth = DomeProjection::Equidistant { field_of_view: PI };
    let truth = view(truth, &camera, arguments.size)?;
    let scene = optics.grid(distance, &camera)?;
    let ticker = Ticker::start("baking the grid".to_owned(), arguments.quiet);
    let (baked, _) = bake(&scene, "grid", Layout::Fast, None, &ticker)?;
    drop(ticker);
    let mut path = arguments.out.clone();
    if !is_png(&path) {
        path.push("compare.png");
    }
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
    let truth = trace(baked.scene(), &truth, &options, quiet)?;
    let simulated = trace(baked.scene(), &simulated, &options, quiet)?;
    let (mut differing, mut true_lines, mut simulated_lines, mut pixels) = (0, 0, 0, 0);
    // The true picture shows in the red of the mirror's.
    let mut picture = simulated.picture;
    for (pixel, &[of_true, _, _, alpha]) in picture.pixels.iter_mut().zip(&truth.picture.pixels) {
        let of_mirror = pixel[0];
        pixels += u64::from(alpha > 0.5);
        true_lines += u64::from(of_true > 0.5);
        simulated_lines += u64::from(of_mirror > 0.5);
        differing += u64::from((of_true - of_mirror).abs() > 0.5);
        *pixel = [of_true, of_mirror, of_mirror, pixel[3]];
    }
    let (config, mapping) = (optics.config.map(Named::name), mapping.name());
    let name = config.unwrap_or("no mirror");
    let note = format!("grid at {distance} radii, {name} ({mapping}): red true, cyan simulated");
    let written = picture.write_png_with_alpha(&path, &metadata(note));
    written.or_fail()?;
    let report = Report {
        image: path.display().to_string(),
        hash: hexadecimal(picture.hash()),
        differing,
        true_lines,
        simulated_lines,
        pixels,
        config,
        mapping,
        distance,
        viewpoint: optics.viewpoint,
        size: arguments.size,
        samples: arguments.samples,
        seconds: truth.seconds + simulated.seconds,
    };
    print(&report, arguments.json)
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = self.config.unwrap_or("no mirror");
        let (mapping, distance, image) = (self.mapping, self.distance, &self.image);
        let (differing, pixels) = (self.differing, self.pixels);
        write!(f, "{name} ({mapping}) at {distance} radii: ")?;
        write!(f, "{differing} of {pixels} pixels differ\n{image}")
    }
}
