//! Dome masters through mirrors: which mirror, how, how large.

mod places;

use super::frames::baked;
use super::front::percent;
use super::page::brief;
use super::{
    Bench, Build, Cause, Comparison, Limit, Measure, Point, Section, Time, Topic, measure, timed,
};
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

/// From the screen's centre to the nearest surface: metres, a hundred radii of
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

    fn picture(&self, bench: &Bench<'_>, scene: &Baked) -> Result<DomePicture, Cause> {
        let mut options = bench.options();
        options.tile = 8;
        let (view, quiet) = (self.view()?, |_, _| {});
        Ok(render::dome(&scene.scene(), &view, None, &options, &quiet)?)
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

/// Each picture with its time and its steps.
fn render(
    bench: &Bench<'_>,
    scene: &Baked,
    optics: &[Optics],
    share: (f64, f64),
) -> Result<Vec<(Time, DomePicture)>, Cause> {
    bench.in_turns(optics, share, |one| {
        let picture = one.picture(bench, scene)?;
        Ok((picture.seconds, picture))
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
        .map(|(one, (time, picture))| Point {
            errors: vec![
                one.near_error(100.0),
                Some(one.far_error()),
                one.near_error(10.0),
            ],
            seconds: time.median,
            spread: time.spread,
            steps: Some(picture.statistics.steps),
            ..one.point(one.mapping.name(), one.name())
        });
    let limit = Limit {
        error: 0.5,
        because: "half a pixel",
    };
    let mut comparison = Comparison::new(
        ("mappings", "Which mirror, and how it is looked at"),
        "The largest error over the picture, of surroundings at 100 and at 10 mirror radii and of \
         what is far away.",
        NEAR_ERRORS.to_vec(),
        limit,
        points.collect(),
    );
    comparison.choice = choice(&comparison.points);
    Ok(comparison)
}

/// For each mapping what to choose: which of them is not a matter of its price, but of
/// what the picture has to be.
fn choice(points: &[Point]) -> String {
    let nearest = |mapping: Mapping| {
        let of = points.iter().filter(|one| one.series == mapping.name());
        of.min_by(|a, b| a.error().total_cmp(&b.error()))
    };
    let farthest = |mapping: Mapping| {
        let of = points.iter().filter(|one| one.series == mapping.name());
        of.max_by(|a, b| a.error().total_cmp(&b.error()))
    };
    let steps = |point: &Point| point.steps.unwrap_or(0) as f64;
    let all = [Mapping::True, Mapping::Exact, Mapping::Mirror].map(nearest);
    let ([Some(lens), Some(unwarped), Some(mirror)], Some(worst)) =
        (all, farthest(Mapping::Mirror))
    else {
        return "Nothing was measured.".to_owned();
    };
    let off = |point: &Point| format!("{} px", brief(point.error()));
    let to_lens = |point: &Point| percent(steps(point) / steps(lens).max(1.0));
    format!(
        "To render a dome, choose {}: off by {}, in {} million steps, and no mirror has to be \
         there. Where the picture has to be what a mirror shows, as beside a photograph or a live \
         camera over one, choose {}: {} ({} with {}), {} of the steps; where such a picture is \
         unwarped, {}: {}, {} of the steps.",
        lens.name,
        off(lens),
        brief(1e-6 * steps(lens)),
        mirror.name,
        off(mirror),
        off(worst),
        worst.name,
        to_lens(mirror),
        unwarped.name,
        off(unwarped),
        to_lens(unwarped),
    )
}

/// Those whose sizes are compared, the nearest at 100 radii first: where several are as
/// near and as dear, it is the one that [`mappings`] prefers that is chosen.
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
    let mut asked = Vec::new();
    for &size in bench.effort.pick(
        &[64u32, 256, 1024][..],
        &[64, 128, 256, 512, 1024, 2048, 4096],
    ) {
        asked.extend(optics.iter().map(|&one| Optics { size, ..one }));
    }
    let places = Places::new(bench, scene)?;
    let measured = render(bench, scene, &asked, (0.3, 0.7))?;
    let mut points = Vec::new();
    for (one, (time, picture)) in asked.iter().zip(measured) {
        points.push(Point {
            errors: places.errors(one, &picture.picture)?,
            seconds: time.median,
            spread: time.spread,
            steps: Some(picture.statistics.steps),
            ..one.point(one.mapping.name(), format!("{}, {}²", one.name(), one.size))
        });
    }
    let measures = vec![
        measure("off_px", "largest error, px of 4,096"),
        measure("off_95_px", "95 %, px"),
        measure("off_mean_px", "mean, px"),
        measure("wrong_colour_percent", "in another colour, %"),
    ];
    let limit = Limit {
        error: 4.0,
        because: "a pixel of 1,024²",
    };
    let mut comparison = Comparison::new(
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
    comparison.logarithmic = true;
    Ok(comparison)
}

fn mirror_sizes(bench: &Bench<'_>, scene: &Baked) -> Result<Comparison, Cause> {
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
    let measured = render(bench, scene, &optics, (0.7, 0.9))?;
    let mut points = Vec::new();
    for ((part, one), (time, picture)) in asked.iter().zip(measured) {
        let near = NearField::new(one.mirror.mirror(), one.mapping);
        let errors = size_errors(&near, *part, 1.0)?;
        let sum = errors.near_field.map(|near| near + errors.rounding);
        points.push(Point {
            errors: vec![sum, errors.near_field, Some(errors.rounding), errors.world],
            seconds: time.median,
            spread: time.spread,
            steps: Some(picture.statistics.steps),
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
    comparison.choice = precision_choice(&comparison, Build::OPTIMISED);
    Ok(comparison)
}

/// A precision for each mapping: which mapping there is to be is another matter.
fn precision_choice(comparison: &Comparison, times_count: bool) -> String {
    let limit = &comparison.limit;
    let point = |precision: &str, mapping: Mapping| {
        let name = format!("{precision} {}", mapping.name());
        comparison.points.iter().find(|point| point.name == name)
    };
    let mut found = Vec::new();
    let mut enough = true;
    for mapping in [Mapping::Mirror, Mapping::Exact] {
        let (Some(single), Some(double)) = (point("f32", mapping), point("f64", mapping)) else {
            return "Nothing was measured.".to_owned();
        };
        enough &= single.error() <= limit.error;
        let text = format!("{} px by {}", brief(single.error()), mapping.name());
        let part = percent(double.seconds / single.seconds);
        found.push(if times_count {
            format!("{text} (f64 takes {part} of its time)")
        } else {
            text
        });
    }
    let precision = if enough { "f32" } else { "f64" };
    let told = if times_count {
        ""
    } else {
        " What f64 takes is not told by this build, which is not optimised."
    };
    format!(
        "Choose {precision}: f32 is off by {}, and up to {} ({}) counts as none.{told}",
        found.join(", "),
        brief(limit.error),
        limit.because,
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_equal_sizes_the_mapping_is_chosen_that_is_nearest() {
        let found = nearest_first();
        let names: Vec<String> = found.iter().map(Optics::name).collect();
        assert_eq!(names[0], "true");
        assert_eq!(names.len(), 5);
        let errors = found.iter().map(|one| one.near_error(100.0).unwrap());
        assert!(errors.collect::<Vec<_>>().is_sorted());
    }

    #[test]
    fn a_precision_is_chosen_for_each_mapping_by_what_it_loses() {
        let says = |error: f64, times_count: bool| {
            let points = [
                ("f32 mirror", error, 1.0),
                ("f64 mirror", 0.0, 0.9),
                ("f32 exact", 0.5 * error, 1.0),
                ("f64 exact", 0.0, 30.0),
            ];
            let points = points.map(|(name, error, seconds)| Point {
                errors: vec![Some(error)],
                seconds,
                ..Point::new("one", name, [])
            });
            let limit = Limit {
                error: 0.01,
                because: "a hundredth of a pixel",
            };
            let of = ("precision", "Precision");
            let measures = vec![measure("rounding_px", "px")];
            let comparison = Comparison::new(of, "", measures, limit, points.into());
            precision_choice(&comparison, times_count)
        };
        let found = says(2.0e-4, true);
        let expected = "Choose f32: f32 is off by 0.0002 px by mirror (f64 takes 90 % of its \
            time), 0.0001 px by exact (f64 takes 3000 % of its time), and up to 0.01 (a hundredth \
            of a pixel) counts as none.";
        assert_eq!(found, expected);
        let found = says(2.0e-4, false);
        assert!(
            found.ends_with("which is not optimised.") && !found.contains('%'),
            "{found}"
        );
        assert!(says(0.1, true).starts_with("Choose f64: "));
    }
}
