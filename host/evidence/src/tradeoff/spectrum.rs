//! Wavelengths: how many, and how rays take them.

use super::front::{deviation, mean};
use super::{
    Bench, Cause, Comparison, Figure, Limit, Measure, Point, Section, Time, Topic, measure,
};
use glam::DVec3;
use rayon::iter::{IntoParallelIterator, ParallelIterator};
use shisen::bake::Baked;
use shisen::cave::{Cave, Eye, Viewer, Wall};
use shisen::live::quantiles::quantile_of;
use shisen::picture::{Picture, colour_differences};
use shisen::render::effects::Effects;
use shisen::render::spectrum::{Dispersion, Method};
use shisen::render::{self, Frame, Observer, Options};
use shisen::scene::builtin::spheres;
use shisen_core::scene::EffectSet;
use shisen_core::spectrum::Wavelengths;
use std::fmt::Write as _;
use std::thread::{self, ScopedJoinHandle};

/// Wavelengths that each ray of the truth takes; times the phases of a comb, 416
/// in all.
const TRUE_WAVELENGTHS: u32 = 13;

/// What is seen of the balls: the lower half of the smallest. Metres, right of and
/// above straight ahead, of details whose pixels are not the same, and a window's side.
const LOWER_LEFT: [[f64; 2]; 5] = [
    [-0.088, -0.588],
    [-0.0771, -0.5813],
    [-0.0993, -0.5797],
    [-0.0837, -0.5951],
    [-0.0949, -0.5911],
];
const SIDE: f64 = 0.128;

/// Of the paper's experiment, a ray each of so many wavelengths.
const SAMPLES: u16 = 56;

/// Rays a pixel of which each takes all wavelengths.
const SPLIT_SAMPLES: u16 = 8;

/// Rays a pixel of each wavelength's picture, where they are as many however many
/// wavelengths there are, and the same ones.
const RAYS_OF_EACH: u16 = 8;

/// Wavelengths of the truth where their number alone differs: the most there may be.
const MOST_WAVELENGTHS: u32 = Wavelengths::MOST;

pub(super) fn section(bench: &Bench<'_>) -> Result<Section, Cause> {
    let details = LOWER_LEFT[bench.effort.pick(1..3, 0..LOWER_LEFT.len())].iter();
    let details: Vec<Balls> = details
        .map(|&at| Balls::new(bench, at))
        .collect::<Result<_, _>>()?;
    // The truth is one of samples, too.
    let samples = true_samples(bench);
    let (truths, rougher) = truths(
        bench,
        &details,
        [samples, samples - samples / 4],
        Balls::truth,
    )?;
    let seen = details.iter().zip(truths).map(|(balls, truth)| {
        let glass = balls.glass()?;
        Ok(Seen { truth, glass })
    });
    let mut seen = seen.collect::<Result<Vec<_>, Cause>>()?;
    (bench.progress)(0.2);
    let own = quantile_of(seen[0].differences(&rougher), 0.95);
    let glass = seen.iter().flat_map(|one| &one.glass);
    let share = glass.clone().filter(|&&one| one).count() as f64 / glass.count() as f64;
    let asked = asked(bench)?;
    let measured = render_all(bench, &asked, &details, (0.2, 0.85))?;
    let mut points = Vec::new();
    let mut best: Option<(f64, String, Picture)> = None;
    for (one, (time, frames)) in asked.iter().zip(&measured) {
        let errors = Differences::of(&seen, frames);
        let point = one.measured(&errors, *time, frames);
        if best
            .as_ref()
            .is_none_or(|best| errors.most_of_them < best.0)
        {
            let picture = frames[0].pictures[0].picture.clone();
            best = Some((errors.most_of_them, point.name.clone(), picture));
        }
        points.push(point);
    }
    let about = about(bench, &details, share, own);
    let mut comparison = Comparison::new(
        ("wavelengths", "How many wavelengths, and how"),
        "One wavelength is none: the index of the d line for all colours, but for the paper's \
         method and fixed wavelengths, which have a picture of it. At equal rays more wavelengths \
         are not always nearer: each has fewer rays, 8 at 7 wavelengths and one or two at 40, and \
         edges that are drawn by so few have colours of their own, which are most of the error; \
         where 64 or 128 rays take all wavelengths, edges have little to add. What the number of \
         wavelengths costs by itself is below. What \
         is less than the standard deviation between details (±) is chance.",
        MEASURES.to_vec(),
        LIMIT,
        points,
    );
    comparison.logarithmic = true;
    let numbers = numbers_alone(bench, &details, &seen)?;
    let choice = format!(
        "{} The number of wavelengths by itself: {}",
        comparison.choice, numbers.choice
    );
    let comparisons = vec![comparison, numbers];
    let mut section = Section::new(Topic::Spectrum, "Wavelengths", about, comparisons);
    section.choice = choice;
    let plain = details[0].frame(&Options {
        dispersion: Dispersion::Off,
        ..details[0].options
    })?;
    let truth = seen.swap_remove(0).truth;
    let figure = |caption: String, picture: Picture| Figure { caption, picture };
    section.pictures = vec![
        figure("The truth".to_owned(), truth),
        figure(
            "Without dispersion".to_owned(),
            plain.pictures[0].picture.clone(),
        ),
    ];
    if let Some((most, name, picture)) = best {
        let caption = format!("{name}: the nearest, 95 % are below {most:.2}");
        section.pictures.push(figure(caption, picture));
    }
    Ok(section)
}

const MEASURES: [Measure; 5] = [
    measure("de2000_95", "95 % ΔE2000"),
    measure("de2000_95_deviation", "±, of details"),
    measure("de2000_mean", "mean ΔE2000"),
    measure("de2000_mean_deviation", "±, of details"),
    measure("de2000_max", "largest ΔE2000"),
];

const LIMIT: Limit = Limit {
    error: 1.0,
    because: "up to which nobody sees a difference, in all but a twentieth of the pixels",
};

/// All details by each method, beside one another: a picture this small keeps one thread
/// busy, and its time is its own.
fn render_all(
    bench: &Bench<'_>,
    asked: &[Asked],
    details: &[Balls],
    share: (f64, f64),
) -> Result<Vec<(Time, Vec<Frame>)>, Cause> {
    bench.in_turns(asked, share, |one| {
        let mut frames = Vec::new();
        for some in details.chunks(bench.threads) {
            // Not on a pool, whose threads do other frames' work while their own waits.
            let each: Vec<_> = thread::scope(|scope| {
                let start = |balls| scope.spawn(move || frame_of(balls, one));
                let started: Vec<_> = some.iter().map(start).collect();
                started.into_iter().map(ScopedJoinHandle::join).collect()
            });
            for frame in each {
                frames.push(frame.unwrap_or_else(|panic| std::panic::resume_unwind(panic))?);
            }
        }
        Ok((frames.iter().map(|frame| frame.seconds).sum(), frames))
    })
}

fn frame_of(balls: &Balls, one: &Asked) -> Result<Frame, Cause> {
    balls.frame(&one.options(&balls.options))
}

/// A truth of each detail from as much as there is of it, and of the first from less: all
/// beside one another, as a small picture keeps one thread busy and none of these is timed.
fn truths<N: Copy + Send + Sync>(
    bench: &Bench<'_>,
    details: &[Balls],
    [much, less]: [N; 2],
    of: impl Fn(&Balls, N) -> Result<Picture, Cause> + Sync,
) -> Result<(Vec<Picture>, Picture), Cause> {
    let each = (0..=details.len()).into_par_iter().map(|number| {
        let asked = details.get(number).map(|balls| (balls, much));
        let (balls, samples) = asked.unwrap_or((&details[0], less));
        of(balls, samples)
    });
    let mut pictures =
        render::pool(bench.threads)?.install(|| each.collect::<Result<Vec<_>, _>>())?;
    let rougher = pictures.swap_remove(details.len());
    Ok((pictures, rougher))
}

/// What the number of wavelengths costs by itself: with the same rays for each wavelength
/// as the truth has for each of its own, edges are drawn alike, and are in no error.
fn numbers_alone(bench: &Bench<'_>, details: &[Balls], seen: &[Seen]) -> Result<Comparison, Cause> {
    let counts = [MOST_WAVELENGTHS, MOST_WAVELENGTHS - MOST_WAVELENGTHS / 4];
    let (truths, fewer) = truths(bench, details, counts, |balls, count| {
        let options = Asked::alone(count)?.options(&balls.options);
        Ok(balls.frame(&options)?.pictures.swap_remove(0).picture)
    })?;
    let alike = truths.into_iter().zip(seen).map(|(truth, seen)| Seen {
        truth,
        glass: seen.glass.clone(),
    });
    let alike: Vec<_> = alike.collect();
    let own = quantile_of(alike[0].differences(&fewer), 0.95);
    let counts = bench.effort.pick(
        &[1u32, 2, 4, 7, 14, 40][..],
        &[1, 2, 3, 4, 5, 6, 7, 8, 10, 12, 14, 16, 20, 28, 40],
    );
    let asked = counts.iter().map(|&count| Asked::alone(count));
    let asked = asked.collect::<Result<Vec<_>, _>>()?;
    let measured = render_all(bench, &asked, details, (0.85, 1.0))?;
    let points = asked.iter().zip(&measured).map(|(one, (time, frames))| {
        let errors = Differences::of(&alike, frames);
        one.measured(&errors, *time, frames)
    });
    let about = format!(
        "A picture of each wavelength by the paper's method, {RAYS_OF_EACH} rays a pixel in each. \
         The truth are {MOST_WAVELENGTHS} wavelengths, the most there may be, with the same rays in \
         the same colours, so that edges are equally rough in both: what differs is the number \
         of wavelengths alone. With a quarter fewer the truth is off by {own:.2} itself (95 %)."
    );
    let mut comparison = Comparison::new(
        ("numbers", "What the number of wavelengths costs by itself"),
        about,
        MEASURES.to_vec(),
        LIMIT,
        points.collect(),
    );
    comparison.logarithmic = true;
    Ok(comparison)
}

/// What is measured, and how.
fn about(bench: &Bench<'_>, details: &[Balls], share: f64, own: f64) -> String {
    format!(
        "{} details of a ball of quartz on a checkered floor, {}² pixels each and no two pixels \
         alike, of which {:.0} % meet glass; errors are of these: \
         CIEDE2000 of what a display shows. The paper's method and fixed wavelengths are a \
         picture for each wavelength, of a part of {SAMPLES} rays a pixel; of a comb each of \
         {SAMPLES} rays takes one wavelength, or of fewer rays each several; split, each of \
         {SPLIT_SAMPLES} rays takes all. The \
         truth are {} rays a pixel, each split into {TRUE_WAVELENGTHS} wavelengths, in turns \
         416, in the colours of the CIE's table; with a quarter fewer rays it is off by {own:.2} \
         itself (95 %).",
        details.len(),
        details[0].size,
        100.0 * share,
        true_samples(bench),
    )
}

fn true_samples(bench: &Bench<'_>) -> u16 {
    bench.effort.pick(400, 512)
}

/// The scene before one wall, for one eye.
struct Balls {
    baked: Baked,
    cave: Cave,
    options: Options,
    size: u32,
}

impl Balls {
    fn new(bench: &Bench<'_>, [x, y]: [f64; 2]) -> Result<Self, Cause> {
        let size = bench.effort.pick(24, 48);
        // A square window 1 m before the eye.
        let corner = |right: f64, up: f64| DVec3::new(SIDE * right + x, SIDE * up + y, -1.0);
        let corners = [corner(0.0, 0.0), corner(1.0, 0.0), corner(0.0, 1.0)];
        let [left, right, above] = corners;
        let wall = Wall::new("front", left, right, above, [size; 2])?;
        let mut options = bench.options();
        options.settings.samples = SAMPLES;
        Ok(Self {
            baked: Baked::new(&spheres())?,
            cave: Cave::new(vec![wall])?,
            options,
            size,
        })
    }

    fn frame(&self, options: &Options) -> Result<Frame, Cause> {
        let eye = Observer::new(Eye::Centre, Viewer::default().eye(Eye::Centre));
        let quiet = |_, _| {};
        Ok(render::cave(
            &self.baked.scene(),
            &self.cave,
            &[eye],
            options,
            &quiet,
        )?)
    }

    fn truth(&self, samples: u16) -> Result<Picture, Cause> {
        let wavelengths = Wavelengths::new(TRUE_WAVELENGTHS, Wavelengths::RANGE)?;
        let mut options = self.options;
        options.dispersion = Dispersion::Reference(wavelengths);
        options.settings.samples = samples;
        Ok(self.frame(&options)?.pictures.swap_remove(0).picture)
    }

    /// Which pixels meet glass: they change where none lets light through.
    fn glass(&self) -> Result<Vec<bool>, Cause> {
        let mut options = self.options;
        options.settings.samples = 4;
        let with = self.frame(&options)?;
        options.effects = Effects::AUTO.less(EffectSet::REFRACTION);
        let without = self.frame(&options)?;
        let pixels = |frame: &Frame| frame.pictures[0].picture.pixels.clone();
        let pairs = pixels(&with).into_iter().zip(pixels(&without));
        Ok(pairs.map(|(a, b)| a != b).collect())
    }
}

/// A number of wavelengths by a method.
struct Asked {
    method: Method,
    count: u32,
    /// Of a comb, wavelengths of a ray, if not one.
    each: Option<u8>,
    /// Rays a pixel, where they are not as many as others have.
    rays: Option<u16>,
    dispersion: Dispersion,
}

fn asked(bench: &Bench<'_>) -> Result<Vec<Asked>, Cause> {
    let all = &[1, 2, 3, 4, 5, 6, 7, 8, 10, 12, 14, 16, 20, 28, 40];
    let of = |method: Method| -> &[u32] {
        match method {
            Method::Paper => bench.effort.pick(&[1, 7, 14, 40], all),
            Method::Fixed => bench.effort.pick(&[7, 14], all),
            Method::Comb => bench.effort.pick(&[1, 4, 7, 14, 40], all),
            Method::Split => bench
                .effort
                .pick(&[4, 7, 14], &[2, 3, 4, 5, 7, 10, 14, 20, 28, 40]),
        }
    };
    let mut asked = Vec::new();
    for method in [Method::Paper, Method::Fixed, Method::Comb, Method::Split] {
        for &count in of(method) {
            asked.push(Asked {
                method,
                count,
                each: None,
                rays: None,
                dispersion: clamped(Dispersion::of(method, count, None)?)?,
            });
        }
    }
    // Where edges are to be smooth, too.
    for &(count, rays) in bench
        .effort
        .pick(&[(14, 128)][..], &[(7, 64), (14, 64), (14, 128)])
    {
        asked.push(Asked {
            method: Method::Split,
            count,
            each: None,
            rays: Some(rays),
            dispersion: clamped(Dispersion::of(Method::Split, count, None)?)?,
        });
    }
    for each in [2, 4, 7] {
        let count = Dispersion::WAVELENGTHS;
        let wavelengths = Wavelengths::new(count, Wavelengths::RANGE)?;
        asked.push(Asked {
            method: Method::Comb,
            count,
            each: Some(each),
            rays: None,
            dispersion: Dispersion::Comb(wavelengths, each),
        });
    }
    Ok(asked)
}

/// Wavelengths of pictures keep to those at which quartz is known.
fn clamped(dispersion: Dispersion) -> Result<Dispersion, Cause> {
    Ok(match dispersion {
        Dispersion::Images(wavelengths, matching) => {
            let known = shisen_core::spectrum::Medium::QUARTZ_O.range();
            Dispersion::Images(wavelengths.clamped_to(known)?, matching)
        }
        other => other,
    })
}

impl Asked {
    /// The paper's method with as many rays for each wavelength however many there are.
    fn alone(count: u32) -> Result<Self, Cause> {
        Ok(Self {
            method: Method::Paper,
            count,
            each: None,
            rays: Some(RAYS_OF_EACH * count as u16),
            dispersion: clamped(Dispersion::of(Method::Paper, count, None)?)?,
        })
    }

    /// What its frames, one of each detail, came to.
    fn measured(&self, errors: &Differences, time: Time, frames: &[Frame]) -> Point {
        Point {
            errors: errors.all(),
            of_details: errors.most_of_each.clone(),
            seconds: time.median,
            spread: time.spread,
            steps: Some(frames.iter().map(|frame| frame.statistics.steps).sum()),
            ..self.point()
        }
    }

    fn samples(&self) -> u16 {
        if let Some(rays) = self.rays {
            return rays;
        }
        match (self.method, self.each) {
            (Method::Split, _) => SPLIT_SAMPLES,
            (_, Some(each)) => SAMPLES / u16::from(each),
            _ => SAMPLES,
        }
    }

    fn options(&self, usual: &Options) -> Options {
        let mut options = *usual;
        options.dispersion = self.dispersion;
        options.settings.samples = self.samples();
        options
    }

    fn point(&self) -> Point {
        let mut name = format!("{} {}", self.method.name(), self.count);
        if let Some(each) = self.each {
            // Writing to a string does not fail, nor below.
            let _ = write!(name, ", {each} each");
        }
        let _ = match (self.method, self.rays) {
            (_, None) => Ok(()),
            (Method::Split, Some(rays)) => write!(name, ", {rays} rays"),
            (_, Some(_)) => write!(name, ", {RAYS_OF_EACH} rays each"),
        };
        let series = match (self.method, self.each, self.rays) {
            (_, Some(_), _) => "comb, several each",
            (Method::Split, _, Some(_)) => "split, more rays",
            (_, _, Some(_)) => "paper, 8 rays for each",
            _ => self.method.name(),
        };
        Point::new(
            series,
            name,
            [
                ("method", self.method.name().into()),
                ("wavelengths", self.count.into()),
                ("each", self.each.into()),
                ("samples", self.samples().into()),
            ],
        )
    }
}

/// What a detail shows.
struct Seen {
    truth: Picture,
    /// Which pixels meet glass.
    glass: Vec<bool>,
}

impl Seen {
    /// From the truth, of the pixels with glass.
    fn differences(&self, found: &Picture) -> Vec<f64> {
        let all = colour_differences(found, &self.truth);
        let all = all.into_iter().zip(&self.glass);
        all.filter(|one| *one.1).map(|one| one.0.into()).collect()
    }
}

/// From the truth, of all details.
struct Differences {
    mean: f64,
    most_of_them: f64,
    largest: f64,
    /// Standard deviations of the means and of the 95 % of details.
    deviations: [f64; 2],
    /// The 95 % of each detail.
    most_of_each: Vec<f64>,
}

impl Differences {
    fn of(seen: &[Seen], frames: &[Frame]) -> Self {
        let pairs = seen.iter().zip(frames);
        let errors = pairs.map(|(seen, frame)| seen.differences(&frame.pictures[0].picture));
        Self::new(&errors.collect::<Vec<_>>())
    }

    fn new(details: &[Vec<f64>]) -> Self {
        let most = details.iter().map(|own| quantile_of(own.clone(), 0.95));
        let most: Vec<f64> = most.collect();
        let means: Vec<f64> = details.iter().map(|own| mean(own)).collect();
        let all = details.concat();
        Self {
            deviations: [deviation(&means), deviation(&most)],
            most_of_each: most,
            mean: mean(&all),
            largest: all.iter().copied().fold(0.0, f64::max),
            most_of_them: quantile_of(all, 0.95),
        }
    }

    fn all(&self) -> Vec<Option<f64>> {
        let [of_mean, of_most] = self.deviations;
        [self.most_of_them, of_most, self.mean, of_mean, self.largest]
            .map(Some)
            .into()
    }
}

#[cfg(test)]
mod tests {
    use super::super::Effort;
    use super::*;
    use shisen::scene::quadruped::quadruped;

    /// Edges are the same in the truth, whatever they are like.
    #[test]
    fn the_more_wavelengths_the_nearer_where_nothing_else_differs() {
        let bench = Bench {
            effort: Effort::Quick,
            threads: 1,
            mesh: &quadruped(),
            progress: &|_| (),
        };
        let balls = vec![Balls::new(&bench, LOWER_LEFT[0]).unwrap()];
        let seen = vec![Seen {
            truth: Picture::new(balls[0].size, balls[0].size).unwrap(),
            glass: balls[0].glass().unwrap(),
        }];
        let found = numbers_alone(&bench, &balls, &seen).unwrap();
        let names = [1, 2, 4, 7, 14, 40].map(|count| format!("paper {count}, 8 rays each"));
        let points = found.points.iter();
        assert_eq!(
            points
                .clone()
                .map(|one| one.name.clone())
                .collect::<Vec<_>>(),
            names
        );
        let errors: Vec<f64> = points.map(Point::error).collect();
        assert!(errors.windows(2).all(|two| two[1] < two[0]), "{errors:?}");
        assert!(
            errors[5] > 0.0 && errors[5] < 0.5 && errors[0] > 2.0,
            "{errors:?}"
        );
        assert!(
            found.choice.starts_with("Choose paper "),
            "{}",
            found.choice
        );
    }

    #[test]
    fn details_count_together_and_tell_how_sure_they_are() {
        let even = [vec![1.0; 99], vec![3.0; 101]];
        let found = Differences::new(&even);
        assert!((found.mean - 2.01).abs() < 1.0e-12);
        assert_eq!([found.most_of_them, found.largest], [3.0, 3.0]);
        let root = libm::sqrt(2.0);
        assert!(
            found
                .deviations
                .iter()
                .all(|one| (one - root).abs() < 1.0e-12)
        );
        assert_eq!(Differences::new(&even[..1]).deviations, [0.0; 2]);
    }
}
