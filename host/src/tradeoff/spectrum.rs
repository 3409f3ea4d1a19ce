//! Wavelengths: how many, and how rays take them.

use super::{Bench, Cause, Comparison, Figure, Limit, Point, Section, Topic, measure};
use crate::bake::Baked;
use crate::cave::{Cave, Eye, Viewer, Wall};
use crate::effects::Effects;
use crate::picture::{Picture, colour_differences};
use crate::quantiles::quantile_of;
use crate::render::{self, Frame, Observer, Options};
use crate::scene::builtin::spheres;
use crate::spectrum::{Dispersion, Method};
use glam::DVec3;
use shisen_core::scene::EffectSet;
use shisen_core::spectrum::Wavelengths;
use std::fmt::Write as _;

/// Wavelengths that each ray of the truth takes; times the phases of a comb, 416
/// in all.
const TRUE_WAVELENGTHS: u32 = 13;

/// What is seen of the balls: the lower half of the smallest. Metres, right of and
/// above straight ahead, and the window's side.
const LOWER_LEFT: [f64; 2] = [-0.088, -0.588];
const SIDE: f64 = 0.128;

/// Of the paper's experiment, a ray each of so many wavelengths.
const SAMPLES: u16 = 56;

/// Rays a pixel of which each takes all wavelengths.
const SPLIT_SAMPLES: u16 = 8;

pub(super) fn section(bench: &Bench<'_>) -> Result<Section, Cause> {
    let balls = Balls::new(bench)?;
    let truth = balls.truth(bench)?;
    let glass = balls.glass()?;
    let share = glass.iter().filter(|&&one| one).count() as f64 / glass.len() as f64;
    let asked = asked(bench)?;
    let measured = bench.in_turns(&asked, (0.2, 1.0), |one| {
        let frame = balls.frame(&one.options(&balls.options))?;
        Ok((frame.seconds, frame))
    })?;
    let mut points = Vec::new();
    let mut best: Option<(f64, String, Picture)> = None;
    for (one, (time, frame)) in asked.iter().zip(measured) {
        let picture = &frame.pictures[0].picture;
        let errors = Differences::new(picture, &truth, &glass);
        points.push(Point {
            errors: errors.all(),
            seconds: time.median,
            spread: time.spread,
            steps: Some(frame.statistics.steps),
            ..one.point()
        });
        if best.as_ref().is_none_or(|best| errors.mean < best.0) {
            best = Some((
                errors.mean,
                points[points.len() - 1].name.clone(),
                picture.clone(),
            ));
        }
    }
    let about = format!(
        "A detail of three balls of quartz on a checkered floor, {}² pixels, of which {:.0} % meet glass; errors are of these: \
         CIEDE2000 of what a display shows. The paper's method and fixed wavelengths are a \
         picture for each wavelength, of a part of {SAMPLES} rays a pixel; of a comb each of \
         {SAMPLES} rays takes one wavelength, or of fewer rays each several; split, each of {SPLIT_SAMPLES} rays takes all. The \
         truth are {} rays a pixel, each split into {TRUE_WAVELENGTHS} wavelengths, in turns \
         416, in the colours of the CIE's table.",
        balls.size,
        100.0 * share,
        true_samples(bench),
    );
    let measures = vec![
        measure("de2000_mean", "mean ΔE2000"),
        measure("de2000_95", "95 % ΔE2000"),
        measure("de2000_max", "largest ΔE2000"),
    ];
    let limit = Limit {
        error: 1.0,
        because: "up to which nobody sees a difference",
    };
    let mut comparison = Comparison::new(
        ("wavelengths", "How many wavelengths, and how"),
        "One wavelength is none: the index of the d line for all colours, but for the paper's \
         method and fixed wavelengths, which have a picture of it.",
        measures,
        limit,
        points,
    );
    comparison.logarithmic = true;
    let mut section = Section::new(Topic::Spectrum, "Wavelengths", about, vec![comparison]);
    let plain = balls.frame(&Options {
        dispersion: Dispersion::Off,
        ..balls.options
    })?;
    let figure = |caption: String, picture: Picture| Figure { caption, picture };
    section.pictures = vec![
        figure("The truth".to_owned(), truth),
        figure(
            "Without dispersion".to_owned(),
            plain.pictures[0].picture.clone(),
        ),
    ];
    if let Some((mean, name, picture)) = best {
        let caption = format!("{name}: the nearest, with a mean of {mean:.2}");
        section.pictures.push(figure(caption, picture));
    }
    Ok(section)
}

fn true_samples(bench: &Bench<'_>) -> u16 {
    bench.effort.pick(64, 160)
}

/// The scene before one wall, for one eye.
struct Balls {
    baked: Baked,
    cave: Cave,
    options: Options,
    size: u32,
}

impl Balls {
    fn new(bench: &Bench<'_>) -> Result<Self, Cause> {
        let size = bench.effort.pick(64, 256);
        // A square window 1 m before the eye.
        let corner = |right: f64, up: f64| {
            let [x, y] = LOWER_LEFT;
            DVec3::new(SIDE * right + x, SIDE * up + y, -1.0)
        };
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

    fn truth(&self, bench: &Bench<'_>) -> Result<Picture, Cause> {
        let wavelengths = Wavelengths::new(TRUE_WAVELENGTHS, Wavelengths::RANGE)?;
        let mut options = self.options;
        options.dispersion = Dispersion::Reference(wavelengths);
        options.settings.samples = true_samples(bench);
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
    dispersion: Dispersion,
}

fn asked(bench: &Bench<'_>) -> Result<Vec<Asked>, Cause> {
    let all = &[
        1, 2, 3, 4, 5, 6, 7, 8, 10, 12, 14, 16, 20, 24, 28, 32, 36, 40,
    ];
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
                dispersion: clamped(Dispersion::of(method, count, None)?)?,
            });
        }
    }
    for each in [2, 4, 7] {
        let count = Dispersion::WAVELENGTHS;
        let wavelengths = Wavelengths::new(count, Wavelengths::RANGE)?;
        asked.push(Asked {
            method: Method::Comb,
            count,
            each: Some(each),
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
    fn samples(&self) -> u16 {
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
            // Writing to a string does not fail.
            let _ = write!(name, ", {each} each");
        }
        let series = match self.each {
            Some(_) => "comb, several each",
            None => self.method.name(),
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

/// From the truth, of the pixels with glass.
struct Differences {
    mean: f64,
    most_of_them: f64,
    largest: f64,
}

impl Differences {
    fn new(found: &Picture, truth: &Picture, glass: &[bool]) -> Self {
        let all = colour_differences(found, truth).into_iter().zip(glass);
        let own: Vec<f64> = all
            .filter(|one| *one.1)
            .map(|one| f64::from(one.0))
            .collect();
        Self {
            mean: own.iter().sum::<f64>() / own.len().max(1) as f64,
            largest: own.iter().copied().fold(0.0, f64::max),
            most_of_them: quantile_of(own, 0.95),
        }
    }

    fn all(&self) -> Vec<Option<f64>> {
        [self.mean, self.most_of_them, self.largest]
            .map(Some)
            .into()
    }
}
