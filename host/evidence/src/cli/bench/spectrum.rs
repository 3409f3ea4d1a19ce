//! `shisen-evidence bench spectrum`: Kishioka's experiment, with numbers.

mod report;
mod views;

use clap::Args;
use report::{Cost, Report, Row, SameError, Split, Splits};
use shisen::bake::{BakedScene, Layout};
use shisen::cave::{Cave, Eye, Viewer, Wall};
use shisen::cli::arguments::source::bake;
use shisen::cli::arguments::{threads, whole};
use shisen::cli::output::failure::Failure;
use shisen::cli::output::picture_files::{make_writable, metadata};
use shisen::cli::output::print;
use shisen::live::quantiles::median;
use shisen::picture::{Picture, colour_differences};
use shisen::render::effects::Effects;
use shisen::render::spectrum::{Dispersion, Method};
use shisen::render::{self, Frame, Observer, Options};
use shisen::scene::builtin::spheres;
use shisen::with_scene;
use shisen_core::frame::MAX_SAMPLES;
use shisen_core::scene::EffectSet;
use shisen_core::spectrum::Wavelengths;
use std::collections::BTreeSet;
use std::num::NonZeroUsize;
use std::path::PathBuf;
use views::{CLOSE, MAIN, WIDE, strip};

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
///
/// With --json, one object: threads, size, samples, repeat, `glass_share` (of the
/// pixels, those that meet a ball), `reference_seconds`, rows: for each number of wavelengths and method (paper, fixed or comb)
/// wavelengths, method, seconds, `time_ratio` (to one wavelength by the same
/// method; null where one is not among them), rays, `rays_ratio` (the same of all
/// rays), and against the reference `mean_difference` and `max_difference` of the
/// pixels with glass and `mean_of_all` of all; `same_error`: the comb
/// that is as close to the reference as the paper's method with most wavelengths,
/// soonest (null where none is sooner): wavelengths, each (of these, a ray takes),
/// samples, seconds, `paper_seconds` (in turns with it), `mean_difference`,
/// `speedup`; cost: of a view in which a tenth of the pixels
/// meets glass `glass_share`, samples, wavelengths, `comb_seconds`,
/// `plain_seconds` (without dispersion), ratio; splits: of a view that one ball
/// fills, each ray split, one ray a pixel: `glass_share`, `plain_seconds` and
/// counts: wavelengths, seconds and ratio; images (paths).
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

/// The ways whose pictures are compared.
const METHODS: [Method; 3] = [Method::Paper, Method::Fixed, Method::Comb];

/// Wavelengths into which each sample of the reference is split.
const REFERENCE_WAVELENGTHS: u32 = 13;

/// Wavelengths into which each ray is split where that alone is measured.
const SPLITS: [u32; 3] = [7, 10, 14];

/// How often frames are rendered whose times alone matter, at least.
const COST_ROUNDS: u32 = 5;

/// How often frames of the same error are.
const ERROR_ROUNDS: u32 = 3;

/// Rays a pixel of the former.
const COST_SAMPLES: u16 = 16;

/// The scene before one wall, for one eye.
struct Bench {
    scene: BakedScene,
    cave: Cave,
    options: Options,
}

impl Bench {
    fn new(arguments: &Arguments, wall: &views::View, size: u32) -> Result<Self, Failure> {
        let mut options = Options::default();
        if let Some(threads) = arguments.threads {
            options.threads = threads.get();
        }
        Ok(Self {
            scene: bake(&spheres(), "spheres", Layout::Fast, None)?,
            cave: Cave::new(vec![wall.wall(size)?])?,
            options,
        })
    }

    fn render(&self, dispersion: Dispersion, samples: u16) -> Result<Frame, Failure> {
        let mut options = Options {
            dispersion,
            ..self.options
        };
        options.settings.samples = samples;
        self.frame(&options)
    }

    fn frame(&self, options: &Options) -> Result<Frame, Failure> {
        let eye = [Observer::new(
            Eye::Centre,
            Viewer::default().eye(Eye::Centre),
        )];
        let (cave, quiet) = (&self.cave, |_, _| {});
        Ok(with_scene!(&self.scene, |scene| render::cave(
            &scene, cave, &eye, options, &quiet
        ))?)
    }

    /// Which pixels meet glass: they change where none lets light through.
    fn glass(&self) -> Result<Vec<bool>, Failure> {
        let mut options = self.options;
        options.settings.samples = 4;
        let with = self.frame(&options)?;
        options.effects = Effects::AUTO.less(EffectSet::REFRACTION);
        let without = self.frame(&options)?;
        let pixels = picture(&with).pixels.iter();
        Ok(pixels
            .zip(&picture(&without).pixels)
            .map(|(a, b)| a != b)
            .collect())
    }

    /// Medians of the seconds of frames, in turns, of so many samples each.
    fn seconds(&self, ways: &[(Dispersion, u16)], rounds: u32) -> Result<Vec<f64>, Failure> {
        let mut seconds = vec![Vec::new(); ways.len()];
        for _ in 0..rounds {
            for ((way, samples), seconds) in ways.iter().zip(&mut seconds) {
                seconds.push(self.render(*way, *samples)?.seconds);
            }
        }
        Ok(seconds.into_iter().map(median).collect())
    }
}

/// Of the only wall.
fn picture(frame: &Frame) -> &Picture {
    &frame.pictures[0].picture
}

fn share(glass: &[bool]) -> f64 {
    glass.iter().filter(|&&glass| glass).count() as f64 / glass.len() as f64
}

/// How far a picture is from the reference.
#[derive(Debug, Clone, Copy)]
struct Difference {
    /// Of the pixels with glass.
    mean: f64,
    max: f64,
    of_all: f64,
}

impl Difference {
    fn new(found: &Picture, reference: &Picture, glass: &[bool]) -> Self {
        let all = colour_differences(found, reference);
        let mean =
            |of: &[f32]| of.iter().copied().map(f64::from).sum::<f64>() / of.len().max(1) as f64;
        let pairs = all.iter().zip(glass);
        let own: Vec<f32> = pairs
            .filter_map(|(&off, &glass)| glass.then_some(off))
            .collect();
        Self {
            mean: mean(&own),
            max: own.iter().copied().fold(0.0, f32::max).into(),
            of_all: mean(&all),
        }
    }
}

fn dispersion(method: Method, count: u32) -> Result<Dispersion, Failure> {
    Dispersion::of(method, count, None).map_err(|error| Failure::usage(&error.to_string()))
}

/// Runs the command.
pub(in crate::cli) fn run(arguments: &Arguments) -> Result<(), Failure> {
    if let Some(folder) = &arguments.out {
        make_writable(folder)?;
    }
    let (size, samples) = if arguments.paper_scale {
        (2048, 3500)
    } else {
        (arguments.size, arguments.samples)
    };
    let bench = Bench::new(arguments, &MAIN, size)?;
    let glass = bench.glass()?;
    let reference = Wavelengths::new(REFERENCE_WAVELENGTHS, Wavelengths::RANGE)
        .map_err(|error| Failure::usage(&error.to_string()))?;
    let reference = bench.render(
        Dispersion::Reference(reference),
        // A few more, so that they go to other places than those of any method.
        samples.saturating_add(samples / 8 + 1).min(MAX_SAMPLES),
    )?;
    let mut ways = Vec::new();
    for &count in &arguments.wavelengths {
        for method in METHODS {
            ways.push((count, method, dispersion(method, count)?));
        }
    }
    let mut seconds = vec![Vec::new(); ways.len()];
    let mut frames = Vec::new();
    for round in 0..arguments.repeat {
        for ((_, _, way), seconds) in ways.iter().zip(&mut seconds) {
            let frame = bench.render(*way, samples)?;
            seconds.push(frame.seconds);
            if round == 0 {
                frames.push(frame);
            }
        }
    }
    let seconds: Vec<f64> = seconds.into_iter().map(median).collect();
    let rays = |frame: &Frame| frame.statistics.rays();
    // Of the same method with one wavelength.
    let base = |method: Method| {
        let place = ways.iter().position(|way| (way.0, way.1) == (1, method))?;
        Some((seconds[place], rays(&frames[place])))
    };
    let mut rows = Vec::new();
    for (number, ((count, method, _), frame)) in ways.iter().zip(&frames).enumerate() {
        let off = Difference::new(picture(frame), picture(&reference), &glass);
        let base = base(*method);
        rows.push(Row {
            wavelengths: *count,
            method: method.name(),
            seconds: seconds[number],
            time_ratio: base.map(|(base, _)| seconds[number] / base),
            rays: rays(frame),
            rays_ratio: base.map(|(_, base)| rays(frame) as f64 / base as f64),
            mean_difference: off.mean,
            max_difference: off.max,
            mean_of_all: off.of_all,
        });
    }
    let most = arguments.wavelengths.iter().copied().max().unwrap_or(1);
    let against = (picture(&reference), glass.as_slice());
    let same_error = same_error(&bench, &rows, most, samples, against)?;
    let pictures: Vec<(u32, &str, &Picture)> = ways
        .iter()
        .zip(&frames)
        .map(|((count, method, _), frame)| (*count, method.name(), picture(frame)))
        .collect();
    let images = match &arguments.out {
        Some(folder) => write(folder, &pictures, picture(&reference))?,
        None => Vec::new(),
    };
    print(
        &Report {
            threads: bench.options.threads,
            size,
            samples,
            repeat: arguments.repeat,
            glass_share: share(&glass),
            reference_seconds: reference.seconds,
            rows,
            same_error,
            cost: cost(arguments, size, most)?,
            splits: splits(arguments, size)?,
            images,
        },
        arguments.json,
    )
}

/// The comb that is soonest as close to the reference as the paper's pictures of
/// most wavelengths; `None` where they are sooner.
fn same_error(
    bench: &Bench,
    rows: &[Row],
    most: u32,
    samples: u16,
    (reference, glass): (&Picture, &[bool]),
) -> Result<Option<SameError>, Failure> {
    let paper = rows
        .iter()
        .find(|row| row.wavelengths == most && row.method == Method::Paper.name());
    let (Some(paper), Dispersion::Comb(wavelengths, _)) = (paper, dispersion(Method::Comb, most)?)
    else {
        return Ok(None);
    };
    let mut sooner = paper.seconds;
    let mut best = None;
    for each in BTreeSet::from([1, most.div_ceil(4), most.div_ceil(2), most]) {
        let way = Dispersion::Comb(wavelengths, each as u8);
        for own in numbers(samples) {
            let frame = bench.render(way, own)?;
            if frame.seconds >= sooner {
                break;
            }
            let off = Difference::new(picture(&frame), reference, glass).mean;
            if off <= paper.mean_difference {
                sooner = frame.seconds;
                best = Some((way, each, own, off));
                break;
            }
        }
    }
    let Some((way, each, own, mean_difference)) = best else {
        return Ok(None);
    };
    let ways = [(dispersion(Method::Paper, most)?, samples), (way, own)];
    let seconds = bench.seconds(&ways, ERROR_ROUNDS)?;
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

/// 1, 2, 3, 4, 6, 8, 12 and so on.
fn numbers(most: u16) -> impl Iterator<Item = u16> {
    let powers = (0..15).map(|power| 1u16 << power);
    let all = powers.flat_map(|power| [power, power + power / 2]);
    all.skip(1)
        .filter(|&number| number > 0)
        .take_while(move |&number| number <= most)
}

/// A view in which a tenth of the pixels meets glass.
fn cost(arguments: &Arguments, size: u32, wavelengths: u32) -> Result<Cost, Failure> {
    let bench = Bench::new(arguments, &WIDE, size)?;
    let ways = [dispersion(Method::Comb, wavelengths)?, Dispersion::Off];
    let ways = ways.map(|way| (way, COST_SAMPLES));
    let seconds = bench.seconds(&ways, arguments.repeat.max(COST_ROUNDS))?;
    Ok(Cost {
        glass_share: share(&bench.glass()?),
        samples: COST_SAMPLES,
        wavelengths,
        comb_seconds: seconds[0],
        plain_seconds: seconds[1],
        ratio: seconds[0] / seconds[1],
    })
}

/// A view that a ball fills, each ray split.
fn splits(arguments: &Arguments, size: u32) -> Result<Splits, Failure> {
    let bench = Bench::new(arguments, &CLOSE, size)?;
    let mut ways = vec![(Dispersion::Off, 1)];
    for count in SPLITS {
        ways.push((dispersion(Method::Split, count)?, 1));
    }
    let seconds = bench.seconds(&ways, arguments.repeat.max(COST_ROUNDS))?;
    let plain = seconds[0];
    let counts = SPLITS.iter().zip(&seconds[1..]);
    Ok(Splits {
        glass_share: share(&bench.glass()?),
        plain_seconds: plain,
        counts: counts
            .map(|(&wavelengths, &seconds)| Split {
                wavelengths,
                seconds,
                ratio: seconds / plain,
            })
            .collect(),
    })
}

/// Writes the pictures and the strip.
fn write(
    folder: &std::path::Path,
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
        "scene spheres, the reference".to_owned(),
    )?;
    let rows = ["paper", "comb"].map(|row| {
        let of_row = pictures.iter().filter(|(_, method, _)| *method == row);
        of_row.map(|(_, _, picture)| *picture).collect::<Vec<_>>()
    });
    let note = "details: the paper's method above, a comb below".to_owned();
    let strip = strip(&rows).map_err(Failure::from_error)?;
    write("strip", &strip, note)?;
    Ok(paths)
}
