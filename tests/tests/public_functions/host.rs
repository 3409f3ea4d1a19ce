//! The host's constructors and formulas under the same numbers.

use super::numbers::{Case, Numbers, finite, finite_or_error};
use glam::{DVec2, DVec3, Vec3};
use shisen::cave::{BuiltInCave, Cave, DomeDescription, DomeScreen, Eye, Wall};
use shisen::dome::{Mapping, Mirror, NearField, effective_viewpoint, size_errors};
use shisen::gaze_reference::{self, Limits};
use shisen::live::{Allowance, Decision, Governor, Look, Quality, Table2, Taken};
use shisen::look::ViewDirection;
use shisen::overview::viewer::ViewerCamera;
use shisen::picture::{Picture, colour_differences, srgb_from_linear};
use shisen::quantiles::{median, median_ratio, quantile_of, quartiles};
use shisen::render::Observer;
use shisen::scene::Background;
use shisen::scene::builtin::{PrismBench, grid};
use shisen::scene::camera::DomeCamera;
use shisen::spectrum::{Dispersion, Method, minimum_deviation};
use shisen::stereo::anaglyph;
use shisen::tracker::calibration::estimation;
use shisen::tracker::{Senses, Spec};
use shisen::tradeoff::{Ring, pareto_front};
use shisen::warp::{Aim, Lens, Projector, Throw};
use shisen_core::frame::LevelOfDetail;
use shisen_core::gaze::{Acuity, Boundary, Gaze, HeadPose, LineOfSight, VisualField};
use shisen_tracker::estimate::EstimatorConfig;

pub(super) fn wall(n: &mut Numbers) -> Option<Wall> {
    let corners = [[-1.0, 0.0, -1.5], [1.0, 0.0, -1.5], [-1.0, 2.0, -1.5]];
    let [a, b, c] = corners.map(|corner| n.dvec3(corner));
    let wall = finite_or_error(Wall::new("front", a, b, c, [64, 48]));
    assert!(wall.is_some() || !n.are_sane());
    wall
}

pub(super) fn dome(n: &mut Numbers) -> Option<DomeScreen> {
    let dome = finite_or_error(DomeScreen::new(DomeDescription {
        name: "dome".to_owned(),
        radius: n.wide(4.0),
        centre: n.dvec3([0.0, 1.0, 0.0]),
        tilt_degrees: n.wide(15.0),
        field_of_view_degrees: n.wide(180.0),
        size: 64,
    }));
    assert!(dome.is_some() || !n.are_sane());
    dome
}

pub(super) fn mirror(n: &mut Numbers) -> Option<Mirror> {
    let (a, slope) = (n.wide(1.2), n.wide(0.8));
    finite_or_error(Mirror::from_slope(a, slope))
}

pub(super) const CASES: &[(&str, Case)] = &[
    ("host cave::Wall::new", |n| {
        wall(n);
    }),
    ("host cave::view::Wall::view_from", |n| {
        let eye = n.dvec3([0.1, 1.6, 0.0]);
        if let Some(wall) = wall(n) {
            finite_or_error(wall.view_from(eye));
        }
    }),
    ("host cave::view::Wall::frustum", |n| {
        let (eye, near) = (n.dvec3([0.1, 1.6, 0.0]), n.wide(0.1));
        if let Some(wall) = wall(n) {
            finite_or_error(wall.frustum(eye, near));
        }
    }),
    ("host cave::Cave::check_eye", |n| {
        let cave = Cave::built_in(BuiltInCave::ThreeWall, [8; 2]).expect("a room");
        let eye = n.dvec3([0.0; 3]);
        let seen = cave.check_eye(eye);
        assert!(eye.is_finite() || seen.is_err(), "{eye}");
    }),
    ("host cave::dome::DomeScreen::new", |n| {
        dome(n);
    }),
    ("host cave::dome::DomeScreen::view_from", |n| {
        let eye = n.dvec3([0.1, 1.0, 0.2]);
        if let Some(dome) = dome(n) {
            finite_or_error(dome.view_from(eye));
        }
    }),
    ("host dome::mirror::Mirror::parallel", |n| {
        finite_or_error(Mirror::parallel(n.wide(1.2)));
    }),
    ("host dome::mirror::Mirror::from_slope", |n| {
        assert!(mirror(n).is_some() || !n.are_sane());
    }),
    ("host dome::mirror::Mirror::from_edge", |n| {
        let (a, edge) = (n.wide(1.2), n.wide(0.6));
        finite_or_error(Mirror::from_edge(a, edge));
    }),
    ("host dome::mirror::Mirror::perspective", |n| {
        let (a, p) = (n.wide(1.2), n.wide(5.0));
        finite_or_error(Mirror::perspective(a, p));
    }),
    ("host dome::near_field::NearField::check", |n| {
        let near = NearField::new(Mirror::parallel(1.0).expect("a mirror"), Mapping::Mirror);
        let distance = n.wide(10.0);
        let allowed = near.check(distance).is_ok();
        assert!(!(allowed && distance.is_nan()));
        if allowed && distance.is_finite() {
            finite(&near.angle(0.5, distance));
        }
    }),
    ("host dome::rounding::size_errors", |n| {
        let near = NearField::new(Mirror::parallel(1.0).expect("a mirror"), Mapping::Mirror);
        let (size, offset) = (n.wide(0.01), n.wide(1.0));
        let errors = size_errors(&near, size, offset);
        // What has no number is none.
        if (1e-6..1.0).contains(&size) && offset.abs() < 1e6 {
            finite_or_error(errors);
        }
    }),
    ("host dome::viewpoint::effective_viewpoint", |n| {
        let near = NearField::new(Mirror::parallel(1.0).expect("a mirror"), Mapping::Mirror);
        let nearest = n.wide(10.0);
        if nearest.is_finite() {
            finite_or_error(effective_viewpoint(&near, nearest));
        }
    }),
    ("host gaze_reference::Gaze::new", |n| {
        let (direction, up) = (n.dvec3([0.0, 0.0, -1.0]), n.dvec3([0.0, 1.0, 0.0]));
        finite_or_error(gaze_reference::Gaze::new(
            direction,
            up,
            Limits::PAPER,
            Boundary::Printed,
        ));
    }),
    ("host gaze_reference::bounces", |n| {
        let level = n.wide(0.5);
        // Levels are 0 to 1.
        let is_level = (0.0..=1.0).contains(&level);
        assert!(!is_level || gaze_reference::bounces(level, 3) <= 3);
    }),
    ("host gaze_reference::faces", |n| {
        let level = n.wide(0.5);
        let faces = gaze_reference::faces(level, 500, 5_000);
        let is_level = (0.0..=1.0).contains(&level);
        assert!(!is_level || (500..=5_000).contains(&faces), "{faces}");
    }),
    ("host look::ViewDirection::new", |n| {
        let direction = n.dvec3([0.1, 0.2, -1.0]);
        let found = ViewDirection::new(direction);
        let is_direction = direction.is_finite() && direction != DVec3::ZERO;
        assert_eq!(found.is_some(), is_direction);
        if let Some(found) = found {
            assert!((found.vector().length() - 1.0).abs() < 1e-12);
        }
    }),
    ("host picture::srgb_from_linear", |n| {
        let light = n.next(0.5);
        let code = srgb_from_linear(light);
        assert!(code == 0 || light > 0.0, "{light} {code}");
        assert!(code == 255 || !(light >= 1.0), "{light} {code}");
    }),
    ("host picture::Picture::from_pixels", |n| {
        let pixel = [0.1, 0.5, 0.9, 1.0].map(|light| n.next(light));
        // Any light is kept as it is.
        let picture = Picture::from_pixels(1, 1, vec![pixel]).expect("a picture");
        let bits = |pixel: [f32; 4]| pixel.map(f32::to_bits);
        assert_eq!(picture.pixel(0, 0).map(bits), Some(bits(pixel)));
    }),
    ("host picture::Picture::set_pixel", |n| {
        let mut picture = Picture::new(2, 2).expect("a picture");
        picture.set_pixel(1, 1, [0.1, 0.5, 0.9, 1.0].map(|light| n.next(light)));
        assert_eq!(picture.pixel(0, 0), Some([0.0; 4]));
    }),
    ("host picture::Picture::sample", |n| {
        let picture = Picture::from_pixels(2, 1, vec![[0.5; 4]; 2]).expect("a picture");
        let (x, y) = (n.wide(0.7), n.wide(0.2));
        let expected = if x.is_nan() || y.is_nan() { 0.0 } else { 0.5 };
        assert_eq!(picture.sample(x, y), [expected; 4]);
    }),
    ("host picture::difference::colour_differences", |n| {
        let pixel = [0.1, 0.5, 0.9].map(|light| n.next(light));
        let of = |[r, g, b]: [f32; 3]| {
            Picture::from_pixels(1, 1, vec![[r, g, b, 1.0]]).expect("a picture")
        };
        let differences = colour_differences(&of(pixel), &of([0.5; 3]));
        // Of light that is no number there is none.
        if n.within(f32::MAX) {
            finite(&differences);
        }
    }),
    ("host quantiles::median", |n| {
        let of = [1.0, 3.0, 2.0].map(|x| n.wide(x));
        let middle = median(of.to_vec());
        assert!(!n.within(f32::MAX) || of.contains(&middle), "{middle}");
    }),
    ("host quantiles::median_ratio", |n| {
        let of = [1.0, 3.0, 2.0].map(|x| n.wide(x));
        let ratio = median_ratio(&of, &of);
        let usable = of.iter().all(|of| of.is_finite() && *of != 0.0);
        assert!(!usable || ratio == 1.0, "{ratio}");
    }),
    ("host quantiles::quartiles", |n| {
        let of = [1.0, 3.0, 2.0].map(|x| n.wide(x));
        let [low, high] = quartiles(of.to_vec());
        assert!(!n.within(f32::MAX) || low <= high, "{low} {high}");
    }),
    ("host quantiles::quantile_of", |n| {
        let of = [1.0, 3.0, 2.0].map(|x| n.wide(x));
        let least = quantile_of(of.to_vec(), 0.0);
        let all_are_above = of.iter().all(|one| *one >= least);
        assert!(!n.within(f32::MAX) || all_are_above, "{least}");
    }),
    ("host scene::Background::uniform", |n| {
        use shisen::bake::Baked;
        let colour = [0.1, 0.5, 0.9].map(|light| n.next(light));
        let mut scene = grid(2.0);
        scene.background = Background::uniform(colour);
        // What is no light is refused when it is baked.
        let is_light = colour.iter().all(|x| x.is_finite() && *x >= 0.0);
        assert!(Baked::<8>::new(&scene).is_err() || is_light, "{colour:?}");
        assert!(Baked::<8>::new(&scene).is_ok() || !n.are_sane());
    }),
    ("host scene::builtin::grid", |n| {
        use shisen::bake::Baked;
        let radius = n.next(2.0);
        // What is no scene is refused when it is baked.
        let baked = Baked::<8>::new(&grid(radius));
        assert!(baked.is_err() || (radius.is_finite() && radius > 0.0));
        assert!(baked.is_ok() || !n.are_sane());
    }),
    ("host scene::builtin::glass::PrismBench::towards", |n| {
        let angle = n.wide(0.3);
        let direction = PrismBench::towards(angle);
        let unit = (direction.length() - 1.0).abs() < 1e-12;
        assert_eq!(unit, angle.is_finite(), "{direction}");
    }),
    ("host scene::camera::DomeCamera::tilted", |n| {
        let (at, angle) = (n.dvec3([0.0, 1.0, 0.0]), n.wide(0.3));
        let camera = DomeCamera::tilted(at, angle);
        if n.within(f32::MAX) {
            finite(&camera);
        }
    }),
    ("host spectrum::dispersion::Dispersion::of", |n| {
        let range = [400.0, 700.0].map(|nm| n.next(nm));
        finite_or_error(Dispersion::of(Method::Comb, 7, Some(range)));
    }),
    ("host spectrum::prism::minimum_deviation", |n| {
        let (index, apex) = (n.wide(1.5), n.wide(1.0));
        if let Some(angle) = minimum_deviation(index, apex) {
            finite(&angle);
        }
    }),
    ("host tradeoff::front::pareto_front", |n| {
        let points = [(1.0, 2.0), (2.0, 1.0)].map(|(a, b)| (n.wide(a), n.wide(b)));
        let front = pareto_front(&points);
        for (point, best) in points.iter().zip(&front) {
            assert!(!best || (point.0.is_finite() && point.1.is_finite()));
        }
        let any = points
            .iter()
            .any(|one| one.0.is_finite() && one.1.is_finite());
        assert_eq!(front.contains(&true), any);
    }),
    ("host tradeoff::metrics::Ring::of", |n| {
        let degrees = n.next(3.0);
        let ring = Ring::of(degrees);
        assert!(degrees <= 5.0 || ring == Ring::Periphery);
    }),
    ("host tracker::calibration::estimation::estimation", |n| {
        let senses = Senses {
            head: true,
            eyes: true,
        };
        let head = HeadPose {
            position: n.vec3([0.0, 1.6, 0.0]),
            orientation: n.quat(),
        };
        let spec: Spec = "mock".parse().expect("a tracker");
        let config = estimation(&spec, senses, head, None);
        // What is no place is refused by the estimator.
        assert!(config.check().is_err() || head.position.is_finite());
        assert!(config.check().is_ok() || !n.are_sane());
    }),
    ("host tracker::times::Times::set", |n| {
        let spec = format!("mock:stuck_after={}", n.wide(0.5)).parse::<Spec>();
        match spec {
            Ok(spec) => {
                let mut config = EstimatorConfig::default();
                spec.times().set(&mut config);
                assert!(config.check().is_ok());
            }
            Err(error) => assert!(!n.are_sane() && !error.to_string().is_empty(), "{error}"),
        }
    }),
    ("host overview::viewer::ViewerCamera::new", |n| {
        let eye = n.dvec3([0.0, 1.6, 3.0]);
        let (forward, up) = (n.dvec3([0.0, 0.0, -1.0]), n.dvec3([0.0, 1.0, 0.0]));
        let field = n.wide(1.0);
        finite_or_error(ViewerCamera::new(eye, forward, up, field, [64, 48]));
    }),
    ("host warp::projector::Projector::new", |n| {
        let position = n.dvec3([0.0, 2.0, 1.0]);
        let look = n.dvec3([0.0, 0.0, -1.0]);
        let up = n.dvec3([0.0, 1.0, 0.0]);
        let lens = Lens {
            throw: Throw::Degrees(n.wide(40.0)),
            vertical_degrees: Some(n.wide(30.0)),
            shift: DVec2::new(n.wide(0.1), n.wide(-0.2)),
        };
        let aim = Aim::Look { look, up };
        finite_or_error(Projector::new("one", position, aim, lens, [64, 48]));
    }),
    ("host stereo::anaglyph", |n| {
        let mut eye = || [0.2, 0.5, 0.9, 1.0].map(|sane| n.next(sane));
        let [red, green, blue, _] = anaglyph(eye(), eye());
        for channel in [red, green, blue] {
            assert!((0.0..=1.0).contains(&channel), "{channel}");
        }
    }),
    ("host live::budget::Table2::seconds", |n| {
        let forward = n.vec3([0.0, -0.3, -1.0]);
        for row in Table2::ROWS {
            assert!(row.lod.contains(&row.seconds(forward)));
        }
    }),
    ("host live::budget::Table2::part", |n| {
        let forward = n.vec3([0.0, -0.3, -1.0]);
        for row in Table2::ROWS {
            let [front, floor] = row.lod.map(|seconds| seconds / row.plain);
            let part = row.part(forward);
            assert!(part >= floor * 0.999 && part <= front * 1.001, "{part}");
        }
    }),
    ("host live::governor::Governor::follow", |n| {
        let mut governor = governor(n);
        for gaze in [Some(n.vec3([0.1, -0.2, -1.0])), None] {
            governor.follow(gaze);
            let decision = governor.decide(Allowance::Steps(1_000_000));
            governor.learn(&decision, 2_000_000, taken(0.01));
            assert!(governor.full_need() >= 2.0e6);
        }
    }),
    ("host live::governor::Governor::learn", |n| {
        let mut governor = governor(n);
        for allowance in [
            Allowance::Unlimited,
            Allowance::Steps(0),
            Allowance::Time(std::time::Duration::MAX),
        ] {
            let decision = governor.decide(allowance);
            assert_eq!(decision.quality, Quality::LADDER[decision.rung]);
            let better = governor.better();
            let rises = governor.rise(allowance);
            assert!(better.is_some() || !rises, "{allowance:?}");
        }
    }),
    ("host live::governor::Governor::compare", |n| {
        let mut governor = governor(n);
        let many = taken(n.wide(0.01));
        let few = Taken {
            steps: 1_000,
            seconds: n.wide(0.001),
        };
        governor.compare(many, few);
        governor.learn(&Decision::FULL, 2_000_000, taken(0.01));
        for milliseconds in [0, 1, 10, 1_000] {
            let time = std::time::Duration::from_millis(milliseconds);
            let decision = governor.decide(Allowance::Time(time));
            assert!(decision.rung < Quality::LADDER.len());
            assert!(decision.steps.is_some() && decision.whole_fovea);
        }
    }),
    ("host render::Observer::foveated", |n| {
        let ahead = LineOfSight::new(Vec3::ZERO, Vec3::NEG_Z, Vec3::Y).expect("a line of sight");
        let eye = Observer::foveated(Eye::Left, DVec3::ZERO, ahead, n.next(0.1));
        assert_eq!(eye.lod.is_some(), eye.acuity.is_some());
        if let Some(lod) = eye.lod {
            finite(&lod.gaze.visual_field());
            finite(&eye.acuity);
        }
    }),
    ("host live::swap::Look::towards", |n| {
        let look = Look {
            head: HeadPose::IDENTITY,
            position: Vec3::ZERO,
            forward: Vec3::NEG_Z,
            up: Vec3::Y,
            widen: 0.1,
        };
        let turned = look.towards(Some(n.vec3([0.0, -0.3, -1.0])));
        for axis in [turned.forward, turned.up] {
            assert!((axis.length() - 1.0).abs() < 1.0e-5, "{axis}");
        }
        assert!(turned.forward.dot(turned.up).abs() < 1.0e-5);
    }),
    ("host live::quality::Quality::lower", |n| {
        let quality = Quality {
            field: n.next(0.5),
            sampling: n.next(2.0),
            ..Quality::FULL
        };
        let ahead = LineOfSight::new(Vec3::ZERO, Vec3::NEG_Z, Vec3::Y).expect("a line of sight");
        let eye = quality.lower(Observer::foveated(Eye::Left, DVec3::ZERO, ahead, 0.0));
        finite(&eye.lod.map(|lod| lod.gaze.visual_field()));
        let slope = eye.acuity.expect("an acuity").slope();
        assert!((Acuity::GUENTER.slope()..=Acuity::STEEPEST).contains(&slope));
    }),
    ("host live::quality::Quality::narrow", |n| {
        let quality = Quality {
            field: n.next(0.5),
            centre: n.next(0.5),
            faces: n.next(0.5),
            ..Quality::FULL
        };
        let ahead = LineOfSight::new(Vec3::ZERO, Vec3::NEG_Z, Vec3::Y).expect("a line of sight");
        let lod = LevelOfDetail::new(Gaze::new(ahead, VisualField::PAPER));
        let limits = quality.narrow(lod).gaze.visual_field().limits();
        finite(&limits);
        assert!(limits.central > 0.09 && limits.central <= VisualField::PAPER.limits().central);
        assert!(limits.up > limits.central && limits.up <= VisualField::PAPER.limits().up);
    }),
];

/// A million steps that took so long.
const fn taken(seconds: f64) -> Taken {
    Taken {
        steps: 1_000_000,
        seconds,
    }
}

/// A governor that has seen a frame whose time is the next number.
fn governor(n: &mut Numbers) -> Governor {
    let mut governor = Governor::new();
    let decision = governor.decide(Allowance::Unlimited);
    governor.learn(&decision, 2_000_000, taken(n.wide(0.01)));
    governor
}
