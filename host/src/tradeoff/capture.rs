//! Dome masters through mirrors: which mirror, how, how large.

use super::{
    Bench, Cause, Comparison, Limit, Measure, Point, Section, Time, Topic, measure, timed,
};
use crate::bake::Baked;
use crate::dome::{Design, Mapping, Named, NearField, size_errors};
use crate::render;
use crate::scene::builtin::grid;
use crate::scene::camera::DomeCamera;
use glam::DVec2;
use serde_json::Value;
use shisen_core::frame::{DomeProjection, MirrorCamera, View};
use std::f32::consts::PI;
use std::f64::consts::{FRAC_2_PI, FRAC_PI_2};
use std::hint::black_box;

/// From the screen's centre to the nearest surface: metres, a hundred radii of
/// the mirror.
const NEAREST: f32 = 0.1;
const RADIUS: f32 = 1.0e-3;

pub(super) fn section(bench: &Bench<'_>) -> Result<Section, Cause> {
    let scene = Baked::new(&grid(NEAREST))?;
    let about = format!(
        "A dome master of meridians and parallels on a sphere about the screen's centre, by the \
         paper's mirrors (paper-1 to paper-3, its Table 1) and the best ones, of {} mm: as the \
         mirror shows it (mirror), with the mirror's point chosen for each pixel so that its \
         direction is right (exact), and by a fisheye without a mirror (true). Errors are angles \
         in pixels of a picture of 4,096².",
        1e3 * RADIUS
    );
    let comparisons = vec![
        mappings(bench, &scene)?,
        sizes(bench, &scene)?,
        mirror_sizes(bench)?,
        precision(bench)?,
    ];
    let title = "Dome masters through a mirror";
    Ok(Section::new(Topic::Capture, title, about, comparisons))
}

/// How a picture is taken.
#[derive(Clone, Copy)]
struct Optics {
    mirror: Named,
    mapping: Mapping,
    /// Equatorial, of the mirror: metres.
    radius: f32,
    /// Pixels a side.
    size: u32,
}

impl Optics {
    fn view(&self) -> Result<View, Cause> {
        let projection = match self.mapping.core() {
            None => DomeProjection::Equidistant { field_of_view: PI },
            Some(mapping) => {
                let mirror = self.mirror.mirror().single()?;
                DomeProjection::Mirror(MirrorCamera {
                    mirror,
                    mapping,
                    radius: self.radius,
                    viewpoint: mirror.screen_distance(),
                    mirrored: false,
                })
            }
        };
        Ok(View::dome(
            projection,
            DomeCamera::UPRIGHT.pose(),
            self.size,
        )?)
    }

    fn point(&self, series: &'static str, name: String) -> Point {
        let mirror = match self.mapping {
            Mapping::True => Value::Null,
            _ => self.mirror.name().into(),
        };
        let settings = [
            ("mirror", mirror),
            ("mapping", self.mapping.name().into()),
            ("mirror_radius_m", f64::from(self.radius).into()),
            ("size", self.size.into()),
        ];
        Point::new(series, name, settings)
    }

    /// How far off what is far away is seen, at most: pixels of 4,096.
    fn far_error(&self) -> f64 {
        let design = Design::of(self.mirror.mirror()).mapped(self.mapping);
        design.error_px_4096
    }

    /// The same of surroundings at a distance in equatorial radii.
    fn near_error(&self, distance: f64) -> Option<f64> {
        let near = NearField::new(self.mirror.mirror(), self.mapping);
        near.check(distance).ok()?;
        Some(near.largest(distance).px_4096())
    }

    fn name(&self) -> String {
        match self.mapping {
            Mapping::True => "true".to_owned(),
            mapping => format!("{} {}", self.mirror.name(), mapping.name()),
        }
    }
}

/// Each picture's time and steps.
fn render(
    bench: &Bench<'_>,
    scene: &Baked,
    optics: &[Optics],
    share: (f64, f64),
) -> Result<Vec<(Time, u64)>, Cause> {
    let mut options = bench.options();
    options.tile = 8;
    bench.in_turns(optics, share, |one| {
        let (view, quiet) = (one.view()?, |_, _| {});
        let picture = render::dome(&scene.scene(), &view, None, &options, &quiet)?;
        Ok((picture.seconds, picture.statistics.steps))
    })
}

/// All mirrors and mappings of one size.
fn all(size: u32) -> Vec<Optics> {
    let mut all = Vec::new();
    for mapping in [Mapping::Mirror, Mapping::Exact] {
        for mirror in Named::ALL {
            all.push(Optics {
                mirror,
                mapping,
                radius: RADIUS,
                size,
            });
        }
    }
    all.push(Optics {
        mirror: Named::Best,
        mapping: Mapping::True,
        radius: RADIUS,
        size,
    });
    all
}

const NEAR_ERRORS: [Measure; 3] = [
    measure("near_100_px", "error at 100 radii, px of 4,096"),
    measure("far_px", "far away, px"),
    measure("near_10_px", "at 10 radii, px"),
];

fn mappings(bench: &Bench<'_>, scene: &Baked) -> Result<Comparison, Cause> {
    let asked = all(bench.effort.pick(256, 1024));
    let measured = render(bench, scene, &asked, (0.0, 0.3))?;
    let points = asked
        .iter()
        .zip(measured)
        .map(|(one, (time, steps))| Point {
            errors: vec![
                one.near_error(100.0),
                Some(one.far_error()),
                one.near_error(10.0),
            ],
            seconds: time.median,
            spread: time.spread,
            steps: Some(steps),
            ..one.point(one.mapping.name(), one.name())
        });
    let limit = Limit {
        error: 0.5,
        because: "half a pixel",
    };
    Ok(Comparison::new(
        ("mappings", "Which mirror, and how it is looked at"),
        "The largest error over the picture, of surroundings at 100 and at 10 mirror radii and of \
         what is far away.",
        NEAR_ERRORS.to_vec(),
        limit,
        points.collect(),
    ))
}

fn sizes(bench: &Bench<'_>, scene: &Baked) -> Result<Comparison, Cause> {
    let mut asked = Vec::new();
    for &size in bench.effort.pick(
        &[64u32, 256, 1024][..],
        &[64, 128, 256, 512, 1024, 2048, 4096],
    ) {
        let of_size = all(size).into_iter().filter(|one| {
            matches!(one.mapping, Mapping::True)
                || matches!(one.mirror, Named::Paper1 | Named::Best)
        });
        asked.extend(of_size);
    }
    let measured = render(bench, scene, &asked, (0.3, 0.7))?;
    let points = asked.iter().zip(measured).map(|(one, (time, steps))| {
        // Half a pixel's diagonal, of the picture from rim to rim.
        let pixel = 4096.0 / f64::from(one.size) * std::f64::consts::FRAC_1_SQRT_2;
        let off = pixel + one.far_error();
        Point {
            errors: vec![Some(off), Some(pixel), Some(one.far_error())],
            seconds: time.median,
            spread: time.spread,
            steps: Some(steps),
            ..one.point(one.mapping.name(), format!("{}, {}²", one.name(), one.size))
        }
    });
    let measures = vec![
        measure("off_px", "error, px of 4,096"),
        measure("pixel_px", "half a pixel, px"),
        measure("far_px", "mirror, px"),
    ];
    let limit = Limit {
        error: 4.0,
        because: "a pixel of 1,024²",
    };
    let mut comparison = Comparison::new(
        ("sizes", "How large a picture"),
        "How far from its place at most a pixel shows what is far away: half of its own diagonal \
         and what the mirror is off, both computed from the formulas and not seen in the pictures, \
         whose times and steps are measured.",
        measures,
        limit,
        points.collect(),
    );
    comparison.logarithmic = true;
    Ok(comparison)
}

fn mirror_sizes(bench: &Bench<'_>) -> Result<Comparison, Cause> {
    let size = bench.effort.pick(128, 512);
    let mut asked = Vec::new();
    for &part in bench.effort.pick(
        &[1e-6f64, 1e-4, 1e-2, 1e-1][..],
        &[1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 3e-2, 1e-1, 3e-1],
    ) {
        for mapping in [Mapping::Mirror, Mapping::Exact] {
            let radius = part as f32 * NEAREST;
            let mirror = Named::Best;
            asked.push((
                part,
                Optics {
                    mirror,
                    mapping,
                    radius,
                    size,
                },
            ));
        }
    }
    let optics: Vec<Optics> = asked.iter().map(|one| one.1).collect();
    let measured = render(bench, &Baked::new(&grid(NEAREST))?, &optics, (0.7, 0.9))?;
    let mut points = Vec::new();
    for ((part, one), (time, steps)) in asked.iter().zip(measured) {
        let near = NearField::new(one.mirror.mirror(), one.mapping);
        let errors = size_errors(&near, *part, 1.0)?;
        let sum = errors.near_field.map(|near| near + errors.rounding);
        points.push(Point {
            errors: vec![sum, errors.near_field, Some(errors.rounding), errors.world],
            seconds: time.median,
            spread: time.spread,
            steps: Some(steps),
            ..one.point(
                one.mapping.name(),
                format!("{} of {part:e}", one.mapping.name()),
            )
        });
    }
    let measures = vec![
        measure("off_px", "error, px of 4,096"),
        measure("near_field_px", "parallax, px"),
        measure("rounding_px", "rounding, px"),
        measure("world_px", "rounding as an object of the world, px"),
    ];
    let limit = Limit {
        error: 0.5,
        because: "half a pixel",
    };
    let mut comparison = Comparison::new(
        ("mirror-sizes", "How large a mirror"),
        "The best mirror, as large as a part of the distance to the nearest surface: a large one \
         has parallax, and a small one, were it an object of the world, would have no digits left \
         of its shape. Traced in its own frame, it keeps them.",
        measures,
        limit,
        points,
    );
    comparison.logarithmic = true;
    Ok(comparison)
}

/// Single and double precision.
fn precision(bench: &Bench<'_>) -> Result<Comparison, Cause> {
    let side = bench.effort.pick(96u32, 256);
    // Places of the picture, from rim to rim.
    let place = |x: u32| (f64::from(x) + 0.5) / f64::from(side) * 2.0 - 1.0;
    let places: Vec<DVec2> = (0..side * side)
        .map(|i| DVec2::new(place(i % side), place(i / side)))
        .filter(|place| place.length() < 1.0)
        .collect();
    let mut asked = Vec::new();
    for mapping in [Mapping::Mirror, Mapping::Exact] {
        for double in [false, true] {
            asked.push((Named::Best, mapping, double));
        }
    }
    let measured = bench.in_turns(&asked, (0.9, 1.0), |&(named, mapping, double)| {
        let mirror = named.mirror();
        let single = mirror.single()?;
        let b1 = mirror.parameters().b1;
        let (seconds, ()) = timed(|| {
            for place in &places {
                if double {
                    let rho = place.length();
                    let on_screen = match mapping {
                        Mapping::Mirror => rho,
                        _ => mirror.r_d(rho * FRAC_PI_2) * FRAC_2_PI,
                    };
                    black_box(mirror.reflect(*place * (on_screen / rho * b1)));
                } else if let Some(mapping) = mapping.core() {
                    let place = place.as_vec2();
                    black_box(single.pixel(place.x, place.y, mapping));
                }
            }
        });
        let near = NearField::new(mirror, mapping);
        // Small, so that there is nothing but rounding.
        let off = if double {
            0.0
        } else {
            size_errors(&near, 1e-6, 0.0)?.rounding
        };
        Ok((seconds, off))
    })?;
    let points = asked.iter().zip(measured).map(|(one, (time, off))| {
        let &(mirror, mapping, double) = one;
        let precision = if double { "f64" } else { "f32" };
        let name = format!("{precision} {}", mapping.name());
        let settings = [
            ("mirror", mirror.name().into()),
            ("mapping", mapping.name().into()),
            ("precision", precision.into()),
            ("rays", places.len().into()),
        ];
        Point {
            errors: vec![Some(off)],
            seconds: time.median,
            spread: time.spread,
            ..Point::new(precision, name, settings)
        }
    });
    let limit = Limit {
        error: 0.01,
        because: "a hundredth of a pixel",
    };
    let mut comparison = Comparison::new(
        ("precision", "Single or double precision"),
        format!(
            "The rays of the best mirror alone, {} of them on one thread: as the core computes them, and as the \
             reference does, which counts as the truth.",
            places.len()
        ),
        vec![measure("rounding_px", "rounding, px of 4,096")],
        limit,
        points.collect(),
    );
    comparison.logarithmic = true;
    Ok(comparison)
}
