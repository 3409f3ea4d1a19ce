//! What single precision loses, stage by stage: what is built in, the same in
//! double precision, and the textbook's way in single.

use super::front::percent;
use super::page::brief;
use super::{Bench, Cause, Comparison, Limit, Measure, Point, Section, Topic, measure, timed};
use crate::dome::Mirror;
use crate::gaze_reference::{self, Limits};
use crate::quantiles::quantile_of;
use crate::selftest::naive::{moller_trumbore, printed_level, textbook_refraction, traced_mirror};
use crate::selftest::{Inputs, exact_refraction};
use glam::{DMat3, DVec2, DVec3, Vec3};
use shisen_core::capture::{Mapping, SpheroidMirror};
use shisen_core::gaze::{Boundary, Gaze, LineOfSight, VisualField};
use shisen_core::shape::{Ray, Triangle};
use shisen_core::spectrum::rgb_from_xyz;
use shisen_core::trace::refract;
use std::f64::consts::{FRAC_PI_2, TAU};
use std::hint::black_box;

/// Errors of a way at all inputs.
type Errors = Vec<f64>;

/// A way to do a stage: all inputs are worked through, and what came of each is
/// held against the truth.
struct Way<'w> {
    name: &'static str,
    /// Works through the inputs and gives nothing: what is timed.
    run: Box<dyn Fn() + 'w>,
    errors: Errors,
}

/// A part of a ray's life.
struct Stage {
    id: &'static str,
    title: &'static str,
    about: &'static str,
    /// The largest error, in a unit, and the same of 95 % and of the mean.
    measures: [Measure; 3],
    limit: Limit,
}

pub(super) fn section(bench: &Bench<'_>) -> Result<Section, Cause> {
    let count = bench.effort.pick(20_000, 200_000);
    let comparisons = vec![
        level(bench, count, (0.0, 0.2))?,
        mirror(bench, count, (0.2, 0.4))?,
        intersection(bench, count, (0.4, 0.6))?,
        refraction(bench, count, (0.6, 0.8))?,
        colour(bench, count, (0.8, 1.0))?,
    ];
    let about = format!(
        "Each stage of a ray on {count} usual inputs, drawn at random and the same on every run, \
         one after another on one thread: as it is built in, the textbook's formula in single \
         precision, and double precision, which is the truth here and was written for clearness \
         and not for speed. Times are of all inputs. What is not usual is among the hard cases \
         below."
    );
    let title = "Single precision";
    Ok(Section::new(Topic::Precision, title, about, comparisons))
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
        let errors = way.errors;
        let largest = quantile_of(errors.clone(), 1.0);
        let mean = errors.iter().sum::<f64>() / errors.len().max(1) as f64;
        let number = |x: f64| x.is_finite().then_some(x);
        let of = [largest, quantile_of(errors, 0.95), mean];
        Point {
            errors: of.map(number).to_vec(),
            seconds: time.median,
            spread: time.spread,
            ..Point::new(stage.id, way.name, [("way", way.name.into())])
        }
    });
    let mut comparison = Comparison::new(
        (stage.id, stage.title),
        stage.about,
        stage.measures.to_vec(),
        stage.limit,
        points.collect(),
    );
    comparison.logarithmic = true;
    comparison.choice = choice(&comparison);
    Ok(comparison)
}

/// What the points say of the way that is built in: the others are no settings.
fn choice(comparison: &Comparison) -> String {
    let [ours, naive, double] = &comparison.points[..] else {
        return "Nothing was measured.".to_owned();
    };
    let largest = |point: &Point| match point.errors.first().copied().flatten() {
        Some(error) => brief(error),
        None => "no number".to_owned(),
    };
    let enough = if ours.error() <= comparison.limit.error {
        "Single precision is enough"
    } else {
        "Single precision is not enough"
    };
    format!(
        "{enough}: what is built in is off by {} at most, of {} ({}); the textbook's formula by \
         {}, in {} of its time, and double precision takes {} of it.",
        largest(ours),
        brief(comparison.limit.error),
        comparison.limit.because,
        largest(naive),
        percent(naive.seconds / ours.seconds),
        percent(double.seconds / ours.seconds),
    )
}

/// What is built in, the textbook's and the truth's way at all of `inputs`.
fn ways<'w, I, T: Copy>(
    inputs: &'w [I],
    ours: impl Fn(&I) -> T + 'w,
    naive: impl Fn(&I) -> T + 'w,
    exact: impl Fn(&I) -> DVec3 + 'w,
    error: impl Fn(T, DVec3) -> f64 + 'w,
) -> Vec<Way<'w>> {
    let truth: Vec<DVec3> = inputs.iter().map(&exact).collect();
    let errors = |of: &dyn Fn(&I) -> T| -> Errors {
        let both = inputs.iter().zip(&truth);
        both.map(|(input, &truth)| error(of(input), truth))
            .collect()
    };
    let (of_ours, of_naive) = (errors(&ours), errors(&naive));
    let none = vec![0.0; inputs.len()];
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

/// A number, where vectors go.
fn number(x: f64) -> DVec3 {
    DVec3::new(x, 0.0, 0.0)
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
            number(
                double
                    .sight(d.as_dvec3())
                    .map_or(f64::NAN, |sight| sight.level),
            )
        },
        |found, exact| (f64::from(found) - exact.x).abs(),
    );
    let stage = Stage {
        id: "level",
        title: "Level of a ray",
        about: "Equations 4 to 8 of Mochizuki and Makino in all directions, a hundredth of them \
                straight up, against arc tangents in double precision.",
        measures: in_unit(["largest error of the level", "95 % are below", "mean"]),
        limit: Limit {
            error: 1.0e-6,
            because: "it changes what one ray in a million does",
        },
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
        |found, exact| {
            let found = found.as_dvec3();
            let angle = found.cross(exact).length().atan2(found.dot(exact));
            angle / FRAC_PI_2 * 2048.0
        },
    );
    let stage = Stage {
        id: "mirror",
        title: "Ray off a mirror",
        about: "The best mirror's rays, over the whole dome master.",
        measures: in_unit(["largest error, pixels of 4096²", "95 % are below", "mean"]),
        limit: Limit {
            error: 1.0e-3,
            because: "a thousandth of a pixel",
        },
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
            let [a, b, c] = corners.map(Vec3::as_dvec3);
            let (o, d) = (ray.origin().as_dvec3(), ray.direction().as_dvec3());
            let normal = (b - a).cross(c - a);
            number(normal.dot(a - o) / normal.dot(d))
        },
        |found, exact| (f64::from(found) - exact.x).abs() / exact.x * 16_777_216.0,
    );
    let stage = Stage {
        id: "intersection",
        title: "Distance of a triangle",
        about: "Triangles of 20 cm in a scene of 4 m, hit in the middle at 0.1 rad or more.",
        measures: in_unit([
            "largest error, parts of 2⁻²⁴ of the distance",
            "95 % are below",
            "mean",
        ]),
        limit: Limit {
            error: 32.0,
            because: "as far off do secondary rays start",
        },
    };
    compare(bench, stage, ways, share)
}

fn refraction(bench: &Bench<'_>, count: usize, share: (f64, f64)) -> Result<Comparison, Cause> {
    let mut draw = Inputs::new(53);
    let inputs: Vec<(Vec3, f32)> = (0..count)
        .map(|_| {
            let cos = draw.range(1.0e-3, 1.0) as f32;
            let sin = (1.0 - f64::from(cos) * f64::from(cos)).sqrt() as f32;
            (Vec3::new(sin, -cos, 0.0), draw.range(1.1, 2.4) as f32)
        })
        .collect();
    let ways = ways(
        &inputs,
        |&(d, n)| {
            let found = refract(d, Vec3::Y, 1.0, n);
            [found.reflectance, found.transmittance]
        },
        |&(d, n)| {
            let found = textbook_refraction(d, Vec3::Y, 1.0, n);
            found.map_or([f32::NAN; 2], |(r, t, _)| [r, t])
        },
        |&(d, n)| {
            let shares = exact_refraction(f64::from(-d.y), 1.0, n.into());
            shares.map_or(DVec3::NAN, |(r, t)| DVec3::new(r, t, 0.0))
        },
        |[r, t], exact| {
            let relative = |found: f32, exact: f64| (f64::from(found) / exact - 1.0).abs();
            relative(r, exact.x).max(relative(t, exact.y))
        },
    );
    let stage = Stage {
        id: "refraction",
        title: "Light at a border",
        about: "Fresnel's equations from air into glass, at all angles: the reflected and the \
                transmitted share, whichever is further off.",
        measures: in_unit(["largest error, relative", "95 % are below", "mean"]),
        limit: Limit {
            error: 2.0e-6,
            because: "what the documentation promises, a thousandth of a step of 8 bits",
        },
    };
    compare(bench, stage, ways, share)
}

fn colour(bench: &Bench<'_>, count: usize, share: (f64, f64)) -> Result<Comparison, Cause> {
    let exact = linear_srgb();
    // As most pages print it.
    let printed = [
        Vec3::new(3.2406, -1.5372, -0.4986),
        Vec3::new(-0.9689, 1.8758, 0.0415),
        Vec3::new(0.0557, -0.2040, 1.0570),
    ];
    let mut draw = Inputs::new(54);
    let inputs: Vec<Vec3> = (0..count)
        .map(|_| {
            // Colours that a display can show.
            let rgb = DVec3::new(draw.unit(), draw.unit(), draw.unit());
            (exact.inverse() * rgb).as_vec3()
        })
        .collect();
    let ways = ways(
        &inputs,
        |&xyz| rgb_from_xyz(xyz),
        |&xyz| Vec3::from_array(printed.map(|row| row.dot(xyz))),
        move |&xyz| exact * xyz.as_dvec3(),
        |found, exact| (found.as_dvec3() - exact).abs().max_element(),
    );
    let stage = Stage {
        id: "colour",
        title: "Colour",
        about: "XYZ to linear sRGB of all colours that a display can show, against the matrix of \
                its primaries and its white in double precision.",
        measures: in_unit(["largest error of a channel", "95 % are below", "mean"]),
        limit: Limit {
            error: 1.0e-5,
            because: "a thirtieth of the least step of 8 bits near black",
        },
    };
    compare(bench, stage, ways, share)
}

/// Of D65, as ASTM E308 has it.
const WHITE: DVec3 = DVec3::new(0.950_47, 1.0, 1.088_83);

/// Linear sRGB of XYZ, from the primaries of IEC 61966-2-1 and the white.
fn linear_srgb() -> DMat3 {
    let xyz = |x: f64, y: f64| DVec3::new(x / y, 1.0, (1.0 - x - y) / y);
    let primaries = DMat3::from_cols(xyz(0.64, 0.33), xyz(0.30, 0.60), xyz(0.15, 0.06));
    let shares = primaries.inverse() * WHITE;
    (primaries * DMat3::from_diagonal(shares)).inverse()
}

#[cfg(test)]
mod tests {
    use super::super::Effort;
    use super::*;
    use crate::quadruped::quadruped;

    #[test]
    fn what_is_built_in_is_within_its_limits_and_double_precision_is_the_truth() {
        let bench = Bench {
            effort: Effort::Quick,
            threads: 1,
            mesh: &quadruped(),
            progress: &|_| (),
        };
        let section = section(&bench).unwrap();
        assert_eq!(section.comparisons.len(), 5);
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
            let choice = &comparison.choice;
            assert!(
                choice.starts_with("Single precision is enough: "),
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
    fn white_is_white() {
        let white = linear_srgb() * WHITE;
        assert!(
            (white - DVec3::ONE).abs().max_element() < 1.0e-14,
            "{white}"
        );
        // All of it is of the primaries: red alone has their red's colour.
        let red = linear_srgb().inverse() * DVec3::X;
        let sum = red.element_sum();
        assert!((red.x / sum - 0.64).abs() < 1.0e-14 && (red.y / sum - 0.33).abs() < 1.0e-14);
    }
}
