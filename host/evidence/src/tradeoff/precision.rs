//! What single precision loses, stage by stage: what is built in, the same in
//! double precision, and the textbook's way in single.

mod choice;
mod colour;
mod double;

use super::{
    Bench, Build, Cause, Comparison, Limit, Measure, Point, Section, Topic, measure, timed,
};
use crate::selftest::Inputs;
use crate::selftest::naive::{moller_trumbore, printed_level, textbook_refraction, traced_mirror};
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

/// A way to do a stage: all inputs are worked through, and what came of each is
/// held against the truth.
struct Way<'w> {
    name: &'static str,
    /// Works through the inputs and gives nothing: what is timed.
    run: Box<dyn Fn() + 'w>,
    /// At all inputs, by [`Stage::parts`] and the largest of them first.
    errors: Vec<Vec<f64>>,
}

/// A part of a ray's life.
struct Stage {
    id: &'static str,
    title: &'static str,
    about: &'static str,
    /// The largest error, in a unit, and the same of 95 % and of the mean.
    measures: [Measure; 3],
    /// The largest of each of several errors, where there are several.
    parts: &'static [Measure],
    limit: Limit,
    /// Primitives tested, all inputs together; none where nothing is.
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
         on every run, one after another on one thread: as it is built in, the textbook's formula \
         in single precision, and the same as what is built in in double precision, which is the \
         truth here. Times are of all inputs. Steps are nodes visited and primitives tested: an \
         intersection is one, in any precision; the other stages are formulas, which visit and \
         test nothing, and have none. What is not usual is among the hard cases below.",
        count / colour::WAVELENGTHS,
    );
    let choice = choice::of_all(&comparisons, Build::OPTIMISED);
    let title = "Single precision";
    let mut section = Section::new(Topic::Precision, title, about, comparisons);
    section.choice = choice;
    Ok(section)
}

/// Times the ways of a stage in turns.
fn compare(
    bench: &Bench<'_>,
    stage: Stage,
    ways: Vec<Way<'_>>,
    share: (f64, f64),
) -> Result<Comparison, Cause> {
    let measured = bench.in_turns(&ways, share, |way| Ok(timed(|| (way.run)())))?;
    let points = ways.into_iter().zip(measured).map(|(way, (time, ()))| {
        let number = |x: f64| x.is_finite().then_some(x);
        let all = way.errors.first().cloned().unwrap_or_default();
        let mean = all.iter().sum::<f64>() / all.len().max(1) as f64;
        let mut errors = vec![
            number(quantile_of(all.clone(), 1.0)),
            number(quantile_of(all, 0.95)),
            number(mean),
        ];
        let parts = way.errors.into_iter().skip(1);
        errors.extend(parts.map(|part| number(quantile_of(part, 1.0))));
        Point {
            errors,
            seconds: time.median,
            spread: time.spread,
            steps: stage.steps,
            ..Point::new(stage.id, way.name, [("way", way.name.into())])
        }
    });
    let mut comparison = Comparison::new(
        (stage.id, stage.title),
        stage.about,
        [&stage.measures[..], stage.parts].concat(),
        stage.limit,
        points.collect(),
    );
    comparison.logarithmic = true;
    comparison.choice = choice::of_one(&comparison, Build::OPTIMISED);
    Ok(comparison)
}

/// Places of the ways of a stage.
const OURS: usize = 0;
const NAIVE: usize = 1;
const DOUBLE: usize = 2;

/// What is built in, the textbook's and the truth's way at all of `inputs`. Of
/// several errors the largest counts.
fn ways<'w, I, T, E, const N: usize>(
    inputs: &'w [I],
    ours: impl Fn(&I) -> T + 'w,
    naive: impl Fn(&I) -> T + 'w,
    exact: impl Fn(&I) -> E + 'w,
    error: impl Fn(T, &E) -> [f64; N] + 'w,
) -> Vec<Way<'w>> {
    let truth: Vec<E> = inputs.iter().map(&exact).collect();
    let errors = |of: &dyn Fn(&I) -> T| {
        let mut errors = vec![Vec::with_capacity(inputs.len()); parts_of(N)];
        for (input, truth) in inputs.iter().zip(&truth) {
            let found = error(of(input), truth);
            let worst = |a: f64, b: f64| if b.is_nan() { b } else { a.max(b) };
            let all = [found.into_iter().fold(0.0, worst)];
            for (errors, one) in errors.iter_mut().zip(all.into_iter().chain(found)) {
                // A NaN is as far off as can be.
                errors.push(if one.is_nan() { f64::INFINITY } else { one });
            }
        }
        errors
    };
    let (of_ours, of_naive) = (errors(&ours), errors(&naive));
    let none = vec![vec![0.0; inputs.len()]; parts_of(N)];
    vec![
        Way {
            name: "built in, f32",
            errors: of_ours,
            run: each(inputs, ours),
        },
        Way {
            name: "textbook, f32",
            errors: of_naive,
            run: each(inputs, naive),
        },
        Way {
            name: "f64",
            errors: none,
            run: each(inputs, exact),
        },
    ]
}

/// Columns of errors for so many kinds of them: one alone is the largest.
const fn parts_of(kinds: usize) -> usize {
    if kinds == 1 { 1 } else { 1 + kinds }
}

/// Works through the inputs for the sake of it.
fn each<'w, I, T>(inputs: &'w [I], way: impl Fn(&I) -> T + 'w) -> Box<dyn Fn() + 'w> {
    Box::new(move || {
        for input in inputs {
            black_box(way(input));
        }
    })
}

const fn in_unit(labels: [&'static str; 3]) -> [Measure; 3] {
    let [largest, most, mean] = labels;
    [
        measure("largest", largest),
        measure("percentile_95", most),
        measure("mean", mean),
    ]
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
        measures: in_unit(["largest error of the level", "95 % are below", "mean"]),
        parts: &[],
        limit: Limit {
            error: 1.0e-6,
            because: "it changes what one ray in a million does",
        },
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
        measures: in_unit(["largest error, pixels of 4096²", "95 % are below", "mean"]),
        parts: &[],
        limit: Limit {
            error: 1.0e-3,
            because: "a thousandth of a pixel",
        },
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
            // As is built in, where weights are computed and not asked for here.
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
        measures: in_unit([
            "largest error, parts of 2⁻²⁴ of the distance",
            "95 % are below",
            "mean",
        ]),
        parts: &[],
        limit: Limit {
            error: 32.0,
            because: "as far off do secondary rays start",
        },
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
        measures: in_unit([
            "largest error: relative, of a share, or rad, of the direction",
            "95 % are below",
            "mean",
        ]),
        parts: &PARTS_OF_LIGHT,
        limit: Limit {
            error: 2.0e-6,
            because: "what the documentation promises of shares, a thousandth of a step of 8 bits",
        },
        steps: None,
    };
    compare(bench, stage, ways, share)
}

const PARTS_OF_LIGHT: [Measure; 2] = [
    measure("shares", "shares, largest, relative"),
    measure("direction_rad", "direction, largest, rad"),
];

/// Between two directions of any length: radians.
fn angle(a: DVec3, b: DVec3) -> f64 {
    libm::atan2(a.cross(b).length(), a.dot(b))
}

#[cfg(test)]
mod tests {
    use super::super::Effort;
    use super::*;
    use shisen::scene::quadruped::quadruped;

    fn section_of(effort: Effort) -> Section {
        let bench = Bench {
            effort,
            threads: 1,
            mesh: &quadruped(),
            progress: &|_| (),
        };
        section(&bench).unwrap()
    }

    #[test]
    fn what_is_built_in_is_within_its_limits_and_double_precision_is_the_truth() {
        let section = section_of(Effort::Quick);
        assert_eq!(section.comparisons.len(), 5);
        let choice = &section.choice;
        let bounds = "as it is built in";
        assert!(
            choice.starts_with("Choose ") && choice.contains(bounds),
            "{choice}"
        );
        assert!(
            choice.contains("all 5 stages keep to their bounds"),
            "{choice}"
        );
        for comparison in &section.comparisons {
            let [ours, naive, double] = &comparison.points[..] else {
                panic!("{}", comparison.id);
            };
            let largest = |point: &Point| point.errors[0].unwrap_or(f64::INFINITY);
            assert!(
                largest(ours) > 0.0 && largest(ours) <= comparison.limit.error,
                "{ours:?}"
            );
            assert!(largest(naive) > largest(ours), "{naive:?} {ours:?}");
            assert_eq!(largest(double), 0.0);
            let choice = choice::of_one(comparison, true);
            assert!(
                choice.starts_with("Choose ") && choice.contains("or less: by "),
                "{choice}"
            );
            assert!(comparison.points.iter().all(|point| point.seconds > 0.0));
            for point in &comparison.points {
                let [largest, most, mean] = [0, 1, 2].map(|i| point.errors[i].unwrap_or(f64::MAX));
                assert!(mean <= most.max(largest) && most <= largest, "{point:?}");
            }
        }
    }

    #[test]
    fn a_primitive_is_a_step_and_formulas_have_none() {
        let stages = |of: &Section| -> Vec<(&str, Option<u64>)> {
            let all = of.comparisons.iter();
            all.map(|one| (one.id, one.points[0].steps)).collect()
        };
        let found = stages(&section_of(Effort::Quick));
        let expected = [
            ("level", None),
            ("mirror", None),
            ("intersection", Some(20_000)),
            ("refraction", None),
            ("colour", None),
        ];
        assert_eq!(found, expected);
    }
}
