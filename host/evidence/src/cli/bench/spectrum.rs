//! `shisen-evidence bench spectrum`: Kishioka's experiment, with numbers.

use super::print;
use crate::measure::{Timed, in_turns};
use crate::quartz::{Quartz, Truth, Window, mean, picture, share};
use crate::table::Table;
use clap::Args;
use schemars::JsonSchema;
use serde::Serialize;
use shisen::cave::Wall;
use shisen::cli::arguments::threads;
use shisen::cli::numbers::whole;
use shisen::cli::output::counted;
use shisen::cli::output::failure::Failure;
use shisen::cli::output::picture_files::{make_writable, metadata};
use shisen::picture::{Picture, PictureError};
use shisen::render::Options;
use shisen::render::spectrum::{Dispersion, Method};
use shisen_core::frame::MAX_SAMPLES;
use shisen_core::spectrum::Wavelengths;
use std::collections::BTreeSet;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

/// Kishioka's experiment: quartz balls by more and more wavelengths
///
/// Renders the built-in scene spheres with each number of wavelengths by the
/// paper's method (a picture of each wavelength with its share of the samples,
/// in Endo's colours), by fixed wavelengths (the same in CIE colours) and by a
/// comb, in turns; times are medians. Colours are compared by CIEDE2000, as a
/// display shows them, with a reference: an eighth more rays, each split into 13
/// wavelengths, in turns 416 in all, in the colours of the CIE's table. How soon a
/// comb is as close to it as the paper's method is found by more and more rays,
/// of which each takes one wavelength, or some, or all. At the default scale all
/// this takes some twenty minutes of one thread.
#[derive(Debug, Args)]
pub(in crate::cli) struct Arguments {
    /// Pixels along each side of the picture
    #[arg(long, value_name = "PIXELS", default_value_t = 512,
          value_parser = whole::<u32>(8..=Wall::MOST_PIXELS))]
    size: u32,
    /// Rays a pixel
    #[arg(long, value_name = "N", default_value_t = 140,
          value_parser = whole::<u16>(1..=MAX_SAMPLES))]
    samples: u16,
    /// The paper's own scale: 2048 pixels a side, 3,500 rays a pixel; takes days
    #[arg(long, conflicts_with_all = ["size", "samples"])]
    paper_scale: bool,
    /// Numbers of wavelengths, 1 to 64
    #[arg(long, value_name = "N,…", default_value = "1,7,10,14", value_delimiter = ',',
          value_parser = whole::<u32>(1..=Wavelengths::MOST))]
    wavelengths: Vec<u32>,
    /// How often to render each picture
    #[arg(long, value_name = "N", default_value_t = 1,
          value_parser = whole::<u32>(1..=1_000))]
    repeat: u32,
    /// Threads to trace on [default: as many as the machine runs at once]
    #[arg(long, value_name = "N", value_parser = threads)]
    threads: Option<NonZeroUsize>,
    /// Write the pictures, and a strip of details of them, to this folder
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

/// Quartz balls by more and more wavelengths.
#[derive(Debug, Serialize, JsonSchema)]
pub(in crate::cli) struct Report {
    /// Threads that trace.
    threads: usize,
    /// Pixels along each side of the picture.
    size: u32,
    /// Rays a pixel.
    samples: u16,
    /// How often each picture was rendered.
    repeat: u32,
    /// Share of the pixels that meet a ball.
    glass_share: f64,
    /// Time of the reference, seconds.
    reference_seconds: f64,
    /// Pictures by each number of wavelengths and each method.
    rows: Vec<Row>,
    /// The fastest comb that is as close to the reference as the paper's method with most
    /// wavelengths; null if that is faster.
    same_error: Option<SameError>,
    /// What a comb costs where a tenth of the pixels meets glass.
    cost: Cost,
    /// What splitting each ray costs where one ball fills the view, one ray a pixel.
    splits: Splits,
    /// Paths of the pictures of --out.
    images: Vec<String>,
}

#[derive(Debug, Serialize, JsonSchema)]
struct Row {
    /// Number of wavelengths.
    wavelengths: u32,
    /// Method: paper, fixed or comb.
    method: &'static str,
    /// Time of the picture, seconds.
    seconds: f64,
    /// Time by that of one wavelength with the same method; null if that was not measured.
    time_ratio: Option<f64>,
    /// Number of rays.
    rays: u64,
    /// Rays by those of one wavelength likewise.
    rays_ratio: Option<f64>,
    /// Mean CIEDE2000 to the reference, of the pixels that meet glass.
    mean_difference: f64,
    /// Greatest CIEDE2000 of these pixels.
    max_difference: f64,
    /// Mean CIEDE2000 of all pixels.
    mean_of_all: f64,
}

#[derive(Debug, Serialize, JsonSchema)]
struct SameError {
    /// Number of wavelengths.
    wavelengths: u32,
    /// Wavelengths of a ray.
    each: u32,
    /// Rays a pixel.
    samples: u16,
    /// Time of the comb, seconds.
    seconds: f64,
    /// Time of the paper's method in turns with it, seconds.
    paper_seconds: f64,
    /// Mean CIEDE2000 to the reference, of the pixels that meet glass.
    mean_difference: f64,
    /// Time of the paper's method by that of the comb.
    speedup: f64,
}

#[derive(Debug, Serialize, JsonSchema)]
struct Cost {
    /// Share of the pixels that meet a ball.
    glass_share: f64,
    /// Rays a pixel.
    samples: u16,
    /// Number of wavelengths.
    wavelengths: u32,
    /// Time of the comb, seconds.
    comb_seconds: f64,
    /// Time without dispersion, seconds.
    plain_seconds: f64,
    /// Time of the comb by time without dispersion.
    ratio: f64,
}

#[derive(Debug, Serialize, JsonSchema)]
struct Splits {
    /// Share of the pixels that meet the ball.
    glass_share: f64,
    /// Time without dispersion, seconds.
    plain_seconds: f64,
    /// Times by the number of wavelengths.
    counts: Vec<Split>,
}

#[derive(Debug, Serialize, JsonSchema)]
struct Split {
    /// Wavelengths into which each ray is split.
    wavelengths: u32,
    /// Time of the picture, seconds.
    seconds: f64,
    /// Time by time without dispersion.
    ratio: f64,
}

const METHODS: [Method; 3] = [Method::Paper, Method::Fixed, Method::Comb];

/// Wavelengths into which each sample of the reference is split.
const REFERENCE_WAVELENGTHS: u32 = 13;

/// Wavelengths into which each ray is split where splitting alone is measured.
const SPLITS: [u32; 3] = [7, 10, 14];

/// The least number of rounds where only the times of frames are used.
const COST_ROUNDS: u32 = 5;

/// Rays a pixel of these frames.
const COST_SAMPLES: u16 = 16;

const ERROR_ROUNDS: u32 = 3;

/// All balls, filling the picture.
const MAIN: Window = Window([-0.44, -0.66], 0.8);

/// All balls, a tenth of the picture.
const WIDE: Window = Window([-0.83, -1.02], 1.58);

/// The largest ball, from edge to edge.
const CLOSE: Window = Window([-0.414, -0.370], 0.404);

/// Returns the median seconds of each way, rendered in turns; a way has its rays a pixel.
fn seconds(quartz: &Quartz, ways: &[(Dispersion, u16)], rounds: u32) -> Result<Vec<f64>, Failure> {
    let timed = in_turns(ways, rounds as usize, |&(way, samples)| {
        Ok::<_, Failure>((quartz.frame(way, samples)?.seconds, ()))
    });
    Ok(timed?.iter().map(Timed::median).collect())
}

fn dispersion(method: Method, count: u32) -> Result<Dispersion, Failure> {
    Dispersion::of(method, count, None).map_err(|error| Failure::usage(&error.to_string()))
}

impl Arguments {
    fn quartz(&self, window: &Window, size: u32) -> Result<Quartz, Failure> {
        let mut options = Options::default();
        if let Some(threads) = self.threads {
            options.threads = threads.get();
        }
        Quartz::new(window, size, options).map_err(Failure::Failed)
    }

    /// Returns a view in which a tenth of the pixels meets glass.
    fn cost(&self, size: u32, wavelengths: u32) -> Result<Cost, Failure> {
        let quartz = self.quartz(&WIDE, size)?;
        let ways = [dispersion(Method::Comb, wavelengths)?, Dispersion::Off];
        let ways = ways.map(|way| (way, COST_SAMPLES));
        let seconds = seconds(&quartz, &ways, self.repeat.max(COST_ROUNDS))?;
        Ok(Cost {
            glass_share: share(&quartz.glass()?),
            samples: COST_SAMPLES,
            wavelengths,
            comb_seconds: seconds[0],
            plain_seconds: seconds[1],
            ratio: seconds[0] / seconds[1],
        })
    }

    /// Returns a view that a ball fills, each ray split.
    fn splits(&self, size: u32) -> Result<Splits, Failure> {
        let quartz = self.quartz(&CLOSE, size)?;
        let mut ways = vec![(Dispersion::Off, 1)];
        for count in SPLITS {
            ways.push((dispersion(Method::Split, count)?, 1));
        }
        let seconds = seconds(&quartz, &ways, self.repeat.max(COST_ROUNDS))?;
        let plain_seconds = seconds[0];
        let counts = SPLITS
            .iter()
            .zip(&seconds[1..])
            .map(|(&wavelengths, &seconds)| Split {
                wavelengths,
                seconds,
                ratio: seconds / plain_seconds,
            });
        Ok(Splits {
            glass_share: share(&quartz.glass()?),
            plain_seconds,
            counts: counts.collect(),
        })
    }
}

// Longer than 80 lines: the report takes a line a field.
pub(in crate::cli) fn run(arguments: &Arguments) -> Result<(), Failure> {
    if let Some(folder) = &arguments.out {
        make_writable(folder)?;
    }
    let (size, samples) = if arguments.paper_scale {
        (2048, 3500)
    } else {
        (arguments.size, arguments.samples)
    };
    let quartz = arguments.quartz(&MAIN, size)?;
    let glass = quartz.glass()?;
    let reference = Wavelengths::new(REFERENCE_WAVELENGTHS, Wavelengths::RANGE)
        .map_err(|error| Failure::usage(&error.to_string()))?;
    let reference = quartz.frame(
        Dispersion::Reference(reference),
        // A few more, so that they go to other places than those of any method.
        samples.saturating_add(samples / 8 + 1).min(MAX_SAMPLES),
    )?;
    let truth = Truth {
        picture: picture(&reference).clone(),
        glass,
    };
    let mut ways = Vec::new();
    for &count in &arguments.wavelengths {
        for method in METHODS {
            ways.push((count, method, dispersion(method, count)?));
        }
    }
    let timed = in_turns(&ways, arguments.repeat as usize, |&(_, _, way)| {
        let frame = quartz.frame(way, samples)?;
        Ok::<_, Failure>((frame.seconds, frame))
    })?;
    let mut rows = Vec::new();
    let mut paper = None;
    let most = arguments.wavelengths.iter().copied().max().unwrap_or(1);
    for (&(wavelengths, method, _), time) in ways.iter().zip(&timed) {
        let [all, own] = truth.differences(picture(&time.first));
        // The same method with one wavelength.
        let base = ways.iter().position(|way| (way.0, way.1) == (1, method));
        let base = base.map(|place| &timed[place]);
        let (seconds, rays) = (time.median(), time.first.statistics.rays());
        if (wavelengths, method) == (most, Method::Paper) {
            paper.get_or_insert((seconds, mean(&own)));
        }
        rows.push(Row {
            wavelengths,
            method: method.name(),
            seconds,
            time_ratio: base.map(|base| seconds / base.median()),
            rays,
            rays_ratio: base.map(|base| rays as f64 / base.first.statistics.rays() as f64),
            mean_difference: mean(&own),
            max_difference: own.iter().copied().fold(0.0, f64::max),
            mean_of_all: mean(&all),
        });
    }
    let same_error = match paper {
        Some(paper) => same_error(&quartz, &truth, paper, most, samples)?,
        None => None,
    };
    let pictures = ways.iter().zip(&timed);
    let pictures: Vec<(u32, &str, &Picture)> = pictures
        .map(|((count, method, _), time)| (*count, method.name(), picture(&time.first)))
        .collect();
    let images = match &arguments.out {
        Some(folder) => write(folder, &pictures, &truth.picture)?,
        None => Vec::new(),
    };
    let report = Report {
        threads: quartz.options.threads,
        size,
        samples,
        repeat: arguments.repeat,
        glass_share: share(&truth.glass),
        reference_seconds: reference.seconds,
        rows,
        same_error,
        cost: arguments.cost(size, most)?,
        splits: arguments.splits(size)?,
        images,
    };
    print(arguments.json, &report, &described(&report))
}

fn described(report: &Report) -> String {
    let table = Table::new(&report.rows)
        .text("method", |one| one.method.to_owned())
        .count("wavelengths", |one| one.wavelengths.into())
        .number("seconds", 3, |one| one.seconds)
        .number("to one", 3, |one| one.time_ratio)
        .number("rays", 3, |one| one.rays_ratio)
        .number("ΔE2000 mean", 2, |one| one.mean_difference)
        .number("max", 1, |one| one.max_difference);
    let same = match &report.same_error {
        None => "No comb is as close as paper in the same time.".to_owned(),
        Some(comb) => format!(
            "A comb with {} of {} wavelengths a ray is as close as paper with {} rays a pixel (ΔE \
             {:.2}), {:.2} times as fast.",
            comb.each, comb.wavelengths, comb.samples, comb.mean_difference, comb.speedup
        ),
    };
    let (cost, splits) = (&report.cost, &report.splits);
    let split = |one: &Split| format!("×{:.2} for {}", one.ratio, one.wavelengths);
    let each = splits.counts.iter().map(split);
    format!(
        "spheres, {0} × {0} pixels, {1} rays a pixel, {2}; {3:.0} % of the pixels meet glass\n\
         {table:#}\n{same}\nWhere {4:.0} % of the pixels meet glass, {5} rays a pixel: {6} \
         wavelengths take {7:.3} of the time without dispersion.\nWhere {8:.0} % do, every ray \
         split: {9}",
        report.size,
        report.samples,
        counted(report.threads as u64, "thread"),
        1e2 * report.glass_share,
        1e2 * cost.glass_share,
        cost.samples,
        cost.wavelengths,
        cost.ratio,
        1e2 * splits.glass_share,
        each.collect::<Vec<_>>().join(", ")
    )
}

/// Returns the fastest comb that is as close to the truth as the paper's pictures of most
/// wavelengths, of which `paper` are the seconds and the mean difference; `None` where these are
/// faster.
fn same_error(
    quartz: &Quartz,
    truth: &Truth,
    paper: (f64, f64),
    most: u32,
    samples: u16,
) -> Result<Option<SameError>, Failure> {
    let Dispersion::Comb(wavelengths, _) = dispersion(Method::Comb, most)? else {
        return Ok(None);
    };
    let (mut fastest, difference) = paper;
    let mut best = None;
    for each in BTreeSet::from([1, most.div_ceil(4), most.div_ceil(2), most]) {
        let way = Dispersion::Comb(wavelengths, each as u8);
        for own in sample_counts(samples) {
            let frame = quartz.frame(way, own)?;
            if frame.seconds >= fastest {
                break;
            }
            let [_, glass] = truth.differences(picture(&frame));
            if mean(&glass) <= difference {
                fastest = frame.seconds;
                best = Some((way, each, own, mean(&glass)));
                break;
            }
        }
    }
    let Some((way, each, own, mean_difference)) = best else {
        return Ok(None);
    };
    let ways = [(dispersion(Method::Paper, most)?, samples), (way, own)];
    let seconds = seconds(quartz, &ways, ERROR_ROUNDS)?;
    Ok(Some(SameError {
        wavelengths: most,
        each,
        samples: own,
        seconds: seconds[1],
        paper_seconds: seconds[0],
        mean_difference,
        speedup: seconds[0] / seconds[1],
    }))
}

fn sample_counts(most: u16) -> impl Iterator<Item = u16> {
    let powers = (1..15).map(|power| 1u16 << power);
    let all = powers.flat_map(|power| [power, power + power / 2]);
    std::iter::once(1)
        .chain(all)
        .take_while(move |&number| number <= most)
}

fn write(
    folder: &Path,
    pictures: &[(u32, &str, &Picture)],
    reference: &Picture,
) -> Result<Vec<String>, Failure> {
    let mut paths = Vec::new();
    let mut write = |name: &str, picture: &Picture, note: String| -> Result<(), Failure> {
        let path = folder.join(format!("{name}.png"));
        picture
            .write_png(&path, &metadata(note))
            .map_err(Failure::from_error)?;
        paths.push(path.display().to_string());
        Ok(())
    };
    for (count, method, picture) in pictures {
        let note = format!("scene spheres, {count} wavelengths, {method}");
        write(&format!("{method}-{count}"), picture, note)?;
    }
    write(
        "reference",
        reference,
        "scene spheres, the reference".into(),
    )?;
    let rows = ["paper", "comb"].map(|row| {
        let own = pictures.iter().filter(|(_, method, _)| *method == row);
        own.map(|(_, _, picture)| *picture).collect::<Vec<_>>()
    });
    let note = "details: the paper's method above, a comb below".to_owned();
    let strip = strip(&rows).map_err(Failure::from_error)?;
    write("strip", &strip, note)?;
    Ok(paths)
}

/// The detail that a strip shows: its middle and its side, in sides of the
/// picture.
const DETAIL: ([f64; 2], f64) = ([0.52, 0.83], 0.16);

/// Pixels a side of a detail in a strip, at least.
const DETAIL_PIXELS: u32 = 256;

const GAP: u32 = 4;

/// Returns rows of pictures' details, enlarged by whole pixels, on white.
///
/// # Errors
/// More pixels than there is memory for.
fn strip(rows: &[Vec<&Picture>]) -> Result<Picture, PictureError> {
    let width = rows.iter().flatten().next().map_or(1, |one| one.width);
    let ([x, y], side) = DETAIL;
    let pixels = |share: f64| (share * f64::from(width)) as u32;
    let side = pixels(side).max(1);
    let first = [pixels(x), pixels(y)].map(|middle| middle.saturating_sub(side / 2));
    let scale = DETAIL_PIXELS.div_ceil(side);
    let cell = side * scale + GAP;
    let columns = rows.iter().map(Vec::len).max().unwrap_or(0) as u32;
    let mut strip = Picture::new(columns * cell + GAP, rows.len() as u32 * cell + GAP)?;
    strip.pixels.fill([1.0; 4]);
    for (row, pictures) in (0..).zip(rows) {
        for (column, picture) in (0..).zip(pictures) {
            for y in 0..side * scale {
                for x in 0..side * scale {
                    let from = picture.pixel(first[0] + x / scale, first[1] + y / scale);
                    let to = (column * cell + GAP + x, row * cell + GAP + y);
                    strip.set_pixel(to.0, to.1, from.unwrap_or_default());
                }
            }
        }
    }
    Ok(strip)
}
