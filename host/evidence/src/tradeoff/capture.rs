//! Dome masters through mirrors: which mirror, which mapping, how large.

mod places;

use super::frames::baked;
use super::{Bench, Cause, Comparison, Limit, Measure, Point, Section, limit, measure, timed};
use crate::measure::Timed;
use glam::DVec2;
use places::Places;
use serde_json::Value;
use shisen::bake::Baked;
use shisen::dome::{Design, Mapping, Named, NearField, size_errors};
use shisen::render::{self, DomePicture};
use shisen::scene::camera::DomeCamera;
use shisen_core::frame::{DomeProjection, MirrorCamera, View};
use std::f32::consts::PI;
use std::f64::consts::{FRAC_2_PI, FRAC_PI_2};
use std::hint::black_box;

/// The distance from the screen's centre to the nearest surface, metres: a hundred radii of
/// the mirror.
const NEAREST: f32 = 0.1;
const RADIUS: f32 = 1.0e-3;

pub(super) fn section(bench: &Bench<'_>) -> Result<Section, Cause> {
    let scene = baked(bench)?;
    let about = format!(
        "Dome masters of the paper's scene A, upright in its middle, three bounces, by the \
         paper's mirrors (paper-1 to paper-3, its Table 1) and the best ones, of {} mm. All are \
         rendered; what differs is what each pixel's ray is. By the mapping mirror it is the one \
         that a camera over the mirror has there, so that the picture is what a photograph of \
         such a mirror would be; by exact it is the one of the mirror's rays that has the right \
         direction, as if the photograph were unwarped; by true there is no mirror, and all rays \
         start in one point. Errors are angles in pixels of a picture of 4,096².",
        1e3 * RADIUS
    );
    let comparisons = vec![
        mappings(bench, &scene)?,
        sizes(bench, &scene)?,
        mirror_sizes(bench, &scene)?,
        precision(bench)?,
    ];
    let title = "Dome masters through a mirror";
    Ok(Section::new("capture", title, about, comparisons))
}

#[derive(Clone, Copy)]
struct Optics {
    mirror: Named,
    mapping: Mapping,
    /// The mirror's equatorial radius, metres.
    radius: f32,
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

    fn picture(&self, bench: &Bench<'_>, scene: &Baked) -> Result<DomePicture, Cause> {
        let mut options = bench.options();
        options.tile = 8;
        let (view, quiet) = (self.view()?, |_, _| {});
        Ok(render::dome(
            scene.scene().into(),
            &view,
            None,
            &options,
            &quiet,
        )?)
    }

    fn measured(&self, errors: Vec<Option<f64>>, name: String, time: &Timed<DomePicture>) -> Point {
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
        let point = Point::new(self.mapping.name(), name, settings);
        point.measured(errors, time, Some(time.first.statistics.steps))
    }

    /// Returns the largest error of surroundings that are far away, pixels of 4,096.
    fn far_error(&self) -> f64 {
        Design::of(self.mirror.mirror())
            .mapped(self.mapping)
            .error_px_4096
    }

    /// Returns the largest error of surroundings at a distance in equatorial radii, pixels of
    /// 4,096.
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

fn render(
    bench: &Bench<'_>,
    scene: &Baked,
    optics: &[Optics],
    share: (f64, f64),
) -> Result<Vec<Timed<DomePicture>>, Cause> {
    bench.in_turns(optics, share, |one| {
        let picture = one.picture(bench, scene)?;
        Ok((picture.seconds, picture))
    })
}

fn all(size: u32) -> Vec<Optics> {
    let optics = |mirror, mapping| Optics {
        mirror,
        mapping,
        radius: RADIUS,
        size,
    };
    let mut all = Vec::new();
    for mapping in [Mapping::Mirror, Mapping::Exact] {
        all.extend(Named::ALL.map(|mirror| optics(mirror, mapping)));
    }
    all.push(optics(Named::Best, Mapping::True));
    all
}

const NEAR_ERRORS: [Measure; 3] = [
    measure("near_100_px", "error at 100 radii, px of 4,096"),
    measure("far_px", "far away, px"),
    measure("near_10_px", "at 10 radii, px"),
];

fn mappings(bench: &Bench<'_>, scene: &Baked) -> Result<Comparison, Cause> {
    let pictures = all(bench.effort.pick(256, 1024));
    let measured = render(bench, scene, &pictures, (0.0, 0.3))?;
    let points = pictures.iter().zip(measured).map(|(one, time)| {
        let errors = [
            one.near_error(100.0),
            Some(one.far_error()),
            one.near_error(10.0),
        ];
        one.measured(errors.into(), one.name(), &time)
    });
    Ok(Comparison::new(
        ("mappings", "Which mirror, and how it is looked at"),
        "The largest error over the picture, of surroundings at 100 and at 10 mirror radii and of \
         what is far away. A picture by the mapping mirror is for comparison with a mirror, or with \
         a camera over one; exact, where such a picture is unwarped.",
        NEAR_ERRORS.to_vec(),
        HALF_A_PIXEL,
        points.collect(),
    ))
}

const HALF_A_PIXEL: Limit = limit(0.5, "half a pixel");

/// Returns the optics whose sizes are compared, the nearest at 100 radii first: of equal ones the
/// first is chosen.
fn nearest_first() -> Vec<Optics> {
    let mut optics = all(1);
    optics.retain(|one| {
        let is_true = matches!(one.mapping, Mapping::True);
        is_true || matches!(one.mirror, Named::Paper1 | Named::Best)
    });
    let error = |one: &Optics| one.near_error(100.0).unwrap_or(f64::INFINITY);
    optics.sort_by(|a, b| error(a).total_cmp(&error(b)));
    optics
}

fn sizes(bench: &Bench<'_>, scene: &Baked) -> Result<Comparison, Cause> {
    let optics = nearest_first();
    let mut pictures = Vec::new();
    for &size in bench.effort.pick(
        &[64u32, 256, 1024][..],
        &[64, 128, 256, 512, 1024, 2048, 4096],
    ) {
        pictures.extend(optics.iter().map(|&one| Optics { size, ..one }));
    }
    let places = Places::new(bench, scene)?;
    let measured = render(bench, scene, &pictures, (0.3, 0.7))?;
    let mut points = Vec::new();
    for (one, time) in pictures.iter().zip(measured) {
        let errors = places.errors(one, &time.first.picture)?;
        let name = format!("{}, {}²", one.name(), one.size);
        points.push(one.measured(errors, name, &time));
    }
    let measures = vec![
        measure("off_px", "largest error, px of 4,096"),
        measure("off_95_px", "95 %, px"),
        measure("off_mean_px", "mean, px"),
        measure("wrong_colour_percent", "in another colour, %"),
    ];
    let limit = limit(4.0, "a pixel of 1,024²");
    let comparison = Comparison::new(
        ("sizes", "How large a picture"),
        format!(
            "In {} directions, drawn at random: the angle from each to the ray of the pixel that \
             stands for it in the dome master, and how many have another colour there, by more \
             than 1 of CIEDE2000, than in a true picture of {}². What has the right directions \
             has the same angles with any mirror or none; of those the sentence names the nearest \
             of the first table.",
            places.at.len(),
            places.truth.size,
        ),
        measures,
        limit,
        points,
    );
    Ok(comparison.logarithmic())
}

fn mirror_sizes(bench: &Bench<'_>, scene: &Baked) -> Result<Comparison, Cause> {
    let size = bench.effort.pick(128, 512);
    let mut pictures = Vec::new();
    for &part in bench.effort.pick(
        &[1e-6f64, 1e-4, 1e-2, 1e-1][..],
        &[1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 3e-2, 1e-1, 3e-1],
    ) {
        for mapping in [Mapping::Mirror, Mapping::Exact] {
            let optics = Optics {
                mirror: Named::Best,
                mapping,
                radius: part as f32 * NEAREST,
                size,
            };
            pictures.push((part, optics));
        }
    }
    let optics: Vec<Optics> = pictures.iter().map(|one| one.1).collect();
    let measured = render(bench, scene, &optics, (0.7, 0.9))?;
    let mut points = Vec::new();
    for ((part, one), time) in pictures.iter().zip(measured) {
        let near = NearField::new(one.mirror.mirror(), one.mapping);
        let errors = size_errors(&near, *part, 1.0)?;
        let sum = errors.near_field_px.map(|near| near + errors.rounding_px);
        let errors = [
            sum,
            errors.near_field_px,
            Some(errors.rounding_px),
            errors.world_px,
        ];
        let name = format!("{} of {part:e}", one.mapping.name());
        points.push(one.measured(errors.into(), name, &time));
    }
    let measures = vec![
        measure("off_px", "error, px of 4,096"),
        measure("near_field_px", "parallax, px"),
        measure("rounding_px", "rounding, px"),
        measure("world_px", "rounding as an object of the world, px"),
    ];
    let comparison = Comparison::new(
        ("mirror-sizes", "How large a mirror"),
        "The best mirror, as large as a part of the distance to the nearest surface: a large one \
         has parallax, and a small one, were it an object of the world, would have no digits left \
         of its shape. Traced in its own frame, it keeps them.",
        measures,
        HALF_A_PIXEL,
        points,
    );
    Ok(comparison.logarithmic())
}

fn precision(bench: &Bench<'_>) -> Result<Comparison, Cause> {
    let side = bench.effort.pick(96u32, 256);
    // Places of the picture, from rim to rim.
    let place = |x: u32| (f64::from(x) + 0.5) / f64::from(side) * 2.0 - 1.0;
    let places: Vec<DVec2> = (0..side * side)
        .map(|i| DVec2::new(place(i % side), place(i / side)))
        .filter(|place| place.length() < 1.0)
        .collect();
    let mut pictures = Vec::new();
    for mapping in [Mapping::Mirror, Mapping::Exact] {
        for double in [false, true] {
            pictures.push((Named::Best, mapping, double));
        }
    }
    let measured = bench.in_turns(&pictures, (0.9, 1.0), |&(named, mapping, double)| {
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
            size_errors(&near, 1e-6, 0.0)?.rounding_px
        };
        Ok((seconds, off))
    })?;
    let points = pictures.iter().zip(measured).map(|(one, time)| {
        let &(mirror, mapping, double) = one;
        let precision = if double { "f64" } else { "f32" };
        let name = format!("{precision} {}", mapping.name());
        let settings = [
            ("mirror", mirror.name().into()),
            ("mapping", mapping.name().into()),
            ("precision", precision.into()),
            ("rays", places.len().into()),
        ];
        let point = Point::new(precision, name, settings);
        point.measured(vec![Some(time.first)], &time, None)
    });
    let limit = limit(0.01, "a hundredth of a pixel");
    let about = format!(
        "The rays of the best mirror alone, {} of them on one thread: as the core computes them, \
         and as the reference does, which counts as the truth.",
        places.len()
    );
    let title = ("precision", "Single or double precision");
    let measures = vec![measure("rounding_px", "rounding, px of 4,096")];
    let comparison = Comparison::new(title, about, measures, limit, points.collect());
    Ok(comparison.logarithmic())
}
