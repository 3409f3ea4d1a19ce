//! Wavelengths: how many, and how rays take them.

use super::{Bench, Cause, Comparison, Limit, Measure, Point, Section, limit, measure};
use crate::measure::Timed;
use crate::quartz::{Quartz, Truth, Window, mean, picture, share};
use rayon::iter::{IntoParallelIterator, ParallelIterator};
use shisen::live::quantiles::quantile_of;
use shisen::picture::Picture;
use shisen::render::spectrum::{Dispersion, Method};
use shisen::render::{self, Frame};
use shisen_core::spectrum::Wavelengths;
use std::thread::{self, ScopedJoinHandle};

/// The wavelengths of each ray of the truth; with the phases of a comb 416 in all.
const TRUE_WAVELENGTHS: u32 = 13;

/// The windows' corners on the lower half of the smallest ball, as in [`Window`]: details
/// without common pixels.
const LOWER_LEFT: [[f64; 2]; 5] = [
    [-0.088, -0.588],
    [-0.0771, -0.5813],
    [-0.0993, -0.5797],
    [-0.0837, -0.5951],
    [-0.0949, -0.5911],
];
/// The windows' side, metres.
const SIDE: f64 = 0.128;

/// Rays a pixel, as in the paper's experiment.
const SAMPLES: u16 = 56;

/// Rays a pixel where each takes all wavelengths.
const SPLIT_SAMPLES: u16 = 8;

/// Rays a pixel of each wavelength's picture, for any number of wavelengths.
const RAYS_OF_EACH: u16 = 8;

/// Wavelengths of the truth where their number alone differs: the most there may be.
const MOST_WAVELENGTHS: u32 = Wavelengths::MOST;

// Longer than 80 lines: half of it is the report.
pub(super) fn section(bench: &Bench<'_>) -> Result<Section, Cause> {
    let size = bench.effort.pick(24, 48);
    let windows = LOWER_LEFT[bench.effort.pick(1..3, 0..LOWER_LEFT.len())].iter();
    let details = windows.map(|&at| Quartz::new(&Window(at, SIDE), size, bench.options()));
    let details: Vec<Quartz> = details.collect::<Result<_, _>>()?;
    // The truth is one of samples, too.
    let samples: u16 = bench.effort.pick(400, 512);
    let reference = Wavelengths::new(TRUE_WAVELENGTHS, Wavelengths::RANGE)?;
    let (truths, rougher) = truths(
        bench,
        &details,
        [samples, samples - samples / 4],
        |quartz, samples| {
            quartz
                .frame(Dispersion::Reference(reference), samples)
                .map_err(Cause::from)
        },
    )?;
    let truths = details.iter().zip(truths).map(|(quartz, picture)| {
        let glass = quartz.glass()?;
        Ok(Truth { picture, glass })
    });
    let mut truths = truths.collect::<Result<Vec<_>, Cause>>()?;
    (bench.progress)(0.2);
    let about = format!(
        "{} details of a ball of quartz on a checkered floor, {size}² pixels each and no two pixels \
         alike, of which {:.0} % meet glass; errors are of these: CIEDE2000 of what a display \
         shows. The paper's method and fixed wavelengths are a picture for each wavelength, of a \
         part of {SAMPLES} rays a pixel; of a comb each of {SAMPLES} rays takes one wavelength, or \
         each of fewer rays several; split, each of {SPLIT_SAMPLES} rays takes all. The truth are \
         {samples} rays a pixel, each split into {TRUE_WAVELENGTHS} wavelengths, in turns 416, in \
         the colours of the CIE's table; with a quarter fewer rays it is off by {:.2} itself (95 %).",
        details.len(),
        100.0
            * share(
                &truths
                    .iter()
                    .flat_map(|one| one.glass.clone())
                    .collect::<Vec<_>>()
            ),
        off_by(&truths[0], &rougher),
    );
    let settings = settings(bench)?;
    let measured = render_all(bench, &settings, &details, (0.2, 0.85))?;
    let mut points = Vec::new();
    for (one, time) in settings.iter().zip(&measured) {
        points.push(one.measured(&truths, time));
    }
    let errors = || points.iter().map(Point::error).enumerate();
    let best = errors()
        .min_by(|a, b| a.1.total_cmp(&b.1))
        .map(|(number, error)| {
            let caption = format!(
                "{}: the nearest, 95 % are below {error:.2}",
                points[number].name
            );
            (caption, picture(&measured[number].first[0]).clone())
        });
    let comparison = Comparison::new(
        ("wavelengths", "How many wavelengths, and how"),
        "One wavelength means no dispersion: the index of the d line for all colours, except in the \
         paper's method and fixed wavelengths, which have a picture of that wavelength. With equal \
         rays more wavelengths are not always nearer: each has fewer rays, 8 at 7 wavelengths and \
         one or two at 40, and edges drawn by so few rays have colours of their own, which are most \
         of the error. With 64 or 128 rays of all wavelengths edges add little. The cost of the \
         number of wavelengths by itself is below. Differences below the standard deviation between \
         details (±) are chance.",
        MEASURES.to_vec(),
        LIMIT,
        points,
    )
    .logarithmic();
    let numbers = numbers_alone(bench, &details, &truths)?;
    let choice = format!(
        "{} The number of wavelengths by itself: {}",
        comparison.choice, numbers.choice
    );
    let comparisons = vec![comparison, numbers];
    let mut section = Section::new("spectrum", "Wavelengths", about, comparisons);
    section.choice = choice;
    let plain = details[0].frame(Dispersion::Off, SAMPLES)?;
    section.pictures = vec![
        ("The truth".to_owned(), truths.swap_remove(0).picture),
        ("Without dispersion".to_owned(), picture(&plain).clone()),
    ];
    section.pictures.extend(best);
    Ok(section)
}

/// Returns the difference that 95 % of the pixels with glass are below.
fn off_by(truth: &Truth, found: &Picture) -> f64 {
    let [_, glass] = truth.differences(found);
    quantile_of(glass, 0.95)
}

const MEASURES: [Measure; 5] = [
    measure("de2000_95", "95 % ΔE2000"),
    measure("de2000_95_deviation", "±, of details"),
    measure("de2000_mean", "mean ΔE2000"),
    measure("de2000_mean_deviation", "±, of details"),
    measure("de2000_max", "largest ΔE2000"),
];

const LIMIT: Limit = limit(
    1.0,
    "nobody sees this difference; a twentieth of the pixels may be farther off",
);

/// Renders all details by each setting: a picture this small keeps one thread busy, and its
/// time is its own.
fn render_all(
    bench: &Bench<'_>,
    settings: &[Setting],
    details: &[Quartz],
    share: (f64, f64),
) -> Result<Vec<Timed<Vec<Frame>>>, Cause> {
    bench.in_turns(settings, share, |one| {
        let mut frames = Vec::new();
        for some in details.chunks(bench.threads) {
            // Not on a pool, whose threads do other frames' work while their own waits.
            let each: Vec<_> = thread::scope(|scope| {
                let frame = |quartz| scope.spawn(move || one.frame(quartz));
                let started: Vec<_> = some.iter().map(frame).collect();
                started.into_iter().map(ScopedJoinHandle::join).collect()
            });
            for frame in each {
                frames.push(frame.unwrap_or_else(|panic| std::panic::resume_unwind(panic))?);
            }
        }
        Ok((frames.iter().map(|frame| frame.seconds).sum(), frames))
    })
}

/// Renders a truth of each detail from as much of something as there is, and of the first
/// detail from less. All run beside one another: none is timed.
fn truths<N: Copy + Send + Sync>(
    bench: &Bench<'_>,
    details: &[Quartz],
    [much, less]: [N; 2],
    frame: impl Fn(&Quartz, N) -> Result<Frame, Cause> + Sync,
) -> Result<(Vec<Picture>, Picture), Cause> {
    let each = (0..=details.len()).into_par_iter().map(|number| {
        let (quartz, count) = match details.get(number) {
            Some(quartz) => (quartz, much),
            None => (&details[0], less),
        };
        Ok(frame(quartz, count)?.pictures.swap_remove(0).picture)
    });
    let each = render::pool(bench.threads)?.install(|| each.collect::<Result<Vec<_>, Cause>>());
    let mut pictures = each?;
    let rougher = pictures.swap_remove(details.len());
    Ok((pictures, rougher))
}

/// Returns the cost of the number of wavelengths by itself: with as many rays for each wavelength
/// as in the truth edges are drawn alike, and add no error.
fn numbers_alone(
    bench: &Bench<'_>,
    details: &[Quartz],
    truths_of_all: &[Truth],
) -> Result<Comparison, Cause> {
    let counts = [MOST_WAVELENGTHS, MOST_WAVELENGTHS - MOST_WAVELENGTHS / 4];
    let (pictures, fewer) = truths(bench, details, counts, |quartz, count| {
        Setting::alone(count)?.frame(quartz)
    })?;
    let alike = pictures.into_iter().zip(truths_of_all);
    let alike = alike.map(|(picture, one)| Truth {
        picture,
        glass: one.glass.clone(),
    });
    let alike: Vec<Truth> = alike.collect();
    let about = format!(
        "A picture of each wavelength by the paper's method, {RAYS_OF_EACH} rays a pixel in each. \
         The truth are {MOST_WAVELENGTHS} wavelengths, the most there may be, with the same rays in \
         the same colours, so that edges are equally rough in both: what differs is the number \
         of wavelengths alone. With a quarter fewer the truth is off by {:.2} itself (95 %).",
        off_by(&alike[0], &fewer)
    );
    let counts = bench.effort.pick(&[1u32, 2, 4, 7, 14, 40][..], &COUNTS);
    let settings = counts.iter().map(|&count| Setting::alone(count));
    let settings = settings.collect::<Result<Vec<_>, _>>()?;
    let measured = render_all(bench, &settings, details, (0.85, 1.0))?;
    let points = settings.iter().zip(&measured);
    let points = points.map(|(one, time)| one.measured(&alike, time));
    Ok(Comparison::new(
        ("numbers", "What the number of wavelengths costs by itself"),
        about,
        MEASURES.to_vec(),
        LIMIT,
        points.collect(),
    )
    .logarithmic())
}

const COUNTS: [u32; 15] = [1, 2, 3, 4, 5, 6, 7, 8, 10, 12, 14, 16, 20, 28, 40];

struct Setting {
    series: &'static str,
    name: String,
    method: Method,
    count: u32,
    /// Wavelengths of a ray of a comb, if not one.
    each: Option<u8>,
    samples: u16,
    dispersion: Dispersion,
}

fn settings(bench: &Bench<'_>) -> Result<Vec<Setting>, Cause> {
    let mut settings = Vec::new();
    for (method, quick, full) in [
        (Method::Paper, &[1, 7, 14, 40][..], &COUNTS[..]),
        (Method::Fixed, &[7, 14], &COUNTS),
        (Method::Comb, &[1, 4, 7, 14, 40], &COUNTS),
        (
            Method::Split,
            &[4, 7, 14],
            &[2, 3, 4, 5, 7, 10, 14, 20, 28, 40],
        ),
    ] {
        for &count in bench.effort.pick(quick, full) {
            settings.push(Setting::new(method, count)?);
        }
    }
    // Enough rays for smooth edges.
    for &(count, samples) in bench
        .effort
        .pick(&[(14, 128)][..], &[(7, 64), (14, 64), (14, 128)])
    {
        let one = Setting::new(Method::Split, count)?;
        settings.push(Setting {
            series: "split, more rays",
            name: format!("{}, {samples} rays", one.name),
            samples,
            ..one
        });
    }
    for each in [2, 4, 7] {
        let count = Dispersion::WAVELENGTHS;
        let wavelengths = Wavelengths::new(count, Wavelengths::RANGE)?;
        let one = Setting::new(Method::Comb, count)?;
        settings.push(Setting {
            series: "comb, several each",
            name: format!("{}, {each} each", one.name),
            each: Some(each),
            samples: SAMPLES / u16::from(each),
            dispersion: Dispersion::Comb(wavelengths, each),
            ..one
        });
    }
    Ok(settings)
}

impl Setting {
    fn new(method: Method, count: u32) -> Result<Self, Cause> {
        let dispersion = match Dispersion::of(method, count, None)? {
            // Pictures keep to the wavelengths at which quartz is known.
            Dispersion::Images(wavelengths, matching) => {
                let known = shisen_core::spectrum::Medium::QUARTZ_O.range();
                Dispersion::Images(wavelengths.clamped_to(known)?, matching)
            }
            other => other,
        };
        Ok(Self {
            series: method.name(),
            name: format!("{} {count}", method.name()),
            method,
            count,
            each: None,
            samples: if method == Method::Split {
                SPLIT_SAMPLES
            } else {
                SAMPLES
            },
            dispersion,
        })
    }

    /// Returns the paper's method with as many rays for each wavelength however many there are.
    fn alone(count: u32) -> Result<Self, Cause> {
        let one = Self::new(Method::Paper, count)?;
        Ok(Self {
            series: "paper, 8 rays for each",
            name: format!("{}, {RAYS_OF_EACH} rays each", one.name),
            samples: RAYS_OF_EACH * count as u16,
            ..one
        })
    }

    fn frame(&self, quartz: &Quartz) -> Result<Frame, Cause> {
        Ok(quartz.frame(self.dispersion, self.samples)?)
    }

    /// Returns the point of the setting's frames, one of each detail.
    fn measured(&self, truths: &[Truth], time: &Timed<Vec<Frame>>) -> Point {
        let pairs = truths.iter().zip(&time.first);
        let details: Vec<Vec<f64>> = pairs
            .map(|(truth, frame)| {
                let [_, glass] = truth.differences(picture(frame));
                glass
            })
            .collect();
        let steps = time.first.iter().map(|frame| frame.statistics.steps);
        let settings = [
            ("method", self.method.name().into()),
            ("wavelengths", self.count.into()),
            ("each", self.each.into()),
            ("samples", self.samples.into()),
        ];
        let point = Point::new(self.series, self.name.clone(), settings);
        point.measured(errors(&details), time, Some(steps.sum()))
    }
}

fn errors(details: &[Vec<f64>]) -> Vec<Option<f64>> {
    let most = details.iter().map(|own| quantile_of(own.clone(), 0.95));
    let most: Vec<f64> = most.collect();
    let means: Vec<f64> = details.iter().map(|own| mean(own)).collect();
    let all = details.concat();
    let largest = all.iter().copied().fold(0.0, f64::max);
    let (of_most, of_mean, all_mean) = (deviation(&most), deviation(&means), mean(&all));
    [quantile_of(all, 0.95), of_most, all_mean, of_mean, largest]
        .map(Some)
        .into()
}

fn deviation(numbers: &[f64]) -> f64 {
    let middle = mean(numbers);
    let squares = numbers.iter().map(|one| (one - middle) * (one - middle));
    libm::sqrt(squares.sum::<f64>() / (numbers.len().max(2) - 1) as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn details_count_together_and_tell_how_sure_they_are() {
        let even = [vec![1.0; 99], vec![3.0; 101]];
        let found = errors(&even).into_iter().map(Option::unwrap);
        let root = libm::sqrt(2.0);
        for (found, expected) in found.zip([3.0, root, 2.01, root, 3.0]) {
            assert!((found - expected).abs() < 1.0e-12, "{found} {expected}");
        }
        assert_eq!(errors(&even[..1])[1], Some(0.0));
    }
}
