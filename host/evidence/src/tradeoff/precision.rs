//! What single precision loses, stage by stage: the built-in way, the same in double precision,
//! and the textbook's way in single precision.

mod colour;
mod double;

use super::front::percent;
use super::page::brief;
use super::{
    Bench, Build, Cause, Comparison, Limit, Measure, Point, Section, limit, measure, timed,
};
use crate::quartz::mean;
use crate::selftest::{Inputs, worse};
use crate::textbook::{angle, moller_trumbore, printed_level, textbook_refraction, traced_mirror};
use glam::{DVec2, DVec3, Vec3};
use shisen::dome::Mirror;
use shisen::live::quantiles::quantile_of;
use shisen::render::gaze_reference::{self, Limits};
use shisen_core::capture::{Mapping, SpheroidMirror};
use shisen_core::gaze::{Boundary, Gaze, LineOfSight, VisualField};
use shisen_core::shape::{Ray, Triangle};
use shisen_core::trace::refract;
use std::f64::consts::{FRAC_PI_2, TAU};
use std::hint::black_box;

struct Way<'w> {
    name: &'static str,
    run: Box<dyn Fn() + 'w>,
    /// The errors at all inputs, by [`Stage::parts`] and the largest of them first.
    errors: Vec<Vec<f64>>,
}

struct Stage {
    id: &'static str,
    title: &'static str,
    about: &'static str,
    /// The label of the largest error.
    largest: &'static str,
    /// The kinds of errors, where there are several: the largest of each.
    parts: &'static [Measure],
    limit: Limit,
    /// The primitives that all inputs test together.
    steps: Option<u64>,
}

pub(super) fn section(bench: &Bench<'_>) -> Result<Section, Cause> {
    let count = bench.effort.pick(20_000, 200_000);
    let comparisons = vec![
        level(bench, count, (0.0, 0.2))?,
        mirror(bench, count, (0.2, 0.4))?,
        intersection(bench, count, (0.4, 0.6))?,
        refraction(bench, count, (0.6, 0.8))?,
        colour::colour(bench, count / colour::WAVELENGTHS, (0.8, 1.0))?,
    ];
    let about = format!(
        "Each stage of a ray on {count} usual inputs ({} spectra), drawn at random and the same \
         on every run, one after another on one thread: as built in, by the textbook's formula in \
         single precision, and as built in but in double precision, which is the truth here. \
         Times are of all inputs. An intersection is one step; the other stages are formulas and \
         have none. Unusual inputs are among the hard cases below.",
        count / colour::WAVELENGTHS,
    );
    let choice = choice(&comparisons, Build::OPTIMISED);
    let title = "Single precision";
    let mut section = Section::new("precision", title, about, comparisons);
    section.choice = choice;
    Ok(section)
}

/// Returns the precision to choose for all stages together: a program has one.
fn choice(comparisons: &[Comparison], times_count: bool) -> String {
    let beyond = |way: usize| {
        let is_beyond = |one: &&Comparison| one.points[way].error() > one.limit.error;
        let stages = comparisons.iter().filter(is_beyond);
        let titles: Vec<String> = stages.map(|one| one.title.to_lowercase()).collect();
        titles.join(", ")
    };
    let (lacking, naive) = (beyond(OURS), beyond(NAIVE));
    if !lacking.is_empty() {
        return format!("Choose double precision for: {lacking}. The built-in way is too far off.");
    }
    let seconds =
        |way: usize| -> f64 { comparisons.iter().map(|one| one.points[way].seconds).sum() };
    let time = if times_count {
        let part = percent(seconds(DOUBLE) / seconds(OURS));
        format!("double precision takes {part} of their time, where rays go one by one")
    } else {
        "this build is not optimised, and does not tell the time of double precision".to_owned()
    };
    format!(
        "Choose single precision as built in: all {} stages keep to their bounds, and {time}. The \
         textbook's formulas are too far off for: {}.",
        comparisons.len(),
        if naive.is_empty() { "none" } else { &naive },
    )
}

/// Times the ways of a stage in turns. The built-in way is chosen where it keeps to its bound.
fn compare(
    bench: &Bench<'_>,
    stage: Stage,
    ways: Vec<Way<'_>>,
    share: (f64, f64),
) -> Result<Comparison, Cause> {
    let measured = bench.in_turns(&ways, share, |way| Ok(timed(|| (way.run)())))?;
    let points = ways.into_iter().zip(measured).map(|(way, time)| {
        let number = |x: f64| x.is_finite().then_some(x);
        let all = way.errors.first().cloned().unwrap_or_default();
        let mut errors = vec![
            number(quantile_of(all.clone(), 1.0)),
            number(quantile_of(all.clone(), 0.95)),
            number(mean(&all)),
        ];
        let parts = way.errors.into_iter().skip(1);
        errors.extend(parts.map(|part| number(quantile_of(part, 1.0))));
        let settings = [("way", way.name.into())];
        Point::new(stage.id, way.name, settings).measured(errors, &time, stage.steps)
    });
    let measures = [
        measure("largest", stage.largest),
        measure("percentile_95", "95 % are below"),
        measure("mean", "mean"),
    ];
    let title = (stage.id, stage.title);
    let measures = [&measures, stage.parts].concat();
    let points = points.collect();
    let mut comparison = Comparison::new(title, stage.about, measures, stage.limit, points);
    comparison.logarithmic = true;
    let (ours, limit) = (&comparison.points[OURS], &comparison.limit);
    if ours.error() <= limit.error {
        comparison.choice = format!(
            "Choose {}, off by at most {}, within its bound of {} ({}).",
            ours.name,
            brief(ours.error()),
            brief(limit.error),
            limit.because
        );
    }
    Ok(comparison)
}

const OURS: usize = 0;
const NAIVE: usize = 1;
const DOUBLE: usize = 2;

/// Returns the built-in, the textbook's and the true way at all inputs; `error` gives the kinds of
/// errors of a result.
fn ways<'w, I, T, E, const N: usize>(
    inputs: &'w [I],
    ours: impl Fn(&I) -> T + 'w,
    naive: impl Fn(&I) -> T + 'w,
    exact: impl Fn(&I) -> E + 'w,
    error: impl Fn(T, &E) -> [f64; N] + 'w,
) -> Vec<Way<'w>> {
    // One kind of errors alone is the largest.
    let columns = if N == 1 { 1 } else { 1 + N };
    let truth: Vec<E> = inputs.iter().map(&exact).collect();
    let errors = |way: &dyn Fn(&I) -> T| {
        let mut errors = vec![Vec::with_capacity(inputs.len()); columns];
        for (input, truth) in inputs.iter().zip(&truth) {
            // A NaN is as far off as can be.
            let found = error(way(input), truth).map(|one| worse(0.0, one));
            let all = [found.into_iter().fold(0.0, f64::max)];
            for (errors, one) in errors.iter_mut().zip(all.into_iter().chain(found)) {
                errors.push(one);
            }
        }
        errors
    };
    let (ours_errors, naive_errors) = (errors(&ours), errors(&naive));
    let way = |name, errors, run| Way { name, run, errors };
    vec![
        way("built in, f32", ours_errors, each(inputs, ours)),
        way("textbook, f32", naive_errors, each(inputs, naive)),
        way(
            "f64",
            vec![vec![0.0; inputs.len()]; columns],
            each(inputs, exact),
        ),
    ]
}

fn each<'w, I, T>(inputs: &'w [I], way: impl Fn(&I) -> T + 'w) -> Box<dyn Fn() + 'w> {
    Box::new(move || {
        for input in inputs {
            black_box(way(input));
        }
    })
}

fn level(bench: &Bench<'_>, count: usize, share: (f64, f64)) -> Result<Comparison, Cause> {
    let sight = LineOfSight::new(Vec3::ZERO, Vec3::NEG_Z, Vec3::Y)?;
    let single = Gaze::new(sight, VisualField::PAPER);
    let boundary = Boundary::Printed;
    let double = gaze_reference::Gaze::new(DVec3::NEG_Z, DVec3::Y, Limits::PAPER, boundary)?;
    let mut draw = Inputs::new(50);
    let inputs: Vec<Vec3> = (0..count)
        .map(|number| match number % 100 {
            // Straight up, and next to the line of sight.
            0 => Vec3::Y,
            1 => (DVec3::NEG_Z + draw.direction() * 1.0e-4).as_vec3(),
            _ => draw.direction().as_vec3(),
        })
        .collect();
    let ways = ways(
        &inputs,
        |&d| single.level(d).unwrap_or(f32::NAN),
        |&d| printed_level(d),
        |&d| {
            let sight = double.sight(d.as_dvec3());
            sight.map_or(f64::NAN, |sight| sight.level)
        },
        |found, exact| [(f64::from(found) - exact).abs()],
    );
    let stage = Stage {
        id: "level",
        title: "Level of a ray",
        about: "Equations 4 to 8 of Mochizuki and Makino in all directions, a hundredth of them \
                straight up, against arc tangents in double precision.",
        largest: "largest error of the level",
        parts: &[],
        limit: limit(1.0e-6, "it changes what one ray in a million does"),
        steps: None,
    };
    compare(bench, stage, ways, share)
}

fn mirror(bench: &Bench<'_>, count: usize, share: (f64, f64)) -> Result<Comparison, Cause> {
    let single = SpheroidMirror::BEST;
    let a = f64::from(single.axis_ratio());
    let double = match single.viewpoint() {
        Some(p) => Mirror::perspective(a, f64::from(p))?,
        None => Mirror::parallel(a)?,
    };
    let b1 = double.parameters().b1;
    let mut draw = Inputs::new(51);
    let inputs: Vec<[f32; 2]> = (0..count)
        .map(|_| {
            let radius = draw.unit().sqrt() * 0.9999;
            let (sin, cos) = libm::sincos(TAU * draw.unit());
            [(radius * cos) as f32, (radius * sin) as f32]
        })
        .collect();
    let ways = ways(
        &inputs,
        |&[u, v]| {
            let found = single.pixel(u, v, Mapping::Screen);
            found.map_or(Vec3::NAN, |found| found.direction)
        },
        |&[u, v]| traced_mirror(&single, [u, v]),
        |&[u, v]| {
            double
                .reflect(DVec2::new(f64::from(u), f64::from(v)) * b1)
                .1
        },
        |found, &exact| [angle(found.as_dvec3(), exact) / FRAC_PI_2 * 2048.0],
    );
    let stage = Stage {
        id: "mirror",
        title: "Ray off a mirror",
        about: "The best mirror's rays, over the whole dome master.",
        largest: "largest error, pixels of 4096²",
        parts: &[],
        limit: limit(1.0e-3, "a thousandth of a pixel"),
        steps: None,
    };
    compare(bench, stage, ways, share)
}

fn intersection(bench: &Bench<'_>, count: usize, share: (f64, f64)) -> Result<Comparison, Cause> {
    let mut draw = Inputs::new(52);
    let mut inputs: Vec<([Vec3; 3], Ray)> = Vec::with_capacity(count);
    while inputs.len() < count {
        let at = draw.in_ball() * 2.0;
        let corners = [0; 3].map(|_| (at + draw.in_ball() * 0.2).as_vec3());
        let [a, b, c] = corners.map(Vec3::as_dvec3);
        // In its middle, from outside of the scene, at 0.1 rad or more.
        let target = (a + b + c) / 3.0;
        let origin = draw.direction() * 4.0;
        let normal = (b - a).cross(c - a);
        let way = target - origin;
        let seen = normal.dot(way).abs() > 0.1 * normal.length() * way.length();
        let ray = Ray::new(origin.as_vec3(), way.normalize().as_vec3());
        if let Some(ray) = ray.filter(|_| seen && normal.length() > 1.0e-3) {
            inputs.push((corners, ray));
        }
    }
    let ways = ways(
        &inputs,
        |(corners, ray)| {
            let hit = Triangle(*corners).intersect(ray, 4.0);
            hit.map_or(f32::NAN, |hit| hit.t)
        },
        |(corners, ray)| moller_trumbore(*corners, ray, None).unwrap_or(f32::NAN),
        |(corners, ray)| {
            let hit = double::intersection(*corners, ray, 4.0);
            // The built-in way computes the weights, too.
            hit.map_or(f64::NAN, |hit| {
                black_box(hit.weights);
                hit.t
            })
        },
        |found, exact| [(f64::from(found) - exact).abs() / exact * 16_777_216.0],
    );
    let stage = Stage {
        id: "intersection",
        title: "Distance of a triangle",
        about: "Triangles of 20 cm in a scene of 4 m, hit in the middle at 0.1 rad or more. What \
                is built in makes a ray ready, decides by exact signs whether it is inside, and \
                gives distance and weights; so does double precision, by the same formulas. The \
                textbook's test is Möller and Trumbore's, which gives the distance alone.",
        largest: "largest error, parts of 2⁻²⁴ of the distance",
        parts: &[],
        limit: limit(32.0, "as far off do secondary rays start"),
        steps: Some(inputs.len() as u64),
    };
    compare(bench, stage, ways, share)
}

fn refraction(bench: &Bench<'_>, count: usize, share: (f64, f64)) -> Result<Comparison, Cause> {
    let mut draw = Inputs::new(53);
    let mut inputs: Vec<(Vec3, [f32; 2])> = Vec::with_capacity(count);
    while inputs.len() < count {
        let cos = draw.range(1.0e-3, 1.0) as f32;
        let sin = (1.0 - f64::from(cos) * f64::from(cos)).sqrt();
        let glass = draw.range(1.1, 2.4) as f32;
        let inwards = inputs.len().is_multiple_of(2);
        // Out of glass what is well under the critical angle.
        if inwards || sin * f64::from(glass) < 0.95 {
            let media = if inwards { [1.0, glass] } else { [glass, 1.0] };
            inputs.push((Vec3::new(sin as f32, -cos, 0.0), media));
        }
    }
    let ways = ways(
        &inputs,
        |&(d, [m, n])| {
            let found = refract(d, Vec3::Y, m, n);
            let direction = found.direction.unwrap_or(Vec3::NAN);
            (found.reflectance, found.transmittance, direction)
        },
        |&(d, [m, n])| {
            let found = textbook_refraction(d, Vec3::Y, m, n);
            found.unwrap_or((f32::NAN, f32::NAN, Vec3::NAN))
        },
        |&(d, [m, n])| double::refraction(d.as_dvec3(), DVec3::Y, m.into(), n.into()),
        |(r, t, direction), &(exact_r, exact_t, exact)| {
            let relative = |found: f32, exact: f64| (f64::from(found) / exact - 1.0).abs();
            let shares = relative(r, exact_r).max(relative(t, exact_t));
            [shares, angle(direction.as_dvec3(), exact)]
        },
    );
    let stage = Stage {
        id: "refraction",
        title: "Light at a border",
        about: "Fresnel's equations and Snell's law between air and glass, half of it inwards at \
                all angles, half outwards up to 0.95 of the critical angle's sine: the reflected \
                and the transmitted share and the direction, whichever is further off.",
        largest: "largest error: relative, of a share, or rad, of the direction",
        parts: &PARTS_OF_LIGHT,
        limit: limit(
            2.0e-6,
            "what the documentation promises of shares, a thousandth of a step of 8 bits",
        ),
        steps: None,
    };
    compare(bench, stage, ways, share)
}

const PARTS_OF_LIGHT: [Measure; 2] = [
    measure("shares", "shares, largest, relative"),
    measure("direction_rad", "direction, largest, rad"),
];

#[cfg(test)]
mod tests {
    use super::super::quick_bench;
    use super::*;
    use shisen::scene::mesh::TriangleMesh;

    #[test]
    fn a_stage_beyond_its_bound_takes_double_precision() {
        let mut stages =
            vec![level(&quick_bench(&TriangleMesh::square()), 100, (0.0, 1.0)).unwrap()];
        let all = choice(&stages, true);
        assert!(all.contains("all 1 stages keep to their bounds"), "{all}");
        stages[0].points[OURS].errors[0] = Some(1.0);
        let all = choice(&stages, true);
        assert!(
            all.starts_with("Choose double precision for: level of a ray."),
            "{all}"
        );
    }
}
